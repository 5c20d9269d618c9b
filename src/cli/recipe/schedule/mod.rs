//! The schedule of a plan: its parts between tests, and what happens in each.

mod document;
mod gantt;
mod quantity;
mod text;

pub(super) use document::{ProductsPlan, ScheduleSection, TimeUnit, sections};
pub(super) use gantt::chart;
pub(super) use quantity::{instant, number, value};
pub(super) use text::{tables, text};

use crate::engine::recipes::words;
use crate::recipe::model::{Action, Layout, Recipe};
use crate::recipe::plan::{
    Entry, EntrySubject, HeldPart, Next, PartOwner, Plan, Schedule, critical_path,
};
use std::collections::BTreeSet;

/// A plan with the models that it is about.
pub(super) struct View<'p> {
    pub plan: &'p Plan,
    pub layout: &'p Layout,
    /// The recipe of each demand.
    pub recipes: Vec<&'p Recipe>,
    /// Position, outcomes, event and resource of each entry of the critical path.
    critical: BTreeSet<(usize, Vec<usize>, usize, usize)>,
    /// Whether it is a run, with one outcome of each test.
    is_run: bool,
}

/// A part of a plan, up to a test or to the end of a position. It begins with a position or with
/// the outcome of a test.
struct Section<'p> {
    /// `2` for the second position, `2.1` for the first outcome of its first test. The sections of
    /// a run are counted.
    number: String,
    position: usize,
    /// The outcomes since the beginning of the position, as indices.
    outcomes: Vec<usize>,
    /// The outcome with which it begins.
    begins: Option<Outcome>,
    schedule: &'p Schedule,
}

/// Outcome of a test.
#[derive(Clone, Copy)]
struct Outcome {
    time: i64,
    product: usize,
    /// Index of the transition of the product's recipe.
    transition: usize,
}

/// What happens at once: an operation of a resource, or a transfer between two.
struct Happening<'p> {
    start: i64,
    end: i64,
    /// The resource; for a transfer, the one that gives and the one that takes.
    resource: String,
    what: String,
    product: Option<usize>,
    is_critical: bool,
    entries: &'p [Entry],
}

impl<'p> View<'p> {
    /// Creates a view of a plan.
    pub fn new(plan: &'p Plan, layout: &'p Layout, recipes: Vec<&'p Recipe>) -> Self {
        let path = if plan.objective.is_time() {
            critical_path(plan)
        } else {
            Vec::new()
        };
        let critical = path.into_iter().map(|c| {
            let entry = &c.entry;
            (c.position, c.outcomes, entry.event, entry.resource)
        });
        Self {
            plan,
            layout,
            recipes,
            critical: critical.collect(),
            is_run: false,
        }
    }

    /// Creates a view of a run as a plan.
    pub fn of_run(run: &'p Plan, layout: &'p Layout, recipes: Vec<&'p Recipe>) -> Self {
        Self {
            plan: run,
            layout,
            recipes,
            critical: BTreeSet::new(),
            is_run: true,
        }
    }

    /// The number of the section that an outcome of a section's test begins.
    fn number_after(&self, section: &Section<'_>, outcome: usize) -> String {
        if self.is_run {
            return (section.outcomes.len() + 2).to_string();
        }
        format!("{}.{}", section.number, outcome + 1)
    }

    fn recipe(&self, product: usize) -> &'p Recipe {
        self.recipes[self.plan.products[product]]
    }

    /// `product 2: `, or nothing if there is only one.
    fn of_product(&self, product: usize) -> String {
        if self.plan.products.len() > 1 {
            format!("product {}: ", product + 1)
        } else {
            String::new()
        }
    }

    /// `product 2: b -> c when visionOk(h2)`
    fn outcome(&self, outcome: Outcome) -> String {
        let transition = &self.recipe(outcome.product).transitions[outcome.transition];
        self.of_product(outcome.product) + &words::transition(transition)
    }

    fn sections(&self) -> Vec<Section<'p>> {
        let mut found = Vec::new();
        for (position, at) in self.plan.positions.iter().enumerate() {
            let first = Section {
                number: (position + 1).to_string(),
                position,
                outcomes: Vec::new(),
                begins: None,
                schedule: &at.schedule,
            };
            self.add(first, &mut found);
        }
        found
    }

    /// Adds a section, and those that follow its test.
    fn add(&self, section: Section<'p>, found: &mut Vec<Section<'p>>) {
        let mut after = Vec::new();
        if let Next::Test {
            time,
            product,
            outcomes,
        } = &section.schedule.then
        {
            for (at, (transition, schedule)) in outcomes.iter().enumerate() {
                after.push(Section {
                    number: self.number_after(&section, at),
                    position: section.position,
                    outcomes: [section.outcomes.as_slice(), &[at]].concat(),
                    begins: Some(Outcome {
                        time: *time,
                        product: *product,
                        transition: *transition,
                    }),
                    schedule,
                });
            }
        }
        found.push(section);
        for section in after {
            self.add(section, found);
        }
    }

    fn is_critical(&self, section: &Section<'_>, entry: &Entry) -> bool {
        let key = (
            section.position,
            section.outcomes.clone(),
            entry.event,
            entry.resource,
        );
        self.critical.contains(&key)
    }

    fn happenings(&self, section: &Section<'p>) -> Vec<Happening<'p>> {
        let mut found = Vec::new();
        for entries in section.schedule.entries.chunk_by(|a, b| a.event == b.event) {
            let name = |e: &Entry| self.layout.resources[e.resource].name.clone();
            let giver = entries.iter().find(|e| self.gives(e));
            let taker = entries.iter().find(|e| !self.gives(e));
            match (giver, taker) {
                (Some(giver), Some(taker)) => found.push(Happening {
                    start: giver.start,
                    end: taker.end,
                    resource: format!("{} => {}", name(giver), name(taker)),
                    what: self.what(giver),
                    product: product(giver),
                    is_critical: entries.iter().any(|e| self.is_critical(section, e)),
                    entries,
                }),
                _ => found.extend(entries.iter().map(|entry| Happening {
                    start: entry.start,
                    end: entry.end,
                    resource: name(entry),
                    what: self.what(entry),
                    product: product(entry),
                    is_critical: self.is_critical(section, entry),
                    entries: std::slice::from_ref(entry),
                })),
            }
        }
        found.sort_by_key(|h| (h.start, h.end));
        found
    }

    /// Whether an entry is the side of a transfer that gives the part.
    fn gives(&self, entry: &Entry) -> bool {
        let resource = &self.layout.resources[entry.resource];
        matches!(
            resource.transitions[entry.transition].action,
            Action::Out(_)
        )
    }

    /// The operation with its parts, the part that is transferred, or `internal turn`.
    fn what(&self, entry: &Entry) -> String {
        match &entry.subject {
            EntrySubject::Operation {
                product,
                transition,
                step,
                call,
            } => {
                let step = &self.recipe(*product).transitions[*transition].steps[*step];
                words::call(&step.operations[*call])
            }
            EntrySubject::Part(part) => part.name.clone(),
            EntrySubject::Internal => {
                let resource = &self.layout.resources[entry.resource];
                words::action(&resource.transitions[entry.transition].action)
            }
        }
    }
}

/// Index of the product that an entry is about.
fn product(entry: &Entry) -> Option<usize> {
    match &entry.subject {
        EntrySubject::Operation { product, .. } => Some(*product),
        EntrySubject::Part(part) => owner(part),
        EntrySubject::Internal => None,
    }
}

/// Index of the product to which a part belongs.
fn owner(part: &HeldPart) -> Option<usize> {
    match part.owner {
        PartOwner::Product(product) => Some(product),
        PartOwner::Stock | PartOwner::LeftOver(_) => None,
    }
}
