//! Repairs of an unrealizable specification: assumptions to add, guarantees to weaken.
//!
//! The search descends a lattice of formulas built from the user's own conditions ([`vocabulary`]).
//! The strongest formula of a family ("the input is always false", "the input never changes", "this
//! guarantee is left out") is tried first: if it does not help, no weaker formula does. If it
//! helps, conditions are added as long as the formula still helps ("after the command, the input is
//! false"), up to [`search::MAX_CONDITIONS`]. So a suggestion is *minimal*: one more condition of
//! the vocabulary would make it insufficient. Suggestions are first tried on the core alone, whose
//! game is small, and then on the whole specification. A suggested assumption must also leave a
//! usable environment: it adds no dead end, the machine cannot force a violation of the
//! assumptions, and some play keeps all formulas.
//!
//! The idea of searching for restrictions of the environment in the user's terms is from Alur,
//! Moarref and Topcu, "Counter-strategy guided refinement of GR(1) temporal logic specifications",
//! FMCAD 2013. The ranking by restrictiveness is our addition.

mod advice;
mod search;
mod trial;
mod vocabulary;

pub use advice::{Advice, NewAssumption, Weakening};
pub use vocabulary::negation;

use super::arena::Selection;
use super::attack::Play;
use super::core::{assumptions_that_matter, quick_xplain};
use super::reference::{GuaranteeRef, split_definitions};
use super::set_up;
use crate::symbolic::{Kernel, Limit, Limits};
use linewright_core::gr1::Specification;

/// Searches for repairs on kernel `K`; see [`super::advise`].
pub(super) fn advise_on<K: Kernel>(
    specification: &Specification,
    core: &[GuaranteeRef],
    play: &Play,
    limits: &Limits,
) -> Result<Advice, Limit> {
    let (formulas, _) = set_up::set_up_default::<K>(specification, limits)?;
    let matters = assumptions_that_matter(&formulas, core)?;
    let mut trials = trial::Trials::new(&formulas, specification, core)?;
    let is_satisfiable =
        |selection: &Selection<'_>| trial::Trials::is_satisfiable(&formulas, selection);
    let contradictory = !is_satisfiable(&Selection::All)?;
    let (definitions, demands) = split_definitions(&specification.guarantees);
    let contradiction = if contradictory && is_satisfiable(&Selection::Only(&definitions))? {
        let mut clashes = |kept: &[GuaranteeRef]| Ok(!is_satisfiable(&Selection::Only(kept))?);
        let mut found = quick_xplain(&mut clashes, &definitions, false, &demands)?;
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
