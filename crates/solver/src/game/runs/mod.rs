//! Infinite behaviors allowed by a set of rules, with an example: the question behind every proof
//! about contracts.
//!
//! There is no game here. Rules are combined as a question needs them, so that omitting rules shows
//! what a proof rests on. Two questions suffice:
//!
//! - [`Runs::lasso`]: is there an infinite run that keeps these rules in every step, meets those
//!   again and again, and from some step on breaks some others for ever? Language inclusion,
//!   equivalence and emptiness all reduce to it. Fair states are computed as by Emerson and Lei
//!   ("Efficient model checking in fragments of the propositional mu-calculus", LICS 1986), within
//!   the reachable states.
//! - [`Runs::step`]: can a rule be broken in a step, although every step before it kept all rules,
//!   and this one keeps some? It is the step of an induction over time, which is sound even if
//!   components rely on one another in a circle.

mod fair;
mod path;
mod rule_encoder;

use super::structure;
use crate::symbolic::{Biodivine, Encoding, Kernel, Limit, Limits, Order, OxiDd};
use linewright_core::gr1::{Domain, Expr, Formula, Side, Specification, Timing, VarId, Variable};
use linewright_core::source::Span;
use rule_encoder::RuleEncoder;
use std::fmt::Debug;

/// When a rule holds. [`linewright_core::gr1`] defines each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RuleKind {
    /// In step 0.
    Initial,
    /// In every step.
    Invariant,
    /// From every step to the next.
    Safety,
    /// Infinitely often; demanded of a run by [`RunQuery::again`] or [`RunQuery::never_again`].
    Justice,
}

/// A formula and when it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// When it holds.
    pub kind: RuleKind,
    /// The formula.
    pub expr: Expr,
}

/// An infinite run: some steps, and then a cycle for ever. A step has a value for every variable.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Lasso {
    /// The steps before the cycle.
    pub prefix: Vec<Vec<i64>>,
    /// The steps of the cycle; never empty.
    pub cycle: Vec<Vec<i64>>,
}

/// Properties of a run; rules are given by index in the list passed to [`Runs`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RunQuery {
    /// Initial conditions, invariants and safety that hold throughout.
    pub keep: Vec<usize>,
    /// Justice that is met again and again.
    pub again: Vec<usize>,
    /// Justice that is not met any more from some step on.
    pub never_again: Vec<usize>,
}

/// A question for a run that breaks a rule.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SafetyViolationQuery {
    /// Rules that every step before the last one keeps.
    pub before: Vec<usize>,
    /// Rules that the last step keeps as well.
    pub last: Vec<usize>,
    /// The rule that the last step breaks: an initial condition, an invariant, or safety.
    pub broken: usize,
}

/// Rules over variables; answers questions about them.
///
/// A question costs as much as reaching all states allowed by the kept rules.
#[derive(Debug)]
pub struct Runs {
    specification: Specification,
    rules: Vec<Rule>,
    order: Order,
    limits: Limits,
    asked: Box<dyn Ask>,
    /// Work done on the small kernel before leaving it.
    before: u64,
}

/// Maximum number of bit pairs for the small kernel.
const SMALL_PAIRS: usize = 24;

trait Ask: Debug + Send {
    fn lasso(&mut self, rules: &[Rule], wanted: &RunQuery) -> Result<Option<Lasso>, Limit>;
    fn any_lasso(&mut self, rules: &[Rule], wanted: &RunQuery) -> Result<bool, Limit>;
    fn step(
        &mut self,
        rules: &[Rule],
        slip: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit>;
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
    /// Prepares questions about these rules.
    ///
    /// # Errors
    /// Returns an error if the kernel cannot hold the variables.
    pub fn new(variables: &[Variable], rules: Vec<Rule>, limits: &Limits) -> Result<Self, Limit> {
        let specification = as_specification(variables, &rules);
        let encoding = Encoding::new(&specification);
        let pairs = encoding.pairs().max(1);
        let order = structure::order(&specification, &encoding, pairs);
        let asked: Box<dyn Ask> = if pairs <= SMALL_PAIRS {
            Box::new(RuleEncoder::<Biodivine>::new(
                &specification,
                &order,
                limits,
            )?)
        } else {
            Box::new(RuleEncoder::<OxiDd>::new(&specification, &order, limits)?)
        };
        Ok(Self {
            specification,
            rules,
            order,
            limits: *limits,
            asked,
            before: 0,
        })
    }

    /// Work done for all questions so far; see [`Kernel::work`]. It is counted if
    /// [`Limits::most_work`] is given.
    pub fn work(&self) -> u64 {
        self.before + self.asked.work()
    }

    /// Asks a question, and repeats it on the large kernel if the small one runs out of room.
    fn ask<T>(
        &mut self,
        question: impl Fn(&mut dyn Ask, &[Rule]) -> Result<T, Limit>,
    ) -> Result<T, Limit> {
        let answer = match question(&mut *self.asked, &self.rules) {
            Err(Limit::Memory) if self.grow()? => question(&mut *self.asked, &self.rules),
            answer => answer,
        };
        answer.map_err(|limit| self.limits.name(limit))
    }

    /// The rules.
    pub fn rules(&self) -> &[Rule] {
        &self.rules
    }

    /// The variables.
    pub fn variables(&self) -> &[Variable] {
        &self.specification.variables
    }

    /// Adds a rule over the same variables; returns its index.
    pub fn add(&mut self, rule: Rule) -> usize {
        self.rules.push(rule);
        self.rules.len() - 1
    }

    /// The variables whose values in a step influence which `answer` these rules allow in that
    /// step, whatever came before. `own` are set together with it and do not count. Kept rules are
    /// as in [`RunQuery::keep`].
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn depends(
        &mut self,
        keep: &[usize],
        answer: VarId,
        own: &[VarId],
    ) -> Result<Vec<VarId>, Limit> {
        self.ask(|asked, rules| asked.depends(rules, keep, answer, own))
    }

    /// A run with these properties, or `None` if there is none. The way into the cycle is a
    /// shortest one; the cycle itself need not be shortest. Variables that no rule of the question
    /// mentions have the smallest value of their domain.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn lasso(&mut self, wanted: &RunQuery) -> Result<Option<Lasso>, Limit> {
        self.ask(|asked, rules| asked.lasso(rules, wanted))
    }

    /// Whether there is a run with these properties: [`Runs::lasso`] without the run, which costs
    /// less.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn any_lasso(&mut self, wanted: &RunQuery) -> Result<bool, Limit> {
        self.ask(|asked, rules| asked.any_lasso(rules, wanted))
    }

    /// The shortest run up to and including a step that breaks the rule; `None` if no step can
    /// break it.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn step(&mut self, slip: &SafetyViolationQuery) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        self.ask(|asked, rules| asked.step(rules, slip))
    }

    /// Number of states reachable under these rules, where a state gives a value to every variable
    /// that they mention. Exact below 2⁵³.
    ///
    /// # Errors
    /// Returns the limit that was reached.
    pub fn count(&mut self, keep: &[usize]) -> Result<f64, Limit> {
        self.ask(|asked, rules| asked.count(rules, keep))
    }

    /// Switches to the large kernel, unless that was already done. Returns whether to repeat the
    /// question.
    fn grow(&mut self) -> Result<bool, Limit> {
        if self.order.pairs().len() > SMALL_PAIRS {
            return Ok(false);
        }
        self.before = self.asked.work();
        self.asked = Box::new(RuleEncoder::<OxiDd>::new(
            &self.specification,
            &self.order,
            &self.limits,
        )?);
        Ok(true)
    }
}

impl<K: Kernel> Ask for RuleEncoder<K> {
    fn lasso(&mut self, rules: &[Rule], wanted: &RunQuery) -> Result<Option<Lasso>, Limit> {
        self.find_lasso(rules, wanted)
    }

    fn any_lasso(&mut self, rules: &[Rule], wanted: &RunQuery) -> Result<bool, Limit> {
        self.is_any_lasso(rules, wanted)
    }

    fn step(
        &mut self,
        rules: &[Rule],
        slip: &SafetyViolationQuery,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        self.find_slip(rules, slip)
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

/// Variables and rules as a specification, for the layout and order of bits.
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

/// The smallest value of every variable: used in a run for variables of which nothing is known.
fn smallest(variables: &[Variable]) -> Vec<i64> {
    variables.iter().map(|v| Domain::low(&v.domain)).collect()
}
