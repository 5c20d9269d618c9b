//! Skill orders: which calls of a machine's skills may follow which.
//!
//! A machine offers *skills* (`Left`, `Down`, `Grip`). Each belongs to a *component* (an axis, a
//! gripper) and leads it into a *situation* (`left`, `down`, `closed`). *Rules* define what may
//! follow what; a sequence of calls that keeps all of them is a *skill order*. The terms, and the
//! levels arbitrary, valid and reasonable, are those of Brandenbourger, Vathoopan and Zoitl,
//! "Modeling and verifying behavioral constraints for automation systems".
//!
//! # Meaning
//!
//! - A [`supervisor::Call`] is one skill, or several at once. Two skills of one component are never
//!   called at once.
//! - Every rule is an automaton over single skills that refuses at the first bad one: a safety
//!   automaton over prefixes, so that a monitor can use it. Several rules together are the product
//!   of theirs.
//! - Several skills called at once are allowed if every order of calling them one after the other
//!   is ([`Serialisation::Every`]); afterwards the state is the set of states that some order leads
//!   to. With [`Serialisation::Some`] one order has to be allowed.
//! - An [`Event`] of several skills, `Left & Down`, means that these are called at once. In a row,
//!   it occurs where they follow each other in one call.
//! - The initial situation ([`Component::initial`]) counts as called where a rule asks whether
//!   something has been called (`after`, `until`, `before`, `only after`, `between`): a unit that
//!   starts up has been called `Up`. It does not count as a separate call: `at most` does not count
//!   it, and nothing follows it directly. It is unknown which of two skills of the initial
//!   situation was called last: this is treated as if they had been called at once. No event of
//!   several skills counts as called.
//! - A *recall*, a skill whose component is already in its target situation, is a call like any
//!   other. The level reasonable forbids it.
//!
//! This module is independent of syntax, contracts and machines.

mod expression;
pub mod findings;
pub mod fsm;
pub mod layout;
pub mod lower;
pub mod monitor;
pub mod picture;
pub mod program;
mod renumber;
pub mod rule;
pub mod serial;
pub mod standing;
pub mod strongest;
pub mod supervisor;
pub mod table;

use linewright_automata::regex::Regex;
use linewright_core::source::Span;

/// Maximum number of skills in a set: a call is a mask of 64 bits.
pub const MOST_SKILLS: usize = 64;

/// Components, their skills, and rules over them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skills {
    /// Name of the set: `PickAndPlaceUnit`.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Components in order of declaration.
    pub components: Vec<Component>,
    /// Skills in order of declaration: those of the first component first. At most [`MOST_SKILLS`].
    pub skills: Vec<Skill>,
    /// Rules in order of declaration.
    pub rules: Vec<Rule>,
    /// Place of its name.
    pub span: Span,
}

impl Skills {
    /// Returns the same set with only these rules, by index.
    #[must_use]
    pub fn with_rules(&self, rules: &[usize]) -> Self {
        Self {
            rules: rules.iter().map(|r| self.rules[*r].clone()).collect(),
            ..self.clone()
        }
    }

    /// Formats a situation: `left, up, open`.
    pub fn situation(&self, situation: &[usize]) -> String {
        let components = self.components.iter().zip(situation);
        let names = components.filter_map(|(c, s)| c.situations.get(*s).map(String::as_str));
        names.collect::<Vec<_>>().join(", ")
    }
}

/// A component that skills move: an axis, a gripper.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    /// Name: `gripper`.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Situations; empty for a component that never changes, a camera.
    pub situations: Vec<String>,
    /// Initial situation, as an index into [`Component::situations`]; 0 if there are none.
    pub initial: usize,
    /// Place of its name.
    pub span: Span,
}

/// A skill that can be called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skill {
    /// Name: `Grip`.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Component, as an index into [`Skills::components`].
    pub component: usize,
    /// Target situation, as an index into the component's; `None` for a skill that changes nothing.
    pub effect: Option<usize>,
    /// Place of its name.
    pub span: Span,
}

/// How much is forbidden, in ascending order. A level has all rules of those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Every call is allowed.
    Arbitrary,
    /// All rules without an explicit level are kept.
    Valid,
    /// Recalls are forbidden, and the rules `at reasonable` are kept as well.
    Reasonable,
}

impl Level {
    /// All levels, in order.
    pub const ALL: [Self; 3] = [Self::Arbitrary, Self::Valid, Self::Reasonable];

    /// Returns the keyword of the level.
    pub fn word(self) -> &'static str {
        match self {
            Self::Arbitrary => "arbitrary",
            Self::Valid => "valid",
            Self::Reasonable => "reasonable",
        }
    }
}

/// When several skills called at once are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Serialisation {
    /// If every order of calling them one after the other is allowed.
    #[default]
    Every,
    /// If some order is allowed.
    Some,
}

/// A rule on the order of calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// Name given by the author, or generated from its position: `order 3`.
    pub name: String,
    /// Requirement it comes from, such as `R-12`.
    pub requirement: Option<String>,
    /// Doc comment without slashes.
    pub doc: String,
    /// Lowest level at which it is kept: valid, or reasonable.
    pub level: Level,
    /// Kind of rule.
    pub kind: Kind,
    /// Transitions that a published model deletes for it; they replace the rule if that model is
    /// requested.
    pub deletions: Vec<Deletion>,
    /// Place of the rule.
    pub span: Span,
    /// Source text, in one line.
    pub text: String,
}

/// A skill, or several at once (`Left & Down`): skills by index, in ascending order, at least one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event(pub Vec<usize>);

/// The condition of a rule. A list of events means any of them; none is empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// `never X`
    Never(Vec<Event>),
    /// `after X until Y: never Z`. A call that both ends and begins the window leaves it open.
    After {
        /// Events that begin it.
        from: Vec<Event>,
        /// Events that end it; empty for never.
        until: Vec<Event>,
        /// Events that must not be called in between.
        never: Vec<Event>,
    },
    /// `X before Y`: no `Y` until there has been an `X`. An event in both lists waits for nothing.
    Before {
        /// Events that have to come first.
        first: Vec<Event>,
        /// Events that wait for them.
        then: Vec<Event>,
    },
    /// `X only after Y`: every `X` needs a separate `Y` since the last `X`. An `X` in the initial
    /// situation has used up none.
    OnlyAfter {
        /// Events with the requirement.
        what: Vec<Event>,
        /// Events that are required.
        after: Vec<Event>,
    },
    /// `at most N of X between Y and Z`: from a `Y` to the next `Z` there are at most N. The call
    /// that ends the window is still counted, the one that begins it is not.
    AtMost {
        /// Maximum count.
        count: u32,
        /// Counted events.
        of: Vec<Event>,
        /// Events that begin the count, again after each end; empty if the count begins at the
        /// start.
        from: Vec<Event>,
        /// Events that end it; empty for never.
        until: Vec<Event>,
    },
    /// `never X then Y then Z`: these do not follow one another directly. `never X twice in a row`
    /// is `X then X`. Any of the words is refused, each a list of positions with the events that
    /// match there.
    InARow(Vec<Vec<Vec<Event>>>),
    /// `sequence (...)`: the calls are a prefix of a word of this regular expression.
    Sequence(Regex),
}

/// Transitions between situations, given by the mentioned components: (component, situation).
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Deletion {
    /// Situations before the transition.
    pub from: Vec<(usize, usize)>,
    /// Situations after the transition.
    pub to: Vec<(usize, usize)>,
}
