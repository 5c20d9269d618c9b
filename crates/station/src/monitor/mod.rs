//! Emits the monitor of skill orders as a program for the cell's controller: C, Structured Text,
//! PLCopen XML. Each form has the same tables as the monitor of this program (`order::layout`).

pub mod c;
pub mod structured_text;
