//! Spectra's language: the benchmark files, each construct against a naive semantics, and bad files.

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
mod support;
