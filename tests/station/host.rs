//! Station libraries as a plant would use them: loaded by a host in C that tests everything a host
//! can rely on.
//!
//! The host is in `station/host` and has no knowledge of machines: the tests here write its plan
//! from the machine in this process ([`walk`], [`plan`]), build the library of every machine for
//! this computer and for Windows, and run the host on it, natively and under Wine ([`passes`]).
//! Faulty libraries must make it fail ([`controls`], [`mutants`], [`runtime`] with its
//! [`corners`]); sanitizers watch it ([`sanitizers`]); and the library files are examined without
//! it ([`shape`], [`images`]). The small host for users is tested too ([`example`]).

mod controls;
mod corners;
mod example;
mod images;
mod machines;
mod mutants;
mod passes;
mod plan;
mod programs;
mod runtime;
mod sanitizers;
mod shape;
mod walk;
