//! Pages of HTML that commands write.

use super::console::Console;
use super::exit::ExitCode;
use super::options::GlobalOptions;
use crate::diagnostics::Diagnostic;
use crate::engine::files::LoadedFiles;
use crate::engine::output::PendingFile;
use crate::report::html::parts::Origin;
use crate::source::SourceMap;
use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The file of a page, which is written when the command has its result.
#[derive(Debug)]
pub struct PageFile {
    path: PathBuf,
    file: PendingFile,
}

impl PageFile {
    /// Begins the file, if one is wanted. If it cannot be written, prints the finding and returns
    /// the command's exit code.
    pub fn begin(
        path: Option<&Path>,
        loaded: &LoadedFiles,
        command: &str,
        options: &GlobalOptions,
    ) -> anyhow::Result<Result<Option<Self>, ExitCode>> {
        match Self::new(path, &loaded.places) {
            Ok(file) => Ok(Ok(file)),
            Err(finding) => {
                let found = [*finding];
                let sources = &loaded.library.sources;
                options.console().failed(command, sources, &found)?;
                Ok(Err(options.exit_code(&found)))
            }
        }
    }

    /// Begins the file, if one is wanted, so that a file that cannot be written ends the command
    /// before the work.
    ///
    /// # Errors
    /// LW504, as for [`PendingFile::new`].
    pub fn new(
        path: Option<&Path>,
        sources: &BTreeSet<PathBuf>,
    ) -> Result<Option<Self>, Box<Diagnostic>> {
        let Some(path) = path else { return Ok(None) };
        let file = PendingFile::new(path, sources)?;
        Ok(Some(Self {
            path: path.to_owned(),
            file,
        }))
    }

    /// Writes the page and says so; if that fails, prints the finding.
    pub fn write(
        self,
        text: &str,
        console: Console,
        sources: &SourceMap,
    ) -> anyhow::Result<ExitCode> {
        let written = self.file.file().write_all(text.as_bytes());
        if let Err(finding) = self.file.keep(written) {
            console.findings(sources, &[*finding])?;
            return Ok(ExitCode::CannotRun);
        }
        console.remark(&format!("wrote {}\n", self.path.display()))?;
        Ok(ExitCode::Success)
    }
}

/// Where a page comes from: this command, with the files that it read and what it found.
pub fn origin<'a>(
    command: &'a str,
    sources: &'a SourceMap,
    findings: &'a [Diagnostic],
) -> Origin<'a> {
    Origin {
        command,
        version: env!("CARGO_PKG_VERSION"),
        sources,
        findings,
    }
}

/// The command line, quoted for a shell where that is necessary.
pub fn command() -> String {
    quoted(std::env::args().skip(1))
}

fn quoted(arguments: impl Iterator<Item = String>) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_=+.,:/%@".contains(c);
    let quoted = arguments.map(|argument| {
        if !argument.is_empty() && argument.chars().all(is_plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    });
    std::iter::once("linewright".to_owned())
        .chain(quoted)
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_command_can_be_pasted_into_a_shell() {
        let arguments = [
            "run",
            "my line.lw",
            "--set",
            "a.takes='2 s'",
            "--parts",
            "5",
        ];
        assert_eq!(
            quoted(arguments.map(str::to_owned).into_iter()),
            r"linewright run 'my line.lw' --set 'a.takes='\''2 s'\''' --parts 5"
        );
    }
}
