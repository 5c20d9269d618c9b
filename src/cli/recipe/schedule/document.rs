//! A plan as part of the JSON document.

use super::quantity::{gap, number, time};
use super::{Section, View, owner, product};
use crate::cli::recipe::plan::MoveEntry;
use crate::engine::recipes::words;
use crate::recipe::plan::{Entry, EntrySubject, HeldPart, Method, Next, Objective};
use schemars::JsonSchema;
use serde::Serialize;

/// A plan of several products, or with least time, energy or transfers.
#[derive(JsonSchema, Serialize)]
pub(in crate::cli::recipe) struct ProductsPlan {
    /// What it has least of, in the worst case over the outcomes of the tests, until all products
    /// are finished or a product closes a loop of its recipe.
    value: f64,
    /// Unit of the value.
    unit: PlanUnit,
    /// No plan has a smaller value.
    lower_bound: f64,
    /// How much of the value is above its lower bound, from 0 to 1.
    gap: f64,
    /// Whether it is proved that no plan has a smaller value.
    is_least: bool,
    /// How the plan was found.
    method: PlanMethod,
    /// If the products are made one after the other: the recipes in their order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    order: Vec<String>,
    /// Whether a replay with other code has confirmed the plan. Only such plans are printed.
    verified: bool,
    /// Unit of all times.
    time_unit: TimeUnit,
    /// The recipe of each product. Product 1 is the first.
    products: Vec<String>,
    /// The names of the resources.
    resources: Vec<String>,
    /// The parts of the schedule between tests. It starts in the first.
    sections: Vec<ScheduleSection>,
}

/// Unit of a value.
#[derive(JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum PlanUnit {
    /// Steps that resources take together.
    Steps,
    /// Seconds.
    #[serde(rename = "s")]
    Seconds,
    /// Joules.
    #[serde(rename = "J")]
    Joules,
    /// Transfers from one resource to another.
    Transfers,
}

/// Unit of times.
#[derive(JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::cli::recipe) enum TimeUnit {
    /// Steps that resources take together.
    Steps,
    /// Seconds.
    #[serde(rename = "s")]
    Seconds,
}

/// How a plan was found.
#[derive(JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum PlanMethod {
    /// By a search over all plans.
    Search,
    /// By making one product after the other. Other orders, and products that are made at the same
    /// time, may be better.
    OneAfterTheOther,
    /// From the schedule with ample buffers.
    JobShop,
}

/// A part of a schedule, up to a test or to the end. Times count from the beginning of its
/// position.
#[derive(JsonSchema, Serialize)]
pub(in crate::cli::recipe) struct ScheduleSection {
    /// Its number: `2` for the second position, `2.1` for the first outcome of its first test.
    number: String,
    /// If it begins with a position: the state of each resource.
    #[serde(skip_serializing_if = "Option::is_none")]
    resource_states: Option<Vec<String>>,
    /// If it begins with a position: the parts that each resource holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<Vec<Vec<PlanPart>>>,
    /// If it begins with the outcome of a test: that outcome.
    #[serde(skip_serializing_if = "Option::is_none")]
    outcome: Option<ScheduleOutcome>,
    /// What each resource does, in the order in which it is decided.
    moves: Vec<ScheduleMove>,
    /// When it ends.
    end: f64,
    /// The sections that can follow, one for each outcome of the test; none at the end.
    then: Vec<String>,
    /// Whether a product has closed a loop of its recipe, which ends the count of the value.
    closes_loop: bool,
}

/// A part in a resource.
#[derive(JsonSchema, Serialize)]
struct PlanPart {
    /// The name of the part, or the type of a part in stock.
    name: String,
    /// The number of the product to which it belongs, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    product: Option<usize>,
}

/// Outcome of a test.
#[derive(JsonSchema, Serialize)]
struct ScheduleOutcome {
    /// The time of the test.
    time: f64,
    /// The number of the tested product.
    product: usize,
    /// The transition that is taken: `b -> c when visionOk(h2)`.
    transition: String,
}

/// What one resource does.
#[derive(JsonSchema, Serialize)]
struct ScheduleMove {
    /// The number of the event in the position. The two sides of a transfer, and the operations of
    /// one step, have the same.
    event: usize,
    /// When it begins.
    start: f64,
    /// When it ends.
    end: f64,
    /// The number of the product that it is about, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    product: Option<usize>,
    #[serde(flatten)]
    what: MoveEntry,
    /// Whether it is on the critical path; only with least steps or time.
    is_critical: bool,
}

impl ProductsPlan {
    /// Describes a plan.
    pub(in crate::cli::recipe) fn new(view: &View<'_>) -> Self {
        let plan = view.plan;
        let (method, order) = match &plan.method {
            Method::Search => (PlanMethod::Search, [].as_slice()),
            Method::JobShop => (PlanMethod::JobShop, [].as_slice()),
            Method::OneAfterTheOther(order) => (PlanMethod::OneAfterTheOther, order.as_slice()),
        };
        let name = |demand: &usize| view.recipes[*demand].name.clone();
        let is_lockstep = plan.objective == Objective::Steps;
        Self {
            value: number(plan.objective, plan.value),
            unit: match plan.objective {
                Objective::Steps => PlanUnit::Steps,
                Objective::Time => PlanUnit::Seconds,
                Objective::Energy => PlanUnit::Joules,
                Objective::Transfers => PlanUnit::Transfers,
            },
            lower_bound: number(plan.objective, plan.lower_bound),
            gap: gap(plan),
            is_least: plan.is_least(),
            method,
            order: order.iter().map(name).collect(),
            verified: true,
            time_unit: if is_lockstep {
                TimeUnit::Steps
            } else {
                TimeUnit::Seconds
            },
            products: plan.products.iter().map(name).collect(),
            resources: (view.layout.resources.iter())
                .map(|r| r.name.clone())
                .collect(),
            sections: sections(view),
        }
    }
}

/// Describes the schedule of a plan.
pub(in crate::cli::recipe) fn sections(view: &View<'_>) -> Vec<ScheduleSection> {
    view.sections().iter().map(|s| section(view, s)).collect()
}

fn section(view: &View<'_>, section: &Section<'_>) -> ScheduleSection {
    let plan = view.plan;
    let position = &plan.positions[section.position];
    let is_first = section.begins.is_none();
    let states = || {
        let states = view.layout.resources.iter().zip(&position.resource_states);
        states
            .map(|(r, state)| r.states[*state].name.clone())
            .collect()
    };
    let part = |held: &HeldPart| PlanPart {
        name: held.name.clone(),
        product: owner(held).map(|p| p + 1),
    };
    let parts = || {
        let held = position.parts.iter();
        held.map(|all| all.iter().map(part).collect()).collect()
    };
    let (end, then, closes_loop) = match &section.schedule.then {
        Next::End { time } => (time, Vec::new(), false),
        Next::Goto {
            time,
            position,
            closes_loop,
        } => (time, vec![(position + 1).to_string()], *closes_loop),
        Next::Test { time, outcomes, .. } => {
            let numbers = (0..outcomes.len()).map(|at| view.number_after(section, at));
            (time, numbers.collect(), false)
        }
    };
    ScheduleSection {
        number: section.number.clone(),
        resource_states: is_first.then(states),
        parts: is_first.then(parts),
        outcome: section.begins.map(|outcome| ScheduleOutcome {
            time: time(plan, outcome.time),
            product: outcome.product + 1,
            transition: words::transition(
                &view.recipe(outcome.product).transitions[outcome.transition],
            ),
        }),
        moves: (section.schedule.entries.iter())
            .map(|entry| moved(view, section, entry))
            .collect(),
        end: time(plan, *end),
        then,
        closes_loop,
    }
}

fn moved(view: &View<'_>, section: &Section<'_>, entry: &Entry) -> ScheduleMove {
    let resource = &view.layout.resources[entry.resource];
    let is = |wanted: fn(&EntrySubject) -> bool| wanted(&entry.subject).then(|| view.what(entry));
    ScheduleMove {
        event: entry.event,
        start: time(view.plan, entry.start),
        end: time(view.plan, entry.end),
        product: product(entry).map(|p| p + 1),
        what: MoveEntry::new(
            resource,
            entry.transition,
            is(|s| matches!(s, EntrySubject::Operation { .. })),
            is(|s| matches!(s, EntrySubject::Part(_))),
        ),
        is_critical: view.is_critical(section, entry),
    }
}
