//! Verifies a controller: replays each of its vectors from the layout and the recipe.
//!
//! The search and this module share the model and the type of a controller, but no code that
//! interprets them: this module works with names and lists, one vector after the other.

use crate::controller::{Controller, Leg, Position, Subject, Vector};
use crate::model::{Action, Guard, Layout, Recipe, Step};
use rustc_hash::FxHashMap;

/// What is wrong with a controller.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The layout or the recipe has problems other than warnings, so it has no meaning.
    #[error("the layout or the recipe has problems")]
    Problems,
    /// There is no position.
    #[error("the controller has no positions")]
    Empty,
    /// An index is too large, or a list has the wrong length.
    #[error("position {position}: {what} does not exist")]
    Malformed {
        /// Index of the position.
        position: usize,
        /// What the index is one of.
        what: &'static str,
    },
    /// The first position is not the start of the recipe in the layout's initial state.
    #[error("the first position is not the start")]
    Start,
    /// The legs of a position are not the transitions that leave its state.
    #[error("position {0}: the legs are not the transitions that leave the state")]
    Legs(usize),
    /// A part remains at an end that may not.
    #[error("position {position}: part `{part}` remains at the end")]
    LeftOver {
        /// Index of the position.
        position: usize,
        /// Name of the part.
        part: String,
    },
    /// The inputs of a test are not at a resource that can perform it.
    #[error("position {position}: the parts of the test of transition {transition} are elsewhere")]
    Untestable {
        /// Index of the position.
        position: usize,
        /// Index of the transition of the recipe.
        transition: usize,
    },
    /// A vector is not possible.
    #[error("position {position}, transition {transition}, vector {vector}: {reason}")]
    Vector {
        /// Index of the position where the leg begins.
        position: usize,
        /// Index of the transition of the recipe.
        transition: usize,
        /// Number of the vector in the leg.
        vector: usize,
        /// Why not.
        reason: VectorFault,
    },
    /// A leg does not perform all steps.
    #[error("position {position}, transition {transition}: {performed} of {steps} steps performed")]
    Unfinished {
        /// Index of the position where the leg begins.
        position: usize,
        /// Index of the transition of the recipe.
        transition: usize,
        /// Number of steps performed.
        performed: usize,
        /// Number of steps of the transition.
        steps: usize,
    },
    /// A leg leads to a position with another state, other resource states, or other parts.
    #[error("position {position}, transition {transition}: the leg does not lead to its target")]
    Target {
        /// Index of the position where the leg begins.
        position: usize,
        /// Index of the transition of the recipe.
        transition: usize,
    },
    /// The number of vectors in the worst case is wrong.
    #[error("the worst case takes {actual} vectors instead of {claimed}")]
    WorstCase {
        /// Number that the controller claims.
        claimed: u32,
        /// Number of its vectors.
        actual: u32,
    },
}

/// Why a vector is not possible.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum VectorFault {
    /// A resource or transition does not exist.
    #[error("a move does not exist")]
    NoSuchMove,
    /// A resource makes two moves, or the moves are not ordered by resource.
    #[error("the moves are not ordered by resource")]
    Order,
    /// A resource is not in the state that its transition leaves.
    #[error("resource `{0}` is in another state")]
    State(String),
    /// A resource waits where it may not.
    #[error("resource `{0}` may not wait")]
    Waits(String),
    /// A move's subject does not belong to its transition.
    #[error("resource `{0}` does something else")]
    Subject(String),
    /// A transfer does not have exactly one partner, or its partner transfers another part.
    #[error("the transfer `{0}` has no partner")]
    Partner(String),
    /// A resource does not hold a part that it gives or needs.
    #[error("resource `{resource}` does not hold part `{part}`")]
    NoPart {
        /// Name of the resource.
        resource: String,
        /// Name of the part.
        part: String,
    },
    /// A resource would hold too many parts.
    #[error("resource `{0}` has no room")]
    NoRoom(String),
    /// The operations are not those of the step.
    #[error("the operations are not those of the next step")]
    Step,
}

/// States and parts of all resources.
#[derive(Clone, PartialEq)]
struct Cell {
    states: Vec<String>,
    parts: Vec<Vec<String>>,
}

/// Replays a controller. Returns the first fault that it finds, in the order of the positions.
///
/// Takes time proportional to the size of the controller and of the layout.
pub fn verify(layout: &Layout, recipe: &Recipe, controller: &Controller) -> Result<(), Fault> {
    let problems = [
        layout.problems(),
        recipe.problems(),
        recipe.problems_on(layout),
    ];
    if problems.iter().flatten().any(|p| !p.is_warning()) {
        return Err(Fault::Problems);
    }
    let mut leaving: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
    for (number, transition) in recipe.transitions.iter().enumerate() {
        leaving.entry(&transition.from).or_default().push(number);
    }
    let replay = Replay {
        layout,
        recipe,
        leaving,
    };
    let cells: Vec<Cell> = (controller.positions.iter().enumerate())
        .map(|(at, position)| replay.cell(at, position))
        .collect::<Result<_, _>>()?;
    let Some(first) = cells.first() else {
        return Err(Fault::Empty);
    };
    let start = &recipe.states[controller.positions[0].recipe_state];
    if *first != replay.initial() || *start != recipe.start {
        return Err(Fault::Start);
    }
    for (at, position) in controller.positions.iter().enumerate() {
        replay.check_position(at, position, &cells[at])?;
        for leg in &position.legs {
            let end = replay.check_leg(at, leg, &cells[at])?;
            let target = controller.positions.get(leg.to).ok_or(Fault::Malformed {
                position: at,
                what: "the target of a leg",
            })?;
            let state = &recipe.states[target.recipe_state];
            if end != cells[leg.to] || *state != recipe.transitions[leg.transition].to {
                return Err(Fault::Target {
                    position: at,
                    transition: leg.transition,
                });
            }
        }
    }
    let actual = worst_case(recipe, controller);
    if actual != controller.worst_case {
        return Err(Fault::WorstCase {
            claimed: controller.worst_case,
            actual,
        });
    }
    Ok(())
}

/// What a controller is replayed on.
struct Replay<'a> {
    layout: &'a Layout,
    recipe: &'a Recipe,
    /// Transitions of the recipe by the state that they leave.
    leaving: FxHashMap<&'a str, Vec<usize>>,
}

impl Replay<'_> {
    fn initial(&self) -> Cell {
        let resources = &self.layout.resources;
        Cell {
            states: resources.iter().map(|r| r.initial.clone()).collect(),
            parts: resources.iter().map(|r| sorted(r.holds.clone())).collect(),
        }
    }

    /// Returns the cell of a position, by names.
    fn cell(&self, at: usize, position: &Position) -> Result<Cell, Fault> {
        let malformed = |what| Fault::Malformed { position: at, what };
        if position.recipe_state >= self.recipe.states.len() {
            return Err(malformed("the state of the recipe"));
        }
        let resources = &self.layout.resources;
        if position.resource_states.len() != resources.len()
            || position.parts.len() != resources.len()
        {
            return Err(malformed("a resource"));
        }
        let states = (resources.iter().zip(&position.resource_states))
            .map(|(r, s)| r.states.get(*s).map(|s| s.name.clone()))
            .collect::<Option<_>>();
        Ok(Cell {
            states: states.ok_or_else(|| malformed("the state of a resource"))?,
            parts: position.parts.clone(),
        })
    }

    fn check_position(&self, at: usize, position: &Position, cell: &Cell) -> Result<(), Fault> {
        let state = &self.recipe.states[position.recipe_state];
        let leaving = self
            .leaving
            .get(state.as_str())
            .cloned()
            .unwrap_or_default();
        if !position
            .legs
            .iter()
            .map(|l| l.transition)
            .eq(leaving.iter().copied())
        {
            return Err(Fault::Legs(at));
        }
        for transition in leaving {
            let Guard::Test {
                inputs,
                at: testers,
                ..
            } = &self.recipe.transitions[transition].guard
            else {
                continue;
            };
            let able = |tester: &String| {
                let resource = self.layout.resources.iter().position(|r| r.name == *tester);
                resource.is_some_and(|r| self.take(cell, r, inputs).is_ok())
            };
            if !testers.is_empty() && !testers.iter().any(able) {
                return Err(Fault::Untestable {
                    position: at,
                    transition,
                });
            }
        }
        if self.recipe.ends.contains(state) {
            for name in cell.parts.iter().flatten() {
                let part = self.recipe.parts.iter().find(|p| p.name == *name);
                let leftover = &self.recipe.leftover;
                if part.is_some_and(|p| !leftover.contains(&p.name) && !leftover.contains(&p.kind))
                {
                    return Err(Fault::LeftOver {
                        position: at,
                        part: name.clone(),
                    });
                }
            }
        }
        Ok(())
    }

    /// Replays the vectors of a leg. Returns the cell after them.
    fn check_leg(&self, at: usize, leg: &Leg, start: &Cell) -> Result<Cell, Fault> {
        let steps = &self.recipe.transitions[leg.transition].steps;
        let (mut cell, mut performed) = (start.clone(), 0);
        for (number, vector) in leg.vectors.iter().enumerate() {
            let fault = |reason| Fault::Vector {
                position: at,
                transition: leg.transition,
                vector: number,
                reason,
            };
            let next = steps.get(performed);
            let (after, performs) = self.apply(&cell, vector, next).map_err(fault)?;
            cell = after;
            performed += usize::from(performs);
        }
        if performed != steps.len() {
            return Err(Fault::Unfinished {
                position: at,
                transition: leg.transition,
                performed,
                steps: steps.len(),
            });
        }
        Ok(cell)
    }

    /// Applies a vector. Returns the cell after it, and whether it performs the step.
    fn apply(
        &self,
        cell: &Cell,
        vector: &Vector,
        step: Option<&Step>,
    ) -> Result<(Cell, bool), VectorFault> {
        let resources = &self.layout.resources;
        if !vector.moves.is_sorted_by(|a, b| a.resource < b.resource) {
            return Err(VectorFault::Order);
        }
        let mut after = cell.clone();
        let mut waits = vec![true; resources.len()];
        let mut performed = Vec::new();
        let mut given: Vec<(&str, &str)> = Vec::new();
        let mut taken: Vec<(&str, &str)> = Vec::new();
        for m in &vector.moves {
            let resource = resources.get(m.resource).ok_or(VectorFault::NoSuchMove)?;
            let transition = resource.transitions.get(m.transition);
            let transition = transition.ok_or(VectorFault::NoSuchMove)?;
            if transition.from != cell.states[m.resource] {
                return Err(VectorFault::State(resource.name.clone()));
            }
            waits[m.resource] = false;
            transition.to.clone_into(&mut after.states[m.resource]);
            let held = &mut after.parts[m.resource];
            match (&transition.action, &m.subject) {
                (Action::Internal(_), Subject::Internal) => {}
                (Action::In(label), Subject::Part(part)) => {
                    held.push(part.clone());
                    taken.push((label, part));
                }
                (Action::Out(label), Subject::Part(part)) => {
                    remove(held, part).ok_or_else(|| VectorFault::NoPart {
                        resource: resource.name.clone(),
                        part: part.clone(),
                    })?;
                    given.push((label, part));
                }
                (Action::Operation(name), Subject::Operation(call)) => {
                    let operation = step.and_then(|s| s.operations.get(*call));
                    let operation = operation.filter(|o| o.name == *name);
                    let operation = operation.ok_or(VectorFault::Step)?;
                    *held = self.take(cell, m.resource, &operation.inputs)?;
                    held.extend(operation.outputs.iter().cloned());
                    performed.push(*call);
                }
                _ => return Err(VectorFault::Subject(resource.name.clone())),
            }
            if held.len() > resource.capacity {
                return Err(VectorFault::NoRoom(resource.name.clone()));
            }
        }
        for (at, resource) in resources.iter().enumerate().filter(|(at, _)| waits[*at]) {
            let state = resource.states.iter().find(|s| s.name == cell.states[at]);
            if !state.is_some_and(|s| s.may_wait) {
                return Err(VectorFault::Waits(resource.name.clone()));
            }
        }
        for (label, part) in given.iter().chain(&taken) {
            let partners = |list: &[(&str, &str)]| list.iter().filter(|t| t.0 == *label).count();
            let same = given.contains(&(label, part)) && taken.contains(&(label, part));
            if !same || partners(&given) != 1 || partners(&taken) != 1 {
                return Err(VectorFault::Partner((*label).to_owned()));
            }
        }
        performed.sort_unstable();
        let calls = step.map_or(0, |s| s.operations.len());
        if !performed.is_empty() && !performed.iter().copied().eq(0..calls) {
            return Err(VectorFault::Step);
        }
        for parts in &mut after.parts {
            parts.sort_unstable();
        }
        Ok((after, !performed.is_empty()))
    }

    /// Returns the parts of a resource without the inputs of an operation. While a part is nowhere
    /// in the cell, stock of its type replaces it.
    fn take(
        &self,
        cell: &Cell,
        resource: usize,
        inputs: &[String],
    ) -> Result<Vec<String>, VectorFault> {
        let mut held = cell.parts[resource].clone();
        for input in inputs {
            let is_somewhere = cell.parts.iter().flatten().any(|p| p == input);
            let part = self.recipe.parts.iter().find(|p| p.name == *input);
            // A type that is also the name of a part is that part, not stock.
            let stock = part.map(|p| &p.kind).filter(|kind| {
                !is_somewhere && !self.recipe.parts.iter().any(|p| p.name == **kind)
            });
            let wanted = stock.unwrap_or(input);
            remove(&mut held, wanted).ok_or_else(|| VectorFault::NoPart {
                resource: self.layout.resources[resource].name.clone(),
                part: input.clone(),
            })?;
        }
        Ok(held)
    }
}

/// Removes one part.
fn remove(parts: &mut Vec<String>, part: &str) -> Option<()> {
    let at = parts.iter().position(|p| p == part)?;
    parts.remove(at);
    Some(())
}

fn sorted(mut parts: Vec<String>) -> Vec<String> {
    parts.sort_unstable();
    parts
}

/// Returns the greatest number of vectors until an end or a transition that closes a loop.
fn worst_case(recipe: &Recipe, controller: &Controller) -> u32 {
    let closes_loop = recipe.closes_loop();
    let mut longest = vec![0_u32; controller.positions.len()];
    // Without the legs that close loops, a path visits each state of the recipe at most once, so
    // the lengths settle.
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for at in (0..longest.len()).rev() {
            let legs = controller.positions[at].legs.iter();
            let each = legs.map(|leg| {
                let rest = if closes_loop[leg.transition] {
                    0
                } else {
                    longest[leg.to]
                };
                leg.vectors.len() as u32 + rest
            });
            let most = each.max().unwrap_or(0);
            changed |= most != longest[at];
            longest[at] = most;
        }
    }
    longest.first().copied().unwrap_or(0)
}
