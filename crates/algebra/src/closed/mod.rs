//! The closed composition of a machine: its components are the controllers that were synthesized
//! for them.
//!
//! [`crate::proof`] shows what is true of all controllers that keep the contracts. Here there is
//! one controller a component, and what comes from outside is free as far as the [`Claim`] leaves
//! it free. So an answer is exact: what holds is true of the machine that is built, and what does
//! not comes with a run that the controllers themselves make ([`replay`]).
//!
//! - A table (`table.rs`) becomes rules over the component's wires and one variable more, which
//!   says together with the outputs of a step which state the table is in *after* it. Before step 0
//!   it is in none; that is what initial rules speak of.
//! - A controller that is functions, too large for a table, goes in as its contract: it keeps the
//!   guarantees as long as its assumptions are kept, for it was certified against them. What is
//!   found so may be due to what the contract leaves open, and counts only if the functions
//!   themselves make that run.
//! - Who answers when is what a step of a machine is: components that answer first give their
//!   outputs, the others follow in the order of their declaration, and then those that answered
//!   first look at their inputs. So of all that can go wrong in one step there is a first, and only
//!   that is told.
//! - What an assumption says of the first step of a call is the caller's to keep ([`Exports`]).

mod decide;
pub mod replay;
mod rules;
mod silent;
mod table;
mod watch;

pub use table::States;
pub use watch::Watch;

use super::caller::Called;
use super::machine::{of_machine, of_promise};
use super::proof::{Claim, Exports, Open, latest};
use super::system::{FormulaRef, Half, Part, System, formulas};
use linewright_core::gr1::{Domain, Expr, Formula, Owner, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, Promised};
use linewright_solver::game::{Lasso, Limit, Limits, RuleKind};
use linewright_solver::mealy::Controller;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;

/// How a component takes part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// As the table of its controller.
    Table,
    /// As its contract: its controller is functions.
    Contract,
}

/// A component that takes part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Participant {
    /// In which form.
    pub form: Form,
    /// Of a table: the variable that says, with its outputs, which state it is in.
    pub state: Option<VarId>,
    /// Of a table: its states.
    pub states: Option<States>,
    /// The first of its wires.
    pub first: usize,
}

/// A machine whose components are their controllers, and what is claimed of it.
#[derive(Debug)]
pub struct Closed<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller a component.
    pub controllers: Vec<&'a Controller>,
    /// The wires and the contracts, as in a proof from contracts alone, with a state for every
    /// table and what watches operations.
    pub system: System,
    /// What is claimed.
    pub claim: Claim,
    /// How each component takes part.
    pub taking: Vec<Participant>,
    /// What watches that operations run what they name, where there are some and nothing else is
    /// claimed.
    pub watch: Option<Watch>,
    /// A truth value that stays true once a rule under examination was broken, where only runs
    /// without an end matter.
    slipped: Option<VarId>,
}

/// How an obligation is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Met {
    /// In every state that can be reached.
    Held,
    /// In every state but those at the beginning of a call, where the caller keeps it.
    Exported,
}

/// A component that has no answer although its assumptions are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stuck {
    /// The component.
    pub component: usize,
    /// Whether it answers first and has no outputs where it is. A table that was verified has a row
    /// for all inputs that keep the assumptions, so no inputs keep them there
    /// ([`Closed::contradiction`]).
    pub silent: bool,
    /// The run; in its last step there is no answer. Of a silent component, what wires are in that
    /// step means nothing.
    pub trace: Vec<Vec<i64>>,
}

/// An operation that does not do what it says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OperationFailure {
    /// The operation.
    pub operation: usize,
    /// What is wrong with it.
    pub why: FailureKind,
}

/// What is wrong with an operation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FailureKind {
    /// No call can begin with it: these assumptions keep it from that, each of them alone where
    /// there are several and one would do.
    NeverBegins(Vec<FormulaRef>),
    /// In the last step of this run an action begins that is not the next one, or the operation is
    /// done too early.
    Order(Vec<Vec<i64>>),
    /// On this run it is never done.
    Endless(Lasso),
}

/// All that came out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Verdict {
    /// Assumptions of components and formulas of the goal that are met.
    pub met: Vec<(FormulaRef, Met)>,
    /// Those that are not; on each run everything else is kept up to its last step.
    pub open: Vec<Open>,
    /// Those that were not decided, since a component went in as its contract.
    pub undecided: Vec<FormulaRef>,
    /// Components without an answer.
    pub stuck: Vec<Stuck>,
    /// Operations that do not do what they say.
    pub misruns: Vec<OperationFailure>,
    /// Operations of which that was not decided.
    pub unclear: Vec<usize>,
    /// How many states can be reached: values of all wires, with what they leave open of the
    /// tables' states and what is remembered.
    pub states: f64,
}

impl Verdict {
    /// Whether nothing is wrong, and nothing undecided.
    pub fn holds(&self) -> bool {
        !self.is_broken() && self.undecided.is_empty() && self.unclear.is_empty()
    }

    /// Whether something is wrong.
    pub fn is_broken(&self) -> bool {
        !self.open.is_empty() || !self.stuck.is_empty() || !self.misruns.is_empty()
    }

    /// How an obligation is met, if it is.
    pub fn is_met(&self, what: FormulaRef) -> Option<Met> {
        self.met.iter().find(|(at, _)| *at == what).map(|(_, m)| *m)
    }

    /// The run on which an obligation is not met.
    pub fn is_open(&self, what: FormulaRef) -> Option<&Open> {
        self.open.iter().find(|o| o.what == what)
    }
}

impl<'a> Closed<'a> {
    /// A machine as its file has it: with the plant that it describes, called again and again.
    ///
    /// # Panics
    /// When there is not one controller a component.
    pub fn of_machine(machine: &'a Machine, controllers: &[&'a Controller]) -> Self {
        let (mut system, claim) = of_machine(machine);
        let watch = Watch::new(machine, &mut system);
        Self::new(machine, controllers, system, claim, watch)
    }

    /// A machine in the place of a contract that it is said to refine: under what that assumes, and
    /// nothing else.
    ///
    /// # Panics
    /// When there is not one controller a component.
    pub fn of_promise(
        machine: &'a Machine,
        controllers: &[&'a Controller],
        promised: &Promised,
    ) -> Self {
        let (system, claim) = of_promise(machine, promised);
        Self::new(machine, controllers, system, claim, None)
    }

    /// A machine that is called as a line calls it.
    ///
    /// # Panics
    /// When there is not one controller a component.
    pub fn of_called(
        machine: &'a Machine,
        controllers: &[&'a Controller],
        called: &Called,
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

    /// Decides everything that is claimed.
    ///
    /// # Errors
    /// When a limit was reached, or the composition has too many bits to be looked at.
    pub fn decide(&self, limits: &Limits) -> Result<Verdict, Limit> {
        decide::decide(self, limits)
    }

    /// The components in the order in which their inputs are looked at within a step.
    pub fn order(&self) -> Vec<usize> {
        let timed = |timing: Timing| {
            let all = 0..self.machine.components.len();
            all.filter(move |i| self.machine.components[*i].specification.timing == timing)
        };
        timed(Timing::Mealy).chain(timed(Timing::Moore)).collect()
    }

    /// The component of an index, as a part of the system.
    fn part(&self, component: usize) -> &Part {
        &self.system.parts[component]
    }

    /// The assumptions of a component.
    fn assumed(&self, component: usize) -> impl Iterator<Item = (FormulaRef, &Formula)> {
        formulas(&self.part(component).assumptions).map(move |(kind, index, formula)| {
            let part = Some(component);
            let half = Half::Assumptions;
            let at = FormulaRef {
                part,
                half,
                kind,
                index,
            };
            (at, formula)
        })
    }

    /// Whether an assumption is handed on to whoever is outside: always, or where a call begins.
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

    /// When a call ends, if that is where the next one's first step is the caller's.
    fn done(&self) -> Option<&Expr> {
        match &self.claim.exports {
            Exports::After(done) => Some(done),
            Exports::Never | Exports::Always => None,
        }
    }
}

/// The variable that says, with a table's outputs, which state it is in.
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

/// One more variable that nobody outside sees.
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
