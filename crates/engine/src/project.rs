//! Entry point: files in; verdicts, station libraries and runs out.

use crate::files::{self, LoadedFiles, StandardLibrary};
use crate::libraries;
use crate::machines;
use crate::pipeline::{CheckedContract, Goal, Jobs, Settings};
use crate::simulation::{self, Run, SimulationOptions};
use crate::synthesis::Synthesis;
use indicatif::ProgressBar;
use linewright_core::diagnostics::{Diagnostic, has_errors};
use linewright_language::contract::Library;
use linewright_language::contract::line::Line;
use linewright_language::contract::machine::Machine;
use linewright_station::Toolchain;
use linewright_station::profile::Profile;
use std::fmt;
use std::path::{Path, PathBuf};

/// Declarations read from files, with the settings for solving them.
#[derive(Debug, Default)]
pub struct Project {
    loaded: LoadedFiles,
    /// Solver settings; by default no limits and no cache.
    pub settings: Settings,
}

/// All findings of an operation that failed; at least one of them is an error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProjectError(pub Vec<Diagnostic>);

impl fmt::Display for ProjectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, finding) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{}: {}", finding.code, finding.message)?;
        }
        Ok(())
    }
}

impl std::error::Error for ProjectError {}

impl ProjectError {
    /// Fails if one of the findings is an error.
    fn if_errors(findings: Vec<Diagnostic>) -> Result<(), Self> {
        if has_errors(&findings) {
            Err(Self(findings))
        } else {
            Ok(())
        }
    }
}

impl Project {
    /// Reads a file, or every `.lw` file below a folder, with all imports; `import std...` reads
    /// the bundled library.
    ///
    /// # Errors
    /// Returns the findings if one of them is an error.
    pub fn open(path: &str) -> Result<Self, ProjectError> {
        let loaded = files::load(&[path.to_owned()], &StandardLibrary::default());
        ProjectError::if_errors(loaded.findings.clone())?;
        Ok(Self {
            loaded,
            settings: Settings::default(),
        })
    }

    /// Declarations of the files and their imports.
    pub fn library(&self) -> &Library {
        &self.loaded.library
    }

    /// Warnings and notes from reading the files.
    pub fn findings(&self) -> &[Diagnostic] {
        &self.loaded.findings
    }

    /// Solves every contract, and extracts controllers of small ones; results are in library order.
    pub fn check(&self) -> Vec<CheckedContract> {
        let mut jobs = Jobs::examining();
        let contracts = self.library().contracts.iter();
        let indices: Vec<usize> = contracts
            .map(|c| jobs.add_for(Goal::Small, &c.specification, c.span))
            .collect();
        let checked = jobs.run(&self.settings, &ProgressBar::hidden());
        indices.into_iter().map(|i| checked[i].clone()).collect()
    }

    /// Returns the machine with this name, if there is one.
    pub fn machine(&self, name: &str) -> Option<&Machine> {
        self.library().machines.iter().find(|m| m.name == name)
    }

    /// Returns the line with this name, if there is one.
    pub fn line(&self, name: &str) -> Option<&Line> {
        self.library().lines.iter().find(|l| l.name == name)
    }

    /// Synthesizes a machine's controllers, proves its obligations, and writes its station library
    /// for this computer into a folder. Returns the paths of the files.
    ///
    /// # Errors
    /// Returns the findings if one of them is an error.
    pub fn build(&self, machine: &Machine, folder: &Path) -> Result<Vec<PathBuf>, ProjectError> {
        let synthesis = self.synthesize([machine])?;
        let toolchain = Toolchain::shipping().with_deadline(self.settings.limits.deadline);
        let mut files = Vec::new();
        for machine in synthesis.controlled() {
            let profile = Profile::assumed();
            let written = libraries::build(&machine, &profile, Some(&toolchain), folder, false)
                .map_err(|finding| ProjectError(vec![*finding]))?;
            files.extend(written.files);
        }
        Ok(files)
    }

    /// Synthesizes the controllers of a line's machines, proves the machines' obligations, builds
    /// their station libraries into a folder, and runs the line.
    ///
    /// # Errors
    /// Returns the findings if one of them is an error. Problems during a run are in the run's
    /// findings.
    pub fn run(
        &self,
        line: &Line,
        folder: &Path,
        how: &SimulationOptions,
    ) -> Result<Run, ProjectError> {
        let machines = machines::of_line(line).into_iter().map(|m| &**m);
        let synthesis = self.synthesize(machines)?;
        let controlled: Vec<_> = synthesis.controlled().collect();
        simulation::simulate(line, &controlled, folder, how, None).map_err(ProjectError)
    }

    fn synthesize<'a>(
        &self,
        machines: impl IntoIterator<Item = &'a Machine>,
    ) -> Result<Synthesis<'a>, ProjectError> {
        let synthesis = Synthesis::new(machines, &self.settings, |_| ProgressBar::hidden());
        let mut findings = synthesis.findings();
        for machine in synthesis.controlled() {
            findings.extend(synthesis.judge(&machine, &self.settings));
        }
        ProjectError::if_errors(findings)?;
        Ok(synthesis)
    }
}
