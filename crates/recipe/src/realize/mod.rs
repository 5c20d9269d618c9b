//! Whether a recipe can be made on a layout: a search that does not need the topology.
//!
//! The idea is that of `CheckManuf` and `ProcessCompositeOp` in the paper (its Algorithms 2 and 3),
//! but not their code: what they leave open or get wrong is decided as follows.
//!
//! - A search node is a transition of the recipe, the number of its steps performed, the states of
//!   all resources and the parts. The paper marks resource states and parts only, so that a step
//!   fails where the one before it has been.
//! - Loops (rework) are a greatest fixpoint with retraction. In the paper they always fail.
//! - A state of the recipe that is reached in two configurations has two positions.
//! - If a resource holds several parts, each is tried; an empty resource cannot give; capacities
//!   are respected; parts that remain at an end have to be allowed.
//! - A test costs no vector. It changes nothing, whatever its outcome.
//! - Parts with the same name are interchangeable.
//!
//! The search explores forward, breadth first, and evaluates backward each time that the graph has
//! doubled. It stops as soon as nothing unexplored can be better; with loops, when all is explored.
//! A depth-first AND-OR search might need fewer nodes for a verdict, but not to prove that a number
//! of vectors is the least.

pub mod cell;
mod evaluate;
mod explore;
mod extract;
mod flow;
pub(crate) mod moves;
mod obstacles;
mod ways;

use crate::controller::Controller;
use crate::model::{Layout, Problem, Recipe};
use cell::Cell;
use evaluate::{NEVER, evaluate};
use explore::Graph;
use extract::extract;
use moves::{Moves, Stride};
pub(crate) use obstacles::obstacles;
use rustc_hash::FxHashSet;

pub use obstacles::Obstacle;

/// Maximum number of decisions for each vector that may be tried. Most vectors need a few; only
/// resources that may not wait, and that compete for a partner, make it many.
const DECISIONS_PER_VECTOR: usize = 64;
/// Part of the limits that trying whole vectors may use at first, where one event at a time could
/// do.
const FIRST_SHARE: usize = 64;

/// Limits of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchLimits {
    /// Maximum number of search nodes. Each takes some hundred bytes.
    pub nodes: usize,
    /// Maximum number of vectors tried.
    pub vectors: usize,
}

impl Default for SearchLimits {
    fn default() -> Self {
        Self {
            nodes: 2_000_000,
            vectors: 40_000_000,
        }
    }
}

/// Answer to the question whether a recipe can be made on a layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// It can, like this.
    Realizable(Controller),
    /// It cannot.
    Unrealizable(Refusal),
    /// The search reached its limits. The recipe may or may not be realizable.
    GaveUp(SearchSize),
}

/// Why a recipe cannot be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// Causes that are found without a search. If there are any, there was no search.
    pub obstacles: Vec<Obstacle>,
    /// The most steps that could be performed of each transition of the recipe, whatever happens
    /// afterward; `None` if the recipe cannot get to it. Empty if this is not known.
    pub furthest_steps: Vec<Option<usize>>,
    /// Size of the search. It was complete, which proves the answer.
    pub size: SearchSize,
}

/// Size of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SearchSize {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of vectors tried.
    pub vectors: usize,
}

/// Decides whether a recipe can be made on a layout, and how with the least number of vectors in
/// the worst case over the outcomes of the tests.
///
/// Whole vectors are tried. If every resource may wait in every state, vectors with one event are
/// sufficient for the verdict; where the search outgrows a part of the limits, they are tried
/// first. A controller that they give has more vectors than necessary
/// ([`is_least`](Controller::is_least) is false); it is the result only if the search with whole
/// vectors reaches the limits without an answer.
///
/// The result is the same each time. Time and memory are proportional to the size of the search,
/// which is exponential in the number of parts, and at worst in the number of resources.
///
/// # Errors
/// All problems of the layout and the recipe, if any of them is more than a warning.
pub fn realize(
    layout: &Layout,
    recipe: &Recipe,
    limits: SearchLimits,
) -> Result<Outcome, Vec<Problem>> {
    let problems = problems(layout, recipe);
    if problems.iter().any(|p| !p.is_warning()) {
        return Err(problems);
    }
    let obstacles = obstacles(layout, recipe);
    if !obstacles.is_empty() {
        return Ok(Outcome::Unrealizable(Refusal {
            obstacles,
            furthest_steps: vec![None; recipe.transitions.len()],
            size: SearchSize::default(),
        }));
    }
    let cell = Cell::new(layout, recipe);
    if cell.all_may_wait() {
        let share = SearchLimits {
            nodes: limits.nodes / FIRST_SHARE,
            vectors: limits.vectors / FIRST_SHARE,
        };
        let first = search(&cell, Stride::Vectors, Goal::Least, share);
        if !stopped(&first) {
            return Ok(first);
        }
        let verdict = search(&cell, Stride::Events, Goal::Verdict, limits);
        if let Outcome::Unrealizable(_) = verdict {
            return Ok(verdict);
        }
    }
    let outcome = search(&cell, Stride::Vectors, Goal::Least, limits);
    Ok(match outcome {
        Outcome::GaveUp(_) if cell.all_may_wait() => {
            search(&cell, Stride::Events, Goal::Least, limits)
        }
        outcome => outcome,
    })
}

/// Decides whether a recipe can be made on a layout; `None` if the search reaches its limits. This
/// needs less time than [`realize`], which also finds the least number of vectors.
///
/// # Errors
/// All problems of the layout and the recipe, if any of them is more than a warning.
pub fn is_realizable(
    layout: &Layout,
    recipe: &Recipe,
    limits: SearchLimits,
) -> Result<Option<bool>, Vec<Problem>> {
    let problems = problems(layout, recipe);
    if problems.iter().any(|p| !p.is_warning()) {
        return Err(problems);
    }
    Ok(decide(layout, recipe, limits))
}

/// Returns whether a search has reached its limits.
fn stopped(outcome: &Outcome) -> bool {
    match outcome {
        Outcome::Realizable(controller) => !controller.is_least,
        Outcome::Unrealizable(_) => false,
        Outcome::GaveUp(_) => true,
    }
}

/// Returns all problems of a layout and a recipe.
pub(crate) fn problems(layout: &Layout, recipe: &Recipe) -> Vec<Problem> {
    let mut problems = layout.problems();
    problems.extend(recipe.problems());
    problems.extend(recipe.problems_on(layout));
    problems
}

/// Decides whether a recipe can be made, if the limits permit. Layout and recipe must not have
/// problems other than warnings.
pub(crate) fn decide(layout: &Layout, recipe: &Recipe, limits: SearchLimits) -> Option<bool> {
    if !obstacles(layout, recipe).is_empty() {
        return Some(false);
    }
    let cell = Cell::new(layout, recipe);
    match search(&cell, verdict_stride(&cell), Goal::Verdict, limits) {
        Outcome::Realizable(_) => Some(true),
        Outcome::Unrealizable(_) => Some(false),
        Outcome::GaveUp(_) => None,
    }
}

/// Where resources could do more than they can.
pub(crate) struct Reached<'r> {
    /// Resources and their states where they hold a part.
    pub holding: FxHashSet<(usize, usize)>,
    /// Resources and their states where they hold the inputs of an operation that is asked for.
    pub asked: FxHashSet<(usize, usize, &'r str)>,
}

/// Explores all that can happen, and collects where resources hold parts; `None` if this reaches
/// the limits. Layout and recipe must not have problems other than warnings.
pub(crate) fn reached<'r>(
    layout: &Layout,
    recipe: &'r Recipe,
    limits: SearchLimits,
) -> Option<Reached<'r>> {
    let cell = Cell::new(layout, recipe);
    let mut graph = Graph::new(&cell);
    let mut moves = Moves::new(&cell, verdict_stride(&cell));
    moves.effort = limits.vectors.saturating_mul(DECISIONS_PER_VECTOR);
    if graph.explore(&mut moves, usize::MAX, limits) {
        return None;
    }
    let mut reached = Reached {
        holding: FxHashSet::default(),
        asked: FxHashSet::default(),
    };
    for node in 0..graph.len() as u32 {
        let (states, held) = graph.configuration(node).split_at(cell.resources());
        for pair in held.chunks_exact(2) {
            let state = states[pair[0] as usize];
            reached.holding.insert((pair[0] as usize, state as usize));
        }
        if graph.place_of(node).is_some() {
            continue;
        }
        let (number, step) = graph.task_of(node);
        let Some(calls) = cell.works[number].steps.get(step) else {
            continue;
        };
        let operations = &recipe.transitions[number].steps[step].operations;
        for (call, operation) in calls.iter().zip(operations) {
            for (resource, state) in states.iter().enumerate() {
                if cell.holds(resource as u16, &call.inputs, held) {
                    let asked = (resource, *state as usize, operation.name.as_str());
                    reached.asked.insert(asked);
                }
            }
        }
    }
    Some(reached)
}

/// Returns the vectors that suffice for a verdict.
fn verdict_stride(cell: &Cell) -> Stride {
    if cell.all_may_wait() {
        Stride::Events
    } else {
        Stride::Vectors
    }
}

/// What a search is for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Goal {
    /// A controller with the least number of vectors.
    Least,
    /// The verdict; the first controller that is found will do.
    Verdict,
}

fn search(cell: &Cell, stride: Stride, goal: Goal, limits: SearchLimits) -> Outcome {
    let mut graph = Graph::new(cell);
    let mut moves = Moves::new(cell, stride);
    moves.effort = limits.vectors.saturating_mul(DECISIONS_PER_VECTOR);
    let has_loops = cell.works.iter().any(|w| w.closes_loop);
    let mut until = 512;
    loop {
        let stopped = graph.explore(&mut moves, until, limits);
        let is_complete = graph.is_complete();
        let size = SearchSize {
            nodes: graph.len(),
            vectors: graph.vectors,
        };
        let evaluation = evaluate(&graph);
        let cost = evaluation.cost.first().copied().unwrap_or(NEVER);
        if cost != NEVER {
            let is_proved = is_complete || (!has_loops && cost <= graph.least_unexplored());
            if is_proved || stopped || goal == Goal::Verdict {
                let is_least = is_proved && stride == Stride::Vectors;
                moves.effort = usize::MAX;
                let controller = extract(&graph, &evaluation, &mut moves, is_least);
                return Outcome::Realizable(controller);
            }
        } else if is_complete {
            return Outcome::Unrealizable(Refusal {
                obstacles: Vec::new(),
                furthest_steps: graph.furthest_steps,
                size,
            });
        }
        if stopped {
            return Outcome::GaveUp(size);
        }
        until = 2 * graph.len();
    }
}
