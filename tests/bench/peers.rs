//! Realizability compared with other tools: `linewright check` and, if available, gr1c, slugs and
//! Spectra, on the same files.
//!
//! Every figure is of a whole process as a user runs it: user and system time, and peak resident
//! memory. The tools take turns on each file, so that other load affects both. If a format's tool
//! is not available, only Linewright's figures are shown. The `README.md` in this folder explains
//! the usage.

#[cfg(unix)]
#[path = "peers/compare.rs"]
mod compare;
#[cfg(unix)]
#[path = "families/mod.rs"]
mod families;
#[cfg(unix)]
#[path = "peers/instances.rs"]
mod instances;
#[cfg(unix)]
#[path = "peers/measure.rs"]
mod measure;
#[cfg(unix)]
#[path = "peers/table.rs"]
mod table;

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    match arguments.split_first() {
        Some((first, rest)) if first == measure::ARGUMENT => measure::stand_between(rest),
        _ => compare::main(&arguments),
    }
}

#[cfg(not(unix))]
fn main() {
    println!("peers: not measured, the system's account of a process is asked for in Unix's way");
}
