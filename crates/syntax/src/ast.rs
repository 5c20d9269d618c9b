//! Syntax trees of the text as written, with places in the file and without name lookup.

mod flow;
mod recipe;
mod skills;
mod time;

pub use flow::{BufferOrder, Copies, Stop, StopChoice};
pub use recipe::{
    ActionKind, CountedName, Dock, Layout, LayoutItem, PartCapacity, Realize, Recipe, RecipeCall,
    RecipeGuard, RecipeItem, RecipePart, RecipeTransition, Resource, ResourceAction, ResourceItem,
    Transport, TransportRoute,
};
pub use skills::{
    Deletion, Event, Order, OrderRule, Regex, RegexKind, Situation, Skill, SkillCalls,
    SkillComponent, SkillItem, SkillSet, Times,
};
pub use time::{Between, Column, Failures, InterruptedWork, Outcome, TimeValue};

use super::binds;
use linewright_core::source::Span;

/// A word and its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// Text of the word.
    pub text: String,
    /// Place of the word.
    pub span: Span,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct File {
    /// Top-level items in source order.
    pub items: Vec<Item>,
    /// Places of all items in source order, including items within others. Outer items come before
    /// inner ones.
    pub places: Vec<Span>,
    /// Paths of the tables that the items name, with their places, in source order.
    pub tables: Vec<Name>,
}

/// A top-level item.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// `import ...`
    Import(Import),
    /// `type ...`
    Type(TypeDecl),
    /// `const ...`
    Const(ConstDecl),
    /// `define ...`
    Define(Define),
    /// `contract ...`
    Contract(Contract),
    /// `machine ...`
    Machine(Machine),
    /// `line ...`
    Line(Line),
    /// `skills ...`
    Skills(SkillSet),
    /// `layout ...`
    Layout(Layout),
    /// `recipe ...`
    Recipe(Recipe),
    /// `realize ...`
    Realize(Realize),
}

/// `import "a.lw"` or `import std.handling.turn`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Import {
    /// Path in quotes, or dotted name.
    pub path: String,
    /// Whether the path was a dotted name.
    pub dotted: bool,
    /// Place of the path.
    pub span: Span,
}

/// `type Command = {none, turn}`
#[derive(Debug, Clone, PartialEq)]
pub struct TypeDecl {
    /// Name of the type.
    pub name: Name,
    /// Definition of the type.
    pub domain: Domain,
}

/// `const PLAN: array[2] of Command = [pick, turn]`
#[derive(Debug, Clone, PartialEq)]
pub struct ConstDecl {
    /// Name of the constant.
    pub name: Name,
    /// Declared type, if any.
    pub domain: Option<Domain>,
    /// Value of the constant.
    pub value: Expr,
}

/// A type as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    /// Kind of type.
    pub kind: DomainKind,
    /// Place of the type.
    pub span: Span,
}

/// Kinds of types.
#[derive(Debug, Clone, PartialEq)]
pub enum DomainKind {
    /// `{none, turn}`
    Labels(Vec<Name>),
    /// `0..n-1`; the string is a unit after the whole range, as in `0..(n-1) mm`.
    Range(Expr, Expr, Option<String>),
    /// `record {x: 0..3, y: 0..3}`
    Record(Vec<(Name, Domain)>),
    /// `array[n] of T`
    Array(Expr, Box<Domain>),
    /// `bool`, `number`, or a declared type.
    Named(Name),
    /// `deg`: a real number with a unit.
    Unit(String),
}

/// `cells: 2..360 = 8`
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name of the parameter.
    pub name: Name,
    /// Type of the parameter.
    pub domain: Domain,
    /// Default value, if any.
    pub default: Option<Expr>,
}

/// `cells = 8`
#[derive(Debug, Clone, PartialEq)]
pub struct Argument {
    /// Name of the parameter.
    pub name: Name,
    /// Value for the parameter.
    pub value: Expr,
}

/// `define near(a, b) = abs(a - b) <= 1`
#[derive(Debug, Clone, PartialEq)]
pub struct Define {
    /// Name of the define.
    pub name: Name,
    /// Formal parameters; empty if the define has none.
    pub formals: Vec<Formal>,
    /// Expression that the define stands for.
    pub value: Expr,
}

/// `i: 0..3` or `i`
#[derive(Debug, Clone, PartialEq)]
pub struct Formal {
    /// Name of the formal parameter.
    pub name: Name,
    /// Declared type, if any.
    pub domain: Option<Domain>,
}

/// `counter waited: 0..20 counts requested resets done`
#[derive(Debug, Clone, PartialEq)]
pub struct Counter {
    /// Name of the counter.
    pub name: Name,
    /// Range of values.
    pub domain: Domain,
    /// Condition under which a step is counted.
    pub counts: Expr,
    /// Condition under which the counter restarts, if any.
    pub resets: Option<Expr>,
}

/// The header of a contract or machine: the text before its brace.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the contract or machine.
    pub name: Name,
    /// Declared parameters.
    pub parameters: Vec<Parameter>,
    /// Taxonomy codes after `implements`.
    pub codes: Vec<Name>,
}

/// `contract ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Contract {
    /// Documentation, name, parameters and taxonomy codes.
    pub header: Header,
    /// Whether the contract is declared `moore`.
    pub moore: bool,
    /// Items within the braces.
    pub items: Vec<ContractItem>,
}

/// Owner of the variables in a declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ownership {
    /// `input`
    Input,
    /// `output`
    Output,
    /// `internal`
    Internal,
}

/// An item of a contract.
#[derive(Debug, Clone, PartialEq)]
pub enum ContractItem {
    /// `input a, b: T`
    Variables {
        /// Owner of the variables.
        ownership: Ownership,
        /// Names of the variables.
        names: Vec<Name>,
        /// Type of the variables.
        domain: Domain,
    },
    /// `define a = e`
    Define(Define),
    /// `counter c: 0..9 counts e resets e`
    Counter(Counter),
    /// `assume ...` or `guarantee ...`
    Formula {
        /// `true` for `guarantee`, `false` for `assume`.
        guarantee: bool,
        /// Name of the formula, if any.
        name: Option<Name>,
        /// Requirement that the formula belongs to, if any.
        requirement: Option<String>,
        /// Asserted formula.
        expr: Expr,
    },
    /// `type ...` within a contract.
    Type(TypeDecl),
    /// `const ...` within a contract.
    Const(ConstDecl),
}

/// An expression or formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// Kind of expression.
    pub kind: ExprKind,
    /// Place of the expression.
    pub span: Span,
}

impl Expr {
    /// Returns the direct subexpressions in source order, except those of a quantifier's type.
    pub fn children(&self) -> Vec<&Self> {
        match &self.kind {
            ExprKind::Unknown
            | ExprKind::Bool(_)
            | ExprKind::Int(_)
            | ExprKind::Quantity(..)
            | ExprKind::Path(_) => Vec::new(),
            ExprKind::Index(a, b)
            | ExprKind::Binary(_, a, b)
            | ExprKind::Since(a, b)
            | ExprKind::Until(_, a, b)
            | ExprKind::Past(_, a, Some(b)) => vec![a, b],
            ExprKind::Next(a)
            | ExprKind::Always(a)
            | ExprKind::Eventually(a)
            | ExprKind::Not(a)
            | ExprKind::Neg(a)
            | ExprKind::Field(a, _)
            | ExprKind::Past(_, a, None)
            | ExprKind::Quantifier(_, _, _, a) => vec![a],
            ExprKind::If(a, b, c) | ExprKind::Within(a, b, c) => vec![a, b, c],
            ExprKind::Call(_, list) | ExprKind::List(list) => list.iter().collect(),
            ExprKind::Record(members) => members.iter().map(|m| &m.value).collect(),
            ExprKind::Pattern(pattern) => pattern.children(),
            ExprKind::Member(a, list) => std::iter::once(&**a).chain(list).collect(),
        }
    }

    /// Calls `visit` with every dotted name that occurs, including those that are called.
    pub fn for_each_path<'a>(&'a self, visit: &mut impl FnMut(&'a [Name])) {
        let mut open = vec![self];
        while let Some(e) = open.pop() {
            match &e.kind {
                ExprKind::Path(names) => visit(names),
                ExprKind::Call(name, _) => visit(std::slice::from_ref(name)),
                _ => {}
            }
            open.extend(e.children());
        }
    }
}

/// Kinds of expressions.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// An expression that could not be built, such as a number that is too large. The parser has
    /// reported it; later stages must not report anything that depends on it.
    Unknown,
    /// `true`
    Bool(bool),
    /// `17`
    Int(i64),
    /// `0.5 m`: the number and its unit, which is empty for a bare number such as `0.5`.
    Quantity(f64, String),
    /// `cell.command`
    Path(Vec<Name>),
    /// `a[i]`
    Index(Box<Expr>, Box<Expr>),
    /// `next e`
    Next(Box<Expr>),
    /// `always f`
    Always(Box<Expr>),
    /// `eventually f`
    Eventually(Box<Expr>),
    /// `not f`
    Not(Box<Expr>),
    /// `-e`
    Neg(Box<Expr>),
    /// An operator with two operands.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `if c then a else b`
    If(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `forall i in D: e`
    Quantifier(Quantifier, Name, Box<Domain>, Box<Expr>),
    /// `min(a, b)`
    Call(Name, Vec<Expr>),
    /// `[a, b]`
    List(Vec<Expr>),
    /// `x in {a, b}`
    Member(Box<Expr>, Vec<Expr>),
    /// `x in 0..3`
    Within(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `cells[2].x`
    Field(Box<Expr>, Name),
    /// `{x = 0, y = 1}`
    Record(Vec<Argument>),
    /// `once e`, `once e within 5 steps`
    Past(PastOp, Box<Expr>, Option<Box<Expr>>),
    /// `a since b`
    Since(Box<Expr>, Box<Expr>),
    /// `a until b`, `a unless b`, `a release b`: never GR(1), whatever its operands.
    Until(UntilOp, Box<Expr>, Box<Expr>),
    /// `s responds to p`, `never p after q`
    Pattern(Pattern),
}

/// A past operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PastOp {
    /// The operand held in the previous step.
    Previous,
    /// The operand holds in this step or held in an earlier one.
    Once,
    /// The operand holds in this step and held in all earlier ones.
    Historically,
}

impl PastOp {
    /// Returns the keyword.
    pub fn word(self) -> &'static str {
        match self {
            Self::Previous => "previous",
            Self::Once => "once",
            Self::Historically => "historically",
        }
    }
}

/// A binary operator of linear temporal logic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UntilOp {
    /// `p until q`: p holds until q does, and q must occur.
    Strong,
    /// `p unless q`, `p W q`: p holds until q does, or for ever.
    Weak,
    /// `p release q`, `p R q`: q holds up to and including the first p, or for ever.
    Release,
}

impl UntilOp {
    /// Returns the keyword.
    pub fn word(self) -> &'static str {
        match self {
            Self::Strong => "until",
            Self::Weak => "unless",
            Self::Release => "release",
        }
    }
}

/// A specification pattern with its scope (Dwyer, Avrunin and Corbett, Patterns in Property
/// Specifications, 1999).
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Condition that has to hold within the scope.
    pub kind: PatternKind,
    /// Maximum number of steps, from `within n steps`.
    pub bound: Option<Box<Expr>>,
    /// Steps of the run to which the pattern applies.
    pub scope: Scope,
}

/// Condition of a pattern.
#[derive(Debug, Clone, PartialEq)]
pub enum PatternKind {
    /// `never p`
    Absence(Box<Expr>),
    /// `eventually p`
    Existence(Box<Expr>),
    /// `always p`
    Universality(Box<Expr>),
    /// `s precedes p`
    Precedence(Box<Expr>, Box<Expr>),
    /// `s responds to p`
    Response(Box<Expr>, Box<Expr>),
}

impl PatternKind {
    /// Creates a pattern from this condition, a bound and a scope.
    pub fn in_scope(self, bound: Option<Box<Expr>>, scope: Scope) -> Pattern {
        Pattern {
            kind: self,
            bound,
            scope,
        }
    }
}

/// Steps of a run to which a pattern applies.
#[derive(Debug, Clone, PartialEq)]
pub enum Scope {
    /// The whole run.
    Globally,
    /// `before r`: up to the first step with r, if there is one.
    Before(Box<Expr>),
    /// `after q`: from the first step with q.
    After(Box<Expr>),
    /// `between q and r`: from each q up to the next r, if there is one.
    Between(Box<Expr>, Box<Expr>),
    /// `after q until r`: from each q up to the next r, or to the end of the run if no r follows.
    AfterUntil(Box<Expr>, Box<Expr>),
}

impl Pattern {
    /// Returns the direct subexpressions in source order.
    pub fn children(&self) -> Vec<&Expr> {
        let mut list: Vec<&Expr> = match &self.kind {
            PatternKind::Absence(p) | PatternKind::Existence(p) | PatternKind::Universality(p) => {
                vec![p]
            }
            PatternKind::Precedence(s, p) | PatternKind::Response(s, p) => vec![s, p],
        };
        list.extend(self.bound.as_deref());
        match &self.scope {
            Scope::Globally => {}
            Scope::Before(q) | Scope::After(q) => list.push(q),
            Scope::Between(q, r) | Scope::AfterUntil(q, r) => list.extend([&**q, &**r]),
        }
        list
    }
}

/// A binary operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are standard")]
pub enum BinaryOp {
    Iff,
    Implies,
    Or,
    Xor,
    And,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    Add,
    Sub,
    Mul,
    Div,
    Mod,
}

impl BinaryOp {
    /// Returns the operator's keyword or symbol.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Iff => "<->",
            Self::Implies => "->",
            Self::Or => "or",
            Self::Xor => "xor",
            Self::And => "and",
            Self::Eq => "=",
            Self::Ne => "!=",
            Self::Lt => "<",
            Self::Le => "<=",
            Self::Gt => ">",
            Self::Ge => ">=",
            Self::Add => "+",
            Self::Sub => "-",
            Self::Mul => "*",
            Self::Div => "/",
            Self::Mod => "mod",
        }
    }

    /// Returns whether grouping does not matter, so that a chain can be built as a balanced tree.
    pub fn is_associative(self) -> bool {
        match self {
            Self::Iff | Self::Or | Self::Xor | Self::And | Self::Add | Self::Mul => true,
            Self::Implies
            | Self::Eq
            | Self::Ne
            | Self::Lt
            | Self::Le
            | Self::Gt
            | Self::Ge
            | Self::Sub
            | Self::Div
            | Self::Mod => false,
        }
    }

    /// Returns whether the operands are conditions, and never numbers. These operators bind more
    /// weakly than comparisons.
    pub fn is_logical(self) -> bool {
        binds::of(self) < binds::COMPARISON
    }
}

/// How the values of a quantified expression are combined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantifier {
    /// Whether all values are true.
    Forall,
    /// Whether at least one value is true.
    Exists,
    /// Number of true values.
    Count,
    /// Sum of the values.
    Sum,
    /// Array of all values.
    Array,
}

/// `machine ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Documentation, name, parameters and taxonomy codes.
    pub header: Header,
    /// Items within the braces.
    pub items: Vec<MachineItem>,
}

/// A declaration `name: T = e`.
#[derive(Debug, Clone, PartialEq)]
pub struct TypedDecl {
    /// Doc comment without slashes.
    pub doc: String,
    /// Declared name.
    pub name: Name,
    /// Declared type.
    pub domain: Domain,
    /// Values after `=`: none, one, or several for a script.
    pub values: Vec<Expr>,
}

/// An item of a machine.
#[derive(Debug, Clone, PartialEq)]
pub enum MachineItem {
    /// `step 1 s`
    Step(Expr),
    /// `idle power 20 W`
    IdlePower(Expr),
    /// `power 150 W`
    Power(Expr),
    /// `limit 500 steps`
    Limit(Expr),
    /// `failures mtbf 8 h mttr 5 min`
    Failures(Failures),
    /// `property ...`
    Property(TypedDecl),
    /// `parameter ...`
    Parameter(TypedDecl),
    /// `signal ...`
    Signal(TypedDecl),
    /// `abstract ...`
    Abstract(TypedDecl),
    /// `coordinator ...`, `action ...` or `machine name: ...`
    Component(Component),
    /// `operation ...`
    Operation {
        /// Name of the operation.
        name: Name,
        /// Taxonomy codes after `implements`.
        codes: Vec<Name>,
        /// Actions, each with the inputs that the operation sets.
        sequence: Vec<OperationCall>,
    },
    /// `done e`
    Done(Expr),
    /// `write p = e` or `write p[i] = e`
    Write {
        /// Name of the property.
        name: Name,
        /// Index of an array element.
        index: Option<Expr>,
        /// Value to write.
        value: Expr,
    },
    /// `skills Set at level { ... }`
    Skills(SkillCalls),
    /// `refines Contract(...) { ... }`, represented as a component that is named after the
    /// contract.
    Refines(Component),
    /// `guarantee ...`
    Guarantee {
        /// Name of the formula, if any.
        name: Option<Name>,
        /// Requirement that the formula belongs to, if any.
        requirement: Option<String>,
        /// Guaranteed formula.
        expr: Expr,
    },
    /// `const ...`
    Const(ConstDecl),
    /// `type ...`
    Type(TypeDecl),
}

/// Role of a component in its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// `coordinator ...`
    Coordinator,
    /// `action ...`
    Action,
    /// `machine ...`: an inner machine.
    Machine,
}

/// `action turn: Turn(cells = 8) when ... { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Role in the machine.
    pub role: Role,
    /// Name of the component.
    pub name: Name,
    /// Name of the contract or inner machine.
    pub contract: Name,
    /// Arguments of the contract or inner machine.
    pub arguments: Vec<Argument>,
    /// Condition under which the component is active, if any.
    pub when: Option<Expr>,
    /// `time e`, and whether `per step` was given.
    pub time: Option<(Expr, bool)>,
    /// `power e`
    pub power: Option<Expr>,
    /// `input = e`, `input[2] = e`
    pub bindings: Vec<Binding>,
    /// Whether an item could not be parsed, which was reported.
    pub broken: bool,
}

impl Component {
    /// Returns whether the component is a coordinator.
    pub fn is_coordinator(&self) -> bool {
        self.role == Role::Coordinator
    }

    /// Returns whether the component is an inner machine.
    pub fn is_machine(&self) -> bool {
        self.role == Role::Machine
    }
}

/// `move_a(tx = 1)`
#[derive(Debug, Clone, PartialEq)]
pub struct OperationCall {
    /// Name of the action or operation; dotted for an operation of an inner machine.
    pub name: Name,
    /// Arguments.
    pub arguments: Vec<Argument>,
}

/// `command = cell.command`
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// Name of the input; dotted for a member of a record.
    pub name: Name,
    /// Index of an array element.
    pub index: Option<i64>,
    /// Member of an array's element; dotted if nested.
    pub member: Option<Name>,
    /// Expression that the input is bound to.
    pub value: Expr,
}

/// `line ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the line.
    pub name: Name,
    /// Items within the braces.
    pub items: Vec<LineItem>,
    /// Second word of each statement that could not be parsed, in the line or its stations: the
    /// declared name, if the statement is a declaration. Uses of these names cause no further
    /// findings.
    pub unparsed: Vec<String>,
}

/// `2 Brick`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartCount {
    /// Number of pieces.
    pub count: u64,
    /// Name of the counted part type.
    pub name: Name,
}

/// An item of a line.
#[derive(Debug, Clone, PartialEq)]
pub enum LineItem {
    /// `part ...`
    Part {
        /// Name of the part type.
        name: Name,
        /// Bill of materials; empty if the part is not assembled.
        bill: Vec<PartCount>,
        /// Properties of each part.
        properties: Vec<TypedDecl>,
    },
    /// `product P, Q`
    Product(Vec<Name>),
    /// `source ...`
    Source {
        /// Name of the source.
        name: Name,
        /// Part type that the source makes.
        part: Name,
        /// When the source makes parts.
        supply: Supply,
        /// Maximum number of parts from this source that can be in the line, from
        /// `, at most N in the line`.
        most: Option<u64>,
    },
    /// `store ...`
    Store {
        /// Name of the store.
        name: Name,
        /// Stock at the start of a run.
        stock: Vec<PartCount>,
    },
    /// `sink ...`
    Sink {
        /// Name of the sink.
        name: Name,
        /// Whether the sink takes rejected parts.
        rejects: bool,
        /// Source that makes replacements for rejected parts, if any.
        reorder: Option<Name>,
    },
    /// `buffer ...`
    Buffer {
        /// Name of the buffer.
        name: Name,
        /// Capacity in parts.
        capacity: u64,
        /// Which part leaves first, if it is not the one that came first.
        order: Option<BufferOrder>,
        /// Minimum time of a part in the buffer, if any.
        dwell: Option<TimeValue>,
        /// Maximum time of a part in the buffer, if any.
        shelf_life: Option<Expr>,
    },
    /// `conveyor ...`
    Conveyor {
        /// Name of the conveyor.
        name: Name,
        /// Machine with arguments, if any.
        machine: Option<(Name, Vec<Argument>)>,
        /// Options `places`, `pitch`, `speed` and `power`.
        options: Vec<(Name, Expr)>,
    },
    /// `station ...`
    Station {
        /// Name of the station.
        name: Name,
        /// Machine with arguments; `None` for a station that is given by its times.
        machine: Option<(Name, Vec<Argument>)>,
        /// Number of such stations, if given.
        times: Option<Copies>,
        /// Items within the braces.
        items: Vec<StationItem>,
    },
    /// `route ...`
    Route {
        /// Part type.
        part: Name,
        /// Stops along the route, in order.
        stops: Vec<Stop>,
        /// Condition under which a part takes the route, if any.
        when: Option<Expr>,
    },
    /// `requirement ...`
    Requirement {
        /// Name of the requirement.
        name: Name,
        /// Name of the metric.
        metric: Name,
        /// Station to which the metric belongs; `None` if it belongs to the line.
        of: Option<Name>,
        /// Comparison operator.
        op: BinaryOp,
        /// Value that the metric is compared with.
        bound: Expr,
        /// Whether the bound is `per hour`.
        per_hour: bool,
        /// Place of the whole requirement.
        span: Span,
    },
    /// `shift ...`
    Shift(Shift),
    /// `start 2026-11-30`: the date as it is written.
    Start(Name),
    /// `holiday 2026-12-24`, or `holiday 2026-12-24 to 2026-12-26`: the dates as they are written.
    Holiday(Name, Option<Name>),
    /// `limit e`, and whether its unit is `products`.
    Limit(Expr, bool),
    /// `const ...`
    Const(ConstDecl),
}

/// `shift 6 h to 14 h on Monday to Friday break 9 h to 9.25 h finish work`
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// Times of day at which work begins and ends.
    pub hours: Hours,
    /// Weekdays; empty for all days.
    pub days: Vec<Days>,
    /// Breaks.
    pub breaks: Vec<Hours>,
    /// Whether stations finish the work that they have begun.
    pub finish_work: bool,
}

/// `6 h to 14 h`: times of day.
#[derive(Debug, Clone, PartialEq)]
pub struct Hours {
    /// Beginning.
    pub from: Expr,
    /// End.
    pub to: Expr,
    /// Place of the two times.
    pub span: Span,
}

/// `Monday`, or `Monday to Friday`
#[derive(Debug, Clone, PartialEq)]
pub struct Days {
    /// First day.
    pub first: Name,
    /// Last day; `None` for a single day.
    pub last: Option<Name>,
}

impl Days {
    /// Place of the days.
    pub fn span(&self) -> Span {
        self.first
            .span
            .to(self.last.as_ref().unwrap_or(&self.first).span)
    }
}

impl Shift {
    /// The times of day of the shift and of its breaks.
    pub fn expressions(&self) -> impl Iterator<Item = &Expr> {
        let hours = std::iter::once(&self.hours).chain(&self.breaks);
        hours.flat_map(|hours| [&hours.from, &hours.to])
    }
}

/// When a source makes parts.
#[derive(Debug, Clone, PartialEq)]
pub enum Supply {
    /// `on order`
    OnOrder,
    /// `every [random] e [limit n]`
    Every {
        /// Time between two parts.
        interval: TimeValue,
        /// Whether the time is exponentially distributed with this mean.
        random: bool,
        /// Maximum number of parts in total.
        limit: Option<u64>,
    },
    /// `at "orders.csv" column due in min`: one part at each instant of a column.
    At(Column),
}

/// An item of a station.
#[derive(Debug, Clone, PartialEq)]
pub enum StationItem {
    /// `perform a, b(x = 1) on P`
    Perform {
        /// Operations, in order.
        operations: Vec<OperationCall>,
        /// Part type.
        part: Name,
    },
    /// `takes 2 s`, or `takes 2 s a Carton`
    Takes {
        /// Duration of the work.
        duration: TimeValue,
        /// Part type; `None` for all types that leave the station.
        part: Option<Name>,
    },
    /// `sets x = e`, or `sets x[i] = e on P`
    Sets {
        /// Property of the part.
        property: Name,
        /// Index, if the property is an array.
        index: Option<Expr>,
        /// Value after the work.
        value: Expr,
        /// Part type; `None` for all types that have the property.
        part: Option<Name>,
    },
    /// `setup d`
    Setup(TimeValue),
    /// `idle power e`
    IdlePower(Expr),
    /// `power e`
    Power(Expr),
    /// `failures mtbf a mttr b`
    Failures(Failures),
    /// `shift ...`
    Shift(Shift),
    /// `defect on P probability p: one of x becomes e`
    Defect {
        /// Part type.
        part: Name,
        /// Probability of the defect.
        probability: Expr,
        /// Whether `one of` is given, which is allowed for arrays only.
        one_of: bool,
        /// Affected property.
        property: Name,
        /// New value.
        value: Expr,
    },
}
