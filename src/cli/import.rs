//! `linewright import`: converts another tool's specification to a contract.

use super::exit::ExitCode;
use super::options::GlobalOptions;
use super::select::Selection;
use crate::diagnostics::has_errors;
use crate::engine::output;
use crate::interchange::contract;
use clap::Args;
use std::path::PathBuf;

/// The arguments of `import`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright import examples/other-tools/arbiter.spc
    linewright import examples/other-tools/arbiter.slugsin --out arbiter.lw

The contract means the same as the file, so checking either gives the same verdict. Names that the \
language does not accept are replaced, and listed in comments.")]
pub struct Arguments {
    /// A specification for gr1c (.spc), slugs (.slugsin, .structuredslugs) or Spectra (.spectra),
    /// or one in TLSF (.tlsf)
    #[arg(value_name = "FILE")]
    pub file: String,
    /// The file to write; if omitted, the contract is printed to standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let selection = Selection {
        path: arguments.file.clone(),
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
            "{} is not a specification of another tool: give a .spc, .slugsin, .structuredslugs, .spectra or .tlsf file",
            arguments.file
        );
    };
    let sources = &loaded.library.sources;
    let file = std::path::Path::new(&arguments.file);
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let text = contract::write(
        specification,
        &contract::origin(&name, foreign.reading.format),
    );
    let mut findings = loaded.findings.clone();
    match &arguments.out {
        None => console.result(&text)?,
        Some(path) => match output::write(path, &text, &loaded.places) {
            Ok(()) => console.remark(&format!("wrote {}\n", path.display()))?,
            Err(finding) => findings.push(*finding),
        },
    }
    if has_errors(&findings) {
        console.failed("import", sources, &findings)?;
    } else {
        console.findings(sources, &findings)?;
    }
    Ok(options.exit_code(&findings))
}
