//! Station libraries as a plant would use them.
#[path = "station/differential.rs"]
mod differential;
#[path = "station/explicit.rs"]
mod explicit;
#[path = "station/fixtures.rs"]
mod fixtures;
#[path = "ice_lab/laboratory.rs"]
mod laboratory;
#[path = "host/machines.rs"]
mod machines;
#[path = "host/passes.rs"]
mod passes;
#[path = "host/plan.rs"]
mod plan;
#[path = "host/programs.rs"]
mod programs;
mod support;
#[path = "host/walk.rs"]
mod walk;
