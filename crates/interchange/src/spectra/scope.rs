//! The names of a file, and what they stand for.

use super::dwyer::{self, PublishedPattern};
use super::import::Target;
use super::syntax::{Define, Pattern, Predicate, Regexp, TypeName};
use linewright_core::gr1::{Domain, VarId};
use linewright_core::source::Span;
use std::collections::BTreeMap;
use std::rc::Rc;

/// A variable or an array of variables, whose ids follow one another, the last index fastest.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    pub first: VarId,
    pub sizes: Vec<i64>,
    pub domain: Domain,
}

/// What a name of the file stands for.
#[derive(Debug, Clone)]
pub(super) enum Symbol {
    Variable(Cells),
    Define(Rc<Define>),
    Predicate(Rc<Predicate>),
    Pattern(Rc<Pattern>),
    /// A pattern that every file may import.
    Published(&'static PublishedPattern),
    Regexp(Rc<Regexp>),
}

impl Symbol {
    /// Whether a file that imports this one may use it: it is a definition, with no state of its
    /// own.
    pub fn is_definition(&self) -> bool {
        !matches!(self, Self::Variable(_))
    }
}

/// The names of one file.
#[derive(Debug, Default)]
pub(super) struct Scope {
    pub types: BTreeMap<String, (Rc<TypeName>, Span)>,
    pub symbols: BTreeMap<String, (Symbol, Span)>,
    /// The file's variables, monitors and counters: where it is imported, they stay there.
    pub behind: BTreeMap<String, Span>,
    /// What the file imports, in order.
    pub imports: Vec<Target>,
}

/// The published patterns by their names.
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
