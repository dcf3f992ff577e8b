//! Images of materials: the formula that multiplies `Cd` by an image, and the files of the images.

use crate::import::names::UniqueNames;
use crate::mesh::{MeshModel, ModelPart, Omissions};
use crate::workspace::{FileKind, presets};

/// The parameter that the formula has more than the built-in one.
pub(super) const PARAMETER: &str = "image";
/// The macro that takes the place of `Cd`.
const COLOUR: &str = "COLOUR";

/// The text of a built-in formula with an image for each body; `None` if there is no such formula. `source` names the
/// file that was imported.
pub(super) fn formula(preset: &str, source: &str) -> Option<String> {
    let text = presets::text(FileKind::Formula, preset)?;
    let (declarations, equations) = text.split_once("\nformula;\n")?;
    let declarations = declarations.replacen(
        "\nbody_specific;\n",
        &format!("\nbody_specific;\n{PARAMETER}: texture;    // by which Cd is multiplied; white where the file has none\n"),
        1,
    );
    let equations = with_name_replaced(equations, "Cd", COLOUR);
    Some(format!(
        "// Made from {source} by `illuminator import`: preset:{preset} with images.\n{declarations}\n\
         formula;\n{COLOUR} = Cd*{PARAMETER}(u, v);\nambient = ka*Ia*{COLOUR};\n{equations}"
    ))
}

/// A text with another name in the place of a name.
fn with_name_replaced(text: &str, old: &str, new: &str) -> String {
    let is_of_name = |character: char| character.is_ascii_alphanumeric() || character == '_';
    let mut result = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(old) {
        let end = at + old.len();
        let is_whole = !rest[..at].ends_with(is_of_name) && !rest[end..].starts_with(is_of_name);
        result.push_str(&rest[..at]);
        result.push_str(if is_whole { new } else { old });
        rest = &rest[end..];
    }
    result + rest
}

/// The images that bodies have, with the names of their files.
#[derive(Default)]
pub(super) struct ImageFiles {
    names: UniqueNames,
    /// The file of each image of the model that has one.
    files: Vec<Option<String>>,
}

impl ImageFiles {
    /// The file of the image of a part; `None` if it has no image, or cannot show one.
    pub(super) fn of_part(&mut self, part: &ModelPart, model: &MeshModel, left_out: &mut Omissions) -> Option<String> {
        let index = part.material.and_then(|material| model.materials.get(material)?.image)?;
        let image = model.images.get(index)?;
        if part.mesh.uvs().is_empty() {
            left_out.add(1, "image(s)", "its part has no surface coordinates");
            return None;
        }
        if self.files.len() <= index {
            self.files.resize(index + 1, None);
        }
        let name = || format!("{}.{}", self.names.take(&image.name, "", "image"), image.suffix);
        Some(self.files[index].get_or_insert_with(name).clone())
    }

    /// The files with their contents, taken from the model.
    pub(super) fn with_contents(self, model: &mut MeshModel) -> Vec<(String, Vec<u8>)> {
        let files = self.files.into_iter().zip(&mut model.images);
        files.filter_map(|(file, image)| Some((file?, std::mem::take(&mut image.bytes)))).collect()
    }
}
