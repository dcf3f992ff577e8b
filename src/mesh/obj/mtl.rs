//! MTL files: the materials of OBJ files. Colours count as linear RGB, as programs of today write them.

use crate::mesh::error::{Fault, Places};
use crate::mesh::images::{IMAGES, REPEATED};
use crate::mesh::ledger::Ledger;
use crate::mesh::model::{ModelLook, Omissions, PhongLook};
use crate::mesh::text::{TextCursor, TextWord};
use crate::mesh::{MeshFile, contents_of, is_relative};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A material, with the file of the image by which its matte colour is multiplied.
pub(super) struct MtlMaterial {
    pub(super) look: ModelLook,
    pub(super) image: Option<PathBuf>,
}

/// The materials of all files that an OBJ file names.
#[derive(Default)]
pub(super) struct MaterialLibraries {
    pub(super) materials: BTreeMap<String, MtlMaterial>,
    pub(super) omissions: Omissions,
}

/// The memory for a material beside its name, at most, in bytes.
const BYTES_PER_MATERIAL: u64 = 512;

/// The material of MTL files that say nothing more.
const PLAIN: PhongLook = PhongLook {
    diffuse: [0.8; 3],
    specular: [0.0; 3],
    sharpness: 10.0,
    index: None,
    coverage: 1.0,
    filter: [0.0; 3],
    illumination: 2,
};

/// Reads the files that the lines `mtllib` of an OBJ file at this path name. One that cannot be read is left out.
pub(super) fn read_all(libraries: &[String], path: &Path, ledger: &mut Ledger) -> Result<MaterialLibraries, Fault> {
    let mut all = MaterialLibraries::default();
    for name in libraries {
        // One line may name several files, and the name of a file may have blanks.
        let folder = path.parent().unwrap_or(Path::new(""));
        let several = !folder.join(name).exists() && name.split_whitespace().count() > 1;
        let names = if several { name.split_whitespace().collect() } else { vec![name.as_str()] };
        for name in names {
            if !is_relative(name) {
                all.omissions.add(1, "file(s) of materials not named by a relative path", "");
                continue;
            }
            let file = folder.join(name);
            match contents_of(&file, "file", ledger) {
                Ok(bytes) => {
                    let shown = file.display().to_string();
                    let outcome = all.read(&MeshFile { path: &file, bytes: &bytes }, ledger);
                    outcome.map_err(|fault| Fault::Elsewhere(Box::new(fault.in_file(&shown, &bytes, |_| Places::Lines))))?;
                    ledger.release(bytes);
                }
                Err(Fault::File(error)) => all.omissions.add(1, "file(s) of materials", &error.message),
                Err(Fault::Content(_)) => all.omissions.add(1, "file(s) of materials", "it is empty"),
                Err(fault @ (Fault::Cancelled | Fault::Memory { .. } | Fault::Elsewhere(_))) => return Err(fault),
            }
        }
    }
    Ok(all)
}

impl MaterialLibraries {
    fn read(&mut self, file: &MeshFile, ledger: &mut Ledger) -> Result<(), Fault> {
        let mut cursor = TextCursor::new(file.bytes, file.text_start());
        let mut current: Option<(String, PhongLook, Option<PathBuf>)> = None;
        let mut line = 0;
        while !cursor.is_at_end() {
            ledger.check(line)?;
            if let Some(keyword) = cursor.word_in_line() {
                if keyword.is("newmtl") {
                    self.keep(current.take());
                    let name = String::from_utf8_lossy(cursor.rest_of_line().bytes).into_owned();
                    ledger.charge(BYTES_PER_MATERIAL + name.len() as u64)?;
                    current = Some((name, PLAIN, None));
                } else if let Some((_, _, image)) = current.as_mut().filter(|_| keyword.is("map_Kd")) {
                    let name = image_name(&mut cursor, &mut self.omissions);
                    ledger.charge(name.as_ref().map_or(0, |name| 2 * name.len() as u64))?;
                    *image = name.map(|name| file.path.parent().unwrap_or(Path::new("")).join(name));
                } else if let Some((_, look, _)) = &mut current {
                    read_value(&keyword, &mut cursor, look, &mut self.omissions)?;
                }
            }
            cursor.skip_line();
            line += 1;
        }
        self.keep(current);
        Ok(())
    }

    fn keep(&mut self, material: Option<(String, PhongLook, Option<PathBuf>)>) {
        if let Some((name, look, image)) = material {
            self.materials.insert(name, MtlMaterial { look: ModelLook::Phong(look), image });
        }
    }
}

/// Reads what a line says about a material.
fn read_value(keyword: &TextWord, cursor: &mut TextCursor, look: &mut PhongLook, omissions: &mut Omissions) -> Result<(), Fault> {
    let is = |word: &str| keyword.is(word);
    let starts = |start: &str| keyword.bytes.get(..start.len()).is_some_and(|bytes| bytes.eq_ignore_ascii_case(start.as_bytes()));
    if is("Kd") {
        look.diffuse = color(keyword, cursor, omissions)?.unwrap_or(look.diffuse);
    } else if is("Ks") {
        look.specular = color(keyword, cursor, omissions)?.unwrap_or(look.specular);
    } else if is("Tf") {
        look.filter = color(keyword, cursor, omissions)?.unwrap_or(look.filter);
    } else if is("Ke") {
        let shines = color(keyword, cursor, omissions)?.is_some_and(|color| color.iter().any(|component| *component > 0.0));
        omissions.add(u64::from(shines), "material(s) with a light of their own", "it is not shown");
    } else if is("Ns") {
        look.sharpness = number(keyword, cursor)?;
    } else if is("Ni") {
        look.index = Some(number(keyword, cursor)?);
    } else if is("d") {
        let word = value(keyword, cursor)?;
        look.coverage = if word.is("-halo") { number(keyword, cursor)? } else { finite(&word)? };
    } else if is("Tr") {
        look.coverage = 1.0 - number(keyword, cursor)?;
    } else if is("illum") {
        let word = value(keyword, cursor)?;
        let model = word.parse().filter(|model| *model <= 10);
        look.illumination = model.ok_or_else(|| {
            Fault::at(word.at.clone(), format!("`{}` is not an illumination model", word.shown())).help("there are 0 to 10")
        })?;
    } else if starts("map_") || ["bump", "disp", "decal", "refl", "norm"].into_iter().any(is) {
        omissions.add(1, "texture(s) of other things than colour", "");
    } else if ["Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor"].into_iter().any(is) {
        omissions.add(1, "number(s) of physical materials", "`Pr`, `Pm` and the like are no part of MTL files proper");
    }
    Ok(())
}

/// The options of textures with a fixed number of words behind them. Those of `OPTIONS_OF_PLACE` have one to three
/// numbers.
const OPTIONS: [(&str, usize); 10] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-bm", 1),
    ("-boost", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-texres", 1),
    ("-type", 1),
];
const OPTIONS_OF_PLACE: [&str; 3] = ["-o", "-s", "-t"];

/// The relative path of an image, behind its options.
fn image_name(cursor: &mut TextCursor, omissions: &mut Omissions) -> Option<String> {
    loop {
        let mut ahead = cursor.clone();
        let word = ahead.word_in_line()?;
        if let Some((_, count)) = OPTIONS.iter().find(|(option, _)| word.is(option)) {
            let first = ahead.word_in_line()?;
            for _ in 1..*count {
                ahead.word_in_line();
            }
            omissions.add(u64::from(word.is("-clamp") && first.is("on")), "texture(s) held at the edges", REPEATED);
        } else if OPTIONS_OF_PLACE.into_iter().any(|option| word.is(option)) {
            omissions.add(1, "texture(s) with place or scale", "the surface coordinates alone say where it is");
            for _ in 0..3 {
                let before = ahead.clone();
                if ahead.word_in_line()?.parse::<f64>().is_none() {
                    ahead = before;
                    break;
                }
            }
        } else {
            break;
        }
        *cursor = ahead;
    }
    let name = String::from_utf8_lossy(cursor.rest_of_line().bytes).trim_matches('"').replace('\\', "/");
    if is_relative(&name) {
        return Some(name);
    }
    omissions.add(1, IMAGES, "not named by a relative path");
    None
}

/// The word behind a keyword.
fn value<'t>(keyword: &TextWord, cursor: &mut TextCursor<'t>) -> Result<TextWord<'t>, Fault> {
    let here = keyword.at.start..cursor.offset();
    cursor.word_in_line().ok_or_else(|| Fault::at(here, format!("a number is missing after `{}`", keyword.shown())))
}

fn number(keyword: &TextWord, cursor: &mut TextCursor) -> Result<f64, Fault> {
    finite(&value(keyword, cursor)?)
}

fn finite(word: &TextWord) -> Result<f64, Fault> {
    let number = word.number()?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(Fault::at(word.at.clone(), format!("`{}` is not a finite number", word.shown())))
    }
}

/// Three numbers, or one for all; `None` for a colour that is not RGB.
fn color(keyword: &TextWord, cursor: &mut TextCursor, omissions: &mut Omissions) -> Result<Option<[f64; 3]>, Fault> {
    let first = value(keyword, cursor)?;
    if first.is("spectral") || first.is("xyz") {
        omissions.add(1, "colour(s) not in RGB", "");
        return Ok(None);
    }
    let red = finite(&first)?;
    let is_comment = |word: &TextWord| word.bytes[0] == b'#';
    match cursor.word_in_line().filter(|word| !is_comment(word)) {
        None => Ok(Some([red; 3])),
        Some(green) => Ok(Some([red, finite(&green)?, number(keyword, cursor)?])),
    }
}
