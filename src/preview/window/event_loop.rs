//! The event loop of the window: wait for input, run the widgets, paint what changed, send it to the display.
//!
//! If nothing happens, nothing is done. The loop sleeps until the display or another thread wakes it, and polls a few
//! times per second for what comes without an event. A frame without changes is not sent, because sending costs more
//! than everything else.

use super::clipboard::Clipboard;
use super::display::{self, Display, LoopEvent, PointerInput};
use super::exit::WindowExit;
use super::file_drops::{DroppedPath, FilesInput};
use super::input_queue::InputQueue;
use super::keys::{KeyInput, KeyQueue, Keyboard};
use super::polled::PolledPointer;
use super::{cursor, printable};
use crate::preview::paint::{PaintInput, Painter, PixelRect};
use crate::preview::{FrameTimes, WindowApp};
use egui::{DroppedFileHandle, Event, FullOutput, HoveredFile, OutputCommand, RawInput, ViewportCommand, ViewportId};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// The shortest time between two frames because of pointer movements.
const MIN_MOTION_INTERVAL: Duration = Duration::from_millis(4);

/// The same, if the picture [follows slowly](WindowApp::follows_slowly).
const SLOW_MOTION_INTERVAL: Duration = Duration::from_millis(16);

/// The shortest time between two frames that egui asks for, for instance for animations.
const MIN_REPAINT_INTERVAL: Duration = Duration::from_millis(16);

/// How often minifb is polled, during and after input.
const POLL_ACTIVE: Duration = Duration::from_millis(8);
const POLL_IDLE: Duration = Duration::from_millis(100);

/// How long after the last input minifb is polled often: an input method gives no events.
const ACTIVE_PERIOD: Duration = Duration::from_millis(300);

/// How often the pixels are sent again if the display does not say when they are lost.
const RESEND_INTERVAL: Duration = Duration::from_millis(400);

/// The window and its state.
pub(super) struct EventLoop {
    window: minifb::Window,
    display: Option<Display>,
    polled: PolledPointer,
    events: Receiver<LoopEvent>,
    keys: KeyQueue,
    keyboard: Keyboard,
    clipboard: Clipboard,
    input_queue: InputQueue,
    /// Files that are dragged over the window, and those that were dropped since the last frame.
    hovered_files: Vec<HoveredFile>,
    dropped_files: Vec<DroppedFileHandle>,
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
    send_all: bool,
    started: Instant,
    last_input: Instant,
    last_frame: Instant,
    /// The shortest time between two frames because of pointer movements.
    motion_interval: Duration,
    last_sent: Instant,
    /// When the next frame is wanted, even without input.
    repaint_at: Option<Instant>,
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

impl EventLoop {
    pub(super) fn new(mut window: minifb::Window, title: String, exit: &WindowExit) -> Self {
        let keys = KeyQueue::default();
        window.set_input_callback(Box::new(keys.clone()));
        window.set_target_fps(0);
        let (sender, events) = channel();
        exit.wakes(sender.clone());
        let context = egui::Context::default();
        // The application sets the size of widgets.
        context.options_mut(|options| options.zoom_with_keyboard = false);
        let (own, waker) = (std::thread::current().id(), sender.clone());
        context.set_request_repaint_callback(move |wish| {
            if let Some(at) = Instant::now().checked_add(wish.delay) {
                let _ = waker.send(LoopEvent::Repaint { at, own: std::thread::current().id() == own });
            }
        });
        let display = u32::try_from(window.get_window_handle() as usize).ok().and_then(|handle| Display::open(handle, sender));
        let now = Instant::now();
        Self {
            window,
            display,
            polled: PolledPointer::default(),
            events,
            keys,
            keyboard: Keyboard::default(),
            clipboard: Clipboard::default(),
            input_queue: InputQueue::default(),
            hovered_files: Vec::new(),
            dropped_files: Vec::new(),
            context,
            painter: Painter::new(),
            title,
            size: [0, 0],
            active: false,
            typed: false,
            focused: true,
            hidden: false,
            send_all: true,
            started: now,
            last_input: now,
            last_frame: now,
            motion_interval: MIN_MOTION_INTERVAL,
            last_sent: now,
            repaint_at: Some(now),
            exit: exit.clone(),
            display_lost: false,
        }
    }

    pub(super) fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Waits for events, and runs a frame if one is needed. Returns why the loop ends, if it does.
    pub(super) fn run_once(&mut self, app: &mut dyn WindowApp) -> Option<Ending> {
        let events = self.wait();
        if events.contains(&LoopEvent::Broken) {
            self.lose_connection();
        }
        if self.display_lost {
            return Some(Ending::DisplayLost);
        }
        self.window.update();
        if !self.window.is_open() || self.exit.is_wanted() {
            return Some(Ending::Closed);
        }
        let scale = valid_scale(app.scale()) * self.context.zoom_factor();
        self.queue_input(events, scale);
        self.update_window_state();
        if self.next_frame_time().is_some_and(|at| at <= Instant::now()) {
            return (!self.frame(app)).then_some(Ending::Closed);
        }
        if self.send_all || (self.display.is_none() && self.last_sent.elapsed() > RESEND_INTERVAL) {
            self.present(&[self.full_region()]);
        }
        None
    }

    /// Continues without the second connection, if the display still exists.
    fn lose_connection(&mut self) {
        self.display = None;
        self.display_lost |= display::is_gone();
    }

    /// When the next frame starts.
    fn next_frame_time(&self) -> Option<Instant> {
        let now = Instant::now();
        let seen = if self.input_queue.is_urgent() {
            Some(now)
        } else {
            (!self.input_queue.is_empty()).then(|| self.last_frame + self.motion_interval)
        };
        seen.into_iter().chain(self.repaint_at).min()
    }

    /// Sleeps until there is something to do.
    fn wait(&self) -> Vec<LoopEvent> {
        let now = Instant::now();
        let rest =
            if self.display.is_some() && now.duration_since(self.last_input) > ACTIVE_PERIOD { POLL_IDLE } else { POLL_ACTIVE };
        let until = self.next_frame_time().map_or(rest, |at| at.saturating_duration_since(now).min(rest));
        let first = if self.keys.is_empty() && !until.is_zero() { self.events.recv_timeout(until).ok() } else { None };
        first.into_iter().chain(self.events.try_iter()).collect()
    }

    /// Puts pointer and keyboard input into one order.
    fn queue_input(&mut self, events: Vec<LoopEvent>, scale: f32) {
        let keys = self.keys.take();
        if !events.is_empty() || !keys.is_empty() {
            self.last_input = Instant::now();
        }
        // Both connections report keys. If the counts agree, it is known between which clicks they were typed.
        let is_key = |input: &KeyInput| matches!(input, KeyInput::Key(..));
        let known =
            keys.iter().filter(|input| is_key(input)).count() == events.iter().filter(|event| **event == LoopEvent::Key).count();
        let mut keys = keys.into_iter().peekable();
        for event in events {
            match event {
                LoopEvent::Pointer(pointer, modifiers, at) => self.pointer(pointer, modifiers, at, scale),
                LoopEvent::Key if known => {
                    while let Some(input) = keys.next() {
                        self.key(input);
                        if keys.peek().is_some_and(is_key) {
                            break;
                        }
                    }
                }
                LoopEvent::Exposed => self.send_all = true,
                LoopEvent::Mapped(mapped) => {
                    self.hidden = !mapped;
                    self.send_all |= mapped;
                }
                LoopEvent::Repaint { at, own } => {
                    let at = if own { at.max(self.last_frame + MIN_REPAINT_INTERVAL) } else { at };
                    self.repaint_at = self.repaint_at.into_iter().chain([at]).min();
                }
                LoopEvent::Files(files) => self.files(files, scale),
                LoopEvent::Key | LoopEvent::Other | LoopEvent::Close | LoopEvent::Broken => {}
            }
        }
        keys.for_each(|input| self.key(input));
        if self.display.is_none() {
            let modifiers = self.keyboard.modifiers();
            for pointer in self.polled.poll(&self.window) {
                self.last_input = Instant::now();
                self.pointer(pointer, modifiers, Instant::now(), scale);
            }
        }
    }

    fn key(&mut self, input: KeyInput) {
        self.typed = true;
        let mut told = Vec::new();
        self.keyboard.handle(input, &mut self.clipboard, &mut told);
        told.into_iter().for_each(|event| self.input_queue.push(event, Instant::now()));
    }

    fn pointer(&mut self, pointer: PointerInput, modifiers: egui::Modifiers, at: Instant, scale: f32) {
        if let Some(event) = self.keyboard.sync_modifiers(modifiers) {
            self.input_queue.push(event, at);
        }
        let point = |[x, y]: [f32; 2]| egui::pos2(x, y) / scale;
        let event = match pointer {
            PointerInput::Moved(position) => Event::PointerMoved(point(position)),
            PointerInput::Left => Event::PointerGone,
            PointerInput::Button { at, button, pressed } => Event::PointerButton { pos: point(at), button, pressed, modifiers },
            PointerInput::Wheel(notches) => Event::MouseWheel {
                unit: egui::MouseWheelUnit::Line,
                delta: notches.into(),
                phase: egui::TouchPhase::Move,
                modifiers,
            },
        };
        self.input_queue.push(event, at);
    }

    /// Notes what is dragged over the window. A frame follows.
    fn files(&mut self, files: FilesInput, scale: f32) {
        match files {
            FilesInput::Moved([x, y]) => {
                self.input_queue.push(Event::PointerMoved(egui::pos2(x, y) / scale), Instant::now());
            }
            FilesInput::Hovered(paths) => {
                let file = |path| HoveredFile { path: Some(path), ..HoveredFile::default() };
                // Files of unknown names are files too.
                self.hovered_files =
                    if paths.is_empty() { vec![HoveredFile::default()] } else { paths.into_iter().map(file).collect() };
            }
            FilesInput::Left => {
                self.hovered_files.clear();
                self.input_queue.push(Event::PointerGone, Instant::now());
            }
            FilesInput::Dropped(paths) => {
                self.hovered_files.clear();
                self.dropped_files.extend(paths.into_iter().map(DroppedPath::handle));
            }
        }
        self.repaint_at = Some(Instant::now());
    }

    /// Updates size and focus, for which minifb gives no events.
    fn update_window_state(&mut self) {
        let (width, height) = self.window.get_size();
        if self.size != [width, height] {
            self.size = [width, height];
            self.send_all = true;
            self.repaint_at = Some(Instant::now());
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
            told.into_iter().for_each(|event| self.input_queue.push(event, Instant::now()));
        }
    }

    /// Runs and shows a frame. Returns false if the window should close.
    fn frame(&mut self, app: &mut dyn WindowApp) -> bool {
        let start = Instant::now();
        self.last_frame = start;
        self.repaint_at = self.repaint_at.filter(|repaint_at| *repaint_at > start);
        let mut motion = None;
        let mut closes = false;
        let mut output = loop {
            let frame_input = self.input_queue.next_frame();
            motion = motion.or(frame_input.motion);
            let input = self.input(frame_input.events, valid_scale(app.scale()));
            let mut output = self.context.run_ui(input, |ui| app.ui(ui));
            self.painter.update_textures(&mut output.textures_delta);
            closes |= self.handle_output(&mut output);
            if self.input_queue.is_empty() {
                break output;
            }
        };
        let widgets = self.context.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let background = self.context.global_style().visuals.panel_fill.to_array();
        let laid_out = Instant::now();

        self.motion_interval = if app.follows_slowly() { SLOW_MOTION_INTERVAL } else { MIN_MOTION_INTERVAL };
        let picture = app.picture();
        let version = picture.as_ref().map(|picture| picture.version);
        let frame = PaintInput {
            size: self.size,
            scale: output.pixels_per_point,
            background: u32::from_be_bytes([0, background[0], background[1], background[2]]),
            widgets: &widgets,
            picture,
        };
        let changed = self.painter.paint(&frame).to_vec();
        let painted = Instant::now();

        let presents = !self.hidden && (self.send_all || !changed.is_empty());
        if presents {
            self.present(&if self.send_all { vec![self.full_region()] } else { changed });
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
            self.update_title(app);
        }
        !closes && !app.wants_close()
    }

    fn input(&mut self, events: Vec<Event>, scale: f32) -> RawInput {
        let size = egui::vec2(self.size[0] as f32, self.size[1] as f32) / (scale * self.context.zoom_factor());
        let mut input = RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            max_texture_side: Some(1 << 13),
            time: Some(self.started.elapsed().as_secs_f64()),
            events,
            focused: self.focused,
            hovered_files: self.hovered_files.clone(),
            dropped_files: std::mem::take(&mut self.dropped_files),
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
    fn handle_output(&mut self, output: &mut FullOutput) -> bool {
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
            self.repaint_at = self.repaint_at.into_iter().chain([at.max(self.last_frame + MIN_REPAINT_INTERVAL)]).min();
        }
        let commands = &root.commands;
        if commands.contains(&ViewportCommand::RequestPaste)
            && let Some(text) = self.clipboard.text()
        {
            self.input_queue.push(Event::Paste(text), Instant::now());
        }
        commands.contains(&ViewportCommand::Close)
    }

    fn update_title(&mut self, app: &dyn WindowApp) {
        let title = printable(&app.title());
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
    }

    fn full_region(&self) -> PixelRect {
        let [right, bottom] = self.painter.size().map(|side| side as i32);
        PixelRect { left: 0, top: 0, right, bottom }
    }

    /// Sends changed regions to the display.
    fn present(&mut self, changed: &[PixelRect]) {
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
        self.send_all = false;
        self.last_sent = Instant::now();
    }
}

/// A valid scale for widgets.
fn valid_scale(scale: f32) -> f32 {
    if scale.is_finite() { scale.clamp(0.5, 4.0) } else { 1.0 }
}
