//! The event loop of the window: wait for input, run the widgets, paint what changed, send it to the display.
//!
//! If nothing happens, nothing is done. The loop sleeps until the display or another thread wakes it, and polls a few
//! times per second for what comes without an event. A frame without changes is not sent, because sending costs more
//! than everything else.

use super::clipboard::Clipboard;
use super::display::{self, Display, Pointer, Signal};
use super::exit::WindowExit;
use super::incoming::Incoming;
use super::keys::{Keyboard, Stroke, Strokes};
use super::polled::Polled;
use super::{cursor, printable};
use crate::preview::paint::{Frame, Painter, Region};
use crate::preview::{FrameTimes, WindowApp};
use egui::{Event, FullOutput, OutputCommand, RawInput, ViewportCommand, ViewportId};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// The shortest time between two frames because of pointer movements.
const MOTION: Duration = Duration::from_millis(4);

/// The shortest time between two frames that egui asks for, for instance for animations.
const ANIMATION: Duration = Duration::from_millis(16);

/// How often minifb is polled, during and after input.
const AWAKE: Duration = Duration::from_millis(8);
const ASLEEP: Duration = Duration::from_millis(100);

/// How long after the last input minifb is polled often: an input method gives no events.
const LATE: Duration = Duration::from_millis(300);

/// How often the pixels are sent again if the display does not say when they are lost.
const AGAIN: Duration = Duration::from_millis(400);

/// The window and its state.
pub(super) struct Shell {
    window: minifb::Window,
    display: Option<Display>,
    polled: Polled,
    signals: Receiver<Signal>,
    strokes: Strokes,
    keyboard: Keyboard,
    clipboard: Clipboard,
    incoming: Incoming,
    context: egui::Context,
    painter: Painter,
    title: String,
    size: [usize; 2],
    /// Whether minifb says that the window has the focus, whether keys came since it last lost it, and what egui was
    /// told.
    active: bool,
    typed: bool,
    focused: bool,
    hidden: bool,
    /// Whether all pixels must be sent, changed or not.
    lost: bool,
    begun: Instant,
    news: Instant,
    last: Instant,
    presented: Instant,
    /// When the next frame is wanted, even without input.
    due: Option<Instant>,
    exit: WindowExit,
    /// Whether the display is gone. minifb must not be called any more then, because Xlib would end the program.
    display_lost: bool,
}

/// Why the loop ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// The window was closed.
    Closed,
    /// The display is gone.
    DisplayLost,
}

impl Shell {
    pub(super) fn new(mut window: minifb::Window, title: String, exit: &WindowExit) -> Self {
        let strokes = Strokes::default();
        window.set_input_callback(Box::new(strokes.clone()));
        window.set_target_fps(0);
        let (sender, signals) = channel();
        exit.wakes(sender.clone());
        let context = egui::Context::default();
        // The application sets the size of widgets.
        context.options_mut(|options| options.zoom_with_keyboard = false);
        let (own, waker) = (std::thread::current().id(), sender.clone());
        context.set_request_repaint_callback(move |wish| {
            if let Some(at) = Instant::now().checked_add(wish.delay) {
                let _ = waker.send(Signal::Repaint { at, own: std::thread::current().id() == own });
            }
        });
        let display = u32::try_from(window.get_window_handle() as usize).ok().and_then(|handle| Display::open(handle, sender));
        let now = Instant::now();
        Self {
            window,
            display,
            polled: Polled::default(),
            signals,
            strokes,
            keyboard: Keyboard::default(),
            clipboard: Clipboard::default(),
            incoming: Incoming::default(),
            context,
            painter: Painter::new(),
            title,
            size: [0, 0],
            active: false,
            typed: false,
            focused: true,
            hidden: false,
            lost: true,
            begun: now,
            news: now,
            last: now,
            presented: now,
            due: Some(now),
            exit: exit.clone(),
            display_lost: false,
        }
    }

    pub(super) fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Waits, and does what is due. Returns why the loop ends, if it does.
    pub(super) fn turn(&mut self, app: &mut dyn WindowApp) -> Option<Ending> {
        let signals = self.wait();
        if signals.contains(&Signal::Broken) {
            self.lose_connection();
        }
        if self.display_lost {
            return Some(Ending::DisplayLost);
        }
        self.window.update();
        if !self.window.is_open() || self.exit.is_wanted() {
            return Some(Ending::Closed);
        }
        let scale = sound(app.scale()) * self.context.zoom_factor();
        self.sort(signals, scale);
        self.look();
        if self.next().is_some_and(|at| at <= Instant::now()) {
            return (!self.frame(app)).then_some(Ending::Closed);
        }
        if self.lost || (self.display.is_none() && self.presented.elapsed() > AGAIN) {
            self.present(&[self.whole()]);
        }
        None
    }

    /// Continues without the second connection, if the display still exists.
    fn lose_connection(&mut self) {
        self.display = None;
        self.display_lost |= display::is_gone();
    }

    /// When the next frame is due.
    fn next(&self) -> Option<Instant> {
        let now = Instant::now();
        let seen = if self.incoming.is_urgent() { Some(now) } else { (!self.incoming.is_empty()).then(|| self.last + MOTION) };
        seen.into_iter().chain(self.due).min()
    }

    /// Sleeps until there is something to do.
    fn wait(&self) -> Vec<Signal> {
        let now = Instant::now();
        let rest = if self.display.is_some() && now.duration_since(self.news) > LATE { ASLEEP } else { AWAKE };
        let until = self.next().map_or(rest, |at| at.saturating_duration_since(now).min(rest));
        let first = if self.strokes.is_empty() && !until.is_zero() { self.signals.recv_timeout(until).ok() } else { None };
        first.into_iter().chain(self.signals.try_iter()).collect()
    }

    /// Puts pointer and keyboard input into one order.
    fn sort(&mut self, signals: Vec<Signal>, scale: f32) {
        let strokes = self.strokes.take();
        if !signals.is_empty() || !strokes.is_empty() {
            self.news = Instant::now();
        }
        // Both connections report keys. If the counts agree, it is known between which clicks they were typed.
        let is_key = |stroke: &Stroke| matches!(stroke, Stroke::Key(..));
        let known = strokes.iter().filter(|stroke| is_key(stroke)).count()
            == signals.iter().filter(|signal| **signal == Signal::Key).count();
        let mut strokes = strokes.into_iter().peekable();
        for signal in signals {
            match signal {
                Signal::Pointer(pointer, modifiers, at) => self.pointer(pointer, modifiers, at, scale),
                Signal::Key if known => {
                    while let Some(stroke) = strokes.next() {
                        self.stroke(stroke);
                        if strokes.peek().is_some_and(is_key) {
                            break;
                        }
                    }
                }
                Signal::Exposed => self.lost = true,
                Signal::Mapped(mapped) => {
                    self.hidden = !mapped;
                    self.lost |= mapped;
                }
                Signal::Repaint { at, own } => {
                    let at = if own { at.max(self.last + ANIMATION) } else { at };
                    self.due = self.due.into_iter().chain([at]).min();
                }
                Signal::Key | Signal::Other | Signal::Close | Signal::Broken => {}
            }
        }
        strokes.for_each(|stroke| self.stroke(stroke));
        if self.display.is_none() {
            let modifiers = self.keyboard.modifiers();
            for pointer in self.polled.look(&self.window) {
                self.news = Instant::now();
                self.pointer(pointer, modifiers, Instant::now(), scale);
            }
        }
    }

    fn stroke(&mut self, stroke: Stroke) {
        self.typed = true;
        let mut told = Vec::new();
        self.keyboard.stroke(stroke, &mut self.clipboard, &mut told);
        told.into_iter().for_each(|event| self.incoming.push(event, Instant::now()));
    }

    fn pointer(&mut self, pointer: Pointer, modifiers: egui::Modifiers, at: Instant, scale: f32) {
        if let Some(event) = self.keyboard.correct(modifiers) {
            self.incoming.push(event, at);
        }
        let point = |[x, y]: [f32; 2]| egui::pos2(x, y) / scale;
        let event = match pointer {
            Pointer::Moved(place) => Event::PointerMoved(point(place)),
            Pointer::Gone => Event::PointerGone,
            Pointer::Button { at, button, pressed } => Event::PointerButton { pos: point(at), button, pressed, modifiers },
            Pointer::Wheel(notches) => Event::MouseWheel {
                unit: egui::MouseWheelUnit::Line,
                delta: notches.into(),
                phase: egui::TouchPhase::Move,
                modifiers,
            },
        };
        self.incoming.push(event, at);
    }

    /// Updates size and focus, for which minifb gives no events.
    fn look(&mut self) {
        let (width, height) = self.window.get_size();
        if self.size != [width, height] {
            self.size = [width, height];
            self.lost = true;
            self.due = Some(Instant::now());
        }
        let active = self.window.is_active();
        if self.active && !active {
            self.typed = false;
        }
        self.active = active;
        // Without a window manager no window has the focus, but keys arrive.
        let focused = active || self.typed;
        if self.focused != focused {
            self.focused = focused;
            let mut told = Vec::new();
            if !focused {
                self.keyboard.release(&mut told);
            }
            told.push(Event::WindowFocused(focused));
            told.into_iter().for_each(|event| self.incoming.push(event, Instant::now()));
        }
    }

    /// Runs and shows a frame. Returns false if the window should close.
    fn frame(&mut self, app: &mut dyn WindowApp) -> bool {
        let start = Instant::now();
        self.last = start;
        self.due = self.due.filter(|due| *due > start);
        let mut motion = None;
        let mut closes = false;
        let mut output = loop {
            let portion = self.incoming.portion();
            motion = motion.or(portion.motion);
            let input = self.input(portion.events, sound(app.scale()));
            let mut output = self.context.run_ui(input, |ui| app.ui(ui));
            self.painter.update_textures(&mut output.textures_delta);
            closes |= self.obey(&mut output);
            if self.incoming.is_empty() {
                break output;
            }
        };
        let widgets = self.context.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let background = self.context.global_style().visuals.panel_fill.to_array();
        let laid_out = Instant::now();

        let picture = app.picture();
        let version = picture.as_ref().map(|picture| picture.version);
        let frame = Frame {
            size: self.size,
            scale: output.pixels_per_point,
            background: u32::from_be_bytes([0, background[0], background[1], background[2]]),
            widgets: &widgets,
            picture,
        };
        let changed = self.painter.paint(&frame).to_vec();
        let painted = Instant::now();

        let presents = !self.hidden && (self.lost || !changed.is_empty());
        if presents {
            self.present(&if self.lost { vec![self.whole()] } else { changed });
        }
        let finished = Instant::now();
        app.frame_shown(&FrameTimes {
            layout: laid_out - start,
            painting: painted - laid_out,
            present: presents.then(|| finished - painted),
            motion,
            finished: Some(finished),
            picture: version,
        });
        if !self.display_lost {
            self.rename(app);
        }
        !closes && !app.wants_close()
    }

    fn input(&self, events: Vec<Event>, scale: f32) -> RawInput {
        let size = egui::vec2(self.size[0] as f32, self.size[1] as f32) / (scale * self.context.zoom_factor());
        let mut input = RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            max_texture_side: Some(1 << 13),
            time: Some(self.begun.elapsed().as_secs_f64()),
            events,
            focused: self.focused,
            ..RawInput::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(scale);
            viewport.inner_rect = input.screen_rect;
            viewport.focused = Some(self.focused);
            viewport.minimized = Some(self.hidden);
        }
        input
    }

    /// Does what egui asks of the platform. Returns whether the window should close.
    fn obey(&mut self, output: &mut FullOutput) -> bool {
        for command in output.platform_output.commands.drain(..) {
            match command {
                OutputCommand::CopyText(text) => self.clipboard.set_text(text),
                OutputCommand::CopyImage(image) => self.clipboard.set_image(&image),
                // Nothing in the workshop opens URLs.
                OutputCommand::OpenUrl(_) => {}
            }
        }
        self.window.set_cursor_style(cursor::style(output.platform_output.cursor_icon));
        let Some(root) = output.viewport_output.get(&ViewportId::ROOT) else { return false };
        if let Some(at) = Instant::now().checked_add(root.repaint_delay) {
            self.due = self.due.into_iter().chain([at.max(self.last + ANIMATION)]).min();
        }
        root.commands.iter().any(|command| matches!(command, ViewportCommand::Close))
    }

    fn rename(&mut self, app: &dyn WindowApp) {
        let title = printable(&app.title());
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
    }

    fn whole(&self) -> Region {
        let [right, bottom] = self.painter.size().map(|side| side as i32);
        Region { left: 0, top: 0, right, bottom }
    }

    /// Sends changed regions to the display.
    fn present(&mut self, changed: &[Region]) {
        let [width, height] = self.painter.size();
        if width == 0 || height == 0 {
            return;
        }
        let pixels = self.painter.pixels();
        if let Some(display) = &mut self.display
            && display.present(pixels, width, changed).is_err()
        {
            self.lose_connection();
        }
        if self.display_lost {
            return;
        }
        if self.display.is_none() {
            let pixels = self.painter.pixels();
            // It only fails if there are fewer pixels than it is told.
            let _ = self.window.update_with_buffer(pixels, width, height);
        }
        self.lost = false;
        self.presented = Instant::now();
    }
}

/// A valid scale for widgets.
fn sound(scale: f32) -> f32 {
    if scale.is_finite() { scale.clamp(0.5, 4.0) } else { 1.0 }
}
