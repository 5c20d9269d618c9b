//! From a specification to a verdict: choice of kernel and order, and statistics.
//!
//! Small games are played on biodivine's kernel, which starts at once. A game that exceeds
//! [`SMALL_NODES`] there, or [`SMALL_MADE`], or has more than [`SMALL_PAIRS`] pairs of bits, is
//! played on `OxiDD`'s. The choice depends only on the specification, so that the same input always
//! gives the same machine.

use super::arena::{Arena, Formulas, first_order};
use super::attack::{self, Attack, Play};
use super::core;
use super::explore::{self, Explicit};
use super::findings::shape::{self, Shape};
use super::findings::{self, EnvironmentFindings};
use super::fixpoint::winning_region;
use super::functions::{self, Controls};
use super::heuristics::Heuristics;
use super::outcome::{Game, LostGame, Outcome, WonGame};
use super::progress::{Phase, Progress};
use super::ranking::{self, Ranking};
use super::reference::GuaranteeRef;
use super::repair::{self, Advice};
use super::set_up;
use super::statistics::Statistics;
use super::strategy::{self, Preference};
use crate::symbolic::{Biodivine, Bit, Diagram, Encoding, Kernel, Limit, Limits, Order, OxiDd};
use linewright_core::gr1::{Formula, Specification, Time, VarId};
use std::sync::Arc;
use std::time::Instant;

/// Maximum number of bit pairs of a small game.
const SMALL_PAIRS: usize = 48;

/// Maximum number of nodes at once in a small game.
const SMALL_NODES: u64 = 13_000;

/// Maximum number of nodes made in total in a small game: about a hundredth of a second.
const SMALL_MADE: u64 = 50_000;

/// Number of nodes at once above which a game is large.
const LARGE_NODES: u64 = 100_000;

/// The same bound where dead nodes count until they are collected.
const LARGE_NODES_SHARED: u64 = 1 << 20;

/// The kernel that a game is played on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelChoice {
    /// Chosen by the size of the game.
    #[default]
    Automatic,
    /// biodivine-lib-bdd: every function owns its nodes.
    Biodivine,
    /// `OxiDD`: a shared store with complement edges.
    OxiDd,
}

/// Options of the solver.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Time and memory limits.
    pub limits: Limits,
    /// Kernel to use.
    pub kernel: KernelChoice,
    /// Enabled heuristics.
    pub heuristics: Heuristics,
    /// Whether to skip the search for a core if there is no machine.
    pub without_core: bool,
    /// Initial variable order, instead of searching for one. With the automatic kernel, only a
    /// large game uses it.
    pub first_order: Option<Order>,
    /// A set of states, as the first root, that is known to contain the winning region. With the
    /// automatic kernel, only a large game uses it.
    pub first_region: Option<Diagram>,
    /// Where progress is published. Cloned options publish to the same place.
    pub progress: Arc<Progress>,
}

/// A verdict and its statistics.
#[derive(Debug)]
pub struct Solution {
    /// The verdict.
    pub outcome: Outcome,
    /// Statistics; if a limit was reached, up to that point.
    pub statistics: Statistics,
}

/// A game won on one kernel.
#[derive(Debug)]
struct RealizedGame<K: Kernel> {
    /// Separate formulas; not kept for a large game.
    formulas: Option<Formulas<K>>,
    arena: Arena<K>,
    /// The states from which the machine wins.
    region: K::Function,
}

impl<K: Kernel> Game for RealizedGame<K> {
    fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<Explicit, Limit> {
        let arena = self.arena.with_limits(limits);
        let strategy = strategy::strategy(&arena, specification, preference, &self.region)?;
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
        match &self.formulas {
            Some(formulas) => findings::examine(
                &formulas.with_limits(limits),
                &self.arena.with_limits(limits),
                specification,
            ),
            None => examine_environment(specification, limits),
        }
    }

    fn shape(&self, specification: &Specification, limits: &Limits) -> Result<Shape, Limit> {
        shape::shape(&self.arena.with_limits(limits), specification, &self.region)
    }

    fn ranking(&self, specification: &Specification, limits: &Limits) -> Result<Ranking, Limit> {
        ranking::ranking(&self.arena.with_limits(limits), specification, &self.region)
    }

    fn region(&self) -> Diagram {
        self.arena.kernel.export(&[&self.region])
    }
}

/// Decides whether a machine exists, with default options; if there is none, also finds a minimal
/// core of guarantees.
pub fn solve(specification: &Specification, limits: &Limits) -> Outcome {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    solve_with(specification, &options).outcome
}

/// Decides whether a machine exists.
pub fn solve_with(specification: &Specification, options: &Options) -> Solution {
    let order = first_order(specification, options.heuristics);
    if let Some(limits) = small(&order, options) {
        let solved = if options.kernel == KernelChoice::Automatic {
            play::<Biodivine>(specification, &order, &limits, options, Start::default())
        } else {
            play::<Biodivine>(specification, &order, &limits, options, Start::of(options))
        };
        let outgrown = options.kernel == KernelChoice::Automatic
            && matches!(solved.outcome, Outcome::GaveUp(Limit::Memory));
        if !outgrown {
            return solved;
        }
    }
    let start = Start::of(options);
    play::<OxiDd>(specification, &order, &options.limits, options, start)
}

/// Prior knowledge for a solve.
#[derive(Clone, Copy, Default)]
struct Start<'a> {
    order: Option<&'a Order>,
    region: Option<&'a Diagram>,
}

impl<'a> Start<'a> {
    fn of(options: &'a Options) -> Self {
        Self {
            order: options.first_order.as_ref(),
            region: options.first_region.as_ref(),
        }
    }

    /// Drops everything that does not fit the bits of the game.
    fn fitting(self, pairs: usize) -> Self {
        Self {
            order: self.order.filter(|o| o.pairs().len() == pairs),
            region: self
                .region
                .filter(|r| r.roots.len() == 1 && r.is_sound(2 * pairs)),
        }
    }
}

/// Limits for an attempt on biodivine's kernel, if one is to be made.
fn small(order: &Order, options: &Options) -> Option<Limits> {
    match options.kernel {
        KernelChoice::Biodivine => Some(options.limits),
        KernelChoice::OxiDd => None,
        KernelChoice::Automatic if order.pairs().len() > SMALL_PAIRS => None,
        KernelChoice::Automatic => Some(Limits {
            most_nodes: Some(SMALL_NODES),
            most_made: Some(SMALL_MADE),
            ..options.limits
        }),
    }
}

/// Examines the environment. Independent of whether the specification is realizable.
pub fn examine_environment(
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
    let progress = Progress::default();
    let (formulas, arena) =
        set_up::set_up::<K>(specification, order, heuristics, limits, &progress)?;
    findings::examine(&formulas, &arena, specification)
}

/// Computes the counterstrategy of a specification and the play that shows it, or `None` if the
/// machine wins.
///
/// In the play the machine starts as `beginning` says, if it can. Meant for the
/// [reduced](super::reduced) specification of a minimal core: a machine that cannot keep the core
/// cannot keep more.
pub fn attack(
    specification: &Specification,
    beginning: &[Formula],
    limits: &Limits,
) -> Result<Option<Attack>, Limit> {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    let order = first_order(specification, options.heuristics);
    if let Some(limits) = small(&order, &options) {
        let found = attack::attack_on::<Biodivine>(specification, beginning, &limits);
        if !matches!(found, Err(Limit::Memory)) {
            return found;
        }
    }
    attack::attack_on::<OxiDd>(specification, beginning, limits)
}

/// Suggests repairs of an unrealizable specification, given a minimal core and a play that shows
/// it.
pub fn advise(
    specification: &Specification,
    core: &[GuaranteeRef],
    play: &Play,
    limits: &Limits,
) -> Result<Advice, Limit> {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    let order = first_order(specification, options.heuristics);
    if let Some(limits) = small(&order, &options) {
        let limits = Limits {
            most_made: None,
            ..limits
        };
        let found = repair::advise_on::<Biodivine>(specification, core, play, &limits);
        if !matches!(found, Err(Limit::Memory)) {
            return found;
        }
    }
    repair::advise_on::<OxiDd>(specification, core, play, limits)
}

/// Solves a game on one kernel.
fn play<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    options: &Options,
    start: Start<'_>,
) -> Solution {
    let start = start.fitting(order.pairs().len());
    let order = start.order.unwrap_or(order);
    let progress = &*options.progress;
    progress.begin(Statistics {
        kernel: K::NAME,
        pairs: order.pairs().len(),
        large: order.pairs().len() > SMALL_PAIRS,
        order_before: variables(specification, order),
        ..Statistics::default()
    });
    let outcome = decide::<K>(specification, order, limits, options, start);
    // Otherwise the phase shows how far it came.
    if outcome.is_ok() {
        progress.enter(Phase::Ended);
    }
    Solution {
        outcome: outcome.unwrap_or_else(Outcome::GaveUp),
        statistics: progress.statistics(),
    }
}

fn decide<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    options: &Options,
    start: Start<'_>,
) -> Result<Outcome, Limit> {
    let progress = &*options.progress;
    let (formulas, arena) =
        set_up::set_up::<K>(specification, order, options.heuristics, limits, progress)?;

    progress.enter(Phase::Fixpoint);
    let clock = Instant::now();
    let within = match start.region {
        Some(region) => Some(arena.kernel.import(region)?.swap_remove(0)),
        None => None,
    };
    let region = winning_region(&arena, within.as_ref(), progress.iterations());
    drop(within);
    let peak_nodes = formulas.peak_nodes();
    let last_order = formulas.kernel().order();
    progress.note(|s| {
        s.fixpoint_seconds = clock.elapsed().as_secs_f64();
        s.peak_nodes = peak_nodes;
        s.order_after = variables(specification, &last_order);
        s.last_order = Some(last_order);
        s.large |= peak_nodes
            > match K::NAME {
                Biodivine::NAME => LARGE_NODES,
                _ => LARGE_NODES_SHARED,
            };
    });
    if let Some(region) = region? {
        return Ok(Outcome::Realizable(WonGame {
            game: Box::new(RealizedGame {
                formulas: (!progress.statistics().large).then_some(formulas),
                arena,
                region,
            }),
            peak_nodes,
        }));
    }
    drop(arena);
    progress.enter(Phase::Core);
    let core = if options.without_core {
        None
    } else {
        match core::minimal_core(&formulas, specification) {
            // This was an attempt with little room; the other kernel has more.
            Err(Limit::Memory) if limits.most_made != options.limits.most_made => {
                return Err(Limit::Memory);
            }
            core => core.ok(),
        }
    };
    Ok(Outcome::Unrealizable(LostGame {
        core,
        peak_nodes: formulas.peak_nodes(),
    }))
}

/// Converts an order of variables, given by index, to an order of bit pairs. `None` unless each
/// variable occurs once.
pub fn order_of_variables(
    specification: &Specification,
    variables: impl IntoIterator<Item = usize>,
) -> Option<Order> {
    let encoding = Encoding::new(specification);
    let known = specification.variables.len();
    let variables = variables.into_iter().filter(|v| *v < known);
    let pairs = variables.flat_map(|v| {
        let bits = encoding.bits(VarId(v as u32), Time::Now);
        bits.map(Bit::pair).collect::<Vec<_>>()
    });
    // The strategy's own pair comes last.
    let last = encoding.pairs() as u16;
    let order = Order::new(pairs.chain([last]).collect())?;
    (order.pairs().len() == usize::from(last) + 1).then_some(order)
}

/// The variables by the position of their topmost bit.
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
