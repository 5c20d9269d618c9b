//! From pieces of text and places where a line may end to lines.
//!
//! A statement is a list of pieces. A [`Piece::Break`] is a blank or the end of a line; it ends the
//! line where the author ended it, and where what follows up to the next break of its own or an
//! outer level would not fit. So the outermost operator breaks first, and within one operator lines
//! are filled (Oppen, Prettyprinting, 1980: inconsistent breaking). What the author broke stays
//! broken, so that a formatted text keeps every break it has: formatting it again changes nothing.

use super::comments::Comment;

/// Lines are at most so wide, where a break can be found.
pub(super) const WIDTH: usize = 135;
/// Blanks of one step of indentation.
const INDENT: usize = 4;

/// A part of a statement.
#[derive(Debug, Clone)]
pub(super) enum Piece {
    /// A text without breaks.
    Text(String),
    /// An operand of this level begins.
    Mark { level: usize },
    /// A blank, or nothing, or the end of a line.
    Break {
        level: usize,
        indent: usize,
        blank: bool,
        forced: bool,
    },
    /// An `if ... else if` of so many pieces begins. Its arms stand on one line, or as the author
    /// broke them, or each on its own.
    Ladder { level: usize, length: usize },
    /// A comment within a statement.
    Comment { comment: Comment, indent: usize },
}

/// What stands before the next text.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pending {
    Nothing,
    Line { indent: usize, empty: bool },
}

/// The text that was written so far. Line ends are written late, so that a comment can still go
/// before them.
pub(super) struct Writer {
    text: String,
    pending: Pending,
    row: usize,
    /// Whether the last line ends with a comment that takes all of it.
    closed: bool,
}

impl Writer {
    pub fn new() -> Self {
        Self {
            text: String::new(),
            pending: Pending::Nothing,
            row: 0,
            closed: false,
        }
    }

    /// The text, whose last line ends.
    pub fn finish(mut self) -> String {
        if !self.text.is_empty() {
            self.trim();
            self.text.push('\n');
        }
        self.text
    }

    /// What follows stands on a new line; with `empty`, an empty line stands before it.
    pub fn line(&mut self, indent: usize, empty: bool) {
        if self.text.is_empty() {
            return;
        }
        let before = match self.pending {
            Pending::Line { empty, .. } => empty,
            Pending::Nothing => {
                self.row += 1;
                false
            }
        };
        self.pending = Pending::Line {
            indent,
            empty: empty || before,
        };
    }

    /// Writes a text.
    pub fn text(&mut self, text: &str) {
        if let Pending::Line { indent, empty } = self.pending {
            self.trim();
            self.text.push_str(if empty { "\n\n" } else { "\n" });
            self.text.extend(std::iter::repeat_n(' ', indent * INDENT));
            self.pending = Pending::Nothing;
        }
        self.row += text.matches('\n').count();
        self.text.push_str(text);
        self.closed = false;
    }

    /// Writes a comment at the end of the line that is being written, also when a new one is due.
    pub fn behind(&mut self, comment: &Comment) {
        if self.closed {
            self.text(&comment.text);
        } else {
            self.trim();
            self.text.push(' ');
            self.row += comment.text.matches('\n').count();
            self.text.push_str(&comment.text);
        }
        self.closed = comment.line();
    }

    fn trim(&mut self) {
        let end = self.text.trim_end_matches(' ').len();
        self.text.truncate(end);
    }

    fn column(&self) -> usize {
        match self.pending {
            Pending::Line { indent, .. } => indent * INDENT,
            Pending::Nothing => {
                let line = self.text.rfind('\n').map_or(0, |n| n + 1);
                self.text[line..].chars().count()
            }
        }
    }
}

/// How wide some pieces are on one line; nothing where they cannot stand on one line, or not within
/// `most`.
pub(super) fn flat(pieces: &[Piece], most: usize) -> Option<usize> {
    let mut width = 0;
    for piece in pieces {
        width += match piece {
            Piece::Text(text) => text.chars().count(),
            Piece::Break { forced: true, .. } => return None,
            Piece::Break { blank, .. } => usize::from(*blank),
            Piece::Comment { comment, .. } if comment.line() || comment.text.contains('\n') => {
                return None;
            }
            Piece::Comment { comment, .. } => comment.text.chars().count() + 1,
            Piece::Mark { .. } | Piece::Ladder { .. } => 0,
        };
        if width > most {
            return None;
        }
    }
    Some(width)
}

/// The pieces up to the next break of this level or an outer one.
fn segment(pieces: &[Piece], level: usize) -> &[Piece] {
    let end = pieces
        .iter()
        .position(|p| matches!(p, Piece::Break { level: l, .. } if *l <= level));
    &pieces[..end.unwrap_or(pieces.len())]
}

/// Writes a statement.
pub(super) fn render(mut pieces: Vec<Piece>, out: &mut Writer) {
    // For each level, the row on which its last operand began.
    let mut rows: Vec<usize> = Vec::new();
    for i in 0..pieces.len() {
        let room = WIDTH.saturating_sub(out.column());
        match pieces[i].clone() {
            Piece::Text(text) => out.text(&text),
            Piece::Mark { level } => began(&mut rows, level, out.row),
            Piece::Ladder { level, length } => {
                began(&mut rows, level, out.row);
                arms(&mut pieces[i + 1..], level, length, room);
            }
            Piece::Break {
                level,
                indent,
                blank,
                forced,
            } => {
                let next = segment(&pieces[i + 1..], level);
                let above = rows.get(level).is_some_and(|row| *row < out.row);
                let room = room.checked_sub(usize::from(blank));
                if forced || above || room.is_none_or(|r| flat(next, r).is_none()) {
                    out.line(indent, false);
                } else if blank {
                    out.text(" ");
                }
                began(&mut rows, level, out.row);
            }
            Piece::Comment { comment, indent } if comment.line() => {
                if comment.own_line {
                    out.line(indent, false);
                    out.text(&comment.text);
                    out.closed = true;
                } else {
                    out.behind(&comment);
                }
                if out.pending == Pending::Nothing {
                    out.line(indent, false);
                }
            }
            Piece::Comment { comment, .. } => {
                out.text(&comment.text);
                out.text(" ");
            }
        }
    }
}

fn began(rows: &mut Vec<usize>, level: usize, row: usize) {
    if rows.len() <= level {
        rows.resize(level + 1, usize::MAX);
    }
    rows[level] = row;
}

/// Breaks before every `else`, where the arms do not fit on one line and the author broke before
/// none.
fn arms(pieces: &mut [Piece], level: usize, length: usize, room: usize) {
    let behind = pieces[length..]
        .iter()
        .position(|p| matches!(p, Piece::Break { level: l, .. } if *l < level));
    let end = behind.map_or(pieces.len(), |n| length + n);
    let fits = flat(&pieces[..end], room).is_some();
    let mut own: Vec<&mut bool> = pieces[..length]
        .iter_mut()
        .filter_map(|p| match p {
            Piece::Break {
                level: l, forced, ..
            } if *l == level => Some(forced),
            _ => None,
        })
        .collect();
    if !fits && !own.iter().any(|forced| **forced) {
        for forced in &mut own {
            **forced = true;
        }
    }
}
