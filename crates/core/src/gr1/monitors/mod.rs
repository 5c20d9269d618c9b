//! Past operators, counters and specification patterns, lowered to GR(1) with monitor variables.
//!
//! GR(1) itself only has this step and the next one. The past that a formula refers to is kept in
//! extra variables of the machine: *monitors*. The idea is old (Pnueli, The Temporal Semantics of
//! Concurrent Programs, 1981, for past operators; Maoz and Ringert, GR(1) Synthesis for LTL
//! Specification Patterns, ESEC/FSE 2015, for patterns). New here: every pattern is written in past
//! operators alone, with a [`Scope`] that defines when it is open. So 25 combinations are five
//! scopes and five patterns, and equal parts of different formulas share one monitor.
//!
//! # What a monitor is
//!
//! Its value in step *t* is about the steps before *t*. It has an initial value and an *update*: an
//! expression over current values that gives its value in the next step. So it never depends on the
//! inputs of the step in which it is read, works for Mealy and Moore machines alike, and leaves the
//! machine no choice: monitors do not change who wins a game.
//!
//! Before step 0 nothing was true: `previous` and `once` begin as false, `historically` as true.
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
//! No deterministic monitor has fewer: where there are two bits, three pasts must be distinguished.
//! All formulas with the same scope share the bits for whether it is open, and all formulas with
//! `once p` share that bit. A response or existence within *n* steps needs a counter up to *n*, or
//! up to *n* + 1 where a scope counts only if it closes (one more for an existence due from the
//! beginning), and the bit for the scope where a response needs one above.
//!
//! # Assumptions
//!
//! An assumption must not constrain the machine's variables in the step that it is about, and
//! monitors are the machine's. So an invariant that reads monitors is [unrolled](Monitors::unroll)
//! before it is assumed.

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
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Placeholder for a monitor's own value in a definition that has no variable yet.
const ITSELF: VarId = VarId(u32::MAX);

/// The formula that a monitor is made for. Its text is shown in place of the monitor's own
/// formulas.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// Name of the assumption or guarantee.
    pub name: String,
    /// Requirement of the formula.
    pub requirement: Option<String>,
    /// Place in the source.
    pub span: Span,
    /// Subformula that the monitor is made for, in one line: `once (a and b)`.
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
    /// Value in the next step, over current values; never outside its domain.
    pub update: Expr,
    /// Formula it was first made for.
    pub origin: Origin,
}

impl Monitor {
    /// Returns the guarantee for step 0.
    pub fn start(&self) -> Formula {
        self.formula(Expr::now(self.id).equals(Expr::Const(self.initial)))
    }

    /// Returns the guarantee for every step to the next.
    pub fn step(&self) -> Formula {
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

/// Selects the list of a [`Side`] that an obligation belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Holds in step 0.
    Initial,
    /// Holds in every step.
    Invariant,
    /// Holds from every step to the next.
    Safety,
    /// Holds infinitely often.
    Justice,
}

/// One of the formulas a pattern is reduced to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Obligation {
    /// When it has to hold.
    pub kind: Kind,
    /// Condition that has to hold. Patterns give current values only.
    pub expr: Expr,
}

impl Obligation {
    fn new(kind: Kind, expr: &Expr) -> Self {
        Self {
            kind,
            expr: expr.simplify(),
        }
    }

    /// Adds the obligation to its list, with the name, place and text of `origin`.
    pub fn add_to(&self, side: &mut Side, origin: &Origin) {
        let list = match self.kind {
            Kind::Initial => &mut side.initial,
            Kind::Invariant => &mut side.invariants,
            Kind::Safety => &mut side.safety,
            Kind::Justice => &mut side.justice,
        };
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
    /// It never holds.
    Absence(Expr),
    /// It holds in some step; with a bound, at most that many steps after the scope opens.
    Existence(Expr, Option<u32>),
    /// It holds in every step.
    Universality(Expr),
    /// No `then` before the first `first`; both in one step are in order.
    Precedence {
        /// Condition that has to come first.
        first: Expr,
        /// Condition that may only come afterwards.
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
struct Remembered {
    /// Value in the previous step: the monitor itself.
    before: Expr,
    /// Value in this step.
    now: Expr,
}

/// Creates monitors and keeps those already created. Equal operators over equal operands share one
/// monitor; names depend only on the order of the calls.
///
/// All operands are expressions over current values, including those of earlier monitors. The
/// caller must check that, since it can report to the user; here it is asserted in debug builds
/// only.
#[derive(Debug, Clone)]
pub struct Monitors {
    first: u32,
    taken: BTreeSet<String>,
    /// Last number used for each name stem.
    numbers: BTreeMap<&'static str, u32>,
    made: Vec<Monitor>,
    /// Monitors by domain, initial value and update, in which [`ITSELF`] stands for the monitor.
    known: HashMap<(Domain, i64, Expr), VarId>,
    /// Boolean monitors that start as false, by update: each is the value of that expression one
    /// step ago.
    delays: HashMap<Expr, VarId>,
}

impl Monitors {
    /// Creates an empty set. The first monitor will be the variable `first`; no monitor gets a name
    /// in `taken`.
    pub fn new(first: VarId, taken: impl IntoIterator<Item = String>) -> Self {
        Self {
            first: first.0,
            taken: taken.into_iter().collect(),
            numbers: BTreeMap::new(),
            made: Vec::new(),
            known: HashMap::new(),
            delays: HashMap::new(),
        }
    }

    /// Renames the monitor that `value` reads.
    pub fn call(&mut self, value: &Expr, name: &str) {
        if let Expr::Var(id, Time::Now) = value
            && let Some(place) = id.0.checked_sub(self.first)
            && let Some(monitor) = self.made.get_mut(place as usize)
        {
            name.clone_into(&mut monitor.variable.name);
        }
    }

    /// Returns all monitors in the order of their ids, which begin with the first free one.
    pub fn made(&self) -> &[Monitor] {
        &self.made
    }

    /// Returns the monitor of a variable.
    pub fn get(&self, id: VarId) -> Option<&Monitor> {
        let place = id.0.checked_sub(self.first)?;
        self.made.get(place as usize)
    }

    /// Returns whether one of the variables is a monitor.
    pub fn occur_in(&self, expr: &Expr) -> bool {
        let mut found = false;
        expr.for_each_var(&mut |v, _| found |= self.get(v).is_some());
        found
    }

    /// Returns the variables that a specification has to append, in order.
    pub fn variables(&self) -> impl Iterator<Item = &Variable> {
        self.made.iter().map(|m| &m.variable)
    }

    /// Adds the guarantees that define the monitors.
    pub fn define(&self, guarantees: &mut Side) {
        guarantees
            .initial
            .extend(self.made.iter().map(Monitor::start));
        guarantees
            .safety
            .extend(self.made.iter().map(Monitor::step));
    }

    /// Appends the monitors to a specification: variables and guarantees. The specification's
    /// variables must end where the monitors' ids begin.
    pub fn add_to(&self, specification: &mut Specification) {
        debug_assert_eq!(specification.variables.len(), self.first as usize);
        specification.variables.extend(self.variables().cloned());
        self.define(&mut specification.guarantees);
    }

    /// Returns the formulas that hold exactly if the pattern holds in the scope. Each file of this
    /// folder named after a pattern gives its formula in temporal logic.
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

    /// Creates the boolean monitor that starts as `initially` and whose update is `now` applied to
    /// its own value.
    fn remember(
        &mut self,
        stem: &'static str,
        initially: bool,
        now: impl Fn(Expr) -> Expr,
        origin: &Origin,
    ) -> Remembered {
        let (initial, definition) = (i64::from(initially), now(Expr::now(ITSELF)).simplify());
        let before = self.make(stem, Domain::Bool, initial, &definition, origin);
        let now = put(&definition, &before);
        Remembered { before, now }
    }

    /// Returns the value in this step of the formula tracked by [`remember`](Self::remember). No
    /// monitor is created if the past does not matter.
    fn follow(
        &mut self,
        stem: &'static str,
        initially: bool,
        now: impl Fn(Expr) -> Expr,
        origin: &Origin,
    ) -> Expr {
        let definition = now(Expr::now(ITSELF)).simplify();
        let mut past = false;
        definition.for_each_var(&mut |v, _| past |= v == ITSELF);
        if past {
            self.remember(stem, initially, now, origin).now
        } else {
            definition
        }
    }

    /// Returns the variable with this domain, initial value and update, in which [`ITSELF`] is the
    /// variable. Creates one if there is none, unless its value never changes.
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
            "a monitor of next values: {definition:?}"
        );
        debug_assert!(domain.contains(initial));
        let constant = Expr::Const(initial);
        if put(definition, &constant) == constant {
            return constant;
        }
        let key = (domain, initial, definition.clone());
        if let Some(id) = self.known.get(&key) {
            return Expr::now(*id);
        }
        let id = VarId(self.first + self.made.len() as u32);
        let update = put(definition, &Expr::now(id));
        let domain = key.0.clone();
        self.known.insert(key, id);
        if domain == Domain::Bool && initial == 0 {
            self.delays.entry(update.clone()).or_insert(id);
        }
        let name = self.name(stem);
        self.made.push(Monitor {
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

    /// Returns a free name: `stem_1`, `stem_2`, ... without those taken.
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

/// Replaces [`ITSELF`] in a definition by a monitor's value.
fn put(definition: &Expr, value: &Expr) -> Expr {
    let replaced = definition.substitute(&mut |v, time| {
        if v == ITSELF {
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
