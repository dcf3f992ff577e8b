//! Parsing the text of a material library.

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::workspace::materials::{Library, Material, NameError, Property};
use crate::workspace::spanned_toml::{TomlEntry, VERSION_KEY, check_version, entries, parse as parse_toml};

pub(super) fn parse(source: &Source) -> Result<(Library, Diagnostics), Diagnostics> {
    let table = parse_toml(source)?;
    let mut diagnostics = Diagnostics::new();
    let mut library = Library::default();
    let mut version = None;
    for entry in entries(&table) {
        if entry.key == VERSION_KEY {
            version = Some(entry.value);
        } else if let Some(material) = material(&entry, &mut diagnostics) {
            // TOML allows each name only once.
            library.put(material);
        }
    }
    check_version(version, &mut diagnostics);
    diagnostics.sort();
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok((library, diagnostics)) }
}

/// The material that a table of the file defines.
fn material(entry: &TomlEntry, diagnostics: &mut Diagnostics) -> Option<Material> {
    let named = Material::new(entry.key).map_err(|error| {
        let expected = match error {
            NameError::Empty => "expected a name",
            NameError::Reserved | NameError::Form => "not a name",
        };
        Diagnostic::error(error.to_string()).at(entry.key_span, expected)
    });
    let table = entry.value.table().map_err(|diagnostic| {
        diagnostic.help(format!(
            "a library holds one table a material; write `[{}]` on a line, then its values, such as `kr = 0.3`",
            entry.key
        ))
    });
    let (mut material, table) = match (named, table) {
        (Ok(material), Ok(table)) => (material, table),
        (named, table) => {
            named.err().into_iter().chain(table.err()).for_each(|diagnostic| diagnostics.push(diagnostic));
            return None;
        }
    };
    for TomlEntry { key, key_span, value } in entries(table) {
        match value.given() {
            Ok(value) => material.properties.push(Property { parameter: key.to_owned(), value, span: key_span }),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    if entries(table).is_empty() {
        let message = format!("the material `{}` has no values and changes nothing", entry.key);
        diagnostics.push(Diagnostic::warning(message).at(entry.key_span, "expected values below it, such as `kr = 0.3`"));
    }
    Some(material)
}
