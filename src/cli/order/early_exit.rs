//! How all commands of `order` end without an answer: the rules cannot be loaded, or the automaton
//! is too large.

use crate::automata::bound::BoundExceeded;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::diagnostics::{Diagnostic, codes};
use crate::source::SourceMap;

/// Result of an `order` command.
pub type Outcome = Result<ExitCode, EarlyExit>;

/// Why a command ends without an answer.
#[derive(Debug)]
pub enum EarlyExit {
    /// The findings have been printed.
    Reported(ExitCode),
    /// The automaton is too large, or the time is up. Fewer rules always help.
    GaveUp {
        /// The limit that was reached.
        error: BoundExceeded,
        /// What else makes this command's automaton smaller.
        besides: Option<&'static str>,
    },
    /// It could not run.
    Failed(anyhow::Error),
}

impl From<anyhow::Error> for EarlyExit {
    fn from(error: anyhow::Error) -> Self {
        Self::Failed(error)
    }
}

impl EarlyExit {
    /// Converts the error of a command to an early exit; `besides` is what helps apart from fewer
    /// rules.
    pub fn gave_up(besides: Option<&'static str>) -> impl Fn(BoundExceeded) -> Self {
        move |error| Self::GaveUp { error, besides }
    }

    /// Prints what has not been printed yet and returns the exit code.
    pub fn report(self, command: &str, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
        let (error, besides) = match self {
            Self::Reported(code) => return Ok(code),
            Self::Failed(error) => return Err(error),
            Self::GaveUp { error, besides } => (error, besides),
        };
        let fewer = "fewer rules (--rule NAME, --no-rule NAME) or fewer repetitions in a sequence";
        let advice = match (error, besides) {
            (BoundExceeded::Late(late), _) => late.remedy().to_owned(),
            (_, Some(besides)) => format!("{fewer}, or {besides}, make it smaller"),
            (_, None) => format!("{fewer} make it smaller"),
        };
        let message = format!("it was not decided: {error}");
        let finding = Diagnostic::error(codes::GAVE_UP, None, message).with_help(advice);
        let console = options.console();
        console.failed(command, &SourceMap::default(), &[finding])?;
        Ok(ExitCode::GaveUp)
    }
}
