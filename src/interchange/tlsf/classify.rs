//! Formulas of temporal logic as parts of GR(1).
//!
//! | formula (`a`, `b` about finitely many steps) | becomes |
//! |---|---|
//! | `a` | an initial condition, or one on the first steps |
//! | `G a` | an invariant, or a condition from each step to the next, the past being remembered where `a` looks further ahead |
//! | `W`, `R`, `G`, `X` in any nesting | an invariant over the state of an [automaton](super::automaton) |
//! | `G F a` | recurrence |
//! | `F a` | recurrence of "a held once" |
//! | `G (a -> X X F b)` | recurrence of "nothing is unanswered" |
//! | `a U b` | `a W b` and `F b` |
//! | `F G a` | persistence, which only some places can take |
//! | a disjunction of these | what holds in the long run: `G F p` or `F G q` |

use super::automaton;
use super::ltl::{F, Formulas, Op};
use crate::gr1::monitors::{Monitors, Origin, Pattern, Scope};
use crate::gr1::{BinaryOp, Domain, Expr, Time, VarId};
use crate::interchange::terms::balanced;
use std::collections::BTreeMap;

/// A part of a formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Piece {
    /// Holds in step 0.
    Initial(Expr),
    /// Holds in every step, over current values.
    Invariant(Expr),
    /// Holds from every step to the next.
    Step(Expr),
    /// Holds again and again.
    Recurrent(Expr),
    /// Holds from some step on.
    Persistent(Expr),
    /// If the first ones hold again and again, then so does the last. The formulas are those that the first ones deny.
    Pair(Vec<(F, Expr)>, Expr),
}

/// Why a formula is none of GR(1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Refusal {
    pub at: F,
    pub why: String,
    pub help: String,
}

pub(super) struct Classifier<'f> {
    pub formulas: &'f mut Formulas,
    pub monitors: Monitors,
    pub origin: Origin,
    /// The variable that admits a broken promise.
    pub broken: VarId,
    /// The first monitor's variable.
    first: u32,
    /// Automata that are there already, by their updates.
    machines: BTreeMap<String, Expr>,
}

/// `X X F b`: how many `X`, and `b`.
fn awaited(formulas: &Formulas, f: F) -> Option<(u32, F)> {
    let (mut f, mut steps) = (f, 0);
    loop {
        match formulas.op(f) {
            Op::Next(a) => (f, steps) = (*a, steps + 1),
            Op::Finally(a) if formulas.ahead(*a).is_some() => return Some((steps, *a)),
            _ => return None,
        }
    }
}

impl<'f> Classifier<'f> {
    pub fn new(formulas: &'f mut Formulas, monitors: Monitors, first: u32, broken: VarId) -> Self {
        Self {
            formulas,
            monitors,
            origin: Origin::default(),
            broken,
            first,
            machines: BTreeMap::new(),
        }
    }

    /// A formula about one step. The recursion is as deep as the formula.
    pub fn state(formulas: &Formulas, f: F) -> Expr {
        let of = |g: &F| Self::state(formulas, *g);
        match formulas.op(f) {
            Op::True => Expr::TRUE,
            Op::False => Expr::FALSE,
            Op::Atom(v) => Expr::now(*v),
            Op::Not(a) => of(a).not(),
            Op::And(list) => balanced(BinaryOp::And, list.iter().map(of).collect()),
            Op::Or(list) => balanced(BinaryOp::Or, list.iter().map(of).collect()),
            Op::Implies(a, b) => of(a).implies(of(b)),
            Op::Iff(a, b) => of(a).equals(of(b)),
            _ => unreachable!("a formula about one step has no temporal operator"),
        }
    }

    /// Whether so many steps were before this one.
    fn begun(&mut self, steps: u32) -> Expr {
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

    /// A formula about finitely many steps, from the step that is `back` steps ago on; it may look one step ahead of now.
    fn seen(&mut self, f: F, back: i64) -> Expr {
        if self.formulas.is_state(f) {
            let e = Self::state(self.formulas, f).simplify();
            return match back {
                -1 => e.substitute(&mut |v, _| Expr::next(v)),
                back => (0..back).fold(e, |e, _| match e {
                    Expr::Const(_) => e,
                    e => self.before(&e),
                }),
            };
        }
        match self.formulas.op(f).clone() {
            Op::Not(a) => self.seen(a, back).not(),
            Op::And(list) => {
                let list = list.into_iter().map(|a| self.seen(a, back)).collect();
                balanced(BinaryOp::And, list)
            }
            Op::Or(list) => {
                let list = list.into_iter().map(|a| self.seen(a, back)).collect();
                balanced(BinaryOp::Or, list)
            }
            Op::Implies(a, b) => self.seen(a, back).implies(self.seen(b, back)),
            Op::Iff(a, b) => self.seen(a, back).equals(self.seen(b, back)),
            Op::Next(a) => self.seen(a, back - 1),
            _ => unreachable!("a formula about finitely many steps has no other operator than X"),
        }
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

    /// The pieces of one part; see [`Formulas::parts`].
    pub fn pieces(&mut self, f: F) -> Result<Vec<Piece>, Refusal> {
        self.piece(f).map(|p| vec![p])
    }

    fn piece(&mut self, f: F) -> Result<Piece, Refusal> {
        if let Some(ahead) = self.formulas.ahead(f) {
            if ahead == 0 {
                return Ok(Piece::Initial(Self::state(self.formulas, f).simplify()));
            }
            let now = self.begun(ahead - 1).and(self.begun(ahead).not());
            let e = self.seen(f, i64::from(ahead) - 1);
            return Ok(Piece::Step(now.implies(e).simplify()));
        }
        if let Op::Globally(a) = self.formulas.op(f).clone()
            && let Some(ahead) = self.formulas.ahead(a)
        {
            if ahead == 0 {
                return Ok(Piece::Invariant(Self::state(self.formulas, a).simplify()));
            }
            let from = self.begun(ahead - 1);
            let e = self.seen(a, i64::from(ahead) - 1);
            return Ok(Piece::Step(from.implies(e).simplify()));
        }
        if self.formulas.is_safety(f) {
            if let Some(ok) = self.watched(f) {
                return Ok(Piece::Invariant(ok));
            }
            if !matches!(self.formulas.op(f), Op::Or(_)) {
                return Err(Refusal {
                    at: f,
                    why: "what this formula has to remember is too much for a monitor".to_owned(),
                    help: "split it into formulas of their own, or remember with an output what they depend on".to_owned(),
                });
            }
        }
        let (mut inner, mut from) = (f, 0);
        while let Op::Next(a) = self.formulas.op(inner) {
            (inner, from) = (*a, from + 1);
        }
        match self.formulas.op(inner).clone() {
            Op::Globally(a) => {
                if let Op::Finally(b) = *self.formulas.op(a)
                    && let Some(ahead) = self.formulas.ahead(b)
                {
                    let e = self.seen(b, i64::from(ahead));
                    return Ok(Piece::Recurrent(e.simplify()));
                }
                self.response(a, from)
            }
            Op::Finally(a) => {
                if let Some(ahead) = self.formulas.ahead(a) {
                    let from = self.begun(ahead + from);
                    let e = self.seen(a, i64::from(ahead));
                    let origin = self.origin.clone();
                    let once = self.monitors.once(&from.and(e).simplify(), &origin);
                    return Ok(Piece::Recurrent(once));
                }
                if let Op::Globally(b) = *self.formulas.op(a)
                    && let Some(ahead) = self.formulas.ahead(b)
                {
                    let e = self.seen(b, i64::from(ahead));
                    return Ok(Piece::Persistent(e.simplify()));
                }
                self.denied(f).ok_or_else(|| self.nested(a, "`F`"))
            }
            Op::Or(list) => self.disjunction(&list),
            Op::Weak(a, b) | Op::Release(a, b) | Op::Until(a, b) => {
                let guilty = if self.formulas.is_safety(a) { b } else { a };
                Err(self.nested(guilty, "`U`, `W` or `R`"))
            }
            _ => Err(self.nested(inner, "a larger formula")),
        }
    }

    /// `G (a | X X F b)`: what is not a is answered by b two steps later or still later.
    fn response(&mut self, body: F, from: u32) -> Result<Piece, Refusal> {
        let list = match self.formulas.op(body).clone() {
            Op::Or(list) => list,
            _ => vec![body],
        };
        let (mut given, mut wait, mut answers) = (Vec::new(), None, Vec::new());
        for part in list {
            if self.formulas.ahead(part).is_some() {
                given.push(part);
                continue;
            }
            match awaited(self.formulas, part) {
                Some((steps, answer)) if wait.is_none_or(|w| w == steps) => {
                    wait = Some(steps);
                    answers.push(answer);
                }
                Some(_) => {
                    return Err(Refusal {
                        at: part,
                        why: "two answers are awaited from different steps on".to_owned(),
                        help: "what is known is `G (a -> X F (b || c))`: put the same number of `X` before each `F`".to_owned(),
                    });
                }
                None => return Err(self.nested(part, "`G`")),
            }
        }
        let place = self.formulas.place(body);
        let (given, answer) = (
            self.formulas.or(given, place),
            self.formulas.or(answers, place),
        );
        let wait = wait.unwrap_or(0);
        let (a, b) = (
            self.formulas.ahead(given).unwrap_or(0),
            self.formulas.ahead(answer).unwrap_or(0),
        );
        let back = b.max(a.saturating_sub(wait));
        let begun = self.begun(back + wait + from);
        let given = self.seen(given, i64::from(back + wait));
        let answer = self.seen(answer, i64::from(back));
        let pattern = Pattern::Response {
            trigger: begun.and(given.not()).simplify(),
            answer: answer.simplify(),
            within: None,
        };
        let origin = self.origin.clone();
        let found = self.monitors.pattern(&pattern, &Scope::Globally, &origin);
        let parts = found.into_iter().map(|o| o.expr).collect();
        Ok(Piece::Recurrent(balanced(BinaryOp::And, parts)))
    }

    /// A formula whose denial is recurrence: `F (a & X G !b)` denies `G (a -> X F b)`.
    fn denied(&mut self, f: F) -> Option<Piece> {
        let denial = self.formulas.positive(f, true);
        let Op::Globally(_) = self.formulas.op(denial) else {
            return None;
        };
        let parts = self.formulas.parts(denial);
        let [part] = parts.as_slice() else {
            return None;
        };
        match self.piece(*part) {
            Ok(Piece::Recurrent(e)) => Some(Piece::Persistent(e.not().simplify())),
            _ => None,
        }
    }

    /// What a disjunction comes to in the long run.
    fn disjunction(&mut self, list: &[F]) -> Result<Piece, Refusal> {
        let (finite, other): (Vec<F>, Vec<F>) = list
            .iter()
            .partition(|g| self.formulas.ahead(**g).is_some());
        let mut all = other;
        if let Some(first) = finite.first() {
            let place = self.formulas.place(*first);
            let joined = self.formulas.or(finite, place);
            all.push(joined);
        }
        let (mut when, mut then) = (Vec::new(), Vec::new());
        for g in all {
            match self.piece(g)? {
                Piece::Recurrent(e) => then.push(e),
                Piece::Persistent(e) => when.push((g, e.not().simplify())),
                Piece::Pair(conditions, e) => {
                    when.extend(conditions);
                    then.push(e);
                }
                safety => {
                    if let Some(e) = self.past(&safety) {
                        then.push(self.kept(&e));
                    }
                }
            }
        }
        let then = balanced(BinaryOp::Or, then);
        Ok(if when.is_empty() {
            Piece::Recurrent(then)
        } else {
            Piece::Pair(when, then)
        })
    }

    /// An invariant that holds as long as a safety formula can still hold.
    fn watched(&mut self, f: F) -> Option<Expr> {
        let automaton = {
            let formulas = &*self.formulas;
            automaton::of(formulas, f, &|g| Self::state(formulas, g))?
        };
        let count = automaton.steps.len();
        let (ok, index) = (
            |t: Option<usize>| i64::from(t.is_some()),
            |t: Option<usize>| t.unwrap_or(0) as i64,
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

    /// The smallest temporal formula in one that stands where none can.
    fn nested(&self, f: F, within: &str) -> Refusal {
        let (mut at, mut within) = (f, within);
        loop {
            let next = match self.formulas.op(at) {
                Op::Next(a) => Some(*a),
                Op::And(list) | Op::Or(list) => {
                    let find =
                        |wanted: &dyn Fn(F) -> bool| list.iter().copied().find(|g| wanted(*g));
                    find(&|g| !self.formulas.is_safety(g))
                        .or_else(|| find(&|g| self.formulas.ahead(g).is_none()))
                }
                Op::Finally(a) if self.formulas.ahead(*a).is_none() => {
                    let persistent = matches!(self.formulas.op(*a), Op::Globally(_));
                    (!persistent).then(|| {
                        within = "`F`";
                        *a
                    })
                }
                // What it waits for, or what holds until then, is itself something to wait for.
                Op::Weak(a, b) | Op::Until(a, b) | Op::Release(a, b) => {
                    let found = [*a, *b].into_iter().find(|g| !self.formulas.is_safety(*g));
                    if found.is_some() {
                        within = "`U`, `W` or `R`";
                    }
                    found
                }
                _ => None,
            };
            match next {
                Some(next) => at = next,
                None => break,
            }
        }
        let (word, help) = match self.formulas.op(at) {
            Op::Until(..) | Op::Weak(..) | Op::Release(..) => (
                "this `U`, `W` or `R`",
                "`a U b` is split into `a W b` and `F b`, and the `F` has to stand alone, under `G`, or behind `->` under `G`: \
                 remember with an output how far the inner one has come",
            ),
            Op::Finally(g) if matches!(self.formulas.op(*g), Op::Globally(_)) => (
                "`F G`",
                "\"some day and from then on\" has no equivalent: let an output say when it begins, `G (settled -> X settled)`, \
                 `G (settled -> a)` and `G F settled`",
            ),
            Op::Globally(g) if matches!(self.formulas.op(*g), Op::Finally(_)) => (
                "`G F`",
                "`G F a` has to stand alone, beside `||`, or behind `->`",
            ),
            Op::Finally(_) => (
                "this `F`",
                "`F` has to stand alone, under `G`, or behind `->` under `G`: remember with an output what it depends on",
            ),
            _ => (
                "this `G`",
                "`G` has to stand alone, or within `X`, `W`, `R` and `G`: remember with an output what it depends on",
            ),
        };
        Refusal {
            at,
            why: format!("{word} stands within {within}, which is outside GR(1)"),
            help: help.to_owned(),
        }
    }
}
