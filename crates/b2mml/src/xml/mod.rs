//! XML as a tree with the place of each element.
//!
//! `quick-xml` separates tags, texts and comments, matches end tags and resolves prefixes. It
//! leaves some rules of XML 1.0 to its users; [`check`] has them. A document type declaration is
//! refused before anything in it has a meaning, so there are no entities to expand.

mod check;
mod tree;
mod writer;

pub(crate) use check::is_blank;
pub(crate) use tree::{Element, Origin, Tree, parse};
pub(crate) use writer::XmlWriter;

/// Namespace of XML Schema's own attributes.
pub(crate) const INSTANCE: &str = "http://www.w3.org/2001/XMLSchema-instance";
