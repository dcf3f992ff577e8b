//! Drawing the editor: gutter, text and list; and what egui's widget did in a frame.

use super::colouring::Laid;
use super::history::{Edit, Selection};
use super::list::List;
use super::marks::VisibleText;
use super::{Document, Editor, EditorCommand, Order, TextStyling, edit_menu_ui, hover, problems};
use crate::assist::completion::Candidate;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::util::undoer::{Settings, Undoer};
use egui::{
    Align, Context, Event, EventFilter, Frame, Id, Key, Margin, Pos2, Rect, Response, ScrollArea, Sense, Shape, SurrenderFocusOn,
};
use egui::{TextEdit, Ui, UiBuilder, pos2, vec2};
use std::sync::Arc;

impl Editor {
    /// Draws gutter and text, lets the widget handle the typed input, and draws the list.
    pub(super) fn text_ui(
        &mut self,
        ui: &mut Ui,
        look: TextStyling<'_>,
        document: &mut Document,
        typed: &[Event],
        summoned: bool,
    ) {
        let room = ui.available_rect_before_wrap();
        ui.painter().rect_filled(room, 0.0, look.palette.background);
        let digit = look.context.fonts_mut(|fonts| fonts.glyph_width(look.font, '0'));
        let laid = self.lay(look, document);
        let gutter = Rect::from_min_max(room.min, pos2(room.left() + VisibleText::gutter_width(&laid, digit), room.bottom()));
        let id = Self::id_of(document);
        let mut inner = ui.new_child(UiBuilder::new().max_rect(room.with_min_x(gutter.right())).id_salt(("text", document.id())));
        let scroll = ScrollArea::both().id_salt(document.id()).auto_shrink([false, false]).animated(false);
        scroll.show(&mut inner, |ui| {
            let (origin, hovered) = self.widget(ui, look, document, typed, summoned);
            self.draw(ui, look, document, (origin, hovered), gutter);
            let caret = self.sheet(look, document, (origin, ui.clip_rect())).caret(&document.text, self.selection.head);
            if std::mem::take(&mut self.reveal) {
                let rect = Rect::from_min_max(caret[0], caret[1]).expand2(vec2(24.0, 0.0));
                let seen = ui.clip_rect().shrink2(vec2(0.0, 2.0)).contains_rect(rect);
                if !seen {
                    ui.scroll_to_rect(rect, Some(Align::Center));
                }
            }
            if !ui.memory(|memory| memory.has_focus(id)) {
                self.list.close();
            }
            let [top, bottom] = caret;
            if self.list.ui(look.context, id, [top, bottom], look.font, look.palette) {
                self.ordered.push(Order::Command(EditorCommand::Accept));
                self.wants_focus = true;
                look.context.request_repaint();
            }
        });
        ui.advance_cursor_after_rect(room);
    }

    /// Draws the widget and handles its output. Returns where the text starts on the screen, and the widget's
    /// response.
    fn widget(
        &mut self,
        ui: &mut Ui,
        look: TextStyling<'_>,
        document: &mut Document,
        typed: &[Event],
        summoned: bool,
    ) -> (Pos2, Response) {
        let id = Self::id_of(document);
        let (kind, laid) = (document.kind(), self.lay(look, document));
        let margin = Margin { left: 4, right: 24, top: 2, bottom: 2 };
        // Lines are not wrapped, so the widget is as wide as the longest one. It covers the visible area, so clicks
        // anywhere reach the text.
        let least = laid.galley.size() + margin.sum();
        let least = least.max(ui.available_size());
        self.tell_widget(look.context, id, document, &laid);
        let before = document.text.clone();
        let old = self.selection;
        let behind = ui.painter().add(Shape::Noop);
        let colouring = &mut self.colouring;
        let mut layouter = |_: &Ui, text: &dyn egui::TextBuffer, _: f32| {
            Arc::clone(&colouring.lay(look.context, kind, text.as_str(), look.font, look.palette).galley)
        };
        // A click into the list must not take the keyboard away from the text.
        let on_list = self.list.is_open()
            && look.context.pointer_interact_pos().and_then(|at| look.context.layer_id_at(at)) == Some(List::layer(id));
        let surrender = look.context.options(|options| options.input_options.surrender_focus_on);
        if on_list || summoned {
            look.context.options_mut(|options| options.input_options.surrender_focus_on = SurrenderFocusOn::Never);
        }
        let output = TextEdit::multiline(&mut document.text)
            .id(id)
            .code_editor()
            .event_filter(EventFilter { tab: true, horizontal_arrows: true, vertical_arrows: true, escape: true })
            .frame(Frame::NONE.inner_margin(margin))
            .min_size(least)
            .desired_width(least.x)
            .layouter(&mut layouter)
            .show(ui);
        look.context.options_mut(|options| options.input_options.surrender_focus_on = surrender);
        // Screen readers and tests find the widget by its name.
        look.context.accesskit_node_builder(id, |node| node.set_label(document.title()));
        let laid = self.lay(look, document);
        if let Some(range) = output.state.cursor.char_range().filter(|_| look.context.memory(|memory| memory.has_focus(id))) {
            let byte = |cursor: CCursor| laid.lines.byte_of(&document.text, cursor.index.0);
            self.selection = Selection { anchor: byte(range.secondary), head: byte(range.primary) };
        }
        // The widget moves the cursor at any click. A right click into selected text opens the menu for it.
        if ui.input(|input| input.pointer.secondary_down()) && old.range().contains(&self.selection.head) {
            (self.selection, self.moved) = (old, true);
        }
        let can = self.possible_edits(document);
        output.response.response.context_menu(|ui| {
            if let Some(command) = edit_menu_ui(ui, can) {
                self.ordered.push(Order::Command(command));
            }
        });
        if let Some(edit) = Edit::between(&before, &document.text) {
            let now = look.context.input(|input| input.time);
            document.note_typed(edit, old, self.selection, now);
            let writes = |event: &Event| matches!(event, Event::Text(_) | Event::Key { key: Key::Backspace, .. });
            if typed.iter().any(writes) {
                self.offer(look, document, false);
            } else {
                self.list.close();
            }
        } else if self.selection != old {
            self.list.close();
        }
        let sheet = self.sheet(look, document, (output.galley_pos, ui.clip_rect()));
        let shapes = sheet.behind(&document.text, self.selection.head, self.find.found(), &self.selection.range(), look.palette);
        ui.painter().set(behind, Shape::Vec(shapes));
        (output.galley_pos, output.response.response.clone())
    }

    /// Tells the widget what is selected, if it cannot know.
    fn tell_widget(&mut self, context: &Context, id: Id, document: &Document, laid: &Laid) {
        let state = TextEditState::load(context, id);
        if !self.moved && state.is_some() {
            return;
        }
        let mut state = state.unwrap_or_default();
        // The document has its own history.
        state.set_undoer(Undoer::with_settings(Settings { max_undos: 0, ..Default::default() }));
        let character = |byte: usize| CCursor::new(laid.lines.char_of(&document.text, byte));
        let range = CCursorRange::two(character(self.selection.anchor), character(self.selection.head));
        state.cursor.set_char_range(Some(range));
        state.store(context, id);
        self.moved = false;
    }

    fn sheet(&mut self, look: TextStyling<'_>, document: &Document, (origin, clip): (Pos2, Rect)) -> VisibleText {
        VisibleText { laid: self.lay(look, document), origin, clip }
    }

    /// Draws what is above the text and beside it, and tooltips for diagnostics under the pointer.
    fn draw(&mut self, ui: &Ui, look: TextStyling<'_>, document: &Document, (origin, hovered): (Pos2, Response), gutter: Rect) {
        let cursor = self.selection.head;
        let diagnostics = if document.is_checked() { document.diagnostics() } else { &[] };
        let text = document.text.as_str();
        let beside = ui.interact(gutter, Self::id_of(document).with("gutter"), Sense::hover());
        let pointer = look.context.pointer_hover_pos();
        let painter = ui.painter();
        let sheet = self.sheet(look, document, (origin, ui.clip_rect()));
        let in_text = sheet.underline(painter, text, diagnostics, pointer.filter(|_| hovered.hovered()), look.palette);
        let outer = look
            .context
            .layer_painter(ui.layer_id())
            .with_clip_rect(gutter.intersect(painter.clip_rect().with_min_x(gutter.left())));
        let rows = VisibleText { clip: gutter.intersect(ui.clip_rect().with_min_x(gutter.left())), ..sheet };
        let in_gutter = rows.gutter(
            &outer,
            (gutter, look.font),
            (text, cursor),
            diagnostics,
            pointer.filter(|at| gutter.contains(*at)),
            look.palette,
        );
        if in_text.is_empty()
            && !self.list.is_open()
            && !self.mouse_rests
            && let Some((known, _)) = self.meaning_at(look, document, (origin, &hovered))
        {
            hovered.clone().on_hover_ui_at_pointer(|ui| hover::hover_ui(ui, &known, look.palette));
        }
        for (response, under) in [(hovered, in_text), (beside, in_gutter)] {
            if !under.is_empty() {
                response.on_hover_ui_at_pointer(|ui| problems::hover_ui(ui, &under));
            }
        }
    }

    /// What is known about the word under the pointer, and the bytes of the word.
    fn meaning_at(
        &mut self,
        look: TextStyling<'_>,
        document: &Document,
        (origin, hovered): (Pos2, &Response),
    ) -> Option<(Candidate, std::ops::Range<usize>)> {
        let pointer = hovered.hover_pos()?;
        let laid = self.lay(look, document);
        let near = laid.galley.cursor_from_pos(pointer - origin);
        let byte = laid.lines.byte_of(&document.text, near.index.0);
        // The nearest place between two characters is the end of the word if the pointer is on its last half.
        let candidates = [Some(byte), byte.checked_sub(1)].into_iter().flatten();
        let sheet = VisibleText { laid: Arc::clone(&laid), origin, clip: hovered.rect };
        let under = |range: &std::ops::Range<usize>| {
            sheet.rectangles(&document.text, range.clone()).iter().any(|rect| rect.contains(pointer))
        };
        candidates.filter_map(|byte| self.pointed.meaning(document, &laid.words, byte)).find(|(_, range)| under(range))
    }
}
