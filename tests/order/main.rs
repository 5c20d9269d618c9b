//! Orders of skills, compared with brute force and on the command line.

mod commands;
#[expect(
    dead_code,
    reason = "only its way from a file to controllers is used here"
)]
#[path = "../station/laboratory.rs"]
mod laboratory;
mod machine;
mod rules;
#[path = "../support/mod.rs"]
mod support;
