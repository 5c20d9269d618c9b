//! Splits a file into comments and words.
//!
//! Strings, comments and words are split as in the grammar: `//` within quotes does not begin a
//! comment, and `/*` or a quote within a line comment has no meaning. The printer needs the
//! comments because the tree contains only some doc comments.

/// Kinds of comments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Line,
    Doc,
    Block,
}

/// A comment.
#[derive(Debug, Clone)]
pub(super) struct Comment {
    /// Text without trailing blanks, with `\n` between its lines.
    pub text: String,
    /// Offset of the comment's first byte.
    pub start: usize,
    kind: Kind,
    /// Whether only blanks precede the comment on its line.
    pub own_line: bool,
    /// Whether an empty line precedes the comment.
    pub blank_before: bool,
    /// Whether only blanks follow the comment on its line.
    pub newline_after: bool,
}

impl Comment {
    /// Returns whether the comment extends to the end of its line.
    pub fn line(&self) -> bool {
        self.kind != Kind::Block
    }

    /// Returns whether the comment is a doc comment `///`, which belongs to the next item.
    pub fn doc(&self) -> bool {
        self.kind == Kind::Doc
    }
}

/// A word, number, string or symbol.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token {
    /// Offset of the token's first byte.
    pub start: usize,
    /// Offset of the token's end.
    pub end: usize,
    /// Whether an empty line precedes the token.
    pub blank_before: bool,
}

/// Comments and tokens, in order.
#[derive(Debug, Default)]
pub(super) struct Cut {
    pub comments: Vec<Comment>,
    pub tokens: Vec<Token>,
}

/// Splits a text into comments and tokens.
pub(super) fn cut(text: &str) -> Cut {
    let mut cut = Cut::default();
    let (mut i, mut gap) = (0, 0);
    while let Some(c) = text[i..].chars().next() {
        let rest = &text[i..];
        if c.is_whitespace() || c == '\u{feff}' {
            i += c.len_utf8();
            continue;
        }
        let breaks = newlines(&text[gap..i]);
        let line = rest.starts_with("//");
        let length = if line {
            rest.find(['\n', '\r'])
        } else if let Some(comment) = rest.strip_prefix("/*") {
            comment.find("*/").map(|n| n + 4)
        } else if let Some(quoted) = rest.strip_prefix('"') {
            Some(quoted.find(['"', '\n', '\r']).map_or(1, |n| n + 2))
        } else if is_word(c) {
            rest.find(|c| !is_word(c))
        } else {
            Some(c.len_utf8())
        };
        let end = i + length.unwrap_or(rest.len()).min(rest.len());
        if line || rest.starts_with("/*") {
            let after = text[end..].trim_start_matches([' ', '\t', '\u{feff}']);
            cut.comments.push(Comment {
                text: text[i..end]
                    .trim_end()
                    .replace("\r\n", "\n")
                    .replace('\r', "\n"),
                start: i,
                kind: match line {
                    true if rest.starts_with("///") && !rest.starts_with("////") => Kind::Doc,
                    true => Kind::Line,
                    false => Kind::Block,
                },
                own_line: breaks > 0 || gap == 0,
                blank_before: breaks > 1,
                newline_after: after.is_empty() || after.starts_with(['\n', '\r']),
            });
        } else {
            cut.tokens.push(Token {
                start: i,
                end,
                blank_before: breaks > 1,
            });
        }
        (i, gap) = (end, end);
    }
    cut
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Returns the number of line ends in a text.
pub(super) fn newlines(text: &str) -> usize {
    let returns = text.matches('\r').count();
    returns + text.matches('\n').count() - text.matches("\r\n").count()
}

/// Keywords of operators, most of which the formatter may write with another spelling, and the last
/// word of `within 5 steps`.
const SPELLINGS: &[&str] = &[
    "always",
    "eventually",
    "until",
    "unless",
    "release",
    "U",
    "W",
    "R",
    "next",
    "not",
    "and",
    "or",
    "xor",
    "implies",
    "iff",
    "mod",
    "GF",
    "G",
    "F",
    "X",
    "O",
    "step",
    "steps",
];

/// Returns the words, numbers and strings of a file, without the words in [`SPELLINGS`].
pub(super) fn words<'t>(text: &'t str, cut: &Cut) -> Vec<&'t str> {
    cut.tokens
        .iter()
        .map(|t| &text[t.start..t.end])
        .filter(|w| w.starts_with(|c| is_word(c) || c == '"'))
        .flat_map(|w| {
            if w.starts_with(|c: char| c.is_ascii_digit()) {
                // A word can follow a number directly, as in `1B`.
                let end = w.find(|c: char| !c.is_ascii_digit()).unwrap_or(w.len());
                let (number, rest) = w.split_at(end);
                let rest = (!rest.is_empty()).then_some(rest);
                std::iter::once(number.trim_start_matches('0')).chain(rest)
            } else {
                std::iter::once(w).chain(None)
            }
        })
        .filter(|w| !SPELLINGS.contains(w))
        .collect()
}
