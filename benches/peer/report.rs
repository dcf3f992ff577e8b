//! What was measured, as a table and as JSON.

use crate::stage::Model;
use serde::Serialize;
use std::fmt::{self, Write};

/// Everything that is told.
#[derive(Serialize)]
pub(crate) struct Report {
    pub(crate) session: &'static str,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) hits: u64,
    pub(crate) records: u64,
    /// How many rounds count.
    pub(crate) rounds: usize,
    /// How busy other programs kept the processors meanwhile, 0 to 1.
    pub(crate) others: f32,
    /// The peers that were not measured, and why.
    pub(crate) missing: Vec<String>,
    pub(crate) agreement: Vec<Agreement>,
    pub(crate) times: Vec<Times>,
    pub(crate) ratios: Vec<Ratio>,
}

/// How far a peer's picture is from ours.
#[derive(Serialize)]
pub(crate) struct Agreement {
    pub(crate) model: &'static str,
    pub(crate) peer: String,
    /// The largest difference, divided by the component's magnitude where that is above 1.
    pub(crate) largest: f32,
    /// How many components are beyond the tolerance.
    pub(crate) beyond: usize,
}

/// The time that a kind of frame takes, in milliseconds.
#[derive(Serialize)]
pub(crate) struct Times {
    pub(crate) model: &'static str,
    pub(crate) threads: usize,
    pub(crate) what: What,
    /// The slider, or who made the peer.
    pub(crate) detail: String,
    pub(crate) best: f64,
    pub(crate) median: f64,
    /// How often it was measured.
    pub(crate) count: usize,
}

/// What is measured.
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
    /// As many bytes as a frame of weighed images moves, over and over.
    Triad,
    /// The same part of the time for many more bytes.
    TriadInMemory,
    DrjitDirections,
    DrjitDots,
}

impl What {
    /// Whether it takes part in few rounds.
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

/// Each ratio, with the time that is divided and the one that it is divided by.
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

/// The ratios that these times have. Of several compilers the best counts.
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
        let Report { session, size: [width, height], hits, records, rounds, .. } = self;
        writeln!(f, "{session}, {width}x{height} pixels, {hits} hits, {records} lit records, {rounds} rounds")?;
        writeln!(f, "other programs kept the processors busy to {:.0} %", 100.0 * self.others)?;
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
