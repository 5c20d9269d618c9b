//! Lines: stations, conveyors, buffers, sources, sinks and stores, and the routes of parts between
//! them.

use super::calendar::WorkCalendar;
use super::distribution::Distribution;
use super::machine::{FailureMode, Machine, RealExpr};
pub use super::metric::{Measure, Metric};
use linewright_core::gr1::describe_domain;
use linewright_core::source::Span;
use std::ops::Range;
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
    /// End products, as indices into `parts`, each once; at least one in a line without errors.
    pub products: Vec<usize>,
    /// Every place in which a part can be.
    pub nodes: Vec<Node>,
    /// Routes between places, in order of priority. Of the routes for its type that start at its
    /// place, a part takes the first one whose condition holds. It waits until the place at the end
    /// of this route has room. Successive routes with the same [`Route::choice`] count as one.
    pub routes: Vec<Route>,
    /// How parts choose between routes; see [`Route::choice`].
    pub choices: Vec<Choice>,
    /// Requirements that a run has to meet.
    pub requirements: Vec<Requirement>,
    /// End of a run if neither `--parts` nor `--until` is given.
    pub limit: Option<Limit>,
    /// When the stations work that have no calendar of their own; `None` for work around the clock.
    pub calendar: Option<WorkCalendar>,
    /// The first day of a run, in days since 1970-01-01; `None` if the line does not give it.
    pub first_day: Option<i64>,
    /// Source position of the name.
    pub span: Span,
}

/// Condition that ends a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Number of end products that have arrived in a sink or store.
    Products(u64),
    /// Simulated time in seconds.
    Seconds(f64),
}

/// A type of mobile unit.
#[derive(Debug, Clone)]
pub struct PartType {
    /// Name of the part type.
    pub name: String,
    /// Properties that a part carries. Each element of an array is an entry of its own, such as
    /// `heights[0]`.
    pub properties: Vec<PartProperty>,
    /// Bill of materials: part types (indices) and their counts. Empty for a part that comes from a
    /// source or store.
    pub bill: Vec<(usize, u32)>,
    /// Source position of the declaration.
    pub span: Span,
}

impl PartType {
    /// Returns the index of the first property whose value is outside its domain. A property
    /// without a domain allows every finite number.
    #[inline]
    pub fn first_out_of_range(&self, values: &[f64]) -> Option<usize> {
        let mut properties = self.properties.iter().zip(values);
        properties.position(|(property, value)| match &property.domain {
            None => !value.is_finite(),
            Some(domain) => !domain.contains_real(*value),
        })
    }
}

/// A property that a part carries.
#[derive(Debug, Clone)]
pub struct PartProperty {
    /// Name of the property.
    pub name: String,
    /// Unit; empty for a bare number.
    pub unit: String,
    /// Domain of truth values, labels or a range of whole numbers; `None` for real numbers.
    pub domain: Option<linewright_core::gr1::Domain>,
    /// Value in a new part.
    pub initial: InitialValue,
}

impl PartProperty {
    /// Formats the domain with its unit; returns `finite numbers` if there is no domain.
    pub fn describe(&self) -> String {
        match &self.domain {
            Some(domain) => describe_domain(domain, &self.unit),
            None => "finite numbers".to_owned(),
        }
    }
}

/// Origin of a property's value in a new part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialValue {
    /// A number.
    Number(f64),
    /// The value that a component has: property `.1` of the first component with part type `.0`.
    Component(usize, usize),
}

/// A place in the line.
#[derive(Debug, Clone)]
pub struct Node {
    /// Name of the place.
    pub name: String,
    /// Kind of place.
    pub kind: NodeKind,
    /// Source position of the declaration.
    pub span: Span,
}

/// Returns the name that the file gives to a place: `capper` for `capper[2]`, one of several
/// stations of a declaration.
pub fn declared_name(name: &str) -> &str {
    name.split('[').next().unwrap_or(name)
}

impl Node {
    /// Returns the machine that controls the place: that of a station or a conveyor, if it has one.
    pub fn machine(&self) -> Option<&Arc<Machine>> {
        match &self.kind {
            NodeKind::Station(station) => station.machine.as_ref(),
            NodeKind::Conveyor { belt, .. } => belt.as_ref().map(|belt| &belt.machine),
            _ => None,
        }
    }
}

/// Kind of a place in the line.
#[derive(Debug, Clone)]
pub enum NodeKind {
    /// Makes new parts. A part that has no room in the next place stays in the source.
    Source {
        /// Type of the parts.
        part: usize,
        /// Times at which parts are made.
        supply: Supply,
        /// Maximum number of parts of this type in the line: the source makes no part while there
        /// are as many. The count includes single parts, parts that are joined to others, and the
        /// part that waits in the source.
        most: Option<u32>,
    },
    /// Takes parts out of the line.
    Sink {
        /// Whether arriving parts count as rejected.
        reject: bool,
        /// Node index of the source that receives a new order for each arriving part.
        reorder: Option<usize>,
    },
    /// Stores arriving parts, and releases parts from its stock.
    Store {
        /// Part types (indices) and their counts at the start.
        stock: Vec<(usize, u64)>,
    },
    /// Works on one part at a time.
    Station(Box<Station>),
    /// A conveyor that carries parts in their order.
    Conveyor {
        /// Capacity in parts.
        places: u32,
        /// Distance between places, in metres.
        pitch: f64,
        /// Speed in metres per second.
        speed: f64,
        /// Machine that controls the conveyor. `None` for an accumulating conveyor, on which parts
        /// move up whenever there is room.
        belt: Option<Belt>,
        /// Power drawn while moving, in watts.
        watts: f64,
    },
    /// Room for parts that wait.
    Buffer {
        /// Capacity in parts.
        capacity: u32,
        /// Which part leaves first, of those that are ready to leave.
        order: BufferOrder,
        /// Time that each part rests here before it is ready to leave.
        dwell: Distribution,
        /// Maximum time of a part here, in seconds. After it, the part is removed as scrap.
        shelf_life: Option<f64>,
    },
}

impl NodeKind {
    /// The kind of a place in a word, such as `station` or `sink for rejects`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Source { .. } => "source",
            Self::Sink { reject: true, .. } => "sink for rejects",
            Self::Sink { .. } => "sink",
            Self::Store { .. } => "store",
            Self::Station(_) => "station",
            Self::Conveyor { .. } => "conveyor",
            Self::Buffer { .. } => "buffer",
        }
    }

    /// The kind of a place, and how many parts it holds if that is limited: `buffer, 3 places`.
    pub fn description(&self) -> String {
        let places = match self {
            Self::Conveyor { places, .. } => *places,
            Self::Buffer { capacity, .. } => *capacity,
            _ => return self.word().to_owned(),
        };
        let unit = if places == 1 { "place" } else { "places" };
        format!("{}, {places} {unit}", self.word())
    }
}

/// Which part leaves a buffer first. Of parts that are alike in this, it is the one that came
/// first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum BufferOrder {
    /// The one that came first.
    #[default]
    FirstIn,
    /// The one that came last.
    LastIn,
    /// The one with the highest or the lowest value of a property.
    Property {
        /// Whether the highest value is first.
        highest: bool,
        /// By part type: the index of the property; `None` for types that do not come here.
        of: Vec<Option<usize>>,
    },
}

/// A conveyor that a machine controls, with the wires that connect the machine to the line. The
/// machine is stepped every pitch/speed seconds.
#[derive(Debug, Clone)]
pub struct Belt {
    /// Machine that controls the conveyor; it has no operations.
    pub machine: Arc<Machine>,
    /// Plant wire that is true while a part waits to be put on place 0.
    pub load: usize,
    /// Plant wire that is true while the next node can take the part on the last place.
    pub unload_ready: usize,
    /// Component wires; wire `i` is true while place `i` is occupied.
    pub places: Vec<usize>,
    /// Component wire that is true while a part can be put on place 0.
    pub ready: usize,
}

/// Times at which a source makes parts.
#[derive(Debug, Clone, PartialEq)]
pub enum Supply {
    /// One part per interval, the first at time 0.
    Every {
        /// Interval; if it is always 0, a part is made whenever there is room.
        interval: Distribution,
        /// Maximum number of parts in total; `None` for no limit.
        limit: Option<u64>,
    },
    /// One part at each of these instants.
    At {
        /// Seconds from the start of a run, in ascending order; at least one.
        instants: Arc<[f64]>,
    },
    /// Parts are made on order. There is one order for each end product of the run's limit
    /// (unlimited if only a time is given, or if the line has several end products), and one for
    /// each part that a sink reorders. An order is for as many parts as one product (or the
    /// rejected part) contains, but for at least one part.
    OnOrder,
}

/// A supply of this many parts at one instant counts as endless, because a run reports a million
/// movements at one instant as an error, and each part can move several times.
const ENDLESS_COUNT: u64 = 50_000;

/// Whether [`ENDLESS_COUNT`] of these instants, in ascending order, or more are the same.
fn come_together(instants: &[f64]) -> bool {
    let mut together = instants.chunk_by(|a, b| a >= b);
    together.any(|parts| parts.len() as u64 >= ENDLESS_COUNT)
}

impl Line {
    /// Returns whether a node supplies parts of this type endlessly, each as soon as the previous
    /// one has left. This is true of a source without waiting time, and of a store with a large
    /// stock. A source with a limit, or with given instants, also counts as endless if a sink
    /// reorders from it, because each order raises the number of parts.
    pub fn is_endless(&self, node: usize, part: usize) -> bool {
        match &self.nodes[node].kind {
            NodeKind::Source { supply, .. } => match supply {
                Supply::OnOrder => true,
                Supply::Every { interval, limit } => {
                    interval.is_zero()
                        && (limit.is_none_or(|n| n >= ENDLESS_COUNT)
                            || self.is_reordered_from(node))
                }
                // A replacement is made at once.
                Supply::At { instants } => come_together(instants) || self.is_reordered_from(node),
            },
            NodeKind::Store { stock } => {
                let of_part = stock.iter().filter(|(p, _)| *p == part);
                of_part.map(|(_, n)| *n).fold(0, u64::saturating_add) >= ENDLESS_COUNT
            }
            _ => false,
        }
    }

    /// Returns whether no part follows at once if those of a source leave the line at this end: the
    /// source has given instants, and the end does not order replacements from it.
    pub fn ends_supply(&self, source: usize, end: usize) -> bool {
        let NodeKind::Source {
            supply: Supply::At { instants },
            ..
        } = &self.nodes[source].kind
        else {
            return false;
        };
        let reorders = matches!(self.nodes[end].kind, NodeKind::Sink { reorder, .. } if reorder == Some(source));
        !reorders && !come_together(instants)
    }

    /// Returns a metric with its unit, for tables: `busy share of capper`.
    pub fn label_of(&self, metric: &Metric) -> String {
        self.with_places(metric.measure.info().label, metric)
    }

    /// Returns a metric with its unit as the subject of a sentence: `the busy share of capper`.
    pub fn subject_of(&self, metric: &Metric) -> String {
        self.with_places(metric.measure.info().subject, metric)
    }

    fn with_places(&self, words: &str, metric: &Metric) -> String {
        let words = metric.words(words);
        if let Some(product) = metric.product {
            let name = self.parts.get(product).map_or("?", |part| &part.name);
            return format!("{words} of type {name}");
        }
        if metric.nodes.is_empty() {
            return words;
        }
        let of = if metric.measure.info().of_line {
            " of"
        } else {
            ""
        };
        format!("{words}{of} {}", self.names_of(&metric.nodes))
    }

    /// Returns the name of a place, or of several that follow one another: `capper[1] to
    /// capper[3]`.
    pub fn names_of(&self, nodes: &Range<usize>) -> String {
        let name = |node: usize| self.nodes.get(node).map_or("?", |node| &node.name);
        if nodes.len() <= 1 {
            return name(nodes.start).to_owned();
        }
        format!("{} to {}", name(nodes.start), name(nodes.end - 1))
    }

    /// Returns the calendar by which a node works; `None` for a node that works around the clock. A
    /// node that is no station always does.
    pub fn calendar_of(&self, node: usize) -> Option<&WorkCalendar> {
        match &self.nodes[node].kind {
            NodeKind::Station(station) => station.calendar.as_ref().or(self.calendar.as_ref()),
            _ => None,
        }
    }

    /// Returns whether parts of this type are an end product.
    pub fn is_product(&self, part: usize) -> bool {
        self.products.contains(&part)
    }

    /// Returns the end product, if there is only one.
    pub fn only_product(&self) -> Option<usize> {
        match self.products[..] {
            [product] => Some(product),
            _ => None,
        }
    }

    /// Returns whether parts can leave the line at a node that is no sink or store: those in work
    /// at a station when a failure scraps them, and those that expire in a buffer.
    pub fn can_lose_parts(&self, node: usize) -> bool {
        match &self.nodes[node].kind {
            NodeKind::Station(station) => {
                let mut modes = station.failures.iter();
                modes.any(FailureMode::scraps_parts)
            }
            NodeKind::Buffer { shelf_life, .. } => shelf_life.is_some(),
            _ => false,
        }
    }

    /// Returns the stations that are given by their times.
    pub fn stations_without_machine(&self) -> impl Iterator<Item = &Node> {
        let nodes = self.nodes.iter();
        nodes.filter(|node| matches!(&node.kind, NodeKind::Station(s) if s.machine.is_none()))
    }

    /// Returns whether a sink reorders from this source.
    pub fn is_reordered_from(&self, source: usize) -> bool {
        let mut nodes = self.nodes.iter();
        nodes.any(|n| matches!(n.kind, NodeKind::Sink { reorder, .. } if reorder == Some(source)))
    }

    /// Returns the routes of which a part with these property values takes one when it leaves a
    /// node: a single route or all those of a choice; `None` if no condition holds.
    pub fn way(&self, node: usize, part: usize, values: &[f64]) -> Option<Range<usize>> {
        let first = self.routes.iter().position(|route| {
            let holds = |c: &RealExpr| c.eval(values, &[]) != 0.0;
            (route.from, route.part) == (node, part) && route.condition.as_ref().is_none_or(holds)
        })?;
        Some(first..self.end_of_way(first))
    }

    /// Returns the end (exclusive) of the routes that belong to the same choice as this one, from
    /// this one on.
    pub fn end_of_way(&self, route: usize) -> usize {
        let choice = self.routes[route].choice;
        let mut later = self.routes[route + 1..].iter();
        let others = later.position(|r| choice.is_none() || r.choice != choice);
        others.map_or(self.routes.len(), |n| route + 1 + n)
    }

    /// Returns the first route that belongs to the same choice as this one.
    pub fn first_of_way(&self, route: usize) -> usize {
        match self.routes[route].choice {
            None => route,
            choice => {
                let earlier = self.routes[..route].iter().rev();
                route - earlier.take_while(|r| r.choice == choice).count()
            }
        }
    }

    /// Returns whether parts that take this route may take another of the same choice instead,
    /// whichever of the places has room first.
    pub fn waits_for_any(&self, route: usize) -> bool {
        let choice = self.routes[route].choice;
        choice.is_some_and(|choice| self.choices[choice].waits_for_any())
    }

    /// Returns whether parts of this type have a route that ends at a node.
    pub fn is_brought(&self, node: usize, part: usize) -> bool {
        self.routes.iter().any(|r| r.to == node && r.part == part)
    }

    /// Returns whether a station joins components to parts of this type; see [`Task::part`]. False
    /// for parts without a bill of materials.
    pub fn is_joined_at(&self, node: usize, part: usize) -> bool {
        let NodeKind::Station(station) = &self.nodes[node].kind else {
            return false;
        };
        let tasks = &station.tasks;
        let bill = &self.parts[part].bill;
        let has_task = |part: usize| tasks.iter().any(|t| t.part == part);
        // If the joined part itself has a route to the station, its components might only pass
        // through. They are joined here only if each of them has a route to the station, and none
        // of them has a task of its own.
        let joins = !self.is_brought(node, part)
            || bill
                .iter()
                .all(|(c, _)| self.is_brought(node, *c) && !has_task(*c));
        has_task(part) && !bill.is_empty() && joins
    }
}

/// A station: it works on one part at a time.
#[derive(Debug, Clone, Default)]
pub struct Station {
    /// Machine of the station. `None` for a station that is given by its times: it has no
    /// controller, and its work takes as long as [`Task::time`] says.
    pub machine: Option<Arc<Machine>>,
    /// Work on each part type.
    pub tasks: Vec<Task>,
    /// Values that the station gives to the parts that it has worked on.
    pub settings: Vec<Setting>,
    /// Random defects, after the settings.
    pub defects: Vec<Defect>,
    /// Setup time, which passes when the part type differs from the previous one.
    pub setup: Distribution,
    /// Failure modes that the line declares or, if it declares none, the machine.
    pub failures: Vec<FailureMode>,
    /// When the station works, if it has a calendar of its own.
    pub calendar: Option<WorkCalendar>,
    /// Power drawn during work at a station without a machine, in watts.
    pub watts: f64,
    /// Power drawn when the station does not work, in watts.
    pub idle_watts: f64,
}

impl Station {
    /// Gives a part of this type the values that the station sets.
    #[inline]
    pub fn set_values(&self, part: usize, values: &mut [f64]) {
        if self.settings.is_empty() {
            return;
        }
        let mut new: Vec<(usize, f64)> = Vec::new();
        for setting in self.settings.iter().filter(|s| s.part == part) {
            new.push((setting.property, setting.value.eval(values, &[])));
        }
        for (property, value) in new {
            values[property] = value;
        }
    }
}

/// Work of a station on one part type.
#[derive(Debug, Clone)]
pub struct Task {
    /// Type of the part that leaves. If its bill is empty, parts of this type also arrive. If it
    /// has a bill, the station waits for all components in the bill, and joins them. There is one
    /// exception: if parts of this type arrive that are already joined (as at a camera that checks
    /// the product), the station works on these parts. It then joins components as well only if all
    /// of them have routes to the station, and none of them has a separate task there.
    pub part: usize,
    /// Operations in order, as indices into [`Machine::operations`], each with the values of its
    /// parameters: pairs (index into [`Machine::properties`], value).
    pub operations: Vec<(usize, Vec<(usize, f64)>)>,
    /// For each of the machine's properties, the property of the part that the machine reads and
    /// writes. `None` for parameters, and for properties that the part does not carry: these have
    /// the machine's default, and writes to them have no effect.
    pub properties: Vec<Option<usize>>,
    /// Duration of the work at a station without a machine; `None` where a controller determines
    /// the duration.
    pub time: Option<Distribution>,
    /// Source position of the declaration.
    pub span: Span,
}

/// A value that a station gives to a property of the parts that it has worked on.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Affected part type.
    pub part: usize,
    /// Property of the part type.
    pub property: usize,
    /// New value, computed from the values before all settings of the station.
    pub value: RealExpr,
    /// Source position of the declaration.
    pub span: Span,
}

/// A random defect after a station's work.
#[derive(Debug, Clone)]
pub struct Defect {
    /// Affected part type.
    pub part: usize,
    /// Probability, from 0 to 1.
    pub probability: f64,
    /// Properties, one of which is chosen at random with equal probability.
    pub properties: Vec<usize>,
    /// New value of the chosen property, computed from the old values: `Property(i)` is the old
    /// value of property `i` of the part type. `Property(n)`, where `n` is the number of properties
    /// of the part type, is the old value of the chosen property.
    pub value: RealExpr,
    /// Source position of the declaration.
    pub span: Span,
}

/// A route of a part type between two nodes.
#[derive(Debug, Clone)]
pub struct Route {
    /// Part type.
    pub part: usize,
    /// Node at which the route starts.
    pub from: usize,
    /// Node at which the route ends.
    pub to: usize,
    /// Condition over the part's properties; any value except 0 is true. `None` for a route without
    /// a condition.
    pub condition: Option<RealExpr>,
    /// Source position of the condition.
    pub condition_span: Option<Span>,
    /// Index into [`Line::choices`] of the choice to which the route belongs; `None` if it is the
    /// only one of its statement. The routes of a choice follow one another, start at the same
    /// place, are for the same part type, have the same condition, and end at different places.
    pub choice: Option<usize>,
    /// Source position of the declaration.
    pub span: Span,
}

/// How a part chooses between several routes.
#[derive(Debug, Clone, PartialEq)]
pub enum Choice {
    /// The first route to a place with room. If no place has room, the part waits for all of them,
    /// and goes to the one that takes it first.
    FirstFree,
    /// The same, but of the places with room, to the one with the fewest parts in it.
    ShortestQueue,
    /// One route after the other. The part waits until the place whose turn it is has room.
    RoundRobin,
    /// By chance. The part waits until the place that was drawn has room.
    Probability {
        /// Probability of each route, in order; greater than 0, with sum 1.
        shares: Vec<f64>,
    },
}

impl Choice {
    /// Whether a part waits for all places of the choice, not for one that is determined before.
    pub fn waits_for_any(&self) -> bool {
        matches!(self, Self::FirstFree | Self::ShortestQueue)
    }
}

/// A requirement on a run: a comparison of a metric with a number.
#[derive(Debug, Clone)]
pub struct Requirement {
    /// Name of the requirement.
    pub name: String,
    /// Metric that is compared.
    pub metric: Metric,
    /// Comparison operator.
    pub comparison: Comparison,
    /// Bound, in the metric's unit.
    pub bound: f64,
    /// Source position of the declaration.
    pub span: Span,
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
