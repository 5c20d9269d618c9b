//! A line as a composition of contracts, one per place, without times and properties: what can be
//! known before a run.
//!
//! ```text
//! Line ─Shape::of→ places and ways ─Vocabulary::of→ variables ─of→ Abstraction (a System and a Claim) ─decide→ Verdict ─findings→ Diagnostics
//! ```
//!
//! The contracts share variables with their neighbors: what one place offers, and which part the
//! next one takes. The claim is that no part is lost, that no place takes more than it has room
//! for, that something can always move, and that every part proceeds until it leaves the line, so
//! that orders are finished.
//!
//! # At once, or at some time
//!
//! [`decide`] first examines an abstraction in which a part that can move eventually does. Only if
//! that has a counterexample, which may never occur in the runner, it examines one in which nothing
//! that takes time ends before every part that can move has moved; only a part that is overdue at a
//! source, or has just been brought to a store, may come before that. Both order parts by how long
//! they have waited. In the second one an instant in which parts move for ever would contradict
//! that anything takes time, and everything would follow: such lines are not decided, and what is
//! proved counts only if the abstraction [has a run](has_a_run).
//!
//! # What is left out, and what that means
//!
//! - *Times.* Service, travel and the time between two supplies take some time, and it ends. What
//!   is proved holds for all times; a counterexample can happen with some times, perhaps not with
//!   those of the line. Setup, breakdowns, repairs and shifts only take time.
//! - *Properties.* Which of several routes a part takes is open each time, and each is taken again
//!   and again. [`super::calls`] leaves out the routes that no part takes, and determines which of
//!   the others chance guarantees; the rest are premises.
//! - *Numbers of orders.* A source on order has the next part as soon as the previous one has left,
//!   no source stops after a number of parts, and stock does not run out. Where this does not hold,
//!   it is a premise.
//! - *Calls.* Every call of a station is answered; [`super::calls`] shows it.
//!
//! If parts of one type may go round in a cycle, each of them is assumed to leave it eventually;
//! the claim is then that all places proceed.

mod belt;
mod book;
mod chain;
mod claim;
mod decide;
mod findings;
mod lemmas;
mod limited;
mod parts;
mod requirements;
mod shape;
mod vocabulary;
pub(crate) mod words;

pub use decide::{Open, Verdict, decide, examine, has_a_run};
pub use findings::findings;
pub use requirements::{GOES_ON, NO_CIRCULAR_WAIT, NO_OVERFLOW, NO_PART_LOST, ORDERS_ARE_FINISHED};
pub use shape::{Place, PlaceKind, Shape, Ways, Work};
pub use vocabulary::{Model, Phase, Queue, Vars, Vocabulary};

use crate::undecided::UndecidedReason;
use linewright_algebra::proof::Claim;
use linewright_algebra::system::System;
use linewright_language::contract::line::Line;

/// The abstraction of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Abstraction {
    /// Its places.
    pub shape: Shape,
    /// Their variables.
    pub vocabulary: Vocabulary,
    /// Their contracts.
    pub system: System,
    /// What is to be proved.
    pub claim: Claim,
}

impl Abstraction {
    /// Abstracts a line accepted by the resolver; parts that can move do so eventually. This keeps
    /// every place's contract local to itself and its neighbors, and allows slightly more than the
    /// runner does: of two sources that take turns, one may be late.
    ///
    /// # Errors
    /// Returns the reason if something in the line has no abstraction, or would make it too large.
    pub fn of(line: &Line) -> Result<Self, UndecidedReason> {
        Self::with(line, false)
    }

    /// Like `of`, but parts move at once when they can, as in the runner: everything that takes
    /// time waits for that.
    ///
    /// # Errors
    /// As [`Abstraction::of`].
    pub fn at_once(line: &Line) -> Result<Self, UndecidedReason> {
        Self::with(line, true)
    }

    fn with(line: &Line, at_once: bool) -> Result<Self, UndecidedReason> {
        let shape = Shape::of(line)?;
        shape.check_time()?;
        if at_once {
            shape.check_overdue()?;
        }
        let vocabulary = Vocabulary::of(line, &shape)?;
        let model = Model {
            shape: &shape,
            vocabulary: &vocabulary,
        };
        let settled = at_once.then(|| model.settled());
        let parts = (0..shape.places.len()).map(|p| parts::part(model, line, p, settled.as_ref()));
        let system = System {
            variables: vocabulary.variables.clone(),
            components: parts.collect(),
        };
        let claim = claim::claim(model, line, &system);
        Ok(Self {
            shape,
            vocabulary,
            system,
            claim,
        })
    }

    /// The places together with their variables.
    pub fn model(&self) -> Model<'_> {
        Model {
            shape: &self.shape,
            vocabulary: &self.vocabulary,
        }
    }
}
