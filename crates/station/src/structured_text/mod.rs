//! Emits a controller as a function block of IEC 61131-3 Structured Text, as text or as PLCopen
//! XML.
//!
//! A [`Block`] is plain data, the same for both output formats. It uses only what the second
//! edition of the standard has and every larger system accepts: no methods, no pointers, no typed
//! access to enumerations, `(* *)` comments, explicit conversions. Enumerations are prefixed
//! (`Command_turn`), so that their labels need no qualifier, whose syntax differs between systems.
//!
//! A machine becomes a CASE over its states (`machine.rs`), or tables if that would be long
//! (`tables.rs`); functions become a table of decisions that a loop walks (`functions.rs`). The
//! common interface, and the beginning and end of a call, are in `interface.rs`.

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
    /// Enumerations that it needs, its own errors last.
    pub types: Vec<Enumeration>,
    /// Variables by kind; the controller's own ones first.
    pub sections: Vec<(Section, Vec<Variable>)>,
    /// Statements of the body.
    pub body: String,
}

/// The type of an enumeration; its labels have the values 0, 1, ...
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Enumeration {
    /// `E_Command`
    pub name: String,
    /// Description for a comment.
    pub description: String,
    /// The labels as declared, `Command_turn`, with their meanings.
    pub labels: Vec<(String, String)>,
}

/// Kinds of variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    /// `VAR_INPUT`
    Input,
    /// `VAR_OUTPUT`
    Output,
    /// `VAR`: kept from call to call.
    Local,
    /// `VAR CONSTANT`
    Constant,
    /// `VAR_TEMP`: not kept, and written before it is read.
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
    /// Description; may be empty.
    pub description: String,
}

/// Value of a variable before the first call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Initial {
    /// `FALSE`, 0, or the first label.
    Usual,
    /// This one.
    Value(String),
    /// Values of an array, in order.
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

    /// Converts an expression of this width to another. No conversion is left to the compiler: the
    /// second edition has none, and systems differ in their warnings.
    pub(super) fn convert(self, to: Self, text: &str) -> String {
        if self == to {
            text.to_owned()
        } else {
            format!("{}_TO_{}({text})", self.keyword(), to.keyword())
        }
    }
}

/// An integer. If it does not fit a `DINT`, it carries its type.
fn literal(value: i64) -> String {
    if i32::try_from(value).is_ok() {
        value.to_string()
    } else {
        format!("LINT#{value}")
    }
}

/// Creates the function block of a controller of this specification.
pub fn block(controller: &mealy::Controller, specification: &Specification) -> Block {
    let mut interface = Interface::new(controller, specification);
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
pub fn block_of_tables(machine: &mealy::Machine, specification: &Specification) -> Block {
    let controller = mealy::Controller::Machine(machine.clone());
    let mut interface = Interface::new(&controller, specification);
    let parts = tables::parts(&mut interface, machine, specification);
    interface.finish(parts)
}

/// What a form of controllers adds to the interface.
struct Parts {
    /// Kept from call to call.
    locals: Vec<Variable>,
    /// Tables.
    constants: Vec<Variable>,
    /// Variables that are not kept.
    temporaries: Vec<Variable>,
    /// Statements that return to before step 0.
    reset: String,
    /// Statements of a step: they set `refused`, or change the state and the outputs. Inputs are
    /// within their domains.
    step: String,
}

impl Variable {
    /// A variable with the type's default before the first call.
    pub fn new(name: &str, kind: Type, description: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            initial: Initial::Usual,
            description: description.to_owned(),
        }
    }

    /// Sets the value before the first call.
    #[must_use]
    pub fn beginning(self, value: &str) -> Self {
        Self {
            initial: Initial::Value(value.to_owned()),
            ..self
        }
    }
}
