//! Formats a simulation run for people ([`table()`]) and for programs ([`json()`]).
//!
//! Both formats show the figures of a [`Trace`](linewright_line::Trace). Figures are rounded to a
//! fixed number of decimal places, so that the same run always produces the same bytes. Only the
//! wall time differs between runs; the caller passes it in and can omit it.

mod json;
mod table;

pub use json::{RUN_SCHEMA, json};
pub use table::{settings, table, waits};

const JOULES_PER_KWH: f64 = 3.6e6;
