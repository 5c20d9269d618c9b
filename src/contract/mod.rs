//! Names resolved: contracts with their domains and parameters, machines and lines.
//!
//! [`resolve`](mod@resolve) turns syntax trees into a [`Library`]; nothing after it looks at a syntax tree again.

pub mod line;
pub mod machine;

use crate::gr1::Specification;
use crate::source::{SourceMap, Span};
use std::sync::Arc;

/// Everything that was found in some files, names resolved.
#[derive(Debug, Clone, Default)]
pub struct Library {
    /// The files.
    pub sources: SourceMap,
    /// Contracts with their default parameters, in order of file and place.
    pub contracts: Vec<Contract>,
    /// Machines, likewise.
    pub machines: Vec<machine::Machine>,
    /// Lines, likewise.
    pub lines: Vec<line::Line>,
}

/// A code of a standard's taxonomy: `din:4.3.1` or `vdi:Drehen`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TaxonomyCode {
    /// The code, with its standard before the colon.
    pub text: String,
    /// Where it stands.
    pub span: Span,
}

/// A contract with values for all its parameters.
#[derive(Debug, Clone)]
pub struct Contract {
    /// The name.
    pub name: String,
    /// The doc comment, without its slashes.
    pub doc: String,
    /// What it implements.
    pub codes: Vec<TaxonomyCode>,
    /// Parameter values, in order of declaration.
    pub arguments: Vec<(String, i64)>,
    /// Its formulas.
    pub specification: Arc<Specification>,
    /// Where its name stands.
    pub span: Span,
}

/// What reads further files: given the path of an `import`, relative to the importing file's name, and that name, it gives the
/// name to show and the text, or why it cannot.
pub type Loader<'a> = dyn Fn(&str, &str) -> Result<(String, String), String> + 'a;

/// Parses and resolves files (name and text) and all that they import. Never fails: what could not be understood is in the
/// findings, and the library holds the rest.
pub fn load(
    files: &[(String, String)],
    loader: &Loader<'_>,
) -> (Library, Vec<crate::diagnostics::Diagnostic>) {
    let _ = (files, loader);
    todo!("parser and resolver")
}
