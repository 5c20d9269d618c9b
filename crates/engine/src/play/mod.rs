//! A contract played step by step: a person has one side, a verified machine the other.
//!
//! Of a realizable contract the person is the plant, and its controller answers. Of one that is
//! not, the person is the machine, and the counterstrategy plays the plant. What a person may do is
//! decided by the contract's rules alone.
//!
//! [`Session`] takes commands as lines and gives texts; it knows neither files nor terminals.

mod command;
mod legal;
mod opponent;
mod session;
mod show;
mod values;
mod why;

pub use opponent::Opponent;
pub use session::{Effect, Reply, Session};
pub use show::LINE_SCHEMA;
