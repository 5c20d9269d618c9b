//! Reasons why a command of `order` ends without a result: the rules cannot be loaded, or the
//! automaton is too large.

use crate::automata::bound::BoundExceeded;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::diagnostics::{Diagnostic, codes};
use crate::source::SourceMap;

/// Result of an `order` command.
pub type Outcome = Result<ExitCode, EarlyExit>;

/// Why a command ends without a result.
#[derive(Debug)]
pub enum EarlyExit {
    /// The findings have been printed.
    Reported(ExitCode),
    /// The automaton is too large, or a time limit was reached. Fewer rules always help.
    GaveUp {
        /// The limit that was reached.
        error: BoundExceeded,
        /// What else makes this command's automaton smaller.
        also_helps: Option<&'static str>,
    },
    /// The command could not run.
    Failed(anyhow::Error),
}

impl From<anyhow::Error> for EarlyExit {
    fn from(error: anyhow::Error) -> Self {
        Self::Failed(error)
    }
}

impl EarlyExit {
    /// Converts an exceeded bound to an early exit; `also_helps` is what helps besides fewer
    /// rules.
    pub fn gave_up(also_helps: Option<&'static str>) -> impl Fn(BoundExceeded) -> Self {
        move |error| Self::GaveUp { error, also_helps }
    }

    /// Prints the finding, unless findings have already been printed, and returns the exit code.
    pub fn report(self, command: &str, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
        let (error, also_helps) = match self {
            Self::Reported(code) => return Ok(code),
            Self::Failed(error) => return Err(error),
            Self::GaveUp { error, also_helps } => (error, also_helps),
        };
        let fewer = "fewer rules (--rule NAME, --no-rule NAME) or fewer repetitions in a sequence";
        let advice = match (error, also_helps) {
            (BoundExceeded::Stopped(late), _) => late.remedy().to_owned(),
            (_, Some(also_helps)) => format!("{fewer}, or {also_helps}, make it smaller"),
            (_, None) => format!("{fewer} make it smaller"),
        };
        let message = format!("not decided: {error}");
        let finding = Diagnostic::error(codes::GAVE_UP, None, message).with_help(advice);
        let console = options.console();
        console.failed(command, &SourceMap::default(), &[finding])?;
        Ok(ExitCode::GaveUp)
    }
}
