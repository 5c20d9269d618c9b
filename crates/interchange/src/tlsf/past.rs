//! Expresses formulas about finitely many steps, and safety formulas, as conditions on the current
//! step and on monitors of the past.

use super::automaton;
use super::classify::{Classifier, Piece};
use super::ltl::{FormulaId, Formulas, Op};
use crate::terms::{balanced, negated};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Time, VarId};
use std::collections::BTreeMap;

impl Classifier<'_> {
    /// The expression of a formula about a single step; `None` for other formulas. The recursion is
    /// as deep as the formula.
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

    /// The condition that at least `steps` steps precede the current one.
    pub fn started(&mut self, steps: u32) -> Expr {
        (0..steps).fold(Expr::TRUE, |e, _| self.before(&e))
    }

    /// The condition `e` on a single transition; `transition` is the number of those before it.
    pub fn only_in(&mut self, transition: u32, e: Expr) -> Piece {
        let now = self.started(transition);
        let now = now.and(self.started(transition + 1).not());
        Piece::Step(now.implies(e).simplify())
    }

    fn before(&mut self, e: &Expr) -> Expr {
        let origin = self.origin.clone();
        match e.simplify() {
            // The previous value of the constant false is false, and the result is false in step 0
            // anyway. So it is always false and needs no monitor.
            Expr::Const(0) => Expr::FALSE,
            e => self.monitors.previous(&e, &origin),
        }
    }

    /// The expression of a formula about finitely many steps, evaluated `back` steps ago. If `back`
    /// is -1, it refers to next values. `None` for other formulas.
    pub fn expr_at(&mut self, f: FormulaId, back: i64) -> Option<Expr> {
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
            Op::Not(a) => negated(&self.expr_at(a, back)?),
            Op::And(list) => balanced(BinaryOp::And, self.exprs_at(&list, back)?),
            Op::Or(list) => balanced(BinaryOp::Or, self.exprs_at(&list, back)?),
            Op::Implies(a, b) => self.expr_at(a, back)?.implies(self.expr_at(b, back)?),
            Op::Iff(a, b) => self.expr_at(a, back)?.equals(self.expr_at(b, back)?),
            Op::Next(a) => self.expr_at(a, back - 1)?,
            _ => return None,
        })
    }

    fn exprs_at(&mut self, list: &[FormulaId], back: i64) -> Option<Vec<Expr>> {
        list.iter().map(|a| self.expr_at(*a, back)).collect()
    }

    /// Rewrites a transition formula as a condition on the previous and the current step. It is
    /// true in step 0.
    pub fn transition_to_past(&mut self, e: &Expr) -> Expr {
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
        self.started(1).implies(e).simplify()
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

    /// A safety piece as an invariant over current values and the past; `None` for other pieces.
    pub fn past(&mut self, piece: &Piece) -> Option<Expr> {
        Some(match piece {
            Piece::Initial(e) => self.started(1).or(e.clone()).simplify(),
            Piece::Invariant(e) => e.clone(),
            Piece::Step(e) => self.transition_to_past(e),
            _ => return None,
        })
    }

    /// The condition that `e` has held in every step so far, including the current one.
    pub fn kept(&mut self, e: &Expr) -> Expr {
        let origin = self.origin.clone();
        self.monitors.historically(e, &origin)
    }

    /// The condition that `e` held in the previous step; true in step 0.
    pub fn previous_step(&mut self, e: &Expr) -> Expr {
        let held = self.before(e);
        self.started(1).implies(held).simplify()
    }

    /// The condition that this is not the first step.
    pub fn not_first(&mut self) -> Expr {
        self.started(1)
    }

    /// An invariant that holds until a safety formula is violated; `None` if the formula's
    /// automaton is too large.
    pub fn safety_monitor(&mut self, f: FormulaId) -> Option<Expr> {
        let automaton = {
            let formulas = &*self.formulas;
            automaton::of(formulas, f, &|g| Self::state(formulas, g))?
        };
        let count = automaton.state_count();
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
        // Equal automata share a monitor.
        let key = format!("{automaton:?}");
        if let Some(Expr::Var(v, _)) = self.state_variables.get(&key) {
            return Some(automaton.by_state(&state(*v), &ok));
        }
        let id = VarId(self.first + self.monitors.all().len() as u32);
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
        self.state_variables.insert(key, value);
        Some(automaton.by_state(&state(id), &ok))
    }

    /// An invariant for `a W b` or `a R b`, where `a` and `b` are about finitely many steps,
    /// however many; `None` for other formulas.
    ///
    /// For `W`, it requires `a` unless `b` has held in this step or before. For `R`, it requires
    /// `b` unless `a` held in an earlier step.
    pub fn unless(&mut self, f: FormulaId) -> Option<Expr> {
        let (kept, end, release) = match *self.formulas.op(f) {
            Op::Weak(a, b) => (a, b, false),
            Op::Release(a, b) => (b, a, true),
            _ => return None,
        };
        let back = self.formulas.ahead(kept)?.max(self.formulas.ahead(end)?);
        let started = self.started(back);
        let (kept, end) = (
            self.expr_at(kept, i64::from(back))?,
            self.expr_at(end, i64::from(back))?,
        );
        let origin = self.origin.clone();
        let mut over = (self.monitors).once(&started.clone().and(end).simplify(), &origin);
        if release {
            over = self.before(&over);
        }
        Some(started.implies(kept.or(over)).simplify())
    }
}
