//! Layout: converts pieces of text and possible line breaks to lines.
//!
//! A statement is a list of pieces. A [`Piece::Break`] becomes either a blank or a line end. It
//! becomes a line end if the author ended the line there, or if the text up to the next break of
//! the same or an outer level would not fit. So the outermost operator breaks first, and lines
//! within one operator are filled (Oppen, Prettyprinting, 1980: inconsistent breaking). Since the
//! author's line ends are kept, formatting a formatted text again changes nothing.

use super::comments::Comment;

/// Maximum line width in columns, unless there is no possible break.
pub(super) const WIDTH: usize = 135;
/// Number of blanks per level of indentation.
const INDENT: usize = 4;

/// A piece of a statement.
#[derive(Debug, Clone)]
pub(super) enum Piece {
    /// Text without breaks.
    Text(String),
    /// The beginning of an operand at this level.
    Mark { level: usize },
    /// A possible line end. If the line does not end here, a blank is written if `blank` is set.
    Break {
        level: usize,
        indent: usize,
        blank: bool,
        forced: bool,
    },
    /// The beginning of an `if ... else if` of `length` pieces. Its arms are all on one line, or
    /// broken where the author broke them, or each on a separate line.
    Ladder { level: usize, length: usize },
    /// A comment within a statement.
    Comment { comment: Comment, indent: usize },
}

/// Line end that is written before the next text.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pending {
    Nothing,
    Line { indent: usize, empty: bool },
}

/// The text written so far. A line end is only written with the next text, so that a comment can
/// still be inserted before it.
pub(super) struct Writer {
    text: String,
    pending: Pending,
    row: usize,
    /// Whether the last line ends with a line comment.
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

    /// Returns the text, ending with a line end.
    pub fn finish(mut self) -> String {
        if !self.text.is_empty() {
            self.trim();
            self.text.push('\n');
        }
        self.text
    }

    /// Starts a new line for the next text; with `empty`, an empty line precedes it.
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

    /// Writes a comment at the end of the current line, even if a line end is pending.
    pub fn append_comment(&mut self, comment: &Comment) {
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

/// Returns the width of pieces on one line; `None` if they cannot be on one line or are wider than
/// `max_width`.
pub(super) fn flat(pieces: &[Piece], max_width: usize) -> Option<usize> {
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
        if width > max_width {
            return None;
        }
    }
    Some(width)
}

/// Returns the pieces up to the next break of this level or an outer one.
fn segment(pieces: &[Piece], level: usize) -> &[Piece] {
    let end = pieces
        .iter()
        .position(|p| matches!(p, Piece::Break { level: l, .. } if *l <= level));
    &pieces[..end.unwrap_or(pieces.len())]
}

/// Writes a statement.
pub(super) fn render(mut pieces: Vec<Piece>, out: &mut Writer) {
    // For each level, the row in which the last operand began.
    let mut rows: Vec<usize> = Vec::new();
    for i in 0..pieces.len() {
        let room = WIDTH.saturating_sub(out.column());
        match pieces[i].clone() {
            Piece::Text(text) => out.text(&text),
            Piece::Mark { level } => set_row(&mut rows, level, out.row),
            Piece::Ladder { level, length } => {
                set_row(&mut rows, level, out.row);
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
                set_row(&mut rows, level, out.row);
            }
            Piece::Comment { comment, indent } if comment.line() => {
                if comment.own_line {
                    out.line(indent, false);
                    out.text(&comment.text);
                    out.closed = true;
                } else {
                    out.append_comment(&comment);
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

fn set_row(rows: &mut Vec<usize>, level: usize, row: usize) {
    if rows.len() <= level {
        rows.resize(level + 1, usize::MAX);
    }
    rows[level] = row;
}

/// Breaks the line before every `else` if the arms do not fit on one line and the author did not
/// break the line before any `else`.
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
