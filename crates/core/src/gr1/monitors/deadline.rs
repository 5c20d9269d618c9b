//! Deadlines: every request within a scope is answered in its step or one of the n steps after it,
//! and before the scope closes.
//!
//! One counter is enough for all requests, since one answer completes all of them: it stores the
//! age of the oldest open request, and 0 if no request is open. A request of this step need not be
//! stored, because it can be read directly. Scopes that count only if they close need one more
//! value, for a missed deadline. If a request is open when the scope closes, the pattern is
//! violated permanently.

use super::scope::{invariant, is};
use super::{BinaryOp, Domain, Expr, Monitors, Obligation, Origin, SELF_VALUE, Scope, choose};

pub(super) struct Deadline<'a> {
    /// Condition that makes a request; false outside the scope.
    pub trigger: Expr,
    /// Condition that answers all open requests.
    pub answer: &'a Expr,
    /// Maximum number of steps from request to answer.
    pub steps: u32,
    /// Whether there was a request one step before step 0.
    pub from_start: bool,
}

impl Deadline<'_> {
    pub fn lower(
        &self,
        monitors: &mut Monitors,
        scope: &Scope,
        origin: &Origin,
    ) -> Vec<Obligation> {
        let (steps, initial) = (i64::from(self.steps), i64::from(self.from_start));
        if steps == 0 {
            let violation = self.trigger.clone().and(self.answer.clone().not());
            return scope.never(monitors, &violation, origin);
        }
        let remembers = scope.counts_if_closed();
        let high = steps + i64::from(remembers);

        let age = Expr::now(SELF_VALUE);
        let older = Expr::binary(BinaryOp::Add, age.clone(), Expr::Const(1));
        let older = Expr::binary(BinaryOp::Min, older, Expr::Const(high));
        let requested = choose(self.trigger.clone(), Expr::Const(1), Expr::Const(0));
        let unanswered = choose(is(&age, 0), requested, older);
        let mut update = choose(self.answer.clone(), Expr::Const(0), unanswered);
        if remembers {
            update = choose(is(&age, high), age, update);
        }
        let domain = Domain::Range { low: 0, high };
        let age = monitors.make("age", domain, initial, &update.simplify(), origin);

        let in_time = is(&age, steps).implies(self.answer.clone());
        match scope.end() {
            None => invariant(&in_time),
            Some(r) => {
                let mut found = invariant(&r.clone().implies(is(&age, 0)));
                if !remembers {
                    found.extend(invariant(&in_time));
                }
                found
            }
        }
    }
}
