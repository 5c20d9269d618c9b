//! Why a game is won, as plain data: the winning region, and for every goal the layers in which it
//! is approached.
//!
//! An outsider can check the verdict from this without solving anything; `docs/proof.md` describes
//! the check.

use super::arena::Arena;
use super::fixpoint::layers;
use crate::symbolic::{Diagram, Encoding, Kernel, Limit};
use linewright_core::gr1::{Specification, Time, VarId};

/// The ranking of a winning region.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranking {
    /// For each variable of the specification, the numbers of its current bits, most significant
    /// first. The next bit of a current bit has the next higher number.
    pub bits: Vec<Vec<u16>>,
    /// The current bits from the top of the diagram to its bottom, each followed by its next bit.
    pub order: Vec<u16>,
    /// All functions, over current bits. Its first root is the winning region.
    pub diagram: Diagram,
    /// For every goal, its layers, the nearest first. A specification without goals has the single
    /// goal `true`.
    pub goals: Vec<Vec<Rank>>,
}

/// One layer on the way to a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rank {
    /// Index of the assumption that fails for ever if the play waits here for ever; without
    /// assumptions there is a single one, `true`.
    pub assumption: usize,
    /// Root of the states in which the machine makes progress, or waits while that assumption does
    /// not hold.
    pub wait: usize,
    /// Root of all states of this layer and the layers before it.
    pub reached: usize,
}

/// Computes the ranking of a winning region.
pub fn ranking<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
) -> Result<Ranking, Limit> {
    let mut functions = vec![region.clone()];
    let mut goals = Vec::new();
    for j in 0..arena.goals.len() {
        let mut ranks = Vec::new();
        for layer in layers(arena, j, region)? {
            ranks.push(Rank {
                assumption: layer.assumption,
                wait: functions.len(),
                reached: functions.len() + 1,
            });
            functions.extend([layer.wait, layer.reached]);
        }
        goals.push(ranks);
    }
    let encoding = Encoding::new(specification);
    let variables = (0..specification.variables.len()).map(|v| VarId(v as u32));
    let pairs = encoding.pairs();
    let order = arena.kernel.order();
    Ok(Ranking {
        bits: variables
            .map(|v| encoding.bits(v, Time::Now).map(|b| b.0).collect())
            .collect(),
        // The last pair belongs to the strategy; no function here depends on it.
        order: order
            .pairs()
            .iter()
            .filter(|p| usize::from(**p) < pairs)
            .map(|p| 2 * p)
            .collect(),
        diagram: arena.kernel.export(&functions.iter().collect::<Vec<_>>()),
        goals,
    })
}
