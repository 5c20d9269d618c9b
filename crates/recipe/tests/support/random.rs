//! Random small cells.

use linewright_recipe::model::{
    Action, Guard, Layout, OperationCall, Part, Recipe, RecipeTransition, Resource, State, Step,
    Transition,
};

/// Random numbers: splitmix64 (Steele, Lea, Flood, 2014).
pub struct Random(pub u64);

impl Random {
    /// Returns a number below `bound`.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % bound as u64) as usize
    }

    /// Returns true with a probability in percent.
    pub fn percent(&mut self, probability: usize) -> bool {
        self.below(100) < probability
    }

    /// Returns one of some names.
    fn name(&mut self, names: &[&str]) -> String {
        names[self.below(names.len())].to_owned()
    }

    /// Returns up to `most` names.
    fn names(&mut self, names: &[&str], most: usize) -> Vec<String> {
        (0..self.below(most + 1))
            .map(|_| self.name(names))
            .collect()
    }
}

const OPERATIONS: [&str; 3] = ["mill", "drill", "join"];
const PARTS: [&str; 3] = ["a", "b", "c"];
/// `b` is the name of a part, too.
const TYPES: [&str; 3] = ["A", "B", "b"];

/// Returns a layout of two to five resources.
fn layout(random: &mut Random) -> Layout {
    let labels = &["1", "2", "3"][..=random.below(3)];
    // In some cells every resource may wait everywhere.
    let waits = [100, 90, 75][random.below(3)];
    let resources = (0..2 + random.below(4))
        .map(|at| {
            let states: Vec<State> = (0..=random.below(3))
                .map(|s| State {
                    name: format!("s{s}"),
                    may_wait: random.percent(waits),
                })
                .collect();
            let capacity = 1 + random.below(2);
            let mut transitions = Vec::new();
            for from in 0..states.len() {
                for _ in 0..=random.below(3) {
                    let action = match random.below(10) {
                        0..4 => Action::Operation(random.name(&OPERATIONS)),
                        4 => Action::Internal("turn".to_owned()),
                        5..7 => Action::In(random.name(labels)),
                        _ => Action::Out(random.name(labels)),
                    };
                    let to = random.below(states.len());
                    transitions.push(Transition {
                        from: format!("s{from}"),
                        to: format!("s{to}"),
                        action,
                        seconds: None,
                        watts: None,
                    });
                }
            }
            let most = if random.percent(25) { capacity } else { 0 };
            Resource {
                name: format!("r{at}"),
                initial: "s0".to_owned(),
                holds: random.names(&["a", "b", "A", "B"], most),
                states,
                capacity,
                transitions,
            }
        })
        .collect();
    Layout {
        name: "Random".to_owned(),
        resources,
    }
}

/// Returns a recipe of two to four states.
fn recipe(random: &mut Random, layout: &Layout) -> Recipe {
    let states = 2 + random.below(3);
    let names: Vec<String> = (0..states).map(|s| format!("q{s}")).collect();
    let mut transitions = Vec::new();
    for from in 0..states - 1 {
        // The parts that seem to be there make the recipe sensible more often.
        let branches = if random.percent(40) {
            2 + random.below(2)
        } else {
            1
        };
        for branch in 0..branches {
            let to = if branch == 0 {
                from + 1
            } else {
                random.below(states)
            };
            let guard = if branches == 1 {
                Guard::Always
            } else if branch + 1 == branches {
                Guard::Otherwise
            } else {
                let mut at = Vec::new();
                if random.percent(40) {
                    let one = random.below(layout.resources.len());
                    at.push(layout.resources[one].name.clone());
                    at.push("r0".to_owned());
                }
                Guard::Test {
                    name: "good".to_owned(),
                    inputs: random.names(&PARTS, 1),
                    at,
                }
            };
            let least = usize::from(to <= from);
            let steps = (0..random.below(3).max(least))
                .map(|_| {
                    let parallel = if random.percent(15) { 2 } else { 1 };
                    let calls = (0..parallel).map(|_| OperationCall {
                        name: random.name(&OPERATIONS),
                        inputs: random.names(&PARTS, 2),
                        outputs: random.names(&PARTS, 2),
                    });
                    Step::new(calls.collect())
                })
                .collect();
            transitions.push(RecipeTransition {
                from: names[from].clone(),
                to: names[to].clone(),
                guard,
                steps,
            });
        }
    }
    let parts = PARTS
        .map(|name| Part::new(name, &random.name(&TYPES)))
        .to_vec();
    let mut leftover: Vec<String> = Vec::new();
    for part in PARTS {
        if random.percent(70) {
            leftover.push(part.to_owned());
        }
    }
    Recipe {
        name: "Random".to_owned(),
        parts,
        start: names[0].clone(),
        ends: vec![names[states - 1].clone()],
        states: names,
        leftover,
        transitions,
    }
}

/// State and parts of each resource.
type Cell = Vec<(String, Vec<String>)>;

/// Takes random transitions, regardless of where resources may wait, and returns up to `wanted`
/// operations as steps.
fn walk(
    random: &mut Random,
    layout: &Layout,
    parts: &[Part],
    cell: &mut Cell,
    wanted: usize,
) -> Vec<Step> {
    let mut steps = Vec::new();
    for _ in 0..120 {
        if steps.len() == wanted {
            break;
        }
        let at = random.below(cell.len());
        let resource = &layout.resources[at];
        let own: Vec<&Transition> = (resource.transitions.iter())
            .filter(|t| t.from == cell[at].0)
            .collect();
        if own.is_empty() {
            continue;
        }
        let transition = own[random.below(own.len())];
        match &transition.action {
            Action::In(_) => continue,
            Action::Internal(_) => {}
            Action::Out(label) => {
                let takes = |n: usize| {
                    let transitions = layout.resources[n].transitions.iter();
                    transitions
                        .filter(|t| t.action == Action::In(label.clone()))
                        .find(|t| {
                            n != at
                                && t.from == cell[n].0
                                && cell[n].1.len() < layout.resources[n].capacity
                        })
                };
                let takers: Vec<_> = (0..cell.len())
                    .filter_map(|n| Some((n, takes(n)?)))
                    .collect();
                if takers.is_empty() || cell[at].1.is_empty() {
                    continue;
                }
                let (taker, taken) = takers[random.below(takers.len())];
                let which = random.below(cell[at].1.len());
                let part = cell[at].1.remove(which);
                cell[taker].1.push(part);
                cell[taker].0.clone_from(&taken.to);
            }
            Action::Operation(name) => {
                let (mut inputs, mut rest) = (Vec::new(), Vec::new());
                for held in &cell[at].1 {
                    let named = parts.iter().find(|p| p.name == *held || p.kind == *held);
                    match named {
                        Some(part) if random.percent(70) => inputs.push(part.name.clone()),
                        _ => rest.push(held.clone()),
                    }
                }
                let outputs = if random.percent(50) && !inputs.is_empty() {
                    inputs.clone()
                } else {
                    random.names(&PARTS, resource.capacity - rest.len())
                };
                cell[at].1 = rest;
                cell[at].1.extend(outputs.iter().cloned());
                steps.push(Step::new(vec![OperationCall {
                    name: name.clone(),
                    inputs,
                    outputs,
                }]));
            }
        }
        cell[at].0.clone_from(&transition.to);
    }
    steps
}

/// Returns a recipe that a random walk makes, at least if all may wait and all tests end well.
fn walked_recipe(random: &mut Random, layout: &Layout) -> Recipe {
    let mut recipe = recipe(random, layout);
    let mut cell: Cell = (layout.resources.iter())
        .map(|r| (r.initial.clone(), r.holds.clone()))
        .collect();
    let mut cells = vec![cell.clone()];
    for state in 0..recipe.states.len() - 1 {
        let name = recipe.states[state].clone();
        for at in 0..recipe.transitions.len() {
            if recipe.transitions[at].from != name {
                continue;
            }
            let to = recipe.transitions[at].to.clone();
            let is_next = to == recipe.states[state + 1] && cells.len() == state + 1;
            let mut branch = cells[state].clone();
            let wanted = random
                .below(4)
                .max(usize::from(recipe.state(&to) <= Some(state)));
            let steps = walk(random, layout, &recipe.parts, &mut branch, wanted);
            if steps.len() == wanted {
                recipe.transitions[at].steps = steps;
            }
            if is_next {
                cell = branch;
                cells.push(cell.clone());
            }
        }
    }
    if random.percent(80) {
        recipe.leftover = PARTS.map(str::to_owned).to_vec();
    }
    recipe
}

/// Returns a random cell.
pub fn cell(seed: u64) -> (Layout, Recipe) {
    let mut random = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let layout = layout(&mut random);
    let recipe = if random.percent(20) {
        recipe(&mut random, &layout)
    } else {
        walked_recipe(&mut random, &layout)
    };
    (layout, recipe)
}

/// Returns a second recipe for a random layout.
pub fn second_recipe(seed: u64, layout: &Layout) -> Recipe {
    let mut random = Random(seed.wrapping_mul(0x9fb2_1c65_1e98_df25));
    walked_recipe(&mut random, layout)
}

/// Gives the transitions of a layout durations of up to three seconds and powers. Those that give a
/// part take no time if `quick` is true.
pub fn set_times(seed: u64, layout: &mut Layout, quick: bool) {
    let mut random = Random(seed.wrapping_mul(0xd6e8_feb8_6659_fd93));
    for transition in layout.resources.iter_mut().flat_map(|r| &mut r.transitions) {
        let seconds = random.below(4) as f64;
        let gives = matches!(transition.action, Action::Out(_));
        transition.seconds = (!gives || !quick).then_some(seconds);
        transition.watts = Some(random.below(3) as f64 * 100.0);
    }
}
