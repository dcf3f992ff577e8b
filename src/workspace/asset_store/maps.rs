//! Reading the images of environments that scenes name.

use super::Cancelled;
use super::named::{AssetOrigin, BuiltInAsset, FoundAsset, find};
use crate::environment::{EnvironmentPreset, MAX_MAP_SIDE, MapRepairs, PRESETS, RadianceMap};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::memory_size::MemorySize;
use crate::mesh::Reading;
use crate::scene::{NamedFile, Scene};
use crate::workspace::Location;
use crate::workspace::images::{EncodedImage, ImageLimits, LINEAR_SUFFIXES, Undecoded, open_image, unreadable};
use crate::world::{Assets, NamedMap};
use image::DynamicImage;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The share of decoding in the whole work on an image. The rest is its map.
const DECODING: f64 = 0.8;

/// Which part of the light components below 0 may be without a warning. Many images have small ones, by compression
/// with loss and by filters that sharpen.
const NEGATIVE: f64 = 0.01;

/// Maps that were read.
#[derive(Debug, Default)]
pub(super) struct KeptMaps {
    kept: Mutex<Vec<KeptMap>>,
}

/// What was read of a file.
#[derive(Debug, Clone)]
struct KeptMap {
    origin: AssetOrigin,
    outcome: Result<(Arc<RadianceMap>, MapRepairs), MapFault>,
}

/// Why there is no map of an image.
#[derive(Debug, Clone)]
enum MapFault {
    /// The work was cancelled.
    Cancelled,
    /// The memory is too small. The diagnostic says so.
    Memory(Diagnostic),
    /// The image cannot be used.
    Unusable(Diagnostic),
}

impl BuiltInAsset for EnvironmentPreset {
    const NOUN: &'static str = "environment";
    const WITH_ARTICLE: &'static str = "an environment";
    const ALL: &'static [Self] = PRESETS;

    fn name(&self) -> &'static str {
        self.name
    }
}

/// The image that the environment of a scene names.
pub(super) fn image_of(scene: &Scene) -> Option<&NamedFile> {
    scene.lights.iter().find_map(|light| light.kind.environment()?.image())
}

impl KeptMaps {
    /// Adds the map of a scene's environment to `assets`, and what is wrong with it to `found`.
    pub(super) fn load(
        &self,
        scene: &Scene,
        scene_location: &Location,
        reading: &Reading,
        assets: &mut Assets,
        found: &mut Diagnostics,
    ) -> Result<(), Cancelled> {
        let Some(image) = image_of(scene) else {
            self.forget_others(None);
            return Ok(());
        };
        let path = image.path();
        let asset = match find(path, scene_location) {
            Ok(asset) => asset,
            Err(diagnostic) => {
                found.push(diagnostic.at(image.span(), "this environment"));
                return Ok(());
            }
        };
        // What was read before counts too.
        let memory = reading.memory.saturating_sub(assets.memory());
        let kept = self.of_asset(&asset, &Reading { memory, ..*reading });
        match &kept.outcome {
            Ok((map, repairs)) => {
                warnings(map, *repairs).for_each(|warning| found.push(warning.at(image.span(), "in this environment")));
                assets.environment = Some(NamedMap { path: path.to_owned(), map: Arc::clone(map) });
            }
            Err(MapFault::Cancelled) => return Err(Cancelled),
            Err(MapFault::Memory(diagnostic) | MapFault::Unusable(diagnostic)) => {
                let diagnostic = diagnostic.clone().at(image.span(), "this environment cannot be used");
                found.push(diagnostic.help_if(kept.origin.missing_hint(path)));
            }
        }
        self.forget_others(Some(&kept.origin));
        Ok(())
    }

    /// The file of a scene's environment if nothing is kept of it.
    pub(super) fn unread(&self, scene: &Scene, scene_location: &Location) -> Option<AssetOrigin> {
        let origin = FoundAsset::<EnvironmentPreset>::file_origin(image_of(scene)?.path(), scene_location)?;
        self.kept(&origin).is_none().then_some(origin)
    }

    /// Forgets which images were too large for the memory. They are tried again.
    pub(super) fn forget_refused(&self) {
        self.lock().retain(|kept| !matches!(kept.outcome, Err(MapFault::Memory(_))));
    }

    fn lock(&self) -> MutexGuard<'_, Vec<KeptMap>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn kept(&self, origin: &AssetOrigin) -> Option<KeptMap> {
        self.lock().iter().find(|kept| kept.origin == *origin).cloned()
    }

    /// Makes a map, unless it is kept.
    fn of_asset(&self, asset: &FoundAsset<EnvironmentPreset>, reading: &Reading) -> KeptMap {
        let origin = asset.origin();
        if let Some(kept) = self.kept(&origin) {
            return kept;
        }
        let outcome = match asset {
            _ if reading.cancelled.load(Ordering::Relaxed) => Err(MapFault::Cancelled),
            FoundAsset::BuiltIn(preset) => {
                let name = format!("preset:{}", preset.name);
                check_memory(&name, preset.memory(), reading).map(|()| (Arc::new(preset.map()), MapRepairs::default()))
            }
            FoundAsset::File(path) => read_map(path, reading),
        };
        (reading.progress)(1.0);
        let kept = KeptMap { origin, outcome };
        if !matches!(kept.outcome, Err(MapFault::Cancelled)) {
            self.lock().push(kept.clone());
        }
        kept
    }

    /// Forgets what neither this scene nor anybody else uses.
    fn forget_others(&self, used: Option<&AssetOrigin>) {
        let in_use = |kept: &KeptMap| kept.outcome.as_ref().is_ok_and(|(map, _)| Arc::strong_count(map) > 1);
        self.lock().retain(|kept| Some(&kept.origin) == used || in_use(kept));
    }
}

fn check_memory(name: &str, needed: u64, reading: &Reading) -> Result<(), MapFault> {
    if needed <= reading.memory {
        return Ok(());
    }
    let (needed, allowed) = (MemorySize(needed), MemorySize(reading.memory));
    let message = format!("`{name}` is too large: it needs {needed}, and {allowed} are allowed");
    Err(MapFault::Memory(Diagnostic::error(message)))
}

/// Reads the map of an image in latitude-longitude form.
fn read_map(path: &Path, reading: &Reading) -> Result<(Arc<RadianceMap>, MapRepairs), MapFault> {
    let known = format!("environments are images of the formats OpenEXR and Radiance HDR ({})", LINEAR_SUFFIXES.join(", "));
    // Whatever fails when the work is cancelled fails because of that.
    let undecoded = |why: Undecoded| match reading.cancelled.load(Ordering::Relaxed) {
        true => MapFault::Cancelled,
        false => MapFault::Unusable(why.diagnostic(path, &known)),
    };
    let (file, metadata) = open_image(path).map_err(MapFault::Unusable)?;
    let limits = ImageLimits { side: MAX_MAP_SIDE, bytes: reading.memory };
    let file = WatchedFile { file, position: 0, length: metadata.len().max(1), reading };
    let encoded = EncodedImage::new(file, limits).map_err(undecoded)?;
    if !encoded.is_linear() {
        let diagnostic = unreadable(path, &format!("it is {}", encoded.noun())).help(known);
        return Err(MapFault::Unusable(diagnostic.help("in other formats, nothing is brighter than white")));
    }
    let [width, height] = encoded.size();
    let texels = u64::from(width) * u64::from(height);
    let (decoding, map) = (texels * encoded.bytes_per_texel(), RadianceMap::memory_of(width, height));
    let numbers = decoding / encoded.copies();
    check_memory(&path.display().to_string(), decoding.max(numbers + map), reading)?;
    let image = encoded.decode(limits).map_err(undecoded)?;
    let made = if let DynamicImage::ImageRgba32F(image) = image {
        map_of::<4>([width, height], image.as_raw())
    } else {
        map_of::<3>([width, height], image.into_rgb32f().as_raw())
    };
    if reading.cancelled.load(Ordering::Relaxed) {
        return Err(MapFault::Cancelled);
    }
    let (map, repairs) = made.ok_or_else(|| undecoded(Undecoded::Contents(format!("it has {width}×{height} texels"))))?;
    Ok((Arc::new(map), repairs))
}

/// The map of texels of this many numbers: red, green, blue, and perhaps transparency, which is left out.
fn map_of<const COMPONENTS: usize>([width, height]: [u32; 2], numbers: &[f32]) -> Option<(RadianceMap, MapRepairs)> {
    let (texels, _) = numbers.as_chunks::<COMPONENTS>();
    RadianceMap::of_rows(width, height, |row, written| {
        let given = texels.chunks_exact(width as usize).nth(row as usize).unwrap_or_default();
        written.iter_mut().zip(given).for_each(|(written, given)| *written = [given[0], given[1], given[2]]);
    })
}

/// What was replaced in an image, and what is odd about it.
fn warnings(map: &RadianceMap, repairs: MapRepairs) -> impl Iterator<Item = Diagnostic> {
    let MapRepairs { not_numbers, too_bright, negative, negative_part } = repairs;
    let negative = if negative_part > NEGATIVE { negative } else { 0 };
    let part = match negative_part.is_finite() {
        true => format!(", {:.1} % of the light", 100.0 * negative_part),
        false => String::new(),
    };
    let counted = |count: u64, what: &str, used: &str| {
        let texels = if count == 1 { "1 texel has".to_owned() } else { format!("{count} texels have") };
        (count > 0).then(|| format!("{texels} {what}; {used} is used"))
    };
    let stretched = map.size().filter(|[width, height]| *width != 2 * height).map(|[width, height]| {
        format!("the image has {width}×{height} texels; one that shows all directions is twice as wide as it is high")
    });
    let black = map.sample([0.5; 2]).is_none().then(|| "the image is black: it sends no light".to_owned());
    let found = [
        counted(not_numbers, "components that are not numbers", "0"),
        counted(negative, &format!("components below 0{part}"), "0"),
        counted(too_bright, "components that are infinite or too large", "8.6e9"),
        stretched,
        black,
    ];
    found.into_iter().flatten().map(Diagnostic::warning)
}

/// A file that tells how much of it was read, and that cannot be read on when the work is cancelled.
struct WatchedFile<'r> {
    file: File,
    position: u64,
    /// At least 1.
    length: u64,
    reading: &'r Reading<'r>,
}

impl Read for WatchedFile<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.reading.cancelled.load(Ordering::Relaxed) {
            return Err(io::Error::other("the work was cancelled"));
        }
        let count = self.file.read(buffer)?;
        self.position += count as u64;
        (self.reading.progress)(DECODING * (self.position as f64 / self.length as f64).min(1.0));
        Ok(count)
    }
}

impl Seek for WatchedFile<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.position = self.file.seek(to)?;
        Ok(self.position)
    }
}
