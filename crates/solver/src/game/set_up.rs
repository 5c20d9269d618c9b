//! The board before the fixpoint: encoded formulas, a good variable order, the relations in
//! clusters.
//!
//! The order is sifted for small clusters first, so that larger ones can be built in it. Whether to
//! combine the pieces of a relation is then decided by size: if the larger clusters take far more
//! nodes than the smaller ones, the game is set up again with clusters that are sifted but not
//! combined further.

use super::arena::{Arena, Formulas, Selection, first_order};
use super::clusters::Clustering;
use super::heuristics::{Heuristic, Heuristics};
use super::progress::{Phase, Progress};
use crate::symbolic::{Kernel, Limit, Limits, Order};
use linewright_core::gr1::Specification;
use std::time::Instant;

/// Bounds of the clusters in nodes. Some relations are best in one piece (generators of buffers,
/// three to four times faster), others in a few (AMBA's arbiter, the reverse).
const FIRST: Clustering = Clustering::InOrder(1_000);

/// For relations that may be in one piece.
const WHOLE: Clustering = Clustering::InOrder(5_000);

/// For relations that benefited from it, when they are rebuilt.
const WHOLE_AGAIN: Clustering = Clustering::ByBits(5_000);

/// For relations that should stay in pieces.
pub const SPLIT: Clustering = Clustering::InOrder(3_000);

/// Number of clusters that need not be reduced further.
const FEW_CLUSTERS: usize = 3;

/// Maximum number of times that larger clusters are rebuilt in the latest order, as long as their
/// number decreases.
const MORE_ROUNDS: usize = 3;

/// A relation stays in pieces if combining it takes more than this percentage of the nodes of its
/// pieces.
const WHOLE_PERCENT: usize = 180;

/// Builds the formulas and the whole game in a good order. The effort of each step is recorded,
/// even if a limit ends it.
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
    progress.note(|s| s.encode_seconds = clock.elapsed().as_secs_f64());
    let formulas = formulas?;

    progress.enter(Phase::Ordering);
    let clock = Instant::now();
    let found = if heuristics.has(Heuristic::Sifting) && K::REORDERS {
        in_order(formulas, encode)
    } else {
        let arena = formulas.arena(&Selection::All, SPLIT);
        arena.map(|arena| (formulas, arena))
    };
    progress.note(|s| s.order_seconds = clock.elapsed().as_secs_f64());
    found
}

/// Builds both with default options, for examining a specification beside its verdict.
pub fn set_up_default<K: Kernel>(
    specification: &Specification,
    limits: &Limits,
) -> Result<(Formulas<K>, Arena<K>), Limit> {
    let heuristics = Heuristics::default();
    let order = first_order(specification, heuristics);
    set_up(
        specification,
        &order,
        heuristics,
        limits,
        &Progress::default(),
    )
}

fn in_order<K: Kernel>(
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
        for _ in 0..MORE_ROUNDS {
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

/// The game in clusters, then sifted, and the number of nodes of its relations.
fn sifted<K: Kernel>(
    formulas: &Formulas<K>,
    clustering: Clustering,
) -> Result<(Arena<K>, usize), Limit> {
    let arena = formulas.arena(&Selection::All, clustering)?;
    formulas.kernel().sift()?;
    let size = arena.environment.size(&arena.kernel) + arena.system.size(&arena.kernel);
    Ok((arena, size))
}
