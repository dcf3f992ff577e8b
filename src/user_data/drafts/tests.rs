//! Drafts kept, left behind by programs that end or are killed, taken over and discarded.
//!
//! A lock belongs to whoever opened the file, so two `Drafts` in one program behave like two programs.

use super::*;
use crate::user_data::drafts::text::{read, to_toml};
use proptest::prelude::*;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, UNIX_EPOCH};

fn home() -> (tempfile::TempDir, Folders) {
    let home = tempfile::tempdir().unwrap();
    let folders = Folders::below(home.path());
    (home, folders)
}

fn leftover_drafts(drafts: &Drafts) -> Vec<LeftoverDraft> {
    let (found, diagnostics) = drafts.leftover_drafts();
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    found
}

fn texts(found: &[LeftoverDraft]) -> Vec<&str> {
    let mut texts: Vec<&str> = found.iter().map(|left| left.draft.as_ref().unwrap().text.as_str()).collect();
    texts.sort_unstable();
    texts
}

/// How many folders of programs there are.
fn programs(folders: &Folders) -> usize {
    subfolders(&folders.state.join("drafts")).unwrap().len()
}

#[test]
fn a_text_that_is_saved_leaves_nothing() {
    let (_home, folders) = home();
    let mut drafts = Drafts::new(&folders);
    assert_eq!(leftover_drafts(&drafts), []);
    assert!(!folders.state.exists(), "nothing is made before there is something to keep");
    drafts.remove(0).unwrap();
    drafts.keep(0, FileKind::Formula, None, None, "one").unwrap();
    drafts.remove(0).unwrap();
    drop(drafts);
    assert_eq!(leftover_drafts(&Drafts::new(&folders)), []);
    assert_eq!(programs(&folders), 0);
}

#[test]
fn what_a_program_leaves_is_found_by_the_next() {
    let (_home, folders) = home();
    let mut drafts = Drafts::new(&folders);
    let preset = Location::new("preset:phong");
    drafts.keep(0, FileKind::Formula, Some(&preset), None, "old").unwrap();
    drafts.keep(0, FileKind::Formula, Some(&preset), None, "new").unwrap();
    drafts.keep(1, FileKind::Scene, Some(&Location::new("a.scene")), None, "").unwrap();
    assert_eq!(leftover_drafts(&Drafts::new(&folders)), [], "the program is running");
    assert_eq!(leftover_drafts(&drafts), []);
    drop(drafts);

    let mut next = Drafts::new(&folders);
    let found = leftover_drafts(&next);
    assert_eq!(texts(&found), ["", "new"]);
    let formula = found.iter().find(|left| left.draft.as_ref().unwrap().kind == FileKind::Formula).unwrap();
    let scene = found.iter().find(|left| left.path() != formula.path()).unwrap();
    let draft = next.take_over(formula, 5).unwrap();
    assert_eq!((draft.location, draft.text.as_str()), (Some(preset), "new"));
    assert!(draft.time <= SystemTime::now() && draft.time > SystemTime::now() - Duration::from_secs(600));
    let elsewhere = scene.draft.clone().unwrap().location;
    assert_eq!(elsewhere, Some(Location::File(std::path::absolute("a.scene").unwrap())));
    assert_eq!(texts(&leftover_drafts(&next)), [""]);
    assert!(next.take_over(scene, 5).unwrap_err().message().contains("a draft of its own"));
    next.discard(scene).unwrap();
    assert_eq!(leftover_drafts(&next), []);
    assert_eq!(programs(&folders), 1, "the folder of the program that is gone is gone too");
    // What was taken over is kept as any other.
    drop(next);
    assert_eq!(texts(&leftover_drafts(&Drafts::new(&folders))), ["new"]);
}

#[test]
fn two_programs_have_drafts_of_their_own() {
    let (_home, folders) = home();
    let (mut one, mut other) = (Drafts::new(&folders), Drafts::new(&folders));
    one.keep(0, FileKind::Formula, None, None, "one").unwrap();
    other.keep(0, FileKind::Formula, None, None, "other").unwrap();
    one.remove(0).unwrap();
    drop(other);
    assert_eq!(texts(&leftover_drafts(&one)), ["other"]);
}

#[test]
fn only_one_program_takes_a_draft_over() {
    let (_home, folders) = home();
    let mut gone = Drafts::new(&folders);
    gone.keep(0, FileKind::Formula, None, None, "text").unwrap();
    gone.keep(1, FileKind::Scene, None, None, "scene").unwrap();
    drop(gone);
    let (mut one, mut other) = (Drafts::new(&folders), Drafts::new(&folders));
    let (mine, yours) = (leftover_drafts(&one), leftover_drafts(&other));
    for (editor, left) in mine.iter().enumerate() {
        one.take_over(left, editor as u32).unwrap();
    }
    for left in &yours {
        let error = other.take_over(left, 0).unwrap_err();
        assert!(error.message().contains("another program"), "{}", error.message());
        assert!(other.discard(left).is_err());
    }
    drop(one);
    assert_eq!(texts(&leftover_drafts(&other)), ["scene", "text"]);
}

#[test]
fn many_programs_at_once_lose_nothing() {
    const PROGRAMS: usize = 8;
    let (_home, folders) = home();
    std::thread::scope(|scope| {
        for program in 0..PROGRAMS {
            let folders = &folders;
            scope.spawn(move || {
                for round in 0..10 {
                    let mut drafts = Drafts::new(folders);
                    // Looking removes folders that are empty, while others are just making theirs.
                    let _ = drafts.leftover_drafts();
                    drafts.keep(0, FileKind::Formula, None, None, &format!("{program} {round}")).unwrap();
                    drafts.keep(1, FileKind::Scene, None, None, "saved").unwrap();
                    drafts.remove(1).unwrap();
                    if round % 2 == 0 {
                        drafts.remove(0).unwrap();
                    }
                }
            });
        }
    });
    let found = leftover_drafts(&Drafts::new(&folders));
    let mut expected: Vec<String> =
        (0..PROGRAMS).flat_map(|program| [1, 3, 5, 7, 9].map(|round| format!("{program} {round}"))).collect();
    expected.sort_unstable();
    assert_eq!(texts(&found), expected);
}

/// Plays the program that is killed when the test below starts it.
const CHILD_HOME: &str = "ILLUMINATOR_TEST_DRAFTS";

/// The name by which the test program knows a test of this module.
fn this_test(name: &str) -> String {
    let module = module_path!().split_once("::").map_or("", |(_, module)| module);
    format!("{module}::{name}")
}

#[test]
fn a_killed_program_leaves_its_drafts() {
    if let Some(home) = std::env::var_os(CHILD_HOME) {
        let mut drafts = Drafts::new(&Folders::below(Path::new(&home)));
        drafts.keep(0, FileKind::Formula, None, None, "typed until the end").unwrap();
        fs::write(Path::new(&home).join("kept"), "").unwrap();
        std::io::stdin().read_to_end(&mut Vec::new()).unwrap();
        return;
    }
    let (home, folders) = home();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", &this_test("a_killed_program_leaves_its_drafts"), "--nocapture"])
        .env(CHILD_HOME, home.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    for _ in 0..3000 {
        if home.path().join("kept").exists() {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let drafts = Drafts::new(&folders);
    let while_running = leftover_drafts(&drafts);
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(while_running, []);
    assert_eq!(texts(&leftover_drafts(&drafts)), ["typed until the end"]);
}

#[test]
fn the_same_text_is_not_written_again() {
    let (_home, folders) = home();
    let mut drafts = Drafts::new(&folders);
    drafts.keep(0, FileKind::Formula, None, None, "text").unwrap();
    let path = file_of(drafts.own_folder.as_ref().unwrap(), 0);
    let written = |path: &Path| fs::metadata(path).unwrap().modified().unwrap();
    let before = written(&path);
    std::thread::sleep(Duration::from_millis(20));
    drafts.keep(0, FileKind::Formula, None, None, "text").unwrap();
    assert_eq!(written(&path), before);
    drafts.keep(0, FileKind::Formula, Some(&Location::new("/saved/as")), None, "text").unwrap();
    assert!(written(&path) > before);
}

#[test]
fn a_folder_that_is_taken_away_is_made_again_with_all_drafts() {
    let (_home, folders) = home();
    let mut drafts = Drafts::new(&folders);
    drafts.keep(0, FileKind::Formula, None, None, "formula").unwrap();
    drafts.keep(1, FileKind::Scene, None, None, "scene").unwrap();
    fs::remove_dir_all(&folders.state).unwrap();
    drafts.keep(0, FileKind::Formula, None, None, "formula").unwrap();
    assert_eq!(leftover_drafts(&Drafts::new(&folders)), []);
    drop(drafts);
    assert_eq!(texts(&leftover_drafts(&Drafts::new(&folders))), ["formula", "scene"]);
}

#[test]
fn what_cannot_be_kept_is_reported_and_tried_again() {
    let (home, folders) = home();
    fs::write(home.path().join("state"), "a file").unwrap();
    let mut drafts = Drafts::new(&folders);
    let error = drafts.keep(0, FileKind::Formula, None, None, "text").unwrap_err();
    assert!(error.message().starts_with("cannot save the draft in `"), "{}", error.message());
    let (found, diagnostics) = drafts.leftover_drafts();
    assert_eq!((found.len(), diagnostics.len()), (0, 1), "{diagnostics:?}");
    fs::remove_file(home.path().join("state")).unwrap();
    drafts.keep(0, FileKind::Formula, None, None, "text").unwrap();

    // Something stands where the next one is to be: the first is unharmed, and so is what could not be kept.
    let path = file_of(drafts.own_folder.as_ref().unwrap(), 1);
    fs::create_dir_all(path.join("inside")).unwrap();
    assert!(drafts.keep(1, FileKind::Scene, None, None, "scene").is_err());
    assert!(drafts.keep(1, FileKind::Scene, None, None, "scene").is_err(), "an error is no success the second time");
    fs::remove_dir_all(&path).unwrap();
    drafts.keep(1, FileKind::Scene, None, None, "scene").unwrap();
    drop(drafts);
    assert_eq!(texts(&leftover_drafts(&Drafts::new(&folders))), ["scene", "text"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_system_that_takes_no_files_is_reported() {
    let mut drafts = Drafts::new(&Folders::below(Path::new("/proc/illuminator")));
    assert!(drafts.keep(0, FileKind::Formula, None, None, "text").is_err());
    assert_eq!(leftover_drafts(&drafts), []);
}

#[test]
fn damaged_drafts_are_reported_and_stay_until_they_are_discarded() {
    let damaged: [(&[u8], &str); 6] = [
        (b"version = 1\nkind = \"formula\"\ntext = \"\xff\"", "not UTF-8"),
        (b"version = 1\nkind = \"formula\"\ntext = \"cut of", "invalid basic string"),
        (b"version = 1\nkind = \"formula\"", "the draft is incomplete"),
        (b"version = 1\nkind = \"poem\"\ntext = \"x\"", "no valid kind"),
        (b"version = 2\nkind = \"formula\"\ntext = \"x\"", "version 2"),
        (b"", "has no version"),
    ];
    let (_home, folders) = home();
    let mut gone = Drafts::new(&folders);
    gone.keep(9, FileKind::Formula, None, None, "sound").unwrap();
    let own_folder = gone.own_folder.as_ref().unwrap();
    for (editor, (bytes, _)) in damaged.iter().enumerate() {
        fs::write(file_of(own_folder, editor as u32), bytes).unwrap();
    }
    fs::write(own_folder.folder().join(".illuminator-half"), "version = 1\nte").unwrap();
    let folder = own_folder.folder().to_owned();
    drop(gone);
    let mut drafts = Drafts::new(&folders);
    let found = leftover_drafts(&drafts);
    assert_eq!(found.len(), damaged.len() + 1);
    assert!(found[0].draft.is_ok(), "what can be read comes first");
    for (editor, (bytes, what)) in damaged.iter().enumerate() {
        let left = found.iter().find(|left| left.path().ends_with(format!("{editor}.toml"))).unwrap();
        let error = left.draft.as_ref().unwrap_err();
        assert!(error.message().contains(what), "{}", error.message());
        assert!(drafts.take_over(left, 0).is_err());
        assert_eq!(fs::read(left.path()).unwrap(), *bytes);
        drafts.discard(left).unwrap();
    }
    drafts.take_over(&found[0], 0).unwrap();
    assert!(!folder.exists(), "what was half written goes with the folder");
}

#[test]
fn folders_without_a_lock_are_taken_for_left_behind() {
    let (_home, folders) = home();
    let mut gone = Drafts::new(&folders);
    gone.keep(0, FileKind::Formula, None, None, "text").unwrap();
    let folder = gone.own_folder.as_ref().unwrap().folder().to_owned();
    drop(gone);
    fs::remove_file(folder.join("lock")).unwrap();
    fs::create_dir(folders.state.join("drafts/empty")).unwrap();
    fs::write(folders.state.join("drafts/file"), "").unwrap();
    let drafts = Drafts::new(&folders);
    assert_eq!(texts(&leftover_drafts(&drafts)), ["text"]);
    assert_eq!(programs(&folders), 1);
}

#[test]
fn huge_texts_are_kept() {
    let (_home, folders) = home();
    // Larger than any file that is opened, with all that needs an escape.
    let text = "formula; /* \"\\ \t\r\n\0 ž \u{1f600} ''' \"\"\" */\n".repeat(500_000);
    assert!(text.len() > crate::lang::source::MAX_BYTES);
    let mut drafts = Drafts::new(&folders);
    drafts.keep(0, FileKind::Formula, None, None, &text).unwrap();
    drop(drafts);
    let found = leftover_drafts(&Drafts::new(&folders));
    assert!(found[0].draft.as_ref().unwrap().text == text);
}

#[cfg(unix)]
#[test]
fn a_text_from_a_path_that_is_no_text_is_kept_without_it() {
    use std::os::unix::ffi::OsStrExt;
    let (_home, folders) = home();
    let location = Location::File(PathBuf::from(std::ffi::OsStr::from_bytes(b"/a\xff")));
    let mut drafts = Drafts::new(&folders);
    drafts.keep(0, FileKind::Formula, Some(&location), None, "text").unwrap();
    drop(drafts);
    let found = leftover_drafts(&Drafts::new(&folders));
    let draft = found[0].draft.as_ref().unwrap();
    assert_eq!((draft.text.as_str(), &draft.location), ("text", &None));
}

#[cfg(unix)]
#[test]
fn pipes_in_place_of_drafts_and_locks_are_reported() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let (_home, folders) = home();
    let mut gone = Drafts::new(&folders);
    gone.keep(0, FileKind::Formula, None, None, "text").unwrap();
    drop(gone);
    let pipe = |name: &str| {
        let path = folders.state.join("drafts").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    };
    pipe("a/lock");
    pipe("b/0.toml");
    let (found, diagnostics) = Drafts::new(&folders).leftover_drafts();
    assert_eq!(texts(&found), ["text"]);
    let messages: Vec<&str> = diagnostics.iter().map(Diagnostic::message).collect();
    assert!(messages.len() == 1 && messages[0].ends_with("/a`: it is a pipe, not a file"), "{messages:?}");
}

#[cfg(unix)]
#[test]
fn drafts_are_the_users_alone() {
    use std::os::unix::fs::PermissionsExt;
    let (_home, folders) = home();
    let mut drafts = Drafts::new(&folders);
    drafts.keep(0, FileKind::Formula, None, None, "text").unwrap();
    assert_eq!(fs::metadata(folders.state.join("drafts")).unwrap().permissions().mode() & 0o77, 0);
}

proptest! {
    #[test]
    fn what_is_kept_is_read_back(text in any::<String>(), lines in "([\r\n\t\"'\\\\ a]|\\PC){0,60}", seconds in 0..1u64 << 40) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("0.toml");
        for text in [text, lines] {
            let location = Some(Location::File(Path::new("/").join(text.replace('\0', ""))));
            let draft = Draft { kind: FileKind::Formula, session: location.clone(), location, text, time: UNIX_EPOCH + Duration::from_secs(seconds) };
            fs::write(&path, to_toml(&draft).unwrap()).unwrap();
            prop_assert_eq!(read(&path).unwrap(), draft);
        }
    }
}
