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
}

/// Why there is no room for one more file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoRoom {
    /// There are too many.
    Number,
    /// They take too much memory.
    Memory,
}

impl<T, const MOST: usize> NumberedFiles<T, MOST> {
    /// Nothing yet. All contents together may take this many bytes.
    pub const fn new(most_bytes: u64) -> Self {
        Self { kept: [const { OnceLock::new() }; MOST], taken: Mutex::new((FIRST, 0)), most_bytes }
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
            Err(NoRoom::Number)
        } else if bytes.saturating_add(more) > self.most_bytes {
            Err(NoRoom::Memory)
        } else {
            Ok(())
        }
    }

    /// Keeps what was read from a file, which takes this many bytes, and gives it a number greater than 0.
    ///
    /// # Errors
    /// There are too many files, or they would take too much memory.
    pub fn keep(&self, path: PathBuf, content: T, bytes: u64) -> Result<f32, NoRoom> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        self.fits(*taken, bytes)?;
        let number = taken.0;
        let place = self.kept.get(number).ok_or(NoRoom::Number)?;
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
        static STORE: NumberedFiles<&str, 258> = NumberedFiles::new(100);
        let one = STORE.keep(PathBuf::from("one"), "first", 60).expect("room");
        assert_eq!((STORE.numbered(one), STORE.path_of(one)), (Some(&"first"), Some(Path::new("one"))));
        assert_eq!(STORE.keep(PathBuf::from("large"), "large", 41), Err(NoRoom::Memory));
        assert_eq!((STORE.check_room(40), STORE.check_room(u64::MAX)), (Ok(()), Err(NoRoom::Memory)));
        let other = STORE.keep(PathBuf::from("two"), "second", 40).expect("room");
        assert_eq!((STORE.numbered(other), other), (Some(&"second"), one + 1.0));
        assert_eq!(STORE.keep(PathBuf::from("three"), "third", 0), Err(NoRoom::Number));
        for number in [0.0, -1.0, f32::NAN, f32::INFINITY, 257.6, 1e30] {
            assert!(STORE.numbered(number).is_none() && STORE.path_of(number).is_none(), "{number}");
        }
    }
}
