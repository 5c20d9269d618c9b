//! Linewright's language: its grammar and syntax trees, skill orders, and contracts, machines and lines with their names resolved.

pub mod contract;
pub mod order;
pub mod syntax;
