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
//! [`examine`] first uses an abstraction in which a part that can move eventually does. A
//! counterexample in it might never occur in the runner. So if there is one, a second abstraction
//! is used, in which nothing that takes time ends before every part that can move has moved. The
//! only exceptions are a part that is overdue at a source and a part that has just been brought to
//! a store. Both abstractions order parts by how long they have waited.
//!
//! In the second abstraction, an instant in which parts move for ever would contradict that events
//! take time, and any claim would follow. Such lines are not decided, and a proof counts only if
//! the abstraction [has a run](has_a_run).
//!
//! # What is left out, and what that means
//!
//! - *Times.* Service, travel and the time between two supplies take some time and end. What is
//!   proved holds for all durations; a counterexample can occur with some durations, but perhaps
//!   not with those of the line. Setup, breakdowns, repairs and shifts only take time. For parts
//!   that are lost by them, see [`with_losses`].
//! - *Properties.* Which of several routes a part takes is left open each time, and each route is
//!   taken again and again. [`super::calls`] omits the routes that no part takes, and determines
//!   for which of the others chance guarantees this. For the rest, it is a premise.
//! - *Numbers of orders.* A source on order has the next part as soon as the previous one has left,
//!   no source stops after a number of parts, and stock does not run out. Where this does not hold
//!   for the line, and matters, it is a premise ([`super::calls`]).
//! - *Calls.* Every call of a station is answered; [`super::calls`] proves this.
//!
//! If parts of one type can go round in a cycle, each of them is assumed to leave it eventually;
//! the claim is then that all places proceed.

mod belt;
mod book;
mod chain;
mod claim;
mod decide;
mod findings;
mod lemmas;
mod limited;
mod losses;
mod parts;
mod requirements;
mod shape;
mod vocabulary;
pub(crate) mod words;

pub use decide::{Open, Verdict, decide, examine, has_a_run};
pub use findings::findings;
pub use losses::with_losses;
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
    /// The places of the line.
    pub shape: Shape,
    /// The variables of the places.
    pub vocabulary: Vocabulary,
    /// The contracts of the places.
    pub system: System,
    /// What is to be proved.
    pub claim: Claim,
}

impl Abstraction {
    /// Abstracts a line accepted by the resolver. A part that can move does so eventually. The
    /// contract of a place therefore involves only the place and its neighbors, and allows slightly
    /// more than the runner does: of two sources that take turns, one can be late.
    ///
    /// The line is one that [`with_losses`] has returned.
    ///
    /// # Errors
    /// Returns the reason if something in the line has no abstraction, or would make it too large.
    pub fn of(line: &Line) -> Result<Self, UndecidedReason> {
        Self::with(line, false)
    }

    /// Like [`Abstraction::of`], but parts move at once when they can, as in the runner: everything
    /// that takes time waits until nothing can move.
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
