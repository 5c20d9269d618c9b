//! Resolution of the resources that are written: their states and transitions, and the machines
//! that do their work.

use super::layout::{Builder, MAX_CAPACITY};
use super::transport::Ride;
use super::unknown;
use crate::contract::machines::non_negative;
use crate::contract::recipe::ResourceInfo;
use crate::contract::value::Dimension;
use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::Span;
use linewright_recipe::model::{Action, Resource, State, Transition};
use linewright_syntax::ast::{self, ActionKind, MachineItem, Name, ResourceItem};
use std::collections::{BTreeMap, BTreeSet};

impl<'a> Builder<'a, '_> {
    pub(super) fn resource(&mut self, decl: &'a ast::Resource) {
        let mut info = ResourceInfo {
            name: decl.name.span,
            kind: decl.kind.as_ref().map(|k| k.text.clone()),
            capacity: decl.capacity.map(|c| c.span),
            ..ResourceInfo::default()
        };
        let mut resource = Resource {
            name: decl.name.text.clone(),
            initial: decl.initial.text.clone(),
            capacity: self.capacity(decl.capacity, MAX_CAPACITY),
            ..Resource::default()
        };
        let mut states: BTreeMap<&str, usize> = BTreeMap::new();
        let mut add = |state: &'a Name| {
            states.entry(&state.text).or_insert_with(|| {
                resource.states.push(State {
                    name: state.text.clone(),
                    may_wait: false,
                });
                info.states.push(state.span);
                resource.states.len() - 1
            });
        };
        let mut has_transitions = false;
        for item in &decl.items {
            if let ResourceItem::Transition { from, to, .. } = item {
                add(from);
                add(to);
                has_transitions = true;
            }
        }
        if !has_transitions {
            add(&decl.initial);
        }
        if !states.contains_key(decl.initial.text.as_str()) {
            self.report_unknown_state(&decl.name, &decl.initial, &resource);
        }
        for item in &decl.items {
            match item {
                ResourceItem::Nop(names) => {
                    for name in names {
                        match states.get(name.text.as_str()) {
                            Some(at) => resource.states[*at].may_wait = true,
                            None => self.report_unknown_state(&decl.name, name, &resource),
                        }
                    }
                }
                ResourceItem::Transition { from, to, actions } => {
                    for action in actions {
                        info.transitions.push(action.span);
                        let ride = self.ride_of(action.time.as_ref(), action.power.as_ref());
                        resource.transitions.push(Transition {
                            from: from.text.clone(),
                            to: to.text.clone(),
                            action: model_action(&action.kind, &decl.name),
                            seconds: ride.seconds,
                            watts: ride.watts,
                        });
                    }
                }
            }
        }
        info.machine = self.machine(decl);
        self.starts
            .push((self.layout.resources.len(), resource.initial.clone()));
        self.layout.model.resources.push(resource);
        self.layout.resources.push(info);
    }

    pub(super) fn report_unknown_state(&mut self, resource: &Name, state: &Name, model: &Resource) {
        let finding = unknown(
            state,
            format!("`{}` has no state `{}`", resource.text, state.text),
            model.states.iter().map(|s| s.name.as_str()),
            "the states of its transitions are",
        );
        self.e.findings.push(finding);
    }

    pub(super) fn ride_of(
        &mut self,
        time: Option<&'a ast::Expr>,
        power: Option<&'a ast::Expr>,
    ) -> Ride {
        let e = &mut self.e;
        Ride {
            seconds: time.and_then(|t| non_negative(e, t, Dimension::Time)),
            watts: power.and_then(|p| non_negative(e, p, Dimension::Power)),
        }
    }

    /// Returns the place of the machine that is the type of a resource, if it is one. Reports
    /// operations of the resource that the machine does not have.
    fn machine(&mut self, decl: &'a ast::Resource) -> Option<Span> {
        let kind = decl.kind.as_ref();
        let machine = kind.and_then(|k| self.scope.machines.get(k.text.as_str()))?;
        let known = machine.items.iter().filter_map(|item| match item {
            MachineItem::Operation { name, .. } => Some(name.text.as_str()),
            _ => None,
        });
        for item in &decl.items {
            let ResourceItem::Transition { actions, .. } = item else {
                continue;
            };
            for action in actions {
                if let ActionKind::Operation(name) = &action.kind
                    && !known.clone().any(|k| k == name.text)
                {
                    let machine = &machine.header.name.text;
                    let finding = unknown(
                        name,
                        format!("the machine `{machine}` has no operation `{}`", name.text),
                        known.clone(),
                        "its operations are",
                    );
                    self.e.findings.push(finding);
                }
            }
        }
        Some(machine.header.name.span)
    }

    /// Warns of states that a resource never enters, because a name is often misspelled so.
    pub(super) fn report_unreached(&mut self, decl: &ast::Resource) {
        let Some(at) = self.layout.model.resource(&decl.name.text) else {
            return;
        };
        let resource = &self.layout.model.resources[at];
        let starts = self.starts.iter().filter(|(of, _)| *of == at);
        let mut open: Vec<&str> = starts.map(|(_, state)| state.as_str()).collect();
        if !open.iter().any(|s| resource.state(s).is_some()) {
            return;
        }
        let mut leaving: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for t in &resource.transitions {
            leaving.entry(&t.from).or_default().push(&t.to);
        }
        let mut reached: BTreeSet<&str> = BTreeSet::new();
        while let Some(state) = open.pop() {
            if reached.insert(state) {
                open.extend(leaving.get(state).into_iter().flatten());
            }
        }
        let mut found = Vec::new();
        for (state, span) in resource
            .states
            .iter()
            .zip(&self.layout.resources[at].states)
        {
            if reached.contains(state.name.as_str()) || *span == Span::default() {
                continue;
            }
            let help = "write a transition that enters it, or remove it";
            let near = nearest(&state.name, reached.iter().copied());
            found.push(
                Diagnostic::warning(
                    codes::LAYOUT_STUCK,
                    *span,
                    format!("`{}` never enters state `{}`", decl.name.text, state.name),
                )
                .with_help(match near {
                    Some(near) => format!("did you mean `{near}`? Otherwise {help}"),
                    None => help.to_owned(),
                }),
            );
        }
        self.e.findings.list.append(&mut found);
    }
}

fn model_action(kind: &ActionKind, resource: &Name) -> Action {
    let label = |label: &Option<Name>| label.as_ref().unwrap_or(resource).text.clone();
    match kind {
        ActionKind::Operation(name) => Action::Operation(name.text.clone()),
        ActionKind::Internal(name) => Action::Internal(name.text.clone()),
        ActionKind::In(name) => Action::In(label(name)),
        ActionKind::Out(name) => Action::Out(label(name)),
    }
}
