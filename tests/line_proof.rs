//! The abstraction of lines, against an explorer that shares no code with it, an evaluator that only evaluates, and the runner.

#[path = "line_proof/examples.rs"]
mod examples;
#[path = "line_proof/explorer.rs"]
mod explorer;
#[path = "line_proof/lines.rs"]
mod lines;
#[path = "algebra/mutants.rs"]
mod mutants;
#[path = "line_proof/random.rs"]
mod random;
#[path = "line_proof/replay.rs"]
mod replay;
#[path = "line/support.rs"]
#[allow(dead_code, reason = "shared with the tests of the runner")]
mod support;
#[path = "algebra/tables.rs"]
mod tables;
