//! The syntax tree of a Spectra file, with unresolved names.

use linewright_core::gr1::{BinaryOp, Owner};
use linewright_core::source::Span;

/// A name and its location.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Name {
    pub text: String,
    pub span: Span,
}

/// A formula or a number.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub shape: Shape,
    pub span: Span,
}

#[derive(Debug, Clone)]
pub(super) enum Shape {
    Bool(bool),
    Number(i64),
    /// A variable, define, parameter, constant, ..., with its indices.
    Name(String, Vec<Node>),
    /// A use of a predicate or a pattern.
    Call(Name, Vec<Node>),
    /// `a.all`, `a.sum`, ...
    Array(Name, Vec<Node>, Name),
    Not(Box<Node>),
    Negative(Box<Node>),
    Next(Box<Node>),
    Past(Past, Box<Node>),
    /// `p SINCE q` and `p TRIGGERED q`, from left to right.
    Since(Box<Node>, Vec<(SinceOp, Node)>),
    /// Operators of one precedence, from left to right.
    Chain(Box<Node>, Vec<(BinaryOp, Node)>),
    Implies(Box<Node>, Box<Node>),
    In {
        value: Box<Node>,
        negated: bool,
        items: Vec<Item>,
    },
    Quantified {
        all: bool,
        name: Name,
        domain: TypeName,
        body: Box<Node>,
    },
    /// `regexp(...)`
    Matches(Regexp),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Past {
    Previous,
    Once,
    Historically,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SinceOp {
    Since,
    Triggered,
}

/// A value in `in { ... }`.
#[derive(Debug, Clone)]
pub(super) enum Item {
    One(Node),
    /// `from-to`
    Range(i64, i64, Span),
}

/// A use of a type.
#[derive(Debug, Clone)]
pub(super) struct TypeName {
    pub base: Base,
    /// Sizes of an array's dimensions.
    pub sizes: Vec<Node>,
    pub span: Span,
}

#[derive(Debug, Clone)]
pub(super) enum Base {
    Bool,
    Int(Box<Node>, Box<Node>),
    Labels(Vec<Name>),
    Named(String),
}

#[derive(Debug, Clone)]
pub(super) struct Parameter {
    pub of: TypeName,
    pub name: Name,
}

/// A regular expression over the steps of a run.
#[derive(Debug, Clone)]
pub(super) struct Regexp {
    pub shape: RegexpShape,
    pub span: Span,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RegexpOp {
    /// Concatenation, which has no sign.
    Then,
    /// `&`
    And,
    /// `|`
    Or,
}

#[derive(Debug, Clone)]
pub(super) enum RegexpShape {
    /// `()`
    Empty,
    /// `true`, `false`
    Constant(bool),
    /// `[p]`: one step in which p holds.
    Step(Box<Node>),
    Named(String),
    Complement(Box<Regexp>),
    /// An operand, and further operators with their operands, which group from the left.
    Chain(Box<Regexp>, Vec<(RegexpOp, Regexp)>),
    /// `r* r+ r? r{n} r{n,} r{n,m}`; the upper number is `None` if it is unbounded.
    Repeat(Box<Regexp>, Box<Node>, Option<Box<Node>>),
}

/// When a formula has to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TemporalForm {
    Initially,
    /// `G`: each transition from a step to the next.
    Transition,
    /// `alw`: every step.
    Always,
    /// `GF`
    Repeatedly,
}

/// A formula of an assumption, a guarantee, a monitor or a pattern.
#[derive(Debug, Clone)]
pub(super) struct Clause {
    pub when: TemporalForm,
    /// Whether the temporal operator is written in the file.
    pub explicit: bool,
    pub node: Node,
    /// Location including the operator.
    pub span: Span,
}

#[derive(Debug, Clone)]
pub(super) enum Body {
    Clause(Clause),
    /// `trig r |=> e`
    Trigger(Regexp, Regexp),
    /// `GE`, `GEF`
    Existential(Span),
}

#[derive(Debug, Clone)]
pub(super) struct Statement {
    pub side: Owner,
    pub name: Option<Name>,
    pub parameters: Vec<Parameter>,
    pub body: Body,
    /// Location of the body.
    pub span: Span,
}

/// Behavior of a counter at the end of its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Overflow {
    Keep,
    Refuse,
    Modulo,
}

#[derive(Debug, Clone)]
pub(super) struct Counter {
    pub name: Name,
    pub low: Node,
    pub high: Node,
    pub initial: Vec<Node>,
    pub reset: Vec<Node>,
    pub up: Vec<Node>,
    pub down: Vec<Node>,
    pub overflow: Option<(Overflow, Span)>,
    pub underflow: Option<(Overflow, Span)>,
}

#[derive(Debug, Clone)]
pub(super) struct Pattern {
    pub name: Name,
    pub parameters: Vec<Name>,
    pub variables: Vec<Parameter>,
    pub clauses: Vec<Clause>,
}

#[derive(Debug, Clone)]
pub(super) struct Predicate {
    pub name: Name,
    pub parameters: Vec<Parameter>,
    pub body: Node,
}

#[derive(Debug, Clone)]
pub(super) struct Monitor {
    pub variable: Parameter,
    pub clauses: Vec<Clause>,
}

/// The elements of `define a[2][2] := {{..}, {..}}`.
#[derive(Debug, Clone)]
pub(super) enum Elements {
    One(Node),
    Many(Vec<Elements>, Span),
}

#[derive(Debug, Clone)]
pub(super) struct Define {
    pub name: Name,
    pub sizes: Vec<Node>,
    pub value: Elements,
}

#[derive(Debug, Clone)]
pub(super) enum Declaration {
    Import(String, Span),
    /// Owner, whether the variable is auxiliary, and the variable.
    Variable((Owner, bool), Parameter),
    Type(Name, TypeName),
    Define(Define),
    Predicate(Predicate),
    Pattern(Pattern),
    Monitor(Monitor),
    Counter(Box<Counter>),
    Regexp(Name, Regexp),
    Statement(Statement),
    /// `weight` or `regtest`.
    Ignored(&'static str, Span),
}
