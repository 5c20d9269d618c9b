//! Sets up a game before the fixpoint: encodes the formulas, finds a good variable order, and
//! builds the relations as clusters.
//!
//! The order is first sifted for small clusters, so that larger clusters can be built in the
//! resulting order. If the larger clusters then take far more nodes than the small ones, the game
//! is set up again from the start with clusters of medium size.

use super::arena::{Arena, Formulas, Selection, initial_order};
use super::clusters::Clustering;
use super::heuristics::{Heuristic, Heuristics};
use super::progress::{Phase, Progress};
use crate::symbolic::{Kernel, Limit, Limits, Order};
use linewright_core::gr1::Specification;
use std::time::Instant;

/// First attempt: small clusters. The number is the maximum number of nodes of a cluster, here and
/// below. Some games are solved three to four times as fast if each relation is one piece (the
/// genbuf benchmarks). Other games gain the same factor from a few pieces (the AMBA arbiter).
const FIRST: Clustering = Clustering::InOrder(1_000);

/// Second attempt: large clusters, for relations that are best as one piece.
const WHOLE: Clustering = Clustering::InOrder(5_000);

/// For rebuilding relations after large clusters have proved worthwhile.
const WHOLE_AGAIN: Clustering = Clustering::ByBits(5_000);

/// Clusters of medium size, for relations that are best as a few pieces.
pub const SPLIT: Clustering = Clustering::InOrder(3_000);

/// Number of clusters, summed over both relations, that is small enough: up to this number,
/// clusters are not combined further.
const FEW_CLUSTERS: usize = 3;

/// Maximum number of times that the large clusters are rebuilt in the latest order. Rebuilding ends
/// earlier if the number of clusters does not decrease.
const MAX_REBUILDS: usize = 3;

/// The relations are split into pieces if the large clusters take more than this percentage of the
/// nodes of the small clusters.
const WHOLE_PERCENT: usize = 180;

/// Encodes the formulas and builds the whole game in a good order. Records the time that each step
/// takes, even if a limit ends the step.
pub fn set_up<K: Kernel>(
    specification: &Specification,
    order: &Order,
    heuristics: Heuristics,
    limits: &Limits,
    progress: &Progress,
) -> Result<(Formulas<K>, Arena<K>), Limit> {
    let encode = || Formulas::<K>::encode(specification, order, heuristics, limits);
    let clock = Instant::now();
    let formulas = encode();
    progress.update(|s| s.encode_seconds = clock.elapsed().as_secs_f64());
    let formulas = formulas?;

    progress.set_phase(Phase::Ordering);
    let clock = Instant::now();
    let found = if heuristics.has(Heuristic::Sifting) && K::REORDERS {
        with_sifting(formulas, encode)
    } else {
        let arena = formulas.arena(&Selection::All, SPLIT);
        arena.map(|arena| (formulas, arena))
    };
    progress.update(|s| s.order_seconds = clock.elapsed().as_secs_f64());
    found
}

/// Sets up a game with default heuristics, for examinations that are independent of a verdict.
pub fn set_up_default<K: Kernel>(
    specification: &Specification,
    limits: &Limits,
) -> Result<(Formulas<K>, Arena<K>), Limit> {
    let heuristics = Heuristics::default();
    let order = initial_order(specification, heuristics);
    set_up(
        specification,
        &order,
        heuristics,
        limits,
        &Progress::default(),
    )
}

/// Chooses the clusters by size and sifts the order; see the module documentation.
fn with_sifting<K: Kernel>(
    formulas: Formulas<K>,
    encode: impl Fn() -> Result<Formulas<K>, Limit>,
) -> Result<(Formulas<K>, Arena<K>), Limit> {
    formulas.kernel().sift()?;
    let count = |arena: &Arena<K>| arena.environment.count() + arena.system.count();
    let (arena, pieces) = sifted(&formulas, FIRST)?;
    if count(&arena) <= FEW_CLUSTERS {
        return Ok((formulas, arena));
    }
    drop(arena);
    let (mut arena, whole) = sifted(&formulas, WHOLE)?;
    if whole * 100 <= pieces * WHOLE_PERCENT {
        for _ in 0..MAX_REBUILDS {
            if count(&arena) <= FEW_CLUSTERS {
                break;
            }
            let next = formulas.arena(&Selection::All, WHOLE_AGAIN)?;
            if count(&next) >= count(&arena) {
                break;
            }
            arena = next;
            formulas.kernel().sift()?;
        }
        return Ok((formulas, arena));
    }
    drop((arena, formulas));
    let formulas = encode()?;
    formulas.kernel().sift()?;
    let (arena, _) = sifted(&formulas, SPLIT)?;
    Ok((formulas, arena))
}

/// Builds the game with this clustering and sifts the order. Returns the game and the number of
/// nodes of its relations.
fn sifted<K: Kernel>(
    formulas: &Formulas<K>,
    clustering: Clustering,
) -> Result<(Arena<K>, usize), Limit> {
    let arena = formulas.arena(&Selection::All, clustering)?;
    formulas.kernel().sift()?;
    let size = arena.environment.size(&arena.kernel) + arena.system.size(&arena.kernel);
    Ok((arena, size))
}
