//! Encodes rules as functions of bits, and answers queries with them.

use super::aside::{Allowance, excludes_cycle};
use super::path::Path;
use super::reached::ReachableStates;
use super::steps::Steps;
use super::{Lasso, Rule, RunQuery, SafetyViolationQuery, fair, smallest};
use crate::symbolic::{Encoding, Kernel, Limit, Limits, Order};
use linewright_core::gr1::{Expr, FormulaKind, Specification, Time, VarId, Variable};
use rustc_hash::FxHashMap;
use std::collections::{BTreeSet, VecDeque};

/// Number of rings after which the first search for a cycle takes place, before all rings are
/// known.
const FIRST_SEARCH: usize = 6;

/// Factor by which the number of rings grows between two searches.
const SEARCH_FACTOR: usize = 6;

/// Number of cached sets of reachable states.
const CACHED_SETS: usize = 64;

/// Number of cached sets of states with the past that a query asks for.
const CACHED_PASTS: usize = 32;

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
    /// Cache of the reachable states with the past that a query asks for, see [`fair::past`]; the
    /// oldest first.
    pasts: VecDeque<(RunQuery, K::Function)>,
}

/// Where a rule can be violated for the first time.
enum Violation<K: Kernel> {
    /// In step 0, which has these values.
    AtStart(Vec<i64>),
    /// In these states, some of which are reachable.
    In(K::Function),
    /// In a step of this relation, from a reachable state.
    After(Box<Steps<K>>),
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
    /// States that can have such a run, even unreachable ones, as far as they have been narrowed.
    candidates: K::Function,
}

impl<K: Kernel> LassoSearch<K> {
    /// Whether it is known that no run has the properties, even from unreachable states. Searches
    /// for that if the allowance permits it.
    fn excludes_cycle(&mut self, allowance: &mut Allowance) -> Result<bool, Limit> {
        if self.reached.complete || !allowance.is_due() {
            return Ok(false);
        }
        let excluded = excludes_cycle(&self.steps, &mut self.candidates, &self.again, allowance)?;
        if excluded == Some(false) {
            allowance.end();
        }
        Ok(excluded == Some(true))
    }
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
            pasts: VecDeque::new(),
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
        Ok(Steps::new(m, states, initial, parts, (now, next)))
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
        Ok((key, ReachableStates::new(steps)))
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
            candidates: self.m.constant(true),
            steps: reached.steps.only(&settled),
            variables,
            key,
            reached,
        })
    }

    /// See [`super::Runs::find_lasso`].
    pub fn find_lasso(&mut self, rules: &[Rule], query: &RunQuery) -> Result<Option<Lasso>, Limit> {
        let mut search = self.lasso_search(rules, query)?;
        let (steps, again) = (&search.steps.clone(), &search.again.clone());
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
            if search.reached.depth == next_search {
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
            let path = self.path(&search.variables);
            Some(path.lasso(&mut search.reached, steps, &fair, again)?)
        };
        self.store(search.key, search.reached);
        Ok(found)
    }

    /// See [`super::Runs::has_lasso`]. Callers mostly expect that no run exists, so only one early
    /// search precedes the complete one. The rules of the query are in order.
    pub fn lasso_exists(&mut self, rules: &[Rule], query: &RunQuery) -> Result<bool, Limit> {
        let mut search = self.lasso_search(rules, query)?;
        let possible = self.on_weaker_runs(query);
        let mut past = self.m.constant(false);
        let mut allowance = Allowance::new();
        loop {
            if search.excludes_cycle(&mut allowance)? {
                break;
            }
            let more = search.reached.grow_with(&mut allowance)?;
            if !more || search.reached.depth == FIRST_SEARCH {
                let within = self.m.and(&search.reached.all, &possible)?;
                past = fair::past(&search.steps, &within, &search.again)?;
            }
            if !more || !self.m.is_false(&past) {
                break;
            }
        }
        let exists = !self.m.is_false(&past);
        if exists && search.reached.complete {
            if self.pasts.len() >= CACHED_PASTS {
                self.pasts.pop_front();
            }
            self.pasts.push_back((query.clone(), past));
        }
        self.store(search.key, search.reached);
        Ok(exists)
    }

    /// Returns the states that the last query for some of these properties has found. Only they can
    /// be on runs with all of them.
    fn on_weaker_runs(&self, query: &RunQuery) -> K::Function {
        let mut pasts = self.pasts.iter().rev();
        let weaker = pasts.find(|(weaker, _)| weaker.is_weaker(query));
        weaker.map_or_else(|| self.m.constant(true), |(_, past)| past.clone())
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
        self.with_violation(rules, query, |encoder, variables, reached, violation| {
            let path = encoder.path(variables);
            let states = match violation {
                Violation::AtStart(values) => return Ok(vec![values]),
                Violation::In(states) => path.run_to(reached, &states)?,
                Violation::After(last) => {
                    let from = last.before_any(&encoder.m.constant(true))?;
                    let mut run = path.run_to(reached, &from)?;
                    let (_, at) = &run[run.len() - 1];
                    let end = path.state(&encoder.m, &last.after(at)?)?;
                    run.push(end.expect("the last step does not exist; please report this"));
                    run
                }
            };
            Ok(states.into_iter().map(|(values, _)| values).collect())
        })
    }

    /// See [`super::Runs::has_violation`].
    pub fn violation_exists(
        &mut self,
        rules: &[Rule],
        query: &SafetyViolationQuery,
    ) -> Result<bool, Limit> {
        let found = self.with_violation(rules, query, |_, _, _, _| Ok(()))?;
        Ok(found.is_some())
    }

    /// Searches for the first violation and, if there is one, extracts something from it.
    fn with_violation<T>(
        &mut self,
        rules: &[Rule],
        query: &SafetyViolationQuery,
        extract: impl FnOnce(
            &Self,
            &BTreeSet<VarId>,
            &mut ReachableStates<K>,
            Violation<K>,
        ) -> Result<T, Limit>,
    ) -> Result<Option<T>, Limit> {
        let all = query
            .before
            .iter()
            .chain(&query.last)
            .chain([&query.broken]);
        let variables = Self::mentioned(rules, all.copied());
        let kind = rules[query.broken].kind;
        let broken = self.broken(rules, query.broken)?;
        let (key, mut reached) = self.reach(rules, &query.before, &variables)?;
        let same_rules = query.before == query.last;
        let violation = if same_rules && kind == FormulaKind::Invariant {
            reached.meets(&broken)?.then(|| Violation::In(broken))
        } else {
            let last = if same_rules {
                reached.steps.clone()
            } else {
                self.steps(rules, &query.last, &variables)?
            };
            self.violating_step(&variables, &mut reached, &last, (kind, &broken))?
        };
        let extracted = match violation {
            Some(violation) => Some(extract(self, &variables, &mut reached, violation)?),
            None => None,
        };
        self.store(key, reached);
        Ok(extracted)
    }

    /// Returns the first violation in a step of `last`. The rule is given by its kind and the
    /// valuations that break it.
    fn violating_step(
        &self,
        variables: &BTreeSet<VarId>,
        reached: &mut ReachableStates<K>,
        last: &Steps<K>,
        (kind, broken): (FormulaKind, &K::Function),
    ) -> Result<Option<Violation<K>>, Limit> {
        let m = &self.m;
        let bad = match kind {
            FormulaKind::Safety | FormulaKind::Justice => broken.clone(),
            FormulaKind::Initial | FormulaKind::Invariant => {
                let at_once = m.and(&last.initial, broken)?;
                if let Some((first, _)) = self.path(variables).state(m, &at_once)? {
                    return Ok(Some(Violation::AtStart(first)));
                }
                if kind == FormulaKind::Initial {
                    return Ok(None);
                }
                m.prime(broken)?
            }
        };
        let found = reached.meets_step(last, &bad)?;
        Ok(found.then(|| Violation::After(Box::new(last.only(&bad)))))
    }

    fn path<'a>(&'a self, variables: &'a BTreeSet<VarId>) -> Path<'a> {
        Path {
            encoding: &self.encoding,
            variables,
            smallest: smallest(&self.variables),
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
}
