//! Checks a machine against its specification without the solver: every transition against safety, every fair cycle
//! against justice.
//!
//! The product of the machine with its environment is built explicitly. A node is a state of the machine and a *context*: what
//! the formulas that speak of two steps still say once the current values are known (`residual.rs`). So current inputs that no
//! formula mentions, or that matter only while something else holds, do not multiply the nodes. Next inputs are enumerated
//! variable by variable, and a branch is left as soon as an assumption is known to be broken.
//!
//! Justice: if the machine breaks goal `j`, some play stays for ever in transitions that do not satisfy it and yet sees every
//! assumption again and again; that is a strongly connected part of the graph without the transitions that satisfy `j`, in
//! which every assumption's justice occurs (`fair.rs`).

mod clause;
mod counter;
mod fair;
mod residual;

pub use clause::Clause;
pub use counter::verify_counterstrategy;

use super::{Cube, Machine, Transition};
use crate::game::{Limit, Limits};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Formula, Specification, Time, Timing, VarId};
use residual::{Id, Place, Pool, Tree, key};
use std::collections::HashMap;
use std::rc::Rc;

/// More pairs of a node and a letter than this are not examined.
pub const MOST_PAIRS: u64 = 50_000_000;

/// What a machine does wrong, with the play that shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// What it breaks.
    pub clause: Clause,
    /// The valuations of all variables, step by step, up to the violation. Without a transition, or with two, the outputs
    /// of the last step are the smallest values of their domains.
    pub trace: Vec<Vec<i64>>,
    /// For a justice formula: the step to which the play returns for ever.
    pub repeats_from: Option<usize>,
}

/// Checks a machine. `Ok(Ok(()))` is: it keeps its contract. Beyond [`MOST_PAIRS`], or as many pairs as there may be nodes
/// ([`Limits::most_nodes`]), it gives up with [`Limit::Size`].
pub fn verify(
    specification: &Specification,
    machine: &Machine,
    limits: &Limits,
) -> Result<Result<(), Violation>, Limit> {
    let mut check = Check::new(specification, machine, limits)?;
    if let Some(clause) = check.malformed() {
        return Ok(Err(Violation {
            clause,
            trace: Vec::new(),
            repeats_from: None,
        }));
    }
    if let Some(violation) = check.explore()? {
        return Ok(Err(violation));
    }
    check.justice()
}

/// A node's formulas, split by what they are for; over next values only.
struct Context {
    /// Where the enumeration of legal inputs begins.
    legal: Place,
    /// The guarantees that are left, with their place among the names.
    guarantees: Vec<(Id, usize)>,
    /// The justice of both sides, first the environment's.
    justice: Vec<Id>,
}

/// A state of the product.
struct Node {
    /// `None` before step 0.
    state: Option<usize>,
    context: Place,
    /// How it was first reached: from which node, with which valuation.
    from: Option<(usize, Vec<i64>)>,
}

/// A step of the product.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    to: usize,
    /// Which justice formulas the transition satisfies.
    label: u32,
}

/// The edges in order, each once.
fn distinct(mut edges: Vec<Edge>) -> Vec<Edge> {
    edges.sort_unstable();
    edges.dedup();
    edges
}

struct Check<'a> {
    specification: &'a Specification,
    machine: &'a Machine,
    limits: &'a Limits,
    pool: Pool,
    inputs: Vec<VarId>,
    outputs: Vec<VarId>,
    /// Asks for current values, outputs first.
    contexts: Tree,
    /// Asks for next inputs.
    legal: Tree,
    assumptions: usize,
    guarantee_names: Vec<String>,
    known: HashMap<Place, Rc<Context>>,
    start: Place,
    step: Place,
    nodes: Vec<Node>,
    edges: Vec<Vec<Edge>>,
    labels: Vec<Vec<bool>>,
    pairs: u64,
    most_pairs: u64,
    /// The place in `legal` where an assumption is broken.
    broken: Place,
}

impl<'a> Check<'a> {
    fn new(
        specification: &'a Specification,
        machine: &'a Machine,
        limits: &'a Limits,
    ) -> Result<Self, Limit> {
        let domain = |v: VarId| Interval::of(&specification.variable(v).domain);
        for formula in specification
            .assumptions
            .all()
            .chain(specification.guarantees.all())
        {
            interval(&formula.expr, &domain).map_err(|_| Limit::Size)?;
        }
        let inputs: Vec<VarId> = specification.inputs().collect();
        let outputs: Vec<VarId> = specification.outputs().collect();
        let ask = |v: &VarId, time: Time| {
            let range = domain(*v);
            (key(v.index(), time), range.low, range.high)
        };
        let now = outputs.iter().chain(&inputs).map(|v| ask(v, Time::Now));
        let next = inputs.iter().map(|v| ask(v, Time::Next));
        let mut pool = Pool::default();
        let mut contexts = Tree::new(now.collect());
        let mut legal = Tree::new(next.collect());
        legal.conjunction = true;
        let no = pool.constant(0);
        let broken = legal.place(&pool, vec![no]);

        // Both lists have the same shape: assumptions, guarantees, justice of both sides. Those that speak of one step speak of
        // the step to come. In step 0 safety and justice have nothing to say.
        let (assumed, guaranteed) = (&specification.assumptions, &specification.guarantees);
        let mut start = Vec::new();
        let mut step = Vec::new();
        let mut guarantee_names = Vec::new();
        for (side, names) in [(assumed, None), (guaranteed, Some(&mut guarantee_names))] {
            let yes = pool.constant(1);
            let mut list = |formulas: &[Formula], at_start: bool, at_step: bool| {
                for formula in formulas {
                    let shifted = pool.add(&formula.expr, &|_| Time::Next);
                    start.push(if at_start { shifted } else { yes });
                    step.push(if !at_step {
                        yes
                    } else if at_start {
                        shifted
                    } else {
                        pool.add(&formula.expr, &|t| t)
                    });
                }
            };
            list(&side.initial, true, false);
            list(&side.invariants, true, true);
            list(&side.safety, false, true);
            if let Some(names) = names {
                let formulas = side.initial.iter().chain(&side.invariants);
                let formulas = formulas.chain(&side.safety);
                names.extend(formulas.map(|f| f.name.clone()));
            }
        }
        for formula in assumed.justice.iter().chain(&guaranteed.justice) {
            start.push(no);
            step.push(pool.add(&formula.expr, &|t| t));
        }
        let start = contexts.place(&pool, start);
        let step = contexts.place(&pool, step);
        Ok(Self {
            specification,
            machine,
            limits,
            pool,
            inputs,
            outputs,
            contexts,
            legal,
            assumptions: assumed.initial.len() + assumed.invariants.len() + assumed.safety.len(),
            guarantee_names,
            known: HashMap::new(),
            start,
            step,
            nodes: Vec::new(),
            edges: Vec::new(),
            labels: Vec::new(),
            pairs: 0,
            most_pairs: limits.most_nodes.unwrap_or(MOST_PAIRS).min(MOST_PAIRS),
            broken,
        })
    }

    /// What is wrong with the machine's form, if anything: its ports, its targets, its outputs, a Moore machine's outputs.
    fn malformed(&self) -> Option<Clause> {
        let machine = self.machine;
        let same = |ports: &[super::Port], ids: &[VarId]| {
            let variables = ids.iter().map(|v| self.specification.variable(*v));
            ports.len() == ids.len()
                && ports
                    .iter()
                    .zip(variables)
                    .all(|(p, v)| p.name == v.name && p.domain == v.domain)
        };
        if !same(&machine.inputs, &self.inputs) || !same(&machine.outputs, &self.outputs) {
            return Some(Clause::Ports);
        }
        if machine.timing != self.specification.timing {
            return Some(Clause::Timing);
        }
        let lists = std::iter::once(&machine.initial).chain(&machine.states);
        for transitions in lists {
            for transition in transitions {
                if transition.to >= machine.states.len() {
                    return Some(Clause::Target);
                }
                if transition.output.len() != self.outputs.len() {
                    return Some(Clause::Values);
                }
                for (port, value) in machine.outputs.iter().zip(&transition.output) {
                    if !port.domain.contains(*value) {
                        return Some(Clause::Domain(port.name.clone()));
                    }
                }
                let tests = transition.guard.0.iter().flat_map(|c| &c.0);
                if tests.into_iter().any(|t| t.input >= self.inputs.len()) {
                    return Some(Clause::Guard);
                }
                if self.specification.timing == Timing::Moore
                    && transition.output != transitions[0].output
                {
                    return Some(Clause::First);
                }
            }
        }
        None
    }

    fn context(&mut self, place: Place) -> Rc<Context> {
        if let Some(known) = self.known.get(&place) {
            return Rc::clone(known);
        }
        let formulas = self.contexts.formulas(place).to_vec();
        let (assumed, rest) = formulas.split_at(self.assumptions);
        let (guaranteed, justice) = rest.split_at(self.guarantee_names.len());
        let always = |id: &Id| self.pool.value(*id) == Some(1);
        let left = assumed.to_vec();
        let guarantees = guaranteed.iter().copied().zip(0..);
        let guarantees = guarantees.filter(|(id, _)| !always(id)).collect();
        let context = Rc::new(Context {
            legal: self.legal.place(&self.pool, left),
            guarantees,
            justice: justice.to_vec(),
        });
        self.known.insert(place, Rc::clone(&context));
        context
    }

    /// Builds the product; gives the first violation of safety.
    fn explore(&mut self) -> Result<Option<Violation>, Limit> {
        let mut numbers: HashMap<(usize, Place), usize> = HashMap::new();
        let mut labels: HashMap<Vec<bool>, u32> = HashMap::new();
        self.nodes.push(Node {
            state: None,
            context: self.start,
            from: None,
        });
        let mut current = 0;
        while current < self.nodes.len() {
            let context = self.context(self.nodes[current].context);
            let mut edges: Vec<Edge> = Vec::new();
            let mut label = vec![false; context.justice.len()];
            let wrong = self.letters(current, &mut |check, transition, next| {
                for (id, name) in &context.guarantees {
                    if check.pool.eval(*id, next) == 0 {
                        let name = check.guarantee_names[*name].clone();
                        return Some(Clause::Guarantee(name));
                    }
                }
                for (bit, id) in label.iter_mut().zip(&context.justice) {
                    *bit = check.pool.eval(*id, next) != 0;
                }
                let number = if let Some(number) = labels.get(&label) {
                    *number
                } else {
                    let number = check.labels.len() as u32;
                    check.labels.push(label.clone());
                    labels.insert(label.clone(), number);
                    number
                };
                let place = check.contexts.descend(&mut check.pool, check.step, next);
                let fresh = check.nodes.len();
                let to = *numbers.entry((transition.to, place)).or_insert(fresh);
                if to == fresh {
                    check.nodes.push(Node {
                        state: Some(transition.to),
                        context: place,
                        from: Some((current, next.to_vec())),
                    });
                }
                let edge = Edge { to, label: number };
                if edges.last() != Some(&edge) {
                    edges.push(edge);
                }
                None
            })?;
            if let Some((clause, next)) = wrong {
                let mut trace = self.trace_to(current);
                trace.push(next);
                return Ok(Some(Violation {
                    clause,
                    trace,
                    repeats_from: None,
                }));
            }
            self.edges.push(distinct(edges));
            current += 1;
        }
        Ok(None)
    }

    /// Calls `visit` with the machine's transition and the valuation of the next step for all next inputs that keep the
    /// assumptions. Stops when it gives a broken clause, or when there is no transition or more than one, and gives the
    /// clause with the valuation.
    fn letters(
        &mut self,
        node: usize,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<Option<(Clause, Vec<i64>)>, Limit> {
        self.limits.check_time()?;
        let context = self.context(self.nodes[node].context);
        let transitions = self.machine.transitions(self.nodes[node].state);
        let cubes = transitions.iter().enumerate().flat_map(|(t, transition)| {
            let cubes = transition.guard.0.iter();
            cubes.map(move |cube| (t, cube))
        });
        let next = self.specification.variables.iter();
        let mut walk = Walk {
            transitions,
            candidates: vec![Vec::new(); self.inputs.len() + 1],
            next: next.map(|v| v.domain.low()).collect(),
        };
        walk.candidates[0] = cubes.collect();
        let broken = self.walk(&mut walk, 0, context.legal, visit)?;
        Ok(broken.map(|clause| (clause, walk.next)))
    }

    fn walk(
        &mut self,
        walk: &mut Walk<'a>,
        depth: usize,
        place: Place,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<Option<Clause>, Limit> {
        if place == self.broken {
            return Ok(None);
        }
        let Some(input) = self.inputs.get(depth).copied() else {
            self.pairs += 1;
            if self.pairs > self.most_pairs {
                return Err(Limit::Size);
            }
            if self.pairs.is_multiple_of(1 << 16) {
                self.limits.check_time()?;
            }
            let clause = match walk.candidates[depth][..] {
                [(t, _)] => {
                    let transition = &walk.transitions[t];
                    for (v, value) in self.outputs.iter().zip(&transition.output) {
                        walk.next[v.index()] = *value;
                    }
                    return Ok(visit(self, transition, &walk.next));
                }
                [] => Clause::Gap,
                _ => Clause::Overlap,
            };
            // Nothing of the letter before.
            for v in &self.outputs {
                walk.next[v.index()] = self.specification.variable(*v).domain.low();
            }
            return Ok(Some(clause));
        };
        let domain = &self.specification.variable(input).domain;
        for value in domain.low()..=domain.high() {
            walk.next[input.index()] = value;
            let (before, after) = walk.candidates.split_at_mut(depth + 1);
            after[0].clear();
            after[0].extend(before[depth].iter().filter(|(_, cube)| {
                let tests = cube.0.iter().filter(|t| t.input == depth);
                tests.into_iter().all(|t| t.low <= value && value <= t.high)
            }));
            let below = if self.legal.question(place) == Some(depth) {
                self.legal.answer(&mut self.pool, place, value)
            } else {
                place
            };
            let broken = self.walk(walk, depth + 1, below, visit)?;
            if broken.is_some() {
                return Ok(broken);
            }
        }
        Ok(None)
    }

    /// The valuations of the play by which a node was first reached.
    fn trace_to(&self, mut node: usize) -> Vec<Vec<i64>> {
        let mut trace = Vec::new();
        while let Some((from, valuation)) = &self.nodes[node].from {
            trace.push(valuation.clone());
            node = *from;
        }
        trace.reverse();
        trace
    }

    /// Looks for a fair play that breaks a justice guarantee.
    fn justice(&mut self) -> Result<Result<(), Violation>, Limit> {
        let assumed = self.specification.assumptions.justice.len();
        for (j, formula) in self.specification.guarantees.justice.iter().enumerate() {
            let bad = |label: u32| !self.labels[label as usize][assumed + j];
            let fair = |label: u32, i: usize| self.labels[label as usize][i];
            let Some(cycle) = fair::fair_cycle(&self.edges, assumed, &bad, &fair, self.limits)?
            else {
                continue;
            };
            let mut trace = self.trace_to(cycle[0].0);
            let repeats_from = Some(trace.len());
            for (from, edge) in cycle {
                trace.push(self.letter_of(from, edge)?);
            }
            return Ok(Err(Violation {
                clause: Clause::Justice(formula.name.clone()),
                trace,
                repeats_from,
            }));
        }
        Ok(Ok(()))
    }

    /// A valuation that takes the product along an edge.
    fn letter_of(&mut self, from: usize, edge: Edge) -> Result<Vec<i64>, Limit> {
        let context = self.context(self.nodes[from].context);
        let target = (self.nodes[edge.to].state, self.nodes[edge.to].context);
        let found = self.letters(from, &mut |check, transition, next| {
            let place = check.contexts.descend(&mut check.pool, check.step, next);
            let mut label = check.labels[edge.label as usize]
                .iter()
                .zip(&context.justice);
            let same = label.all(|(bit, id)| *bit == (check.pool.eval(*id, next) != 0));
            // Whatever is given stops the enumeration here.
            (same && target == (Some(transition.to), place)).then_some(Clause::Gap)
        })?;
        Ok(found.map(|(_, next)| next).unwrap_or_default())
    }
}

/// What is called for every letter: with the transition taken and the valuation of the step.
type Visit<'v, 'a> = dyn FnMut(&mut Check<'a>, &Transition, &[i64]) -> Option<Clause> + 'v;

/// The state of an enumeration of letters.
struct Walk<'a> {
    transitions: &'a [Transition],
    /// By depth, the cubes that the inputs chosen so far satisfy.
    candidates: Vec<Vec<(usize, &'a Cube)>>,
    next: Vec<i64>,
}
