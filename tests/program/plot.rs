//! Charts of formulas: their numbers, their files, and what is said about options.

use crate::{folder, run, told, write};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

/// All views.
const VIEWS: [&str; 8] = ["polar", "cartesian", "lobe", "slice", "albedo", "furnace", "reciprocity", "sphere"];

/// Draws, and expects that nothing is said.
fn drawn(folder: &Path, arguments: &str) {
    assert_eq!(told(folder, &format!("plot {arguments}")), "exit status 0\n", "{arguments}");
}

/// The columns and the rows of a table.
fn table(folder: &Path, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(folder.join(name)).expect("a table");
    let mut lines = text.lines();
    // Every other piece is between quotation marks.
    let pieces = lines.next().expect("names").split('"').enumerate();
    let kept: Vec<String> =
        pieces.map(|(index, piece)| if index % 2 == 0 { piece.to_owned() } else { piece.replace(',', ";") }).collect();
    let columns = kept.concat().split(',').map(str::to_owned).collect();
    // Where a curve has no point, the cell is empty.
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse::<f64>().expect("a number") };
    (columns, lines.map(|line| line.split(',').map(number).collect()).collect())
}

/// The number beside an angle.
fn at(rows: &[Vec<f64>], angle: f64) -> f64 {
    rows.iter().find(|row| (row[0] - angle).abs() < 1e-9).expect("a row for the angle")[1]
}

#[test]
fn tables_have_the_numbers_of_closed_forms() {
    let folder = folder();
    write(&folder, "matte.formula", "formula; = IL*Cd*max(0, N.L);");
    let folder = folder.path();
    drawn(folder, "--formula matte.formula --set Cd=<0.5,0.5,0.5> --view cartesian --theta 40 -o matte.csv");
    let (columns, rows) = table(folder, "matte.csv");
    assert_eq!(columns.len(), 2);
    assert_eq!(columns[..2], ["outgoing angle (°)", "θi = 40°"]);
    assert!(rows.len() > 300);
    assert!(rows.iter().all(|row| (row[1] - 0.5 / PI).abs() < 1e-6));
    // kd = 0.5, ks = 0.2, h = 20, Cd = 0.8: at the mirror direction and 30° away from it.
    drawn(folder, "model.txt --view polar --theta 40 --quantity value -o phong.csv");
    let (_, rows) = table(folder, "phong.csv");
    let matte = 0.5 * 0.8 * 40_f64.to_radians().cos();
    assert!((at(&rows, 40.0) - matte - 0.2).abs() < 1e-5, "{}", at(&rows, 40.0));
    assert!((at(&rows, 70.0) - matte - 0.2 * 30_f64.to_radians().cos().powi(20)).abs() < 1e-5, "{}", at(&rows, 70.0));
    // In a plane at right angles to that of incidence, 40° from the normal: R.V is cos² 40°.
    drawn(folder, "model.txt --view polar --theta 40 --plane 90 --quantity value -o across.csv");
    let (_, rows) = table(folder, "across.csv");
    let across = 40_f64.to_radians().cos().powi(2).powi(20);
    assert!((at(&rows, 40.0) - matte - 0.2 * across).abs() < 1e-5, "{}", at(&rows, 40.0));
    // A beam from the normal: kd Cd + 2 ks/(h + 2), and a furnace: 2 ks/(h + 1).
    drawn(folder, "model.txt --set h=100 --view albedo -o albedo.csv");
    let (columns, rows) = table(folder, "albedo.csv");
    assert_eq!(columns.len(), 3);
    assert!((rows[0][1] - 0.4 - 0.4 / 102.0).abs() < 2e-4 && (rows[0][2] - 0.4 - 0.4 / 101.0).abs() < 2e-4, "{:?}", rows[0]);
}

#[test]
fn values_are_those_of_a_body_of_a_session() {
    let folder = folder();
    let folder = folder.path();
    let red = |arguments: &str| {
        drawn(
            folder,
            &format!("session.toml {arguments} --view cartesian --theta 0 --component each --quantity value -o out.csv"),
        );
        let (columns, rows) = table(folder, "out.csv");
        assert_eq!(columns.len(), 4);
        let row = rows.iter().find(|row| row[0] == 60.0).expect("a row");
        [row[1], row[2]]
    };
    let shine = 0.2 * 0.5_f64.powi(20);
    // The ball is red, and the floor is not.
    assert!(red("").iter().zip([0.5 + shine, shine]).all(|(found, wanted)| (found - wanted).abs() < 1e-6));
    assert!(red("--body floor").iter().all(|found| (found - 0.4 - shine).abs() < 1e-6));
    assert!(red("--body floor --set floor.kd=0.25").iter().all(|found| (found - 0.2 - shine).abs() < 1e-6));
}

#[test]
fn every_view_is_written_in_every_form() {
    let folder = folder();
    let folder = folder.path();
    for view in VIEWS {
        let beside = if view == "albedo" { "--with preset:lambert" } else { "" };
        for name in ["chart.png", "chart.svg", "chart.csv"] {
            drawn(folder, &format!("model.txt {beside} --view {view} --size 240x180 -o {name}"));
        }
        let picture = image::open(folder.join("chart.png")).expect("a picture").to_rgb8();
        assert_eq!(picture.dimensions(), (240, 180));
        let colours: std::collections::BTreeSet<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
        assert!(colours.len() > 16, "{view}: something is drawn");
        let text = fs::read_to_string(folder.join("chart.svg")).expect("a text");
        assert_eq!(well_formed(&text), Ok(()), "{view}");
        assert!(text.contains("width=\"240\""), "{view}");
        // Pictures in it may have any letters.
        let has_odd_numbers = |line: &str| !line.starts_with("<image") && (line.contains("NaN") || line.contains("inf"));
        assert!(!text.lines().any(has_odd_numbers), "{view}");
        let (columns, rows) = table(folder, "chart.csv");
        assert!(rows.len() > 30 && rows.iter().all(|row| row.len() == columns.len()), "{view}");
    }
}

#[test]
fn dark_paper_is_dark() {
    let folder = folder();
    drawn(folder.path(), "model.txt --view cartesian --log --dark -o chart.PNG");
    let picture = image::open(folder.path().join("chart.PNG")).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), (800, 600));
    assert!(picture.get_pixel(2, 2).0.iter().all(|component| *component < 64));
}

#[test]
fn mistakes_are_explained() {
    let files = folder();
    write(&files, "wrong.formula", "formula; = Cb;");
    let folder = files.path();
    let says = |arguments: &str, status: i32, parts: &[&str]| {
        let said = told(folder, &format!("plot {arguments}"));
        assert!(said.ends_with(&format!("exit status {status}\n")), "{arguments}: {said}");
        parts.iter().for_each(|part| assert!(said.contains(part), "{arguments}: {part} is not in {said}"));
    };
    says("model.txt --view pola -o a.png", 2, &["invalid value 'pola'", "polar"]);
    says("model.txt -o a.png", 2, &["--view"]);
    says("model.txt --view polar -o a.gif", 2, &["charts of the kind `.gif` cannot be written", ".png, .svg, .csv"]);
    says("model.txt --view polar -o a", 2, &["does not say by a suffix"]);
    says("model.txt --view polar -o no/a.png", 2, &["the folder `no` does not exist"]);
    says("model.txt --view polar --theta 0,95 -o a.png", 2, &["expected an angle from 0 to 89.99 degrees"]);
    says("model.txt --view polar --size 9x9 -o a.png", 2, &["each side 180 to 8192"]);
    says("session.toml --body bal --view polar -o a.png", 2, &["there is no body `bal`", "did you mean `ball`?"]);
    says("session.toml --light sun --view polar -o a.png", 2, &["there is no light `sun`", "the names are key"]);
    says("model.txt --set kx=1 --view polar -o a.png", 2, &["`kx` is not a parameter of the formula", "are kd, ks, h,"]);
    says("model.txt --set kdd=1 --view polar -o a.png", 2, &["did you mean `kd`?"]);
    says("model.txt --view lobe --size 8192x8192 --memory 300MiB -o a.png", 1, &["of memory, and 300.0 MiB may be used"]);
    says("wrong.formula --view polar -o a.png", 1, &["`Cb` is not known"]);
    says("none.formula --view polar -o a.png", 1, &["there is no such file"]);
    says("sub/place.txt --view polar -o a.png", 1, &["is a scene", "a model is a formula, a session"]);
    says("model.txt --with sub/place.txt --view polar -o a.png", 1, &["is a scene"]);
    says("model.txt --formula preset:phong --view polar -o a.png", 2, &["two models are given"]);
    says("model.txt --view furnace --theta 3 -o a.png", 0, &["Warning: `--theta` changes nothing in the view `furnace`"]);
    says("--formula model.txt --set kd=0 --set ks=0 --view polar -o a.png", 0, &["Warning: the model is 0"]);
    write(&files, "below.formula", "formula; = IL*(-0.5)*max(0, N.L);");
    write(&files, "odd.formula", "formula; = IL*sqrt(0.5 - N.V)*max(0, N.L);");
    says("below.formula --view sphere -o a.png", 0, &["Warning: some values are negative, down to -0.500"]);
    says("below.formula --view polar --log -o a.png", 0, &["Warning: no value is above 0, so a logarithmic scale shows nothing"]);
    says("odd.formula --view slice -o a.png", 0, &["Warning: some values are not numbers; they are magenta in pictures"]);
    let nine = "--theta 0,10,20,30,40,50,60,70,80";
    says(&format!("model.txt --view polar --component each {nine} -o a.png"), 0, &["Warning: there are more curves than looks"]);
    says(&format!("model.txt --with model.txt --view lobe {nine} -o a.png"), 2, &["at most 12 lobes", "make 18"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("model.txt", folder.join("link.svg")).expect("a link");
        says("model.txt --view polar -o link.svg", 2, &["the output would overwrite `model.txt`"]);
    }
}

#[test]
fn a_measured_material_is_drawn_beside_a_formula() {
    let folder = folder();
    write(&folder, "matte.formula", "formula; = IL*Cd*max(0, N.L);");
    let file = illuminator::measured::merl::bytes(|_, _| glam::DVec3::splat(0.8 / PI));
    fs::write(folder.path().join("matte.binary"), file).expect("a file");
    let folder = folder.path();
    drawn(folder, "matte.binary --with matte.formula --view albedo -o both.csv");
    let (columns, rows) = table(folder, "both.csv");
    assert_eq!(columns.len(), 3);
    // A lookup table is 0 at the horizon.
    let near = |row: &&Vec<f64>| (row[1] - 0.8).abs() < 2e-3 && (row[2] - 0.8).abs() < 2e-4;
    assert!(rows.iter().filter(|row| row[0] < 80.0).all(|row| near(&row)), "{rows:?}");
    fs::write(folder.join("short.binary"), [0; 40]).expect("a file");
    let said = told(folder, "plot short.binary --view polar -o a.png");
    assert!(said.contains("short.binary") && said.ends_with("exit status 1\n"), "{said}");
    let said = told(folder, "plot matte.binary --set kd=1 --view polar -o a.png");
    assert!(said.contains("`--set` changes nothing in a measured material"), "{said}");
}

#[test]
fn a_chart_goes_to_a_pipe() {
    let folder = folder();
    let output = run(folder.path(), "plot model.txt --view cartesian --size 200x180 -o -");
    let picture = image::load_from_memory(&output.stdout).expect("a picture");
    assert_eq!((picture.width(), picture.height(), output.status.code()), (200, 180, Some(0)));
}

/// Whether a text is well-formed XML, as far as elements, attributes and references go.
fn well_formed(text: &str) -> Result<(), String> {
    let mut open = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let (before, tag) = rest.split_at(start);
        for reference in before.split('&').skip(1) {
            let name = reference.split_once(';').map(|(name, _)| name);
            if !matches!(name, Some("lt" | "gt" | "amp" | "quot")) {
                return Err(format!("a stray & in {before}"));
            }
        }
        let end = tag.find('>').ok_or("an open tag")?;
        let inside = &tag[1..end];
        rest = &tag[end + 1..];
        let name = inside.trim_matches('/').split_whitespace().next().unwrap_or_default();
        let quotes = inside.matches('"').count();
        if quotes % 2 != 0 || inside.contains('<') {
            return Err(format!("a wrong attribute in {inside}"));
        }
        if inside.starts_with('/') {
            if open.pop() != Some(name) {
                return Err(format!("{name} is closed and not open"));
            }
        } else if !inside.ends_with('/') {
            open.push(name);
        }
    }
    if open.is_empty() { Ok(()) } else { Err(format!("{open:?} stay open")) }
}

#[test]
fn a_pattern_has_the_numbers_of_the_place_that_is_given() {
    let folder = folder();
    // Fields of 0.2 and 0.8, each a half of the surface long.
    let checker = "formula; FIELD = floor(2*u) + floor(2*v); ODD = FIELD - 2*floor(FIELD/2);
        = IL*(0.2 + 0.6*ODD)*max(0, N.L);";
    write(&folder, "checker.formula", checker);
    write(&folder, "matte.formula", "formula; = IL*0.5*max(0, N.L);");
    let folder = folder.path();
    for (at, albedo) in [("", 0.2), ("--at 0.75,0.25", 0.8), ("--at 0.75,0.75", 0.2), ("--at -0.25,0.1", 0.8)] {
        drawn(folder, &format!("checker.formula {at} --view cartesian --theta 30 -o place.csv"));
        let (_, rows) = table(folder, "place.csv");
        assert!(rows.iter().all(|row| (row[1] - albedo / PI).abs() < 1e-6), "{at}: {:?}", rows[0]);
        let output = run(folder, &format!("measure --json checker.formula {at}"));
        let measured: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let share = measured["greatest_albedo"]["share"].as_f64().expect("a share");
        assert!((share - albedo).abs() < 2e-4, "{at}: {share}");
        // The ranges of expressions are those of the same place: of the result, from 0 to the albedo.
        let expressions = measured["expressions"].as_array().expect("expressions");
        let odd = expressions.iter().find(|range| range["name"] == "ODD").expect("a macro");
        assert_eq!(odd["greatest"].as_f64(), Some(f64::from(u8::from(albedo > 0.5))), "{at}");
    }
    // A model beside it is looked at at the same place.
    drawn(folder, "checker.formula --at 0.75,0.25 --with checker.formula --view cartesian --theta 30 -o both.csv");
    let (_, rows) = table(folder, "both.csv");
    assert!(rows.iter().all(|row| (row[1] - row[2]).abs() < 1e-9 && row[1] > 0.2), "{:?}", rows[0]);
    let said = told(folder, "plot matte.formula --at 0.5,0.5 --view polar -o matte.csv");
    assert!(said.contains("`--at` changes nothing in a formula that reads neither `u` nor `v`"), "{said}");
    for wrong in ["0.5", "0.5,", "a,b", "nan,0"] {
        let said = told(folder, &format!("plot checker.formula --at {wrong} --view polar -o wrong.csv"));
        assert!(said.contains("expected two numbers such as 0.25,0.5") && said.contains("exit status 2"), "{said}");
    }
}
