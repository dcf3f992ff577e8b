//! Where the lines of a text end: at a line feed (LF), at a carriage return (CR), or at both in this order (CRLF).
//!
//! Nothing else ends a line: U+0085, U+2028 and U+2029 are ordinary characters, as they are in editors. The functions
//! work on bytes, so that they also serve for texts that are not UTF-8.

/// The characters that end a line, alone or as the pair CRLF.
pub const LINE_ENDS: [char; 2] = ['\r', '\n'];

/// The ways to end a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineEnd {
    /// LF.
    LineFeed,
    /// CRLF.
    Both,
    /// CR.
    CarriageReturn,
}

impl LineEnd {
    /// How the first line of a text ends; LF if it has only one line.
    pub fn first_in(text: &str) -> LineEnd {
        let rest = &text[line_end(text.as_bytes(), 0)..];
        let ends = [LineEnd::Both, LineEnd::CarriageReturn];
        ends.into_iter().find(|end| rest.starts_with(end.text())).unwrap_or(LineEnd::LineFeed)
    }

    /// Its characters.
    pub fn text(self) -> &'static str {
        match self {
            LineEnd::LineFeed => "\n",
            LineEnd::Both => "\r\n",
            LineEnd::CarriageReturn => "\r",
        }
    }
}

/// The text with LF at the end of every line.
pub fn with_line_feeds(text: &str) -> String {
    text.replace("\r\n", "\n").replace('\r', "\n")
}

/// Offset of the first byte of the line that holds the byte at `offset`. A line end belongs to the line that it ends.
pub fn line_start(text: &[u8], offset: usize) -> usize {
    let offset = offset.min(text.len());
    (1..=offset).rev().find(|&start| is_behind_line_end(text, start)).unwrap_or(0)
}

/// Offset of the first byte at or after `offset` that belongs to a line end; the length of the text in its last line.
pub fn line_end(text: &[u8], offset: usize) -> usize {
    let offset = offset.min(text.len());
    let rest = &text[offset..];
    rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).map_or(text.len(), |length| offset + length)
}

/// The number of line ends in a text.
pub fn count_line_ends(text: &[u8]) -> usize {
    // Three simple loops, which the compiler vectorises: texts may have millions of lines, and errors are counted from
    // the top.
    let count = |end| text.iter().filter(|byte| **byte == end).count();
    let pairs = || text.windows(2).filter(|two| *two == b"\r\n").count();
    match count(b'\r') {
        0 => count(b'\n'),
        returns => count(b'\n') + returns - pairs(),
    }
}

/// Whether a line end is complete just before `offset`, which is 1 or more: the CR of a CRLF alone is not.
fn is_behind_line_end(text: &[u8], offset: usize) -> bool {
    match text[offset - 1] {
        b'\n' => true,
        b'\r' => text.get(offset) != Some(&b'\n'),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_ends_are_recognised_and_replaced() {
        let texts = [
            ("a", LineEnd::LineFeed),
            ("a\nb\r", LineEnd::LineFeed),
            ("a\r\nb\n", LineEnd::Both),
            ("a\rb\r\n", LineEnd::CarriageReturn),
        ];
        texts.iter().for_each(|(text, end)| assert_eq!(LineEnd::first_in(text), *end, "{text:?}"));
        assert_eq!(with_line_feeds("a\r\nb\rc\n\r\n\u{85}"), "a\nb\nc\n\n\u{85}");
    }

    #[test]
    fn all_three_line_ends_count_once() {
        let text = "ab\ncd\r\nef\rgh\n\r\ni\u{85}\u{2028}\u{2029}".as_bytes();
        // ab LF, cd CRLF, ef CR, gh LF, CRLF.
        assert_eq!(count_line_ends(text), 5);
        let starts: Vec<usize> = (0..text.len()).filter(|&at| line_start(text, at) == at).collect();
        assert_eq!(starts, [0, 3, 7, 10, 13, 15]);
        assert_eq!(line_start(text, 6), 3, "the LF of a CRLF belongs to the line that it ends");
        assert_eq!(line_start(text, 999), 15);
        assert_eq!([0, 2, 3, 5, 7, 10, 13, 15].map(|at| line_end(text, at)), [2, 2, 5, 5, 9, 12, 13, text.len()]);
        assert_eq!((line_start(b"", 5), line_end(b"", 5), count_line_ends(b"")), (0, 0, 0));
    }
}
