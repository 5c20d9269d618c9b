//! Monitors of skill orders: the one of this process, the one in C and the one in Structured Text
//! say the same, call by call.

mod automata;
mod c;
mod reference;
mod rust;
mod structured_text;
mod tables;
