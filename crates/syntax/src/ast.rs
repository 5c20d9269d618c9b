//! Syntax trees: what was written, with its places, and nothing that has to be looked up.

mod skills;

pub use skills::{
    Deletion, Event, Order, OrderRule, Regex, RegexKind, Situation, Skill, SkillCalls,
    SkillComponent, SkillItem, SkillSet, Times,
};

use linewright_core::source::Span;

/// A word and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// The word.
    pub text: String,
    /// Where it stands.
    pub span: Span,
}

/// A whole file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct File {
    /// Its items, in order.
    pub items: Vec<Item>,
    /// Where they and the items within them stand, each before those within it, all in the order in
    /// which they were written.
    pub places: Vec<Span>,
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
}

/// `import "a.lw"` or `import std.handling.turn`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Import {
    /// The path in quotes, or the dotted name.
    pub path: String,
    /// Whether it was a dotted name.
    pub dotted: bool,
    /// Where the path stands.
    pub span: Span,
}

/// `type Command = {none, turn}`
#[derive(Debug, Clone, PartialEq)]
pub struct TypeDecl {
    /// Its name.
    pub name: Name,
    /// What it stands for.
    pub domain: Domain,
}

/// `const PLAN: array[2] of Command = [pick, turn]`
#[derive(Debug, Clone, PartialEq)]
pub struct ConstDecl {
    /// Its name.
    pub name: Name,
    /// Its type, where it was written.
    pub domain: Option<Domain>,
    /// Its value.
    pub value: Expr,
}

/// A type as it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    /// What it is.
    pub kind: DomainKind,
    /// Where it stands.
    pub span: Span,
}

/// The kinds of types.
#[derive(Debug, Clone, PartialEq)]
pub enum DomainKind {
    /// `{none, turn}`
    Labels(Vec<Name>),
    /// `0..n-1`; the unit is one written behind the range, `0..(n-1) mm`.
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
    /// Its name.
    pub name: Name,
    /// Its type.
    pub domain: Domain,
    /// Its default.
    pub default: Option<Expr>,
}

/// `cells = 8`
#[derive(Debug, Clone, PartialEq)]
pub struct Argument {
    /// The parameter's name.
    pub name: Name,
    /// Its value.
    pub value: Expr,
}

/// `define near(a, b) = abs(a - b) <= 1`
#[derive(Debug, Clone, PartialEq)]
pub struct Define {
    /// Its name.
    pub name: Name,
    /// What it is asked of; empty for a mere name.
    pub formals: Vec<Formal>,
    /// What it stands for.
    pub value: Expr,
}

/// `i: 0..3`, or `i` alone
#[derive(Debug, Clone, PartialEq)]
pub struct Formal {
    /// Its name.
    pub name: Name,
    /// Its type, where it was written.
    pub domain: Option<Domain>,
}

/// `counter waited: 0..20 counts requested resets done`
#[derive(Debug, Clone, PartialEq)]
pub struct Counter {
    /// Its name.
    pub name: Name,
    /// Its values.
    pub domain: Domain,
    /// The steps that are counted.
    pub counts: Expr,
    /// The steps after which it begins anew.
    pub resets: Option<Expr>,
}

/// What stands before the brace of a contract or machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// The doc comment, slashes removed.
    pub doc: String,
    /// The name.
    pub name: Name,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// The codes after `implements`.
    pub codes: Vec<Name>,
}

/// `contract ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Contract {
    /// Name, parameters, codes.
    pub header: Header,
    /// Whether it was declared `moore`.
    pub moore: bool,
    /// What stands within.
    pub items: Vec<ContractItem>,
}

/// Whose variables a declaration introduces.
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
        /// Whose they are.
        ownership: Ownership,
        /// Their names.
        names: Vec<Name>,
        /// Their type.
        domain: Domain,
    },
    /// `define a = e`
    Define(Define),
    /// `counter c: 0..9 counts e resets e`
    Counter(Counter),
    /// `assume ...` or `guarantee ...`
    Formula {
        /// `true` for `guarantee`.
        guarantee: bool,
        /// Its name.
        name: Option<Name>,
        /// Its requirement.
        requirement: Option<String>,
        /// The formula.
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
    /// What it is.
    pub kind: ExprKind,
    /// Where it stands.
    pub span: Span,
}

impl Expr {
    /// The expressions directly within, in the order in which they stand; those of a quantifier's
    /// type are left out.
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

    /// Calls `visit` with every dotted name that occurs, and with those that are called.
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

/// The kinds of expressions.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// What could not be read: the parser has said why, and nothing is concluded from it.
    Unknown,
    /// `true`
    Bool(bool),
    /// `17`
    Int(i64),
    /// `0.5 m`: the number, and its unit or nothing.
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
    /// Two operands.
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
    /// `a until b`, `a unless b`, `a release b`: outside GR(1), whatever stands in it.
    Until(UntilOp, Box<Expr>, Box<Expr>),
    /// `s responds to p`, `never p after q`
    Pattern(Pattern),
}

/// An operator that looks back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PastOp {
    /// In the step before.
    Previous,
    /// In this step or an earlier one.
    Once,
    /// In this step and all earlier ones.
    Historically,
}

impl PastOp {
    /// The operator's word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Previous => "previous",
            Self::Once => "once",
            Self::Historically => "historically",
        }
    }
}

/// An operator of linear temporal logic that joins two formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UntilOp {
    /// `p until q`: p up to a q, which comes.
    Strong,
    /// `p unless q`, `p W q`: the same, or p for ever.
    Weak,
    /// `p release q`, `p R q`: q up to and including the first p, or for ever.
    Release,
}

impl UntilOp {
    /// The operator's word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Strong => "until",
            Self::Weak => "unless",
            Self::Release => "release",
        }
    }
}

/// A specification pattern in its scope (Dwyer, Avrunin and Corbett, Patterns in Property
/// Specifications, 1999).
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// What shall hold.
    pub kind: PatternKind,
    /// Within so many steps.
    pub bound: Option<Box<Expr>>,
    /// Where.
    pub scope: Scope,
}

/// What a pattern asks for.
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
    /// The pattern with a bound and a scope.
    pub fn in_scope(self, bound: Option<Box<Expr>>, scope: Scope) -> Pattern {
        Pattern {
            kind: self,
            bound,
            scope,
        }
    }
}

/// The part of a run in which a pattern is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum Scope {
    /// All of it.
    Globally,
    /// `before r`: up to the first step with r, if there is one.
    Before(Box<Expr>),
    /// `after q`: from the first step with q on.
    After(Box<Expr>),
    /// `between q and r`: from each q up to the r after it, where there is one.
    Between(Box<Expr>, Box<Expr>),
    /// `after q until r`: the same, and also where no r follows.
    AfterUntil(Box<Expr>, Box<Expr>),
}

impl Pattern {
    /// The expressions directly within, in the order in which they stand.
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

/// Operators with two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
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
    /// The operator's word or sign.
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
}

/// What is done with the values of a quantified expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantifier {
    /// All hold.
    Forall,
    /// One holds.
    Exists,
    /// How many hold.
    Count,
    /// Their sum.
    Sum,
    /// All of them, as an array.
    Array,
}

/// `machine ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name, parameters, codes.
    pub header: Header,
    /// What stands within.
    pub items: Vec<MachineItem>,
}

/// A declaration `name: T = e`.
#[derive(Debug, Clone, PartialEq)]
pub struct Typed {
    /// The doc comment.
    pub doc: String,
    /// The name.
    pub name: Name,
    /// The type.
    pub domain: Domain,
    /// The values; none, one, or a script's many.
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
    Failures(Expr, Expr),
    /// `property ...`
    Property(Typed),
    /// `parameter ...`
    Parameter(Typed),
    /// `signal ...`
    Signal(Typed),
    /// `abstract ...`
    Abstract(Typed),
    /// `coordinator ...`, `action ...` or `machine name: ...`
    Component(Component),
    /// `operation ...`
    Operation {
        /// Its name.
        name: Name,
        /// The codes after `implements`.
        codes: Vec<Name>,
        /// Its actions, each with the inputs that the operation sets.
        sequence: Vec<Performed>,
    },
    /// `done e`
    Done(Expr),
    /// `write p = e` or `write p[i] = e`
    Write {
        /// The property.
        name: Name,
        /// The element of an array.
        index: Option<Expr>,
        /// The value.
        value: Expr,
    },
    /// `skills Set at level { ... }`
    Skills(SkillCalls),
    /// `refines Contract(...) { ... }`: a component that is called like its contract.
    Refines(Component),
    /// `guarantee ...`
    Guarantee {
        /// Its name.
        name: Option<Name>,
        /// Its requirement.
        requirement: Option<String>,
        /// The formula.
        expr: Expr,
    },
    /// `const ...`
    Const(ConstDecl),
    /// `type ...`
    Type(TypeDecl),
}

/// What a component is in its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// `coordinator ...`
    Coordinator,
    /// `action ...`
    Action,
    /// `machine ...`: a machine within the machine.
    Machine,
}

/// `action turn: Turn(cells = 8) when ... { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// What it is.
    pub place: Place,
    /// Its name.
    pub name: Name,
    /// The contract's name, or the machine's.
    pub contract: Name,
    /// The contract's arguments, or the machine's.
    pub arguments: Vec<Argument>,
    /// When it is active.
    pub when: Option<Expr>,
    /// `time e`, and whether it was `per step`.
    pub time: Option<(Expr, bool)>,
    /// `power e`
    pub power: Option<Expr>,
    /// `input = e`, `input[2] = e`
    pub bindings: Vec<Binding>,
    /// Whether something within could not be understood; it was reported.
    pub broken: bool,
}

impl Component {
    /// Whether it is a coordinator.
    pub fn is_coordinator(&self) -> bool {
        self.place == Place::Coordinator
    }

    /// Whether it is a machine within the machine.
    pub fn is_machine(&self) -> bool {
        self.place == Place::Machine
    }
}

/// `move_a(tx = 1)`
#[derive(Debug, Clone, PartialEq)]
pub struct Performed {
    /// What is done; dotted for an operation of a machine within the machine.
    pub name: Name,
    /// What it is given.
    pub arguments: Vec<Argument>,
}

/// `command = cell.command`
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// The input; dotted for a member of a record.
    pub name: Name,
    /// The element of an array.
    pub index: Option<i64>,
    /// The member of an array's element, dotted where it lies deeper.
    pub member: Option<Name>,
    /// What it is bound to.
    pub value: Expr,
}

/// `line ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The doc comment.
    pub doc: String,
    /// The name.
    pub name: Name,
    /// What stands within.
    pub items: Vec<LineItem>,
}

/// `2 Brick`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counted {
    /// How many.
    pub count: u64,
    /// Of what.
    pub name: Name,
}

/// An item of a line.
#[derive(Debug, Clone, PartialEq)]
pub enum LineItem {
    /// `part ...`
    Part {
        /// Its name.
        name: Name,
        /// What it is joined from.
        bill: Vec<Counted>,
        /// What it carries.
        properties: Vec<Typed>,
    },
    /// `product P`
    Product(Name),
    /// `source ...`
    Source {
        /// Its name.
        name: Name,
        /// The part type.
        part: Name,
        /// When it makes them.
        supply: Supply,
        /// `, at most N in the line`.
        most: Option<u64>,
    },
    /// `store ...`
    Store {
        /// Its name.
        name: Name,
        /// What is in it at the start.
        stock: Vec<Counted>,
    },
    /// `sink ...`
    Sink {
        /// Its name.
        name: Name,
        /// Whether it takes scrap.
        rejects: bool,
        /// The source that makes replacements.
        reorder: Option<Name>,
    },
    /// `buffer ...`
    Buffer {
        /// Its name.
        name: Name,
        /// How many parts fit.
        capacity: u64,
    },
    /// `conveyor ...`
    Conveyor {
        /// Its name.
        name: Name,
        /// Its machine, with arguments.
        machine: Option<(Name, Vec<Argument>)>,
        /// `places`, `pitch`, `speed` and `power`.
        options: Vec<(Name, Expr)>,
    },
    /// `station ...`
    Station {
        /// Its name.
        name: Name,
        /// Its machine.
        machine: Name,
        /// The machine's arguments.
        arguments: Vec<Argument>,
        /// What stands within.
        items: Vec<StationItem>,
    },
    /// `route ...`
    Route {
        /// The part type.
        part: Name,
        /// The places it goes through.
        stops: Vec<Name>,
        /// When.
        when: Option<Expr>,
    },
    /// `requirement ...`
    Requirement {
        /// Its name.
        name: Name,
        /// What is measured.
        metric: Name,
        /// Of which station.
        of: Option<Name>,
        /// How it is compared.
        op: BinaryOp,
        /// With what.
        bound: Expr,
        /// Whether `per hour` followed.
        per_hour: bool,
        /// The whole of it.
        span: Span,
    },
    /// `shift a to b`
    Shift(Expr, Expr),
    /// `limit e`, and whether it was `products`.
    Limit(Expr, bool),
    /// `const ...`
    Const(ConstDecl),
}

/// When a source makes parts.
#[derive(Debug, Clone, PartialEq)]
pub enum Supply {
    /// `on order`
    OnOrder,
    /// `every [random] e [limit n]`
    Every {
        /// Seconds between two.
        seconds: Expr,
        /// Exponentially distributed.
        random: bool,
        /// How many in all.
        limit: Option<u64>,
    },
}

/// An item of a station.
#[derive(Debug, Clone, PartialEq)]
pub enum StationItem {
    /// `perform a, b(x = 1) on P`
    Perform {
        /// The operations.
        operations: Vec<Performed>,
        /// The part type.
        part: Name,
    },
    /// `setup e`
    Setup(Expr),
    /// `failures mtbf a mttr b`
    Failures(Expr, Expr),
    /// `defect on P probability p: one of x becomes e`
    Defect {
        /// The part type.
        part: Name,
        /// How likely.
        probability: Expr,
        /// The property.
        property: Name,
        /// The value it gets.
        value: Expr,
    },
}
