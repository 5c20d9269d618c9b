//! Names resolved: contracts with their domains and parameters, machines and lines.
//!
//! [`load`] turns files into a [`Library`]; nothing after it looks at a syntax tree again.

mod elaborate;
mod formula;
mod instantiate;
pub mod line;
mod lines;
mod load;
pub mod machine;
mod machines;
mod patterns;
mod routes;
mod scope;
mod shape;
mod skills;
mod units;
mod uses;
mod value;

pub use load::load;
pub use units::{GREATEST_WATTS, LONGEST_SECONDS, SHORTEST_SECONDS, is_duration, is_energy};

use crate::order::Skills;
use linewright_core::gr1::Specification;
use linewright_core::source::{FileId, SourceMap, Span};
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
    /// Sets of skills, likewise.
    pub skills: Vec<Arc<Skills>>,
    /// Contracts that were declared, but cannot be used: the name, and where it stands. The
    /// findings say why.
    pub refused: Vec<(String, Span)>,
    /// Machines that cannot be used.
    pub refused_machines: Vec<(String, Span)>,
    /// Lines that cannot be used.
    pub refused_lines: Vec<(String, Span)>,
    /// Sets of skills that cannot be used.
    pub refused_skills: Vec<(String, Span)>,
    /// Files whose text does not follow the grammar.
    pub unsound: Vec<FileId>,
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

/// What reads further files: given what an `import` names (a path relative to the importing file,
/// or `std.handling.turn` of the bundled library) and the importing file's name, it gives the name
/// to show and the text, or why it cannot. Equal names are the same file.
pub type Loader<'a> = dyn Fn(&str, &str) -> Result<(String, String), String> + 'a;
