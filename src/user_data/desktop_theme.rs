//! Whether the desktop is dark, as far as files and the environment say so.
//!
//! Desktops have no common place for it. Read are `GTK_THEME`, the colours of KDE (`kdeglobals`) and the settings of
//! GTK (`settings.ini`). What a desktop keeps only in a database or behind a service is not asked for.

use crate::files::Readable;
use crate::workspace::read_source;
use directories::BaseDirs;
use std::path::Path;

/// Whether the desktop of this user is dark; `None` if nothing says so.
pub fn desktop_is_dark() -> Option<bool> {
    let folders = BaseDirs::new()?;
    let variable = |name: &str| std::env::var_os(name).and_then(|value| value.to_str().map(str::to_owned));
    is_dark(folders.config_dir(), variable("GTK_THEME").as_deref(), variable("XDG_CURRENT_DESKTOP").as_deref())
}

/// The same, for a folder of settings and the values of two environment variables.
fn is_dark(configuration: &Path, gtk_theme: Option<&str>, desktop: Option<&str>) -> Option<bool> {
    let read = |name: &str| {
        let path = configuration.join(name);
        // A file that is missing or cannot be read says nothing.
        path.is_file().then(|| read_source(&path, None, Readable::Regular).ok()).flatten()
    };
    let kde = || read("kdeglobals").and_then(|file| kde_is_dark(file.text()));
    let gtk = || {
        let mut files = ["gtk-4.0/settings.ini", "gtk-3.0/settings.ini"].into_iter();
        files.find_map(|name| read(name).and_then(|file| gtk_is_dark(file.text())))
    };
    let is_kde = desktop.is_some_and(|desktop| desktop.split(':').any(|name| name.eq_ignore_ascii_case("kde")));
    let chosen = gtk_theme.filter(|theme| !theme.is_empty()).map(names_dark);
    chosen.or_else(|| if is_kde { kde().or_else(gtk) } else { gtk().or_else(kde) })
}

/// Whether the name of a theme is that of a dark one: `Adwaita-dark`, `Adwaita:dark`.
fn names_dark(theme: &str) -> bool {
    theme.to_lowercase().contains("dark")
}

/// The value of a key in a section of a file of settings.
fn value<'t>(text: &'t str, section: &str, key: &str) -> Option<&'t str> {
    let mut within = false;
    text.lines().map(str::trim).find_map(|line| {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            within = name == section;
            return None;
        }
        let (name, value) = line.split_once('=')?;
        (within && name.trim() == key).then(|| value.trim())
    })
}

fn gtk_is_dark(text: &str) -> Option<bool> {
    let prefers = value(text, "Settings", "gtk-application-prefer-dark-theme").map(|value| matches!(value, "1" | "true"));
    let theme = value(text, "Settings", "gtk-theme-name").map(names_dark);
    // A dark theme is dark whatever is preferred.
    match (prefers, theme) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (prefers, theme) => prefers.or(theme),
    }
}

fn kde_is_dark(text: &str) -> Option<bool> {
    let colour = value(text, "Colors:Window", "BackgroundNormal").map(|value| {
        let components = value.split(',').map(|part| part.trim().parse::<u32>().ok());
        components.collect::<Option<Vec<u32>>>().filter(|components| components.len() == 3)
    });
    match colour.flatten() {
        // The luma of the background of windows, in thousandths of a component.
        Some(components) => {
            Some(components.iter().zip([299, 587, 114]).map(|(part, weight)| part * weight).sum::<u32>() < 128_000)
        }
        None => value(text, "General", "ColorScheme").map(names_dark),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_variables_say_whether_the_desktop_is_dark() {
        let home = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = home.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let asked = |gtk: Option<&str>, desktop: Option<&str>| is_dark(home.path(), gtk, desktop);
        assert_eq!(asked(None, Some("GNOME")), None);
        assert_eq!(asked(Some("Adwaita:dark"), None), Some(true));
        write("gtk-3.0/settings.ini", "[Settings]\ngtk-theme-name = Yaru\n");
        assert_eq!(asked(None, None), Some(false));
        write("gtk-4.0/settings.ini", "[Settings]\ngtk-application-prefer-dark-theme=1\n");
        assert_eq!(asked(None, None), Some(true));
        assert_eq!(asked(Some("Adwaita"), None), Some(false));
        write("kdeglobals", "[General]\nColorScheme=BreezeDark\n[Colors:Window]\nBackgroundNormal=239,240,241\n");
        assert_eq!(asked(None, Some("KDE")), Some(false));
        assert_eq!(asked(None, Some("ubuntu:GNOME")), Some(true));
        write("kdeglobals", "[General]\nColorScheme=BreezeDark\n");
        assert_eq!(asked(None, Some("kde")), Some(true));
    }
}
