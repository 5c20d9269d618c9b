//! Names in scope: variables, constants, types, defines and counters.
//!
//! Quantified names and the parameters of a define are constants that temporarily hide others of
//! the same name.

use crate::contract::shape::{Entry, Shape};
use crate::contract::value::{Type, Value};
use linewright_syntax::ast;
use std::collections::{BTreeMap, BTreeSet};

/// Names declared outside of all contracts, as seen by the defines declared there.
#[derive(Clone, Default)]
pub(in crate::contract) struct Outside<'a> {
    /// Constants.
    pub constants: BTreeMap<String, Value>,
    /// Defines.
    pub defines: BTreeMap<String, &'a ast::Define>,
}

/// Names in scope.
#[derive(Clone, Default)]
pub(in crate::contract) struct Names<'a> {
    /// Variables; dotted for those of a component.
    pub variables: BTreeMap<String, Entry>,
    /// Constants, parameters and quantified names.
    pub constants: BTreeMap<String, Value>,
    /// Named types.
    pub types: BTreeMap<String, Type>,
    /// Shapes of the named types.
    pub shapes: BTreeMap<String, Shape>,
    /// Defines.
    pub defines: BTreeMap<String, &'a ast::Define>,
    /// Counters.
    pub counters: BTreeMap<String, &'a ast::Counter>,
    /// Names whose declaration was reported as wrong: their uses are not reported.
    pub broken: BTreeSet<String>,
    /// Names visible to a define of the file.
    pub outside: Outside<'a>,
    /// Quantified names, innermost last.
    bound: HiddenNames,
}

/// Quantified names with the values they hide.
pub(super) type HiddenNames = Vec<(String, Option<Value>)>;

/// Names visible only within a contract or machine.
pub(super) struct Inside<'a> {
    variables: BTreeMap<String, Entry>,
    constants: BTreeMap<String, Value>,
    defines: BTreeMap<String, &'a ast::Define>,
    counters: BTreeMap<String, &'a ast::Counter>,
}

impl<'a> Names<'a> {
    /// Returns the same names without variables, counters and quantified names.
    pub fn without_variables(&self) -> Self {
        Self {
            variables: BTreeMap::new(),
            constants: self.constants.clone(),
            types: self.types.clone(),
            shapes: self.shapes.clone(),
            defines: self.defines.clone(),
            counters: BTreeMap::new(),
            broken: self.broken.clone(),
            outside: self.outside.clone(),
            bound: HiddenNames::new(),
        }
    }

    /// Returns whether a variable, constant, define or counter has this name.
    pub fn contains(&self, name: &str) -> bool {
        self.variables.contains_key(name)
            || self.constants.contains_key(name)
            || self.defines.contains_key(name)
            || self.counters.contains_key(name)
    }

    /// Removes an outer declaration that a variable of the same name hides.
    pub fn hide(&mut self, name: &str) {
        self.constants.remove(name);
        self.defines.remove(name);
    }

    /// Returns whether a dotted name, or a prefix of it, is declared.
    pub(super) fn knows(&self, names: &[ast::Name]) -> bool {
        (1..=names.len()).any(|n| {
            let words: Vec<&str> = names[..n].iter().map(|n| n.text.as_str()).collect();
            let name = words.join(".");
            self.constants.contains_key(&name)
                || self.defines.contains_key(&name)
                || self.variables.contains_key(&name)
                || self.broken.contains(&name)
        })
    }

    /// Returns whether an expression consists of names that can only be labels.
    pub(super) fn is_label(&self, e: &ast::Expr) -> bool {
        match &e.kind {
            ast::ExprKind::Path(names) => match names.as_slice() {
                [name] => !self.contains(&name.text),
                _ => false,
            },
            ast::ExprKind::If(_, a, b) => self.is_label(a) && self.is_label(b),
            ast::ExprKind::List(members) => members.iter().all(|m| self.is_label(m)),
            ast::ExprKind::Index(base, _) => self.is_label(base),
            _ => false,
        }
    }

    /// Returns the variable of this dotted name, if nothing else in scope has the name.
    pub(super) fn variable(&self, names: &[ast::Name]) -> Option<&Entry> {
        let words: Vec<&str> = names.iter().map(|n| n.text.as_str()).collect();
        let name = words.join(".");
        let hidden = self.constants.contains_key(&name)
            || self.defines.contains_key(&name)
            || self.counters.contains_key(&name);
        self.variables.get(&name).filter(|_| !hidden)
    }

    /// Returns the length of an array, if the name is that of an array.
    pub(super) fn length(&self, name: &str) -> Option<usize> {
        match (self.constants.get(name), self.variables.get(name)) {
            (Some(Value::Array(values)), _) => Some(values.len()),
            (None, Some(Entry::Many(list))) => Some(list.len()),
            _ => None,
        }
    }

    /// Adds a quantified name, until [`Names::unbind`].
    pub(super) fn bind(&mut self, name: String, value: Value) {
        let hidden = self.constants.insert(name.clone(), value);
        self.bound.push((name, hidden));
    }

    /// Removes the innermost quantified name.
    pub(super) fn unbind(&mut self) {
        if let Some((name, hidden)) = self.bound.pop() {
            self.replace_constant(name, hidden);
        }
    }

    /// Removes all quantified names, until [`Names::show_bound`].
    pub(super) fn hide_bound(&mut self) -> HiddenNames {
        let mut bound = std::mem::take(&mut self.bound);
        for (name, value) in bound.iter_mut().rev() {
            *value = self.replace_constant(name.clone(), value.take());
        }
        bound
    }

    /// Restores quantified names.
    pub(super) fn show_bound(&mut self, mut bound: HiddenNames) {
        for (name, value) in &mut bound {
            *value = self.replace_constant(name.clone(), value.take());
        }
        self.bound = bound;
    }

    /// Keeps only the names declared outside of all contracts, until [`Names::show_inside`].
    pub(super) fn hide_inside(&mut self) -> Inside<'a> {
        let Outside { constants, defines } = self.outside.clone();
        Inside {
            variables: std::mem::take(&mut self.variables),
            constants: std::mem::replace(&mut self.constants, constants),
            defines: std::mem::replace(&mut self.defines, defines),
            counters: std::mem::take(&mut self.counters),
        }
    }

    /// Restores the names visible only within a contract or machine.
    pub(super) fn show_inside(&mut self, inside: Inside<'a>) {
        self.variables = inside.variables;
        self.constants = inside.constants;
        self.defines = inside.defines;
        self.counters = inside.counters;
    }

    fn replace_constant(&mut self, name: String, value: Option<Value>) -> Option<Value> {
        match value {
            Some(value) => self.constants.insert(name, value),
            None => self.constants.remove(&name),
        }
    }
}
