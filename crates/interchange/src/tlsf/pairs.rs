//! Guarantees of the form `G F a -> G F b`: Streett pairs.

use super::classify::{Piece, Refusal};
use super::found::{LocatedPiece, formula};
use super::ltl::{FormulaId, Op};
use super::meaning::Meaning;
use linewright_core::gr1::{Expr, Formula};

impl Meaning<'_, '_, '_> {
    /// The conditions of guarantees of the form `G F a -> G F b`, as justice assumptions.
    ///
    /// All guarantees must have the same conditions. Reports those that differ, because the file is
    /// outside GR(1) then.
    pub(super) fn pairs(
        &mut self,
        assert: &[LocatedPiece],
        guarantee: &[LocatedPiece],
        soft_safety: bool,
    ) -> Vec<Formula> {
        let mut first: Option<(&LocatedPiece, &Vec<(FormulaId, Expr)>)> = None;
        let same = |a: &[(FormulaId, Expr)], b: &[(FormulaId, Expr)]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.1 == b.1)
        };
        let mut refusals = Vec::new();
        for found in assert.iter().chain(guarantee) {
            match &found.piece {
                Piece::Persistent(_) => refusals.push(for_ever(self.for_ever_part(found.at))),
                Piece::Pair(when, _) => match first {
                    None => first = Some((found, when)),
                    Some((_, known)) if same(known, when) => {}
                    Some(_) => {
                        refusals.push(pair(found, "another guarantee has a different condition"));
                    }
                },
                _ => {}
            }
        }
        if let Some((found, _)) = first {
            let other = assert
                .iter()
                .chain(guarantee)
                .any(|f| matches!(f.piece, Piece::Recurrent(_)));
            if other {
                refusals.push(pair(
                    found,
                    "other guarantees with `F` or `G F` have no such condition",
                ));
            } else if soft_safety {
                refusals.push(pair(found, "the safety guarantees have no such condition"));
            }
        }
        for refusal in &refusals {
            self.refuse(refusal);
        }
        let Some((found, when)) = first else {
            return Vec::new();
        };
        when.iter().map(|(_, e)| formula(found, e)).collect()
    }

    /// The subformula `G b` of `F (a & G b)`.
    fn for_ever_part(&self, at: FormulaId) -> FormulaId {
        let formulas = &*self.classifier.formulas;
        let lasting = |f: &FormulaId| matches!(formulas.op(*f), Op::Globally(_));
        match formulas.op(at) {
            Op::Finally(a) => match formulas.op(*a) {
                Op::And(list) => list.iter().copied().find(lasting).unwrap_or(at),
                _ => at,
            },
            _ => at,
        }
    }
}

fn for_ever(at: FormulaId) -> Refusal {
    Refusal {
        at,
        why: "this guarantee has the form `F G` (from some step on for ever), which is outside GR(1)".to_owned(),
        help: "add an output `settled` that signals when it begins: `G (settled -> X settled)`, `G (settled -> a)` and `G F settled`".to_owned(),
    }
}

fn pair(found: &LocatedPiece, why: &str) -> Refusal {
    // `F G a | F G b` is a pair whose result is false: `G F !a & G F !b -> false`.
    if let Piece::Pair(when, Expr::Const(0)) = &found.piece {
        return for_ever(when.first().map_or(found.at, |w| w.0));
    }
    let at = match &found.piece {
        Piece::Pair(when, _) => when.first().map_or(found.at, |w| w.0),
        _ => found.at,
    };
    Refusal {
        at,
        why: format!("a guarantee depends on this happening infinitely often, but {why}: this is a Streett pair, which is outside GR(1)"),
        help: "put the condition under ASSUME, if all guarantees can depend on it: GR(1) is one implication, from all assumptions `G F a` to all guarantees `G F b`".to_owned(),
    }
}
