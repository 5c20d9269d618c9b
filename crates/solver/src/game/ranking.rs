//! Evidence that a game is won, as plain data: the winning region, and for every goal the layers
//! through which a play approaches it.
//!
//! It allows an independent program to check the verdict without solving the game; `docs/proof.md`
//! describes the check.

use super::arena::Arena;
use super::fixpoint::layers;
use crate::symbolic::{Diagram, Encoding, Kernel, Limit};
use linewright_core::gr1::{Specification, Time, VarId};

/// A winning region with the layers of every goal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranking {
    /// Numbers of the current bits of each variable of the specification, most significant first.
    /// The next bit of a current bit has the next higher number.
    pub bits: Vec<Vec<u16>>,
    /// Numbers of the current bits from the top of the diagram to its bottom. Each current bit is
    /// directly above its next bit, which is not listed.
    pub order: Vec<u16>,
    /// All sets of states, over current bits. The first root is the winning region.
    pub diagram: Diagram,
    /// Layers of every goal, the one nearest to the goal first. A specification without goals has
    /// the single goal `true`.
    pub goals: Vec<Vec<Rank>>,
}

/// One layer of a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rank {
    /// Index of the justice assumption that is never met if the play waits in this layer for ever.
    /// A specification without justice assumptions has the single assumption `true`.
    pub assumption: usize,
    /// Index of the diagram's root for the states in which the machine makes progress, or waits
    /// while that assumption does not hold.
    pub wait: usize,
    /// Index of the diagram's root for the states of this layer and of all layers before it.
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
        // The last pair holds the strategy's flag; no function here depends on it.
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
