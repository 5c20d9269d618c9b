//! Layouts of `UF_Value`: the probe with mocks of Plant Simulation, whose layouts a C compiler
//! made; libraries with the inferred profiles; profiles as files; the generated SimTalk.

mod damage;
mod doctor;
mod files;
mod methods;
mod mocks;
mod probing;
mod simtalk;
mod suite;
mod windows;
