//! Spectra's language: the benchmark files, each construct compared with a naive semantics, and
//! invalid files.

mod bad;
mod bench;
mod constructs;
mod formulas;
mod imports;
mod lassos;
mod patterns;
