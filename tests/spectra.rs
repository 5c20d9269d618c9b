//! Spectra's language: the benchmark files, each construct against a naive semantics, bad files, and the way back.

#[path = "spectra/back.rs"]
mod back;
#[path = "spectra/bad.rs"]
mod bad;
#[path = "spectra/bench.rs"]
mod bench;
#[path = "spectra/constructs.rs"]
mod constructs;
#[path = "spectra/formulas.rs"]
mod formulas;
#[path = "spectra/imports.rs"]
mod imports;
#[path = "spectra/lassos.rs"]
mod lassos;
#[path = "spectra/patterns.rs"]
mod patterns;
#[path = "interchange/random.rs"]
mod random;
mod support;
