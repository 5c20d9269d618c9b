//! Executes vectors on a layout, given by the labels of a machine.

use super::{Command, RecipeMachine};
use linewright_recipe::model::{Action, Layout, Recipe, Resource, Step};

/// States and parts of all resources.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Cell {
    pub states: Vec<usize>,
    pub parts: Vec<Vec<String>>,
}

/// What has been made.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Progress {
    /// Current transition of the recipe; `None` before the first.
    pub transition: Option<usize>,
    /// Number of its steps that were performed.
    pub performed: usize,
    pub cell: Cell,
}

/// What a vector leads to.
pub(super) struct Vector {
    pub after: Progress,
    /// For each resource that performs an operation, its index and the call of the step.
    pub calls: Calls,
}

/// Resources with calls of a step, as indices.
type Calls = Vec<(usize, usize)>;

/// What is executed.
pub(super) struct Execution<'a> {
    pub layout: &'a Layout,
    pub recipe: &'a Recipe,
    pub of: &'a RecipeMachine,
}

impl Execution<'_> {
    /// Returns the beginning: the states and parts of the layout.
    pub fn start(&self) -> Progress {
        let resources = &self.layout.resources;
        Progress {
            transition: None,
            performed: 0,
            cell: Cell {
                states: (resources.iter())
                    .map(|r| r.state(&r.initial).unwrap_or_default())
                    .collect(),
                parts: resources.iter().map(|r| sorted(r.holds.clone())).collect(),
            },
        }
    }

    /// Returns the command of a label, and its action; `None` for `wait`.
    pub fn command(&self, at: usize, label: i64) -> Option<(&Command, &Action)> {
        let index = usize::try_from(label).ok()?.checked_sub(1)?;
        let command = self.of.commands[at].get(index)?;
        let transition = self.layout.resources[at].transitions.get(command.action)?;
        Some((command, &transition.action))
    }

    /// Returns what a vector can lead to; nothing if it is impossible.
    pub fn apply(&self, before: &Progress, labels: &[i64]) -> Vec<Vector> {
        let resources = &self.layout.resources;
        let mut after = before.cell.clone();
        let (mut given, mut taking, mut acting) = (Vec::new(), Vec::new(), Vec::new());
        for (at, resource) in resources.iter().enumerate() {
            let state = &resource.states[before.cell.states[at]];
            let Some((command, action)) = self.command(at, labels[at]) else {
                if labels[at] != 0 || !state.may_wait {
                    return Vec::new();
                }
                continue;
            };
            let Some(target) = target(resource, &state.name, command, action) else {
                return Vec::new();
            };
            after.states[at] = target;
            match action {
                Action::Internal(_) => {}
                Action::Operation(_) => acting.push((at, command)),
                Action::In(label) => taking.push((label, at)),
                Action::Out(label) => {
                    let held = &mut after.parts[at];
                    let which = match &command.parts {
                        None => (held.len() == 1).then_some(0),
                        Some(parts) => held.iter().position(|p| parts.contains(p)),
                    };
                    let Some(which) = which else {
                        return Vec::new();
                    };
                    given.push((label, held.remove(which)));
                }
            }
        }
        if given.len() != taking.len() {
            return Vec::new();
        }
        for (label, part) in &given {
            let mut takers = taking.iter().filter(|(other, _)| other == label);
            let givers = given.iter().filter(|(other, _)| other == label).count();
            let (Some((_, taker)), None, 1) = (takers.next(), takers.next(), givers) else {
                return Vec::new();
            };
            let held = &mut after.parts[*taker];
            held.push(part.clone());
            held.sort_unstable();
            if held.len() > resources[*taker].capacity {
                return Vec::new();
            }
        }
        let mut cells = Vec::new();
        if acting.is_empty() {
            cells.push((after, Vec::new()));
        } else if let Some(step) = self.next_step(before)
            && step.operations.len() == acting.len()
        {
            let found = (after, Vec::new());
            self.perform(&before.cell, step, &acting, &found, &mut cells);
        }
        let performed = before.performed + usize::from(!acting.is_empty());
        let vector = |(cell, calls)| Vector {
            after: Progress {
                transition: before.transition,
                performed,
                cell,
            },
            calls,
        };
        cells.into_iter().map(vector).collect()
    }

    fn next_step(&self, progress: &Progress) -> Option<&Step> {
        let transition = &self.recipe.transitions[progress.transition?];
        transition.steps.get(progress.performed)
    }

    /// Distributes the calls of a step to the resources that act, in all ways that their labels and
    /// parts permit.
    fn perform(
        &self,
        before: &Cell,
        step: &Step,
        acting: &[(usize, &Command)],
        after: &(Cell, Calls),
        found: &mut Vec<(Cell, Calls)>,
    ) {
        let Some(((at, command), rest)) = acting.split_first() else {
            found.push(after.clone());
            return;
        };
        let resource = &self.layout.resources[*at];
        let action = &resource.transitions[command.action].action;
        for (number, call) in step.operations.iter().enumerate() {
            let is_free = after.1.iter().all(|(_, taken)| *taken != number);
            let is_meant = is_free
                && *action == Action::Operation(call.name.clone())
                && command.parts.as_ref().is_none_or(|p| *p == call.inputs)
                && command.made.as_ref().is_none_or(|m| *m == call.outputs);
            let Some(mut held) = self.without(before, *at, &call.inputs) else {
                continue;
            };
            held.extend(call.outputs.iter().cloned());
            if !is_meant || held.len() > resource.capacity {
                continue;
            }
            let mut next = after.clone();
            next.0.parts[*at] = sorted(held);
            next.1.push((*at, number));
            self.perform(before, step, rest, &next, found);
        }
    }

    /// Returns the parts of a resource without some. While a part is nowhere in the cell, stock of
    /// its type replaces it.
    pub fn without(&self, cell: &Cell, at: usize, parts: &[String]) -> Option<Vec<String>> {
        let mut held = cell.parts[at].clone();
        for name in parts {
            let mut wanted = name;
            if !cell.parts.iter().flatten().any(|p| p == name)
                && let Some(part) = self.recipe.parts.iter().find(|p| p.name == *name)
                && self.recipe.part(&part.kind).is_none()
            {
                wanted = &part.kind;
            }
            let which = held.iter().position(|p| p == wanted)?;
            held.remove(which);
        }
        Some(held)
    }
}

/// Returns the state that a command leads to, if the resource's own state determines it.
fn target(resource: &Resource, from: &str, command: &Command, action: &Action) -> Option<usize> {
    let mut targets: Vec<usize> = (resource.transitions.iter())
        .filter(|t| t.from == from && t.action == *action)
        .filter_map(|t| resource.state(&t.to))
        .filter(|to| command.to.is_none_or(|wanted| wanted == *to))
        .collect();
    targets.dedup();
    match targets.as_slice() {
        [only] => Some(*only),
        _ => None,
    }
}

fn sorted(mut parts: Vec<String>) -> Vec<String> {
    parts.sort_unstable();
    parts
}
