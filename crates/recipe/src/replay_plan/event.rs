//! Events: the moves of one or more resources that belong together.

use super::{EventFault, Replay, World};
use crate::model::{Action, Transition};
use crate::plan::{Entry, EntrySubject, Execution, HeldPart, Objective, PartOwner, Progress};

impl Replay<'_> {
    /// Returns the parts of a resource without the inputs of an operation.
    pub(super) fn take(
        &self,
        world: &World,
        resource: usize,
        product: usize,
        inputs: &[String],
    ) -> Option<Vec<HeldPart>> {
        let mut held = world.parts[resource].clone();
        for input in inputs {
            let own = HeldPart {
                name: input.clone(),
                owner: PartOwner::Product(product),
            };
            let kind = &self
                .recipe(product)
                .parts
                .iter()
                .find(|p| p.name == *input)?
                .kind;
            let made = self.demands.iter().filter(|d| d.count > 0);
            let is_part = made
                .into_iter()
                .any(|d| d.recipe.parts.iter().any(|p| p.name == *kind));
            let wanted = if world.parts.iter().flatten().any(|p| *p == own) || is_part {
                own
            } else {
                HeldPart {
                    name: kind.clone(),
                    owner: PartOwner::Stock,
                }
            };
            let at = held.iter().position(|p| *p == wanted)?;
            held.remove(at);
        }
        Some(held)
    }

    /// Returns how long a transition takes.
    fn duration(&self, transition: &Transition) -> i64 {
        match self.plan.execution() {
            Execution::Lockstep => 1,
            Execution::Timed => (transition.seconds.unwrap_or(0.0) * 1e9).round() as i64,
        }
    }

    /// Applies an event. Returns its cost, if the objective is not a time.
    pub(super) fn event(&self, world: &mut World, entries: &[Entry]) -> Result<i64, EventFault> {
        let before = world.clone();
        let mut cost = 0;
        let mut transitions = Vec::new();
        for (number, entry) in entries.iter().enumerate() {
            let resource = self.layout.resources.get(entry.resource);
            let resource = resource.ok_or(EventFault::NoSuchMove)?;
            let transition = resource.transitions.get(entry.transition);
            let transition = transition.ok_or(EventFault::NoSuchMove)?;
            let name = || resource.name.clone();
            if entries[..number]
                .iter()
                .any(|e| e.resource == entry.resource)
            {
                return Err(EventFault::Apart);
            }
            if transition.from != before.states[entry.resource] {
                return Err(EventFault::State(name()));
            }
            let free = before.free[entry.resource];
            if entry.start < free || entry.start < before.floor {
                return Err(EventFault::Early(name()));
            }
            if entry.start > free && !resource.may_wait(&transition.from) {
                return Err(EventFault::Waits(name()));
            }
            if entry.end - entry.start != self.duration(transition) {
                return Err(EventFault::Time(name()));
            }
            world.states[entry.resource].clone_from(&transition.to);
            world.free[entry.resource] = entry.end;
            cost += match self.plan.objective {
                Objective::Transfers => i64::from(matches!(transition.action, Action::Out(_))),
                Objective::Energy => {
                    let watts = transition.watts.unwrap_or(0.0);
                    (transition.seconds.unwrap_or(0.0) * watts * 1e6).round() as i64
                }
                Objective::Steps | Objective::Time => 0,
            };
            transitions.push(transition);
        }
        match &entries[0].subject {
            EntrySubject::Internal => {
                let is_internal = matches!(transitions[0].action, Action::Internal(_));
                if entries.len() != 1 || !is_internal {
                    return Err(EventFault::Apart);
                }
            }
            EntrySubject::Part(part) => self.transfer(world, entries, &transitions, part)?,
            EntrySubject::Operation { product, .. } => {
                self.step(world, &before, entries, &transitions, *product)?;
            }
        }
        for entry in entries {
            let resource = &self.layout.resources[entry.resource];
            if world.parts[entry.resource].len() > resource.capacity {
                return Err(EventFault::NoRoom(resource.name.clone()));
            }
        }
        Ok(cost)
    }

    fn transfer(
        &self,
        world: &mut World,
        entries: &[Entry],
        transitions: &[&Transition],
        part: &HeldPart,
    ) -> Result<(), EventFault> {
        let ([giver, taker], [given, taken]) = (entries, transitions) else {
            return Err(EventFault::Apart);
        };
        let (Action::Out(label), Action::In(other)) = (&given.action, &taken.action) else {
            return Err(EventFault::Apart);
        };
        let is_together = match self.plan.execution() {
            Execution::Lockstep => giver.start == taker.start,
            Execution::Timed => giver.end == taker.start,
        };
        if label != other || giver.subject != taker.subject || !is_together {
            return Err(EventFault::Apart);
        }
        if self.plan.execution() == Execution::Lockstep {
            let used = (label.clone(), giver.start);
            if world.labels.contains(&used) {
                return Err(EventFault::Label(label.clone()));
            }
            world.labels.push(used);
        }
        let held = &mut world.parts[giver.resource];
        let Some(at) = held.iter().position(|p| p == part) else {
            let name = &self.layout.resources[giver.resource].name;
            return Err(EventFault::NoPart(name.clone()));
        };
        let part = held.remove(at);
        world.parts[taker.resource].push(part);
        Ok(())
    }

    fn step(
        &self,
        world: &mut World,
        before: &World,
        entries: &[Entry],
        transitions: &[&Transition],
        product: usize,
    ) -> Result<(), EventFault> {
        let fault = || EventFault::Step(product);
        let progress = before.progress.get(product).ok_or_else(fault)?;
        let Progress::Performing { transition, steps } = *progress else {
            return Err(fault());
        };
        let recipe = self.recipe(product);
        let step = recipe.transitions[transition]
            .steps
            .get(steps)
            .ok_or_else(fault)?;
        if entries.len() != step.operations.len() || before.closed[product] {
            return Err(fault());
        }
        for (number, (entry, taken)) in entries.iter().zip(transitions).enumerate() {
            let operation = &step.operations[number];
            let subject = EntrySubject::Operation {
                product,
                transition,
                step: steps,
                call: number,
            };
            let early = entry.start < before.ready[product] || entry.start != entries[0].start;
            if entry.subject != subject
                || early
                || taken.action != Action::Operation(operation.name.clone())
            {
                return Err(fault());
            }
            let Some(mut held) = self.take(before, entry.resource, product, &operation.inputs)
            else {
                let name = &self.layout.resources[entry.resource].name;
                return Err(EventFault::NoPart(name.clone()));
            };
            held.extend(operation.outputs.iter().map(|name| HeldPart {
                name: name.clone(),
                owner: PartOwner::Product(product),
            }));
            world.parts[entry.resource] = held;
            world.ready[product] = world.ready[product].max(entry.end);
        }
        world.progress[product] = Progress::Performing {
            transition,
            steps: steps + 1,
        };
        Ok(())
    }
}
