//! FMI units: what is in the archive, that it steps as the machine in this process does, and that
//! wrong calls are answered.
//!
//! One tape of calls is played by several hosts: a C program that loads the unit's library
//! (`fmi/host.c`, on Linux and as a Windows program under Wine), and `FMPy` (`fmi/host.py`). Every
//! one of them prints what it reads after each step, and that is compared with `fmi/reference.rs`,
//! a unit written over the interpreter.

mod archive;
mod calls;
mod hosts;
mod python;
mod reference;
mod tape;
mod windows;
