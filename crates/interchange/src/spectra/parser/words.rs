//! Splits a Spectra file into tokens.

use std::ops::Range;

/// A token kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Word {
    /// A name or a keyword.
    Name,
    /// A whole number without a sign.
    Number,
    /// A text in quotes.
    Quoted,
    /// An operator or a bracket.
    Sign(&'static str),
    /// A character outside the language.
    Stray,
    /// The end of the file.
    End,
}

/// A token kind and its byte range.
pub(super) type Token = (Word, Range<usize>);

/// Operators and brackets. A sign comes before any other sign that is a prefix of it, because the
/// first match is taken.
const SIGNS: [&str; 30] = [
    "<->", "|=>", ":=", "..", "->", "!=", "<=", ">=", "<", ">", "=", "(", ")", "{", "}", "[", "]",
    ",", ";", ":", ".", "&", "|", "!", "+", "-", "*", "/", "%", "~",
];

/// The tokens of a text without its comments `-- ...`, `// ...`, `/* ... */`; the last token is
/// [`Word::End`].
pub(super) fn words(text: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &text[at..];
        if rest.starts_with("--") || rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
            continue;
        }
        if let Some(comment) = rest.strip_prefix("/*") {
            at += comment.find("*/").map_or(rest.len(), |end| end + 4);
            continue;
        }
        // Some editors write a byte order mark at the start of a file.
        if rest.starts_with('\u{feff}') {
            at += '\u{feff}'.len_utf8();
            continue;
        }
        let (word, length) = match bytes[at] {
            c if c.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            c if c.is_ascii_alphabetic() || c == b'_' => (
                Word::Name,
                run(rest, |c| c.is_ascii_alphanumeric() || c == b'_'),
            ),
            // Xtext allows a keyword as a name after this sign.
            b'^' if rest[1..].starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') => (
                Word::Name,
                1 + run(&rest[1..], |c| c.is_ascii_alphanumeric() || c == b'_'),
            ),
            c if c.is_ascii_digit() => (Word::Number, run(rest, |c| c.is_ascii_digit())),
            quote @ (b'"' | b'\'') => match rest[1..].find([char::from(quote), '\n']) {
                Some(end) if rest.as_bytes()[end + 1] == quote => (Word::Quoted, end + 2),
                _ => (Word::Stray, 1),
            },
            b'?' => (Word::Sign("?"), 1),
            _ => match SIGNS.into_iter().find(|s| rest.starts_with(s)) {
                Some(sign) => (Word::Sign(sign), sign.len()),
                None => (Word::Stray, rest.chars().next().map_or(1, char::len_utf8)),
            },
        };
        found.push((word, at..at + length));
        at += length;
    }
    found.push((Word::End, text.len()..text.len()));
    found
}

fn run(text: &str, of: impl Fn(u8) -> bool) -> usize {
    let end = text.bytes().position(|c| !of(c));
    end.unwrap_or(text.len())
}

/// The text on one line, without comments.
pub(in crate::spectra) fn one_line(text: &str) -> String {
    let mut line = String::new();
    let mut last = 0;
    for (word, range) in words(text) {
        if word == Word::End {
            break;
        }
        if range.start > last && !line.is_empty() {
            line.push(' ');
        }
        last = range.end;
        line.push_str(&text[range]);
    }
    line
}
