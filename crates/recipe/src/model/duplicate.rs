//! Duplication of a resource together with its routes.
//!
//! The paper adds duplicates to its demonstrator and does not say how they are connected. Here a
//! duplicate has labels of its own. Each resource that exchanges parts with the original offers
//! the duplicate's labels wherever it offers the original's. A state that is entered only by
//! taking a part from the original (a transport that holds such a part) gets a copy that is
//! entered by taking one from the duplicate, and that has the same transitions.

use super::{Action, Layout, Resource, State, Transition};

/// Error for a resource that cannot be duplicated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DuplicateError {
    /// The layout has no resource with the name.
    #[error("the layout has no resource `{0}`")]
    Unknown(String),
    /// The layout already has a resource with the name.
    #[error("the layout already has a resource `{0}`")]
    Taken(String),
}

impl Layout {
    /// Adds a duplicate of the resource `of`, which is called `name` and holds no parts.
    pub fn duplicate(&mut self, of: &str, name: &str) -> Result<(), DuplicateError> {
        let Some(original) = self.resource(of) else {
            return Err(DuplicateError::Unknown(of.to_owned()));
        };
        if self.resource(name).is_some() {
            return Err(DuplicateError::Taken(name.to_owned()));
        }
        let mut copy = self.resources[original].clone();
        name.clone_into(&mut copy.name);
        copy.holds.clear();
        let mut labels: Vec<(String, String)> = Vec::new();
        for transition in &mut copy.transitions {
            if let Action::In(label) | Action::Out(label) = &mut transition.action {
                if !labels.iter().any(|(old, _)| old == label) {
                    labels.push((label.clone(), self.free_label(label, name)));
                }
                *label = renamed(&labels, label).unwrap_or_default();
            }
        }
        for (at, resource) in self.resources.iter_mut().enumerate() {
            if at != original {
                add_routes(resource, &labels, name);
            }
        }
        self.resources.push(copy);
        Ok(())
    }

    /// Returns a label that the layout does not use yet.
    fn free_label(&self, label: &str, name: &str) -> String {
        let mut free = format!("{label}@{name}");
        while (self.resources.iter())
            .flat_map(|r| &r.transitions)
            .any(|t| t.action.label() == Some(&free))
        {
            free.push('\'');
        }
        free
    }
}

/// Returns the duplicate's label for one of the original.
fn renamed(labels: &[(String, String)], label: &str) -> Option<String> {
    (labels.iter().find(|(old, _)| old == label)).map(|(_, new)| new.clone())
}

/// Adds to a resource what it needs to exchange parts with the duplicate.
fn add_routes(resource: &mut Resource, labels: &[(String, String)], name: &str) {
    let takes = |action: &Action| match action {
        Action::In(label) => renamed(labels, label).is_some(),
        _ => false,
    };
    let copied: Vec<State> = (resource.states.iter())
        .filter(|s| {
            let mut entering = (resource.transitions.iter()).filter(|t| t.to == s.name);
            let first = entering.next().is_some_and(|t| takes(&t.action));
            first && entering.all(|t| takes(&t.action)) && s.name != resource.initial
        })
        .cloned()
        .collect();
    let copies: Vec<(String, String)> = (copied.iter())
        .map(|s| {
            let mut free = format!("{}@{name}", s.name);
            while resource.state(&free).is_some() {
                free.push('\'');
            }
            (s.name.clone(), free)
        })
        .collect();
    resource.states.extend(copied.iter().map(|s| State {
        name: renamed(&copies, &s.name).unwrap_or_default(),
        may_wait: s.may_wait,
    }));
    let mut added = Vec::new();
    for transition in &resource.transitions {
        let sources = [
            Some(transition.from.clone()),
            renamed(&copies, &transition.from),
        ];
        let label = transition.action.label();
        let actions = [
            Some(transition.action.clone()),
            label
                .and_then(|l| renamed(labels, l))
                .map(|l| match transition.action {
                    Action::In(_) => Action::In(l),
                    _ => Action::Out(l),
                }),
        ];
        for (which, from) in sources.iter().enumerate() {
            for (other, action) in actions.iter().enumerate() {
                let (Some(from), Some(action), false) = (from, action, which + other == 0) else {
                    continue;
                };
                let to = if other == 1 && takes(&transition.action) {
                    renamed(&copies, &transition.to)
                } else {
                    None
                };
                added.push(Transition {
                    from: from.clone(),
                    to: to.unwrap_or_else(|| transition.to.clone()),
                    action: action.clone(),
                    ..*transition
                });
            }
        }
    }
    resource.transitions.extend(added);
}
