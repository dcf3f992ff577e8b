//! The comments that describe a statement: those behind it, inside it, or above it.

use crate::lang::lines::{LINE_ENDS, line_start};
use crate::lang::source::SourceSpan;

/// What the author says about a statement, as one line: the comment behind it on its last line; otherwise the comments
/// inside it; otherwise those directly above it. `comments` are all comments of the text, in order.
///
/// A comment behind a statement goes on in the lines below it if they hold nothing but comments in the same column.
pub fn doc(text: &str, comments: &[SourceSpan], statement: SourceSpan) -> Option<String> {
    let after = comments.partition_point(|comment| comment.start < statement.end);
    let before = comments.partition_point(|comment| comment.start < statement.start);
    let behind = &comments[after..after + behind(text, &comments[after..], statement.end)];
    let above = || &comments[before - above(text, &comments[..before], statement.start)..before];
    [behind, &comments[before..after]].into_iter().find_map(|found| written(text, found)).or_else(|| written(text, above()))
}

/// How many of the comments are behind what ends at a byte.
fn behind(text: &str, comments: &[SourceSpan], end: u32) -> usize {
    let mut count = 0;
    let mut at = end;
    for comment in comments {
        let gap = gap(text, at, comment.start);
        let goes_on = || column(text, *comment) == column(text, comments[0]) && is_alone(text, *comment);
        let belongs = match line_ends(gap) {
            0 => true,
            1 => count > 0 && goes_on(),
            _ => false,
        };
        if !gap.trim().is_empty() || !belongs {
            break;
        }
        at = comment.end;
        count += 1;
    }
    count
}

/// How many of the comments, counted from the last, are directly above what starts at a byte.
fn above(text: &str, comments: &[SourceSpan], start: u32) -> usize {
    let mut count = 0;
    let mut at = start;
    for (index, comment) in comments.iter().enumerate().rev() {
        let gap = gap(text, comment.end, at);
        if !gap.trim().is_empty() || line_ends(gap) > 1 {
            break;
        }
        if !is_alone(text, *comment) {
            // It is behind something else. If the comments below it are in its column, they go on with it.
            let goes_on = comments.get(index + 1).is_some_and(|next| column(text, *next) == column(text, *comment));
            return if goes_on { 0 } else { count };
        }
        at = comment.start;
        count += 1;
    }
    count
}

fn gap(text: &str, from: u32, to: u32) -> &str {
    text.get(from as usize..to as usize).unwrap_or_default()
}

/// The number of line ends in white space.
fn line_ends(gap: &str) -> usize {
    gap.replace("\r\n", "\n").matches(LINE_ENDS).count()
}

/// The characters before a comment on its line.
fn column(text: &str, comment: SourceSpan) -> usize {
    let start = comment.start as usize;
    text[line_start(text.as_bytes(), start)..start].chars().count()
}

/// Whether nothing is before a comment on its line.
fn is_alone(text: &str, comment: SourceSpan) -> bool {
    let start = comment.start as usize;
    text[line_start(text.as_bytes(), start)..start].trim_start_matches('\u{feff}').trim().is_empty()
}

/// The words of comments as one line, without the marks around them; `None` if there are none.
fn written(text: &str, comments: &[SourceSpan]) -> Option<String> {
    let lines = comments.iter().flat_map(|comment| {
        let comment = &text[comment.range()];
        let inner = comment.strip_prefix("/*").map(|inner| inner.strip_suffix("*/").unwrap_or(inner));
        inner.unwrap_or(comment).split(LINE_ENDS)
    });
    // Lines of dashes only separate.
    let lines = lines
        .map(|line| line.trim().trim_start_matches(['/', '*', '!']).trim_end_matches(['*', ' ']))
        .filter(|line| line.contains(char::is_alphanumeric));
    let words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    (!words.is_empty()).then(|| words.join(" "))
}

#[cfg(test)]
mod tests {
    use crate::lang::parser::parse;
    use crate::lang::source::Source;

    /// What is said about each parameter, in order.
    fn docs(text: &str) -> Vec<Option<String>> {
        let (file, diagnostics) = parse(&Source::new("t", format!("{text}\nformula;\n= Cd;\n")));
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        file.declarations().map(|declaration| declaration.doc.clone()).collect()
    }

    fn some(text: &str) -> Option<String> {
        Some(text.to_owned())
    }

    #[test]
    fn a_comment_behind_a_declaration_counts_before_one_above_it() {
        let text =
            "global; // of the scene\n// above a\na: scalar; // matte part\nb: scalar;   /* the\n  rest */  // of it\nc: scalar;";
        assert_eq!(docs(text), [some("matte part"), some("the rest of it"), None]);
    }

    #[test]
    fn a_comment_above_belongs_to_the_next_line_only() {
        let text = "global;\n// far away\n\n// two\n//   lines\na: scalar;\nb: scalar; // behind b\n// above c\nc: scalar;";
        assert_eq!(docs(text), [some("two lines"), some("behind b"), some("above c")]);
        assert_eq!(docs("// of the file\nglobal;\na: scalar;"), [None]);
    }

    #[test]
    fn a_comment_goes_on_in_its_column() {
        let text = "global;\na: scalar;  // one\n            // two\nb: scalar;\nc: scalar; d: scalar; // of d";
        assert_eq!(docs(text), [some("one two"), None, None, some("of d")]);
        let text = "global;\na: scalar, choices \"č\", \"ž\";  // one\n                              // two";
        assert_eq!(docs(text), [some("one two")]);
    }

    #[test]
    fn a_comment_inside_counts_and_lines_of_dashes_do_not() {
        let text = "global;\n// ------\na: scalar;\nb: scalar, // sharpness\n  default -1;\n/// for all\r\nc: scalar;\n/*** -1: dark ***/\nd: scalar;";
        assert_eq!(docs(text), [None, some("sharpness"), some("for all"), some("-1: dark")]);
    }
}
