//! Finds runs that a set of rules allows: the basis of every proof about contracts.
//!
//! No game is involved. Each query selects the rules that it uses, so a caller can leave out rules
//! to find out which of them a proof needs. Two kinds of queries suffice:
//!
//! - [`Runs::find_lasso`] searches for an infinite run that keeps some rules in every step, meets
//!   some justice infinitely often, and other justice only finitely often. Language inclusion,
//!   equivalence and emptiness all reduce to it. The fair states are computed as by Emerson and Lei
//!   ("Efficient model checking in fragments of the propositional mu-calculus", LICS 1986), within
//!   the reachable states.
//! - [`Runs::find_violation`] searches for a step that breaks a rule, although all earlier steps
//!   keep a given set of rules and the step itself keeps another. This is the induction step of a
//!   proof over time. Such a proof is sound even if components rely on each other in a cycle.

mod aside;
mod fair;
mod path;
mod reached;
mod rule_encoder;
mod steps;

use super::structure::{self, Orientation};
use crate::symbolic::{Biodivine, Encoding, Kernel, Limit, Limits, Order, SharedStore};
use linewright_core::gr1::{
    Domain, Expr, Formula, FormulaKind, Side, Specification, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use rule_encoder::RuleEncoder;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

/// A formula with its kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// Kind of the rule.
    pub kind: FormulaKind,
    /// The formula.
    pub expr: Expr,
}

/// An infinite run: some steps, and a cycle that repeats for ever. A step has a value for every
/// variable.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Lasso {
    /// The steps before the cycle.
    pub prefix: Vec<Vec<i64>>,
    /// The steps of the cycle; never empty.
    pub cycle: Vec<Vec<i64>>,
}

/// Required properties of an infinite run. Rules are given by their index in [`Runs::rules`].
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct RunQuery {
    /// Initial conditions, invariants and safety that the run keeps.
    pub keep: Vec<usize>,
    /// Justice that the run meets infinitely often.
    pub infinitely_often: Vec<usize>,
    /// Justice that the run never meets from some step on.
    pub finitely_often: Vec<usize>,
}

impl RunQuery {
    /// The same query with its rules in ascending order.
    fn in_order(&self) -> Self {
        let in_order = |rules: &[usize]| {
            let mut rules = rules.to_vec();
            rules.sort_unstable();
            rules
        };
        Self {
            keep: in_order(&self.keep),
            infinitely_often: in_order(&self.infinitely_often),
            finitely_often: in_order(&self.finitely_often),
        }
    }

    /// Whether this query asks for some of the properties for which another asks, so that every run
    /// with the other's has these. The rules of both are in order.
    fn is_weaker(&self, other: &Self) -> bool {
        let is_subset =
            |some: &[usize], all: &[usize]| some.iter().all(|rule| all.binary_search(rule).is_ok());
        is_subset(&self.keep, &other.keep)
            && is_subset(&self.infinitely_often, &other.infinitely_often)
            && is_subset(&self.finitely_often, &other.finitely_often)
    }
}

/// Required properties of a finite run whose last step breaks a rule. Rules are given by their
/// index in [`Runs::rules`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SafetyViolationQuery {
    /// Rules that all steps before the last one keep.
    pub before: Vec<usize>,
    /// Rules that the last step keeps.
    pub last: Vec<usize>,
    /// Rule that the last step breaks: an initial condition, an invariant or safety.
    pub broken: usize,
}

/// Rules over variables, with queries about the runs that they allow.
///
/// A query can take as long as computing all states reachable under the rules that it keeps.
#[derive(Debug)]
pub struct Runs {
    specification: Specification,
    rules: Vec<Rule>,
    order: Order,
    limits: Limits,
    engine: Box<dyn Engine>,
    /// Answers of [`Self::has_lasso`]. A prover repeats many of its questions.
    has_lasso: FxHashMap<RunQuery, bool>,
    /// Work done on the small kernel before the switch to the large one.
    earlier_work: u64,
}

/// Maximum number of bit pairs for the small kernel.
const SMALL_PAIRS: usize = 24;

/// Queries on one kernel; see the methods of [`Runs`].
trait Engine: Debug + Send {
    fn lasso(&mut self, rules: &[Rule], query: &RunQuery) -> Result<Option<Lasso>, Limit>;
    fn has_lasso(&mut self, rules: &[Rule], query: &RunQuery) -> Result<bool, Limit>;
    fn step(
        &mut self,
        rules: &[Rule],
        query: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit>;
    fn has_step(&mut self, rules: &[Rule], query: &SafetyViolationQuery) -> Result<bool, Limit>;
    fn depends(
        &mut self,
        rules: &[Rule],
        keep: &[usize],
        answer: VarId,
        own: &[VarId],
    ) -> Result<Vec<VarId>, Limit>;
    fn count(&mut self, rules: &[Rule], keep: &[usize]) -> Result<f64, Limit>;
    fn work(&self) -> u64;
}

impl Runs {
    /// Creates the rules and a kernel for queries about them.
    ///
    /// # Errors
    /// Returns an error if the kernel cannot hold the variables.
    pub fn new(variables: &[Variable], rules: Vec<Rule>, limits: &Limits) -> Result<Self, Limit> {
        let specification = as_specification(variables, &rules);
        let encoding = Encoding::new(&specification);
        let pairs = encoding.pairs().max(1);
        let order = structure::order(&specification, &encoding, pairs, Orientation::AsFound);
        let engine: Box<dyn Engine> = if pairs <= SMALL_PAIRS {
            Box::new(RuleEncoder::<Biodivine>::new(
                &specification,
                &order,
                limits,
            )?)
        } else {
            Box::new(RuleEncoder::<SharedStore>::new(
                &specification,
                &order,
                limits,
            )?)
        };
        Ok(Self {
            specification,
            rules,
            order,
            limits: *limits,
            engine,
            has_lasso: FxHashMap::default(),
            earlier_work: 0,
        })
    }

    /// Returns the work done for all queries so far; see [`Kernel::work`]. Work is counted only if
    /// [`Limits::max_work`] is given.
    pub fn work(&self) -> u64 {
        self.earlier_work + self.engine.work()
    }

    /// Runs a query, and repeats it on the large kernel if the small one runs out of memory.
    fn run_query<T>(
        &mut self,
        query: impl Fn(&mut dyn Engine, &[Rule]) -> Result<T, Limit>,
    ) -> Result<T, Limit> {
        let answer = match query(&mut *self.engine, &self.rules) {
            Err(Limit::Memory) if self.switch_kernel()? => query(&mut *self.engine, &self.rules),
            answer => answer,
        };
        answer.map_err(|limit| self.limits.attribute(limit))
    }

    /// Returns the rules.
    pub fn rules(&self) -> &[Rule] {
        &self.rules
    }

    /// Returns the variables.
    pub fn variables(&self) -> &[Variable] {
        &self.specification.variables
    }

    /// Adds a rule over the same variables; returns its index.
    pub fn add(&mut self, rule: Rule) -> usize {
        self.rules.push(rule);
        self.rules.len() - 1
    }

    /// Returns the variables on which the choice of `answer` depends: their values in a step affect
    /// which values of `answer` the rules `keep` allow in that step, regardless of earlier steps.
    /// The variables `own` are set together with `answer` and do not count.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn dependencies(
        &mut self,
        keep: &[usize],
        answer: VarId,
        own: &[VarId],
    ) -> Result<Vec<VarId>, Limit> {
        self.run_query(|engine, rules| engine.depends(rules, keep, answer, own))
    }

    /// Returns a run with these properties, or `None` if none exists. Its prefix and its cycle are
    /// not always the shortest possible ones. Variables that no rule of the query mentions have the
    /// smallest values of their domains.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn find_lasso(&mut self, query: &RunQuery) -> Result<Option<Lasso>, Limit> {
        self.run_query(|engine, rules| engine.lasso(rules, query))
    }

    /// Whether a run with these properties exists. Cheaper than [`Runs::find_lasso`], since no run
    /// is extracted. A repeated query is answered at once.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn has_lasso(&mut self, query: &RunQuery) -> Result<bool, Limit> {
        let query = query.in_order();
        if let Some(known) = self.has_lasso.get(&query) {
            return Ok(*known);
        }
        let found = self.run_query(|engine, rules| engine.has_lasso(rules, &query))?;
        self.has_lasso.insert(query, found);
        Ok(found)
    }

    /// Returns a shortest run whose last step breaks the rule; `None` if no step can break it.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn find_violation(
        &mut self,
        query: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        self.run_query(|engine, rules| engine.step(rules, query))
    }

    /// Whether some step can break the rule. Cheaper than [`Runs::find_violation`], since no run is
    /// extracted.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn has_violation(&mut self, query: &SafetyViolationQuery) -> Result<bool, Limit> {
        self.run_query(|engine, rules| engine.has_step(rules, query))
    }

    /// Returns the number of states reachable under these rules. A state is a valuation of the
    /// variables that the rules mention. The number is exact below 2⁵³.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn count_states(&mut self, keep: &[usize]) -> Result<f64, Limit> {
        self.run_query(|engine, rules| engine.count(rules, keep))
    }

    /// Switches to the large kernel and returns true, so that the query is repeated. Returns false
    /// if the number of bits required the large kernel from the start.
    fn switch_kernel(&mut self) -> Result<bool, Limit> {
        if self.order.pairs().len() > SMALL_PAIRS {
            return Ok(false);
        }
        self.earlier_work = self.engine.work();
        self.engine = Box::new(RuleEncoder::<SharedStore>::new(
            &self.specification,
            &self.order,
            &self.limits,
        )?);
        Ok(true)
    }
}

impl<K: Kernel> Engine for RuleEncoder<K> {
    fn lasso(&mut self, rules: &[Rule], query: &RunQuery) -> Result<Option<Lasso>, Limit> {
        self.find_lasso(rules, query)
    }

    fn has_lasso(&mut self, rules: &[Rule], query: &RunQuery) -> Result<bool, Limit> {
        self.lasso_exists(rules, query)
    }

    fn step(
        &mut self,
        rules: &[Rule],
        query: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        self.find_violation(rules, query)
    }

    fn has_step(&mut self, rules: &[Rule], query: &SafetyViolationQuery) -> Result<bool, Limit> {
        self.violation_exists(rules, query)
    }

    fn depends(
        &mut self,
        rules: &[Rule],
        keep: &[usize],
        answer: VarId,
        own: &[VarId],
    ) -> Result<Vec<VarId>, Limit> {
        self.find_dependencies(rules, keep, answer, own)
    }

    fn count(&mut self, rules: &[Rule], keep: &[usize]) -> Result<f64, Limit> {
        self.count_states(rules, keep)
    }

    fn work(&self) -> u64 {
        self.kernel().work()
    }
}

/// Returns variables and rules as a specification, for the encoding and order of bits.
fn as_specification(variables: &[Variable], rules: &[Rule]) -> Specification {
    let formulas = rules.iter().map(|rule| Formula {
        defines: false,
        name: String::new(),
        requirement: None,
        expr: rule.expr.clone(),
        span: Span::default(),
        text: String::new(),
    });
    Specification {
        name: String::new(),
        timing: Timing::Mealy,
        variables: variables.to_vec(),
        assumptions: Side::default(),
        guarantees: Side {
            safety: formulas.collect(),
            ..Side::default()
        },
    }
}

/// Returns the smallest value of every variable. Variables that no rule of a query mentions get
/// this value.
fn smallest(variables: &[Variable]) -> Vec<i64> {
    variables.iter().map(|v| Domain::low(&v.domain)).collect()
}
