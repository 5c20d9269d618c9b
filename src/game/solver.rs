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
use super::functions::{self, Controls};
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
    /// Seconds spent on the order before the fixpoint.
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
    fn explore(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Explicit, Limit>;

    /// See [`Won::functions`].
    fn functions(&self, specification: &Specification, limits: &Limits) -> Result<Controls, Limit>;

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
    fn explore(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Explicit, Limit> {
        let arena = self.arena.with_limits(limits);
        let strategy = strategy::strategy(&arena, specification, &self.region)?;
        explore::explore(&arena, specification, &strategy, limits)
    }

    fn functions(&self, specification: &Specification, limits: &Limits) -> Result<Controls, Limit> {
        functions::functions(&self.arena.with_limits(limits), specification, &self.region)
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
    let formulas = Formulas::<K>::encode(specification, order, heuristics, limits)?;
    findings::examine(&arena_of(&formulas, heuristics)?, specification)
}

/// The whole game, in a good order.
fn arena_of<K: Kernel>(
    formulas: &Formulas<K>,
    heuristics: Heuristics,
) -> Result<Arena<K>, Limit> {
    let sifting = heuristics.has(Heuristic::Sifting);
    if sifting {
        formulas.kernel().sift()?;
    }
    let mut arena = formulas.arena(&Selection::All)?;
    if sifting {
        let n: usize = std::env::var("LW_ROUNDS").ok().and_then(|s| s.parse().ok()).unwrap_or(0);
        for _ in 0..n {
            formulas.kernel().sift()?;
            arena = formulas.arena(&Selection::All)?;
        }
        formulas.kernel().sift()?;
    }
    Ok(arena)
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
    let formulas = Formulas::<K>::encode(specification, order, options.heuristics, limits)?;
    statistics.encode_seconds = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let arena = arena_of(&formulas, options.heuristics)?;
    statistics.order_seconds = start.elapsed().as_secs_f64();

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
