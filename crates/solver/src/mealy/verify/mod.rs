//! Checks a machine against its specification without the solver: every transition against safety,
//! every fair cycle against justice.
//!
//! The product of the machine with its environment is built explicitly. A node is a state of the
//! machine and a *context*: the formulas that remain once the current values are known
//! (`residual.rs`). So current inputs that no formula mentions, or that matter only under some
//! condition, do not multiply the nodes. Next inputs are enumerated variable by variable, and a
//! branch is cut as soon as an assumption is known to be broken.
//!
//! Justice: if the machine breaks goal `j`, some play never satisfies `j` from some step on and yet
//! meets every assumption infinitely often. Such a play exists exactly if the graph without the
//! transitions that satisfy `j` has a strongly connected component in which every justice
//! assumption is met (`fair.rs`).

mod clause;
mod counter;
mod fair;
mod form;
mod letter;
mod product;
mod residual;

pub use clause::Clause;
pub use counter::verify_counterstrategy;

use super::{Machine, Transition};
use crate::game::{Limit, Limits};
use form::{Rules, malformed};
use letter::{Letter, TransitionMatch};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Specification, Time, VarId};
use product::{Edge, Product};
use residual::{Id, Place, Pool, Tree, key};
use rustc_hash::FxHashMap;
use std::rc::Rc;

/// Maximum number of pairs of a node and an input valuation that are examined.
pub const MAX_PAIRS: u64 = 50_000_000;

/// A violation by a machine or counterstrategy, with a play that shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The violated clause.
    pub clause: Clause,
    /// The valuations of all variables, step by step, up to the violation. If the machine has no
    /// transition, or several, the outputs of the last step are the smallest values of their
    /// domains. Empty if the form of the machine is wrong.
    pub trace: Vec<Vec<i64>>,
    /// For a violation of justice, the index of the step to which the play returns for ever.
    pub repeats_from: Option<usize>,
}

/// Checks a machine. `Ok(Ok(()))` means that the machine keeps its contract. Above [`MAX_PAIRS`] or
/// [`Limits::max_nodes`] examined pairs, the check ends with [`Limit::Size`].
pub fn verify(
    specification: &Specification,
    machine: &Machine,
    limits: &Limits,
) -> Result<Result<(), Violation>, Limit> {
    let mut check = Check::new(specification, machine, limits)?;
    let ports = [&*check.inputs, &*check.outputs];
    if let Some(clause) = malformed(machine, specification, ports, specification.timing) {
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

/// The remaining formulas of a node, grouped by purpose. They mention only next values.
struct Context {
    /// Place in [`Check::legal`] at which the enumeration of legal inputs starts.
    legal: Place,
    /// Place of the remaining guarantees in [`Check::kept`].
    kept: Place,
    /// Place of the justice formulas in [`Check::met`]: the environment's, then the machine's.
    met: Place,
    /// The remaining guarantees, in the order of their names.
    guarantees: Vec<Id>,
}

/// A check in progress.
struct Check<'a> {
    specification: &'a Specification,
    machine: &'a Machine,
    limits: &'a Limits,
    pool: Pool,
    inputs: Vec<VarId>,
    outputs: Vec<VarId>,
    /// Tree that tests current values, outputs first.
    contexts: Tree,
    /// Tree that tests next inputs.
    legal: Tree,
    /// Tree of the guarantees, which tests next values, outputs first.
    kept: Tree,
    /// Tree of the justice formulas, which tests the same values.
    met: Tree,
    /// Number of the environment's formulas in a context, without justice. These formulas come
    /// first.
    assumptions: usize,
    guarantee_names: Vec<String>,
    known: FxHashMap<Place, Rc<Context>>,
    /// Place in `contexts` of the formulas about a later step.
    step: Place,
    product: Product,
    pairs: u64,
    max_pairs: u64,
    /// Place in `legal` at which an assumption is broken.
    broken: Place,
    /// Place in `kept` at which a guarantee is broken.
    violated: Place,
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
        let all = |time| outputs.iter().chain(&inputs).map(move |v| ask(v, time));
        let mut pool = Pool::default();
        let mut contexts = Tree::new(all(Time::Now).collect());
        let mut legal = Tree::new(inputs.iter().map(|v| ask(v, Time::Next)).collect());
        let mut kept = Tree::new(all(Time::Next).collect());
        let met = Tree::new(all(Time::Next).collect());
        legal.conjunction = true;
        kept.conjunction = true;
        let no = pool.constant(0);
        let broken = legal.place(&pool, vec![no]);
        let violated = kept.place(&pool, vec![no]);

        let rules = Rules::of(specification, &mut pool);
        let start = contexts.place(&pool, rules.start);
        let step = contexts.place(&pool, rules.step);
        let assumptions = rules.counts[0];
        Ok(Self {
            specification,
            machine,
            limits,
            pool,
            inputs,
            outputs,
            contexts,
            legal,
            kept,
            met,
            assumptions,
            guarantee_names: rules.names[assumptions..].to_vec(),
            known: FxHashMap::default(),
            step,
            product: Product::new(start),
            pairs: 0,
            max_pairs: limits.max_nodes.unwrap_or(MAX_PAIRS).min(MAX_PAIRS),
            broken,
            violated,
        })
    }

    fn context(&mut self, place: Place) -> Rc<Context> {
        if let Some(known) = self.known.get(&place) {
            return Rc::clone(known);
        }
        let formulas = self.contexts.formulas(place).to_vec();
        let (assumed, rest) = formulas.split_at(self.assumptions);
        let (guaranteed, justice) = rest.split_at(self.guarantee_names.len());
        let context = Rc::new(Context {
            legal: self.legal.place(&self.pool, assumed.to_vec()),
            kept: self.kept.place(&self.pool, guaranteed.to_vec()),
            met: self.met.place(&self.pool, justice.to_vec()),
            guarantees: guaranteed.to_vec(),
        });
        self.known.insert(place, Rc::clone(&context));
        context
    }

    /// Builds the product. Returns the first violation, except violations of justice, which
    /// [`Self::justice`] finds.
    fn explore(&mut self) -> Result<Option<Violation>, Limit> {
        while let Some(current) = self.product.next() {
            let context = self.context(self.product.node(current).1);
            let mut edges: Vec<Edge> = Vec::new();
            let wrong = self.letters(current, &mut |check, transition, next| {
                let kept = check.kept.descend(&mut check.pool, context.kept, next);
                if kept == check.violated {
                    return Some(check.violated_guarantee(&context, next));
                }
                let label = check.label(&context, next);
                let place = check.contexts.descend(&mut check.pool, check.step, next);
                let to = (transition.to, place);
                let edge = check.product.edge(current, next, &label, to);
                if edges.last() != Some(&edge) {
                    edges.push(edge);
                }
                None
            })?;
            if let Some((clause, next)) = wrong {
                let mut trace = self.product.trace_to(current);
                trace.push(next);
                return Ok(Some(Violation {
                    clause,
                    trace,
                    repeats_from: None,
                }));
            }
            self.product.close(edges);
        }
        Ok(None)
    }

    /// The first guarantee that is violated in a step with this valuation, which violates one.
    fn violated_guarantee(&self, context: &Context, next: &[i64]) -> Clause {
        let mut guarantees = context.guarantees.iter().zip(&self.guarantee_names);
        let violated = guarantees.find(|(id, _)| self.pool.eval(**id, next) == 0);
        Clause::Guarantee(violated.map(|(_, name)| name.clone()).unwrap_or_default())
    }

    /// For each justice formula, whether a step with this valuation satisfies it.
    fn label(&mut self, context: &Context, next: &[i64]) -> Vec<bool> {
        let place = self.met.descend(&mut self.pool, context.met, next);
        let known = self.met.formulas(place).iter();
        known.map(|id| self.pool.value(*id) != Some(0)).collect()
    }

    /// Calls `visit` with the machine's transition and the valuation of the next step, for all next
    /// inputs that keep the assumptions. Stops at the first violated clause and returns it with the
    /// valuation. Either `visit` returns the clause, or the number of transitions for an input is
    /// not one.
    fn letters(
        &mut self,
        node: usize,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<Option<(Clause, Vec<i64>)>, Limit> {
        self.limits.check_time()?;
        let (state, context) = self.product.node(node);
        let legal = self.context(context).legal;
        let transitions = self.machine.transitions(state);
        let mut letter = Letter::new(self.specification, transitions, self.inputs.len());
        let broken = self.walk(&mut letter, 0, legal, visit)?;
        Ok(broken.map(|clause| (clause, letter.next)))
    }

    fn walk(
        &mut self,
        letter: &mut Letter<'a>,
        depth: usize,
        place: Place,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<Option<Clause>, Limit> {
        if place == self.broken {
            return Ok(None);
        }
        let Some(input) = self.inputs.get(depth).copied() else {
            return self.leaf(letter, visit);
        };
        let domain = &self.specification.variable(input).domain;
        for value in domain.low()..=domain.high() {
            letter.choose(depth, input, value);
            let below = self.legal.follow(&mut self.pool, place, depth, value);
            let broken = self.walk(letter, depth + 1, below, visit)?;
            if broken.is_some() {
                return Ok(broken);
            }
        }
        Ok(None)
    }

    /// Handles one input valuation that keeps the assumptions.
    fn leaf(
        &mut self,
        letter: &mut Letter<'a>,
        visit: &mut Visit<'_, 'a>,
    ) -> Result<Option<Clause>, Limit> {
        self.pairs += 1;
        if self.pairs > self.max_pairs {
            return Err(Limit::Size);
        }
        if self.pairs.is_multiple_of(1 << 16) {
            self.limits.check_time()?;
        }
        let clause = match letter.taken() {
            TransitionMatch::One(transition) => {
                for (v, value) in self.outputs.iter().zip(&transition.output) {
                    letter.next[v.index()] = *value;
                }
                return Ok(visit(self, transition, &letter.next));
            }
            TransitionMatch::Nothing => Clause::MissingTransition,
            TransitionMatch::Several => Clause::AmbiguousTransition,
        };
        // Resets the outputs that an earlier letter has set.
        for v in &self.outputs {
            letter.next[v.index()] = self.specification.variable(*v).domain.low();
        }
        Ok(Some(clause))
    }

    /// Searches for a play that meets all justice assumptions and breaks a justice guarantee.
    fn justice(&mut self) -> Result<Result<(), Violation>, Limit> {
        let assumed = self.specification.assumptions.justice.len();
        for (j, formula) in self.specification.guarantees.justice.iter().enumerate() {
            let product = &self.product;
            let bad = |label: u32| !product.satisfies(label, assumed + j);
            let fair = |label: u32, i: usize| product.satisfies(label, i);
            let Some(cycle) = fair::fair_cycle(&product.edges, assumed, &bad, &fair, self.limits)?
            else {
                continue;
            };
            let mut trace = product.trace_to(cycle[0].0);
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

    /// Returns a valuation of the step along an edge.
    fn letter_of(&mut self, from: usize, edge: Edge) -> Result<Vec<i64>, Limit> {
        let context = self.context(self.product.node(from).1);
        let target = self.product.node(edge.to);
        let found = self.letters(from, &mut |check, transition, next| {
            let place = check.contexts.descend(&mut check.pool, check.step, next);
            let same = check.label(&context, next) == check.product.labels[edge.label as usize];
            // Any clause would do: it only stops the enumeration.
            (same && target == (Some(transition.to), place)).then_some(Clause::MissingTransition)
        })?;
        Ok(found.map(|(_, next)| next).unwrap_or_default())
    }
}

/// Callback for every legal letter, with the transition and the valuation of the step; returns a
/// violated clause, if any.
type Visit<'v, 'a> = dyn FnMut(&mut Check<'a>, &Transition, &[i64]) -> Option<Clause> + 'v;
