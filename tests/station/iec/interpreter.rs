//! Runs Structured Text: a function block is checked and compiled ([`compiler`](super::compiler))
//! to closures over a row of numbers, and called.
//!
//! Where IEC 61131-3 leaves freedom, this chooses the strict interpretation, so that whatever runs
//! here runs everywhere: no implicit conversions, both operands of AND and OR are evaluated,
//! temporary variables have no value at the beginning of a call, nor does the variable of a FOR
//! loop after it. Numbers out of range, indices out of bounds, and endless loops are faults.

use super::compiler::Compiler;
use super::syntax::{Section, Unit};
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// A temporary variable without a value.
pub const NOTHING: i64 = i64::MIN + 1;

/// Maximum number of loop iterations of a call; beyond it, the call counts as hung.
const MOST_TURNS: i64 = 10_000_000;

/// The type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    Bool,
    /// By index in [`INTEGERS`].
    Integer(usize),
    /// By index among the declared ones.
    Enumeration(usize),
    /// A string with this maximum length. Its value is its index in [`Program::texts`].
    Text(usize),
    /// A number without its own type.
    Literal,
}

/// The integer types; `ULINT` is omitted.
pub const INTEGERS: [(&str, i64, i64); 7] = [
    ("SINT", i8::MIN as i64, i8::MAX as i64),
    ("INT", i16::MIN as i64, i16::MAX as i64),
    ("DINT", i32::MIN as i64, i32::MAX as i64),
    ("LINT", i64::MIN, i64::MAX),
    ("USINT", 0, u8::MAX as i64),
    ("UINT", 0, u16::MAX as i64),
    ("UDINT", 0, u32::MAX as i64),
];

/// A variable and its location.
#[derive(Debug, Clone)]
pub struct Variable {
    pub section: Section,
    pub kind: Type,
    /// The values that a subrange allows.
    pub range: Option<(i64, i64)>,
    /// Bounds of an array's dimensions.
    pub dimensions: Vec<(i64, i64)>,
    pub slot: usize,
    pub length: usize,
}

/// The fault that ended a call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault(pub String);

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    On,
    Exit,
    Continue,
    Return,
}

pub type Numbers = [i64];
pub type Run = Box<dyn Fn(&mut Numbers) -> Flow>;

/// A compiled expression; simple ones have their own variants for speed.
pub enum Code {
    Constant(i64),
    Slot(usize),
    Other(Box<dyn Fn(&mut Numbers) -> i64>),
}

impl Code {
    pub fn run(&self, m: &mut Numbers) -> i64 {
        match self {
            Self::Constant(value) => *value,
            Self::Slot(slot) => m[*slot],
            Self::Other(code) => code(m),
        }
    }
}

/// A compiled function block.
pub struct Program {
    pub variables: HashMap<String, Variable>,
    /// Their names in the order of their declarations.
    pub order: Vec<String>,
    /// The labels of every enumeration.
    pub enumerations: Vec<(String, Vec<String>)>,
    /// All strings in the text; the empty one first.
    pub texts: Vec<String>,
    pub beginning: Vec<i64>,
    pub temporary: Vec<(usize, usize)>,
    pub body: Vec<Run>,
}

/// An instance of a function block.
pub struct Instance<'a> {
    program: &'a Program,
    numbers: Vec<i64>,
}

pub fn fault(line: usize, text: &str) -> ! {
    // Not a panic, so that nothing is printed.
    resume_unwind(Box::new(Fault(format!("line {line}: {text}"))))
}

pub fn sequence(body: &[Run], m: &mut Numbers) -> Flow {
    for statement in body {
        let flow = statement(m);
        if flow != Flow::On {
            return flow;
        }
    }
    Flow::On
}

/// Two operands and an operation.
pub fn both(a: Code, b: Code, f: impl Fn(i64, i64) -> i64 + 'static) -> Code {
    Code::Other(match (a, b) {
        (Code::Slot(a), Code::Constant(b)) => Box::new(move |m| f(m[a], b)),
        (Code::Slot(a), Code::Slot(b)) => Box::new(move |m| f(m[a], m[b])),
        (Code::Other(a), Code::Constant(b)) => Box::new(move |m| f(a(m), b)),
        (Code::Other(a), Code::Other(b)) => Box::new(move |m| {
            let a = a(m);
            f(a, b(m))
        }),
        (a, b) => Box::new(move |m| {
            let a = a.run(m);
            f(a, b.run(m))
        }),
    })
}

pub fn one(a: Code, f: impl Fn(i64) -> i64 + 'static) -> Code {
    Code::Other(match a {
        Code::Other(a) => Box::new(move |m| f(a(m))),
        a => Box::new(move |m| f(a.run(m))),
    })
}

impl Program {
    /// Checks and compiles the only function block of a text.
    pub fn new(unit: &Unit) -> Result<Self, String> {
        let [block] = unit.blocks.as_slice() else {
            return Err(format!("{} function blocks", unit.blocks.len()));
        };
        Compiler::new(unit, block)?.block(block)
    }

    /// An instance before its first call.
    pub fn instance(&self) -> Instance<'_> {
        Instance {
            program: self,
            numbers: self.beginning.clone(),
        }
    }
}

impl Instance<'_> {
    pub fn get(&self, variable: &Variable) -> i64 {
        self.numbers[variable.slot]
    }

    pub fn set(&mut self, variable: &Variable, value: i64) {
        self.numbers[variable.slot] = value;
    }

    /// All numbers: variables are in their slots.
    pub fn snapshot(&self) -> Vec<i64> {
        self.numbers.clone()
    }

    /// One call.
    pub fn call(&mut self) -> Result<(), Fault> {
        for (slot, length) in &self.program.temporary {
            self.numbers[*slot..slot + length].fill(NOTHING);
        }
        self.numbers[0] = MOST_TURNS;
        let numbers = &mut self.numbers;
        let body = &self.program.body;
        match catch_unwind(AssertUnwindSafe(|| sequence(body, numbers))) {
            Ok(_) => Ok(()),
            Err(cause) => match cause.downcast::<Fault>() {
                Ok(fault) => Err(*fault),
                Err(cause) => resume_unwind(cause),
            },
        }
    }
}

/// Counts a loop iteration.
pub fn turn(m: &mut Numbers, line: usize) {
    m[0] -= 1;
    if m[0] < 0 {
        fault(line, "a loop does not end");
    }
}
