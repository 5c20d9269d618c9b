//! Assumptions and guarantees, and the formulas of monitors.
//!
//! | | guarantee | assumption |
//! |---|---|---|
//! | `ini`, or nothing | initial | initial, over inputs |
//! | `G` | from each step to the next | likewise, over next values of inputs |
//! | `alw` | in every step; with `next`, as `G` | in every step where it is about inputs and their past; else as `G` |
//! | `GF` | again and again | again and again |
//!
//! `asm alw` over the machine's variables is judged when the environment has made its next move, as
//! Spectra's tool does: it could not be blamed for what the machine answers.

use super::parser::one_line;
use super::reader::Reader;
use super::scope::Symbol;
use super::syntax::{Body, Clause, Monitor, Name, Node, Shape, Statement, TemporalForm};
use super::value::Value;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::monitors::{Kind, Obligation, Origin};
use linewright_core::gr1::{Expr, Owner, Time, VarId};
use linewright_core::source::Span;

/// Maximum number of instances of a parametrised assumption or guarantee.
const MAX_INSTANCES: usize = 1 << 12;

impl Reader {
    /// Adds an assumption or guarantee. `number` counts those of its side.
    pub fn statement(&mut self, statement: &Statement, text: &str, number: usize) {
        let name = match (&statement.name, statement.side) {
            (Some(name), _) => name.text.clone(),
            (None, Owner::Environment) => format!("assumption {number}"),
            (None, Owner::System) => format!("guarantee {number}"),
        };
        let mut instances = vec![(name, Vec::new())];
        for parameter in &statement.parameters {
            let Some(values) = self.values(&parameter.of) else {
                return;
            };
            let Some((domain, _)) = self.domain(&parameter.of) else {
                return;
            };
            if instances.len() * values.len() > MAX_INSTANCES {
                self.error(
                    codes::TOO_LARGE,
                    parameter.name.span,
                    format!("this would be more than {MAX_INSTANCES} formulas"),
                    "use smaller types for the parameters",
                );
                return;
            }
            let mut next = Vec::new();
            for (name, bound) in &instances {
                for value in &values {
                    let shown = value.constant().map(|v| domain.show(v)).unwrap_or_default();
                    let mut bound = bound.clone();
                    bound.push((parameter.name.text.clone(), value.clone()));
                    next.push((format!("{name}{{{shown}}}"), bound));
                }
            }
            instances = next;
        }
        let line = one_line(text_of(text, statement.span));
        for (name, bound) in instances {
            self.begin(name, statement.span, line.clone());
            let count = bound.len();
            let frame = self.frames.last_mut();
            if let Some(frame) = frame {
                let bound = bound.into_iter();
                frame.extend(bound.map(|(n, v)| (n, super::reader::Binding::Value(v))));
            }
            let _ = self.body(statement);
            if let Some(frame) = self.frames.last_mut() {
                frame.truncate(frame.len() - count);
            }
        }
    }

    /// What is added from here on belongs to a formula of the file.
    fn begin(&mut self, name: String, span: Span, text: String) {
        self.mentions.clear();
        self.origin = Origin {
            name,
            requirement: None,
            span,
            text,
        };
    }

    fn body(&mut self, statement: &Statement) -> Option<()> {
        let side = statement.side;
        match &statement.body {
            // They make it GR(1)* (Amram, Maoz, Pistiner: GR(1)*: GR(1) Specifications Extended
            // with Existential Guarantees, FM 2019).
            Body::Existential(span) => {
                self.error(
                    codes::NOT_GR1,
                    *span,
                    "an existential guarantee asks that something can happen, which is a property of the machine's tree of runs and not of each run",
                    "GR(1) describes runs: say what has to happen, with `GF` or a trigger, or leave it out",
                );
                None
            }
            Body::Trigger(from, to) => self.trigger(side, from, to, statement.span),
            Body::Clause(clause) => self.lowered(side, clause, &clause.node),
        }
    }

    /// A formula, a pattern or a regular expression, also below `forall`. A pattern says itself
    /// when it has to hold: `G` before it adds nothing.
    fn lowered(&mut self, side: Owner, clause: &Clause, node: &Node) -> Option<()> {
        let plain = !clause.explicit
            || matches!(clause.when, TemporalForm::Transition | TemporalForm::Always);
        match &node.shape {
            Shape::Call(name, arguments) if plain && self.is_pattern(name) => {
                self.pattern(side, name, arguments, node.span)
            }
            Shape::Name(name, indices) if plain && indices.is_empty() => {
                let name = Name {
                    text: name.clone(),
                    span: node.span,
                };
                if self.bound(&name.text).is_none() && self.is_pattern(&name) {
                    return self.pattern(side, &name, &[], node.span);
                }
                let value = self.truth(node)?;
                self.add(side, clause.when, value);
                Some(())
            }
            Shape::Matches(regexp) => self.matched(side, clause.when, regexp, node.span),
            Shape::Quantified {
                all: true,
                name,
                domain,
                body,
            } if self.holds_all(body) => {
                for value in self.values(domain)? {
                    self.with(&name.text, value, |reader| {
                        reader.lowered(side, clause, body)
                    });
                }
                Some(())
            }
            _ => {
                let value = self.truth(node)?;
                self.add(side, clause.when, value);
                Some(())
            }
        }
    }

    /// Whether something below `forall` is no formula.
    fn holds_all(&self, node: &Node) -> bool {
        match &node.shape {
            Shape::Call(name, _) => self.is_pattern(name),
            Shape::Matches(_) => true,
            Shape::Quantified {
                all: true, body, ..
            } => self.holds_all(body),
            _ => false,
        }
    }

    /// Adds what a monitor says.
    pub fn monitor(&mut self, monitor: &Monitor, text: &str) {
        for clause in &monitor.clauses {
            let line = one_line(text_of(text, clause.span));
            self.begin(monitor.variable.name.text.clone(), clause.span, line);
            if clause.when == TemporalForm::Repeatedly {
                self.error(
                    codes::NOT_GR1,
                    clause.span,
                    "a monitor only watches: it cannot ask that something happens again and again",
                    "say it in a guarantee: `gar GF ...`",
                );
                continue;
            }
            if let Some(value) = self.truth(&clause.node) {
                self.add(Owner::System, clause.when, value);
            }
        }
    }

    /// Adds what a counter says.
    pub fn counted_by(&mut self, counter: &super::syntax::Counter, text: &str) {
        let span = counter.name.span;
        let Some((Symbol::Variable(cells), _)) = self.symbol(&counter.name.text, span).cloned()
        else {
            return;
        };
        let line = one_line(text_of(text, span));
        self.begin(counter.name.text.clone(), span, line);
        self.counter(counter, &cells);
    }

    /// Adds a formula to the list that it belongs to.
    pub fn add(&mut self, side: Owner, when: TemporalForm, value: Value) {
        let Value { mut expr, size, .. } = value;
        let next = expr.mentions_next();
        if when == TemporalForm::Initially && next {
            expr = self.first_transition(expr);
        }
        let kind = match when {
            TemporalForm::Initially if !next => Kind::Initial,
            TemporalForm::Always if !next => Kind::Invariant,
            TemporalForm::Initially | TemporalForm::Transition | TemporalForm::Always => {
                Kind::Safety
            }
            TemporalForm::Repeatedly => Kind::Justice,
        };
        let obligations = if side == Owner::System {
            vec![Obligation { kind, expr }]
        } else {
            if kind == Kind::Initial
                && self.speaks_of_outputs(&expr, None).is_some()
                && let Some(left) = self.left_to_environment(&expr)
            {
                expr = left;
            }
            // Who watches the machine's variables waits for its answer.
            let kind = if kind == Kind::Invariant && self.speaks_of_outputs(&expr, None).is_some() {
                Kind::Safety
            } else {
                kind
            };
            if self.monitors.occur_in(&expr) {
                self.monitors.assumed(&Obligation { kind, expr })
            } else {
                vec![Obligation { kind, expr }]
            }
        };
        for obligation in obligations {
            if side == Owner::Environment && !self.may_be_assumed(&obligation) {
                return;
            }
            let span = self.origin.span;
            if self.finished(&obligation.expr, size, span).is_none() {
                return;
            }
            let lists = match side {
                Owner::System => &mut self.specification.guarantees,
                Owner::Environment => &mut self.specification.assumptions,
            };
            obligation.add_to(lists, &self.origin);
        }
    }

    /// Whether an assumption constrains only what the environment chooses; reports it otherwise.
    fn may_be_assumed(&mut self, obligation: &Obligation) -> bool {
        let when = match obligation.kind {
            Kind::Initial => None,
            Kind::Safety => Some(Time::Next),
            Kind::Invariant | Kind::Justice => return true,
        };
        let Some(v) = self.speaks_of_outputs(&obligation.expr, when) else {
            return true;
        };
        let name = self.variable(v).name.clone();
        let span = self.first_mention(|w| w == v);
        if when.is_none() {
            self.error(
                codes::NOT_CONTROLLED,
                span,
                format!("this assumption constrains `{name}`, which the system chooses"),
                "the environment chooses first: its initial condition refers to its own variables only",
            );
        } else {
            self.error(
                codes::NEXT_OUTPUT_ASSUMED,
                span,
                format!("this assumption refers to the next value of `{name}`, which the system chooses after the environment has moved"),
                format!("the environment cannot keep such a promise: refer to `{name}` without `next`, a step later"),
            );
        }
        false
    }

    /// A variable of the machine, no monitor, that an expression mentions at a time.
    fn speaks_of_outputs(&self, expr: &Expr, at: Option<Time>) -> Option<VarId> {
        let mut found = None;
        expr.for_each_var(&mut |v, time| {
            let output = match self.monitors.get(v) {
                Some(_) => time == Time::Next,
                None => self.variable(v).owner == Owner::System,
            };
            if output && at.is_none_or(|t| t == time) && found.is_none() {
                found = Some(v);
            }
        });
        found
    }

    /// Where the statement at hand mentions a variable.
    fn first_mention(&self, of: impl Fn(VarId) -> bool) -> Span {
        let around = self.origin.span;
        let mut found = self.mentions.iter().filter(|(v, _)| of(*v));
        let inside = found.clone().find(|(_, span)| around.holds(*span));
        inside.or(found.next()).map_or(around, |(_, span)| *span)
    }
}

/// The text of a place.
pub(super) fn text_of(text: &str, span: Span) -> &str {
    text.get(span.start as usize..span.end as usize)
        .unwrap_or_default()
}
