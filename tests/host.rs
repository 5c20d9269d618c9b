//! Station libraries as a plant would use them: loaded by a host in C that tests everything a host can rely on.
//!
//! The host is in `station/host`, and knows nothing of machines: the tests here write its plan from the machine in this process
//! ([`walk`], [`plan`]), build the library of every machine for this computer and for Windows, and run the host on it, natively and
//! under Wine ([`passes`]). Libraries that are not what they should be must make it fail ([`controls`], [`mutants`], [`runtime`] with
//! its [`corners`]); sanitizers watch it ([`sanitizers`]); and what a library is as a file is looked at without it ([`shape`],
//! [`images`]). The small host for users is tried too ([`example`]).

#[path = "station/controlled.rs"]
mod controlled;
#[path = "host/controls.rs"]
mod controls;
#[path = "host/corners.rs"]
mod corners;
#[path = "station/counting.rs"]
mod counting;
#[expect(dead_code, reason = "a plan needs its random numbers only")]
#[path = "station/differential.rs"]
mod differential;
#[path = "host/example.rs"]
mod example;
#[path = "station/explicit.rs"]
mod explicit;
#[path = "station/fixtures.rs"]
mod fixtures;
#[path = "host/images.rs"]
mod images;
#[expect(dead_code, reason = "the loader's machines are tested as well")]
#[path = "ice_lab/laboratory.rs"]
mod laboratory;
#[path = "host/machines.rs"]
mod machines;
#[path = "host/mutants.rs"]
mod mutants;
#[path = "host/passes.rs"]
mod passes;
#[path = "host/plan.rs"]
mod plan;
#[path = "host/programs.rs"]
mod programs;
#[path = "host/runtime.rs"]
mod runtime;
#[path = "host/sanitizers.rs"]
mod sanitizers;
#[path = "host/shape.rs"]
mod shape;
mod support;
#[path = "host/walk.rs"]
mod walk;
