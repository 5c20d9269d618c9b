//! Random syntax trees of every kind that the parser can produce: any shape of operators (brackets
//! give every shape), names that are no words of the language, and nothing that no text could mean
//! (a negative number, an `eventually` pattern without bound and scope).
//!
//! A tree is generated from a list of numbers, one per choice, so that proptest shrinks trees by
//! shrinking lists; at the end of the list, every choice is the first option, which ends the
//! generation.

#[path = "recipes.rs"]
mod recipes;
#[path = "skills.rs"]
mod skills;

use linewright::source::Span;
use linewright::syntax::ast::*;

/// The answers to the choices.
pub struct Choices<'n> {
    numbers: &'n [u32],
    depth: usize,
}

/// Names, including some that are words only where a scope, a setting or a unit is expected.
const NAMES: &[&str] = &[
    "a", "grip", "tx", "angle_1", "Größe", "after", "within", "s", "steps", "power", "responds",
    "_",
];
/// Names that a preceding expression could not absorb.
const PLAIN: &[&str] = &["a", "grip", "tx", "angle_1", "Größe", "Turn"];
const UNITS: &[&str] = &["mm", "deg", "s", "%", "kWh", "m/s"];

fn name(text: &str) -> Name {
    Name {
        text: text.to_owned(),
        span: Span::default(),
    }
}

fn expr(kind: ExprKind) -> Expr {
    Expr {
        kind,
        span: Span::default(),
    }
}

impl<'n> Choices<'n> {
    pub fn new(numbers: &'n [u32]) -> Self {
        Self { numbers, depth: 0 }
    }

    /// A number below `count`.
    fn pick(&mut self, count: usize) -> usize {
        match self.numbers {
            [first, rest @ ..] => {
                self.numbers = rest;
                *first as usize % count
            }
            [] => 0,
        }
    }

    fn maybe(&mut self) -> bool {
        self.pick(2) == 1
    }

    fn name(&mut self) -> Name {
        name(NAMES[self.pick(NAMES.len())])
    }

    fn plain(&mut self) -> Name {
        name(PLAIN[self.pick(PLAIN.len())])
    }

    fn dotted(&mut self) -> Name {
        let (a, b) = (self.plain(), self.plain());
        name(&if self.maybe() {
            format!("{}.{}", a.text, b.text)
        } else {
            a.text
        })
    }

    fn list<T>(
        &mut self,
        least: usize,
        most: usize,
        mut one: impl FnMut(&mut Self) -> T,
    ) -> Vec<T> {
        let count = least + self.pick(most + 1 - least);
        (0..count).map(|_| one(self)).collect()
    }

    fn option<T>(&mut self, one: impl FnOnce(&mut Self) -> T) -> Option<T> {
        self.maybe().then(|| one(self))
    }

    fn doc(&mut self) -> String {
        let lines = self.list(0, 3, |c| {
            ["what it is", " - a point", "x // y \"z"][c.pick(3)]
        });
        lines.join("\n")
    }

    fn boxed(&mut self) -> Box<Expr> {
        Box::new(self.expr())
    }

    fn count(&mut self) -> u64 {
        [1, 0, 3, 500][self.pick(4)]
    }

    /// Any expression.
    pub fn expr(&mut self) -> Expr {
        if self.depth > 8 {
            return expr(ExprKind::Bool(true));
        }
        self.depth += 1;
        let e = self.kind();
        self.depth -= 1;
        expr(e)
    }

    fn kind(&mut self) -> ExprKind {
        match self.pick(25) {
            0 => ExprKind::Path(self.list(1, 2, Self::name)),
            1 => ExprKind::Bool(self.maybe()),
            2 => ExprKind::Int([0, 1, 7, 1 << 53][self.pick(4)]),
            3 => {
                let value = [0.5, 3.0, 1e20, 0.1 + 0.2, 1e-9, 0.0][self.pick(6)];
                let unit = if self.maybe() {
                    UNITS[self.pick(UNITS.len())]
                } else {
                    ""
                };
                ExprKind::Quantity(value, unit.to_owned())
            }
            4 => ExprKind::Index(self.boxed(), self.boxed()),
            5 => ExprKind::Next(self.boxed()),
            6 => ExprKind::Always(self.boxed()),
            7 => ExprKind::Eventually(self.boxed()),
            8 => ExprKind::Not(self.boxed()),
            9 => ExprKind::Neg(self.boxed()),
            10..=13 => self.binary(),
            14 => self.chain(),
            15 => ExprKind::If(self.boxed(), self.boxed(), self.boxed()),
            16 => {
                use Quantifier::{Array, Count, Exists, Forall, Sum};
                let kind = [Forall, Exists, Count, Sum, Array][self.pick(5)];
                ExprKind::Quantifier(kind, self.plain(), Box::new(self.domain()), self.boxed())
            }
            17 => ExprKind::Call(self.plain(), self.list(1, 3, Self::expr)),
            18 => ExprKind::List(self.list(1, 4, Self::expr)),
            19 => ExprKind::Member(self.boxed(), self.list(1, 3, Self::expr)),
            20 => ExprKind::Within(self.boxed(), self.boxed(), self.boxed()),
            21 => ExprKind::Field(self.boxed(), self.plain()),
            22 => ExprKind::Record(self.arguments(1)),
            23 => {
                let op = [PastOp::Previous, PastOp::Once, PastOp::Historically][self.pick(3)];
                let body = self.boxed();
                ExprKind::Past(op, body, self.option(Self::boxed))
            }
            _ if self.maybe() => ExprKind::Since(self.boxed(), self.boxed()),
            _ if self.maybe() => {
                let op = [UntilOp::Strong, UntilOp::Weak, UntilOp::Release][self.pick(3)];
                ExprKind::Until(op, self.boxed(), self.boxed())
            }
            _ => ExprKind::Pattern(self.pattern()),
        }
    }

    fn op(&mut self) -> BinaryOp {
        use BinaryOp::{
            Add, And, Div, Eq, Ge, Gt, Iff, Implies, Le, Lt, Mod, Mul, Ne, Or, Sub, Xor,
        };
        let all = [
            And, Or, Implies, Iff, Xor, Eq, Ne, Lt, Le, Gt, Ge, Add, Sub, Mul, Div, Mod,
        ];
        all[self.pick(all.len())]
    }

    fn binary(&mut self) -> ExprKind {
        ExprKind::Binary(self.op(), self.boxed(), self.boxed())
    }

    /// A tree produced by long chains of one kind of operator, or nearly so: halved, to the left,
    /// to the right, or compared.
    fn chain(&mut self) -> ExprKind {
        let operands = self.list(3, 9, Self::expr);
        let op = self.op();
        let way = self.pick(4);
        if way == 3 {
            let links: Vec<Expr> = operands
                .windows(2)
                .map(|w| join(BinaryOp::Lt, w[0].clone(), w[1].clone()))
                .collect();
            return halves(BinaryOp::And, links).kind;
        }
        let chain = match way {
            0 => halves(op, operands),
            1 => {
                let mut operands = operands.into_iter();
                let first = operands.next().expect("an operand");
                operands.fold(first, |a, b| join(op, a, b))
            }
            _ => {
                let mut operands = operands.into_iter().rev();
                let last = operands.next().expect("an operand");
                operands.fold(last, |b, a| join(op, a, b))
            }
        };
        chain.kind
    }

    fn pattern(&mut self) -> Pattern {
        let (kind, may_have_bound) = match self.pick(5) {
            0 => (PatternKind::Absence(self.boxed()), false),
            1 => (PatternKind::Existence(self.boxed()), true),
            2 => (PatternKind::Universality(self.boxed()), false),
            3 => (PatternKind::Precedence(self.boxed(), self.boxed()), true),
            _ => (PatternKind::Response(self.boxed(), self.boxed()), true),
        };
        let bound = if may_have_bound {
            self.option(Self::boxed)
        } else {
            None
        };
        let scope = match self.pick(5) {
            0 => Scope::Before(self.boxed()),
            1 => Scope::After(self.boxed()),
            2 => Scope::Between(self.boxed(), self.boxed()),
            3 => Scope::AfterUntil(self.boxed(), self.boxed()),
            _ => Scope::Globally,
        };
        // Without bound and scope these two are the operators.
        let plain = bound.is_none() && scope == Scope::Globally;
        let scope = match kind {
            PatternKind::Existence(_) | PatternKind::Universality(_) if plain => {
                Scope::Before(self.boxed())
            }
            _ => scope,
        };
        kind.in_scope(bound, scope)
    }

    fn domain(&mut self) -> Domain {
        self.depth += 1;
        let choice = if self.depth > 8 { 0 } else { self.pick(6) };
        let kind = match choice {
            0 => DomainKind::Named(name(["bool", "Command", "real.angle"][self.pick(3)])),
            1 => DomainKind::Labels(self.list(1, 4, Self::name)),
            2 => {
                let (low, high) = (self.expr(), self.expr());
                let unit = self.option(|c| UNITS[c.pick(UNITS.len())].to_owned());
                DomainKind::Range(low, high, unit)
            }
            3 => DomainKind::Record(self.list(1, 3, |c| (c.name(), c.domain()))),
            4 => DomainKind::Array(self.expr(), Box::new(self.domain())),
            _ => DomainKind::Unit(UNITS[self.pick(UNITS.len())].to_owned()),
        };
        self.depth -= 1;
        Domain {
            kind,
            span: Span::default(),
        }
    }

    fn arguments(&mut self, least: usize) -> Vec<Argument> {
        self.list(least, 3, |c| Argument {
            name: c.name(),
            value: c.expr(),
        })
    }

    fn performed(&mut self) -> OperationCall {
        OperationCall {
            name: self.dotted(),
            arguments: self.arguments(0),
        }
    }

    fn codes(&mut self) -> Vec<Name> {
        self.list(0, 2, |c| name(["din:4.1.3", "vdi:Drehen"][c.pick(2)]))
    }

    fn header(&mut self) -> Header {
        Header {
            doc: self.doc(),
            name: self.plain(),
            parameters: self.list(0, 3, |c| Parameter {
                name: c.name(),
                domain: c.domain(),
                default: c.option(Self::expr),
            }),
            codes: self.codes(),
        }
    }

    fn type_decl(&mut self) -> TypeDecl {
        TypeDecl {
            name: self.plain(),
            domain: self.domain(),
        }
    }

    fn const_decl(&mut self) -> ConstDecl {
        ConstDecl {
            name: self.name(),
            domain: self.option(Self::domain),
            value: self.expr(),
        }
    }

    fn define(&mut self) -> Define {
        Define {
            name: self.name(),
            formals: self.list(0, 3, |c| Formal {
                name: c.name(),
                domain: c.option(Self::domain),
            }),
            value: self.expr(),
        }
    }

    fn contract_item(&mut self) -> ContractItem {
        match self.pick(8) {
            0..=2 => ContractItem::Formula {
                guarantee: self.maybe(),
                name: self.option(Self::name),
                requirement: self.option(|c| ["REQ-12", "a, b"][c.pick(2)].to_owned()),
                expr: self.expr(),
            },
            3 => ContractItem::Variables {
                ownership: [Ownership::Input, Ownership::Output, Ownership::Internal][self.pick(3)],
                names: self.list(1, 3, Self::name),
                domain: self.domain(),
            },
            4 => ContractItem::Define(self.define()),
            5 => ContractItem::Counter(Counter {
                name: self.name(),
                domain: self.domain(),
                counts: self.expr(),
                resets: self.option(Self::expr),
            }),
            6 => ContractItem::Type(self.type_decl()),
            _ => ContractItem::Const(self.const_decl()),
        }
    }

    fn typed(&mut self, least: usize, most: usize) -> TypedDecl {
        TypedDecl {
            doc: self.doc(),
            name: self.plain(),
            domain: self.domain(),
            values: self.list(least, most, Self::expr),
        }
    }

    fn component(&mut self) -> Component {
        Component {
            role: match self.pick(3) {
                0 => Role::Coordinator,
                1 => Role::Action,
                _ => Role::Machine,
            },
            name: self.plain(),
            contract: self.dotted(),
            arguments: self.arguments(0),
            when: self.option(Self::expr),
            time: self.option(|c| (c.expr(), c.maybe())),
            power: self.option(Self::expr),
            bindings: self.list(0, 3, |c| {
                let index = c.option(|c| c.count() as i64);
                Binding {
                    name: c.dotted(),
                    index,
                    member: index.and_then(|_| c.option(Self::dotted)),
                    value: c.expr(),
                }
            }),
            broken: false,
        }
    }

    fn machine_item(&mut self) -> MachineItem {
        match self.pick(16) {
            0 => MachineItem::Step(self.expr()),
            1 => MachineItem::IdlePower(self.expr()),
            2 => MachineItem::Power(self.expr()),
            3 => MachineItem::Limit(self.expr()),
            4 => MachineItem::Failures(self.failures()),
            5 => MachineItem::Property(self.typed(0, 1)),
            6 => MachineItem::Parameter(self.typed(0, 1)),
            7 => MachineItem::Signal(self.typed(1, 4)),
            8 => MachineItem::Abstract(self.typed(1, 1)),
            9 => MachineItem::Component(self.component()),
            10 => MachineItem::Operation {
                name: self.plain(),
                codes: self.codes(),
                sequence: self.list(0, 4, Self::performed),
            },
            11 => MachineItem::Done(self.expr()),
            12 => MachineItem::Write {
                name: self.dotted(),
                index: self.option(Self::expr),
                value: self.expr(),
            },
            13 => MachineItem::Const(self.const_decl()),
            14 => MachineItem::Skills(self.skill_calls()),
            _ => MachineItem::Type(self.type_decl()),
        }
    }

    fn counted(&mut self) -> PartCount {
        PartCount {
            count: self.count(),
            name: self.plain(),
        }
    }

    fn duration(&mut self) -> TimeValue {
        match self.pick(4) {
            0 | 1 => return TimeValue::Value(self.expr()),
            2 => {
                return TimeValue::Empirical {
                    column: self.column(),
                    span: Span::default(),
                };
            }
            _ => {}
        }
        self.drawn()
    }

    fn drawn(&mut self) -> TimeValue {
        TimeValue::Drawn {
            name: name(["uniform", "normal", "discrete"][self.pick(3)]),
            outcomes: self.list(1, 3, |c| Outcome {
                value: c.expr(),
                weight: c.option(Self::expr),
            }),
            span: Span::default(),
        }
    }

    fn column(&mut self) -> Column {
        let quoted = self.maybe();
        Column {
            path: name(["times.csv", "../a b//c.csv"][self.pick(2)]),
            header: if quoted {
                name(["time in s", "due"][self.pick(2)])
            } else {
                self.plain()
            },
            quoted,
            unit: name(["s", "min", "ms"][self.pick(3)]),
        }
    }

    fn failures(&mut self) -> Failures {
        Failures {
            name: self.option(Self::plain),
            between: match self.pick(3) {
                0 => Between::Parts(self.count()),
                1 => Between::DrawnParts(self.drawn()),
                _ => Between::Time(self.duration()),
            },
            mttr: self.duration(),
            calendar: self.maybe(),
            interrupted: [
                InterruptedWork::Resumes,
                InterruptedWork::Restarts,
                InterruptedWork::ScrapsPart,
            ][self.pick(3)],
            span: Span::default(),
        }
    }

    fn station_item(&mut self) -> StationItem {
        match self.pick(9) {
            0 => StationItem::Perform {
                operations: self.list(1, 3, Self::performed),
                part: self.plain(),
            },
            1 => StationItem::Setup(self.duration()),
            2 => StationItem::Failures(self.failures()),
            3 => StationItem::Takes {
                duration: self.duration(),
                part: self.option(Self::plain),
            },
            4 => StationItem::Sets {
                property: self.plain(),
                index: self.option(Self::expr),
                value: self.expr(),
                part: self.option(Self::plain),
            },
            5 => StationItem::IdlePower(self.expr()),
            6 => StationItem::Power(self.expr()),
            7 => StationItem::Shift(self.shift()),
            _ => StationItem::Defect {
                part: self.plain(),
                probability: self.expr(),
                one_of: self.pick(2) == 0,
                property: self.plain(),
                value: self.expr(),
            },
        }
    }

    fn hours(&mut self) -> Hours {
        Hours {
            from: self.expr(),
            to: self.expr(),
            span: Span::default(),
        }
    }

    fn shift(&mut self) -> Shift {
        Shift {
            hours: self.hours(),
            days: self.list(0, 3, |c| Days {
                first: c.plain(),
                last: c.option(Self::plain),
            }),
            breaks: self.list(0, 2, Self::hours),
            finish_work: self.maybe(),
        }
    }

    fn date(&mut self) -> Name {
        name(["2026-12-24", "0-00-1"][self.pick(2)])
    }

    fn line_item(&mut self) -> LineItem {
        let place = self.plain();
        match self.pick(15) {
            0 => LineItem::Part {
                name: place,
                bill: self.list(0, 3, Self::counted),
                properties: self.list(0, 2, |c| c.typed(0, 1)),
            },
            1 => LineItem::Product(self.list(1, 3, Self::plain)),
            2 => LineItem::Source {
                name: place,
                part: self.plain(),
                supply: match self.pick(4) {
                    0 => Supply::OnOrder,
                    1 => Supply::At(self.column()),
                    _ => Supply::Every {
                        interval: self.duration(),
                        random: self.maybe(),
                        limit: self.option(Self::count),
                    },
                },
                most: self.option(Self::count),
            },
            3 => LineItem::Store {
                name: place,
                stock: self.list(0, 3, Self::counted),
            },
            4 => LineItem::Sink {
                name: place,
                rejects: self.maybe(),
                reorder: self.option(Self::plain),
            },
            5 => LineItem::Buffer {
                name: place,
                capacity: self.count(),
                order: self.option(|c| match c.pick(3) {
                    0 => BufferOrder::LastIn,
                    1 => BufferOrder::Highest(c.plain()),
                    _ => BufferOrder::Lowest(c.plain()),
                }),
                dwell: self.option(Self::duration),
                shelf_life: self.option(Self::expr),
            },
            6 => LineItem::Conveyor {
                name: place,
                machine: self.option(|c| (c.dotted(), c.arguments(0))),
                options: self.list(0, 4, |c| {
                    let word = ["places", "pitch", "speed", "power"][c.pick(4)];
                    (name(word), c.expr())
                }),
            },
            7 => LineItem::Station {
                name: place,
                machine: self.option(|c| (c.dotted(), c.arguments(0))),
                times: self.option(|c| Copies {
                    count: c.count(),
                    span: Span::default(),
                }),
                items: self.list(0, 3, Self::station_item),
            },
            8 => LineItem::Route {
                part: place,
                stops: self.list(2, 4, |c| Stop {
                    places: c.list(1, 4, Self::plain),
                    choice: c.option(|c| match c.pick(4) {
                        0 => StopChoice::FirstFree,
                        1 => StopChoice::ShortestQueue,
                        2 => StopChoice::RoundRobin,
                        _ => StopChoice::Probability(c.list(1, 3, Self::expr)),
                    }),
                    span: Span::default(),
                }),
                when: self.option(Self::expr),
            },
            9 => {
                use BinaryOp::{Eq, Ge, Gt, Le, Lt, Ne};
                LineItem::Requirement {
                    name: place,
                    metric: self.plain(),
                    of: self.option(Self::plain),
                    op: [Ge, Le, Lt, Gt, Eq, Ne][self.pick(6)],
                    bound: self.expr(),
                    per_hour: self.maybe(),
                    span: Span::default(),
                }
            }
            10 => LineItem::Shift(self.shift()),
            11 => LineItem::Start(self.date()),
            12 => LineItem::Holiday(self.date(), self.option(Self::date)),
            13 => {
                let value = self.expr();
                // A bare number would be the limit of a source above it; as the line's limit it
                // means nothing.
                let products = self.maybe() || matches!(value.kind, ExprKind::Int(_));
                LineItem::Limit(value, products)
            }
            _ => LineItem::Const(self.const_decl()),
        }
    }

    fn item(&mut self) -> Item {
        match self.pick(14) {
            0..=2 => Item::Contract(Contract {
                header: self.header(),
                moore: self.maybe(),
                items: self.list(0, 5, Self::contract_item),
            }),
            3 => Item::Machine(Machine {
                header: self.header(),
                items: self.list(0, 5, Self::machine_item),
            }),
            4 => Item::Line(Line {
                doc: self.doc(),
                name: self.plain(),
                items: self.list(0, 5, Self::line_item),
                unparsed: Vec::new(),
            }),
            5 => {
                let (path, dotted) =
                    [("std.handling.turn", true), ("../a b//c.lw", false)][self.pick(2)];
                Item::Import(Import {
                    path: path.to_owned(),
                    dotted,
                    span: Span::default(),
                })
            }
            6 => Item::Type(self.type_decl()),
            7 => Item::Const(self.const_decl()),
            8 | 9 => Item::Skills(self.skill_set()),
            10 => Item::Layout(self.layout()),
            11 => Item::Recipe(self.recipe()),
            12 => Item::Realize(self.realize()),
            _ => Item::Define(self.define()),
        }
    }

    /// A whole file.
    pub fn file(&mut self) -> File {
        let mut items = Vec::new();
        while items.is_empty() || !self.numbers.is_empty() {
            items.push(self.item());
        }
        File {
            items,
            places: Vec::new(),
            tables: Vec::new(),
        }
    }
}

fn join(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    expr(ExprKind::Binary(op, Box::new(a), Box::new(b)))
}

fn halves(op: BinaryOp, mut operands: Vec<Expr>) -> Expr {
    while operands.len() > 1 {
        operands = operands
            .chunks(2)
            .map(|pair| match pair {
                [a, b] => join(op, a.clone(), b.clone()),
                _ => pair[0].clone(),
            })
            .collect();
    }
    operands.remove(0)
}
