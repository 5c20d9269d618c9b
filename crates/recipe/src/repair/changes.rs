//! Changes of a layout that a repair can make.

use crate::model::{Action, Layout, Recipe, Resource, State, Transition};
use rustc_hash::FxHashSet;

/// A change of a layout. Resources and states are given by name.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Change {
    /// A transport gives what it holds in a state to the resource that takes it under a label.
    Route {
        /// Name of the transport.
        resource: String,
        /// Name of the state that the new transition leaves.
        from: String,
        /// Label of the transfer.
        label: String,
        /// Name of the state that it enters.
        to: String,
    },
    /// A transport takes a part under a label that it has not taken yet, and gives it under
    /// another: a route that begins where none of its routes begins.
    Connection {
        /// Name of the transport.
        resource: String,
        /// Name of the state in which it takes the part, and to which it returns.
        empty: String,
        /// Label under which it takes the part.
        take: String,
        /// Label under which it gives the part.
        give: String,
    },
    /// A resource holds one part more.
    Capacity {
        /// Name of the resource.
        resource: String,
    },
    /// A resource performs an operation.
    Operation {
        /// Name of the resource.
        resource: String,
        /// Name of the state that the new transition leaves.
        from: String,
        /// Name of the operation.
        operation: String,
        /// Name of the state that it enters.
        to: String,
    },
    /// A second resource like this one, with its routes.
    Duplicate {
        /// Name of the resource.
        resource: String,
    },
}

/// Returns the layout with some changes. Duplicates are made last, so they have the others. What
/// the layout does not have is ignored.
pub fn apply<'a>(layout: &Layout, changes: impl Iterator<Item = &'a Change>) -> Layout {
    let mut changed = layout.clone();
    let mut duplicated = Vec::new();
    for change in changes {
        let (name, transition) = match change {
            Change::Route {
                resource,
                from,
                label,
                to,
            } => (resource, (from, Action::Out(label.clone()), to)),
            Change::Operation {
                resource,
                from,
                operation,
                to,
            } => (resource, (from, Action::Operation(operation.clone()), to)),
            Change::Connection {
                resource,
                empty,
                take,
                give,
            } => {
                if let Some(at) = changed.resource(resource) {
                    connect(&mut changed.resources[at], empty, take, give);
                }
                continue;
            }
            Change::Capacity { resource } => {
                if let Some(at) = changed.resource(resource) {
                    changed.resources[at].capacity += 1;
                }
                continue;
            }
            Change::Duplicate { resource } => {
                duplicated.push(resource);
                continue;
            }
        };
        if let Some(at) = changed.resource(name) {
            let (from, action, to) = transition;
            changed.resources[at].transitions.push(Transition {
                from: from.clone(),
                to: to.clone(),
                action,
                seconds: None,
                watts: None,
            });
        }
    }
    for name in duplicated {
        let mut copy = format!("{name}'");
        while changed.resource(&copy).is_some() {
            copy.push('\'');
        }
        // It fails only for a resource that does not exist.
        let _ = changed.duplicate(name, &copy);
    }
    changed
}

/// Adds a state in which a transport carries a part from `take` to `give`.
fn connect(transport: &mut Resource, empty: &str, take: &str, give: &str) {
    let mut carrying = format!("{take}->{give}");
    while transport.state(&carrying).is_some() {
        carrying.push('\'');
    }
    transport.states.push(State {
        name: carrying.clone(),
        may_wait: true,
    });
    let mut add = |from: &str, action: Action, to: &str| {
        transport.transitions.push(Transition {
            from: from.to_owned(),
            to: to.to_owned(),
            action,
            seconds: None,
            watts: None,
        });
    };
    add(empty, Action::In(take.to_owned()), &carrying);
    add(&carrying, Action::Out(give.to_owned()), empty);
}

/// Returns all operations of the recipe that a resource could perform in addition: every state that
/// the new transition could leave, and every state that it could enter.
pub fn operations(layout: &Layout, recipe: &Recipe) -> Vec<Change> {
    let mut names: Vec<&str> = Vec::new();
    let steps = recipe.transitions.iter().flat_map(|t| &t.steps);
    for call in steps.flat_map(|s| &s.operations) {
        if !names.contains(&call.name.as_str()) {
            names.push(&call.name);
        }
    }
    let mut changes = Vec::new();
    for name in names {
        let action = Action::Operation(name.to_owned());
        for resource in &layout.resources {
            for (from, to) in new_transitions(resource, &action) {
                changes.push(Change::Operation {
                    resource: resource.name.clone(),
                    from,
                    operation: name.to_owned(),
                    to,
                });
            }
        }
    }
    changes
}

/// Returns all pairs of states that are not yet joined by an action.
fn new_transitions(resource: &Resource, action: &Action) -> Vec<(String, String)> {
    let known: FxHashSet<(&str, &str)> = (resource.transitions.iter())
        .filter(|t| t.action == *action)
        .map(|t| (t.from.as_str(), t.to.as_str()))
        .collect();
    let names = || resource.states.iter().map(|s| s.name.as_str());
    let pairs = names().flat_map(|from| names().map(move |to| (from, to)));
    (pairs.filter(|pair| !known.contains(pair)))
        .map(|(from, to)| (from.to_owned(), to.to_owned()))
        .collect()
}

/// Returns all routes that could be added. A transport is a resource that takes parts and performs
/// no operation; a route leaves a state that it enters with a part, and enters a state that it
/// enters without one (any state if there is none).
pub fn routes(layout: &Layout) -> Vec<Change> {
    let mut changes = Vec::new();
    for (at, resource) in layout.resources.iter().enumerate() {
        let transitions = &resource.transitions;
        if transitions
            .iter()
            .any(|t| matches!(t.action, Action::Operation(_)))
        {
            continue;
        }
        let entered = |by: fn(&Action) -> bool| -> Vec<&str> {
            let states = resource.states.iter().map(|s| s.name.as_str());
            let is = |s: &&str| transitions.iter().any(|t| t.to == *s && by(&t.action));
            states.filter(is).collect()
        };
        let from = entered(|a| matches!(a, Action::In(_)));
        let mut to = entered(|a| matches!(a, Action::Out(_)));
        if to.is_empty() {
            to = resource.states.iter().map(|s| s.name.as_str()).collect();
        }
        let mut labels: Vec<&str> = Vec::new();
        for (_, other) in layout
            .resources
            .iter()
            .enumerate()
            .filter(|(o, _)| *o != at)
        {
            for transition in &other.transitions {
                if let Action::In(label) = &transition.action
                    && !labels.contains(&label.as_str())
                {
                    labels.push(label);
                }
            }
        }
        for label in labels {
            let action = Action::Out(label.to_owned());
            for pair in new_transitions(resource, &action) {
                if from.contains(&pair.0.as_str()) && to.contains(&pair.1.as_str()) {
                    changes.push(Change::Route {
                        resource: resource.name.clone(),
                        from: pair.0,
                        label: label.to_owned(),
                        to: pair.1,
                    });
                }
            }
        }
    }
    changes
}

/// Returns all routes that could be added to a transport and begin where none of its routes begins.
/// A transport is a resource that takes parts, or has no transitions, and performs no operation.
pub fn connections(layout: &Layout) -> Vec<Change> {
    let mut changes = Vec::new();
    for (at, resource) in layout.resources.iter().enumerate() {
        let actions = || resource.transitions.iter().map(|t| &t.action);
        let takes = || actions().any(|a| matches!(a, Action::In(_)));
        if actions().any(|a| matches!(a, Action::Operation(_)))
            || !(resource.transitions.is_empty() || takes())
        {
            continue;
        }
        let mut empty: Vec<&str> = Vec::new();
        for transition in &resource.transitions {
            if matches!(transition.action, Action::In(_)) && !empty.contains(&&*transition.from) {
                empty.push(&transition.from);
            }
        }
        if empty.is_empty() {
            empty.push(&resource.initial);
        }
        let (mut given, mut taken): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
        let others = layout.resources.iter().enumerate();
        for transition in others
            .filter(|(o, _)| *o != at)
            .flat_map(|(_, r)| &r.transitions)
        {
            match &transition.action {
                Action::Out(label) if !given.contains(&label.as_str()) => given.push(label),
                Action::In(label) if !taken.contains(&label.as_str()) => taken.push(label),
                _ => {}
            }
        }
        given.retain(|label| !actions().any(|a| *a == Action::In((*label).to_owned())));
        for empty in &empty {
            for take in &given {
                for give in &taken {
                    changes.push(Change::Connection {
                        resource: resource.name.clone(),
                        empty: (*empty).to_owned(),
                        take: (*take).to_owned(),
                        give: (*give).to_owned(),
                    });
                }
            }
        }
    }
    changes
}

/// Returns a larger capacity for each resource.
pub fn capacities(layout: &Layout) -> Vec<Change> {
    let names = layout.resources.iter().map(|r| r.name.clone());
    names
        .map(|resource| Change::Capacity { resource })
        .collect()
}

/// Returns a duplicate of each resource that may wait in its initial state. Others could make a
/// layout worse.
pub fn duplicates(layout: &Layout) -> Vec<Change> {
    let may_wait = |r: &&Resource| r.state(&r.initial).is_some_and(|s| r.states[s].may_wait);
    let names = layout
        .resources
        .iter()
        .filter(may_wait)
        .map(|r| r.name.clone());
    names
        .map(|resource| Change::Duplicate { resource })
        .collect()
}
