//! Pictures against an independent renderer in double precision, `tests/reference/reference.py`. It was written from
//! the description of the languages alone.
//!
//! `cases` are pictures of one pass. A pixel is stable if it keeps its colour under a shift of a hundredth of a pixel.
//! Of the stable pixels, 99.9 % must agree within 2e-3.
//!
//! `sampled` are pictures of lights with an area and of environments: the mean of many passes, against sums over grids
//! of rays and of points of lights. The reference also has the standard deviation of one pass. See [`judge`].

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const TOLERANCE: f32 = 2e-3;
const SHARE: f64 = 0.999;
/// Passes of pictures whose brightness is told to 1 %.
const MANY: u32 = 128;

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

/// Renders a case of a folder. The components of the picture are linear floats.
fn render(case: &str, options: &[&str]) -> Result<image::Rgb32FImage, String> {
    let out = tempfile::tempdir().expect("a temporary folder");
    let picture = out.path().join("out.exr");
    let file = |kind: &str| folder().join(format!("{case}.{kind}"));
    let arguments = fs::read_to_string(file("args")).unwrap_or_default();
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .arg("render")
        .arg("--formula")
        .arg(file("formula"))
        .arg("--scene")
        .arg(file("scene"))
        .args(options)
        .args(arguments.split_whitespace())
        .arg("-o")
        .arg(&picture)
        .output()
        .expect("the program runs");
    if !output.status.success() {
        return Err(format!("{case} {options:?}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(image::open(&picture).expect("the program's own picture").into_rgb32f())
}

fn check(name: &str, backend: &str) -> Result<(), String> {
    let ours = render(&format!("cases/{name}"), &["--size", "64x48", "--backend", backend])?;
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

/// What is wrong with a mean of `passes` passes, if anything. All three are components of pixels, row by row.
///
/// - The root of the mean square of the differences is at most that of independent passes,
///   sqrt(mean(deviation²) / passes). The program's passes are spread evenly and do better, and so leave room for what
///   the reference misses.
/// - The mean difference of each of red, green and blue is at most four times its standard error, which follows from
///   how the differences of pixels scatter, and 0.1 % of the mean for what the grids of the reference miss.
fn judge(ours: &[f32], theirs: &[f64], deviations: &[f32], passes: u32) -> Result<(), String> {
    let pixels = (ours.len() / 3) as f64;
    let differences: Vec<f64> = ours.iter().zip(theirs).map(|(ours, theirs)| f64::from(*ours) - theirs).collect();
    let square = differences.iter().map(|difference| difference * difference).sum::<f64>();
    let variance = deviations.iter().map(|deviation| f64::from(*deviation).powi(2)).sum::<f64>();
    if square > variance / f64::from(passes) {
        let [found, allowed] = [square, variance / f64::from(passes)].map(|sum| (sum / (3.0 * pixels)).sqrt());
        return Err(format!("the root of the mean square is {found}, and {allowed} is allowed"));
    }
    for component in 0..3 {
        let of = |numbers: &[f64]| -> (f64, f64) {
            let sum =
                |f: fn(f64) -> f64| numbers.iter().skip(component).step_by(3).map(|number| f(*number)).sum::<f64>() / pixels;
            let mean = sum(|number| number);
            (mean, sum(|number| number * number) - mean * mean)
        };
        let ((mean, scatter), (whole, _)) = (of(&differences), of(theirs));
        let allowed = 4.0 * (scatter / pixels).sqrt() + 1e-3 * whole;
        if mean.is_nan() || mean.abs() > allowed {
            return Err(format!("component {component} is {mean} off {whole}, and {allowed} is allowed"));
        }
    }
    Ok(())
}

/// Compares a case of lights with noise. With [`MANY`] passes, it must tell a picture that is 1 % brighter.
fn check_sampled(name: &str, backend: &str, passes: u32) -> Result<(), String> {
    let options = ["--size", "32x24", "--backend", backend, "--samples", &passes.to_string()];
    let ours = render(&format!("sampled/{name}"), &options)?;
    let picture = |kind: &str| read_pfm(&folder().join(format!("pictures/sampled/{name}.{kind}")));
    let ((width, height, theirs), (_, _, deviations)) = (picture("pfm"), picture("deviation.pfm"));
    assert_eq!((ours.width() as usize, ours.height() as usize, deviations.len()), (width, height, theirs.len()));
    let judge = |brightness: f64| {
        let theirs: Vec<f64> = theirs.iter().map(|component| f64::from(*component) * brightness).collect();
        judge(ours.as_raw(), &theirs, &deviations, passes)
            .map_err(|wrong| format!("{name} ({backend}, {passes} passes): {wrong}"))
    };
    judge(1.0)?;
    if passes < MANY {
        return Ok(());
    }
    match [0.99, 1.01].map(judge) {
        [Err(_), Err(_)] => Ok(()),
        _ => Err(format!("{name} ({backend}, {passes} passes): 1 % of light is not told")),
    }
}

fn names(of: &str) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder().join(of))
        .expect("the cases")
        .filter_map(|entry| entry.expect("an entry").file_name().to_str()?.strip_suffix(".formula").map(str::to_owned))
        .collect();
    names.sort();
    names
}

#[test]
fn pictures_agree_with_the_reference_renderer() {
    let names = names("cases");
    assert!(names.len() >= 46, "all cases are there");
    let failures: Vec<String> = names
        .iter()
        .flat_map(|name| ["jit", "interpreter"].map(|backend| check(name, backend)))
        .filter_map(Result::err)
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn means_of_passes_agree_with_the_reference_renderer() {
    let names = names("sampled");
    assert!(names.len() >= 7, "all cases are there");
    let failures: Vec<String> = names
        .iter()
        .flat_map(|name| [("jit", MANY), ("interpreter", 16)].map(|(backend, passes)| check_sampled(name, backend, passes)))
        .filter_map(Result::err)
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
