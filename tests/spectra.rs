//! Spectra's language: the benchmark files, each construct against a naive semantics, bad files, and the way back.

#[path = "spectra/bench.rs"]
mod bench;
mod support;
