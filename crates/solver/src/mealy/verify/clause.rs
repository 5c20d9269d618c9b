//! The clauses in the definitions of a correct machine and of a correct counterstrategy.

use std::fmt;

/// A clause in the definition of a correct machine or of a correct counterstrategy.
///
/// The name of a variant names the violation; its documentation states what must hold. Clauses
/// about formulas of the contract carry the name of a violated formula.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Clause {
    /// The ports equal those of the contract: names, domains and order.
    Ports,
    /// A machine has the timing of the contract, a counterstrategy the opposite timing.
    Timing,
    /// Every transition leads to an existing state.
    MissingTarget,
    /// Every transition has one value for each output port.
    OutputCount,
    /// Every value of a transition lies in the domain of its port. The variant carries the name of
    /// a port for which this is violated.
    Domain(String),
    /// Guards refer to existing input ports.
    UnknownInput,
    /// If the machine or counterstrategy moves first, all transitions of a state have the same
    /// values.
    FirstMover,
    /// A counterstrategy has a transition in every state.
    NoTransition,
    /// A machine has a transition for every input that keeps the assumptions.
    MissingTransition,
    /// A machine has at most one transition for every input that keeps the assumptions.
    AmbiguousTransition,
    /// A counterstrategy has a transition for every answer that keeps the guarantees, or, if the
    /// machine moves first, for every answer.
    Unanswered,
    /// A counterstrategy has at most one transition for each of these answers.
    AnsweredTwice,
    /// A machine keeps every guaranteed initial condition, invariant and safety formula.
    Guarantee(String),
    /// A machine meets each of its goals infinitely often in every play that meets all justice
    /// assumptions infinitely often.
    Justice(String),
    /// A counterstrategy keeps every assumed initial condition, invariant and safety formula.
    Assumption(String),
    /// A counterstrategy meets every justice assumption infinitely often.
    StarvedAssumption(String),
    /// No play against a counterstrategy meets all goals of the machine infinitely often.
    MachineWins,
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ports => "the ports differ from those of the contract",
            Self::Timing => "the order of moves differs from the contract",
            Self::MissingTarget => "a transition leads to a state that does not exist",
            Self::OutputCount => "a transition has too few or too many output values",
            Self::Domain(port) => return write!(f, "a value of `{port}` is outside its domain"),
            Self::UnknownInput => "a guard refers to a port that does not exist",
            Self::FirstMover => "the side that moves first gives values that depend on the answer",
            Self::NoTransition => "a state has no transition",
            Self::MissingTransition => "inputs that keep the assumptions have no transition",
            Self::AmbiguousTransition => "two transitions match the same inputs",
            Self::Unanswered => "an answer has no transition",
            Self::AnsweredTwice => "two transitions match the same answer",
            Self::MachineWins => "the machine keeps all guarantees in some play",
            Self::Guarantee(name)
            | Self::Justice(name)
            | Self::Assumption(name)
            | Self::StarvedAssumption(name) => name,
        })
    }
}
