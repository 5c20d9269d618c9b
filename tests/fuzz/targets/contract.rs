//! Arbitrary bytes as a small contract, checked and synthesized.
#![no_main]

#[path = "../check.rs"]
#[allow(dead_code, reason = "each target uses a part of it")]
mod check;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    check::contract_of(bytes);
});
