//! Syntax trees of skills and of the orders of their calls.

use super::{Argument, Name};
use linewright_core::source::Span;

/// `skills PickAndPlaceUnit { ... }`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkillSet {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the set.
    pub name: Name,
    /// Items within the braces.
    pub items: Vec<SkillItem>,
    /// Whether some part could not be parsed; this was reported.
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
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the component.
    pub name: Name,
    /// Situations; empty if none were written.
    pub situations: Vec<Name>,
    /// Initial situation, if written.
    pub initial: Option<Name>,
    /// Skills of the component.
    pub skills: Vec<Skill>,
    /// Whether a skill could not be parsed, which was reported.
    pub broken: bool,
}

/// `Left -> left`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skill {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the skill.
    pub name: Name,
    /// Situation that the skill leads to, if written.
    pub effect: Option<Name>,
}

/// `order name [requirement] at level: rule deletes ...`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the order, if any.
    pub name: Option<Name>,
    /// Requirement that the order belongs to, if any.
    pub requirement: Option<String>,
    /// Lowest level at which the order is enforced, if written.
    pub level: Option<Name>,
    /// Rule of the order.
    pub rule: OrderRule,
    /// Place of the rule.
    pub body: Span,
    /// Transitions that a published model deletes for this order.
    pub deletions: Vec<Deletion>,
    /// Place of the whole order, from its first word.
    pub span: Span,
}

/// `Left & Down`: skills that are called in the same step; usually only one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Skills, in source order.
    pub skills: Vec<Name>,
}

impl Event {
    /// Returns the place of the event.
    pub fn span(&self) -> Span {
        span_of(&self.skills)
    }
}

/// The rule of an order. A list of events stands for any one of its events.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OrderRule {
    /// `never X`
    Never(Vec<Event>),
    /// `after X until Y: never Z`
    After {
        /// Events after which the rule applies.
        from: Vec<Event>,
        /// Events that end the rule's application; empty if omitted.
        until: Vec<Event>,
        /// Events that must not happen in between.
        never: Vec<Event>,
    },
    /// `X before Y`
    Before {
        /// Events that come first.
        first: Vec<Event>,
        /// Events that must not happen before one of `first`.
        then: Vec<Event>,
    },
    /// `X only after Y`
    OnlyAfter {
        /// Events that the rule restricts.
        what: Vec<Event>,
        /// Events of which at least one has to happen first.
        after: Vec<Event>,
    },
    /// `at most 2 of X between Y and Z`
    AtMost {
        /// Maximum number of events, and the place of the number.
        count: (u64, Span),
        /// Counted events.
        of: Vec<Event>,
        /// Events that begin and end the counting, if written.
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
    /// Kind of expression.
    pub kind: RegexKind,
    /// Place of the expression.
    pub span: Span,
}

/// Kinds of regular expressions.
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
    /// `Left & Down`: in any order or in the same step.
    AnyOrder(Vec<Name>),
    /// `Left Down`: a concatenation of at least two expressions.
    Concat(Vec<Regex>),
    /// `Left | Right`: a union of at least two expressions.
    Either(Vec<Regex>),
    /// `Left*`
    Repeat(Box<Regex>, Times),
}

impl Regex {
    /// Returns the direct subexpressions.
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

/// A number of repetitions, as written.
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
    /// Returns the minimum and the maximum number of repetitions; the maximum is `None` if
    /// unbounded.
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
    /// Situations before the transition.
    pub from: Vec<Situation>,
    /// Situations after the transition.
    pub to: Vec<Situation>,
}

impl Deletion {
    /// Returns the place of the deletion.
    pub fn span(&self) -> Span {
        let ends = self.from.first().zip(self.to.last());
        ends.map_or_else(Span::default, |(a, b)| a.span().to(b.span()))
    }
}

/// `left`, or `x.left` if several components have a situation of that name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Situation {
    /// Component, if written.
    pub component: Option<Name>,
    /// Name of the situation.
    pub label: Name,
}

impl Situation {
    /// Returns the place of the situation.
    pub fn span(&self) -> Span {
        let first = self.component.as_ref().unwrap_or(&self.label);
        first.span.to(self.label.span)
    }
}

/// `skills PickAndPlaceUnit at reasonable { Left = ... }` in a machine: the conditions under which
/// the machine calls each skill.
#[derive(Debug, Clone, PartialEq)]
pub struct SkillCalls {
    /// Name of the set.
    pub set: Name,
    /// Level of the rules that the machine obeys, if written.
    pub level: Option<Name>,
    /// Skills, each with the condition under which it is called.
    pub calls: Vec<Argument>,
    /// Whether some part could not be parsed; this was reported.
    pub broken: bool,
}

fn span_of(names: &[Name]) -> Span {
    let ends = names.first().zip(names.last());
    ends.map_or_else(Span::default, |(a, b)| a.span.to(b.span))
}
