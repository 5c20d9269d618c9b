//! Builds machines: properties, components and operations.

use super::super::ast::{Binding, Component, Machine, MachineItem, OperationCall, Role, TypedDecl};
use super::super::parser::Rule;
use super::{Builder, Children};
use linewright_core::diagnostics::{Diagnostic, codes};
use pest::iterators::Pair;

impl Builder {
    pub(super) fn machine(&mut self, pair: Pair<'_, Rule>) -> Machine {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let header = self.header(doc, &mut c);
        let mut items = Vec::new();
        for item in c.rest() {
            self.place(&item);
            let rule = item.as_rule();
            if rule == Rule::bad_machine_item {
                self.bad(&item);
            } else {
                items.push(self.machine_item(rule, item));
            }
        }
        Machine { header, items }
    }

    pub(super) fn machine_item(&mut self, rule: Rule, item: Pair<'_, Rule>) -> MachineItem {
        match rule {
            Rule::m_component => return MachineItem::Component(self.component(item)),
            Rule::m_refines => return MachineItem::Refines(self.refines(item)),
            Rule::m_skills => return MachineItem::Skills(self.skill_calls(item)),
            Rule::m_property => return MachineItem::Property(self.typed(item)),
            Rule::m_parameter => return MachineItem::Parameter(self.typed(item)),
            Rule::m_signal => return MachineItem::Signal(self.typed(item)),
            Rule::m_abstract => return MachineItem::Abstract(self.typed(item)),
            Rule::const_decl => return MachineItem::Const(self.const_decl(item)),
            Rule::type_decl => return MachineItem::Type(self.type_decl(item)),
            _ => {}
        }
        let span = self.span(&item);
        let mut c = Children::of(item);
        match rule {
            Rule::m_step => MachineItem::Step(self.expr(c.next())),
            Rule::m_idle => MachineItem::IdlePower(self.expr(c.next())),
            Rule::m_power => MachineItem::Power(self.expr(c.next())),
            Rule::m_limit => MachineItem::Limit(self.expr(c.next())),
            Rule::m_failures => MachineItem::Failures(self.failures(c, span)),
            Rule::m_operation => {
                Self::doc(&mut c);
                let name = self.name(&c.next());
                let codes = self.codes(c.take(Rule::implements));
                let performed: Vec<_> = c.rest().collect();
                let sequence = performed.into_iter().map(|p| self.performed(p)).collect();
                MachineItem::Operation {
                    name,
                    codes,
                    sequence,
                }
            }
            Rule::m_guarantee => {
                Self::doc(&mut c);
                let (name, requirement) = self.label(&mut c);
                MachineItem::Guarantee {
                    name,
                    requirement,
                    expr: self.expr(c.next()),
                }
            }
            Rule::m_write => {
                let name = self.name(&c.next());
                let index = c
                    .take(Rule::index)
                    .map(|i| self.expr(Children::of(i).next()));
                MachineItem::Write {
                    name,
                    index,
                    value: self.expr(c.next()),
                }
            }
            _ => MachineItem::Done(self.expr(c.next())),
        }
    }

    pub(super) fn typed(&mut self, pair: Pair<'_, Rule>) -> TypedDecl {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let domain = self.domain(c.next());
        let values: Vec<_> = c.rest().collect();
        TypedDecl {
            doc,
            name,
            domain,
            values: values.into_iter().map(|v| self.expr(v)).collect(),
        }
    }

    /// Builds a call of an action or operation, with its arguments.
    pub(super) fn performed(&mut self, pair: Pair<'_, Rule>) -> OperationCall {
        let mut c = Children::of(pair);
        let name = self.name(&c.next());
        let arguments = c.take(Rule::arguments);
        OperationCall {
            name,
            arguments: self.arguments(arguments),
        }
    }

    /// Reports a second `word` in a component. `given` is whether the component already has one.
    fn report_second(&mut self, given: bool, word: &str, item: &Pair<'_, Rule>) {
        if given {
            let message = format!("`{word}` appears twice");
            self.findings.push(
                Diagnostic::error(codes::NAME_DUPLICATE, self.span(item), message)
                    .with_help("remove one of them"),
            );
        }
    }

    /// Builds `refines Contract { ... }`, with the bindings of the contract's variables.
    fn refines(&mut self, pair: Pair<'_, Rule>) -> Component {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let contract = self.name(&c.next());
        let arguments = c.take(Rule::arguments);
        let mut refines = Component {
            role: Role::Action,
            name: contract.clone(),
            contract,
            arguments: self.arguments(arguments),
            when: None,
            time: None,
            power: None,
            bindings: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            if item.as_rule() == Rule::c_binding {
                let binding = self.binding(item);
                refines.bindings.push(binding);
            } else {
                refines.broken = true;
                self.bad(&item);
            }
        }
        refines
    }

    /// Builds `h[0].x = e`.
    fn binding(&mut self, item: Pair<'_, Rule>) -> Binding {
        let mut c = Children::of(item);
        let name = self.name(&c.next());
        // If the index is too large, which was reported, use 0, because every array has this
        // element.
        let index = c.take(Rule::integer).map(|i| self.integer(&i).unwrap_or(0));
        let member = c.take(Rule::path).map(|p| self.name(&p));
        Binding {
            name,
            index,
            member,
            value: self.expr(c.next()),
        }
    }

    pub(super) fn component(&mut self, pair: Pair<'_, Rule>) -> Component {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let role = match c.next().as_str().trim() {
            "coordinator" => Role::Coordinator,
            "machine" => Role::Machine,
            _ => Role::Action,
        };
        let name = self.name(&c.next());
        let contract = self.name(&c.next());
        let arguments = c.take(Rule::arguments);
        let arguments = self.arguments(arguments);
        let when = c.take(Rule::expression).map(|e| self.expr(e));
        let mut component = Component {
            role,
            name,
            contract,
            arguments,
            when,
            time: None,
            power: None,
            bindings: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            match item.as_rule() {
                Rule::c_time => {
                    self.report_second(component.time.is_some(), "time", &item);
                    let mut c = Children::of(item);
                    let value = self.expr(c.next());
                    component.time = Some((value, c.take(Rule::per_step).is_some()));
                }
                Rule::c_power => {
                    self.report_second(component.power.is_some(), "power", &item);
                    component.power = Some(self.expr(Children::of(item).next()));
                }
                Rule::c_binding => {
                    let binding = self.binding(item);
                    component.bindings.push(binding);
                }
                _ => {
                    component.broken = true;
                    self.bad(&item);
                }
            }
        }
        component
    }
}
