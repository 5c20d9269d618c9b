//! Checks a counterstrategy against the specification without the solver: the environment keeps its safety whatever the
//! machine answers, every legal answer is met, and no play satisfies the machine's goals or starves an assumption.
//!
//! The product of the counterstrategy with every machine is built explicitly, as [`super::verify`] does it with the roles the
//! other way round: a node is a state and what the formulas still say once the current values are known. Answers are
//! enumerated output by output, and a branch is left as soon as a guarantee is known to be broken. Outputs that neither a
//! formula nor a guard mentions stay at their smallest value.
//!
//! Liveness: on every cycle each assumption's justice occurs, and in no strongly connected part do all goals.

use super::fair::fair_cycle;
use super::residual::{Id, Place, Pool, Tree, key};
use super::{Clause, Edge, MOST_PAIRS, Violation, distinct};
use crate::game::{Limit, Limits};
use crate::mealy::{Cube, Machine, Transition};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Formula, Specification, Time, Timing, VarId};
use std::collections::HashMap;

/// Checks a counterstrategy: whoever plays it against any machine keeps all assumptions of the specification, and the
/// machine breaks one of its guarantees.
pub fn verify_counterstrategy(
    specification: &Specification,
    counterstrategy: &Machine,
    limits: &Limits,
) -> Result<Result<(), Violation>, Limit> {
    let domain = |v: VarId| Interval::of(&specification.variable(v).domain);
    let (assumed, guaranteed) = (&specification.assumptions, &specification.guarantees);
    for formula in assumed.all().chain(guaranteed.all()) {
        interval(&formula.expr, &domain).map_err(|_| Limit::Size)?;
    }
    let mut check = Check::new(specification, counterstrategy, limits);
    if let Some(clause) = check.malformed() {
        return Ok(Err(Violation {
            clause,
            trace: Vec::new(),
            repeats_from: None,
        }));
    }
    if let Some((node, last, clause)) = check.explore()? {
        let mut trace = check.trace_to(node);
        trace.push(last);
        return Ok(Err(Violation {
            clause,
            trace,
            repeats_from: None,
        }));
    }
    Ok(check.liveness()?.map_or(Ok(()), Err))
}

struct Node {
    state: Option<usize>,
    context: Place,
    from: Option<(usize, Vec<i64>)>,
}

struct Check<'a> {
    specification: &'a Specification,
    machine: &'a Machine,
    limits: &'a Limits,
    pool: Pool,
    /// The environment's variables.
    given: Vec<VarId>,
    /// The machine's variables.
    answered: Vec<VarId>,
    /// Whether anything mentions them.
    matters: Vec<bool>,
    contexts: Tree,
    legal: Tree,
    broken: Place,
    /// How many formulas of a context are the environment's rules, and how many the machine's.
    rules: [usize; 2],
    names: Vec<String>,
    start: Place,
    step: Place,
    nodes: Vec<Node>,
    numbers: HashMap<(usize, Place), usize>,
    edges: Vec<Vec<Edge>>,
    labels: Vec<Vec<bool>>,
    label_numbers: HashMap<Vec<bool>, u32>,
    pairs: u64,
    /// The edge whose valuation is looked for, once the product is there.
    wanted: Option<Edge>,
}

/// What is found wrong: the node, the valuation of the step after it, and the clause.
type Wrong = (usize, Vec<i64>, Clause);

/// The answers of one step, being enumerated.
struct Letter<'a> {
    node: usize,
    /// The formulas of the context with the given inputs fixed.
    formulas: Vec<Id>,
    transitions: &'a [Transition],
    /// By depth, the cubes that the answers chosen so far satisfy.
    candidates: Vec<Vec<(usize, &'a Cube)>>,
    next: Vec<i64>,
    edges: Vec<Edge>,
}

impl<'a> Check<'a> {
    fn new(specification: &'a Specification, machine: &'a Machine, limits: &'a Limits) -> Self {
        let given: Vec<VarId> = specification.inputs().collect();
        let answered: Vec<VarId> = specification.outputs().collect();
        let domain = |v: &VarId, time| {
            let domain = &specification.variable(*v).domain;
            (key(v.index(), time), domain.low(), domain.high())
        };
        let mut pool = Pool::default();
        let all = answered.iter().chain(&given);
        let mut contexts = Tree::new(all.map(|v| domain(v, Time::Now)).collect());
        let asked = answered.iter().map(|v| domain(v, Time::Next)).collect();
        let mut legal = Tree::new(asked);
        legal.conjunction = true;
        let no = pool.constant(0);
        let broken = legal.place(&pool, vec![no]);

        let (assumed, guaranteed) = (&specification.assumptions, &specification.guarantees);
        let (mut start, mut step, mut names) = (Vec::new(), Vec::new(), Vec::new());
        let rules = [assumed, guaranteed].map(|side| {
            let before = names.len();
            let yes = pool.constant(1);
            let mut list = |formulas: &[Formula], at_start: bool, at_step: bool| {
                for formula in formulas {
                    let to_come = pool.add(&formula.expr, &|_| Time::Next);
                    let two_steps = pool.add(&formula.expr, &|t| t);
                    start.push(if at_start { to_come } else { yes });
                    step.push(match (at_start, at_step) {
                        (_, false) => yes,
                        (true, true) => to_come,
                        (false, true) => two_steps,
                    });
                    names.push(formula.name.clone());
                }
            };
            list(&side.initial, true, false);
            list(&side.invariants, true, true);
            list(&side.safety, false, true);
            names.len() - before
        });
        for formula in assumed.justice.iter().chain(&guaranteed.justice) {
            start.push(no);
            step.push(pool.add(&formula.expr, &|t| t));
        }
        let mut matters = vec![false; specification.variables.len()];
        for formula in assumed.all().chain(guaranteed.all()) {
            formula
                .expr
                .for_each_var(&mut |v, _| matters[v.index()] = true);
        }
        let lists = std::iter::once(&machine.initial).chain(&machine.states);
        for transition in lists.flatten() {
            for test in transition.guard.0.iter().flat_map(|c| &c.0) {
                if let Some(v) = answered.get(test.input) {
                    matters[v.index()] = true;
                }
            }
        }
        let start = contexts.place(&pool, start);
        let step = contexts.place(&pool, step);
        Self {
            specification,
            machine,
            limits,
            pool,
            given,
            answered,
            matters,
            contexts,
            legal,
            broken,
            rules,
            names,
            start,
            step,
            nodes: Vec::new(),
            numbers: HashMap::new(),
            edges: Vec::new(),
            labels: Vec::new(),
            label_numbers: HashMap::new(),
            pairs: 0,
            wanted: None,
        }
    }

    fn malformed(&self) -> Option<Clause> {
        let fits = |ports: &[crate::mealy::Port], ids: &[VarId]| {
            let variables = ids.iter().map(|v| self.specification.variable(*v));
            ports.len() == ids.len()
                && ports
                    .iter()
                    .zip(variables)
                    .all(|(p, v)| p.name == v.name && p.domain == v.domain)
        };
        if !fits(&self.machine.inputs, &self.answered) || !fits(&self.machine.outputs, &self.given)
        {
            return Some(Clause::Ports);
        }
        if self.machine.timing == self.specification.timing {
            return Some(Clause::Timing);
        }
        let first = self.specification.timing == Timing::Mealy;
        for transitions in std::iter::once(&self.machine.initial).chain(&self.machine.states) {
            if transitions.is_empty() {
                return Some(Clause::Nothing);
            }
            for t in transitions {
                if t.to >= self.machine.states.len() {
                    return Some(Clause::Target);
                }
                if t.output.len() != self.given.len() {
                    return Some(Clause::Values);
                }
                for (port, value) in self.machine.outputs.iter().zip(&t.output) {
                    if !port.domain.contains(*value) {
                        return Some(Clause::Domain(port.name.clone()));
                    }
                }
                let mut tests = t.guard.0.iter().flat_map(|c| &c.0);
                if tests.any(|test| test.input >= self.answered.len()) {
                    return Some(Clause::Guard);
                }
                if first && t.output != transitions[0].output {
                    return Some(Clause::First);
                }
            }
        }
        None
    }

    fn explore(&mut self) -> Result<Option<Wrong>, Limit> {
        self.nodes.push(Node {
            state: None,
            context: self.start,
            from: None,
        });
        let mut current = 0;
        while current < self.nodes.len() {
            let transitions = self.machine.transitions(self.nodes[current].state);
            let first = self.specification.timing == Timing::Mealy;
            let mut edges = Vec::new();
            for group in self.groups(current) {
                if let Some(wrong) = self.answers(current, group, &mut edges)? {
                    return Ok(Some(wrong));
                }
            }
            if !first && let Some(wrong) = self.answered_always(current, transitions)? {
                return Ok(Some(wrong));
            }
            self.edges.push(distinct(edges));
            current += 1;
        }
        Ok(None)
    }

    /// The transitions of a node that give the same. Where the environment moves first, all do and are looked at together.
    fn groups(&self, node: usize) -> Vec<&'a [Transition]> {
        let transitions = self.machine.transitions(self.nodes[node].state);
        match self.specification.timing {
            Timing::Mealy => vec![transitions],
            Timing::Moore => transitions.chunks(1).collect(),
        }
    }

    /// Follows all legal answers to what a group of transitions gives.
    fn answers(
        &mut self,
        node: usize,
        group: &'a [Transition],
        edges: &mut Vec<Edge>,
    ) -> Result<Option<Wrong>, Limit> {
        self.limits.check_time()?;
        let mut next: Vec<i64> = self
            .specification
            .variables
            .iter()
            .map(|v| v.domain.low())
            .collect();
        for (v, value) in self.given.iter().zip(&group[0].output) {
            next[v.index()] = *value;
        }
        let mut formulas = self.contexts.formulas(self.nodes[node].context).to_vec();
        for id in &mut formulas {
            for v in &self.given {
                *id = self
                    .pool
                    .fix(*id, key(v.index(), Time::Next), next[v.index()]);
            }
        }
        // A rule of the environment that is broken whatever the answer is.
        for (index, id) in formulas[..self.rules[0]].iter().enumerate() {
            if self.pool.value(*id) == Some(0) {
                let name = self.names[index].clone();
                return Ok(Some((node, next, Clause::Assumption(name))));
            }
        }
        let machine = formulas[self.rules[0]..self.rules[0] + self.rules[1]].to_vec();
        let place = self.legal.place(&self.pool, machine);
        let cubes = group.iter().enumerate();
        let cubes =
            cubes.flat_map(|(t, transition)| transition.guard.0.iter().map(move |c| (t, c)));
        let mut letter = Letter {
            node,
            formulas,
            transitions: group,
            candidates: vec![Vec::new(); self.answered.len() + 1],
            next,
            edges: Vec::new(),
        };
        letter.candidates[0] = cubes.collect();
        let wrong = self.walk(&mut letter, 0, place)?;
        edges.append(&mut letter.edges);
        Ok(wrong.map(|clause| (node, letter.next, clause)))
    }

    fn walk(
        &mut self,
        letter: &mut Letter<'a>,
        depth: usize,
        place: Place,
    ) -> Result<Option<Clause>, Limit> {
        // Where the machine answers first, the other groups have transitions for these answers.
        let elsewhere = self.specification.timing == Timing::Moore;
        if place == self.broken || elsewhere && letter.candidates[depth].is_empty() {
            return Ok(None);
        }
        let Some(output) = self.answered.get(depth).copied() else {
            return self.leaf(letter);
        };
        let domain = &self.specification.variable(output).domain;
        let high = if self.matters[output.index()] {
            domain.high()
        } else {
            domain.low()
        };
        for value in domain.low()..=high {
            letter.next[output.index()] = value;
            narrow(&mut letter.candidates, depth, value);
            let below = if self.legal.question(place) == Some(depth) {
                self.legal.answer(&mut self.pool, place, value)
            } else {
                place
            };
            let wrong = self.walk(letter, depth + 1, below)?;
            if wrong.is_some() {
                return Ok(wrong);
            }
        }
        Ok(None)
    }

    /// Counts an answer that is looked at.
    fn count(&mut self) -> Result<(), Limit> {
        // To tell what was found costs nothing more.
        if self.wanted.is_some() {
            return Ok(());
        }
        self.pairs += 1;
        if self.pairs > self.limits.most_nodes.unwrap_or(MOST_PAIRS).min(MOST_PAIRS) {
            return Err(Limit::Size);
        }
        if self.pairs.is_multiple_of(1 << 14) {
            self.limits.check_time()?;
        }
        Ok(())
    }

    /// A legal answer.
    fn leaf(&mut self, letter: &mut Letter<'a>) -> Result<Option<Clause>, Limit> {
        self.count()?;
        let next = &letter.next;
        for (index, id) in letter.formulas[..self.rules[0]].iter().enumerate() {
            if self.pool.eval(*id, next) == 0 {
                return Ok(Some(Clause::Assumption(self.names[index].clone())));
            }
        }
        let transition = match letter.candidates[self.answered.len()][..] {
            [] => return Ok(Some(Clause::Unanswered)),
            [(t, _)] => &letter.transitions[t],
            _ => return Ok(Some(Clause::AnsweredTwice)),
        };
        let justice = &letter.formulas[self.rules[0] + self.rules[1]..];
        let label: Vec<bool> = justice
            .iter()
            .map(|id| self.pool.eval(*id, next) != 0)
            .collect();
        let fresh = self.labels.len() as u32;
        let label_number = *self.label_numbers.entry(label.clone()).or_insert(fresh);
        if label_number == fresh {
            self.labels.push(label);
        }
        let context = self.contexts.descend(&mut self.pool, self.step, next);
        let fresh = self.nodes.len();
        let to = *self
            .numbers
            .entry((transition.to, context))
            .or_insert(fresh);
        if to == fresh {
            self.nodes.push(Node {
                state: Some(transition.to),
                context,
                from: Some((letter.node, next.clone())),
            });
        }
        let edge = Edge {
            to,
            label: label_number,
        };
        if self.wanted == Some(edge) {
            // Whatever is given stops the enumeration here.
            return Ok(Some(Clause::Won));
        }
        if letter.edges.last() != Some(&edge) {
            letter.edges.push(edge);
        }
        Ok(None)
    }

    /// Where the machine answers first, the environment has something to give whatever the answer is.
    fn answered_always(
        &mut self,
        node: usize,
        transitions: &'a [Transition],
    ) -> Result<Option<Wrong>, Limit> {
        let cubes = transitions.iter().enumerate();
        let cubes =
            cubes.flat_map(|(t, transition)| transition.guard.0.iter().map(move |c| (t, c)));
        let low = self.specification.variables.iter().map(|v| v.domain.low());
        let mut letter = Letter {
            node,
            formulas: Vec::new(),
            transitions,
            candidates: vec![Vec::new(); self.answered.len() + 1],
            next: low.collect(),
            edges: Vec::new(),
        };
        letter.candidates[0] = cubes.collect();
        let wrong = self.gap(&mut letter, 0)?;
        Ok(wrong.map(|clause| (node, letter.next, clause)))
    }

    /// Looks for an answer below that satisfies no cube, or several.
    fn gap(&mut self, letter: &mut Letter<'a>, depth: usize) -> Result<Option<Clause>, Limit> {
        let here = &letter.candidates[depth];
        if here.is_empty() {
            return Ok(Some(Clause::Unanswered));
        }
        if let [(_, cube)] = here[..]
            && cube.0.iter().all(|t| t.input < depth)
        {
            return Ok(None);
        }
        let Some(output) = self.answered.get(depth).copied() else {
            return Ok(Some(Clause::AnsweredTwice));
        };
        self.count()?;
        let domain = &self.specification.variable(output).domain;
        for value in domain.low()..=domain.high() {
            letter.next[output.index()] = value;
            narrow(&mut letter.candidates, depth, value);
            let wrong = self.gap(letter, depth + 1)?;
            if wrong.is_some() {
                return Ok(wrong);
            }
        }
        Ok(None)
    }

    fn trace_to(&self, mut node: usize) -> Vec<Vec<i64>> {
        let mut trace = Vec::new();
        while let Some((from, valuation)) = &self.nodes[node].from {
            trace.push(valuation.clone());
            node = *from;
        }
        trace.reverse();
        trace
    }

    /// A cycle on which an assumption is starved or all goals are met.
    fn liveness(&mut self) -> Result<Option<Violation>, Limit> {
        let assumed = &self.specification.assumptions.justice;
        let goals = self.specification.guarantees.justice.len();
        let holds = |label: u32, place: usize| self.labels[label as usize][place];
        let met = |label: u32, j: usize| holds(label, assumed.len() + j);
        for (i, formula) in assumed.iter().enumerate() {
            let starved = |label: u32| !holds(label, i);
            let cycle = fair_cycle(&self.edges, 0, &starved, &met, self.limits)?;
            if let Some(cycle) = cycle {
                let clause = Clause::Starved(formula.name.clone());
                return self.violation(clause, &cycle).map(Some);
            }
        }
        match fair_cycle(&self.edges, goals, &|_| true, &met, self.limits)? {
            Some(cycle) => self.violation(Clause::Won, &cycle).map(Some),
            None => Ok(None),
        }
    }

    /// What a cycle shows.
    fn violation(&mut self, clause: Clause, cycle: &[(usize, Edge)]) -> Result<Violation, Limit> {
        let mut trace = self.trace_to(cycle[0].0);
        let repeats_from = Some(trace.len());
        for (from, edge) in cycle {
            self.wanted = Some(*edge);
            for group in self.groups(*from) {
                if let Some((_, valuation, _)) = self.answers(*from, group, &mut Vec::new())? {
                    trace.push(valuation);
                    break;
                }
            }
        }
        Ok(Violation {
            clause,
            trace,
            repeats_from,
        })
    }
}

/// The cubes that still hold when the answer at `depth` is known.
fn narrow(candidates: &mut [Vec<(usize, &Cube)>], depth: usize, value: i64) {
    let (before, after) = candidates.split_at_mut(depth + 1);
    after[0].clear();
    after[0].extend(before[depth].iter().filter(|(_, cube)| {
        let mut tests = cube.0.iter().filter(|t| t.input == depth);
        tests.all(|t| t.low <= value && value <= t.high)
    }));
}
