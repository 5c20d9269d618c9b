//! Skill orders: which calls of a machine's skills may follow which.
//!
//! A machine offers *skills* (`Left`, `Down`, `Grip`). Each belongs to a *component* (an axis, a
//! gripper) and leads it into a *situation* (`left`, `down`, `closed`). *Rules* say what may follow
//! what; a sequence of calls that keeps all of them is a *skill order*. The terms, and the levels
//! arbitrary, valid and reasonable, are those of Brandenbourger, Vathoopan and Zoitl, "Modeling and
//! verifying behavioral constraints for automation systems".
//!
//! # Meaning
//!
//! - A [`supervisor::Call`] is one skill, or several at once. Two skills of one component are never
//!   called at once.
//! - Every rule is an automaton over single skills that refuses at the first bad one: a safety
//!   automaton over prefixes, so that a monitor can use it. Several rules together are the product
//!   of theirs.
//! - Several skills called at once are allowed when every order of calling them one after the other
//!   is ([`Serialisation::Every`]); what is known afterwards is the set of states that some order
//!   leads to. With [`Serialisation::Some`] one order has to be allowed.
//! - An [`Event`] of several skills, `Left & Down`, means that these are called at once. In a row
//!   it is there where they follow each other in one call.
//! - What stands at the start ([`Component::initial`]) counts as called where a rule asks whether
//!   something has been called (`after`, `until`, `before`, `only after`, `between`): a unit that
//!   stands up has been called `Up`. It does not count as a call of its own: not among those of
//!   `at most`, and nothing follows it directly. Which of two skills that stand was called last is
//!   not known: that is as if they had been called at once. No event of several skills counts as
//!   called.
//! - A *recall*, a skill whose component is already where it leads, is a call like any other. The
//!   level reasonable forbids it.
//!
//! Nothing here knows of syntax, contracts or machines.

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

/// So many skills a set has at most: a call is a mask of 64 bits.
pub const MOST_SKILLS: usize = 64;

/// Components, their skills, and rules over them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skills {
    /// The name: `PickAndPlaceUnit`.
    pub name: String,
    /// The doc comment, without its slashes.
    pub doc: String,
    /// The components in order of declaration.
    pub components: Vec<Component>,
    /// The skills in order of declaration: those of the first component first. At most
    /// [`MOST_SKILLS`].
    pub skills: Vec<Skill>,
    /// The rules in order of declaration.
    pub rules: Vec<Rule>,
    /// Where its name stands.
    pub span: Span,
}

impl Skills {
    /// The same with only these rules, by their places.
    #[must_use]
    pub fn with_rules(&self, rules: &[usize]) -> Self {
        Self {
            rules: rules.iter().map(|r| self.rules[*r].clone()).collect(),
            ..self.clone()
        }
    }

    /// A situation in words: `left, up, open`.
    pub fn situation(&self, situation: &[usize]) -> String {
        let components = self.components.iter().zip(situation);
        let names = components.filter_map(|(c, s)| c.situations.get(*s).map(String::as_str));
        names.collect::<Vec<_>>().join(", ")
    }
}

/// What skills move: an axis, a gripper.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    /// Its name: `gripper`.
    pub name: String,
    /// The doc comment.
    pub doc: String,
    /// Its situations; empty for a component that is always the same, a camera.
    pub situations: Vec<String>,
    /// Where it is at the start, as an index into [`Component::situations`]; 0 where there are
    /// none.
    pub initial: usize,
    /// Where its name stands.
    pub span: Span,
}

/// What can be called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skill {
    /// Its name: `Grip`.
    pub name: String,
    /// The doc comment.
    pub doc: String,
    /// Its component, as an index into [`Skills::components`].
    pub component: usize,
    /// The situation that it leads to, as an index into the component's; `None` for one that
    /// changes nothing.
    pub effect: Option<usize>,
    /// Where its name stands.
    pub span: Span,
}

/// How much is forbidden, from nothing upwards. A level has all rules of those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Every call is allowed.
    Arbitrary,
    /// All rules that say nothing else are kept.
    Valid,
    /// No recall, and the rules that are `at reasonable` are kept as well.
    Reasonable,
}

impl Level {
    /// All of them, in order.
    pub const ALL: [Self; 3] = [Self::Arbitrary, Self::Valid, Self::Reasonable];

    /// The word for it.
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
    /// When every order of calling them one after the other is.
    #[default]
    Every,
    /// When some order is.
    Some,
}

/// One rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// The name the author gave, or one made up from its place: `order 3`.
    pub name: String,
    /// The requirement it comes from, `R-12`.
    pub requirement: Option<String>,
    /// The doc comment.
    pub doc: String,
    /// From which level on it is kept: valid, or reasonable.
    pub level: Level,
    /// What it says.
    pub kind: Kind,
    /// The transitions that a published model deletes for it; they stand in for the rule where that
    /// model is asked for.
    pub deletions: Vec<Deletion>,
    /// Where it stands.
    pub span: Span,
    /// Its source text, in one line.
    pub text: String,
}

/// A skill, or several at once (`Left & Down`): skills by index, in ascending order, at least one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event(pub Vec<usize>);

/// What a rule says. Lists of events mean any of them; none is empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// `never X`
    Never(Vec<Event>),
    /// `after X until Y: never Z`. A call that closes and opens leaves it open.
    After {
        /// What begins it.
        from: Vec<Event>,
        /// What ends it; empty for never.
        until: Vec<Event>,
        /// What must not be called meanwhile.
        never: Vec<Event>,
    },
    /// `X before Y`: no `Y` until there has been an `X`. What is in both lists waits for nothing.
    Before {
        /// What has to come first.
        first: Vec<Event>,
        /// What waits for it.
        then: Vec<Event>,
    },
    /// `X only after Y`: every `X` needs a `Y` of its own, since the last `X`. An `X` that stands
    /// at the start has used up none.
    OnlyAfter {
        /// What needs it.
        what: Vec<Event>,
        /// What is needed.
        after: Vec<Event>,
    },
    /// `at most N of X between Y and Z`: from a `Y` to the next `Z` there are at most so many. The
    /// call that ends this is still counted, the one that begins it is not.
    AtMost {
        /// How many.
        count: u32,
        /// Of what.
        of: Vec<Event>,
        /// What begins the count, anew after each end; empty where the count begins at the start.
        from: Vec<Event>,
        /// What ends it; empty for never.
        until: Vec<Event>,
    },
    /// `never X then Y then Z`: these do not follow one another directly. `never X twice in a row`
    /// is `X then X`. Any of the words is refused, each a list of places with the events that may
    /// stand there.
    InARow(Vec<Vec<Vec<Event>>>),
    /// `sequence (...)`: what is called is the beginning of a word of this regular expression.
    Sequence(Regex),
}

/// Transitions from some situations to others, by the components that are spoken of: (component,
/// situation).
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Deletion {
    /// From where.
    pub from: Vec<(usize, usize)>,
    /// To where.
    pub to: Vec<(usize, usize)>,
}
