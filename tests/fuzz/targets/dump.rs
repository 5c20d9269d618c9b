//! Arbitrary text as the dump of a probe.
#![no_main]

#[path = "../uf_value.rs"]
#[allow(dead_code, reason = "each target uses a part of it")]
mod uf_value;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    uf_value::dump(text);
});
