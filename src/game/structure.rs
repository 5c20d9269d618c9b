//! An order of the variables from the structure of a specification: those that occur together lie near each other.
//!
//! FORCE (Aloul, Markov and Sakallah, "FORCE: a fast and easy-to-implement variable-ordering heuristic", GLSVLSI 2003):
//! formulas are hyperedges; every formula pulls its variables towards its centre of gravity, until the sum of all spans
//! no longer shrinks. A small span is a start for sifting, not an order to rely on.

use crate::gr1::{Formula, Side, Specification, Time, VarId};
use crate::symbolic::{Bit, Encoding, Order};

/// Rounds of pulling; spans hardly shrink after the first few.
const MOST_ROUNDS: usize = 30;

/// The pairs of bits by variable, the variables ordered by structure; pairs that belong to no variable come last.
pub fn order(specification: &Specification, encoding: &Encoding, pairs: usize) -> Order {
    let sides = [&specification.assumptions, &specification.guarantees];
    let formulas = sides.into_iter().flat_map(Side::all);
    let edges: Vec<Vec<usize>> = formulas.map(variables).filter(|e| e.len() > 1).collect();

    let mut best = first_seen(&edges, specification.variables.len());
    let mut best_span = span(&edges, &best);
    let mut current = best.clone();
    for _ in 0..MOST_ROUNDS {
        current = pull(&edges, &current);
        let current_span = span(&edges, &current);
        if current_span >= best_span {
            break;
        }
        (best, best_span) = (current.clone(), current_span);
    }

    let mut order = Vec::with_capacity(pairs);
    for variable in best {
        let bits = encoding.bits(VarId(variable as u32), Time::Now);
        order.extend(bits.map(Bit::pair));
    }
    order.extend(encoding.pairs() as u16..pairs as u16);
    Order::new(order).expect("every variable has its place; please report this")
}

/// The variables of a formula, each once.
fn variables(formula: &Formula) -> Vec<usize> {
    let mut found = Vec::new();
    formula.expr.for_each_var(&mut |v, _| found.push(v.index()));
    found.sort_unstable();
    found.dedup();
    found
}

/// The variables as the formulas mention them, and then the others.
fn first_seen(edges: &[Vec<usize>], variables: usize) -> Vec<usize> {
    let mut order = Vec::new();
    let mut seen = vec![false; variables];
    for variable in edges.iter().flatten().copied().chain(0..variables) {
        if !std::mem::replace(&mut seen[variable], true) {
            order.push(variable);
        }
    }
    order
}

fn positions(order: &[usize]) -> Vec<usize> {
    let mut positions = vec![0; order.len()];
    for (position, variable) in order.iter().enumerate() {
        positions[*variable] = position;
    }
    positions
}

/// The sum of the distances between the first and the last variable of each formula.
fn span(edges: &[Vec<usize>], order: &[usize]) -> usize {
    let positions = positions(order);
    let spans = edges.iter().map(|edge| {
        let places = || edge.iter().map(|v| positions[*v]);
        places().max().unwrap_or(0) - places().min().unwrap_or(0)
    });
    spans.sum()
}

/// One round: every variable goes to the mean of the centres of its formulas.
fn pull(edges: &[Vec<usize>], order: &[usize]) -> Vec<usize> {
    let positions = positions(order);
    let mut sums = vec![(0.0, 0usize); order.len()];
    for edge in edges {
        let total: usize = edge.iter().map(|v| positions[*v]).sum();
        let centre = total as f64 / edge.len() as f64;
        for variable in edge {
            sums[*variable].0 += centre;
            sums[*variable].1 += 1;
        }
    }
    let mut pulled: Vec<(f64, usize)> = order
        .iter()
        .map(|v| match sums[*v] {
            (_, 0) => (positions[*v] as f64, *v),
            (sum, count) => (sum / count as f64, *v),
        })
        .collect();
    // The sort is stable: what is pulled to the same place keeps its order.
    pulled.sort_by(|a, b| a.0.total_cmp(&b.0));
    pulled.into_iter().map(|(_, v)| v).collect()
}
