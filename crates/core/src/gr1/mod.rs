//! GR(1) specifications: the common interface between input languages and solvers.
//!
//! A [`Specification`] is flat: scalar variables with finite domains, and formulas over their
//! current and next values. Arrays, parameters, quantifiers and defines have been expanded; every
//! formula keeps its name, its span and its text.
//!
//! # Meaning
//!
//! Time is a sequence of steps. In step *t* the environment chooses the inputs x(t) and the machine
//! answers with the outputs y(t) (internal variables count as outputs). With `Mealy` timing, y(t)
//! can depend on x(t); with `Moore` timing, it cannot.
//!
//! - `initial` formulas hold in step 0 (no next values);
//! - `invariants` hold in every step, step 0 included (no next values);
//! - `safety` formulas hold for every two consecutive steps (current and next values);
//! - `justice` formulas hold infinitely often (current values, and next values where a format
//!   allows it).
//!
//! The semantics is strict (Bloem et al., Synthesis of Reactive(1) Designs, 2012): the machine must
//! keep its initial conditions, invariants and safety for as long as the environment has kept its
//! own, and its justice whenever the environment's justice holds. It must have an answer to every
//! initial choice that the environment is allowed to make.

pub mod diagram;
pub mod eval;
mod expr;
pub mod interval;
pub mod monitors;
pub mod overflow;
pub mod text;

pub use expr::{BinaryOp, Expr, Time, UnaryOp};

use crate::source::Span;
use serde::{Deserialize, Serialize};

/// The index of a variable in [`Specification::variables`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct VarId(pub u32);

impl VarId {
    /// Returns the index into slices of values.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The finite set of values of a variable. Every value is an `i64`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Domain {
    /// `false` is 0, `true` is 1.
    Bool,
    /// The integers `low..=high`.
    Range {
        /// Smallest value.
        low: i64,
        /// Largest value.
        high: i64,
    },
    /// Labels, numbered from 0.
    Enum {
        /// Declared name of the type; `None` if the labels are written in place.
        name: Option<String>,
        /// Labels in order.
        labels: Vec<String>,
    },
}

impl Domain {
    /// Returns the smallest value.
    pub fn low(&self) -> i64 {
        match self {
            Self::Range { low, .. } => *low,
            _ => 0,
        }
    }

    /// Returns the largest value.
    pub fn high(&self) -> i64 {
        match self {
            Self::Bool => 1,
            Self::Range { high, .. } => *high,
            Self::Enum { labels, .. } => labels.len() as i64 - 1,
        }
    }

    /// Returns the number of values; at least 1.
    pub fn size(&self) -> u64 {
        (self.high() - self.low() + 1) as u64
    }

    /// Returns whether `value` is in the domain.
    pub fn contains(&self, value: i64) -> bool {
        (self.low()..=self.high()).contains(&value)
    }

    /// Returns whether a real number is one of the values.
    pub fn contains_real(&self, value: f64) -> bool {
        #[expect(clippy::float_cmp, reason = "a whole number equals its floor exactly")]
        let whole = value == value.floor();
        whole && self.low() as f64 <= value && value <= self.high() as f64
    }

    /// Formats a value for the user: `true`, `17` or `turn`.
    pub fn show(&self, value: i64) -> String {
        match self {
            Self::Bool => (value != 0).to_string(),
            Self::Range { .. } => value.to_string(),
            Self::Enum { labels, .. } => labels
                .get(value as usize)
                .cloned()
                .unwrap_or_else(|| value.to_string()),
        }
    }

    /// Formats the domain for the user: `bool`, `0..4` or `{none, turn}`.
    pub fn describe(&self) -> String {
        match self {
            Self::Bool => "bool".to_owned(),
            Self::Range { low, high } => format!("{low}..{high}"),
            Self::Enum { labels, .. } => format!("{{{}}}", labels.join(", ")),
        }
    }
}

/// Side that chooses a variable's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Owner {
    /// An input.
    Environment,
    /// An output or internal variable.
    System,
}

/// A scalar variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Name; an array's element is called `h[2]`.
    pub name: String,
    /// Side that chooses the variable's value.
    pub owner: Owner,
    /// Whether the variable is internal to the machine: treated like an output, but not part of the
    /// interface.
    pub internal: bool,
    /// Set of the variable's values.
    pub domain: Domain,
    /// Unit of the values, such as `mm`; empty for bare numbers. For display only: the numbers in
    /// formulas are already converted to this unit.
    pub unit: String,
    /// Place of the declaration.
    pub span: Span,
}

impl Variable {
    /// Formats a value with its unit: `90 deg`.
    pub fn show(&self, value: i64) -> String {
        show_value(&self.domain, value, &self.unit)
    }

    /// Formats the domain with its unit: `0..359 deg`.
    pub fn describe(&self) -> String {
        describe_domain(&self.domain, &self.unit)
    }
}

/// Formats a domain with its unit.
pub fn describe_domain(domain: &Domain, unit: &str) -> String {
    let domain = domain.describe();
    if unit.is_empty() {
        domain
    } else {
        format!("{domain} {unit}")
    }
}

/// Formats a value with its unit.
pub fn show_value(domain: &Domain, value: i64, unit: &str) -> String {
    let value = domain.show(value);
    if unit.is_empty() {
        value
    } else {
        format!("{value} {unit}")
    }
}

/// Order of the two sides within a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Timing {
    /// The machine chooses its outputs after it has seen the inputs of the step.
    Mealy,
    /// The machine chooses its outputs before it sees the inputs of the step.
    Moore,
}

/// A formula and its source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Formula {
    /// Name given by the author, or generated from its position: `guarantee 3`.
    pub name: String,
    /// Requirement that the formula comes from, such as `R-12`.
    pub requirement: Option<String>,
    /// Formula without its outer temporal operator. The list in [`Side`] that contains the formula
    /// stands for that operator. The value of the formula is 0 or 1.
    pub expr: Expr,
    /// Place in the source.
    pub span: Span,
    /// Source text, in one line.
    pub text: String,
    /// Whether the formula defines the value of a monitor and nothing else, so that it does not
    /// restrict the machine's choices: see [`monitors`].
    pub defines: bool,
}

/// Formulas of one side, by kind. The module documentation gives the meaning of each kind.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Side {
    /// Formulas that hold in step 0.
    pub initial: Vec<Formula>,
    /// Formulas that hold in every step.
    pub invariants: Vec<Formula>,
    /// Formulas that hold from every step to the next.
    pub safety: Vec<Formula>,
    /// Formulas that hold infinitely often.
    pub justice: Vec<Formula>,
}

/// When a formula has to hold. Selects one of the lists of a [`Side`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum FormulaKind {
    /// In step 0.
    Initial,
    /// In every step.
    Invariant,
    /// From every step to the next.
    Safety,
    /// Infinitely often.
    Justice,
}

impl FormulaKind {
    /// All kinds, in the order of the lists of a [`Side`].
    pub const ALL: [Self; 4] = [Self::Initial, Self::Invariant, Self::Safety, Self::Justice];
}

impl Side {
    /// Returns the formulas of one kind.
    pub fn list(&self, kind: FormulaKind) -> &[Formula] {
        match kind {
            FormulaKind::Initial => &self.initial,
            FormulaKind::Invariant => &self.invariants,
            FormulaKind::Safety => &self.safety,
            FormulaKind::Justice => &self.justice,
        }
    }

    /// Returns the formulas of one kind, mutable.
    pub fn list_mut(&mut self, kind: FormulaKind) -> &mut Vec<Formula> {
        match kind {
            FormulaKind::Initial => &mut self.initial,
            FormulaKind::Invariant => &mut self.invariants,
            FormulaKind::Safety => &mut self.safety,
            FormulaKind::Justice => &mut self.justice,
        }
    }

    /// Adds the formulas of another side to the lists of this one.
    pub fn append(&mut self, more: &Self) {
        for kind in FormulaKind::ALL {
            self.list_mut(kind).extend_from_slice(more.list(kind));
        }
    }

    /// Returns all formulas with their kinds and their indices in the list of that kind.
    pub fn formulas(&self) -> impl Iterator<Item = (FormulaKind, usize, &Formula)> {
        FormulaKind::ALL.into_iter().flat_map(|kind| {
            let list = self.list(kind).iter().enumerate();
            list.map(move |(index, formula)| (kind, index, formula))
        })
    }

    /// Returns all formulas: initial, invariants, safety, justice.
    pub fn all(&self) -> impl Iterator<Item = &Formula> {
        self.initial
            .iter()
            .chain(&self.invariants)
            .chain(&self.safety)
            .chain(&self.justice)
    }
}

/// A GR(1) specification. An empty justice list means the single goal `true`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Specification {
    /// Name of the contract.
    pub name: String,
    /// Order of the two sides within a step.
    pub timing: Timing,
    /// All variables in declaration order; inputs and outputs can be mixed.
    pub variables: Vec<Variable>,
    /// Assumptions about the environment. Initial conditions and invariants mention inputs only;
    /// safety formulas mention current values of all variables, but next values of inputs only.
    pub assumptions: Side,
    /// Guarantees of the machine.
    pub guarantees: Side,
}

impl Specification {
    /// Returns the ids of the inputs, in order.
    pub fn inputs(&self) -> impl Iterator<Item = VarId> {
        self.owned_by(Owner::Environment)
    }

    /// Returns the ids of the outputs and internal variables, in order.
    pub fn outputs(&self) -> impl Iterator<Item = VarId> {
        self.owned_by(Owner::System)
    }

    /// Returns the variable with an id.
    pub fn variable(&self, id: VarId) -> &Variable {
        &self.variables[id.index()]
    }

    /// Returns whether a variable was generated for a monitor: an internal variable whose span lies
    /// within a formula instead of a declaration.
    pub fn is_auxiliary(&self, id: VarId) -> bool {
        let variable = self.variable(id);
        let mut formulas = self.assumptions.all().chain(self.guarantees.all());
        variable.internal && formulas.any(|f| f.span.contains(variable.span))
    }

    fn owned_by(&self, owner: Owner) -> impl Iterator<Item = VarId> {
        self.variables
            .iter()
            .enumerate()
            .filter(move |(_, v)| v.owner == owner)
            .map(|(i, _)| VarId(i as u32))
    }
}
