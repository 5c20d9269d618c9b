//! The program from outside, the library as other programs use it, and the rules of the repository.

mod algebra;
mod b2mml;
mod book;
mod browser;
mod catalogue;
mod cli;
mod drawings;
mod hostile;
mod imports;
mod pages;
mod project;
mod readme;
mod recipe_runs;
mod recipes;
mod schema;
mod step;
mod style;
#[path = "../support/mod.rs"]
mod support;
mod watch;
