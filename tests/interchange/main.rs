//! Other tools' formats: read, written, and proved equivalent.

mod formats;
mod random;
mod round_trips;
mod spectra;
#[path = "../support/mod.rs"]
mod support;
mod tlsf;
