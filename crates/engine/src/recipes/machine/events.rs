//! What happens in a vector: the events of a run.

use super::execution::{Execution, Progress, Vector};
use linewright_recipe::model::Action;
use linewright_recipe::plan::{Entry, EntrySubject, HeldPart, PartOwner};

impl Execution<'_> {
    /// Returns the events of a vector: the step of the recipe, transfers, and internal operations.
    pub fn events(
        &self,
        before: &Progress,
        labels: &[i64],
        vector: &Vector,
    ) -> Option<Vec<Vec<Entry>>> {
        let (mut step, mut others) = (Vec::new(), Vec::new());
        let commands = labels.iter().enumerate();
        let commands: Vec<(usize, &Action)> = commands
            .filter_map(|(at, label)| Some((at, self.command(at, *label)?.1)))
            .collect();
        let entry = |at, action: &Action, subject| {
            let states = [before, &vector.after].map(|p| p.cell.states[at]);
            self.entry(at, action, states, subject)
        };
        for (at, action) in &commands {
            match action {
                Action::Operation(_) => {
                    let call = vector.calls.iter().find(|c| c.0 == *at)?.1;
                    let subject = EntrySubject::Operation {
                        product: 0,
                        transition: before.transition?,
                        step: before.performed,
                        call,
                    };
                    step.push(entry(*at, action, subject)?);
                }
                Action::Internal(_) => {
                    others.push(vec![entry(*at, action, EntrySubject::Internal)?]);
                }
                Action::Out(label) => {
                    let [held, left] = [before, &vector.after].map(|p| &p.cell.parts[*at]);
                    let subject = EntrySubject::Part(self.given(held, left)?);
                    let takes = Action::In(label.clone());
                    let taker = commands.iter().find(|(_, other)| **other == takes)?.0;
                    others.push(vec![
                        entry(*at, action, subject.clone())?,
                        entry(taker, &takes, subject)?,
                    ]);
                }
                Action::In(_) => {}
            }
        }
        let step = (!step.is_empty()).then_some(step);
        Some(step.into_iter().chain(others).collect())
    }

    /// Returns the entry of a resource that goes from one state to another.
    fn entry(
        &self,
        at: usize,
        action: &Action,
        states: [usize; 2],
        subject: EntrySubject,
    ) -> Option<Entry> {
        let resource = &self.layout.resources[at];
        let [from, to] = states.map(|state| &resource.states[state].name);
        let mut all = resource.transitions.iter();
        let transition = all.position(|t| t.from == *from && t.to == *to && t.action == *action)?;
        Some(Entry {
            event: 0,
            start: 0,
            end: 0,
            resource: at,
            transition,
            subject,
        })
    }

    /// Returns the part that a resource has given.
    fn given(&self, held: &[String], left: &[String]) -> Option<HeldPart> {
        let count = |all: &[String], part: &str| all.iter().filter(|p| *p == part).count();
        let given = held.iter().find(|p| count(held, p) > count(left, p))?;
        let owner = match self.recipe.part(given) {
            Some(_) => PartOwner::Product(0),
            None => PartOwner::Stock,
        };
        Some(HeldPart {
            name: given.clone(),
            owner,
        })
    }
}
