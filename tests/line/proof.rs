//! The abstraction of lines, compared with an independent explorer, a pure evaluator, and the
//! runner.

mod advice;
mod examples;
mod explorer;
mod lines;
mod random;
mod replay;
