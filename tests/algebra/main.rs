//! Composition, refinement and the other operations on contracts, compared with brute force.

mod closed;
mod composition;
mod discharge;
#[expect(dead_code, reason = "only who wins is asked here")]
#[path = "../solver/game.rs"]
mod game;
mod layers;
mod library;
mod oracle;
#[expect(dead_code, reason = "only its random numbers are used here")]
#[path = "../solver/random.rs"]
mod random;
#[path = "../support/mod.rs"]
mod support;
