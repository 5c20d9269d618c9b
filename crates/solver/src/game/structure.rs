//! Derives a variable order from the structure of a specification. In this order, variables that
//! occur in the same formulas lie near each other.
//!
//! The method is FORCE (Aloul, Markov and Sakallah, "FORCE: a fast and easy-to-implement
//! variable-ordering heuristic", GLSVLSI 2003). Every formula, or every conjunct of a conjunction,
//! is a hyperedge. In every round, each hyperedge pulls its variables toward their center of
//! gravity, until the sum of all spans no longer shrinks. The result is only a starting point for
//! sifting.
//!
//! An order and its reverse have the same spans, but not the same diagrams. An element of an array
//! that is selected by an index needs the index above the array: otherwise, the diagram has to
//! remember every element. Without such formulas, large games are solved up to eight times as fast
//! if the outputs are nearer to the top (the laboratory's cell, AMBA and genbuf). Sets of reachable
//! states are not: those of the cell's composition take twelve times as long. Nor is listing the
//! states of a small machine: with the outputs of the guide's press at the top, it takes minutes
//! instead of a quarter of a second. See [`Orientation`].
//!
//! An index can also be written in Boolean variables, as in the AMBA and genbuf benchmarks. In
//! large games, its bits are moved to the bottom. Without that, the time for genbuf from 190
//! senders on and for AMBA from 12 masters on is a matter of luck, with factors of up to eight
//! between neighboring sizes.
//!
//! FORCE only finds a local minimum. If a specification mentions the doors of all elevators, then
//! the positions of all elevators, and so on, the variables of an elevator can stay apart: that
//! game takes minutes instead of two seconds. So in large games, FORCE also starts from greedy
//! orders, which complete one component before they begin another.
//!
//! A formula about whole arrays does not show which elements belong together, but its comparisons
//! do. If `built[i]` is compared with `target[i]` for every `i`, but the order does not place each
//! `built[i]` next to its `target[i]`, the diagram of the formula becomes large. A game with many
//! bits can be encoded only in a good order. So above [`MANY_PAIRS`], comparisons of numbers are
//! hyperedges, too.

use crate::symbolic::{Bit, Encoding, MAX_PAIRS, Order};
use linewright_core::gr1::{BinaryOp, Expr, Owner, Side, Specification, Time, VarId};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of rounds; spans hardly shrink after the first few.
const MAX_ROUNDS: usize = 30;

/// Maximum number of greedy orders from which FORCE starts; see [`from_greedy_starts`].
const MAX_STARTS: usize = 64;

/// Maximum number of variables that all greedy orders of a specification compare with each other.
const MAX_GREEDY_STEPS: usize = 1_000_000;

/// An order that FORCE finds from a greedy order is used only if its spans are at most this
/// percentage of those without. Otherwise neither is better in general.
const CLEARLY_SHORTER_PERCENT: usize = 75;

/// With more bit pairs than this, each comparison of numbers is a hyperedge of its own, and
/// formulas are restricted to bit codes that stand for a value of the domain.
pub const MANY_PAIRS: usize = 48;

/// Maximum number of variables of a specification per hyperedge in which the bits of an index
/// occur; see [`move_index_bits_down`].
const MAX_VARIABLES_PER_CASE: usize = 3;

/// Which of an order and its reverse is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// The one that is better for most games: indices above the arrays from which they select (by
    /// choices or by cases), or else, with more than [`MANY_PAIRS`], outputs nearer to the top.
    Preferred,
    /// The reverse of [`Self::Preferred`].
    Reversed,
    /// The one that FORCE finds, which begins with the variables of the first formulas.
    AsFound,
}

/// Orders the variables by the structure of the specification, and returns the resulting order of
/// all `pairs` bit pairs. The pairs of a variable are adjacent. Pairs that belong to no variable
/// come last. `orientation` chooses between the order that FORCE finds and its reverse.
pub fn order(
    specification: &Specification,
    encoding: &Encoding,
    pairs: usize,
    orientation: Orientation,
) -> Order {
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

    let number = specification.variables.len();
    let (mut best, best_span) = force(&edges, order_of_mention(&edges, number));
    if pairs > MANY_PAIRS {
        let is_clearly_shorter =
            |(_, span): &(_, usize)| span * 100 <= best_span * CLEARLY_SHORTER_PERCENT;
        if let Some((shorter, _)) = from_greedy_starts(&edges, number).filter(is_clearly_shorter) {
            best = shorter;
        }
    }
    if orientation != Orientation::AsFound {
        if is_upside_down(specification, &best, pairs) {
            best.reverse();
        }
        if pairs > MANY_PAIRS {
            move_index_bits_down(&edges, &numeric, &mut best);
        }
    }
    if orientation == Orientation::Reversed {
        best.reverse();
    }

    let mut order = Vec::with_capacity(pairs);
    for variable in best {
        let bits = encoding.bits(VarId(variable as u32), Time::Now);
        order.extend(bits.map(Bit::pair));
    }
    order.extend(encoding.pairs() as u16..pairs as u16);
    Order::new(order).expect("the order is not a permutation of the pairs; please report this")
}

/// Whether the reverse of an order is preferred; see [`Orientation::Preferred`].
fn is_upside_down(specification: &Specification, order: &[usize], pairs: usize) -> bool {
    let mut places = vec![0; order.len()];
    for (place, v) in order.iter().enumerate() {
        places[*v] = place;
    }
    // Sums of places avoid rounding: a / n < b / m if a * m < b * n.
    let mean = |of: &[usize]| (of.iter().map(|v| places[*v]).sum::<usize>(), of.len());
    let compared = |above: &[usize], below: &[usize]| {
        let ((a, n), (b, m)) = (mean(above), mean(below));
        (a * m).cmp(&(b * n)) as i64
    };
    let sides = [&specification.assumptions, &specification.guarantees];
    let mut votes = 0;
    for formula in sides.into_iter().flat_map(Side::all) {
        let mut found = selections(specification, &formula.expr);
        found.extend(cases(specification, &formula.expr));
        for (index, elements) in found {
            votes += compared(&[index], &elements);
        }
    }
    if votes == 0 && pairs > MANY_PAIRS {
        let is_output = |v: &usize| specification.variables[*v].owner == Owner::System;
        let (outputs, inputs): (Vec<usize>, Vec<usize>) = order.iter().partition(|v| is_output(v));
        votes = compared(&outputs, &inputs);
    }
    votes > 0
}

/// Moves the bits of indices to the bottom, next to each other. A specification that writes
/// numbers in Boolean variables has a formula about all bits of `index = i` for every element `i`.
/// So two or more Boolean variables count as an index if they occur in the same hyperedges, and in
/// at least one for every [`MAX_VARIABLES_PER_CASE`] variables. Sifting rarely brings such bits
/// together, because each alone seems well placed between elements.
fn move_index_bits_down(
    edges: &[Vec<usize>],
    is_numeric: &impl Fn(&usize) -> bool,
    order: &mut Vec<usize>,
) {
    let mut occurrences = vec![Vec::new(); order.len()];
    for (number, edge) in edges.iter().enumerate() {
        for v in edge {
            occurrences[*v].push(number);
        }
    }
    let mut groups: BTreeMap<&[usize], usize> = BTreeMap::new();
    for v in order.iter().filter(|v| !is_numeric(v)) {
        *groups.entry(&occurrences[*v]).or_default() += 1;
    }
    let is_index_bit = |v: &usize| {
        let edges = &occurrences[*v][..];
        let is_frequent = edges.len() * MAX_VARIABLES_PER_CASE >= occurrences.len();
        is_frequent && !is_numeric(v) && groups[edges] > 1
    };
    let (bits, mut rest): (Vec<usize>, Vec<usize>) = order.iter().partition(|v| is_index_bit(v));
    rest.extend(bits);
    *order = rest;
}

/// Returns the index of each access to an array in a formula, with the elements that it selects:
/// chains of at least two choices that compare the same variable with constants. Elements with at
/// most two values do not count, since a diagram can remember many of them.
fn selections(specification: &Specification, formula: &Expr) -> Vec<(usize, Vec<usize>)> {
    let mut found = Vec::new();
    let mut left = vec![formula];
    while let Some(expr) = left.pop() {
        let (mut indices, mut elements) = (Vec::new(), Vec::new());
        let mut last = expr;
        while let Expr::If(c, a, b) = last {
            indices.push(case(c).map(|(index, _)| index));
            elements.extend(variables(a));
            left.extend([&**c, &**a]);
            last = b;
        }
        match last {
            Expr::Const(_) | Expr::Var(..) | Expr::If(..) => {}
            Expr::Unary(_, a) => left.push(a),
            Expr::Binary(_, a, b) => left.extend([&**a, &**b]),
        }
        let [Some(index), .., _] = indices[..] else {
            continue;
        };
        elements.extend(variables(last));
        elements.retain(|v| *v != index && specification.variables[*v].domain.size() > 2);
        elements.sort_unstable();
        elements.dedup();
        if elements.len() > 1 && indices.iter().all(|i| *i == Some(index)) {
            found.push((index, elements));
        }
    }
    found
}

/// Like [`selections`], for implications: `index = 0 -> ...` about one element, `index = 1 -> ...`
/// about another, and so on.
fn cases(specification: &Specification, formula: &Expr) -> Vec<(usize, Vec<usize>)> {
    // For each index, the cases in which each element is mentioned.
    let mut indices: BTreeMap<usize, BTreeMap<usize, BTreeSet<i64>>> = BTreeMap::new();
    for part in formula.parts() {
        let mut conditions = Vec::new();
        let mut rest = &part;
        while let Expr::Binary(BinaryOp::Implies, before, after) = rest {
            conditions.extend(before.conjuncts());
            rest = after;
        }
        let elements = variables(rest);
        for (index, value) in conditions.into_iter().filter_map(case) {
            let cases = indices.entry(index).or_default();
            for v in elements.iter().filter(|v| **v != index) {
                if specification.variables[*v].domain.size() > 2 {
                    cases.entry(*v).or_default().insert(value);
                }
            }
        }
    }
    let mut found = Vec::new();
    for (index, elements) in indices {
        let own = elements.into_iter().filter(|(_, cases)| cases.len() == 1);
        let own: Vec<usize> = own.map(|(v, _)| v).collect();
        if own.len() > 1 {
            found.push((index, own));
        }
    }
    found
}

/// Returns the variable that a condition compares with a constant, and the constant.
fn case(condition: &Expr) -> Option<(usize, i64)> {
    match condition {
        Expr::Binary(BinaryOp::Eq, a, b) => match (&**a, &**b) {
            (Expr::Var(v, _), Expr::Const(c)) | (Expr::Const(c), Expr::Var(v, _)) => {
                Some((v.index(), *c))
            }
            _ => None,
        },
        _ => None,
    }
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

/// Returns the order with the smallest sum of spans that FORCE finds from this one, with its sum.
fn force(edges: &[Vec<usize>], start: Vec<usize>) -> (Vec<usize>, usize) {
    let start_span = span(edges, &start);
    let mut best = (start, start_span);
    let mut current = best.0.clone();
    for _ in 0..MAX_ROUNDS {
        current = pull(edges, &current);
        let current_span = span(edges, &current);
        if current_span >= best.1 {
            break;
        }
        best = (current.clone(), current_span);
    }
    best
}

/// Returns the best of the orders that FORCE finds from greedy orders with different first
/// variables, with its sum of spans; `None` if there are too many variables to try.
fn from_greedy_starts(edges: &[Vec<usize>], variables: usize) -> Option<(Vec<usize>, usize)> {
    let starts = MAX_STARTS
        .min(MAX_GREEDY_STEPS / variables.pow(2).max(1))
        .min(variables);
    let orders = (0..starts).map(|i| {
        let first = i * variables / starts;
        force(edges, greedy_order(edges, variables, first))
    });
    orders.min_by_key(|(_, span)| *span)
}

/// Returns an order in which few hyperedges are open at any place: the next variable is one that
/// begins as few hyperedges as possible, minus those that it completes; among these, one that
/// occurs in many that have begun.
fn greedy_order(edges: &[Vec<usize>], variables: usize, first: usize) -> Vec<usize> {
    let mut occurrences = vec![Vec::new(); variables];
    for (number, edge) in edges.iter().enumerate() {
        for v in edge {
            occurrences[*v].push(number);
        }
    }
    let mut missing: Vec<usize> = edges.iter().map(Vec::len).collect();
    let mut left: Vec<usize> = (0..variables).collect();
    let mut order = Vec::with_capacity(variables);
    let mut next = Some(first);
    while !left.is_empty() {
        let place = next.take().unwrap_or_else(|| {
            let cost = |place: &usize| {
                let (mut opened, mut completed, mut open) = (0_i64, 0, 0_i64);
                for edge in &occurrences[left[*place]] {
                    let is_open = missing[*edge] < edges[*edge].len();
                    opened += i64::from(!is_open);
                    open += i64::from(is_open);
                    completed += i64::from(missing[*edge] == 1);
                }
                (opened - completed, -open)
            };
            (0..left.len())
                .min_by_key(cost)
                .expect("a variable is left")
        });
        let variable = left.remove(place);
        for edge in &occurrences[variable] {
            missing[*edge] -= 1;
        }
        order.push(variable);
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

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::gr1::{Domain, Formula, Timing, Variable};
    use linewright_core::source::Span;

    /// A specification over variables with these owners and with the values 0 to 3.
    fn specification(owners: &[Owner], formulas: Vec<Expr>) -> Specification {
        specification_over(&Domain::Range { low: 0, high: 3 }, owners, formulas)
    }

    fn specification_over(domain: &Domain, owners: &[Owner], formulas: Vec<Expr>) -> Specification {
        let variable = |(i, owner): (usize, &Owner)| Variable {
            name: format!("v{i}"),
            owner: *owner,
            internal: false,
            unit: String::new(),
            domain: domain.clone(),
            span: Span::default(),
        };
        let formula = |expr| Formula {
            defines: false,
            name: String::new(),
            requirement: None,
            expr,
            span: Span::default(),
            text: String::new(),
        };
        Specification {
            name: String::new(),
            timing: Timing::Mealy,
            variables: owners.iter().enumerate().map(variable).collect(),
            assumptions: Side::default(),
            guarantees: Side {
                safety: formulas.into_iter().map(formula).collect(),
                ..Side::default()
            },
        }
    }

    fn var(index: u32) -> Expr {
        Expr::Var(VarId(index), Time::Now)
    }

    fn equal(a: Expr, b: Expr) -> Expr {
        Expr::Binary(BinaryOp::Eq, Box::new(a), Box::new(b))
    }

    /// The variables of a game with more than [`MANY_PAIRS`] from top to bottom.
    fn ordered(specification: &Specification, orientation: Orientation) -> Vec<u16> {
        let encoding = Encoding::new(specification);
        let order = order(specification, &encoding, MANY_PAIRS + 1, orientation);
        // Each variable has two pairs.
        let pairs = &order.pairs()[..encoding.pairs()];
        pairs.iter().step_by(2).map(|p| p / 2).collect()
    }

    #[test]
    fn outputs_are_nearer_to_the_top() {
        use Owner::{Environment, System};
        for owners in [
            [Environment, Environment, System, System],
            [System, System, Environment, Environment],
        ] {
            let chain = (0..3).map(|i| equal(var(i), var(i + 1)));
            let specification = specification(&owners, chain.collect());
            let order = ordered(&specification, Orientation::Preferred);
            assert_eq!(owners[usize::from(order[0])], System, "{order:?}");
            let mut reversed = ordered(&specification, Orientation::Reversed);
            reversed.reverse();
            assert_eq!(order, reversed);
        }
    }

    /// An index that is mentioned last, or first, and an expression about its array.
    fn an_index_is_above_its_array(select: impl Fn(u32, &[u32]) -> Expr) {
        use Owner::{Environment, System};
        for index in [4, 0] {
            let elements: Vec<u32> = (0..5).filter(|v| *v != index).collect();
            let neighbours = elements.windows(2).map(|w| equal(var(w[0]), var(w[1])));
            let mut formulas: Vec<Expr> = neighbours.collect();
            formulas.push(select(index, &elements));
            let mut owners = vec![System; 5];
            owners[index as usize] = Environment;
            let order = ordered(&specification(&owners, formulas), Orientation::Preferred);
            let place = order.iter().position(|v| u32::from(*v) == index);
            assert!(place <= Some(2), "{order:?}");
        }
    }

    #[test]
    fn an_index_of_choices_is_above_its_array() {
        an_index_is_above_its_array(|index, elements| {
            let selected = (0..4).rfold(var(elements[3]), |rest, i| {
                let chosen = equal(var(index), Expr::Const(i as i64));
                Expr::If(Box::new(chosen), Box::new(var(elements[i])), Box::new(rest))
            });
            equal(selected, Expr::Const(2))
        });
    }

    #[test]
    fn an_index_of_cases_is_above_its_array() {
        an_index_is_above_its_array(|index, elements| {
            let case = |i: usize| {
                let chosen = equal(var(index), Expr::Const(i as i64));
                chosen.implies(equal(var(elements[i]), Expr::Const(2)))
            };
            (1..4).fold(case(0), |all, i| all.and(case(i)))
        });
    }

    /// Whether the bits 0 and 3, about which there is a formula with every element, are at the
    /// bottom of the order, next to each other.
    fn are_index_bits_at_the_bottom(domain: &Domain) -> bool {
        let elements = [1, 2, 4, 5];
        let formulas = elements.map(|i| equal(var(0), var(3)).implies(var(i)));
        let neighbours = elements.windows(2).map(|w| equal(var(w[0]), var(w[1])));
        let formulas = formulas.into_iter().chain(neighbours).collect();
        let specification = specification_over(domain, &[Owner::System; 6], formulas);
        let encoding = Encoding::new(&specification);
        let order = order(
            &specification,
            &encoding,
            MANY_PAIRS + 1,
            Orientation::Preferred,
        );
        let size = encoding.pairs() as u16 / 6;
        let pairs = &order.pairs()[..encoding.pairs()];
        let variables: Vec<u16> = pairs.chunks(size.into()).map(|p| p[0] / size).collect();
        variables[4..].iter().all(|v| [0, 3].contains(v))
    }

    /// Every component has as many variables as there are kinds, and formulas about neighboring
    /// kinds. The formulas mention all components' variables of one kind after the other.
    #[test]
    fn components_stay_together() {
        const COMPONENTS: usize = 6;
        const KINDS: usize = 8;
        let number = COMPONENTS * KINDS;
        let variable = |component: usize, kind: usize| kind * COMPONENTS + component;
        let edges: Vec<Vec<usize>> = (1..KINDS)
            .flat_map(|kind| {
                (0..COMPONENTS).map(move |c| vec![variable(c, kind - 1), variable(c, kind)])
            })
            .collect();
        let (order, shorter) = from_greedy_starts(&edges, number).unwrap();
        assert_eq!(shorter, edges.len(), "all neighbours are adjacent");
        for component in order.chunks(KINDS) {
            assert!(
                component
                    .iter()
                    .all(|v| v % COMPONENTS == component[0] % COMPONENTS)
            );
        }
        let (_, longer) = force(&edges, order_of_mention(&edges, number));
        assert!(
            shorter * 100 <= longer * CLEARLY_SHORTER_PERCENT,
            "{shorter} {longer}"
        );

        let formulas = edges
            .iter()
            .map(|e| equal(var(e[0] as u32), var(e[1] as u32)));
        let specification = specification(&vec![Owner::System; number], formulas.collect());
        let order = ordered(&specification, Orientation::Preferred);
        for component in order.chunks(KINDS) {
            let of = |v: &u16| usize::from(*v) % COMPONENTS;
            assert!(component.iter().all(|v| of(v) == of(&component[0])));
        }
    }

    #[test]
    fn too_many_variables_are_not_ordered_greedily() {
        assert_eq!(from_greedy_starts(&[vec![0, 1]], 2_000), None);
        assert_eq!(from_greedy_starts(&[], 0), None);
    }

    #[test]
    fn bits_of_an_index_are_at_the_bottom() {
        assert!(are_index_bits_at_the_bottom(&Domain::Bool));
        assert!(!are_index_bits_at_the_bottom(&Domain::Range {
            low: 0,
            high: 3
        }));
    }
}
