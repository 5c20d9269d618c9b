//! The clauses in the definitions of a correct machine and a correct counterstrategy, by the way
//! they can be violated.

use std::fmt;

/// The clause that a machine or a counterstrategy violates. If a contract's formula is violated,
/// the clause carries its name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Clause {
    /// Its ports equal those of the contract: names, domains, order.
    Ports,
    /// A machine moves when the contract says, a counterstrategy when the contract's machine does
    /// not.
    Timing,
    /// Every transition leads to an existing state.
    Target,
    /// Every transition gives a value for each port.
    Values,
    /// The values in a transition lie in the domains of their ports; carries the port's name.
    Domain(String),
    /// Guards refer to existing ports.
    Guard,
    /// The side that moves first gives the same values in all transitions of a state.
    First,
    /// A counterstrategy gives something in every state.
    Nothing,
    /// There is a transition for every input that keeps the assumptions.
    Gap,
    /// There is only one such transition.
    Overlap,
    /// A counterstrategy has a transition for every answer that keeps the guarantees, or, if the
    /// machine moves first, for every answer.
    Unanswered,
    /// It has only one such transition.
    AnsweredTwice,
    /// A machine keeps each initial condition, invariant and safety formula that it guarantees.
    Guarantee(String),
    /// A machine meets each of its goals in every play that meets all justice assumptions again and
    /// again.
    Justice(String),
    /// A counterstrategy keeps each initial condition, invariant and safety formula that is
    /// assumed.
    Assumption(String),
    /// It meets each justice assumption again and again.
    Starved(String),
    /// No play against it meets all goals of the machine.
    Won,
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ports => "the ports are not the contract's",
            Self::Timing => "it is not said who answers first as in the contract",
            Self::Target => "a transition leads to a state that does not exist",
            Self::Values => "a transition has too few or too many values",
            Self::Domain(port) => return write!(f, "domain of {port}"),
            Self::Guard => "a guard asks for a port that does not exist",
            Self::First => "what is given first depends on the answer to it",
            Self::Nothing => "a state gives nothing",
            Self::Gap => "no transition for inputs that keep the assumptions",
            Self::Overlap => "two transitions for the same inputs",
            Self::Unanswered => "no transition for an answer",
            Self::AnsweredTwice => "two transitions for the same answer",
            Self::Won => "the machine keeps all guarantees",
            Self::Guarantee(name)
            | Self::Justice(name)
            | Self::Assumption(name)
            | Self::Starved(name) => name,
        })
    }
}
