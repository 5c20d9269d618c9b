//! Proof of each obligation: the rules from which it follows, or a counterexample.

use super::super::system::{ContractSide, FormulaRef, System};
use super::book::{ProofRules, latest};
use super::loops::AnswerDependencies;
use super::{Claim, Discharge, DischargeRule, Exports, Open, Proof, Refutation};
use linewright_core::gr1::{Expr, FormulaKind, Time};
use linewright_solver::game::{Limit, Limits, Rule, SafetyViolationQuery, quick_xplain};
use std::collections::{BTreeMap, BTreeSet};

/// Number of rings of rules that count as near.
const NEAR: usize = 1;

/// No limit on the number of rings.
pub(super) const ALL: usize = usize::MAX;

/// State of a proof.
pub struct Prover<'a> {
    pub(super) book: ProofRules<'a>,
    pub(super) claim: &'a Claim,
    /// Order in which components answer within a step.
    order: Order,
    /// Rule numbers of the assumptions that are exported to the environment.
    pub(super) exported: Vec<usize>,
    /// Justice assumptions that were discharged: other justice can rest on them.
    pub(super) met: Vec<usize>,
    /// Completions of components that follow from the component's own contract.
    pub(super) derived: Vec<usize>,
    /// Completions that were examined.
    pub(super) examined: BTreeSet<usize>,
    /// Formulas of the goal that are proved: other justice of the goal can rest on them.
    pub(super) shown: Vec<usize>,
    /// The formulas in `shown` that are kept step by step, even in steps after which no run
    /// continues.
    pub(super) kept: BTreeSet<usize>,
    /// Whether the rules that a discharge rests on must be minimal, not only sufficient.
    pub(super) minimal: bool,
    /// Whether the goal's safety has to be kept step by step.
    pub(super) stepwise: bool,
    pub(super) proof: Proof,
}

/// An order in which components can answer within a step.
#[derive(Debug, Default)]
struct Order {
    /// Position of each component. Components with the same position wait for one another, or might
    /// do so.
    places: Vec<usize>,
    /// For a component: other components with the same position that count as earlier.
    earlier: BTreeMap<usize, BTreeSet<usize>>,
}

impl Order {
    /// Returns whether the answer of the first component can be relied on when the inputs of the
    /// second are checked.
    fn is_before(&self, first: usize, second: usize) -> bool {
        self.places[first] < self.places[second]
            || self
                .earlier
                .get(&second)
                .is_some_and(|s| s.contains(&first))
    }
}

/// Result for one obligation.
pub(super) enum ObligationResult {
    /// The obligation follows from these rules.
    Follows(Vec<usize>),
    /// The obligation does not follow, as this counterexample shows.
    Fails(Refutation),
}

impl<'a> Prover<'a> {
    /// Creates the state in which a proof begins.
    pub fn new(system: &'a System, claim: &'a Claim, limits: &Limits) -> Result<Self, Limit> {
        Ok(Self {
            book: ProofRules::new(system, claim, limits)?,
            claim,
            order: Order::default(),
            exported: Vec::new(),
            met: Vec::new(),
            derived: Vec::new(),
            examined: BTreeSet::new(),
            shown: Vec::new(),
            kept: BTreeSet::new(),
            minimal: true,
            stepwise: false,
            proof: Proof::default(),
        })
    }

    /// Accepts sufficient sets of rules instead of minimal ones.
    pub fn quick(self) -> Self {
        Self {
            minimal: false,
            ..self
        }
    }

    /// Requires safety of the goal to be kept step by step, even in steps after which no run
    /// continues.
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
        self.prove_safety()?;
        let reliable = self.prove_justice()?;
        self.prove_goal(&reliable)?;
        self.proof.discharges.sort_by_key(|d| place(d.what));
        self.proof.open.sort_by_key(|o| place(o.what));
        Ok(self.proof)
    }

    // ---- order of answers -----------------------------------------------------------------------

    /// Computes the order: a component comes after the components that its answers wait for, and
    /// after the components that its assumptions mention.
    fn order_of(&self, waits: &AnswerDependencies) -> Order {
        let system = self.book.system;
        let mut edges = waits.components.clone();
        for (i, component) in system.components.iter().enumerate() {
            for (kind, _, formula) in component.assumptions.formulas() {
                if kind != FormulaKind::Justice {
                    let read = latest(&formula.expr, kind);
                    let drivers = read.iter().filter_map(|v| system.driver(*v));
                    edges[i].extend(drivers.filter(|j| *j != i));
                }
            }
        }
        let reach: Vec<BTreeSet<usize>> = (0..edges.len()).map(|i| reachable(&edges, i)).collect();
        // Depth in the graph of strongly connected components: a component that reaches more
        // components comes later.
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
            earlier: BTreeMap::new(),
        }
    }

    /// Returns whether a rule can be relied on in the same step in which a component's assumption
    /// is checked.
    fn is_usable(&self, rule: usize, component: usize) -> bool {
        let entry = &self.book.entries[rule];
        entry.unconditional
            || self.exported.contains(&rule)
            || entry
                .component
                .is_some_and(|p| self.order.is_before(p, component))
    }

    // ---- safety ---------------------------------------------------------------------------------

    /// Returns the rules that safety can rest on: givens, exported assumptions, guarantees of
    /// components, and proved common lemmas, without justice.
    pub(super) fn hypotheses(&self) -> Vec<usize> {
        let mut found = self.book.rules_where(|at| is_given(*at));
        found.extend(&self.exported);
        found.extend(self.book.rules_where(|at| is_guarantee(*at)));
        found.extend(self.shown.iter().filter(|i| self.is_common_lemma(**i)));
        found.retain(|i| !self.book.is_justice(*i));
        found
    }

    /// Adds the safety assumptions of components to these rules, since these assumptions were kept
    /// in all earlier steps. They follow from the other rules unless an assumption is open.
    pub(super) fn with_assumptions(&self, mut rules: Vec<usize>) -> Vec<usize> {
        let assumed = self.book.rules_where(|at| is_assumption(*at));
        rules.extend(assumed.into_iter().filter(|i| !self.book.is_justice(*i)));
        rules.sort_unstable();
        rules.dedup();
        rules
    }

    /// Proves the initial conditions, invariants and safety that components assume.
    fn prove_safety(&mut self) -> Result<(), Limit> {
        let assumed = self.book.rules_where(|at| is_assumption(*at));
        let mut left: Vec<usize> = assumed;
        left.retain(|i| !self.book.is_justice(*i));
        loop {
            let mut failed = Vec::new();
            let mut open = Vec::new();
            let mut moved = false;
            for rule in std::mem::take(&mut left) {
                // If the caller makes the requests, an assumption that does not follow from near
                // rules is exported without further search.
                if matches!(self.claim.exports, Exports::After(_)) && self.is_about_outside(rule) {
                    if let Some(by) = self.minimal_for_step(rule, Some(rule), NEAR)? {
                        self.record_discharge(rule, &by);
                        continue;
                    }
                    match self.export(rule)? {
                        Ok(by) => {
                            self.record_export(rule, &by);
                            moved = true;
                            continue;
                        }
                        // An assumption that fails even in a step for which the environment is not
                        // responsible stays open.
                        Err(Some(worse)) => {
                            open.push((rule, worse));
                            continue;
                        }
                        Err(None) => {}
                    }
                }
                match self.prove_assumption(rule)? {
                    ObligationResult::Follows(by) => self.record_discharge(rule, &by),
                    ObligationResult::Fails(why) => failed.push((rule, why)),
                }
            }
            // Assumptions that only the environment can keep are exported; then other assumptions
            // might follow from them.
            for (rule, why) in failed {
                match self.export(rule)? {
                    Ok(by) => {
                        self.record_export(rule, &by);
                        moved = true;
                    }
                    Err(worse) => open.push((rule, worse.unwrap_or(why))),
                }
            }
            if moved {
                left = open.into_iter().map(|(rule, _)| rule).collect();
                continue;
            }
            return self.retry_within_step(open);
        }
    }

    /// Retries failed assumptions with the answers of components that have the same position. A
    /// proof is accepted if the components can be ordered so that it relies on earlier answers
    /// only; otherwise there is a loop.
    fn retry_within_step(&mut self, failed: Vec<(usize, Refutation)>) -> Result<(), Limit> {
        let mut needs: Vec<(usize, BTreeSet<usize>, Vec<usize>)> = Vec::new();
        let mut open = Vec::new();
        for (rule, why) in failed {
            let component = self.component_of(rule);
            let same: BTreeSet<usize> = (0..self.order.places.len())
                .filter(|j| {
                    *j != component && self.order.places[*j] == self.order.places[component]
                })
                .collect();
            let found = if same.is_empty() {
                None
            } else {
                self.order.earlier.insert(component, same.clone());
                let found = self.minimal_for_step(rule, Some(rule), ALL)?;
                self.order.earlier.remove(&component);
                found
            };
            match found {
                Some(by) => {
                    let mut needed = BTreeSet::new();
                    for j in same {
                        let rests = by
                            .iter()
                            .any(|i| self.book.entries[*i].component == Some(j));
                        self.order
                            .earlier
                            .insert(component, self.same_place(component, j));
                        if rests && !self.step_holds(&by, rule, Some(component))? {
                            needed.insert(j);
                        }
                        self.order.earlier.remove(&component);
                    }
                    needs.push((rule, needed, by));
                }
                None => open.push((rule, why)),
            }
        }
        // Dependencies between the components for all these assumptions.
        let mut edges = vec![BTreeSet::new(); self.order.places.len()];
        for (rule, needed, _) in &needs {
            edges[self.component_of(*rule)].extend(needed.iter().copied());
        }
        for (rule, needed, by) in needs {
            let component = self.component_of(rule);
            let cycle = needed
                .iter()
                .any(|j| reachable(&edges, *j).contains(&component));
            if cycle {
                let variables = self.loop_of(rule, &needed);
                if !self.proof.loops.iter().any(|l| l.variables == variables) {
                    self.proof.loops.push(super::SameStepLoop { variables });
                }
            } else {
                self.record_discharge(rule, &by);
            }
        }
        for (rule, why) in open {
            let what = self.at(rule);
            self.proof.open.push(Open { what, why });
        }
        Ok(())
    }

    /// Returns the other components with the same position as `component`, except `without`.
    fn same_place(&self, component: usize, without: usize) -> BTreeSet<usize> {
        let place = self.order.places[component];
        (0..self.order.places.len())
            .filter(|j| *j != component && *j != without && self.order.places[*j] == place)
            .collect()
    }

    /// Returns the variables of a loop within a step: those of other components that an assumption
    /// waits for, and those of its own component that the others' assumptions mention.
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
        let component = self.component_of(rule);
        variables.extend(
            self.book.system.components[component]
                .drives
                .iter()
                .filter(|v| {
                    needed.iter().any(|j| {
                        let other = &self.book.system.components[*j];
                        other
                            .assumptions
                            .all()
                            .any(|f| super::book::mentions(&f.expr).contains(v))
                    })
                }),
        );
        variables.sort_unstable();
        variables.dedup();
        variables
    }

    /// Proves an assumption of a component, by induction over time.
    fn prove_assumption(&mut self, rule: usize) -> Result<ObligationResult, Limit> {
        let component = self.component_of(rule);
        if let Some(by) = self.minimal_for_step(rule, Some(rule), ALL)? {
            return Ok(ObligationResult::Follows(by));
        }
        // All other assumptions were also kept in earlier steps.
        let mut all = self.with_assumptions(self.hypotheses());
        if self.book.rule(rule).kind == FormulaKind::Initial {
            let first = [FormulaKind::Initial, FormulaKind::Invariant];
            all.retain(|i| first.contains(&self.book.rule(*i).kind));
        }
        if let Some(trace) = self.step(&all, rule, Some(component))? {
            return Ok(ObligationResult::Fails(Refutation::Trace(trace)));
        }
        let mut holds = |kept: &[usize]| self.step_holds(kept, rule, Some(component));
        Ok(ObligationResult::Follows(quick_xplain(
            &mut holds,
            &[],
            false,
            &all,
        )?))
    }

    /// Returns a minimal subset of the hypotheses from which a rule follows step by step, within a
    /// maximum number of rings; `None` if it does not follow. `assumed` is the rule if it is an
    /// assumption of a component.
    pub(super) fn minimal_for_step(
        &mut self,
        rule: usize,
        assumed: Option<usize>,
        rings: usize,
    ) -> Result<Option<Vec<usize>>, Limit> {
        let component = assumed.map(|rule| self.component_of(rule));
        let mut candidates = self.hypotheses();
        if let Some(sources) = self.sources(rule, &candidates) {
            let found = self.minimal(rule, &sources, ALL, &mut |p, kept| {
                p.step_holds(kept, rule, component)
            })?;
            if found.is_some() || self.is_lemma(rule) {
                return Ok(found);
            }
        }
        if self.book.rule(rule).kind == FormulaKind::Initial {
            // Only these kinds of rules constrain step 0.
            let first = [FormulaKind::Initial, FormulaKind::Invariant];
            candidates.retain(|i| first.contains(&self.book.rule(*i).kind));
        }
        self.minimal(rule, &candidates, rings, &mut |p, kept| {
            p.step_holds(kept, rule, component)
        })
    }

    /// Returns a minimal sufficient subset of the candidates. Tries formulas that the environment
    /// keeps, then each single rule of the first ring, then ring by ring, up to `max_rings`.
    /// Returns `None` if the candidates are not sufficient.
    pub(super) fn minimal(
        &mut self,
        goal: usize,
        candidates: &[usize],
        max_rings: usize,
        holds: &mut impl FnMut(&mut Self, &[usize]) -> Result<bool, Limit>,
    ) -> Result<Option<Vec<usize>>, Limit> {
        let rings = self.book.rings(&[goal], candidates);
        if !self.minimal {
            let near = rings.into_iter().take(max_rings).flatten();
            let enough: Vec<usize> = match max_rings {
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
            .filter(|i| self.is_from_environment(*i))
            .collect();
        if !environment.is_empty() && holds(self, &environment)? {
            return self.minimize(&environment, holds).map(Some);
        }
        for single in rings.first().into_iter().flatten() {
            if !self.is_from_environment(*single) && holds(self, &[*single])? {
                return Ok(Some(vec![*single]));
            }
        }
        let mut kept = Vec::new();
        for ring in rings.into_iter().take(max_rings) {
            // Prefer justice, since it explains a justice goal best; then prefer the nearest rules.
            let (justice, safety): (Vec<usize>, Vec<usize>) =
                ring.into_iter().partition(|i| self.book.is_justice(*i));
            kept.splice(0..0, justice);
            kept.extend(safety);
            if holds(self, &kept)? {
                return self.minimize(&kept, holds).map(Some);
            }
        }
        // Unreachable candidates are relevant only if they contradict each other.
        if max_rings == ALL && kept.len() < candidates.len() && holds(self, candidates)? {
            return self.minimize(candidates, holds).map(Some);
        }
        Ok(None)
    }

    /// Removes rules that are not needed from a sufficient set.
    pub(super) fn minimize(
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

    pub(super) fn is_from_environment(&self, rule: usize) -> bool {
        self.exported.contains(&rule) || self.book.entries[rule].at.is_some_and(is_given)
    }

    pub(super) fn step_holds(
        &mut self,
        kept: &[usize],
        rule: usize,
        component: Option<usize>,
    ) -> Result<bool, Limit> {
        let query = self.step_query(kept, rule, component);
        Ok(!self.book.runs.has_violation(&query)?)
    }

    /// Returns a run that keeps the rules `kept` and whose last step breaks `rule`. If `rule` is an
    /// assumption of a component, the last step only has to keep the rules that can be relied on
    /// when the inputs of that component are checked.
    pub(super) fn step(
        &mut self,
        kept: &[usize],
        rule: usize,
        component: Option<usize>,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let query = self.step_query(kept, rule, component);
        self.book.runs.find_violation(&query)
    }

    fn step_query(
        &self,
        kept: &[usize],
        rule: usize,
        component: Option<usize>,
    ) -> SafetyViolationQuery {
        let definitions = self.book.definitions(kept.iter().copied().chain([rule]));
        let usable = |i: &usize| component.is_none_or(|component| self.is_usable(*i, component));
        let last = kept.iter().copied().filter(usable);
        SafetyViolationQuery {
            last: last.chain(definitions.iter().copied()).collect(),
            before: [kept, &definitions].concat(),
            broken: rule,
        }
    }

    // ---- exported assumptions -------------------------------------------------------------------

    /// Returns whether a rule reads outside values in the last step that it constrains.
    fn is_about_outside(&self, rule: usize) -> bool {
        let Rule { kind, expr } = self.book.rule(rule);
        let mut latest = latest(expr, *kind).into_iter();
        latest.any(|v| self.book.system.driver(v).is_none())
    }

    /// Tries to export an assumption that was not discharged. `Ok(Ok(_))` contains the rules that
    /// the export rests on. `Ok(Err(_))` means that the assumption cannot be exported: it contains
    /// a run on which the assumption is broken in a step for which the environment is not
    /// responsible, or `None` if the claim does not allow the export at all.
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
            Exports::After(_) if kind == FormulaKind::Initial => return Ok(Ok(Vec::new())),
            Exports::After(_) if kind == FormulaKind::Justice => return Ok(Err(None)),
            Exports::After(after) => after.clone(),
        };
        let next = match kind {
            FormulaKind::Invariant => expr.substitute(&mut |v, _| Expr::Var(v, Time::Next)),
            _ => expr,
        };
        // The assumption itself was kept in all earlier steps: in each, it is either exported or
        // proved here.
        let weaker = self.book.add(Rule {
            kind: FormulaKind::Safety,
            expr: after.or(next),
        });
        let component = self.component_of(rule);
        let mut candidates = self.hypotheses();
        candidates.push(rule);
        let query = |p: &Self, kept: &[usize]| {
            // In the last step, the assumption has to be proved, so it is left out.
            let definitions = p.book.definitions(kept.iter().copied().chain([weaker]));
            let last = kept
                .iter()
                .copied()
                .filter(|i| *i != rule && p.is_usable(*i, component));
            SafetyViolationQuery {
                last: last.chain(definitions.iter().copied()).collect(),
                before: [kept, &definitions].concat(),
                broken: weaker,
            }
        };
        let mut holds = |p: &mut Self, kept: &[usize]| {
            let query = query(p, kept);
            Ok(!p.book.runs.has_violation(&query)?)
        };
        let by = if let Some(by) = self.minimal(weaker, &candidates, ALL, &mut holds)? {
            by
        } else {
            let all = self.with_assumptions(candidates);
            let query = query(self, &all);
            if let Some(trace) = self.book.runs.find_violation(&query)? {
                return Ok(Err(Some(Refutation::Trace(trace))));
            }
            self.minimize(&all, &mut holds)?
        };
        Ok(Ok(by.into_iter().filter(|i| *i != rule).collect()))
    }

    pub(super) fn record_export(&mut self, rule: usize, by: &[usize]) {
        self.exported.push(rule);
        let what = self.at(rule);
        let by = by.iter().map(|i| self.at(*i)).collect();
        self.proof.discharges.push(Discharge {
            what,
            rule: DischargeRule::Exported,
            by,
        });
    }

    fn record_discharge(&mut self, rule: usize, by: &[usize]) {
        let of_the_environment = by.iter().all(|i| self.is_from_environment(*i));
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
        at.expect("the rule is not a formula of any contract or claim; please report this")
    }

    pub(super) fn component_of(&self, rule: usize) -> usize {
        let component = self.book.entries[rule].component;
        component.expect("the rule is not a formula of any component; please report this")
    }
}

pub(super) fn is_given(at: FormulaRef) -> bool {
    at.component.is_none() && at.half == ContractSide::Assumptions
}

pub(super) fn is_goal(at: FormulaRef) -> bool {
    at.component.is_none() && at.half == ContractSide::Guarantees
}

pub(super) fn is_guarantee(at: FormulaRef) -> bool {
    at.component.is_some() && at.half == ContractSide::Guarantees
}

pub(super) fn is_assumption(at: FormulaRef) -> bool {
    at.component.is_some() && at.half == ContractSide::Assumptions
}

pub(super) fn is_completion(at: FormulaRef) -> bool {
    at.half == ContractSide::Completions
}

/// Returns a sort key: components in order, the goal last.
fn place(at: FormulaRef) -> (usize, FormulaKind, usize) {
    (at.component.unwrap_or(usize::MAX), at.kind, at.index)
}

/// Returns the nodes of a graph that can be reached from a node by at least one edge.
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
