//! Transports: from routes to a labelled transition system.
//!
//! A transport is empty or carries one part. It takes a part with a label under which the resource
//! at the beginning of a route gives parts, and is then in a state that is named after that
//! resource; from there it gives the part with a label under which the resource at the end of the
//! route takes parts. The time of a route is that of the second transfer. It may wait everywhere.
//!
//! A transport for several parts is as many resources, called `shuttle`, `shuttle#2` and so on.
//! A single resource would not know which of its parts came from where, and could take a part along
//! the route of another. A part passes from one transport to another with a label of their own.

use super::layout::Builder;
use super::unknown;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_recipe::model::{Action, Layout, State, Transition};
use linewright_syntax::ast::{Dock, Name};

/// Name of the state in which a transport carries nothing.
pub(super) const EMPTY: &str = "empty";

/// Time and power of a route.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ride {
    pub seconds: Option<f64>,
    pub watts: Option<f64>,
}

/// Which transfers of a resource are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// Those that give a part.
    Gives,
    /// Those that take a part.
    Takes,
}

impl Side {
    fn label(self, action: &Action) -> Option<&str> {
        match (self, action) {
            (Self::Gives, Action::Out(label)) | (Self::Takes, Action::In(label)) => Some(label),
            _ => None,
        }
    }

    fn opposite(self) -> Self {
        match self {
            Self::Gives => Self::Takes,
            Self::Takes => Self::Gives,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Gives => "out",
            Self::Takes => "in",
        }
    }
}

/// Returns whether a transfer has this label, or has got it as that of a duplicate.
fn is_label(label: &str, written: &str) -> bool {
    let original = label.strip_prefix(written);
    original.is_some_and(|rest| rest.is_empty() || rest.starts_with('@'))
}

/// Returns the labels of a resource's transfers, each once.
fn labels(layout: &Layout, resource: usize, side: Side) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for transition in &layout.resources[resource].transitions {
        if let Some(label) = side.label(&transition.action)
            && !labels.iter().any(|l| l == label)
        {
            labels.push(label.to_owned());
        }
    }
    labels
}

impl Builder<'_, '_> {
    /// Adds a route of a transport between two resources that the layout already has.
    pub(super) fn route(&mut self, transport: &Name, from: &Dock, to: &Dock, ride: Ride) {
        let (Some(taken), Some(given)) = (
            self.dock_labels(transport, from, Side::Gives),
            self.dock_labels(transport, to, Side::Takes),
        ) else {
            return;
        };
        for slot in self.indices(&transport.text) {
            let state = self.loaded_state(slot, &taken, from);
            for label in &given {
                let action = Action::Out(label.clone());
                let resource = &self.layout.model.resources[slot];
                let known =
                    (resource.transitions.iter()).any(|t| t.from == state && t.action == action);
                if !known {
                    self.ride(slot, (&state, EMPTY), action, ride, to.span());
                }
            }
        }
    }

    /// Returns the labels with which a transport exchanges parts with a resource.
    fn dock_labels(&mut self, transport: &Name, dock: &Dock, side: Side) -> Option<Vec<String>> {
        let name = &dock.resource;
        if name.text == transport.text {
            self.report_route(
                dock,
                format!("the transport `{}` is an end of its own route", name.text),
                "a route leads from one resource to another",
            );
            return None;
        }
        let indices = self.indices(&name.text);
        let Some(first) = indices.first().copied() else {
            self.report_unknown_resource(name);
            return None;
        };
        if self.layout.resources[first].is_transport {
            let label = match side {
                Side::Gives => format!("{}->{}", name.text, transport.text),
                Side::Takes => format!("{}->{}", transport.text, name.text),
            };
            return Some(vec![label]);
        }
        let all = labels(&self.layout.model, first, side);
        let word = side.word();
        if let Some(written) = &dock.label {
            let meant = all.iter().find(|l| is_label(l, &written.text));
            if meant.is_none() {
                let finding = unknown(
                    written,
                    format!("`{}` has no transfer `{word}:{}`", name.text, written.text),
                    all.iter().map(String::as_str),
                    "its labels are",
                );
                self.e.findings.push(finding);
            }
            return meant.map(|label| vec![label.clone()]);
        }
        let free: Vec<String> = (all.iter())
            .filter(|label| !self.has_direct_partner(first, label, side))
            .cloned()
            .collect();
        if free.is_empty() {
            let verb = if side == Side::Gives {
                "gives"
            } else {
                "takes"
            };
            let (message, help) = match all.first() {
                None => (
                    format!("`{}` {verb} no parts", name.text),
                    format!(
                        "write a transition with `{word}` in `{}`: `s1 -> s0: {word}`",
                        name.text
                    ),
                ),
                Some(label) => (
                    format!("`{}` {verb} parts only directly", name.text),
                    format!(
                        "give it a transfer for the transport, or name the label here: `{}:{label}`",
                        name.text
                    ),
                ),
            };
            self.report_route(dock, message, &help);
            return None;
        }
        Some(free)
    }

    /// Returns whether a resource that is no transport is the partner in a transfer.
    fn has_direct_partner(&self, resource: usize, label: &str, side: Side) -> bool {
        let others = (self
            .layout
            .model
            .resources
            .iter()
            .zip(&self.layout.resources))
        .enumerate();
        others
            .filter(|(at, (_, info))| *at != resource && !info.is_transport)
            .flat_map(|(_, (other, _))| &other.transitions)
            .any(|t| side.opposite().label(&t.action) == Some(label))
    }

    /// Returns the state in which a transport carries a part that it took with one of these labels,
    /// and adds what is missing.
    fn loaded_state(&mut self, slot: usize, labels: &[String], from: &Dock) -> String {
        let resource = &self.layout.model.resources[slot];
        let takes = |label: &String| {
            let action = Action::In(label.clone());
            (resource.transitions.iter())
                .find(|t| t.action == action)
                .map(|t| t.to.clone())
        };
        let name = &from.resource.text;
        let state = labels
            .iter()
            .find_map(takes)
            .unwrap_or_else(|| match name.as_str() {
                EMPTY => format!("{EMPTY}_"),
                _ => name.clone(),
            });
        let missing: Vec<&String> = labels.iter().filter(|l| takes(l).is_none()).collect();
        let missing: Vec<String> = missing.into_iter().cloned().collect();
        if resource.state(&state).is_none() {
            self.layout.model.resources[slot].states.push(State {
                name: state.clone(),
                may_wait: true,
            });
            self.layout.resources[slot].states.push(from.span());
        }
        for label in missing {
            let none = Ride {
                seconds: None,
                watts: None,
            };
            self.ride(slot, (EMPTY, &state), Action::In(label), none, from.span());
        }
        state
    }

    fn ride(&mut self, slot: usize, states: (&str, &str), action: Action, ride: Ride, place: Span) {
        self.layout.model.resources[slot]
            .transitions
            .push(Transition {
                from: states.0.to_owned(),
                to: states.1.to_owned(),
                action,
                seconds: ride.seconds,
                watts: ride.watts,
            });
        self.layout.resources[slot].transitions.push(place);
    }

    fn report_route(&mut self, dock: &Dock, message: String, help: &str) {
        let finding = Diagnostic::error(codes::LAYOUT_ROUTE, dock.span(), message);
        self.e.findings.push(finding.with_help(help));
    }
}
