//! Skill orders: which calls of a machine's skills may follow which.
//!
//! A machine offers *skills* (`Left`, `Down`, `Grip`). Each belongs to a *component* (an axis, a
//! gripper) and leads it into a *situation* (`left`, `down`, `closed`). *Rules* define which calls
//! can follow which; a sequence of calls that satisfies all rules is a *skill order*. The terms,
//! and the levels arbitrary, valid and reasonable, are those of Brandenbourger, Vathoopan and
//! Zoitl, "Modeling and verifying behavioral constraints for automation systems".
//!
//! # Meaning
//!
//! - A [`supervisor::Call`] is one skill, or several at once. Two skills of one component are never
//!   called at once.
//! - Every rule is an automaton over single skills. It refuses the first skill that breaks the
//!   rule, so it is a safety automaton, which a monitor can use. Several rules together are the
//!   product of their automata.
//! - Several skills called at once are allowed if every order of calling them one after the other
//!   is allowed ([`Serialisation::Every`]). The state afterwards is the set of all states to which
//!   these orders lead. With [`Serialisation::Some`], only one order has to be allowed.
//! - An [`Event`] of several skills, `Left & Down`, means that these are called at once. In a rule
//!   with `in a row` or `then`, it occurs where these skills follow each other within one call.
//! - The skills that lead to the initial situation ([`Component::initial`]) count as called where a
//!   rule depends on whether something has been called (`after`, `until`, `before`, `only after`,
//!   `between`): if a unit is up at the start, `Up` has been called. Their order is unknown, so
//!   every order is considered possible. An event of several skills (`Left & Up`) does not count as
//!   called, since the situation does not show which skills were called at once. `at most` does not
//!   count these skills, and the first call does not directly follow one of them.
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

/// Maximum number of skills in a set. It is 64 because a call is a mask of 64 bits.
pub const MAX_SKILLS: usize = 64;

/// Components, their skills, and rules over them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skills {
    /// Name of the set: `PickAndPlaceUnit`.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Components in order of declaration.
    pub components: Vec<Component>,
    /// Skills in order of declaration: those of the first component first. At most [`MAX_SKILLS`].
    pub skills: Vec<Skill>,
    /// Rules in order of declaration.
    pub rules: Vec<Rule>,
    /// Source position of the name.
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

    /// Formats a situation, given by the situation of each component: `left, up, open`.
    pub fn situation_text(&self, situation: &[usize]) -> String {
        let components = self.components.iter().zip(situation);
        let names = components.filter_map(|(c, s)| c.situations.get(*s).map(String::as_str));
        names.collect::<Vec<_>>().join(", ")
    }
}

/// A component that skills move: an axis, a gripper.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    /// Name, such as `gripper`.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Situations; empty for a component that never changes, such as a camera.
    pub situations: Vec<String>,
    /// Initial situation, as an index into [`Component::situations`]; 0 if there are none.
    pub initial: usize,
    /// Source position of the name.
    pub span: Span,
}

/// A skill that can be called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skill {
    /// Name, such as `Grip`.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Component, as an index into [`Skills::components`].
    pub component: usize,
    /// Target situation, as an index into the situations of the component; `None` for a skill that
    /// changes nothing.
    pub effect: Option<usize>,
    /// Source position of the name.
    pub span: Span,
}

/// Strictness of the rules, in ascending order. Each level includes the rules of the lower levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Every call is allowed.
    Arbitrary,
    /// All rules without an explicit level apply.
    Valid,
    /// Recalls are forbidden, and the rules `at reasonable` apply as well.
    Reasonable,
}

impl Level {
    /// All levels, in order.
    pub const ALL: [Self; 3] = [Self::Arbitrary, Self::Valid, Self::Reasonable];

    /// Returns the keyword of the level.
    pub fn keyword(self) -> &'static str {
        match self {
            Self::Arbitrary => "arbitrary",
            Self::Valid => "valid",
            Self::Reasonable => "reasonable",
        }
    }
}

/// Condition under which several skills called at once are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Serialisation {
    /// Every order of calling them one after the other is allowed.
    #[default]
    Every,
    /// At least one order is allowed.
    Some,
}

/// A rule on the order of calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// Name given by the author, or generated from its position: `order 3`.
    pub name: String,
    /// Requirement from which the rule comes, such as `R-12`.
    pub requirement: Option<String>,
    /// Doc comment without slashes.
    pub doc: String,
    /// Lowest level at which the rule applies: valid, or reasonable.
    pub level: Level,
    /// Kind of rule.
    pub kind: Kind,
    /// Transitions that a published model deletes instead of applying this rule; used only if that
    /// model is requested ([`supervisor::Options::paper`]).
    pub deletions: Vec<Deletion>,
    /// Source position of the rule.
    pub span: Span,
    /// Source text, on one line.
    pub text: String,
}

/// A skill, or several at once (`Left & Down`): skills by index, in ascending order, at least one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event(pub Vec<usize>);

/// Condition of a rule. A list of events means any of them; no list is empty unless stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// `never X`
    Never(Vec<Event>),
    /// `after X until Y: never Z`. A call that both ends and begins the window leaves it open.
    After {
        /// Events that open the window.
        from: Vec<Event>,
        /// Events that close the window; if empty, it stays open.
        until: Vec<Event>,
        /// Events that are forbidden in the window.
        never: Vec<Event>,
    },
    /// `X before Y`: no `Y` until there has been an `X`. An event in both lists is always
    /// allowed.
    Before {
        /// Events of which one has to come first.
        first: Vec<Event>,
        /// Events that are forbidden until one of `first` has come.
        then: Vec<Event>,
    },
    /// `X only after Y`: every `X` needs a separate `Y` since the last `X`. An `X` that the initial
    /// situation implies consumes no `Y`.
    OnlyAfter {
        /// Events that need a preceding event.
        what: Vec<Event>,
        /// Events of which one has to precede.
        after: Vec<Event>,
    },
    /// `at most N of X between Y and Z`: from a `Y` to the next `Z` there are at most N. The call
    /// that ends the window is still counted, the one that begins it is not.
    AtMost {
        /// Maximum count.
        count: u32,
        /// Counted events.
        of: Vec<Event>,
        /// Events that begin the count, for the first time and again after each end; empty if the
        /// count begins at the start.
        from: Vec<Event>,
        /// Events that end the count; if empty, it never ends.
        until: Vec<Event>,
    },
    /// `never X then Y then Z`: these must not follow one another directly. `never X twice in a
    /// row` is `X then X`. Every listed word is refused; a word is a list of positions, each with
    /// the events that match there.
    InARow(Vec<Vec<Vec<Event>>>),
    /// `sequence (...)`: the calls are a prefix of a word of this regular expression.
    Sequence(Regex),
}

/// Transitions between situations, selected by conditions (component, situation).
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Deletion {
    /// Conditions on the situation before the transition.
    pub from: Vec<(usize, usize)>,
    /// Conditions on the situation after the transition.
    pub to: Vec<(usize, usize)>,
}
