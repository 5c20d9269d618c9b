//! Exact decisions about sets of runs: whether a set is empty, and whether it is included in
//! another.
//!
//! A set is split into cases. A case states for some halves of contracts whether the run keeps or
//! breaks them. A half is broken if its safety is broken once, which a Boolean records, or if one
//! of its justice formulas never holds again from some step on. So every case takes a few queries
//! to [`Runs`], and a run that is found is a lasso.

use super::contract::{Contract, RunSet};
use super::system::{ContractSide, System, rule};
use linewright_core::gr1::{Domain, Expr, FormulaKind, Owner, Side, Time, VarId, Variable};
use linewright_core::source::Span;
use linewright_solver::game::{Lasso, Limit, Limits, Rule, RunQuery, Runs};
use std::collections::{BTreeMap, BTreeSet};

/// Rules of one half of a contract.
#[derive(Debug, Clone, Default)]
struct HalfRules {
    /// Initial conditions, invariants and safety.
    keep: Vec<usize>,
    /// Justice rules.
    justice: Vec<usize>,
    /// Rules that define the Boolean that records a violation of safety, and the justice rule that
    /// the Boolean is true; `None` if the half has justice only.
    broken: Option<(Vec<usize>, usize)>,
}

/// Decision procedure for sets of runs of a system.
#[derive(Debug)]
pub struct Decider<'a> {
    system: &'a System,
    runs: Runs,
    halves: BTreeMap<(usize, ContractSide), HalfRules>,
    definitions: Vec<Vec<usize>>,
}

/// For some halves of contracts, whether a run keeps them.
type Case = BTreeMap<(usize, ContractSide), bool>;

impl<'a> Decider<'a> {
    /// Prepares decisions about a system.
    ///
    /// # Errors
    /// When the variables do not fit into the limits.
    pub fn new(system: &'a System, limits: &Limits) -> Result<Self, Limit> {
        let mut variables = system.variables.clone();
        let mut rules = Vec::new();
        let mut halves = BTreeMap::new();
        let mut definitions = Vec::new();
        for (i, component) in system.components.iter().enumerate() {
            let mut own = Vec::new();
            for (kind, _, formula) in component.definitions.formulas() {
                own.push(rules.len());
                rules.push(rule(kind, &formula.expr));
            }
            definitions.push(own);
            for half in [ContractSide::Assumptions, ContractSide::Guarantees] {
                let bit = VarId(variables.len() as u32);
                let half_rules = add_half(component.half(half), bit, &mut rules);
                if half_rules.broken.is_some() {
                    variables.push(Variable {
                        name: system.fresh_name(&format!("broken {}", variables.len())),
                        owner: Owner::System,
                        internal: true,
                        domain: Domain::Bool,
                        unit: String::new(),
                        span: Span::default(),
                    });
                }
                halves.insert((i, half), half_rules);
            }
        }
        Ok(Self {
            system,
            runs: Runs::new(&variables, rules, limits)?,
            halves,
            definitions,
        })
    }

    /// Returns a run in a set, over the system's variables; `None` if the set is empty.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn find(&mut self, set: &RunSet) -> Result<Option<Lasso>, Limit> {
        let mut seen = BTreeSet::new();
        self.find_in_cases(vec![(set.clone(), true)], Case::new(), &mut seen)
    }

    /// Returns a run that is in `small` but not in `large`; `None` if `large` includes `small`.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn difference(&mut self, small: &RunSet, large: &RunSet) -> Result<Option<Lasso>, Limit> {
        self.find(&small.clone().and(large.clone().not()))
    }

    /// Returns a run that shows that `small` does not refine `large`; `None` if it does. With
    /// `Assumptions`, the run shows that `large` assumes less: `large` allows the environment to
    /// make this run, but `small` does not. With `Guarantees`, it shows that `small` guarantees
    /// less: `small` allows an implementation to make this run, but `large` does not.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn refutation(
        &mut self,
        small: &Contract,
        large: &Contract,
    ) -> Result<Option<(ContractSide, Lasso)>, Limit> {
        if let Some(run) = self.difference(&large.assumption, &small.assumption)? {
            return Ok(Some((ContractSide::Assumptions, run)));
        }
        let found = self.difference(&small.guarantee, &large.guarantee)?;
        Ok(found.map(|run| (ContractSide::Guarantees, run)))
    }

    /// Returns whether two contracts refine each other.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn equivalent(&mut self, a: &Contract, b: &Contract) -> Result<bool, Limit> {
        Ok(self.refutation(a, b)?.is_none() && self.refutation(b, a)?.is_none())
    }

    /// Splits the sets in `left`, each paired with whether the run has to be in it, into cases.
    /// Returns a run of the first case that has one.
    fn find_in_cases(
        &mut self,
        mut left: Vec<(RunSet, bool)>,
        mut case: Case,
        seen: &mut BTreeSet<Vec<((usize, ContractSide), bool)>>,
    ) -> Result<Option<Lasso>, Limit> {
        while let Some((set, kept)) = left.pop() {
            match (set, kept) {
                (RunSet::Not(inner), kept) => left.push((*inner, !kept)),
                (RunSet::Side(component, half), kept) => {
                    if case
                        .insert((component, half), kept)
                        .is_some_and(|k| k != kept)
                    {
                        return Ok(None);
                    }
                }
                (RunSet::All(all), true) => left.extend(all.into_iter().map(|w| (w, true))),
                (RunSet::Any(any), false) => left.extend(any.into_iter().map(|w| (w, false))),
                (RunSet::All(list), false) | (RunSet::Any(list), true) => {
                    for one in list {
                        let mut rest = left.clone();
                        rest.push((one, kept));
                        if let Some(run) = self.find_in_cases(rest, case.clone(), seen)? {
                            return Ok(Some(run));
                        }
                    }
                    return Ok(None);
                }
            }
        }
        let key: Vec<_> = case.into_iter().collect();
        if !seen.insert(key.clone()) {
            return Ok(None);
        }
        self.decide_case(&key)
    }

    /// Returns a run of one case; `None` if it has none.
    fn decide_case(
        &mut self,
        case: &[((usize, ContractSide), bool)],
    ) -> Result<Option<Lasso>, Limit> {
        let mut wanted = RunQuery::default();
        let components: BTreeSet<usize> =
            case.iter().map(|((component, _), _)| *component).collect();
        for component in components {
            wanted.keep.extend(&self.definitions[component]);
        }
        let mut broken = Vec::new();
        for (at, kept) in case {
            let half = &self.halves[at];
            if *kept {
                wanted.keep.extend(&half.keep);
                wanted.infinitely_often.extend(&half.justice);
            } else {
                broken.push(half.clone());
            }
        }
        self.find_broken(&wanted, &broken)
    }

    fn find_broken(
        &mut self,
        wanted: &RunQuery,
        broken: &[HalfRules],
    ) -> Result<Option<Lasso>, Limit> {
        let Some((half, rest)) = broken.split_first() else {
            let found = self.runs.find_lasso(wanted)?;
            return Ok(found.map(|run| self.without_bits(run)));
        };
        if let Some((definitions, seen)) = &half.broken {
            let mut more = wanted.clone();
            more.keep.extend(definitions);
            more.infinitely_often.push(*seen);
            if let Some(run) = self.find_broken(&more, rest)? {
                return Ok(Some(run));
            }
        }
        for justice in &half.justice {
            let mut more = wanted.clone();
            more.finitely_often.push(*justice);
            if let Some(run) = self.find_broken(&more, rest)? {
                return Ok(Some(run));
            }
        }
        Ok(None)
    }

    /// Removes the Booleans that record violations from a run.
    fn without_bits(&self, mut run: Lasso) -> Lasso {
        let count = self.system.variables.len();
        for step in run.prefix.iter_mut().chain(&mut run.cycle) {
            step.truncate(count);
        }
        run
    }
}

/// Adds the rules of one half; `bit` records that its safety was broken.
fn add_half(side: &Side, bit: VarId, rules: &mut Vec<Rule>) -> HalfRules {
    let mut half_rules = HalfRules::default();
    let mut first = Expr::FALSE;
    let mut later = Expr::FALSE;
    for (kind, _, formula) in side.formulas() {
        let index = rules.len();
        rules.push(rule(kind, &formula.expr));
        let broken = formula.expr.clone().not();
        match kind {
            FormulaKind::Justice => {
                half_rules.justice.push(index);
                continue;
            }
            FormulaKind::Initial => first = first.or(broken),
            FormulaKind::Invariant => {
                let next = broken.substitute(&mut |v, _| Expr::Var(v, Time::Next));
                first = first.or(broken);
                later = later.or(next);
            }
            FormulaKind::Safety => later = later.or(broken),
        }
        half_rules.keep.push(index);
    }
    if !half_rules.keep.is_empty() {
        let start = rules.len();
        rules.push(Rule {
            kind: FormulaKind::Initial,
            expr: Expr::now(bit).equals(first.simplify()),
        });
        rules.push(Rule {
            kind: FormulaKind::Safety,
            expr: Expr::next(bit).equals(Expr::now(bit).or(later.simplify())),
        });
        rules.push(Rule {
            kind: FormulaKind::Justice,
            expr: Expr::now(bit),
        });
        half_rules.broken = Some((vec![start, start + 1], start + 2));
    }
    half_rules
}
