//! The language: parsing, names, types, layout and the messages about them.

mod cases;
#[path = "../fuzz/check.rs"]
mod check;
mod corpus;
mod explanations;
mod format;
mod forms;
mod printed;
#[path = "../fuzz/program.rs"]
mod program;
mod recipes;
mod robustness;
mod sarif;
mod semantics;
mod shapes;
mod skills;
mod spans;
#[path = "../support/mod.rs"]
mod support;
mod table1;
mod tables;
#[path = "../fuzz/uf_value.rs"]
mod uf_value;
mod words;
