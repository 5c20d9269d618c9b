//! Branch and bound over pairs of tasks on the same machine.
//!
//! A node decides which of two tasks comes first, as in Carlier and Pinson (1989). Before that,
//! both orders of each open pair are tried; one that is refuted by propagation decides the pair, as
//! in J. Carlier and E. Pinson, "Adjustment of heads and tails for the job-shop problem", EJOR 78
//! (1994), 146-161. The node then branches on the pair whose orders narrow the domain most, so that
//! a proof needs few nodes. Depth first: memory is proportional to the depth.

use super::propagate::{Domain, Propagator};
use super::{Instance, Solution};

/// A node that is still to be examined.
struct Node {
    domain: Domain,
    /// Decided pairs.
    decided: Vec<(u32, u32)>,
}

/// Improves a solution until it is proved optimal, or the limit of nodes is reached.
pub(super) fn improve(instance: &Instance, best: &mut Solution, max_nodes: usize) {
    let mut propagator = Propagator::new(instance);
    let mut stack = vec![Node {
        domain: propagator.initial(best.makespan - 1),
        decided: Vec::new(),
    }];
    while let Some(mut node) = stack.pop() {
        if best.nodes == max_nodes {
            return;
        }
        best.nodes += 1;
        let limit = best.makespan - 1;
        for (latest, task) in node.domain.latest.iter_mut().zip(&instance.tasks) {
            *latest = (*latest).min(limit - task.tail);
        }
        let Some(branches) = probe(&mut propagator, &mut node) else {
            continue;
        };
        let Some((first, second)) = branches else {
            // All pairs are in order, so each task can begin as early as possible.
            let start = node.domain.earliest.clone();
            let ends = start.iter().zip(&instance.tasks);
            let makespan = ends.map(|(s, t)| s + t.duration + t.tail).max();
            best.makespan = makespan.unwrap_or(0);
            best.start = start;
            if best.makespan <= best.lower_bound {
                return;
            }
            // Pairs that are in order by chance may leave something better.
            stack.push(node);
            continue;
        };
        stack.push(second);
        stack.push(first);
    }
    best.lower_bound = best.makespan;
}

/// Narrows a node by trying both orders of each open pair. Returns the two nodes that follow, or
/// nothing within if all pairs are in order; `None` if there is no schedule.
#[expect(clippy::option_option, reason = "no schedule, and no open pair")]
fn probe(propagator: &mut Propagator<'_>, node: &mut Node) -> Option<Option<(Node, Node)>> {
    if !propagator.narrow(&mut node.domain, &node.decided) {
        return None;
    }
    let width = |domain: &Domain| -> i64 {
        let all = domain.latest.iter().zip(&domain.earliest);
        all.map(|(l, e)| l - e).sum()
    };
    loop {
        let mut refuted = false;
        let mut best: Option<(i64, i64, Node, Node)> = None;
        for (a, b) in open_pairs(propagator, &node.domain) {
            if is_ordered(propagator.instance, &node.domain, a, b) {
                continue;
            }
            let mut attempt = |pair: (u32, u32)| {
                let mut tried = Node {
                    domain: node.domain.clone(),
                    decided: node.decided.clone(),
                };
                tried.decided.push(pair);
                let fits = propagator.narrow(&mut tried.domain, &tried.decided);
                fits.then_some(tried)
            };
            let (a, b) = (a as u32, b as u32);
            match (attempt((a, b)), attempt((b, a))) {
                (None, None) => return None,
                (Some(only), None) | (None, Some(only)) => {
                    *node = only;
                    refuted = true;
                }
                (Some(forth), Some(back)) => {
                    let (wide, narrow) = (width(&forth.domain), width(&back.domain));
                    let score = (wide.max(narrow), wide.min(narrow));
                    if best.as_ref().is_none_or(|b| score < (b.0, b.1)) {
                        // The order with more room is tried first.
                        let (first, second) = if wide >= narrow {
                            (forth, back)
                        } else {
                            (back, forth)
                        };
                        best = Some((score.0, score.1, first, second));
                    }
                }
            }
        }
        if !refuted {
            return Some(best.map(|(_, _, first, second)| (first, second)));
        }
    }
}

/// Returns whether two tasks are in order, whichever comes first.
fn is_ordered(instance: &Instance, domain: &Domain, a: usize, b: usize) -> bool {
    let precedes = |first: usize, second: usize| {
        let (first_task, second_task) = (&instance.tasks[first], &instance.tasks[second]);
        domain.earliest[first] + first_task.duration <= domain.earliest[second]
            && domain.latest[first] <= domain.latest[second] - second_task.duration
    };
    precedes(a, b) || precedes(b, a)
}

/// Returns the pairs of tasks on the same machine that are not in order.
fn open_pairs(propagator: &Propagator<'_>, domain: &Domain) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for tasks in &propagator.tasks {
        for (at, a) in tasks.iter().enumerate() {
            let open = |b: &&usize| !is_ordered(propagator.instance, domain, *a, **b);
            pairs.extend(tasks[at + 1..].iter().filter(open).map(|b| (*a, *b)));
        }
    }
    pairs
}
