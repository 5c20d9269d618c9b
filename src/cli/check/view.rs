//! The files of a check with their declarations, and whether the declarations are free of errors.

use crate::cli::outline::{self, Declaration, Kind};
use crate::diagnostics::{Diagnostic, codes, has_errors};
use crate::engine::files::LoadedFiles;
use crate::interchange::Format;
use crate::source::{FileId, Span};

/// A file with its declarations and the findings of loading it.
pub(super) struct FileView<'a> {
    pub(super) id: FileId,
    pub(super) name: &'a str,
    pub(super) declarations: Vec<Declaration>,
    pub(super) findings: Vec<&'a Diagnostic>,
    /// Whether the file does not parse, or has an error outside all declarations. No declaration of
    /// such a file is checked.
    pub(super) broken: bool,
}

impl<'a> FileView<'a> {
    pub(super) fn all(loaded: &'a LoadedFiles) -> Vec<Self> {
        let sources = &loaded.library.sources;
        sources
            .files()
            .map(|(id, file)| {
                // A table, or a file that is imported by another tool's file, has no declarations;
                // its errors are errors of the file that reads it.
                let imported = loaded.library.tables.contains(&id)
                    || loaded.foreign(id).is_none() && Format::from_path(&file.name).is_some();
                let declarations = match loaded.foreign(id) {
                    Some(foreign) => vec![Declaration {
                        kind: Kind::Contract,
                        name: foreign.name.clone(),
                        extent: foreign.reading.span,
                    }],
                    None if imported => Vec::new(),
                    None => outline::declarations(sources, id),
                };
                let findings: Vec<&Diagnostic> = loaded
                    .findings
                    .iter()
                    .filter(|f| f.span.is_some_and(|s| s.file == id))
                    .collect();
                let wrong = |f: &&Diagnostic| {
                    let inside = |d: &Declaration| f.span.is_some_and(|s| d.holds(s));
                    has_errors(std::slice::from_ref(*f))
                        && (f.code.id < codes::NAME_UNKNOWN.id || !declarations.iter().any(inside))
                };
                let broken = !imported && findings.iter().any(wrong);
                Self {
                    id,
                    name: &file.name,
                    declarations,
                    findings,
                    broken,
                }
            })
            .collect()
    }

    /// Whether the declaration that contains `name` has no errors.
    pub(super) fn is_sound(&self, name: Span) -> bool {
        let declaration = self.declarations.iter().find(|d| d.holds(name));
        !self.broken && declaration.is_some_and(|d| !has_errors(&self.within(d)))
    }

    /// The findings within a declaration.
    pub(super) fn within(&self, declaration: &Declaration) -> Vec<Diagnostic> {
        self.findings
            .iter()
            .filter(|f| f.span.is_some_and(|s| declaration.holds(s)))
            .map(|f| (*f).clone())
            .collect()
    }

    /// The findings outside all declarations.
    pub(super) fn outside(&self) -> Vec<Diagnostic> {
        let inside = |f: &&&Diagnostic| {
            f.span
                .is_some_and(|s| self.declarations.iter().any(|d| d.holds(s)))
        };
        let outside = self.findings.iter().filter(|f| !inside(f));
        outside.map(|f| (*f).clone()).collect()
    }
}

/// Returns the view of a file; `None` if the check has no such file.
pub(super) fn view<'a, 'b>(files: &'b [FileView<'a>], id: FileId) -> Option<&'b FileView<'a>> {
    files.iter().find(|f| f.id == id)
}
