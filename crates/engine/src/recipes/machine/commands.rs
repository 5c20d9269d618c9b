//! Commands to resources: the labels of the outputs of a machine.

use linewright_recipe::controller::{Move, Subject};
use linewright_recipe::model::{Action, Layout, OperationCall, Recipe, Resource, Step};

/// What a resource has to do, unless it has to wait.
///
/// With its own state and what it holds, this determines what the resource does.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Command {
    /// Index of the resource's first transition that has the action.
    pub action: usize,
    /// Parts that an operation needs, or the part that is given; if the resource has room for
    /// several.
    pub parts: Option<Vec<String>>,
    /// Parts that an operation makes, if the recipe also asks for the operation with the same parts
    /// and other results.
    pub made: Option<Vec<String>>,
    /// Index of the state that it enters, if the action leads from one state to several.
    pub to: Option<usize>,
}

impl Command {
    /// Returns the command for a move. `step` is the next step of the recipe.
    pub(super) fn of(layout: &Layout, recipe: &Recipe, m: &Move, step: Option<&Step>) -> Self {
        let resource = &layout.resources[m.resource];
        let taken = &resource.transitions[m.transition];
        let mut same = resource.transitions.iter();
        let mut command = Self {
            action: same
                .position(|t| t.action == taken.action)
                .unwrap_or(m.transition),
            parts: None,
            made: None,
            to: None,
        };
        let is_roomy = resource.capacity > 1;
        match (&taken.action, &m.subject) {
            (Action::Out(_), Subject::Part(part)) => {
                command.parts = is_roomy.then(|| vec![part.clone()]);
            }
            (Action::Operation(_), Subject::Operation(number)) => {
                if let Some(call) = step.and_then(|s| s.operations.get(*number)) {
                    command.parts = is_roomy.then(|| call.inputs.clone());
                    command.made = has_other_results(recipe, call).then(|| call.outputs.clone());
                }
            }
            _ => {}
        }
        if is_ambiguous(resource, &taken.action) {
            command.to = resource.state(&taken.to);
        }
        command
    }

    /// Returns the label: `glue`, `out_3`, `engrave_h`, `load_f`, `turn_to_s2`. It may contain
    /// characters of labels that no identifier has, and need not be unique.
    pub(super) fn label(&self, resource: &Resource) -> String {
        let mut words = vec![match &resource.transitions[self.action].action {
            Action::Operation(name) | Action::Internal(name) => name.clone(),
            Action::In(label) => format!("in_{label}"),
            Action::Out(label) => format!("out_{label}"),
        }];
        words.extend(self.parts.iter().chain(&self.made).flatten().cloned());
        if let Some(state) = self.to {
            words.push(format!("to_{}", resource.states[state].name));
        }
        words.join("_")
    }
}

/// Whether an action leads from one state of a resource to several.
fn is_ambiguous(resource: &Resource, action: &Action) -> bool {
    let own = || resource.transitions.iter().filter(|t| t.action == *action);
    own().any(|a| own().any(|b| a.from == b.from && a.to != b.to))
}

/// Whether the recipe asks for the same operation with the same parts and other results.
fn has_other_results(recipe: &Recipe, call: &OperationCall) -> bool {
    let steps = recipe.transitions.iter().flat_map(|t| &t.steps);
    let mut calls = steps.flat_map(|s| &s.operations);
    calls.any(|c| c.name == call.name && c.inputs == call.inputs && c.outputs != call.outputs)
}
