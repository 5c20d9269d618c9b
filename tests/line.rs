//! The runner, on lines built by hand and controllers that answer what the test wants: no solver, no C.
#![expect(clippy::float_cmp, reason = "the times of these lines are exact")]

#[path = "line/belts.rs"]
mod belts;
#[path = "line/blocked.rs"]
mod blocked;
#[path = "line/conservation.rs"]
mod conservation;
#[path = "line/conveyors.rs"]
mod conveyors;
#[path = "line/ends.rs"]
mod ends;
#[path = "line/flow.rs"]
mod flow;

#[path = "line/reports.rs"]
mod reports;
#[path = "line/serial.rs"]
mod serial;
#[path = "line/stations.rs"]
mod stations;
#[path = "line/support.rs"]
mod support;
#[path = "line/turns.rs"]
mod turns;
