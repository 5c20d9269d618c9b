//! Derives a variable order from the structure of a specification. In this order, variables that
//! occur in the same formulas lie near each other.
//!
//! The method is FORCE (Aloul, Markov and Sakallah, "FORCE: a fast and easy-to-implement
//! variable-ordering heuristic", GLSVLSI 2003). Every formula, or every conjunct of a conjunction,
//! is a hyperedge. In every round, each hyperedge pulls its variables toward their center of
//! gravity, until the sum of all spans no longer shrinks. The result is only a starting point for
//! sifting.
//!
//! A formula about whole arrays does not show which elements belong together, but its comparisons
//! do. If `built[i]` is compared with `target[i]` for every `i`, but the order does not place each
//! `built[i]` next to its `target[i]`, the diagram of the formula becomes large. A game with many
//! bits can be encoded only in a good order. So above [`MANY_PAIRS`], comparisons of numbers are
//! hyperedges, too.

use crate::symbolic::{Bit, Encoding, MAX_PAIRS, Order};
use linewright_core::gr1::{BinaryOp, Expr, Side, Specification, Time, VarId};

/// Maximum number of rounds; spans hardly shrink after the first few.
const MAX_ROUNDS: usize = 30;

/// With more bit pairs than this, each comparison of numbers is a hyperedge of its own, and
/// formulas are restricted to bit codes that stand for a value of the domain.
pub const MANY_PAIRS: usize = 48;

/// Orders the variables by the structure of the specification, and returns the resulting order of
/// all `pairs` bit pairs. The pairs of a variable are adjacent. Pairs that belong to no variable
/// come last.
pub fn order(specification: &Specification, encoding: &Encoding, pairs: usize) -> Order {
    if pairs > MAX_PAIRS {
        return Order::natural(pairs);
    }
    let sides = [&specification.assumptions, &specification.guarantees];
    let formulas = sides.into_iter().flat_map(Side::all);
    let parts: Vec<&Expr> = formulas.flat_map(|f| f.expr.conjuncts()).collect();
    let numeric = |v: &usize| specification.variables[*v].domain.size() > 2;
    let mut edges: Vec<Vec<usize>> = Vec::new();
    if pairs > MANY_PAIRS {
        let compared = parts.iter().flat_map(|part| comparisons(part));
        edges.extend(compared.map(variables).filter(|e| e.iter().all(numeric)));
    }
    edges.extend(parts.into_iter().map(variables));
    edges.retain(|e| e.len() > 1);

    let mut best = order_of_mention(&edges, specification.variables.len());
    let mut best_span = span(&edges, &best);
    let mut current = best.clone();
    for _ in 0..MAX_ROUNDS {
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
    Order::new(order).expect("the order is not a permutation of the pairs; please report this")
}

/// Returns the comparisons in a formula, from left to right.
fn comparisons(formula: &Expr) -> Vec<&Expr> {
    let mut found = Vec::new();
    let mut left = vec![formula];
    while let Some(expr) = left.pop() {
        match expr {
            Expr::Const(_) | Expr::Var(..) => {}
            Expr::Unary(_, a) => left.push(a),
            Expr::If(c, a, b) => left.extend([&**b, &**a, &**c]),
            Expr::Binary(op, a, b) => {
                if is_comparison(*op) {
                    found.push(expr);
                }
                left.extend([&**b, &**a]);
            }
        }
    }
    found
}

fn is_comparison(op: BinaryOp) -> bool {
    use BinaryOp::{Eq, Ge, Gt, Le, Lt, Ne};
    matches!(op, Eq | Ne | Lt | Le | Gt | Ge)
}

/// Returns the indices of a formula's variables, ascending, without repetition.
fn variables(formula: &Expr) -> Vec<usize> {
    let mut found = Vec::new();
    formula.for_each_var(&mut |v, _| found.push(v.index()));
    found.sort_unstable();
    found.dedup();
    found
}

/// Returns the variables in the order in which the hyperedges mention them, followed by the
/// variables that no hyperedge mentions.
fn order_of_mention(edges: &[Vec<usize>], variables: usize) -> Vec<usize> {
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

/// Returns the sum of the distances between the first and the last variable of each hyperedge.
fn span(edges: &[Vec<usize>], order: &[usize]) -> usize {
    let positions = positions(order);
    let spans = edges.iter().map(|edge| {
        let places = || edge.iter().map(|v| positions[*v]);
        places().max().unwrap_or(0) - places().min().unwrap_or(0)
    });
    spans.sum()
}

/// Runs one round: moves every variable to the mean of the centers of its hyperedges.
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
    // The sort is stable: variables pulled to the same place keep their order.
    pulled.sort_by(|a, b| a.0.total_cmp(&b.0));
    pulled.into_iter().map(|(_, v)| v).collect()
}
