//! Computes how the environment wins a game that the machine loses: the dual of the three-nested
//! fixpoint, with its stages.
//!
//! ```text
//! Z = μZ. ⋁ⱼ νY. ⋀ᵢ μX. EPre( Z′ ∨ (¬Gⱼ ∧ Y′ ∧ (Aᵢ ∨ X′)) )
//! ```
//!
//! `EPre(T)` is the set of states in which the environment has a legal move after which every legal
//! answer of the machine is a transition of T. A move after which the machine has no legal answer
//! counts, too. Z is the complement of the machine's winning region ([`super::fixpoint`]; after
//! Könighofer, Hofferek and Bloem, "Debugging formal specifications: a practical approach using
//! model-based diagnosis and counterstrategies", STTT 15, 2013). Each iteration of Z is kept as a
//! [`board::Stage`]: either one more forced step, or a goal that the environment can withhold from
//! the machine for ever while it meets every justice assumption infinitely often. The search ends
//! with the first stage into which the environment can force the play in step 0, so the environment
//! wins with the fewest stages.

mod board;
mod explore;
mod play;
mod strategy;

use super::explore::ExplicitStrategy;
use super::reference::GuaranteeRef;
use super::set_up;
use crate::symbolic::{Kernel, Limit, Limits};
use board::Board;
use linewright_core::gr1::{Formula, Specification};
pub use play::{Ending, Play, PlayEnd};

/// A counterstrategy as plain data, and the play between it and a machine that resists as long as
/// it can.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attack {
    /// The counterstrategy. Its roles are swapped: conditions refer to the machine's outputs by
    /// index, and the `output` of a row has the values of the machine's inputs. If the environment
    /// moves first, all rows of a state have the same output.
    pub explicit: ExplicitStrategy,
    /// A play in which the environment wins as early as it can, and the machine resists as long as
    /// it can.
    pub play: Play,
}

/// Computes the counterstrategy of a specification, or `None` if the machine wins.
pub(super) fn attack_on<K: Kernel>(
    end: PlayEnd,
    specification: &Specification,
    start: &[Formula],
    limits: &Limits,
) -> Result<Option<Attack>, Limit> {
    let (formulas, _) = set_up::set_up_default::<K>(specification, limits)?;
    let board = Board::new(&formulas, specification.timing)?;
    let Some(stages) = board.stages()? else {
        return Ok(None);
    };
    let strategy = strategy::Strategy::new(&board, specification, &stages)?;
    let explicit = explore::explore(&board, specification, &strategy, limits)?;
    let m = formulas.kernel();
    let mut starting_states = m.constant(true);
    for formula in start {
        starting_states = m.and(
            &starting_states,
            &formulas.encoding().formula(m, &formula.expr)?,
        )?;
    }
    let play = play::play(
        &board,
        specification,
        &formulas,
        &strategy,
        &stages,
        &starting_states,
        end,
    )?;
    Ok(Some(Attack { explicit, play }))
}

/// Returns the specification with only these guarantees.
pub fn select_guarantees(
    specification: &Specification,
    guarantees: &[GuaranteeRef],
) -> Specification {
    use linewright_core::gr1::FormulaKind as Kind;
    let all = &specification.guarantees;
    let keep = |kind: Kind, list: &[linewright_core::gr1::Formula]| {
        let list = list.iter().enumerate();
        list.filter(|(index, _)| {
            guarantees.contains(&GuaranteeRef {
                kind,
                index: *index,
            })
        })
        .map(|(_, f)| f.clone())
        .collect()
    };
    Specification {
        guarantees: linewright_core::gr1::Side {
            initial: keep(Kind::Initial, &all.initial),
            invariants: keep(Kind::Invariant, &all.invariants),
            safety: keep(Kind::Safety, &all.safety),
            justice: keep(Kind::Justice, &all.justice),
        },
        ..specification.clone()
    }
}
