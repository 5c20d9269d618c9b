//! How an unrealizable specification could be mended: assumptions to add, guarantees to weaken.
//!
//! The search walks down a lattice of sentences made of the user's own conditions ([`vocabulary`]). The strongest sentence of
//! a family ("the input is always false", "the input never changes", "this guarantee is left out") is tried first: where it
//! does not help, no weaker one does. Where it helps, conditions are added to it as long as it goes on helping ("after the
//! command it is false"), up to [`MOST_CONDITIONS`]; so what is suggested is *minimal*: with one more condition of the
//! vocabulary it would not be enough. First the core alone is played, which is small; what mends that is tried on the whole
//! specification, and has to leave an environment that can keep all assumptions: it has no dead end, cannot be forced to
//! break one where it could not before, and some play keeps everything.
//!
//! The idea to look for environments' restrictions in the user's terms is from Alur, Moarref and Topcu, "Counter-strategy
//! guided refinement of GR(1) temporal logic specifications", FMCAD 2013; the ranking by what is forbidden is ours.

mod search;
mod trial;
mod vocabulary;

pub use vocabulary::negation;

use super::arena::Selection;
use super::core::{assumptions_that_matter, quick_xplain};
use super::{AssumptionRef, GuaranteeKind, GuaranteeRef, Play, set_up};
use crate::symbolic::{Kernel, Limit, Limits};
use linewright_core::gr1::{Expr, Specification};
use serde::{Deserialize, Serialize};

/// So many conditions stand before what a suggestion asks for.
const MOST_CONDITIONS: usize = 2;

/// So many suggestions of a kind are made.
const MOST_SUGGESTIONS: usize = 3;

/// What could be done about an unrealizable specification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The assumptions without which fewer guarantees than the core's would clash already.
    pub matters: Vec<AssumptionRef>,
    /// Not even a plant that helps could make all guarantees hold: no assumption mends it.
    pub contradictory: bool,
    /// Then: guarantees that contradict each other even so, none of which can be left out. None, if the assumptions do by themselves.
    pub contradiction: Vec<GuaranteeRef>,
    /// Assumptions, any of which makes it realizable, the one that forbids least first.
    pub assumptions: Vec<NewAssumption>,
    /// Where no single guarantee can be weakened: a minimal set of guarantees without which the rest can be kept.
    pub leave_out: Vec<GuaranteeRef>,
    /// Guarantees of the core, any of which can be weakened to make it realizable, the one that gives up least first.
    pub weakenings: Vec<Weakening>,
}

/// An assumption that would help.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewAssumption {
    /// Which kind it is.
    pub kind: GuaranteeKind,
    /// The formula.
    pub formula: Expr,
    /// The share of the environment's steps that it forbids; of a justice assumption, in which its condition does not hold.
    pub forbids: f64,
}

/// A guarantee that need not hold in every case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weakening {
    /// Which guarantee.
    pub guarantee: GuaranteeRef,
    /// When it need not hold; `None` where it has to be left out.
    pub unless: Option<Expr>,
    /// The share of all steps in which it need not hold.
    pub gives_up: f64,
}

/// Looks for what could be done.
pub(super) fn advise_on<K: Kernel>(
    specification: &Specification,
    core: &[GuaranteeRef],
    play: &Play,
    limits: &Limits,
) -> Result<Advice, Limit> {
    let (formulas, _) = set_up::usual::<K>(specification, limits)?;
    let matters = assumptions_that_matter(&formulas, core)?;
    let mut trials = trial::Trials::new(&formulas, specification, core)?;
    let possible = |selection: &Selection<'_>| trial::Trials::possible(&formulas, selection);
    let contradictory = !possible(&Selection::All)?;
    let contradiction = if contradictory && possible(&Selection::Only(&[]))? {
        let mut clashes = |kept: &[GuaranteeRef]| Ok(!possible(&Selection::Only(kept))?);
        let mut found = quick_xplain(&mut clashes, &[], false, &formulas.guarantees())?;
        found.sort_unstable();
        found
    } else {
        Vec::new()
    };
    let words = vocabulary::words(
        specification,
        core.iter()
            .map(|g| g.formula(&specification.guarantees))
            .chain(
                matters
                    .iter()
                    .map(|a| a.formula(&specification.assumptions)),
            ),
        play,
    );
    let assumptions = if contradictory {
        Vec::new()
    } else {
        search::assumptions(&mut trials, specification, &words)?
    };
    let weakenings = search::weakenings(&mut trials, core, &words)?;
    let leave_out = if weakenings.is_empty() {
        search::leave_out(&trials)?
    } else {
        Vec::new()
    };
    Ok(Advice {
        matters,
        contradictory,
        contradiction,
        assumptions,
        leave_out,
        weakenings,
    })
}
