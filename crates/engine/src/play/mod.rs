//! Plays a contract step by step: a person plays one side, a verified machine the other.
//!
//! In a realizable contract the person is the plant, and the controller answers. In an unrealizable
//! one the person is the machine, and the counterstrategy plays the plant. The contract's rules
//! alone decide which moves are legal.
//!
//! [`Session`] takes commands as lines and returns texts; it uses neither files nor terminals.

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
