//! The images of base colours (glTF 2.0, chapters 3.8 and 5.29, and the extension `KHR_texture_transform`).

use crate::mesh::MeshFile;
use crate::mesh::error::Fault;
use crate::mesh::gltf::container::{UriTarget, resolve};
use crate::mesh::gltf::document::GltfDocument;
use crate::mesh::images::{IMAGES, ImageList, REPEATED};
use crate::mesh::ledger::Ledger;
use crate::mesh::model::Omissions;
use glam::{Mat2, Vec2};
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// How a material refers to a texture.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureReference {
    index: usize,
    #[serde(default)]
    tex_coord: u32,
    #[serde(default)]
    extensions: ReferenceExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct ReferenceExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}

/// Where a texture is taken at surface coordinates.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct TextureTransform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl TextureTransform {
    /// Surface coordinates whose v goes upwards, after the transform. It is one of coordinates whose v goes down.
    pub(super) fn apply(&self, uv: Vec2) -> Vec2 {
        let (sine, cosine) = self.rotation.sin_cos();
        let turn = Mat2::from_cols_array(&[cosine, -sine, sine, cosine]);
        let moved = Vec2::from(self.offset) + turn * (Vec2::from(self.scale) * Vec2::new(uv.x, 1.0 - uv.y));
        Vec2::new(moved.x, 1.0 - moved.y)
    }
}

/// A texture: an image, and how it is sampled.
#[derive(Deserialize)]
pub(super) struct GltfTexture {
    source: Option<usize>,
    sampler: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct GltfImage {
    #[serde(default)]
    name: String,
    uri: Option<String>,
    buffer_view: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct GltfSampler {
    mag_filter: Option<u32>,
    wrap_s: Option<u32>,
    wrap_t: Option<u32>,
}

const NEAREST: u32 = 9728;
const REPEAT: u32 = 10497;

impl TextureReference {
    /// The transform of its coordinates.
    pub(super) fn transform(&self) -> Option<&TextureTransform> {
        self.extensions.transform.as_ref()
    }

    /// Whether it is placed by the surface coordinates that meshes have.
    fn has_usual_coordinates(&self) -> bool {
        self.transform().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord) == 0
    }
}

/// The lists of textures in a file.
#[derive(Clone, Copy)]
pub(super) struct GltfTextures<'l> {
    pub(super) textures: &'l [GltfTexture],
    pub(super) images: &'l [GltfImage],
    pub(super) samplers: &'l [GltfSampler],
}

/// Gives the images of materials, each once.
pub(super) struct ImageReader<'l> {
    lists: GltfTextures<'l>,
    file: &'l MeshFile<'l>,
    document: &'l GltfDocument,
    buffers: &'l [Cow<'l, [u8]>],
    pub(super) found: ImageList,
    /// The images that have been asked for.
    known: BTreeMap<usize, Option<usize>>,
}

impl<'l> ImageReader<'l> {
    pub(super) fn new(
        lists: GltfTextures<'l>,
        file: &'l MeshFile<'l>,
        document: &'l GltfDocument,
        buffers: &'l [Cow<'l, [u8]>],
    ) -> Self {
        Self { lists, file, document, buffers, found: ImageList::default(), known: BTreeMap::new() }
    }

    /// The image of a texture, an index of `found`; `None`, with a note, if it cannot be used.
    pub(super) fn image_of(
        &mut self,
        reference: &TextureReference,
        omissions: &mut Omissions,
        ledger: &mut Ledger,
    ) -> Result<Option<usize>, Fault> {
        let GltfTextures { textures, images, samplers } = self.lists;
        let missing =
            |list: &str, index: usize, has: usize| Fault::new(format!("there is no {list}[{index}]: the file has {has}"));
        let texture = textures.get(reference.index).ok_or_else(|| missing("textures", reference.index, textures.len()))?;
        let Some(source) = texture.source else {
            omissions.add(1, IMAGES, "its format is one of an extension");
            return Ok(None);
        };
        if !reference.has_usual_coordinates() {
            omissions.add(1, IMAGES, "other surface coordinates than the first place it");
            return Ok(None);
        }
        let image = images.get(source).ok_or_else(|| missing("images", source, images.len()))?;
        let found = match self.known.get(&source) {
            Some(known) => *known,
            None => {
                let found = self.read(image, source, omissions, ledger)?;
                self.known.insert(source, found);
                found
            }
        };
        if let Some(sampler) = texture.sampler.and_then(|sampler| samplers.get(sampler)).filter(|_| found.is_some()) {
            let repeats = |wrap: Option<u32>| wrap.is_none_or(|wrap| wrap == REPEAT);
            let is_held = !(repeats(sampler.wrap_s) && repeats(sampler.wrap_t));
            omissions.add(u64::from(is_held), "texture(s) held or mirrored at the edges", REPEATED);
            let is_nearest = sampler.mag_filter == Some(NEAREST);
            omissions.add(u64::from(is_nearest), "texture(s) of plain texels", "it is interpolated here");
        }
        Ok(found)
    }

    fn read(
        &mut self,
        image: &GltfImage,
        index: usize,
        omissions: &mut Omissions,
        ledger: &mut Ledger,
    ) -> Result<Option<usize>, Fault> {
        let mut bytes = Vec::new();
        if let Some(view) = image.buffer_view {
            let outside = || Fault::new(format!("images[{index}] is not within its buffer"));
            let view = self.document.buffer_views.get(view).ok_or_else(outside)?;
            let buffer = self.buffers.get(view.buffer).ok_or_else(outside)?;
            let range = usize::try_from(view.byte_offset).ok().zip(usize::try_from(view.byte_length).ok());
            let part = range.and_then(|(start, length)| buffer.get(start..start.checked_add(length)?)).ok_or_else(outside)?;
            ledger.reserve(&mut bytes, part.len())?;
            bytes.extend_from_slice(part);
        } else if let Some(uri) = &image.uri {
            match resolve(uri, &format!("images[{index}]"), self.file.path, ledger)? {
                UriTarget::Data(data) => bytes = data,
                UriTarget::File(path) => return self.found.add_file(&path, ledger, omissions),
            }
        } else {
            return Err(Fault::new(format!("images[{index}] has neither a `uri` nor a `bufferView`")));
        }
        Ok(self.found.add(image.name.clone(), bytes, omissions))
    }
}
