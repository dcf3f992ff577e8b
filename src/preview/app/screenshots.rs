//! Screenshots of the workshop, made with its own painter, are compared with stored ones.
//!
//! After an intended change, run these tests with `UPDATE_SCREENSHOTS=1` and look at the new screenshots.

use super::*;
use crate::workspace::session::PictureSettings;
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, TestRenderer};
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use crate::preview::paint;

const SIZE: [usize; 2] = [1000, 620];
/// The height of the status bar, which shows times and is not compared.
const LEFT_OUT: usize = 26;

/// Passes textures to a painter.
struct TextureSink(Rc<RefCell<paint::Painter>>);

impl TestRenderer for TextureSink {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.0.borrow_mut().update_textures(delta);
    }
}

/// A workshop with a painter.
struct TestWorkshop {
    harness: Harness<'static, App>,
    painter: Rc<RefCell<paint::Painter>>,
}

impl TestWorkshop {
    fn new() -> Self {
        let app = App::new(Some(&Location::Preset("studio".to_owned())), None).expect("a built-in session");
        let painter = Rc::new(RefCell::new(paint::Painter::new()));
        let [width, height] = SIZE.map(|side| side as f32);
        let harness = Harness::builder().with_size(egui::vec2(width, height)).renderer(TextureSink(Rc::clone(&painter)));
        let mut harness = harness.build_ui_state(|ui, app: &mut App| app.draw(ui), app);
        let context = harness.ctx.clone();
        harness.state_mut().started(&context);
        harness.state_mut().pane.zoom = pane::Zoom::ACTUAL;
        // One pass: then nothing changes once there is a picture.
        let picture = PictureSettings { size: [260, 180], samples: Some(1), ..harness.state().workshop.settings() };
        harness.state_mut().workshop.set_picture(picture).expect("a size in range");
        let mut stage = Self { harness, painter };
        stage.settle();
        stage
    }

    /// Waits until nothing changes any more.
    fn settle(&mut self) {
        for _ in 0..30_000 {
            self.harness.step();
            if self.harness.state().workshop.is_up_to_date() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        self.harness.remove_cursor();
        // Longer than any animation.
        self.harness.run_steps(40);
        assert!(self.harness.state().workshop.is_up_to_date());
    }

    /// The screenshot, as red, green and blue.
    fn look(&mut self) -> image::RgbImage {
        let context = self.harness.ctx.clone();
        let output = self.harness.output();
        let scale = output.pixels_per_point;
        let ground = context.global_style().visuals.panel_fill;
        let pane = self.harness.state().pane.area();
        // The harness draws a background under everything. In the window, the picture is there.
        let covers = |shape: &egui::Shape| matches!(shape, egui::Shape::Rect(rect) if rect.fill == ground && rect.rect.contains_rect(pane));
        let shapes = output.shapes.iter().filter(|clipped| !covers(&clipped.shape)).cloned().collect();
        let widgets = context.tessellate(shapes, scale);
        let background = ground.to_array();
        let background = u32::from_be_bytes([0, background[0], background[1], background[2]]);
        let picture = self.harness.state_mut().picture();
        let mut painter = self.painter.borrow_mut();
        painter.paint(&paint::PaintInput { size: SIZE, scale, background, widgets: &widgets, picture });
        let [width, height] = SIZE.map(|side| side as u32);
        let bytes = painter.pixels().iter().flat_map(|word| word.to_be_bytes().into_iter().skip(1)).collect();
        image::RgbImage::from_raw(width, height, bytes).expect("as many bytes")
    }

    /// Compares the screenshot with the stored one of this name.
    fn is_as_in(&mut self, name: &str) {
        let seen = self.look();
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/preview/app/screenshots").join(name).with_extension("png");
        if std::env::var_os("UPDATE_SCREENSHOTS").is_some() {
            seen.save(&path).expect("a file that can be written");
        }
        let wanted = image::open(&path).expect("a picture").to_rgb8();
        assert_eq!(wanted.dimensions(), seen.dimensions());
        let compared = (SIZE[1] - LEFT_OUT) * SIZE[0];
        // Processors round differently: colours differ by one step, and by more at edges.
        let differs = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 8);
        let differing = wanted.pixels().zip(seen.pixels()).take(compared).filter(differs).count();
        if differing * 1000 > compared {
            let kept = std::env::temp_dir().join(format!("{name}-seen.png"));
            seen.save(&kept).expect("a file that can be written");
            panic!("{name} looks different in {differing} pixels of {compared}: see {}", kept.display());
        }
    }
}

#[test]
fn a_mistake_is_marked_and_listed() {
    let mut stage = TestWorkshop::new();
    stage.harness.state_mut().documents.formula.replace_text("formula;\nDIFFUSE = IL*Cd*max(0, N.L);\n= DIFUSE + N.L;\n");
    stage.harness.get_by_label("Apply formula").click();
    stage.settle();
    stage.is_as_in("mistake");
}

#[test]
fn the_light_theme_is_chosen_in_the_menu_and_bodies_have_their_sliders() {
    let mut stage = TestWorkshop::new();
    stage.harness.get_by_label("View").click();
    stage.harness.run_steps(5);
    stage.harness.get_by_label("Light").click();
    stage.harness.run_steps(5);
    stage.harness.key_press(egui::Key::Escape);
    stage.harness.get_all_by_label("ball").next().expect("a body").click();
    stage.settle();
    assert_eq!(stage.harness.state().theme, Theme::Light);
    stage.is_as_in("light");
}

#[test]
fn a_pixel_is_looked_into() {
    let mut stage = TestWorkshop::new();
    stage.harness.key_press(egui::Key::F5);
    stage.harness.run_steps(5);
    let pane = stage.harness.state().pane.area();
    let at = pane.center() + egui::vec2(-40.0, 20.0);
    stage.harness.drag_at(at);
    stage.harness.run_steps(2);
    stage.harness.drop_at(at);
    stage.settle();
    stage.is_as_in("inspector");
}
