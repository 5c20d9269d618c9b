//! Shared by the tests: the reconstructed demonstrator.

pub mod pad;
