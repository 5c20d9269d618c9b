//! The monitor of skill orders as a program to load on the cell: C, Structured Text, PLCopen XML.
//! Each form has the same rows as this process's own monitor (`order::layout`).

pub mod c;
pub mod structured_text;
