//! From loaded files to verdicts, controllers and proofs: the stages joined, what is known of contracts remembered, and findings put into words.
//!
//! ```text
//! contract::Library ─Jobs::run→ CheckedContract ─Planned::controlled→ Controlled ─machine::proved→ Proved
//!      ─lines::examine→ Proof
//! ```
//!
//! Nothing here prints or knows an argument of the command line. It reads and writes one thing on the disk, the [`cache`].

mod asked;
pub mod cache;
pub mod closed;
pub mod controlled;
pub mod controller;
pub mod findings;
pub mod found;
pub mod internal;
pub mod interrupt;
pub mod judgement;
mod layers;
pub mod lines;
pub mod machine;
pub mod machines;
pub mod pipeline;
pub mod play;
pub mod statistics;
pub mod words;
pub mod worker;
