//! Arbitrary text as a profile of `UF_Value`.
#![no_main]

#[path = "../uf_value.rs"]
#[allow(dead_code, reason = "each target uses a part of it")]
mod uf_value;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    uf_value::profile(text);
});
