//! A printed or formatted text parses as the same formula or scene.

use illuminator::lang::ast::{ExprKind, FormulaFile, ParameterAttributes, Section};
use illuminator::lang::format::formatted;
use illuminator::lang::parser::parse;
use illuminator::lang::printer::print;
use illuminator::lang::source::{Source, SourceSpan};
use illuminator::scene::Scene;
use illuminator::workspace::{FileKind, presets};
use proptest::prelude::*;
use proptest::sample::select;

/// The syntax without places and without parentheses that change nothing.
fn bare(mut file: FormulaFile) -> FormulaFile {
    let nowhere = SourceSpan::default();
    for expression in &mut file.expressions {
        expression.span = nowhere;
        expression.outer = nowhere;
        match &mut expression.kind {
            ExprKind::Infix(_, span, _) => *span = nowhere,
            ExprKind::Call(callee, _) => callee.span = nowhere,
            ExprKind::Number(_)
            | ExprKind::Name(_)
            | ExprKind::Text(_)
            | ExprKind::Prefix(..)
            | ExprKind::Vector(_)
            | ExprKind::Conditional(_)
            | ExprKind::Missing => {}
        }
    }
    for definition in &mut file.definitions {
        definition.name.span = nowhere;
        definition.arguments.iter_mut().flatten().for_each(|argument| argument.span = nowhere);
    }
    if let Some((_, span)) = &mut file.uses {
        *span = nowhere;
    }
    for section in &mut file.sections {
        match section {
            Section::Parameters(_, declarations) => {
                for declaration in declarations {
                    declaration.name.span = nowhere;
                    bare_attributes(&mut declaration.attributes);
                }
            }
            Section::Predefined(lines) => {
                for line in lines {
                    line.name.span = nowhere;
                    bare_attributes(&mut line.attributes);
                }
            }
            Section::Invariants(lines) => {
                for line in lines {
                    line.span = nowhere;
                    line.terms.iter_mut().for_each(|term| term.span = nowhere);
                }
            }
        }
    }
    file
}

fn bare_attributes(attributes: &mut ParameterAttributes) {
    let nowhere = SourceSpan::default();
    let ParameterAttributes { range, default, image, slider, colour, switch, choices } = attributes;
    range.iter_mut().for_each(|(_, span)| *span = nowhere);
    default.iter_mut().for_each(|(_, span)| *span = nowhere);
    image.iter_mut().for_each(|(_, span)| *span = nowhere);
    choices.iter_mut().for_each(|(_, span)| *span = nowhere);
    [slider, colour, switch].into_iter().flatten().for_each(|span| *span = nowhere);
}

fn read(text: &str) -> Result<FormulaFile, TestCaseError> {
    let source = Source::new("round trip", text);
    let (file, diagnostics) = parse(&source);
    prop_assert!(diagnostics.is_empty(), "{}", diagnostics.located(&source));
    Ok(bare(file))
}

/// Any expression of the grammar, with some parentheses.
fn expression() -> impl Strategy<Value = String> {
    let atom = prop_oneof![
        select(vec!["N", "kd", "alpha", "A_1", "e3"]).prop_map(str::to_owned),
        any::<f32>().prop_filter("finite", |x| x.is_finite()).prop_map(|x| format!("{}", x.abs())),
        select(vec!["1e-3", "2.", ".5", "7E+2"]).prop_map(str::to_owned),
    ];
    atom.prop_recursive(6, 64, 4, |inner| {
        let infix = select(vec!["+", "-", "*", "/", " . ", "^"]);
        let compare = select(vec![" < ", " <= ", " > ", " >= ", " == ", " != "]);
        let condition = (inner.clone(), compare, inner.clone(), 0..5u8).prop_map(|(a, mark, b, form)| match form {
            0 => format!("({a}{mark}{b})"),
            1 => format!("!({a}{mark}{b})"),
            2 => format!("{a}{mark}{b} && {b}{mark}{a} || !{a}{mark}{b}"),
            3 => format!("({a}{mark}{b} || {a}{mark}1) && 0{mark}{b}"),
            _ => format!("{a}{mark}{b}"),
        });
        prop_oneof![
            4 => (inner.clone(), infix, inner.clone()).prop_map(|(a, mark, b)| format!("{a} {mark} {b}")),
            2 => inner.clone().prop_map(|a| format!("({a})")),
            2 => inner.clone().prop_map(|a| format!("-({a})")),
            1 => inner.clone().prop_map(|a| format!("- {a}")),
            1 => (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("<{a}, {b}, {c}>")),
            1 => inner.clone().prop_map(|a| format!("<{a}>")),
            1 => condition.clone().prop_map(|condition| format!("({condition})")),
            1 => proptest::collection::vec(inner.clone(), 1..4).prop_map(|list| format!("f({})", list.join(", "))),
            1 => (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("sum(i, 1, {a}, {b})")),
            1 => (condition, inner.clone(), inner).prop_map(|(c, a, b)| format!("if({c}, {a}, {b})")),
        ]
    })
}

fn declaration() -> impl Strategy<Value = String> {
    let range =
        prop_oneof![Just(String::new()), (-5.0..0.0_f32, 0.0..9.0_f32).prop_map(|(a, b)| format!(", constraint {a}..{b}"))];
    let default = prop_oneof![
        Just(String::new()),
        any::<f32>().prop_filter("finite", |x| x.is_finite()).prop_map(|x| format!(", default {x}")),
        Just(", default <1, -2.5, .25>".to_owned())
    ];
    let flags = select(vec!["", ", slider", ", color", ", color, slider", ", switch", ", choices \"GGX\", \"a; // b\", slider"]);
    let said = select(vec!["", " // what it is", " /* -1 */ /// dark", "\n// of the next", "\n\n/* of\n nothing */\n"]);
    (select(vec!["kd", "scalar", "slider", "x_9"]), select(vec!["scalar", "vector"]), range, default, flags, said)
        .prop_map(|(name, ty, range, default, flags, said)| format!("{name}: {ty}{range}{default}{flags};{said}\n"))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn printed_formulas_read_back(
        uses in prop_oneof![Just(String::new()), Just("#uses some where/x.toml;\n".to_owned())],
        declarations in proptest::collection::vec(declaration(), 0..4),
        relation in select(vec!["=", "<="]),
        macros in proptest::collection::vec(expression(), 0..3),
        function in expression(),
        result in expression(),
    ) {
        let macros: String = macros.iter().enumerate().map(|(index, body)| format!("M{index} = {body};\n")).collect();
        let text = format!(
            "{uses}light_specific;\n{}predefined; ki: constraint 0..50, default 1; Cd: color;\ninvariants;\nkr + kt {relation} 1;\n\
             formula;\n{macros}f(x, y) = {function};\nis = N.L > 0 || {function} < 1;\n= {result};",
            declarations.concat()
        );
        let first = read(&text)?;
        let printed = print(&first);
        let second = read(&printed)?;
        prop_assert_eq!(&first, &second, "{}\n{}", text, printed);
    }
}

#[test]
fn built_in_files_mean_the_same_when_they_are_formatted() {
    for kind in [FileKind::Formula, FileKind::Scene] {
        for name in presets::names(kind) {
            let text = presets::text(kind, name).expect("a built-in file");
            let once = formatted(&Source::new(name, text)).expect("known characters");
            assert_eq!(formatted(&Source::new(name, once.as_str())).expect("known characters"), once, "{name}");
            if kind == FileKind::Formula {
                let parsed = |text: &str| {
                    let (file, diagnostics) = parse(&Source::new(name, text));
                    assert!(!diagnostics.has_errors(), "{name}: {diagnostics:?}");
                    bare(file)
                };
                assert_eq!(parsed(&once), parsed(text), "{name}");
            } else {
                let parsed = |text: &str| Scene::parse(&Source::new(name, text)).expect("a sound scene").0.to_string();
                assert_eq!(parsed(&once), parsed(text), "{name}");
            }
            // That formula is written as the thesis prints it.
            let is_regular = once == text || name == "phong-thesis";
            assert!(is_regular, "{name} is not formatted; `illuminator fmt presets/{0}/{name}.{0}` does it", kind.noun());
        }
    }
}
