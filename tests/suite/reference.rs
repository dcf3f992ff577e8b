//! Pictures against an independent renderer in double precision, `tests/reference/reference.py`. It was written from
//! the description of the languages alone. A pixel is stable if it keeps its colour under a shift of a hundredth of a
//! pixel. Of the stable pixels, 99.9 % must agree within 2e-3.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const TOLERANCE: f32 = 2e-3;
const SHARE: f64 = 0.999;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference")
}

/// A file in the manner of netpbm: the words of its header (magic, width, height, last), and the data.
fn header(bytes: &[u8]) -> ([String; 4], &[u8]) {
    let mut words = Vec::new();
    let mut at = 0;
    while words.len() < 4 {
        let end = at + bytes[at..].iter().position(u8::is_ascii_whitespace).expect("a header of four words");
        words.push(String::from_utf8(bytes[at..end].to_vec()).expect("words of ASCII"));
        at = end + 1;
    }
    (words.try_into().expect("four words"), &bytes[at..])
}

/// The floats of a PFM file, row by row from the top. The file has them from the bottom.
fn read_pfm(path: &Path) -> (usize, usize, Vec<f32>) {
    let bytes = fs::read(path).expect("a reference picture");
    let ([magic, width, height, scale], data) = header(&bytes);
    assert!(magic == "PF" && scale.starts_with('-'), "a little-endian colour PFM");
    let (width, height): (usize, usize) = (width.parse().expect("a width"), height.parse().expect("a height"));
    let floats: Vec<f32> = data.chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect();
    assert_eq!(floats.len(), 3 * width * height);
    (width, height, floats.chunks_exact(3 * width).rev().flatten().copied().collect())
}

fn check(name: &str, backend: &str) -> Result<(), String> {
    let cases = folder().join("cases");
    let out = tempfile::tempdir().expect("a temporary folder");
    let picture = out.path().join("out.exr");
    let arguments = fs::read_to_string(cases.join(format!("{name}.args"))).unwrap_or_default();
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .arg("render")
        .arg("--formula")
        .arg(cases.join(format!("{name}.formula")))
        .arg("--scene")
        .arg(cases.join(format!("{name}.scene")))
        .args(["--size", "64x48", "--backend", backend])
        .args(arguments.split_whitespace())
        .arg("-o")
        .arg(&picture)
        .output()
        .expect("the program runs");
    if !output.status.success() {
        return Err(format!("{name} ({backend}): {}", String::from_utf8_lossy(&output.stderr)));
    }
    let ours = image::open(&picture).expect("the program's own picture").into_rgb32f();
    let (width, height, theirs) = read_pfm(&folder().join(format!("pictures/{name}.pfm")));
    let mask = fs::read(folder().join(format!("pictures/{name}.mask"))).expect("a mask");
    let (_, stable) = header(&mask);
    assert_eq!((ours.width() as usize, ours.height() as usize, stable.len()), (width, height, width * height));
    let pixels = ours.as_raw().chunks_exact(3).zip(theirs.chunks_exact(3)).zip(stable);
    let (mut compared, mut agreeing, mut worst) = (0, 0, (0.0, 0));
    for (index, ((ours, theirs), stable)) in pixels.enumerate() {
        if *stable == 0 {
            continue;
        }
        compared += 1;
        let difference =
            |(ours, theirs): (&f32, &f32)| if ours == theirs { 0.0 } else { (ours - theirs).abs() / theirs.abs().max(1.0) };
        let largest = ours.iter().zip(theirs).map(difference).fold(0.0, |one: f32, other| if other <= one { one } else { other });
        agreeing += usize::from(largest <= TOLERANCE);
        if largest > worst.0 {
            worst = (largest, index);
        }
    }
    assert!(compared > width * height / 2, "{name}: most pixels are stable");
    let share = agreeing as f64 / compared as f64;
    let pixel = (worst.1 % width, worst.1 / width);
    if share >= SHARE {
        Ok(())
    } else {
        Err(format!("{name} ({backend}): {agreeing} of {compared} agree; worst {} at {pixel:?}", worst.0))
    }
}

#[test]
fn pictures_agree_with_the_reference_renderer() {
    let mut names: Vec<String> = fs::read_dir(folder().join("cases"))
        .expect("the cases")
        .filter_map(|entry| entry.expect("an entry").file_name().to_str()?.strip_suffix(".formula").map(str::to_owned))
        .collect();
    names.sort();
    assert!(names.len() >= 20, "all cases are there");
    let failures: Vec<String> = names
        .iter()
        .flat_map(|name| ["jit", "interpreter"].map(|backend| check(name, backend)))
        .filter_map(Result::err)
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
