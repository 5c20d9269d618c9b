//! Correct machines, counterstrategies and functions, and changed ones: of contracts of the
//! repository and of random specifications.

use crate::random::{self, Random};
use crate::support;
use linewright::cli::proof;
use linewright::contract::load;
use linewright::diagnostics::has_errors;
use linewright::game::{
    Aim, AssumedFormula, DiagramNode, Edge, Limits, Options, Order, Outcome, attack, solve_with,
};
use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright::mealy::functions::Functions;
use linewright::mealy::{Cube, Machine, Port, Test, Transition, counter, extract::extract};
use linewright::source::Span;
use linewright::symbolic::{Bit, Diagram};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// An artefact to check.
#[derive(Clone, Debug, PartialEq)]
pub enum Artefact {
    Machine(Machine),
    Counterstrategy(Machine),
    Functions(Box<Functions>),
    Proof(Value, Tried),
    /// The edges of a graph with their labels as bits: whether it stays bad, and what is met.
    Graph(Vec<Vec<(usize, u32)>>, usize),
    /// Formulas, and the values that their variables receive.
    Formulas(Vec<Expr>, Vec<[i64; 2]>),
    /// What a verifier builds for a correct machine or counterstrategy.
    Product(Box<Artefact>),
}

/// How a proof is examined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tried {
    /// States and inputs are enumerated.
    All,
    /// Enough are tried to meet all.
    Some,
    /// States are examined without their inputs: whether a step has an answer is not tested.
    StatesOnly,
}

/// Maximum number of valuations, and of pairs of bits, that are enumerated.
const MOST_VALUATIONS: u64 = 130;
const MOST_PAIRS: usize = 7;

/// Maximum number of states of proofs that are checked state by state and step by step.
const MOST_STATES: u128 = 40;

/// Maximum number of states that are tried often enough to meet all.
const MOST_TRIED: u128 = 6;

fn sizes(specification: &Specification) -> u128 {
    let sizes = specification.variables.iter().map(|v| v.domain.size());
    sizes.map(u128::from).product()
}

fn small(specification: &Specification) -> bool {
    sizes(specification) <= u128::from(MOST_VALUATIONS)
}

/// The solver's results for a specification.
pub fn right(specification: &Specification) -> Vec<Artefact> {
    let limits = Limits::default();
    let options = Options {
        without_core: true,
        ..Options::default()
    };
    match solve_with(specification, &options).outcome {
        Outcome::Realizable(won) => {
            let machine = extract(specification, &won, &limits).expect("no limit");
            let functions = Functions::extract(specification, &won, &limits).expect("no limit");
            let mut found = vec![Artefact::Machine(machine)];
            if functions.pairs() <= MOST_PAIRS {
                found.push(Artefact::Functions(Box::new(functions)));
            }
            if sizes(specification) <= MOST_STATES {
                let ranking = won.ranking(specification, &limits).expect("no limit");
                let text = proof::to_text(specification, &ranking);
                let document: Value = serde_json::from_str(&text).expect("a document");
                if sizes(specification) <= MOST_TRIED {
                    found.push(Artefact::Proof(document.clone(), Tried::Some));
                }
                found.push(Artefact::Proof(document, Tried::All));
            }
            found
        }
        Outcome::Unrealizable(_) => {
            let attack = attack(specification, &[], &limits).expect("no limit");
            let attack = attack.expect("something beats it");
            vec![Artefact::Counterstrategy(counter::to_machine(
                specification,
                &attack,
            ))]
        }
        Outcome::GaveUp(limit) => panic!("{limit}"),
    }
}

/// A graph with up to six nodes and up to three conditions to meet.
pub fn graph(r: &mut Random) -> Artefact {
    let nodes = 1 + r.below(6) as usize;
    let met = r.below(4) as usize;
    let share = 15 + r.below(40);
    let mut edges = vec![Vec::new(); nodes];
    for out in &mut edges {
        for to in 0..nodes {
            for _ in 0..2 {
                if r.chance(share) {
                    let bad = u32::from(r.chance(80));
                    let fair = (1..=met)
                        .filter(|_| r.chance(35))
                        .fold(0, |all, i| all | 1 << i);
                    out.push((to, bad | fair));
                }
            }
        }
        out.sort_unstable();
        out.dedup();
    }
    Artefact::Graph(edges, met)
}

/// Formulas of a specification, and values for its variables.
pub fn formulas(r: &mut Random, specification: &Specification) -> Artefact {
    let all = specification
        .assumptions
        .all()
        .chain(specification.guarantees.all());
    let formulas = all.map(|f| f.expr.clone()).collect();
    let mut value = |d: &Domain| d.low() + r.below(d.size()) as i64;
    let variables = specification.variables.iter();
    let values = variables
        .map(|v| [value(&v.domain), value(&v.domain)])
        .collect();
    Artefact::Formulas(formulas, values)
}

/// The small contracts of the repository, and random ones.
pub fn specifications(random_ones: u64) -> Vec<Specification> {
    let mut found = Vec::new();
    for folder in ["contracts", "examples", "tests/cases"] {
        let mut files = Vec::new();
        collect(&support::root().join(folder), &mut files);
        files.sort();
        for file in files {
            let Ok(text) = std::fs::read_to_string(&file) else {
                continue;
            };
            let files = [(file.display().to_string(), text)];
            let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
            if has_errors(&findings) {
                continue;
            }
            for contract in &library.contracts {
                let specification = (*contract.specification).clone();
                if small(&specification) && !found.contains(&specification) {
                    found.push(specification);
                }
            }
        }
    }
    for seed in 0..random_ones {
        let mut r = Random::new(seed);
        let mut specification = if seed % 2 == 0 {
            random::specification(&mut r)
        } else {
            random::specification_with_goals(&mut r)
        };
        if small(&specification) {
            found.push(specification.clone());
        }
        // With an output that nothing mentions.
        if seed % 4 == 0 {
            let domain = Domain::Range { low: 0, high: 2 };
            specification.variables.push(Variable {
                name: "spare".to_owned(),
                owner: Owner::System,
                internal: false,
                unit: String::new(),
                domain,
                span: Span::default(),
            });
            if small(&specification) {
                found.push(specification);
            }
        }
    }
    found
}

/// Functions of more bits than fit a word, which can only be examined from outside: each output
/// repeats an input.
pub fn wide() -> (Specification, Functions) {
    let mut specification = Specification {
        name: "wide".to_owned(),
        timing: Timing::Mealy,
        variables: Vec::new(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    };
    for i in 0..33 {
        let mut add = |name: &str, owner| {
            specification.variables.push(Variable {
                name: format!("{name}{i}"),
                owner,
                internal: false,
                unit: String::new(),
                domain: Domain::Bool,
                span: Span::default(),
            });
        };
        // The last output repeats the first input.
        if i < 32 {
            add("x", Owner::Environment);
        }
        add("y", Owner::System);
        let repeated = if i < 32 { [2 * i, 2 * i + 1] } else { [0, 64] };
        let expr = repeated.map(|v| Expr::Var(VarId(v), Time::Next));
        let [x, y] = expr;
        specification.guarantees.safety.push(formula(
            &format!("repeat {i}"),
            Expr::binary(BinaryOp::Eq, x, y),
        ));
    }
    let options = Options {
        without_core: true,
        ..Options::default()
    };
    let Outcome::Realizable(won) = solve_with(&specification, &options).outcome else {
        panic!("outputs can repeat inputs");
    };
    let functions = Functions::extract(&specification, &won, &Limits::default());
    let functions = functions.expect("no limit");
    (specification, functions)
}

/// Functions, one of which tests a bit at the end of a word, either at once or below another bit.
pub fn at_words(right: &Functions) -> Vec<Functions> {
    let end = 2 * right.pairs() as u16;
    let words = (0..end).step_by(64);
    let bits = words.flat_map(|w| [w.checked_sub(1), Some(w), Some(w + 1)]);
    let mut found = Vec::new();
    for bit in bits.flatten().filter(|b| *b < end).map(Bit) {
        for beneath in [false, true] {
            for place in 0..4 {
                let mut functions = right.clone();
                let controls = &mut functions.controls;
                let diagram = if place == 0 {
                    &mut controls.certificate.diagram
                } else {
                    &mut controls.diagram
                };
                let mut edge = literal(diagram, bit);
                if beneath {
                    edge = pointed(diagram, edge, &[(Bit(0), false)], true);
                }
                let mode = &mut controls.goals[0].modes[0];
                *match place {
                    0 => &mut controls.certificate.region,
                    1 => &mut controls.first[0].1,
                    2 => &mut mode.outputs[0].1,
                    _ => &mut mode.when,
                } = edge;
                found.push(functions);
            }
        }
    }
    found
}

fn formula(name: &str, expr: Expr) -> Formula {
    Formula {
        defines: false,
        name: name.to_owned(),
        requirement: None,
        text: format!("{expr:?}"),
        expr,
        span: Span::default(),
    }
}

/// Specifications with one more formula whose numbers exceed 64 bits: the first, the last, and the
/// only one.
pub fn too_large(specification: &Specification) -> [Specification; 3] {
    let variable = Expr::Var(VarId(0), Time::Now);
    let large = Expr::binary(BinaryOp::Mul, variable, Expr::Const(i64::MAX));
    let large = formula("large", Expr::binary(BinaryOp::Ge, large, Expr::Const(0)));
    let mut first = specification.clone();
    first.assumptions.initial.insert(0, large.clone());
    let mut last = specification.clone();
    last.guarantees.justice.push(large.clone());
    let mut only = specification.clone();
    (only.assumptions, only.guarantees) = Default::default();
    only.guarantees.safety.push(large);
    [first, last, only]
}

/// A specification with only goals.
pub fn goals_alone(specification: &Specification) -> Specification {
    let mut alone = specification.clone();
    let side = &mut alone.guarantees;
    side.initial.clear();
    side.invariants.clear();
    side.safety.clear();
    alone
}

/// A specification with an assumption that no second step keeps.
pub fn ended(specification: &Specification) -> Specification {
    let mut ended = specification.clone();
    let side = &mut ended.assumptions;
    side.safety.push(formula("ended", Expr::Const(0)));
    ended
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|e| e == "lw") {
            found.push(path);
        }
    }
}

/// Changes a specification or an artefact for it.
pub fn change(
    r: &mut Random,
    specification: &mut Specification,
    artefact: &mut Artefact,
    steps: &[[Vec<i64>; 2]],
) {
    let answers = matches!(artefact, Artefact::Counterstrategy(_));
    if r.chance(if answers { 45 } else { 30 }) {
        change_specification(r, specification, answers, steps);
        return;
    }
    match artefact {
        Artefact::Machine(machine) | Artefact::Counterstrategy(machine) => {
            change_machine(r, machine);
        }
        Artefact::Functions(functions) => change_functions(r, functions),
        Artefact::Proof(document, _) => change_proof(r, document),
        Artefact::Graph(..) | Artefact::Formulas(..) | Artefact::Product(_) => {}
    }
}

fn pick<T>(r: &mut Random, list: &[T]) -> Option<usize> {
    (!list.is_empty()).then(|| r.below(list.len() as u64) as usize)
}

/// Adds, removes or replaces a formula.
fn change_specification(
    r: &mut Random,
    specification: &mut Specification,
    answers: bool,
    steps: &[[Vec<i64>; 2]],
) {
    let kind = match r.below(8) {
        // Justice, met again and again.
        kind if answers && r.chance(50) => [0, 3, 3, 7][kind as usize % 4],
        kind if !answers && r.chance(25) => [3, 7][kind as usize % 2],
        kind => kind,
    };
    let variables = specification.variables.clone();
    let inputs = |v: usize| variables[v].owner == Owner::Environment;
    // Variables that may be mentioned: current and next ones.
    let (now, next): (Vec<usize>, Vec<usize>) = {
        let all = 0..variables.len();
        match kind {
            // The environment's values after an answer may be assumed to fit it.
            0 if answers => (all.collect(), Vec::new()),
            0 | 1 => (all.filter(|v| inputs(*v)).collect(), Vec::new()),
            2 => (all.clone().collect(), all.filter(|v| inputs(*v)).collect()),
            4 | 5 => (all.collect(), Vec::new()),
            _ => (all.clone().collect(), all.collect()),
        }
    };
    let step = pick(r, steps).map(|i| &steps[i]);
    let mut parts = Vec::new();
    for (list, time) in [(&now, Time::Now), (&next, Time::Next)] {
        for v in list {
            if !r.chance(60) {
                continue;
            }
            let domain = &variables[*v].domain;
            // Initial conditions and invariants also refer to the step taken.
            let place = usize::from(time == Time::Next || matches!(kind, 0 | 1 | 4 | 5));
            let value = match step {
                Some(step) if r.chance(80) => step[place][*v],
                _ => domain.low() + r.below(domain.size()) as i64,
            };
            let variable = Expr::Var(VarId(*v as u32), time);
            parts.push(Expr::binary(BinaryOp::Eq, variable, Expr::Const(value)));
        }
    }
    let expr = parts
        .into_iter()
        .reduce(|a, b| Expr::binary(BinaryOp::And, a, b));
    let expr = expr.unwrap_or(Expr::Const(1));
    let expr = if r.chance(70) { expr.not() } else { expr };
    let added = formula(&format!("added {}", r.below(1 << 30)), expr);
    let (assume, guarantee) = (
        &mut specification.assumptions,
        &mut specification.guarantees,
    );
    let list = match kind {
        0 => &mut assume.initial,
        1 => &mut assume.invariants,
        2 => &mut assume.safety,
        3 => &mut assume.justice,
        4 => &mut guarantee.initial,
        5 => &mut guarantee.invariants,
        6 => &mut guarantee.safety,
        _ => &mut guarantee.justice,
    };
    let at = r.below(list.len() as u64 + 1) as usize;
    match r.below(5) {
        0 if at < list.len() => drop(list.remove(at)),
        1 if at < list.len() => list[at] = added,
        _ => list.insert(at, added),
    }
}

fn change_ports(r: &mut Random, ports: &mut Vec<Port>) {
    let Some(i) = pick(r, ports) else {
        return;
    };
    match r.below(5) {
        0 => ports[i].name.push('x'),
        1 => drop(ports.remove(i)),
        2 => ports.push(ports[i].clone()),
        3 => ports.reverse(),
        _ => {
            let (low, high) = (ports[i].domain.low(), ports[i].domain.high());
            let low = low + r.below(2) as i64;
            ports[i].domain = Domain::Range {
                low,
                high: high + 1,
            };
        }
    }
}

fn flipped(timing: Timing) -> Timing {
    match timing {
        Timing::Mealy => Timing::Moore,
        Timing::Moore => Timing::Mealy,
    }
}

fn change_machine(r: &mut Random, machine: &mut Machine) {
    let states = machine.states.len();
    let inputs = machine.inputs.clone();
    let outputs = machine.outputs.clone();
    let spare = inputs.iter().any(|p| p.name == "spare") && r.chance(30);
    match if spare { 4 } else { r.below(30) } {
        0 => return change_ports(r, &mut machine.inputs),
        1 => return change_ports(r, &mut machine.outputs),
        4 | 5 => {
            // A guard that tests an input that nothing else does.
            let spare = inputs.iter().position(|p| p.name == "spare");
            let mut lists: Vec<_> = machine.states.iter_mut().collect();
            lists.push(&mut machine.initial);
            let transitions = lists.into_iter().flatten();
            let mut cubes: Vec<_> = transitions.flat_map(|t| &mut t.guard.0).collect();
            if r.chance(50) {
                cubes.retain(|c| !c.0.is_empty());
            }
            if let (Some(input), Some(c)) = (spare, pick(r, &cubes)) {
                cubes[c].0.push(Test {
                    input,
                    low: 0,
                    high: 0,
                });
            }
            return;
        }
        2 => return machine.timing = flipped(machine.timing),
        3 => {
            // A state that is never reached.
            let state = machine.states.first().cloned().unwrap_or_default();
            machine
                .states
                .push(if r.chance(40) { Vec::new() } else { state });
            return;
        }
        _ => {}
    }
    let list = match r.below(1 + states as u64) as usize {
        0 => &mut machine.initial,
        i => &mut machine.states[i - 1],
    };
    let Some(i) = pick(r, list) else {
        return;
    };
    let Some(k) = pick(r, &outputs) else {
        return;
    };
    if list.iter().any(|t| t.output.len() <= k) {
        return;
    }
    let domain = &outputs[k].domain;
    match r.below(17) {
        0 => list[i].to = states + r.below(2) as usize,
        1 => list[i].to = r.below(states.max(1) as u64) as usize,
        2 => list[i].output.push(0),
        3 => drop(list[i].output.pop()),
        4 => list[i].output[k] = domain.high() + 1,
        5 => list[i].output[k] = domain.low() - 1,
        6 => {
            let test = Test {
                input: inputs.len(),
                low: 0,
                high: 1,
            };
            match pick(r, &list[i].guard.0) {
                Some(c) => list[i].guard.0[c].0.push(test),
                None => list[i].guard.0.push(Cube(vec![test])),
            }
        }
        7 => list[i].output[k] = domain.low() + r.below(domain.size()) as i64,
        8 => {
            let value = domain.low() + r.below(domain.size()) as i64;
            for transition in list {
                transition.output[k] = value;
            }
        }
        9 => drop(list.remove(i)),
        10 => {
            if let Some(c) = pick(r, &list[i].guard.0) {
                list[i].guard.0.remove(c);
            }
        }
        11 => {
            let again = list[i].clone();
            list.push(again);
        }
        12 => {
            if let Some(c) = pick(r, &list[i].guard.0) {
                let again = list[i].guard.0[c].clone();
                list[i].guard.0.push(again);
            }
        }
        13 => list.clear(),
        14 => list[i].guard.0.push(Cube::default()),
        _ => change_cube(r, &mut list[i], &inputs),
    }
}

/// Makes a test wider, narrower, different, additional or missing.
fn change_cube(r: &mut Random, transition: &mut Transition, inputs: &[Port]) {
    let Some(c) = pick(r, &transition.guard.0) else {
        return;
    };
    let tests = &mut transition.guard.0[c].0;
    let (Some(t), true) = (pick(r, tests), r.chance(80)) else {
        let Some(input) = pick(r, inputs) else {
            return;
        };
        let domain = &inputs[input].domain;
        let low = domain.low() + r.below(domain.size()) as i64;
        tests.push(Test {
            input,
            low,
            high: low,
        });
        return;
    };
    match r.below(5) {
        0 => tests[t].low -= 1,
        1 => tests[t].low += 1,
        2 => tests[t].high -= 1,
        3 => tests[t].high += 1,
        _ => drop(tests.remove(t)),
    }
}

/// The function with the value for one valuation of some bits changed.
fn pointed(diagram: &mut Diagram, edge: Edge, bits: &[(Bit, bool)], value: bool) -> Edge {
    let mut inner = if value { Edge::TRUE } else { Edge::FALSE };
    for (bit, set) in bits {
        let (high, low) = if *set { (inner, edge) } else { (edge, inner) };
        diagram.nodes.push(DiagramNode {
            bit: *bit,
            high,
            low,
        });
        inner = Edge::to(diagram.nodes.len() - 1);
    }
    inner
}

fn literal(diagram: &mut Diagram, bit: Bit) -> Edge {
    diagram.nodes.push(DiagramNode {
        bit,
        high: Edge::TRUE,
        low: Edge::FALSE,
    });
    Edge::to(diagram.nodes.len() - 1)
}

/// A function of some bit; occasionally it tests another, always known bit first.
fn asking(r: &mut Random, diagram: &mut Diagram, bit: Bit) -> Edge {
    let edge = literal(diagram, bit);
    if r.chance(60) {
        return edge;
    }
    pointed(diagram, edge, &[(Bit(0), r.chance(50))], r.chance(50))
}

/// One of the edges of the functions.
fn some_edge<'f>(r: &mut Random, functions: &'f mut Functions) -> Option<&'f mut Edge> {
    let controls = &mut functions.controls;
    let mut edges: Vec<&mut Edge> = match r.below(6) {
        0 => controls.assumed_first.iter_mut().map(|(_, e)| e).collect(),
        1 => controls.assumed.iter_mut().map(|(_, e)| e).collect(),
        2 => controls.first.iter_mut().map(|(_, e)| e).collect(),
        3 => controls.goals.iter_mut().map(|g| &mut g.reached).collect(),
        4 => controls
            .goals
            .iter_mut()
            .flat_map(|g| g.modes.iter_mut().map(|m| &mut m.when))
            .collect(),
        _ => {
            let modes = controls.goals.iter_mut().flat_map(|g| &mut g.modes);
            modes
                .flat_map(|m| m.outputs.iter_mut().map(|(_, e)| e))
                .collect()
        }
    };
    let i = pick(r, &edges)?;
    Some(edges.swap_remove(i))
}

/// One of the sets of the certificate.
fn some_set<'f>(r: &mut Random, functions: &'f mut Functions) -> Option<&'f mut Edge> {
    let certificate = &mut functions.controls.certificate;
    if r.chance(30) {
        return Some(&mut certificate.region);
    }
    let mut sets: Vec<&mut Edge> = certificate
        .goals
        .iter_mut()
        .flatten()
        .map(|s| &mut s.reached)
        .collect();
    let i = pick(r, &sets)?;
    Some(sets.swap_remove(i))
}

fn change_functions(r: &mut Random, functions: &mut Functions) {
    let pairs = functions.pairs();
    let any_bit = |r: &mut Random| match r.below(10) {
        0 => Bit(2 * pairs as u16 - 1),
        _ => Bit(r.below(2 * pairs as u64) as u16),
    };
    let point = |r: &mut Random, share: u64, only_now: bool| -> Vec<(Bit, bool)> {
        let bits = (0..2 * pairs as u16).filter(|b| !only_now || b % 2 == 0);
        bits.filter_map(|b| {
            if r.chance(share) {
                Some((Bit(b), r.chance(50)))
            } else {
                None
            }
        })
        .collect()
    };
    let goals = functions.controls.goals.len();
    if goals == 0 || functions.controls.certificate.goals.len() < goals {
        return;
    }
    let goal = r.below(goals as u64) as usize;
    match r.below(45) {
        0 => change_ports(r, &mut functions.inputs),
        1 => change_ports(r, &mut functions.outputs),
        2 => functions.timing = flipped(functions.timing),
        3 => {
            let lists = if r.chance(50) {
                &mut functions.input_bits
            } else {
                &mut functions.output_bits
            };
            if let Some(i) = pick(r, lists) {
                match r.below(3) {
                    0 => lists[i].reverse(),
                    1 => drop(lists.pop()),
                    _ => lists[i].push(Bit(0)),
                }
            }
        }
        4 => functions.controls.order = Order::natural(pairs + 1 - 2 * r.below(2) as usize),
        5 => match r.below(4) {
            0 => drop(functions.controls.goals.pop()),
            1 => {
                let again = functions.controls.goals[goal].clone();
                functions.controls.goals.push(again);
            }
            2 => drop(functions.controls.certificate.goals.pop()),
            _ => functions.controls.certificate.goals.push(Vec::new()),
        },
        6 => {
            let later = Edge::to(functions.controls.diagram.nodes.len());
            if let Some(edge) = some_edge(r, functions) {
                *edge = later;
            }
        }
        7 => {
            let later = Edge::to(functions.controls.certificate.diagram.nodes.len());
            if let Some(edge) = some_set(r, functions) {
                *edge = later;
            }
        }
        8 => {
            let controls = &mut functions.controls;
            let diagram = if r.chance(50) {
                &mut controls.diagram
            } else {
                &mut controls.certificate.diagram
            };
            if let Some(i) = pick(r, &diagram.nodes) {
                match r.below(3) {
                    0 => diagram.nodes[i].bit = Bit(2 * pairs as u16),
                    1 => diagram.nodes[i].high = Edge::to(i),
                    _ => diagram.nodes[i].low = Edge::to(i),
                }
            }
        }
        // A set that tests an arbitrary bit, a function that does.
        9 => {
            let bit = any_bit(r);
            let edge = asking(r, &mut functions.controls.certificate.diagram, bit);
            if let Some(set) = some_set(r, functions) {
                *set = edge;
            }
        }
        10 | 11 => {
            let bit = any_bit(r);
            let edge = asking(r, &mut functions.controls.diagram, bit);
            if let Some(place) = some_edge(r, functions) {
                *place = edge;
            }
        }
        12 => {
            let mut stages: Vec<_> = functions
                .controls
                .certificate
                .goals
                .iter_mut()
                .flatten()
                .collect();
            if let Some(i) = pick(r, &stages) {
                stages[i].assumption = r.below(4) as usize;
            }
        }
        13 | 14 => {
            let controls = &mut functions.controls;
            let mut lists = vec![&mut controls.first];
            lists.extend(
                controls
                    .goals
                    .iter_mut()
                    .flat_map(|g| g.modes.iter_mut().map(|m| &mut m.outputs)),
            );
            let i = r.below(lists.len() as u64) as usize;
            let list = &mut *lists[i];
            if let Some(i) = pick(r, list) {
                match r.below(4) {
                    0 => list.reverse(),
                    1 => drop(list.remove(i)),
                    2 => list.push(list[i]),
                    _ => list[i].0 = any_bit(r),
                }
            }
        }
        15 => {
            let modes = &mut functions.controls.goals[goal].modes;
            match r.below(4) {
                0 => drop(modes.pop()),
                1 => modes.reverse(),
                2 => {
                    if let Some(last) = modes.last_mut() {
                        last.when = Edge::FALSE;
                    }
                }
                _ => {
                    if let Some(mut first) = modes.first().cloned() {
                        first.when = Edge::TRUE;
                        modes.push(first);
                    }
                }
            }
        }
        16..=18 => {
            let modes = &mut functions.controls.goals[goal].modes;
            if let Some(i) = pick(r, modes) {
                modes[i].aim = match r.below(6) {
                    0 => Aim::Goal,
                    1 | 2 => Aim::Nearer,
                    _ => Aim::Layer(r.below(4) as usize),
                };
            }
        }
        19 => {
            let controls = &mut functions.controls;
            let (list, names) = if r.chance(50) {
                (&mut controls.assumed_first, &mut functions.names_first)
            } else {
                (&mut controls.assumed, &mut functions.names)
            };
            let Some(i) = pick(r, list) else {
                return;
            };
            match r.below(6) {
                0 => {
                    list.remove(i);
                    names.pop();
                }
                1 => drop(names.pop()),
                2 => names.iter_mut().for_each(|n| n.push('x')),
                3 => list[i].0 = AssumedFormula::Safety(9),
                4 => list[i].0 = AssumedFormula::Invariant(9),
                _ => list[i].0 = AssumedFormula::Initial(9),
            }
        }
        20 => {
            let stages = &mut functions.controls.certificate.goals[goal];
            if let Some(i) = pick(r, stages) {
                match r.below(4) {
                    0 => stages.reverse(),
                    1 => drop(stages.remove(i)),
                    2 => stages.insert(i, stages[i]),
                    _ => stages.swap(0, i),
                }
            }
        }
        21 => {
            let region = functions.controls.certificate.region;
            if let Some(set) = some_set(r, functions) {
                *set = if r.chance(50) { region } else { Edge::FALSE };
            }
        }
        22 => {
            if let Some(edge) = some_edge(r, functions) {
                *edge = match r.below(3) {
                    0 => Edge::TRUE,
                    1 => Edge::FALSE,
                    _ => edge.negated(),
                };
            }
        }
        23..=27 => {
            let (bits, value) = (point(r, 80, true), r.chance(50));
            let mut diagram = std::mem::take(&mut functions.controls.certificate.diagram);
            if let Some(set) = some_set(r, functions) {
                *set = pointed(&mut diagram, *set, &bits, value);
            }
            functions.controls.certificate.diagram = diagram;
        }
        // Checks of a driver in some of its inputs.
        34..=38 => {
            let first = r.chance(40);
            let inputs = functions.input_bits.iter().flatten().map(|b| b.primed());
            let mut bits: Vec<Bit> = inputs.collect();
            if !first {
                bits.extend((0..pairs as u16).map(|p| Bit(2 * p)));
            }
            let controls = &mut functions.controls;
            let list = if first {
                &mut controls.assumed_first
            } else {
                &mut controls.assumed
            };
            let share = [100, 60][r.below(2) as usize];
            for (_, edge) in list.iter_mut() {
                if r.chance(share) {
                    let bits = bits.iter().copied();
                    let point: Vec<_> = bits
                        .filter_map(|b| {
                            if r.chance(50) {
                                Some((b, r.chance(50)))
                            } else {
                                None
                            }
                        })
                        .collect();
                    let value = r.chance(40);
                    *edge = pointed(&mut controls.diagram, *edge, &point, value);
                }
            }
        }
        39 | 42.. => {
            for mode in &mut functions.controls.goals[goal].modes {
                mode.aim = Aim::Nearer;
            }
            if r.chance(60) {
                functions.controls.certificate.goals[goal].pop();
            }
        }
        // One state less or more, everywhere.
        28 | 29 => {
            let (bits, value) = (point(r, 90, true), r.chance(30));
            let certificate = &mut functions.controls.certificate;
            let mut sets: Vec<&mut Edge> = certificate
                .goals
                .iter_mut()
                .flatten()
                .map(|s| &mut s.reached)
                .collect();
            sets.push(&mut certificate.region);
            for set in sets {
                *set = pointed(&mut certificate.diagram, *set, &bits, value);
            }
        }
        _ => {
            let now = r.chance(40);
            let (bits, value) = (point(r, 70, now), r.chance(50));
            let mut diagram = std::mem::take(&mut functions.controls.diagram);
            if let Some(edge) = some_edge(r, functions) {
                *edge = pointed(&mut diagram, *edge, &bits, value);
            }
            functions.controls.diagram = diagram;
        }
    }
}

/// Values of some of a proof's bits, each taken with this probability.
fn some_bits(r: &mut Random, document: &Value, chance: u64) -> Vec<(u64, bool)> {
    let variables = document["variables"].as_array().into_iter().flatten();
    let bits = variables.flat_map(|v| v["bits"].as_array().into_iter().flatten());
    let bits: Vec<u64> = bits.filter_map(Value::as_u64).collect();
    let mut found = Vec::new();
    for bit in bits {
        if r.chance(chance) {
            found.push((bit, r.chance(50)));
        }
    }
    found
}

/// Aspects of functions that random changes seldom reach: steps that leave a layer whose assumption
/// never holds, steps that lead below their target layer, and the last of several assumptions
/// missing from a driver.
pub fn variants(
    r: &mut Random,
    specification: &Specification,
    functions: &Functions,
) -> Vec<(Specification, Functions)> {
    let mut found = Vec::new();
    let current: Vec<Bit> = (0..functions.pairs() as u16).map(|p| Bit(2 * p)).collect();
    let mut never = specification.clone();
    never
        .assumptions
        .justice
        .push(formula("never", Expr::Const(0)));
    for goal in 0..functions.controls.goals.len() {
        let mut changed = functions.clone();
        for mode in &mut changed.controls.goals[goal].modes {
            mode.aim = Aim::Nearer;
        }
        let certificate = &mut changed.controls.certificate;
        let stages = &mut certificate.goals[goal];
        let Some(at) = pick(r, stages) else {
            continue;
        };
        let before = at.checked_sub(1).map(|i| stages[i].reached);
        let mut state = Vec::new();
        for bit in &current {
            if r.chance(90) {
                state.push((*bit, r.chance(50)));
            }
        }
        let before = before.unwrap_or(Edge::FALSE);
        let mut added = stages[at];
        added.reached = pointed(&mut certificate.diagram, before, &state, true);
        stages.insert(at, added);
        for stage in stages {
            stage.assumption = never.assumptions.justice.len() - 1;
        }
        found.push((never.clone(), changed));
        let layers = functions.controls.certificate.goals[goal].len();
        for (i, mode) in functions.controls.goals[goal].modes.iter().enumerate() {
            if let Aim::Layer(layer) = mode.aim
                && layer + 1 < layers
            {
                let mut changed = functions.clone();
                changed.controls.goals[goal].modes[i].aim = Aim::Layer(layer + 1);
                found.push((specification.clone(), changed));
            }
        }
    }
    for first in [true, false] {
        let mut changed = functions.clone();
        let controls = &mut changed.controls;
        let (list, names) = if first {
            (&mut controls.assumed_first, &mut changed.names_first)
        } else {
            (&mut controls.assumed, &mut changed.names)
        };
        if list.len() > 1 {
            list.pop();
            names.pop();
            found.push((specification.clone(), changed));
        }
    }
    found
}

/// A function of a proof with another value where bits have these values.
fn changed(document: &mut Value, edge: &Value, bits: &[(u64, bool)], value: bool) -> Value {
    let mut inner = json!(u64::from(value));
    let Some(nodes) = document["nodes"].as_array_mut() else {
        return inner;
    };
    for (bit, set) in bits {
        nodes.push(if *set {
            json!([bit, inner, edge])
        } else {
            json!([bit, edge, inner])
        });
        inner = json!(2 * nodes.len());
    }
    inner
}

/// A function of a proof that differs in one state or several.
fn another(r: &mut Random, document: &mut Value, edge: &Value) -> Value {
    let value = r.chance(50);
    let bits = some_bits(r, document, 85);
    changed(document, edge, &bits, value)
}

/// Adds a layer of the previous states and one state or several, which are marked as waiting.
fn add_layer(r: &mut Random, document: &mut Value, goal: usize, layer: usize) {
    let bits = some_bits(r, document, 95);
    let layers = &document["goals"][goal]["layers"];
    let before = match layer.checked_sub(1) {
        Some(before) => layers[before]["reached"].clone(),
        None => json!(0),
    };
    let wait = changed(document, &json!(0), &bits, true);
    let reached = changed(document, &before, &bits, true);
    let added = json!({"assumption": r.below(2), "wait": wait, "reached": reached});
    if let Some(list) = document["goals"][goal]["layers"].as_array_mut() {
        list.insert(layer, added);
    }
}

/// Adds two layers of states from which the goal is already reached: marking them as waiting is
/// harmless, wherever they lead.
fn add_idle_layers(r: &mut Random, document: &mut Value, goal: usize) {
    let bits = some_bits(r, document, 95);
    let states = changed(document, &json!(0), &bits, true);
    if let Some(list) = document["goals"][goal]["layers"].as_array_mut() {
        list.push(json!({"assumption": 0, "wait": 0, "reached": states}));
        list.push(json!({"assumption": 0, "wait": states, "reached": states}));
    }
}

/// Replaces a function in a proof, removes a part, or makes it no proof at all.
fn change_proof(r: &mut Random, document: &mut Value) {
    let count = document["nodes"].as_array().map_or(0, Vec::len) as u64;
    let goals = document["goals"].as_array().map_or(0, Vec::len) as u64;
    let goal = r.below(goals.max(1)) as usize;
    let layers = document["goals"][goal]["layers"]
        .as_array()
        .map_or(0, Vec::len) as u64;
    let layer = r.below(layers.max(1)) as usize;
    let edge = |r: &mut Random| match r.below(4) {
        0 => json!(r.below(2)),
        _ => json!(2 + r.below(2 * count.max(1))),
    };
    match r.below(20) {
        17 | 18 if layers > 0 => add_layer(r, document, goal, layer),
        19 if layers > 0 => add_idle_layers(r, document, goal),
        16 => {
            let count = document["variables"].as_array().map_or(0, Vec::len) as u64;
            if count > 0 {
                document["variables"][r.below(count) as usize]["low"] = Value::Null;
            }
        }
        0 if count > 0 => {
            let node = r.below(count) as usize;
            let child = 1 + r.below(2) as usize;
            let later = 2 * node as u64 + 2;
            document["nodes"][node][child] = if r.chance(30) {
                json!(later)
            } else {
                json!(r.below(later))
            };
        }
        1 => {
            let end = json!(2 * count + 2 + r.below(2));
            match r.below(3) {
                0 => document["region"] = end,
                1 if layers > 0 => document["goals"][goal]["layers"][layer]["wait"] = end,
                _ if layers > 0 => document["goals"][goal]["layers"][layer]["reached"] = end,
                _ => {}
            }
        }
        2 => {
            let field = ["variables", "nodes", "region", "goals"][r.below(4) as usize];
            document[field] = json!("none");
        }
        3 => {
            let Some(list) = document["goals"].as_array_mut() else {
                return;
            };
            match r.below(3) {
                0 => list.reverse(),
                1 => drop(list.pop()),
                _ => list.push(json!({"layers": []})),
            }
        }
        4 => {
            let edge = edge(r);
            document["region"] = edge;
        }
        5 | 6 => {
            let old = document["region"].clone();
            document["region"] = another(r, document, &old);
        }
        _ if layers == 0 => {}
        7 | 8 => {
            let list = document["goals"][goal]["layers"]
                .as_array_mut()
                .expect("a list");
            match r.below(3) {
                0 => drop(list.remove(layer)),
                1 => list.insert(layer, list[layer].clone()),
                _ => list.reverse(),
            }
        }
        9 => document["goals"][goal]["layers"][layer]["assumption"] = json!(r.below(3)),
        10 => {
            let field = ["assumption", "wait", "reached"][r.below(3) as usize];
            document["goals"][goal]["layers"][layer][field] = json!(-1);
        }
        11 => document["goals"][goal]["layers"][layer]["wait"] = edge(r),
        12 => document["goals"][goal]["layers"][layer]["reached"] = edge(r),
        n => {
            let field = if n == 13 { "wait" } else { "reached" };
            let old = document["goals"][goal]["layers"][layer][field].clone();
            document["goals"][goal]["layers"][layer][field] = another(r, document, &old);
        }
    }
}
