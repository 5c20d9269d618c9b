//! Contracts side by side, over one set of variables.

use linewright_core::gr1::{Expr, Formula, Side, Specification, Time, Timing, VarId, Variable};
use linewright_solver::game::{Rule, RuleKind};

/// Contracts over one set of variables. What several contracts call by one name is one variable:
/// that is how they are wired.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct System {
    /// All variables.
    pub variables: Vec<Variable>,
    /// The contracts.
    pub parts: Vec<Part>,
}

/// One contract of a [`System`]. Its formulas are over the system's variables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// What it is called: the contract's name, or that of a component.
    pub name: String,
    /// Whether it sees the inputs of the step that it answers.
    pub timing: Timing,
    /// The variables that it sets.
    pub drives: Vec<VarId>,
    /// What it assumes.
    pub assumptions: Side,
    /// What it guarantees.
    pub guarantees: Side,
    /// What defines its monitors: never broken by anyone, and no promise to anyone.
    pub definitions: Side,
}

/// Which half of a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Half {
    /// What it assumes.
    Assumptions,
    /// What it guarantees.
    Guarantees,
}

/// Points at one formula of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FormulaRef {
    /// The part, by its place; `None` is the environment's side of a [`super::proof::Claim`], or
    /// its goal's.
    pub part: Option<usize>,
    /// Which half of it. Of a claim: what is given is assumed, what is to be shown is guaranteed.
    pub half: Half,
    /// The list it stands in.
    pub kind: RuleKind,
    /// Its place in that list.
    pub index: usize,
}

/// The formulas of one kind.
pub fn list(side: &Side, kind: RuleKind) -> &[Formula] {
    match kind {
        RuleKind::Initial => &side.initial,
        RuleKind::Invariant => &side.invariants,
        RuleKind::Safety => &side.safety,
        RuleKind::Justice => &side.justice,
    }
}

/// The formulas of one kind, to be changed.
pub fn list_mut(side: &mut Side, kind: RuleKind) -> &mut Vec<Formula> {
    match kind {
        RuleKind::Initial => &mut side.initial,
        RuleKind::Invariant => &mut side.invariants,
        RuleKind::Safety => &mut side.safety,
        RuleKind::Justice => &mut side.justice,
    }
}

/// The kinds, in the order in which a side lists them.
pub const KINDS: [RuleKind; 4] = [
    RuleKind::Initial,
    RuleKind::Invariant,
    RuleKind::Safety,
    RuleKind::Justice,
];

/// All formulas of a side, with where they stand.
pub fn formulas(side: &Side) -> impl Iterator<Item = (RuleKind, usize, &Formula)> {
    KINDS.into_iter().flat_map(|kind| {
        list(side, kind)
            .iter()
            .enumerate()
            .map(move |(i, f)| (kind, i, f))
    })
}

/// A formula as a rule of runs.
pub fn rule(kind: RuleKind, expr: &Expr) -> Rule {
    Rule {
        kind,
        expr: expr.clone(),
    }
}

impl Part {
    /// One half of it.
    pub fn half(&self, half: Half) -> &Side {
        match half {
            Half::Assumptions => &self.assumptions,
            Half::Guarantees => &self.guarantees,
        }
    }

    /// A contract by itself, over its own variables as they are numbered there.
    pub fn of(specification: &Specification) -> Self {
        Self::mapped(specification, &specification.name, &mut |v, time| {
            Expr::Var(v, time)
        })
    }

    /// A contract whose variables stand for expressions over other ones. What it drives has to
    /// become variables.
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
    /// The formula that is pointed at, where it belongs to a part.
    pub fn formula(&self, at: FormulaRef) -> Option<&Formula> {
        let part = &self.parts[at.part?];
        list(part.half(at.half), at.kind).get(at.index)
    }

    /// The part that sets a variable; `None` for one that comes from outside.
    pub fn driver(&self, variable: VarId) -> Option<usize> {
        self.parts.iter().position(|p| p.drives.contains(&variable))
    }

    /// A name for a variable that no other has.
    pub fn fresh_name(&self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        while self.variables.iter().any(|v| v.name == name) {
            name.push('_');
        }
        name
    }
}
