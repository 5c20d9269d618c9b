//! A file for one machine, asked of the other one.
//!
//! Where TARGET is not the machine that SEMANTICS was written for, the formula is moved by a step:
//! for a Moore machine a Mealy formula reads outputs one step later, for a Mealy machine a Moore
//! formula reads inputs one step later; or the other side one step earlier, where the formula reads
//! it behind `X` only. Either way the file has the verdict of its own semantics.

use super::ast::Semantics;
use super::found::Conjunct;
use super::ltl::{FormulaId, Formulas, Op};
use linewright_core::gr1::{Owner, VarId, Variable};

/// The formulas for the machine that is wanted, where they were written for the other one.
pub(super) fn moved(
    wishes: Vec<Conjunct>,
    formulas: &mut Formulas,
    semantics: Semantics,
    moore: bool,
    variables: &[Variable],
) -> Vec<Conjunct> {
    if semantics.moore == moore {
        return wishes;
    }
    let of = |owner: Owner| move |v: VarId| variables[v.index()].owner == owner;
    // The side that is read later, and the other one, which may as well be read earlier.
    let (later, other) = if moore {
        (Owner::System, Owner::Environment)
    } else {
        (Owner::Environment, Owner::System)
    };
    let all = wishes
        .iter()
        .all(|w| formulas.all_delayed(w.formula, &of(other)));
    let moved = wishes.into_iter().map(|w| Conjunct {
        formula: if all {
            formulas.undelayed(w.formula, &of(other))
        } else {
            formulas.delayed(w.formula, &of(later))
        },
        ..w
    });
    moved.collect()
}

impl Formulas {
    /// The same with every variable that `later` chooses read a step later.
    fn delayed(&mut self, f: FormulaId, later: &dyn Fn(VarId) -> bool) -> FormulaId {
        let place = self.place(f);
        match self.op(f).clone() {
            Op::True | Op::False => f,
            Op::Atom(v) => {
                if later(v) {
                    self.make(Op::Next(f), place)
                } else {
                    f
                }
            }
            op => {
                let op = self.mapped(op, &mut |s, g| s.delayed(g, later));
                self.make(op, place)
            }
        }
    }

    /// The same without the `X` before every variable that `now` chooses.
    fn undelayed(&mut self, f: FormulaId, now: &dyn Fn(VarId) -> bool) -> FormulaId {
        let place = self.place(f);
        match self.op(f).clone() {
            Op::True | Op::False | Op::Atom(_) => f,
            Op::Next(a) if matches!(self.op(a), Op::Atom(v) if now(*v)) => a,
            op => {
                let op = self.mapped(op, &mut |s, g| s.undelayed(g, now));
                self.make(op, place)
            }
        }
    }

    /// Whether every variable that `chosen` chooses appears directly behind an `X`.
    fn all_delayed(&self, f: FormulaId, chosen: &dyn Fn(VarId) -> bool) -> bool {
        match self.op(f) {
            Op::Atom(v) => !chosen(*v),
            Op::Next(a) if matches!(self.op(*a), Op::Atom(_)) => true,
            op => Self::children(op)
                .iter()
                .all(|g| self.all_delayed(*g, chosen)),
        }
    }
}
