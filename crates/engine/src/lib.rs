//! From loaded files to verdicts, controllers and proofs: connects the stages, caches results of
//! contracts, and words the findings.
//!
//! ```text
//! contract::Library ─Jobs::run→ CheckedContract ─MachinePlan::controlled→ ControlledMachine
//!      ─machine::prove_machine→ MachineProof ─lines::examine→ Proof
//! ```
//!
//! [`project`] is the entry point: files in; verdicts, station libraries and runs out. Nothing here
//! prints or depends on command-line arguments. The crate reads sources ([`files`]) and the
//! [`cache`]; it writes the cache and the requested build results.

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
mod parametrized;
pub mod pipeline;
pub mod play;
pub mod project;
pub mod prover;
pub mod recipes;
pub mod simulation;
pub mod speed;
pub mod statistics;
pub mod synthesis;
pub mod words;
pub mod worker;
