//! Types shared by all parts of Linewright: sources and places in them, findings, names for other
//! languages, taxonomies, and GR(1) specifications.

pub mod deadline;
pub mod diagnostics;
pub mod drawing;
pub mod gr1;
pub mod rename;
pub mod source;
pub mod taxonomy;
