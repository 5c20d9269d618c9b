//! The monitor of skill orders as a program to load on the cell: C, Structured Text, PLCopen XML.
//! Each form has the same rows as the monitor of this process (`order::layout`).

pub mod c;
pub mod structured_text;
