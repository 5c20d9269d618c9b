//! From loaded files to verdicts, controllers and proofs: the stages joined, what is known of
//! contracts remembered, and findings put into words.
//!
//! ```text
//! contract::Library ─Jobs::run→ CheckedContract ─Planned::controlled→ Controlled ─machine::proved→ Proved
//!      ─lines::examine→ Proof
//! ```
//!
//! [`project`] is where to begin: files in, verdicts, station libraries and runs out. Nothing here
//! prints or knows an argument of the command line. What it reads are sources ([`files`]) and the
//! [`cache`]; what it writes are the cache and what it is asked to build.

pub mod cache;
mod call_check;
pub mod closed;
pub mod controlled;
pub mod controller;
pub mod files;
pub mod findings;
pub mod found;
pub mod internal;
pub mod judgement;
mod layers;
pub mod libraries;
pub mod lines;
pub mod machine;
pub mod machines;
pub mod output;
pub mod pipeline;
pub mod play;
pub mod project;
pub mod simulation;
pub mod statistics;
pub mod synthesis;
pub mod words;
pub mod worker;
