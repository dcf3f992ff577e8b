//! The row of a texture: its image, the name of the file, and buttons that choose another image or none.

use crate::formula::{Parameter, ParameterId};
use crate::lang::display_text::one_line;
use crate::lang::types::Type;
use crate::picture::Transfer;
use crate::preview::app::App;
use crate::preview::app::jobs::{ImageRead, JobResult};
use crate::texture;
use crate::workspace::{OwnerId, textures};
use egui::{Color32, ColorImage, Id, Image, Sense, TextureHandle, TextureOptions, Ui, Vec2, vec2};
use std::path::Path;

/// What the user did with an image.
pub(super) enum ImageEdit {
    /// Wants to choose another one.
    Choose,
    /// Wants none.
    Clear,
}

/// The side of the image in a row, in points, and in texels.
const SIDE: f32 = 18.0;
const TEXELS: usize = 36;

impl App {
    /// Reads an image for a texture of an owner, on another thread: a large one takes seconds.
    pub(super) fn read_image(&mut self, owner: OwnerId, parameter: String, path: &Path) {
        if self.texture_of(owner, &parameter).is_some() {
            let path = path.to_owned();
            self.run_job(move || {
                let outcome = textures::load(&path);
                Some(JobResult::ImageRead(Box::new(ImageRead { owner, parameter, outcome })))
            });
        }
    }

    /// Shows an image that was read, unless its owner or its parameter is gone.
    pub(super) fn set_image(&mut self, ImageRead { owner, parameter, outcome }: ImageRead) {
        match (outcome, self.texture_of(owner, &parameter)) {
            (Ok(number), Some(id)) => self.workshop.set(owner, id, [number, 0.0, 0.0]),
            (Ok(_), None) => {}
            (Err(error), _) => self.dialogs.show_message("The image was not read", error.message()),
        }
    }

    /// The texture parameter of this name, if there are this owner and this parameter.
    fn texture_of(&self, owner: OwnerId, parameter: &str) -> Option<ParameterId> {
        let table = self.workshop.values().table();
        let known = table.parameter_named(parameter).filter(|id| table.parameter(*id).ty == Type::Texture);
        known.filter(|_| table.owners().has(owner))
    }
}

/// The name of the file of a texture.
pub(super) fn image_name(number: f32) -> Option<String> {
    Some(one_line(&texture::path_of(number)?.file_name()?.to_string_lossy()))
}

/// Draws the cells behind the name of a texture parameter.
pub(super) fn image_cells(ui: &mut Ui, parameter: &Parameter, number: f32, width: f32) -> Option<ImageEdit> {
    let mut edit = None;
    let path = texture::path_of(number).map(|path| one_line(&path.display().to_string()));
    match thumbnail(ui, number) {
        Some(shown) => {
            let size = shown.size_vec2();
            let scaled = size * (SIDE / size.max_elem());
            ui.add(Image::new((shown.id(), scaled)));
        }
        None => {
            let (rect, _) = ui.allocate_exact_size(Vec2::splat(SIDE), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, Color32::WHITE);
        }
    }
    let name = image_name(number).unwrap_or_else(|| "Choose an image…".to_owned());
    let clear = if path.is_some() { 24.0 } else { 0.0 };
    let size = vec2((width - SIDE - clear).max(48.0), ui.spacing().interact_size.y);
    let button = ui.add(egui::Button::new(name).truncate().min_size(vec2(size.x, 0.0)));
    let hint = path.clone().unwrap_or_else(|| format!("{} is white", one_line(&parameter.name)));
    if button.on_hover_text(hint).clicked() {
        edit = Some(ImageEdit::Choose);
    }
    if path.is_some() && ui.small_button("×").on_hover_text("No image: white").clicked() {
        edit = Some(ImageEdit::Clear);
    }
    edit
}

/// The small image of a texture. It is made once.
fn thumbnail(ui: &Ui, number: f32) -> Option<TextureHandle> {
    let id = Id::new(("image of texture", number as u32));
    if let Some(made) = ui.data(|data| data.get_temp::<TextureHandle>(id)) {
        return Some(made);
    }
    let found = texture::numbered(number)?;
    let largest = found.size().into_iter().max().unwrap_or(1) as usize;
    let [width, height] = found.size().map(|side| (TEXELS * side as usize / largest).max(1));
    let byte = |linear: f32| (255.0 * Transfer::Srgb.encode(f64::from(linear.clamp(0.0, 1.0)))).round() as u8;
    let mut pixels = Vec::with_capacity(width * height);
    for y in (0..height).rev() {
        for x in 0..width {
            let share = |at: usize, count: usize| (at as f32 + 0.5) / count as f32;
            let [red, green, blue] = found.colour(share(x, width), share(y, height)).map(byte);
            pixels.push(Color32::from_rgb(red, green, blue));
        }
    }
    let made = ui.ctx().load_texture("image of a texture", ColorImage::new([width, height], pixels), TextureOptions::LINEAR);
    ui.data_mut(|data| data.insert_temp(id, made.clone()));
    Some(made)
}
