//! The closed composition of a machine: its components are their synthesized controllers.
//!
//! [`crate::proof`] shows what is true of all controllers that keep the contracts. Here there is
//! one controller per component, and outside inputs are free as far as the [`Claim`] allows. So the
//! answer is exact: a result that holds is true of the machine that is built, and one that does not
//! comes with a run that the controllers themselves make ([`replay`]).
//!
//! - A table (`table.rs`) becomes rules over the component's wires and one more variable. Together
//!   with the outputs of a step, the variable identifies the state of the table *after* it. Before
//!   step 0 the table is in no state; the initial rules are about that.
//! - A controller made of functions, too large for a table, is replaced by its contract: it keeps
//!   the guarantees as long as its assumptions are kept, for it was certified against them. An
//!   error found this way may be due to freedom left by the contract, and counts only if the
//!   functions themselves make that run.
//! - The order of answers is that of a step of a machine: components that answer first give their
//!   outputs, the others follow in the order of their declaration, and then those that answered
//!   first read their inputs. So the possible errors of a step have a first one, and only that is
//!   reported.
//! - An assumption about the first step of a call is the caller's to keep ([`Exports`]).

mod decide;
pub mod replay;
mod rules;
mod silent;
mod table;
mod watch;

pub use table::States;
pub use watch::Watch;

use super::caller::CalledMachine;
use super::machine::{of_machine, of_promise};
use super::proof::{Claim, Exports, Open, latest};
use super::system::{ContractSide, FormulaRef, Part, System, formulas};
use linewright_core::gr1::{Domain, Expr, Formula, Owner, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, RefinedContract};
use linewright_solver::game::{Lasso, Limit, Limits, RuleKind};
use linewright_solver::mealy::Controller;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;

/// Representation of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Its controller's table.
    Table,
    /// Its contract: the controller is functions.
    Contract,
}

/// A component in the composition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Participant {
    /// Representation.
    pub form: Form,
    /// For a table: the variable that, with its outputs, identifies its state.
    pub state: Option<VarId>,
    /// For a table: its states.
    pub states: Option<States>,
    /// Index of its first wire.
    pub first: usize,
}

/// A machine whose components are their controllers, and the claim about it.
#[derive(Debug)]
pub struct Closed<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller per component.
    pub controllers: Vec<&'a Controller>,
    /// Wires and contracts, as in a proof from contracts alone, plus a state for every table and
    /// the variables that watch operations.
    pub system: System,
    /// Claim to decide.
    pub claim: Claim,
    /// Representation of each component.
    pub taking: Vec<Participant>,
    /// Variables that check that operations run the actions they name, if there are operations and
    /// nothing else is claimed.
    pub watch: Option<Watch>,
    /// Boolean that stays true once the rule under examination was broken; only used where just
    /// infinite runs count.
    slipped: Option<VarId>,
}

/// How an obligation is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DischargeMethod {
    /// In every reachable state.
    Held,
    /// In every reachable state except at the beginning of a call, where the caller keeps it.
    Exported,
}

/// A component that has no answer although its assumptions are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StuckComponent {
    /// Index of the component.
    pub component: usize,
    /// Whether it answers first and has no outputs in its state. A verified table has a row for all
    /// inputs that keep the assumptions, so no inputs keep them there ([`Closed::contradiction`]).
    pub silent: bool,
    /// Run whose last step has no answer. For a silent component, the wires in that step are
    /// meaningless.
    pub trace: Vec<Vec<i64>>,
}

/// An operation that does not run as declared.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OperationFailure {
    /// Index of the operation.
    pub operation: usize,
    /// Kind of failure.
    pub why: FailureKind,
}

/// Failure of an operation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FailureKind {
    /// No call can begin with it because of these assumptions. If there are several, each one alone
    /// would be enough.
    NeverBegins(Vec<FormulaRef>),
    /// In the last step of this run an action begins out of order, or the operation is done too
    /// early.
    Order(Vec<Vec<i64>>),
    /// On this run the operation is never done.
    Endless(Lasso),
}

/// Result of the decision.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Verdict {
    /// Assumptions of components and formulas of the goal that are met.
    pub met: Vec<(FormulaRef, DischargeMethod)>,
    /// Those that are not met; each run keeps everything else up to its last step.
    pub open: Vec<Open>,
    /// Those that were not decided because a component was used as its contract.
    pub undecided: Vec<FormulaRef>,
    /// Components without an answer.
    pub stuck: Vec<StuckComponent>,
    /// Operations that do not run as declared.
    pub misruns: Vec<OperationFailure>,
    /// Operations for which this was not decided.
    pub unclear: Vec<usize>,
    /// Number of reachable states: values of all wires, together with the undetermined part of the
    /// tables' states and the remembered values.
    pub states: f64,
}

impl Verdict {
    /// Returns whether there is no error and nothing undecided.
    pub fn holds(&self) -> bool {
        !self.is_broken() && self.undecided.is_empty() && self.unclear.is_empty()
    }

    /// Returns whether there is an error.
    pub fn is_broken(&self) -> bool {
        !self.open.is_empty() || !self.stuck.is_empty() || !self.misruns.is_empty()
    }

    /// Returns how an obligation is met, if it is.
    pub fn is_met(&self, what: FormulaRef) -> Option<DischargeMethod> {
        self.met.iter().find(|(at, _)| *at == what).map(|(_, m)| *m)
    }

    /// Returns the open obligation with its run, if it is not met.
    pub fn is_open(&self, what: FormulaRef) -> Option<&Open> {
        self.open.iter().find(|o| o.what == what)
    }
}

impl<'a> Closed<'a> {
    /// Builds a machine as declared in its file: with the plant described there, called repeatedly.
    ///
    /// # Panics
    /// When the number of controllers differs from the number of components.
    pub fn of_machine(machine: &'a Machine, controllers: &[&'a Controller]) -> Self {
        let (mut system, claim) = of_machine(machine);
        let watch = Watch::new(machine, &mut system);
        Self::new(machine, controllers, system, claim, watch)
    }

    /// Builds a machine in place of a contract that it is claimed to refine: under that contract's
    /// assumptions only.
    ///
    /// # Panics
    /// When the number of controllers differs from the number of components.
    pub fn of_promise(
        machine: &'a Machine,
        controllers: &[&'a Controller],
        promised: &RefinedContract,
    ) -> Self {
        let (system, claim) = of_promise(machine, promised);
        Self::new(machine, controllers, system, claim, None)
    }

    /// Builds a machine that is called as a line calls it.
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
            "one controller a component"
        );
        let mut taking = Vec::new();
        for (index, controller) in controllers.iter().enumerate() {
            let table = controller.machine();
            let states = table.map(States::new);
            let most = states.as_ref().map(States::most);
            let state = most.map(|most| state(machine, index, most, &mut system));
            taking.push(Participant {
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
        let slipped = (claim.exports == Exports::Never).then(|| {
            let name = system.fresh_name("slipped");
            let domain = Domain::Bool;
            remember(&mut system, name, domain, machine.span)
        });
        Self {
            machine,
            controllers: controllers.to_vec(),
            system,
            claim,
            taking,
            watch,
            slipped,
        }
    }

    /// Decides the whole claim.
    ///
    /// # Errors
    /// When a limit was reached, or the composition has too many bits.
    pub fn decide(&self, limits: &Limits) -> Result<Verdict, Limit> {
        decide::decide(self, limits)
    }

    /// Returns the components in the order in which their inputs are read within a step.
    pub fn order(&self) -> Vec<usize> {
        let timed = |timing: Timing| {
            let all = 0..self.machine.components.len();
            all.filter(move |i| self.machine.components[*i].specification.timing == timing)
        };
        timed(Timing::Mealy).chain(timed(Timing::Moore)).collect()
    }

    /// Returns a component as a part of the system.
    fn part(&self, component: usize) -> &Part {
        &self.system.parts[component]
    }

    /// Returns the assumptions of a component.
    fn assumed(&self, component: usize) -> impl Iterator<Item = (FormulaRef, &Formula)> {
        formulas(&self.part(component).assumptions).map(move |(kind, index, formula)| {
            let part = Some(component);
            let half = ContractSide::Assumptions;
            let at = FormulaRef {
                part,
                half,
                kind,
                index,
            };
            (at, formula)
        })
    }

    /// Returns whether an assumption is handed on to the environment: always, or at the beginning
    /// of a call.
    pub fn is_exported(&self, kind: RuleKind, formula: &Formula) -> bool {
        let may = match &self.claim.exports {
            Exports::Never => false,
            Exports::Always => true,
            Exports::After(_) => kind != RuleKind::Justice,
        };
        let mut spoken_of: BTreeSet<VarId> = latest(&formula.expr, kind);
        if kind == RuleKind::Justice {
            formula.expr.for_each_var(&mut |v, _| {
                spoken_of.insert(v);
            });
        }
        may && spoken_of
            .into_iter()
            .any(|v| self.system.driver(v).is_none())
    }

    /// Returns when a call ends, if the first step of the next call is the caller's responsibility.
    fn done(&self) -> Option<&Expr> {
        match &self.claim.exports {
            Exports::After(done) => Some(done),
            Exports::Never | Exports::Always => None,
        }
    }
}

/// Adds the variable that, with a table's outputs, identifies its state.
fn state(machine: &Machine, component: usize, most: usize, system: &mut System) -> VarId {
    let name = system.fresh_name(&format!("{} (state)", machine.components[component].name));
    let domain = Domain::Range {
        low: 0,
        high: most as i64 - 1,
    };
    let id = remember(system, name, domain, machine.components[component].span);
    system.parts[component].drives.push(id);
    id
}

/// Adds an internal variable.
fn remember(system: &mut System, name: String, domain: Domain, span: Span) -> VarId {
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
