//! Monitors of skill orders: those of this process, in C and in Structured Text agree, call by
//! call.

mod automata;
mod c;
mod reference;
mod rust;
mod structured_text;
mod tables;
