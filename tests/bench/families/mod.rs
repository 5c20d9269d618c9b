//! Generators of benchmark specifications. Each family has instances of any size.

#![allow(dead_code, reason = "no program uses all families")]

pub mod anzu;
pub mod arithmetic;
pub mod formula;
