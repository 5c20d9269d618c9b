//! The names of a file and their meanings.

use super::dwyer::{self, PublishedPattern};
use super::import::Target;
use super::syntax::{Define, Pattern, Predicate, Regexp, TypeName};
use linewright_core::gr1::{Domain, VarId};
use linewright_core::source::Span;
use std::collections::BTreeMap;
use std::rc::Rc;

/// A variable, or an array of variables with consecutive ids in row-major order.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    pub first: VarId,
    pub sizes: Vec<i64>,
    pub domain: Domain,
}

impl Cells {
    /// Returns the ids of all elements.
    pub fn ids(&self) -> Vec<VarId> {
        let count: i64 = self.sizes.iter().product();
        let first = self.first.0;
        (first..first + count as u32).map(VarId).collect()
    }
}

/// The meaning of a name.
#[derive(Debug, Clone)]
pub(super) enum Symbol {
    Variable(Cells),
    Define(Rc<Define>),
    Predicate(Rc<Predicate>),
    Pattern(Rc<Pattern>),
    /// A pattern that every file can import.
    Published(&'static PublishedPattern),
    Regexp(Rc<Regexp>),
}

impl Symbol {
    /// Whether importing files can use the symbol: definitions only, not variables.
    pub fn is_definition(&self) -> bool {
        !matches!(self, Self::Variable(_))
    }
}

/// The names of one file.
#[derive(Debug, Default)]
pub(super) struct Scope {
    pub types: BTreeMap<String, (Rc<TypeName>, Span)>,
    pub symbols: BTreeMap<String, (Symbol, Span)>,
    /// Variables, monitors and counters of the file; importing files cannot use them.
    pub not_exported: BTreeMap<String, Span>,
    /// Imports of the file, in order.
    pub imports: Vec<Target>,
}

/// The scope that contains the published patterns.
pub(super) fn published() -> Scope {
    let symbol = |p: &'static PublishedPattern| (Symbol::Published(p), Span::default());
    let symbols = dwyer::PATTERNS
        .iter()
        .map(|p| (p.name.to_owned(), symbol(p)));
    Scope {
        symbols: symbols.collect(),
        ..Scope::default()
    }
}
