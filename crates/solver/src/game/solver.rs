//! Solves a specification: chooses the kernel and the variable order, decides whether a machine
//! exists, and collects statistics.
//!
//! Small games are solved on biodivine's kernel, which takes no time to start. A game that has more
//! than [`SMALL_PAIRS`] pairs of bits, or exceeds [`SMALL_NODES`] there, is solved on the kernel
//! with a shared store. The choice depends only on the specification, so that the same input always
//! gives the same machine.

use super::arena::{Arena, Formulas, initial_order, oriented_order};
use super::attack::{self, Attack, Play, PlayEnd};
use super::core;
use super::explore::{self, ExplicitStrategy};
use super::findings::shape::{self, WeaknessFindings};
use super::findings::{self, EnvironmentFindings};
use super::fixpoint::winning_region;
use super::functions::{self, StrategyFunctions};
use super::heuristics::{Heuristic, Heuristics};
use super::outcome::{Game, LostGame, Outcome, WonGame};
use super::progress::{Phase, Progress};
use super::ranking::{self, Ranking};
use super::reference::GuaranteeRef;
use super::repair::{self, Advice};
use super::set_up;
use super::statistics::Statistics;
use super::strategy::{self, Preference};
use super::structure::Orientation;
use crate::symbolic::{
    Biodivine, Bit, Budget, Diagram, Encoding, Kernel, Limit, Limits, Order, SharedStore,
};
use linewright_core::gr1::{Formula, Specification, Time, VarId};
use std::sync::Arc;
use std::time::Instant;

/// Maximum number of bit pairs of a small game.
const SMALL_PAIRS: usize = 48;

/// Maximum number of nodes created in total in a small game.
const SMALL_NODES: u64 = 5_000;

/// Peak number of nodes above which a game is large.
const LARGE_NODES: u64 = 100_000;

/// Like [`LARGE_NODES`], but for a kernel that counts dead nodes until it collects them.
const LARGE_NODES_SHARED: u64 = 1 << 20;

/// Maximum work for solving a game again from the reversed order, in addition to
/// [`REVERSED_WORK_FACTOR`] times the work that solving it took. It takes a fifth of a second.
const REVERSED_WORK: u64 = 4_000_000;

/// See [`REVERSED_WORK`].
const REVERSED_WORK_FACTOR: u64 = 4;

/// Maximum work in each variable order for the functions that pursue the first goal. As long as it
/// suffices in neither order, it is multiplied by [`FIRST_GOAL_FACTOR`].
const FIRST_GOAL_WORK: u64 = 4_000_000;

/// See [`FIRST_GOAL_WORK`].
const FIRST_GOAL_FACTOR: u64 = 4;

/// The kernel on which a game is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelChoice {
    /// The solver chooses by the size of the game.
    #[default]
    Automatic,
    /// biodivine-lib-bdd, where every function owns its nodes.
    Biodivine,
    /// Linewright's own kernel, with a common store and complement edges.
    Shared,
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
    /// Whether to skip the search for a core if the specification is unrealizable.
    pub without_core: bool,
    /// Initial variable order, such as that of an earlier run; `None` to derive one from the
    /// formulas. With the automatic kernel, only a large game uses it.
    pub initial_order: Option<Order>,
    /// Whether [`Self::initial_order`] is good enough to be used without sifting.
    pub is_final_order: bool,
    /// A diagram whose only root is a set of states known to contain the winning region. With the
    /// automatic kernel, only a large game uses it.
    pub initial_region: Option<Diagram>,
    /// Progress of the run, updated while it runs. Clones of the options share it.
    pub progress: Arc<Progress>,
}

/// A verdict and its statistics.
#[derive(Debug)]
pub struct Solution {
    /// The verdict.
    pub outcome: Outcome,
    /// Statistics of the run; if a limit was reached, up to that point.
    pub statistics: Statistics,
}

/// A game that was won on kernel `K`.
#[derive(Debug)]
struct RealizedGame<K: Kernel> {
    /// The encoded formulas; dropped for a large game.
    formulas: Option<Formulas<K>>,
    arena: Arena<K>,
    /// The states from which the machine wins.
    region: K::Function,
    /// The heuristics with which the game was solved.
    heuristics: Heuristics,
}

impl<K: Kernel> RealizedGame<K> {
    /// Solves the game again from the reversed initial order, for functions that may be smaller.
    /// Returns `None` if that takes far more work than solving it took, or if the order is not
    /// derived from the structure.
    fn reversed(&self, specification: &Specification, limits: &Limits) -> Option<Self> {
        if !self.heuristics.has(Heuristic::Structure) {
            return None;
        }
        let m = &self.arena.kernel;
        let order = oriented_order(specification, self.heuristics, Orientation::Reversed);
        let limits = Limits {
            max_work: Some(REVERSED_WORK + REVERSED_WORK_FACTOR * m.work()),
            ..*limits
        };
        let played = play::<K>(
            specification,
            &order,
            self.heuristics,
            &limits,
            &Progress::default(),
            Some(&self.region()),
        );
        let (_, arena, region) = played.ok()?;
        Some(Self {
            formulas: None,
            arena,
            region: region?,
            heuristics: self.heuristics,
        })
    }
}

impl<K: Kernel> Game for RealizedGame<K> {
    fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<ExplicitStrategy, Limit> {
        let arena = self.arena.with_limits(limits);
        let strategy = strategy::strategy(&arena, specification, preference, &self.region)?;
        explore::explore(&arena, specification, &strategy, limits)
    }

    fn functions(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<StrategyFunctions, Limit> {
        let arena = self.arena.with_limits(limits);
        let Some(reversed) = self.reversed(specification, limits) else {
            return functions::functions(&arena, specification, &self.region);
        };
        let other = reversed.arena.with_limits(limits);
        better_functions(
            specification,
            [(&arena, &self.region), (&other, &reversed.region)],
        )
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

    fn find_weaknesses(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<WeaknessFindings, Limit> {
        shape::find_weaknesses(&self.arena.with_limits(limits), specification, &self.region)
    }

    fn ranking(&self, specification: &Specification, limits: &Limits) -> Result<Ranking, Limit> {
        ranking::ranking(&self.arena.with_limits(limits), specification, &self.region)
    }

    fn region(&self) -> Diagram {
        self.arena.kernel.export(&[&self.region])
    }

    fn work(&self) -> u64 {
        self.arena.kernel.work()
    }
}

/// Computes functions in two variable orders as far as the first goal, and returns those for all
/// goals in the better order. The orders take turns with growing limits of work, so that a bad one
/// costs at most a few times the work of the other.
fn better_functions<K: Kernel>(
    specification: &Specification,
    games: [(&Arena<K>, &K::Function); 2],
) -> Result<StrategyFunctions, Limit> {
    let mut work = FIRST_GOAL_WORK;
    loop {
        let tried =
            games.map(|(arena, region)| functions::first_goal(arena, specification, region, work));
        let chosen = match &tried {
            [Ok(own), Ok(other)] => {
                usize::from(other.diagram.nodes.len() < own.diagram.nodes.len())
            }
            [Ok(_), _] => 0,
            [_, Ok(_)] => 1,
            [Err(Limit::Work(_)), _] | [_, Err(Limit::Work(_))] => {
                work *= FIRST_GOAL_FACTOR;
                continue;
            }
            [Err(limit), Err(_)] => return Err(*limit),
        };
        let (arena, region) = games[chosen];
        if arena.goals.len() > 1 {
            return functions::functions(arena, specification, region);
        }
        let [own, other] = tried;
        return if chosen == 0 { own } else { other };
    }
}

/// Decides with default options whether a machine exists. If none exists, also searches for a
/// minimal core of guarantees.
pub fn solve(specification: &Specification, limits: &Limits) -> Outcome {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    solve_with(specification, &options).outcome
}

/// Decides whether a machine exists, with these options.
pub fn solve_with(specification: &Specification, options: &Options) -> Solution {
    let order = initial_order(specification, options.heuristics);
    if let Some(limits) = small_limits(&order, options) {
        let solved = if options.kernel == KernelChoice::Automatic {
            solve_on::<Biodivine>(specification, &order, &limits, options, Hints::default())
        } else {
            solve_on::<Biodivine>(specification, &order, &limits, options, Hints::of(options))
        };
        let outgrown = options.kernel == KernelChoice::Automatic
            && matches!(solved.outcome, Outcome::GaveUp(Limit::Memory));
        if !outgrown {
            return solved;
        }
    }
    let hints = Hints::of(options);
    solve_on::<SharedStore>(specification, &order, &options.limits, options, hints)
}

/// The initial variable order and the initial region that the options provide.
#[derive(Clone, Copy, Default)]
struct Hints<'a> {
    order: Option<&'a Order>,
    region: Option<&'a Diagram>,
}

impl<'a> Hints<'a> {
    fn of(options: &'a Options) -> Self {
        Self {
            order: options.initial_order.as_ref(),
            region: options.initial_region.as_ref(),
        }
    }

    /// Drops an order or a region that does not fit the number of pairs of the game.
    fn drop_unfitting(self, pairs: usize) -> Self {
        Self {
            order: self.order.filter(|o| o.pairs().len() == pairs),
            region: self
                .region
                .filter(|r| r.roots.len() == 1 && r.is_sound(2 * pairs)),
        }
    }
}

/// Returns the limits of the attempt on biodivine's kernel, or `None` to use the shared store from
/// the start.
fn small_limits(order: &Order, options: &Options) -> Option<Limits> {
    match options.kernel {
        KernelChoice::Biodivine => Some(options.limits),
        KernelChoice::Shared => None,
        KernelChoice::Automatic if order.pairs().len() > SMALL_PAIRS => None,
        KernelChoice::Automatic => Some(Limits {
            max_nodes: Some(SMALL_NODES),
            max_created: Some(SMALL_NODES),
            ..options.limits
        }),
    }
}

/// Examines the assumptions of a specification, whether or not it is realizable.
pub fn examine_environment(
    specification: &Specification,
    limits: &Limits,
) -> Result<EnvironmentFindings, Limit> {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    let order = initial_order(specification, options.heuristics);
    if let Some(limits) = small_limits(&order, &options) {
        let found = examine_on::<Biodivine>(specification, &order, &limits, options.heuristics);
        if found != Err(Limit::Memory) {
            return found;
        }
    }
    examine_on::<SharedStore>(specification, &order, limits, options.heuristics)
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

/// Computes a counterstrategy and a play in which it wins; `None` if the machine wins.
///
/// In the play, the machine starts with values that satisfy `start`, if possible. The specification
/// is usually [reduced](super::select_guarantees) to a minimal core: a machine that cannot keep the
/// core cannot keep all guarantees either.
pub fn attack(
    specification: &Specification,
    start: &[Formula],
    limits: &Limits,
) -> Result<Option<Attack>, Limit> {
    attack_until(PlayEnd::Violation, specification, start, limits)
}

/// Like [`attack`], but with a choice of the step in which the play ends.
pub fn attack_until(
    end: PlayEnd,
    specification: &Specification,
    start: &[Formula],
    limits: &Limits,
) -> Result<Option<Attack>, Limit> {
    let options = Options {
        limits: *limits,
        ..Options::default()
    };
    let order = initial_order(specification, options.heuristics);
    if let Some(limits) = small_limits(&order, &options) {
        let found = attack::attack_on::<Biodivine>(end, specification, start, &limits);
        if !matches!(found, Err(Limit::Memory)) {
            return found;
        }
    }
    attack::attack_on::<SharedStore>(end, specification, start, limits)
}

/// Suggests repairs of an unrealizable specification, given a minimal core and a play that the
/// machine loses.
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
    let order = initial_order(specification, options.heuristics);
    if let Some(limits) = small_limits(&order, &options) {
        let limits = Limits {
            max_created: None,
            ..limits
        };
        let found = repair::advise_on::<Biodivine>(specification, core, play, &limits);
        if !matches!(found, Err(Limit::Memory)) {
            return found;
        }
    }
    repair::advise_on::<SharedStore>(specification, core, play, limits)
}

/// Solves a game on one kernel.
fn solve_on<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    options: &Options,
    hints: Hints<'_>,
) -> Solution {
    let hints = hints.drop_unfitting(order.pairs().len());
    let order = hints.order.unwrap_or(order);
    let progress = &*options.progress;
    progress.restart(Statistics {
        kernel: K::NAME,
        pairs: order.pairs().len(),
        large: order.pairs().len() > SMALL_PAIRS,
        order_before: variables_by_position(specification, order),
        ..Statistics::default()
    });
    let outcome = decide::<K>(specification, order, limits, options, hints);
    // If a limit was reached, the phase still shows where the run ended.
    if outcome.is_ok() {
        progress.set_phase(Phase::Ended);
    }
    Solution {
        outcome: outcome.unwrap_or_else(Outcome::GaveUp),
        statistics: progress.statistics(),
    }
}

/// An encoded game and its winning region; `None` if the environment wins.
type Played<K> = (Formulas<K>, Arena<K>, Option<<K as Kernel>::Function>);

/// Sets up a game and computes its winning region. `within` is a set of states known to contain it.
fn play<K: Kernel>(
    specification: &Specification,
    order: &Order,
    heuristics: Heuristics,
    limits: &Limits,
    progress: &Progress,
    within: Option<&Diagram>,
) -> Result<Played<K>, Limit> {
    let (formulas, arena) =
        set_up::set_up::<K>(specification, order, heuristics, limits, progress)?;

    progress.set_phase(Phase::Fixpoint);
    let clock = Instant::now();
    let within = match within {
        Some(within) => Some(arena.kernel.import(within)?.swap_remove(0)),
        None => None,
    };
    let region = winning_region(&arena, within.as_ref(), progress.iterations());
    drop(within);
    let peak_nodes = formulas.peak_nodes();
    let last_order = formulas.kernel().order();
    progress.update(|s| {
        s.fixpoint_seconds = clock.elapsed().as_secs_f64();
        s.peak_nodes = peak_nodes;
        s.order_after = variables_by_position(specification, &last_order);
        s.last_order = Some(last_order);
        s.large |= peak_nodes
            > match K::NAME {
                Biodivine::NAME => LARGE_NODES,
                _ => LARGE_NODES_SHARED,
            };
    });
    let region = region?;
    Ok((formulas, arena, region))
}

fn decide<K: Kernel>(
    specification: &Specification,
    order: &Order,
    limits: &Limits,
    options: &Options,
    hints: Hints<'_>,
) -> Result<Outcome, Limit> {
    let progress = &*options.progress;
    let heuristics = if options.is_final_order && hints.order.is_some() {
        options.heuristics.without(Heuristic::Sifting)
    } else {
        options.heuristics
    };
    let (formulas, arena, region) = play::<K>(
        specification,
        order,
        heuristics,
        limits,
        progress,
        hints.region,
    )?;
    let peak_nodes = formulas.peak_nodes();
    if let Some(region) = region {
        return Ok(Outcome::Realizable(WonGame {
            game: Box::new(RealizedGame {
                formulas: (!progress.statistics().large).then_some(formulas),
                arena,
                region,
                heuristics: options.heuristics,
            }),
            peak_nodes,
        }));
    }
    drop(arena);
    progress.set_phase(Phase::Core);
    let (mut core, mut stopped_by) = (None, None);
    if !options.without_core {
        let limits = limits.with_budget_after(formulas.kernel().work(), Budget::CORE);
        match core::minimal_core(&formulas.with_limits(&limits), specification) {
            // The attempt on the small kernel ran out of room; the large kernel has more.
            Err(Limit::Memory) if limits.max_created != options.limits.max_created => {
                return Err(Limit::Memory);
            }
            Err(limit) => stopped_by = Some(limits.attribute(limit)),
            Ok(found) => core = Some(found),
        }
    }
    Ok(Outcome::Unrealizable(LostGame {
        core,
        stopped_by,
        peak_nodes: formulas.peak_nodes(),
    }))
}

/// Converts an order of variables, given by index, to an order of pairs of bits. Returns `None`
/// unless every variable with more than one value occurs exactly once; unknown indices are ignored.
pub fn order_from_variables(
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
    // The pair for the strategy's flag comes last.
    let last = encoding.pairs() as u16;
    let order = Order::new(pairs.chain([last]).collect())?;
    (order.pairs().len() == usize::from(last) + 1).then_some(order)
}

/// Returns the variables, sorted by the position of their topmost bit.
fn variables_by_position(specification: &Specification, order: &Order) -> Vec<VarId> {
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
