//! `import "Rules.spectra"`: the file, and those that it imports, each read once.
//!
//! An import brings in types, defines, predicates, patterns and regular expressions. Variables,
//! monitors, counters, assumptions and guarantees stay behind, as in Spectra, whose scopes look for
//! them in the file itself. So it does no harm that files import each other in a circle.
//!
//! The file of the published patterns is there also where it is not: see [`dwyer`](super::dwyer).

use super::dwyer;
use super::parser;
use super::syntax::{Declaration, Name};
use crate::Loader;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Maximum number of imported files, including indirect imports.
const MAX_FILES: usize = 64;
/// Maximum number of missing imports; later ones are not searched.
const MAX_MISSED: usize = 64;
/// Files of the language end so.
const ENDING: &str = ".spectra";

/// What an import leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// A file that was read.
    File(FileId),
    /// The published patterns, without a file.
    Published,
}

/// A file's declarations.
#[derive(Debug)]
pub(super) struct Source {
    pub file: FileId,
    pub text: Arc<str>,
    pub declarations: Vec<Declaration>,
    pub imports: Vec<(Target, Span)>,
}

/// What was found: the file itself, then those that it imports.
pub(super) struct Sources {
    pub files: Vec<Source>,
    pub findings: Vec<Diagnostic>,
    missed: usize,
}

/// Parses a file and all that it imports.
pub(super) fn gather(file: FileId, text: &str, loader: &mut Loader<'_>) -> Sources {
    let mut sources = Sources {
        files: Vec::new(),
        findings: Vec::new(),
        missed: 0,
    };
    sources.add(file, text.into());
    let mut at = 0;
    while at < sources.files.len() {
        let Source {
            file, declarations, ..
        } = &sources.files[at];
        let file = *file;
        let wanted: Vec<(String, Span)> = declarations
            .iter()
            .filter_map(|d| match d {
                Declaration::Import(path, span) => Some((path.clone(), *span)),
                _ => None,
            })
            .collect();
        for (path, span) in wanted {
            let target = sources.import(&path, file, span, loader);
            let imports = &mut sources.files[at].imports;
            // The same file again brings nothing new.
            if let Some(target) = target
                && imports.iter().all(|(known, _)| *known != target)
            {
                imports.push((target, span));
            }
        }
        at += 1;
    }
    sources.left_behind();
    sources
}

impl Sources {
    fn add(&mut self, file: FileId, text: Arc<str>) {
        let (declarations, findings) = parser::parse(file, &text);
        self.findings.extend(findings);
        self.files.push(Source {
            file,
            text,
            declarations,
            imports: Vec::new(),
        });
    }

    fn import(
        &mut self,
        path: &str,
        importer: FileId,
        span: Span,
        loader: &mut Loader<'_>,
    ) -> Option<Target> {
        if self.missed >= MAX_MISSED {
            return None;
        }
        if !path.ends_with(ENDING) {
            self.refuse(
                span,
                format!("`{path}` is not a Spectra file"),
                format!("name a file that ends with `{ENDING}`"),
            );
            return None;
        }
        match loader(path, importer) {
            Ok((file, _)) if self.files.iter().any(|s| s.file == file) => Some(Target::File(file)),
            Ok(_) if self.files.len() > MAX_FILES => {
                self.refuse(
                    span,
                    format!("this would be more than {MAX_FILES} imported files"),
                    "put the declarations of several into one",
                );
                None
            }
            Ok((file, text)) => {
                self.add(file, text);
                Some(Target::File(file))
            }
            Err(_) if path.rsplit(['/', '\\']).next() == Some(dwyer::FILE) => {
                Some(Target::Published)
            }
            Err(why) => {
                self.refuse(
                    span,
                    format!("cannot import `{path}`: {why}"),
                    format!("the path is relative to the file that imports; `{}` is there without a file", dwyer::FILE),
                );
                None
            }
        }
    }

    fn refuse(&mut self, span: Span, message: String, help: impl Into<String>) {
        self.missed += 1;
        self.findings
            .push(Diagnostic::error(codes::IMPORT_MISSING, span, message).with_help(help));
    }

    /// Says of each import what of its file is not used.
    fn left_behind(&mut self) {
        // A file that is imported in a circle is there anyway.
        let others = self.files[1..].iter();
        let left: BTreeMap<FileId, usize> = others
            .map(|s| (s.file, s.declarations.iter().filter(|d| stays(d)).count()))
            .collect();
        for (target, span) in self.files.iter().flat_map(|s| &s.imports) {
            let Target::File(file) = target else {
                continue;
            };
            let what = match left.get(file) {
                None | Some(0) => continue,
                Some(1) => "is 1 declaration".to_owned(),
                Some(count) => format!("are {count} declarations"),
            };
            let note = Diagnostic::note(
                codes::OWN_TOOL,
                *span,
                format!("in this file there {what} that an import does not bring in"),
            )
            .with_help("types, defines, predicates, patterns and regular expressions are imported; declare variables, monitors and counters, and write assumptions and guarantees, in this file");
            self.findings.push(note);
        }
    }
}

/// The name of what has a state: a variable, a monitor or a counter.
pub(super) fn state(declaration: &Declaration) -> Option<&Name> {
    match declaration {
        Declaration::Variable(_, variable) => Some(&variable.name),
        Declaration::Monitor(monitor) => Some(&monitor.variable.name),
        Declaration::Counter(counter) => Some(&counter.name),
        _ => None,
    }
}

/// Whether an import leaves this in its file.
fn stays(declaration: &Declaration) -> bool {
    state(declaration).is_some() || matches!(declaration, Declaration::Statement(_))
}
