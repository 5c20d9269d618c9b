//! The built program, end to end: the exit code and the whole message of every bad input, and what is left on disk.
//!
//! What is fed to it stands in `tests/cases/cli` and `tests/cases/line`; what it prints, in snapshots. Every message says what
//! is wrong and what to do next.

#[path = "cli/cache.rs"]
mod cache;
#[path = "cli/disk.rs"]
mod disk;
#[path = "cli/exits.rs"]
mod exits;
#[path = "cli/fmt.rs"]
mod fmt;
#[path = "cli/inputs.rs"]
mod inputs;
#[path = "cli/internal.rs"]
mod internal;
#[path = "cli/libraries.rs"]
mod libraries;
#[path = "cli/limits.rs"]
mod limits;
#[path = "cli/names.rs"]
mod names;
#[path = "cli/outside.rs"]
mod outside;
#[path = "cli/places.rs"]
mod places;
#[path = "cli/session.rs"]
mod session;
mod support;
