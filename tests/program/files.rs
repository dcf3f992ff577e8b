//! The files that the program writes.

use crate::{folder, run, told, write};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

pub(crate) fn render(folder: &Path, arguments: &str, output: &str) -> image::DynamicImage {
    let done = run(folder, &format!("render {arguments} -o {output}"));
    assert!(done.status.success(), "{arguments}: {}", String::from_utf8_lossy(&done.stderr));
    image::open(folder.join(output)).expect("a picture")
}

#[test]
fn formats_agree() {
    let folder = folder();
    let png = render(folder.path(), "session.toml", "out.png");
    assert_eq!((png.width(), png.height(), png.color()), (32, 24, image::ColorType::Rgb8));
    assert_eq!(png, render(folder.path(), "session.toml", "out.BMP"));
    let floats = render(folder.path(), "session.toml", "out.exr").into_rgb32f();
    for (byte, float) in png.into_rgb8().iter().zip(floats.iter()) {
        assert_eq!(*byte, (255.0 * float.clamp(0.0, 1.0)).round() as u8);
    }
}

#[test]
fn options_override_sessions() {
    let folder = folder();
    let red = render(folder.path(), "session.toml", "red.png").into_rgb8();
    let centre = *red.get_pixel(16, 12);
    assert!(centre[0] > 2 * centre[1], "{centre:?}");
    let green = render(folder.path(), "session.toml --set ball.Cd=#00ff00 --size 64x48", "green.png").into_rgb8();
    let centre = *green.get_pixel(32, 24);
    assert!(centre[1] > 2 * centre[0], "{centre:?}");
    // With both files given and no session, colours are defaults.
    let grey = render(folder.path(), "-f model.txt -s sub/place.txt --size 32x24 --background <0,0,1>", "grey.png").into_rgb8();
    let centre = *grey.get_pixel(16, 12);
    assert_eq!(centre[0], centre[1]);
    assert_eq!(grey.get_pixel(0, 0).0, [0, 0, 255]);
    // With another formula, values stay if it has the same parameter.
    let kept = render(folder.path(), "session.toml -f preset:lambert", "kept.png").into_rgb8();
    let centre = *kept.get_pixel(16, 12);
    assert!(centre[0] > 2 * centre[1], "{centre:?}");
}

#[test]
fn meshes_are_read_beside_their_scene_and_look_like_what_they_stand_for() {
    let folder = folder();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";
    fs::create_dir_all(folder.path().join("sub/models")).expect("a folder");
    write(&folder, "sub/models/cube.obj", cube);
    let scene = |body: &str| {
        format!(
            "bodies; c: {body}, rotate <0,1,0> 30, refractive_index 1.4; f: rectangle, <-3,-0.1,-3>, <3,-0.1,-3>, <3,-0.1,3>;
             lights; key: point, <3,4,5>; camera; position <0.3,2,5>; gaze <0,-0.3,-1>; up <0,1,0>; fov 30;"
        )
    };
    write(&folder, "sub/mesh.scene", &scene("mesh, \"models/cube.obj\", fit <0,0.5,0> 1"));
    write(&folder, "box.scene", &scene("box, <-0.5,0,-0.5>, <0.5,1,0.5>"));
    let set = "--set c.kt=0.6 --set c.kr=0.2 --set f.Cd=<0.2,0.6,0.9> --size 96x72 -f preset:lambert";
    let mesh = render(folder.path(), &format!("-s sub/mesh.scene {set}"), "mesh.exr").into_rgb32f();
    let cube = render(folder.path(), &format!("-s box.scene {set}"), "box.exr").into_rgb32f();
    let off = mesh.iter().zip(cube.iter()).filter(|(one, other)| (*one - *other).abs() > 1e-3).count();
    assert!(off <= 6, "{off} components of 20736 differ");
    // The same by the interpreter.
    assert!(run(folder.path(), &format!("verify -s sub/mesh.scene {set}")).status.success());
    let checked = run(folder.path(), "check sub/mesh.scene");
    assert!(checked.status.success() && checked.stderr.is_empty());
    fs::remove_file(folder.path().join("sub/models/cube.obj")).expect("a file");
    let missing = run(folder.path(), &format!("render -s sub/mesh.scene {set} -o none.png"));
    assert!(
        missing.status.code() == Some(1)
            && String::from_utf8_lossy(&missing.stderr).contains("cannot read the mesh `sub/models/cube.obj`")
    );
    let small = run(folder.path(), &format!("render -s box.scene {set} --memory 1K -o none.png"));
    assert_eq!(small.status.code(), Some(1));
}

#[test]
fn threads_and_runs_give_the_same_bytes() {
    let folder = folder();
    let bytes = |threads: u32| {
        render(folder.path(), &format!("session.toml --size 300x200 --samples 2 --threads {threads}"), "out.exr");
        fs::read(folder.path().join("out.exr")).expect("the picture")
    };
    let one = bytes(1);
    assert!(one == bytes(1) && one == bytes(3) && one == bytes(64));
}

#[test]
fn backends_agree_and_say_so() {
    let folder = folder();
    assert!(
        told(folder.path(), "verify session.toml --set *.kr=0.4 --set ball.kt=0.5 --depth 4").ends_with("pass\nexit status 0\n")
    );
    let jit = render(folder.path(), "session.toml --samples 4", "jit.png").into_rgb8();
    let other = render(folder.path(), "session.toml --samples 4 --backend interpreter", "other.png").into_rgb8();
    assert!(jit.iter().zip(other.iter()).all(|(one, other)| one.abs_diff(*other) <= 1));
    let said = told(folder.path(), "verify session.toml --samples 4");
    assert!(
        said.contains("\neach the mean of passes                    4\n") && said.ends_with("pass\nexit status 0\n"),
        "{said}"
    );
}

#[test]
fn sessions_say_how_many_passes_and_the_command_line_overrides_them() {
    let folder = folder();
    let session = fs::read_to_string(folder.path().join("session.toml")).expect("a session");
    write(&folder, "four.toml", &session.replace("depth = 2", "depth = 2\nsamples = 4"));
    let picture = |arguments: &str| render(folder.path(), arguments, "out.exr").into_rgb32f();
    let (one, four) = (picture("session.toml"), picture("session.toml --samples 4"));
    assert!(one != four);
    assert!(picture("four.toml") == four);
    assert!(picture("four.toml --samples 1") == one);
    // Edges are smooth: more pixels than before are between the colours of their neighbours.
    let between = |picture: &image::Rgb32FImage| {
        let is_between = |pixel: usize| {
            let [left, own, right] = [pixel - 1, pixel, pixel + 1].map(|at| picture.as_raw()[3 * at]);
            (own - left).abs() > 0.02 && (own - right).abs() > 0.02 && (left - right).abs() > (own - left).abs()
        };
        (1..32 * 24 - 1).filter(|pixel| is_between(*pixel)).count()
    };
    assert!(between(&four) > between(&one), "{} {}", between(&four), between(&one));
}

#[test]
fn a_failure_leaves_the_old_picture() {
    let folder = folder();
    write(&folder, "out.png", "precious");
    assert_eq!(run(folder.path(), "render session.toml --formula none.txt -o out.png").status.code(), Some(1));
    assert_eq!(fs::read_to_string(folder.path().join("out.png")).expect("the file"), "precious");
    let names = fs::read_dir(folder.path()).expect("the folder").count();
    assert_eq!(names, 4, "nothing is left behind");
}

/// A limit for the size of files stands for a full disk: writing beyond it fails.
#[cfg(unix)]
#[test]
fn a_picture_that_does_not_fit_on_the_disk_is_reported() {
    let folder = folder();
    for name in ["out.png", "out.bmp", "out.exr"] {
        write(&folder, name, "precious");
        let program = env!("CARGO_BIN_EXE_illuminator");
        let output = Command::new("sh")
            .current_dir(folder.path())
            .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"", program, "render", "session.toml", "-o", name])
            .args(["--size", "200x100", "--background", "#123456"])
            .output()
            .expect("a shell");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.ends_with(&format!("Error: cannot write the picture `{name}`: file too large\n")), "{told}");
        assert_eq!(fs::read_to_string(folder.path().join(name)).expect("the file"), "precious");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 6, "nothing is left behind");
}

#[test]
fn hits_are_written_as_the_index_describes() {
    let folder = folder();
    assert_eq!(told(folder.path(), "dump session.toml --stage hits -o hits"), "exit status 0\n");
    let hits = folder.path().join("hits");
    let index: serde_json::Value = serde_json::from_slice(&fs::read(hits.join("index.json")).expect("an index")).expect("JSON");
    assert_eq!((index["width"].as_u64(), index["height"].as_u64()), (Some(32), Some(24)));
    let mut count = 0;
    for table in ["hits", "records", "misses", "paths"] {
        let rows = index["tables"][table]["count"].as_u64().expect("a count");
        for column in index["tables"][table]["columns"].as_array().expect("columns") {
            let length = fs::metadata(hits.join(column["file"].as_str().expect("a name"))).expect("a column").len();
            assert_eq!(length, 4 * rows * column["components"].as_u64().expect("a number"), "{column}");
            count += 1;
        }
    }
    assert_eq!(fs::read_dir(&hits).expect("the folder").count(), count + 1);
    let column = |file: &str| -> Vec<u32> {
        let bytes = fs::read(hits.join(file)).expect("a column");
        bytes.chunks_exact(4).map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect()
    };
    // Every pixel has hits or a miss, and every record a hit.
    let mut pixels = [column("hits.pixel.u32"), column("misses.pixel.u32")].concat();
    pixels.sort_unstable();
    pixels.dedup();
    assert_eq!(pixels, (0..32 * 24).collect::<Vec<u32>>());
    let last = column("hits.pixel.u32").len() as u32;
    assert!(column("records.hit.u32").iter().all(|hit| *hit < last));
    // Bodies are spheres and rectangles: one part each, coordinates from 0 to 1, and a geometric normal that is N.
    assert!(column("hits.primitive.u32").iter().all(|primitive| *primitive == 0));
    let real = |file: &str| column(file).into_iter().map(f32::from_bits).collect::<Vec<f32>>();
    for file in ["hits.u.f32", "hits.v.f32"] {
        let coordinates = real(file);
        assert!(coordinates.iter().all(|share| (0.0..=1.0).contains(share)), "{file}");
        assert!(coordinates.iter().any(|share| (0.3..0.7).contains(share)), "{file}");
    }
    assert_eq!(real("hits.Ng.f32"), real("hits.N.f32"));
    assert!(column("records.visible.f32").iter().all(|visible| f32::from_bits(*visible) == 1.0));
}

/// Rays are tested by vectors of several widths, and hit the same.
#[test]
fn hits_on_meshes_do_not_depend_on_the_width_of_vectors() {
    let folder = folder();
    let written = |lanes: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_illuminator"));
        program.env("ILLUMINATOR_LANES", lanes).current_dir(folder.path());
        let arguments = ["dump", "preset:shaderball-glass", "--size", "64x36", "--stage", "hits", "-o", lanes];
        assert!(program.args(arguments).status().expect("the program").success());
        let columns = fs::read_dir(folder.path().join(lanes)).expect("a folder").map(|file| file.expect("a file").path());
        let mut columns: Vec<_> =
            columns.map(|path| (path.file_name().map(ToOwned::to_owned), fs::read(&path).expect("a column"))).collect();
        columns.sort();
        columns
    };
    let wide = written("16");
    assert!(wide.len() > 5);
    assert!(wide == written("8"));
    assert!(wide == written("4"));
}

#[test]
fn hits_have_a_record_for_each_light_if_the_formula_reads_visible() {
    let folder = folder();
    fs::write(folder.path().join("shade.formula"), "formula; = IL*Cd*(0.1 + visible);").expect("a file");
    let count = |arguments: &str| {
        let said = told(folder.path(), &format!("dump session.toml {arguments} --stage hits -o hits"));
        // A note says which values of the session the other formula keeps.
        assert!(said.ends_with("exit status 0\n") && !said.contains("rror"), "{said}");
        let hits = folder.path().join("hits");
        let index: serde_json::Value =
            serde_json::from_slice(&fs::read(hits.join("index.json")).expect("an index")).expect("JSON");
        let [hits_count, records] = ["hits", "records"].map(|table| index["tables"][table]["count"].as_u64().expect("a count"));
        let bytes = fs::read(hits.join("records.visible.f32")).expect("a column");
        let visible = bytes.chunks_exact(4).filter(|four| *four == 1.0_f32.to_le_bytes()).count() as u64;
        (hits_count, records, visible, index["lights"].as_array().expect("lights").len() as u64)
    };
    let (hits, reaching, visible, _) = count("");
    assert_eq!(visible, reaching);
    let (all_hits, records, visible, lights) = count("--formula shade.formula");
    assert_eq!((all_hits, records), (hits, hits * lights));
    assert!(reaching <= visible && visible < records, "{reaching} {visible} {records}");
}

#[test]
fn measurements_are_reported_as_table_and_json() {
    let folder = folder();
    let table = told(folder.path(), "bench session.toml --runs 1 --slider ball.kd");
    let words = ["32x24", "interpreter", "full evaluation", "ball.kd", "images", "fps"];
    assert!(words.iter().all(|word| table.contains(word)), "{table}");
    let output = run(folder.path(), "bench session.toml --runs 2 --threads 1 --json");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((&json["size"], &json["depth"], &json["threads"]), (&serde_json::json!([32, 24]), &2.into(), &1.into()), "{json}");
    let figures = [
        "/trace_ms",
        "/compile_ms",
        "/full_ms/jit",
        "/full_ms/interpreter",
        "/bytes_per_pixel/jit",
        "/bytes_per_pixel/interpreter",
    ];
    for pointer in figures.into_iter().chain(["/hits", "/records", "/paths", "/groups"]) {
        assert!(json.pointer(pointer).and_then(serde_json::Value::as_f64) > Some(0.0), "{pointer}: {json}");
    }
    // Every slider that can be moved, with the components of colours.
    let drags = json["drag"].as_array().expect("drags");
    let method = |name: &str| drags.iter().find(|drag| drag["parameter"] == name).map(|drag| drag["method"].clone());
    assert_eq!(method("ball.kd"), Some("images".into()), "{json}");
    assert_eq!(method("ball.h"), Some("specialised".into()), "{json}");
    assert_eq!(method("background.g"), Some("images".into()), "{json}");
    assert!(drags.iter().all(|drag| drag["frame_ms"].as_f64() > Some(0.0) && drag["prepare_ms"].as_f64() > Some(0.0)), "{json}");
}

/// Ten macros, each of which uses the one before it three times: written out at every use, 29,524 powers.
fn chain() -> String {
    let links: String = (1..10).map(|n| format!("M{n} = (M{0} + M{0}*M{0})/(1 + {n}*alpha)^2;\n", n - 1)).collect();
    format!("body_specific;\nkd: scalar;\nformula;\nM0 = kd*max(0, N.L)^1.5;\n{links}= IL*Cd*M9;\n")
}

#[test]
fn pictures_of_several_passes_are_measured_beside_those_of_one() {
    let folder = folder();
    let table = told(folder.path(), "bench session.toml --runs 1 --samples 3 --slider ball.kd");
    assert!(table.contains("3 passes") && table.matches(" x ").count() == 2, "{table}");
    // Each thread that has work has memory of its own, so the memory of several threads may differ.
    let output =
        run(folder.path(), "bench session.toml --runs 2 --samples 3 --slider ball.kd --slider ball.h --json --threads 1");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let number = |pointer: &str| json.pointer(pointer).and_then(serde_json::Value::as_f64).unwrap_or_default();
    for name in ["passes", "trace_ms", "prepare_ms", "full_ms", "one_pass_ms", "bytes_per_pixel"] {
        assert!(number(&format!("/passes/{name}")) > 0.0, "{name}: {json}");
    }
    for drag in [0, 1] {
        assert!(number(&format!("/passes/drag/{drag}/frame_ms")) > 0.0, "{json}");
        assert!(number(&format!("/passes/drag/{drag}/one_pass_ms")) > 0.0, "{json}");
    }
    let refused = told(folder.path(), "bench session.toml --runs 1 --samples 4000 --memory 1 --slider ball.kd --size 64x48");
    assert!(refused.contains("passes take about") && refused.contains("`--memory SIZE` allows more"), "{refused}");
    assert!(number("/passes/bytes_per_pixel") > number("/bytes_per_pixel/jit"), "all passes are kept: {json}");
}

#[test]
fn chains_of_macros_are_computed_once_by_every_backend() {
    let folder = folder();
    fs::write(folder.path().join("chain.formula"), chain()).expect("write");
    let text = told(folder.path(), "dump session.toml --formula chain.formula --stage bytecode");
    let count = |word: &str| text.matches(word).count();
    assert_eq!((count("PowerSS"), count("STORE_S"), count("LOAD_S")), (10, 9, 18), "{text}");
    assert!(text.starts_with("type I: the formula, ") && text.contains(" bytes; slots: 1\n"), "{text}");
    for command in ["verify", "render --backend interpreter -o interpreted.png", "render -o compiled.png"] {
        let said = told(folder.path(), &format!("{command} session.toml --formula chain.formula --depth 3"));
        assert!(said.ends_with("exit status 0\n"), "{said}");
    }
}

#[test]
fn every_stage_is_shown() {
    let folder = folder();
    for (stage, word) in [("ast", "max()"), ("bytecode", "PARAM_B_S"), ("clif", "function"), ("asm", "ret")] {
        let text = told(folder.path(), &format!("dump session.toml --stage {stage}"));
        assert!(text.contains(word) && text.ends_with("exit status 0\n"), "{stage}: {text}");
    }
    let text = told(folder.path(), "dump session.toml --stage bytecode --pixel 16,12");
    assert!(text.contains("type II: pixel (16, 12)"), "{text}");
}

#[test]
fn a_closed_pipe_is_not_a_failure() {
    let mut program = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .arg("help-language")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    drop(program.stdout.take());
    let output = program.wait_with_output().expect("it ends");
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}
