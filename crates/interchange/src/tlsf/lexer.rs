//! Splits a TLSF text into tokens, without comments: `//` to the end of the line, and `/* ... */`,
//! which nest.

use super::report::Report;
use std::ops::Range;

/// A token kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Word {
    /// A name or a keyword, depending on the context.
    Name,
    /// Digits.
    Number,
    /// A text in quotation marks.
    Text,
    /// An operator or a bracket.
    Sign,
}

/// A token kind and its byte range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Token {
    pub word: Word,
    pub range: Range<usize>,
}

/// Operators and brackets, the longest first.
const SIGNS: [&str; 35] = [
    "<->", "(\\)", "(-)", "(+)", "(*)", "&&", "||", "->", "<-", "==", "/=", "!=", "<=", ">=", "..",
    "{", "}", "(", ")", "[", "]", ";", ",", ":", "=", "!", "<", ">", "+", "-", "*", "/", "%", "|",
    "~",
];

/// Splits a text into tokens; reports each run of invalid characters.
pub(super) fn words(text: &str, report: &mut Report) -> Vec<Token> {
    let mut found = Vec::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        if c.is_whitespace() || c == '\u{feff}' {
            at += c.len_utf8();
        } else if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at = comment(text, at, report);
        } else if c == '"' {
            let inner = rest[1..].find('"');
            let end = inner.map_or(text.len(), |i| at + i + 2);
            if inner.is_none() {
                report.syntax(
                    at..at + 1,
                    "this text is not closed",
                    "close it with a quotation mark",
                );
            }
            found.push(Token {
                word: Word::Text,
                range: at..end,
            });
            at = end;
        } else if c.is_ascii_digit() {
            let end = run(bytes, at, |b| b.is_ascii_digit());
            found.push(Token {
                word: Word::Number,
                range: at..end,
            });
            at = end;
        } else if c.is_ascii_alphabetic() || c == '_' || c == '@' {
            let end = run(bytes, at, |b| {
                b.is_ascii_alphanumeric() || matches!(b, b'_' | b'@' | b'\'')
            });
            found.push(Token {
                word: Word::Name,
                range: at..end,
            });
            at = end;
        } else if let Some(sign) = SIGNS.iter().find(|s| rest.starts_with(**s)) {
            found.push(Token {
                word: Word::Sign,
                range: at..at + sign.len(),
            });
            at += sign.len();
        } else {
            let strange =
                |c: char| !c.is_ascii() || c.is_ascii_control() || "#$?`\\^&'.".contains(c);
            let end = rest.find(|c: char| !strange(c) || c.is_whitespace());
            let end = end.map_or(text.len(), |i| at + i.max(c.len_utf8()));
            report.syntax(
                at..end,
                format!("`{}` is not valid here", super::super::names::quoted(&text[at..end])),
                "use `&&`, `||`, `!`, `->`, `<->`, `==` and names of letters, digits, `_`, `@` and `'`",
            );
            at = end;
        }
    }
    found
}

fn run(bytes: &[u8], from: usize, of: impl Fn(u8) -> bool) -> usize {
    from + bytes[from..].iter().take_while(|b| of(**b)).count()
}

/// The end of the comment that begins at `start`.
fn comment(text: &str, start: usize, report: &mut Report) -> usize {
    let bytes = text.as_bytes();
    let (mut at, mut open) = (start + 2, 1_usize);
    while at < bytes.len() {
        match bytes.get(at..at + 2) {
            Some(b"/*") => (open, at) = (open + 1, at + 2),
            Some(b"*/") => {
                (open, at) = (open - 1, at + 2);
                if open == 0 {
                    return at;
                }
            }
            _ => at += 1,
        }
    }
    report.syntax(
        start..start + 2,
        "this comment is not closed",
        "close it with `*/`; comments nest, so each `/*` needs its own",
    );
    text.len()
}

/// The text on one line, without comments.
pub(super) fn one_line(text: &str) -> String {
    let mut silent = Report::silent();
    let tokens = words(text, &mut silent);
    let mut line = String::new();
    let mut end = 0;
    for token in tokens {
        if !line.is_empty() && token.range.start > end {
            line.push(' ');
        }
        line.push_str(&text[token.range.clone()]);
        end = token.range.end;
    }
    line
}
