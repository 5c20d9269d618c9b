//! FMI units: the content of the archive, stepping compared with the machine in this process, and
//! answers to wrong calls.
//!
//! One tape of calls is played by several hosts: a C program that loads the unit's library
//! (`fmi/host.c`, on Linux and as a Windows program under Wine), and `FMPy` (`fmi/host.py`). Each
//! prints what it reads after each step, and the output is compared with `fmi/reference.rs`, a unit
//! based on the interpreter.

mod archive;
mod calls;
mod hosts;
mod python;
mod reference;
mod tape;
mod windows;
