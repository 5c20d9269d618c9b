//! The bundled discrete-event runner: it takes a resolved
//! [`Line`](linewright_language::contract::line::Line) with its controllers, and returns a
//! [`Trace`].
//!
//! # What a run means
//!
//! **Ways.** When a part is done at a node, it chooses its way: the first route of its type from
//! there (in source order) whose condition holds for the part's properties at that moment. At a
//! station, this is the end of service, after new properties and defects have been applied. The
//! choice is final: the part waits at the node until the next node has room, and everything behind
//! it waits, too. Moving takes no time. If several parts wait for one node, the one that has waited
//! longest goes first. (`plant/flow.rs` states the rule, and what it means for contracted belts,
//! which hand over parts only when they are stepped.) Parts that began to wait at the same instant
//! go in calendar order, which is the same in every run.
//!
//! A way can end at a list of places. To the first free one, or by the shortest queue, the part
//! goes at once if one of them has room and nobody else waits for it; otherwise, it waits for all
//! of them. In turn and by chance, it waits for the place that was determined; the turn passes, and
//! the next number is drawn, when a part has moved. In a buffer with an order of its own, a part
//! that comes may be the next to leave. It then takes the turn of the part that it overtakes.
//!
//! **Entering.** A part enters the line when it leaves its source or a store's stock. A joined part
//! enters when the joining begins; its components are consumed at that moment. A part that a store
//! receives is finished, unless a route of its type leaves the store again. A part that is
//! rejected, by a sink or because of a violation, leaves the line at once.
//!
//! **Sources** hold the part that they made until there is room for it. The next part is due once
//! the declared time has passed since that part was made. It is made when it is due, but not before
//! the previous part has left. A part of a table is due at its instant, whenever the previous part
//! was made; replacements that a sink orders come as soon as there is room. A source on order gets
//! one order for each part of its type that the requested products need, plus the replacements for
//! rejected parts; orders to a timed source raise its limit. A source with a limit of work in
//! process makes no part while the number of parts of its type in the line equals the limit. The
//! part that the source holds, and parts joined to others, count, too (CONWIP; Spearman, Woodruff
//! and Hopp, 1990).
//!
//! **Stations** work on one part at a time and block after service. A task that joins has a place
//! for each component of its bill. These places fill while the station works, and the task is ready
//! when all components are there. Any other task takes a part of its type when the station is free.
//! [`Task::part`](linewright_language::contract::line::Task::part) defines whether a task joins: a
//! camera that checks a joined product does not join it again. If several tasks need a component of
//! the same type, the places of the first such task fill first. A free station begins with whatever
//! has waited longest. The setup time passes if the type that leaves differs from that of the
//! previous part. The controller is called when service begins; the station is then busy for the
//! duration that the controller returned. A station without a machine is busy for a duration that
//! is drawn. At the end of service, the station's settings apply to the part, then its defects. Off
//! shift, and in breaks, setup and service are suspended and no new part is taken; conveyors,
//! sources and stores continue. A shift that finishes work lets them go on with a part that has
//! begun before. Each station works by its own calendar, or else by that of the line. For
//! breakdowns, see `plant/failures.rs`; repairs continue off shift.
//!
//! **Warm-up.** Until it ends, parts move as ever, but nothing is counted, and products do not end
//! the run. It ends at a time, or at the instant of a number of products. See `plant/warm_up.rs`.
//!
//! **Conveyors** without a contract accumulate. A part travels for `places * pitch / speed` seconds
//! and comes off at least `pitch / speed` seconds after the part ahead of it. It comes on once the
//! part ahead of it has moved up by one pitch and fewer than `places` parts are on the conveyor.
//! For conveyors with a contract, see `plant/belt.rs`.

pub mod abstraction;
pub mod batches;
mod bottleneck;
pub mod calendar;
pub mod calls;
pub mod comparison;
pub mod estimates;
pub mod log;
pub mod metric;
pub mod monitor;
pub mod mser;
pub mod picture;
mod plant;
pub mod random;
pub mod replicate;
mod requirement;
pub mod sampler;
mod statistics;
pub mod trace;
mod undecided;
mod validate;

pub use batches::{Batch, Batches};
pub use bottleneck::{Bottleneck, Candidate, Deadlock};
use linewright_core::deadline::Deadline;
pub use log::Observer;
pub use monitor::Monitor;
pub use plant::Plant;
pub use replicate::{Count, Estimate, Replications};
pub use requirement::{ReplicatedRequirement, Verdict};
pub use trace::{End, Trace};
pub use undecided::UndecidedReason;

/// Options of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of end products after which the run ends; `None` if they do not end it.
    pub parts: Option<u64>,
    /// Simulated seconds after which the run ends; `None` if time does not end it.
    pub until: Option<f64>,
    /// Simulated seconds from the start in which nothing is counted. The requested number of
    /// products counts from then on.
    pub warm_up: f64,
    /// Number of end products of the warm-up: nothing is counted until as many have been made. 0
    /// for none, or for a warm-up that [`Self::warm_up`] gives.
    pub warm_up_products: u64,
    /// Number of batches into which a run is cut after the warm-up, for confidence intervals;
    /// `None` for none. See [`batches`].
    pub batches: Option<u32>,
    /// Wall-clock deadline.
    pub deadline: Deadline,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            parts: None,
            until: None,
            warm_up: 0.0,
            warm_up_products: 0,
            batches: None,
            deadline: Deadline::NONE,
        }
    }
}
