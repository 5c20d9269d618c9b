//! Checks and compiles a function block: its declarations. Statements and expressions have separate
//! files.

use super::interpreter::{Code, INTEGERS, Program, Type, Variable};
use super::syntax::{Block, Declaration, Section, Spec, Unit};
use std::cell::RefCell;
use std::collections::HashMap;

/// State of compiling a block.
pub struct Compiler {
    pub variables: HashMap<String, Variable>,
    pub enumerations: Vec<(String, Vec<String>)>,
    aliases: HashMap<String, Spec>,
    texts: RefCell<Vec<String>>,
    pub line: usize,
}

impl Compiler {
    pub fn new(unit: &Unit, block: &Block) -> Result<Self, String> {
        let mut compiler = Self {
            variables: HashMap::new(),
            enumerations: Vec::new(),
            aliases: HashMap::new(),
            texts: RefCell::new(vec![String::new()]),
            line: 0,
        };
        // One name has one meaning in the whole text, ignoring case.
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

    pub fn block(mut self, block: &Block) -> Result<Program, String> {
        // The first number counts loop iterations.
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
            texts: self.texts.into_inner(),
            beginning,
            temporary,
            body,
        })
    }

    pub fn declared(
        &self,
        declaration: &Declaration,
        row: &mut Vec<i64>,
    ) -> Result<Variable, String> {
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

    /// A type with names of declared types resolved.
    pub fn resolved(&self, spec: &Spec) -> Spec {
        let mut spec = spec.clone();
        while let Spec::Named(name) = &spec {
            let Some(other) = self.aliases.get(name) else {
                break;
            };
            spec = other.clone();
        }
        spec
    }

    pub fn kind(&self, spec: &Spec) -> Result<(Type, Option<(i64, i64)>), String> {
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
            Spec::Text(length @ 1..=254) => Ok((Type::Text(*length as usize), None)),
            _ => Err("a type that is not supported here".to_owned()),
        }
    }

    /// The value of a string.
    pub fn text(&self, text: &str) -> i64 {
        let mut texts = self.texts.borrow_mut();
        let place = texts.iter().position(|t| t == text);
        let place = place.unwrap_or_else(|| {
            texts.push(text.to_owned());
            texts.len() - 1
        });
        place as i64
    }

    pub fn wrong<T>(&self, text: &str) -> Result<T, String> {
        Err(format!("line {}: {text}", self.line))
    }
}
