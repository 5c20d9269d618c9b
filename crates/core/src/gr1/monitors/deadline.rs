//! Deadlines: every request within a scope is answered in its step or one of the n steps after it,
//! and before the scope closes.
//!
//! One counter is enough for all requests, since an answer answers all of them: it stores the age
//! of the oldest open request. Age 0 is not stored, because a request of this step is seen in this
//! step. Scopes that count only if they close need one more value, for a missed deadline. A request
//! that is open when the scope closes has broken the pattern for good.

use super::scope::{invariant, is};
use super::{BinaryOp, Domain, Expr, ITSELF, Monitors, Obligation, Origin, Scope, choose};

pub(super) struct Deadline<'a> {
    /// Request; false outside the scope.
    pub trigger: Expr,
    /// Answer.
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
            let mistake = self.trigger.clone().and(self.answer.clone().not());
            return scope.never(monitors, &mistake, origin);
        }
        let remembers = scope.counts_if_closed();
        let high = steps + i64::from(remembers);

        let age = Expr::now(ITSELF);
        let older = Expr::binary(BinaryOp::Add, age.clone(), Expr::Const(1));
        let older = Expr::binary(BinaryOp::Min, older, Expr::Const(high));
        let asked = choose(self.trigger.clone(), Expr::Const(1), Expr::Const(0));
        let unanswered = choose(is(&age, 0), asked, older);
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
