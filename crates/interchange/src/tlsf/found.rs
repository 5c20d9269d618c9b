//! Formulas of the sections, and the pieces of GR(1) that they consist of.

use super::ast::Section;
use super::classify::Piece;
use super::ltl::FormulaId;
use linewright_core::gr1::monitors::Origin;
use linewright_core::gr1::{Expr, Formula};
use std::ops::Range;

/// An expanded formula of a section.
#[derive(Debug, Clone)]
pub(super) struct Conjunct {
    pub section: Section,
    pub name: String,
    /// Byte range of the name of the section.
    pub heading: Range<usize>,
    pub formula: FormulaId,
}

/// A piece and where it comes from.
pub(super) struct LocatedPiece {
    pub piece: Piece,
    pub at: FormulaId,
    pub origin: Origin,
    /// Byte range of the name of the section.
    pub heading: Range<usize>,
}

/// Whether a finite prefix can violate the piece.
pub(super) fn is_safety(piece: &Piece) -> bool {
    matches!(
        piece,
        Piece::Initial(_) | Piece::Invariant(_) | Piece::Step(_)
    )
}

/// A formula with the name, location and text of a piece.
pub(super) fn formula(found: &LocatedPiece, expr: &Expr) -> Formula {
    Formula {
        defines: false,
        name: found.origin.name.clone(),
        requirement: None,
        expr: expr.simplify(),
        span: found.origin.span,
        text: found.origin.text.clone(),
    }
}

/// Removes pieces that are constantly true, and turns constantly false pieces into justice.
pub(super) fn normalize_constants(list: &mut Vec<LocatedPiece>) {
    let constant = |f: &LocatedPiece| match f.piece {
        Piece::Initial(Expr::Const(value)) | Piece::Invariant(Expr::Const(value)) => Some(value),
        _ => None,
    };
    list.retain(|f| constant(f).is_none_or(|value| value == 0));
    for found in list {
        if constant(found).is_some() {
            found.piece = Piece::Recurrent(Expr::FALSE);
        }
    }
}

/// Removes a condition from a pair if the condition is also a justice assumption.
pub(super) fn drop_assumed_conditions(
    require: &[LocatedPiece],
    assume: &[LocatedPiece],
    guarantees: &mut [LocatedPiece],
) {
    let known: Vec<&Expr> = require
        .iter()
        .chain(assume)
        .filter_map(|f| match &f.piece {
            Piece::Recurrent(e) => Some(e),
            _ => None,
        })
        .collect();
    for found in guarantees {
        let Piece::Pair(when, then) = &mut found.piece else {
            continue;
        };
        when.retain(|(_, e)| !known.contains(&e));
        if when.is_empty() {
            found.piece = Piece::Recurrent(then.clone());
        }
    }
}
