//! `--least`: what plans have least of.

use crate::recipe::plan::Objective;
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

/// What a plan has least of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Least {
    /// Steps that resources take together.
    Steps,
    /// Time until all is done.
    Time,
    /// Electrical energy of all transitions.
    Energy,
    /// Transfers of a part from one resource to another.
    Transfers,
}

impl From<Least> for Objective {
    fn from(least: Least) -> Self {
        match least {
            Least::Steps => Self::Steps,
            Least::Time => Self::Time,
            Least::Energy => Self::Energy,
            Least::Transfers => Self::Transfers,
        }
    }
}
