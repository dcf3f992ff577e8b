//! Only the definitions that a kernel needs: the driver compiles all of them for each formula, and the table of noise
//! takes memory of each pixel.

/// The text, with those of the definitions that it names, and those that these name.
pub(super) fn with_definitions(mut text: String, definitions: &[String]) -> String {
    let mut left: Vec<&String> = definitions.iter().collect();
    loop {
        let count = left.len();
        left.retain(|definition| {
            let is_needed = names(definition).any(|name| has_word(&text, name));
            if is_needed {
                text.push('\n');
                text.push_str(definition);
                text.push('\n');
            }
            !is_needed
        });
        if left.len() == count {
            return text;
        }
    }
}

/// The names that a piece of text defines.
fn names(definition: &str) -> impl Iterator<Item = &str> {
    definition.lines().filter_map(|line| {
        let rest = ["fn ", "const ", "struct "].iter().find_map(|kind| line.strip_prefix(kind))?;
        rest.split(|letter: char| !is_part(letter)).next()
    })
}

fn is_part(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_'
}

/// Whether a text has a word.
fn has_word(text: &str, word: &str) -> bool {
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back().is_some_and(is_part);
        let after = text[at + word.len()..].chars().next().is_some_and(is_part);
        !before && !after
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_come_with_those_that_they_need() {
        let definitions =
            ["fn one() { two(); }", "const TWO: f32 = 2.0;", "fn two() { TWO; }", "fn three() {}", "fn twofold() {}"];
        let text = with_definitions("one".to_owned(), &definitions.map(str::to_owned));
        assert!(["fn one", "fn two()", "TWO: f32"].iter().all(|needed| text.contains(needed)), "{text}");
        assert!(!text.contains("three") && !text.contains("twofold"), "{text}");
    }
}
