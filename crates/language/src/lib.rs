//! Meaning of texts in Linewright's language: skill orders, and contracts, machines and lines with
//! their names resolved.

pub mod contract;
pub mod order;
