//! The abstraction of lines, against an explorer that shares no code with it, an evaluator that only evaluates, and the runner.

#[path = "line_proof/examples.rs"]
mod examples;
