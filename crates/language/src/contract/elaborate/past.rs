//! Conversion of past operators and counters to expressions over monitors.

use super::Elaborator;
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::monitors::{Monitors, Origin};
use linewright_core::gr1::{Domain, Expr, Time};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, PastOp};

/// Maximum number of steps to look back. A monitor needs one value for each step.
const MAX_STEPS: i64 = 1 << 16;

impl<'a> Elaborator<'a> {
    /// Elaborates `previous p`, `once p`, `historically p`, with or without a bound.
    pub(super) fn past(
        &mut self,
        span: Span,
        op: PastOp,
        body: &'a ast::Expr,
        bound: Option<&'a ast::Expr>,
        time: Time,
    ) -> Option<Value> {
        let operand = self.state(body, op.word())?;
        let steps = match bound {
            Some(bound) => Some(self.steps(bound)?),
            None => None,
        };
        if let (PastOp::Previous, Some(bound)) = (op, bound) {
            self.findings.error_with(
                codes::TYPE_MISMATCH,
                bound.span,
                "`previous` looks back exactly one step, and takes no bound",
                "write `once P within n steps`, or `historically P within n steps`",
            );
            return None;
        }
        self.look_back(span, time, |monitors, origin| match (op, steps) {
            (PastOp::Previous, _) => monitors.previous(&operand, origin),
            (PastOp::Once, None) => monitors.once(&operand, origin),
            (PastOp::Once, Some(n)) => monitors.once_within(&operand, n, origin),
            (PastOp::Historically, None) => monitors.historically(&operand, origin),
            (PastOp::Historically, Some(n)) => monitors.historically_within(&operand, n, origin),
        })
    }

    /// Elaborates `p since q`.
    pub(super) fn since(
        &mut self,
        span: Span,
        p: &'a ast::Expr,
        q: &'a ast::Expr,
        time: Time,
    ) -> Option<Value> {
        let (p, q) = (self.state(p, "since"), self.state(q, "since"));
        let (p, q) = (p?, q?);
        self.look_back(span, time, |monitors, origin| {
            monitors.since(&p, &q, origin)
        })
    }

    /// Returns the value of a declared counter.
    pub(super) fn counter(&mut self, counter: &'a ast::Counter, time: Time) -> Option<Value> {
        let name = &counter.name;
        let (domain, length) = self.domain(&counter.domain)?;
        let high = match (&domain, length) {
            (Domain::Range { low: 0, high }, None) if (1..=MAX_STEPS).contains(high) => *high,
            _ => {
                self.findings.error_with(
                    codes::DOMAIN_EMPTY,
                    counter.domain.span,
                    format!(
                        "the domain of a counter has to be `0..n`, where n is from 1 to {MAX_STEPS}"
                    ),
                    "write a range such as `0..20`; the counter stops at its end",
                );
                return None;
            }
        };
        let counts = self.state(&counter.counts, "counter");
        let resets = match &counter.resets {
            Some(resets) => self.state(resets, "counter"),
            None => Some(Expr::FALSE),
        };
        let (counts, resets) = (counts?, resets?);
        let text = name.text.clone();
        let value = self.look_back(name.span, time, |monitors, origin| {
            let value = monitors.counter(&counts, &resets, high as u32, origin);
            monitors.rename(&value, &text);
            value
        })?;
        Some(match value {
            Value::Scalar(term, _) => Value::Scalar(term, Type::Int),
            other => other,
        })
    }

    /// Elaborates an operand of `word`, an operator that looks at other steps. The operand has to
    /// be a condition on one step.
    pub(in crate::contract) fn state(&mut self, e: &'a ast::Expr, word: &str) -> Option<Expr> {
        let allowed = std::mem::replace(&mut self.dialect.next, false);
        let enclosing = self.dialect.looking_back.replace(word.to_owned());
        let term = self.boolean(e, Time::Now);
        self.dialect.next = allowed;
        self.dialect.looking_back = enclosing;
        let term = term?;
        self.formula(&term, e.span)
    }

    /// Evaluates a bound in steps. Reports a bound that is out of range.
    pub(in crate::contract) fn steps(&mut self, bound: &'a ast::Expr) -> Option<u32> {
        let steps = self.constant_int(bound)?;
        if (1..=MAX_STEPS).contains(&steps) {
            return Some(steps as u32);
        }
        self.findings.error_with(
            codes::NUMBER_RANGE,
            bound.span,
            format!("a bound has to be a number of steps from 1 to {MAX_STEPS}"),
            "write, for example, `within 5 steps`",
        );
        None
    }

    /// Creates a monitor with `make`, and returns its output in the current or the next step.
    /// Reports an error if monitors are not available.
    fn look_back(
        &mut self,
        span: Span,
        time: Time,
        make: impl FnOnce(&mut Monitors, &Origin) -> Expr,
    ) -> Option<Value> {
        let Some(monitors) = &mut self.memory.monitors else {
            self.findings.error_with(
                codes::PAST,
                span,
                "past operators, patterns and counters are not allowed here",
                "use them in a contract, and read an output of that contract here",
            );
            return None;
        };
        let origin = Origin {
            span,
            ..self.memory.origin.clone()
        };
        let now = make(monitors, &origin);
        let value = match time {
            Time::Now => now,
            Time::Next => monitors.one_step_later(&now),
        };
        self.variables.add_monitors(monitors);
        let term = Term::from_expr(&value);
        self.expansion
            .spend(span, term.size(), &mut self.findings)?;
        Some(Value::Scalar(term, Type::Bool))
    }
}
