//! What the sections ask, as formulas and as the pieces that these come to.

use super::ast::Section;
use super::classify::Piece;
use super::ltl::FormulaId;
use linewright_core::gr1::monitors::Origin;
use linewright_core::gr1::{Expr, Formula};
use std::ops::Range;

/// A formula of a section, expanded.
#[derive(Debug, Clone)]
pub(super) struct Conjunct {
    pub section: Section,
    pub name: String,
    /// Where the name of its section appears.
    pub heading: Range<usize>,
    pub formula: FormulaId,
}

/// A piece and where it comes from.
pub(super) struct LocatedPiece {
    pub piece: Piece,
    pub at: FormulaId,
    pub origin: Origin,
    /// Where the name of its section appears.
    pub heading: Range<usize>,
}

/// Whether a run that breaks it does so at some step.
pub(super) fn is_safety(piece: &Piece) -> bool {
    matches!(
        piece,
        Piece::Initial(_) | Piece::Invariant(_) | Piece::Step(_)
    )
}

/// A formula of a piece, with its name and its place.
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

/// Constants among what is assumed or promised: what says nothing is left out, and what nothing can
/// keep is as well asked again and again.
pub(super) fn only_in_vain(list: &mut Vec<LocatedPiece>) {
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

/// "If again and again c, then" says nothing where c is assumed to happen again and again.
pub(super) fn under_assumptions(
    require: &[LocatedPiece],
    assume: &[LocatedPiece],
    promises: &mut [LocatedPiece],
) {
    let known: Vec<&Expr> = require
        .iter()
        .chain(assume)
        .filter_map(|f| match &f.piece {
            Piece::Recurrent(e) => Some(e),
            _ => None,
        })
        .collect();
    for found in promises {
        let Piece::Pair(when, then) = &mut found.piece else {
            continue;
        };
        when.retain(|(_, e)| !known.contains(&e));
        if when.is_empty() {
            found.piece = Piece::Recurrent(then.clone());
        }
    }
}
