//! How the environment wins a game that the machine loses: the dual of the three-nested fixpoint,
//! with its record.
//!
//! ```text
//! Z = μZ. ⋁ⱼ νY. ⋀ᵢ μX. EPre( Z′ ∨ (¬Gⱼ ∧ Y′ ∧ (Aᵢ ∨ X′)) )
//! ```
//!
//! `EPre` holds the states in which the environment has a legal move after which every legal answer
//! of the machine lies in its argument; this includes states without a legal answer. The set is the
//! complement of the machine's winning region ([`super::fixpoint`]; after Könighofer, Hofferek and
//! Bloem, "Debugging formal specifications: a practical approach using model-based diagnosis and
//! counterstrategies", STTT 15, 2013). The steps of Z are kept as [`board::Stage`]s: either one
//! more forced step, or a goal that can be withheld from the machine for ever while every
//! assumption's justice is met again and again. The search ends with the first stage from which the
//! environment can start, so the last stage is the lowest possible.

mod board;
mod explore;
mod play;
mod strategy;

use super::explore::Explicit;
use super::reference::GuaranteeRef;
use super::set_up;
use crate::symbolic::{Kernel, Limit, Limits};
use board::Board;
use linewright_core::gr1::{Formula, Specification};
pub use play::{Ending, Play};

/// A counterstrategy as plain data, and the play between it and a machine that resists as long as
/// it can.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attack {
    /// The counterstrategy. Conditions refer to the machine's outputs by index; the `output` of a
    /// row is what the environment gives. If the environment moves first, all rows of a state give
    /// the same.
    pub explicit: Explicit,
    /// A play in which the environment wins as early as it can, and the machine resists as long as
    /// it can.
    pub play: Play,
}

/// Computes the counterstrategy of a specification, or `None` if the machine wins.
pub(super) fn attack_on<K: Kernel>(
    specification: &Specification,
    beginning: &[Formula],
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
    let mut begin = m.constant(true);
    for formula in beginning {
        begin = m.and(&begin, &formulas.encoding().formula(m, &formula.expr)?)?;
    }
    let play = play::play(&board, specification, &formulas, &strategy, &stages, &begin)?;
    Ok(Some(Attack { explicit, play }))
}

/// The specification with only these guarantees.
pub fn reduced(specification: &Specification, guarantees: &[GuaranteeRef]) -> Specification {
    use super::reference::GuaranteeKind as Kind;
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
