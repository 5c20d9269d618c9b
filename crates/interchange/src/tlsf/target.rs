//! Adapts a file whose TARGET is another machine than that of its SEMANTICS.
//!
//! If the two differ, the variables of one side are read at another step. For a Moore target, a
//! Mealy formula reads outputs one step later; for a Mealy target, a Moore formula reads inputs one
//! step later. If the other side's variables occur only directly after `X`, they are read one step
//! earlier instead. In both cases, the verdict is that of the original semantics.

use super::ast::Semantics;
use super::found::Conjunct;
use super::ltl::{FormulaId, Formulas, Op};
use linewright_core::gr1::{Owner, VarId, Variable};

/// The formulas adapted to the target machine; unchanged if the semantics has the same machine.
pub(super) fn adapted(
    conjuncts: Vec<Conjunct>,
    formulas: &mut Formulas,
    semantics: Semantics,
    moore: bool,
    variables: &[Variable],
) -> Vec<Conjunct> {
    if semantics.moore == moore {
        return conjuncts;
    }
    let of = |owner: Owner| move |v: VarId| variables[v.index()].owner == owner;
    // The side to read later, and the other side, which could be read earlier instead.
    let (later, other) = if moore {
        (Owner::System, Owner::Environment)
    } else {
        (Owner::Environment, Owner::System)
    };
    let all = conjuncts
        .iter()
        .all(|w| formulas.all_delayed(w.formula, &of(other)));
    let moved = conjuncts.into_iter().map(|w| Conjunct {
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
    /// The formula with an `X` before each variable that `later` accepts.
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
                let op = self.map_operands(op, &mut |s, g| s.delayed(g, later));
                self.make(op, place)
            }
        }
    }

    /// The formula without the `X` before each variable that `now` accepts.
    fn undelayed(&mut self, f: FormulaId, now: &dyn Fn(VarId) -> bool) -> FormulaId {
        let place = self.place(f);
        match self.op(f).clone() {
            Op::True | Op::False | Op::Atom(_) => f,
            Op::Next(a) if matches!(self.op(a), Op::Atom(v) if now(*v)) => a,
            op => {
                let op = self.map_operands(op, &mut |s, g| s.undelayed(g, now));
                self.make(op, place)
            }
        }
    }

    /// Whether each variable that `chosen` accepts occurs directly after an `X`.
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
