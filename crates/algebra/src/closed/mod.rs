//! The closed composition of a machine: its components are their synthesized controllers.
//!
//! [`crate::proof`] shows what is true for all controllers that keep the contracts. Here, each
//! component has one given controller, and outside inputs are restricted only by the [`Claim`]. So
//! the answer is exact: a positive result is true for the machine that is built, and a negative
//! result comes with a run that the controllers themselves make ([`replay`]).
//!
//! - A table (`table.rs`) becomes rules over the component's wires and one more variable. Together
//!   with the outputs of a step, the variable identifies the state of the table *after* that step.
//!   Before step 0 the table is in no state; the initial rules describe its first row.
//! - A controller made of functions, too large for a table, is replaced by its contract: it keeps
//!   the guarantees as long as its assumptions are kept, since it was verified against the
//!   contract. An error found this way can be due to freedom that the contract leaves, and counts
//!   only if the functions themselves make that run.
//! - Components answer in the same order as in a step of a machine: components that answer first
//!   give their outputs, the others follow in the order of their declaration, and finally those
//!   that answered first read their inputs. So the errors of a step are ordered, and only the first
//!   one is reported.
//! - The caller is responsible for assumptions about the first step of a call ([`Exports`]).

mod decide;
pub mod replay;
mod rules;
mod silent;
mod table;
mod watch;

pub use table::TableStates;
pub use watch::Watch;

use super::caller::CalledMachine;
use super::machine::{of_machine, of_refined_contract};
use super::proof::{Claim, DischargeRule, Exports, Open, Proof, latest};
use super::system::{Component, ContractSide, FormulaRef, System};
use linewright_core::gr1::{Domain, Expr, Formula, FormulaKind, Owner, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, RefinedContract};
use linewright_solver::game::{Lasso, Limit, Limits};
use linewright_solver::mealy::Controller;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Representation of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// The table of its controller.
    Table,
    /// Its contract, since its controller is made of functions.
    Contract,
}

/// A component in the composition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Participant {
    /// Representation of the component.
    pub form: Form,
    /// For a table: the variable that, together with the outputs, identifies its state.
    pub state: Option<VarId>,
    /// For a table: the encoding of its states.
    pub states: Option<TableStates>,
    /// Index of the component's first wire.
    pub first: usize,
}

/// Obligations that follow from a proof from the contracts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Known {
    /// Whether all safety assumptions of components are kept as long as all components answer, and
    /// with them the safety of the goal.
    pub safety: bool,
    /// Justice that holds on all runs without errors.
    pub justice: BTreeSet<FormulaRef>,
}

/// A machine whose components are represented by their controllers, and a claim about it.
#[derive(Debug)]
pub struct ClosedComposition<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller per component.
    pub controllers: Vec<&'a Controller>,
    /// Wires and contracts as in a proof from contracts, plus a state variable for every table and
    /// the variables of `watch`.
    pub system: System,
    /// Claim to decide.
    pub claim: Claim,
    /// Representation of each component.
    pub participants: Vec<Participant>,
    /// Variables that check that operations run the actions they name. Only for a machine with
    /// operations, built with [`ClosedComposition::of_machine`].
    pub watch: Option<Watch>,
    /// What follows from a proof; see [`ClosedComposition::knowing`].
    pub known: Known,
}

/// How an obligation of a closed composition is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum DischargeMethod {
    /// The obligation holds in every reachable state.
    Held,
    /// The obligation holds in every reachable state except in the first step of a call, where the
    /// caller is responsible for it.
    Exported,
}

/// A component that has no answer although its assumptions are kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StuckComponent {
    /// Index of the component.
    pub component: usize,
    /// Whether the component answers first and has no outputs in its state. A verified table has a
    /// row for all inputs that keep the assumptions, so no inputs keep the assumptions in that
    /// state ([`ClosedComposition::contradiction`]).
    pub silent: bool,
    /// Run in whose last step the component has no answer. For a silent component, the wires in
    /// that step have no meaning.
    pub trace: Vec<Vec<i64>>,
}

/// An operation that does not run as declared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperationFailure {
    /// Index of the operation.
    pub operation: usize,
    /// Kind of failure.
    pub why: FailureKind,
}

/// Failure of an operation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FailureKind {
    /// No call can begin with the operation because of these assumptions. Either the operation
    /// could begin without any one of them, or they are all the assumptions that mention the
    /// requested operation.
    NeverBegins(Vec<FormulaRef>),
    /// In the last step of this run an action begins out of order, or the operation is done too
    /// early or too late.
    Order(Vec<Vec<i64>>),
    /// On this run the operation is never done.
    Endless(Lasso),
}

/// Result of the decision.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// Obligations that are met: assumptions of components and formulas of the goal.
    pub met: Vec<(FormulaRef, DischargeMethod)>,
    /// Obligations that are not met, each with a run that has no other error before its last step.
    pub open: Vec<Open>,
    /// Obligations that were not decided because a component was represented by its contract.
    pub undecided: Vec<FormulaRef>,
    /// Components that have no answer in some reachable step.
    pub stuck: Vec<StuckComponent>,
    /// Operations that do not run as declared.
    pub operation_failures: Vec<OperationFailure>,
    /// Operations that were not decided because a component was represented by its contract.
    pub undecided_operations: Vec<usize>,
}

impl Verdict {
    /// Returns whether there are no errors and everything was decided.
    pub fn holds(&self) -> bool {
        !self.is_broken() && self.undecided.is_empty() && self.undecided_operations.is_empty()
    }

    /// Returns whether there is an error.
    pub fn is_broken(&self) -> bool {
        !self.open.is_empty() || !self.stuck.is_empty() || !self.operation_failures.is_empty()
    }

    /// Returns how an obligation is met; `None` if it is not.
    pub fn is_met(&self, what: FormulaRef) -> Option<DischargeMethod> {
        self.met.iter().find(|(at, _)| *at == what).map(|(_, m)| *m)
    }

    /// Returns the counterexample of an obligation; `None` if it has none.
    pub fn is_open(&self, what: FormulaRef) -> Option<&Open> {
        self.open.iter().find(|o| o.what == what)
    }
}

impl<'a> ClosedComposition<'a> {
    /// Composes a machine as declared in its file: with the plant that the file describes, and
    /// called repeatedly.
    ///
    /// # Panics
    /// When the number of controllers differs from the number of components.
    pub fn of_machine(machine: &'a Machine, controllers: &[&'a Controller]) -> Self {
        let (mut system, claim) = of_machine(machine);
        let watch = Watch::new(machine, &mut system);
        Self::new(machine, controllers, system, claim, watch)
    }

    /// Composes a machine under the assumptions of a contract only, to decide whether it refines
    /// the contract.
    ///
    /// # Panics
    /// When the number of controllers differs from the number of components.
    pub fn of_refined_contract(
        machine: &'a Machine,
        controllers: &[&'a Controller],
        refined: &RefinedContract,
    ) -> Self {
        let (system, claim) = of_refined_contract(machine, refined);
        Self::new(machine, controllers, system, claim, None)
    }

    /// Composes a machine that is called as a line calls it.
    ///
    /// # Panics
    /// When the number of controllers differs from the number of components.
    pub fn of_called(
        machine: &'a Machine,
        controllers: &[&'a Controller],
        called: &CalledMachine,
    ) -> Self {
        let (system, claim) = (called.system.clone(), called.claim.clone());
        Self::new(machine, controllers, system, claim, None)
    }

    fn new(
        machine: &'a Machine,
        controllers: &[&'a Controller],
        mut system: System,
        claim: Claim,
        watch: Option<Watch>,
    ) -> Self {
        assert_eq!(
            controllers.len(),
            machine.components.len(),
            "one controller per component"
        );
        let mut participants = Vec::new();
        for (index, controller) in controllers.iter().enumerate() {
            let table = controller.machine();
            let states = table.map(TableStates::new);
            let most = states.as_ref().map(TableStates::max_per_output);
            let state = most.map(|most| add_state_variable(machine, index, most, &mut system));
            participants.push(Participant {
                form: if table.is_some() {
                    Form::Table
                } else {
                    Form::Contract
                },
                state,
                states,
                first: machine.first_wire(index),
            });
        }
        Self {
            machine,
            controllers: controllers.to_vec(),
            system,
            claim,
            participants,
            watch,
            known: Known::default(),
        }
    }

    /// Takes over what was proved from the contracts, step by step, for the same system and claim:
    /// it is not decided again. What holds for all controllers that keep the contracts holds for
    /// these, which were verified against them.
    ///
    /// - Justice: the proof goes in turns, so the justice guarantees that it relies on are those of
    ///   components whose justice assumptions it has discharged before.
    /// - Safety, if the whole proof succeeded: a verified table has a row for all inputs that keep
    ///   the assumptions. Only whether a component that answers first has outputs is still open,
    ///   because contracts do not say what happens where no inputs keep the assumptions.
    #[must_use]
    pub fn knowing(mut self, proof: &Proof) -> Self {
        let shown = proof.discharges.iter();
        let shown = shown
            .filter(|d| d.what.kind == FormulaKind::Justice && d.rule != DischargeRule::Exported);
        self.known = Known {
            safety: proof.holds(),
            justice: shown.map(|d| d.what).collect(),
        };
        self
    }

    /// Decides all obligations.
    ///
    /// # Errors
    /// When a limit was reached, or the composition has too many bits.
    pub fn decide(&self, limits: &Limits) -> Result<Verdict, Limit> {
        decide::decide(self, limits)
    }

    /// Counts the reachable states without errors: values of all wires and internal variables. The
    /// number is exact below 2⁵³. Counting can take far longer than [`Self::decide`], which rarely
    /// needs to find all states.
    ///
    /// # Errors
    /// When a limit was reached, or the composition has too many bits.
    pub fn count_states(&self, limits: &Limits) -> Result<f64, Limit> {
        decide::count_states(self, limits)
    }

    /// Returns the components in the order in which their inputs are read within a step.
    pub fn order(&self) -> Vec<usize> {
        let timed = |timing: Timing| {
            let all = 0..self.machine.components.len();
            all.filter(move |i| self.machine.components[*i].specification.timing == timing)
        };
        timed(Timing::Mealy).chain(timed(Timing::Moore)).collect()
    }

    /// Returns a component of the system.
    fn component(&self, component: usize) -> &Component {
        &self.system.components[component]
    }

    /// Returns the assumptions of a component.
    fn assumed(&self, component: usize) -> impl Iterator<Item = (FormulaRef, &Formula)> {
        self.component(component)
            .assumptions
            .formulas()
            .map(move |(kind, index, formula)| {
                let component = Some(component);
                let half = ContractSide::Assumptions;
                let at = FormulaRef {
                    component,
                    half,
                    kind,
                    index,
                };
                (at, formula)
            })
    }

    /// Returns whether an assumption is exported to the environment, either in every step or in the
    /// first step of each call.
    pub fn is_exported(&self, kind: FormulaKind, formula: &Formula) -> bool {
        let may = match &self.claim.exports {
            Exports::Never => false,
            Exports::Always => true,
            Exports::After(_) => kind != FormulaKind::Justice,
        };
        let mut mentioned: BTreeSet<VarId> = latest(&formula.expr, kind);
        if kind == FormulaKind::Justice {
            formula.expr.for_each_var(&mut |v, _| {
                mentioned.insert(v);
            });
        }
        may && mentioned
            .into_iter()
            .any(|v| self.system.driver(v).is_none())
    }

    /// Returns the condition that ends a call, if the caller is responsible for the first step of
    /// the next call.
    fn done(&self) -> Option<&Expr> {
        match &self.claim.exports {
            Exports::After(done) => Some(done),
            Exports::Never | Exports::Always => None,
        }
    }
}

/// Adds the variable that, together with a table's outputs, identifies its state.
fn add_state_variable(
    machine: &Machine,
    component: usize,
    most: usize,
    system: &mut System,
) -> VarId {
    let name = system.fresh_name(&format!("{} (state)", machine.components[component].name));
    let domain = Domain::Range {
        low: 0,
        high: most as i64 - 1,
    };
    let id = add_internal_variable(system, name, domain, machine.components[component].span);
    system.components[component].drives.push(id);
    id
}

/// Adds an internal variable to the system.
fn add_internal_variable(system: &mut System, name: String, domain: Domain, span: Span) -> VarId {
    let id = VarId(system.variables.len() as u32);
    system.variables.push(Variable {
        name,
        owner: Owner::System,
        internal: true,
        domain,
        unit: String::new(),
        span,
    });
    id
}
