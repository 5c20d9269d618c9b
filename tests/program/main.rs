//! The program from outside, the library as other programs use it, and the rules of the repository.

mod algebra;
mod cli;
mod hostile;
mod imports;
mod project;
mod readme;
mod step;
mod style;
#[path = "../support/mod.rs"]
mod support;
mod watch;
