//! How an unrealizable specification could be mended: assumptions to add, guarantees to weaken.
//!
//! The search walks down a lattice of sentences made of the user's own conditions ([`vocabulary`]).
//! The strongest sentence of a family ("the input is always false", "the input never changes",
//! "this guarantee is left out") is tried first: where it does not help, no weaker one does. Where
//! it helps, conditions are added to it as long as it goes on helping ("after the command it is
//! false"), up to [`search::MOST_CONDITIONS`]; so what is suggested is *minimal*: with one more
//! condition of the vocabulary it would not be enough. First the core alone is played, which is
//! small; what mends that is tried on the whole specification, and has to leave an environment that
//! can keep all assumptions: it has no dead end, cannot be forced to break one where it could not
//! before, and some play keeps everything.
//!
//! The idea to look for environments' restrictions in the user's terms is from Alur, Moarref and
//! Topcu, "Counter-strategy guided refinement of GR(1) temporal logic specifications", FMCAD 2013;
//! the ranking by what is forbidden is ours.

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

/// Looks for what could be done.
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
