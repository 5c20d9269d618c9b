//! Tests of the building blocks of games, on random functions and specifications.

mod orders;
mod parts;

#[allow(dead_code, reason = "each test needs a part of it")]
#[path = "../../../../../tests/solver/random.rs"]
mod random;

use random::{Random, specification, specification_with_goals};
