//! Verifies a plan: replays each of its schedules from the layout and the recipes.
//!
//! The search and this module share the model and the types of a plan, but no code that interprets
//! them: this module works with names and lists, one event after the other. It applies the rules
//! that are written in [`crate::plan`].

use crate::model::{Action, Demand, Guard, Layout, Recipe, Transition, demand_problems};
use crate::plan::{
    Entry, EntrySubject, Execution, HeldPart, Next, Objective, PartOwner, Plan, PlanPosition,
    Progress, Schedule,
};

/// What is wrong with a plan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanFault {
    /// The layout or a recipe has problems other than warnings, so it has no meaning.
    #[error("the layout or a recipe has problems")]
    Problems,
    /// The products are not those of the demands.
    #[error("the products are not those of the demands")]
    Products,
    /// The first position is not the start.
    #[error("the first position is not the start")]
    Start,
    /// An index is too large, or a list has the wrong length.
    #[error("position {0}: something does not exist")]
    Malformed(usize),
    /// An event is not possible.
    #[error("position {position}, event {event}: {reason}")]
    Event {
        /// Index of the position.
        position: usize,
        /// Number of the event.
        event: usize,
        /// Why not.
        reason: EventFault,
    },
    /// A test is not possible.
    #[error("position {position}: product {product} cannot be tested like this")]
    Test {
        /// Index of the position.
        position: usize,
        /// Index of the product.
        product: usize,
    },
    /// A schedule ends before all is done, or the time of its end is wrong.
    #[error("position {0}: a schedule ends too early, or its time is wrong")]
    End(usize),
    /// A part remains of a finished product that may not.
    #[error("position {position}: part `{part}` of product {product} remains")]
    LeftOver {
        /// Index of the position.
        position: usize,
        /// Index of the product.
        product: usize,
        /// Name of the part.
        part: String,
    },
    /// A schedule leads to a position that differs from what is then the case.
    #[error("position {0}: a schedule does not lead to its target")]
    Target(usize),
    /// Positions follow each other in a circle in which no loop of a recipe is closed.
    #[error("position {0} leads back to itself")]
    Circle(usize),
    /// The value is wrong, or the lower bound is greater.
    #[error("the value is {actual} instead of {claimed}, or the bound is greater")]
    Value {
        /// Value that the plan claims.
        claimed: i64,
        /// Its value.
        actual: i64,
    },
}

/// Why an event is not possible.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EventFault {
    /// A resource, a transition or an operation does not exist.
    #[error("it does not exist")]
    NoSuchMove,
    /// A resource is not in the state that its transition leaves.
    #[error("resource `{0}` is in another state")]
    State(String),
    /// A resource begins before it is free, or before the test that decides this.
    #[error("resource `{0}` begins too early")]
    Early(String),
    /// A resource waits where it may not.
    #[error("resource `{0}` may not wait")]
    Waits(String),
    /// A transition does not take its time.
    #[error("resource `{0}` takes another time")]
    Duration(String),
    /// The entries of an event do not belong together.
    #[error("its entries do not belong together")]
    Apart,
    /// A label is used twice in one vector.
    #[error("label `{0}` is used twice")]
    Label(String),
    /// A resource does not hold a part that it gives or needs.
    #[error("resource `{0}` does not hold a part")]
    NoPart(String),
    /// A resource would hold too many parts.
    #[error("resource `{0}` has no room")]
    NoRoom(String),
    /// The operations are not the next step of the product, or begin before the last one has ended.
    #[error("it is not the next step of product {0}")]
    Step(usize),
}

/// What is known while a schedule is replayed.
#[derive(Clone)]
struct World {
    states: Vec<String>,
    /// End of the last transition of each resource.
    free: Vec<i64>,
    parts: Vec<Vec<HeldPart>>,
    progress: Vec<Progress>,
    /// Whether each product has closed a loop.
    closed: Vec<bool>,
    /// End of the last step of each product.
    ready: Vec<i64>,
    /// Labels and the vectors in which they are used.
    labels: Vec<(String, i64)>,
    /// Time of the last test.
    floor: i64,
}

/// Replays a plan. Returns the first fault that it finds.
///
/// Takes time proportional to the size of the plan, times the number of parts.
pub fn verify(layout: &Layout, demands: &[Demand], plan: &Plan) -> Result<(), PlanFault> {
    if demand_problems(layout, demands)
        .iter()
        .any(|p| !p.is_warning())
    {
        return Err(PlanFault::Problems);
    }
    let mut products = Vec::new();
    for (number, demand) in demands.iter().enumerate() {
        products.extend(vec![number; demand.count]);
    }
    if products != plan.products {
        return Err(PlanFault::Products);
    }
    let replay = Replay {
        layout,
        demands,
        plan,
        closes: demands.iter().map(|d| d.recipe.closes_loop()).collect(),
    };
    let first = plan.positions.first().ok_or(PlanFault::Start)?;
    if !replay.is_start(first) {
        return Err(PlanFault::Start);
    }
    // The cost of each position on its own, with the positions that follow it.
    let mut costs: Vec<Vec<(i64, Option<usize>)>> = Vec::new();
    for at in 0..plan.positions.len() {
        let mut paths = Vec::new();
        let world = replay.world(at)?;
        replay.follow(at, world, &plan.positions[at].schedule, 0, &mut paths)?;
        costs.push(paths);
    }
    let mut worst = vec![None; costs.len()];
    let actual = worst_case(&costs, 0, &mut vec![false; costs.len()], &mut worst)?;
    if actual != plan.value || plan.lower_bound > actual {
        let claimed = plan.value;
        return Err(PlanFault::Value { claimed, actual });
    }
    Ok(())
}

/// Returns the greatest cost from a position on.
fn worst_case(
    costs: &[Vec<(i64, Option<usize>)>],
    at: usize,
    open: &mut [bool],
    known: &mut [Option<i64>],
) -> Result<i64, PlanFault> {
    if let Some(cost) = known[at] {
        return Ok(cost);
    }
    if std::mem::replace(&mut open[at], true) {
        return Err(PlanFault::Circle(at));
    }
    let mut most = 0;
    for (cost, next) in &costs[at] {
        let rest = match next {
            Some(next) => worst_case(costs, *next, open, known)?,
            None => 0,
        };
        most = most.max(cost + rest);
    }
    open[at] = false;
    known[at] = Some(most);
    Ok(most)
}

/// What a plan is replayed on.
struct Replay<'a> {
    layout: &'a Layout,
    demands: &'a [Demand],
    plan: &'a Plan,
    /// For each demand, the transitions of its recipe that close a loop.
    closes: Vec<Vec<bool>>,
}

impl Replay<'_> {
    fn recipe(&self, product: usize) -> &Recipe {
        &self.demands[self.plan.products[product]].recipe
    }

    /// Returns whether a position is the start.
    fn is_start(&self, position: &PlanPosition) -> bool {
        let products = self.plan.products.len();
        let mut given: Vec<(usize, &String)> = Vec::new();
        let mut parts: Vec<Vec<HeldPart>> = Vec::new();
        for resource in &self.layout.resources {
            let mut held = Vec::new();
            for name in &resource.holds {
                let has = |p: &usize| self.recipe(*p).parts.iter().any(|part| part.name == *name);
                let owners: Vec<usize> = (0..products).filter(has).collect();
                let free = owners.iter().find(|p| !given.contains(&(**p, name)));
                let owner = free.or(owners.first());
                given.extend(owner.map(|p| (*p, name)));
                held.push(HeldPart {
                    name: name.clone(),
                    owner: owner.map_or(PartOwner::Stock, |p| PartOwner::Product(*p)),
                });
            }
            held.sort();
            parts.push(held);
        }
        let state = |(r, s): (&crate::model::Resource, &usize)| {
            r.states.get(*s).is_some_and(|s| s.name == r.initial)
        };
        let begins = |(product, progress): (usize, &Progress)| match progress {
            Progress::At(state) => {
                self.recipe(product).states.get(*state) == Some(&self.recipe(product).start)
            }
            _ => false,
        };
        position.progress.len() == products
            && position.progress.iter().enumerate().all(begins)
            && position.resource_states.len() == self.layout.resources.len()
            && (self.layout.resources.iter().zip(&position.resource_states)).all(state)
            && position.parts == parts
    }

    /// Returns the world at the beginning of a position.
    fn world(&self, at: usize) -> Result<World, PlanFault> {
        let position = &self.plan.positions[at];
        let resources = &self.layout.resources;
        let products = self.plan.products.len();
        let fault = PlanFault::Malformed(at);
        if position.resource_states.len() != resources.len()
            || position.parts.len() != resources.len()
            || position.progress.len() != products
        {
            return Err(fault);
        }
        let states = (resources.iter().zip(&position.resource_states))
            .map(|(r, s)| r.states.get(*s).map(|s| s.name.clone()))
            .collect::<Option<Vec<String>>>();
        let exists = |(product, progress): (usize, &Progress)| match *progress {
            Progress::Ended => true,
            Progress::At(state) => state < self.recipe(product).states.len(),
            Progress::Performing { transition, steps } => (self.recipe(product).transitions)
                .get(transition)
                .is_some_and(|t| steps <= t.steps.len()),
        };
        let (Some(states), true) = (states, position.progress.iter().enumerate().all(exists))
        else {
            return Err(fault);
        };
        let mut world = World {
            states,
            free: vec![0; resources.len()],
            parts: position.parts.clone(),
            progress: position.progress.clone(),
            closed: vec![false; products],
            ready: vec![0; products],
            labels: Vec::new(),
            floor: 0,
        };
        for product in 0..products {
            self.arrive(at, &mut world, product)?;
        }
        Ok(world)
    }

    /// Lets a product pass all states of its recipe that it leaves without a choice.
    fn arrive(&self, at: usize, world: &mut World, product: usize) -> Result<(), PlanFault> {
        let recipe = self.recipe(product);
        loop {
            match world.progress[product] {
                Progress::Ended => return Ok(()),
                Progress::Performing { transition, steps } => {
                    let about = &recipe.transitions[transition];
                    if steps < about.steps.len() {
                        return Ok(());
                    }
                    if self.closes[self.plan.products[product]][transition] {
                        world.closed[product] = true;
                        return Ok(());
                    }
                    let to = recipe.states.iter().position(|s| *s == about.to);
                    world.progress[product] = Progress::At(to.ok_or(PlanFault::Malformed(at))?);
                }
                Progress::At(state) => {
                    let name = &recipe.states[state];
                    if recipe.ends.contains(name) {
                        self.finish(at, world, product)?;
                        world.progress[product] = Progress::Ended;
                        return Ok(());
                    }
                    let leaving = self.leaving(product, state);
                    if leaving.len() != 1 {
                        return Ok(());
                    }
                    world.progress[product] = Progress::Performing {
                        transition: leaving[0],
                        steps: 0,
                    };
                }
            }
        }
    }

    /// Returns the transitions that leave a state of a product's recipe.
    fn leaving(&self, product: usize, state: usize) -> Vec<usize> {
        let recipe = self.recipe(product);
        let all = recipe.transitions.iter().enumerate();
        let leaving = all.filter(|(_, t)| t.from == recipe.states[state]);
        leaving.map(|(n, _)| n).collect()
    }

    /// Checks what remains of a finished product.
    fn finish(&self, at: usize, world: &mut World, product: usize) -> Result<(), PlanFault> {
        let recipe = self.recipe(product);
        for held in world.parts.iter_mut().flatten() {
            if held.owner != PartOwner::Product(product) {
                continue;
            }
            let kind = recipe
                .parts
                .iter()
                .find(|p| p.name == held.name)
                .map(|p| &p.kind);
            let allowed = |name: &String| recipe.leftover.contains(name);
            if !allowed(&held.name) && !kind.is_some_and(allowed) {
                return Err(PlanFault::LeftOver {
                    position: at,
                    product,
                    part: held.name.clone(),
                });
            }
            held.owner = PartOwner::LeftOver(self.plan.products[product]);
        }
        Ok(())
    }

    /// Replays a schedule. Adds the cost of each way through it, with the position that follows if
    /// the count goes on there.
    fn follow(
        &self,
        at: usize,
        mut world: World,
        schedule: &Schedule,
        spent: i64,
        paths: &mut Vec<(i64, Option<usize>)>,
    ) -> Result<(), PlanFault> {
        let mut spent = spent;
        let mut entries = schedule.entries.as_slice();
        while let Some(first) = entries.first() {
            let same = entries
                .iter()
                .take_while(|e| e.event == first.event)
                .count();
            let (event, rest) = entries.split_at(same);
            entries = rest;
            spent += self
                .event(&mut world, event)
                .map_err(|reason| PlanFault::Event {
                    position: at,
                    event: first.event,
                    reason,
                })?;
            if let EntrySubject::Operation { product, .. } = first.subject {
                self.arrive(at, &mut world, product)?;
            }
        }
        let is_time = matches!(self.plan.objective, Objective::Steps | Objective::Time);
        match &schedule.then {
            Next::End { time } => {
                let ended = |p: &Progress| *p == Progress::Ended;
                if !world.progress.iter().all(ended) || !self.is_rest(&world, *time) {
                    return Err(PlanFault::End(at));
                }
                paths.push((if is_time { *time } else { spent }, None));
            }
            Next::Goto {
                time,
                position,
                closes_loop,
            } => {
                if !self.is_rest(&world, *time) {
                    return Err(PlanFault::End(at));
                }
                if *position >= self.plan.positions.len() {
                    return Err(PlanFault::Malformed(at));
                }
                let same = self.arrives(&world, *position, *closes_loop);
                same.ok_or(PlanFault::Target(at))?;
                let cost = if is_time { *time } else { spent };
                paths.push((cost, (!closes_loop).then_some(*position)));
            }
            Next::Test {
                time,
                product,
                outcomes,
            } => {
                let fault = PlanFault::Test {
                    position: at,
                    product: *product,
                };
                let Some(leaving) = self.is_testable(&world, *product, *time) else {
                    return Err(fault);
                };
                if !outcomes.iter().map(|o| o.0).eq(leaving) {
                    return Err(fault);
                }
                world.floor = *time;
                for (transition, rest) in outcomes {
                    let mut world = world.clone();
                    world.ready[*product] = *time;
                    world.progress[*product] = Progress::Performing {
                        transition: *transition,
                        steps: 0,
                    };
                    self.arrive(at, &mut world, *product)?;
                    self.follow(at, world, rest, spent, paths)?;
                }
            }
        }
        Ok(())
    }

    /// Returns whether the time is that at which all resources are at rest.
    fn is_rest(&self, world: &World, time: i64) -> bool {
        let last = world.free.iter().chain(&world.ready).max();
        let resources = self
            .layout
            .resources
            .iter()
            .zip(&world.states)
            .zip(&world.free);
        let mut resources = resources.map(|((r, s), free)| (r.may_wait(s), *free));
        time == world.floor.max(last.copied().unwrap_or(0))
            && resources.all(|(may_wait, free)| may_wait || free == time)
    }

    /// Returns whether a position is what is the case.
    fn arrives(&self, world: &World, target: usize, closes_loop: bool) -> Option<()> {
        let mut world = world.clone();
        let mut wanted = self.world(target).ok()?;
        let mut closed = 0;
        for product in 0..world.progress.len() {
            if !world.closed[product] {
                continue;
            }
            let before = self.plan.positions[target].progress[product];
            if let Progress::Performing { transition, .. } = world.progress[product]
                && let Progress::At(state) = before
            {
                let recipe = self.recipe(product);
                let to = &recipe.transitions[transition].to;
                (recipe.states.get(state) == Some(to)).then_some(())?;
                world.closed[product] = false;
                world.progress[product] = before;
                self.arrive(target, &mut world, product).ok()?;
                closed += 1;
            }
        }
        for held in world.parts.iter_mut().chain(&mut wanted.parts) {
            held.sort();
        }
        let is_same = world.states == wanted.states
            && world.parts == wanted.parts
            && world.progress == wanted.progress
            && world.closed == wanted.closed;
        (is_same && closes_loop == (closed > 0)).then_some(())
    }

    /// Returns the transitions that can follow a test, if it is possible.
    fn is_testable(&self, world: &World, product: usize, time: i64) -> Option<Vec<usize>> {
        let Progress::At(state) = *world.progress.get(product)? else {
            return None;
        };
        (time >= world.ready[product] && time >= world.floor).then_some(())?;
        let leaving = self.leaving(product, state);
        for transition in &leaving {
            let recipe = self.recipe(product);
            let Guard::Test { inputs, at, .. } = &recipe.transitions[*transition].guard else {
                continue;
            };
            let able = |name: &String| {
                let resource = self.layout.resources.iter().position(|r| r.name == *name);
                resource.is_some_and(|r| {
                    world.free[r] <= time && self.take(world, r, product, inputs).is_some()
                })
            };
            (at.is_empty() || at.iter().any(able)).then_some(())?;
        }
        // In lockstep, all resources are at rest between two vectors.
        let rests = |free: &i64| *free <= time;
        let lockstep = self.plan.execution() == Execution::Lockstep;
        (!lockstep || world.free.iter().all(rests)).then_some(leaving)
    }

    /// Returns the parts of a resource without the inputs of an operation.
    fn take(
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
    fn event(&self, world: &mut World, entries: &[Entry]) -> Result<i64, EventFault> {
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
                return Err(EventFault::Duration(name()));
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
