//! `linewright import`: converts another tool's specification to a contract, and documents of other
//! systems to layouts and recipes.

use super::exit::ExitCode;
use super::options::GlobalOptions;
use super::select::Selection;
use crate::diagnostics::{Diagnostic, has_errors};
use crate::engine::files::is_document;
use crate::engine::output;
use crate::engine::recipes::import::{Imported, import};
use crate::interchange::contract;
use crate::source::SourceMap;
use clap::Args;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The arguments of `import`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright import examples/other-tools/arbiter.spc
    linewright import examples/other-tools/arbiter.slugsin --out arbiter.lw
    linewright import examples/b2mml/cell.xml examples/b2mml/order.xml --out order.lw

The contract means the same as the file, so checking either gives the same verdict. Several \
documents in B2MML give one file; if they have one layout, it asks with `realize` whether each \
recipe can be made there. Names that the language does not accept are replaced, and listed in \
comments.")]
pub struct Arguments {
    /// A specification for gr1c (.spc), slugs (.slugsin, .structuredslugs) or Spectra (.spectra),
    /// or one in TLSF (.tlsf); or documents in B2MML 7 (.xml) with layouts and recipes
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<String>,
    /// The file to write; if omitted, the text is printed to standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let files = &arguments.files;
    if files.iter().all(|f| is_document(Path::new(f))) {
        let Imported {
            sources,
            findings,
            text,
            places,
        } = import(files);
        let result = Converted {
            sources: &sources,
            places: &places,
            findings,
            text,
        };
        return result.finish(arguments, options);
    }
    let [file] = files.as_slice() else {
        anyhow::bail!(
            "only documents in B2MML (.xml) are imported together: give one file of another kind"
        );
    };
    specification(file, arguments, options)
}

/// Imports a specification.
fn specification(
    file: &str,
    arguments: &Arguments,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let selection = Selection {
        path: file.to_owned(),
        name: None,
    };
    let loaded = match selection.load("import", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let read = loaded
        .foreign
        .first()
        .and_then(|f| Some((f, f.reading.specification.as_ref()?)));
    let Some((foreign, specification)) = read else {
        anyhow::bail!(
            "{file} is not a specification of another tool: give a .spc, .slugsin, .structuredslugs, .spectra or .tlsf file, or a B2MML document (.xml)"
        );
    };
    let name = Path::new(file).file_name().unwrap_or_default();
    let origin = contract::origin(&name.to_string_lossy(), foreign.reading.format);
    let result = Converted {
        sources: &loaded.library.sources,
        places: &loaded.places,
        findings: loaded.findings.clone(),
        text: Some(contract::write(specification, &origin)),
    };
    result.finish(arguments, options)
}

/// What was imported.
struct Converted<'a> {
    sources: &'a SourceMap,
    /// Canonical paths of the files, which must not be overwritten.
    places: &'a BTreeSet<PathBuf>,
    findings: Vec<Diagnostic>,
    /// The text, if there is one.
    text: Option<String>,
}

impl Converted<'_> {
    /// Writes or prints the text, and prints the findings.
    fn finish(self, arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
        let console = options.console();
        let mut findings = self.findings;
        match (self.text, &arguments.out) {
            (None, _) => {}
            (Some(text), None) => console.result(&text)?,
            (Some(text), Some(path)) => match output::write(path, &text, self.places) {
                Ok(()) => console.remark(&format!("wrote {}\n", path.display()))?,
                Err(finding) => findings.push(*finding),
            },
        }
        if has_errors(&findings) {
            console.failed("import", self.sources, &findings)?;
        } else {
            console.findings(self.sources, &findings)?;
        }
        Ok(options.exit_code(&findings))
    }
}
