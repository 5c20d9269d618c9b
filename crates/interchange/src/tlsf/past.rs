//! Formulas about finitely many steps, and safety, as conditions on this step and what monitors
//! remember.

use super::automaton;
use super::classify::{Classifier, Piece};
use super::ltl::{FormulaId, Formulas, Op};
use crate::terms::{balanced, negated};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Time, VarId};
use std::collections::BTreeMap;

impl Classifier<'_> {
    /// A formula about one step, `None` for any other. The recursion is as deep as the formula.
    pub fn state(formulas: &Formulas, f: FormulaId) -> Option<Expr> {
        let of = |g: &FormulaId| Self::state(formulas, *g);
        let all = |list: &[FormulaId]| list.iter().map(of).collect::<Option<Vec<Expr>>>();
        Some(match formulas.op(f) {
            Op::True => Expr::TRUE,
            Op::False => Expr::FALSE,
            Op::Atom(v) => Expr::now(*v),
            Op::Not(a) => negated(&of(a)?),
            Op::And(list) => balanced(BinaryOp::And, all(list)?),
            Op::Or(list) => balanced(BinaryOp::Or, all(list)?),
            Op::Implies(a, b) => of(a)?.implies(of(b)?),
            Op::Iff(a, b) => of(a)?.equals(of(b)?),
            _ => return None,
        })
    }

    /// Whether at least this many steps precede the current one.
    pub fn begun(&mut self, steps: u32) -> Expr {
        (0..steps).fold(Expr::TRUE, |e, _| self.before(&e))
    }

    fn before(&mut self, e: &Expr) -> Expr {
        let origin = self.origin.clone();
        match e.simplify() {
            // It was not true before there was a step.
            Expr::Const(0) => Expr::FALSE,
            e => self.monitors.previous(&e, &origin),
        }
    }

    /// A formula about finitely many steps, from the step that is `back` steps ago on; it may look
    /// one step ahead of now. `None` for any other.
    pub fn seen(&mut self, f: FormulaId, back: i64) -> Option<Expr> {
        if self.formulas.is_state(f) {
            let e = Self::state(self.formulas, f)?.simplify();
            return Some(match back {
                -1 => e.substitute(&mut |v, _| Expr::next(v)),
                back => (0..back).fold(e, |e, _| match e {
                    Expr::Const(_) => e,
                    e => self.before(&e),
                }),
            });
        }
        Some(match self.formulas.op(f).clone() {
            Op::Not(a) => negated(&self.seen(a, back)?),
            Op::And(list) => balanced(BinaryOp::And, self.all_seen(&list, back)?),
            Op::Or(list) => balanced(BinaryOp::Or, self.all_seen(&list, back)?),
            Op::Implies(a, b) => self.seen(a, back)?.implies(self.seen(b, back)?),
            Op::Iff(a, b) => self.seen(a, back)?.equals(self.seen(b, back)?),
            Op::Next(a) => self.seen(a, back - 1)?,
            _ => return None,
        })
    }

    fn all_seen(&mut self, list: &[FormulaId], back: i64) -> Option<Vec<Expr>> {
        list.iter().map(|a| self.seen(*a, back)).collect()
    }

    /// A condition from each step to the next as one about this step, which is true in step 0.
    pub fn late(&mut self, e: &Expr) -> Expr {
        let mut moved = BTreeMap::new();
        e.for_each_var(&mut |v, time| {
            if time == Time::Now {
                moved.insert(v, Expr::FALSE);
            }
        });
        for (v, slot) in &mut moved {
            *slot = self.value_before(*v);
        }
        let e = e.substitute(&mut |v, time| match time {
            Time::Now => moved[&v].clone(),
            Time::Next => Expr::now(v),
        });
        self.begun(1).implies(e).simplify()
    }

    fn value_before(&mut self, v: VarId) -> Expr {
        let domain = match self.monitors.get(v) {
            Some(monitor) => monitor.variable.domain.clone(),
            None => Domain::Bool,
        };
        let origin = self.origin.clone();
        match domain {
            Domain::Bool => self.monitors.previous(&Expr::now(v), &origin),
            domain => {
                let low = domain.low();
                self.monitors
                    .previous_value(&Expr::now(v), domain, low, &origin)
            }
        }
    }

    /// A piece of safety as a condition on every step about current values and the past.
    pub fn past(&mut self, piece: &Piece) -> Option<Expr> {
        Some(match piece {
            Piece::Initial(e) => self.begun(1).or(e.clone()).simplify(),
            Piece::Invariant(e) => e.clone(),
            Piece::Step(e) => self.late(e),
            _ => return None,
        })
    }

    /// That it has held in every step so far, this one included.
    pub fn kept(&mut self, e: &Expr) -> Expr {
        let origin = self.origin.clone();
        self.monitors.historically(e, &origin)
    }

    /// That a condition on every step held in the step before.
    pub fn one_later(&mut self, e: &Expr) -> Expr {
        let held = self.before(e);
        self.begun(1).implies(held).simplify()
    }

    /// Whether this is not the first step.
    pub fn not_first(&mut self) -> Expr {
        self.begun(1)
    }

    /// An invariant that holds as long as a safety formula can still hold.
    pub fn watched(&mut self, f: FormulaId) -> Option<Expr> {
        let automaton = {
            let formulas = &*self.formulas;
            automaton::of(formulas, f, &|g| Self::state(formulas, g))?
        };
        let count = automaton.states();
        let (ok, index) = (
            |t: Option<u32>| i64::from(t.is_some()),
            |t: Option<u32>| i64::from(t.unwrap_or(0)),
        );
        if count == 1 {
            return Some(automaton.by_state(&|_| Expr::TRUE, &ok));
        }
        let high = count as i64 - 1;
        let state = |v: VarId| {
            move |s: usize| match (high, s) {
                (1, 0) => Expr::now(v).not(),
                (1, _) => Expr::now(v),
                _ => Expr::now(v).equals(Expr::Const(s as i64)),
            }
        };
        // The same automaton again is the same monitor.
        let key = format!("{automaton:?}");
        if let Some(Expr::Var(v, _)) = self.machines.get(&key) {
            return Some(automaton.by_state(&state(*v), &ok));
        }
        let id = VarId(self.first + self.monitors.made().len() as u32);
        let update = automaton.by_state(&state(id), &index);
        let domain = if high == 1 {
            Domain::Bool
        } else {
            Domain::Range { low: 0, high }
        };
        let origin = self.origin.clone();
        let value = self.monitors.previous_value(&update, domain, 0, &origin);
        let Expr::Var(id, _) = value else {
            return Some(automaton.by_state(&|_| Expr::TRUE, &ok));
        };
        self.machines.insert(key, value);
        Some(automaton.by_state(&state(id), &ok))
    }

    /// `a W b` and `a R b` about finitely many steps, on which there is no bound here: `a` in every
    /// step up to which `b` has not been, and `b` in every step before which `a` has not been.
    pub fn unless(&mut self, f: FormulaId) -> Option<Expr> {
        let (kept, end, release) = match *self.formulas.op(f) {
            Op::Weak(a, b) => (a, b, false),
            Op::Release(a, b) => (b, a, true),
            _ => return None,
        };
        let back = self.formulas.ahead(kept)?.max(self.formulas.ahead(end)?);
        let begun = self.begun(back);
        let (kept, end) = (
            self.seen(kept, i64::from(back))?,
            self.seen(end, i64::from(back))?,
        );
        let origin = self.origin.clone();
        let mut over = (self.monitors).once(&begun.clone().and(end).simplify(), &origin);
        if release {
            over = self.before(&over);
        }
        Some(begun.implies(kept.or(over)).simplify())
    }
}
