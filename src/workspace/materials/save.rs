//! Writing a material library as text and to its file.

use crate::files::replace_text;
use crate::workspace::materials::{Library, Material};
use crate::workspace::spanned_toml::{TomlNumber, VERSION, VERSION_KEY};
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::fs;
use std::io;
use std::path::Path;

/// The file, with its tables in the order of the materials.
struct LibraryFile<'l>(&'l Library);

/// A table of the file, with its keys in the order of the values.
struct MaterialTable<'l>(&'l Material);

impl Serialize for LibraryFile<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1 + self.0.len()))?;
        map.serialize_entry(VERSION_KEY, &VERSION)?;
        for material in self.0.iter() {
            map.serialize_entry(material.name(), &MaterialTable(material))?;
        }
        map.end()
    }
}

impl Serialize for MaterialTable<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.properties.iter().map(|property| (&property.parameter, TomlNumber::from(&property.value))))
    }
}

pub(super) fn to_toml(library: &Library) -> Result<String, toml::ser::Error> {
    toml::to_string(&LibraryFile(library))
}

pub(super) fn save(library: &Library, path: &Path) -> io::Result<()> {
    let text = to_toml(library).map_err(io::Error::other)?;
    // The file is replaced by another one, which its write protection would not prevent.
    if fs::metadata(path).is_ok_and(|metadata| metadata.permissions().readonly()) {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder)?;
    }
    replace_text(path, &text)
}
