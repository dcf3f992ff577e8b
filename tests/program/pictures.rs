//! What is said about pictures that show nothing, and about values that another formula or scene takes over.

use crate::messages::check;
use crate::{folder, told, write};

#[test]
fn pictures_that_show_nothing() {
    let folder = folder();
    write(&folder, "root.txt", "formula;\nCOSINE = N.L;\nROOT = sqrt(-max(0.5, COSINE));\n= IL*Cd*ROOT;\n");
    write(&folder, "all.txt", "formula;\n= <1, 1, 1>*(0/(N.N - N.N));\n");
    let away = crate::SCENE.replace("gaze <0,-0.15,-1>", "gaze <0,0.5,1>");
    write(&folder, "away.txt", &away);
    check(
        "pictures",
        &folder,
        &[
            "render session.toml -o out.png --set key.ki=0 --set ka=0",
            "render session.toml -o out.png --set *.kd=0 --set *.ks=0 --set ka=0 --samples 2",
            "render session.toml -o out.png --scene away.txt",
            "render session.toml -o out.png --scene away.txt --background #ff8000",
            "render session.toml -o out.png --exposure -16",
            "render session.toml -o out.exr --formula root.txt --size 8x6",
            "verify session.toml --formula all.txt --size 8x6 --depth 1 --set floor.Cd=<1,1,1>",
        ],
    );
    // The pixel that is named has the number that is named.
    let rays = told(folder.path(), "dump session.toml --formula root.txt --size 8x6 --stage rays --pixel 3,2");
    assert!(rays.contains("NaN"), "{rays}");
}

#[test]
fn values_of_another_formula() {
    let folder = folder();
    let session = std::fs::read_to_string(folder.path().join("session.toml")).expect("the session");
    // Values that the other formula has with another range, or does not have.
    write(&folder, "rich.toml", &format!("{session}kd = 0.9\nks = 0.1\nh = 30\n[bodies.cone]\nkd = 1\n"));
    write(
        &folder,
        "narrow.txt",
        "body_specific;\nkd: scalar, constraint 0..0.5, default 0.25;\nformula;\n= kd*IL*Cd*max(0, N.L);\n",
    );
    write(&folder, "typed.toml", &format!("{session}[lights.key]\nki = [1, 1, 1]\n"));
    check(
        "carried",
        &folder,
        &[
            "render rich.toml -o out.png --formula narrow.txt",
            "render rich.toml -o out.png --formula narrow.txt --set ball.kd=0.3",
            "render rich.toml -o out.png --formula narrow.txt --set ball.kd=0.7",
            "render session.toml -o out.png --scene preset:studio --size 8x6",
            "render typed.toml -o out.png",
            "render typed.toml -o out.png --set key.ki=0.5",
        ],
    );
}

#[test]
fn invariants_hold_for_the_values_that_are_used() {
    let folder = folder();
    let session = std::fs::read_to_string(folder.path().join("session.toml")).expect("the session");
    write(&folder, "bright.toml", &format!("{session}kd = 0.1\nks = 0.9\n"));
    std::fs::copy(folder.path().join("model.txt"), folder.path().join("other.txt")).expect("a copy");
    // The default of kd, 0.5, would not leave 0.9 for ks.
    let said = told(folder.path(), "render bright.toml -o out.png --formula other.txt --set ball.kd=0.05");
    assert_eq!(said, "Note: values kept by name: Cd, ks\nexit status 0\n");
}

#[test]
fn a_session_with_mistakes_is_refused_where_its_picture_is_needed_and_opened_in_the_window() {
    let folder = folder();
    let session = std::fs::read_to_string(folder.path().join("session.toml")).expect("the session");
    write(&folder, "wrong.txt", &crate::FORMULA.replace("N.L", "N.Lx"));
    write(&folder, "wrong.toml", &session.replace("model.txt", "wrong.txt"));
    write(&folder, "gone.toml", &session.replace("model.txt", "gone.txt").replace("sub/place.txt", "gone.scene"));
    write(&folder, "torn.toml", "version = 1\nformula = \"model.txt\nscene = 3 4\n");
    check(
        "sessions_with_mistakes",
        &folder,
        &[
            "render wrong.toml -o out.png",
            "render gone.toml -o out.png",
            "preview wrong.toml",
            "preview gone.toml",
            "preview torn.toml",
            "preview none.toml",
        ],
    );
}
