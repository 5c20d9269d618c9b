//! From a specification to a verdict: which kernel, which order, and what it took.
//!
//! Small games are played on biodivine's kernel, which starts at once; a game that outgrows [`SMALL_NODES`] there, or has more
//! than [`SMALL_PAIRS`] pairs of bits, is played on OxiDD's. The choice depends on the specification only, so that the same
//! input always gives the same machine.

use super::arena::{Arena, Formulas, Selection, first_order};
use super::core;
use super::explore::{self, Explicit};
use super::findings::{self, EnvironmentFindings};
use super::fixpoint::{Iterations, winning_region};
use super::heuristics::{Heuristic, Heuristics};
use super::strategy;
use super::{Lost, Outcome, Won};
use crate::gr1::{Specification, Time, VarId};
use crate::symbolic::{Biodivine, Encoding, Kernel, Limit, Limits, Order, OxiDd};
use std::fmt::Debug;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// A game of more pairs of bits than this is not small.
const SMALL_PAIRS: usize = 48;

/// A game that needs more nodes than this at once is not small.
const SMALL_NODES: u64 = 100_000;

/// Which kernel a game is played on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelChoice {
    /// By the size of the game.
    #[default]
    Automatic,
    /// biodivine-lib-bdd: every function owns its nodes.
    Biodivine,
    /// OxiDD: a shared store with complement edges.
    OxiDd,
}

/// How to solve.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// When to give up.
    pub limits: Limits,
    /// Which kernel.
    pub kernel: KernelChoice,
    /// What is done to be fast.
    pub heuristics: Heuristics,
    /// Whether no core is looked for when there is no machine.
    pub without_core: bool,
}

/// What a verdict took.
#[derive(Debug, Clone, Default)]
pub struct Statistics {
    /// The kernel it was found on.
    pub kernel: &'static str,
    /// Pairs of a current and a next bit.
    pub pairs: usize,
    /// Seconds of the clock until all formulas were functions.
    pub encode_seconds: f64,
    /// Seconds spent on the order and the clusters before the fixpoint.
    pub order_seconds: f64,
    /// Seconds of the fixpoint.
    pub fixpoint_seconds: f64,
    /// The largest number of nodes that were kept at once.
    pub peak_nodes: u64,
    /// Steps of the outermost fixpoint: one a goal and round.
    pub outer: u64,
    /// Steps of the middle fixpoints: one an assumption and round.
    pub middle: u64,
    /// Steps of the innermost fixpoints.
    pub inner: u64,
    /// Controllable predecessors that were computed.
    pub predecessors: u64,
    /// The variables from the top of the diagrams to their bottom at the start, by the place of their first bit.
    pub order_before: Vec<VarId>,
    /// The same at the end.
    pub order_after: Vec<VarId>,
}

/// A verdict and what it took.
#[derive(Debug)]
pub struct Solved {
    /// The verdict.
    pub outcome: Outcome,
    /// What it took; what was reached when a limit ended it.
    pub statistics: Statistics,
}

/// What a won game can do, whatever its kernel.
pub trait Game: Debug + Send + Sync {
    /// See [`Won::explore`].
    fn explore(&self, specification: &Specification, limits: &Limits) -> Result<Explicit, Limit>;

    /// See [`Won::examine_environment`].
    fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit>;
}

/// A game that was won on one kernel.
#[derive(Debug)]
struct WonGame<K: Kernel> {
    arena: Arena<K>,
    /// The states from which the machine wins.
    region: K::Function,
}

impl<K: Kernel> Game for WonGame<K> {
    fn explore(&self, specification: &Specification, limits: &Limits) -> Result<Explicit, Limit> {
        let arena = self.arena.with_limits(limits);
        let strategy = strategy::strategy(&arena, specification, &self.region)?;
        explore::explore(&arena, specification, &strategy, limits)
    }

    fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit> {
        findings::examine(&self.arena.with_limits(limits), specification)
    }
}

/// Decides whether a machine exists, in the usual way; where there is none, also looks for a minimal core of guarantees.
pub fn solve(specification: &Specification, limits: &Limits) -> Outcome {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    solve_with(specification, &options).outcome
}

/// Decides whether a machine exists.
pub fn solve_with(specification: &Specification, options: &Options) -> Solved {
    let order = first_order(specification, options.heuristics);
    if let Some(limits) = small(&order, options) {
        let solved = play::<Biodivine>(specification, &order, &limits, options);
        let outgrown = options.kernel == KernelChoice::Automatic
            && matches!(solved.outcome, Outcome::GaveUp(Limit::Memory));
        if !outgrown {
            return solved;
        }
    }
    play::<OxiDd>(specification, &order, &options.limits, options)
}

/// The limits for a try on biodivine's kernel, if there shall be one.
fn small(order: &Order, options: &Options) -> Option<Limits> {
    match options.kernel {
        KernelChoice::Biodivine => Some(options.limits),
        KernelChoice::OxiDd => None,
        KernelChoice::Automatic if order.pairs().len() > SMALL_PAIRS => None,
        KernelChoice::Automatic => Some(Limits {
            most_nodes: Some(SMALL_NODES),
            ..options.limits
        }),
    }
}

/// Examines the environment's side on whichever kernel fits.
pub fn examine(
    specification: &Specification,
    limits: &Limits,
) -> Result<EnvironmentFindings, Limit> {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    let order = first_order(specification, options.heuristics);
    if let Some(limits) = small(&order, &options) {
        let found = examine_on::<Biodivine>(specification, &order, &limits, options.heuristics);
        if found != Err(Limit::Memory) {
            return found;
        }
    }
    examine_on::<OxiDd>(specification, &order, limits, options.heuristics)
}

fn examine_on<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    heuristics: Heuristics,
) -> Result<EnvironmentFindings, Limit> {
    let (_, arena, _) = set_up::<K>(specification, order, heuristics, limits)?;
    findings::examine(&arena, specification)
}

/// Bounds of the clusters, in nodes. Some relations want to be in one piece (generators of buffers, three to four times
/// faster), others in a few (AMBA's arbiter, the reverse).
const FIRST_BOUND: usize = 1_000;

/// The bound for relations that may be in one piece.
const WHOLE_BOUND: usize = 5_000;

/// The bound for relations that had better stay in pieces.
pub const SPLIT_BOUND: usize = 3_000;

/// So few clusters need not become fewer.
const FEW_CLUSTERS: usize = 3;

/// How often larger clusters are built anew in the order that the last ones led to, while that makes them fewer or smaller.
const MORE_ROUNDS: usize = 3;

/// A relation stays in pieces when putting it together takes more than this many percent of the nodes that its pieces have.
const WHOLE_PERCENT: usize = 180;

/// The formulas and the whole game, in a good order, and the seconds it took to encode them.
///
/// The order is sifted for small clusters first, so that larger ones can be built in it. Whether the pieces of a relation
/// belong together is then a matter of size: if the larger clusters take far more nodes than the smaller ones did, the game
/// is set up once more, with clusters that are sifted but not put together further.
fn set_up<K: Kernel>(
    specification: &Specification,
    order: &Order,
    heuristics: Heuristics,
    limits: &Limits,
) -> Result<(Formulas<K>, Arena<K>, f64), Limit> {
    let start = Instant::now();
    let encode = || Formulas::<K>::encode(specification, order, heuristics, limits);
    let formulas = encode()?;
    let encoding = start.elapsed().as_secs_f64();
    let kernel = formulas.kernel();
    if !heuristics.has(Heuristic::Sifting) || !K::REORDERS {
        let arena = formulas.arena(&Selection::All, SPLIT_BOUND)?;
        return Ok((formulas, arena, encoding));
    }
    let sifted = |formulas: &Formulas<K>, bound: usize| -> Result<_, Limit> {
        let arena = formulas.arena(&Selection::All, bound)?;
        formulas.kernel().sift()?;
        let size = arena.environment.size(&arena.kernel) + arena.system.size(&arena.kernel);
        Ok((arena, size))
    };
    kernel.sift()?;
    let (arena, pieces) = sifted(&formulas, FIRST_BOUND)?;
    drop(arena);
    let (mut arena, mut whole) = sifted(&formulas, WHOLE_BOUND)?;
    if whole * 100 <= pieces * WHOLE_PERCENT {
        let count = |arena: &Arena<K>| arena.environment.count() + arena.system.count();
        for _ in 0..MORE_ROUNDS {
            if count(&arena) <= FEW_CLUSTERS {
                break;
            }
            let (next, size) = sifted(&formulas, WHOLE_BOUND)?;
            if count(&next) >= count(&arena) && size >= whole {
                break;
            }
            (arena, whole) = (next, size);
        }
        return Ok((formulas, arena, encoding));
    }
    drop((arena, formulas));
    let formulas = encode()?;
    formulas.kernel().sift()?;
    let (arena, _) = sifted(&formulas, SPLIT_BOUND)?;
    Ok((formulas, arena, encoding))
}

/// Solves a game on one kernel.
fn play<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    options: &Options,
) -> Solved {
    let mut statistics = Statistics {
        kernel: K::NAME,
        pairs: order.pairs().len(),
        order_before: variables(specification, order),
        ..Statistics::default()
    };
    let iterations = Iterations::default();
    let outcome = decide::<K>(
        specification,
        order,
        limits,
        options,
        &iterations,
        &mut statistics,
    )
    .unwrap_or_else(Outcome::GaveUp);
    statistics.outer = iterations.outer.load(Ordering::Relaxed);
    statistics.middle = iterations.middle.load(Ordering::Relaxed);
    statistics.inner = iterations.inner.load(Ordering::Relaxed);
    statistics.predecessors = iterations.predecessors.load(Ordering::Relaxed);
    Solved {
        outcome,
        statistics,
    }
}

fn decide<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    options: &Options,
    iterations: &Iterations,
    statistics: &mut Statistics,
) -> Result<Outcome, Limit> {
    let start = Instant::now();
    let (formulas, arena, encoding) =
        set_up::<K>(specification, order, options.heuristics, limits)?;
    statistics.encode_seconds = encoding;
    statistics.order_seconds = start.elapsed().as_secs_f64() - encoding;

    let start = Instant::now();
    let region = winning_region(&arena, iterations);
    statistics.fixpoint_seconds = start.elapsed().as_secs_f64();
    statistics.peak_nodes = formulas.peak_nodes();
    statistics.order_after = variables(specification, &formulas.kernel().order());
    if let Some(region) = region? {
        return Ok(Outcome::Realizable(Won {
            game: Box::new(WonGame { arena, region }),
            peak_nodes: formulas.peak_nodes(),
        }));
    }
    drop(arena);
    let core = if options.without_core {
        None
    } else {
        core::minimal_core(&formulas).ok()
    };
    Ok(Outcome::Unrealizable(Lost {
        core,
        peak_nodes: formulas.peak_nodes(),
    }))
}

/// The variables by the place of their topmost bit.
fn variables(specification: &Specification, order: &Order) -> Vec<VarId> {
    let encoding = Encoding::new(specification);
    let positions = order.positions();
    let mut places: Vec<(u16, VarId)> = (0..specification.variables.len() as u32)
        .filter_map(|v| {
            let bits = encoding.bits(VarId(v), Time::Now);
            let top = bits.map(|b| positions[usize::from(b.pair())]).min()?;
            Some((top, VarId(v)))
        })
        .collect();
    places.sort_unstable();
    places.into_iter().map(|(_, v)| v).collect()
}
