//! Proof of each obligation: what it follows from, or how it is broken.

use super::super::system::{ContractSide, FormulaRef, System};
use super::book::{ProofRules, latest};
use super::loops::AnswerDependencies;
use super::{Claim, Discharge, DischargeRule, Exports, Open, Proof, Refutation};
use linewright_core::gr1::{Expr, Time};
use linewright_solver::game::{Limit, Limits, Rule, RuleKind, SafetyViolationQuery, quick_xplain};
use std::collections::{BTreeMap, BTreeSet};

/// Number of rings of rules that count as near.
const NEAR: usize = 1;

/// No limit on the number of rings.
pub(super) const ALL: usize = usize::MAX;

/// State of a proof.
pub struct Prover<'a> {
    pub(super) book: ProofRules<'a>,
    pub(super) claim: &'a Claim,
    /// Order in which parts answer in a step.
    order: Order,
    /// Assumptions handed on to the environment, by rule.
    pub(super) exported: Vec<usize>,
    /// Formulas of the goal that were shown: justice of the goal may rest on them.
    pub(super) shown: Vec<usize>,
    /// Those of `shown` that are kept step by step, also on runs that cannot go on.
    pub(super) kept: BTreeSet<usize>,
    /// Whether reasons must be minimal, and not only sufficient.
    minimal: bool,
    /// Whether the goal's safety has to be kept step by step.
    pub(super) stepwise: bool,
    pub(super) proof: Proof,
}

/// An order in which the parts may answer within a step.
#[derive(Debug, Default)]
struct Order {
    /// Place of every part. Parts in one place wait for one another, or may do so.
    places: Vec<usize>,
    /// For parts in one place, those that were found to come earlier.
    sooner: BTreeMap<usize, BTreeSet<usize>>,
}

impl Order {
    /// Returns whether one part's answer may be relied on when another's inputs are checked.
    fn is_before(&self, first: usize, second: usize) -> bool {
        self.places[first] < self.places[second]
            || self.sooner.get(&second).is_some_and(|s| s.contains(&first))
    }
}

/// Result for one obligation.
pub(super) enum ObligationResult {
    /// It follows from these rules.
    Follows(Vec<usize>),
    /// It does not follow, as this counterexample shows.
    Fails(Refutation),
}

impl<'a> Prover<'a> {
    /// Creates the state at the beginning of a proof.
    pub fn new(system: &'a System, claim: &'a Claim, limits: &Limits) -> Result<Self, Limit> {
        Ok(Self {
            book: ProofRules::new(system, claim, limits)?,
            claim,
            order: Order::default(),
            exported: Vec::new(),
            shown: Vec::new(),
            kept: BTreeSet::new(),
            minimal: true,
            stepwise: false,
            proof: Proof::default(),
        })
    }

    /// Accepts sufficient reasons instead of minimal ones.
    pub fn quick(self) -> Self {
        Self {
            minimal: false,
            ..self
        }
    }

    /// Requires safety of the goal to be kept step by step, also on runs that cannot go on.
    pub fn stepwise(self) -> Self {
        Self {
            stepwise: true,
            ..self
        }
    }

    /// Runs the proof.
    pub fn prove(mut self) -> Result<Proof, Limit> {
        let waits = AnswerDependencies::new(&mut self.book)?;
        self.proof.loops = waits.loops();
        if !self.proof.loops.is_empty() {
            return Ok(self.proof);
        }
        self.order = self.order_of(&waits);
        self.safety()?;
        let reliable = self.justice()?;
        self.goal(&reliable)?;
        self.proof.discharges.sort_by_key(|d| place(d.what));
        self.proof.open.sort_by_key(|o| place(o.what));
        Ok(self.proof)
    }

    // ---- order of answers -----------------------------------------------------------------------

    /// Computes the order: a part comes after those whose answers its own wait for, and after those
    /// that its assumptions mention.
    fn order_of(&self, waits: &AnswerDependencies) -> Order {
        let system = self.book.system;
        let mut edges = waits.parts.clone();
        for (i, part) in system.parts.iter().enumerate() {
            for (kind, _, formula) in super::super::system::formulas(&part.assumptions) {
                if kind != RuleKind::Justice {
                    let read = latest(&formula.expr, kind);
                    let drivers = read.iter().filter_map(|v| system.driver(*v));
                    edges[i].extend(drivers.filter(|j| *j != i));
                }
            }
        }
        let reach: Vec<BTreeSet<usize>> = (0..edges.len()).map(|i| reachable(&edges, i)).collect();
        // Depth in the graph of strongly connected components: a part that reaches more parts comes
        // later.
        let together =
            |i: usize, j: usize| i == j || (reach[i].contains(&j) && reach[j].contains(&i));
        let mut places = vec![usize::MAX; edges.len()];
        let mut place = 0;
        while let Some(i) = (0..edges.len()).find(|i| {
            let ready = |j: &usize| places[*j] != usize::MAX || together(*i, *j);
            places[*i] == usize::MAX && reach[*i].iter().all(ready)
        }) {
            for j in (0..edges.len()).filter(|j| together(i, *j)) {
                places[j] = place;
            }
            place += 1;
        }
        Order {
            places,
            sooner: BTreeMap::new(),
        }
    }

    /// Returns whether a rule may be relied on in the step in which a part's assumption is checked.
    fn is_usable(&self, rule: usize, part: usize) -> bool {
        let entry = &self.book.entries[rule];
        entry.unconditional
            || self.exported.contains(&rule)
            || entry.part.is_some_and(|p| self.order.is_before(p, part))
    }

    // ---- safety ---------------------------------------------------------------------------------

    /// Returns the rules that hold from the beginning: givens, exported assumptions, and guarantees
    /// of parts.
    pub(super) fn hypotheses(&self) -> Vec<usize> {
        let mut found = self.book.numbers(|at| is_given(*at));
        found.extend(&self.exported);
        found.extend(self.book.numbers(|at| is_guarantee(*at)));
        found.extend(self.shown.iter().filter(|i| self.is_common_lemma(**i)));
        found.retain(|i| !self.book.is_justice(*i));
        found
    }

    /// Adds the safety that parts assume to these rules: it was kept so far. It follows from the
    /// others unless one of the assumptions is open.
    pub(super) fn with_assumptions(&self, mut rules: Vec<usize>) -> Vec<usize> {
        let assumed = self.book.numbers(|at| is_assumption(*at));
        rules.extend(assumed.into_iter().filter(|i| !self.book.is_justice(*i)));
        rules.sort_unstable();
        rules.dedup();
        rules
    }

    /// Proves the initial conditions, invariants and safety that parts assume.
    fn safety(&mut self) -> Result<(), Limit> {
        let assumed = self.book.numbers(|at| is_assumption(*at));
        let mut left: Vec<usize> = assumed;
        left.retain(|i| !self.book.is_justice(*i));
        loop {
            let mut failed = Vec::new();
            let mut open = Vec::new();
            let mut moved = false;
            for rule in std::mem::take(&mut left) {
                // If the caller chooses, an assumption that does not follow from near rules is
                // handed on without further search.
                if matches!(self.claim.exports, Exports::After(_)) && self.is_about_outside(rule) {
                    if let Some(by) = self.step_minimal(rule, Some(rule), NEAR)? {
                        self.discharged(rule, &by);
                        continue;
                    }
                    match self.export(rule)? {
                        Ok(by) => {
                            self.hand_on(rule, &by);
                            moved = true;
                            continue;
                        }
                        // An assumption that fails even where the environment has no choice fails
                        // altogether.
                        Err(Some(worse)) => {
                            open.push((rule, worse));
                            continue;
                        }
                        Err(None) => {}
                    }
                }
                match self.assumption(rule)? {
                    ObligationResult::Follows(by) => self.discharged(rule, &by),
                    ObligationResult::Fails(why) => failed.push((rule, why)),
                }
            }
            // Assumptions that only the environment can keep are handed on; with them, more may
            // follow.
            for (rule, why) in failed {
                match self.export(rule)? {
                    Ok(by) => {
                        self.hand_on(rule, &by);
                        moved = true;
                    }
                    Err(worse) => open.push((rule, worse.unwrap_or(why))),
                }
            }
            if moved {
                left = open.into_iter().map(|(rule, _)| rule).collect();
                continue;
            }
            return self.within_a_step(open);
        }
    }

    /// Retries assumptions that failed without the answers of parts that may wait for one another,
    /// now with those answers, if the parts can be ordered.
    fn within_a_step(&mut self, failed: Vec<(usize, Refutation)>) -> Result<(), Limit> {
        let mut needs: Vec<(usize, BTreeSet<usize>, Vec<usize>)> = Vec::new();
        let mut open = Vec::new();
        for (rule, why) in failed {
            let part = self.part_of(rule);
            let same: BTreeSet<usize> = (0..self.order.places.len())
                .filter(|j| *j != part && self.order.places[*j] == self.order.places[part])
                .collect();
            let found = if same.is_empty() {
                None
            } else {
                self.order.sooner.insert(part, same.clone());
                let found = self.step_minimal(rule, Some(rule), ALL)?;
                self.order.sooner.remove(&part);
                found
            };
            match found {
                Some(by) => {
                    let mut needed = BTreeSet::new();
                    for j in same {
                        let rests = by.iter().any(|i| self.book.entries[*i].part == Some(j));
                        self.order.sooner.insert(part, self.same_place(part, j));
                        if rests && !self.step_holds(&by, rule, Some(part))? {
                            needed.insert(j);
                        }
                        self.order.sooner.remove(&part);
                    }
                    needs.push((rule, needed, by));
                }
                None => open.push((rule, why)),
            }
        }
        // Dependencies of all of them.
        let mut edges = vec![BTreeSet::new(); self.order.places.len()];
        for (rule, needed, _) in &needs {
            edges[self.part_of(*rule)].extend(needed.iter().copied());
        }
        for (rule, needed, by) in needs {
            let part = self.part_of(rule);
            let circle = needed.iter().any(|j| reachable(&edges, *j).contains(&part));
            if circle {
                let variables = self.loop_of(rule, &needed);
                if !self.proof.loops.iter().any(|l| l.variables == variables) {
                    self.proof.loops.push(super::SameStepLoop { variables });
                }
            } else {
                self.discharged(rule, &by);
            }
        }
        for (rule, why) in open {
            let what = self.at(rule);
            self.proof.open.push(Open { what, why });
        }
        Ok(())
    }

    /// Returns the parts in the same place, except these two.
    fn same_place(&self, part: usize, without: usize) -> BTreeSet<usize> {
        let place = self.order.places[part];
        (0..self.order.places.len())
            .filter(|j| *j != part && *j != without && self.order.places[*j] == place)
            .collect()
    }

    /// Returns the variables of other parts that an assumption waits for within its step.
    fn loop_of(&self, rule: usize, needed: &BTreeSet<usize>) -> Vec<linewright_core::gr1::VarId> {
        let Rule { kind, expr } = self.book.rule(rule);
        let mut variables: Vec<_> = latest(expr, *kind)
            .into_iter()
            .filter(|v| {
                self.book
                    .system
                    .driver(*v)
                    .is_some_and(|j| needed.contains(&j))
            })
            .collect();
        let part = self.part_of(rule);
        variables.extend(self.book.system.parts[part].drives.iter().filter(|v| {
            needed.iter().any(|j| {
                let other = &self.book.system.parts[*j];
                other
                    .assumptions
                    .all()
                    .any(|f| super::book::mentions(&f.expr).contains(v))
            })
        }));
        variables.sort_unstable();
        variables.dedup();
        variables
    }

    /// Proves an assumption of a part, by induction over time.
    fn assumption(&mut self, rule: usize) -> Result<ObligationResult, Limit> {
        let part = self.part_of(rule);
        if let Some(by) = self.step_minimal(rule, Some(rule), ALL)? {
            return Ok(ObligationResult::Follows(by));
        }
        // Other assumptions were kept so far as well.
        let mut all = self.with_assumptions(self.hypotheses());
        if self.book.rule(rule).kind == RuleKind::Initial {
            let first = [RuleKind::Initial, RuleKind::Invariant];
            all.retain(|i| first.contains(&self.book.rule(*i).kind));
        }
        if let Some(trace) = self.step(&all, rule, Some(part))? {
            return Ok(ObligationResult::Fails(Refutation::Trace(trace)));
        }
        let mut holds = |kept: &[usize]| self.step_holds(kept, rule, Some(part));
        Ok(ObligationResult::Follows(quick_xplain(
            &mut holds,
            &[],
            false,
            &all,
        )?))
    }

    /// Returns the smallest subset of the hypotheses from which a rule follows step by step, within
    /// a maximum number of rings; `None` if it does not follow. `assumed` is the rule if it is an
    /// assumption of a part.
    pub(super) fn step_minimal(
        &mut self,
        rule: usize,
        assumed: Option<usize>,
        rings: usize,
    ) -> Result<Option<Vec<usize>>, Limit> {
        let part = assumed.map(|rule| self.part_of(rule));
        let mut candidates = self.hypotheses();
        if let Some(sources) = self.sources(rule, &candidates) {
            let found = self.minimal(rule, &sources, ALL, &mut |p, kept| {
                p.step_holds(kept, rule, part)
            })?;
            if found.is_some() || self.is_lemma(rule) {
                return Ok(found);
            }
        }
        if self.book.rule(rule).kind == RuleKind::Initial {
            // Nothing else is about step 0.
            let first = [RuleKind::Initial, RuleKind::Invariant];
            candidates.retain(|i| first.contains(&self.book.rule(*i).kind));
        }
        self.minimal(rule, &candidates, rings, &mut |p, kept| {
            p.step_holds(kept, rule, part)
        })
    }

    /// Returns the smallest sufficient subset of some candidates: givens alone, a single guarantee,
    /// then ring by ring, up to `most_rings`.
    pub(super) fn minimal(
        &mut self,
        goal: usize,
        candidates: &[usize],
        most_rings: usize,
        holds: &mut impl FnMut(&mut Self, &[usize]) -> Result<bool, Limit>,
    ) -> Result<Option<Vec<usize>>, Limit> {
        let rings = self.book.rings(&[goal], candidates);
        if !self.minimal {
            let near = rings.into_iter().take(most_rings).flatten();
            let enough: Vec<usize> = match most_rings {
                ALL => candidates.to_vec(),
                _ => near.collect(),
            };
            return Ok(holds(self, &enough)?.then_some(enough));
        }
        if holds(self, &[])? {
            return Ok(Some(Vec::new()));
        }
        let environment: Vec<usize> = rings
            .iter()
            .flatten()
            .copied()
            .filter(|i| self.is_environments(*i))
            .collect();
        if !environment.is_empty() && holds(self, &environment)? {
            return self.fewest(&environment, holds).map(Some);
        }
        for single in rings.first().into_iter().flatten() {
            if !self.is_environments(*single) && holds(self, &[*single])? {
                return Ok(Some(vec![*single]));
            }
        }
        let mut kept = Vec::new();
        for ring in rings.into_iter().take(most_rings) {
            // Justice if it is enough, since it is what the reader looks for; then the nearest.
            let (justice, safety): (Vec<usize>, Vec<usize>) =
                ring.into_iter().partition(|i| self.book.is_justice(*i));
            kept.splice(0..0, justice);
            kept.extend(safety);
            if holds(self, &kept)? {
                return self.fewest(&kept, holds).map(Some);
            }
        }
        // Unreachable candidates matter only if they cannot be kept at all.
        if most_rings == ALL && kept.len() < candidates.len() && holds(self, candidates)? {
            return self.fewest(candidates, holds).map(Some);
        }
        Ok(None)
    }

    /// Removes rules that are not needed.
    pub(super) fn fewest(
        &mut self,
        enough: &[usize],
        holds: &mut impl FnMut(&mut Self, &[usize]) -> Result<bool, Limit>,
    ) -> Result<Vec<usize>, Limit> {
        if !self.minimal {
            return Ok(enough.to_vec());
        }
        let mut asked = |kept: &[usize]| holds(self, kept);
        let mut found = quick_xplain(&mut asked, &[], false, enough)?;
        found.sort_unstable();
        Ok(found)
    }

    pub(super) fn is_environments(&self, rule: usize) -> bool {
        self.exported.contains(&rule) || self.book.entries[rule].at.is_some_and(is_given)
    }

    pub(super) fn step_holds(
        &mut self,
        kept: &[usize],
        rule: usize,
        part: Option<usize>,
    ) -> Result<bool, Limit> {
        Ok(self.step(kept, rule, part)?.is_none())
    }

    /// Returns a run up to the first step that breaks a rule, keeping some others. For a part's
    /// assumption, the last step only has to keep what can be relied on when the part's inputs are
    /// present.
    pub(super) fn step(
        &mut self,
        kept: &[usize],
        rule: usize,
        part: Option<usize>,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let definitions = self.book.definitions(kept.iter().copied().chain([rule]));
        let usable = |i: &usize| part.is_none_or(|part| self.is_usable(*i, part));
        let last = kept.iter().copied().filter(usable);
        let slip = SafetyViolationQuery {
            last: last.chain(definitions.iter().copied()).collect(),
            before: [kept, &definitions].concat(),
            broken: rule,
        };
        self.book.runs.step(&slip)
    }

    // ---- exported assumptions -------------------------------------------------------------------

    /// Returns whether a rule mentions outside values in the last step that it is about.
    fn is_about_outside(&self, rule: usize) -> bool {
        let Rule { kind, expr } = self.book.rule(rule);
        let mut latest = latest(expr, *kind).into_iter();
        latest.any(|v| self.book.system.driver(v).is_none())
    }

    /// Returns what the export of an undischarged assumption rests on. If it may not be handed on,
    /// returns how it is broken where the environment has no choice, or `None` if it may never be
    /// handed on.
    pub(super) fn export(
        &mut self,
        rule: usize,
    ) -> Result<Result<Vec<usize>, Option<Refutation>>, Limit> {
        let Rule { kind, expr } = self.book.rule(rule).clone();
        let outside = self.is_about_outside(rule);
        let after = match &self.claim.exports {
            Exports::Never => return Ok(Err(None)),
            _ if !outside => return Ok(Err(None)),
            Exports::Always => return Ok(Ok(Vec::new())),
            Exports::After(_) if kind == RuleKind::Initial => return Ok(Ok(Vec::new())),
            Exports::After(_) if kind == RuleKind::Justice => return Ok(Err(None)),
            Exports::After(after) => after.clone(),
        };
        let next = match kind {
            RuleKind::Invariant => expr.substitute(&mut |v, _| Expr::Var(v, Time::Next)),
            _ => expr,
        };
        // The assumption itself held in the steps before: it is either handed on or shown here.
        let weaker = self.book.add(Rule {
            kind: RuleKind::Safety,
            expr: after.or(next),
        });
        let part = self.part_of(rule);
        let mut candidates = self.hypotheses();
        candidates.push(rule);
        let slips = |p: &mut Self, kept: &[usize]| {
            // In the last step it is to be shown.
            let definitions = p.book.definitions(kept.iter().copied().chain([weaker]));
            let last = kept
                .iter()
                .copied()
                .filter(|i| *i != rule && p.is_usable(*i, part));
            let slip = SafetyViolationQuery {
                last: last.chain(definitions.iter().copied()).collect(),
                before: [kept, &definitions].concat(),
                broken: weaker,
            };
            p.book.runs.step(&slip)
        };
        let mut holds = |p: &mut Self, kept: &[usize]| Ok(slips(p, kept)?.is_none());
        let by = if let Some(by) = self.minimal(weaker, &candidates, ALL, &mut holds)? {
            by
        } else {
            let all = self.with_assumptions(candidates);
            if let Some(trace) = slips(self, &all)? {
                return Ok(Err(Some(Refutation::Trace(trace))));
            }
            self.fewest(&all, &mut holds)?
        };
        Ok(Ok(by.into_iter().filter(|i| *i != rule).collect()))
    }

    pub(super) fn hand_on(&mut self, rule: usize, by: &[usize]) {
        self.exported.push(rule);
        let what = self.at(rule);
        let by = by.iter().map(|i| self.at(*i)).collect();
        self.proof.discharges.push(Discharge {
            what,
            rule: DischargeRule::Exported,
            by,
        });
    }

    fn discharged(&mut self, rule: usize, by: &[usize]) {
        let of_the_environment = by.iter().all(|i| self.is_environments(*i));
        let kind = if of_the_environment {
            DischargeRule::Environment
        } else {
            DischargeRule::Induction
        };
        self.record(rule, kind, by);
    }

    pub(super) fn record(&mut self, rule: usize, kind: DischargeRule, by: &[usize]) {
        let what = self.at(rule);
        let by = by.iter().map(|i| self.at(*i)).collect();
        self.proof.discharges.push(Discharge {
            what,
            rule: kind,
            by,
        });
    }

    pub(super) fn at(&self, rule: usize) -> FormulaRef {
        let at = self.book.entries[rule].at;
        at.expect("a formula that somebody wrote; please report this")
    }

    pub(super) fn part_of(&self, rule: usize) -> usize {
        let part = self.book.entries[rule].part;
        part.expect("an assumption of a part; please report this")
    }
}

pub(super) fn is_given(at: FormulaRef) -> bool {
    at.part.is_none() && at.half == ContractSide::Assumptions
}

pub(super) fn is_goal(at: FormulaRef) -> bool {
    at.part.is_none() && at.half == ContractSide::Guarantees
}

pub(super) fn is_guarantee(at: FormulaRef) -> bool {
    at.part.is_some() && at.half == ContractSide::Guarantees
}

pub(super) fn is_assumption(at: FormulaRef) -> bool {
    at.part.is_some() && at.half == ContractSide::Assumptions
}

/// Returns a sort key: parts in order, the goal last.
fn place(at: FormulaRef) -> (usize, RuleKind, usize) {
    (at.part.unwrap_or(usize::MAX), at.kind, at.index)
}

/// Returns what can be reached in a graph, by at least one edge.
fn reachable(edges: &[BTreeSet<usize>], from: usize) -> BTreeSet<usize> {
    let mut seen = BTreeSet::new();
    let mut open: Vec<usize> = edges[from].iter().copied().collect();
    while let Some(at) = open.pop() {
        if seen.insert(at) {
            open.extend(&edges[at]);
        }
    }
    seen
}
