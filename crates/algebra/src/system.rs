//! Contracts side by side, over one set of variables.

use linewright_core::gr1::{Expr, Formula, Side, Specification, Time, Timing, VarId, Variable};
use linewright_solver::game::{Rule, RuleKind};

/// Contracts over one set of variables. Variables of the same name are one variable: this is how
/// contracts are wired.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct System {
    /// All variables.
    pub variables: Vec<Variable>,
    /// Contracts of the system.
    pub parts: Vec<Part>,
}

/// One contract of a [`System`]. Its formulas are over the system's variables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Name of the contract or component.
    pub name: String,
    /// Whether it sees the inputs of the step that it answers.
    pub timing: Timing,
    /// Variables that it sets.
    pub drives: Vec<VarId>,
    /// Formulas that it assumes.
    pub assumptions: Side,
    /// Formulas that it guarantees.
    pub guarantees: Side,
    /// Definitions of its monitors: they cannot be broken and promise nothing.
    pub definitions: Side,
}

/// One half of a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ContractSide {
    /// Formulas that it assumes.
    Assumptions,
    /// Formulas that it guarantees.
    Guarantees,
}

/// Reference to one formula of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FormulaRef {
    /// Index of the part; `None` for the environment's side of a [`super::proof::Claim`], or its
    /// goal.
    pub part: Option<usize>,
    /// Half of the contract. For a claim, the givens are the assumptions and the goal is the
    /// guarantees.
    pub half: ContractSide,
    /// List that contains the formula.
    pub kind: RuleKind,
    /// Index in that list.
    pub index: usize,
}

/// Returns the formulas of one kind.
pub fn list(side: &Side, kind: RuleKind) -> &[Formula] {
    match kind {
        RuleKind::Initial => &side.initial,
        RuleKind::Invariant => &side.invariants,
        RuleKind::Safety => &side.safety,
        RuleKind::Justice => &side.justice,
    }
}

/// Returns the formulas of one kind, mutable.
pub fn list_mut(side: &mut Side, kind: RuleKind) -> &mut Vec<Formula> {
    match kind {
        RuleKind::Initial => &mut side.initial,
        RuleKind::Invariant => &mut side.invariants,
        RuleKind::Safety => &mut side.safety,
        RuleKind::Justice => &mut side.justice,
    }
}

/// All kinds, in the order of a side's lists.
pub const KINDS: [RuleKind; 4] = [
    RuleKind::Initial,
    RuleKind::Invariant,
    RuleKind::Safety,
    RuleKind::Justice,
];

/// Returns all formulas of a side with kind and index.
pub fn formulas(side: &Side) -> impl Iterator<Item = (RuleKind, usize, &Formula)> {
    KINDS.into_iter().flat_map(|kind| {
        list(side, kind)
            .iter()
            .enumerate()
            .map(move |(i, f)| (kind, i, f))
    })
}

/// Returns a formula as a rule of runs.
pub fn rule(kind: RuleKind, expr: &Expr) -> Rule {
    Rule {
        kind,
        expr: expr.clone(),
    }
}

impl Part {
    /// Returns one half of the part.
    pub fn half(&self, half: ContractSide) -> &Side {
        match half {
            ContractSide::Assumptions => &self.assumptions,
            ContractSide::Guarantees => &self.guarantees,
        }
    }

    /// Returns the part of a contract, over its own variables and numbering.
    pub fn of(specification: &Specification) -> Self {
        Self::mapped(specification, &specification.name, &mut |v, time| {
            Expr::Var(v, time)
        })
    }

    /// Returns the part of a contract whose variables are replaced by expressions over others. The
    /// variables it drives must be replaced by variables.
    pub fn mapped(
        specification: &Specification,
        name: &str,
        put: &mut impl FnMut(VarId, Time) -> Expr,
    ) -> Self {
        let drives = specification
            .outputs()
            .filter_map(|v| match put(v, Time::Now) {
                Expr::Var(v, _) => Some(v),
                _ => None,
            });
        let drives = drives.collect();
        let mut side = |side: &Side, keep: &dyn Fn(&Formula) -> bool| {
            let mut list = |formulas: &[Formula]| -> Vec<Formula> {
                let kept = formulas.iter().filter(|f| keep(f));
                kept.map(|f| Formula {
                    expr: f.expr.substitute(put),
                    ..f.clone()
                })
                .collect()
            };
            Side {
                initial: list(&side.initial),
                invariants: list(&side.invariants),
                safety: list(&side.safety),
                justice: list(&side.justice),
            }
        };
        Self {
            name: name.to_owned(),
            timing: specification.timing,
            drives,
            assumptions: side(&specification.assumptions, &|_| true),
            guarantees: side(&specification.guarantees, &|f| !f.defines),
            definitions: side(&specification.guarantees, &|f| f.defines),
        }
    }
}

impl System {
    /// Returns the referenced formula if it belongs to a part.
    pub fn formula(&self, at: FormulaRef) -> Option<&Formula> {
        let part = &self.parts[at.part?];
        list(part.half(at.half), at.kind).get(at.index)
    }

    /// Returns the part that sets a variable; `None` if it comes from outside.
    pub fn driver(&self, variable: VarId) -> Option<usize> {
        self.parts.iter().position(|p| p.drives.contains(&variable))
    }

    /// Returns an unused name for a variable.
    pub fn fresh_name(&self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        while self.variables.iter().any(|v| v.name == name) {
            name.push('_');
        }
        name
    }
}
