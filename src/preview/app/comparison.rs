//! Comparing pictures: two side by side along a line, or their difference. A picture is the current one or a snapshot.

use crate::preview::renderer::Picture;
use crate::preview::workshop::Workshop;

/// The names of the snapshots.
pub(super) const SNAPSHOTS: [&str; 2] = ["A", "B"];

/// By how much differences can be amplified.
pub(super) const GAINS: [u32; 3] = [1, 4, 16];

/// A picture that can be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compared {
    /// The current picture.
    Now,
    /// A snapshot.
    Snapshot(usize),
    /// The picture with a measured material on one body.
    Measured,
}

impl Compared {
    /// What the user calls it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Compared::Now => "now",
            Compared::Snapshot(slot) => SNAPSHOTS.get(slot).copied().unwrap_or_default(),
            Compared::Measured => "measured",
        }
    }

    /// The picture; `None` if the snapshot was not taken.
    fn picture(self, workshop: &Workshop) -> Option<&Picture> {
        match self {
            Compared::Now => Some(workshop.shown()),
            Compared::Snapshot(slot) => workshop.snapshot(slot).map(|snapshot| &snapshot.picture),
            Compared::Measured => workshop.measured_picture(),
        }
    }

    /// The picture, unless it shows another scene than the present one, and will follow it.
    fn present_picture(self, workshop: &Workshop) -> Option<&Picture> {
        let follows = self == Compared::Measured && !workshop.measured_shows_scene();
        self.picture(workshop).filter(|_| !follows)
    }
}

/// Two pictures that are compared.
pub(super) type Pair = [Compared; 2];

/// The pairs that can be compared.
pub(super) const PAIRS: [Pair; 4] = [
    [Compared::Snapshot(0), Compared::Now],
    [Compared::Snapshot(1), Compared::Now],
    [Compared::Snapshot(0), Compared::Snapshot(1)],
    [Compared::Measured, Compared::Now],
];

/// What the pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum PaneMode {
    /// The current picture.
    #[default]
    Current,
    /// A snapshot.
    Snapshot(usize),
    /// How much each pixel depends on a parameter.
    Sensitivity,
    /// One picture on the left, the other on the right.
    Split(Pair),
    /// The difference of two pictures, amplified by a factor.
    Difference(Pair, u32),
}

impl PaneMode {
    /// The pictures that are compared, if any are.
    pub(super) fn pair(self) -> Option<Pair> {
        match self {
            PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Sensitivity => None,
            PaneMode::Split(pair) | PaneMode::Difference(pair, _) => Some(pair),
        }
    }

    /// Whether the camera can be led meanwhile, because what is in view follows it.
    pub(super) fn follows_camera(self) -> bool {
        match self {
            PaneMode::Current => true,
            PaneMode::Snapshot(_) | PaneMode::Sensitivity => false,
            PaneMode::Split(pair) | PaneMode::Difference(pair, _) => {
                pair.iter().all(|side| !matches!(side, Compared::Snapshot(_)))
            }
        }
    }

    /// The size that the current picture must have to be compared. One with a measured material follows it instead.
    pub(super) fn wanted_size(self, workshop: &Workshop) -> Option<[u32; 2]> {
        let [one, other] = self.pair()?;
        (other == Compared::Now && one != Compared::Measured)
            .then(|| one.picture(workshop).map(|picture| picture.full_size))
            .flatten()
    }
}

/// Why two pictures cannot be compared, if so.
pub(super) fn obstacle(pair: Pair, workshop: &Workshop) -> Option<String> {
    let missing = pair.into_iter().find(|side| side.picture(workshop).is_none());
    if missing == Some(Compared::Measured) {
        return Some("Load a measured material in the instruments, and compare it in the picture".to_owned());
    }
    if let Some(missing) = missing {
        return Some(format!("There is no {} yet: keep a picture as {0}", missing.name()));
    }
    let sizes = pair.map(|side| side.picture(workshop).map(|picture| picture.full_size));
    let fixed = !pair.contains(&Compared::Now);
    (fixed && sizes[0] != sizes[1]).then(|| format!("{} and {} have different sizes", pair[0].name(), pair[1].name()))
}

/// The largest difference of two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct LargestDifference {
    /// In steps of a component, 0..=255.
    steps: u32,
    /// The first pixel that has it.
    pixel: [u32; 2],
}

/// What a comparison was made of.
#[derive(Clone, Copy, PartialEq)]
struct ComparisonKey {
    mode: PaneMode,
    versions: [u64; 2],
    /// How many columns the first picture has.
    columns: usize,
}

/// The picture of a comparison.
#[derive(Default)]
pub(super) struct Comparison {
    picture: Picture,
    largest: LargestDifference,
    /// How many passes both pictures have.
    passes: [usize; 2],
    made_of: Option<ComparisonKey>,
}

impl Comparison {
    /// Makes the picture, unless it is there. `line` is where two pictures meet, 0..1 of their width.
    pub(super) fn update(&mut self, mode: PaneMode, line: f32, workshop: &Workshop) {
        let pictures = mode.pair().map(|pair| pair.map(|side| side.present_picture(workshop)));
        let Some([Some(one), Some(other)]) = pictures else {
            self.made_of = None;
            return;
        };
        let columns = match mode {
            PaneMode::Split(_) => (line * other.width as f32).round() as usize,
            PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Sensitivity | PaneMode::Difference(..) => 0,
        };
        let key = ComparisonKey { mode, versions: [one.version, other.version], columns };
        if self.made_of == Some(key) {
            return;
        }
        // A version that no picture has, and that differs from the previous one.
        let version = 1 << 63 | (self.picture.version + 1);
        let made = match mode {
            PaneMode::Difference(_, gain) => {
                let (picture, largest) = difference(one, other, gain);
                self.largest = largest;
                picture
            }
            PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Sensitivity | PaneMode::Split(_) => join(one, other, columns),
        };
        self.passes = [one.passes.shown, other.passes.shown];
        self.picture = Picture { version, ..made };
        self.made_of = Some(key);
    }

    /// The picture in this mode, if pictures are compared.
    pub(super) fn picture(&self, mode: PaneMode) -> Option<&Picture> {
        self.made_of.filter(|key| key.mode == mode).map(|_| &self.picture)
    }

    /// What the difference in view says in words.
    pub(super) fn words(&self, pair: Pair, gain: u32) -> String {
        let [one, other] = pair.map(Compared::name);
        let amplified = if gain == 1 { String::new() } else { format!(", amplified ×{gain}") };
        let LargestDifference { steps, pixel: [x, y] } = self.largest;
        let unequal = match self.passes {
            [first, second] if first != second => format!(" ({first} and {second} passes)"),
            _ => String::new(),
        };
        match steps {
            0 => format!("{one} and {other} are equal"),
            _ => format!("Difference of {one} and {other}{unequal}{amplified}; the largest is {steps} of 255, at ({x}, {y})"),
        }
    }
}

/// Whether two pictures have the same pixels to compare: one of low resolution waits for the full one.
fn is_comparable(one: &Picture, other: &Picture) -> bool {
    [one.width, one.height] == [other.width, other.height]
}

/// Some columns of one picture, a line, and the rest of the other picture.
fn join(one: &Picture, other: &Picture, columns: usize) -> Picture {
    let mut both = other.clone();
    if !is_comparable(one, other) {
        return both;
    }
    let width = (other.width as usize).max(1);
    let columns = columns.min(width);
    for (row, from) in both.pixels.chunks_exact_mut(width).zip(one.pixels.chunks_exact(width)) {
        row[..columns].copy_from_slice(&from[..columns]);
        if let Some(pixel) = row.get_mut(columns) {
            *pixel = 0x00ff_ffff;
        }
    }
    both
}

/// The absolute difference of the displayed components, times `gain`, and the largest difference without it.
fn difference(one: &Picture, other: &Picture, gain: u32) -> (Picture, LargestDifference) {
    if !is_comparable(one, other) {
        return (other.clone(), LargestDifference::default());
    }
    let mut largest = (0, 0);
    let differ = |(index, (a, b)): (usize, (&u32, &u32))| {
        let mut word = 0;
        for shift in [0, 8, 16] {
            let steps = (a >> shift & 0xff).abs_diff(b >> shift & 0xff);
            if steps > largest.0 {
                largest = (steps, index);
            }
            word |= (steps * gain).min(255) << shift;
        }
        word
    };
    let pixels = one.pixels.iter().zip(&other.pixels).enumerate().map(differ).collect();
    let (steps, index) = largest;
    let width = one.width.max(1);
    let pixel = [index as u32 % width, index as u32 / width];
    // A difference has no linear colours: it is one of bytes.
    (Picture { pixels, linear: None, ..other.clone() }, LargestDifference { steps, pixel })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[u32]) -> Picture {
        let [width, height] = [pixels.len() as u32 / 2, 2];
        Picture { width, height, pixels: pixels.to_vec(), full_size: [width, height], version: 1, ..Picture::default() }
    }

    #[test]
    fn a_difference_is_absolute_amplified_and_says_the_largest() {
        let one = picture(&[0x0010_2030, 0x00ff_0000, 0x0000_0000, 0x0000_0005]);
        let other = picture(&[0x0010_2030, 0x00f0_0000, 0x0000_1300, 0x0000_0000]);
        let (plain, largest) = difference(&one, &other, 1);
        assert_eq!(plain.pixels, [0, 0x000f_0000, 0x0000_1300, 0x0000_0005]);
        assert_eq!(largest, LargestDifference { steps: 0x13, pixel: [0, 1] });
        let (amplified, same) = difference(&other, &one, 16);
        assert_eq!(amplified.pixels, [0, 0x00f0_0000, 0x0000_ff00, 0x0000_0050]);
        assert_eq!(same, largest, "the largest is that before amplification");
        // One of low resolution has other pixels, so there is nothing to compare yet.
        let coarse = Picture { width: 1, height: 1, pixels: vec![7], ..one.clone() };
        assert_eq!(difference(&one, &coarse, 1).0.pixels, [7]);
    }

    #[test]
    fn joined_pictures_meet_at_a_line() {
        let joined = join(&picture(&[1, 1, 1, 1, 1, 1]), &picture(&[2, 2, 2, 2, 2, 2]), 1);
        assert_eq!(joined.pixels, [1, 0x00ff_ffff, 2, 1, 0x00ff_ffff, 2]);
    }
}
