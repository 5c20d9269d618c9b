//! Emits a controller as a function block of IEC 61131-3 Structured Text, as text or as PLCopen
//! XML.
//!
//! A [`Block`] is plain data, the same for both output formats. It uses only features of the
//! standard's second edition that all major systems accept: no methods, no pointers, no typed
//! access to enumerations, `(* *)` comments, explicit conversions. Labels of enumerations have a
//! prefix (`Command_turn`), so that they need no qualifier, whose syntax differs between systems.
//!
//! A machine becomes a CASE over its states (`machine.rs`), or tables if the CASE would be long
//! (`tables.rs`); functions become a table of decisions that a loop evaluates (`functions.rs`). The
//! common interface and the frame of a call are in `interface.rs`.

mod assumptions;
mod codes;
mod expression;
mod functions;
mod interface;
mod machine;
pub(super) mod names;
mod plcopen;
pub(super) mod tables;
mod text;

use crate::emit::controller::Origin;
use interface::Interface;
use linewright_core::gr1::Specification;
use linewright_solver::mealy;

/// A function block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Name of the contract.
    pub contract: String,
    /// Name of the block: `FB_Turn`.
    pub name: String,
    /// Description and usage, one paragraph per line.
    pub description: Vec<String>,
    /// Enumerations that the block uses; the block's error type comes last.
    pub types: Vec<Enumeration>,
    /// Variables by kind; in each kind, the block's own variables come before the contract's.
    pub sections: Vec<(Section, Vec<Variable>)>,
    /// Statements of the body.
    pub body: String,
}

/// The type of an enumeration; its labels have the values 0, 1, ...
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type: `E_Command`.
    pub name: String,
    /// Description for a comment.
    pub description: String,
    /// The labels as declared, `Command_turn`, each with a comment, which can be empty.
    pub labels: Vec<(String, String)>,
}

/// Kinds of variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    /// `VAR_INPUT`
    Input,
    /// `VAR_OUTPUT`
    Output,
    /// `VAR`: keeps its value between calls.
    Local,
    /// `VAR CONSTANT`
    Constant,
    /// `VAR_TEMP`: written before it is read in every call.
    Temporary,
}

/// A variable of a block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Name of the variable.
    pub name: String,
    /// Type of the variable.
    pub kind: Type,
    /// Value before the first call, if it differs from the type's default.
    pub initial: Initial,
    /// Description; can be empty.
    pub description: String,
}

/// Value of a variable before the first call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Initial {
    /// The default of the type: `FALSE`, 0, or the first label.
    Default,
    /// A single value.
    Value(String),
    /// The values of an array, in order.
    Values(Vec<String>),
}

/// Types of variables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// `BOOL`
    Bool,
    /// Integer of 16, 32 or 64 bits.
    Integer(Width),
    /// An enumeration, by its name.
    Enumeration(String),
    /// `STRING` with this maximum number of characters.
    Text(usize),
    /// An array with these first and last indices.
    Array(i64, i64, Box<Type>),
}

/// Width of an integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// `INT`
    Int,
    /// `DINT`
    Dint,
    /// `LINT`
    Lint,
}

impl Width {
    /// The narrowest width that holds all values from `low` to `high`.
    pub(super) fn of(low: i64, high: i64) -> Self {
        if i16::try_from(low).is_ok() && i16::try_from(high).is_ok() {
            Self::Int
        } else if i32::try_from(low).is_ok() && i32::try_from(high).is_ok() {
            Self::Dint
        } else {
            Self::Lint
        }
    }

    /// Keyword of the type.
    fn keyword(self) -> &'static str {
        match self {
            Self::Int => "INT",
            Self::Dint => "DINT",
            Self::Lint => "LINT",
        }
    }

    /// Converts an expression of this width to another width. All conversions are explicit, because
    /// the second edition has no implicit ones, and systems differ in their warnings.
    pub(super) fn convert(self, to: Self, text: &str) -> String {
        if self == to {
            text.to_owned()
        } else {
            format!("{}_TO_{}({text})", self.keyword(), to.keyword())
        }
    }
}

/// Formats an integer literal; it has a type prefix if it does not fit a `DINT`.
fn literal(value: i64) -> String {
    if i32::try_from(value).is_ok() {
        value.to_string()
    } else {
        format!("LINT#{value}")
    }
}

/// Creates the function block of a controller of this specification.
pub fn block(controller: &mealy::Controller, specification: &Specification) -> Block {
    block_from(
        controller,
        specification,
        &Origin::contract(controller.name()),
    )
}

/// Like [`block`], for a controller of any origin.
pub fn block_from(
    controller: &mealy::Controller,
    specification: &Specification,
    origin: &Origin,
) -> Block {
    let mut interface = Interface::new(controller, specification, origin);
    match controller {
        mealy::Controller::Machine(machine) => {
            let parts = if machine::is_short(machine) {
                machine::parts(&mut interface, machine, specification)
            } else {
                tables::parts(&mut interface, machine, specification)
            };
            interface.finish(parts)
        }
        mealy::Controller::Functions(functions) => {
            let parts = functions::parts(&mut interface, functions);
            interface.finish(parts)
        }
    }
}

/// Like `block`, but always with tables, even for a short machine; for tests.
#[doc(hidden)]
pub fn block_with_tables(machine: &mealy::Machine, specification: &Specification) -> Block {
    let controller = mealy::Controller::Machine(machine.clone());
    let origin = Origin::contract(&machine.name);
    let mut interface = Interface::new(&controller, specification, &origin);
    let parts = tables::parts(&mut interface, machine, specification);
    interface.finish(parts)
}

/// The parts of a block that depend on the form of the controller.
struct Parts {
    /// Variables that keep their values between calls.
    locals: Vec<Variable>,
    /// Tables.
    constants: Vec<Variable>,
    /// Temporary variables.
    temporaries: Vec<Variable>,
    /// Statements that return to the state before step 0.
    reset: String,
    /// Statements of a step, for inputs within their domains: they either set `refused`, or change
    /// the state and the outputs.
    step: String,
}

impl Variable {
    /// Creates a variable with the type's default before the first call.
    pub fn new(name: &str, kind: Type, description: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            initial: Initial::Default,
            description: description.to_owned(),
        }
    }

    /// Sets the value before the first call.
    #[must_use]
    pub fn with_initial_value(self, value: &str) -> Self {
        Self {
            initial: Initial::Value(value.to_owned()),
            ..self
        }
    }
}
