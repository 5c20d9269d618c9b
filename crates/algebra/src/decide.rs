//! Exact questions about sets of runs: is a set empty, is it included in another?
//!
//! A set is split into cases, each a list of halves of parts that are kept or broken. For a broken
//! half, either its safety is broken once, which a Boolean records, or one of its justice formulas
//! is not met any more from some step on. So every case is one question to [`Runs`], and the
//! counterexample is a lasso.

use super::contract::{Contract, Words};
use super::system::{ContractSide, System, formulas, rule};
use linewright_core::gr1::{Domain, Expr, Owner, Side, Time, VarId, Variable};
use linewright_core::source::Span;
use linewright_solver::game::{Lasso, Limit, Limits, Rule, RuleKind, RunQuery, Runs};
use std::collections::{BTreeMap, BTreeSet};

/// One half of a part as rules.
#[derive(Debug, Clone, Default)]
struct HalfRules {
    /// Initial conditions, invariants and safety.
    keep: Vec<usize>,
    /// Justice.
    again: Vec<usize>,
    /// Rules that make a Boolean record that safety was broken, and the rule that it was; `None` if
    /// there is no safety.
    broken: Option<(Vec<usize>, usize)>,
}

/// Answers questions about the runs of a system.
#[derive(Debug)]
pub struct Decider<'a> {
    system: &'a System,
    runs: Runs,
    halves: BTreeMap<(usize, ContractSide), HalfRules>,
    definitions: Vec<Vec<usize>>,
}

/// Halves that are kept or broken.
type Case = BTreeMap<(usize, ContractSide), bool>;

impl<'a> Decider<'a> {
    /// Prepares the system for questions.
    ///
    /// # Errors
    /// When the variables do not fit into the limits.
    pub fn new(system: &'a System, limits: &Limits) -> Result<Self, Limit> {
        let mut variables = system.variables.clone();
        let mut rules = Vec::new();
        let mut halves = BTreeMap::new();
        let mut definitions = Vec::new();
        for (i, part) in system.parts.iter().enumerate() {
            let mut own = Vec::new();
            for (kind, _, formula) in formulas(&part.definitions) {
                own.push(rules.len());
                rules.push(rule(kind, &formula.expr));
            }
            definitions.push(own);
            for half in [ContractSide::Assumptions, ContractSide::Guarantees] {
                let bit = VarId(variables.len() as u32);
                let written = write(part.half(half), bit, &mut rules);
                if written.broken.is_some() {
                    variables.push(Variable {
                        name: system.fresh_name(&format!("broken {}", variables.len())),
                        owner: Owner::System,
                        internal: true,
                        domain: Domain::Bool,
                        unit: String::new(),
                        span: Span::default(),
                    });
                }
                halves.insert((i, half), written);
            }
        }
        Ok(Self {
            system,
            runs: Runs::new(&variables, rules, limits)?,
            halves,
            definitions,
        })
    }

    /// Returns a run of a set, over the system's variables; `None` if there is none.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn find(&mut self, words: &Words) -> Result<Option<Lasso>, Limit> {
        let mut seen = BTreeSet::new();
        self.cases(vec![(words.clone(), true)], Case::new(), &mut seen)
    }

    /// Returns a run of the first set that is not in the second; `None` if there is none.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn difference(&mut self, small: &Words, large: &Words) -> Result<Option<Lasso>, Limit> {
        self.find(&small.clone().and(large.clone().not()))
    }

    /// Returns why a contract does not refine another: a run that the other's environments allow
    /// and it does not, or one that it allows an implementation and the other forbids. `None` if it
    /// does.
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

    /// Returns whether two contracts are equal.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn equivalent(&mut self, a: &Contract, b: &Contract) -> Result<bool, Limit> {
        Ok(self.refutation(a, b)?.is_none() && self.refutation(b, a)?.is_none())
    }

    /// Splits the remaining sets, and decides every case.
    fn cases(
        &mut self,
        mut left: Vec<(Words, bool)>,
        mut case: Case,
        seen: &mut BTreeSet<Vec<((usize, ContractSide), bool)>>,
    ) -> Result<Option<Lasso>, Limit> {
        while let Some((words, kept)) = left.pop() {
            match (words, kept) {
                (Words::Not(inner), kept) => left.push((*inner, !kept)),
                (Words::Side(part, half), kept) => {
                    if case.insert((part, half), kept).is_some_and(|k| k != kept) {
                        return Ok(None);
                    }
                }
                (Words::All(all), true) => left.extend(all.into_iter().map(|w| (w, true))),
                (Words::Any(any), false) => left.extend(any.into_iter().map(|w| (w, false))),
                (Words::All(list), false) | (Words::Any(list), true) => {
                    for one in list {
                        let mut rest = left.clone();
                        rest.push((one, kept));
                        if let Some(run) = self.cases(rest, case.clone(), seen)? {
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
        self.ask(&key)
    }

    /// Decides one case: every way in which its broken halves may be broken.
    fn ask(&mut self, case: &[((usize, ContractSide), bool)]) -> Result<Option<Lasso>, Limit> {
        let mut wanted = RunQuery::default();
        let parts: BTreeSet<usize> = case.iter().map(|((part, _), _)| *part).collect();
        for part in parts {
            wanted.keep.extend(&self.definitions[part]);
        }
        let mut broken = Vec::new();
        for (at, kept) in case {
            let half = &self.halves[at];
            if *kept {
                wanted.keep.extend(&half.keep);
                wanted.again.extend(&half.again);
            } else {
                broken.push(half.clone());
            }
        }
        self.ways(&wanted, &broken)
    }

    fn ways(&mut self, wanted: &RunQuery, broken: &[HalfRules]) -> Result<Option<Lasso>, Limit> {
        let Some((half, rest)) = broken.split_first() else {
            let found = self.runs.lasso(wanted)?;
            return Ok(found.map(|run| self.visible(run)));
        };
        if let Some((remember, seen)) = &half.broken {
            let mut more = wanted.clone();
            more.keep.extend(remember);
            more.again.push(*seen);
            if let Some(run) = self.ways(&more, rest)? {
                return Ok(Some(run));
            }
        }
        for justice in &half.again {
            let mut more = wanted.clone();
            more.never_again.push(*justice);
            if let Some(run) = self.ways(&more, rest)? {
                return Ok(Some(run));
            }
        }
        Ok(None)
    }

    /// Removes the Booleans that only the questions needed.
    fn visible(&self, mut run: Lasso) -> Lasso {
        let count = self.system.variables.len();
        for step in run.prefix.iter_mut().chain(&mut run.cycle) {
            step.truncate(count);
        }
        run
    }
}

/// Writes one half as rules; `bit` records that its safety was broken.
fn write(side: &Side, bit: VarId, rules: &mut Vec<Rule>) -> HalfRules {
    let mut written = HalfRules::default();
    let mut first = Expr::FALSE;
    let mut later = Expr::FALSE;
    for (kind, _, formula) in formulas(side) {
        let index = rules.len();
        rules.push(rule(kind, &formula.expr));
        let broken = formula.expr.clone().not();
        match kind {
            RuleKind::Justice => {
                written.again.push(index);
                continue;
            }
            RuleKind::Initial => first = first.or(broken),
            RuleKind::Invariant => {
                let next = broken.substitute(&mut |v, _| Expr::Var(v, Time::Next));
                first = first.or(broken);
                later = later.or(next);
            }
            RuleKind::Safety => later = later.or(broken),
        }
        written.keep.push(index);
    }
    if !written.keep.is_empty() {
        let start = rules.len();
        rules.push(Rule {
            kind: RuleKind::Initial,
            expr: Expr::now(bit).equals(first.simplify()),
        });
        rules.push(Rule {
            kind: RuleKind::Safety,
            expr: Expr::next(bit).equals(Expr::now(bit).or(later.simplify())),
        });
        rules.push(Rule {
            kind: RuleKind::Justice,
            expr: Expr::now(bit),
        });
        written.broken = Some((vec![start, start + 1], start + 2));
    }
    written
}
