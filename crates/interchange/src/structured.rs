//! Features of structured slugs beyond `.slugsin`: numbers with a range, and infix formulas.
//!
//! A number `x: lo...hi` is read as one variable. slugs' translator encodes it in bits that hold
//! the distance from `lo`. A line in prefix notation can refer to these bits: `x@0.lo.hi` is the
//! lowest bit, `x@1`, `x@2`, ... are the others.

use super::infix;
use super::names::{Names, bit, quoted};
use super::terms::{Kind, Term};
use linewright_core::gr1::{Domain, Owner, Time};
use std::ops::Range;

/// Reserved words of slugs.
pub(super) const WORDS: [&str; 9] = [
    "X",
    "F",
    "G",
    "U",
    "W",
    "FALSE",
    "TRUE",
    "next",
    "LEASTSIGNIFICANTBITOVERWRITES",
];

/// Reads a declaration `x` or `x: lo...hi`.
pub(super) fn declaration(names: &mut Names<'_>, owner: Owner, line: Range<usize>) {
    let text = &names.text[line.clone()];
    let (name, range) = match text.split_once(':') {
        Some((name, range)) => (name.trim_end(), Some(range)),
        None => (text, None),
    };
    let place = line.start..line.start + name.len();
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_' || c == '.');
    let plain = name
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
    if !starts || !plain || WORDS.contains(&name) {
        names.syntax(
            place,
            format!("`{}` cannot be a variable's name", quoted(name)),
            "use letters, digits, `_` and `.`; do not begin with a digit or use the name of an operator",
        );
        return;
    }
    let Some(range) = range else {
        names.declare(owner, name, Domain::Bool, place);
        return;
    };
    let bounds = range
        .split_once("...")
        .and_then(|(low, high)| {
            Some((
                low.trim().parse::<i64>().ok()?,
                high.trim().parse::<i64>().ok()?,
            ))
        })
        .filter(|(low, high)| low.unsigned_abs().max(high.unsigned_abs()) < 1 << 40);
    let Some((low, high)) = bounds else {
        names.syntax(
            line,
            "expected the smallest and the largest number after the colon",
            "write `x: 0...7`",
        );
        names.declare_refused(owner, name, place);
        return;
    };
    match names.domain(low, high, line) {
        Some(domain) => names.declare(owner, name, domain, place),
        None => names.declare_refused(owner, name, place),
    }
}

/// Parses a line in infix notation; `None` after an error, which is reported.
pub(super) fn formula(names: &mut Names<'_>, line: Range<usize>) -> Option<Term> {
    let words = infix::words(names.text, line.clone(), infix::Dialect::Structured);
    infix::formula(names, &words, line, infix::Dialect::Structured)
}

/// The bit that a word in prefix notation refers to, such as `x@0.0.23` or `x@1`; `None` if there
/// is no such bit.
pub(super) fn bit_of(
    names: &mut Names<'_>,
    word: &str,
    time: Time,
    range: Range<usize>,
) -> Option<Term> {
    let (name, index) = word.split_once('@')?;
    let (var, kind) = names.find(name)?;
    if names.is_refused(var) {
        return Some(bit(names, var, 0, time, range));
    }
    let (low, high) = names.bounds(var);
    let held = u64::BITS - ((high - low) as u64).leading_zeros();
    let k: u32 = match index.split_once('.') {
        Some((zero, bounds)) if zero == "0" && bounds == format!("{low}.{high}") => 0,
        Some(_) => return None,
        None => index.parse().ok().filter(|k| *k > 0)?,
    };
    (kind == Kind::Int && k < held).then(|| bit(names, var, k, time, range))
}
