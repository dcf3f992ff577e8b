//! The editor driven without a window, as a user would.

use super::*;
use crate::workspace::{FileKind, presets};
use egui::{Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

/// An editor with its document and the list of problems.
struct Desk {
    editor: Editor,
    document: Document,
    response: EditorResponse,
    applied: usize,
}

const FORMULA: &str = "formula;\nDIFFUSE = max(0, N.L)*Cd;\n= DIFFUSE;\n";

fn desk(kind: FileKind, text: &str) -> Harness<'static, Desk> {
    let editor = Editor { wants_focus: true, ..Editor::default() };
    let desk = Desk { editor, document: Document::untitled(kind, text), response: EditorResponse::default(), applied: 0 };
    let mut harness = Harness::builder().with_size(egui::vec2(700.0, 500.0)).with_step_dt(0.02).build_ui_state(
        |ui, desk: &mut Desk| {
            let rect = ui.available_rect_before_wrap();
            let upper = Rect::from_min_max(rect.min, egui::pos2(rect.right(), rect.bottom() - 150.0));
            let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(upper));
            desk.response = desk.editor.ui(&mut inner, &mut desk.document, &Palette::DARK);
            desk.applied += usize::from(desk.response.apply);
            let lower = Rect::from_min_max(egui::pos2(rect.left(), upper.bottom()), rect.max);
            let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(lower));
            if let Some((_, span)) = problems_ui(&mut inner, &[((), &desk.document)]) {
                desk.editor.jump_to(span);
            }
        },
        desk,
    );
    harness.run_steps(3);
    harness
}

impl Desk {
    fn selected(&self) -> &str {
        &self.document.text()[self.editor.selection.range()]
    }
}

fn press(harness: &mut Harness<'_, Desk>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.run_steps(3);
}

fn type_text(harness: &mut Harness<'_, Desk>, text: &str) {
    for character in text.chars() {
        match character {
            '\n' => harness.key_press(Key::Enter),
            other => harness.event(Event::Text(other.to_string())),
        }
    }
    harness.run_steps(text.len() + 3);
}

fn cursor_to(harness: &mut Harness<'_, Desk>, byte: usize) {
    harness.state_mut().editor.jump_to(SourceSpan::new(byte, byte));
    harness.run_steps(3);
}

#[test]
fn what_is_typed_in_one_go_stands_in_its_order() {
    let mut harness = desk(FileKind::Formula, "");
    assert!(harness.state().response.focused && !harness.state().document.unsaved());
    assert_eq!(harness.state().document.counts()[0], 1, "an empty text is no formula");
    type_text(&mut harness, "formula;\n  a = 1;\n= Cd*a;\n");
    let desk = harness.state();
    assert_eq!(desk.document.text(), "formula;\n  a = 1;\n  = Cd*a;\n  ");
    assert_eq!((desk.response.place, desk.document.counts()), ((4, 3), [0, 0]));
    assert_eq!(desk.document.title(), "untitled formula •");
    assert_eq!(desk.applied, 0);
    press(&mut harness, Modifiers::COMMAND, Key::Enter);
    assert_eq!(harness.state().applied, 1);
    assert_eq!(harness.state().document.text().lines().count(), 4);
}

#[test]
fn steps_are_taken_back_and_done_again() {
    let mut harness = desk(FileKind::Formula, FORMULA);
    cursor_to(&mut harness, FORMULA.len());
    type_text(&mut harness, "// one two");
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(harness.state().document.text(), format!("{FORMULA}// one "));
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    press(&mut harness, Modifiers::COMMAND, Key::Y);
    assert_eq!(harness.state().document.text(), format!("{FORMULA}// one two"));
    for _ in 0..5 {
        press(&mut harness, Modifiers::COMMAND, Key::Z);
    }
    assert!(!harness.state().document.unsaved());
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(harness.state().document.text(), format!("{FORMULA}// "));
}

#[test]
fn what_is_wrong_is_listed_and_found_by_a_click() {
    let text = "// č😀\nformula;\nA = /* č */ unknwn;\n= č;\n";
    let mut harness = desk(FileKind::Formula, text);
    assert_eq!(harness.state().document.counts()[0], 2);
    harness.get_by_label_contains("`unknwn` is not known").click();
    harness.run_steps(4);
    let desk = harness.state();
    assert_eq!((desk.selected(), desk.response.place), ("unknwn", (3, 19)));
    assert!(desk.response.focused);
    // Typing replaces the wrong text.
    type_text(&mut harness, "kd");
    assert!(harness.state().document.text().contains("/* č */ kd;"));
    harness.get_by_label_contains("`č` is not part of the language").click();
    harness.run_steps(4);
    type_text(&mut harness, "Cd");
    assert!(harness.state().document.text().contains("= Cd;"), "{}", harness.state().document.text());
}

#[test]
fn marks_are_where_the_errors_are() {
    let text = "formula;\n// \u{1f600}č\n= č + Cd;";
    let mut harness = desk(FileKind::Formula, text);
    harness.run_steps(2);
    let context = harness.ctx.clone();
    let look =
        TextStyling { context: &context, font: &TextStyle::Monospace.resolve(&context.global_style()), palette: &Palette::DARK };
    let desk = harness.state_mut();
    let laid = desk.editor.colouring.lay(look.context, FileKind::Formula, text, look.font, look.palette);
    assert_eq!(laid.galley.rows.len(), laid.lines.count());
    let sheet = marks::VisibleText { laid, origin: egui::Pos2::ZERO, clip: Rect::EVERYTHING };
    let span = desk.document.diagnostics()[0].span().unwrap();
    let [rect] = sheet.rectangles(text, span.range())[..] else { panic!("one line") };
    let row = &sheet.laid.galley.rows[2];
    assert_eq!((rect.left(), rect.top()), (row.glyphs[2].pos.x, row.min_y()));
    assert_eq!(row.glyphs[2].chr, 'č');
    // A mark at the very end, and one over several lines.
    assert_eq!(sheet.rectangles(text, text.len()..text.len()).len(), 1);
    assert_eq!(sheet.rectangles(text, 0..text.len()).len(), 3);
    assert_eq!(sheet.rectangles(text, 0..9999).len(), 3);
}

#[test]
fn the_message_is_shown_under_the_pointer() {
    let mut harness = desk(FileKind::Formula, "formula;\n= unknwn;");
    assert_eq!(harness.query_all_by_label_contains("`unknwn` is not known").count(), 1);
    let position = egui::pos2(90.0, 24.0);
    for step in 0..40 {
        harness.hover_at(position + egui::vec2(step as f32 * 0.1, 0.0));
        harness.step();
    }
    harness.run_steps(60);
    assert!(harness.query_all_by_label_contains("`unknwn` is not known").count() > 1, "the hint beside the list");
}

#[test]
fn nothing_is_explained_while_the_mouse_rests_and_keys_are_pressed() {
    let mut harness = desk(FileKind::Formula, "formula;\n= smoothstep(0, 1, N.L)*Cd;");
    let rest = |harness: &mut Harness<'_, Desk>, from: f32| {
        for step in 0..10 {
            harness.hover_at(egui::pos2(from + step as f32 * 0.1, 32.0));
            harness.step();
        }
        harness.run_steps(60);
    };
    let doc = crate::lang::builtins::named("smoothstep").and_then(|form| form.overloads().next()).unwrap().doc();
    let explained = |harness: &Harness<'_, Desk>| harness.query_all_by_label_contains(doc).count() > 0;
    rest(&mut harness, 90.0);
    assert!(explained(&harness));
    cursor_to(&mut harness, 9);
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    harness.run_steps(90);
    assert!(!explained(&harness));
    rest(&mut harness, 92.0);
    assert!(explained(&harness));
}

#[test]
fn completion_writes_the_rest() {
    let mut harness = desk(FileKind::Formula, "formula;\n= ");
    cursor_to(&mut harness, 11);
    type_text(&mut harness, "smoo");
    assert!(harness.state().editor.list.is_open());
    press(&mut harness, Modifiers::NONE, Key::Tab);
    assert_eq!(harness.state().document.text(), "formula;\n= smoothstep(");
    assert!(!harness.state().editor.list.is_open());
    // A complete name needs no list, so Enter is a line break.
    type_text(&mut harness, "IL\n");
    assert!(harness.state().document.text().ends_with("smoothstep(IL\n"));
    type_text(&mut harness, "ma");
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(!harness.state().editor.list.is_open() && harness.state().response.focused);
    press(&mut harness, Modifiers::COMMAND, Key::Space);
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert!(harness.state().document.text().ends_with("\nmax("), "{}", harness.state().document.text());
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert!(harness.state().document.text().ends_with("\nma"));
}

#[test]
fn an_entry_of_the_list_can_be_clicked() {
    let mut harness = desk(FileKind::Formula, "formula;\n= ");
    cursor_to(&mut harness, 11);
    type_text(&mut harness, "k");
    assert!(harness.state().editor.list.is_open());
    press(&mut harness, Modifiers::NONE, Key::ArrowDown);
    harness.run_steps(2);
    harness.get_by_label_contains("weight of the refracted ray").click();
    harness.run_steps(5);
    assert_eq!(harness.state().document.text(), "formula;\n= kt");
    assert!(harness.state().response.focused);
}

#[test]
fn what_is_searched_for_is_found_and_replaced() {
    let mut harness = desk(FileKind::Formula, FORMULA);
    press(&mut harness, Modifiers::COMMAND, Key::F);
    harness.event(Event::Text("diffuse".to_owned()));
    harness.run_steps(4);
    assert_eq!(harness.state().selected(), "DIFFUSE");
    assert_eq!(harness.state().editor.selection.range(), 9..16);
    harness.get_by_label("1 of 2");
    harness.key_press(Key::Enter);
    harness.run_steps(4);
    assert_eq!(harness.state().editor.selection.range().start, FORMULA.rfind("DIFFUSE").unwrap());
    harness.get_by_label("Aa").click();
    harness.run_steps(3);
    harness.get_by_label("none");
    harness.get_by_label("Aa").click();
    harness.run_steps(3);
    harness.get_by_label("All").click();
    harness.run_steps(3);
    assert_eq!(harness.state().document.text(), "formula;\n = max(0, N.L)*Cd;\n= ;\n");
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(harness.state().response.focused && !harness.state().editor.find.is_open());
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(harness.state().document.text(), FORMULA);
}

#[test]
fn keys_indent_and_comment() {
    let mut harness = desk(FileKind::Formula, "a\nb");
    cursor_to(&mut harness, 1);
    press(&mut harness, Modifiers::NONE, Key::Tab);
    assert_eq!(harness.state().document.text(), "a    \nb");
    press(&mut harness, Modifiers::COMMAND, Key::A);
    press(&mut harness, Modifiers::NONE, Key::Tab);
    press(&mut harness, Modifiers::COMMAND, Key::Slash);
    assert_eq!(harness.state().document.text(), "    // a    \n    // b");
    press(&mut harness, Modifiers::COMMAND, Key::Slash);
    press(&mut harness, Modifiers::SHIFT, Key::Tab);
    assert_eq!(harness.state().document.text(), "a    \nb");
    assert!(harness.state().response.focused, "Tab is the text's");
}

#[test]
fn texts_come_and_go_with_their_line_ends() {
    let mut harness = desk(FileKind::Formula, "formula;\r\n= č;\r\n");
    assert_eq!(harness.state().document.diagnostics()[0].span(), Some(SourceSpan::new(11, 13)));
    cursor_to(&mut harness, 0);
    harness.event(Event::Paste("// x\r\n".to_owned()));
    harness.run_steps(3);
    assert_eq!(harness.state().document.text(), "// x\nformula;\n= č;\n");
    assert_eq!(harness.state().document.file_text(), "// x\r\nformula;\r\n= č;\r\n");
    assert_eq!(harness.state().response.place, (2, 1));
}

#[test]
fn each_document_keeps_its_place_and_steps() {
    let mut harness = desk(FileKind::Formula, FORMULA);
    cursor_to(&mut harness, 9);
    type_text(&mut harness, "x");
    let other = Document::untitled(FileKind::Scene, "bodies;");
    let first = std::mem::replace(&mut harness.state_mut().document, other);
    harness.state_mut().editor.focus();
    harness.run_steps(3);
    assert_eq!(harness.state().response.place, (1, 1));
    type_text(&mut harness, "// ");
    assert_eq!(harness.state().document.text(), "// bodies;");
    harness.state_mut().document = first;
    harness.state_mut().editor.focus();
    harness.run_steps(3);
    assert_eq!(harness.state().response.place, (2, 2));
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(harness.state().document.text(), FORMULA);
    harness.state_mut().editor.insert("abc");
    harness.run_steps(3);
    assert!(harness.state().document.text().starts_with("formula;\nabcDIFFUSE"));
}

#[test]
fn a_place_far_below_is_scrolled_into_view() {
    let text = format!("{}formula;\n= unknwn;", "// line\n".repeat(3000));
    let mut harness = desk(FileKind::Formula, &text);
    harness.get_by_label_contains("`unknwn` is not known").click();
    harness.run_steps(5);
    assert_eq!(harness.state().response.place, (3002, 9));
    let id = Editor::id_of(&harness.state().document);
    let rect = harness.ctx.read_response(id).unwrap().rect;
    assert!(rect.top() < -30_000.0, "{rect:?}");
}

#[test]
fn every_built_in_text_is_shown_without_a_mark() {
    for kind in [FileKind::Formula, FileKind::Scene] {
        for name in presets::names(kind) {
            let harness = desk(kind, presets::text(kind, name).unwrap());
            assert_eq!(harness.state().document.counts()[0], 0, "{name}");
        }
    }
}

#[test]
fn the_reference_inserts_what_is_clicked() {
    let mut harness = Harness::new_ui_state(
        |ui, (query, inserted): &mut (String, Option<String>)| {
            if let Some(text) = reference_ui(ui, query) {
                *inserted = Some(text);
            }
        },
        ("dot prod".to_owned(), None),
    );
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("clamp").is_none());
    harness.state_mut().0 = "hermite".to_owned();
    harness.run_steps(3);
    harness.get_by_label_contains("No match");
    harness.state_mut().0 = "clamp(x, lo".to_owned();
    harness.run_steps(8);
    harness.get_by_label("clamp(x, lo, hi)").click();
    harness.run_steps(3);
    assert_eq!(harness.state().1.as_deref(), Some("clamp("));
}

/// A measurement, not a test; run it by name, with `--nocapture`.
#[test]
#[ignore = "takes seconds and prints times"]
fn times_of_a_large_text() {
    let preset = presets::text(FileKind::Formula, "strauss").unwrap();
    let text = preset.repeat((1 << 20) / preset.len());
    let context = egui::Context::default();
    let mut desk = (Editor { wants_focus: true, ..Editor::default() }, Document::untitled(FileKind::Formula, &text));
    for (frame, typed) in ["", "", "", "x", "", "y", "", "z", ""].into_iter().enumerate() {
        let mut input = egui::RawInput { time: Some(frame as f64 * 0.02), ..egui::RawInput::default() };
        input.events.extend((!typed.is_empty()).then(|| Event::Text(typed.to_owned())));
        let start = std::time::Instant::now();
        let mut output = context.run_ui(input, |ui| {
            let _ = desk.0.ui(ui, &mut desk.1, &Palette::DARK);
        });
        let drawn = start.elapsed();
        output.textures_delta.clear();
        let meshes = context.tessellate(output.shapes, 1.0);
        println!("frame {frame} {typed:?}: {drawn:?}, with meshes ({}) {:?}", meshes.len(), start.elapsed());
    }
    let start = std::time::Instant::now();
    let words = crate::assist::words::Words::new(FileKind::Formula, &text);
    println!("words: {:?}", start.elapsed());
    let start = std::time::Instant::now();
    let at = text.rfind("DIFFUSE + ").unwrap() + 4;
    println!(
        "completion: {} in {:?}",
        complete(FileKind::Formula, &text, &words, at).map_or(0, |one| one.candidates.len()),
        start.elapsed()
    );
    let start = std::time::Instant::now();
    desk.1.replace_text(&text);
    desk.1.check();
    println!("check: {:?}, {:?}", start.elapsed(), desk.1.counts());
}
