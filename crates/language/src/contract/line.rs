//! Lines: stations, conveyors, buffers, sources, sinks and stores, and the routes of parts between
//! them.

use super::machine::{Failures, Machine, RealExpr};
use linewright_core::gr1::described;
use linewright_core::source::Span;
use std::sync::Arc;

/// A line with all names resolved to indices.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name of the line.
    pub name: String,
    /// Doc comment without slashes.
    pub doc: String,
    /// Types of mobile units.
    pub parts: Vec<PartType>,
    /// End product, as an index into `parts`.
    pub product: usize,
    /// Every place that a part can be in.
    pub nodes: Vec<Node>,
    /// Routes between places. For one part type and one `from` they are tried in order; the first
    /// whose condition holds is taken, and the part waits until its `to` has room.
    pub routes: Vec<Route>,
    /// Requirements that a run is checked against.
    pub requirements: Vec<Requirement>,
    /// End of a run without `--parts` and `--until`.
    pub limit: Option<Limit>,
    /// Working hours; `None` is around the clock.
    pub shift: Option<Shift>,
    /// Place of its name.
    pub span: Span,
}

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// After this many end products in a sink or store.
    Products(u64),
    /// After this many simulated seconds.
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
    /// Number of seconds in a day.
    pub const DAY: f64 = 86_400.0;

    /// Returns the working seconds from the start of a run to this second of it.
    pub fn worked_until(&self, second: f64) -> f64 {
        let days = (second / Self::DAY).floor();
        let today = (second - days * Self::DAY).clamp(self.from, self.to) - self.from;
        days * (self.to - self.from) + today
    }
}

/// A type of mobile unit.
#[derive(Debug, Clone)]
pub struct PartType {
    /// Name of the part type.
    pub name: String,
    /// Numbers that a part carries; arrays are flattened to `heights[0]`.
    pub properties: Vec<PartProperty>,
    /// Bill of materials: part types and their counts. Empty for a part that comes from a source or
    /// store.
    pub bill: Vec<(usize, u32)>,
    /// Place of its declaration.
    pub span: Span,
}

impl PartType {
    /// Returns the first property whose value is outside its domain. Without a domain, any finite
    /// number is allowed.
    pub fn misfit(&self, values: &[f64]) -> Option<usize> {
        let mut properties = self.properties.iter().zip(values);
        properties.position(|(property, value)| match &property.domain {
            None => !value.is_finite(),
            Some(domain) => !domain.contains_real(*value),
        })
    }
}

/// A number that a part carries.
#[derive(Debug, Clone)]
pub struct PartProperty {
    /// Name of the property.
    pub name: String,
    /// Unit; empty for a bare number.
    pub unit: String,
    /// Domain, for truth values, labels or a range of whole numbers.
    pub domain: Option<linewright_core::gr1::Domain>,
    /// Value in a new part.
    pub initial: InitialValue,
}

impl PartProperty {
    /// Formats the domain with its unit.
    pub fn describe(&self) -> String {
        match &self.domain {
            Some(domain) => described(domain, &self.unit),
            None => "finite numbers".to_owned(),
        }
    }
}

/// Origin of a new part's property.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialValue {
    /// A number.
    Number(f64),
    /// Property `.1` of the first component of part type `.0` that the part was joined from.
    Component(usize, usize),
}

/// A place in the line.
#[derive(Debug, Clone)]
pub struct Node {
    /// Name of the place.
    pub name: String,
    /// Kind of place.
    pub kind: NodeKind,
    /// Place of its declaration.
    pub span: Span,
}

/// Kind of a place in the line.
#[derive(Debug, Clone)]
pub enum NodeKind {
    /// Makes new parts, and keeps one until there is room for it.
    Source {
        /// Part type that it makes.
        part: usize,
        /// When it makes parts.
        supply: Supply,
        /// Maximum number of parts of the type in the line, by themselves or joined to others, at
        /// which it stops making more. The part that it keeps counts, too.
        most: Option<u32>,
    },
    /// Takes parts out of the line. `reject` counts them as rejected, and each one gives the source
    /// `reorder` (a node) a new order.
    Sink {
        /// Whether arriving parts are scrap.
        reject: bool,
        /// Source that makes a replacement.
        reorder: Option<usize>,
    },
    /// Takes parts in, and gives out those in stock.
    Store {
        /// Part types and their counts at the start.
        stock: Vec<(usize, u64)>,
    },
    /// An instance of a machine that performs operations on parts, one at a time.
    Station {
        /// Machine of the station.
        machine: Arc<Machine>,
        /// Operations on each part type.
        tasks: Vec<Task>,
        /// Random defects.
        defects: Vec<Defect>,
        /// Setup time in seconds when the part type differs from the previous one.
        setup_seconds: f64,
        /// Breakdowns; from the line's own statement, or else the machine's.
        failures: Option<Failures>,
    },
    /// A belt that carries parts in their order.
    Conveyor {
        /// Capacity in parts.
        places: u32,
        /// Distance between places, in metres.
        pitch: f64,
        /// Speed in metres per second.
        speed: f64,
        /// Contract that moves it, if any; otherwise parts move up by themselves wherever there is
        /// room (accumulating).
        belt: Option<Belt>,
        /// Power drawn while moving, in watts.
        watts: f64,
    },
    /// Room for parts that wait, first in, first out.
    Buffer {
        /// Capacity in parts.
        capacity: u32,
    },
}

/// A conveyor's machine and the wires by which the runner drives it. It is stepped every
/// pitch/speed seconds.
#[derive(Debug, Clone)]
pub struct Belt {
    /// Machine of the belt; it has no operations.
    pub machine: Arc<Machine>,
    /// Plant wire: a part is put on place 0, if that is free.
    pub load: usize,
    /// Plant wire: the next node would take the part on the last place.
    pub unload_ready: usize,
    /// Component wires: place `i` is occupied.
    pub places: Vec<usize>,
    /// Component wire: place 0 is free.
    pub ready: usize,
}

/// How a source makes parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Supply {
    /// One part per interval, the first at time 0; `limit` in total, if given.
    Every {
        /// Interval in seconds; 0 means whenever there is room.
        seconds: f64,
        /// Whether the interval is exponentially distributed with that mean.
        random: bool,
        /// Maximum number of parts in total.
        limit: Option<u64>,
    },
    /// On order. There are as many orders as end products are wanted (unlimited if only a time is
    /// given), and one more for each part that a sink reorders. Each order is for the number of
    /// these parts in one product (or in the rejected part), at least one.
    OnOrder,
}

/// Number of parts that counts as endless if they move at one instant: a run takes a million
/// movements at one instant for no progress, and a part may make several.
const ENDLESS: u64 = 50_000;

impl Line {
    /// Returns whether a source, or the stock of a store, has another part of this type as soon as
    /// the previous one has left, without end. An order raises the limit of a source, so it never
    /// runs out if a sink orders from it again.
    pub fn is_endless(&self, node: usize, part: usize) -> bool {
        match &self.nodes[node].kind {
            NodeKind::Source { supply, .. } => match *supply {
                Supply::OnOrder => true,
                Supply::Every { seconds, limit, .. } => {
                    seconds <= 0.0 && (limit.is_none_or(|n| n >= ENDLESS) || self.reorders(node))
                }
            },
            NodeKind::Store { stock } => {
                let of_part = stock.iter().filter(|(p, _)| *p == part);
                of_part.map(|(_, n)| *n).fold(0, u64::saturating_add) >= ENDLESS
            }
            _ => false,
        }
    }

    /// Whether a sink orders from this source again.
    fn reorders(&self, source: usize) -> bool {
        let mut nodes = self.nodes.iter();
        nodes.any(|n| matches!(n.kind, NodeKind::Sink { reorder, .. } if reorder == Some(source)))
    }
}

/// A station's work on an arriving part.
#[derive(Debug, Clone)]
pub struct Task {
    /// Part type that leaves. If its bill is empty, it is also the type that arrives; otherwise the
    /// station waits for all components in the bill, and joins them. If routes bring parts of this
    /// type to the station, it works on them as they are nevertheless (a camera that checks the
    /// joined product). It joins them as well only if routes also bring all of the components, and
    /// none of these has a separate task there.
    pub part: usize,
    /// Operations in order, as indices into the machine's operations, each with the values of the
    /// machine's parameters (index into its properties, value).
    pub operations: Vec<(usize, Vec<(usize, f64)>)>,
    /// For each of the machine's properties, the part's property that it reads and writes; `None`
    /// for parameters and for properties that the part does not carry (they have the machine's
    /// default, and writes to them are lost).
    pub properties: Vec<Option<usize>>,
    /// Place of its declaration.
    pub span: Span,
}

/// A random defect after a station's operations.
#[derive(Debug, Clone)]
pub struct Defect {
    /// Affected part type.
    pub part: usize,
    /// Probability, from 0 to 1.
    pub probability: f64,
    /// Properties of which one is chosen, with equal probability.
    pub properties: Vec<usize>,
    /// New value of the chosen property, over the part's properties before: `Property(i)` is
    /// property `i` of the part type, and `Property(n)`, where the part type has `n` properties, is
    /// the value of the chosen one.
    pub value: RealExpr,
    /// Place of its declaration.
    pub span: Span,
}

/// A route of a part type between two nodes.
#[derive(Debug, Clone)]
pub struct Route {
    /// Part type.
    pub part: usize,
    /// Node where it starts.
    pub from: usize,
    /// Node where it ends.
    pub to: usize,
    /// Condition over the part's properties: taken only if this is not 0. `None` is always.
    pub condition: Option<RealExpr>,
    /// Place of its declaration.
    pub span: Span,
}

/// A requirement of a run: compares a measured value with a number.
#[derive(Debug, Clone)]
pub struct Requirement {
    /// Name of the requirement.
    pub name: String,
    /// Measured value.
    pub metric: Metric,
    /// Comparison operator.
    pub comparison: Comparison,
    /// Bound, in the metric's unit.
    pub bound: f64,
    /// Place of its declaration.
    pub span: Span,
}

/// A measured value of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Metric {
    /// End products per hour in their sink or store.
    ThroughputPerHour,
    /// Seconds from the start to the last end product.
    MakespanSeconds,
    /// Mean time from a product's first part to its end, in seconds.
    LeadTimeMeanSeconds,
    /// Total energy in kilowatt hours.
    EnergyKwh,
    /// Number of rejected parts.
    Rejected,
    /// Number of end products.
    Products,
    /// Number of contract violations.
    Violations,
    /// Busy share of a station, from 0 to 1.
    Busy(usize),
}

/// Comparison of a metric with its bound.
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
