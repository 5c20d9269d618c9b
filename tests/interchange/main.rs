//! Other tools' formats: read, written, and proved to mean the same.

mod formats;
mod random;
mod round_trips;
mod spectra;
#[path = "../support/mod.rs"]
mod support;
mod tlsf;
