//! Machines: a coordinator and actions, wired together, and what their numbers mean in the plant.
//!
//! # Wires
//!
//! In one step a machine computes a vector of `i64` *wires*: first what the plant gives
//! ([`Machine::plant`]), then every output and internal variable of every component, in the order
//! of [`Machine::components`] and of each one's specification ([`Machine::first_wire`]). Bindings
//! are expressions over wires; `VarId(i)` with `Time::Now` is wire `i`. Only current values occur
//! in them.
//!
//! # One step
//!
//! 1. The plant's wires are given. A value outside its domain is an error.
//! 2. The coordinator, a Moore machine and always component 0 where there is one, puts its outputs
//!    on its wires.
//! 3. The actions follow in order: each one's inputs are computed from its bindings, its
//!    assumptions are checked, and its outputs are put on its wires. A Moore component's outputs
//!    are on its wires from the beginning of the step.
//! 4. The coordinator's inputs are computed and its assumptions checked; then all advance together.
//!
//! A broken assumption ends the step with an error and changes nothing.
//!
//! # Layers
//!
//! A machine may have machines as components. What is here is flat all the same: the components of
//! an inner machine `left` stand among the others as `left.pick`, its coordinator is one more, and
//! whatever is emitted or run knows of no layers. [`Layers`] keeps what proofs need of them.

use super::TaxonomyCode;
use crate::order::{Level, Skills};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Side, Specification, UnaryOp, Variable, described,
};
use linewright_core::source::Span;
use std::sync::Arc;

/// A machine with values for all its parameters.
#[derive(Debug, Clone)]
pub struct Machine {
    /// The name.
    pub name: String,
    /// The doc comment.
    pub doc: String,
    /// What it implements.
    pub codes: Vec<TaxonomyCode>,
    /// The coordinator (if there is one) first, then the actions in order of declaration.
    pub components: Vec<Component>,
    /// The plant's wires.
    pub plant: Vec<PlantInput>,
    /// The part's properties and the operations' parameters, as `simulate` takes them.
    pub properties: Vec<Property>,
    /// The jobs; at least one for a machine with a coordinator. `value` of the plant input
    /// `Operation` selects one.
    pub operations: Vec<Operation>,
    /// What an operation leaves in the part: after the last step, property `.0` gets the value `.1`
    /// (over final wires and the properties at the start). Evaluated together, then written
    /// together.
    pub writes: Vec<(usize, RealExpr)>,
    /// Over wires: the operation has ended. `None` for a machine without operations, which is only
    /// stepped.
    pub done: Option<Expr>,
    /// Duration of a step in which no action is active, in seconds.
    pub step_seconds: f64,
    /// Power drawn while an operation runs, beside that of the actions, in watts.
    pub base_watts: f64,
    /// Power drawn while the machine waits, in watts.
    pub idle_watts: f64,
    /// After so many steps an operation has failed.
    pub step_limit: u64,
    /// Breakdowns, if any.
    pub failures: Option<Failures>,
    /// The contracts that it is said to refine.
    pub refines: Vec<Promised>,
    /// What it guarantees as a whole, over wires.
    pub guarantees: Rules,
    /// The skills that it calls, and the orders that it keeps doing so: its own, then those of
    /// inner machines.
    pub orders: Vec<Orders>,
    /// The machines that it was made of.
    pub layers: Layers,
    /// Where its name stands.
    pub span: Span,
}

/// The machines that a machine was made of; none for most.
#[derive(Debug, Clone, Default)]
pub struct Layers {
    /// The machines one layer below, in the order of their declaration.
    pub inner: Vec<Inner>,
    /// The same machine as proofs look at it: an inner machine that refines a contract is one
    /// component with that contract, and nothing is known of it beside. `None` where there are no
    /// inner machines.
    pub abstracted: Option<Arc<Machine>>,
}

/// A machine within a machine.
#[derive(Debug, Clone)]
pub struct Inner {
    /// Its name there: `left`.
    pub name: String,
    /// The machine by itself, with the arguments that it has there.
    pub machine: Arc<Machine>,
    /// Where its name stands.
    pub span: Span,
}

/// A contract that a machine is said to refine: whatever uses the contract may use the machine.
#[derive(Debug, Clone)]
pub struct Promised {
    /// The contract's name.
    pub contract: String,
    /// Its formulas with these arguments.
    pub specification: Arc<Specification>,
    /// For every variable, in order, what it is in the machine, over wires; `None` for the
    /// variables of monitors.
    pub bindings: Vec<Option<Expr>>,
    /// Where its name stands.
    pub span: Span,
}

/// A set of skills that a machine calls.
#[derive(Debug, Clone)]
pub struct Orders {
    /// The skills and their orders; machines that call the same ones share them.
    pub skills: Arc<Skills>,
    /// How much is forbidden to the machine.
    pub level: Level,
    /// Over wires, one for each skill in their order: it is being called in this step.
    pub when: Vec<Expr>,
    /// The inner machine whose skills these are, `left.arm`; empty for the machine's own.
    pub of: String,
    /// Where the set is named in the machine.
    pub span: Span,
}

/// Formulas over wires, and over the variables of monitors that they need.
#[derive(Debug, Clone, Default)]
pub struct Rules {
    /// The formulas.
    pub side: Side,
    /// Variables of monitors; they are numbered after the wires.
    pub monitors: Vec<Variable>,
    /// What defines them.
    pub definitions: Side,
}

/// A contract in its place in a machine.
#[derive(Debug, Clone)]
pub struct Component {
    /// The name in the machine: `pick_a`.
    pub name: String,
    /// The contract's name: `Pick`.
    pub contract: String,
    /// Whether it is the coordinator or an action.
    pub role: Role,
    /// The contract's formulas with this component's arguments.
    pub specification: Arc<Specification>,
    /// One expression over wires an input of the specification, in that order.
    pub bindings: Vec<Expr>,
    /// Over wires: this action is being executed in this step. `None` for the coordinator.
    pub active: Option<Expr>,
    /// How long an execution takes.
    pub time: Option<ActionTime>,
    /// Power drawn while it is active, in watts, over the properties at the start of the operation.
    pub watts: RealExpr,
    /// Where its name stands.
    pub span: Span,
}

/// The place of a component in the two layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The upper layer.
    Coordinator,
    /// The lower layer.
    Action,
    /// Beside both: it is told which skills are called, and assumes that the orders of its set are
    /// kept. It does nothing.
    Watch,
}

/// How long an action takes, in seconds, over the properties at the start of the operation.
#[derive(Debug, Clone, PartialEq)]
pub enum ActionTime {
    /// Every step in which it is active takes so long.
    PerStep(RealExpr),
    /// One execution (a run of consecutive active steps) takes so long, however many steps it has:
    /// charged to the first.
    PerExecution(RealExpr),
}

/// One wire that the plant gives.
#[derive(Debug, Clone)]
pub struct PlantInput {
    /// Its name.
    pub name: String,
    /// Its values.
    pub domain: Domain,
    /// What they count, `deg`; empty for bare numbers.
    pub unit: String,
    /// Where its value comes from when `simulate` runs.
    pub source: PlantSource,
    /// Where it is declared.
    pub span: Span,
}

impl PlantInput {
    /// Its values as a person writes them, with their unit: `0..359 deg`.
    pub fn describe(&self) -> String {
        described(&self.domain, &self.unit)
    }
}

/// Where a plant wire's value comes from when `simulate` runs.
#[derive(Debug, Clone)]
pub enum PlantSource {
    /// The operation's value.
    Operation,
    /// A signal of the plant: its value in step `i` (from 0, anew for each call) is
    /// `script[i % script.len()]`. Never empty; one entry is a constant.
    Signal {
        /// The values.
        script: Vec<i64>,
    },
    /// The property abstraction: this expression over the properties at the start, which must be an
    /// integer of the domain.
    Property(RealExpr),
}

/// One number of the part, or one parameter of the operation, as `simulate` takes it. Arrays are
/// flattened.
#[derive(Debug, Clone)]
pub struct Property {
    /// Its name; an array's element is called `heights[2]`.
    pub name: String,
    /// Its unit, `deg`; empty for a bare number.
    pub unit: String,
    /// Its value where the part or the call has none.
    pub default: f64,
    /// Whether it belongs to the part or to the call.
    pub kind: PropertyKind,
    /// Its values, where they are truth values, labels or a range of whole numbers.
    pub domain: Option<Domain>,
    /// Where it is declared.
    pub span: Span,
}

/// To whom a property belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PropertyKind {
    /// The mobile unit carries it.
    Part,
    /// The operation is called with it.
    Parameter,
}

/// A job of the coordinator.
#[derive(Debug, Clone)]
pub struct Operation {
    /// Its name: `emptying`.
    pub name: String,
    /// What it implements.
    pub codes: Vec<TaxonomyCode>,
    /// The actions it executes, in order, as indices into [`Machine::components`].
    pub sequence: Vec<usize>,
    /// The value of the plant's operation wire.
    pub value: i64,
    /// Where it is declared.
    pub span: Span,
}

/// Breakdowns of a machine: exponentially distributed, over the time in which it works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Failures {
    /// Mean working time between failures, in seconds.
    pub mtbf: f64,
    /// Mean time to repair, in seconds.
    pub mttr: f64,
}

/// An expression over real numbers: what the plant computes with. Truth values are 0 and 1.
#[derive(Debug, Clone, PartialEq)]
pub enum RealExpr {
    /// A number.
    Number(f64),
    /// A property by its index.
    Property(usize),
    /// A wire by its index, after the last step.
    Wire(usize),
    /// One operand.
    Unary(RealUnary, Box<RealExpr>),
    /// Two operands.
    Binary(RealBinary, Box<RealExpr>, Box<RealExpr>),
    /// `if c then a else b`; true is anything but 0.
    If(Box<RealExpr>, Box<RealExpr>, Box<RealExpr>),
}

/// An operator with one operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RealUnary {
    /// Boolean negation.
    Not,
    /// `-x`
    Neg,
    /// `abs(x)`
    Abs,
    /// `floor(x)`
    Floor,
    /// `ceil(x)`
    Ceil,
    /// `round(x)`: halves away from zero.
    Round,
}

/// An operator with two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RealBinary {
    /// Boolean and.
    And,
    /// Boolean or.
    Or,
    /// Boolean implication.
    Implies,
    /// `=`
    Eq,
    /// `!=`
    Ne,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`
    Mul,
    /// `/`: the division of real numbers.
    Div,
    /// `x - y * floor(x / y)`
    Mod,
    /// The smaller one.
    Min,
    /// The larger one.
    Max,
}

impl RealExpr {
    /// The same with other expressions for properties and for wires.
    #[must_use]
    pub fn substitute(
        &self,
        property: &impl Fn(usize) -> Self,
        wire: &impl Fn(usize) -> Self,
    ) -> Self {
        let sub = |x: &Self| Box::new(x.substitute(property, wire));
        match self {
            Self::Number(x) => Self::Number(*x),
            Self::Property(i) => property(*i),
            Self::Wire(i) => wire(*i),
            Self::Unary(op, a) => Self::Unary(*op, sub(a)),
            Self::Binary(op, a, b) => Self::Binary(*op, sub(a), sub(b)),
            Self::If(c, a, b) => Self::If(sub(c), sub(a), sub(b)),
        }
    }

    /// Calls `seen` with every property and every wire in it.
    pub fn for_each(&self, seen: &mut impl FnMut(&Self)) {
        match self {
            Self::Number(_) => {}
            Self::Property(_) | Self::Wire(_) => seen(self),
            Self::Unary(_, a) => a.for_each(seen),
            Self::Binary(_, a, b) => {
                a.for_each(seen);
                b.for_each(seen);
            }
            Self::If(c, a, b) => {
                c.for_each(seen);
                a.for_each(seen);
                b.for_each(seen);
            }
        }
    }

    /// A whole-number expression over wires.
    pub fn of_wires(expr: &Expr) -> Self {
        let sub = |x: &Expr| Box::new(Self::of_wires(x));
        match expr {
            Expr::Const(c) => Self::Number(*c as f64),
            Expr::Var(v, _) => Self::Wire(v.index()),
            Expr::Unary(op, a) => Self::Unary(
                match op {
                    UnaryOp::Not => RealUnary::Not,
                    UnaryOp::Neg => RealUnary::Neg,
                    UnaryOp::Abs => RealUnary::Abs,
                },
                sub(a),
            ),
            // Whole numbers are divided downwards.
            Expr::Binary(BinaryOp::Div, a, b) => {
                let ratio = Self::Binary(RealBinary::Div, sub(a), sub(b));
                Self::Unary(RealUnary::Floor, Box::new(ratio))
            }
            Expr::Binary(op, a, b) => Self::Binary(RealBinary::of(*op), sub(a), sub(b)),
            Expr::If(c, a, b) => Self::If(sub(c), sub(a), sub(b)),
        }
    }

    /// The value, with these properties and wires.
    pub fn eval(&self, properties: &[f64], wires: &[i64]) -> f64 {
        let truth = |b: bool| if b { 1.0 } else { 0.0 };
        match self {
            Self::Number(x) => *x,
            Self::Property(i) => properties[*i],
            Self::Wire(i) => wires[*i] as f64,
            Self::Unary(op, a) => {
                let a = a.eval(properties, wires);
                match op {
                    RealUnary::Not => truth(a == 0.0),
                    RealUnary::Neg => -a,
                    RealUnary::Abs => a.abs(),
                    RealUnary::Floor => a.floor(),
                    RealUnary::Ceil => a.ceil(),
                    RealUnary::Round => a.round(),
                }
            }
            Self::Binary(op, a, b) => {
                let (a, b) = (a.eval(properties, wires), b.eval(properties, wires));
                #[expect(clippy::float_cmp, reason = "the language's own equality")]
                match op {
                    RealBinary::And => truth(a != 0.0 && b != 0.0),
                    RealBinary::Or => truth(a != 0.0 || b != 0.0),
                    RealBinary::Implies => truth(a == 0.0 || b != 0.0),
                    RealBinary::Eq => truth(a == b),
                    RealBinary::Ne => truth(a != b),
                    RealBinary::Lt => truth(a < b),
                    RealBinary::Le => truth(a <= b),
                    RealBinary::Gt => truth(a > b),
                    RealBinary::Ge => truth(a >= b),
                    RealBinary::Add => a + b,
                    RealBinary::Sub => a - b,
                    RealBinary::Mul => a * b,
                    RealBinary::Div => a / b,
                    RealBinary::Mod => a - b * (a / b).floor(),
                    RealBinary::Min => a.min(b),
                    RealBinary::Max => a.max(b),
                }
            }
            Self::If(c, a, b) => {
                if c.eval(properties, wires) == 0.0 {
                    b.eval(properties, wires)
                } else {
                    a.eval(properties, wires)
                }
            }
        }
    }
}

impl RealBinary {
    /// The same operator on real numbers.
    pub fn of(op: BinaryOp) -> Self {
        match op {
            BinaryOp::And => Self::And,
            BinaryOp::Or => Self::Or,
            BinaryOp::Implies => Self::Implies,
            BinaryOp::Eq => Self::Eq,
            BinaryOp::Ne => Self::Ne,
            BinaryOp::Lt => Self::Lt,
            BinaryOp::Le => Self::Le,
            BinaryOp::Gt => Self::Gt,
            BinaryOp::Ge => Self::Ge,
            BinaryOp::Add => Self::Add,
            BinaryOp::Sub => Self::Sub,
            BinaryOp::Mul => Self::Mul,
            BinaryOp::Div => Self::Div,
            BinaryOp::Mod => Self::Mod,
            BinaryOp::Min => Self::Min,
            BinaryOp::Max => Self::Max,
        }
    }
}

impl Machine {
    /// The first wire of component `index`.
    pub fn first_wire(&self, index: usize) -> usize {
        self.plant.len()
            + self.components[..index]
                .iter()
                .map(|c| c.specification.outputs().count())
                .sum::<usize>()
    }

    /// How many wires there are.
    pub fn wire_count(&self) -> usize {
        self.first_wire(self.components.len())
    }

    /// The name of a wire: `grip` for the plant's, `pick_a.stage` for a component's.
    pub fn wire_name(&self, wire: usize) -> String {
        if let Some(input) = self.plant.get(wire) {
            return input.name.clone();
        }
        let mut first = self.plant.len();
        for component in &self.components {
            let outputs: Vec<_> = component.specification.outputs().collect();
            if let Some(id) = outputs.get(wire - first) {
                return format!(
                    "{}.{}",
                    component.name,
                    component.specification.variable(*id).name
                );
            }
            first += outputs.len();
        }
        format!("wire {wire}")
    }

    /// The values of a wire.
    ///
    /// # Panics
    /// When there is no such wire.
    pub fn wire_domain(&self, wire: usize) -> &Domain {
        if let Some(input) = self.plant.get(wire) {
            return &input.domain;
        }
        let outputs = self.components.iter().flat_map(|c| {
            let specification = &c.specification;
            specification
                .outputs()
                .map(|id| &specification.variable(id).domain)
        });
        let domain = outputs.into_iter().nth(wire - self.plant.len());
        domain.expect("a wire of this machine; please report this")
    }

    /// The machine as proofs look at it: with what inner machines promise in the place of what they
    /// are made of.
    pub fn abstracted(&self) -> &Self {
        self.layers.abstracted.as_deref().unwrap_or(self)
    }

    /// The coordinator, if there is one: component 0.
    pub fn coordinator(&self) -> Option<&Component> {
        self.components
            .first()
            .filter(|c| c.role == Role::Coordinator)
    }

    /// The operation of a name.
    pub fn operation(&self, name: &str) -> Option<&Operation> {
        self.operations.iter().find(|o| o.name == name)
    }
}
