//! Machines: a coordinator and actions that are wired together, with their durations, powers and
//! properties in the plant.
//!
//! # Wires
//!
//! In one step a machine computes a vector of `i64` *wires*: first the plant's inputs
//! ([`Machine::plant`]), then every output and internal variable of every component, in the order
//! of [`Machine::components`] and, within a component, in the order of its specification
//! ([`Machine::first_wire`]). Bindings are expressions over wires, in which `VarId(i)` with
//! `Time::Now` is wire `i`. They contain only current values.
//!
//! # One step
//!
//! 1. The caller sets the plant's wires. A value outside its domain is an error.
//! 2. All Moore components, including the coordinators, write their outputs to their wires. The
//!    machine's own coordinator is component 0 if there is one.
//! 3. The actions follow in order. For each action, the inputs are computed from its bindings, and
//!    its assumptions are checked. If it is a Mealy machine, it then writes its outputs to its
//!    wires.
//! 4. The inputs of the coordinators are computed, and their assumptions are checked. Then all
//!    components change their state at the same time.
//!
//! If an assumption is violated, the step ends with an error and no state changes.
//!
//! # Layers
//!
//! A machine can have machines as components. This model is flat nevertheless: the components of an
//! inner machine `left` are listed among the others, as `left.pick`; the coordinators of all layers
//! come first. Code generation and execution do not depend on the layers. [`Layers`] records the
//! structure for proofs.

use super::TaxonomyCode;
use super::distribution::Distribution;
use crate::order::{Level, Skills};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Owner, Side, Specification, UnaryOp, Variable, describe_domain,
};
use linewright_core::source::Span;
pub use linewright_syntax::ast::InterruptedWork;
use std::sync::Arc;

/// A machine with values for all its parameters.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Name of the machine.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Taxonomy codes that the machine implements.
    pub codes: Vec<TaxonomyCode>,
    /// Components: the coordinator first (if there is one), followed by those of inner machines,
    /// then the actions in order of declaration, then the watches.
    pub components: Vec<Component>,
    /// Wires that the plant sets.
    pub plant: Vec<PlantInput>,
    /// Properties of the part and parameters of the operations; `simulate` accepts a value for
    /// each.
    pub properties: Vec<Property>,
    /// Operations; at least one for a machine with a coordinator. The plant input with the source
    /// [`PlantSource::Operation`] selects one by its [`Operation::value`].
    pub operations: Vec<Operation>,
    /// Writes to the part at the end of an operation: property `.0` gets the value `.1`, computed
    /// from the wires after the last step and the properties at the start. All values are computed
    /// before the first one is written.
    pub writes: Vec<(usize, RealExpr)>,
    /// Whether the operation has ended, as a condition over wires. `None` for a machine without
    /// operations, which is only stepped.
    pub done: Option<Expr>,
    /// Duration of a step in which no action is active, in seconds.
    pub step_seconds: f64,
    /// Power drawn while an operation runs, in watts, in addition to the power of the actions.
    pub base_watts: f64,
    /// Power drawn while the machine waits, in watts.
    pub idle_watts: f64,
    /// Number of steps after which an unfinished operation counts as failed.
    pub step_limit: u64,
    /// Failure modes.
    pub failures: Vec<FailureMode>,
    /// Contracts that the machine is declared to refine.
    pub refines: Vec<RefinedContract>,
    /// Guarantees of the whole machine, over wires.
    pub guarantees: Rules,
    /// Skill sets that the machine calls, with their orders: first its own sets, then those of
    /// inner machines.
    pub orders: Vec<SkillOrders>,
    /// Inner machines, for proofs layer by layer.
    pub layers: Layers,
    /// Source position of the name.
    pub span: Span,
}

/// Inner machines of a machine; empty if it has none.
#[derive(Debug, Clone, Default)]
pub struct Layers {
    /// Machines one layer below, in the order of their declaration.
    pub inner: Vec<InnerMachine>,
    /// Abstraction of the machine for proofs: an inner machine that refines a contract is replaced
    /// by one component with that contract. `None` if there are no inner machines.
    pub abstraction: Option<Arc<Machine>>,
}

/// An inner machine.
#[derive(Debug, Clone)]
pub struct InnerMachine {
    /// Name within the outer machine: `left`.
    pub name: String,
    /// The machine by itself, with the arguments that the outer machine gives it.
    pub machine: Arc<Machine>,
    /// Source position of the name.
    pub span: Span,
}

/// A contract that a machine is declared to refine: the machine can be used wherever the contract
/// is used.
#[derive(Debug, Clone)]
pub struct RefinedContract {
    /// Name of the contract.
    pub contract: String,
    /// Formulas of the contract with its arguments.
    pub specification: Arc<Specification>,
    /// Value of every variable of the specification in the machine, over wires; `None` for
    /// variables of monitors.
    pub bindings: Vec<Option<Expr>>,
    /// Source position of the name.
    pub span: Span,
}

/// A skill set that a machine calls, with its orders.
#[derive(Debug, Clone)]
pub struct SkillOrders {
    /// Skills and their orders; shared by all machines that call them.
    pub skills: Arc<Skills>,
    /// Level of the orders with which the machine has to comply.
    pub level: Level,
    /// For each skill, in order, whether it is called in this step, as a condition over wires.
    pub when: Vec<Expr>,
    /// Path of the inner machine that calls the skills, such as `left.arm`; empty for the machine
    /// itself.
    pub caller: String,
    /// Source position of the set's name in the machine.
    pub span: Span,
}

/// Formulas over wires and over the variables of their monitors.
#[derive(Debug, Clone, Default)]
pub struct Rules {
    /// The formulas.
    pub side: Side,
    /// Variables of monitors; their ids follow those of the wires.
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
    /// One expression over wires for each input of the specification, in the same order.
    pub bindings: Vec<Expr>,
    /// Whether this action is active in this step, as a condition over wires. `None` for a
    /// component without such a condition, such as a coordinator.
    pub active: Option<Expr>,
    /// Duration of an execution.
    pub time: Option<ActionTime>,
    /// Power drawn while the action is active, in watts, as an expression over the properties at
    /// the start of the operation.
    pub watts: RealExpr,
    /// Source position of the name.
    pub span: Span,
}

/// Role of a component in a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// Decides which actions run.
    Coordinator,
    /// Runs when the coordinator requests it.
    Action,
    /// Observes the calls of skills. Its assumptions are the orders of the skill set, so a call
    /// that breaks an order violates an assumption. It has no influence on the machine.
    Watch,
}

/// Duration of an action, in seconds, as an expression over the properties at the start of the
/// operation.
#[derive(Debug, Clone, PartialEq)]
pub enum ActionTime {
    /// Duration of every step in which the action is active.
    PerStep(RealExpr),
    /// Duration of one execution (a run of consecutive active steps), regardless of the number of
    /// steps. The first step takes all of it.
    PerExecution(RealExpr),
}

/// A wire set by the plant.
#[derive(Debug, Clone)]
pub struct PlantInput {
    /// Name of the wire.
    pub name: String,
    /// Domain of its values.
    pub domain: Domain,
    /// Unit, such as `deg`; empty for a bare number.
    pub unit: String,
    /// Origin of the value in `simulate`.
    pub source: PlantSource,
    /// Source position of the declaration.
    pub span: Span,
}

impl PlantInput {
    /// The wire as an input of a specification.
    pub fn variable(&self) -> Variable {
        Variable {
            name: self.name.clone(),
            owner: Owner::Environment,
            internal: false,
            domain: self.domain.clone(),
            unit: self.unit.clone(),
            span: self.span,
        }
    }

    /// Formats the domain with its unit: `0..359 deg`.
    pub fn describe(&self) -> String {
        describe_domain(&self.domain, &self.unit)
    }
}

/// Origin of a plant wire's value in `simulate`.
#[derive(Debug, Clone)]
pub enum PlantSource {
    /// Value of the running operation.
    Operation,
    /// A signal of the plant: its value in step `i` of an operation (counted from 0) is
    /// `script[i % script.len()]`. The script is never empty; a constant has one entry.
    Signal {
        /// Values of the script.
        script: Vec<i64>,
    },
    /// Abstraction of properties: the value of this expression over the properties at the start of
    /// the operation. It must be an integer in the domain of the wire.
    Property(RealExpr),
}

/// A property of the part or a parameter of the operation, for which `simulate` accepts a value. An
/// array has one entry per element.
#[derive(Debug, Clone)]
pub struct Property {
    /// Name; an array's element is called `heights[2]`.
    pub name: String,
    /// Unit, such as `deg`; empty for a bare number.
    pub unit: String,
    /// Value if neither the part nor the call gives one.
    pub default: f64,
    /// Who gives the value: the part or the call.
    pub kind: PropertyKind,
    /// Domain of truth values, labels or a range of whole numbers; `None` for real numbers.
    pub domain: Option<Domain>,
    /// Source position of the declaration.
    pub span: Span,
}

/// Origin of a property's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PropertyKind {
    /// The part carries the value.
    Part,
    /// The call of the operation gives the value.
    Parameter,
}

/// An operation of the machine.
#[derive(Debug, Clone)]
pub struct Operation {
    /// Name, such as `emptying`.
    pub name: String,
    /// Taxonomy codes that the machine implements.
    pub codes: Vec<TaxonomyCode>,
    /// Actions in the order of their execution, as indices into [`Machine::components`].
    pub sequence: Vec<usize>,
    /// Value of the plant's operation wire that selects this operation.
    pub value: i64,
    /// Source position of the declaration.
    pub span: Span,
}

/// A way in which a machine breaks down. While it is broken down, it does not work.
#[derive(Debug, Clone, PartialEq)]
pub struct FailureMode {
    /// Name of the mode; empty for the only one that needs none.
    pub name: String,
    /// What lies between the end of a repair and the next failure.
    pub between: Between,
    /// Time to repair.
    pub repair: Distribution,
    /// What happens to the work that a failure interrupts.
    pub interrupted: InterruptedWork,
}

impl FailureMode {
    /// Returns whether it scraps parts. Failures after a number of parts interrupt no work.
    pub fn scraps_parts(&self) -> bool {
        self.interrupted == InterruptedWork::ScrapsPart
            && !matches!(self.between, Between::Parts(_) | Between::DrawnParts(_))
    }
}

/// What lies between the end of a repair and the next failure.
#[derive(Debug, Clone, PartialEq)]
pub enum Between {
    /// Time in which the machine works on a part.
    Working(Distribution),
    /// Time by the calendar. A machine can break down while it waits.
    Calendar(Distribution),
    /// A number of finished parts, at least 1.
    Parts(u64),
    /// A number of finished parts that is drawn: each draw is rounded to a whole number that is at
    /// least 1.
    DrawnParts(Distribution),
}

/// An expression over real numbers, as computed by the plant. Truth values are 0 and 1.
#[derive(Debug, Clone, PartialEq)]
pub enum RealExpr {
    /// A number.
    Number(f64),
    /// The value of the property with this index.
    Property(usize),
    /// The value of the wire with this index after the last step.
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

    /// Calls `visit` with every property and every wire in the expression.
    pub fn for_each(&self, visit: &mut impl FnMut(&Self)) {
        match self {
            Self::Number(_) => {}
            Self::Property(_) | Self::Wire(_) => visit(self),
            Self::Unary(_, a) => a.for_each(visit),
            Self::Binary(_, a, b) => {
                a.for_each(visit);
                b.for_each(visit);
            }
            Self::If(c, a, b) => {
                c.for_each(visit);
                a.for_each(visit);
                b.for_each(visit);
            }
        }
    }

    /// Converts an integer expression over wires.
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
            // Integer division rounds down.
            Expr::Binary(BinaryOp::Div, a, b) => {
                let ratio = Self::Binary(RealBinary::Div, sub(a), sub(b));
                Self::Unary(RealUnary::Floor, Box::new(ratio))
            }
            Expr::Binary(op, a, b) => Self::Binary(RealBinary::of(*op), sub(a), sub(b)),
            Expr::If(c, a, b) => Self::If(sub(c), sub(a), sub(b)),
        }
    }

    /// Evaluates the expression with these values of properties and wires. A comparison or a
    /// Boolean operator returns 0 or 1.
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
                #[expect(clippy::float_cmp, reason = "the language defines equality as exact")]
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
    /// Returns the operator on real numbers that corresponds to an operator on integers. `Div`
    /// becomes real division.
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
    /// Returns the index of the first wire of component `index`, or the number of wires if `index`
    /// is the number of components.
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

    /// Returns the name of a wire: `grip` for a wire of the plant, `pick_a.stage` for a wire of a
    /// component, `wire N` for an invalid index.
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
    /// When `wire` is not below [`Machine::wire_count`].
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
        domain.expect("the wire is not one of this machine; please report this")
    }

    /// Returns the abstraction of the machine for proofs, in which the inner machines are replaced
    /// by the contracts that they refine; the machine itself if it has no inner machines.
    pub fn abstraction(&self) -> &Self {
        self.layers.abstraction.as_deref().unwrap_or(self)
    }

    /// Returns the coordinator, if there is one: component 0.
    pub fn coordinator(&self) -> Option<&Component> {
        self.components
            .first()
            .filter(|c| c.role == Role::Coordinator)
    }

    /// Returns the operation with this name.
    pub fn operation(&self, name: &str) -> Option<&Operation> {
        self.operations.iter().find(|o| o.name == name)
    }
}
