//! Arbitrary text as a `.spc` file.
#![no_main]

#[path = "../check.rs"]
#[allow(dead_code, reason = "each target uses a part of it")]
mod check;

use libfuzzer_sys::fuzz_target;
use linewright::interchange::Format;

fuzz_target!(|text: &str| check::reader(Format::Spc, text));
