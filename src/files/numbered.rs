//! What was read from files, each with a number: for values of parameters, which are numbers.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The first number. Unit tests apply all operations to small numbers, which stay those of nothing.
const FIRST: usize = if cfg!(test) { 256 } else { 1 };

/// Contents of files by their numbers, at most `MOST` of them. They are kept until the program ends, because their
/// numbers may be anywhere: in compiled code, in values, and in steps of undo. 0 is the number of nothing.
#[derive(Debug)]
pub struct NumberedFiles<T, const MOST: usize> {
    kept: [OnceLock<(PathBuf, T)>; MOST],
    /// The next number, and how many bytes all contents take.
    taken: Mutex<(usize, u64)>,
    /// The most bytes that they may take.
    most_bytes: u64,
    /// What they are, in the plural.
    what: &'static str,
}

/// Why there is no room for one more file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoRoom {
    /// There are too many.
    #[error("there are more than {most} {what}")]
    Number {
        /// What they are.
        what: &'static str,
        /// The most that there can be.
        most: usize,
    },
    /// They take too much memory.
    #[error("all {what} together, and reading this one, take more than {} GiB of memory", most_bytes >> 30)]
    Memory {
        /// What they are.
        what: &'static str,
        /// The most that they may take.
        most_bytes: u64,
    },
}

impl<T, const MOST: usize> NumberedFiles<T, MOST> {
    /// Nothing yet. All contents together may take this many bytes; `what` they are is for messages, in the plural.
    pub const fn new(what: &'static str, most_bytes: u64) -> Self {
        Self { kept: [const { OnceLock::new() }; MOST], taken: Mutex::new((FIRST, 0)), most_bytes, what }
    }

    /// Whether there is room for this many bytes beside what is there.
    ///
    /// # Errors
    /// There are too many files, or they would take too much memory.
    pub fn check_room(&self, more: u64) -> Result<(), NoRoom> {
        self.fits(*self.taken.lock().unwrap_or_else(PoisonError::into_inner), more)
    }

    fn fits(&self, (next, bytes): (usize, u64), more: u64) -> Result<(), NoRoom> {
        if next >= MOST {
            Err(self.too_many())
        } else if bytes.saturating_add(more) > self.most_bytes {
            Err(NoRoom::Memory { what: self.what, most_bytes: self.most_bytes })
        } else {
            Ok(())
        }
    }

    fn too_many(&self) -> NoRoom {
        NoRoom::Number { what: self.what, most: MOST }
    }

    /// Keeps what was read from a file, which takes this many bytes, and gives it a number greater than 0.
    ///
    /// # Errors
    /// There are too many files, or they would take too much memory.
    pub fn keep(&self, path: PathBuf, content: T, bytes: u64) -> Result<f32, NoRoom> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        self.fits(*taken, bytes)?;
        let number = taken.0;
        let place = self.kept.get(number).ok_or(self.too_many())?;
        place.get_or_init(|| (path, content));
        *taken = (number + 1, taken.1.saturating_add(bytes));
        Ok(number as f32)
    }

    fn kept(&self, number: f32) -> Option<&(PathBuf, T)> {
        // NaN and negative numbers become 0.
        self.kept.get((number + 0.5) as usize)?.get()
    }

    /// What has a number; `None` for numbers that nothing has.
    pub fn numbered(&self, number: f32) -> Option<&T> {
        self.kept(number).map(|(_, content)| content)
    }

    /// The file that has a number.
    pub fn path_of(&self, number: f32) -> Option<&Path> {
        self.kept(number).map(|(path, _)| path.as_path())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lead_to_contents_as_long_as_there_is_room() {
        static STORE: NumberedFiles<&str, 258> = NumberedFiles::new("words", 3 << 30);
        let part = 1 << 30;
        let one = STORE.keep(PathBuf::from("one"), "first", 2 * part).expect("room");
        assert_eq!((STORE.numbered(one), STORE.path_of(one)), (Some(&"first"), Some(Path::new("one"))));
        let large = STORE.keep(PathBuf::from("large"), "large", part + 1).expect_err("no room");
        assert_eq!(large.to_string(), "all words together, and reading this one, take more than 3 GiB of memory");
        assert_eq!((STORE.check_room(part), STORE.check_room(u64::MAX)), (Ok(()), Err(large)));
        let other = STORE.keep(PathBuf::from("two"), "second", part).expect("room");
        assert_eq!((STORE.numbered(other), other), (Some(&"second"), one + 1.0));
        let many = STORE.keep(PathBuf::from("three"), "third", 0).expect_err("no room");
        assert_eq!(many.to_string(), "there are more than 258 words");
        for number in [0.0, -1.0, f32::NAN, f32::INFINITY, 257.6, 1e30] {
            assert!(STORE.numbered(number).is_none() && STORE.path_of(number).is_none(), "{number}");
        }
    }
}
