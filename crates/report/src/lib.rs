//! Formats a simulation run for people, as a table ([`table()`]) and as a page ([`html`]), and for
//! programs ([`json()`]).
//!
//! All formats show the figures of a [`Trace`](linewright_line::Trace). Figures are rounded to a
//! fixed number of decimal places, so that the same run always produces the same bytes. Only the
//! wall time differs between runs; the caller passes it in and can omit it.

use linewright_line::{Batches, Replications};

mod columns;
mod energy;
pub mod html;
mod intervals;
mod json;
mod table;
mod what_if;

pub use json::{RUN_SCHEMA, json};
pub use table::{details, settings, table};
pub use what_if::{Variant, what_if_json, what_if_table};

/// What the confidence intervals of a report come from.
#[derive(Debug, Clone, Copy)]
pub enum Intervals<'a> {
    /// Several runs, of which the report shows the first.
    Replications(&'a Replications),
    /// The batches of the run that the report shows.
    Batches(&'a Batches),
}
