//! The GR(1) game: who wins, how, and why not.
//!
//! ```text
//! Specification ─encode→ Arena ─winning_region→ Won ─strategy→ Explorer ─→ explicit states, mealy::extract takes over
//!                                            └→ Lost ─minimal_core→ the guarantees that clash
//! ```
//!
//! The semantics is that of [`crate::gr1`]: Bloem, Jobstmann, Piterman, Pnueli and Sa'ar, "Synthesis of Reactive(1) Designs",
//! Journal of Computer and System Sciences 78(3), 2012; safety first, strictly. No BDD type is public here.

mod arena;
mod core;
mod cover;
mod explore;
mod findings;
mod fixpoint;
mod strategy;

pub use self::explore::{Explicit, Row};
pub use self::findings::{EnvironmentFindings, examine_environment};
pub use crate::symbolic::{Limit, Limits};

use self::arena::{Arena, Selection};
use crate::gr1::{Side, Specification};
use crate::symbolic::Function;

/// The verdict on a specification.
#[derive(Debug)]
pub enum Outcome {
    /// There is a machine.
    Realizable(Won),
    /// There is none.
    Unrealizable(Lost),
    /// A limit was reached; nothing is known.
    GaveUp(Limit),
}

/// What is known of a specification that is realizable. [`Won::explore`] makes a strategy of it.
#[derive(Debug)]
pub struct Won {
    game: Box<WonGame>,
    /// The largest number of nodes that were alive at once.
    pub peak_nodes: u64,
}

/// The game that was won.
#[derive(Debug)]
struct WonGame {
    arena: Arena,
    /// The states from which the machine wins.
    region: Function,
}

/// What is known of a specification that is not.
#[derive(Debug)]
pub struct Lost {
    /// Guarantees that cannot be kept together under the assumptions, although any smaller set of them could: a minimal core.
    /// `None` when a limit was reached before it was known.
    pub core: Option<Vec<GuaranteeRef>>,
    /// The largest number of nodes that were alive at once.
    pub peak_nodes: u64,
}

/// Points at one guarantee of a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GuaranteeRef {
    /// Its list.
    pub kind: GuaranteeKind,
    /// Its place in that list.
    pub index: usize,
}

/// The lists of [`Side`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum GuaranteeKind {
    /// [`Side::initial`]
    Initial,
    /// [`Side::invariants`]
    Invariant,
    /// [`Side::safety`]
    Safety,
    /// [`Side::justice`]
    Justice,
}

impl GuaranteeRef {
    /// The formula it points at.
    pub fn formula(self, guarantees: &Side) -> &crate::gr1::Formula {
        match self.kind {
            GuaranteeKind::Initial => &guarantees.initial[self.index],
            GuaranteeKind::Invariant => &guarantees.invariants[self.index],
            GuaranteeKind::Safety => &guarantees.safety[self.index],
            GuaranteeKind::Justice => &guarantees.justice[self.index],
        }
    }
}

impl Lost {
    /// The names of the core's formulas; empty when the core is not known.
    pub fn core_names(&self, specification: &Specification) -> Vec<String> {
        let core = self.core.iter().flatten();
        core.map(|r| r.formula(&specification.guarantees).name.clone())
            .collect()
    }
}

impl Won {
    /// A strategy as explicit states with guards, in plain data.
    pub fn explore(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Explicit, Limit> {
        let arena = self.game.arena.with_limits(limits);
        let strategy = strategy::strategy(&arena, specification, &self.game.region)?;
        explore::explore(&arena, specification, &strategy, limits)
    }
}

/// Decides whether a machine exists; where there is none, also looks for a minimal core of guarantees.
pub fn solve(specification: &Specification, limits: &Limits) -> Outcome {
    let lost = || -> Result<_, Limit> {
        let formulas = arena::Formulas::encode(specification, limits)?;
        let arena = formulas.arena(&Selection::All)?;
        if let Some(region) = fixpoint::winning_region(&arena)? {
            let peak_nodes = formulas.peak_nodes();
            let game = Box::new(WonGame { arena, region });
            return Ok(Err(Won { game, peak_nodes }));
        }
        drop(arena);
        let core = core::minimal_core(&formulas).ok();
        let peak_nodes = formulas.peak_nodes();
        Ok(Ok(Lost { core, peak_nodes }))
    };
    match lost() {
        Ok(Err(won)) => Outcome::Realizable(won),
        Ok(Ok(lost)) => Outcome::Unrealizable(lost),
        Err(limit) => Outcome::GaveUp(limit),
    }
}
