//! The real window on a virtual screen (Xvfb), driven by xdotool. It covers what tests of the widgets cannot see.
#![cfg(target_os = "linux")]
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod clicks;
mod drops;
mod looks;

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A screen with the window on it.
struct Screen {
    display: String,
    server: Child,
    window: Child,
    /// The lines of the window's log.
    log: Arc<Mutex<Vec<String>>>,
    home: tempfile::TempDir,
}

impl Screen {
    fn new(session: &str) -> Self {
        Self::with(session, &[])
    }

    /// A desktop with these further arguments for the display server. Without a name, the session is that of the start.
    fn with(session: &str, told: &[&str]) -> Self {
        Self::prepared(session, told, |_| ())
    }

    /// The same, with what is prepared in the working directory.
    fn prepared(session: &str, told: &[&str], prepare: impl FnOnce(&std::path::Path)) -> Self {
        // The server chooses a free number and reports it when it accepts connections. It keeps running without
        // clients.
        let mut server = Command::new("Xvfb");
        let server = server.args(["-displayfd", "1", "-noreset", "-screen", "0", "1300x820x24"]).args(told);
        let mut server = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("Xvfb, of Debian's package xvfb");
        let mut number = String::new();
        BufReader::new(server.stdout.take().expect("a pipe")).read_line(&mut number).expect("a number");
        let display = format!(":{}", number.trim());
        let home = tempfile::tempdir().expect("a folder");
        // Pictures of one pass: they are the same each time that they are taken.
        let configuration = home.path().join("configuration");
        std::fs::create_dir_all(&configuration).expect("a folder");
        std::fs::write(configuration.join("settings.toml"), "version = 1\nsamples = 1\n").expect("a file");
        prepare(home.path());
        let mut window = Command::new(env!("CARGO_BIN_EXE_illuminator"));
        let named = (!session.is_empty()).then_some(session);
        let window = window.args(["preview", "--log"]).args(named).env("DISPLAY", &display).env("ILLUMINATOR_HOME", home.path());
        let mut window = window.current_dir(home.path()).stderr(Stdio::piped()).spawn().expect("the program");
        let log = Arc::new(Mutex::new(Vec::new()));
        let (told, lines) = (window.stderr.take().expect("a pipe"), Arc::clone(&log));
        std::thread::spawn(move || {
            for line in BufReader::new(told).lines().map_while(Result::ok) {
                lines.lock().expect("lines").push(line);
            }
        });
        let screen = Self { display, server, window, log, home };
        wait("the window", || screen.window_id().is_some());
        screen
    }

    fn run(&self, program: &str, arguments: &[&str]) -> Vec<u8> {
        let output = Command::new(program).args(arguments).env("DISPLAY", &self.display).output();
        output.unwrap_or_else(|error| panic!("{program}: {error}")).stdout
    }

    fn window_id(&self) -> Option<String> {
        let found = self.run("xdotool", &["search", "--name", "Illuminator"]);
        let found = String::from_utf8_lossy(&found).lines().next().map(str::to_owned);
        found.filter(|id| !id.is_empty())
    }

    /// The position of the window on the screen.
    fn corner(&self) -> [i32; 2] {
        let id = self.window_id().expect("a window");
        let told = self.run("xdotool", &["getwindowgeometry", "--shell", &id]);
        let told = String::from_utf8_lossy(&told).into_owned();
        ["X=", "Y="].map(|name| {
            let line = told.lines().find_map(|line| line.strip_prefix(name)).expect("a position");
            line.parse().expect("a number")
        })
    }

    fn title(&self) -> String {
        let id = self.window_id().expect("a window");
        String::from_utf8_lossy(&self.run("xdotool", &["getwindowname", &id])).trim().to_owned()
    }

    /// How many lines of the log contain this.
    fn told(&self, part: &str) -> usize {
        self.log.lock().expect("lines").iter().filter(|line| line.contains(part)).count()
    }

    fn mouse(&self, at: [i32; 2]) {
        let corner = self.corner();
        let [x, y] = [0, 1].map(|axis| (corner[axis] + at[axis]).to_string());
        self.run("xdotool", &["mousemove", &x, &y]);
    }

    /// The pixels of a part of the window with this position and size.
    fn pixels(&self, [x, y]: [i32; 2], [width, height]: [i32; 2]) -> Vec<u8> {
        let corner = self.corner();
        let part = format!("{width}x{height}+{}+{}", corner[0] + x, corner[1] + y);
        let picture = self.run("import", &["-window", "root", "-crop", &part, "-depth", "8", "rgb:-"]);
        assert_eq!(picture.len(), (width * height * 3) as usize, "a screenshot, by ImageMagick");
        picture
    }

    /// Whether the full picture is traced and evaluated.
    fn is_traced_in_full(&self) -> bool {
        let log = self.log.lock().expect("lines");
        let mut after = log.iter().skip_while(|line| !line.starts_with("traced ") || line.starts_with("traced coarsely"));
        after.any(|line| line.starts_with("ready in"))
    }

    /// The picture, once it is complete, has several colours, and no longer changes.
    fn picture_at_rest(&self) -> Vec<u8> {
        wait("all pixels", || self.is_traced_in_full());
        let mut before = Vec::new();
        wait("the picture", || {
            let now = self.pixels(PICTURE.0, PICTURE.1);
            let colours = now.chunks_exact(3).collect::<std::collections::HashSet<&[u8]>>().len();
            let rests = now == before;
            before = now;
            rests && colours > 100
        });
        before
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        for child in [&mut self.window, &mut self.server] {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Waits until a condition holds.
fn wait(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(60), "{what} did not come");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// A part of the picture, between the panels.
const PICTURE: ([i32; 2], [i32; 2]) = ([500, 200], [350, 400]);

#[test]
fn the_window_follows_the_mouse_and_the_keyboard() {
    let mut screen = Screen::new("preset:studio");
    let before = screen.picture_at_rest();
    assert!(!screen.title().contains('•'), "nothing was changed yet");
    // The slider of ka, the first one of the scene, is dragged to its end. The whole picture becomes brighter.
    screen.mouse([1100, 368]);
    screen.run("xdotool", &["mousedown", "1"]);
    for x in (1100..1190).step_by(10) {
        screen.mouse([x, 368]);
    }
    let sum = |pixels: &[u8]| pixels.iter().map(|byte| u64::from(*byte)).sum::<u64>();
    wait("a brighter picture", || sum(&screen.pixels(PICTURE.0, PICTURE.1)) > sum(&before) * 11 / 10);
    screen.run("xdotool", &["mouseup", "1"]);
    assert!(!screen.title().is_empty());
    // Ten fast clicks on "Apply formula": none is lost, none counts twice.
    let applied = screen.told("read in");
    screen.mouse([247, 34]);
    screen.run("xdotool", &["click", "--repeat", "10", "--delay", "12", "1"]);
    wait("ten clicks", || screen.told("read in") == applied + 10);
    // The session is saved under a typed name.
    screen.run("xdotool", &["key", "ctrl+shift+s"]);
    std::thread::sleep(Duration::from_millis(500));
    screen.run("xdotool", &["type", "--delay", "20", "brighter"]);
    screen.run("xdotool", &["key", "Return"]);
    let saved = screen.home.path().join("brighter.toml");
    wait("a saved session", || std::fs::read_to_string(&saved).is_ok_and(|text| text.contains("ka =")));
    wait("the name in the title", || screen.title().contains("brighter.toml"));
    // A wrong formula is marked at once, and the title shows that it is unsaved.
    screen.mouse([200, 500]);
    screen.run("xdotool", &["click", "1"]);
    screen.run("xdotool", &["key", "ctrl+End"]);
    screen.run("xdotool", &["type", "--delay", "20", "= N"]);
    wait("the mark of unsaved text", || screen.title().contains('•'));
    let marked =
        |pixels: &[u8]| pixels.chunks_exact(3).filter(|pixel| pixel[0] > 200 && pixel[1] < 110 && pixel[2] < 110).count();
    wait("a red mark beside the line", || marked(&screen.pixels([0, 60], [60, 600])) > 5);
    // The window quits with unsaved text. The text is kept for the next start.
    screen.run("xdotool", &["key", "ctrl+q"]);
    let status = screen.window.wait().expect("an end");
    assert!(status.success(), "{status}");
}

#[test]
fn a_formula_of_the_command_line_opens_in_the_built_in_session() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mine.formula");
    std::fs::write(&path, "formula;\n= IL*Cd*max(0, N.L);\n").expect("a file");
    let screen = Screen::new(path.to_str().expect("UTF-8"));
    wait("the formula", || screen.told("mine.formula: read in") == 1);
}

#[test]
fn the_camera_and_a_light_follow_the_mouse_and_one_undo_brings_each_back() {
    let screen = Screen::new("preset:studio");
    let away = [200, 500];
    screen.mouse(away);
    let before = screen.picture_at_rest();
    let shown = |picture: &[u8]| screen.pixels(PICTURE.0, PICTURE.1) == picture;
    let drag = |from: [i32; 2], by: [i32; 2]| {
        screen.mouse(from);
        std::thread::sleep(Duration::from_millis(200));
        screen.run("xdotool", &["mousedown", "1"]);
        for step in 1..=12 {
            screen.mouse([0, 1].map(|axis| from[axis] + by[axis] * step / 12));
        }
        screen.run("xdotool", &["mouseup", "1"]);
        screen.mouse(away);
    };
    drag([640, 380], [140, 30]);
    wait("the log of the orbit", || screen.told("moved the camera:") == 1);
    wait("unsaved text", || screen.title().contains('•'));
    assert!(screen.picture_at_rest() != before);
    // Nothing was clicked that has the keyboard.
    screen.run("xdotool", &["key", "ctrl+z"]);
    wait("the first picture", || shown(&before) && !screen.title().contains('•'));
    // The marker of a light has a colour of its own. It is seen while the pointer is over the picture.
    screen.mouse([640, 380]);
    let (left, top, size) = (410, 60, [580, 700]);
    let mut marker = None;
    wait("the marker of a light", || {
        let pixels = screen.pixels([left, top], size);
        let is_light = |x: i32, y: i32| pixels[(3 * (y * size[0] + x)) as usize..][..3] == [255, 221, 87];
        let mut inner = (2..size[1] - 2).flat_map(|y| (2..size[0] - 2).map(move |x| (x, y)));
        let found = inner.find(|(x, y)| (-2..=2).all(|dy| (-2..=2).all(|dx| is_light(x + dx, y + dy))));
        marker = found.map(|(x, y)| [left + x, top + y]);
        marker.is_some()
    });
    drag(marker.expect("a marker"), [60, 50]);
    let lights = ["key", "fill", "rim"];
    wait("the log of the light", || lights.iter().map(|name| screen.told(&format!("moved {name}:"))).sum::<usize>() == 1);
    assert!(screen.picture_at_rest() != before);
    screen.run("xdotool", &["key", "ctrl+z"]);
    wait("the first picture again", || shown(&before) && !screen.title().contains('•'));
}

/// Types into the formula of a window and ends it at once. Returns the exit status and the text of the draft.
fn typed_and_ended(end: impl FnOnce(&mut Screen)) -> (std::process::ExitStatus, String) {
    let mut screen = Screen::new("preset:studio");
    screen.picture_at_rest();
    screen.mouse([200, 500]);
    screen.run("xdotool", &["click", "1"]);
    screen.run("xdotool", &["key", "ctrl+End"]);
    wait("the mark of unsaved text", || {
        screen.run("xdotool", &["type", "x"]);
        screen.title().contains('•')
    });
    // The text so far is saved after two seconds. The text typed now is newer than that when the window ends.
    std::thread::sleep(Duration::from_millis(2500));
    screen.run("xdotool", &["type", "--delay", "1", "typed at last"]);
    // The keys need time to reach the window, on a busy machine too.
    std::thread::sleep(Duration::from_millis(1000));
    end(&mut screen);
    let status = screen.window.wait().expect("an end");
    let mut drafts = Vec::new();
    for folder in std::fs::read_dir(screen.home.path().join("state/drafts")).expect("drafts") {
        drafts.push(std::fs::read_to_string(folder.expect("a folder").path().join("0.toml")).expect("a draft"));
    }
    assert_eq!(drafts.len(), 1);
    (status, drafts.concat())
}

#[test]
fn a_signal_or_the_loss_of_the_display_costs_nothing_that_was_typed() {
    let (status, draft) = typed_and_ended(|screen| {
        let id = screen.window.id().to_string();
        assert!(Command::new("kill").arg(id).status().expect("kill").success());
    });
    assert_eq!(std::os::unix::process::ExitStatusExt::signal(&status), Some(15), "{status}");
    assert!(draft.contains("typed at last"), "{draft}");
    let (status, draft) = typed_and_ended(|screen| screen.server.kill().expect("the server"));
    assert_eq!(status.code(), Some(1), "{status}");
    assert!(draft.contains("typed at last"), "{draft}");
    // The display closes the connection of the window, as with `xkill`. Xlib then ends the program.
    let (status, draft) = typed_and_ended(|screen| {
        let id = screen.window_id().expect("a window");
        screen.run("xdotool", &["windowkill", &id]);
    });
    assert_eq!(status.code(), Some(1), "{status}");
    assert!(draft.contains("typed at last"), "{draft}");
}

#[test]
fn a_display_that_shares_no_memory_shows_the_same() {
    let screens = [&[][..], &["-extension", "MIT-SHM"]].map(|told| Screen::with("preset:studio", told));
    // A slow window shows the coarse picture for some time.
    let mut shown = [vec![], vec![]];
    wait("the same picture", || {
        shown = screens.each_ref().map(Screen::picture_at_rest);
        shown[0] == shown[1]
    });
    // The shared memory of the pixels is a file in memory.
    let shares = screens.each_ref().map(|screen| {
        let files = std::fs::read_dir(format!("/proc/{}/fd", screen.window.id())).expect("open files");
        let mut names = files.filter_map(|file| std::fs::read_link(file.ok()?.path()).ok());
        names.any(|name| name.starts_with("/dev/shm"))
    });
    assert_eq!(shares, [true, false]);
    // A dragged slider changes parts of the window.
    for screen in &screens {
        screen.mouse([1100, 368]);
        screen.run("xdotool", &["mousedown", "1"]);
        for x in (1100..1180).step_by(8) {
            screen.mouse([x, 368]);
            // A slow window would see the whole drag at once, and draw no picture of it.
            std::thread::sleep(Duration::from_millis(50));
        }
        screen.run("xdotool", &["mouseup", "1"]);
        wait("the end of the drag", || screen.told("dragged ka") > 0);
    }
    wait("the same picture after the drag", || {
        let dragged = screens.each_ref().map(Screen::picture_at_rest);
        dragged[0] == dragged[1] && dragged[0] != shown[0]
    });
}

#[test]
fn a_session_with_a_wrong_formula_is_open_and_can_be_mended() {
    let screen = Screen::prepared("own.toml", &[], |folder| {
        let session =
            "version = 1\nformula = \"own.formula\"\nscene = \"preset:studio\"\n[bodies.ball]\nCd = [1, 0, 0]\nkq = 0.5\n";
        std::fs::write(folder.join("own.toml"), session).expect("a session");
        std::fs::write(folder.join("own.formula"), "formula;\n= IL*Cd*max(0, N.Lx);\n").expect("a formula");
    });
    wait("what is wrong", || screen.told("The session own.toml is open with mistakes") == 1);
    assert!(screen.title().contains("own.toml") && !screen.title().contains('•'), "{}", screen.title());
    let plain = screen.picture_at_rest();
    let marked =
        |pixels: &[u8]| pixels.chunks_exact(3).filter(|pixel| pixel[0] > 200 && pixel[1] < 110 && pixel[2] < 110).count();
    wait("a red mark beside the line", || marked(&screen.pixels([0, 60], [60, 600])) > 5);
    // The text is typed again, with a parameter whose value the session has.
    screen.mouse([200, 400]);
    screen.run("xdotool", &["click", "1"]);
    screen.run("xdotool", &["key", "ctrl+a"]);
    screen.run("xdotool", &["type", "--delay", "20", "body_specific; kq: scalar; formula; = kq*IL*Cd*max(0, N.L);"]);
    screen.run("xdotool", &["key", "ctrl+Return"]);
    wait("the applied formula", || screen.told("read in") == 1);
    wait("another picture", || screen.pixels(PICTURE.0, PICTURE.1) != plain);
}

#[test]
fn without_a_display_one_line_says_what_works() {
    let mut program = Command::new(env!("CARGO_BIN_EXE_illuminator"));
    let output = program.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").output().expect("the program");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.lines().count() == 1 && told.contains("render"), "{told}");
}
