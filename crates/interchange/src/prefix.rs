//! Parses formulas in slugs' prefix notation: operators before their operands, words separated by
//! blanks.
//!
//! ```text
//! ! a      & a b     | a b     ^ a b     0  1     a'
//! $ 3 f0 f1 f2     a memory buffer of three formulas; its value is that of the last one
//! ? 0              within a buffer: the value of formula 0, which has to be before the `?`
//! ```
//!
//! The parser keeps a stack of operators that wait for operands, and does not recurse. A formula
//! that is recalled several times is a single shared node ([`Terms`](super::terms::Terms)), so an
//! adder's carry chain stays as small as it is written.

use super::names::{Names, quoted};
use super::structured;
use super::terms::{Kind, Term};
use linewright_core::gr1::{BinaryOp, Time};
use std::ops::Range;

/// Whether a word is an operator or a constant.
pub(super) fn is_operator(word: &str) -> bool {
    matches!(word, "!" | "&" | "|" | "^" | "$" | "?" | "0" | "1")
}

fn words(text: &str, line: Range<usize>) -> impl DoubleEndedIterator<Item = (&str, Range<usize>)> {
    let base = text.as_ptr() as usize;
    text[line].split_whitespace().map(move |word| {
        let start = word.as_ptr() as usize - base;
        (word, start..start + word.len())
    })
}

/// Whether a line of a structured file is in prefix notation.
///
/// This is the case if the line has a buffer, or if evaluating its words from the right leaves one
/// value.
pub(super) fn is_prefix(names: &Names<'_>, line: Range<usize>) -> bool {
    let text = names.text;
    if words(text, line.clone()).any(|(word, _)| word == "$") {
        return true;
    }
    let mut values = 0usize;
    for (word, _) in words(text, line).rev() {
        match word {
            "&" | "|" | "^" if values < 2 => return false,
            "&" | "|" | "^" => values -= 1,
            "!" => {}
            "0" | "1" => values += 1,
            name => {
                let name = name.strip_suffix('\'').unwrap_or(name);
                let known = match name.split_once('@') {
                    Some((number, _)) => names.find(number).is_some(),
                    None => names.find(name).is_some_and(|(_, kind)| kind == Kind::Bool),
                };
                if !known {
                    return false;
                }
                values += 1;
            }
        }
    }
    values == 1
}

/// An operator or buffer that waits for operands.
enum Waiting {
    Not,
    Binary(BinaryOp, Option<Term>),
    Buffer(usize, Vec<Term>),
}

/// Parses a line; `None` after an error, which is reported.
pub(super) fn formula(names: &mut Names<'_>, line: Range<usize>) -> Option<Term> {
    let text = names.text;
    let mut words = words(text, line.clone());
    let mut waiting: Vec<Waiting> = Vec::new();
    let mut buffers: Vec<usize> = Vec::new();
    let mut sound = true;
    while let Some((word, range)) = words.next() {
        let mut value = match word {
            "!" => {
                waiting.push(Waiting::Not);
                continue;
            }
            "&" | "|" | "^" => {
                let op = match word {
                    "&" => BinaryOp::And,
                    "|" => BinaryOp::Or,
                    _ => BinaryOp::Ne,
                };
                waiting.push(Waiting::Binary(op, None));
                continue;
            }
            "$" => {
                let count = count(
                    names,
                    words.next(),
                    &range,
                    "the number of formulas in the buffer",
                )?;
                if count == 0 {
                    names.syntax(
                        range,
                        "this memory buffer has no formulas",
                        "write the number of its formulas, at least 1: `$ 2 f0 f1`",
                    );
                    return None;
                }
                buffers.push(waiting.len());
                waiting.push(Waiting::Buffer(count, Vec::new()));
                continue;
            }
            "?" => {
                let index = count(
                    names,
                    words.next(),
                    &range,
                    "the index of a formula in the buffer",
                )?;
                let cells = buffers.last().and_then(|at| match &waiting[*at] {
                    Waiting::Buffer(_, cells) => Some(cells),
                    _ => None,
                });
                let Some(term) = cells.and_then(|cells| cells.get(index)) else {
                    let (message, help) = if cells.is_some() {
                        (
                            "the buffer has no formula with this index yet",
                            "count formulas from 0, and recall only earlier ones",
                        )
                    } else {
                        (
                            "`?` is outside any memory buffer",
                            "begin a buffer with `$` and the number of its formulas",
                        )
                    };
                    names.syntax(range, message, help);
                    return None;
                };
                *term
            }
            "0" | "1" => names.terms.bool(word == "1"),
            name if is_infix(names, name) => {
                names.syntax(
                    range,
                    format!("`{}` belongs to infix notation; this line is read in prefix notation", quoted(name)),
                    "write operators before their operands, without parentheses: `& a b`, `| ! a b`; use infix notation in `.structuredslugs` files",
                );
                return None;
            }
            name => {
                let found = variable(names, name, range);
                sound &= found.is_some();
                found.unwrap_or_else(|| names.terms.bool(true))
            }
        };
        // Pass the value to the operator that waits for it. If this completes the operator, repeat
        // with the operator's value.
        loop {
            match waiting.pop() {
                None => {
                    if let Some((word, range)) = words.next() {
                        let message = format!("the formula is complete before `{}`", quoted(word));
                        names.syntax(
                            range.start..line.end,
                            message,
                            "write operators before their operands: `& a b`, `| ! a b`",
                        );
                        return None;
                    }
                    return sound.then_some(value);
                }
                Some(Waiting::Not) => value = names.terms.not(value),
                Some(Waiting::Binary(op, None)) => {
                    waiting.push(Waiting::Binary(op, Some(value)));
                    break;
                }
                Some(Waiting::Binary(op, Some(first))) => {
                    value = names.terms.binary(op, first, value);
                }
                Some(Waiting::Buffer(count, mut cells)) => {
                    cells.push(value);
                    if cells.len() < count {
                        waiting.push(Waiting::Buffer(count, cells));
                        break;
                    }
                    buffers.pop();
                }
            }
        }
    }
    names.syntax(
        line,
        "the formula ends before it is complete",
        "write two operands after `&`, `|` and `^`, one after `!`, and n after `$ n`",
    );
    None
}

/// Whether a word occurs in infix notation only. A declared name never counts, because names can
/// contain any characters.
fn is_infix(names: &Names<'_>, word: &str) -> bool {
    let sign = matches!(word, "->" | "<->" | "&&" | "||" | "=" | "/\\" | "\\/");
    (sign || word.starts_with('(') || word.ends_with(')')) && names.find(word).is_none()
}

fn count(
    names: &mut Names<'_>,
    word: Option<(&str, Range<usize>)>,
    operator: &Range<usize>,
    what: &str,
) -> Option<usize> {
    let place = word.as_ref().map_or(operator.clone(), |w| w.1.clone());
    let number = word.and_then(|(word, _)| word.parse::<usize>().ok());
    if number.is_none() {
        names.syntax(
            place,
            format!("expected {what}"),
            "write `$ 2 f0 f1` for a buffer and `? 0` for its first formula",
        );
    }
    number
}

fn variable(names: &mut Names<'_>, word: &str, range: Range<usize>) -> Option<Term> {
    let (name, time) = match word.strip_suffix('\'') {
        Some(name) => (name, Time::Next),
        None => (word, Time::Now),
    };
    match names.find(name) {
        Some((var, Kind::Bool)) => return Some(names.mention(var, Kind::Bool, time, range)),
        Some(_) => {
            names.syntax(
                range,
                format!(
                    "`{}` is a number, which prefix notation does not support",
                    quoted(name)
                ),
                "write the line in infix notation, or refer to a bit of the number",
            );
            return None;
        }
        None => {}
    }
    if let Some(term) = structured::bit_of(names, name, time, range.clone()) {
        return Some(term);
    }
    names.unknown(name, range);
    None
}
