//! Verdicts, machines, counterstrategies and proofs of specifications, compared with naive solvers.

mod benchmarks;
mod case_study;
mod checker;
mod checkers;
mod explained;
#[path = "../fixtures/mod.rs"]
mod fixtures;
mod functions;
mod game;
mod incremental;
#[expect(
    dead_code,
    reason = "the large contracts are tested as function blocks"
)]
#[path = "../station/library.rs"]
mod library;
mod monitors;
mod oracle;
mod proof;
mod queries;
mod random;
#[path = "../support/mod.rs"]
mod support;
mod switch;
