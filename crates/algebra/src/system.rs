//! Systems of contracts over one set of variables.

use super::machine::COMPLETES;
use linewright_core::gr1::{
    Expr, Formula, FormulaKind, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_solver::game::{Rule, declared_requests};
use serde::{Deserialize, Serialize};

/// Components over one set of variables. Components are wired by the names of their ports: ports
/// with the same name are one variable.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct System {
    /// All variables.
    pub variables: Vec<Variable>,
    /// Components with their contracts.
    pub components: Vec<Component>,
}

/// A component of a [`System`] with its contract. Formulas are over the system's variables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    /// Name of the contract or component.
    pub name: String,
    /// Whether the component sees the inputs of a step before it sets its outputs (Mealy) or not
    /// (Moore).
    pub timing: Timing,
    /// Variables that the component sets.
    pub drives: Vec<VarId>,
    /// Formulas that the component assumes.
    pub assumptions: Side,
    /// Formulas that the component guarantees.
    pub guarantees: Side,
    /// Definitions of the component's monitors: they cannot be broken, and constrain nothing else.
    pub definitions: Side,
    /// Justice that may follow from the rest of the contract: each request that the contract
    /// declares is completed. A proof that rests on one of these formulas derives it first.
    pub completions: Side,
}

/// The two halves of a contract, and what may follow from them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ContractSide {
    /// Formulas that the component assumes.
    Assumptions,
    /// Formulas that the component guarantees.
    Guarantees,
    /// Formulas that may follow from the others: see [`Component::completions`].
    Completions,
}

/// Reference to one formula of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FormulaRef {
    /// Index of the component; `None` for a given or a goal formula of a [`super::proof::Claim`].
    pub component: Option<usize>,
    /// Side of the contract. For a claim, assumptions are the givens and guarantees are the goal.
    pub half: ContractSide,
    /// Kind of the formula, which selects the list that contains it.
    pub kind: FormulaKind,
    /// Index in that list.
    pub index: usize,
}

/// Returns the rule for a formula of this kind.
pub fn rule(kind: FormulaKind, expr: &Expr) -> Rule {
    Rule {
        kind,
        expr: expr.clone(),
    }
}

impl Component {
    /// Returns one side of the component.
    pub fn half(&self, half: ContractSide) -> &Side {
        match half {
            ContractSide::Assumptions => &self.assumptions,
            ContractSide::Guarantees => &self.guarantees,
            ContractSide::Completions => &self.completions,
        }
    }

    /// Creates a component from a contract, with the variable ids of the contract.
    pub fn of(specification: &Specification) -> Self {
        Self::mapped(specification, &specification.name, &mut |v, time| {
            Expr::Var(v, time)
        })
    }

    /// Creates a component from a contract and replaces the contract's variables by expressions.
    /// `put` must return a variable for each output. Guarantees that define monitors become the
    /// component's definitions.
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
            completions: side(&completions(specification), &|_| true),
        }
    }
}

/// Returns the formulas of [`Component::completions`]. A contract with justice guarantees states
/// itself what recurs, and has none.
fn completions(specification: &Specification) -> Side {
    if !specification.guarantees.justice.is_empty() {
        return Side::default();
    }
    let requests = declared_requests(specification).into_iter();
    let justice = requests.map(|request| {
        let output = specification.variable(request.output);
        Formula {
            defines: false,
            name: COMPLETES.to_owned(),
            requirement: None,
            expr: request.request.not().or(request.done),
            span: output.span,
            text: format!("always eventually (not requested or {})", output.name),
        }
    });
    Side {
        justice: justice.collect(),
        ..Side::default()
    }
}

impl System {
    /// Returns the referenced formula; `None` if it does not belong to a component or does not
    /// exist.
    pub fn formula(&self, at: FormulaRef) -> Option<&Formula> {
        let component = &self.components[at.component?];
        component.half(at.half).list(at.kind).get(at.index)
    }

    /// Returns the index of the component that sets a variable; `None` if the variable is set from
    /// outside.
    pub fn driver(&self, variable: VarId) -> Option<usize> {
        self.components
            .iter()
            .position(|p| p.drives.contains(&variable))
    }

    /// Returns `wanted`, extended by underscores until no variable has this name.
    pub fn fresh_name(&self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        while self.variables.iter().any(|v| v.name == name) {
            name.push('_');
        }
        name
    }
}
