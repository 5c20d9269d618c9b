//! Encodes rules as functions of bits, and answers queries with them.

use super::aside::{Allowance, BackwardSearch, excludes_cycle};
use super::path::Path;
use super::{Lasso, Rule, RunQuery, SafetyViolationQuery, fair, smallest};
use crate::game::clusters::Clustering;
use crate::game::heuristics::Heuristics;
use crate::game::relation::Relation;
use crate::symbolic::{BitSet, Encoding, Kernel, Limit, Limits, Order};
use linewright_core::gr1::{Expr, FormulaKind, Specification, Time, VarId, Variable};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// How the parts of a relation are combined.
const CLUSTERING: Clustering = Clustering::ByBits(3_000);

/// Number of rings after which the first search for a cycle takes place, before all rings are
/// known.
const FIRST_SEARCH: usize = 6;

/// Factor by which the number of rings grows between two searches.
const SEARCH_FACTOR: usize = 6;

/// Number of cached sets of reachable states.
const CACHED_SETS: usize = 24;

/// The rules as functions, encoded on first use, with a cache of reachable states.
#[derive(Debug)]
pub struct RuleEncoder<K: Kernel> {
    m: K,
    encoding: Encoding,
    variables: Vec<Variable>,
    /// Conjuncts of each rule, by index.
    functions: FxHashMap<usize, Vec<K::Function>>,
    /// Cache of reachable states by rules and variables, the most recently used last.
    reached: Vec<(Vec<usize>, ReachableStates<K>)>,
}

/// The step relation of a query's rules.
#[derive(Debug, Clone)]
pub struct Steps<K: Kernel> {
    /// The kernel.
    pub m: K,
    /// States that satisfy the invariants and domains.
    pub states: K::Function,
    /// States of step 0.
    pub initial: K::Function,
    /// Conjuncts of the relation: safety, and the invariants and domains of the next step.
    parts: Vec<K::Function>,
    /// Relation for forward steps; quantifies current bits.
    forward: Relation<K>,
    /// Relation for backward steps; quantifies next bits.
    backward: Relation<K>,
    /// Current bits of the mentioned variables.
    pub now: BitSet,
    /// Next bits of the mentioned variables.
    pub next: BitSet,
}

/// Reachable states by number of steps.
#[derive(Debug, Clone)]
pub struct ReachableStates<K: Kernel> {
    /// The step relation of the query.
    pub steps: Steps<K>,
    /// The states that are first reached after 0, 1, 2, ... steps.
    pub rings: Vec<K::Function>,
    /// All reachable states so far.
    pub all: K::Function,
    /// Whether all reachable states have been found.
    pub complete: bool,
}

/// A prepared query about infinite runs.
struct LassoSearch<K: Kernel> {
    /// The variables that the query mentions.
    variables: BTreeSet<VarId>,
    /// Key for caching the reachable states.
    key: Vec<usize>,
    /// Reachable states.
    reached: ReachableStates<K>,
    /// The steps that meet none of the justice formulas that are to be met only finitely often.
    steps: Steps<K>,
    /// Justice to be met infinitely often.
    again: Vec<K::Function>,
}

impl<K: Kernel> LassoSearch<K> {
    /// Whether it is known that no run has the properties, even from unreachable states. Searches
    /// for that if the allowance permits it.
    fn excludes_cycle(&self, allowance: &mut Allowance) -> Result<bool, Limit> {
        if self.reached.complete || !allowance.is_due() {
            return Ok(false);
        }
        let excluded = excludes_cycle(&self.steps, &self.again, allowance)?;
        if excluded == Some(false) {
            allowance.end();
        }
        Ok(excluded == Some(true))
    }
}

impl<K: Kernel> ReachableStates<K> {
    /// Computes the next ring; returns false if there are no new states.
    fn grow(&mut self) -> Result<bool, Limit> {
        if self.complete {
            return Ok(false);
        }
        let m = &self.steps.m;
        let last = &self.rings[self.rings.len() - 1];
        let new = m.and_not(&self.steps.after(last)?, &self.all)?;
        if m.is_false(&new) {
            self.complete = true;
            return Ok(false);
        }
        self.all = m.or(&self.all, &new)?;
        self.rings.push(new);
        self.steps.m.safe_point()?;
        Ok(true)
    }

    /// Like [`Self::grow`], with the work recorded in the allowance of a side search.
    fn grow_with(&mut self, allowance: &mut Allowance) -> Result<bool, Limit> {
        let before = self.steps.m.work();
        let more = self.grow()?;
        allowance.add(self.steps.m.work() - before);
        Ok(more)
    }

    /// Returns the number of the first ring that contains states of `goal`, and these states;
    /// `None` if no state of the goal is reachable.
    fn find(&mut self, goal: &K::Function) -> Result<Option<(usize, K::Function)>, Limit> {
        let m = self.steps.m.clone();
        for (number, ring) in self.rings.iter().enumerate() {
            let here = m.and(ring, goal)?;
            if !m.is_false(&here) {
                return Ok(Some((number, here)));
            }
        }
        let mut backward = Some(BackwardSearch::new(goal));
        let mut allowance = Allowance::new();
        loop {
            if let Some(search) = &mut backward
                && allowance.is_due()
                && !self.complete
            {
                match search.step(&self.steps, &mut allowance)? {
                    Some(false) => return Ok(None),
                    // A reachable state leads to the goal: only the exploration can tell how soon.
                    Some(true) if search.meets(&m, &self.all)? => backward = None,
                    Some(true) | None => {}
                }
                continue;
            }
            if !self.grow_with(&mut allowance)? {
                return Ok(None);
            }
            let here = m.and(&self.rings[self.rings.len() - 1], goal)?;
            if !m.is_false(&here) {
                return Ok(Some((self.rings.len() - 1, here)));
            }
        }
    }
}

impl<K: Kernel> Steps<K> {
    /// Returns the successors of these states.
    pub fn after(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.m.unprime(&self.forward.product(&self.m, states)?)
    }

    /// Returns the states after these steps.
    pub fn after_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        self.m.unprime(&self.forward.product(&self.m, steps)?)
    }

    /// Returns the predecessors of these states.
    pub fn before(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.before_step(&self.m.prime(states)?)
    }

    /// Returns the states from which one of these steps is possible.
    pub fn before_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        let found = self.backward.product(&self.m, steps)?;
        self.m.and(&self.states, &found)
    }

    /// Returns the relation restricted to these steps.
    pub fn only(&self, steps: &K::Function) -> Result<Self, Limit> {
        if self.m.is_true(steps) {
            return Ok(self.clone());
        }
        let mut parts = self.parts.clone();
        parts.push(steps.clone());
        self.with_parts(parts)
    }

    /// Returns the same relation on another handle of the same kernel.
    pub fn on(&self, m: K) -> Self {
        Self { m, ..self.clone() }
    }

    fn with_parts(&self, parts: Vec<K::Function>) -> Result<Self, Limit> {
        let (forward, backward) = relations(&self.m, &parts, &self.now, &self.next)?;
        Ok(Self {
            parts,
            forward,
            backward,
            ..self.clone()
        })
    }
}

fn relations<K: Kernel>(
    m: &K,
    parts: &[K::Function],
    now: &BitSet,
    next: &BitSet,
) -> Result<(Relation<K>, Relation<K>), Limit> {
    let heuristics = Heuristics::default();
    Ok((
        Relation::new(m, parts, now, CLUSTERING, heuristics)?,
        Relation::new(m, parts, next, CLUSTERING, heuristics)?,
    ))
}

impl<K: Kernel> RuleEncoder<K> {
    /// Creates an encoder; no rule is encoded yet.
    pub fn new(
        specification: &Specification,
        order: &Order,
        limits: &Limits,
    ) -> Result<Self, Limit> {
        Ok(Self {
            m: K::new(order, limits)?,
            encoding: Encoding::new(specification),
            variables: specification.variables.clone(),
            functions: FxHashMap::default(),
            reached: Vec::new(),
        })
    }

    /// Returns the kernel.
    pub fn kernel(&self) -> &K {
        &self.m
    }

    /// Returns the conjuncts of a rule.
    fn conjuncts(&mut self, rules: &[Rule], index: usize) -> Result<Vec<K::Function>, Limit> {
        if let Some(known) = self.functions.get(&index) {
            return Ok(known.clone());
        }
        let rule = &rules[index];
        let conjuncts = match rule.kind {
            FormulaKind::Safety | FormulaKind::Invariant => rule.expr.conjuncts(),
            FormulaKind::Initial | FormulaKind::Justice => vec![&rule.expr],
        };
        let encoded: Vec<K::Function> = conjuncts
            .into_iter()
            .map(|part| self.encode(part))
            .collect::<Result<_, _>>()?;
        self.functions.insert(index, encoded.clone());
        Ok(encoded)
    }

    /// Encodes a formula, restricted to codes that stand for a value.
    fn encode(&self, part: &Expr) -> Result<K::Function, Limit> {
        let mut function = self.encoding.formula(&self.m, part)?;
        let mut mentioned = BTreeSet::new();
        part.for_each_var(&mut |v, t| {
            mentioned.insert((v, t));
        });
        for (v, t) in mentioned {
            let within = self.encoding.in_domain(&self.m, v, t)?;
            function = self.m.and(&function, &within)?;
        }
        Ok(function)
    }

    /// Returns a rule as a single function.
    pub fn function(&mut self, rules: &[Rule], index: usize) -> Result<K::Function, Limit> {
        let conjuncts = self.conjuncts(rules, index)?;
        self.m.all(&conjuncts)
    }

    /// Returns the valuations that break a rule. The result also contains codes that stand for no
    /// value.
    fn broken(&mut self, rules: &[Rule], index: usize) -> Result<K::Function, Limit> {
        let function = self.function(rules, index)?;
        self.m.not(&function)
    }

    /// Returns the variables that these rules mention.
    fn mentioned(rules: &[Rule], of: impl IntoIterator<Item = usize>) -> BTreeSet<VarId> {
        let mut found = BTreeSet::new();
        for index in of {
            rules[index].expr.for_each_var(&mut |v, _| {
                found.insert(v);
            });
        }
        found
    }

    /// Returns the step relation of the rules `keep` over these variables.
    fn steps(
        &mut self,
        rules: &[Rule],
        keep: &[usize],
        variables: &BTreeSet<VarId>,
    ) -> Result<Steps<K>, Limit> {
        let m = self.m.clone();
        let now = self.encoding.bit_set(variables.iter().copied(), Time::Now);
        let next = self.encoding.bit_set(variables.iter().copied(), Time::Next);
        let mut states = m.constant(true);
        for v in variables.iter().rev() {
            let within = self.encoding.in_domain(&m, *v, Time::Now)?;
            states = m.and(&states, &within)?;
        }
        let mut parts = vec![m.prime(&states)?];
        let mut initial = m.constant(true);
        for index in keep {
            let conjuncts = self.conjuncts(rules, *index)?;
            match rules[*index].kind {
                FormulaKind::Initial => initial = m.and(&initial, &m.all(&conjuncts)?)?,
                FormulaKind::Invariant => {
                    for part in &conjuncts {
                        states = m.and(&states, part)?;
                        parts.push(m.prime(part)?);
                    }
                }
                FormulaKind::Safety => parts.extend(conjuncts),
                FormulaKind::Justice => {}
            }
        }
        let initial = m.and(&states, &initial)?;
        let (forward, backward) = relations(&m, &parts, &now, &next)?;
        Ok(Steps {
            m,
            states,
            initial,
            parts,
            forward,
            backward,
            now,
            next,
        })
    }

    /// Takes the states reachable under the rules `keep` from the cache, as far as they have been
    /// computed, or starts with the initial states. `variables` are those of the whole query. The
    /// caller returns the states to the cache with [`Self::store`].
    fn reach(
        &mut self,
        rules: &[Rule],
        keep: &[usize],
        variables: &BTreeSet<VarId>,
    ) -> Result<(Vec<usize>, ReachableStates<K>), Limit> {
        let mut key: Vec<usize> = keep.to_vec();
        key.sort_unstable();
        key.push(usize::MAX);
        key.extend(variables.iter().map(|v| v.index()));
        if let Some(place) = self.reached.iter().position(|(k, _)| *k == key) {
            return Ok(self.reached.remove(place));
        }
        let steps = self.steps(rules, keep, variables)?;
        let first = steps.initial.clone();
        let reached = ReachableStates {
            all: first.clone(),
            rings: vec![first],
            complete: false,
            steps,
        };
        Ok((key, reached))
    }

    /// Puts reachable states into the cache.
    fn store(&mut self, key: Vec<usize>, reached: ReachableStates<K>) {
        if self.reached.len() >= CACHED_SETS {
            self.reached.remove(0);
        }
        self.reached.push((key, reached));
    }

    /// Prepares a query about infinite runs.
    fn lasso_search(&mut self, rules: &[Rule], query: &RunQuery) -> Result<LassoSearch<K>, Limit> {
        let all = query
            .keep
            .iter()
            .chain(&query.infinitely_often)
            .chain(&query.finitely_often);
        let variables = Self::mentioned(rules, all.copied());
        let (key, reached) = self.reach(rules, &query.keep, &variables)?;
        let mut settled = self.m.constant(true);
        for index in &query.finitely_often {
            let broken = self.broken(rules, *index)?;
            settled = self.m.and(&settled, &broken)?;
        }
        let again = query
            .infinitely_often
            .iter()
            .map(|index| self.function(rules, *index));
        Ok(LassoSearch {
            again: again.collect::<Result<_, _>>()?,
            steps: reached.steps.only(&settled)?,
            variables,
            key,
            reached,
        })
    }

    /// See [`super::Runs::find_lasso`].
    pub fn find_lasso(&mut self, rules: &[Rule], query: &RunQuery) -> Result<Option<Lasso>, Limit> {
        let mut search = self.lasso_search(rules, query)?;
        let (steps, again) = (&search.steps, &search.again);
        let m = self.m.clone();
        // Searches early, since runs are often found near the start.
        let mut next_search = FIRST_SEARCH;
        let mut fair = m.constant(false);
        let mut allowance = Allowance::new();
        loop {
            if search.excludes_cycle(&mut allowance)? {
                break;
            }
            let more = search.reached.grow_with(&mut allowance)?;
            if search.reached.rings.len() == next_search {
                next_search *= SEARCH_FACTOR;
                fair = fair::fair(steps, &search.reached.all, again)?;
            } else if !more {
                // Searches forward first, because that shows more cheaply that no run exists.
                let past = fair::past(steps, &search.reached.all, again)?;
                if !m.is_false(&past) {
                    fair = fair::fair(steps, &search.reached.all, again)?;
                }
            }
            if !more || !m.is_false(&fair) {
                break;
            }
        }
        let found = if m.is_false(&fair) {
            None
        } else {
            let smallest = smallest(&self.variables);
            let path = self.path(&search.variables, &smallest);
            Some(path.lasso(&search.reached, steps, &fair, again)?)
        };
        self.store(search.key, search.reached);
        Ok(found)
    }

    /// See [`super::Runs::has_lasso`]. Callers mostly expect that no run exists, so only one early
    /// search precedes the complete one.
    pub fn lasso_exists(&mut self, rules: &[Rule], query: &RunQuery) -> Result<bool, Limit> {
        let mut search = self.lasso_search(rules, query)?;
        let mut past = self.m.constant(false);
        let mut allowance = Allowance::new();
        loop {
            if search.excludes_cycle(&mut allowance)? {
                break;
            }
            let more = search.reached.grow_with(&mut allowance)?;
            if !more || search.reached.rings.len() == FIRST_SEARCH {
                past = fair::past(&search.steps, &search.reached.all, &search.again)?;
            }
            if !more || !self.m.is_false(&past) {
                break;
            }
        }
        self.store(search.key, search.reached);
        Ok(!self.m.is_false(&past))
    }

    /// See [`super::Runs::dependencies`].
    pub fn find_dependencies(
        &mut self,
        rules: &[Rule],
        keep: &[usize],
        answer: VarId,
        own: &[VarId],
    ) -> Result<Vec<VarId>, Limit> {
        let variables = Self::mentioned(rules, keep.iter().copied());
        if !variables.contains(&answer) {
            return Ok(Vec::new());
        }
        let steps = self.steps(rules, keep, &variables)?;
        let m = self.m.clone();
        let others: Vec<VarId> = own.iter().copied().filter(|v| *v != answer).collect();
        let at = |time| self.encoding.bit_set(others.iter().copied(), time);
        let first = m.exists(&steps.initial, &at(Time::Now))?;
        let later = m.exists(&m.all(&steps.parts)?, &at(Time::Next))?;
        let mut found = Vec::new();
        for v in variables {
            if v == answer || own.contains(&v) {
                continue;
            }
            let matters = |f: &K::Function, time: Time| {
                let mut bits = self.encoding.bits(v, time);
                // A cheap first test. It is not exact, because the function can depend on the bits
                // of a variable only because its domain restricts them.
                bits.any(|bit| m.depends_on(f, bit))
            };
            let within = |time: Time| self.encoding.in_domain(&m, v, time);
            // Compares the answers that are possible for some value with those possible for all
            // values of the variable's domain.
            let differs = |f: &K::Function, time: Time| -> Result<bool, Limit> {
                if !matters(f, time) {
                    return Ok(false);
                }
                let bits = self.encoding.bit_set([v], time);
                let some = m.and_exists(f, &within(time)?, &bits)?;
                let all = m.implies_forall(&within(time)?, f, &bits)?;
                Ok(some != all)
            };
            if differs(&first, Time::Now)? || differs(&later, Time::Next)? {
                found.push(v);
            }
        }
        Ok(found)
    }

    /// See [`super::Runs::find_violation`].
    pub fn find_violation(
        &mut self,
        rules: &[Rule],
        query: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let all = query
            .before
            .iter()
            .chain(&query.last)
            .chain([&query.broken]);
        let variables = Self::mentioned(rules, all.copied());
        let broken = self.broken(rules, query.broken)?;
        let (key, mut reached) = self.reach(rules, &query.before, &variables)?;
        let same_rules = query.before == query.last;
        let is_invariant = rules[query.broken].kind == FormulaKind::Invariant;
        let run = if same_rules && is_invariant {
            self.find_state(&variables, &mut reached, &broken)?
        } else {
            let last = if same_rules {
                reached.steps.clone()
            } else {
                self.steps(rules, &query.last, &variables)?
            };
            let kind = rules[query.broken].kind;
            self.find_step(&variables, &mut reached, &last, (kind, &broken))?
        };
        self.store(key, reached);
        Ok(run)
    }

    /// Returns a shortest run to a state that breaks an invariant. Used for queries whose last step
    /// keeps the same rules as all other steps.
    fn find_state(
        &self,
        variables: &BTreeSet<VarId>,
        reached: &mut ReachableStates<K>,
        broken: &K::Function,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let Some((ring, here)) = reached.find(broken)? else {
            return Ok(None);
        };
        let smallest = smallest(&self.variables);
        let path = self.path(variables, &smallest);
        let run = path.back_to_start(reached, ring, &here)?;
        Ok(Some(run.into_iter().map(|(v, _)| v).collect()))
    }

    /// Returns a shortest run whose last step belongs to `last` and breaks the rule, given by its
    /// kind and the valuations that break it.
    fn find_step(
        &self,
        variables: &BTreeSet<VarId>,
        reached: &mut ReachableStates<K>,
        last: &Steps<K>,
        (kind, broken): (FormulaKind, &K::Function),
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let m = &self.m;
        let bad = match kind {
            FormulaKind::Safety | FormulaKind::Justice => broken.clone(),
            FormulaKind::Initial | FormulaKind::Invariant => {
                let at_once = m.and(&last.initial, broken)?;
                let smallest = smallest(&self.variables);
                if let Some(first) = self.path(variables, &smallest).state(m, &at_once)? {
                    return Ok(Some(vec![first.0]));
                }
                if kind == FormulaKind::Initial {
                    return Ok(None);
                }
                m.prime(broken)?
            }
        };
        // Uses the backward relation without `last.states`, because an invariant that only the last
        // step keeps does not restrict the states before that step.
        let from = last.backward.product(m, &bad)?;
        let Some((ring, here)) = reached.find(&from)? else {
            return Ok(None);
        };
        let last = last.only(&bad)?;
        self.run_with_last_step(variables, reached, (ring, &here), &last)
            .map(Some)
    }

    fn path<'a>(&'a self, variables: &'a BTreeSet<VarId>, smallest: &'a [i64]) -> Path<'a> {
        Path {
            encoding: &self.encoding,
            variables,
            smallest,
        }
    }

    /// See [`super::Runs::count_states`].
    pub fn count_states(&mut self, rules: &[Rule], keep: &[usize]) -> Result<f64, Limit> {
        let variables = Self::mentioned(rules, keep.iter().copied());
        let (key, mut reached) = self.reach(rules, keep, &variables)?;
        while reached.grow()? {}
        let share = self.m.export(&[&reached.all]).shares()[0];
        let bits = reached.steps.now.iter().count();
        self.store(key, reached);
        Ok(share * 2f64.powi(i32::try_from(bits).unwrap_or(i32::MAX)))
    }

    /// Returns a run to a state of `here`, which is a subset of the ring with the number `ring`,
    /// followed by a step of `last`.
    fn run_with_last_step(
        &self,
        variables: &BTreeSet<VarId>,
        reached: &ReachableStates<K>,
        (ring, here): (usize, &K::Function),
        last: &Steps<K>,
    ) -> Result<Vec<Vec<i64>>, Limit> {
        let path = Path {
            encoding: &self.encoding,
            variables,
            smallest: &smallest(&self.variables),
        };
        let run = path.back_to_start(reached, ring, here)?;
        let (_, at) = &run[run.len() - 1];
        let end = path.state(&self.m, &last.after(at)?)?;
        let (end, _) = end.expect("the last step does not exist; please report this");
        let mut values: Vec<Vec<i64>> = run.into_iter().map(|(v, _)| v).collect();
        values.push(end);
        Ok(values)
    }
}
