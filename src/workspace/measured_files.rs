//! Files of measured materials that formulas name. How they are read is in `measured`.
//!
//! A file is read once, until it changes. So two formulas that name it share one material.

use crate::files::{FileStamp, NoRoom};
use crate::formula::Formula;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::measured::{self, MeasuredError, Measurement, kept};
use crate::workspace::location::near_file;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// How many times the numbers of a file are in memory at most while it is read: in the file, and twice in the material.
const COPIES: u64 = 3;

/// The numbers of the materials that were read.
static READ: Mutex<Option<HashMap<FileStamp, f32>>> = Mutex::new(None);

/// Whether the suffix of a file is that of measured materials.
pub fn is_named_like_material(path: &Path) -> bool {
    let suffix = path.extension().and_then(|suffix| suffix.to_str()).unwrap_or_default().to_lowercase();
    measured::FORMATS.iter().any(|format| format.has_all_directions && format.suffixes.contains(&suffix.as_str()))
}

/// The number of the material in a file.
///
/// # Errors
/// The file cannot be read, holds no material, is damaged or too large, or there is no room for it.
pub fn load(path: &Path) -> Result<f32, Diagnostic> {
    let told = |error: MeasuredError| {
        let name = path.file_name().and_then(|name| name.to_str());
        let near = name.filter(|_| !path.exists()).and_then(|name| near_file(path, name));
        let near = near.map(|near| format!("did you mean `{}`?", near.display()));
        Diagnostic::error(error.to_string()).help_if(error.hint.or(near))
    };
    let no_room = |error: NoRoom| Diagnostic::error(format!("cannot read the measured material `{}`: {error}", path.display()));
    let (file, metadata) = measured::open(path).map_err(told)?;
    // There are many ways to write a path.
    let stamp = FileStamp::new(&path.canonicalize().unwrap_or_else(|_| path.to_owned()), &metadata);
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let read = read.get_or_insert_default();
    if let Some(number) = read.get(&stamp) {
        return Ok(*number);
    }
    kept::check_room(COPIES * metadata.len().min(measured::LARGEST_FILE)).map_err(no_room)?;
    let material = Measurement::read_from(path, file, &metadata).and_then(|read| read.material(path)).map_err(told)?;
    let number = kept::keep(path.to_owned(), material).map_err(no_room)?;
    read.insert(stamp, number);
    Ok(number)
}

/// Reads the measured materials that a formula names, with paths relative to `folder`, and reports those that cannot be
/// read.
pub fn read_materials(formula: &mut Formula, folder: &Path, diagnostics: &mut Diagnostics) {
    for material in &mut formula.materials {
        match load(&folder.join(material.path.trim())) {
            Ok(number) => material.number = number,
            Err(error) => diagnostics.push(error.at(material.span, "named here")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::workspace::Location;
    use crate::workspace::textures::parse_formula;
    use std::fs;
    use std::time::SystemTime;

    const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/measured/isotropic_rgb.bsdf");

    #[test]
    fn a_file_is_read_once_until_it_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        fs::create_dir(folder.join("models")).expect("a folder");
        fs::copy(FILE, folder.join("gold.bsdf")).expect("copied");
        let read = |path: &str, text: &str| {
            let source = Source::new("m", format!("formula; = {text};"));
            let (formula, _) = parse_formula(&source, &Location::File(folder.join(path))).expect("a formula");
            formula.materials.iter().map(|material| material.number).collect::<Vec<f32>>()
        };
        let first = read("a.formula", "measured(\"gold.bsdf\") + measured(\"gold.bsdf\", V, L)");
        assert_eq!(first.len(), 1, "one file");
        assert_eq!(kept::path_of(first[0]), Some(folder.join("gold.bsdf").as_path()));
        assert_eq!(read("b.formula", "measured(\" gold.bsdf \")"), first);
        let other = read("models/c.formula", "measured(\"../gold.bsdf\") + measured(\"../gold.bsdf\")*2");
        // Another way to the same file is the same file.
        assert_eq!(other, first);
        let file = fs::File::options().write(true).open(folder.join("gold.bsdf")).expect("a file");
        file.set_modified(SystemTime::UNIX_EPOCH).expect("changed");
        assert_ne!(read("a.formula", "measured(\"gold.bsdf\")"), first);
    }

    #[test]
    fn formulas_that_were_not_loaded_have_no_material() {
        let (formula, _) = Formula::parse(&Source::new("m", "formula; = measured(\"gold.bsdf\");")).expect("a formula");
        assert_eq!(formula.materials[0].number, 0.0);
    }
}
