//! Tests of the building blocks of games, on random functions and specifications.

mod orders;
mod parts;
mod runs;

use crate::random::{Random, specification, specification_with_goals};
