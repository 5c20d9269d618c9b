//! Lowers assumptions and guarantees, and the formulas of monitors.
//!
//! | | guarantee | assumption |
//! |---|---|---|
//! | `ini`, or none | initial | initial, over inputs |
//! | `G` | each transition | each transition, over next values of inputs |
//! | `alw` | every step; with `next`, as `G` | every step if it refers only to inputs and their past; otherwise as `G` |
//! | `GF` | infinitely often | infinitely often |
//!
//! As in Spectra's tool, `asm alw` over the system's variables is evaluated after the environment's
//! next move, because the environment cannot influence the system's answer.

use super::parser::one_line;
use super::reader::Reader;
use super::scope::Symbol;
use super::syntax::{Body, Clause, Monitor, Name, Node, Shape, Statement, TemporalForm};
use super::value::Value;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::monitors::{Obligation, Origin};
use linewright_core::gr1::{Expr, FormulaKind, Owner, Time, VarId};
use linewright_core::source::Span;

/// Maximum number of instances of a parametrised assumption or guarantee.
const MAX_INSTANCES: usize = 1 << 12;

impl Reader {
    /// Adds an assumption or guarantee; `number` is its position among those of its side, from 1.
    pub fn statement(&mut self, statement: &Statement, text: &str, number: usize) {
        let name = match (&statement.name, statement.side) {
            (Some(name), _) => name.text.clone(),
            (None, Owner::Environment) => format!("assumption {number}"),
            (None, Owner::System) => format!("guarantee {number}"),
        };
        let mut instances = vec![(self.unique(name), Vec::new())];
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
                    format!("this statement expands to more than {MAX_INSTANCES} formulas"),
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
            self.set_origin(name, statement.span, line.clone());
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

    /// A unique name for a statement; a repeated name gets a number, so that findings refer to one
    /// statement.
    fn unique(&mut self, name: String) -> String {
        let names = (2..).map(|number| format!("{name}_{number}"));
        let mut names = std::iter::once(name.clone()).chain(names);
        let unused = names.find(|n| !self.statement_names.contains(n));
        let unique = unused.unwrap_or(name);
        self.statement_names.insert(unique.clone());
        unique
    }

    /// Sets the origin of the formulas that are added next.
    fn set_origin(&mut self, name: String, span: Span, text: String) {
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
            // GR(1)* has existential guarantees (Amram, Maoz, Pistiner: GR(1)*: GR(1)
            // Specifications Extended with Existential Guarantees, FM 2019).
            Body::Existential(span) => {
                self.error(
                    codes::NOT_GR1,
                    *span,
                    "an existential guarantee is outside GR(1): it requires that something can happen, which is not a property of single runs",
                    "state what has to happen in every run, with `GF` or a trigger, or remove the guarantee",
                );
                None
            }
            Body::Trigger(from, to) => self.trigger(side, from, to, statement.span),
            Body::Clause(clause) => self.clause(side, clause, &clause.node),
        }
    }

    /// Lowers a formula, a pattern or a regular expression, also under `forall`. A pattern itself
    /// determines when it has to hold, so `G` before it has no effect.
    fn clause(&mut self, side: Owner, clause: &Clause, node: &Node) -> Option<()> {
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
            Shape::Matches(regexp) => self.regexp_clause(side, clause.when, regexp, node.span),
            Shape::Quantified {
                all: true,
                name,
                domain,
                body,
            } if self.is_pattern_or_regexp(body) => {
                for value in self.values(domain)? {
                    self.with(&name.text, value, |reader| {
                        reader.clause(side, clause, body)
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

    /// Whether the body of `forall` is a pattern or a regular expression.
    fn is_pattern_or_regexp(&self, node: &Node) -> bool {
        match &node.shape {
            Shape::Call(name, _) => self.is_pattern(name),
            Shape::Matches(_) => true,
            Shape::Quantified {
                all: true, body, ..
            } => self.is_pattern_or_regexp(body),
            _ => false,
        }
    }

    /// Adds the formulas of a monitor.
    pub fn monitor(&mut self, monitor: &Monitor, text: &str) {
        let before = self.counts();
        for clause in &monitor.clauses {
            let line = one_line(text_of(text, clause.span));
            self.set_origin(monitor.variable.name.text.clone(), clause.span, line);
            if clause.when == TemporalForm::Repeatedly {
                self.error(
                    codes::NOT_GR1,
                    clause.span,
                    "a monitor cannot require that something happens again and again",
                    "write a guarantee: `gar GF ...`",
                );
                continue;
            }
            if let Some(value) = self.truth(&clause.node) {
                self.add(Owner::System, clause.when, value);
            }
        }
        let variable = &monitor.variable.name;
        if let Some((Symbol::Variable(cells), _)) = self.symbol(&variable.text, variable.span) {
            let cells = cells.ids();
            self.record_group(cells, before);
        }
    }

    /// Adds the formulas of a counter.
    pub fn counter_formulas(&mut self, counter: &super::syntax::Counter, text: &str) {
        let span = counter.name.span;
        let Some((Symbol::Variable(cells), _)) = self.symbol(&counter.name.text, span).cloned()
        else {
            return;
        };
        let line = one_line(text_of(text, span));
        // The formulas are located at the counter's range, because an internal variable that is
        // declared within the span of a formula counts as generated.
        let range = counter.low.span.to(counter.high.span);
        self.set_origin(counter.name.text.clone(), range, line);
        let before = self.counts();
        self.counter(counter, &cells);
        self.record_group(cells.ids(), before);
    }

    /// Adds a formula to the list for its side and its temporal form.
    pub fn add(&mut self, side: Owner, when: TemporalForm, value: Value) {
        let Value { mut expr, size, .. } = value;
        let next = expr.mentions_next();
        if when == TemporalForm::Initially && next {
            expr = self.first_transition(expr);
        }
        let kind = match when {
            TemporalForm::Initially if !next => FormulaKind::Initial,
            TemporalForm::Always if !next => FormulaKind::Invariant,
            TemporalForm::Initially | TemporalForm::Transition | TemporalForm::Always => {
                FormulaKind::Safety
            }
            TemporalForm::Repeatedly => FormulaKind::Justice,
        };
        if kind == FormulaKind::Justice && next && side == Owner::System {
            self.note(
                codes::OWN_TOOL,
                self.origin.span,
                "Spectra refuses next values in `GF`; here a transition can satisfy the formula",
                "store the transition in a variable if both tools should read the file",
            );
        }
        let obligations = if side == Owner::System {
            vec![Obligation { kind, expr }]
        } else {
            if kind == FormulaKind::Initial
                && self.mentioned_output(&expr, None).is_some()
                && let Some(left) = self.without_outputs(&expr)
            {
                expr = left;
            }
            // If an assumption refers to the system's variables, it is evaluated after the system's
            // answer.
            let kind =
                if kind == FormulaKind::Invariant && self.mentioned_output(&expr, None).is_some() {
                    FormulaKind::Safety
                } else {
                    kind
                };
            if self.monitors.occur_in(&expr) {
                self.monitors.as_assumptions(&Obligation { kind, expr })
            } else {
                vec![Obligation { kind, expr }]
            }
        };
        for obligation in obligations {
            if side == Owner::Environment && !self.can_be_assumed(&obligation) {
                return;
            }
            let span = self.origin.span;
            if self.check_finished(&obligation.expr, size, span).is_none() {
                return;
            }
            let lists = match side {
                Owner::System => &mut self.specification.guarantees,
                Owner::Environment => &mut self.specification.assumptions,
            };
            obligation.add_to(lists, &self.origin);
        }
    }

    /// Whether an assumption constrains only values that the environment chooses. Reports an
    /// assumption that does not.
    fn can_be_assumed(&mut self, obligation: &Obligation) -> bool {
        let when = match obligation.kind {
            FormulaKind::Initial => None,
            FormulaKind::Safety => Some(Time::Next),
            FormulaKind::Invariant | FormulaKind::Justice => return true,
        };
        let Some(v) = self.mentioned_output(&obligation.expr, when) else {
            return true;
        };
        let name = self.variable(v).name.clone();
        let span = self.first_mention(|w| w == v);
        if when.is_none() {
            self.error(
                codes::NOT_CONTROLLED,
                span,
                format!("this assumption constrains `{name}`, which the system chooses"),
                "the environment chooses first: refer only to its own variables in its initial condition",
            );
        } else {
            self.error(
                codes::NEXT_OUTPUT_ASSUMED,
                span,
                format!("this assumption refers to the next value of `{name}`, which the system chooses after the environment has moved"),
                format!("the environment cannot keep such an assumption: refer to `{name}` without `next`, one step later"),
            );
        }
        false
    }

    /// A variable of the system that `expr` mentions at the time `at`, or at any time if `at` is
    /// `None`.
    ///
    /// Monitors of past formulas count only with their next values.
    fn mentioned_output(&self, expr: &Expr, at: Option<Time>) -> Option<VarId> {
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

    /// The first location at which the current statement mentions one of the variables.
    fn first_mention(&self, of: impl Fn(VarId) -> bool) -> Span {
        let around = self.origin.span;
        let mut found = self.mentions.iter().filter(|(v, _)| of(*v));
        let inside = found.clone().find(|(_, span)| around.contains(*span));
        inside.or(found.next()).map_or(around, |(_, span)| *span)
    }
}

/// The text at a location; empty if it is out of range.
pub(super) fn text_of(text: &str, span: Span) -> &str {
    text.get(span.start as usize..span.end as usize)
        .unwrap_or_default()
}
