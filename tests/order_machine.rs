//! The pick-and-place unit with its orders: a synthesized coordinator keeps them, a mutant is found out by the proof, in a run, and by the
//! library's return code.

#[path = "ice_lab/laboratory.rs"]
#[expect(
    dead_code,
    reason = "only its way from a file to controllers is needed"
)]
mod laboratory;
#[path = "order_machine/mutant.rs"]
mod mutant;
#[path = "order_machine/operations.rs"]
mod operations;
#[path = "order_machine/unit.rs"]
mod unit;

#[path = "support/mod.rs"]
mod support;
