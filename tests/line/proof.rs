//! The abstraction of lines, against an explorer that shares no code with it, an evaluator that
//! only evaluates, and the runner.

mod advice;
mod examples;
mod explorer;
mod lines;
mod random;
mod replay;
