//! The built program, end to end: the exit code and the whole message of every bad input, and what
//! is left on disk.
//!
//! What is fed to it stands in `tests/cases/cli` and `tests/cases/line`; what it prints, in
//! snapshots. Every message says what is wrong and what to do next.

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
mod session;
