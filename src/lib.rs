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

pub mod cli;

pub use linewright_algebra as algebra;
pub use linewright_core::{diagnostics, drawing, gr1, source, taxonomy};
pub use linewright_engine::{self as engine, play};
pub use linewright_interchange as interchange;
pub use linewright_language::{contract, order, syntax};
pub use linewright_line as line;
pub use linewright_report as report;
pub use linewright_solver::{game, mealy, symbolic};
pub use linewright_station as station;
