//! The files that `synth` and `draw` write: into a folder, or the only one to standard output.

use super::exit::ExitCode;
use super::options::GlobalOptions;
use crate::diagnostics::{Diagnostic, codes, has_errors};
use crate::engine::files::LoadedFiles;
use crate::engine::output;
use crate::source::Span;
use crate::station::is_windows_device;
use std::collections::BTreeMap;
use std::path::Path;

/// Files to be written.
#[derive(Debug, Default)]
pub struct Results {
    /// Names and texts of the files.
    files: Vec<(String, String)>,
    /// Declaration of each file, by the file's name in lower case: some file systems ignore case.
    owners: BTreeMap<String, String>,
}

impl Results {
    /// Fails if there is more than one result and no folder for them.
    pub fn check_count(count: usize, out: Option<&Path>) -> anyhow::Result<()> {
        anyhow::ensure!(
            count <= 1 || out.is_some(),
            "there are {count} results: give an output folder with --out DIR"
        );
        Ok(())
    }

    /// Adds files of a declaration. If one has the name of a file that was already added, adds none
    /// and returns a finding (LW504).
    pub fn add(
        &mut self,
        owner: &str,
        span: Span,
        files: Vec<(String, String)>,
    ) -> Option<Diagnostic> {
        for (name, _) in &files {
            if let Some(other) = self.owners.get(&name.to_lowercase()) {
                let message = format!("`{other}` and `{owner}` would both be written to {name}");
                let help = "rename one of them, or write each into a folder of its own: FILE::NAME --out DIR";
                let finding = Diagnostic::error(codes::OUTPUT_UNWRITABLE, span, message);
                return Some(finding.with_help(help));
            }
        }
        for (name, _) in &files {
            self.owners.insert(name.to_lowercase(), owner.to_owned());
        }
        self.files.extend(files);
        None
    }

    /// Writes the files into a folder, or prints the only one of them, and prints the findings.
    pub fn finish(
        &self,
        command: &str,
        out: Option<&Path>,
        loaded: &LoadedFiles,
        mut findings: Vec<Diagnostic>,
        options: &GlobalOptions,
    ) -> anyhow::Result<ExitCode> {
        let console = options.console();
        let sources = &loaded.library.sources;
        if let Some(folder) = out {
            for (name, text) in &self.files {
                let path = folder.join(name);
                match output::write(&path, text, &loaded.places) {
                    Ok(()) => console.remark(&format!("wrote {}\n", path.display()))?,
                    Err(finding) => findings.push(*finding),
                }
            }
        } else if let [(_, text)] = self.files.as_slice() {
            console.result(text)?;
        }
        if has_errors(&findings) && (self.files.is_empty() || out.is_some()) {
            console.failed(command, sources, &findings)?;
        } else {
            console.findings(sources, &findings)?;
        }
        Ok(options.exit_code(&findings))
    }
}

/// Creates a file name that is valid on every system.
pub fn file_name(name: &str, ending: &str) -> String {
    let mark = if is_windows_device(name) { "_" } else { "" };
    format!("{name}{mark}.{ending}")
}
