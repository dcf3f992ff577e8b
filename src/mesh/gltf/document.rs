//! The parts of a glTF document that a mesh needs, as they stand in its JSON (glTF 2.0, chapter 5).

use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use serde::Deserialize;

/// Extensions that a file may require and that do not change its triangles, by the beginnings of their names.
const HARMLESS: [&str; 7] =
    ["KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_animation_", "KHR_xmp"];

/// The memory for an object of the JSON and for another value of it, at most, in bytes. A child of a node takes the
/// most: it waits with a matrix.
const BYTES_PER_OBJECT: u64 = 512;
const BYTES_PER_VALUE: u64 = 192;

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfDocument {
    asset: GltfAsset,
    pub(super) extensions_required: Vec<String>,
    pub(super) buffers: Vec<GltfBuffer>,
    pub(super) buffer_views: Vec<BufferView>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) meshes: Vec<GltfMesh>,
    pub(super) nodes: Vec<GltfNode>,
    pub(super) scenes: Vec<GltfScene>,
    pub(super) scene: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct GltfAsset {
    version: serde_json::Value,
}

/// What all versions of glTF have.
#[derive(Deserialize)]
struct Versioned {
    asset: GltfAsset,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct GltfBuffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: u64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) shape: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
}

#[derive(Deserialize)]
pub(super) struct GltfMesh {
    pub(super) primitives: Vec<GltfPrimitive>,
}

#[derive(Deserialize)]
pub(super) struct GltfPrimitive {
    pub(super) attributes: GltfAttributes,
    pub(super) indices: Option<usize>,
    pub(super) mode: Option<u32>,
}

#[derive(Deserialize)]
pub(super) struct GltfAttributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
    #[serde(rename = "NORMAL")]
    pub(super) normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub(super) uv: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct GltfNode {
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
pub(super) struct GltfScene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

impl GltfDocument {
    /// Reads the JSON, which begins at `start` in the file.
    pub(super) fn read(json: &[u8], start: usize, ledger: &mut Ledger) -> Result<Self, Fault> {
        charge_values(json, ledger)?;
        let document: GltfDocument = serde_json::from_slice(json).map_err(|error| {
            // Objects of glTF 1.0 have another form.
            let asset = serde_json::from_slice::<Versioned>(json).map(|versioned| versioned.asset).unwrap_or_default();
            asset.check().err().unwrap_or_else(|| wrong_json(json, start, &error))
        })?;
        document.asset.check()?;
        match document.extensions_required.iter().find(|name| !HARMLESS.iter().any(|start| name.starts_with(start))) {
            Some(name) => Err(Fault::new(format!("it requires the extension `{name}`, which is not read"))
                .help("export it without compression and without extensions of geometry")),
            None => Ok(document),
        }
    }
}

impl GltfAsset {
    /// Checks the version. A file that has none counts as one of 2.0.
    fn check(&self) -> Result<(), Fault> {
        let version = self.version.as_str().map_or_else(|| self.version.to_string(), str::to_owned);
        if self.version.is_null() || version.split('.').next() == Some("2") {
            return Ok(());
        }
        Err(Fault::new(format!("it is of version {version} of glTF, and only glTF 2.0 is read")).help("export it as glTF 2.0"))
    }
}

/// Counts the memory that the values of JSON take when they are stored.
pub(super) fn charge_values(json: &[u8], ledger: &mut Ledger) -> Result<(), Fault> {
    let count = |mark: u8| json.iter().filter(|byte| **byte == mark).count() as u64;
    let values = count(b'{') * BYTES_PER_OBJECT + count(b',') * BYTES_PER_VALUE;
    // Strings are copied.
    ledger.charge(values + json.len() as u64)
}

/// The fault of JSON that begins at `start` in the file.
pub(super) fn wrong_json(json: &[u8], start: usize, error: &serde_json::Error) -> Fault {
    let at = start + offset(json, error.line(), error.column());
    if error.is_eof() {
        return Fault::at(at..at + 1, "the file ends in the middle of its JSON").help("the file is cut off");
    }
    let text = error.to_string();
    let message = text.split(" at line ").next().unwrap_or_default();
    let message = match message.rsplit_once(", expected ") {
        Some((found, expected)) => format!("{found}, expected {}", in_words(expected)),
        None => message.to_owned(),
    };
    Fault::at(at..at + 1, format!("the JSON of the glTF file is wrong: {message}"))
}

/// What the reader of JSON expected, which it names by its type.
fn in_words(expected: &str) -> &str {
    match expected {
        "usize" | "u64" | "u32" => "a whole number of at least 0",
        "f64" => "a number",
        "a sequence" => "a list",
        _ if expected.starts_with("struct ") => "an object",
        _ => expected,
    }
}

/// The offset of a line and a column that count from 1.
fn offset(text: &[u8], line: usize, column: usize) -> usize {
    let before: usize = text.split_inclusive(|byte| *byte == b'\n').take(line.saturating_sub(1)).map(<[u8]>::len).sum();
    (before + column.saturating_sub(1)).min(text.len().saturating_sub(1))
}
