//! Past operators, counters and specification patterns, lowered to GR(1) with monitor variables.
//!
//! A GR(1) formula relates only the current step and the next one. What a formula says about the
//! past is stored in additional variables of the machine, called *monitors*. The idea is old
//! (Pnueli, The Temporal Semantics of Concurrent Programs, 1981, for past operators; Maoz and
//! Ringert, GR(1) Synthesis for LTL Specification Patterns, ESEC/FSE 2015, for patterns). What is
//! new here: every pattern is written with past operators only, and a [`Scope`] defines the steps
//! in which the pattern has to hold. So the 25 combinations need only five scopes and five
//! patterns, and equal parts of different formulas share one monitor.
//!
//! # What a monitor is
//!
//! The value of a monitor in step *t* depends on the steps before *t* only. A monitor has an
//! initial value and an *update*: an expression over current values that gives its value in the
//! next step. So it never depends on the inputs of the step in which it is read, and works for
//! Mealy and Moore machines alike. The machine has no choice of its value, so monitors do not
//! change who wins a game.
//!
//! There are no steps before step 0. Therefore `previous` and `once` begin as false, and
//! `historically` begins as true.
//!
//! # Cost
//!
//! In the worst case each bit of state doubles a game, so the aim is to save bits:
//!
//! | | bits |
//! |---|---|
//! | `previous`, `once`, `historically`, `since` | 1 each |
//! | `once` and `historically` within *n* steps, a counter up to *n* | those of 0..*n* |
//!
//! | pattern | globally | before r | after q | between q and r | after q until r |
//! |---|---|---|---|---|---|
//! | absence, universality | 0 | 2 | 1 | 2 | 1 |
//! | existence | 1 | 1 | 2 | 1 | 1 |
//! | precedence | 1 | 2 | 2 | 2 | 1 |
//! | response | 1 | 2 | 2 | 2 | 2 |
//!
//! No deterministic monitor has fewer bits: where the table says 2, three different pasts must be
//! distinguished. All formulas with the same scope share the bits that store whether it is open,
//! and all formulas with `once p` share its bit. A response or existence within *n* steps needs a
//! counter up to *n*, or up to *n* + 1 in a scope that counts only if it closes (one more for an
//! existence in a scope that is open from the beginning). A response in any scope but `globally`
//! also needs the bit that stores whether the scope is open.
//!
//! # Assumptions
//!
//! An assumed initial condition or invariant must not mention the machine's variables, and monitors
//! are variables of the machine. So an invariant that reads monitors is
//! [unrolled](Monitors::unroll) before it is assumed.

mod absence;
mod counter;
mod deadline;
mod existence;
mod historically;
mod once;
mod precedence;
mod previous;
mod response;
mod scope;
mod since;
mod universality;
mod unroll;

pub use scope::Scope;
pub use unroll::UnrolledInvariant;

use super::{BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, VarId, Variable};
use crate::gr1::FormulaKind;
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Placeholder for the value of a monitor in its own update, as long as the monitor has no
/// variable.
const SELF_VALUE: VarId = VarId(u32::MAX);

/// The formula that a monitor is created for. Its text is displayed instead of the formulas that
/// define the monitor.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// Name of the assumption or guarantee.
    pub name: String,
    /// Requirement of the formula.
    pub requirement: Option<String>,
    /// Place in the source.
    pub span: Span,
    /// Subformula that the monitor tracks, in one line: `once (a and b)`.
    pub text: String,
}

/// A variable that stores information about earlier steps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Monitor {
    /// Index among the specification's variables.
    pub id: VarId,
    /// Declaration of the variable.
    pub variable: Variable,
    /// Value in step 0.
    pub initial: i64,
    /// Value in the next step, as an expression over current values; never outside the domain.
    pub update: Expr,
    /// Formula that the monitor was first created for.
    pub origin: Origin,
}

impl Monitor {
    /// Returns the guarantee for step 0: the monitor has its initial value.
    pub fn initial_formula(&self) -> Formula {
        self.formula(Expr::now(self.id).equals(Expr::Const(self.initial)))
    }

    /// Returns the safety guarantee: the monitor's next value equals its update.
    pub fn update_formula(&self) -> Formula {
        self.formula(Expr::next(self.id).equals(self.update.clone()))
    }

    fn formula(&self, expr: Expr) -> Formula {
        Formula {
            defines: true,
            name: self.origin.name.clone(),
            requirement: self.origin.requirement.clone(),
            expr,
            span: self.origin.span,
            text: self.origin.text.clone(),
        }
    }
}

/// One of the formulas a pattern is reduced to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Obligation {
    /// When the condition has to hold.
    pub kind: FormulaKind,
    /// Condition that has to hold. Obligations of patterns read current values only.
    pub expr: Expr,
}

impl Obligation {
    fn new(kind: FormulaKind, expr: &Expr) -> Self {
        Self {
            kind,
            expr: expr.simplify(),
        }
    }

    /// Adds the obligation to its list, with the name, place and text of `origin`.
    pub fn add_to(&self, side: &mut Side, origin: &Origin) {
        let list = side.list_mut(self.kind);
        list.push(Formula {
            defines: false,
            name: origin.name.clone(),
            requirement: origin.requirement.clone(),
            expr: self.expr.clone(),
            span: origin.span,
            text: origin.text.clone(),
        });
    }
}

/// Condition on the steps of a scope. Operands are boolean expressions over current values.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// The condition never holds.
    Absence(Expr),
    /// The condition holds in some step; with a bound, at most that many steps after the scope
    /// opens.
    Existence(Expr, Option<u32>),
    /// The condition holds in every step.
    Universality(Expr),
    /// `then` does not hold before `first` has held. Both can hold for the first time in the same
    /// step.
    Precedence {
        /// Condition that has to come first.
        first: Expr,
        /// Condition that must not come before `first`.
        then: Expr,
    },
    /// Every `trigger` is answered in its step or later; with a bound, at most that many steps
    /// later.
    Response {
        /// Request.
        trigger: Expr,
        /// Answer.
        answer: Expr,
        /// Maximum number of steps from request to answer.
        within: Option<u32>,
    },
}

/// A past formula that is tracked by a monitor.
#[derive(Debug, Clone)]
struct TrackedFormula {
    /// Value in the previous step: the monitor itself.
    before: Expr,
    /// Value in this step.
    now: Expr,
}

/// Creates and owns monitors. Equal operators with equal operands share one monitor. Names depend
/// only on the order of the calls.
///
/// All operands must be expressions over current values, which can include values of earlier
/// monitors. The caller must check this, since only the caller can report it to the user; here it
/// is only asserted, in debug builds.
#[derive(Debug, Clone)]
pub struct Monitors {
    first: u32,
    taken: BTreeSet<String>,
    /// Last number used for each name stem.
    numbers: BTreeMap<&'static str, u32>,
    list: Vec<Monitor>,
    /// Monitors by domain, initial value and update, in which [`SELF_VALUE`] stands for the
    /// monitor.
    known: HashMap<(Domain, i64, Expr), VarId>,
    /// Boolean monitors that start as false, by update: each holds the value that its update
    /// expression had one step ago.
    delays: HashMap<Expr, VarId>,
}

impl Monitors {
    /// Creates an empty set. The first monitor will have the id `first`, and the following monitors
    /// the ids after it. No monitor gets a name in `taken`.
    pub fn new(first: VarId, taken: impl IntoIterator<Item = String>) -> Self {
        Self {
            first: first.0,
            taken: taken.into_iter().collect(),
            numbers: BTreeMap::new(),
            list: Vec::new(),
            known: HashMap::new(),
            delays: HashMap::new(),
        }
    }

    /// Renames a monitor, given the expression that reads it. Does nothing if `value` is not the
    /// current value of a monitor.
    pub fn rename(&mut self, value: &Expr, name: &str) {
        if let Expr::Var(id, Time::Now) = value
            && let Some(place) = id.0.checked_sub(self.first)
            && let Some(monitor) = self.list.get_mut(place as usize)
        {
            name.clone_into(&mut monitor.variable.name);
        }
    }

    /// Returns all monitors in the order of their ids.
    pub fn all(&self) -> &[Monitor] {
        &self.list
    }

    /// Returns the monitor with this id; `None` if the variable is not a monitor.
    pub fn get(&self, id: VarId) -> Option<&Monitor> {
        let place = id.0.checked_sub(self.first)?;
        self.list.get(place as usize)
    }

    /// Returns whether an expression reads a monitor.
    pub fn occur_in(&self, expr: &Expr) -> bool {
        let mut found = false;
        expr.for_each_var(&mut |v, _| found |= self.get(v).is_some());
        found
    }

    /// Returns the variables that a specification has to append, in order.
    pub fn variables(&self) -> impl Iterator<Item = &Variable> {
        self.list.iter().map(|m| &m.variable)
    }

    /// Adds the guarantees that define the monitors.
    pub fn define(&self, guarantees: &mut Side) {
        guarantees
            .initial
            .extend(self.list.iter().map(Monitor::initial_formula));
        guarantees
            .safety
            .extend(self.list.iter().map(Monitor::update_formula));
    }

    /// Appends the monitors to a specification: variables and guarantees. The specification's
    /// variables must end where the monitors' ids begin.
    pub fn add_to(&self, specification: &mut Specification) {
        debug_assert_eq!(specification.variables.len(), self.first as usize);
        specification.variables.extend(self.variables().cloned());
        self.define(&mut specification.guarantees);
    }

    /// Returns obligations that hold exactly if the pattern holds in the scope. For the meaning of
    /// a pattern in temporal logic, see the module of the same name, such as `absence`.
    pub fn pattern(
        &mut self,
        pattern: &Pattern,
        scope: &Scope,
        origin: &Origin,
    ) -> Vec<Obligation> {
        match pattern {
            Pattern::Absence(p) => absence::lower(self, p, scope, origin),
            Pattern::Existence(p, None) => existence::lower(self, p, scope, origin),
            Pattern::Existence(p, Some(n)) => existence::within(self, p, *n, scope, origin),
            Pattern::Universality(p) => universality::lower(self, p, scope, origin),
            Pattern::Precedence { first, then } => {
                precedence::lower(self, first, then, scope, origin)
            }
            Pattern::Response {
                trigger,
                answer,
                within: None,
            } => response::lower(self, trigger, answer, scope, origin),
            Pattern::Response {
                trigger,
                answer,
                within: Some(n),
            } => response::within(self, trigger, answer, *n, scope, origin),
        }
    }

    /// Creates or reuses a boolean monitor. Its value in step 0 is `initially`, and its update is
    /// `now` applied to the monitor's own value.
    fn track(
        &mut self,
        stem: &'static str,
        initially: bool,
        now: impl Fn(Expr) -> Expr,
        origin: &Origin,
    ) -> TrackedFormula {
        let (initial, definition) = (i64::from(initially), now(Expr::now(SELF_VALUE)).simplify());
        let before = self.make(stem, Domain::Bool, initial, &definition, origin);
        let now = replace_self(&definition, &before);
        TrackedFormula { before, now }
    }

    /// Like [`track`](Self::track), but returns only the formula's value in this step. No monitor
    /// is created if that value does not depend on the past.
    fn track_now(
        &mut self,
        stem: &'static str,
        initially: bool,
        now: impl Fn(Expr) -> Expr,
        origin: &Origin,
    ) -> Expr {
        let definition = now(Expr::now(SELF_VALUE)).simplify();
        let mut past = false;
        definition.for_each_var(&mut |v, _| past |= v == SELF_VALUE);
        if past {
            self.track(stem, initially, now, origin).now
        } else {
            definition
        }
    }

    /// Returns the value of the monitor with this domain, initial value and update, in which
    /// [`SELF_VALUE`] stands for the monitor. Creates the monitor if it does not exist; returns a
    /// constant instead if its value would never change.
    fn make(
        &mut self,
        stem: &'static str,
        domain: Domain,
        initial: i64,
        definition: &Expr,
        origin: &Origin,
    ) -> Expr {
        debug_assert!(
            !definition.mentions_next(),
            "the update of a monitor must not refer to next values: {definition:?}"
        );
        debug_assert!(domain.contains(initial));
        let constant = Expr::Const(initial);
        if replace_self(definition, &constant) == constant {
            return constant;
        }
        let key = (domain, initial, definition.clone());
        if let Some(id) = self.known.get(&key) {
            return Expr::now(*id);
        }
        let id = VarId(self.first + self.list.len() as u32);
        let update = replace_self(definition, &Expr::now(id));
        let domain = key.0.clone();
        self.known.insert(key, id);
        if domain == Domain::Bool && initial == 0 {
            self.delays.entry(update.clone()).or_insert(id);
        }
        let name = self.name(stem);
        self.list.push(Monitor {
            id,
            variable: Variable {
                name,
                owner: Owner::System,
                internal: true,
                unit: String::new(),
                domain,
                span: origin.span,
            },
            initial,
            update,
            origin: origin.clone(),
        });
        Expr::now(id)
    }

    /// Returns the next free name of `stem_1`, `stem_2`, ...
    fn name(&mut self, stem: &'static str) -> String {
        let number = self.numbers.entry(stem).or_insert(0);
        loop {
            *number += 1;
            let name = format!("{stem}_{number}");
            if !self.taken.contains(&name) {
                return name;
            }
        }
    }
}

/// Replaces [`SELF_VALUE`] in a definition by a monitor's value.
fn replace_self(definition: &Expr, value: &Expr) -> Expr {
    let replaced = definition.substitute(&mut |v, time| {
        if v == SELF_VALUE {
            value.clone()
        } else {
            Expr::Var(v, time)
        }
    });
    replaced.simplify()
}

/// Returns `if c then a else b`.
fn choose(c: Expr, a: Expr, b: Expr) -> Expr {
    Expr::If(Box::new(c), Box::new(a), Box::new(b))
}
