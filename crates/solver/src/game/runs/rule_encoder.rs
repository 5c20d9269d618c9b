//! Encodes rules as functions of bits, combined for one question.

use super::path::Path;
use super::{Lasso, Rule, RuleKind, RunQuery, SafetyViolationQuery, fair, smallest};
use crate::game::clusters::Clustering;
use crate::game::heuristics::Heuristics;
use crate::game::relation::Relation;
use crate::symbolic::{BitSet, Encoding, Kernel, Limit, Limits, Order};
use linewright_core::gr1::{Expr, Specification, Time, VarId, Variable};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// How the parts of a relation are combined.
const CLUSTERING: Clustering = Clustering::ByBits(3_000);

/// Number of rings after which a cycle is first searched, although there may be more rings.
const FIRST_LOOK: usize = 6;

/// Factor by which the number of rings grows until the next search.
const LOOK_AGAIN: usize = 6;

/// Number of cached sets of reachable states.
const REMEMBERED: usize = 24;

/// Functions of rules, created on first use.
#[derive(Debug)]
pub struct RuleEncoder<K: Kernel> {
    m: K,
    encoding: Encoding,
    variables: Vec<Variable>,
    /// Conjuncts by rule.
    functions: FxHashMap<usize, Vec<K::Function>>,
    /// Reachable states by set of rules, the latest last.
    reached: Vec<(Vec<usize>, ReachableStates<K>)>,
}

/// The step relation of a question's rules.
#[derive(Debug, Clone)]
pub struct Steps<K: Kernel> {
    /// The kernel.
    pub m: K,
    /// States that keep invariants and domains.
    pub states: K::Function,
    /// States of step 0.
    pub initial: K::Function,
    /// Safety, and invariants of the next step, as parts.
    parts: Vec<K::Function>,
    /// For forward steps: current bits are quantified.
    forward: Relation<K>,
    /// For backward steps: next bits are quantified.
    backward: Relation<K>,
    /// Current bits of the variables that occur.
    pub now: BitSet,
    /// Their next bits.
    pub next: BitSet,
}

/// Reachable states by number of steps.
#[derive(Debug, Clone)]
pub struct ReachableStates<K: Kernel> {
    /// The step relation of the question.
    pub steps: Steps<K>,
    /// States by the number of steps after which they are first reached.
    pub rings: Vec<K::Function>,
    /// All reachable states so far.
    pub all: K::Function,
    /// Whether there are no more.
    pub complete: bool,
}

/// A question about infinite runs.
struct Question<K: Kernel> {
    /// The variables that it mentions.
    variables: BTreeSet<VarId>,
    /// Key for caching the reachable states.
    key: Vec<usize>,
    /// Reachable states.
    reached: ReachableStates<K>,
    /// The steps after which no justice is met that must not be met again.
    steps: Steps<K>,
    /// Justice that is met again and again.
    again: Vec<K::Function>,
}

impl<K: Kernel> ReachableStates<K> {
    /// Adds a ring; returns whether there was one.
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
}

impl<K: Kernel> Steps<K> {
    /// The states after a step from one of these.
    pub fn after(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.m.unprime(&self.forward.product(&self.m, states)?)
    }

    /// The states after one of these steps.
    pub fn after_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        self.m.unprime(&self.forward.product(&self.m, steps)?)
    }

    /// The states before a step into one of these.
    pub fn before(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.before_step(&self.m.prime(states)?)
    }

    /// The states from which some step is one of these steps.
    pub fn before_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        let found = self.backward.product(&self.m, steps)?;
        self.m.and(&self.states, &found)
    }

    /// Restricts the relation to these steps.
    pub fn only(&self, steps: &K::Function) -> Result<Self, Limit> {
        if self.m.is_true(steps) {
            return Ok(self.clone());
        }
        let mut parts = self.parts.clone();
        parts.push(steps.clone());
        self.with_parts(parts)
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
    /// Creates an encoder without functions.
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

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.m
    }

    /// The conjuncts of a rule.
    fn conjuncts(&mut self, rules: &[Rule], index: usize) -> Result<Vec<K::Function>, Limit> {
        if let Some(known) = self.functions.get(&index) {
            return Ok(known.clone());
        }
        let rule = &rules[index];
        let conjuncts = match rule.kind {
            RuleKind::Safety | RuleKind::Invariant => rule.expr.conjuncts(),
            RuleKind::Initial | RuleKind::Justice => vec![&rule.expr],
        };
        let encoded: Vec<K::Function> = conjuncts
            .into_iter()
            .map(|part| self.encode(part))
            .collect::<Result<_, _>>()?;
        self.functions.insert(index, encoded.clone());
        Ok(encoded)
    }

    /// A formula, restricted to codes that have a value.
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

    /// A rule as a single function.
    pub fn function(&mut self, rules: &[Rule], index: usize) -> Result<K::Function, Limit> {
        let conjuncts = self.conjuncts(rules, index)?;
        self.m.all(&conjuncts)
    }

    /// The codes with values where a rule is broken.
    fn broken(&mut self, rules: &[Rule], index: usize) -> Result<K::Function, Limit> {
        let function = self.function(rules, index)?;
        self.m.not(&function)
    }

    /// The variables that some rules mention.
    fn mentioned(rules: &[Rule], of: impl IntoIterator<Item = usize>) -> BTreeSet<VarId> {
        let mut found = BTreeSet::new();
        for index in of {
            rules[index].expr.for_each_var(&mut |v, _| {
                found.insert(v);
            });
        }
        found
    }

    /// The step relation of these rules over these variables.
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
                RuleKind::Initial => initial = m.and(&initial, &m.all(&conjuncts)?)?,
                RuleKind::Invariant => {
                    for part in &conjuncts {
                        states = m.and(&states, part)?;
                        parts.push(m.prime(part)?);
                    }
                }
                RuleKind::Safety => parts.extend(conjuncts),
                RuleKind::Justice => {}
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

    /// The states reachable under these rules, as far as computed before; at least the initial
    /// states. `variables` are those of the whole question. A caller that continues the computation
    /// returns the result with [`Self::remember`].
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

    fn remember(&mut self, key: Vec<usize>, reached: ReachableStates<K>) {
        if self.reached.len() >= REMEMBERED {
            self.reached.remove(0);
        }
        self.reached.push((key, reached));
    }

    /// Prepares a question about infinite runs.
    fn question(&mut self, rules: &[Rule], wanted: &RunQuery) -> Result<Question<K>, Limit> {
        let all = wanted
            .keep
            .iter()
            .chain(&wanted.again)
            .chain(&wanted.never_again);
        let variables = Self::mentioned(rules, all.copied());
        let (key, reached) = self.reach(rules, &wanted.keep, &variables)?;
        let mut settled = self.m.constant(true);
        for index in &wanted.never_again {
            let broken = self.broken(rules, *index)?;
            settled = self.m.and(&settled, &broken)?;
        }
        let again = wanted
            .again
            .iter()
            .map(|index| self.function(rules, *index));
        Ok(Question {
            again: again.collect::<Result<_, _>>()?,
            steps: reached.steps.only(&settled)?,
            variables,
            key,
            reached,
        })
    }

    /// See [`super::Runs::lasso`].
    pub fn find_lasso(
        &mut self,
        rules: &[Rule],
        wanted: &RunQuery,
    ) -> Result<Option<Lasso>, Limit> {
        let mut asked = self.question(rules, wanted)?;
        let (steps, again) = (&asked.steps, &asked.again);
        let m = self.m.clone();
        // Runs are often found near the start.
        let mut next_look = FIRST_LOOK;
        let mut fair = m.constant(false);
        loop {
            let more = asked.reached.grow()?;
            if asked.reached.rings.len() == next_look {
                next_look *= LOOK_AGAIN;
                fair = fair::fair(steps, &asked.reached.all, again)?;
            } else if !more {
                // Forward search shows more cheaply that there is no run.
                let past = fair::past(steps, &asked.reached.all, again)?;
                if !m.is_false(&past) {
                    fair = fair::fair(steps, &asked.reached.all, again)?;
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
            let path = self.path(&asked.variables, &smallest);
            Some(path.lasso(&asked.reached, steps, &fair, again)?)
        };
        self.remember(asked.key, asked.reached);
        Ok(found)
    }

    /// See [`super::Runs::any_lasso`]. Callers mostly expect that there is no run: so there is one
    /// early search, and then a complete one.
    pub fn is_any_lasso(&mut self, rules: &[Rule], wanted: &RunQuery) -> Result<bool, Limit> {
        let mut asked = self.question(rules, wanted)?;
        let mut past = self.m.constant(false);
        loop {
            let more = asked.reached.grow()?;
            if !more || asked.reached.rings.len() == FIRST_LOOK {
                past = fair::past(&asked.steps, &asked.reached.all, &asked.again)?;
            }
            if !more || !self.m.is_false(&past) {
                break;
            }
        }
        self.remember(asked.key, asked.reached);
        Ok(!self.m.is_false(&past))
    }

    /// See [`super::Runs::depends`].
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
                // A domain whose size is no power of two is mentioned, but does not matter.
                bits.any(|bit| m.depends_on(f, bit))
            };
            let within = |time: Time| self.encoding.in_domain(&m, v, time);
            // Compared where the variable has a value: either the answers are the same for all of
            // its values, or they are not.
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

    /// See [`super::Runs::step`].
    pub fn find_slip(
        &mut self,
        rules: &[Rule],
        slip: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let all = slip.before.iter().chain(&slip.last).chain([&slip.broken]);
        let variables = Self::mentioned(rules, all.copied());
        let broken = self.broken(rules, slip.broken)?;
        let (key, mut reached) = self.reach(rules, &slip.before, &variables)?;
        let alike = slip.before == slip.last;
        let state = rules[slip.broken].kind == RuleKind::Invariant;
        let run = if alike && state {
            self.find_state(&variables, &mut reached, &broken)?
        } else {
            let last = if alike {
                reached.steps.clone()
            } else {
                self.steps(rules, &slip.last, &variables)?
            };
            let kind = rules[slip.broken].kind;
            self.find_step(&variables, &mut reached, &last, (kind, &broken))?
        };
        self.remember(key, reached);
        Ok(run)
    }

    /// A shortest run to a state that breaks an invariant, where the last step keeps what all
    /// others do.
    fn find_state(
        &self,
        variables: &BTreeSet<VarId>,
        reached: &mut ReachableStates<K>,
        broken: &K::Function,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let mut ring = 0;
        loop {
            let here = self.m.and(&reached.rings[ring], broken)?;
            if !self.m.is_false(&here) {
                let smallest = smallest(&self.variables);
                let run = self
                    .path(variables, &smallest)
                    .back_to_start(reached, ring, &here)?;
                return Ok(Some(run.into_iter().map(|(v, _)| v).collect()));
            }
            ring += 1;
            if ring == reached.rings.len() && !reached.grow()? {
                return Ok(None);
            }
        }
    }

    /// A shortest run to a last step, restricted to `last`, that breaks a rule of this kind.
    fn find_step(
        &self,
        variables: &BTreeSet<VarId>,
        reached: &mut ReachableStates<K>,
        last: &Steps<K>,
        (kind, broken): (RuleKind, &K::Function),
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let m = &self.m;
        let bad = match kind {
            RuleKind::Safety | RuleKind::Justice => broken.clone(),
            RuleKind::Initial | RuleKind::Invariant => {
                let at_once = m.and(&last.initial, broken)?;
                let smallest = smallest(&self.variables);
                if let Some(first) = self.path(variables, &smallest).state(m, &at_once)? {
                    return Ok(Some(vec![first.0]));
                }
                if kind == RuleKind::Initial {
                    return Ok(None);
                }
                m.prime(broken)?
            }
        };
        // An invariant kept only by the last step does not restrict the states before it.
        let from = last.backward.product(m, &bad)?;
        let mut ring = 0;
        loop {
            let here = m.and(&reached.rings[ring], &from)?;
            if !m.is_false(&here) {
                let last = last.only(&bad)?;
                return self
                    .up_to(variables, reached, (ring, &here), &last)
                    .map(Some);
            }
            ring += 1;
            if ring == reached.rings.len() && !reached.grow()? {
                return Ok(None);
            }
        }
    }

    fn path<'a>(&'a self, variables: &'a BTreeSet<VarId>, smallest: &'a [i64]) -> Path<'a> {
        Path {
            encoding: &self.encoding,
            variables,
            smallest,
        }
    }

    /// See [`super::Runs::count`].
    pub fn count_states(&mut self, rules: &[Rule], keep: &[usize]) -> Result<f64, Limit> {
        let variables = Self::mentioned(rules, keep.iter().copied());
        let (key, mut reached) = self.reach(rules, keep, &variables)?;
        while reached.grow()? {}
        let share = self.m.export(&[&reached.all]).shares()[0];
        let bits = reached.steps.now.iter().count();
        self.remember(key, reached);
        Ok(share * 2f64.powi(i32::try_from(bits).unwrap_or(i32::MAX)))
    }

    /// A run to a state in a ring, followed by one more step.
    fn up_to(
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
        let (end, _) = end.expect("a step out of what was found; please report this");
        let mut values: Vec<Vec<i64>> = run.into_iter().map(|(v, _)| v).collect();
        values.push(end);
        Ok(values)
    }
}
