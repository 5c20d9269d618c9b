//! The bundled discrete-event runner: a resolved
//! [`Line`](linewright_language::contract::line::Line) and its controllers in, a [`Trace`] out.
//!
//! # What a run means
//!
//! **Ways.** When a part is done at a node, it takes the first of its type's routes from there (in
//! source order) whose condition holds for its properties at that moment; at a station this is the
//! end of service, after new properties and defects are applied. It keeps to that choice and waits
//! there until the next node has room, and everything behind it waits too. Moving takes no time. If
//! several parts wait for one node, the one that has waited longest goes first (`plant/flow.rs` has
//! the rule, and what it means for contracted belts, which hand over only when they are stepped).
//! Parts that began to wait at the same instant go in calendar order, which is the same in every
//! run.
//!
//! **Entering.** A part enters the line when it leaves its source, or a store's stock, and a joined
//! part when the joining begins; its components are consumed at that moment. Parts that a store
//! takes in are finished, unless a route of their type leaves the store again. A part that is
//! rejected by a sink or because of a violation leaves the line at once.
//!
//! **Sources** keep the part they made until there is room for it. The next part is due the
//! declared time after that one was made, and is made then, or as soon as the previous one has
//! left. A source on order has one order for each wanted product (times the number of its parts in
//! a product), plus one for each part that is rejected and sent back; orders to a timed source
//! raise its limit. A source with a limit of work in process makes no part while the limit is
//! reached by parts of its type in the line, including the one it keeps and those joined to others
//! (CONWIP; Spearman, Woodruff and Hopp, 1990).
//!
//! **Stations** work on one part at a time and block after service. A task that joins has a place
//! for each component of its bill; these fill ahead while the station works, and the task is ready
//! when all are there. Any other task takes a part of its type when the station is free.
//! [`Task::part`](linewright_language::contract::line::Task::part) defines which task does which: a
//! camera that checks a joined product does not join it again. Where a component has several
//! places, the first task's fills first. A free station begins with whatever has waited longest.
//! The setup time passes when the type that leaves differs from the previous one. The controller is
//! called when service begins; the station is then busy for the duration it returned. The time to
//! the next breakdown runs only while the station is busy; repairs go on off shift. Off shift,
//! setup and service stand still and no new part is taken; conveyors, sources and stores go on.
//!
//! **Conveyors** without a contract accumulate: a part travels `places * pitch / speed` seconds,
//! comes off no sooner than `pitch / speed` after the one before it, and comes on when the one
//! before it has moved up by one pitch and fewer than `places` parts are there. For conveyors with
//! a contract, see `plant/belt.rs`.

pub mod abstraction;
pub mod calendar;
pub mod calls;
mod metric;
mod plant;
pub mod random;
pub mod replicate;
mod statistics;
pub mod trace;
mod undecided;
mod validate;

use linewright_core::deadline::Deadline;
pub use metric::ReplicatedRequirement;
pub use plant::Plant;
pub use replicate::{Estimate, Replications};
pub use trace::{End, Trace};
pub use undecided::UndecidedReason;

/// Options of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of end products after which the run ends.
    pub parts: Option<u64>,
    /// Simulated seconds after which the run ends.
    pub until: Option<f64>,
    /// Wall-clock deadline.
    pub deadline: Deadline,
    /// Whether to keep every movement in [`Trace::log`]; memory then grows with the run.
    pub log: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            parts: None,
            until: None,
            deadline: Deadline::NONE,
            log: false,
        }
    }
}
