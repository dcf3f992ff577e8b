//! Texts with unusual characters and line ends. Every error is drawn, at the line and column that an editor shows.

use crate::{FORMULA, SCENE, folder, told, write};

/// Texts that consist of white space and invisible characters.
const BLANKS: [&str; 9] =
    ["\u{a0}", "\u{85}", "\u{2003}", "\u{2028}", "\u{2029}", "\u{feff}", "\u{feff}\u{a0}\r\n", "\r", "\u{3000}\n\n"];

#[test]
fn texts_of_white_space_are_errors_in_every_command() {
    let folder = folder();
    for blank in BLANKS {
        for (name, text) in [("formula", FORMULA), ("scene", SCENE)] {
            write(&folder, "blank", blank);
            write(&folder, "tail", &format!("{text}{blank}"));
            let [option, other] = match name {
                "formula" => ["-f", "-s sub/place.txt"],
                _ => ["-s", "-f model.txt"],
            };
            for command in ["render -o out.png --size 8x6", "verify --size 8x6", "dump --stage ast"] {
                let refused = told(folder.path(), &format!("{command} {option} blank {other}"));
                assert!(refused.contains("Error: ") && refused.contains("blank:"), "{command} {name} {blank:?}: {refused}");
                assert!(refused.ends_with("exit status 1\n"), "{command} {name} {blank:?}: {refused}");
            }
            let refused = told(folder.path(), &format!("check --kind {name} blank"));
            assert!(refused.ends_with("exit status 1\n"), "{name} {blank:?}: {refused}");
            let tail = told(folder.path(), &format!("check --kind {name} tail"));
            assert!(!tail.contains("panicked"), "{name} {blank:?}: {tail}");
        }
        for kind in ["session", "material"] {
            let refused = told(folder.path(), &format!("check --kind {kind} blank"));
            assert!(
                ["exit status 0\n", "exit status 1\n"].iter().any(|status| refused.ends_with(status)),
                "{kind} {blank:?}: {refused}"
            );
        }
        write(&folder, "uses.txt", &format!("#uses blank;\n{FORMULA}"));
        let refused = told(folder.path(), "render -f uses.txt -s sub/place.txt -o out.png --size 8x6 --material ball=gold");
        assert!(refused.contains("Error: ") && !refused.contains("panicked"), "{blank:?}: {refused}");
    }
}

#[test]
fn lines_and_columns_are_those_of_an_editor() {
    let folder = folder();
    for (name, end) in [("lf", "\n"), ("crlf", "\r\n"), ("cr", "\r")] {
        let lines = [
            "\u{feff}// one \u{85} \u{2028} \u{2029} still one",
            "formula;",
            "\ta = 1; /* 光 \u{1f600} */ b = Q;",
            "= a*Cd;",
            "",
        ];
        write(&folder, name, &lines.join(end));
        let said = told(folder.path(), &format!("check {name}"));
        assert!(said.contains(&format!("[ {name}:3:23 ]")), "{said}");
    }
    write(&folder, "uses.txt", "#uses a.toml\r; formula;\r= Cd;");
    let said = told(folder.path(), "check uses.txt");
    assert!(said.contains("no `;` at the end of its line"), "{said}");
}

#[test]
fn unusual_characters_are_drawn() {
    let folder = folder();
    let lines = |text: &str| format!("formula;\n{text}\n");
    write(&folder, "wide.txt", &lines("= /* 測量·光 \u{1f600}é */ IL*Cd*max(0, N.Q);"));
    write(&folder, "combining.txt", &lines("= /* e\u{301}\u{301} \u{200b} */ IL*Cd*max(0, N.Q);"));
    write(&folder, "tabs.txt", &lines("\t\ta = 1;\n\t\t= IL*Cd*max(0, N.Q);"));
    write(&folder, "escape.txt", &lines("= /* \u{1b}[31m \u{9b}1m \u{202e} */ IL*Cd*max(0, N.Q);"));
    write(&folder, "fullwidth.txt", &lines("= IL*Cd*max（0, N.L）;"));
    write(&folder, "separators.txt", &lines("= IL*Cd /* \u{85}\u{2028}\u{2029}\u{b}\u{c} */ * Q;"));
    write(&folder, "multi.txt", &lines("= N\n  .\n  L;"));
    crate::messages::check(
        "unusual_characters",
        &folder,
        &["check wide.txt combining.txt tabs.txt escape.txt fullwidth.txt separators.txt multi.txt"],
    );
}
