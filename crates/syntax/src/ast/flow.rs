//! Routes, parallel stations and the order of parts in a buffer, in the syntax tree.

use super::{Expr, Name};
use linewright_core::source::Span;

/// A stop of a route: one place, or several of which each part goes to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Stop {
    /// The places, in source order; at least one.
    pub places: Vec<Name>,
    /// How one of several places is chosen, if this is written.
    pub choice: Option<StopChoice>,
    /// Place of the whole stop.
    pub span: Span,
}

impl Stop {
    /// The expressions in the stop, in source order.
    pub fn expressions(&self) -> &[Expr] {
        match &self.choice {
            Some(StopChoice::Probability(shares)) => shares,
            _ => &[],
        }
    }
}

/// How a part chooses one of several places.
#[derive(Debug, Clone, PartialEq)]
pub enum StopChoice {
    /// `first free`
    FirstFree,
    /// `shortest queue`
    ShortestQueue,
    /// `round robin`
    RoundRobin,
    /// `by probability 5 %, 95 %`
    Probability(Vec<Expr>),
}

impl StopChoice {
    /// The words of the choice, without probabilities.
    pub fn words(&self) -> &'static str {
        match self {
            Self::FirstFree => "first free",
            Self::ShortestQueue => "shortest queue",
            Self::RoundRobin => "round robin",
            Self::Probability(_) => "by probability",
        }
    }
}

/// `times 3`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Copies {
    /// Number of stations.
    pub count: u64,
    /// Place of the number.
    pub span: Span,
}

/// Which part leaves a buffer first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BufferOrder {
    /// `lifo`: the one that came last.
    LastIn,
    /// `highest urgency first`: the one with the highest value of a property.
    Highest(Name),
    /// `lowest due first`: the one with the lowest value of a property.
    Lowest(Name),
}
