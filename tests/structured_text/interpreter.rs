//! Structured Text, run: a function block is checked, compiled to closures over a row of numbers, and called.
//!
//! Where IEC 61131-3 leaves room, this takes the narrow side, so that what runs here runs everywhere: no conversion happens by
//! itself, both operands of AND and OR are evaluated, temporary variables have no value at the beginning of a call, and neither
//! has the variable of a FOR loop behind it. Numbers that leave their type, indices that leave their array, and loops that do
//! not end are faults.

use super::syntax::{Block, Declaration, Expr, Kind, Label, Section, Spec, Statement, Unit};
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// A temporary variable without a value.
const NOTHING: i64 = i64::MIN + 1;

/// A call that takes more turns of loops than this hangs.
const MOST_TURNS: i64 = 10_000_000;

/// The type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    Bool,
    /// By its place in [`INTEGERS`].
    Integer(usize),
    /// By its place among the declared ones.
    Enumeration(usize),
    /// A number without a type of its own.
    Literal,
}

/// The types of whole numbers; `ULINT` is left out.
const INTEGERS: [(&str, i64, i64); 7] = [
    ("SINT", i8::MIN as i64, i8::MAX as i64),
    ("INT", i16::MIN as i64, i16::MAX as i64),
    ("DINT", i32::MIN as i64, i32::MAX as i64),
    ("LINT", i64::MIN, i64::MAX),
    ("USINT", 0, u8::MAX as i64),
    ("UINT", 0, u16::MAX as i64),
    ("UDINT", 0, u32::MAX as i64),
];

/// A variable and where it lies.
#[derive(Debug, Clone)]
pub struct Variable {
    pub section: Section,
    pub kind: Type,
    /// The values that a subrange allows.
    range: Option<(i64, i64)>,
    /// Bounds of the dimensions of an array.
    dimensions: Vec<(i64, i64)>,
    pub slot: usize,
    pub length: usize,
}

/// What ended a call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault(pub String);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    On,
    Exit,
    Continue,
    Return,
}

type Numbers = [i64];
type Run = Box<dyn Fn(&mut Numbers) -> Flow>;

/// A compiled expression; the simple ones are told apart for speed.
enum Code {
    Constant(i64),
    Slot(usize),
    Other(Box<dyn Fn(&mut Numbers) -> i64>),
}

impl Code {
    fn run(&self, m: &mut Numbers) -> i64 {
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
    beginning: Vec<i64>,
    temporary: Vec<(usize, usize)>,
    body: Vec<Run>,
}

/// An instance of a function block.
pub struct Instance<'a> {
    program: &'a Program,
    numbers: Vec<i64>,
}

fn fault(line: usize, text: &str) -> ! {
    // Not a panic: nothing is to be printed.
    resume_unwind(Box::new(Fault(format!("line {line}: {text}"))))
}

fn sequence(body: &[Run], m: &mut Numbers) -> Flow {
    for statement in body {
        let flow = statement(m);
        if flow != Flow::On {
            return flow;
        }
    }
    Flow::On
}

/// Two operands and what is made of them.
fn both(a: Code, b: Code, f: impl Fn(i64, i64) -> i64 + 'static) -> Code {
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

fn one(a: Code, f: impl Fn(i64) -> i64 + 'static) -> Code {
    Code::Other(match a {
        Code::Other(a) => Box::new(move |m| f(a(m))),
        a => Box::new(move |m| f(a.run(m))),
    })
}

struct Compiler {
    variables: HashMap<String, Variable>,
    enumerations: Vec<(String, Vec<String>)>,
    aliases: HashMap<String, Spec>,
    line: usize,
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

    /// All numbers: variables lie in their slots.
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

impl Compiler {
    fn new(unit: &Unit, block: &Block) -> Result<Self, String> {
        let mut compiler = Self {
            variables: HashMap::new(),
            enumerations: Vec::new(),
            aliases: HashMap::new(),
            line: 0,
        };
        // One name means one thing in the whole text, whatever its case.
        let mut known = vec![block.name.clone()];
        let mut declare = |name: &str| {
            if known.iter().any(|k| k == name) {
                return Err(format!("`{name}` is declared twice"));
            }
            known.push(name.to_owned());
            Ok(())
        };
        for (name, spec) in &unit.types {
            declare(name)?;
            if let Spec::Enumeration(labels) = spec {
                for label in labels {
                    declare(label)?;
                }
                compiler.enumerations.push((name.clone(), labels.clone()));
            } else {
                compiler.aliases.insert(name.clone(), spec.clone());
            }
        }
        for declaration in &block.declarations {
            declare(&declaration.name)?;
        }
        Ok(compiler)
    }

    fn block(mut self, block: &Block) -> Result<Program, String> {
        // The first number counts the turns of loops.
        let mut beginning = vec![0];
        let mut temporary = Vec::new();
        for declaration in &block.declarations {
            let variable = self.declared(declaration, &mut beginning)?;
            if variable.section == Section::Temporary {
                temporary.push((variable.slot, variable.length));
            }
            self.variables.insert(declaration.name.clone(), variable);
        }
        let body = self.statements(&block.body)?;
        let names = block.declarations.iter().map(|d| d.name.clone());
        Ok(Program {
            order: names.collect(),
            variables: self.variables,
            enumerations: self.enumerations,
            beginning,
            temporary,
            body,
        })
    }

    fn declared(&self, declaration: &Declaration, row: &mut Vec<i64>) -> Result<Variable, String> {
        let name = &declaration.name;
        let (spec, dimensions) = match self.resolved(&declaration.spec) {
            Spec::Array(dimensions, of) => (self.resolved(&of), dimensions),
            spec => (spec, Vec::new()),
        };
        let (kind, range) = self.kind(&spec).map_err(|e| format!("{name}: {e}"))?;
        let dimensions: Vec<(i64, i64)> = dimensions
            .into_iter()
            .map(|(a, b)| (a as i64, b as i64))
            .collect();
        if dimensions.iter().any(|(a, b)| a > b) {
            return Err(format!("{name}: an array without elements"));
        }
        let length = dimensions
            .iter()
            .map(|(a, b)| (b - a + 1) as usize)
            .product();
        let usual = range.map_or(0, |(low, high)| if low <= 0 && 0 <= high { 0 } else { low });
        let slot = row.len();
        row.resize(slot + length, usual);
        if let Some(values) = &declaration.initial {
            if declaration.section == Section::Temporary {
                return Err(format!("{name}: a temporary variable with a value"));
            }
            let scalar = dimensions.is_empty();
            if values.len() > length || scalar != (values.len() == 1 && scalar) {
                return Err(format!("{name}: {} values for {length}", values.len()));
            }
            for (place, value) in values.iter().enumerate() {
                let (of, code) = self.expression(value)?;
                let code = self
                    .fitted(of, code, kind)
                    .map_err(|e| format!("{name}: {e}"))?;
                let Code::Constant(value) = code else {
                    return Err(format!("{name}: no constant"));
                };
                if range.is_some_and(|(low, high)| value < low || high < value) {
                    return Err(format!("{name}: {value} is out of range"));
                }
                row[slot + place] = value;
            }
        }
        Ok(Variable {
            section: declaration.section,
            kind,
            range,
            dimensions,
            slot,
            length,
        })
    }

    /// A type without the names that are declared for others.
    fn resolved(&self, spec: &Spec) -> Spec {
        let mut spec = spec.clone();
        while let Spec::Named(name) = &spec {
            let Some(other) = self.aliases.get(name) else {
                break;
            };
            spec = other.clone();
        }
        spec
    }

    fn kind(&self, spec: &Spec) -> Result<(Type, Option<(i64, i64)>), String> {
        let integer = |name: &str| INTEGERS.iter().position(|(n, ..)| *n == name);
        match spec {
            Spec::Named(name) if name == "BOOL" => Ok((Type::Bool, None)),
            Spec::Named(name) => {
                if let Some(place) = integer(name) {
                    return Ok((Type::Integer(place), None));
                }
                let place = self.enumerations.iter().position(|(n, _)| n == name);
                let place = place.ok_or_else(|| format!("there is no type `{name}`"))?;
                Ok((Type::Enumeration(place), None))
            }
            Spec::Subrange(name, low, high) => {
                let place = integer(name).ok_or("a subrange of what is no whole number")?;
                Ok((Type::Integer(place), Some((*low as i64, *high as i64))))
            }
            _ => Err("a type that is not supported here".to_owned()),
        }
    }

    fn wrong<T>(&self, text: &str) -> Result<T, String> {
        Err(format!("line {}: {text}", self.line))
    }

    fn statements(&mut self, list: &[Statement]) -> Result<Vec<Run>, String> {
        list.iter().map(|s| self.statement(s)).collect()
    }

    fn statement(&mut self, statement: &Statement) -> Result<Run, String> {
        self.line = statement.line;
        let line = statement.line;
        Ok(match &statement.kind {
            Kind::Exit => Box::new(|_| Flow::Exit),
            Kind::Continue => Box::new(|_| Flow::Continue),
            Kind::Return => Box::new(|_| Flow::Return),
            Kind::Assign(target, value) => self.assignment(target, value)?,
            Kind::If(branches, otherwise) => {
                let mut compiled = Vec::new();
                for (condition, body) in branches {
                    let condition = self.condition(condition)?;
                    compiled.push((condition, self.statements(body)?));
                }
                let otherwise = self.statements(otherwise)?;
                Box::new(move |m| {
                    for (condition, body) in &compiled {
                        if condition.run(m) != 0 {
                            return sequence(body, m);
                        }
                    }
                    sequence(&otherwise, m)
                })
            }
            Kind::Case(selector, branches, otherwise) => {
                self.case(selector, branches, otherwise)?
            }
            Kind::While(condition, body) => {
                let condition = self.condition(condition)?;
                let body = self.statements(body)?;
                Box::new(move |m| {
                    while condition.run(m) != 0 {
                        turn(m, line);
                        match sequence(&body, m) {
                            Flow::On | Flow::Continue => {}
                            Flow::Exit => break,
                            Flow::Return => return Flow::Return,
                        }
                    }
                    Flow::On
                })
            }
            Kind::Repeat(body, condition) => {
                let body = self.statements(body)?;
                self.line = line;
                let condition = self.condition(condition)?;
                Box::new(move |m| {
                    loop {
                        turn(m, line);
                        match sequence(&body, m) {
                            Flow::On | Flow::Continue => {}
                            Flow::Exit => break,
                            Flow::Return => return Flow::Return,
                        }
                        if condition.run(m) != 0 {
                            break;
                        }
                    }
                    Flow::On
                })
            }
            Kind::For {
                variable,
                from,
                to,
                by,
                body,
            } => {
                let variable = self.written(variable)?;
                let (Type::Integer(place), true) = (variable.kind, variable.dimensions.is_empty())
                else {
                    return self.wrong("the variable of a FOR is a whole number");
                };
                let (_, low, high) = INTEGERS[place];
                let mut number = |expr: &Expr| {
                    let (of, code) = self.expression(expr)?;
                    self.fitted(of, code, variable.kind)
                };
                let (from, to) = (number(from)?, number(to)?);
                let by = by.as_ref().map_or(Ok(Code::Constant(1)), &mut number)?;
                if matches!(by, Code::Constant(0)) {
                    return self.wrong("a FOR that does not advance");
                }
                if assigns(body, &variable.slot, &self.variables) {
                    return self.wrong("the variable of a FOR is changed within");
                }
                let slot = variable.slot;
                let temporary = variable.section == Section::Temporary;
                let body = self.statements(body)?;
                Box::new(move |m| {
                    let (from, to, by) = (from.run(m), to.run(m), by.run(m));
                    m[slot] = from;
                    while if by > 0 { m[slot] <= to } else { m[slot] >= to } {
                        turn(m, line);
                        match sequence(&body, m) {
                            Flow::On | Flow::Continue => {}
                            Flow::Exit => return Flow::On,
                            Flow::Return => return Flow::Return,
                        }
                        m[slot] = match m[slot].checked_add(by) {
                            Some(next) if low <= next && next <= high => next,
                            _ => fault(line, "the variable of a FOR overflows"),
                        };
                    }
                    if temporary {
                        m[slot] = NOTHING;
                    }
                    Flow::On
                })
            }
        })
    }

    /// A variable that may be written to.
    fn written(&self, name: &str) -> Result<Variable, String> {
        let Some(variable) = self.variables.get(name) else {
            return self.wrong(&format!("`{name}` is not declared"));
        };
        if matches!(variable.section, Section::Input | Section::Constant) {
            return self.wrong(&format!("`{name}` cannot be written to"));
        }
        Ok(variable.clone())
    }

    fn assignment(&mut self, target: &Expr, value: &Expr) -> Result<Run, String> {
        let line = self.line;
        let (Expr::Name(name) | Expr::Index(name, _)) = target else {
            return self.wrong("no variable");
        };
        let variable = self.written(name)?;
        let (of, code) = self.expression(value)?;
        let code = self.fitted(of, code, variable.kind)?;
        let code = match variable.range {
            None => code,
            Some((low, high)) => one(code, move |v| {
                if v < low || high < v {
                    fault(line, "a value leaves its subrange");
                }
                v
            }),
        };
        let indices: &[Expr] = if let Expr::Index(_, indices) = target {
            indices
        } else {
            &[]
        };
        Ok(match (self.place(&variable, indices)?, code) {
            (Code::Constant(slot), Code::Constant(value)) => {
                let slot = slot as usize;
                Box::new(move |m| {
                    m[slot] = value;
                    Flow::On
                })
            }
            (Code::Constant(slot), code) => {
                let slot = slot as usize;
                Box::new(move |m| {
                    m[slot] = code.run(m);
                    Flow::On
                })
            }
            (place, code) => Box::new(move |m| {
                let value = code.run(m);
                let slot = place.run(m) as usize;
                m[slot] = value;
                Flow::On
            }),
        })
    }

    /// Where an element lies.
    fn place(&self, variable: &Variable, indices: &[Expr]) -> Result<Code, String> {
        let line = self.line;
        if indices.len() != variable.dimensions.len() {
            return self.wrong("an array and its indices do not go together");
        }
        let mut place = Code::Constant(variable.slot as i64);
        let mut stride = variable.length as i64;
        for (index, (low, high)) in indices.iter().zip(&variable.dimensions) {
            let (low, high) = (*low, *high);
            stride /= high - low + 1;
            let (of, code) = self.expression(index)?;
            if !matches!(of, Type::Integer(_) | Type::Literal) {
                return self.wrong("an index is a whole number");
            }
            let step = stride;
            let offset = move |index: i64| {
                if index < low || high < index {
                    fault(line, "an index leaves its array");
                }
                (index - low) * step
            };
            place = match (place, code) {
                (Code::Constant(base), Code::Constant(index)) => {
                    if index < low || high < index {
                        return self.wrong("an index leaves its array");
                    }
                    Code::Constant(base + offset(index))
                }
                (Code::Constant(base), code) => one(code, move |i| base + offset(i)),
                (place, code) => both(place, code, move |base, i| base + offset(i)),
            };
        }
        Ok(place)
    }

    fn case(
        &mut self,
        selector: &Expr,
        branches: &[(Vec<Label>, Vec<Statement>)],
        otherwise: &[Statement],
    ) -> Result<Run, String> {
        let (of, selector) = self.expression(selector)?;
        if !matches!(of, Type::Integer(_) | Type::Enumeration(_)) {
            return self.wrong("a CASE chooses by a number or a label");
        }
        let mut ranges: Vec<(i64, i64, usize)> = Vec::new();
        let mut bodies = Vec::new();
        for (labels, body) in branches {
            for label in labels {
                let constant = |expr: &Expr| {
                    let (kind, code) = self.expression(expr)?;
                    match self.fitted(kind, code, of)? {
                        Code::Constant(value) => Ok(value),
                        _ => self.wrong("a label of a CASE is no constant"),
                    }
                };
                let first = constant(&label.first)?;
                let last = label.last.as_ref().map_or(Ok(first), constant)?;
                if ranges.iter().any(|(a, b, _)| *a <= last && first <= *b) {
                    return self.wrong("a value of a CASE stands there twice");
                }
                ranges.push((first, last, bodies.len()));
            }
            bodies.push(self.statements(body)?);
        }
        ranges.sort_unstable();
        let otherwise = self.statements(otherwise)?;
        Ok(Box::new(move |m| {
            let value = selector.run(m);
            let place = ranges.partition_point(|(first, ..)| *first <= value);
            match place.checked_sub(1).map(|p| ranges[p]) {
                Some((_, last, body)) if value <= last => sequence(&bodies[body], m),
                _ => sequence(&otherwise, m),
            }
        }))
    }

    fn condition(&self, expr: &Expr) -> Result<Code, String> {
        let (of, code) = self.expression(expr)?;
        if of != Type::Bool {
            return self.wrong("a condition is a BOOL");
        }
        Ok(code)
    }

    /// A value where another type is wanted: only numbers without a type fit any.
    fn fitted(&self, of: Type, code: Code, wanted: Type) -> Result<Code, String> {
        match (of, wanted, &code) {
            (Type::Literal, Type::Integer(place), Code::Constant(value)) => {
                let (name, low, high) = INTEGERS[place];
                if *value < low || high < *value {
                    return self.wrong(&format!("{value} is no {name}"));
                }
                Ok(code)
            }
            _ if of == wanted => Ok(code),
            _ => self.wrong(&format!("{of:?} where {wanted:?} is wanted")),
        }
    }

    /// Two operands of one type.
    fn alike(&self, a: (Type, Code), b: (Type, Code)) -> Result<(Type, Code, Code), String> {
        let of = if a.0 == Type::Literal { b.0 } else { a.0 };
        Ok((of, self.fitted(a.0, a.1, of)?, self.fitted(b.0, b.1, of)?))
    }

    fn label(&self, name: &str) -> Option<(Type, Code)> {
        let places = self.enumerations.iter().enumerate();
        let mut found = places.filter_map(|(place, (_, labels))| {
            let value = labels.iter().position(|l| l == name)?;
            Some((Type::Enumeration(place), Code::Constant(value as i64)))
        });
        found.next()
    }

    fn expression(&self, expr: &Expr) -> Result<(Type, Code), String> {
        let line = self.line;
        match expr {
            Expr::Number(value) => match i64::try_from(*value) {
                Ok(value) => Ok((Type::Literal, Code::Constant(value))),
                Err(_) => self.wrong("a number that no type holds"),
            },
            Expr::Typed(name, value) => self.typed(name, value),
            Expr::Name(name) if name == "TRUE" || name == "FALSE" => {
                Ok((Type::Bool, Code::Constant(i64::from(name == "TRUE"))))
            }
            Expr::Name(name) | Expr::Index(name, _) => {
                let Some(variable) = self.variables.get(name) else {
                    return match self.label(name) {
                        Some(label) if matches!(expr, Expr::Name(_)) => Ok(label),
                        _ => self.wrong(&format!("`{name}` is not declared")),
                    };
                };
                let indices: &[Expr] = if let Expr::Index(_, i) = expr { i } else { &[] };
                let checked = move |value: i64| {
                    if value == NOTHING {
                        fault(line, "a temporary variable has no value yet");
                    }
                    value
                };
                let temporary = variable.section == Section::Temporary;
                let code = match self.place(variable, indices)? {
                    Code::Constant(slot) if temporary => {
                        let slot = slot as usize;
                        Code::Other(Box::new(move |m| checked(m[slot])))
                    }
                    Code::Constant(slot) => Code::Slot(slot as usize),
                    place if temporary => Code::Other(Box::new(move |m| {
                        let slot = place.run(m) as usize;
                        checked(m[slot])
                    })),
                    place => Code::Other(Box::new(move |m| {
                        let slot = place.run(m) as usize;
                        m[slot]
                    })),
                };
                Ok((variable.kind, code))
            }
            Expr::Unary("NOT", a) => {
                let a = self.condition(a)?;
                Ok((Type::Bool, one(a, |v| 1 - v)))
            }
            Expr::Unary(_, a) => {
                let zero = (Type::Literal, Code::Constant(0));
                let (of, zero, a) = self.alike(zero, self.expression(a)?)?;
                self.arithmetic("-", of, zero, a)
            }
            Expr::Binary(op, a, b) => {
                let (of, a, b) = self.alike(self.expression(a)?, self.expression(b)?)?;
                let truth = |code| Ok((Type::Bool, code));
                match (*op, of) {
                    ("AND", Type::Bool) => truth(both(a, b, |a, b| a & b)),
                    ("OR", Type::Bool) => truth(both(a, b, |a, b| a | b)),
                    ("XOR", Type::Bool) => truth(both(a, b, |a, b| a ^ b)),
                    ("=", _) => truth(both(a, b, |a, b| i64::from(a == b))),
                    ("<>", _) => truth(both(a, b, |a, b| i64::from(a != b))),
                    ("<" | ">" | "<=" | ">=", Type::Integer(_) | Type::Literal) => {
                        truth(match *op {
                            "<" => both(a, b, |a, b| i64::from(a < b)),
                            ">" => both(a, b, |a, b| i64::from(a > b)),
                            "<=" => both(a, b, |a, b| i64::from(a <= b)),
                            _ => both(a, b, |a, b| i64::from(a >= b)),
                        })
                    }
                    ("+" | "-" | "*" | "/" | "MOD", Type::Integer(_) | Type::Literal) => {
                        self.arithmetic(op, of, a, b)
                    }
                    _ => self.wrong(&format!("`{op}` of {of:?}")),
                }
            }
            Expr::Call(name, arguments) => self.function(name, arguments),
        }
    }

    fn typed(&self, name: &str, value: &Expr) -> Result<(Type, Code), String> {
        if let Some(place) = self.enumerations.iter().position(|(n, _)| n == name) {
            let labels = &self.enumerations[place].1;
            let Expr::Name(label) = value else {
                return self.wrong("no label");
            };
            let Some(value) = labels.iter().position(|l| l == label) else {
                return self.wrong(&format!("`{name}` has no label `{label}`"));
            };
            return Ok((Type::Enumeration(place), Code::Constant(value as i64)));
        }
        let (kind, _) = self.kind(&Spec::Named(name.to_owned()))?;
        match (kind, value) {
            (Type::Bool, Expr::Number(bit @ (0 | 1))) => {
                Ok((Type::Bool, Code::Constant(*bit as i64)))
            }
            (_, Expr::Number(_) | Expr::Name(_)) => {
                let (of, code) = self.expression(value)?;
                Ok((kind, self.fitted(of, code, kind)?))
            }
            _ => self.wrong("no literal"),
        }
    }

    /// `+ - * / MOD` within a type. Division rounds towards 0; the rest of a division by 0 is 0.
    fn arithmetic(&self, op: &str, of: Type, a: Code, b: Code) -> Result<(Type, Code), String> {
        let line = self.line;
        let (low, high) = match of {
            Type::Integer(place) => (INTEGERS[place].1, INTEGERS[place].2),
            Type::Literal => (i64::MIN, i64::MAX),
            _ => return self.wrong(&format!("`{op}` of {of:?}")),
        };
        let held = move |value: Option<i64>| match value {
            Some(value) if low <= value && value <= high => value,
            _ => fault(line, "a number leaves its type"),
        };
        let code = match op {
            "+" => both(a, b, move |a, b| held(a.checked_add(b))),
            "-" => both(a, b, move |a, b| held(a.checked_sub(b))),
            "*" => both(a, b, move |a, b| held(a.checked_mul(b))),
            "/" => both(a, b, move |a, b| {
                if b == 0 {
                    fault(line, "a division by 0");
                }
                held(a.checked_div(b))
            }),
            _ => both(a, b, |a, b| if b == 0 { 0 } else { a.wrapping_rem(b) }),
        };
        // Of numbers without a type comes one, at once.
        if of == Type::Literal {
            let computed = catch_unwind(AssertUnwindSafe(|| code.run(&mut [])));
            return match computed {
                Ok(value) => Ok((of, Code::Constant(value))),
                Err(_) => self.wrong("a constant that cannot be computed"),
            };
        }
        Ok((of, code))
    }

    fn function(&self, name: &str, arguments: &[Expr]) -> Result<(Type, Code), String> {
        let line = self.line;
        let mut given = Vec::new();
        for argument in arguments {
            given.push(self.expression(argument)?);
        }
        let count = given.len();
        let mut given = given.into_iter();
        let mut next = || given.next().expect("they were counted");
        let integer = |of: Type| matches!(of, Type::Integer(_));
        match (name, count) {
            ("ABS", 1) => {
                let (of, a) = next();
                if let (Type::Literal, Code::Constant(value)) = (of, &a) {
                    return Ok((of, Code::Constant(value.abs())));
                }
                let Type::Integer(place) = of else {
                    return self.wrong("ABS of what is no number");
                };
                let high = INTEGERS[place].2;
                let code = one(a, move |v| match v.checked_abs() {
                    Some(v) if v <= high => v,
                    _ => fault(line, "a number leaves its type"),
                });
                Ok((of, code))
            }
            ("MIN" | "MAX", 2) => {
                let (of, a, b) = self.alike(next(), next())?;
                if !integer(of) {
                    return self.wrong("MIN and MAX of what are no numbers");
                }
                let code = if name == "MIN" {
                    both(a, b, i64::min)
                } else {
                    both(a, b, i64::max)
                };
                Ok((of, code))
            }
            ("LIMIT", 3) => {
                let (low, value, high) = (next(), next(), next());
                let (of, low, value) = self.alike(low, value)?;
                let high = self.fitted(high.0, high.1, of)?;
                if !integer(of) {
                    return self.wrong("LIMIT of what are no numbers");
                }
                Ok((of, both(both(low, value, i64::max), high, i64::min)))
            }
            ("SEL", 3) => {
                let (of, condition) = next();
                if of != Type::Bool {
                    return self.wrong("SEL chooses by a BOOL");
                }
                let (of, no, yes) = self.alike(next(), next())?;
                let code = Code::Other(Box::new(move |m| {
                    let (chosen, no) = (condition.run(m), no.run(m));
                    let yes = yes.run(m);
                    if chosen != 0 { yes } else { no }
                }));
                Ok((of, code))
            }
            (_, 1) => {
                let kind = |n: &str| INTEGERS.iter().position(|(name, ..)| *name == n);
                let pair = name.split_once("_TO_");
                let pair = pair.and_then(|(a, b)| Some((kind(a)?, kind(b)?)));
                let Some((from, to)) = pair else {
                    return self.wrong(&format!("there is no function `{name}`"));
                };
                let (of, a) = next();
                let a = self.fitted(of, a, Type::Integer(from))?;
                let (_, low, high) = INTEGERS[to];
                let code = one(a, move |v| {
                    if v < low || high < v {
                        fault(line, "a number leaves its type");
                    }
                    v
                });
                Ok((Type::Integer(to), code))
            }
            _ => self.wrong(&format!("there is no function `{name}` of {count}")),
        }
    }
}

/// One more turn of a loop.
fn turn(m: &mut Numbers, line: usize) {
    m[0] -= 1;
    if m[0] < 0 {
        fault(line, "a loop does not end");
    }
}

/// Whether statements assign to the variable in this slot.
fn assigns(list: &[Statement], slot: &usize, variables: &HashMap<String, Variable>) -> bool {
    let is = |name: &String| variables.get(name).is_some_and(|v| v.slot == *slot);
    let inside = |list: &[Statement]| assigns(list, slot, variables);
    list.iter().any(|statement| match &statement.kind {
        Kind::Assign(Expr::Name(name), _) => is(name),
        Kind::If(branches, otherwise) => {
            branches.iter().any(|(_, b)| inside(b)) || inside(otherwise)
        }
        Kind::Case(_, branches, otherwise) => {
            branches.iter().any(|(_, b)| inside(b)) || inside(otherwise)
        }
        Kind::For { variable, body, .. } => is(variable) || inside(body),
        Kind::While(_, body) | Kind::Repeat(body, _) => inside(body),
        _ => false,
    })
}
