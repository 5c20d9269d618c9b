//! Linewright: from assume-guarantee contracts to a running virtual production line.
//!
//! The way of the data, one module an arrow, each type owned by the module on its left:
//!
//! ```text
//! text ─parse→ Ast ─resolve→ Library ─lower→ gr1::Specification ─encode→ symbolic::Arena ─solve→ game::Outcome
//!      ─extract→ mealy::Machine (verified) ─emit→ station::Package ─load→ line::Plant ─run→ line::Trace ─→ report
//! ```
//!
//! Three narrow waists hold the rest together: [`gr1::Specification`], [`mealy::Machine`] and [`line::Trace`].

// Tests of inner parts share files with those from outside.
#[cfg(test)]
extern crate self as linewright;

pub mod algebra;
pub mod cli;
pub mod contract;
pub mod diagnostics;
pub mod drawing;
pub mod engine;
pub mod game;
pub mod gr1;
pub mod interchange;
pub mod line;
pub mod mealy;
pub mod order;
pub mod play;
pub mod report;
pub mod source;
pub mod station;
pub mod symbolic;
pub mod syntax;
pub mod taxonomy;
