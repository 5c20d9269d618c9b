//! Repairs of an unrealizable specification: assumptions to add, guarantees to weaken.
//!
//! The search descends a lattice of formulas built from the user's own conditions ([`vocabulary`]).
//! The strongest formula of a family ("the input is always false", "the input never changes", "this
//! guarantee is left out") is tried first: if it does not help, no weaker one does. If it helps,
//! conditions are added as long as it still helps ("after the command it is false"), up to
//! [`search::MOST_CONDITIONS`]. So a suggestion is *minimal*: with one more condition of the
//! vocabulary it would not suffice. First the core alone is played, which is small. What repairs it
//! is tried on the whole specification, and must leave an environment that can keep all
//! assumptions: it has no dead end, cannot be forced to break an assumption where it could not be
//! before, and some play keeps everything.
//!
//! The idea of searching for restrictions of the environment in the user's terms is from Alur,
//! Moarref and Topcu, "Counter-strategy guided refinement of GR(1) temporal logic specifications",
//! FMCAD 2013; the ranking by restrictiveness is ours.

mod advice;
mod search;
mod trial;
mod vocabulary;

pub use advice::{Advice, NewAssumption, Weakening};
pub use vocabulary::negation;

use super::arena::Selection;
use super::attack::Play;
use super::core::{assumptions_that_matter, quick_xplain};
use super::reference::{GuaranteeRef, definitions};
use super::set_up;
use crate::symbolic::{Kernel, Limit, Limits};
use linewright_core::gr1::Specification;

/// Searches for repairs.
pub(super) fn advise_on<K: Kernel>(
    specification: &Specification,
    core: &[GuaranteeRef],
    play: &Play,
    limits: &Limits,
) -> Result<Advice, Limit> {
    let (formulas, _) = set_up::set_up_default::<K>(specification, limits)?;
    let matters = assumptions_that_matter(&formulas, core)?;
    let mut trials = trial::Trials::new(&formulas, specification, core)?;
    let possible = |selection: &Selection<'_>| trial::Trials::possible(&formulas, selection);
    let contradictory = !possible(&Selection::All)?;
    let (definitions, asked) = definitions(&specification.guarantees);
    let contradiction = if contradictory && possible(&Selection::Only(&definitions))? {
        let mut clashes = |kept: &[GuaranteeRef]| Ok(!possible(&Selection::Only(kept))?);
        let mut found = quick_xplain(&mut clashes, &definitions, false, &asked)?;
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
