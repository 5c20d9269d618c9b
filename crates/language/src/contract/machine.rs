//! Machines: a coordinator and actions, wired together, and the meaning of their numbers in the
//! plant.
//!
//! # Wires
//!
//! In one step a machine computes a vector of `i64` *wires*: first the plant's inputs
//! ([`Machine::plant`]), then every output and internal variable of every component, in the order
//! of [`Machine::components`] and of each one's specification ([`Machine::first_wire`]). Bindings
//! are expressions over wires; `VarId(i)` with `Time::Now` is wire `i`. Only current values occur
//! in them.
//!
//! # One step
//!
//! 1. The plant's wires are given. A value outside its domain is an error.
//! 2. The coordinator, a Moore machine and always component 0 if there is one, puts its outputs on
//!    its wires.
//! 3. The actions follow in order: each one's inputs are computed from its bindings, its
//!    assumptions are checked, and its outputs are put on its wires. A Moore component's outputs
//!    are on its wires from the beginning of the step.
//! 4. The coordinator's inputs are computed and its assumptions checked; then all advance together.
//!
//! A broken assumption ends the step with an error and changes nothing.
//!
//! # Layers
//!
//! A machine may have machines as components. This model is flat nevertheless: the components of an
//! inner machine `left` are listed among the others as `left.pick`, its coordinator is an
//! additional one, and code generation and execution see no layers. [`Layers`] keeps what proofs
//! need of them.

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
    /// Name of the machine.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Taxonomy codes that it implements.
    pub codes: Vec<TaxonomyCode>,
    /// Components: the coordinator first (if there is one), then the actions in order of
    /// declaration.
    pub components: Vec<Component>,
    /// The plant's wires.
    pub plant: Vec<PlantInput>,
    /// Properties of the part and parameters of the operations, as `simulate` takes them.
    pub properties: Vec<Property>,
    /// Operations; at least one for a machine with a coordinator. `value` of the plant input
    /// `Operation` selects one.
    pub operations: Vec<Operation>,
    /// Writes to the part by an operation: after the last step, property `.0` gets the value `.1`
    /// (over final wires and the properties at the start). All are evaluated first, then written.
    pub writes: Vec<(usize, RealExpr)>,
    /// Condition over wires that the operation has ended. `None` for a machine without operations,
    /// which is only stepped.
    pub done: Option<Expr>,
    /// Duration of a step in which no action is active, in seconds.
    pub step_seconds: f64,
    /// Power drawn while an operation runs, in addition to that of the actions, in watts.
    pub base_watts: f64,
    /// Power drawn while the machine waits, in watts.
    pub idle_watts: f64,
    /// Number of steps after which an operation has failed.
    pub step_limit: u64,
    /// Breakdowns, if any.
    pub failures: Option<Failures>,
    /// Contracts that it is claimed to refine.
    pub refines: Vec<RefinedContract>,
    /// Guarantees of the whole machine, over wires.
    pub guarantees: Rules,
    /// Sets of skills that it calls, with their orders: its own, then those of inner machines.
    pub orders: Vec<Orders>,
    /// Machines that it was made of.
    pub layers: Layers,
    /// Place of its name.
    pub span: Span,
}

/// The layers of a machine; empty for most.
#[derive(Debug, Clone, Default)]
pub struct Layers {
    /// Machines one layer below, in the order of their declaration.
    pub inner: Vec<Inner>,
    /// The same machine as seen by proofs: an inner machine that refines a contract is one
    /// component with that contract, and nothing else is known of it. `None` if there are no inner
    /// machines.
    pub abstracted: Option<Arc<Machine>>,
}

/// An inner machine.
#[derive(Debug, Clone)]
pub struct Inner {
    /// Name within the outer machine: `left`.
    pub name: String,
    /// The machine by itself, with its arguments in the outer machine.
    pub machine: Arc<Machine>,
    /// Place of its name.
    pub span: Span,
}

/// A contract that a machine is claimed to refine: the machine may be used wherever the contract
/// is.
#[derive(Debug, Clone)]
pub struct RefinedContract {
    /// Name of the contract.
    pub contract: String,
    /// Formulas with these arguments.
    pub specification: Arc<Specification>,
    /// For every variable, in order, its value in the machine, over wires; `None` for the variables
    /// of monitors.
    pub bindings: Vec<Option<Expr>>,
    /// Place of its name.
    pub span: Span,
}

/// A set of skills that a machine calls.
#[derive(Debug, Clone)]
pub struct Orders {
    /// Skills and their orders; shared by machines that call the same ones.
    pub skills: Arc<Skills>,
    /// Level of the orders that the machine keeps.
    pub level: Level,
    /// One condition over wires per skill, in their order: it is being called in this step.
    pub when: Vec<Expr>,
    /// Inner machine that the skills belong to, `left.arm`; empty for the machine's own.
    pub of: String,
    /// Place of the set's name in the machine.
    pub span: Span,
}

/// Formulas over wires and over the variables of their monitors.
#[derive(Debug, Clone, Default)]
pub struct Rules {
    /// The formulas.
    pub side: Side,
    /// Variables of monitors, numbered after the wires.
    pub monitors: Vec<Variable>,
    /// Definitions of the monitors.
    pub definitions: Side,
}

/// A contract as a component of a machine.
#[derive(Debug, Clone)]
pub struct Component {
    /// Name in the machine: `pick_a`.
    pub name: String,
    /// Name of the contract: `Pick`.
    pub contract: String,
    /// Role: coordinator, action or watch.
    pub role: Role,
    /// Formulas of the contract with this component's arguments.
    pub specification: Arc<Specification>,
    /// One expression over wires per input of the specification, in that order.
    pub bindings: Vec<Expr>,
    /// Condition over wires that this action is being executed in this step. `None` for the
    /// coordinator.
    pub active: Option<Expr>,
    /// Duration of an execution.
    pub time: Option<ActionTime>,
    /// Power drawn while it is active, in watts, over the properties at the start of the operation.
    pub watts: RealExpr,
    /// Place of its name.
    pub span: Span,
}

/// Role of a component in the two layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The upper layer.
    Coordinator,
    /// The lower layer.
    Action,
    /// Beside both layers: receives the calls of skills, and assumes that the orders of its set are
    /// kept. It does nothing.
    Watch,
}

/// Duration of an action, in seconds, over the properties at the start of the operation.
#[derive(Debug, Clone, PartialEq)]
pub enum ActionTime {
    /// Duration of every step in which it is active.
    PerStep(RealExpr),
    /// Duration of one execution (a run of consecutive active steps), independent of its number of
    /// steps: charged to the first.
    PerExecution(RealExpr),
}

/// A wire set by the plant.
#[derive(Debug, Clone)]
pub struct PlantInput {
    /// Name of the wire.
    pub name: String,
    /// Domain of its values.
    pub domain: Domain,
    /// Unit, such as `deg`; empty for bare numbers.
    pub unit: String,
    /// Origin of its value in `simulate`.
    pub source: PlantSource,
    /// Place of its declaration.
    pub span: Span,
}

impl PlantInput {
    /// Formats the domain with its unit: `0..359 deg`.
    pub fn describe(&self) -> String {
        described(&self.domain, &self.unit)
    }
}

/// Origin of a plant wire's value in `simulate`.
#[derive(Debug, Clone)]
pub enum PlantSource {
    /// Value of the running operation.
    Operation,
    /// A signal of the plant: its value in step `i` (from 0, restarting for each call) is
    /// `script[i % script.len()]`. Never empty; one entry is a constant.
    Signal {
        /// Values of the script.
        script: Vec<i64>,
    },
    /// Abstraction of properties: this expression over the properties at the start, which must be
    /// an integer of the domain.
    Property(RealExpr),
}

/// A number of the part or a parameter of the operation, as `simulate` takes it. Arrays are
/// flattened.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name; an array's element is called `heights[2]`.
    pub name: String,
    /// Unit, such as `deg`; empty for a bare number.
    pub unit: String,
    /// Value if the part or the call has none.
    pub default: f64,
    /// Owner of the property: part or call.
    pub kind: PropertyKind,
    /// Domain, for truth values, labels or a range of whole numbers.
    pub domain: Option<Domain>,
    /// Place of its declaration.
    pub span: Span,
}

/// Owner of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PropertyKind {
    /// The mobile unit carries it.
    Part,
    /// The operation is called with it.
    Parameter,
}

/// An operation of the machine.
#[derive(Debug, Clone)]
pub struct Operation {
    /// Name: `emptying`.
    pub name: String,
    /// Taxonomy codes that it implements.
    pub codes: Vec<TaxonomyCode>,
    /// Actions that it executes, in order, as indices into [`Machine::components`].
    pub sequence: Vec<usize>,
    /// Value of the plant's operation wire that selects it.
    pub value: i64,
    /// Place of its declaration.
    pub span: Span,
}

/// Breakdowns of a machine: exponentially distributed, over its working time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Failures {
    /// Mean working time between failures, in seconds.
    pub mtbf: f64,
    /// Mean time to repair, in seconds.
    pub mttr: f64,
}

/// An expression over real numbers, as computed by the plant. Truth values are 0 and 1.
#[derive(Debug, Clone, PartialEq)]
pub enum RealExpr {
    /// A number.
    Number(f64),
    /// A property by its index.
    Property(usize),
    /// A wire by its index, after the last step.
    Wire(usize),
    /// An operator with one operand.
    Unary(RealUnary, Box<RealExpr>),
    /// An operator with two operands.
    Binary(RealBinary, Box<RealExpr>, Box<RealExpr>),
    /// `if c then a else b`; any value except 0 is true.
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
    /// `/`: real division.
    Div,
    /// `x - y * floor(x / y)`
    Mod,
    /// Minimum.
    Min,
    /// Maximum.
    Max,
}

impl RealExpr {
    /// Replaces properties and wires by other expressions.
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

    /// Converts a whole-number expression over wires.
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
            // Division of whole numbers rounds down.
            Expr::Binary(BinaryOp::Div, a, b) => {
                let ratio = Self::Binary(RealBinary::Div, sub(a), sub(b));
                Self::Unary(RealUnary::Floor, Box::new(ratio))
            }
            Expr::Binary(op, a, b) => Self::Binary(RealBinary::of(*op), sub(a), sub(b)),
            Expr::If(c, a, b) => Self::If(sub(c), sub(a), sub(b)),
        }
    }

    /// Evaluates the expression with these properties and wires.
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
    /// Returns the same operator on real numbers.
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
    /// Returns the first wire of component `index`.
    pub fn first_wire(&self, index: usize) -> usize {
        self.plant.len()
            + self.components[..index]
                .iter()
                .map(|c| c.specification.outputs().count())
                .sum::<usize>()
    }

    /// Returns the number of wires.
    pub fn wire_count(&self) -> usize {
        self.first_wire(self.components.len())
    }

    /// Returns the name of a wire: `grip` for the plant's, `pick_a.stage` for a component's.
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

    /// Returns the domain of a wire.
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

    /// Returns the machine as seen by proofs: inner machines are replaced by their promises.
    pub fn abstracted(&self) -> &Self {
        self.layers.abstracted.as_deref().unwrap_or(self)
    }

    /// Returns the coordinator, if there is one: component 0.
    pub fn coordinator(&self) -> Option<&Component> {
        self.components
            .first()
            .filter(|c| c.role == Role::Coordinator)
    }

    /// Returns the operation with a name.
    pub fn operation(&self, name: &str) -> Option<&Operation> {
        self.operations.iter().find(|o| o.name == name)
    }
}
