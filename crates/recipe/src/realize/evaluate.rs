//! Which nodes of the graph are realizable, and at what cost.
//!
//! Realizable places are a greatest fixpoint: loops of the recipe may be repeated for ever, but
//! each of its transitions takes finitely many vectors.
//!
//! ```text
//! ν P. μ T.  task in T   <=>  an edge leads to a task in T, or to a place in P
//!            place in P  <=>  it is an end, or all its edges lead to T or P
//! ```
//!
//! P is assumed only where a transition of the recipe closes a loop; without such transitions the
//! recipe has no loops. The places that turn out not to be realizable are retracted, and the rest
//! is evaluated again. Costs come from the same pass, which visits nodes in ascending order of
//! cost (Knuth, "A generalization of Dijkstra's algorithm", 1977): the cost of a task is the least
//! over its edges, that of a place the greatest. A transition that closes a loop ends the count.

use super::explore::{DEAD, Graph};

/// Cost of a node that is not realizable.
pub(super) const NEVER: u32 = u32::MAX;

/// Result of the evaluation.
pub(super) struct Evaluation {
    /// Number of vectors from each node in the worst case, or [`NEVER`].
    pub cost: Vec<u32>,
    /// Realizable nodes in ascending order of cost; what a cost depends on comes before it.
    pub order: Vec<u32>,
    /// Whether a place is realizable, if a transition that closes a loop leads to it.
    pub assumed: Vec<bool>,
}

/// An edge that closes a loop of the recipe.
struct Closing {
    from: u32,
    place: u32,
    /// 1 for a vector, 0 otherwise.
    cost: u32,
}

/// Edges by their target.
struct Reverse {
    begin: Vec<usize>,
    /// Sources, doubled; plus one if the edge costs a vector.
    sources: Vec<u32>,
    closing: Vec<Closing>,
}

impl Reverse {
    fn new(graph: &Graph<'_>) -> Self {
        let nodes = graph.len();
        let mut closing = Vec::new();
        let mut begin = vec![0_usize; nodes + 1];
        for_each_edge(graph, |_, to, _, closes| {
            if !closes {
                begin[to as usize + 1] += 1;
            }
        });
        for node in 0..nodes {
            begin[node + 1] += begin[node];
        }
        let mut free = begin.clone();
        let mut sources = vec![0; begin[nodes]];
        for_each_edge(graph, |from, to, cost, closes| {
            if closes {
                closing.push(Closing {
                    from,
                    place: to,
                    cost,
                });
            } else {
                sources[free[to as usize]] = 2 * from + cost;
                free[to as usize] += 1;
            }
        });
        Self {
            begin,
            sources,
            closing,
        }
    }
}

/// Calls `visit` with source, target and cost of each edge, and whether it closes a loop.
fn for_each_edge(graph: &Graph<'_>, mut visit: impl FnMut(u32, u32, u32, bool)) {
    let works = &graph.cell.works;
    for node in 0..graph.len() as u32 {
        if let Some(state) = graph.place_of(node) {
            let leaving = &graph.cell.recipe_states[state as usize].leaving;
            for ((to, _), work) in graph.edges(node).zip(leaving) {
                if to != DEAD {
                    let closes = works[*work as usize].closes_loop && graph.place_of(to).is_some();
                    visit(node, to, 0, closes);
                }
            }
            continue;
        }
        let closes_loop = works[graph.task_of(node).0].closes_loop;
        for (to, _) in graph.edges(node) {
            visit(node, to, 1, closes_loop && graph.place_of(to).is_some());
        }
        let stop = graph.stops[node as usize];
        if stop != DEAD {
            visit(node, stop, 0, closes_loop);
        }
    }
}

/// Evaluates the explored part of the graph; what is not explored counts as not realizable.
///
/// Takes time proportional to the number of edges for each round of retractions.
pub(super) fn evaluate(graph: &Graph<'_>) -> Evaluation {
    let reverse = Reverse::new(graph);
    let mut assumed = vec![false; graph.len()];
    for edge in &reverse.closing {
        assumed[edge.place as usize] = true;
    }
    loop {
        let (cost, order) = pass(graph, &reverse, &assumed);
        let mut retracted = false;
        for edge in &reverse.closing {
            let place = edge.place as usize;
            if assumed[place] && cost[place] == NEVER {
                assumed[place] = false;
                retracted = true;
            }
        }
        if !retracted {
            return Evaluation {
                cost,
                order,
                assumed,
            };
        }
    }
}

/// Computes costs under the assumption that some places are realizable.
fn pass(graph: &Graph<'_>, reverse: &Reverse, assumed: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let nodes = graph.len();
    let mut cost = vec![NEVER; nodes];
    let mut order: Vec<u32> = Vec::new();
    let mut next: Vec<u32> = Vec::new();
    // Edges of each place whose targets have no cost yet; for a task, this is not used.
    let mut missing = vec![0_u32; nodes];
    for node in 0..nodes as u32 {
        let Some(state) = graph.place_of(node) else {
            continue;
        };
        missing[node as usize] = graph.edges(node).len() as u32;
        if graph.cell.recipe_states[state as usize].is_end {
            cost[node as usize] = 0;
            order.push(node);
        }
    }
    let mut visit =
        |from: u32, dearer: bool, at: u32, order: &mut Vec<u32>, next: &mut Vec<u32>| {
            let index = from as usize;
            if graph.place_of(from).is_some() {
                missing[index] -= 1;
                if missing[index] == 0 {
                    cost[index] = at;
                    order.push(from);
                }
            } else if dearer {
                if cost[index] == NEVER {
                    next.push(from);
                }
            } else if cost[index] == NEVER {
                cost[index] = at;
                order.push(from);
            }
        };
    for edge in reverse.closing.iter().filter(|e| assumed[e.place as usize]) {
        visit(edge.from, edge.cost > 0, 0, &mut order, &mut next);
    }
    let (mut done, mut at) = (0, 0);
    loop {
        while let Some(node) = order.get(done).copied() {
            done += 1;
            let sources = reverse.begin[node as usize]..reverse.begin[node as usize + 1];
            for source in &reverse.sources[sources] {
                visit(source / 2, source % 2 > 0, at, &mut order, &mut next);
            }
        }
        at += 1;
        for node in std::mem::take(&mut next) {
            visit(node, false, at, &mut order, &mut next);
        }
        if done == order.len() {
            return (cost, order);
        }
    }
}
