//! Names in scope: variables, constants, types, defines and counters.
//!
//! Quantified names and the parameters of a define are treated as constants. While they are in
//! scope, they hide other declarations of the same name.

use crate::contract::shape::{Entry, Shape};
use crate::contract::value::{Type, Value};
use linewright_syntax::ast;
use std::collections::{BTreeMap, BTreeSet};

/// Names declared at the top level of files. A define at the top level can use only these names.
#[derive(Clone, Default)]
pub(in crate::contract) struct FileNames<'a> {
    /// Constants.
    pub constants: BTreeMap<String, Value>,
    /// Defines.
    pub defines: BTreeMap<String, &'a ast::Define>,
}

/// Names in scope.
#[derive(Clone, Default)]
pub(in crate::contract) struct Names<'a> {
    /// Variables; those of a component have dotted names.
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
    /// Names whose declaration has a reported error: their uses are not reported again.
    pub broken: BTreeSet<String>,
    /// Names declared at the top level of files.
    pub of_file: FileNames<'a>,
    /// Quantified names, innermost last.
    bound: BoundNames,
}

/// Quantified names, each with the constant that it hides, if any.
pub(super) type BoundNames = Vec<(String, Option<Value>)>;

/// Names in scope within a contract or machine.
pub(super) struct LocalNames<'a> {
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
            of_file: self.of_file.clone(),
            bound: BoundNames::new(),
        }
    }

    /// Returns whether a variable, constant, define or counter has this name.
    pub fn contains(&self, name: &str) -> bool {
        self.variables.contains_key(name)
            || self.constants.contains_key(name)
            || self.defines.contains_key(name)
            || self.counters.contains_key(name)
    }

    /// Removes the constant or define with this name, because a variable of the same name hides it.
    pub fn hide(&mut self, name: &str) {
        self.constants.remove(name);
        self.defines.remove(name);
    }

    /// Returns whether a dotted name, or a prefix of it, is declared.
    pub(super) fn has_prefix_of(&self, names: &[ast::Name]) -> bool {
        (1..=names.len()).any(|n| {
            let words: Vec<&str> = names[..n].iter().map(|n| n.text.as_str()).collect();
            let name = words.join(".");
            self.constants.contains_key(&name)
                || self.defines.contains_key(&name)
                || self.variables.contains_key(&name)
                || self.broken.contains(&name)
        })
    }

    /// Returns whether the value of an expression can only be a label or an array of labels,
    /// because its names are not declared.
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

    /// Returns the variable with this dotted name, unless a constant, define or counter hides it.
    pub(super) fn variable(&self, names: &[ast::Name]) -> Option<&Entry> {
        let words: Vec<&str> = names.iter().map(|n| n.text.as_str()).collect();
        let name = words.join(".");
        let hidden = self.constants.contains_key(&name)
            || self.defines.contains_key(&name)
            || self.counters.contains_key(&name);
        self.variables.get(&name).filter(|_| !hidden)
    }

    /// Returns the length of the array with this name; `None` if there is no such array.
    pub(super) fn array_length(&self, name: &str) -> Option<usize> {
        match (self.constants.get(name), self.variables.get(name)) {
            (Some(Value::Array(values)), _) => Some(values.len()),
            (None, Some(Entry::Many(list))) => Some(list.len()),
            _ => None,
        }
    }

    /// Brings a quantified name into scope, until [`Names::unbind`].
    pub(super) fn bind(&mut self, name: String, value: Value) {
        let hidden = self.constants.insert(name.clone(), value);
        self.bound.push((name, hidden));
    }

    /// Removes the innermost quantified name from the scope.
    pub(super) fn unbind(&mut self) {
        if let Some((name, hidden)) = self.bound.pop() {
            self.replace_constant(name, hidden);
        }
    }

    /// Removes all quantified names from the scope, until [`Names::restore_bound`].
    pub(super) fn hide_bound(&mut self) -> BoundNames {
        let mut bound = std::mem::take(&mut self.bound);
        for (name, value) in bound.iter_mut().rev() {
            *value = self.replace_constant(name.clone(), value.take());
        }
        bound
    }

    /// Restores the quantified names that [`Names::hide_bound`] removed.
    pub(super) fn restore_bound(&mut self, mut bound: BoundNames) {
        for (name, value) in &mut bound {
            *value = self.replace_constant(name.clone(), value.take());
        }
        self.bound = bound;
    }

    /// Removes all names except those declared at the top level of files, until
    /// [`Names::restore_local`].
    pub(super) fn hide_local(&mut self) -> LocalNames<'a> {
        let FileNames { constants, defines } = self.of_file.clone();
        LocalNames {
            variables: std::mem::take(&mut self.variables),
            constants: std::mem::replace(&mut self.constants, constants),
            defines: std::mem::replace(&mut self.defines, defines),
            counters: std::mem::take(&mut self.counters),
        }
    }

    /// Restores the names that [`Names::hide_local`] removed.
    pub(super) fn restore_local(&mut self, local: LocalNames<'a>) {
        self.variables = local.variables;
        self.constants = local.constants;
        self.defines = local.defines;
        self.counters = local.counters;
    }

    fn replace_constant(&mut self, name: String, value: Option<Value>) -> Option<Value> {
        match value {
            Some(value) => self.constants.insert(name, value),
            None => self.constants.remove(&name),
        }
    }
}
