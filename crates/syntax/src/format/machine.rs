//! Prints machines.

use super::super::ast::{
    Between, Binding, Column, Component, Expr, Failures, InterruptedWork, Machine, MachineItem,
    Name, Outcome, Role, TimeValue, TypedDecl,
};
use super::printer::Printer;
use linewright_core::source::Span;

/// An item of a component. Items are printed in source order.
enum Part<'c> {
    Time(&'c Expr, bool),
    Power(&'c Expr),
    Binding(&'c Binding),
}

impl Printer<'_> {
    pub(super) fn machine(&mut self, place: Span, m: &Machine) {
        self.doc(&m.header.doc);
        self.put("machine ");
        self.header(&m.header);
        self.block(place, &m.items, false, Self::machine_item);
    }

    fn machine_item(&mut self, place: Span, item: &MachineItem) {
        match item {
            MachineItem::Step(e) => self.setting("step ", e),
            MachineItem::IdlePower(e) => self.setting("idle power ", e),
            MachineItem::Power(e) => self.setting("power ", e),
            MachineItem::Limit(e) => {
                self.setting("limit ", e);
                self.put(" steps");
            }
            MachineItem::Failures(f) => self.failures(f),
            MachineItem::Property(t) => self.typed("property ", t),
            MachineItem::Parameter(t) => self.typed("parameter ", t),
            MachineItem::Signal(t) => self.typed("signal ", t),
            MachineItem::Abstract(t) => self.typed("abstract ", t),
            MachineItem::Component(c) => self.component(place, c),
            MachineItem::Operation {
                name,
                codes,
                sequence,
            } => {
                self.put("operation ");
                self.name(name);
                self.codes(codes);
                if !sequence.is_empty() {
                    self.put(": ");
                    self.list(sequence, |p| p.name.span, Self::performed);
                }
            }
            MachineItem::Done(e) => self.setting("done ", e),
            MachineItem::Write { name, index, value } => {
                self.put("write ");
                self.name(name);
                let mut before = name.span;
                if let Some(index) = index {
                    self.put("[");
                    self.expression(index);
                    self.put("]");
                    before = index.span;
                }
                self.value(before, value);
            }
            MachineItem::Skills(s) => self.skill_calls(place, s),
            MachineItem::Refines(c) => {
                self.put("refines ");
                self.name(&c.contract);
                self.arguments(c.contract.span, &c.arguments);
                if !c.bindings.is_empty() {
                    self.block(place, &c.bindings, true, |p, _, b| p.binding(b));
                }
            }
            MachineItem::Guarantee {
                name,
                requirement,
                expr,
            } => {
                self.put("guarantee ");
                self.label(name.as_ref(), requirement.as_deref());
                self.expression(expr);
            }
            MachineItem::Const(c) => self.const_decl(c),
            MachineItem::Type(t) => self.type_decl(t),
        }
    }

    pub(super) fn setting(&mut self, word: &str, e: &Expr) {
        self.put(word);
        self.expression(e);
    }

    pub(super) fn failures(&mut self, failures: &Failures) {
        self.put("failures ");
        if let Some(name) = &failures.name {
            self.name(name);
            self.put(": ");
        }
        match &failures.between {
            Between::Time(time) => {
                self.put("mtbf ");
                self.duration(time);
            }
            Between::Parts(1) => self.put("every 1 part"),
            Between::Parts(count) => self.put(&format!("every {count} parts")),
            Between::DrawnParts(count) => {
                self.put("every ");
                self.duration(count);
                self.put(" parts");
            }
        }
        self.put(" mttr ");
        self.duration(&failures.mttr);
        self.put(if failures.calendar {
            " by calendar"
        } else {
            ""
        });
        self.put(match failures.interrupted {
            InterruptedWork::Resumes => "",
            InterruptedWork::Restarts => " restart",
            InterruptedWork::ScrapsPart => " scrap",
        });
    }

    pub(super) fn duration(&mut self, duration: &TimeValue) {
        match duration {
            TimeValue::Value(value) => self.expression(value),
            TimeValue::Drawn { name, outcomes, .. } => {
                self.name(name);
                self.put("(");
                self.list(outcomes, |o| o.value.span, Self::outcome);
                self.put(")");
            }
            TimeValue::Empirical { column, .. } => {
                self.put("empirical(");
                self.column(column);
                self.put(")");
            }
        }
    }

    pub(super) fn column(&mut self, column: &Column) {
        self.quoted(&column.path);
        self.put(" column ");
        if column.quoted {
            self.quoted(&column.header);
        } else {
            self.name(&column.header);
        }
        self.put(" in ");
        self.name(&column.unit);
    }

    /// Prints a text in quotes.
    fn quoted(&mut self, text: &Name) {
        self.before(text.span);
        self.put(&format!("\"{}\"", text.text));
    }

    fn outcome(&mut self, outcome: &Outcome) {
        self.expression(&outcome.value);
        if let Some(weight) = &outcome.weight {
            self.setting(": ", weight);
        }
    }

    pub(super) fn typed(&mut self, word: &str, t: &TypedDecl) {
        self.doc(&t.doc);
        self.put(word);
        self.name(&t.name);
        self.put(": ");
        self.domain(&t.domain);
        let mut before = t.domain.span;
        for (i, value) in t.values.iter().enumerate() {
            if i == 0 {
                self.value(before, value);
            } else {
                self.put(",");
                self.nest = 1;
                let forced = self.broken(before, value.span);
                self.gap(0, true, forced);
                self.expression(value);
                self.nest = 0;
            }
            before = value.span;
        }
    }

    fn component(&mut self, place: Span, c: &Component) {
        self.put(match c.role {
            Role::Coordinator => "coordinator ",
            Role::Action => "action ",
            Role::Machine => "machine ",
        });
        self.name(&c.name);
        self.put(": ");
        self.name(&c.contract);
        self.arguments(c.contract.span, &c.arguments);
        if let Some(when) = &c.when {
            let before = c.arguments.last().map_or(c.contract.span, |a| a.value.span);
            self.clause("when ", before, when);
        }
        let mut parts: Vec<(u32, Part<'_>)> = Vec::new();
        parts.extend(
            c.bindings
                .iter()
                .map(|b| (b.name.span.start, Part::Binding(b))),
        );
        if let Some((time, per_step)) = &c.time {
            parts.push((time.span.start, Part::Time(time, *per_step)));
        }
        if let Some(power) = &c.power {
            parts.push((power.span.start, Part::Power(power)));
        }
        parts.sort_by_key(|(start, _)| *start);
        if parts.is_empty() {
            return;
        }
        self.block(place, &parts, true, |p, _, (_, part)| match part {
            Part::Time(e, per_step) => {
                p.setting("time ", e);
                p.put(if *per_step { " per step" } else { "" });
            }
            Part::Power(e) => p.setting("power ", e),
            Part::Binding(b) => p.binding(b),
        });
    }

    fn binding(&mut self, b: &Binding) {
        self.name(&b.name);
        if let Some(index) = b.index {
            self.put(&format!("[{index}]"));
        }
        if let Some(member) = &b.member {
            self.put(".");
            self.name(member);
        }
        self.value(b.member.as_ref().map_or(b.name.span, |m| m.span), &b.value);
    }
}
