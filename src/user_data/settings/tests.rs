//! Settings read, saved, damaged, and kept by several programs at once.

use super::*;
use crate::formula::Formula;
use crate::scene::Scene;
use crate::user_data::folders::Folders;
use crate::workspace::values::Values;
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

const TEXT: &str = r#"version = 1
shadows = false
depth = 3
size = [1280, 720]
ior = 1.25
srgb = false
samples = 64
backend = "interpreter"
memory = 2048
startup = "preset:glass"

[defaults]
Cd = [0.9, 0.2, 0.1]
ka = 0
background = [0, 0, 0.25]

[window]
theme = "light"
scale = 1.5
apply_as_you_type = true
gallery = false
log = true
instruments = true
instruments_at = "right"
size = [1920, 1080]
owners_height = 300
"#;

fn parse(text: &str) -> (Settings, Vec<String>) {
    let (settings, diagnostics) = Settings::parse(&Source::new("settings.toml", text));
    (settings, diagnostics.iter().map(|diagnostic| diagnostic.message().to_owned()).collect())
}

/// A home with a settings file of this text.
fn home(text: &[u8]) -> (tempfile::TempDir, Folders) {
    let home = tempfile::tempdir().unwrap();
    let folders = Folders::below(home.path());
    fs::create_dir(&folders.configuration).unwrap();
    fs::write(folders.configuration.join("settings.toml"), text).unwrap();
    (home, folders)
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn settings_are_read() {
    let (settings, messages) = parse(TEXT);
    assert_eq!(messages, [""; 0]);
    let picture =
        PictureSettings { size: [1280, 720], depth: 3, shadows: false, default_index: 1.25, ..PictureSettings::default() };
    assert_eq!(settings.picture(), picture);
    assert_eq!(settings.startup, Location::new("preset:glass"));
    assert_eq!((settings.samples, settings.backend, settings.memory), (64, crate::backends::REFERENCE, Some(2048)));
    assert_eq!(settings.defaults.of(Predefined::BodyColour), [0.9, 0.2, 0.1]);
    assert_eq!(settings.defaults.of(Predefined::Ambient), [0.0]);
    assert_eq!(settings.defaults.of(Predefined::Background), [0.0, 0.0, 0.25]);
    assert_eq!(settings.defaults.of(Predefined::Intensity), [1.0]);
    let mut panels = PanelSizes::default();
    panels.set(PanelSide::Owners, 300.0);
    let (theme, size) = (ThemeSetting::Light, [1920, 1080]);
    let (apply_as_you_type, gallery, log, instruments) = (true, false, true, true);
    let window = WindowSettings {
        theme,
        scale: 1.5,
        apply_as_you_type,
        gallery,
        log,
        instruments,
        instruments_at: InstrumentDock::Right,
        size,
        panels,
    };
    assert_eq!(settings.window, window);
}

#[test]
fn what_is_not_said_is_as_by_default() {
    assert_eq!(parse("version = 1"), (Settings::default(), vec![]));
    let picture = PictureSettings { view: Transfer::Srgb.into(), ..PictureSettings::default() };
    assert_eq!(Settings::default().picture(), picture);
    assert_eq!(parse("version = 1\nmemory = 0").0.memory, None);
    assert_eq!(parse("\u{feff}version = 1\r\ndepth = 2\r\n").0.depth, 2);
    assert!(
        ThemeSetting::System.is_dark(None)
            && !ThemeSetting::System.is_dark(Some(false))
            && !ThemeSetting::Light.is_dark(Some(true))
    );
}

#[test]
fn what_is_out_of_range_is_the_nearest_that_is_within() {
    let text = "version = 1\ndepth = 99999999999999999999\nsize = [0, 40000]\nior = -1\nsamples = 0\n[defaults]\nkr = 2\n\
                Cd = [0.5, -1, 3]\n[window]\nscale = 0.1\nsize = [1, 800]\ntexts_width = 9e9\n";
    let (settings, messages) = parse(text);
    assert_eq!(
        messages,
        [
            "99999999999999999999 is out of range; 9 is used",
            "0 is out of range; 1 is used",
            "40000 is out of range; 32768 is used",
            "the refractive index -1 is not positive; 1.5 is used",
            "0 is out of range; 1 is used",
            "2 is out of range; 1 is used",
            "-1 is out of range; 0 is used",
            "3 is out of range; 1 is used",
            "0.1 is out of range; 0.5 is used",
            "1 is out of range; 320 is used",
            "9000000000 is out of range; 4000 is used",
        ]
    );
    assert_eq!((settings.depth, settings.size, settings.default_index, settings.samples), (9, [1, 32_768], 1.5, 1));
    assert_eq!(settings.defaults.of(Predefined::BodyColour), [0.5, 0.0, 1.0]);
    let (_, diagnostics) = Settings::parse(&Source::new("s", text));
    assert!(!diagnostics.has_errors(), "warnings alone");
}

#[test]
fn what_is_wrong_is_reported_and_the_rest_is_taken() {
    let text = "version = 1\nshadows = 0\ndepth = 2.5\nsize = 3\nior = nan\nstartup = \" \"\n[defaults]\nkr = [1, 1, 1]\n\
                Cd = 1\nka = \"x\"\nkt = 0.5\n[window]\ntheme = \"drak\"\ninstruments_at = \"left\"\nlog = true\n";
    let (settings, messages) = parse(text);
    assert_eq!(
        messages,
        [
            "expected `true` or `false`, found a whole number",
            "expected a whole number from 1 to 9, found a number",
            "expected width and height, `[640, 480]`, found a whole number",
            "this number is too large or not finite",
            "the path of the session is empty",
            "`kr` is a scalar",
            "`Cd` is a vector",
            "expected a number, or three as `[x, y, z]`, found a text",
            "there is no theme \"drak\"",
            "the instruments cannot be at \"left\"",
        ]
    );
    assert_eq!(settings.defaults.of(Predefined::Refraction), [0.5]);
    assert!(settings.window.log);
    assert_eq!(parse("version = 1\nwindow = 3\ndefaults = []").1.len(), 2);
    assert_eq!(parse("version = 2\ndepth = 3"), (Settings::default(), vec!["version 2 of this file cannot be read".to_owned()]));
    assert_eq!(parse("depth = 3").1, ["the file has no version"]);
    assert_eq!(parse("depth = ").0, Settings::default());
}

#[test]
fn a_new_session_begins_with_the_chosen_defaults() {
    let formula = "body_specific; kd: scalar, constraint 0..1, default 0.5; invariants; kr + kt = 1; formula; = kd*Cd;";
    let scene = "bodies; ball: sphere, center <0,0,0>, radius 1; wall: sphere, center <9,0,0>, radius 1, matte;
                 lights; key: point, <9,9,9>; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    let formula = Formula::parse(&Source::new("f", formula)).unwrap().0;
    let scene = Scene::parse(&Source::new("s", scene)).unwrap().0;
    let table = ParameterTable::new(&formula, &scene);
    let mut settings = Settings::default();
    assert_eq!(settings.initial_values(&table), []);
    settings.defaults.set(Predefined::BodyColour, [0.1, 0.2, 7.0]);
    settings.defaults.set(Predefined::Reflection, [0.25, f32::NAN, f32::NAN]);
    settings.defaults.set(Predefined::Refraction, [0.5; 3]);
    settings.defaults.set(Predefined::Ambient, [f32::NAN; 3]);
    settings.defaults.set(Predefined::Background, [0.0, 0.0, 1.0]);
    let (values, warnings) = Values::new(&formula, &scene, &settings.initial_values(&table));
    assert_eq!(warnings, []);
    let shown: Vec<String> = values
        .iter()
        .filter(|(owner, id, _)| {
            ["ball.Cd", "ball.kr", "ball.kt", "wall.kr", "wall.Cd", "ka", "background"]
                .contains(&table.label(*owner, *id).as_str())
        })
        .map(|(owner, id, value)| format!("{}={value:?}", table.label(owner, id)))
        .collect();
    assert_eq!(
        shown,
        [
            "ka=[0.1]",
            "background=[0.0, 0.0, 1.0]",
            "ball.Cd=[0.1, 0.2, 1.0]",
            "ball.kr=[0.25]",
            "ball.kt=[0.75]",
            "wall.Cd=[0.1, 0.2, 1.0]",
            "wall.kr=[0.0]",
        ]
    );
}

#[test]
fn no_file_means_defaults_and_is_made_when_saved() {
    let home = tempfile::tempdir().unwrap();
    let folders = Folders::below(&home.path().join("not/there/yet"));
    let mut file = SettingsFile::new(&folders);
    let reading = file.read();
    assert_eq!((&reading.settings, reading.diagnostics.len()), (&Settings::default(), 0));
    assert!(!folders.configuration.exists(), "reading makes nothing");
    let settings = Settings { depth: 7, ..reading.settings };
    assert_eq!(file.save(&settings).unwrap(), None);
    assert_eq!(SettingsFile::new(&folders).read().settings, settings);
    assert_eq!(names(&folders.configuration), ["settings.toml"]);
    fs::remove_dir_all(&folders.configuration).unwrap();
    file.save(&settings).unwrap();
    assert_eq!(SettingsFile::new(&folders).read().settings, settings, "all of it again where the folder was taken away");
}

#[test]
fn a_damaged_file_is_kept_aside() {
    let huge = vec![b' '; crate::lang::source::MAX_BYTES + 1];
    for damaged in [b"depth = [".as_slice(), b"version = 1\ndepth = \xff", b"version = 1\ndepth = true", b"version = 2", &huge] {
        let (_home, folders) = home(damaged);
        let mut file = SettingsFile::new(&folders);
        let reading = file.read();
        assert_eq!(reading.settings, Settings::default());
        let told = format!("{:#}", reading.diagnostics.located(&reading.source));
        assert!(reading.diagnostics.has_errors() && told.contains("settings.toml.damaged`"), "{told}");
        let settings = Settings { shadows: false, ..reading.settings };
        let renamed = file.save(&settings).unwrap().expect("renamed and kept");
        assert_eq!(fs::read(&renamed).unwrap(), damaged);
        assert_eq!(names(&folders.configuration), ["settings.toml", "settings.toml.damaged"]);
        assert_eq!(file.read().settings, settings);
        assert_eq!(file.save(&settings).unwrap(), None);
        // Damaged again, while the program runs: what it has is not lost, nor is what was kept renamed before.
        fs::write(file.path(), "again = ").unwrap();
        let renamed = file.save(&settings).unwrap().unwrap();
        assert!(renamed.ends_with("settings.toml.damaged-2"));
        assert_eq!(file.read().settings, settings);
    }
}

#[test]
fn a_folder_in_place_of_the_file_is_reported_and_kept_aside() {
    let home = tempfile::tempdir().unwrap();
    let folders = Folders::below(home.path());
    fs::create_dir_all(folders.configuration.join("settings.toml/inside")).unwrap();
    let mut file = SettingsFile::new(&folders);
    let reading = file.read();
    assert!(reading.diagnostics.located(&reading.source).to_string().contains("is a folder"));
    assert!(file.save(&reading.settings).unwrap().unwrap().join("inside").is_dir());
}

#[test]
fn what_cannot_be_saved_is_reported_and_harms_nothing() {
    let home = tempfile::tempdir().unwrap();
    fs::write(home.path().join("configuration"), "a file").unwrap();
    let mut file = SettingsFile::new(&Folders::below(home.path()));
    assert!(file.read().diagnostics.has_errors());
    let error = file.save(&Settings::default()).unwrap_err();
    assert!(error.message().starts_with("cannot save the settings in `"), "{}", error.message());
    assert!(!error.hints().is_empty());
    assert_eq!(fs::read_to_string(home.path().join("configuration")).unwrap(), "a file");
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_keeps_what_it_has() {
    use std::os::unix::fs::PermissionsExt;
    for text in [TEXT, "damaged ="] {
        let (_home, folders) = home(text.as_bytes());
        let permit = |mode| fs::set_permissions(&folders.configuration, fs::Permissions::from_mode(mode)).unwrap();
        permit(0o500);
        // The superuser may write anywhere.
        let is_refused = tempfile::tempfile_in(&folders.configuration).is_err();
        let mut file = SettingsFile::new(&folders);
        let mut settings = file.read().settings;
        settings.depth = 8;
        let outcome = file.save(&settings);
        permit(0o700);
        assert_eq!(outcome.is_err(), is_refused);
        if is_refused {
            assert!(outcome.unwrap_err().message().contains("permission denied"));
            assert_eq!(fs::read_to_string(file.path()).unwrap(), text);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_system_that_takes_no_files_is_reported() {
    let mut file = SettingsFile::new(&Folders::below(Path::new("/proc/illuminator")));
    assert_eq!(file.read().settings, Settings::default());
    assert!(file.save(&Settings::default()).is_err());
}

#[test]
fn what_means_nothing_stays_in_the_file() {
    let text = TEXT
        .replace("depth = 3\n", "depth = 3\ndept = 4\nfuture = { a = [1, 2] }\nwhen = 2020-01-01\n")
        .replace("[defaults]\n", "[defaults]\nkx = [1, 2]\n")
        + "glow = 0.5\n[[list]]\nx = 1\n";
    let (_home, folders) = home(text.as_bytes());
    let mut file = SettingsFile::new(&folders);
    let reading = file.read();
    let messages: Vec<&str> = reading.diagnostics.iter().map(Diagnostic::message).collect();
    let unknown = |key: &str| format!("`{key}` is unknown here and is ignored");
    assert_eq!(messages, ["dept", "future", "when", "kx", "glow", "list"].map(unknown));
    let settings = Settings { depth: 4, ..reading.settings };
    assert_eq!(file.save(&settings).unwrap(), None);
    let saved = fs::read_to_string(file.path()).unwrap();
    let table: toml::Table = saved.parse().unwrap();
    let old: toml::Table = text.parse().unwrap();
    for key in ["dept", "future", "when", "list"] {
        assert_eq!(table[key], old[key], "{saved}");
    }
    assert_eq!((&table["defaults"]["kx"], &table["window"]["glow"]), (&old["defaults"]["kx"], &old["window"]["glow"]));
    assert_eq!(file.read().settings, settings);
}

#[test]
fn two_programs_keep_each_others_changes() {
    let (_home, folders) = home(TEXT.as_bytes());
    let (mut one, mut other) = (SettingsFile::new(&folders), SettingsFile::new(&folders));
    let (mut first, mut second) = (one.read().settings, other.read().settings);
    first.depth = 9;
    first.defaults.set(Predefined::Reflection, [0.5; 3]);
    one.save(&first).unwrap();
    second.window.theme = ThemeSetting::Dark;
    second.defaults.set(Predefined::Refraction, [0.25; 3]);
    other.save(&second).unwrap();
    first.window.log = false;
    first.window.panels.set(PanelSide::Texts, 500.0);
    one.save(&first).unwrap();
    second.window.panels.set(PanelSide::Owners, 99.0);
    other.save(&second).unwrap();
    let settings = SettingsFile::new(&folders).read().settings;
    assert_eq!((settings.depth, settings.window.theme, settings.window.log), (9, ThemeSetting::Dark, false));
    let sizes = PanelSide::ALL.map(|side| settings.window.panels.get(side));
    assert_eq!(sizes, [500.0, 310.0, 99.0, 240.0, 380.0, 420.0, 380.0, 400.0, 320.0]);
    assert_eq!(settings.defaults.of(Predefined::Reflection), [0.5]);
    assert_eq!(settings.defaults.of(Predefined::Refraction), [0.25]);
}

#[test]
fn a_file_that_says_it_already_is_not_written() {
    let (_home, folders) = home(TEXT.as_bytes());
    let mut file = SettingsFile::new(&folders);
    let settings = file.read().settings;
    file.save(&settings).unwrap();
    let before = fs::metadata(file.path()).unwrap().modified().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(20));
    file.save(&settings).unwrap();
    assert_eq!(fs::metadata(file.path()).unwrap().modified().unwrap(), before);
}

#[test]
fn the_startup_session_is_found_from_anywhere() {
    let (_home, folders) = home(b"version = 1\nstartup = \"mine.toml\"\n");
    let mut file = SettingsFile::new(&folders);
    let mut settings = file.read().settings;
    assert_eq!(settings.startup, Location::File(folders.configuration.join("mine.toml")));
    settings.startup = Location::new("here/a \"b\".toml");
    file.save(&settings).unwrap();
    let absolute = std::path::absolute("here/a \"b\".toml").unwrap();
    assert_eq!(file.read().settings.startup, Location::File(absolute));
}

#[cfg(unix)]
#[test]
fn a_path_that_is_no_text_is_refused() {
    use std::os::unix::ffi::OsStrExt;
    let path = PathBuf::from(std::ffi::OsStr::from_bytes(b"/a\xff"));
    let error = Settings { startup: Location::File(path), ..Settings::default() }.to_toml().unwrap_err();
    assert!(error.message().contains("not UTF-8"));
}

fn any_settings() -> impl Strategy<Value = Settings> {
    let values = proptest::collection::vec(proptest::array::uniform3(any::<f32>()), Predefined::ALL.len());
    let numbers = (any::<u32>(), any::<[u32; 2]>(), any::<f64>(), any::<f32>(), any::<[u32; 2]>());
    (any::<[bool; 7]>(), numbers, "/?[^/\0]{1,12}", proptest::sample::select(ThemeSetting::ALL.to_vec()), values).prop_map(
        |(
            [shadows, apply_as_you_type, log, instruments, gallery, srgb, compiled],
            (depth, size, default_index, scale, window),
            startup,
            theme,
            values,
        )| {
            let mut defaults = Defaults::default();
            for (parameter, value) in Predefined::ALL.iter().zip(values) {
                defaults.set(*parameter, value);
            }
            let mut panels = PanelSizes::default();
            panels.set(PanelSide::Texts, scale * 100.0);
            panels.set(PanelSide::Inspector, scale);
            let size_of_window = window;
            let instruments_at = InstrumentDock::ALL[usize::from(srgb) + usize::from(log)];
            let window = WindowSettings {
                theme,
                scale,
                apply_as_you_type,
                gallery,
                log,
                instruments,
                instruments_at,
                size: size_of_window,
                panels,
            };
            let startup = Location::new(startup);
            let transfer = if srgb { Transfer::Srgb } else { Transfer::Linear };
            let backend = if compiled { DEFAULT } else { crate::backends::REFERENCE };
            let memory = shadows.then_some(depth);
            let samples = size[0];
            Settings { shadows, depth, size, default_index, transfer, samples, backend, memory, startup, defaults, window }
        },
    )
}

proptest! {
    #[test]
    fn what_is_saved_is_read_back(settings in any_settings()) {
        let text = settings.to_toml().unwrap();
        let (again, messages) = parse(&text);
        prop_assert!(messages.is_empty(), "{:?} in\n{}", messages, text);
        let mut expected = settings.within_ranges();
        if let Location::File(path) = &settings.startup {
            expected.startup = Location::File(std::path::absolute(path).unwrap());
        }
        prop_assert_eq!(again, expected);
    }

    #[test]
    fn no_text_is_too_much(text in "\\PC{0,40}|(version = 1\n)?[a-z]{1,8} ?= ?[-\\[\\]{}0-9.\"a-z, ]{0,12}\n\\[window\\]\n(scale|size|log) = .{0,9}") {
        let (settings, _) = parse(&text);
        prop_assert_eq!(&settings.within_ranges(), &settings);
    }
}
