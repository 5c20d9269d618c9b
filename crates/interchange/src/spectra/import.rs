//! `import "Rules.spectra"`: reads the imported files, each once.
//!
//! An import includes types, defines, predicates, patterns and regular expressions. As in Spectra,
//! it does not include variables, monitors, counters, assumptions and guarantees. Therefore files
//! can import each other in a cycle.
//!
//! The published patterns can be imported even if their file does not exist; see
//! [`dwyer`](super::dwyer).

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
/// Maximum number of invalid imports; later imports are ignored.
const MAX_MISSED: usize = 64;
/// File extension of the language.
const ENDING: &str = ".spectra";

/// The file that an import refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// A file that was read.
    File(FileId),
    /// The published patterns, without a file.
    Published,
}

/// A parsed file.
#[derive(Debug)]
pub(super) struct Source {
    pub file: FileId,
    pub text: Arc<str>,
    pub declarations: Vec<Declaration>,
    pub imports: Vec<(Target, Span)>,
}

/// The parsed files: the main file, then the imported ones.
pub(super) struct Sources {
    pub files: Vec<Source>,
    pub findings: Vec<Diagnostic>,
    missed: usize,
}

/// Parses a file and all its imports.
pub(super) fn parse_with_imports(file: FileId, text: &str, loader: &mut Loader<'_>) -> Sources {
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
            // A repeated import of a file has no effect.
            if let Some(target) = target
                && imports.iter().all(|(known, _)| *known != target)
            {
                imports.push((target, span));
            }
        }
        at += 1;
    }
    sources.note_omissions();
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
                format!("name a file with the extension `{ENDING}`"),
            );
            return None;
        }
        match loader(path, importer) {
            Ok((file, _)) if self.files.iter().any(|s| s.file == file) => Some(Target::File(file)),
            Ok(_) if self.files.len() > MAX_FILES => {
                self.refuse(
                    span,
                    format!("more than {MAX_FILES} files are imported"),
                    "combine several files into one",
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
                    format!(
                        "write the path relative to the importing file; `{}` needs no file",
                        dwyer::FILE
                    ),
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

    /// Adds a note to each import whose file has declarations that the import does not include.
    fn note_omissions(&mut self) {
        // All declarations of the main file are used, even if a cycle imports it.
        let others = self.files[1..].iter();
        let left: BTreeMap<FileId, usize> = others
            .map(|s| {
                (
                    s.file,
                    s.declarations.iter().filter(|d| is_omitted(d)).count(),
                )
            })
            .collect();
        for (target, span) in self.files.iter().flat_map(|s| &s.imports) {
            let Target::File(file) = target else {
                continue;
            };
            let what = match left.get(file) {
                None | Some(0) => continue,
                Some(1) => "1 declaration".to_owned(),
                Some(count) => format!("{count} declarations"),
            };
            let note = Diagnostic::note(
                codes::OWN_TOOL,
                *span,
                format!("this import does not include {what} of the file"),
            )
            .with_help("imports include types, defines, predicates, patterns and regular expressions; declare variables, monitors and counters, and write assumptions and guarantees, in the importing file");
            self.findings.push(note);
        }
    }
}

/// The name of a variable, a monitor or a counter.
pub(super) fn state_name(declaration: &Declaration) -> Option<&Name> {
    match declaration {
        Declaration::Variable(_, variable) => Some(&variable.name),
        Declaration::Monitor(monitor) => Some(&monitor.variable.name),
        Declaration::Counter(counter) => Some(&counter.name),
        _ => None,
    }
}

/// Whether an import of the file does not include this declaration.
fn is_omitted(declaration: &Declaration) -> bool {
    state_name(declaration).is_some() || matches!(declaration, Declaration::Statement(_))
}
