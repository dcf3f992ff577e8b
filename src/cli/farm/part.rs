//! A part of the work: `3/20` is the third of twenty.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// A job has at most this many parts. Slurm takes about a thousand by default, others take more.
pub(in crate::cli) const MOST_PARTS: u32 = 10_000;

/// A part of the work, by its number from 1 and how many there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cli) struct WorkPart {
    number: u32,
    of: u32,
}

impl FromStr for WorkPart {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("expected a part such as 3/20: the third of twenty, of at most {MOST_PARTS}");
        let (number, of) = text.split_once('/').ok_or_else(form)?;
        let [number, of] = [number, of].map(|number| number.trim().parse::<u32>().ok());
        match (number, of) {
            (Some(number), Some(of)) if (1..=of).contains(&number) && of <= MOST_PARTS => Ok(Self { number, of }),
            _ => Err(form()),
        }
    }
}

impl fmt::Display for WorkPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl WorkPart {
    /// Its share of `count` things, by index. The shares of all parts are all things, each once, and their sizes differ
    /// by at most 1.
    pub(in crate::cli) fn share(self, count: u32) -> Range<u32> {
        let bound = |part: u32| (u64::from(part) * u64::from(count) / u64::from(self.of)) as u32;
        bound(self.number - 1)..bound(self.number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_things_once() {
        for (count, of) in [(200, 7), (5, 9), (0, 3), (10_000, 10_000), (u32::MAX, 3)] {
            let part = |number| WorkPart { number, of }.share(count);
            let mut end = 0;
            let mut sizes = Vec::new();
            for number in 1..=of {
                let share = part(number);
                assert_eq!(share.start, end);
                end = share.end;
                sizes.push(share.len());
            }
            assert_eq!(end, count);
            assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
        }
    }

    #[test]
    fn parts_are_read() {
        assert_eq!("3/20".parse(), Ok(WorkPart { number: 3, of: 20 }));
        assert_eq!("3/20".parse::<WorkPart>().unwrap().to_string(), "3/20");
        for text in ["0/5", "6/5", "3", "/", "3/", "a/b", "-1/5", "1/10001", "1/99999999999"] {
            assert!(text.parse::<WorkPart>().is_err(), "{text}");
        }
    }
}
