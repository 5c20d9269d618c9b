//! Layouts of `UF_Value`: the probe against mocks of Plant Simulation, whose layouts a C compiler made; libraries with the profiles that
//! were found; profiles as files; the SimTalk that is generated.

#[path = "profile/damage.rs"]
mod damage;
#[path = "profile/doctor.rs"]
mod doctor;
#[path = "station/explicit.rs"]
mod explicit;
#[path = "profile/files.rs"]
mod files;
#[path = "station/fixtures.rs"]
mod fixtures;
#[path = "profile/methods.rs"]
mod methods;
#[path = "profile/mocks.rs"]
mod mocks;
#[path = "profile/probing.rs"]
mod probing;
#[path = "profile/simtalk.rs"]
mod simtalk;
#[path = "profile/suite.rs"]
mod suite;
mod support;
#[path = "fuzz/uf_value.rs"]
#[allow(dead_code, reason = "profiles as files have tests of their own")]
mod uf_value;
#[path = "profile/windows.rs"]
mod windows;
