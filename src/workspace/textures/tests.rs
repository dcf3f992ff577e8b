//! Images of every format, sound and damaged.

use super::*;
use crate::files::Readable;
use crate::scene::Scene;
use crate::workspace::project::{Listener, OpenProjectError, Project, Request, SessionText};
use crate::workspace::{FileValue, Session, Values};
use image::{ExtendedColorType, ImageEncoder, Rgb, Rgb32FImage, RgbImage};
use std::fs;
use std::path::PathBuf;

fn texture(path: &Path) -> &'static TextureImage {
    let number = load(path).unwrap_or_else(|error| panic!("{}", error.message()));
    texture::numbered(number).expect("a texture")
}

fn near(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= tolerance);
    assert!(close, "{found:?} is not {expected:?}");
}

/// Above red and green, below blue and grey.
fn four() -> RgbImage {
    let pixels = vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 188, 188, 188];
    RgbImage::from_raw(2, 2, pixels).expect("four pixels")
}

#[test]
fn png_is_srgb_and_its_last_row_is_the_lowest() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("four.png");
    four().save(&path).expect("a file");
    let texture = texture(&path);
    assert_eq!(texture.size(), [2, 2]);
    assert_eq!((texture.texel(0, 1), texture.texel(1, 1)), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
    assert_eq!(texture.texel(0, 0), [0.0, 0.0, 1.0]);
    // ((188/255 + 0.055)/1.055)^2.4, by IEC 61966-2-1.
    near(texture.texel(1, 0), [0.502_886_5; 3], 1e-6);
    // Transparency is left out, and grey is three equal components.
    let path = folder.path().join("grey.png");
    image::GrayAlphaImage::from_raw(1, 1, vec![188, 0]).expect("a pixel").save(&path).expect("a file");
    near(self::texture(&path).texel(0, 0), [0.502_886_5; 3], 1e-6);
    let path = folder.path().join("deep.png");
    let deep = image::ImageBuffer::<Rgb<u16>, _>::from_raw(1, 1, vec![65_535_u16, 0, 188 * 257]).expect("a pixel");
    deep.save(&path).expect("a file");
    near(self::texture(&path).texel(0, 0), [1.0, 0.0, 0.502_886_5], 1e-6);
}

#[test]
fn jpeg_is_srgb_and_exr_and_hdr_are_linear() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grey.jpeg");
    RgbImage::from_pixel(8, 8, Rgb([188; 3])).save(&path).expect("a file");
    near(texture(&path).texel(3, 3), [0.502_886_5; 3], 0.01);
    let bright = Rgb32FImage::from_raw(1, 2, vec![4.0, 0.5, 0.25, 0.125, 0.0, 16.0]).expect("pixels");
    for name in ["bright.exr", "bright.hdr"] {
        let path = folder.path().join(name);
        bright.save(&path).expect("a file");
        let texture = texture(&path);
        // The exponent of HDR is shared by the three components, which have eight bits.
        near(texture.texel(0, 1), [4.0, 0.5, 0.25], 0.02);
        near(texture.texel(0, 0), [0.125, 0.0, 16.0], 0.13);
    }
    // Some programs begin Radiance files with another word.
    let bytes = fs::read(folder.path().join("bright.hdr")).expect("the file");
    let rest = bytes.strip_prefix(b"#?RADIANCE").expect("a signature");
    fs::write(folder.path().join("other.hdr"), [b"#?RGBE", rest].concat()).expect("a file");
    near(self::texture(&folder.path().join("other.hdr")).texel(0, 1), [4.0, 0.5, 0.25], 0.02);
}

#[test]
fn header_lines_of_radiance_files_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plain.hdr");
    Rgb32FImage::from_raw(2, 1, vec![4.0, 2.0, 1.0, 0.0, 1.0, 0.5]).expect("pixels").save(&path).expect("a file");
    let bytes = fs::read(&path).expect("the file");
    let rest = bytes.strip_prefix(b"#?RADIANCE\n").expect("a signature");
    let with = |lines: &str| {
        let path = folder.path().join("lines.hdr");
        fs::write(&path, [b"#?RADIANCE\n", lines.as_bytes(), rest].concat()).expect("a file");
        load(&path).map(|number| texture::numbered(number).expect("a texture")).map_err(|error| error.message().to_owned())
    };
    // The lines say by what the numbers were multiplied: 4·½·⟨1, 2, 4⟩.
    let texture = with("EXPOSURE=4\nEXPOSURE= 0.5\nCOLORCORR=1 2 4\n").expect("an image");
    assert_eq!([texture.texel(0, 0), texture.texel(1, 0)], [[2.0, 0.5, 0.125], [0.0, 0.25, 0.0625]]);
    for wrong in ["EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=nan\n", "COLORCORR=1 0 1\n", "EXPOSURE=1e30\nEXPOSURE=1e30\n"] {
        let message = with(wrong).expect_err(wrong);
        assert!(message.ends_with("its EXPOSURE or COLORCORR is not a number above 0"), "{message}");
    }
    let text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 2 +X 4\n";
    fs::write(&path, text).expect("a file");
    assert!(load(&path).expect_err("turned").message().ends_with("only the orientation -Y +X is read"));
    fs::write(&path, "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 4\n").expect("a file");
    assert!(load(&path).expect_err("XYZ").message().ends_with("its colours are XYZ: only RGB is read"));
}

#[test]
fn a_file_is_read_again_when_it_has_changed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("four.png");
    four().save(&path).expect("a file");
    let first = load(&path).expect("an image");
    assert_eq!(load(&path), Ok(first));
    RgbImage::from_pixel(40, 30, Rgb([7, 8, 9])).save(&path).expect("a file");
    let second = load(&path).expect("an image");
    assert!(second > first);
    assert_eq!(texture::path_of(second), Some(path.as_path()));
    assert_eq!(load(Path::new("")), Ok(0.0));
}

#[test]
fn what_cannot_be_read_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let message = |name: &str| {
        let error = load(&path(name)).expect_err(name);
        assert!(error.message().contains(&format!("{name}`")), "{}", error.message());
        (error.message().to_owned(), error.hints().join(" "))
    };
    four().save(path("wood.png")).expect("a file");
    assert!(message("wod.png").1.contains("wood.png"), "the nearest file");
    fs::write(path("text.png"), "formula; = Cd;").expect("a file");
    assert!(message("text.png").0.ends_with("it is no image of a known format"));
    fs::write(path("empty.png"), "").expect("a file");
    assert_eq!(message("empty.png").1, "");
    assert!(message("empty.png").0.ends_with("the file is empty"));
    fs::write(path("pointer.png"), "version https://git-lfs.github.com/spec/v1\n").expect("a file");
    assert!(message("pointer.png").0.ends_with("it looks like a pointer of Git LFS"));
    fs::create_dir(path("folder.png")).expect("a folder");
    assert!(message("folder.png").0.ends_with("it is a folder, not a file"));
    image::codecs::bmp::BmpEncoder::new(&mut fs::File::create(path("old.png")).expect("a file"))
        .write_image(four().as_raw(), 2, 2, ExtendedColorType::Rgb8)
        .expect("a file");
    assert!(message("old.png").0.ends_with("it is no image of a known format"));
    // Damaged at each byte, and cut off after each. The image may still be readable.
    for suffix in ["png", "jpeg", "exr", "hdr"] {
        let sound = path(&format!("sound.{suffix}"));
        match suffix {
            "png" | "jpeg" => four().save(&sound).expect("a file"),
            _ => Rgb32FImage::from_pixel(2, 2, Rgb([1.0, 2.0, 3.0])).save(&sound).expect("a file"),
        }
        let bytes = fs::read(&sound).expect("the file");
        let name = format!("damaged.{suffix}");
        for at in 0..bytes.len() {
            fs::write(path(&name), &bytes[..at]).expect("a file");
            let cut = load(&path(&name));
            let mut changed = bytes.clone();
            changed[at] ^= 0xff;
            fs::write(path(&name), changed).expect("a file");
            for error in [cut, load(&path(&name))].into_iter().filter_map(Result::err) {
                assert!(error.message().contains(&name), "{}", error.message());
            }
        }
        fs::write(path(&name), &bytes[..bytes.len() / 2]).expect("a file");
        let (cut, help) = message(&name);
        // Half of so small a HDR file is in its header.
        assert!(suffix == "hdr" || cut.ends_with("the file ends too early"), "{cut}");
        assert_eq!(help, "");
    }
}

#[test]
fn a_header_that_lies_allocates_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("large.png");
    // A Radiance header for 4·10⁹ texels, with no texel behind it.
    fs::write(&path, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65000 +X 65000\n").expect("a file");
    let error = load(&path).expect_err("too large");
    assert!(error.message().contains("16384"), "{}", error.message());
}

/// Keeps what it is told.
#[derive(Default)]
struct Notes(Vec<String>);

impl Listener for Notes {
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source) {
        self.0.extend(diagnostics.iter().map(|found| format!("{}: {}", source.name(), found.message())));
    }

    fn message(&mut self, diagnostic: Diagnostic) {
        self.0.push(diagnostic.message().to_owned());
    }

    fn remark(&mut self, text: &str) {
        self.0.push(text.to_owned());
    }
}

const FORMULA: &str =
    "global; sky: texture; body_specific; wood: texture, default \"four.png\"; formula; = wood(u, v)*sky(u, v);";
const SCENE: &str = "bodies; ball: sphere, center <0,0,0>, radius 1; cube: box, <2,0,0>, <3,1,1>; lights;
    camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 45;";

fn open(folder: &Path, session: &str) -> Result<Project, (OpenProjectError, Vec<String>)> {
    fs::write(folder.join("s.toml"), session).expect("a file");
    let location = Location::File(folder.join("s.toml"));
    let request = Request { session: Some(SessionText::At(location)), ..Request::default() };
    let mut notes = Notes::default();
    Project::open(&request, &mut notes).map_err(|error| (error, notes.0))
}

#[test]
fn sessions_name_images_relative_to_themselves() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::create_dir_all(folder.join("models")).expect("a folder");
    fs::create_dir_all(folder.join("images")).expect("a folder");
    four().save(folder.join("models/four.png")).expect("a file");
    four().save(folder.join("images/other.png")).expect("a file");
    fs::write(folder.join("models/m.formula"), FORMULA).expect("a file");
    fs::write(folder.join("s.scene"), SCENE).expect("a file");
    let head = "version = 1\nformula = \"models/m.formula\"\nscene = \"s.scene\"\n";
    let text = format!("{head}[global]\nsky = \"images/other.png\"\n[bodies.cube]\nwood = \"\"\n");
    let project = open(folder, &text).expect("a session");
    let paths = |values: &Values| -> Vec<Option<PathBuf>> {
        let textures = values.iter().filter(|(_, id, _)| values.table().parameter(*id).ty == Type::Texture);
        textures.map(|(_, _, numbers)| texture::path_of(numbers[0]).map(Path::to_owned)).collect()
    };
    let all = [Some(folder.join("images/other.png")), Some(folder.join("models/four.png")), None];
    assert_eq!(paths(&project.values), all);
    // What is saved is read again.
    let saved = Session {
        formula: project.formula_location.clone(),
        scene: project.scene_location.clone(),
        picture: project.picture,
        values: Session::name_values(&project.values),
    };
    let text = saved.to_toml(folder).expect("a text");
    assert!(text.contains("sky = \"images/other.png\"") && text.contains("wood = \"models/four.png\""), "{text}");
    assert_eq!(paths(&open(folder, &text).expect("a session").values), all);
    let elsewhere = saved.to_toml(&folder.join("models")).expect("a text");
    assert!(elsewhere.contains("sky = \"../images/other.png\"") && elsewhere.contains("wood = \"four.png\""), "{elsewhere}");
    // Another formula keeps the images of parameters that it has too.
    let source = Source::new("other", FORMULA.replace("sky(u, v)", "1"));
    let location = Location::File(folder.join("models/other.formula"));
    let (formula, _) = parse_formula(&source, &location).expect("a formula");
    let (scene, _) = Scene::parse(&Source::new("scene", SCENE)).expect("a scene");
    assert_eq!(paths(&project.values.carry_over(&formula, &scene).0), all);
    let (_, told) = open(folder, &format!("{head}[bodies.ball]\nwood = \"images/none.png\"\n")).expect_err("no such file");
    assert!(told.len() == 1 && told[0].contains("images/none.png`: there is no such file"), "{told:?}");
    // A number is no image, and an image no number: warnings, as for other types.
    assert!(open(folder, &format!("{head}[bodies.ball]\nwood = 3\nkr = \"a.png\"\n")).is_ok());
    // A name without a suffix stays the path of an image.
    fs::copy(folder.join("models/four.png"), folder.join("four")).expect("a file");
    let project = open(folder, &format!("{head}[bodies.ball]\nwood = \"./four\"\n")).expect("a session");
    let saved = Session { values: Session::name_values(&project.values), ..saved };
    let text = saved.to_toml(folder).expect("a text");
    assert_eq!(paths(&open(folder, &text).expect("a session").values)[1], Some(folder.join("./four")), "{text}");
    fs::remove_file(folder.join("models/four.png")).expect("removed");
    let (_, told) = open(folder, head).expect_err("no such file");
    assert!(told.len() == 1 && told[0].contains("models/four.png`"), "{told:?}");
}

#[test]
fn materials_name_images_relative_to_their_library() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    four().save(folder.join("four.png")).expect("a file");
    let location = Location::File(folder.join("m.formula"));
    let (formula, _) = parse_formula(&Source::new("m", FORMULA), &location).expect("a formula");
    let (scene, _) = Scene::parse(&Source::new("scene", SCENE)).expect("a scene");
    let values = Values::defaults(&formula, &scene);
    let body = crate::scene::BodyId(0);
    let material = crate::workspace::Material::of_body("oak", &values, body).expect("a name");
    let image = FileValue::Image(folder.join("four.png"));
    assert!(material.properties.iter().any(|property| property.parameter == "wood" && property.value == image));
    let mut library = crate::workspace::Library::default();
    library.put(material.clone());
    let path = folder.join("own.toml");
    library.save(&path).expect("a file");
    let text = fs::read_to_string(&path).expect("the file");
    assert!(text.contains("wood = \"four.png\""), "{text}");
    let at = crate::workspace::materials::LibraryLocation::find(Some("own.toml"), Some(&location), None).expect("a place");
    let (materials, _) = crate::workspace::Materials::open(at, Readable::Regular).unwrap_or_else(|_| panic!("a library"));
    let oak = materials.get("oak").expect("the material");
    assert!(oak.is_of(&values, body));
    assert_eq!(oak.assignments(values.table(), body).0, material.assignments(values.table(), body).0);
}
