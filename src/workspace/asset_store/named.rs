//! What a name in a scene means: a built-in mesh or environment, or a file.

use crate::files::FileStamp;
use crate::lang::diagnostic::{Diagnostic, nearest};
use crate::workspace::location::{Location, PRESET};
use std::path::{Path, PathBuf};

/// A built-in mesh or environment.
pub(super) trait BuiltInAsset: Sized + 'static {
    /// What it is called.
    const NOUN: &'static str;
    /// The same with its article.
    const WITH_ARTICLE: &'static str;
    /// All of its kind.
    const ALL: &'static [Self];

    /// Its name, without `preset:`.
    fn name(&self) -> &'static str;
}

/// The file or the built-in asset that a name in a scene means.
pub(super) enum FoundAsset<P: 'static> {
    BuiltIn(&'static P),
    File(PathBuf),
}

/// Where an asset comes from, and which contents the file has.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AssetOrigin {
    BuiltIn(&'static str),
    File(FileStamp),
    /// There is no such file, or it cannot be looked at.
    Missing(PathBuf),
}

impl AssetOrigin {
    /// The file at a path, as it is now.
    fn of_file(path: &Path) -> Self {
        FileStamp::of(path).map_or_else(|| AssetOrigin::Missing(path.to_owned()), AssetOrigin::File)
    }

    /// Whether it is a file that does not exist. Then this helps if the name is relative to the folder of the scene.
    pub(super) fn missing_hint(&self, name: &str) -> Option<String> {
        let is_missing = matches!(self, AssetOrigin::Missing(_)) && !Path::new(name).is_absolute();
        is_missing.then(|| "a relative path starts from the folder of the scene".to_owned())
    }

    /// How many bytes would be read.
    pub(super) fn length(&self) -> u64 {
        match self {
            AssetOrigin::File(stamp) => stamp.length(),
            AssetOrigin::BuiltIn(_) | AssetOrigin::Missing(_) => 0,
        }
    }
}

impl<P: BuiltInAsset> FoundAsset<P> {
    /// Where it comes from, as it is now.
    pub(super) fn origin(&self) -> AssetOrigin {
        match self {
            FoundAsset::BuiltIn(preset) => AssetOrigin::BuiltIn(preset.name()),
            FoundAsset::File(path) => AssetOrigin::of_file(path),
        }
    }

    /// The file that a name means; `None` for a built-in asset, and for names that mean nothing.
    pub(super) fn file_origin(name: &str, scene_location: &Location) -> Option<AssetOrigin> {
        match find::<P>(name, scene_location) {
            Ok(FoundAsset::File(path)) => Some(AssetOrigin::of_file(&path)),
            Ok(FoundAsset::BuiltIn(_)) | Err(_) => None,
        }
    }
}

/// The file or the built-in asset that a name in a scene means.
pub(super) fn find<P: BuiltInAsset>(name: &str, scene_location: &Location) -> Result<FoundAsset<P>, Diagnostic> {
    let noun = P::NOUN;
    if let Some(name) = name.strip_prefix(PRESET) {
        return P::ALL.iter().find(|preset| preset.name() == name).map(FoundAsset::BuiltIn).ok_or_else(|| {
            let names = P::ALL.iter().map(P::name);
            let help = match nearest(name, names.clone()) {
                Some(near) => format!("did you mean `{PRESET}{near}`?"),
                None => format!("the built-in ones are {}", names.collect::<Vec<_>>().join(", ")),
            };
            Diagnostic::error(format!("there is no built-in {noun} `{PRESET}{name}`")).help(help)
        });
    }
    match scene_location {
        _ if Path::new(name).is_absolute() => Ok(FoundAsset::File(PathBuf::from(name))),
        Location::File(scene) => Ok(FoundAsset::File(scene.parent().unwrap_or(Path::new("")).join(name))),
        Location::Preset(_) => {
            let message = format!("a built-in scene has no folder from which {} could be read", P::WITH_ARTICLE);
            let help = format!("save the scene beside the {noun}, or name a built-in {noun}, `{PRESET}NAME`");
            Err(Diagnostic::error(message).help(help))
        }
    }
}
