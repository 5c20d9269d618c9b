//! Name resolution: contracts with their domains and parameters, machines, lines, layouts and
//! recipes.
//!
//! [`load`] turns files into a [`Library`]; later stages never use a syntax tree.

pub mod calendar;
pub mod date;
mod definitions;
pub mod distribution;
mod elaborate;
mod formula;
mod instantiate;
pub mod line;
mod lines;
mod load;
pub mod machine;
mod machines;
pub mod metric;
mod patterns;
pub mod picture;
pub mod recipe;
pub mod recipe_tree;
mod recipes;
mod routes;
mod scope;
pub mod set;
mod shape;
mod skills;
mod table;
mod units;
mod uses;
mod value;

pub use definitions::{DefinedValue, Definition};
pub use load::{load, load_with, settable};
pub use routes::{NONE_HOLDS, is_covered};
pub use table::MAX_ROWS;
pub use units::{MAX_SECONDS, MAX_WATTS, MIN_SECONDS, is_duration, is_energy};

use crate::order::Skills;
use linewright_core::gr1::Specification;
use linewright_core::source::{FileId, SourceMap, Span};
use std::collections::BTreeMap;
use std::sync::Arc;

/// All declarations of a set of files, with names resolved.
#[derive(Debug, Clone, Default)]
pub struct Library {
    /// Source files.
    pub sources: SourceMap,
    /// Contracts with their default parameters, in order of file and position.
    pub contracts: Vec<Contract>,
    /// The definitions that each contract uses, by the place of the contract's name.
    pub definitions: BTreeMap<Span, Vec<Definition>>,
    /// Machines, in order of file and position.
    pub machines: Vec<machine::Machine>,
    /// Lines, in order of file and position.
    pub lines: Vec<line::Line>,
    /// Layouts, in order of file and position.
    pub layouts: Vec<recipe::Layout>,
    /// Recipes, in order of file and position.
    pub recipes: Vec<recipe::Recipe>,
    /// What is to be made, in order of file and position, where neither the recipes nor the layout
    /// has errors.
    pub realizations: Vec<recipe::Realization>,
    /// Skill sets, in order of file and position.
    pub skills: Vec<Arc<Skills>>,
    /// Contracts that cannot be used because of errors: name and its source position. The findings
    /// give the reasons.
    pub refused_contracts: Vec<(String, Span)>,
    /// Machines that cannot be used because of errors.
    pub refused_machines: Vec<(String, Span)>,
    /// Lines that cannot be used because of errors.
    pub refused_lines: Vec<(String, Span)>,
    /// Layouts that cannot be used because of errors.
    pub refused_layouts: Vec<(String, Span)>,
    /// Recipes that cannot be used because of errors.
    pub refused_recipes: Vec<(String, Span)>,
    /// Skill sets that cannot be used because of errors.
    pub refused_skills: Vec<(String, Span)>,
    /// Files with syntax errors.
    pub malformed_files: Vec<FileId>,
    /// Tables that statements name; the other sources are text of the language.
    pub tables: Vec<FileId>,
}

impl Library {
    /// Returns the machine that is declared at this place.
    pub fn machine_at(&self, declared: Span) -> Option<&machine::Machine> {
        self.machines.iter().find(|m| m.span == declared)
    }

    /// Returns the layout that is declared at this place.
    pub fn layout_at(&self, declared: Span) -> Option<&recipe::Layout> {
        self.layouts.iter().find(|l| l.span == declared)
    }

    /// Returns the recipe that is declared at this place.
    pub fn recipe_at(&self, declared: Span) -> Option<&recipe::Recipe> {
        self.recipes.iter().find(|r| r.span == declared)
    }

    /// Returns the definitions that the rules of a contract use.
    pub fn definitions_of(&self, contract: &Contract) -> &[Definition] {
        self.definitions
            .get(&contract.span)
            .map_or(&[], Vec::as_slice)
    }
}

/// A code of a standard's taxonomy: `din:4.3.1` or `vdi:Drehen`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TaxonomyCode {
    /// Standard and code, separated by a colon: `din:4.3.1`.
    pub text: String,
    /// Source position of the code.
    pub span: Span,
}

/// A contract with values for all its parameters.
#[derive(Debug, Clone)]
pub struct Contract {
    /// Name of the contract.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Taxonomy codes that the contract implements.
    pub codes: Vec<TaxonomyCode>,
    /// Parameters and their values, in order of declaration.
    pub arguments: Vec<(String, i64)>,
    /// Formulas of the contract.
    pub specification: Arc<Specification>,
    /// Source position of the name.
    pub span: Span,
}

/// Function that reads imported files and tables. Takes the target of an `import` (a path relative
/// to the importing file, or the name of a bundled file such as `std.handling.turn`), or the path
/// of a table, and the name of the importing file. Returns the display name and the text, or the
/// reason for the failure. Files with equal display names are the same file.
pub type Loader<'a> = dyn Fn(&str, &str) -> Result<(String, String), String> + 'a;
