//! Station libraries, FMI units and function blocks, run and compared with the interpreter.

mod controlled;
mod counting;
mod differential;
mod explicit;
mod fixtures;
mod fmi;
mod host;
mod ice_lab;
mod iec;
mod laboratory;
mod libraries;
mod library;
mod order_monitor;
mod profile;
#[expect(dead_code, reason = "only its random numbers are used here")]
#[path = "../solver/random.rs"]
mod random;
#[expect(dead_code, reason = "second recipes are not used here")]
#[path = "../../crates/recipe/tests/support/random.rs"]
mod random_cells;
mod recipes;
mod structured_text;
#[path = "../support/mod.rs"]
mod support;
#[expect(dead_code, reason = "profiles are read with their findings here")]
#[path = "../fuzz/uf_value.rs"]
mod uf_value;
mod unit;
