//! How the commands of `order` end before they have an answer. They all do it alike: the rules
//! cannot be loaded, or the automaton is too large.

use crate::automata::bound::BoundExceeded;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;

/// What a command of `order` returns.
pub type Outcome = Result<ExitCode, EarlyExit>;

/// Why a command ends without an answer.
#[derive(Debug)]
pub enum EarlyExit {
    /// The findings have been printed.
    Reported(ExitCode),
    /// The automaton is too large, or the time is up. Fewer rules help every command.
    GaveUp {
        /// Which bound was met.
        error: BoundExceeded,
        /// What else makes the automaton of this command smaller.
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
    /// Turns the error of a command into its early exit; `besides` is what helps beside fewer
    /// rules.
    pub fn gave_up(besides: Option<&'static str>) -> impl Fn(BoundExceeded) -> Self {
        move |error| Self::GaveUp { error, besides }
    }

    /// Prints what has not been printed yet and gives the exit code.
    pub fn report(self, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
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
        options
            .console()
            .remark(&format!("gave up: {error}; {advice}\n"))?;
        Ok(ExitCode::GaveUp)
    }
}
