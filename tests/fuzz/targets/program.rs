//! Arbitrary text as a program of calls, in lines and as a table.
#![no_main]

#[path = "../program.rs"]
mod program;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    program::program(text);
});
