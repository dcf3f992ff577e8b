//! Rust source as a list of words and marks: no comments, no literals, and nothing that is compiled for tests alone.

/// A piece of Rust source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Token {
    /// An identifier, a keyword or a number.
    Word(String),
    /// `::`
    PathSeparator,
    /// Any other character; of a mark like `->`, each.
    Mark(char),
}

impl Token {
    /// The text of a word.
    pub(crate) fn word(&self) -> Option<&str> {
        match self {
            Token::Word(word) => Some(word),
            Token::PathSeparator | Token::Mark(_) => None,
        }
    }
}

/// The tokens of a source file. A literal is left out; nothing that matters here is written in one.
pub(crate) fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if let Some(length) = string(rest) {
            length
        } else if first == '\'' {
            character_or_lifetime(rest)
        } else if first == '_' || first.is_alphanumeric() {
            let length = rest.find(|c: char| c != '_' && !c.is_alphanumeric()).unwrap_or(rest.len());
            tokens.push(Token::Word(rest[..length].to_owned()));
            length
        } else if rest.starts_with("::") {
            tokens.push(Token::PathSeparator);
            2
        } else {
            tokens.push(Token::Mark(first));
            first.len_utf8()
        };
        rest = &rest[length..];
    }
    tokens
}

/// How long the comment is, with the comments in it.
fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    let mut at = 0;
    loop {
        let Some(next) = text[at..].find("/*").into_iter().chain(text[at..].find("*/")).min() else { return text.len() };
        at += next + 2;
        depth += if text[at - 2..].starts_with("/*") { 1 } else { -1 };
        if depth == 0 {
            return at;
        }
    }
}

/// How long the string literal is that stands at the beginning, if one does.
fn string(text: &str) -> Option<usize> {
    let prefix = text.bytes().take_while(|byte| b"bcr".contains(byte)).count();
    let raw = text[..prefix].ends_with('r');
    let hashes = if raw { text[prefix..].bytes().take_while(|byte| *byte == b'#').count() } else { 0 };
    let start = prefix + hashes;
    if prefix > 2 || !text[start..].starts_with('"') {
        return None;
    }
    if raw {
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(text[start + 1..].find(&end).map_or(text.len(), |length| start + 1 + length + end.len()));
    }
    let mut escaped = false;
    let end = text[start + 1..].find(|c: char| {
        let ends = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    Some(end.map_or(text.len(), |length| start + 1 + length + 1))
}

/// How long the character literal is, or the mark before a lifetime.
fn character_or_lifetime(text: &str) -> usize {
    let mut characters = text.char_indices().skip(1);
    match (characters.next(), characters.next()) {
        (Some((_, '\\')), Some((at, escaped))) => {
            let behind = at + escaped.len_utf8();
            text[behind..].find('\'').map_or(text.len(), |length| behind + length + 1)
        }
        (Some(_), Some((at, '\''))) => at + 1,
        _ => 1,
    }
}

/// The tokens without the items under `#[cfg(test)]`.
pub(crate) fn without_tests(tokens: &[Token]) -> Vec<Token> {
    let mut kept = Vec::with_capacity(tokens.len());
    let mut at = 0;
    while at < tokens.len() {
        match attribute(&tokens[at..]) {
            Some(length) if is_test(&tokens[at..at + length]) => {
                at += length;
                while let Some(another) = attribute(&tokens[at..]) {
                    at += another;
                }
                at += item(&tokens[at..]);
            }
            _ => {
                kept.push(tokens[at].clone());
                at += 1;
            }
        }
    }
    kept
}

/// How many tokens the attribute at the beginning has, if one stands there.
fn attribute(tokens: &[Token]) -> Option<usize> {
    matches!(tokens, [Token::Mark('#'), Token::Mark('['), ..]).then(|| 1 + group(&tokens[1..]))
}

fn is_test(attribute: &[Token]) -> bool {
    let has = |word: &str| attribute.iter().any(|token| token.word() == Some(word));
    has("cfg") && has("test") && !has("not")
}

/// How many tokens the group in brackets has that begins here.
fn group(tokens: &[Token]) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate() {
        match token {
            Token::Mark('(' | '[' | '{') => depth += 1,
            Token::Mark(')' | ']' | '}') => depth -= 1,
            Token::Word(_) | Token::PathSeparator | Token::Mark(_) => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    tokens.len()
}

/// How many tokens the item has that begins here: up to a `;`, or to the end of a body.
fn item(tokens: &[Token]) -> usize {
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        match token {
            Token::Mark(';') => return at + 1,
            Token::Mark('{') => return at + group(&tokens[at..]),
            Token::Mark('(' | '[') => at += group(&tokens[at..]),
            Token::Word(_) | Token::PathSeparator | Token::Mark(_) => at += 1,
        }
    }
    at
}

#[test]
fn comments_literals_and_tests_are_left_out() {
    let text = r##"
        // crate::a
        /* crate::b /* */ crate::c */
        const A: &str = "crate::d \" // "; const B: [char; 3] = ['"', '\'', 'c']; const C: &str = r#"crate::e " "#;
        fn f<'a>(x: &'a str) -> u8 { b'"' }
        #[cfg(test)]
        #[allow(unused)]
        fn g() -> [u8; 2] { if true { crate::h() } }
        #[cfg(test)]
        mod tests;
        #[cfg(not(test))]
        use crate::{i};
    "##;
    let shown: String = without_tests(&tokens(text))
        .iter()
        .map(|token| match token {
            Token::Word(word) => format!("{word} "),
            Token::PathSeparator => ":: ".to_owned(),
            Token::Mark(mark) => mark.to_string(),
        })
        .collect();
    assert_eq!(
        shown,
        "const A :&str =;const B :[char ;3 ]=[,,];const C :&str =;fn f <a >(x :&a str )->u8 {b }#[cfg (not (test ))]use crate :: {i };"
    );
}
