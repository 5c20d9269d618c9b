//! Layouts of `UF_Value`: the probe against mocks of Plant Simulation, whose layouts a C compiler
//! made; libraries with the profiles that were found; profiles as files; the SimTalk that is
//! generated.

mod damage;
mod doctor;
mod files;
mod methods;
mod mocks;
mod probing;
mod simtalk;
mod suite;
mod windows;
