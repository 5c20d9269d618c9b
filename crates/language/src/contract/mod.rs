//! Name resolution: contracts with their domains and parameters, machines and lines.
//!
//! [`load`] turns files into a [`Library`]; later stages never use a syntax tree.

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

/// Everything declared in some files, names resolved.
#[derive(Debug, Clone, Default)]
pub struct Library {
    /// Source files.
    pub sources: SourceMap,
    /// Contracts with their default parameters, in order of file and place.
    pub contracts: Vec<Contract>,
    /// Machines, in order of file and place.
    pub machines: Vec<machine::Machine>,
    /// Lines, in order of file and place.
    pub lines: Vec<line::Line>,
    /// Sets of skills, in order of file and place.
    pub skills: Vec<Arc<Skills>>,
    /// Contracts that were declared but cannot be used: name and place. The findings give the
    /// reason.
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
    /// Code with its standard before the colon.
    pub text: String,
    /// Place of the code.
    pub span: Span,
}

/// A contract with values for all its parameters.
#[derive(Debug, Clone)]
pub struct Contract {
    /// Name of the contract.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Taxonomy codes that it implements.
    pub codes: Vec<TaxonomyCode>,
    /// Parameter values, in order of declaration.
    pub arguments: Vec<(String, i64)>,
    /// Formulas of the contract.
    pub specification: Arc<Specification>,
    /// Place of its name.
    pub span: Span,
}

/// Reads imported files. Takes the target of an `import` (a path relative to the importing file, or
/// `std.handling.turn` of the bundled library) and the importing file's name; returns the display
/// name and the text, or the reason for failure. Equal names are the same file.
pub type Loader<'a> = dyn Fn(&str, &str) -> Result<(String, String), String> + 'a;
