//! Lines: stations, conveyors, buffers, sources, sinks and stores, and the ways of the parts
//! between them.

use super::machine::{Failures, Machine, RealExpr};
use linewright_core::gr1::described;
use linewright_core::source::Span;
use std::sync::Arc;

/// A line, all names resolved to indices.
#[derive(Debug, Clone)]
pub struct Line {
    /// The name.
    pub name: String,
    /// The doc comment.
    pub doc: String,
    /// The types of mobile units.
    pub parts: Vec<PartType>,
    /// The end product: an index into `parts`.
    pub product: usize,
    /// Everything that a part can be in.
    pub nodes: Vec<Node>,
    /// The ways between them. For one part type and one `from` they are tried in order; the first
    /// whose condition holds is taken, and the part waits until its `to` has room.
    pub routes: Vec<Route>,
    /// What a run is checked against.
    pub requirements: Vec<Requirement>,
    /// When a run ends without `--parts` and `--until`.
    pub limit: Option<Limit>,
    /// Working hours; `None` is around the clock.
    pub shift: Option<Shift>,
    /// Where its name stands.
    pub span: Span,
}

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// So many end products in a sink or store.
    Products(u64),
    /// So many simulated seconds.
    Seconds(f64),
}

/// Daily working hours, in seconds from the start of the day; a run starts at time 0 of day 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// First second of work.
    pub from: f64,
    /// First second after work; later than `from`, at most 86 400.
    pub to: f64,
}

impl Shift {
    /// Seconds of a day.
    pub const DAY: f64 = 86_400.0;

    /// Seconds of work from the start of a run to this second of it.
    pub fn worked_until(&self, second: f64) -> f64 {
        let days = (second / Self::DAY).floor();
        let today = (second - days * Self::DAY).clamp(self.from, self.to) - self.from;
        days * (self.to - self.from) + today
    }
}

/// A type of mobile unit.
#[derive(Debug, Clone)]
pub struct PartType {
    /// The name.
    pub name: String,
    /// The numbers it carries; arrays are flattened to `heights[0]`.
    pub properties: Vec<PartProperty>,
    /// What it is joined from: part types and how many of each. Empty for one that comes from a
    /// source or store.
    pub bill: Vec<(usize, u32)>,
    /// Where it is declared.
    pub span: Span,
}

impl PartType {
    /// The first property whose value is not one of its domain; what has none may be any finite
    /// number.
    pub fn misfit(&self, values: &[f64]) -> Option<usize> {
        let mut properties = self.properties.iter().zip(values);
        properties.position(|(property, value)| match &property.domain {
            None => !value.is_finite(),
            Some(domain) => !domain.contains_real(*value),
        })
    }
}

/// One number that a part carries.
#[derive(Debug, Clone)]
pub struct PartProperty {
    /// The name.
    pub name: String,
    /// Its unit; empty for a bare number.
    pub unit: String,
    /// Its values, where they are truth values, labels or a range of whole numbers.
    pub domain: Option<linewright_core::gr1::Domain>,
    /// Its value in a new part.
    pub initial: InitialValue,
}

impl PartProperty {
    /// Its values as a person writes them, with their unit.
    pub fn describe(&self) -> String {
        match &self.domain {
            Some(domain) => described(domain, &self.unit),
            None => "finite numbers".to_owned(),
        }
    }
}

/// Where a new part's property comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialValue {
    /// A number.
    Number(f64),
    /// The property `.1` of the first component of part type `.0` that the part was joined from.
    Component(usize, usize),
}

/// A place in the line.
#[derive(Debug, Clone)]
pub struct Node {
    /// The name.
    pub name: String,
    /// What it is.
    pub kind: NodeKind,
    /// Where it is declared.
    pub span: Span,
}

/// What a place is.
#[derive(Debug, Clone)]
pub enum NodeKind {
    /// Makes new parts, and keeps one until there is room for it.
    Source {
        /// The part type.
        part: usize,
        /// When it makes them.
        supply: Supply,
        /// It makes none while so many of the type are in the line, by themselves or joined to
        /// others; the one that it keeps counts, too.
        most: Option<u32>,
    },
    /// Takes parts out of the line. `reject` counts them as rejected, and each one gives the source
    /// `reorder` (a node) a new order.
    Sink {
        /// Whether what arrives is scrap.
        reject: bool,
        /// The source that makes a replacement.
        reorder: Option<usize>,
    },
    /// Takes parts in, and gives out those it has in stock.
    Store {
        /// Part type and how many there are at the start.
        stock: Vec<(usize, u64)>,
    },
    /// An instance of a machine that performs operations on parts, one at a time.
    Station {
        /// The machine.
        machine: Arc<Machine>,
        /// What it does to which parts.
        tasks: Vec<Task>,
        /// Defects it makes, by chance.
        defects: Vec<Defect>,
        /// Seconds of setup when the part type differs from the one before.
        setup_seconds: f64,
        /// Breakdowns; the line's own statement, or else the machine's.
        failures: Option<Failures>,
    },
    /// A belt that carries parts in their order.
    Conveyor {
        /// How many parts fit.
        places: u32,
        /// Distance from place to place, in metres.
        pitch: f64,
        /// Metres a second.
        speed: f64,
        /// The contract that moves it, if any; otherwise it moves up by itself wherever there is
        /// room (accumulating).
        belt: Option<Belt>,
        /// Power drawn while it moves, in watts.
        watts: f64,
    },
    /// Room for parts that wait, first in, first out.
    Buffer {
        /// How many parts fit.
        capacity: u32,
    },
}

/// A conveyor's machine and the wires by which the runner drives it. It is stepped every
/// pitch/speed seconds.
#[derive(Debug, Clone)]
pub struct Belt {
    /// The machine; it has no operations.
    pub machine: Arc<Machine>,
    /// Plant wire: a part is put on place 0, if that is free.
    pub load: usize,
    /// Plant wire: what follows would take the part on the last place.
    pub unload_ready: usize,
    /// Component wires: place `i` is occupied.
    pub places: Vec<usize>,
    /// Component wire: place 0 is free.
    pub ready: usize,
}

/// How a source makes parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Supply {
    /// One every so many seconds, the first at 0; `limit` in all, if there is one.
    Every {
        /// Seconds between two; 0 is "whenever there is room".
        seconds: f64,
        /// Whether the time between two is exponentially distributed with that mean.
        random: bool,
        /// How many in all.
        limit: Option<u64>,
    },
    /// One an order: as many orders as end products are wanted (without end where only a time is
    /// given), and one more for each part that a sink sends back for a new one; each is for as many
    /// parts as are in one product (or in the part that was rejected), and at least one.
    OnOrder,
}

impl Supply {
    /// Whether the next part is there as soon as the one before has left, however many there were.
    pub fn is_endless(&self) -> bool {
        match self {
            Self::OnOrder => true,
            Self::Every { seconds, limit, .. } => *seconds <= 0.0 && limit.is_none(),
        }
    }
}

/// What a station does with a part that comes.
#[derive(Debug, Clone)]
pub struct Task {
    /// The part type that leaves. Where its bill is empty it is also the one that comes; otherwise
    /// the station waits for all that the bill names, and joins them. A station to which routes
    /// bring parts of this type works on them as they are even so (a camera that checks the joined
    /// product); it joins them as well only if routes also bring all of the components, and none of
    /// these has a task of its own there.
    pub part: usize,
    /// The operations, one after the other, as indices into the machine's operations, each with the
    /// values of the machine's parameters (index into its properties, value).
    pub operations: Vec<(usize, Vec<(usize, f64)>)>,
    /// For each of the machine's properties, the part's property that it reads and writes; `None`
    /// for parameters and for properties that the part does not carry (they have the machine's
    /// default, and writing is lost).
    pub properties: Vec<Option<usize>>,
    /// Where it is declared.
    pub span: Span,
}

/// A defect that a station makes by chance after its operations.
#[derive(Debug, Clone)]
pub struct Defect {
    /// In which part type.
    pub part: usize,
    /// How likely, from 0 to 1.
    pub probability: f64,
    /// One of these properties, each as likely as the others, ...
    pub properties: Vec<usize>,
    /// ... gets this value, over the part's properties before: `Property(i)` is property `i` of the
    /// part type, and `Property(n)`, where the part type has `n` properties, is the value of the
    /// one that was chosen.
    pub value: RealExpr,
    /// Where it is declared.
    pub span: Span,
}

/// A way of a part.
#[derive(Debug, Clone)]
pub struct Route {
    /// The part type.
    pub part: usize,
    /// From this node ...
    pub from: usize,
    /// ... to this one.
    pub to: usize,
    /// Over the part's properties: only when this is not 0. `None` is always.
    pub condition: Option<RealExpr>,
    /// Where it is declared.
    pub span: Span,
}

/// What a run is checked against: a comparison of a measured value with a number.
#[derive(Debug, Clone)]
pub struct Requirement {
    /// The name.
    pub name: String,
    /// What is measured.
    pub metric: Metric,
    /// How it is compared.
    pub comparison: Comparison,
    /// With what, in the metric's unit.
    pub bound: f64,
    /// Where it is declared.
    pub span: Span,
}

/// A measured value of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Metric {
    /// End products in their sink or store an hour.
    ThroughputPerHour,
    /// Seconds from the start to the last end product.
    MakespanSeconds,
    /// Mean seconds from a product's first part to its end.
    LeadTimeMeanSeconds,
    /// Kilowatt hours in all.
    EnergyKwh,
    /// Parts that were rejected.
    Rejected,
    /// End products.
    Products,
    /// Contract violations.
    Violations,
    /// The busy share of a station, from 0 to 1.
    Busy(usize),
}

/// How a metric is compared with its bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `=`
    Eq,
    /// `>=`
    Ge,
    /// `>`
    Gt,
}
