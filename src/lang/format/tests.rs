use super::*;
use crate::lang::parser::parse;
use proptest::prelude::*;

fn of(text: &str) -> String {
    formatted(&Source::new("t", text)).unwrap()
}

/// The words of a text, and its comments without blanks at their ends.
fn content(text: &str) -> (Vec<TokenKind>, Vec<String>) {
    let TokenizedText { tokens, comments, .. } = tokenize(&Source::new("t", text));
    let kinds = tokens.into_iter().map(|mut token| {
        // The place of the path moves.
        if let TokenKind::Uses(_, place) = &mut token.kind {
            *place = SourceSpan::default();
        }
        token.kind
    });
    (kinds.collect(), comments.iter().map(|comment| with_line_feeds(text[comment.range()].trim_end())).collect())
}

/// Whether formatting keeps the content, and is done after once.
fn is_regular(text: &str) {
    let once = of(text);
    assert_eq!(content(&once), content(text), "{text:?}\nbecomes\n{once}");
    let twice = of(&once);
    assert_eq!(twice, once, "{text:?}\nis not stable");
}

#[test]
fn statements_get_lines_and_words_get_spaces() {
    let text = "#uses  m.toml ;\nglobal ; a :scalar,constraint -1 .. 1 ,default  -0.5,slider; b: vector,default <1,0,-1>;\n\n\n\
                invariants;\na+kr<=1;\nformula;\nM(x,y)=mix ( x,y , - a )*x . y^ -2;\n  = <1,M (1,2), -a>*( 1-a)/(2*a) ;\n\n";
    let expected = "#uses m.toml;\nglobal;\na: scalar, constraint -1..1, default -0.5, slider;\nb: vector, default <1, 0, -1>;\n\n\
                    invariants;\na + kr <= 1;\nformula;\nM(x, y) = mix(x, y, -a)*x.y^-2;\n= <1, M(1, 2), -a>*(1 - a)/(2*a);\n";
    assert_eq!(of(text), expected);
    is_regular(text);
}

#[test]
fn operators_keep_the_sense_of_the_author() {
    let of = |expression: &str| {
        let text = of(&format!("formula;\n= {expression};"));
        text.strip_prefix("formula;\n= ").and_then(|rest| rest.strip_suffix(";\n")).map(str::to_owned).unwrap()
    };
    assert_eq!(of("(a-b) / (c-d)"), "(a - b) / (c - d)");
    assert_eq!(of("(a-b)/(c-d)"), "(a - b)/(c - d)");
    assert_eq!(of("a * (b+c) * d"), "a*(b + c)*d");
    assert_eq!(of("if(a>b&&!c,-1,<0>)"), "if(a > b && !c, -1, <0>)");
    assert_eq!(of("<a, (b>c), if(a<b, 1, 2)>-<1>"), "<a, (b > c), if(a < b, 1, 2)> - <1>");
    assert_eq!(of("a- -b"), "a - -b");
    assert_eq!(of("2 . N"), "2 .N", "`2.` would be a number");
    assert_eq!(of("N . .5"), "N. .5");
    assert_eq!(of("a / /* why */ b"), "a/ /* why */ b");
    assert_eq!(of("( /* x */ a /* y */ )"), "(/* x */ a /* y */)");
}

#[test]
fn comments_stay_where_they_are() {
    let text = "// of the file\n\nglobal;// of the scene\n/* above */ a: scalar;   /* behind\n  it */ // too\n// above b\n\
                b: scalar, // in b\n   default 1; // behind b\n             // and on\nc: scalar; // c\nformula;\n= a; // end";
    let expected = "// of the file\n\nglobal; // of the scene\n/* above */ a: scalar;   /* behind\n  it */ // too\n// above b\n\
                    b: scalar, // in b\n   default 1; // behind b\n              // and on\nc: scalar; // c\nformula;\n= a; // end\n";
    assert_eq!(of(&text.replace("             // and on", "              // and on")), expected);
    is_regular(text);
    assert_eq!(of("formula;\na = 1; b = 2; // of b\n= a;"), "formula;\na = 1;\nb = 2; // of b\n= a;\n");
    assert_eq!(of("formula;\n= a // why\n;"), "formula;\n= a // why\n    ;\n");
}

#[test]
fn columns_stay_columns() {
    let text = "formula;\nF  =1;\nGA =  2;   // of GA\n\nH(x)=x+  1; // of H\nab= 3;\n= F;";
    assert_eq!(of(text), "formula;\nF  = 1;\nGA = 2;   // of GA\n\nH(x) = x + 1; // of H\nab = 3;\n= F;\n");
    let text = "formula;\nc2      = 1;\nplanck(t)=t;\n\n// more\nCOLOUR  =glow;\nx  = 2;\ny =3;\n= c2;";
    let expected = "formula;\nc2      = 1;\nplanck(t) = t;\n\n// more\nCOLOUR  = glow;\nx = 2;\ny = 3;\n= c2;\n";
    assert_eq!(of(text), expected, "longer lines do not interrupt a column, and one line alone is none");
    is_regular(text);
    assert_eq!(of("formula;\na = 1;\nkg=2;\n= a;"), "formula;\na = 1;\nkg = 2;\n= a;\n", "by chance in one column");
    let text = "global;\nd:     scalar,slider;// one\nlonger:scalar;       // two\nx: scalar;\n";
    assert_eq!(of(text), "global;\nd:      scalar, slider; // one\nlonger: scalar;         // two\nx: scalar;\n");
    let text = "bodies;\n  b: sphere,center <0,0,0>,  // here\n       radius 1;             // small\nlights;\n\
                key:point,<1,2,3>;\ncamera;\nfov 30;";
    let expected = "bodies;\n  b: sphere, center <0, 0, 0>,  // here\n       radius 1;                // small\nlights;\n  \
                    key: point, <1, 2, 3>;\ncamera;\n  fov 30;\n";
    assert_eq!(of(text), expected);
    is_regular(text);
}

#[test]
fn the_ends_of_lines_and_a_byte_order_mark_stay() {
    assert_eq!(of("\u{feff}formula;\r\n\r\n\r\n= Cd"), "\u{feff}formula;\r\n\r\n= Cd\r\n");
    assert_eq!(of(""), "");
    assert_eq!(of("\n\n// a  \n\n"), "// a\n");
}

#[test]
fn a_text_with_unknown_characters_is_refused() {
    for text in ["formula; = a ? b;", "# note\nformula;", "/* open"] {
        assert!(formatted(&Source::new("t", text)).unwrap_err().has_errors(), "{text}");
    }
}

/// Words and comments of every kind, with blanks between them.
fn texts() -> impl Strategy<Value = String> {
    let words = prop::sample::select(vec![
        "a",
        "bc",
        "formula",
        "global",
        "bodies",
        "if",
        "1",
        "2.5",
        ".5",
        "1.",
        "3e2",
        "\"č x\"",
        "(",
        ")",
        "<",
        ">",
        ",",
        ";",
        ";",
        ":",
        "=",
        "+",
        "-",
        "*",
        "/",
        ".",
        "^",
        "..",
        "<=",
        "==",
        "&&",
        "!",
        "#uses x/y ;",
        "// c\n",
        "// c \r\n",
        "/* d */",
        "/* e\n   f */",
    ]);
    let blanks = prop::sample::select(vec!["", " ", " ", "  ", "\n", "\n", "\n\n\n", "\n  ", "\n\t", "\r\n   ", "     "]);
    prop::collection::vec((words, blanks), 0..40).prop_map(|parts| {
        // What is joined by chance is one word, or a mistake that is not looked at.
        parts.into_iter().flat_map(|(word, blank)| [word, blank]).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn formatting_loses_nothing_and_is_done_after_once(text in texts()) {
        if formatted(&Source::new("t", text.as_str())).is_ok() {
            is_regular(&text);
        }
    }

    #[test]
    fn what_comments_describe_stays(gaps in prop::collection::vec(prop::sample::select(vec![
        "", " ", "\n", "\n\n", "// x\n", " // y\n          // z\n", "/* k */", "\n/* l\n m */\n", "\n          // n\n"
    ]), 8)) {
        let mut text = String::from("global;");
        for (at, gap) in gaps.iter().enumerate() {
            text.push_str(gap);
            text.push_str(&format!("p{at}: scalar{} default 1;", if at % 3 == 0 { ", // in\n " } else { "," }));
        }
        text.push_str("\nformula;\n= Cd;\n");
        let docs = |text: &str| -> Vec<Option<String>> {
            let (file, diagnostics) = parse(&Source::new("t", text));
            assert!(!diagnostics.has_errors(), "{diagnostics:?}");
            file.declarations().map(|declaration| declaration.doc.clone()).collect()
        };
        prop_assert_eq!(docs(&of(&text)), docs(&text), "{}\nbecomes\n{}", text, of(&text));
    }
}
