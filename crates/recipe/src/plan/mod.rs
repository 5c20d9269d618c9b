//! Plans: several products at once, with least steps, time, energy or transfers.
//!
//! # What a plan is
//!
//! - Each product follows its own recipe. The resources are shared. The plan holds for every
//!   outcome of the tests, and its value is the one of the worst outcomes.
//! - A part belongs to the product that has made it, and no other product can use it. A part that
//!   the layout holds at the start under the name of a recipe's part belongs to the first product
//!   whose recipe has that part and that has none of the name yet. Every other part is stock. While
//!   a product has no part of a name, stock of the part's type can be used in its place.
//! - When a product is finished, only parts that its recipe allows may remain of it. They stay
//!   where they are, and take room.
//! - Equal products are interchangeable; the search looks at each arrangement of them once.
//!
//! # Timed execution
//!
//! - Each transition of a resource takes its time (none if it has none), and a resource takes one
//!   at a time. Resources work concurrently. The operations of one step begin together, and the
//!   next step begins when all have ended.
//! - A transfer happens at one instant. The time of the transition that gives the part passes
//!   before it (the transport is on its way), that of the transition that takes it afterward. So a
//!   resource keeps a part until another one takes it (blocking). A transport is a resource.
//! - Between two transitions, a resource waits as long as it likes where it may wait, and not at
//!   all where it may not.
//! - A test takes no time. The resource that performs it is at rest and holds the parts.
//! - What is decided before a test is the same for all its outcomes; what is decided after it
//!   begins no earlier. A transfer is decided when it begins, and so is what its taker does until
//!   then.
//! - At the end, and where a loop is closed, all resources are at rest.
//!
//! Durations are rounded to nanoseconds, energies to microjoules.
//!
//! # Lockstep
//!
//! Every transition takes one unit of time, the two sides of a transfer take it together, and no
//! two transfers of one vector have the same label. The number of vectors for one product is that
//! of [`crate::realize`].
//!
//! # How plans are found
//!
//! 1. One product after the other: fast, even for many products.
//! 2. For least time, without tests: the schedule of [`crate::jobshop`] in which buffers are ample
//!    and transports are never busy. Its length is a lower bound; its order of operations is tried
//!    in the cell.
//! 3. A search over all plans (`search`), up to a limit of nodes, for one that is better than
//!    those. If it ends, the plan is optimal.
//!
//! All limits are counts, so the result is the same on every machine. Each plan is replayed by
//! [`crate::replay_plan`] before it is given out.

mod bounds;
mod dispatch;
mod events;
mod extract;
mod path;
mod search;
mod sequence;
mod shop;
mod state;
mod types;
mod value;
mod zone;

pub use path::{CriticalEntry, critical_path};
pub use types::{
    Entry, EntrySubject, Execution, HeldPart, Method, Next, Objective, PartOwner, Plan,
    PlanPosition, Progress, Schedule,
};

use crate::jobshop;
use crate::model::{Demand, Layout, Problem, demand_problems};
use crate::realize::Obstacle;
use crate::replay_plan;
use search::{NONE, Search};
use shop::{Shop, initial, products};

/// Maximum duration of a transition in s, and maximum energy in kJ.
const MAX_SECONDS: usize = 10_000_000;
/// Maximum number of products that the search over all plans looks at.
pub const MAX_TOGETHER: usize = 64;

/// Limits of planning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanLimits {
    /// Maximum number of nodes of each search for one product or one operation. A node takes about
    /// one kilobyte.
    pub nodes: usize,
    /// Maximum number of nodes of the search over all plans.
    pub together: usize,
    /// Limits of the schedule with ample buffers.
    pub job_shop: jobshop::Limits,
    /// Whether the first plan that is found suffices, whatever its value.
    pub first: bool,
}

impl Default for PlanLimits {
    fn default() -> Self {
        Self {
            nodes: 100_000,
            together: 100_000,
            job_shop: jobshop::Limits::default(),
            first: false,
        }
    }
}

/// Result of planning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PlanOutcome {
    /// A plan.
    Planned(Plan),
    /// There is no plan in this execution.
    Unrealizable {
        /// Causes that were found without a search, each with the index of its demand.
        obstacles: Vec<(usize, Obstacle)>,
        /// Number of search nodes. The search was complete.
        nodes: usize,
    },
    /// No plan was found within the limits. There may be one.
    GaveUp {
        /// Number of search nodes.
        nodes: usize,
        /// What was tried without success beside the search over all plans.
        tried: Vec<Method>,
    },
}

/// Plans the products of some demands on a layout.
///
/// Time and memory are proportional to the limits of nodes, times the number of resources and
/// products. The number of nodes that an optimal plan needs is exponential in the number of parts
/// that are in the cell at the same time.
///
/// # Errors
/// All problems of the layout and the recipes, if any of them is more than a warning; durations
/// over 10,000,000 s and energies over 10,000,000,000 J of a transition are problems, too.
pub fn plan(
    layout: &Layout,
    demands: &[Demand],
    objective: Objective,
    limits: PlanLimits,
) -> Result<PlanOutcome, Vec<Problem>> {
    let mut problems = demand_problems(layout, demands);
    problems.extend(large_quantities(layout));
    if problems.iter().any(|p| !p.is_warning()) {
        return Err(problems);
    }
    let wanted = demands.iter().enumerate().filter(|(_, d)| d.count > 0);
    let obstacles: Vec<(usize, Obstacle)> = wanted
        .flat_map(|(d, demand)| {
            let found = crate::realize::obstacles(layout, &demand.recipe);
            found.into_iter().map(move |obstacle| (d, obstacle))
        })
        .collect();
    if !obstacles.is_empty() {
        let nodes = 0;
        return Ok(PlanOutcome::Unrealizable { obstacles, nodes });
    }
    let outcome = find(layout, demands, objective, limits);
    if let PlanOutcome::Planned(plan) = &outcome {
        let replayed = replay_plan::verify(layout, demands, plan);
        assert_eq!(replayed, Ok(()), "a plan is wrong; please report this");
    }
    Ok(outcome)
}

/// Returns a problem if a transition takes longer, or needs more energy, than sums permit that can
/// be represented.
fn large_quantities(layout: &Layout) -> Option<Problem> {
    let transitions = layout.resources.iter().flat_map(|r| &r.transitions);
    let mut sizes = transitions.map(|t| {
        let seconds = t.seconds.unwrap_or(0.0);
        (seconds, seconds * t.watts.unwrap_or(0.0))
    });
    sizes.find_map(|(seconds, joules)| {
        let what = if seconds > MAX_SECONDS as f64 {
            "seconds in a transition"
        } else if joules > MAX_SECONDS as f64 * 1e3 {
            "kilojoules in a transition"
        } else {
            return None;
        };
        Some(Problem::TooLarge {
            what,
            limit: MAX_SECONDS,
        })
    })
}

/// Plans the products; layout and recipes have no problems.
fn find(
    layout: &Layout,
    demands: &[Demand],
    objective: Objective,
    limits: PlanLimits,
) -> PlanOutcome {
    let all: Vec<usize> = (0..products(demands).len()).collect();
    let configuration = initial(layout, demands);
    let shop = Shop::new(layout, demands, objective.execution(), &all, &configuration);
    let mut search = Search::new(&shop, objective, limits.together);
    let start: Vec<Progress> = (shop.slots.iter())
        .map(|(_, demand)| Progress::At(shop.cells[*demand].start as usize))
        .collect();
    let root = shop.root(&configuration, &start);
    let mut lower_bound = search.bound(&root);
    let (mut nodes, mut best, mut tried) = (0, None, Vec::new());
    let mut keep = |found: Option<Plan>, nodes: &mut usize| {
        if let Some(plan) = found {
            *nodes += plan.nodes;
            let least = best.as_ref().map_or(NONE, |b: &Plan| b.value);
            if plan.value < least {
                best = Some(plan);
            }
        }
        best.clone()
    };
    if all.len() > 1 {
        let found = sequence::plan(layout, demands, objective, limits.nodes);
        if found.is_none() {
            tried.push(Method::OneAfterTheOther((0..demands.len()).collect()));
        }
        keep(found, &mut nodes);
    }
    if objective == Objective::Time && shop.is_ordered && !all.is_empty() {
        let (found, bound) = dispatch::plan(layout, demands, limits);
        lower_bound = lower_bound.max(bound);
        if found.is_none() {
            tried.push(Method::JobShop);
        }
        keep(found, &mut nodes);
    }
    let best = keep(None, &mut nodes);
    let done = best
        .as_ref()
        .is_some_and(|b| limits.first || b.value <= lower_bound);
    if done || all.len() > MAX_TOGETHER {
        return match best {
            Some(plan) => PlanOutcome::Planned(Plan {
                lower_bound: lower_bound.min(plan.value),
                nodes,
                ..plan
            }),
            None => PlanOutcome::GaveUp { nodes, tried },
        };
    }
    let cutoff = best.as_ref().map_or(NONE, |b| b.value);
    let solved = search.run(&root, cutoff);
    nodes += search.nodes;
    let Ok(solved) = solved else {
        return match best {
            Some(plan) => PlanOutcome::Planned(Plan {
                lower_bound: lower_bound.max(search.floor).min(plan.value),
                nodes,
                ..plan
            }),
            None => PlanOutcome::GaveUp { nodes, tried },
        };
    };
    if let Some(value) = solved.value {
        let positions = extract::positions(&search, &root, &solved);
        return PlanOutcome::Planned(Plan {
            objective,
            products: shop.slots.iter().map(|s| s.1).collect(),
            positions,
            value,
            lower_bound: lower_bound.max(solved.lower).min(value),
            method: Method::Search,
            nodes,
        });
    }
    match best {
        Some(plan) => PlanOutcome::Planned(Plan {
            lower_bound: lower_bound.max(solved.lower).min(plan.value),
            nodes,
            ..plan
        }),
        None if solved.lower == NONE => PlanOutcome::Unrealizable {
            obstacles: Vec::new(),
            nodes,
        },
        None => PlanOutcome::GaveUp { nodes, tried },
    }
}
