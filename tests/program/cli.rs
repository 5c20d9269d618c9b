//! The built program, end to end: the exit code and the complete message for every bad input, and
//! the files left on disk.
//!
//! Inputs are in `tests/cases/cli` and `tests/cases/line`; outputs, in snapshots. Every message
//! says what is wrong and what to do next.

mod cache;
mod disk;
mod exits;
mod fmt;
mod inputs;
mod internal;
mod libraries;
mod limits;
mod names;
mod outside;
mod places;
mod replications;
mod session;
mod settings;
mod tables;
mod traces;
