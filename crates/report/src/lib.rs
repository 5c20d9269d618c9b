//! Formats a run for people ([`table()`]) and for programs ([`json()`]).
//!
//! Both show the same [`Trace`](linewright_line::Trace) and add nothing to it. Figures are rounded
//! to fixed places, so that the same run gives the same bytes; the one measured figure, the wall
//! time, is passed in and may be left out.

mod json;
mod table;

pub use json::{RUN_SCHEMA, json};
pub use table::table;

const JOULES_PER_KWH: f64 = 3.6e6;
