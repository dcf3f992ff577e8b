//! Libraries read, saved and met by formulas.
