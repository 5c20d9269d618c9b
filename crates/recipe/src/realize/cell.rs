//! A layout and a recipe in numbers, as the search uses them.

use crate::model::{Action, Guard, Layout, OperationCall, Recipe};
use rustc_hash::FxHashMap;

/// A transition of a resource, from a known state.
#[derive(Debug, Clone, Copy)]
pub struct Taken {
    /// Index of the resource.
    pub resource: u16,
    /// Index of the transition.
    pub transition: u16,
    /// The state that it enters.
    pub to: u16,
}

/// An operation of a step. Parts are kinds; see [`Cell::kinds`].
#[derive(Debug)]
pub struct Call {
    /// What can perform it: the state that is left, and the transition.
    pub performers: Vec<(u16, Taken)>,
    /// The parts that it takes.
    pub inputs: Vec<u16>,
    /// The parts that it leaves.
    pub outputs: Vec<u16>,
}

/// A transition of the recipe.
pub struct Work {
    /// Its steps, each with the operations that are performed together.
    pub steps: Vec<Vec<Call>>,
    /// The state of the recipe that it enters.
    pub to: u16,
    /// Whether it closes a loop of the recipe.
    pub closes_loop: bool,
}

/// A state of the recipe.
#[derive(Default)]
pub struct RecipeState {
    /// Transitions that leave it.
    pub leaving: Vec<u16>,
    /// Whether the recipe ends here.
    pub is_end: bool,
    /// Tests that need their inputs at one of some resources.
    pub tests: Vec<(Vec<u16>, Vec<u16>)>,
    /// Minimum number of steps from here to an end or to the end of a loop, in the worst case.
    pub steps_to_go: u32,
}

/// What a resource can do in one of its states, apart from operations.
#[derive(Default)]
pub struct StateTable {
    /// Whether it may wait.
    pub may_wait: bool,
    /// Internal operations.
    pub internal: Vec<Taken>,
    /// Labels under which it gives a part.
    pub gives: Vec<(u16, Taken)>,
    /// Labels under which it takes a part.
    pub takes: Vec<(u16, Taken)>,
}

/// A layout and a recipe in numbers.
pub struct Cell {
    /// Names of parts: those of the recipe, then types of stock that no part has as a name.
    pub kinds: Vec<String>,
    /// For each part of the recipe, the stock that can replace it.
    pub stock: Vec<Option<u16>>,
    /// Whether each kind may remain at an end.
    pub may_remain: Vec<bool>,
    /// Number of parts for which each resource has room.
    pub capacity: Vec<usize>,
    /// Tables by resource and state.
    pub states: Vec<Vec<StateTable>>,
    /// Resources with internal operations.
    pub with_internal: Vec<u16>,
    /// Resources with states where they may not wait.
    pub restless: Vec<u16>,
    /// Resources that take parts under each label.
    pub receivers: Vec<Vec<u16>>,
    /// The transitions of the recipe.
    pub works: Vec<Work>,
    /// The states of the recipe.
    pub recipe_states: Vec<RecipeState>,
    /// The state at the start of the recipe.
    pub start: u16,
    /// States of the resources at the start, then pairs of a resource and the kind of a part that
    /// it holds, sorted.
    pub configuration: Vec<u16>,
}

impl Cell {
    /// Translates a layout and a recipe that have no problems other than warnings.
    pub fn new(layout: &Layout, recipe: &Recipe) -> Self {
        let mut kinds: Vec<String> = recipe.parts.iter().map(|p| p.name.clone()).collect();
        let mut configuration: Vec<u16> = (layout.resources.iter())
            .map(|r| r.state(&r.initial).unwrap_or(0) as u16)
            .collect();
        for (at, resource) in layout.resources.iter().enumerate() {
            let mut held = Vec::new();
            for name in &resource.holds {
                let kind = kinds.iter().position(|k| k == name).unwrap_or_else(|| {
                    kinds.push(name.clone());
                    kinds.len() - 1
                });
                held.push(kind as u16);
            }
            held.sort_unstable();
            configuration.extend(held.iter().flat_map(|kind| [at as u16, *kind]));
        }
        let parts = recipe.parts.len();
        let stock = (recipe.parts.iter())
            .map(|p| kinds[parts..].iter().position(|k| *k == p.kind))
            .map(|found| found.map(|at| (at + parts) as u16))
            .collect();
        let allowed = |name: &String| recipe.leftover.contains(name);
        let may_remain = (kinds.iter().enumerate())
            .map(|(at, name)| at >= parts || allowed(name) || allowed(&recipe.parts[at].kind))
            .collect();
        let mut cell = Self {
            kinds,
            stock,
            may_remain,
            capacity: layout.resources.iter().map(|r| r.capacity).collect(),
            states: Vec::new(),
            with_internal: Vec::new(),
            restless: Vec::new(),
            receivers: Vec::new(),
            works: Vec::new(),
            recipe_states: Vec::new(),
            start: recipe.state(&recipe.start).unwrap_or(0) as u16,
            configuration,
        };
        let performers = cell.add_resources(layout);
        cell.add_recipe(layout, recipe, &performers);
        cell
    }

    /// Fills the tables of the resources. Returns what can perform each operation.
    fn add_resources<'a>(&mut self, layout: &'a Layout) -> FxHashMap<&'a str, Vec<(u16, Taken)>> {
        let mut labels: FxHashMap<&str, usize> = FxHashMap::default();
        let mut performers: FxHashMap<&str, Vec<(u16, Taken)>> = FxHashMap::default();
        for (at, resource) in layout.resources.iter().enumerate() {
            let mut tables: Vec<StateTable> = (resource.states.iter())
                .map(|s| StateTable {
                    may_wait: s.may_wait,
                    ..StateTable::default()
                })
                .collect();
            for (number, transition) in resource.transitions.iter().enumerate() {
                let from = resource.state(&transition.from).unwrap_or(0);
                let taken = Taken {
                    resource: at as u16,
                    transition: number as u16,
                    to: resource.state(&transition.to).unwrap_or(0) as u16,
                };
                let mut label = |name| {
                    let free = labels.len();
                    let label = *labels.entry(name).or_insert(free);
                    self.receivers.resize(labels.len(), Vec::new());
                    label
                };
                match &transition.action {
                    Action::Operation(name) => {
                        performers
                            .entry(name)
                            .or_default()
                            .push((from as u16, taken));
                    }
                    Action::Internal(_) => tables[from].internal.push(taken),
                    Action::In(name) => {
                        let label = label(name.as_str());
                        tables[from].takes.push((label as u16, taken));
                        if !self.receivers[label].contains(&(at as u16)) {
                            self.receivers[label].push(at as u16);
                        }
                    }
                    Action::Out(name) => {
                        let label = label(name.as_str());
                        tables[from].gives.push((label as u16, taken));
                    }
                }
            }
            if tables.iter().any(|t| !t.internal.is_empty()) {
                self.with_internal.push(at as u16);
            }
            if tables.iter().any(|t| !t.may_wait) {
                self.restless.push(at as u16);
            }
            self.states.push(tables);
        }
        performers
    }

    fn add_recipe(
        &mut self,
        layout: &Layout,
        recipe: &Recipe,
        performers: &FxHashMap<&str, Vec<(u16, Taken)>>,
    ) {
        let parts = |names: &[String]| -> Vec<u16> {
            names
                .iter()
                .filter_map(|n| recipe.part(n))
                .map(|p| p as u16)
                .collect()
        };
        let call = |c: &OperationCall| Call {
            performers: performers.get(c.name.as_str()).cloned().unwrap_or_default(),
            inputs: parts(&c.inputs),
            outputs: parts(&c.outputs),
        };
        self.recipe_states = (recipe.states.iter())
            .map(|s| RecipeState {
                is_end: recipe.ends.contains(s),
                ..RecipeState::default()
            })
            .collect();
        let closes_loop = recipe.closes_loop();
        for (number, transition) in recipe.transitions.iter().enumerate() {
            let steps = transition.steps.iter();
            self.works.push(Work {
                steps: steps
                    .map(|s| s.operations.iter().map(call).collect())
                    .collect(),
                to: recipe.state(&transition.to).unwrap_or(0) as u16,
                closes_loop: closes_loop[number],
            });
            let from = recipe.state(&transition.from).unwrap_or(0);
            self.recipe_states[from].leaving.push(number as u16);
            if let Guard::Test { inputs, at, .. } = &transition.guard
                && !at.is_empty()
            {
                let at = at
                    .iter()
                    .filter_map(|r| layout.resource(r))
                    .map(|r| r as u16);
                self.recipe_states[from]
                    .tests
                    .push((parts(inputs), at.collect()));
            }
        }
        // Without the transitions that close loops, each round settles at least one state more.
        let mut changed = true;
        while std::mem::take(&mut changed) {
            for state in (0..self.recipe_states.len()).rev() {
                let leaving = self.recipe_states[state].leaving.iter();
                let to_go = leaving.map(|w| {
                    let work = &self.works[*w as usize];
                    work.steps.len() as u32 + self.steps_after(work)
                });
                let to_go = to_go.max().unwrap_or(0);
                changed |= to_go != self.recipe_states[state].steps_to_go;
                self.recipe_states[state].steps_to_go = to_go;
            }
        }
    }

    /// Returns the minimum number of steps after a transition of the recipe.
    pub fn steps_after(&self, work: &Work) -> u32 {
        if work.closes_loop {
            0
        } else {
            self.recipe_states[work.to as usize].steps_to_go
        }
    }

    /// Returns the number of resources.
    pub fn resources(&self) -> usize {
        self.capacity.len()
    }

    /// Returns whether every resource may wait in every state.
    pub fn all_may_wait(&self) -> bool {
        self.restless.is_empty()
    }

    /// Returns the kind of part that stands for a part of the recipe: the part itself if it is
    /// anywhere in the cell, or else stock of its type.
    pub fn resolve(&self, part: u16, held: &[u16]) -> u16 {
        let exists = || held.chunks_exact(2).any(|pair| pair[1] == part);
        match self.stock[part as usize] {
            Some(stock) if !exists() => stock,
            _ => part,
        }
    }

    /// Returns whether a resource holds all these parts of the recipe.
    pub fn holds(&self, resource: u16, parts: &[u16], held: &[u16]) -> bool {
        let kinds: Vec<u16> = parts.iter().map(|p| self.resolve(*p, held)).collect();
        kinds.iter().all(|kind| {
            let needed = kinds.iter().filter(|k| *k == kind).count();
            let pairs = held.chunks_exact(2);
            pairs.filter(|p| p[0] == resource && p[1] == *kind).count() >= needed
        })
    }
}
