//! The results, as a table and as JSON.

use crate::stage::Model;
use serde::Serialize;
use std::fmt::{self, Write};

/// All results.
#[derive(Serialize)]
pub(crate) struct Report {
    pub(crate) session: &'static str,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    /// Numbers in a vector, the same for Illuminator and the peers.
    pub(crate) lanes: usize,
    pub(crate) hits: u64,
    pub(crate) records: u64,
    /// The number of rounds, without those discarded.
    pub(crate) rounds: usize,
    /// How busy other programs kept the processors, 0 to 1.
    pub(crate) others: f32,
    /// The peers that were not measured, and why.
    pub(crate) missing: Vec<String>,
    pub(crate) agreement: Vec<Agreement>,
    pub(crate) times: Vec<Times>,
    pub(crate) ratios: Vec<Ratio>,
}

/// How much the picture of a peer differs from ours.
#[derive(Serialize)]
pub(crate) struct Agreement {
    pub(crate) model: &'static str,
    pub(crate) peer: String,
    /// The largest difference, divided by the magnitude of the component where that is above 1.
    pub(crate) largest: f32,
    /// The number of components beyond the tolerance.
    pub(crate) beyond: usize,
}

/// The times that a kind of frame takes, in milliseconds.
#[derive(Serialize)]
pub(crate) struct Times {
    pub(crate) model: &'static str,
    pub(crate) threads: usize,
    pub(crate) what: What,
    /// The slider, or the compiler of the peer.
    pub(crate) detail: String,
    pub(crate) best: f64,
    pub(crate) median: f64,
    /// The number of measurements.
    pub(crate) count: usize,
}

/// Kinds of frames, and other work that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum What {
    Full,
    Images,
    OneChannel,
    Exponent,
    Interpreter,
    PeerDirections,
    PeerDots,
    /// As many bytes as a frame of weighted images moves, repeatedly.
    Triad,
    /// The same number of bytes, as a part of a triad that no cache holds.
    TriadInMemory,
    DrjitDirections,
    DrjitDots,
}

impl What {
    /// Whether it is measured in few rounds only.
    pub(crate) fn is_slow(self) -> bool {
        matches!(self, What::Interpreter | What::TriadInMemory)
    }
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            What::Full => "full evaluation",
            What::Images => "drag, images",
            What::OneChannel => "drag, one channel",
            What::Exponent => "drag, exponent",
            What::Interpreter => "interpreter",
            What::PeerDirections => "C, nlv",
            What::PeerDots => "C, dots",
            What::Triad => "C, triad",
            What::TriadInMemory => "C, triad in memory",
            What::DrjitDirections => "Dr.Jit, nlv",
            What::DrjitDots => "Dr.Jit, dots",
        })
    }
}

/// One time divided by another.
#[derive(Serialize)]
pub(crate) struct Ratio {
    pub(crate) model: &'static str,
    pub(crate) threads: usize,
    pub(crate) name: &'static str,
    pub(crate) of_best: f64,
    pub(crate) of_medians: f64,
}

/// The ratios: name, dividend, divisor.
const RATIOS: [(&str, What, What); 10] = [
    ("interpreter / full", What::Interpreter, What::Full),
    ("full / C nlv", What::Full, What::PeerDirections),
    ("full / C dots", What::Full, What::PeerDots),
    ("full / Dr.Jit nlv", What::Full, What::DrjitDirections),
    ("full / Dr.Jit dots", What::Full, What::DrjitDots),
    ("images / full", What::Images, What::Full),
    ("one channel / full", What::OneChannel, What::Full),
    ("exponent / full", What::Exponent, What::Full),
    ("images / triad of as many bytes", What::Images, What::Triad),
    ("images / the same in memory", What::Images, What::TriadInMemory),
];

/// The ratios of these times. Of several compilers the quickest counts.
pub(crate) fn ratios(times: &[Times]) -> Vec<Ratio> {
    let least = |model: Model, threads: usize, what: What, time: fn(&Times) -> f64| {
        let own = times.iter().filter(|times| (times.model, times.threads, times.what) == (model.name(), threads, what));
        own.map(time).min_by(f64::total_cmp)
    };
    let mut counts: Vec<usize> = times.iter().map(|times| times.threads).collect();
    counts.sort_unstable();
    counts.dedup();
    let mut ratios = Vec::new();
    for model in Model::ALL {
        let ratio = |name, threads, one: (usize, What), other: (usize, What)| {
            let divided = |time| Some(least(model, one.0, one.1, time)? / least(model, other.0, other.1, time)?);
            let [of_best, of_medians] = [divided(|times| times.best)?, divided(|times| times.median)?];
            Some(Ratio { model: model.name(), threads, name, of_best, of_medians })
        };
        for threads in &counts {
            ratios.extend(
                RATIOS.iter().filter_map(|(name, one, other)| ratio(*name, *threads, (*threads, *one), (*threads, *other))),
            );
            if *threads > 1 {
                ratios.extend(ratio("full, 1 thread / all", *threads, (1, What::Full), (*threads, What::Full)));
            }
        }
    }
    ratios
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Report { session, size: [width, height], lanes, hits, records, rounds, .. } = self;
        writeln!(f, "{session}, {width}x{height} pixels, {hits} hits, {records} lit records, {rounds} rounds")?;
        writeln!(f, "vectors of {lanes} lanes")?;
        writeln!(f, "other programs used {:.0} % of the processors", 100.0 * self.others)?;
        for reason in &self.missing {
            writeln!(f, "not measured: {reason}")?;
        }
        writeln!(f, "\nlargest difference of linear components, over max(1, value)")?;
        for Agreement { model, peer, largest, beyond } in &self.agreement {
            writeln!(f, "  {model:<9}{peer:<22}{largest:>10.1e}{beyond:>6} beyond the tolerance")?;
        }
        let mut heading = String::new();
        let mut head = |f: &mut fmt::Formatter, model: &str, threads: usize, columns: [&str; 2]| {
            let mut wanted = String::new();
            write!(wanted, "{model}, {threads} thread{}", if threads == 1 { "" } else { "s" })?;
            if wanted == heading {
                return Ok(());
            }
            heading = wanted;
            writeln!(f, "\n{heading:<54}{:>10}{:>10}", columns[0], columns[1])
        };
        for Times { model, threads, what, detail, best, median, .. } in &self.times {
            head(f, model, *threads, ["best", "median"])?;
            writeln!(f, "  {:<20}{detail:<32}{best:>10.3}{median:>10.3} ms", what.to_string())?;
        }
        for Ratio { model, threads, name, of_best, of_medians } in &self.ratios {
            head(f, model, *threads, ["best", "medians"])?;
            writeln!(f, "  {name:<52}{of_best:>10.3}{of_medians:>10.3}")?;
        }
        Ok(())
    }
}
