//! The controller of a realizable start: fewest vectors first, then fewest events.

use super::evaluate::{Evaluation, NEVER};
use super::explore::{DEAD, Graph};
use super::moves::{Event, Moves};
use crate::controller::{Controller, Leg, Move, Position, Subject, Vector};
use rustc_hash::FxHashMap;

/// What a task does next.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Choice {
    /// Nothing: its transition of the recipe is complete.
    Stop,
    /// Takes a vector with this number of events to this node.
    Vector(u32, u8),
}

/// Chooses for each task a vector of least cost. Among these, it chooses one with the fewest events
/// from here on, and among these the first.
fn choose(graph: &Graph<'_>, evaluation: &Evaluation) -> Vec<Choice> {
    let mut events = vec![0_u32; graph.len()];
    let mut choices = vec![Choice::Stop; graph.len()];
    for node in &evaluation.order {
        let index = *node as usize;
        let at = evaluation.cost[index];
        // Cost and events of a target; those that close a loop end the count.
        let value = |to: u32, closes_loop: bool| {
            if closes_loop && graph.place_of(to).is_some() {
                let cost = if evaluation.assumed[to as usize] {
                    0
                } else {
                    NEVER
                };
                (cost, 0)
            } else {
                (evaluation.cost[to as usize], events[to as usize])
            }
        };
        if let Some(state) = graph.place_of(*node) {
            let leaving = &graph.cell.recipe_states[state as usize].leaving;
            let closes = |work: &u16| graph.cell.works[*work as usize].closes_loop;
            let each = graph.edges(*node).zip(leaving);
            let most = each.map(|((to, _), work)| value(to, closes(work)).1).max();
            events[index] = most.unwrap_or(0);
            continue;
        }
        let closes_loop = graph.cell.works[graph.task_of(*node).0].closes_loop;
        let mut best: Option<(u32, Choice)> = None;
        let mut offer = |count: u32, choice| {
            if best.is_none_or(|(least, _)| count < least) {
                best = Some((count, choice));
            }
        };
        let stop = graph.stops[index];
        if stop != DEAD {
            let (cost, count) = value(stop, closes_loop);
            if cost == at {
                offer(count, Choice::Stop);
            }
        }
        for (to, weight) in graph.edges(*node) {
            let (cost, count) = value(to, closes_loop);
            if cost != NEVER && cost + 1 == at {
                offer(count + u32::from(weight), Choice::Vector(to, weight));
            }
        }
        if let Some((count, choice)) = best {
            (events[index], choices[index]) = (count, choice);
        }
    }
    choices
}

/// Builds the controller. The start has to be realizable.
pub(super) fn extract(
    graph: &Graph<'_>,
    evaluation: &Evaluation,
    moves: &mut Moves<'_>,
    is_least: bool,
) -> Controller {
    let choices = choose(graph, evaluation);
    let mut numbers: FxHashMap<u32, usize> = FxHashMap::from_iter([(0, 0)]);
    let mut places = vec![0];
    let mut positions: Vec<Position> = Vec::new();
    while let Some(place) = places.get(positions.len()).copied() {
        let state = graph.place_of(place).unwrap_or(0);
        let leaving = &graph.cell.recipe_states[state as usize].leaving;
        let mut legs = Vec::new();
        for ((child, _), work) in graph.edges(place).zip(leaving) {
            let (vectors, to) = follow(graph, &choices, moves, child);
            let number = *numbers.entry(to).or_insert_with(|| {
                places.push(to);
                places.len() - 1
            });
            legs.push(Leg {
                transition: *work as usize,
                vectors,
                to: number,
            });
        }
        let (resource_states, parts) = describe(graph, place);
        positions.push(Position {
            recipe_state: state as usize,
            resource_states,
            parts,
            legs,
        });
    }
    Controller {
        positions,
        worst_case: evaluation.cost[0],
        is_least,
    }
}

/// Returns the vectors from a child of a place to the next place.
fn follow(
    graph: &Graph<'_>,
    choices: &[Choice],
    moves: &mut Moves<'_>,
    child: u32,
) -> (Vec<Vector>, u32) {
    let (mut node, mut vectors) = (child, Vec::new());
    while graph.place_of(node).is_none() {
        let Choice::Vector(to, weight) = choices[node as usize] else {
            return (vectors, graph.stops[node as usize]);
        };
        vectors.push(find_vector(graph, moves, node, to, weight));
        node = to;
    }
    (vectors, node)
}

/// Enumerates the vectors of a task again to find the one that leads to a node.
fn find_vector(graph: &Graph<'_>, moves: &mut Moves<'_>, node: u32, to: u32, weight: u8) -> Vector {
    let (number, step) = graph.task_of(node);
    let step_of = graph.cell.works[number].steps.get(step).map(Vec::as_slice);
    let target = graph.configuration(to);
    // A place follows the last step; a task that differs from this one, another step.
    let advances = match graph.place_of(to) {
        Some(_) => true,
        None => graph.task_of(to).1 > step,
    };
    let mut found = Vec::new();
    moves.each(
        graph.configuration(node),
        step_of,
        &mut |vector, configuration, performs| {
            let fits = configuration == target
                && performs == advances
                && vector.len().min(255) as u8 == weight;
            if fits {
                found = vector.to_vec();
            }
            !fits
        },
    );
    let mut taken = Vec::new();
    for event in found {
        let subject = match event {
            Event::Operation { call, .. } => Subject::Operation(call as usize),
            Event::Internal(_) => Subject::Internal,
            Event::Transfer { kind, .. } => Subject::Part(graph.cell.kinds[kind as usize].clone()),
        };
        taken.extend(event.taken().map(|t| Move {
            resource: t.resource as usize,
            transition: t.transition as usize,
            subject: subject.clone(),
        }));
    }
    taken.sort_by_key(|m| m.resource);
    Vector { moves: taken }
}

/// Returns the states and the parts of all resources.
fn describe(graph: &Graph<'_>, node: u32) -> (Vec<usize>, Vec<Vec<String>>) {
    let resources = graph.cell.resources();
    let (states, held) = graph.configuration(node).split_at(resources);
    let mut parts = vec![Vec::new(); resources];
    for pair in held.chunks_exact(2) {
        parts[pair[0] as usize].push(graph.cell.kinds[pair[1] as usize].clone());
    }
    for held in &mut parts {
        held.sort_unstable();
    }
    (states.iter().map(|s| *s as usize).collect(), parts)
}
