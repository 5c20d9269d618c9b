//! What texts in Linewright's language mean: skill orders, and contracts, machines and lines with
//! their names resolved.

pub mod contract;
pub mod order;
