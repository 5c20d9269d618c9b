//! The contract language: grammar, syntax trees, parser.
//!
//! [`parse`] returns a tree and a list of findings; it never fails and never panics. The crate
//! `language` resolves the names.

pub mod ast;
mod binds;
mod build;
pub mod format;
mod mend;
mod parser;
mod spans;
mod words;

pub use mend::{is_component, is_skill_set, is_skills_head};
pub use parser::parse;
pub use words::{is_reserved, reserved};
