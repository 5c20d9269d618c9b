//! Controllers as Structured Text and PLCopen XML, run by an interpreter that is written from IEC
//! 61131-3 and shares no code with what writes them.

mod hostile;
mod mutated;
mod others;
mod play;
mod played;
mod plcopen;
mod rules;
mod wide;
mod written;
