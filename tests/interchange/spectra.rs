//! Spectra's language: the benchmark files, each construct against a naive semantics, and bad
//! files.

mod bad;
mod bench;
mod constructs;
mod formulas;
mod imports;
mod lassos;
mod patterns;
