//! What the names of each file stand for.
//!
//! A file sees what it declares itself and what the files that it imports declare, not what those
//! import. A definition is read with the names of its own file, wherever it is used: each name
//! carries its place, and its place tells the file.

use super::import::Target;
use super::reader::Reader;
use super::scope::{Scope, Symbol};
use super::syntax::{Name, TypeName};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use std::rc::Rc;

impl Reader {
    /// The scopes of the files that a file imports.
    fn imported(&self, at: Span) -> impl Iterator<Item = &Scope> {
        let imports = self.scopes.get(&at.file).map(|s| &s.imports);
        let scopes = imports.into_iter().flatten().map(|target| match target {
            Target::File(file) => self.scopes.get(file),
            Target::Published => Some(&self.published),
        });
        scopes.flatten()
    }

    /// What a name means in the file in which it is used: its own meaning, or the first one that is
    /// imported.
    pub fn symbol(&self, name: &str, at: Span) -> Option<&(Symbol, Span)> {
        let own = self.scopes.get(&at.file)?.symbols.get(name);
        own.or_else(|| {
            self.imported(at)
                .filter_map(|scope| scope.symbols.get(name))
                .find(|(symbol, _)| symbol.is_definition())
        })
    }

    /// What a type's name means in the file in which it is used.
    pub fn declared_type(&self, name: &str, at: Span) -> Option<&Rc<TypeName>> {
        let own = self.scopes.get(&at.file)?.types.get(name);
        let found = own.or_else(|| self.imported(at).find_map(|scope| scope.types.get(name)));
        found.map(|(of, _)| of)
    }

    /// The variable, monitor or counter of that name that an import leaves in its file.
    pub fn left_behind(&self, name: &str, at: Span) -> Option<Span> {
        let own = self.scopes.get(&at.file).filter(|_| at.file != self.root);
        let scopes = own.into_iter().chain(self.imported(at));
        let mut found = scopes.filter_map(|scope| scope.behind.get(name));
        found.next().copied()
    }

    /// The names that a file sees.
    pub fn seen(&self, at: Span) -> impl Iterator<Item = &str> {
        let scopes = self
            .scopes
            .get(&at.file)
            .into_iter()
            .chain(self.imported(at));
        scopes.flat_map(|scope| scope.symbols.keys().map(String::as_str))
    }

    /// The names of types that a file sees.
    pub fn seen_types(&self, at: Span) -> impl Iterator<Item = &str> {
        let scopes = self
            .scopes
            .get(&at.file)
            .into_iter()
            .chain(self.imported(at));
        scopes.flat_map(|scope| scope.types.keys().map(String::as_str))
    }

    /// Gives a name its meaning in its file, once.
    pub fn define(&mut self, name: &Name, symbol: Symbol) {
        let scope = self.scopes.entry(name.span.file).or_default();
        if let Some((_, first)) = scope.symbols.get(&name.text) {
            let finding = Diagnostic::error(
                codes::NAME_DOUBLE,
                name.span,
                format!("`{}` is declared twice", name.text),
            )
            .with_label(*first, "declared here first")
            .with_help("give one of the two another name");
            self.findings.push(finding);
            return;
        }
        scope.symbols.insert(name.text.clone(), (symbol, name.span));
    }
}
