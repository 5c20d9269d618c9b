//! A controller for a programmable controller: a function block of IEC 61131-3 Structured Text, as
//! text or as PLCopen XML.
//!
//! A [`Block`] is plain data, the same for both written forms. Only what the second edition of the
//! standard has and every larger system takes is used: no methods, no pointers, no typed access to
//! enumerations, `(* *)` comments, explicit conversions. Enumerations are prefixed
//! (`Command_turn`), so that their labels need no qualifier, which systems write differently.
//!
//! A machine becomes a CASE over its states (`machine.rs`), or tables where that would be long
//! (`tables.rs`); functions become a table of decisions that a loop walks (`functions.rs`). What is
//! the same for all, the interface and how a call begins and ends, stands in `interface.rs`.

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
    /// The contract's name.
    pub contract: String,
    /// The block's own: `FB_Turn`.
    pub name: String,
    /// What it is and how it is used, one paragraph a line.
    pub description: Vec<String>,
    /// The enumerations it needs, its own errors last.
    pub types: Vec<Enumeration>,
    /// Its variables, by kind; the controller's own ones first.
    pub sections: Vec<(Section, Vec<Variable>)>,
    /// Its statements.
    pub body: String,
}

/// The type of an enumeration; its labels have the values 0, 1, ...
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Enumeration {
    /// `E_Command`
    pub name: String,
    /// What it is.
    pub description: String,
    /// The labels as declared, `Command_turn`, and what each means.
    pub labels: Vec<(String, String)>,
}

/// The kinds of variables.
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
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Type,
    /// Its value before the first call, where that is not the type's own.
    pub initial: Initial,
    /// What it is; may be empty.
    pub description: String,
}

/// The value of a variable before the first call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Initial {
    /// `FALSE`, 0, or the first label.
    Usual,
    /// This one.
    Value(String),
    /// Those of an array, in order.
    Values(Vec<String>),
}

/// The types that are used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// `BOOL`
    Bool,
    /// Whole numbers of 16, 32 or 64 bits.
    Integer(Width),
    /// An enumeration, by its name.
    Enumeration(String),
    /// `STRING` of at most so many characters
    Text(usize),
    /// An array with these first and last indices.
    Array(i64, i64, Box<Type>),
}

/// How wide a whole number is.
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
    /// The narrowest that holds all values between two.
    pub(super) fn of(low: i64, high: i64) -> Self {
        if i16::try_from(low).is_ok() && i16::try_from(high).is_ok() {
            Self::Int
        } else if i32::try_from(low).is_ok() && i32::try_from(high).is_ok() {
            Self::Dint
        } else {
            Self::Lint
        }
    }

    /// Its keyword.
    fn keyword(self) -> &'static str {
        match self {
            Self::Int => "INT",
            Self::Dint => "DINT",
            Self::Lint => "LINT",
        }
    }

    /// An expression of this width as one of another. No conversion is left to the compiler: the
    /// second edition has none, and systems differ in the warnings they give.
    pub(super) fn convert(self, to: Self, text: &str) -> String {
        if self == to {
            text.to_owned()
        } else {
            format!("{}_TO_{}({text})", self.keyword(), to.keyword())
        }
    }
}

/// A whole number. One that a `DINT` does not hold carries its type.
fn literal(value: i64) -> String {
    if i32::try_from(value).is_ok() {
        value.to_string()
    } else {
        format!("LINT#{value}")
    }
}

/// The function block of a controller of this specification.
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

/// The same with tables, however short the machine is: for the tests.
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
    /// Not kept.
    temporaries: Vec<Variable>,
    /// What leads back to before step 0.
    reset: String,
    /// A step: it sets `refused`, or changes the state and the outputs. Inputs are within their
    /// domains.
    step: String,
}

impl Variable {
    /// A variable that has its type's own value before the first call.
    pub fn new(name: &str, kind: Type, description: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            initial: Initial::Usual,
            description: description.to_owned(),
        }
    }

    /// The same with this value before the first call.
    #[must_use]
    pub fn beginning(self, value: &str) -> Self {
        Self {
            initial: Initial::Value(value.to_owned()),
            ..self
        }
    }
}
