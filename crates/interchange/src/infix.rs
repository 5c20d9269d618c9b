//! Parses the infix formulas of gr1c and structured slugs: splits them into words and applies the
//! precedence of the operators.
//!
//! The parser is Dijkstra's shunting yard with two explicit stacks: it takes linear time, does not
//! recurse, and reports a syntax error at the first word that does not fit. The two formats differ
//! in their words and in the precedence of `&` and `|`; see [`Dialect`].

use super::names::{Names, overwrite_low_bits, quoted};
use super::terms::{Kind, Term};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Time};
use std::ops::Range;

/// Vocabulary and operator precedence of a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dialect {
    /// gr1c: `&` and `|` bind equally tightly, and every operator groups from the left. A
    /// comparison has a variable on its left and a number on its right.
    Spc,
    /// Structured slugs: `&`, `|`, `^`, `->` and `<->` bind from tightest to loosest and group from
    /// the left. Arithmetic is allowed.
    Structured,
}

/// Error message for `<>[]p`.
pub(super) const PERSISTENCE: &str = "persistence (`<>[]p` or `F G p`) is outside GR(1)";

/// A binary operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Infix {
    Op(BinaryOp),
    /// `<->`
    Iff,
    /// `^`
    Xor,
    /// Replaces the lowest bits of the right operand with the bits of the left operand.
    Overwrite,
}

/// A token kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Word {
    Name,
    Number,
    True,
    False,
    Prime,
    Not,
    /// `X`, `next`, `()`
    Next,
    Infix(Infix),
    Open,
    Close,
    OpenBracket,
    CloseBracket,
    /// `[]`, `G`
    Always,
    /// `<>`, `F`
    Eventually,
    /// `U`, `W`
    Until,
    Comma,
    Semicolon,
    Colon,
    /// Any other character.
    Stray,
}

/// A token kind and its byte range.
pub(super) type Token = (Word, Range<usize>);

/// The tokens in a range of a text.
pub(super) fn words(text: &str, range: Range<usize>, dialect: Dialect) -> Vec<Token> {
    let mut found: Vec<Token> = Vec::new();
    let mut at = range.start;
    while let Some(c) = text[at..range.end].chars().next() {
        let rest = &text[at..range.end];
        if c == '#' && dialect == Dialect::Spc {
            at += rest.find('\n').unwrap_or(rest.len());
            continue;
        }
        if c.is_whitespace() || c == '\u{feff}' {
            at += c.len_utf8();
            continue;
        }
        let (word, length) = word(rest, c, dialect);
        found.push((word, at..at + length));
        at += length;
    }
    found
}

/// Signs of both formats. A sign comes before any other sign that is a prefix of it, because the
/// first match is taken.
const COMMON: &[(&str, Word)] = &[
    ("<->", Word::Infix(Infix::Iff)),
    ("->", Word::Infix(Infix::Op(BinaryOp::Implies))),
    ("<>", Word::Eventually),
    ("[]", Word::Always),
    ("<=", Word::Infix(Infix::Op(BinaryOp::Le))),
    (">=", Word::Infix(Infix::Op(BinaryOp::Ge))),
    ("!=", Word::Infix(Infix::Op(BinaryOp::Ne))),
    ("<", Word::Infix(Infix::Op(BinaryOp::Lt))),
    (">", Word::Infix(Infix::Op(BinaryOp::Gt))),
    ("=", Word::Infix(Infix::Op(BinaryOp::Eq))),
    ("&", Word::Infix(Infix::Op(BinaryOp::And))),
    ("|", Word::Infix(Infix::Op(BinaryOp::Or))),
    ("!", Word::Not),
    ("(", Word::Open),
    (")", Word::Close),
    ("[", Word::OpenBracket),
    ("]", Word::CloseBracket),
];
/// Signs of gr1c only, matched before the common ones.
const SPC: &[(&str, Word)] = &[
    ("'", Word::Prime),
    (",", Word::Comma),
    (";", Word::Semicolon),
    (":", Word::Colon),
];
/// Signs of structured slugs, matched before the common ones.
const STRUCTURED: &[(&str, Word)] = &[
    ("<-->", Word::Infix(Infix::Iff)),
    ("-->", Word::Infix(Infix::Op(BinaryOp::Implies))),
    ("->", Word::Infix(Infix::Op(BinaryOp::Implies))),
    ("()", Word::Next),
    ("&&", Word::Infix(Infix::Op(BinaryOp::And))),
    ("/\\", Word::Infix(Infix::Op(BinaryOp::And))),
    ("||", Word::Infix(Infix::Op(BinaryOp::Or))),
    ("\\/", Word::Infix(Infix::Op(BinaryOp::Or))),
    ("~", Word::Not),
    ("^", Word::Infix(Infix::Xor)),
    ("+", Word::Infix(Infix::Op(BinaryOp::Add))),
    ("-", Word::Infix(Infix::Op(BinaryOp::Sub))),
    ("*", Word::Infix(Infix::Op(BinaryOp::Mul))),
    ("/", Word::Infix(Infix::Op(BinaryOp::Div))),
];

fn word(rest: &str, c: char, dialect: Dialect) -> (Word, usize) {
    let structured = dialect == Dialect::Structured;
    let starts = |c: char| c.is_ascii_alphabetic() || c == '_' || structured && ".'@".contains(c);
    if starts(c) {
        let goes_on = |c: char| {
            c.is_ascii_alphanumeric() || "_.".contains(c) || structured && "'@".contains(c)
        };
        let length = rest.find(|c| !goes_on(c)).unwrap_or(rest.len());
        let word = match (&rest[..length], structured) {
            ("True", false) | ("TRUE", true) => Word::True,
            ("False", false) | ("FALSE", true) => Word::False,
            ("X" | "next", true) => Word::Next,
            ("G", true) => Word::Always,
            ("F", true) => Word::Eventually,
            ("U" | "W", true) => Word::Until,
            ("LEASTSIGNIFICANTBITOVERWRITES", true) => Word::Infix(Infix::Overwrite),
            _ => Word::Name,
        };
        return (word, length);
    }
    if c.is_ascii_digit() {
        let digits = |s: &str| s.find(|c: char| !c.is_ascii_digit()).unwrap_or(s.len());
        let mut length = digits(rest);
        if let Some(fraction) = rest[length..].strip_prefix('.')
            && fraction.starts_with(|c: char| c.is_ascii_digit())
        {
            length += 1 + digits(fraction);
        }
        return (Word::Number, length);
    }
    let own = if structured { STRUCTURED } else { SPC };
    own.iter()
        .chain(COMMON)
        .find(|(sign, _)| rest.starts_with(sign))
        .map_or((Word::Stray, c.len_utf8()), |(sign, word)| {
            (*word, sign.len())
        })
}

/// A completed subformula or number, with its byte range. `mark` is the value of [`Names::mark`]
/// before it was read.
#[derive(Debug, Clone)]
struct Operand {
    term: Term,
    range: Range<usize>,
    mark: usize,
    /// Number of bits in which slugs' translator stores the value.
    bits: u32,
    /// Whether the operand is a single word or in parentheses.
    closed: bool,
}

/// An operator that waits for its right operand, or an open bracket.
#[derive(Debug, Clone)]
enum Waiting {
    Prefix(Word, Range<usize>, usize),
    Infix(Infix),
    Open(Word, Range<usize>),
}

/// Precedence of prefix operators: looser than comparisons, so `!x = 3` is `!(x = 3)`.
const PREFIX: u8 = 6;

fn binding(infix: Infix, dialect: Dialect) -> u8 {
    use BinaryOp as B;
    match infix {
        Infix::Iff => 1,
        Infix::Op(B::Implies) => 2,
        Infix::Xor => 3,
        Infix::Op(B::Or) => 4,
        Infix::Op(B::And) if dialect == Dialect::Spc => 4,
        Infix::Op(B::And) => 5,
        Infix::Op(B::Add | B::Sub) => 8,
        Infix::Op(B::Mul | B::Div) => 9,
        Infix::Overwrite => 10,
        Infix::Op(_) => 7,
    }
}

/// Parses a formula from its tokens.
///
/// After an error, which is reported, returns `None`. An error about a formula without tokens is
/// reported at `whole`.
pub(super) fn formula(
    names: &mut Names<'_>,
    tokens: &[Token],
    whole: Range<usize>,
    dialect: Dialect,
) -> Option<Term> {
    let mut yard = Yard {
        names,
        dialect,
        operands: Vec::new(),
        waiting: Vec::new(),
        sound: true,
    };
    let term = yard.run(tokens, whole)?;
    yard.sound.then_some(term)
}

struct Yard<'n, 't> {
    names: &'n mut Names<'t>,
    dialect: Dialect,
    operands: Vec<Operand>,
    waiting: Vec<Waiting>,
    /// `false` after an error that does not stop the parser: an unknown name, or a number where a
    /// truth value is expected.
    sound: bool,
}

impl Yard<'_, '_> {
    fn run(&mut self, tokens: &[Token], whole: Range<usize>) -> Option<Term> {
        let mut operand_wanted = true;
        let mut index = 0;
        while let Some((word, range)) = tokens.get(index) {
            let range = range.clone();
            index += 1;
            if operand_wanted {
                match word {
                    Word::Not | Word::Next => {
                        let mark = self.names.mark();
                        self.waiting.push(Waiting::Prefix(*word, range, mark));
                    }
                    Word::Open | Word::OpenBracket => {
                        self.waiting.push(Waiting::Open(*word, range));
                    }
                    Word::True | Word::False => {
                        let term = self.names.terms.bool(*word == Word::True);
                        self.leaf(term, range, 1);
                        operand_wanted = false;
                    }
                    Word::Number => {
                        self.number(range);
                        operand_wanted = false;
                    }
                    Word::Name => {
                        let primed = matches!(tokens.get(index), Some((Word::Prime, _)));
                        index += usize::from(primed);
                        self.name(range, primed);
                        operand_wanted = false;
                    }
                    _ => {
                        self.misplaced(*word, range, true);
                        return None;
                    }
                }
            } else {
                match word {
                    Word::Infix(infix) => {
                        self.infix(*infix, range)?;
                        operand_wanted = true;
                    }
                    Word::Close | Word::CloseBracket => self.close(*word, range)?,
                    _ => {
                        self.misplaced(*word, range, false);
                        return None;
                    }
                }
            }
        }
        if operand_wanted {
            let end = tokens.last().map_or(whole.clone(), |t| t.1.clone());
            let message = if tokens.is_empty() {
                "a formula is missing here"
            } else {
                "the formula ends too early"
            };
            self.names.syntax(
                end,
                message,
                "complete the formula, or remove its last operator",
            );
            return None;
        }
        self.reduce(0);
        if let Some(Waiting::Open(_, range)) = self.waiting.last() {
            let range = range.clone();
            self.names.syntax(
                range,
                "this bracket is never closed",
                "close it, or remove it",
            );
            return None;
        }
        let last = self.operands.pop()?;
        if self.names.terms.kind(last.term) == Kind::Int {
            self.mistyped(&last, Kind::Bool);
        }
        Some(last.term)
    }

    fn misplaced(&mut self, word: Word, range: Range<usize>, operand_wanted: bool) {
        let text = quoted(&self.names.text[range.clone()]);
        match word {
            Word::Always | Word::Eventually | Word::Until => {
                let help = match self.dialect {
                    Dialect::Spc => {
                        "begin each formula of a section with its operator, and join them with `&`: `[]a & []b`"
                    }
                    Dialect::Structured => {
                        "the section already says when its formulas hold: write them without temporal operators"
                    }
                };
                let after = self.names.text[range.end..].trim_start();
                let message = if word == Word::Eventually
                    && (after.starts_with("[]") || after.starts_with("G "))
                {
                    PERSISTENCE.to_owned()
                } else {
                    format!("the temporal operator `{text}` is not allowed here")
                };
                self.names.error(codes::NOT_GR1, range, message, help);
            }
            Word::Prime => self.names.syntax(
                range,
                "this prime does not follow a variable",
                "write `x'` for the next value of `x`",
            ),
            _ if operand_wanted => self.names.syntax(
                range,
                format!("expected a variable or a formula, found `{text}`"),
                "write an operator between two formulas, and close each `(`",
            ),
            _ => self.names.syntax(
                range,
                format!("expected an operator, found `{text}`"),
                "join two formulas with `&`, `|`, `->` or `<->`",
            ),
        }
    }

    fn leaf(&mut self, term: Term, range: Range<usize>, bits: u32) {
        let mark = self.names.mark();
        self.operands.push(Operand {
            term,
            range,
            mark,
            bits,
            closed: true,
        });
    }

    fn number(&mut self, range: Range<usize>) {
        let digits = self.names.text[range.clone()].to_owned();
        let value = self.names.number(&digits, range.clone());
        self.sound &= value.is_some();
        let value = value.unwrap_or(0);
        let term = self.names.terms.int(value);
        self.leaf(term, range, i64::BITS - value.leading_zeros());
    }

    /// Reads a variable whose prime is a separate token or the end of its word.
    fn name(&mut self, range: Range<usize>, primed: bool) {
        let word = &self.names.text[range.clone()];
        let (name, primed) = match word.strip_suffix('\'') {
            Some(name) => (name, true),
            None => (word, primed),
        };
        let time = if primed { Time::Next } else { Time::Now };
        let mark = self.names.mark();
        let Some((var, kind)) = self.names.find(name) else {
            let name = name.to_owned();
            self.names.unknown(&name, range.clone());
            self.sound = false;
            // The constant `true` replaces the unknown variable, so that the name causes no further
            // findings.
            let term = self.names.terms.bool(true);
            self.leaf(term, range, 1);
            return;
        };
        let term = self.names.mention(var, kind, time, range.clone());
        let (low, high) = self.names.bounds(var);
        let held = u64::BITS - ((high - low) as u64).leading_zeros();
        let bits = match low {
            0 => held,
            // The bits hold the distance from the smallest value. The translator adds the smallest
            // value to it, and the sum can need one more bit.
            _ => held.max(u64::BITS - low.unsigned_abs().leading_zeros()) + 1,
        };
        self.operands.push(Operand {
            term,
            range,
            mark,
            bits,
            closed: true,
        });
    }

    fn infix(&mut self, infix: Infix, range: Range<usize>) -> Option<()> {
        use BinaryOp as B;
        let level = binding(infix, self.dialect);
        // Skip operators that bind more tightly than `infix`: in `a | x < 1 & c`, the `<` belongs
        // to the operand between `|` and `&`.
        let waiting = self.waiting.iter().rev();
        let before = waiting
            .take_while(|w| !matches!(w, Waiting::Open(..)))
            .find_map(|w| match w {
                Waiting::Infix(op) if binding(*op, self.dialect) <= level => Some(*op),
                _ => None,
            });
        if let Some(before) = before {
            let unusual = match (before, infix) {
                (Infix::Op(B::Or), Infix::Op(B::And)) if self.dialect == Dialect::Spc => Some((
                    "`a | b & c` is read as `(a | b) & c`: `&` and `|` bind equally here",
                    "write the parentheses",
                )),
                (Infix::Op(B::Implies), Infix::Op(B::Implies)) => Some((
                    "`a -> b -> c` is read as `(a -> b) -> c`: implications group from the left here",
                    "write the parentheses",
                )),
                _ => None,
            };
            if let Some((message, help)) = unusual {
                self.names
                    .note(codes::NOTATION, range.clone(), message, help);
            }
        }
        self.reduce(level);
        if level == 7 {
            let left = self.operands.last()?;
            if self.names.terms.kind(left.term) == Kind::Bool && !left.closed {
                self.names.syntax(
                    range,
                    "comparisons cannot be chained",
                    "write `a < b & b < c`",
                );
                return None;
            }
        }
        if infix == Infix::Op(B::Div) {
            self.names.syntax(
                range,
                "this format has no division",
                "multiply the other side instead",
            );
            return None;
        }
        self.waiting.push(Waiting::Infix(infix));
        Some(())
    }

    fn close(&mut self, word: Word, range: Range<usize>) -> Option<()> {
        self.reduce(0);
        let wanted = if word == Word::Close {
            Word::Open
        } else {
            Word::OpenBracket
        };
        match self.waiting.pop() {
            Some(Waiting::Open(open, start)) if open == wanted => {
                if let Some(operand) = self.operands.last_mut() {
                    operand.range = start.start..range.end;
                    operand.closed = true;
                }
                Some(())
            }
            _ => {
                self.names.syntax(
                    range,
                    "this bracket closes nothing",
                    "remove it, or add the opening bracket",
                );
                None
            }
        }
    }

    /// Applies waiting operators until one binds more loosely than `level`.
    fn reduce(&mut self, level: u8) {
        while let Some(waiting) = self.waiting.last().cloned() {
            match waiting {
                Waiting::Prefix(word, range, mark) if PREFIX >= level => {
                    self.waiting.pop();
                    self.prefix(word, range, mark);
                }
                Waiting::Infix(infix) if binding(infix, self.dialect) >= level => {
                    self.waiting.pop();
                    self.combine(infix);
                }
                _ => return,
            }
        }
    }

    fn prefix(&mut self, word: Word, range: Range<usize>, mark: usize) {
        let Some(mut operand) = self.operands.pop() else {
            return;
        };
        if self.names.terms.kind(operand.term) == Kind::Int {
            operand.term = self.mistyped(&operand, Kind::Bool);
        }
        if word == Word::Not {
            operand.term = self.names.terms.not(operand.term);
        } else if self.names.terms.has_next(operand.term) {
            // Report several nested operators only once.
            if std::mem::replace(&mut self.sound, false) {
                self.names.error(
                    codes::NEXT_NESTED,
                    range.clone(),
                    "a next value is nested in another",
                    "write either the prime or the operator; to refer to two steps ahead, remember a value in a variable",
                );
            }
        } else {
            operand.term = self.names.primed(operand.term, mark);
        }
        operand.range.start = range.start;
        operand.mark = mark;
        operand.closed = false;
        self.operands.push(operand);
    }

    /// Reports an operand of the wrong kind. Returns a constant of the `wanted` kind to continue
    /// with.
    fn mistyped(&mut self, operand: &Operand, wanted: Kind) -> Term {
        if self.sound {
            let (message, help) = match wanted {
                Kind::Bool => (
                    "expected a truth value, found a number",
                    "compare the number with another one",
                ),
                Kind::Int => (
                    "expected a number, found a truth value",
                    "compare numbers; join truth values with `<->`",
                ),
            };
            self.names
                .error(codes::TYPE_MISMATCH, operand.range.clone(), message, help);
        }
        self.sound = false;
        match wanted {
            Kind::Bool => self.names.terms.bool(true),
            Kind::Int => self.names.terms.int(0),
        }
    }

    fn combine(&mut self, infix: Infix) {
        use BinaryOp as B;
        let (Some(mut b), Some(mut a)) = (self.operands.pop(), self.operands.pop()) else {
            return;
        };
        let op = match infix {
            Infix::Op(op) => op,
            Infix::Iff => B::Eq,
            Infix::Xor => B::Ne,
            Infix::Overwrite => B::Add,
        };
        let wanted = if binding(infix, self.dialect) >= 7 {
            Kind::Int
        } else {
            Kind::Bool
        };
        if wanted == Kind::Int && self.dialect == Dialect::Spc {
            self.check_comparison(&mut a, &b);
        }
        for operand in [&mut a, &mut b] {
            if self.names.terms.kind(operand.term) != wanted {
                operand.term = self.mistyped(operand, wanted);
            }
        }
        let (range, mark) = (a.range.start..b.range.end, a.mark);
        let (term, bits) = if infix == Infix::Overwrite {
            self.overwrite(&a, &b)
        } else {
            if matches!(op, B::Sub | B::Mul) {
                self.names.note(
                    codes::OWN_TOOL,
                    range.clone(),
                    "slugs' translator refuses `-` and `*`; here they are computed exactly",
                    "to make the file readable by both tools, write a subtraction as an addition on the other side",
                );
            }
            let bits = match op {
                B::Mul => a.bits.saturating_add(b.bits),
                _ if a.bits == 0 || b.bits == 0 => a.bits.max(b.bits),
                _ => a.bits.max(b.bits) + 1,
            };
            (self.names.terms.binary(op, a.term, b.term), bits)
        };
        self.operands.push(Operand {
            term,
            range,
            mark,
            bits,
            closed: false,
        });
    }

    /// Checks that a comparison of gr1c has a variable on its left and a number on its right.
    ///
    /// A Boolean variable is compared as the number 0 or 1.
    fn check_comparison(&mut self, a: &mut Operand, b: &Operand) {
        let terms = &mut self.names.terms;
        let number = terms
            .constant(b.term)
            .filter(|_| terms.kind(b.term) == Kind::Int);
        let variable = terms.is_var(a.term);
        if number.is_none() || !variable {
            if self.sound {
                self.names.syntax(
                    a.range.start..b.range.end,
                    "this comparison needs a variable on its left and a number on its right",
                    "compare two variables value by value, and truth values with `<->`",
                );
            }
            self.sound = false;
        } else if terms.kind(a.term) == Kind::Bool {
            a.term = terms.as_number(a.term);
        }
    }

    /// Applies [`Infix::Overwrite`]. The left operand must have fewer bits than the right one.
    fn overwrite(&mut self, a: &Operand, b: &Operand) -> (Term, u32) {
        if a.bits >= b.bits || a.bits > 40 {
            if self.sound && !self.names.mentions_refused() {
                self.names.error(
                    codes::TYPE_MISMATCH,
                    a.range.start..b.range.end,
                    format!(
                        "a number of {} bits cannot overwrite the lowest bits of a number of {} bits",
                        a.bits, b.bits
                    ),
                    "put the shorter number on the left",
                );
            }
            self.sound = false;
            return (a.term, a.bits);
        }
        let term = overwrite_low_bits(&mut self.names.terms, a.term, b.term, a.bits);
        (term, b.bits)
    }
}
