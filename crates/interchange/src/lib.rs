//! Specifications of other tools: gr1c's `.spc`, slugs' `.slugsin` and `.structuredslugs`,
//! Spectra's `.spectra`, and `.tlsf`, the format of LTL synthesis.
//!
//! [`read`] turns a text into a [`Specification`] and findings; [`write`](fn@write) goes the other
//! way for the formats that a solver takes, and [`contract::write`] prints a specification as a
//! contract of our own language. The formats differ in how a formula is written, hardly in what it
//! means, so each reader has its own syntax and shares `terms` (operators, sharing, bounds on size
//! and depth) and `names` (declarations, who may refer to what).
//!
//! The meaning follows each format's definition, not what its tool happens to do; where the two
//! part, [`own_tool`] says what the tool would have answered. Sources: the documents
//! `spc_format.md` and the grammar of gr1c 0.13, and `input_formats.md` and the grammar of
//! structured slugs.
//!
//! Spectra's and TLSF are languages with declarations and definitions, so their readers have
//! folders of their own, `spectra` and `tlsf`, and syntax trees.
//!
//! The readers are written by hand rather than with pest: the first three formats are a list of
//! words, prefix or infix operators between them, and no deeper structure, which explicit stacks
//! read in linear time and without recursion, however deep a formula nests. Recursive descent,
//! pest's included, would need a bound on nesting before it starts.

pub mod contract;
mod infix;
mod labels;
pub mod lower;
mod names;
pub mod own_tool;
mod prefix;
mod rename;
mod slugsin;
mod spc;
mod spectra;
mod structured;
mod terms;
mod tlsf;
mod write;

use linewright_core::diagnostics::{Diagnostic, has_errors};
use linewright_core::gr1::Specification;
use linewright_core::source::{FileId, Span};
use std::sync::Arc;

pub use own_tool::{Inquiry, inquiries};
pub use write::{Target, write};

/// A format of another tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// gr1c's, with its reachability games.
    Spc,
    /// What slugs reads: Boolean variables, prefix notation.
    Slugsin,
    /// What slugs' own translator turns into the former: numbers, infix notation.
    StructuredSlugs,
    /// Spectra's.
    Spectra,
    /// The format of LTL synthesis, as far as it is GR(1).
    Tlsf,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Spc,
        Self::Slugsin,
        Self::StructuredSlugs,
        Self::Spectra,
        Self::Tlsf,
    ];

    /// The format that a file's ending promises.
    pub fn of_path(path: &str) -> Option<Self> {
        let (_, ending) = path.rsplit_once('.')?;
        Self::ALL.into_iter().find(|f| f.ending() == ending)
    }

    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Spc => "spc",
            Self::Slugsin => "slugsin",
            Self::StructuredSlugs => "structuredslugs",
            Self::Spectra => "spectra",
            Self::Tlsf => "tlsf",
        }
    }

    /// The tool whose format it is.
    pub fn tool(self) -> &'static str {
        match self {
            Self::Spc => "gr1c",
            Self::Slugsin | Self::StructuredSlugs => "slugs",
            Self::Spectra => "Spectra",
            Self::Tlsf => "LTL synthesis",
        }
    }
}

/// What was read.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The format.
    pub format: Format,
    /// What the file says; `None` where a finding is an error.
    pub specification: Option<Specification>,
    /// Where some assumptions of the specification are not the file's own, but moved or added to
    /// say in GR(1) what the file means: the specification with the file's own assumptions only.
    /// What is odd about assumptions is to be asked of this one.
    pub own: Option<Arc<Specification>>,
    /// What was found on the way.
    pub findings: Vec<Diagnostic>,
    /// Whether the file describes a reachability game (`SYSGOAL: <>p;`).
    pub reachability: bool,
    /// The whole file, for what is said about no place in particular.
    pub span: Span,
}

/// Finds a file that another one imports, by the path that is written there: its id, the same each
/// time, and its text; or why it cannot be read.
pub type Loader<'a> = dyn FnMut(&str, FileId) -> Result<(FileId, Arc<str>), String> + 'a;

/// Bytes of stack: what the readers' bounds on depth allow times what a level needs, generously.
/// Whoever calls may have less.
const STACK: usize = 256 << 20;

/// Reads a text that imports nothing. `name` becomes the specification's name. Never fails: what
/// could not be understood is in the findings.
pub fn read(format: Format, name: &str, file: FileId, text: &str) -> Reading {
    let alone = &mut |_: &str, _| Err("no other files are read here".to_owned());
    read_with(format, name, file, text, alone)
}

/// Reads a text and the files that it imports.
pub fn read_with(
    format: Format,
    name: &str,
    file: FileId,
    text: &str,
    loader: &mut Loader<'_>,
) -> Reading {
    let mut names = names::Names::new(name, file, text);
    let mut reachability = false;
    let mut own = None;
    let (specification, mut findings) = stacker::grow(STACK, || match format {
        Format::Spectra => spectra::read(name, file, text, loader),
        Format::Spc => {
            reachability = spc::read(&mut names);
            names.finish()
        }
        Format::Slugsin => {
            slugsin::read(&mut names, slugsin::Dialect::Prefix);
            names.finish()
        }
        Format::StructuredSlugs => {
            slugsin::read(&mut names, slugsin::Dialect::Structured);
            names.finish()
        }
        Format::Tlsf => {
            let ((specification, with_own), findings) = tlsf::read(name, file, text);
            own = with_own.map(Arc::new);
            (specification, findings)
        }
    });
    findings.sort_by_key(|f| f.span);
    Reading {
        format,
        own: own.filter(|_| !has_errors(&findings)),
        specification: (!has_errors(&findings)).then_some(specification),
        findings,
        reachability,
        span: Span::new(file, 0, text.len()),
    }
}
