//! Specifications of other tools: gr1c's `.spc`, slugs' `.slugsin` and `.structuredslugs`,
//! Spectra's `.spectra`, and `.tlsf`, the format of LTL synthesis.
//!
//! [`read`] turns a text into a [`Specification`] and findings. [`write`](fn@write) does the
//! reverse for the formats that solvers read, and [`contract::write`] prints a specification as a
//! contract in Linewright's own language. The formats differ much more in syntax than in meaning.
//! Therefore each reader parses its own syntax, but the first three formats share `terms`
//! (operators, shared nodes, limits on size and depth) and `names` (declarations, and which section
//! can refer to which variables).
//!
//! The meaning follows each format's definition, not the behavior of its tool. Where the two
//! differ, [`own_tool`] reports the tool's answer. Sources: `spc_format.md` and the grammar of
//! gr1c 0.13, and `input_formats.md` and the grammar of structured slugs.
//!
//! Spectra and TLSF are languages with declarations and definitions, so their readers build syntax
//! trees and have modules of their own, `spectra` and `tlsf`.
//!
//! The readers are written by hand rather than with pest. Formulas of the first three formats are
//! flat sequences of operands and prefix or infix operators. Explicit stacks read them in linear
//! time and without recursion, however deeply a formula nests. Recursive descent, including
//! pest's, would have to limit the nesting first.

pub mod contract;
mod infix;
mod labels;
pub mod lower;
mod names;
pub mod own_tool;
mod prefix;
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
pub use write::{Target, statement, write};

/// A specification format of another tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// gr1c's format, including its reachability games.
    Spc,
    /// The input format of slugs: Boolean variables, prefix notation.
    Slugsin,
    /// The format that slugs' own translator turns into `.slugsin`: numbers, infix notation.
    StructuredSlugs,
    /// The Spectra language.
    Spectra,
    /// The format of LTL synthesis, restricted to GR(1).
    Tlsf,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 5] = [
        Self::Spc,
        Self::Slugsin,
        Self::StructuredSlugs,
        Self::Spectra,
        Self::Tlsf,
    ];

    /// The format of a file, by the extension of its path; `None` for unknown extensions.
    pub fn from_path(path: &str) -> Option<Self> {
        let (_, ending) = path.rsplit_once('.')?;
        Self::ALL.into_iter().find(|f| f.ending() == ending)
    }

    /// File extension of the format, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Spc => "spc",
            Self::Slugsin => "slugsin",
            Self::StructuredSlugs => "structuredslugs",
            Self::Spectra => "spectra",
            Self::Tlsf => "tlsf",
        }
    }

    /// Name of the tool that defines the format, for messages.
    pub fn tool(self) -> &'static str {
        match self {
            Self::Spc => "gr1c",
            Self::Slugsin | Self::StructuredSlugs => "slugs",
            Self::Spectra => "Spectra",
            Self::Tlsf => "LTL synthesis",
        }
    }
}

/// The result of reading a file.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Format of the file.
    pub format: Format,
    /// The specification in the file; `None` if a finding is an error.
    pub specification: Option<Specification>,
    /// `specification` with only those assumptions that the file itself contains; `None` if there
    /// are no others. The reader moves or adds assumptions to express the file's meaning in GR(1).
    /// Checks of the assumptions' quality have to use this specification.
    pub with_own_assumptions: Option<Arc<Specification>>,
    /// Errors, warnings and notes.
    pub findings: Vec<Diagnostic>,
    /// Whether the file describes a reachability game (`SYSGOAL: <>p;`).
    pub reachability: bool,
    /// The file from its first line with content on, for findings without a more specific location.
    pub span: Span,
}

/// Loads an imported file. The arguments are the path in the import, and the file that contains the
/// import.
///
/// Returns the imported file's id, which is the same on each call, and its text; or the reason why
/// the file cannot be read.
pub type Loader<'a> = dyn FnMut(&str, FileId) -> Result<(FileId, Arc<str>), String> + 'a;

/// Bytes of stack for a reader: the maximum nesting depth times a generous size for each level. The
/// caller's own stack can be smaller.
const STACK: usize = 256 << 20;

/// Reads a text that imports no other files.
///
/// `name` becomes the specification's name. Errors are in [`Reading::findings`]. Importing any file
/// except Spectra's published patterns is an error.
pub fn read(format: Format, name: &str, file: FileId, text: &str) -> Reading {
    let alone = &mut |_: &str, _| Err("no other files are read here".to_owned());
    read_with(format, name, file, text, alone)
}

/// Reads a text and the files that it imports through `loader`; otherwise like [`read`].
pub fn read_with(
    format: Format,
    name: &str,
    file: FileId,
    text: &str,
    loader: &mut Loader<'_>,
) -> Reading {
    let mut names = names::Names::new(name, file, text);
    let mut reachability = false;
    let mut with_own_assumptions = None;
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
            let ((specification, own), findings) = tlsf::read(name, file, text);
            with_own_assumptions = own.map(Arc::new);
            (specification, findings)
        }
    });
    findings.sort_by_key(|f| f.span);
    Reading {
        format,
        with_own_assumptions: with_own_assumptions.filter(|_| !has_errors(&findings)),
        specification: (!has_errors(&findings)).then_some(specification),
        findings,
        reachability,
        span: Span::new(file, heading(format, text), text.len()),
    }
}

/// Offset of the first line with content; in a Spectra file, of the line that names the
/// specification. Findings about the whole file are shown there.
fn heading(format: Format, text: &str) -> usize {
    let mut at = 0;
    let mut first = None;
    for line in text.split_inclusive('\n') {
        let content = line.trim_start_matches(['\u{feff}', ' ', '\t']);
        let start = at + line.len() - content.len();
        at += line.len();
        let content = content.trim_end();
        if content.is_empty() || content.starts_with(['#', '/', '*']) || content.starts_with("--") {
            continue;
        }
        let names = content.starts_with("spec ") || content.starts_with("module ");
        if format != Format::Spectra || names {
            return start;
        }
        first = first.or(Some(start));
    }
    first.unwrap_or_default()
}
