//! Skills and the orders in which they may be called, as they were written.

use super::{Argument, Name};
use linewright_core::source::Span;

/// `skills PickAndPlaceUnit { ... }`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkillSet {
    /// The doc comment.
    pub doc: String,
    /// Its name.
    pub name: Name,
    /// What stands within.
    pub items: Vec<SkillItem>,
    /// Whether something within could not be understood; it was reported.
    pub broken: bool,
}

/// An item of a set of skills.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SkillItem {
    /// `component ...`
    Component(SkillComponent),
    /// `order ...`
    Order(Order),
}

/// `component x: {left, right} = left { Left -> left ... }`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkillComponent {
    /// The doc comment.
    pub doc: String,
    /// Its name.
    pub name: Name,
    /// Its situations; empty where none were written.
    pub situations: Vec<Name>,
    /// Where it is at the start, if that was written.
    pub initial: Option<Name>,
    /// Its skills.
    pub skills: Vec<Skill>,
    /// Whether a skill could not be understood; it was reported.
    pub broken: bool,
}

/// `Left -> left`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skill {
    /// The doc comment.
    pub doc: String,
    /// Its name.
    pub name: Name,
    /// The situation that it leads to, where one was written.
    pub effect: Option<Name>,
}

/// `order name [requirement] at level: rule deletes ...`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    /// The doc comment.
    pub doc: String,
    /// Its name.
    pub name: Option<Name>,
    /// Its requirement.
    pub requirement: Option<String>,
    /// From which level on it is kept.
    pub level: Option<Name>,
    /// What it says.
    pub rule: OrderRule,
    /// Where that stands.
    pub body: Span,
    /// The transitions that a published model deletes for it.
    pub deletions: Vec<Deletion>,
    /// The whole of it, from its first word.
    pub span: Span,
}

/// `Left & Down`: skills called at once; mostly one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// The skills, as they were written.
    pub skills: Vec<Name>,
}

impl Event {
    /// Where it stands.
    pub fn span(&self) -> Span {
        span_of(&self.skills)
    }
}

/// What an order says. Lists of events mean any of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OrderRule {
    /// `never X`
    Never(Vec<Event>),
    /// `after X until Y: never Z`
    After {
        /// What begins it.
        from: Vec<Event>,
        /// What ends it; empty where nothing was written.
        until: Vec<Event>,
        /// What must not be called meanwhile.
        never: Vec<Event>,
    },
    /// `X before Y`
    Before {
        /// What comes first.
        first: Vec<Event>,
        /// What waits for it.
        then: Vec<Event>,
    },
    /// `X only after Y`
    OnlyAfter {
        /// What needs it.
        what: Vec<Event>,
        /// What is needed.
        after: Vec<Event>,
    },
    /// `at most 2 of X between Y and Z`
    AtMost {
        /// How many, and where that stands.
        count: (u64, Span),
        /// Of what.
        of: Vec<Event>,
        /// What begins and what ends the count, where that was written.
        between: Option<(Vec<Event>, Vec<Event>)>,
    },
    /// `never X twice in a row`
    Twice(Vec<Event>),
    /// `never X then Y then Z`
    InARow(Vec<Vec<Event>>),
    /// `sequence (X Y)*`
    Sequence(Regex),
}

/// A regular expression over skills.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Regex {
    /// What it is.
    pub kind: RegexKind,
    /// Where it stands.
    pub span: Span,
}

/// The kinds of regular expressions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RegexKind {
    /// `()`: the empty word.
    Empty,
    /// `Left`
    Skill(Name),
    /// `.`: any skill.
    Any,
    /// `not Left`, `not (Left | Right)`
    AnyBut(Vec<Name>),
    /// `Left & Down`: in any order, or at once.
    AnyOrder(Vec<Name>),
    /// `Left Down`: one after the other, at least two.
    Concat(Vec<Regex>),
    /// `Left | Right`: one of them, at least two.
    Either(Vec<Regex>),
    /// `Left*`
    Repeat(Box<Regex>, Times),
}

impl Regex {
    /// The expressions directly within.
    pub fn children(&self) -> &[Self] {
        match &self.kind {
            RegexKind::Concat(parts) | RegexKind::Either(parts) => parts,
            RegexKind::Repeat(of, _) => std::slice::from_ref(of),
            RegexKind::Empty
            | RegexKind::Skill(_)
            | RegexKind::Any
            | RegexKind::AnyBut(_)
            | RegexKind::AnyOrder(_) => &[],
        }
    }
}

/// How often, as it was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Times {
    /// `*`
    Any,
    /// `+`
    Some,
    /// `?`
    Maybe,
    /// `{3}`
    Exactly(u64),
    /// `{3,}`
    AtLeast(u64),
    /// `{2,3}`
    Between(u64, u64),
}

impl Times {
    /// The least and the greatest number of times; no greatest where there is no end.
    pub fn bounds(self) -> (u64, Option<u64>) {
        match self {
            Self::Any => (0, None),
            Self::Some => (1, None),
            Self::Maybe => (0, Some(1)),
            Self::Exactly(n) => (n, Some(n)),
            Self::AtLeast(n) => (n, None),
            Self::Between(low, high) => (low, Some(high)),
        }
    }
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Any => f.write_str("*"),
            Self::Some => f.write_str("+"),
            Self::Maybe => f.write_str("?"),
            Self::Exactly(n) => write!(f, "{{{n}}}"),
            Self::AtLeast(n) => write!(f, "{{{n},}}"),
            Self::Between(low, high) => write!(f, "{{{low},{high}}}"),
        }
    }
}

/// `down & left -> right`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Deletion {
    /// From where.
    pub from: Vec<Situation>,
    /// To where.
    pub to: Vec<Situation>,
}

impl Deletion {
    /// Where it stands.
    pub fn span(&self) -> Span {
        let ends = self.from.first().zip(self.to.last());
        ends.map_or_else(Span::default, |(a, b)| a.span().to(b.span()))
    }
}

/// `left`, or `x.left` where several components have a situation of that name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Situation {
    /// The component, where it was written.
    pub component: Option<Name>,
    /// The situation.
    pub label: Name,
}

impl Situation {
    /// Where it stands.
    pub fn span(&self) -> Span {
        let first = self.component.as_ref().unwrap_or(&self.label);
        first.span.to(self.label.span)
    }
}

/// `skills PickAndPlaceUnit at reasonable { Left = ... }` in a machine: when it calls each skill.
#[derive(Debug, Clone, PartialEq)]
pub struct SkillCalls {
    /// The set of skills.
    pub set: Name,
    /// How much is forbidden to the machine.
    pub level: Option<Name>,
    /// Each skill, and when it is being called.
    pub calls: Vec<Argument>,
    /// Whether something within could not be understood; it was reported.
    pub broken: bool,
}

fn span_of(names: &[Name]) -> Span {
    let ends = names.first().zip(names.last());
    ends.map_or_else(Span::default, |(a, b)| a.span.to(b.span))
}
