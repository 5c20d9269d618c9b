//! Resolves the names of each file.
//!
//! Visible in a file are its own declarations and the definitions of the files that it imports,
//! but not of their imports. Names in a definition are always resolved in the file of the
//! definition: each name has a location, which includes the file.

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

    /// The meaning of a name at a location: the file's own declaration, or the first imported one.
    pub fn symbol(&self, name: &str, at: Span) -> Option<&(Symbol, Span)> {
        let own = self.scopes.get(&at.file)?.symbols.get(name);
        own.or_else(|| {
            self.imported(at)
                .filter_map(|scope| scope.symbols.get(name))
                .find(|(symbol, _)| symbol.is_definition())
        })
    }

    /// The type called `name` at a location: the file's own declaration, or the first imported one.
    pub fn declared_type(&self, name: &str, at: Span) -> Option<&Rc<TypeName>> {
        let own = self.scopes.get(&at.file)?.types.get(name);
        let found = own.or_else(|| self.imported(at).find_map(|scope| scope.types.get(name)));
        found.map(|(of, _)| of)
    }

    /// The location of a variable, monitor or counter with this name that is not visible at `at`,
    /// because imports do not include it.
    pub fn not_imported(&self, name: &str, at: Span) -> Option<Span> {
        let own = self.scopes.get(&at.file).filter(|_| at.file != self.root);
        let scopes = own.into_iter().chain(self.imported(at));
        let mut found = scopes.filter_map(|scope| scope.not_exported.get(name));
        found.next().copied()
    }

    /// The names of the file and of its imports.
    pub fn visible_names(&self, at: Span) -> impl Iterator<Item = &str> {
        let scopes = self
            .scopes
            .get(&at.file)
            .into_iter()
            .chain(self.imported(at));
        scopes.flat_map(|scope| scope.symbols.keys().map(String::as_str))
    }

    /// The names of types of the file and of its imports.
    pub fn visible_types(&self, at: Span) -> impl Iterator<Item = &str> {
        let scopes = self
            .scopes
            .get(&at.file)
            .into_iter()
            .chain(self.imported(at));
        scopes.flat_map(|scope| scope.types.keys().map(String::as_str))
    }

    /// Declares a name in its file; reports a second declaration.
    pub fn define(&mut self, name: &Name, symbol: Symbol) {
        let scope = self.scopes.entry(name.span.file).or_default();
        if let Some((_, first)) = scope.symbols.get(&name.text) {
            let finding = Diagnostic::error(
                codes::NAME_DUPLICATE,
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
