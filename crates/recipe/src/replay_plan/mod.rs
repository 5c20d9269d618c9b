//! Verifies a plan: replays each of its schedules from the layout and the recipes.
//!
//! The search and this module share the model and the types of a plan, but no code that interprets
//! them: this module works with names and lists, one event after the other. It applies the rules
//! that are written in [`crate::plan`].

mod event;
mod fault;

pub use fault::{EventFault, PlanFault};

use crate::model::{Demand, Guard, Layout, Recipe, demand_problems};
use crate::plan::{
    EntrySubject, Execution, HeldPart, Next, Objective, PartOwner, Plan, PlanPosition, Progress,
    Schedule,
};

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
}
