//! The syntax tree of a TLSF file, before expansion.

use std::ops::Range;

/// An expression of any type; evaluation determines whether it is a number, a set or a formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Tree {
    pub kind: Kind,
    pub range: Range<usize>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    Number(i64),
    Truth(bool),
    /// `otherwise`
    Otherwise,
    /// `_` in a pattern.
    Wild,
    Name(String),
    /// `f(x, y)`
    Call(String, Vec<Tree>),
    /// `b[i]`
    Element(String, Box<Tree>),
    /// `{a, b}`
    Set(Vec<Tree>),
    /// `{a, b .. c}`
    Span(Box<Tree>, Box<Tree>, Box<Tree>),
    Unary(Unary, Box<Tree>),
    /// `X[n]`, `G[n:m]`, `F[n:m]`
    Bounded(Unary, Box<Tree>, Box<Tree>),
    /// `&&[0 <= i < n, j IN S]`
    Big(BigOperator, Vec<Tree>, Box<Tree>),
    /// A chain of `&&`.
    And(Vec<Tree>),
    /// A chain of `||`.
    Or(Vec<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unary {
    Not,
    Next,
    Globally,
    Finally,
    SizeOf,
    Size,
    Min,
    Max,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BigOperator {
    And,
    Or,
    Sum,
    Product,
    Cup,
    Cap,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Times,
    Divide,
    Modulo,
    Plus,
    Minus,
    SetMinus,
    Cap,
    Cup,
    Equal,
    Unequal,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
    Element,
    And,
    Or,
    Implies,
    Equivalent,
    Weak,
    Until,
    Release,
    Pattern,
    Colon,
}

/// A definition: `f(x, y) = guard : value ... otherwise : value`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Definition {
    pub name: String,
    pub place: Range<usize>,
    pub arguments: Vec<String>,
    pub cases: Vec<Tree>,
    /// Whether the definition is under PARAMETERS.
    pub parameter: bool,
}

/// A value of an enumeration, with its codes. A bit of a code is `None` if it can be either 0 or 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Label {
    pub name: String,
    pub place: Range<usize>,
    pub codes: Vec<Vec<Option<bool>>>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Enumeration {
    pub name: String,
    pub place: Range<usize>,
    pub width: usize,
    pub labels: Vec<Label>,
}

/// The type of a signal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Shape {
    Single,
    Bus(Tree),
    Typed(String, Range<usize>),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Signal {
    pub name: String,
    pub place: Range<usize>,
    pub input: bool,
    pub shape: Shape,
}

/// A section of formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Section {
    Initially,
    Preset,
    Require,
    Assume,
    Assert,
    Guarantee,
}

/// A formula of a section, with the section's name as the file spells it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Entry {
    pub section: Section,
    pub heading: String,
    /// Byte range of the section's name.
    pub place: Range<usize>,
    pub tree: Tree,
}

/// The semantics of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Semantics {
    pub moore: bool,
    pub strict: bool,
}

/// A parsed file.
#[derive(Debug, Default)]
pub(super) struct File {
    pub semantics: Option<Semantics>,
    /// Whether the semantics is that of finite runs, which is refused.
    pub finite: bool,
    /// Whether the target is a Moore machine; `None` without a TARGET.
    pub target: Option<bool>,
    pub title: Option<String>,
    pub definitions: Vec<Definition>,
    pub enumerations: Vec<Enumeration>,
    pub signals: Vec<Signal>,
    pub entries: Vec<Entry>,
}
