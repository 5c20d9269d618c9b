//! Lowers `PREV ONCE HISTORICALLY SINCE TRIGGERED` to
//! [`monitors`](linewright_core::gr1::monitors).
//!
//! | | in step t |
//! |---|---|
//! | `PREV p` | t > 0, and p in step t - 1 |
//! | `ONCE p` | p in some step up to t |
//! | `HISTORICALLY p` | p in all steps up to t |
//! | `p SINCE q` | q in some step k up to t, and p in all steps after k up to t |
//! | `p TRIGGERED q` | not (not p SINCE not q) |
//!
//! The operand of `PREV` can refer to its next step, which is the current step of `PREV`. If the
//! operand also refers to its own step, a monitor remembers each variable that it mentions there.

use super::reader::Reader;
use super::syntax::{Node, Past, SinceOp};
use super::types::kind_of;
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Expr, Time};
use linewright_core::source::Span;

impl Reader {
    pub fn past(&mut self, past: Past, value: &Value, span: Span) -> Option<Value> {
        if past == Past::Previous && value.expr.mentions_next() {
            return Some(self.previous_transition(&value.expr));
        }
        self.check_present(value, span)?;
        let origin = self.origin.clone();
        let expr = match past {
            Past::Previous => self.monitors.previous(&value.expr, &origin),
            Past::Once => self.monitors.once(&value.expr, &origin),
            Past::Historically => self.monitors.historically(&value.expr, &origin),
        };
        Some(Value::of(expr, Kind::Bool))
    }

    /// The value of `PREV p` for a formula `p` that refers to its own step and to the next one.
    fn previous_transition(&mut self, expr: &Expr) -> Value {
        let origin = self.origin.clone();
        let started = self.monitors.previous(&Expr::TRUE, &origin);
        let mut mentioned = Vec::new();
        expr.for_each_var(&mut |v, time| {
            if time == Time::Now && mentioned.iter().all(|(w, _)| *w != v) {
                mentioned.push((v, Expr::TRUE));
            }
        });
        for (v, before) in &mut mentioned {
            let domain = self.variable(*v).domain.clone();
            let low = domain.low();
            let now = Expr::now(*v);
            *before = match kind_of(&domain) {
                Kind::Bool => self.monitors.previous(&now, &origin),
                _ => self.monitors.previous_value(&now, domain, low, &origin),
            };
        }
        let shifted = expr.substitute(&mut |v, time| match time {
            Time::Next => Expr::now(v),
            Time::Now => mentioned
                .iter()
                .find(|(w, _)| *w == v)
                .map_or(Expr::now(v), |(_, before)| before.clone()),
        });
        Value::of(started.and(shifted), Kind::Bool)
    }

    pub fn since(&mut self, first: &Node, rest: &[(SinceOp, Node)]) -> Option<Value> {
        let mut value = self.truth(first)?;
        self.check_present(&value, first.span)?;
        for (op, node) in rest {
            let other = self.truth(node)?;
            self.check_present(&other, node.span)?;
            let origin = self.origin.clone();
            let expr = match op {
                SinceOp::Since => self.monitors.since(&value.expr, &other.expr, &origin),
                SinceOp::Triggered => {
                    self.note(
                        codes::OWN_TOOL,
                        node.span,
                        "Spectra's tool reads `p TRIGGERED q` as `p SINCE q` from step 1 on, and as `p | q` in step 0; here it has its meaning in temporal logic",
                        "write `!(!p SINCE !q)`, which both tools read alike",
                    );
                    let (p, q) = (value.not(), other.not());
                    let since = self.monitors.since(&p.expr, &q.expr, &origin);
                    since.not().simplify()
                }
            };
            value = self.check_size(Value::of(expr, Kind::Bool), node.span)?;
        }
        Some(value)
    }

    fn check_present(&mut self, value: &Value, span: Span) -> Option<()> {
        if !value.expr.mentions_next() {
            return Some(());
        }
        self.error(
            codes::PAST,
            span,
            "the operand of a past operator refers to the next step, perhaps through a define",
            "refer to the current step only: the past operator then has the same value one step later",
        );
        None
    }
}
