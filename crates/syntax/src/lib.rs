//! The contract language: grammar, syntax trees, parser and formatter.
//!
//! [`parse`] always returns a tree and a list of findings, and does not panic on any text. The
//! crate `language` resolves the names.

// What pest generates without its feature `std` names this crate. The feature measures the rest of
// the stack at every rule; this parser bounds the depth of a text instead.
extern crate alloc;

pub mod ast;
mod binds;
mod build;
pub mod format;
mod mend;
mod parser;
mod spans;
mod value;
mod words;

pub use mend::{
    begins_skill_set, declares_inner_machine, declares_layout_or_recipe, declares_skill_set,
};
pub use parser::{is_transfer_label, is_word, parse, parse_value};
pub use value::{Value, ValueSyntax};
pub use words::{is_reserved, reserved_words};
