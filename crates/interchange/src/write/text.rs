//! Builds the text of formulas, with the necessary parentheses.

use super::gates::{Gate, Gates, Shape};

/// How tightly a piece of text binds, from loose to tight; the order fits all written formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    Implies,
    Iff,
    Or,
    And,
    Relation,
    Sum,
    Product,
    Tight,
}

/// A piece of text, and how tightly it binds.
pub(super) type Piece = (Rank, String);

/// The text, in parentheses if it binds more loosely than `wanted`.
pub(super) fn at_least((rank, text): Piece, wanted: Rank) -> String {
    if rank >= wanted {
        text
    } else {
        format!("({text})")
    }
}

/// Operators and constants of a format.
#[derive(Debug)]
pub(super) struct Words {
    pub truth: [&'static str; 2],
    pub not: &'static str,
    pub and: &'static str,
    pub or: &'static str,
    pub iff: &'static str,
}

impl Words {
    pub fn truth(&self, value: bool) -> Piece {
        (Rank::Tight, self.truth[usize::from(value)].to_owned())
    }

    pub fn not(&self, piece: Piece) -> Piece {
        let negated = at_least(piece, Rank::Tight);
        (Rank::Tight, format!("{}{negated}", self.not))
    }

    /// The conjunction of the pieces; `true` for none.
    pub fn all(&self, pieces: Vec<Piece>) -> Piece {
        self.chain(pieces, Rank::And, self.and, true)
    }

    /// The disjunction of the pieces; `false` for none.
    pub fn any(&self, pieces: Vec<Piece>) -> Piece {
        self.chain(pieces, Rank::Or, self.or, false)
    }

    fn chain(&self, mut pieces: Vec<Piece>, rank: Rank, word: &str, empty: bool) -> Piece {
        if pieces.len() < 2 {
            return pieces.pop().unwrap_or_else(|| self.truth(empty));
        }
        // Operands with other operators get parentheses, because mixed `and` and `or` are easily
        // misread.
        let operand = |piece: Piece| match piece.0 {
            own if own == rank => piece.1,
            _ => at_least(piece, Rank::Relation),
        };
        let operands: Vec<String> = pieces.into_iter().map(operand).collect();
        (rank, operands.join(&format!(" {word} ")))
    }

    pub fn iff(&self, a: Piece, b: Piece) -> Piece {
        let (a, b) = (at_least(a, Rank::Relation), at_least(b, Rank::Relation));
        (Rank::Iff, format!("{a} {} {b}", self.iff))
    }

    /// The text of a gate; `atom` writes tests of single variables. The recursion is as deep as the
    /// gate.
    pub fn gate(&self, gates: &Gates, gate: Gate, atom: &dyn Fn(Shape) -> Piece) -> Piece {
        let of = |g: Gate| self.gate(gates, g, atom);
        match gates.shape(gate) {
            Shape::Const(value) => self.truth(value),
            Shape::Not(a) => match gates.shape(a) {
                Shape::Xor(a, b) => self.iff(of(a), of(b)),
                _ => self.not(of(a)),
            },
            Shape::And(..) => self.all(gates.conjuncts(gate).into_iter().map(of).collect()),
            Shape::Or(..) => self.any(gates.disjuncts(gate).into_iter().map(of).collect()),
            Shape::Xor(a, b) => self.not(self.iff(of(a), of(b))),
            shape @ (Shape::Within(..) | Shape::Bit(..)) => atom(shape),
        }
    }
}
