//! Tests of the readers against other programs, known models, and damaged files.

use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

/// A file of tests/reference/measured.
fn reference(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/measured").join(name)
}

/// The lines of a table of numbers, without comments.
fn table<const N: usize>(name: &str) -> Vec<[f64; N]> {
    let text = std::fs::read_to_string(reference(name)).expect("a table");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let number = |word: &str| word.parse::<f64>().expect("a number");
    lines.map(|line| line.split(',').map(number).collect::<Vec<_>>().try_into().expect("all numbers")).collect()
}

fn vector(numbers: &[f64]) -> DVec3 {
    DVec3::from_slice(numbers)
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn material(bytes: &[u8]) -> Arc<MeasuredMaterial> {
    let read = || Measurement::of_bytes("test", bytes)?.material(Path::new("test"));
    read().unwrap_or_else(|error: MeasuredError| panic!("{error:#}"))
}

fn close(found: DVec3, expected: DVec3, relative: f64, absolute: f64) -> bool {
    (found - expected).abs().cmple(expected.abs() * relative + DVec3::splat(absolute)).all()
}

/// A MERL file whose three colours are the indices of each sample.
fn file_of_indices() -> Vec<u8> {
    let mut bytes = merl::bytes(|_, _| DVec3::ZERO);
    let numbers = bytes[12..].as_chunks_mut::<8>().0;
    for (index, scale) in [1.0, 1.15, 1.66].iter().enumerate() {
        for theta_h in 0..90 {
            for theta_d in 0..90 {
                for phi_d in 0..180 {
                    let place = [theta_h, theta_d, phi_d][index] as f64 * 1500.0 / scale;
                    numbers[((index * 90 + theta_h) * 90 + theta_d) * 180 + phi_d] = place.to_le_bytes();
                }
            }
        }
    }
    bytes
}

#[test]
fn merl_samples_are_where_brdfread_looks_for_them() {
    let table_of_indices = MerlTable::parse(&file_of_indices()).expect("a file");
    let lines = table::<12>("merl_indices.csv");
    assert_eq!(lines.len(), 200);
    for line in lines {
        let (light, view) = (vector(&line[..3]), vector(&line[3..]));
        let [places, indices] = [vector(&line[6..]), vector(&line[9..])];
        // Next to the edge of a cell, rounding decides.
        let is_inside = places.to_array().iter().all(|place| (place - place.round()).abs() > 1e-6);
        assert!(!is_inside || close(table_of_indices.nearest(light, view), indices, 1e-6, 1e-6), "{line:?}");
        // Along an axis the values are the indices, so between the middles of cells they are the coordinates less ½.
        let expected = (places - 0.5).clamp(DVec3::ZERO, DVec3::new(89.0, 89.0, 179.0));
        let found = table_of_indices.value(light, view);
        // The last and the first azimuth are neighbours.
        let is_between = (0.5..179.5).contains(&places.z);
        let found = if is_between { found } else { found.with_z(expected.z) };
        // φd has no meaning where θd is 0, and loses digits near it.
        assert!(close(found, expected, 1e-6, 1e-4), "{line:?}: {found} {expected}");
    }
}

#[test]
fn merl_values_are_reciprocal_and_isotropic() {
    let mirror = |light: DVec3, view: DVec3| DVec3::new(1.0, 0.5, 0.2) * (light + view).normalize().z.powi(20);
    let material = material(&merl::bytes(mirror));
    for (index, line) in table::<12>("merl_indices.csv").iter().enumerate() {
        let (light, view) = (vector(&line[..3]), vector(&line[3..6]));
        let value = material.value(light, view);
        assert!(close(material.value(view, light), value, 1e-5, 1e-9), "{light} {view}");
        let turned = |v: DVec3| glam::DQuat::from_rotation_z(index as f64) * v;
        assert!(close(material.value(turned(light), turned(view)), value, 1e-5, 1e-9), "{light} {view}");
        assert!(close(value, mirror(light, view), 0.02, 2e-3), "{value} {}", mirror(light, view));
    }
}

#[test]
fn a_lambert_file_is_constant_up_to_the_horizon() {
    let white = DVec3::new(0.5, 0.25, 1.0) / PI;
    let material = material(&merl::bytes(|_, _| white));
    for theta in [0.0, 0.3, 1.0, 1.5, 1.57] {
        for phi in [0.0, 1.0, 3.0, -2.0] {
            for view in [DVec3::Z, direction(1.2, 0.7), direction(1.57, 2.0)] {
                assert!(close(material.value(direction(theta, phi), view), white, 1e-6, 0.0), "{theta} {phi} {view}");
            }
        }
    }
    let below = direction(1.6, 0.0);
    for other in [DVec3::X, below, DVec3::NEG_Z, DVec3::NAN, DVec3::splat(f64::INFINITY)] {
        assert_eq!((material.value(other, DVec3::Z), material.value(DVec3::Z, other)), (DVec3::ZERO, DVec3::ZERO));
    }
}

#[test]
fn the_writer_and_the_reader_of_merl_files_agree_on_units() {
    // Half angle 40.5², difference angle 10.5, azimuth 20.5 in units of their axes: the middle of a cell.
    let mut bytes = merl::bytes(|_, _| DVec3::ZERO);
    let offset = |plane: usize| 12 + 8 * (((plane * 90 + 40) * 90 + 10) * 180 + 20);
    for plane in 0..3 {
        bytes[offset(plane)..][..8].copy_from_slice(&3000.0_f64.to_le_bytes());
    }
    let table_of_one = MerlTable::parse(&bytes).expect("a file");
    let theta_h = (40.5_f64 / 90.0).powi(2) * PI / 2.0;
    let half = direction(theta_h, 0.0);
    let in_half = direction(10.5_f64.to_radians(), 20.5_f64.to_radians());
    let light = glam::DQuat::from_rotation_y(theta_h) * in_half;
    let view = 2.0 * half.dot(light) * half - light;
    // Matusik et al.: 1/1500, 1.15/1500 and 1.66/1500.
    assert!(close(table_of_one.value(light, view), DVec3::new(2.0, 2.3, 3.32), 1e-6, 0.0));
    assert_eq!(table_of_one.nearest(light, view), table_of_one.nearest(view, light));
}

#[test]
fn samples_that_were_not_measured_are_left_out() {
    let set = |bytes: &mut [u8], plane: usize, index: usize, value: f64| {
        bytes[12 + 8 * (plane * 90 * 90 * 180 + index)..][..8].copy_from_slice(&value.to_le_bytes());
    };
    // As in files of the database, cells whose middle is below the horizon have negative numbers.
    let white = DVec3::new(0.5, 0.25, 1.0) / PI;
    let mut bytes = merl::bytes(|_, _| white);
    let index = |cell: [usize; 3]| (cell[0] * 90 + cell[1]) * 180 + cell[2];
    let mut missing = 0;
    for (theta_h, theta_d, phi_d) in (0..90).flat_map(|h| (0..90).flat_map(move |d| (0..180).map(move |phi| (h, d, phi)))) {
        let middle = |index: usize, count: f64| (index as f64 + 0.5) / count;
        let half_angle = middle(theta_h, 90.0).powi(2) * PI / 2.0;
        let in_half = direction(middle(theta_d, 90.0) * PI / 2.0, middle(phi_d, 180.0) * PI);
        let turn = glam::DQuat::from_rotation_y(half_angle);
        let light = turn * in_half;
        let view = turn * DVec3::new(-in_half.x, -in_half.y, in_half.z);
        if light.z <= 0.0 || view.z <= 0.0 {
            (0..3).for_each(|plane| set(&mut bytes, plane, index([theta_h, theta_d, phi_d]), -1.0));
            missing += 1;
        }
    }
    assert!(missing > 100_000);
    let known = material(&bytes);
    for theta in [0.0, 1.0, 1.5, 1.555] {
        for view in [DVec3::Z, direction(1.2, 0.7), direction(1.5, 2.0), direction(1.55, 3.1)] {
            assert!(close(known.value(direction(theta, 0.2), view), white, 1e-6, 0.0), "{theta} {view}");
        }
    }
    // One negative colour alone is 0.
    let mut bytes = merl::bytes(|_, _| white);
    (0..90 * 90 * 180).for_each(|index| set(&mut bytes, 1, index, -0.01));
    let value = material(&bytes).value(DVec3::Z, direction(0.5, 1.0));
    assert!(close(value, DVec3::new(0.5, 0.0, 1.0) / PI, 1e-6, 1e-12), "{value}");
    bytes[12..].as_chunks_mut::<8>().0.iter_mut().for_each(|number| *number = (-1.0_f64).to_le_bytes());
    let error = Measurement::of_bytes("none.binary", &bytes).expect_err("nothing");
    assert!(error.to_string().contains("all samples are negative, so nothing was measured"), "{error}");
}

#[test]
fn rgl_files_have_the_values_of_mitsuba() {
    for name in ["isotropic_rgb", "isotropic_spectral", "anisotropic_rgb", "half_circle_rgb", "quarter_circle_spectral"] {
        let material = MeasuredMaterial::read(&reference(&format!("{name}.bsdf"))).unwrap_or_else(|error| panic!("{error}"));
        let lines = table::<9>(&format!("{name}.csv"));
        assert_eq!((lines.len(), material.is_isotropic()), (60, name.starts_with("isotropic")));
        for line in lines {
            let (light, view, expected) = (vector(&line[..3]), vector(&line[3..6]), vector(&line[6..]));
            let found = material.value(light, view);
            // Mitsuba computes in single precision.
            assert!(close(found, expected, 1e-3, 1e-5), "{name}: {light} {view}: {found} {expected}");
        }
    }
}

#[test]
fn an_rgl_file_of_a_known_model_is_near_the_model() {
    // GGX with alpha 0.35, Schlick's Fresnel term and separable shadowing, as in tests/reference/make_measured.py.
    let model = |light: DVec3, view: DVec3| {
        let half = (light + view).normalize();
        let alpha2 = 0.35_f64 * 0.35;
        let normals = alpha2 / (PI * (half.z * half.z * (alpha2 - 1.0) + 1.0).powi(2));
        let shadowing = |z: f64| 2.0 * z / (z + (z * z + alpha2 * (1.0 - z * z)).sqrt());
        let fresnel = DVec3::new(0.95, 0.7, 0.35);
        let fresnel = fresnel + (1.0 - fresnel) * (1.0 - light.dot(half)).powi(5);
        fresnel * normals * shadowing(light.z) * shadowing(view.z) / (4.0 * light.z * view.z)
    };
    let material = MeasuredMaterial::read(&reference("isotropic_rgb.bsdf")).expect("a file");
    for (theta, phi, view) in [(0.3, 0.0, 0.0), (0.5, 3.1, 0.5), (0.7, 2.5, 0.4), (0.2, 1.0, 0.8), (0.8, 3.0, 0.8)] {
        let (light, view) = (direction(theta, phi), direction(view, 0.0));
        let (found, expected) = (material.value(light, view), model(light, view));
        assert!(close(found, expected, 0.03, 0.0), "{light} {view}: {found} {expected}");
    }
}

#[test]
fn a_white_spectrum_is_white_and_a_yellow_one_is_yellow() {
    let wavelengths = [360.0, 450.0, 520.5, 521.0, 600.0, 900.0];
    let weights = spectrum::weights(&wavelengths).expect("visible light");
    assert!(close(weights.iter().sum(), DVec3::ONE, 1e-12, 0.0));
    // By colour-science: `sd_to_XYZ` of a step from 0 at 500 nm to 1 at 501 nm under D65, as sRGB over that of white.
    let step = spectrum::weights(&[500.0, 501.0]).expect("visible light")[1];
    assert!(close(step, DVec3::from_array(STEP_AT_500), 0.0, 2e-3), "{step}");
    assert_eq!(spectrum::weights(&[800.0, 900.0]), None);
}

const STEP_AT_500: [f64; 3] = [1.058_090_7, 0.984_150_0, -0.099_148_3];

#[test]
fn lists_of_samples_are_read() {
    let plain = "# a comment\n10, 20, 30, 40, 0.1, 0.2, 0.3 # behind\n\n0 0 0 0 1 2 3\n";
    let samples = ReflectanceSamples::of_text("a.csv", plain).expect("samples").samples;
    assert_eq!(samples.len(), 2);
    assert!(samples[0].light.abs_diff_eq(direction(10_f64.to_radians(), 20_f64.to_radians()), 1e-12));
    assert!(samples[0].view.abs_diff_eq(direction(30_f64.to_radians(), 40_f64.to_radians()), 1e-12));
    assert_eq!((samples[0].value, samples[1].light), (DVec3::new(0.1, 0.2, 0.3), DVec3::Z));
    let named = "\u{FEFF}b;g;r;phi_o [rad];theta_o_rad;phi_i(deg);theta_i\r\n3;2;1;0.5;0.25;90;45\r\n";
    let samples = ReflectanceSamples::of_text("b.csv", named).expect("samples").samples;
    assert_eq!(samples[0].value, DVec3::new(1.0, 2.0, 3.0));
    assert!(samples[0].light.abs_diff_eq(direction(PI / 4.0, PI / 2.0), 1e-12));
    assert!(samples[0].view.abs_diff_eq(direction(0.25, 0.5), 1e-12));
    // As other programs write lists: a separator at the end, and columns beside.
    let more = "weight,theta_i,phi_i,theta_o,phi_o,r,g,b,note,\n0.5,10,20,30,40,0.1,0.2,0.3,,\n";
    let samples = ReflectanceSamples::of_text("c.csv", more).expect("samples").samples;
    assert_eq!((samples.len(), samples[0].value), (1, DVec3::new(0.1, 0.2, 0.3)));
    let samples = ReflectanceSamples::of_text("d.csv", "10,20,30,40,0.1,0.2,0.3,\n").expect("samples").samples;
    assert_eq!(samples[0].value, DVec3::new(0.1, 0.2, 0.3));
}

#[test]
fn mistakes_in_lists_of_samples_are_explained() {
    for (text, expected) in [
        ("", "it has no samples"),
        ("# only\n", "it has no samples"),
        ("1,2,3,4,5,6\n", "line 1, column 11: 6 numbers, and 7 were expected"),
        ("0,0,0,0,1,1,1\n0,0,0, x7,1,1,1\n", "line 2, column 8: `x7` is no number"),
        ("0,0,0,0,1,1,inf\n", "line 1, column 13: `inf` is no finite number of single precision"),
        ("0;0;0;0;0,5x;1;1\n", "line 1, column 9: `0,5x` is no number"),
        ("0,0,0,0,0,0,0,0,0,0,0,5,1,1\n", "line 1, column 27: 14 numbers, and 7 were expected"),
        ("0,0,0,0,1,1,1,1,\n", "line 1, column 15: 8 numbers, and 7 were expected"),
        ("0,0,90,0,1,1,1\n", "line 1, column 5: the polar angle `90` is not from 0 to less than 90 degrees"),
        ("theta_i,phi_i,theta_o,phi_o,r,g\n", "line 1, column 1: there is no column `b`"),
        ("theta_i,phi_i,theta_o,phi_o,r,r,g\n", "line 1, column 31: there are two columns `r`"),
        ("theta_i,phi,theta_o,phi_o,r,g,b\n", "line 1, column 9: `phi` is no number and no name of a column"),
    ] {
        let error = ReflectanceSamples::of_text("list.csv", text).expect_err(text);
        assert_eq!(error.reason(), expected);
        assert!(error.to_string().starts_with("cannot read the measured material `list.csv`: "), "{error}");
    }
}

#[test]
fn files_of_other_formats_are_explained() {
    let merl = merl::bytes(|_, _| DVec3::ONE);
    let other_sizes = [&90_i32.to_le_bytes()[..], &90_i32.to_le_bytes(), &1_i32.to_le_bytes(), &[0; 24 * 8100]].concat();
    let turned = {
        let mut bytes = merl.clone();
        bytes[8..12].copy_from_slice(&360_i32.to_le_bytes());
        bytes
    };
    let nan = {
        let mut bytes = merl.clone();
        bytes[12 + 8 * 5..][..8].copy_from_slice(&f64::NAN.to_le_bytes());
        bytes
    };
    for (bytes, expected) in [
        (&b""[..], "the file is empty"),
        (&b"\x7fELF\0\0\0\0\0\0\0\0\0\0"[..], "it is of no known format"),
        (&merl[..1000], "the file is cut off: it has 1000 bytes, and 34992012 were expected (at byte 1000)"),
        (&other_sizes, "it has 90×90×1 samples, and 90×90×180 were expected (at byte 0)"),
        (&turned, "it has 90×90×360 samples, and 90×90×180 were expected (at byte 0)"),
        (&nan, "a sample is NaN, which is no reflectance (at byte 52)"),
        (b"tensor_file\0\x02\x00", "the version of the tensor file is 2.0, and 1.0 was expected (at byte 12)"),
        (b"tensor_file\0\x01\x00", "the file ends in its header (at byte 14)"),
        (b"tensor_file\0\x01\x00\xff\xff\xff\xff", "it has 4294967295 fields, and at most 64 are possible (at byte 14)"),
        (b"tensor_file\0\x01\x00\0\0\0\0", "it has no field `phi_i`"),
    ] {
        assert_eq!(Measurement::of_bytes("x", bytes).expect_err(expected).reason(), expected);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("list.csv");
    std::fs::write(&path, "0,0,0,0,1,1,1\n").expect("written");
    assert_eq!(ReflectanceSamples::read(&path).map(|list| list.samples.len()), Ok(1));
    let error = ReflectanceSamples::read(&reference("isotropic_rgb.bsdf")).expect_err("a material");
    assert_eq!(error.reason(), "it is a material for all directions, and no list of samples");
    let error = MeasuredMaterial::read(&path).expect_err("a list");
    assert_eq!(error.reason(), "it is a list of samples, and no material for all directions");
    assert_eq!(MeasuredMaterial::read(folder.path()).expect_err("a folder").reason(), "it is a folder, not a file");
    let missing = MeasuredMaterial::read(&folder.path().join("no")).expect_err("nothing");
    assert_eq!(missing.reason(), "there is no such file");
}

#[test]
fn a_file_of_huge_length_is_refused_by_its_length() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, beginning) in [("a", &b"tensor_file\0\x01\x00"[..]), ("b", b"1,2,3"), ("c", &merl_header())] {
        let path = folder.path().join(name);
        std::fs::write(&path, beginning).expect("written");
        // A sparse file takes no space.
        File::options().write(true).open(&path).and_then(|file| file.set_len(1 << 40)).expect("lengthened");
        let error = Measurement::read(&path).expect_err("too large").reason();
        // The text is followed by zeros, so it is none.
        assert!(error.contains("1099511627776 bytes") || error == "it is of no known format", "{error}");
    }
}

fn merl_header() -> Vec<u8> {
    [90_i32, 90, 180].iter().flat_map(|size| size.to_le_bytes()).collect()
}

/// An error, or a material with finite values.
fn is_error_or_finite(bytes: &[u8]) {
    let Ok(Measurement::Material(material)) = Measurement::of_bytes("damaged", bytes) else { return };
    for (light, view) in [(DVec3::Z, DVec3::Z), (direction(1.0, 2.0), direction(1.5, -3.0)), (direction(1.57, 0.0), DVec3::Z)] {
        let value = material.value(light, view);
        assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
    }
}

#[test]
fn files_that_are_cut_off_are_errors() {
    for name in ["isotropic_rgb.bsdf", "quarter_circle_spectral.bsdf"] {
        let bytes = std::fs::read(reference(name)).expect("a file");
        for length in (0..bytes.len()).filter(|length| *length < 800 || length % 97 == 0 || bytes.len() - length < 9) {
            assert!(Measurement::of_bytes("cut", &bytes[..length]).is_err(), "{name} {length}");
        }
    }
}

proptest! {
    #[test]
    fn damaged_tensor_files_are_errors_or_finite(changes in prop::collection::vec((0_usize..600, any::<u8>()), 1..4),
                                                 numbers in prop::collection::vec((600_usize..13_000, any::<u32>()), 0..4)) {
        let mut bytes = std::fs::read(reference("isotropic_spectral.bsdf")).expect("a file");
        for (offset, byte) in changes {
            bytes[offset] = byte;
        }
        for (offset, number) in numbers {
            bytes[offset / 4 * 4..][..4].copy_from_slice(&number.to_le_bytes());
        }
        is_error_or_finite(&bytes);
    }

    #[test]
    fn damaged_lists_are_errors_or_samples(text in "([-0-9.,;e \\t\\nthaiophrgb_#\u{e9}]{0,80})") {
        if let Ok(samples) = ReflectanceSamples::of_text("list", &text) {
            prop_assert!(samples.samples.iter().all(|sample| sample.light.is_normalized() && sample.value.is_finite()));
        }
    }

    #[test]
    fn any_bytes_are_errors_or_finite(bytes in prop::collection::vec(any::<u8>(), 0..200), is_tensor in any::<bool>()) {
        let beginning: &[u8] = if is_tensor { b"tensor_file\0\x01\x00\x02\0\0\0" } else { b"" };
        is_error_or_finite(&[beginning, &bytes].concat());
    }
}

#[test]
fn samples_of_merl_files_are_found_near_any_directions() {
    let model = |light: DVec3, view: DVec3| DVec3::splat((light.dot(view) + light.z * view.z).abs());
    let material = material(&merl::bytes(model));
    for (index, line) in table::<12>("merl_indices.csv").iter().enumerate() {
        let [light, view] = [[line[0], line[1], line[2]], [line[3], line[4], line[5]]].map(DVec3::from_array);
        let [one, other] = material.nearest_sample(light, view).expect("a file of samples");
        assert!((one.length() - 1.0).abs() < 1e-12 && (other.length() - 1.0).abs() < 1e-12);
        // A cell is at most 1.2 degrees wide, but for those at the end of the square root.
        let near = one.dot(light).min(other.dot(view)).acos().to_degrees();
        assert!(near < 2.5, "line {index}: {near} degrees");
        if one.z > 0.01 && other.z > 0.01 {
            let (found, wanted) = (material.value(one, other).x, model(one, other).x);
            assert!((found - wanted).abs() < 1e-5, "line {index}: {found} {wanted}");
        }
    }
}

#[test]
fn a_page_that_was_saved_as_a_material_is_told_from_one() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format) in [("gold.binary", "MERL"), ("felt.bsdf", "RGL")] {
        let path = folder.path().join(name);
        std::fs::write(&path, "<html><body>404 Not Found</body></html>").unwrap();
        let error = Measurement::read(&path).unwrap_err();
        assert!(error.to_string().contains(&format!("named as a file of the format {format}")), "{error}");
    }
    // A list may have any name that no other format has.
    let path = folder.path().join("list.dat");
    std::fs::write(&path, "0,0,0,0,0.1,0.1,0.1\n").unwrap();
    Measurement::read(&path).unwrap();
}

#[test]
fn lists_of_spreadsheets_are_read() {
    let plain = ReflectanceSamples::of_text("plain", "30,0,45.5,180,0.8,0.6,0.25\n").unwrap();
    let header = "theta_i [°];phi_i [°];theta_o [°];phi_o [°];r;g;b";
    let tabs = "30,0\t0,0\t45,5\t180,0\t0,8\t0,6\t0,25";
    for text in [
        format!("sep=;\n{header}\n30;0;45,5;180;0,8;0,6;0,25\n"),
        format!("{tabs}\n"),
        "\"theta_i\",\"phi_i\",\"theta_o\",\"phi_o\",\"r\",\"g\",\"b\"\n\"30\",\"0\",\"45.5\",\"180\",\"0.8\",\"0.6\",\"0.25\"\n"
            .to_owned(),
        "30,\t0,\t45.5,\t180,\t0.8,\t0.6,\t0.25\n".to_owned(),
    ] {
        assert_eq!(ReflectanceSamples::of_text("list", &text).unwrap(), plain, "{text}");
    }
    // As "Unicode text": UTF-16 with a mark, in both orders of bytes.
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let text = format!("\u{feff}{}\r\n{tabs}\r\n", header.replace(';', "\t"));
        let file: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
        let Measurement::Samples(found) = Measurement::of_bytes("list.txt", &file).unwrap() else { panic!("no list") };
        assert_eq!(found, plain);
        let cut = Measurement::of_bytes("list.txt", &file[..file.len() - 1]).unwrap_err();
        assert!(cut.to_string().contains("UTF-16"), "{cut}");
    }
}

/// The file with other numbers in a field of 32-bit numbers.
fn with_numbers(file: &[u8], name: &str, change: impl Fn(f32) -> f32) -> Vec<u8> {
    // A field is the length of its name, the name, the number of its sizes, its type, its offset, and its sizes.
    let named = [&(name.len() as u16).to_le_bytes()[..], name.as_bytes()].concat();
    let at = file.windows(named.len()).position(|bytes| bytes == named).expect("the field") + named.len();
    let number =
        |at: usize, bytes: usize| file[at..at + bytes].iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte));
    let (sizes, offset) = (number(at, 2), number(at + 3, 8));
    let count: usize = (0..sizes).map(|index| number(at + 11 + 8 * index, 8)).product();
    let mut changed = file.to_vec();
    for bytes in changed[offset..offset + 4 * count].as_chunks_mut::<4>().0 {
        *bytes = change(f32::from_le_bytes(*bytes)).to_le_bytes();
    }
    changed
}

#[test]
fn fields_of_rgl_files_with_numbers_that_mean_nothing_are_errors() {
    let file = std::fs::read(reference("isotropic_rgb.bsdf")).unwrap();
    let same = with_numbers(&file, "theta_i", |angle| angle);
    assert!(same == file && Measurement::of_bytes("x", &same).is_ok());
    for (name, change, expected) in [
        ("theta_i", f32::to_degrees as fn(f32) -> f32, "and at most 1.5708 was expected"),
        ("sigma", |_| 0.0, "the field `sigma` has no number above 0"),
        ("ndf", |_| 0.0, "the field `ndf` has no number above 0"),
    ] {
        let error = Measurement::of_bytes("x", &with_numbers(&file, name, change)).unwrap_err().reason();
        assert!(error.contains(expected), "{error}");
    }
}
