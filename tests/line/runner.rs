//! The runner, on handmade lines and controllers with the answers that the test needs: no solver,
//! no C.
#![expect(clippy::float_cmp, reason = "the times of these lines are exact")]

mod arrivals;
mod batches;
mod belts;
mod blocked;
mod calendars;
pub mod conservation;
mod conveyors;
mod ends;
mod equipment;
mod failures;
mod flow;
mod losses;

mod reports;
mod requirements;
mod serial;
mod stations;
mod turns;
mod waits;
mod warm_up;
