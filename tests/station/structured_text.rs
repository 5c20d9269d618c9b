//! Controllers as Structured Text and PLCopen XML, run by an interpreter implemented from IEC
//! 61131-3 that shares no code with the emitter.

mod hostile;
mod mutated;
mod others;
pub mod play;
mod played;
mod plcopen;
mod rules;
mod wide;
mod written;
