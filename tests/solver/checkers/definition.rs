//! Definition of a correct machine, counterstrategy and certificate, by enumeration: which clauses
//! an artefact violates. Formulas are evaluated directly, diagrams are walked from their roots, and
//! no part of the checkers is used.
//!
//! Clauses are in stages, and a checker names one of the first stage with a violation: the form,
//! without which the others are meaningless, then safety before liveness, or a certificate's region
//! before promises and steps.

use crate::game::value;
use linewright::game::{Aim, AssumedFormula, Edge};
use linewright::gr1::{Formula, Owner, Specification, Timing};
use linewright::mealy::functions::Functions;
use linewright::mealy::verify::Clause;
use linewright::mealy::{Machine, Port, Transition, certify};
use linewright::symbolic::{Bit, Diagram};
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};

pub type Broken = BTreeSet<Clause>;

/// The clauses that an artefact violates.
pub struct Found<C> {
    /// Violated clauses of the first stage, one of which a checker names.
    pub named: BTreeSet<C>,
    /// Violated clauses of later stages, as far as they are meaningful.
    pub later: BTreeSet<C>,
}

impl<C: Ord> Found<C> {
    fn staged(stages: impl IntoIterator<Item = BTreeSet<C>>) -> Self {
        let mut broken = stages.into_iter().filter(|stage| !stage.is_empty());
        Self {
            named: broken.next().unwrap_or_default(),
            later: broken.flatten().collect(),
        }
    }
}

/// All valuations of one side's variables; the other variables are 0.
pub fn valuations(specification: &Specification, owner: Owner) -> Vec<Vec<i64>> {
    let mut all = vec![vec![0; specification.variables.len()]];
    for (v, variable) in specification.variables.iter().enumerate() {
        if variable.owner == owner {
            let values = variable.domain.low()..=variable.domain.high();
            let extend = |state: &Vec<i64>| {
                let with = |x| {
                    let mut state = state.clone();
                    state[v] = x;
                    state
                };
                values.clone().map(with).collect::<Vec<_>>()
            };
            all = all.iter().flat_map(extend).collect();
        }
    }
    all
}

/// The values of one side's variables, in order.
pub fn part(specification: &Specification, valuation: &[i64], owner: Owner) -> Vec<i64> {
    let variables = specification.variables.iter().zip(valuation);
    let own = variables.filter(|(v, _)| v.owner == owner);
    own.map(|(_, x)| *x).collect()
}

/// A valuation with other values for one side's variables.
pub fn with(
    specification: &Specification,
    valuation: &[i64],
    owner: Owner,
    values: &[i64],
) -> Vec<i64> {
    let mut result = valuation.to_vec();
    let own = specification
        .variables
        .iter()
        .enumerate()
        .filter(|(_, v)| v.owner == owner);
    for ((v, _), value) in own.zip(values) {
        result[v] = *value;
    }
    result
}

pub fn holds(formula: &Formula, now: &[i64], next: &[i64]) -> bool {
    value(&formula.expr, now, next) != 0
}

/// The formulas of a side that a step violates; without a previous valuation, it is the first step.
pub fn broken<'a>(
    side: &'a linewright::gr1::Side,
    now: Option<&[i64]>,
    next: &[i64],
) -> Vec<&'a Formula> {
    let mut found: Vec<&Formula> = Vec::new();
    if now.is_none() {
        found.extend(side.initial.iter().filter(|f| !holds(f, next, &[])));
    }
    found.extend(side.invariants.iter().filter(|f| !holds(f, next, &[])));
    if let Some(now) = now {
        found.extend(side.safety.iter().filter(|f| !holds(f, now, next)));
    }
    found
}

/// The transitions with the cubes that some values satisfy, one entry per cube.
pub fn matching<'m>(transitions: &'m [Transition], values: &[i64]) -> Vec<&'m Transition> {
    let cubes = transitions
        .iter()
        .flat_map(|t| t.guard.0.iter().map(move |c| (t, c)));
    let inside = cubes.filter(|(_, c)| {
        c.0.iter()
            .all(|t| (t.low..=t.high).contains(&values[t.input]))
    });
    inside.map(|(t, _)| t).collect()
}

fn same_ports(specification: &Specification, owner: Owner, ports: &[Port]) -> bool {
    let own: Vec<_> = specification
        .variables
        .iter()
        .filter(|v| v.owner == owner)
        .collect();
    own.len() == ports.len()
        && own
            .iter()
            .zip(ports)
            .all(|(v, p)| v.name == p.name && v.domain == p.domain)
}

/// Violations in the form of transitions: they test `asked` and set `given`.
fn form(specification: &Specification, machine: &Machine, asked: Owner, given: Owner) -> Broken {
    let mut found = Broken::new();
    if !same_ports(specification, asked, &machine.inputs)
        || !same_ports(specification, given, &machine.outputs)
    {
        return [Clause::Ports].into();
    }
    let counterstrategy = given == Owner::Environment;
    let swapped = (machine.timing == specification.timing) == counterstrategy;
    if swapped {
        found.insert(Clause::Timing);
    }
    let ports: Vec<_> = specification
        .variables
        .iter()
        .filter(|v| v.owner == given)
        .collect();
    let answers_first = (specification.timing == Timing::Moore) != counterstrategy;
    for list in std::iter::once(&machine.initial).chain(&machine.states) {
        if counterstrategy && list.is_empty() {
            found.insert(Clause::NoTransition);
        }
        for t in list {
            if t.to >= machine.states.len() {
                found.insert(Clause::MissingTarget);
            }
            if t.output.len() != ports.len() {
                found.insert(Clause::OutputCount);
            }
            for (port, x) in ports.iter().zip(&t.output) {
                if *x < port.domain.low() || *x > port.domain.high() {
                    found.insert(Clause::Domain(port.name.clone()));
                }
            }
            if t.guard
                .0
                .iter()
                .flat_map(|c| &c.0)
                .any(|t| t.input >= machine.inputs.len())
            {
                found.insert(Clause::UnknownInput);
            }
            if answers_first && t.output != list[0].output {
                found.insert(Clause::FirstMover);
            }
        }
    }
    found
}

/// A play's graph: nodes are states of a machine with a valuation, and conditions on an edge depend
/// on two valuations.
#[derive(Default)]
pub struct Product {
    pub nodes: Vec<(usize, Vec<i64>)>,
    numbers: HashMap<(usize, Vec<i64>), usize>,
    pub edges: Vec<(usize, usize)>,
    /// Initial nodes of the product.
    pub first: Vec<usize>,
}

impl Product {
    fn number(&mut self, node: (usize, Vec<i64>)) -> usize {
        let fresh = self.nodes.len();
        let number = *self.numbers.entry(node.clone()).or_insert(fresh);
        if number == fresh {
            self.nodes.push(node);
        }
        number
    }

    /// Walks from the first steps on; `next` returns the steps from a node, or the initial ones.
    fn walk(mut next: impl FnMut(Option<(usize, &[i64])>) -> Vec<(usize, Vec<i64>)>) -> Self {
        let mut product = Self::default();
        for node in next(None) {
            let number = product.number(node);
            product.first.push(number);
        }
        let mut at = 0;
        while at < product.nodes.len() {
            let (state, valuation) = product.nodes[at].clone();
            for node in next(Some((state, &valuation))) {
                let to = product.number(node);
                product.edges.push((at, to));
            }
            at += 1;
        }
        product
    }

    /// Whether some cycle of the edges that `stays` allows meets all of the formulas.
    fn cycle(&self, stays: impl Fn(&[i64], &[i64]) -> bool, met: &[Formula]) -> bool {
        let values = |n: usize| &self.nodes[n].1[..];
        let edges: Vec<_> = self
            .edges
            .iter()
            .filter(|(a, b)| stays(values(*a), values(*b)))
            .collect();
        let mut out = vec![Vec::new(); self.nodes.len()];
        for (from, to) in &edges {
            out[*from].push(*to);
        }
        let reach: Vec<Vec<bool>> = (0..self.nodes.len()).map(|n| reachable(&out, n)).collect();
        (0..self.nodes.len()).any(|n| {
            let inner = |(a, b): (usize, usize)| (a == n || reach[n][a]) && (b == n || reach[b][n]);
            reach[n][n]
                && met.iter().all(|f| {
                    edges
                        .iter()
                        .any(|(a, b)| inner((*a, *b)) && holds(f, values(*a), values(*b)))
                })
        })
    }
}

fn reachable(out: &[Vec<usize>], from: usize) -> Vec<bool> {
    let mut reached = vec![false; out.len()];
    let mut open = out[from].clone();
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut reached[node], true) {
            open.extend(&out[node]);
        }
    }
    reached
}

/// The clauses that a machine violates.
pub fn machine(specification: &Specification, machine: &Machine) -> (Found<Clause>, Product) {
    let mut found = form(specification, machine, Owner::Environment, Owner::System);
    if !found.is_empty() {
        return (Found::staged([found]), Product::default());
    }
    let inputs = valuations(specification, Owner::Environment);
    let product = Product::walk(|at| {
        let mut steps = Vec::new();
        for given in &inputs {
            if !broken(&specification.assumptions, at.map(|(_, now)| now), given).is_empty() {
                continue;
            }
            let values = part(specification, given, Owner::Environment);
            match matching(machine.transitions(at.map(|(s, _)| s)), &values)[..] {
                [] => drop(found.insert(Clause::MissingTransition)),
                [t] => {
                    let next = with(specification, given, Owner::System, &t.output);
                    let wrong = broken(&specification.guarantees, at.map(|(_, now)| now), &next);
                    if wrong.is_empty() {
                        steps.push((t.to, next));
                    }
                    found.extend(wrong.iter().map(|f| Clause::Guarantee(f.name.clone())));
                }
                _ => drop(found.insert(Clause::AmbiguousTransition)),
            }
        }
        steps
    });
    let missed = specification.guarantees.justice.iter().filter(|goal| {
        product.cycle(
            |now, next| !holds(goal, now, next),
            &specification.assumptions.justice,
        )
    });
    let missed = missed.map(|f| Clause::Justice(f.name.clone())).collect();
    (Found::staged([found, missed]), product)
}

/// The clauses that a counterstrategy violates.
pub fn counterstrategy(
    specification: &Specification,
    machine: &Machine,
) -> (Found<Clause>, Product) {
    let mut found = form(specification, machine, Owner::System, Owner::Environment);
    if !found.is_empty() {
        return (Found::staged([found]), Product::default());
    }
    let outputs = valuations(specification, Owner::System);
    let product = Product::walk(|at| {
        let transitions = machine.transitions(at.map(|(s, _)| s));
        let now = at.map(|(_, now)| now);
        let mut steps = Vec::new();
        // Its values, whether taken or not, keep the assumptions.
        let mut keeps = Vec::new();
        for t in transitions {
            let mut wrong: BTreeSet<&str> =
                specification.assumptions.all().map(|f| &*f.name).collect();
            for answer in &outputs {
                let step = with(specification, answer, Owner::Environment, &t.output);
                let here = broken(&specification.assumptions, now, &step);
                wrong.retain(|name| here.iter().any(|f| f.name == *name));
            }
            keeps.push(wrong.is_empty());
            found.extend(
                wrong
                    .iter()
                    .map(|name| Clause::Assumption((*name).to_owned())),
            );
        }
        for answer in &outputs {
            let values = part(specification, answer, Owner::System);
            let of = matching(transitions, &values);
            let step = |t: &Transition| with(specification, answer, Owner::Environment, &t.output);
            let legal = |next: &[i64]| broken(&specification.guarantees, now, next).is_empty();
            let first = specification.timing == Timing::Mealy;
            if first && !legal(&step(&transitions[0])) {
                continue;
            }
            match of.len() {
                0 => drop(found.insert(Clause::Unanswered)),
                1 => {}
                _ => drop(found.insert(Clause::AnsweredTwice)),
            }
            for (t, keeps) in transitions.iter().zip(&keeps) {
                let next = step(t);
                // Values given first meet this answer whether or not a transition is for it.
                let met = first || of.contains(&t);
                if !(met && *keeps && legal(&next)) {
                    continue;
                }
                let wrong = broken(&specification.assumptions, now, &next);
                if wrong.is_empty() && of == [t] {
                    steps.push((t.to, next));
                }
                found.extend(wrong.iter().map(|f| Clause::Assumption(f.name.clone())));
            }
        }
        steps
    });
    let starved = specification
        .assumptions
        .justice
        .iter()
        .filter(|f| product.cycle(|now, next| !holds(f, now, next), &[]));
    let mut live: Broken = starved
        .map(|f| Clause::StarvedAssumption(f.name.clone()))
        .collect();
    if product.cycle(|_, _| true, &specification.guarantees.justice) {
        live.insert(Clause::MachineWins);
    }
    (Found::staged([found, live]), product)
}

/// Whether some cycle of bad edges meets all conditions.
pub fn fair_cycle(edges: &[Vec<(usize, u32)>], met: usize) -> bool {
    let bad: Vec<Vec<(usize, u32)>> = edges
        .iter()
        .map(|out| {
            out.iter()
                .copied()
                .filter(|(_, label)| label & 1 == 1)
                .collect()
        })
        .collect();
    let out: Vec<Vec<usize>> = bad
        .iter()
        .map(|o| o.iter().map(|(to, _)| *to).collect())
        .collect();
    let reach: Vec<Vec<bool>> = (0..out.len()).map(|n| reachable(&out, n)).collect();
    (0..out.len()).any(|n| {
        let on = |a: usize, b: usize| (a == n || reach[n][a]) && (b == n || reach[b][n]);
        let seen = |i: usize| {
            (0..out.len()).any(|a| bad[a].iter().any(|(b, l)| on(a, *b) && l >> i & 1 == 1))
        };
        reach[n][n] && (1..=met).all(seen)
    })
}

/// The value of an edge, with bits indexed by number.
fn evaluate(diagram: &Diagram, mut edge: Edge, bits: &[bool]) -> bool {
    let mut negated = false;
    loop {
        negated ^= edge.0 % 2 == 1;
        if edge.0 < 2 {
            return negated;
        }
        let node = &diagram.nodes[edge.0 as usize / 2 - 1];
        edge = if bits[node.bit.index()] {
            node.high
        } else {
            node.low
        };
    }
}

/// The bits that an edge tests.
fn asked(diagram: &Diagram, edge: Edge) -> BTreeSet<Bit> {
    let mut found = BTreeSet::new();
    let mut open = vec![edge];
    while let Some(edge) = open.pop() {
        if edge.0 > 1 {
            let node = &diagram.nodes[edge.0 as usize / 2 - 1];
            found.insert(node.bit);
            open.extend([node.high, node.low]);
        }
    }
    found
}

fn sound(diagram: &Diagram, bits: usize, edges: &[Edge]) -> bool {
    let nodes = diagram.nodes.iter().enumerate();
    let earlier = |edge: Edge, end: usize| edge.0 < 2 || (edge.0 as usize / 2 - 1) < end;
    nodes
        .into_iter()
        .all(|(i, n)| n.bit.index() < bits && earlier(n.high, i) && earlier(n.low, i))
        && edges.iter().all(|e| earlier(*e, diagram.nodes.len()))
}

type Certified = BTreeSet<certify::Clause>;

/// The clauses that functions with their certificate violate; `None` if formulas would be evaluated
/// on codes without a meaning.
pub fn functions(
    specification: &Specification,
    functions: &Functions,
) -> Option<Found<certify::Clause>> {
    let found = form_of_functions(specification, functions);
    if !found.is_empty() {
        return Some(Found::staged([found]));
    }
    let codes = Codes::new(specification, functions);
    // Too many to enumerate.
    if codes.pairs > 12 {
        None
    } else {
        codes.check()
    }
}

fn layout(specification: &Specification) -> Vec<Vec<Bit>> {
    let mut pairs = 0u16;
    let bits = specification.variables.iter().map(|v| {
        let size = (v.domain.high() - v.domain.low() + 1) as u64;
        let count = size.next_power_of_two().trailing_zeros() as u16;
        pairs += count;
        (pairs - count..pairs).map(|p| Bit(2 * p)).collect()
    });
    bits.collect()
}

fn form_of_functions(specification: &Specification, functions: &Functions) -> Certified {
    use certify::Clause;
    let layout = layout(specification);
    let pairs: usize = layout.iter().map(Vec::len).sum();
    let of = |owner: Owner| -> Vec<Vec<Bit>> {
        let own = specification
            .variables
            .iter()
            .zip(&layout)
            .filter(|(v, _)| v.owner == owner);
        own.map(|(_, bits)| bits.clone()).collect()
    };
    let controls = &functions.controls;
    let certificate = &controls.certificate;
    let goals = specification.guarantees.justice.len().max(1);
    if !same_ports(specification, Owner::Environment, &functions.inputs)
        || !same_ports(specification, Owner::System, &functions.outputs)
        || of(Owner::Environment) != functions.input_bits
        || of(Owner::System) != functions.output_bits
        || functions.timing != specification.timing
        || controls.order.pairs().len() != pairs
        || controls.goals.len() != goals
        || certificate.goals.len() != goals
    {
        return [Clause::Ports].into();
    }
    let mut edges: Vec<Edge> = controls
        .assumed_first
        .iter()
        .chain(&controls.assumed)
        .map(|(_, e)| *e)
        .collect();
    edges.extend(controls.first.iter().map(|(_, e)| *e));
    for goal in &controls.goals {
        edges.push(goal.reached);
        edges.extend(
            goal.modes
                .iter()
                .flat_map(|m| m.outputs.iter().map(|(_, e)| *e).chain([m.when])),
        );
    }
    let mut sets: Vec<Edge> = certificate
        .goals
        .iter()
        .flatten()
        .map(|s| s.reached)
        .collect();
    sets.push(certificate.region);
    if !sound(&controls.diagram, 2 * pairs, &edges)
        || !sound(&certificate.diagram, 2 * pairs, &sets)
    {
        return [Clause::Diagram].into();
    }
    let mut found = Certified::new();
    let is_next = |bit: &Bit| bit.0 % 2 == 1;
    if sets
        .iter()
        .any(|s| asked(&certificate.diagram, *s).iter().any(is_next))
    {
        found.insert(Clause::SetOfStates);
    }
    let assumptions = specification.assumptions.justice.len().max(1);
    if certificate
        .goals
        .iter()
        .flatten()
        .any(|s| s.assumption >= assumptions)
    {
        found.insert(Clause::LayerAssumption);
    }
    let next = |owner: Owner| -> BTreeSet<Bit> {
        of(owner).iter().flatten().map(|b| Bit(b.0 + 1)).collect()
    };
    let before = |first: bool| -> BTreeSet<Bit> {
        let mut known: BTreeSet<Bit> = if first {
            BTreeSet::new()
        } else {
            layout.iter().flatten().copied().collect()
        };
        if specification.timing == Timing::Mealy {
            known.extend(next(Owner::Environment));
        }
        known
    };
    let mut outputs = |list: &[(Bit, Edge)], mut known: BTreeSet<Bit>| {
        let wanted = next(Owner::System);
        let mut computed = BTreeSet::new();
        for (bit, edge) in list {
            if !asked(&controls.diagram, *edge).is_subset(&known) {
                found.insert(Clause::OutputDependency);
            }
            if !wanted.contains(bit) || !computed.insert(*bit) {
                found.insert(Clause::OutputTwice);
            }
            known.insert(*bit);
        }
        if !wanted.is_subset(&computed) {
            found.insert(Clause::OutputMissing);
        }
    };
    outputs(&controls.first, before(true));
    for mode in controls.goals.iter().flat_map(|g| &g.modes) {
        outputs(&mode.outputs, before(false));
    }
    for (goal, layers) in controls.goals.iter().zip(&certificate.goals) {
        for mode in &goal.modes {
            if !asked(&controls.diagram, mode.when).is_subset(&before(false)) {
                found.insert(Clause::ModeDependency);
            }
            if let Aim::Layer(layer) = mode.aim
                && layer >= layers.len()
            {
                found.insert(Clause::ModeLayer);
            }
        }
        if goal.modes.last().is_none_or(|m| m.when != Edge::TRUE) {
            found.insert(Clause::ModeMissing);
        }
    }
    let side = &specification.assumptions;
    let lists = [
        (true, &controls.assumed_first, &functions.names_first),
        (false, &controls.assumed, &functions.names),
    ];
    for (first, list, names) in lists {
        let mut known = next(Owner::Environment);
        if !first {
            known.extend(layout.iter().flatten().copied());
        }
        let name = |assumed: &AssumedFormula| match *assumed {
            AssumedFormula::Initial(i) => side.initial.get(i),
            AssumedFormula::Invariant(i) => side.invariants.get(i),
            AssumedFormula::Safety(i) => side.safety.get(i),
        };
        let right = list.len() == names.len()
            && list.iter().zip(names).all(|((assumed, edge), n)| {
                name(assumed).is_some_and(|f| f.name == *n)
                    && asked(&controls.diagram, *edge).is_subset(&known)
            });
        if !right {
            found.insert(Clause::AssumptionCheck);
        }
    }
    found
}

/// Bits instead of values, and conditions on them.
struct Codes<'a> {
    specification: &'a Specification,
    functions: &'a Functions,
    layout: Vec<Vec<Bit>>,
    pairs: usize,
}

impl<'a> Codes<'a> {
    fn new(specification: &'a Specification, functions: &'a Functions) -> Self {
        let layout = layout(specification);
        let pairs = layout.iter().map(Vec::len).sum();
        Self {
            specification,
            functions,
            layout,
            pairs,
        }
    }

    /// The values encoded by current (0) or next (1) bits.
    fn values(&self, bits: &[bool], time: usize) -> Vec<i64> {
        let variables = self.specification.variables.iter().zip(&self.layout);
        let code = |of: &Vec<Bit>| {
            of.iter()
                .fold(0, |code, b| 2 * code + i64::from(bits[b.index() + time]))
        };
        variables.map(|(v, of)| v.domain.low() + code(of)).collect()
    }

    /// The first variable of a side that has no value.
    fn outside(&self, values: &[i64], owner: Owner) -> Option<&'a str> {
        let variables = self.specification.variables.iter().zip(values);
        let mut own = variables.filter(|(v, _)| v.owner == owner);
        own.find(|(v, x)| **x > v.domain.high())
            .map(|(v, _)| v.name.as_str())
    }

    /// All valuations of the current or next bits of some variables.
    fn all(&self, bits: &[bool], time: usize, owner: Option<Owner>) -> Vec<Vec<bool>> {
        let variables = self.specification.variables.iter().zip(&self.layout);
        let own = variables.filter(|(v, _)| owner.is_none_or(|o| v.owner == o));
        let places: Vec<usize> = own
            .flat_map(|(_, b)| b.iter().map(|b| b.index() + time))
            .collect();
        let set = |code: usize| {
            let mut bits = bits.to_vec();
            for (i, place) in places.iter().enumerate() {
                bits[*place] = code >> i & 1 == 1;
            }
            bits
        };
        (0..1 << places.len()).map(set).collect()
    }

    fn set(&self, edge: Edge, bits: &[bool]) -> bool {
        evaluate(&self.functions.controls.certificate.diagram, edge, bits)
    }

    fn function(&self, edge: Edge, bits: &[bool]) -> bool {
        evaluate(&self.functions.controls.diagram, edge, bits)
    }

    /// Current bits equal to the next ones of these.
    fn then(bits: &[bool]) -> Vec<bool> {
        let mut then = bits.to_vec();
        for pair in then.chunks_exact_mut(2) {
            pair[0] = pair[1];
        }
        then
    }

    fn check(&self) -> Option<Found<certify::Clause>> {
        use certify::Clause;
        let mut sets = Certified::new();
        let controls = &self.functions.controls;
        let (assume, guarantee) = (
            &self.specification.assumptions,
            &self.specification.guarantees,
        );
        let none = vec![false; 2 * self.pairs];
        let states = self.all(&none, 0, None);
        let region: Vec<&Vec<bool>> = states
            .iter()
            .filter(|s| self.set(controls.certificate.region, s))
            .collect();
        for state in &region {
            let now = self.values(state, 0);
            if self.outside(&now, Owner::Environment).is_some() {
                return None;
            }
            let variables = self.specification.variables.iter().zip(&now);
            let out = variables.filter(|(v, x)| **x > v.domain.high());
            let out: Vec<_> = out.map(|(v, _)| Clause::Domain(v.name.clone())).collect();
            if out.is_empty() {
                let wrong = guarantee.invariants.iter().filter(|f| !holds(f, &now, &[]));
                sets.extend(wrong.map(|f| Clause::Invariant(f.name.clone())));
            }
            sets.extend(out);
        }
        for layers in &controls.certificate.goals {
            let mut bounds = layers
                .iter()
                .map(|s| s.reached)
                .skip(1)
                .chain([controls.certificate.region]);
            let nested = layers.iter().all(|stage| {
                let bound = bounds.next().expect("a bound for each");
                states
                    .iter()
                    .all(|s| !self.set(stage.reached, s) || self.set(bound, s))
            });
            if !nested {
                sets.insert(Clause::Layers);
            }
        }
        // Formulas are undefined on codes outside the domains.
        if sets.iter().any(|c| matches!(c, Clause::Domain(_))) {
            return Some(Found::staged([sets]));
        }

        // Checks of a driver.
        let legal = |bits: &[bool], first: bool| {
            let next = self.values(bits, 1);
            let now = self.values(bits, 0);
            self.outside(&next, Owner::Environment).is_none()
                && broken(assume, (!first).then_some(&now), &next).is_empty()
        };
        let mut promises = Certified::new();
        let mut ask = |bits: &[bool], first: bool| {
            let list = if first {
                &controls.assumed_first
            } else {
                &controls.assumed
            };
            let accepted = list.iter().all(|(_, e)| self.function(*e, bits));
            let legal = legal(bits, first);
            if legal && !accepted {
                promises.insert(Clause::LegalInputRefused);
            }
            if accepted
                && !legal
                && self
                    .outside(&self.values(bits, 1), Owner::Environment)
                    .is_none()
            {
                promises.insert(Clause::IllegalInputAccepted);
            }
        };
        for bits in self.all(&none, 1, Some(Owner::Environment)) {
            ask(&bits, true);
        }
        for state in &region {
            for bits in self.all(state, 1, Some(Owner::Environment)) {
                ask(&bits, false);
            }
        }
        let mut steps = Certified::new();
        for mut bits in self.all(&none, 1, Some(Owner::Environment)) {
            if legal(&bits, true) {
                for (bit, edge) in &controls.first {
                    bits[bit.index()] = self.function(*edge, &bits);
                }
                let next = self.values(&bits, 1);
                let wrong = guarantee.initial.iter().filter(|f| !holds(f, &next, &[]));
                steps.extend(wrong.map(|f| Clause::Initial(f.name.clone())));
                if self.outside(&next, Owner::System).is_some() {
                    // Formulas are meaningless on codes without a value.
                    let any = guarantee.initial.iter();
                    steps.extend(any.map(|f| Clause::Initial(f.name.clone())));
                }
                if !self.set(controls.certificate.region, &Self::then(&bits)) {
                    steps.insert(Clause::InitialRegion);
                }
            }
        }
        for goal in 0..controls.goals.len() {
            for state in &region {
                for bits in self.all(state, 1, Some(Owner::Environment)) {
                    if legal(&bits, false) {
                        self.step(goal, bits, &mut steps);
                    }
                }
            }
        }
        Some(Found::staged([sets, promises, steps]))
    }

    /// One step in pursuit of a goal.
    fn step(&self, goal: usize, mut bits: Vec<bool>, found: &mut Certified) {
        use certify::Clause;
        let controls = &self.functions.controls;
        let pursuit = &controls.goals[goal];
        let mode = pursuit.modes.iter().find(|m| self.function(m.when, &bits));
        let mode = mode.expect("a mode for all states");
        for (bit, edge) in &mode.outputs {
            bits[bit.index()] = self.function(*edge, &bits);
        }
        let (now, next) = (self.values(&bits, 0), self.values(&bits, 1));
        let then = Self::then(&bits);
        let side = &self.specification.guarantees;
        let wrong = side.safety.iter().filter(|f| !holds(f, &now, &next));
        found.extend(wrong.map(|f| Clause::Safety(f.name.clone())));
        let formula = side.justice.get(goal);
        let name = formula.map_or("true".to_owned(), |f| f.name.clone());
        let met = formula.is_none_or(|f| holds(f, &now, &next));
        let meaningless = self.outside(&next, Owner::System).is_some();
        if meaningless {
            let any = side.safety.iter();
            found.extend(any.map(|f| Clause::Safety(f.name.clone())));
        }
        if meaningless || self.function(pursuit.reached, &bits) != met {
            found.insert(Clause::GoalSwitch(name.clone()));
        }
        if met && self.set(controls.certificate.region, &then) {
            return;
        }
        let stages = &controls.certificate.goals[goal];
        let within = |k: usize, state: &[bool]| self.set(stages[k].reached, state);
        let below = |k: usize, state: &[bool]| k > 0 && within(k - 1, state);
        let assumed = |k: usize| {
            let formula = self
                .specification
                .assumptions
                .justice
                .get(stages[k].assumption);
            formula.is_none_or(|f| holds(f, &now, &next))
        };
        match mode.aim {
            Aim::Goal => drop(found.insert(Clause::GoalMissed(name))),
            Aim::Layer(k) => {
                if !within(k, &then) {
                    found.insert(Clause::LayerMissed(name.clone()));
                }
                if below(k, &bits) {
                    found.insert(Clause::MovesAway(name.clone()));
                }
                if within(k, &bits) && !below(k, &bits) && assumed(k) && !below(k, &then) {
                    found.insert(Clause::UnjustifiedWait(name));
                }
            }
            Aim::Nearer => match (0..stages.len()).find(|k| within(*k, &bits)) {
                None => drop(found.insert(Clause::OutsideLayers(name))),
                Some(k) if below(k, &then) => {}
                Some(k) if !within(k, &then) => drop(found.insert(Clause::LayerMissed(name))),
                Some(k) if assumed(k) => drop(found.insert(Clause::UnjustifiedWait(name))),
                Some(_) => {}
            },
        }
    }
}

/// The obligations of `docs/proof.md` that a document violates. A checker that enumerates states in
/// the same order names the first.
pub fn proof(specification: &Specification, document: &Value) -> Found<String> {
    let obligations = Document::read(document)
        .filter(|d| d.goals.len() == specification.guarantees.justice.len().max(1));
    let Some(document) = obligations else {
        return Found::staged([["Form".to_owned()].into()]);
    };
    let stages = document.broken(specification).into_iter();
    Found::staged(stages.map(|clause| [clause.to_owned()].into()))
}

/// A proof with its sets of states.
struct Document {
    bits: Vec<(Vec<usize>, i64)>,
    nodes: Vec<[usize; 3]>,
    region: usize,
    goals: Vec<Vec<[usize; 3]>>,
}

impl Document {
    fn read(document: &Value) -> Option<Self> {
        let number = |v: &Value| v.as_u64().map(|n| n as usize);
        let variable = |v: &Value| {
            let bits: Option<Vec<usize>> = v["bits"].as_array()?.iter().map(number).collect();
            Some((bits?, v["low"].as_i64().unwrap_or(0)))
        };
        let node = |n: &Value| Some([number(&n[0])?, number(&n[1])?, number(&n[2])?]);
        let layer = |l: &Value| {
            Some([
                number(&l["assumption"])?,
                number(&l["wait"])?,
                number(&l["reached"])?,
            ])
        };
        let goal = |g: &Value| {
            g["layers"]
                .as_array()?
                .iter()
                .map(layer)
                .collect::<Option<Vec<_>>>()
        };
        let read = Self {
            bits: document["variables"]
                .as_array()?
                .iter()
                .map(variable)
                .collect::<Option<_>>()?,
            nodes: document["nodes"]
                .as_array()?
                .iter()
                .map(node)
                .collect::<Option<_>>()?,
            region: number(&document["region"])?,
            goals: document["goals"]
                .as_array()?
                .iter()
                .map(goal)
                .collect::<Option<_>>()?,
        };
        let count = read.nodes.len();
        let backwards = (1..)
            .zip(&read.nodes)
            .all(|(n, [_, high, low])| high / 2 < n && low / 2 < n);
        let roots = read
            .goals
            .iter()
            .flatten()
            .all(|[_, wait, reached]| wait / 2 <= count && reached / 2 <= count);
        (backwards && roots && read.region / 2 <= count).then_some(read)
    }

    fn holds(&self, edge: usize, state: &[i64]) -> bool {
        if edge < 2 {
            return edge == 1;
        }
        let [bit, high, low] = self.nodes[edge / 2 - 1];
        let variables = self.bits.iter().zip(state);
        let mut bits = variables.flat_map(|((bits, low), x)| {
            let count = bits.len();
            bits.iter()
                .enumerate()
                .map(move |(i, b)| (*b, (x - low) >> (count - 1 - i) & 1 == 1))
        });
        let set = bits.find(|(b, _)| *b == bit).is_some_and(|(_, set)| set);
        self.holds(if set { high } else { low }, state) != (edge % 2 == 1)
    }

    /// Violations in the order in which they are found.
    fn broken(&self, specification: &Specification) -> Vec<&'static str> {
        let mut found = Vec::new();
        let (assume, guarantee) = (&specification.assumptions, &specification.guarantees);
        let inputs = valuations(specification, Owner::Environment);
        let outputs = valuations(specification, Owner::System);
        let joined = |x: &[i64], y: &[i64]| {
            with(
                specification,
                y,
                Owner::Environment,
                &part(specification, x, Owner::Environment),
            )
        };
        let states: Vec<Vec<i64>> = inputs
            .iter()
            .flat_map(|x| outputs.iter().map(|y| joined(x, y)))
            .collect();
        let legal = |s: &[i64]| {
            assume
                .invariants
                .iter()
                .chain(&guarantee.invariants)
                .all(|f| holds(f, s, &[]))
        };
        let region = |s: &[i64]| self.holds(self.region, s);
        // Whether the machine can answer so that each step satisfies `good`.
        let can = |given: &[&Vec<i64>], good: &dyn Fn(&[i64]) -> bool| match specification.timing {
            Timing::Mealy => given
                .iter()
                .all(|x| outputs.iter().any(|y| good(&joined(x, y)))),
            Timing::Moore => outputs
                .iter()
                .any(|y| given.iter().all(|x| good(&joined(x, y)))),
        };
        let first: Vec<_> = inputs
            .iter()
            .filter(|x| broken(assume, None, x).is_empty())
            .collect();
        let starts =
            |s: &[i64]| legal(s) && guarantee.initial.iter().all(|f| holds(f, s, &[])) && region(s);
        let mut note = |wrong: bool, name: &'static str| {
            if wrong && !found.contains(&name) {
                found.push(name);
            }
        };
        note(!can(&first, &starts), "Start");
        for state in states.iter().filter(|s| region(s)) {
            note(!legal(state), "Region");
            let given: Vec<_> = inputs
                .iter()
                .filter(|x| broken(assume, Some(state), x).is_empty())
                .collect();
            for (j, layers) in self.goals.iter().enumerate() {
                for (k, [assumption, wait, reached]) in layers.iter().enumerate() {
                    let below = |s: &[i64]| k > 0 && self.holds(layers[k - 1][2], s);
                    let waits = self.holds(*wait, state);
                    note(
                        self.holds(*reached, state) && !waits && !below(state),
                        "Layer",
                    );
                    let met = |list: &[Formula], i: usize, next: &[i64]| {
                        list.get(i).is_none_or(|f| holds(f, state, next))
                    };
                    let good = |next: &[i64]| {
                        let goal = met(&guarantee.justice, j, next) && region(next);
                        let idle =
                            !met(&assume.justice, *assumption, next) && self.holds(*wait, next);
                        legal(next)
                            && guarantee.safety.iter().all(|f| holds(f, state, next))
                            && (goal || below(next) || idle)
                    };
                    note(waits && !below(state) && !can(&given, &good), "Answer");
                }
                let mut reached = layers.iter().map(|[_, _, reached]| reached);
                note(!reached.any(|r| self.holds(*r, state)), "Reached");
            }
        }
        for state in states.iter().filter(|s| !region(s)) {
            let layers = self.goals.iter().flatten();
            let mut sets = layers.flat_map(|[_, wait, reached]| [wait, reached]);
            note(sets.any(|s| self.holds(*s, state)), "Within");
        }
        found
    }
}
