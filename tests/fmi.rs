//! FMI units: what is in the archive, that it steps as the machine in this process does, and that wrong calls are answered.
//!
//! One tape of calls is played by several hosts: a C program that loads the unit's library (`fmi/host.c`, on Linux and as a Windows
//! program under Wine), and `FMPy` (`fmi/host.py`). Every one of them prints what it reads after each step, and that is compared
//! with `fmi/reference.rs`, a unit written over the interpreter.

#[path = "fmi/archive.rs"]
mod archive;
#[path = "fmi/calls.rs"]
mod calls;
#[expect(dead_code, reason = "a tape needs its random numbers only")]
#[path = "station/differential.rs"]
mod differential;
#[path = "station/explicit.rs"]
mod explicit;
#[allow(dead_code, reason = "other tests use the rest of it")]
#[path = "station/fixtures.rs"]
mod fixtures;
#[path = "fmi/hosts.rs"]
mod hosts;
#[allow(dead_code, reason = "other tests use the rest of it")]
#[path = "ice_lab/laboratory.rs"]
mod laboratory;
#[path = "fmi/python.rs"]
mod python;
#[path = "fmi/reference.rs"]
mod reference;
mod support;
#[path = "fmi/tape.rs"]
mod tape;
#[path = "fmi/windows.rs"]
mod windows;
