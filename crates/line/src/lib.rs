//! The bundled discrete-event runner: a resolved
//! [`Line`](linewright_language::contract::line::Line) and its controllers in, a [`Trace`] out.
//!
//! # What a run means
//!
//! **Ways.** A part that is done at a node takes the first of its type's routes from there (in the
//! order of the text) whose condition holds for the properties the part has at that moment; at a
//! station that is the end of its service, new properties and defects included. It keeps to that
//! choice and waits there until the next node has room, and what is behind it waits too. Moving
//! takes no time. Where several parts wait for one node, the one that has waited longest goes first
//! (`plant/flow.rs` has the rule, and what it means for contracted belts, which hand over only when
//! they are stepped); those that began to wait at one instant go in the order in which the calendar
//! treated them, which is the same in every run.
//!
//! **Entering.** A part enters the line when it leaves its source, or a store's stock, and a joined
//! one when the joining begins; its components are consumed at that moment. Parts that a store
//! takes in are finished, unless a route of their type leaves the store again. A part that is
//! rejected by a sink or because of a violation leaves the line at once.
//!
//! **Sources** keep the part they made until there is room for it. The next one is due the stated
//! time after that one was made, and is made then, or as soon as the one before it has left. A
//! source on order has one order for each wanted product (times how many of its parts a product is
//! joined from), and as many again for each part that is rejected and sent back; orders to a source
//! by time raise its limit. A source with a limit of work in progress makes none while so many of
//! its type are in the line, the one it keeps and those that were joined to others included
//! (CONWIP; Spearman, Woodruff and Hopp, 1990).
//!
//! **Stations** work on one part at a time and block after service. A task that joins has a place
//! for each component of its bill; these fill ahead while the station works, and the task is ready
//! when all are there. Any other task takes a part of its type when the station is free. Which task
//! does which is said at [`Task::part`](linewright_language::contract::line::Task::part): a camera
//! that checks a joined product does not join it again. Where a component has several places, the
//! first task's fills first. A free station begins with what has waited longest. The setup time
//! passes when the type that leaves differs from the last one. The controller is called when
//! service begins; the station is then busy for as long as it answered. The working time to the
//! next breakdown counts only while the station is busy; repairs go on off shift. Off shift, setup
//! and service stand still and no new part is taken; conveyors, sources and stores go on.
//!
//! **Conveyors** without a contract accumulate: a part travels `places * pitch / speed` seconds,
//! comes off no sooner than `pitch / speed` after the one before it, and goes on when the one
//! before it has moved up by one pitch and fewer than `places` are there. For those with one see
//! `plant/belt.rs`.

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
pub use undecided::Undecided;

/// How a line is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Where all randomness comes from.
    pub seed: u64,
    /// End when so many end products are made.
    pub parts: Option<u64>,
    /// End after so many simulated seconds.
    pub until: Option<f64>,
    /// When to give up, by the real clock.
    pub deadline: Deadline,
    /// Keep every movement in [`Trace::log`]; memory then grows with the run.
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
