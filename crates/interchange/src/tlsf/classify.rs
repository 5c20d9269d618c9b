//! Classifies formulas of temporal logic as pieces of GR(1).
//!
//! | formula (`a`, `b` about finitely many steps) | piece |
//! |---|---|
//! | `a` | an initial condition, or one on the first steps |
//! | `G a` | an invariant or a transition formula; monitors remember the past if `a` looks further ahead |
//! | `W`, `R`, `G`, `X` in any nesting | an invariant over the state of an [automaton](super::automaton) |
//! | `G F a` | justice |
//! | `F a` | justice of "a held once" |
//! | `G (a -> X X F b)` | justice of "no request is unanswered"; answers that can come earlier are expanded with `F b = b \| X F b` |
//! | negation of a safety formula, `F (a & X (b U c))` | justice of "the safety formula is violated" |
//! | `a U b` | `a W b` and `F b` |
//! | `F G a` | persistence, allowed only in some positions |
//! | a disjunction of these | a formula about the long run: `G F p` or `F G q` |

use super::ltl::{FormulaId, Formulas, Op};
use crate::terms::{balanced, negated};
use linewright_core::gr1::monitors::{Monitors, Origin, Pattern, Scope};
use linewright_core::gr1::{BinaryOp, Expr, VarId};
use std::collections::BTreeMap;

/// A piece of GR(1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Piece {
    /// Holds in step 0.
    Initial(Expr),
    /// Holds in every step, over current values.
    Invariant(Expr),
    /// Holds for every transition.
    Step(Expr),
    /// Holds infinitely often.
    Recurrent(Expr),
    /// Holds from some step on.
    Persistent(Expr),
    /// If each condition holds infinitely often, so does the result. Each condition comes with the
    /// persistent formula that it negates.
    Pair(Vec<(FormulaId, Expr)>, Expr),
}

/// The reason why a formula is outside GR(1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Refusal {
    pub at: FormulaId,
    pub why: String,
    pub help: String,
}

pub(super) struct Classifier<'f> {
    pub formulas: &'f mut Formulas,
    pub monitors: Monitors,
    pub origin: Origin,
    /// The variable that is true after a guarantee was broken.
    pub broken: VarId,
    /// Index of the first monitor's variable.
    pub first: u32,
    /// State variables of the automata that already exist, each with the debug text of its
    /// automaton as the key.
    pub state_variables: BTreeMap<String, Expr>,
    /// Whether a negation is being classified, which prevents a second negation.
    in_negation: bool,
}

/// For `X X F b`, the number of `X` and the formula `b`.
fn answered(formulas: &Formulas, f: FormulaId) -> Option<(u32, FormulaId)> {
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
            state_variables: BTreeMap::new(),
            in_negation: false,
        }
    }

    /// Classifies a part of a formula; [`Formulas::parts`] splits formulas into parts.
    pub fn piece(&mut self, f: FormulaId) -> Result<Piece, Refusal> {
        match self.direct(f) {
            Err(refusal) => (self.co_safety(f))
                .or_else(|| self.negated_pieces(f))
                .ok_or(refusal),
            found => found,
        }
    }

    fn direct(&mut self, f: FormulaId) -> Result<Piece, Refusal> {
        if let Some(ahead) = self.formulas.ahead(f)
            && let Some(e) = self.expr_at(f, i64::from(ahead.max(1)) - 1)
        {
            if ahead == 0 {
                return Ok(Piece::Initial(e.simplify()));
            }
            return Ok(self.only_in(ahead - 1, e));
        }
        if let Op::Globally(a) = self.formulas.op(f).clone()
            && let Some(ahead) = self.formulas.ahead(a)
            && let Some(e) = self.expr_at(a, i64::from(ahead.max(1)) - 1)
        {
            if ahead == 0 {
                return Ok(Piece::Invariant(e.simplify()));
            }
            let from = self.started(ahead - 1);
            return Ok(Piece::Step(from.implies(e).simplify()));
        }
        if self.formulas.is_safety(f) {
            if let Some(ok) = self.safety_monitor(f).or_else(|| self.unless(f)) {
                return Ok(Piece::Invariant(ok));
            }
            if !matches!(self.formulas.op(f), Op::Or(_)) {
                return Err(Refusal {
                    at: f,
                    why: "this formula needs a monitor that is too large".to_owned(),
                    help: "split it into several formulas, or add an output that remembers what it depends on".to_owned(),
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
                    && let Some(e) = self.past_expr(b)
                {
                    return Ok(Piece::Recurrent(e));
                }
                self.response(a, from)
            }
            Op::Finally(a) => {
                if let Some(ahead) = self.formulas.ahead(a)
                    && let Some(e) = self.expr_at(a, i64::from(ahead))
                {
                    let from = self.started(ahead + from);
                    let origin = self.origin.clone();
                    let once = self.monitors.once(&from.and(e).simplify(), &origin);
                    return Ok(Piece::Recurrent(once));
                }
                if let Op::Globally(b) = *self.formulas.op(a)
                    && let Some(e) = self.past_expr(b)
                {
                    return Ok(Piece::Persistent(e));
                }
                Err(self.nested(a, "`F`"))
            }
            Op::Or(list) => self.disjunction(&list),
            Op::Weak(a, b) | Op::Release(a, b) | Op::Until(a, b) => {
                let guilty = if self.formulas.is_safety(a) { b } else { a };
                Err(self.nested(guilty, "`U`, `W` or `R`"))
            }
            _ => Err(self.nested(inner, "a larger formula")),
        }
    }

    /// The expression of a formula about finitely many steps, evaluated in its last step; `None`
    /// for other formulas. Used only for justice, where the value in the first steps does not
    /// matter.
    fn past_expr(&mut self, f: FormulaId) -> Option<Expr> {
        // One step less is enough, because justice formulas can refer to the next step directly.
        let ahead = self.formulas.ahead(f)?.max(1) - 1;
        Some(self.expr_at(f, i64::from(ahead))?.simplify())
    }

    /// The piece of `G (a | X X F b)`: each step without a is followed by b, at least two steps
    /// later.
    fn response(&mut self, body: FormulaId, from: u32) -> Result<Piece, Refusal> {
        let list = match self.formulas.op(body).clone() {
            Op::Or(list) => list,
            _ => vec![body],
        };
        let (mut given, mut awaited, mut wait) = (Vec::new(), Vec::new(), 0);
        for part in list {
            if self.formulas.ahead(part).is_some() {
                given.push(part);
            } else if let Some((steps, answer)) = answered(self.formulas, part) {
                awaited.push((steps, answer));
                wait = wait.max(steps);
            } else {
                return Err(self.nested(part, "`G`"));
            }
        }
        let place = self.formulas.place(body);
        let mut answers = Vec::new();
        for (steps, answer) in awaited {
            // F b = b | X F b
            for early in steps..wait {
                let early = (0..early).fold(answer, |f, _| self.formulas.next(f, place));
                given.push(early);
            }
            answers.push(answer);
        }
        let (given, answer) = (
            self.formulas.or(given, place),
            self.formulas.or(answers, place),
        );
        let (a, b) = (
            self.formulas.ahead(given).unwrap_or(0),
            self.formulas.ahead(answer).unwrap_or(0),
        );
        let back = b.max(a.saturating_sub(wait));
        let started = self.started(back + wait + from);
        let given = self.expr_at(given, i64::from(back + wait));
        let (Some(given), Some(answer)) = (given, self.expr_at(answer, i64::from(back))) else {
            return Err(self.nested(body, "`G`"));
        };
        let pattern = Pattern::Response {
            trigger: started.and(negated(&given)).simplify(),
            answer: answer.simplify(),
            within: None,
        };
        let origin = self.origin.clone();
        let found = self.monitors.pattern(&pattern, &Scope::Globally, &origin);
        let parts = found.into_iter().map(|o| o.expr).collect();
        Ok(Piece::Recurrent(balanced(BinaryOp::And, parts)))
    }

    /// The piece of a co-safety formula. Its negation is a safety formula, which has to be violated
    /// eventually.
    fn co_safety(&mut self, f: FormulaId) -> Option<Piece> {
        let denial = self.formulas.positive(f, true);
        if !self.formulas.is_safety(denial) {
            return None;
        }
        let mut kept = Vec::new();
        for part in self.formulas.parts(denial) {
            let piece = self.piece(part).ok()?;
            let e = self.past(&piece)?;
            kept.push(e);
        }
        let kept = self.kept(&balanced(BinaryOp::And, kept));
        Some(Piece::Recurrent(negated(&kept)))
    }

    /// The piece of a formula whose negation consists of pieces: `F (a & X G !b)` is the negation
    /// of `G (a -> X F b)`.
    fn negated_pieces(&mut self, f: FormulaId) -> Option<Piece> {
        if self.in_negation {
            return None;
        }
        self.in_negation = true;
        let found = self.classify_negation(f);
        self.in_negation = false;
        found
    }

    fn classify_negation(&mut self, f: FormulaId) -> Option<Piece> {
        let denial = self.formulas.positive(f, true);
        let (mut when, mut then) = (Vec::new(), Vec::new());
        for part in self.formulas.parts(denial) {
            match self.piece(part).ok()? {
                Piece::Recurrent(e) => when.push((f, e)),
                Piece::Persistent(e) => then.push(negated(&e)),
                Piece::Pair(..) => return None,
                safety => {
                    let e = self.past(&safety)?;
                    then.push(negated(&self.kept(&e)));
                }
            }
        }
        Some(match (when.as_slice(), then.as_slice()) {
            ([(_, e)], []) => Piece::Persistent(negated(e)),
            _ => long_run(when, then),
        })
    }

    /// The piece of a disjunction.
    fn disjunction(&mut self, list: &[FormulaId]) -> Result<Piece, Refusal> {
        let (finite, other): (Vec<FormulaId>, Vec<FormulaId>) = list
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
                Piece::Persistent(e) => when.push((g, negated(&e))),
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
        Ok(long_run(when, then))
    }
}

/// The piece "if all of `when` hold infinitely often, so does one of `then`".
fn long_run(when: Vec<(FormulaId, Expr)>, then: Vec<Expr>) -> Piece {
    let then = balanced(BinaryOp::Or, then).simplify();
    if when.is_empty() {
        Piece::Recurrent(then)
    } else {
        Piece::Pair(when, then)
    }
}
