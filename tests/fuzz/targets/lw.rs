//! Arbitrary text as a `.lw` file.
#![no_main]

#[path = "../check.rs"]
#[allow(dead_code, reason = "each target uses a part of it")]
mod check;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| check::language(text));
