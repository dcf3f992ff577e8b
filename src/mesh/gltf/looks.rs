//! What a glTF document says beside its triangles: names, materials, cameras and lights, as they stand in its JSON
//! (glTF 2.0, chapter 5, and the extensions `KHR_lights_punctual` and `KHR_materials_…`).

use crate::mesh::error::Fault;
use crate::mesh::gltf::document::{charge_values, wrong_json};
use crate::mesh::gltf::textures::{GltfImage, GltfSampler, GltfTexture, GltfTextures, TextureReference};
use crate::mesh::ledger::Ledger;
use crate::mesh::model::{ModelLook, ModelMaterial, Omissions, PhysicalLook};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// The extensions whose meaning is kept. Others change how the file looks, or nothing that is drawn.
const KEPT: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfLooks {
    extensions_used: Vec<String>,
    extensions: RootExtensions,
    materials: Vec<GltfMaterial>,
    pub(super) cameras: Vec<GltfCamera>,
    pub(super) nodes: Vec<NodeLooks>,
    pub(super) meshes: Vec<MeshLooks>,
    textures: Vec<GltfTexture>,
    images: Vec<GltfImage>,
    samplers: Vec<GltfSampler>,
    animations: Vec<IgnoredAny>,
    scenes: Vec<IgnoredAny>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    lights: PunctualLights,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct PunctualLights {
    lights: Vec<GltfLight>,
}

#[derive(Deserialize)]
pub(super) struct GltfLight {
    #[serde(default)]
    pub(super) name: String,
    #[serde(rename = "type")]
    pub(super) kind: GltfLightKind,
    #[serde(default = "white")]
    pub(super) color: [f64; 3],
    #[serde(default = "one")]
    pub(super) intensity: f64,
    #[serde(default)]
    pub(super) spot: GltfCone,
}

/// The cone of a spot light: angles in radians.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfCone {
    pub(super) inner_cone_angle: f64,
    pub(super) outer_cone_angle: f64,
}

impl Default for GltfCone {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f64::consts::FRAC_PI_4 }
    }
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum GltfLightKind {
    Point,
    Spot,
    Directional,
}

#[derive(Deserialize)]
pub(super) struct GltfCamera {
    pub(super) perspective: Option<GltfPerspective>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct GltfPerspective {
    pub(super) yfov: f64,
    pub(super) aspect_ratio: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct NodeLooks {
    pub(super) name: String,
    pub(super) camera: Option<usize>,
    skin: Option<IgnoredAny>,
    extensions: NodeExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    light: Option<LightOfNode>,
}

#[derive(Deserialize)]
struct LightOfNode {
    light: usize,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct MeshLooks {
    pub(super) name: String,
    pub(super) primitives: Vec<PrimitiveLooks>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct PrimitiveLooks {
    pub(super) material: Option<usize>,
    targets: Vec<IgnoredAny>,
    attributes: PrimitiveColors,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct PrimitiveColors {
    #[serde(rename = "COLOR_0")]
    color: Option<IgnoredAny>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct GltfMaterial {
    name: String,
    pbr_metallic_roughness: MetallicRoughness,
    normal_texture: Option<IgnoredAny>,
    occlusion_texture: Option<IgnoredAny>,
    emissive_texture: Option<IgnoredAny>,
    emissive_factor: [f64; 3],
    alpha_mode: Option<String>,
    extensions: MaterialExtensions,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct MetallicRoughness {
    base_color_factor: [f64; 4],
    base_color_texture: Option<TextureReference>,
    metallic_factor: f64,
    roughness_factor: f64,
    metallic_roughness_texture: Option<IgnoredAny>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct MaterialExtensions {
    #[serde(rename = "KHR_materials_ior")]
    index: Option<MaterialIndex>,
    #[serde(rename = "KHR_materials_transmission")]
    transmission: MaterialTransmission,
    #[serde(rename = "KHR_materials_volume")]
    volume: MaterialVolume,
    #[serde(rename = "KHR_materials_specular")]
    specular: MaterialSpecular,
    #[serde(rename = "KHR_materials_clearcoat")]
    coat: MaterialCoat,
}

#[derive(Deserialize)]
struct MaterialIndex {
    #[serde(default = "usual_index")]
    ior: f64,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct MaterialTransmission {
    transmission_factor: f64,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct MaterialVolume {
    thickness_factor: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct MaterialSpecular {
    specular_factor: f64,
    specular_color_factor: [f64; 3],
}

impl Default for MaterialSpecular {
    fn default() -> Self {
        Self { specular_factor: 1.0, specular_color_factor: white() }
    }
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct MaterialCoat {
    clearcoat_factor: f64,
    clearcoat_roughness_factor: f64,
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

fn one() -> f64 {
    1.0
}

fn usual_index() -> f64 {
    1.5
}

/// The metalness and roughness of materials whose texture has them.
const TEXTURED: (f64, f64) = (0.0, 0.5);

impl GltfLooks {
    /// Reads the JSON, which begins at `start` in the file.
    pub(super) fn read(json: &[u8], start: usize, ledger: &mut Ledger) -> Result<Self, Fault> {
        charge_values(json, ledger)?;
        serde_json::from_slice(json).map_err(|error| wrong_json(json, start, &error))
    }

    /// The light of a node.
    pub(super) fn light_of(&self, node: usize) -> Result<Option<&GltfLight>, Fault> {
        let Some(light) = self.nodes.get(node).and_then(|node| node.extensions.light.as_ref()) else { return Ok(None) };
        let lights = &self.extensions.lights.lights;
        let missing = || Fault::new(format!("nodes[{node}] has the light {}: the file has {}", light.light, lights.len()));
        lights.get(light.light).map(Some).ok_or_else(missing)
    }

    /// The materials of the file, without images.
    pub(super) fn materials(&self) -> Vec<ModelMaterial> {
        let material = |material: &GltfMaterial| ModelMaterial {
            name: material.name.clone(),
            look: ModelLook::Physical(material.look()),
            image: None,
        };
        self.materials.iter().map(material).collect()
    }

    /// The lists of textures.
    pub(super) fn textures(&self) -> GltfTextures<'_> {
        GltfTextures { textures: &self.textures, images: &self.images, samplers: &self.samplers }
    }

    /// The texture of the base colour of a material.
    pub(super) fn base_texture(&self, material: usize) -> Option<&TextureReference> {
        self.materials.get(material).and_then(|material| material.pbr_metallic_roughness.base_color_texture.as_ref())
    }

    /// What is left out of the file as a whole.
    pub(super) fn omissions(&self) -> Omissions {
        let mut omissions = Omissions::default();
        let mut add = |count: usize, what: &str, note: &str| omissions.add(count as u64, what, note);
        let with = |has: &dyn Fn(&GltfMaterial) -> bool| self.materials.iter().filter(|material| has(material)).count();
        add(with(&|material| material.normal_texture.is_some()), "texture(s) of bumps", "");
        add(with(&|material| material.occlusion_texture.is_some()), "texture(s) of shade", "");
        add(with(&|material| material.emissive_texture.is_some()), "texture(s) of light", "");
        let is_veil = |material: &GltfMaterial| {
            material.alpha_mode.as_deref() == Some("BLEND") && material.pbr_metallic_roughness.base_color_texture.is_some()
        };
        add(with(&is_veil), "transparency of texture(s)", "only that of the whole material is kept");
        let textured = |material: &&GltfMaterial| material.pbr_metallic_roughness.metallic_roughness_texture.is_some();
        let note = "each such material counts as a dielectric of roughness 0.5";
        add(self.materials.iter().filter(textured).count(), "texture(s) of metal and roughness", note);
        let shine = |material: &&GltfMaterial| material.emissive_factor.iter().any(|component| *component > 0.0);
        add(self.materials.iter().filter(shine).count(), "material(s) with a light of their own", "it is not shown");
        let is_mask = |material: &&GltfMaterial| material.alpha_mode.as_deref() == Some("MASK");
        add(self.materials.iter().filter(is_mask).count(), "mask(s)", "the whole surface is drawn");
        add(self.animations.len(), "animation(s)", "");
        let skins = self.nodes.iter().filter(|node| node.skin.is_some()).count();
        add(skins, "part(s) with a skin", "without their pose");
        let primitives = || self.meshes.iter().flat_map(|mesh| &mesh.primitives);
        add(primitives().filter(|primitive| !primitive.targets.is_empty()).count(), "part(s) with morph targets", "");
        add(
            primitives().filter(|primitive| primitive.attributes.color.is_some()).count(),
            "part(s) with colours of vertices",
            "",
        );
        add(self.scenes.len().saturating_sub(1), "other scene(s)", "");
        for name in self.extensions_used.iter().filter(|name| !KEPT.contains(&name.as_str())) {
            add(1, &format!("extension(s): `{name}`"), "");
        }
        omissions
    }
}

impl GltfMaterial {
    fn look(&self) -> PhysicalLook {
        let surface = &self.pbr_metallic_roughness;
        let [red, green, blue, alpha] = surface.base_color_factor;
        let is_blended = self.alpha_mode.as_deref() == Some("BLEND");
        let textured = surface.metallic_roughness_texture.is_some();
        let (metallic, roughness) = if textured { TEXTURED } else { (surface.metallic_factor, surface.roughness_factor) };
        PhysicalLook {
            base: [red, green, blue],
            coverage: if is_blended { alpha } else { 1.0 },
            metallic,
            roughness,
            specular: self.extensions.specular.specular_factor,
            specular_color: self.extensions.specular.specular_color_factor,
            coat: self.extensions.coat.clearcoat_factor,
            coat_roughness: self.extensions.coat.clearcoat_roughness_factor,
            transmission: self.extensions.transmission.transmission_factor,
            index: self.extensions.index.as_ref().map_or(usual_index(), |index| index.ior),
            // By the letter, an index without a thickness bends no light either. Whoever gives one wants to see it.
            is_thin: self.extensions.index.is_none() && self.extensions.volume.thickness_factor <= 0.0,
        }
    }
}
