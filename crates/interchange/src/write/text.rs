//! Pieces of a formula as text, with as many parentheses as the reader of the format needs.

use super::gates::{Gate, Gates, Shape};

/// How tightly a piece binds. No format that is written binds these in another order.
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

/// The text, in parentheses where it would fall apart.
pub(super) fn at_least((rank, text): Piece, wanted: Rank) -> String {
    if rank >= wanted {
        text
    } else {
        format!("({text})")
    }
}

/// The words of a format.
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

    /// All of them; `true` if there are none.
    pub fn all(&self, pieces: Vec<Piece>) -> Piece {
        self.chain(pieces, Rank::And, self.and, true)
    }

    /// One of them; `false` if there are none.
    pub fn any(&self, pieces: Vec<Piece>) -> Piece {
        self.chain(pieces, Rank::Or, self.or, false)
    }

    fn chain(&self, mut pieces: Vec<Piece>, rank: Rank, word: &str, empty: bool) -> Piece {
        if pieces.len() < 2 {
            return pieces.pop().unwrap_or_else(|| self.truth(empty));
        }
        // Next to each other `and` and `or` are easily misread.
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

    /// A gate whose tests of single variables are written by `atom`. The recursion is as deep as
    /// the gate.
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
