//! The comments of a file, and where its words stand.
//!
//! Texts, comments and words are cut as the grammar cuts them: `//` within quotes is no comment,
//! and neither is what stands behind one on its line. What is found is put back by the printer: the
//! tree holds no comment but some doc comments.

/// The kinds of comments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Line,
    Doc,
    Block,
}

/// A comment.
#[derive(Debug, Clone)]
pub(super) struct Comment {
    /// All of it, without blanks at its end, with `\n` between its lines.
    pub text: String,
    /// Where it begins.
    pub start: usize,
    kind: Kind,
    /// Whether nothing stands before it on its line.
    pub own_line: bool,
    /// Whether an empty line stands before it.
    pub blank_before: bool,
    /// Whether nothing stands behind it on its line.
    pub newline_after: bool,
}

impl Comment {
    /// Whether it ends with its line.
    pub fn line(&self) -> bool {
        self.kind != Kind::Block
    }

    /// Whether it is `///`, which belongs to what follows.
    pub fn doc(&self) -> bool {
        self.kind == Kind::Doc
    }
}

/// A word, number, text or sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token {
    /// Where it begins.
    pub start: usize,
    /// Where it ends.
    pub end: usize,
    /// Whether an empty line stands before it.
    pub blank_before: bool,
}

/// Comments and words, in order.
#[derive(Debug, Default)]
pub(super) struct Cut {
    pub comments: Vec<Comment>,
    pub tokens: Vec<Token>,
}

/// Cuts a text.
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

/// How many lines end within a text.
pub(super) fn newlines(text: &str) -> usize {
    let returns = text.matches('\r').count();
    returns + text.matches('\n').count() - text.matches("\r\n").count()
}

/// Words and signs of operators, which may be spelled in several ways, and the end of
/// `within 5 steps`.
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

/// The words, numbers and texts of a file, without the words for operators.
pub(super) fn words<'t>(text: &'t str, cut: &Cut) -> Vec<&'t str> {
    cut.tokens
        .iter()
        .map(|t| &text[t.start..t.end])
        .filter(|w| w.starts_with(|c| is_word(c) || c == '"'))
        .flat_map(|w| {
            if w.starts_with(|c: char| c.is_ascii_digit()) {
                // What follows a number need not stand apart from it: `1B`.
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
