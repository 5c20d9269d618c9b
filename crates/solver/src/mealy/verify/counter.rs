//! Checks a counterstrategy against the specification without the solver: the environment keeps its
//! safety for all answers of the machine, every legal answer has a transition, every play meets all
//! justice assumptions, and no play meets all of the machine's goals.
//!
//! The product of the counterstrategy with all machines is built explicitly, as in
//! [`super::verify`] with swapped roles: a node is a state with the formulas that remain once the
//! current values are known. Answers are enumerated output by output, and a branch is cut as soon
//! as a guarantee is known to be broken. Outputs that neither a formula nor a guard mentions keep
//! their smallest value.
//!
//! Liveness: every cycle meets each justice assumption, and no strongly connected component meets
//! all goals.

use super::fair::fair_cycle;
use super::form::{Rules, malformed};
use super::letter::{Letter, TransitionMatch};
use super::product::{Edge, Product};
use super::residual::{Id, Place, Pool, Tree, key};
use super::{Clause, MAX_PAIRS, Violation};
use crate::game::{Limit, Limits};
use crate::mealy::{Machine, Transition};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Specification, Time, Timing, VarId};

/// Checks a counterstrategy. `Ok(Ok(()))` means that, against every machine, the counterstrategy
/// keeps all assumptions of the specification and the machine breaks a guarantee. Limits are those
/// of [`super::verify`].
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
        let mut trace = check.product.trace_to(node);
        trace.push(last);
        return Ok(Err(Violation {
            clause,
            trace,
            repeats_from: None,
        }));
    }
    Ok(check.liveness()?.map_or(Ok(()), Err))
}

/// A check in progress.
struct Check<'a> {
    specification: &'a Specification,
    machine: &'a Machine,
    limits: &'a Limits,
    pool: Pool,
    /// The environment's variables.
    given: Vec<VarId>,
    /// The machine's variables.
    answered: Vec<VarId>,
    /// For each variable, whether a formula or a guard mentions it.
    matters: Vec<bool>,
    contexts: Tree,
    legal: Tree,
    broken: Place,
    /// Numbers of the environment's and of the machine's formulas in a context, without justice.
    rules: [usize; 2],
    names: Vec<String>,
    step: Place,
    product: Product,
    pairs: u64,
    /// Edge whose valuation is searched for, once the product is complete.
    wanted: Option<Edge>,
}

/// A violation: the node, the valuation of the next step, and the clause.
type ClauseViolation = (usize, Vec<i64>, Clause);

/// State of the enumeration of a step's answers.
struct Answers<'a> {
    node: usize,
    /// Formulas of the context with the environment's values fixed.
    formulas: Vec<Id>,
    letter: Letter<'a>,
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

        let mut matters = vec![false; specification.variables.len()];
        let assumed = specification.assumptions.all();
        for formula in assumed.chain(specification.guarantees.all()) {
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
        let rules = Rules::of(specification, &mut pool);
        let start = contexts.place(&pool, rules.start);
        let step = contexts.place(&pool, rules.step);
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
            rules: rules.counts,
            names: rules.names,
            step,
            product: Product::new(start),
            pairs: 0,
            wanted: None,
        }
    }

    /// Returns the clause that the form of the counterstrategy violates, if any.
    fn malformed(&self) -> Option<Clause> {
        // A counterstrategy has the opposite timing of the contract.
        let timing = match self.specification.timing {
            Timing::Mealy => Timing::Moore,
            Timing::Moore => Timing::Mealy,
        };
        let ports = [&*self.answered, &*self.given];
        let mut lists = std::iter::once(&self.machine.initial).chain(&self.machine.states);
        malformed(self.machine, self.specification, ports, timing)
            .or_else(|| lists.any(Vec::is_empty).then_some(Clause::NoTransition))
    }

    /// Builds the product. Returns the first violation, except violations of liveness, which
    /// [`Self::liveness`] finds.
    fn explore(&mut self) -> Result<Option<ClauseViolation>, Limit> {
        while let Some(current) = self.product.next() {
            let transitions = self.machine.transitions(self.product.node(current).0);
            let first = self.specification.timing == Timing::Mealy;
            let mut edges = Vec::new();
            for group in self.groups(current) {
                if let Some(wrong) = self.answers(current, group, &mut edges)? {
                    return Ok(Some(wrong));
                }
            }
            if !first && let Some(wrong) = self.check_all_answered(current, transitions)? {
                return Ok(Some(wrong));
            }
            self.product.close(edges);
        }
        Ok(None)
    }

    /// Groups the transitions of a node by the environment's values. If the environment moves
    /// first, all transitions have the same values and form one group; otherwise each transition is
    /// a group of its own.
    fn groups(&self, node: usize) -> Vec<&'a [Transition]> {
        let transitions = self.machine.transitions(self.product.node(node).0);
        match self.specification.timing {
            Timing::Mealy => vec![transitions],
            Timing::Moore => transitions.chunks(1).collect(),
        }
    }

    /// Follows all legal answers to the values of a group of transitions.
    fn answers(
        &mut self,
        node: usize,
        group: &'a [Transition],
        edges: &mut Vec<Edge>,
    ) -> Result<Option<ClauseViolation>, Limit> {
        self.limits.check_time()?;
        let mut letter = Letter::new(self.specification, group, self.answered.len());
        for (v, value) in self.given.iter().zip(&group[0].output) {
            letter.next[v.index()] = *value;
        }
        let context = self.product.node(node).1;
        let mut formulas = self.contexts.formulas(context).to_vec();
        for id in &mut formulas {
            for v in &self.given {
                let value = letter.next[v.index()];
                *id = self.pool.fix(*id, key(v.index(), Time::Next), value);
            }
        }
        // Checks whether every answer breaks the same formula of the environment.
        for (index, id) in formulas[..self.rules[0]].iter().enumerate() {
            if self.pool.value(*id) == Some(0) {
                let name = self.names[index].clone();
                return Ok(Some((node, letter.next, Clause::Assumption(name))));
            }
        }
        let machine = formulas[self.rules[0]..self.rules[0] + self.rules[1]].to_vec();
        let place = self.legal.place(&self.pool, machine);
        let mut answers = Answers {
            node,
            formulas,
            letter,
            edges: Vec::new(),
        };
        let wrong = self.walk(&mut answers, 0, place)?;
        edges.append(&mut answers.edges);
        Ok(wrong.map(|clause| (node, answers.letter.next, clause)))
    }

    fn walk(
        &mut self,
        answers: &mut Answers<'a>,
        depth: usize,
        place: Place,
    ) -> Result<Option<Clause>, Limit> {
        // If the machine moves first, the transitions for other answers are in other groups.
        let elsewhere = self.specification.timing == Timing::Moore;
        if place == self.broken || elsewhere && answers.letter.candidates(depth).is_empty() {
            return Ok(None);
        }
        let Some(output) = self.answered.get(depth).copied() else {
            return self.leaf(answers);
        };
        let domain = &self.specification.variable(output).domain;
        let high = if self.matters[output.index()] {
            domain.high()
        } else {
            domain.low()
        };
        for value in domain.low()..=high {
            answers.letter.choose(depth, output, value);
            let below = self.legal.follow(&mut self.pool, place, depth, value);
            let wrong = self.walk(answers, depth + 1, below)?;
            if wrong.is_some() {
                return Ok(wrong);
            }
        }
        Ok(None)
    }

    /// Counts an examined answer; fails above the maximum number.
    fn count(&mut self) -> Result<(), Limit> {
        // The search for the valuation of a known edge is not limited.
        if self.wanted.is_some() {
            return Ok(());
        }
        self.pairs += 1;
        if self.pairs > self.limits.max_nodes.unwrap_or(MAX_PAIRS).min(MAX_PAIRS) {
            return Err(Limit::Size);
        }
        if self.pairs.is_multiple_of(1 << 14) {
            self.limits.check_time()?;
        }
        Ok(())
    }

    /// Handles one legal answer.
    fn leaf(&mut self, answers: &mut Answers<'a>) -> Result<Option<Clause>, Limit> {
        self.count()?;
        let next = &answers.letter.next;
        for (index, id) in answers.formulas[..self.rules[0]].iter().enumerate() {
            if self.pool.eval(*id, next) == 0 {
                return Ok(Some(Clause::Assumption(self.names[index].clone())));
            }
        }
        let transition = match answers.letter.taken() {
            TransitionMatch::One(transition) => transition,
            TransitionMatch::Nothing => return Ok(Some(Clause::Unanswered)),
            TransitionMatch::Several => return Ok(Some(Clause::AnsweredTwice)),
        };
        let justice = &answers.formulas[self.rules[0] + self.rules[1]..];
        let label: Vec<bool> = justice
            .iter()
            .map(|id| self.pool.eval(*id, next) != 0)
            .collect();
        let context = self.contexts.descend(&mut self.pool, self.step, next);
        let to = (transition.to, context);
        let edge = self.product.edge(answers.node, next, &label, to);
        if self.wanted == Some(edge) {
            // Any clause would do: it only stops the enumeration.
            return Ok(Some(Clause::MachineWins));
        }
        if answers.edges.last() != Some(&edge) {
            answers.edges.push(edge);
        }
        Ok(None)
    }

    /// Checks that every answer has exactly one transition. Used if the machine moves first.
    fn check_all_answered(
        &mut self,
        node: usize,
        transitions: &'a [Transition],
    ) -> Result<Option<ClauseViolation>, Limit> {
        let mut letter = Letter::new(self.specification, transitions, self.answered.len());
        let wrong = self.gap(&mut letter, 0)?;
        Ok(wrong.map(|clause| (node, letter.next, clause)))
    }

    /// Searches for an answer that starts with the `depth` chosen values and satisfies either no
    /// cube or several cubes.
    fn gap(&mut self, letter: &mut Letter<'a>, depth: usize) -> Result<Option<Clause>, Limit> {
        let here = letter.candidates(depth);
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
            letter.choose(depth, output, value);
            let wrong = self.gap(letter, depth + 1)?;
            if wrong.is_some() {
                return Ok(wrong);
            }
        }
        Ok(None)
    }

    /// Searches for a cycle that never meets an assumption or meets all goals.
    fn liveness(&mut self) -> Result<Option<Violation>, Limit> {
        let assumed = &self.specification.assumptions.justice;
        let goals = self.specification.guarantees.justice.len();
        let product = &self.product;
        let met = |label: u32, j: usize| product.satisfies(label, assumed.len() + j);
        for (i, formula) in assumed.iter().enumerate() {
            let starved = |label: u32| !product.satisfies(label, i);
            let cycle = fair_cycle(&product.edges, 0, &starved, &met, self.limits)?;
            if let Some(cycle) = cycle {
                let clause = Clause::StarvedAssumption(formula.name.clone());
                return self.violation(clause, &cycle).map(Some);
            }
        }
        match fair_cycle(&product.edges, goals, &|_| true, &met, self.limits)? {
            Some(cycle) => self.violation(Clause::MachineWins, &cycle).map(Some),
            None => Ok(None),
        }
    }

    /// Returns the violation that a cycle shows.
    fn violation(&mut self, clause: Clause, cycle: &[(usize, Edge)]) -> Result<Violation, Limit> {
        let mut trace = self.product.trace_to(cycle[0].0);
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
