//! A line as the composition of contracts, one a place, with times and properties left out: what
//! can be known before a run.
//!
//! ```text
//! Line ─Shape::of→ places and ways ─Vocabulary::of→ variables ─of→ Abstraction (a System and a Claim) ─decide→ Verdict ─findings→ Diagnostics
//! ```
//!
//! The neighbours' variables are what the contracts share: what one place offers, and whom the next
//! one takes. The claim is that no part is lost, that no place takes more than it has room for,
//! that something can always move, and that every part goes on until it leaves the line, so that
//! orders are finished.
//!
//! # At once, or at some time
//!
//! [`decide`] asks first of an abstraction in which a part that can move does so at some time. Only
//! where that has a counterexample, which may be one that the runner never shows, it asks again of
//! one in which nothing that takes time ends before every part that can move has moved. Both order
//! parts by how long they have waited.
//!
//! # What is left out, and what that means
//!
//! - *Times.* Service, travel and the time between two supplies take some time, and it ends. What
//!   is proved holds for all times; what is found wrong can happen with some times, perhaps not
//!   with those of the line. Setup, breakdowns, repairs and shifts only take time.
//! - *Properties.* Which of several routes a part takes is open, each time anew, and each is taken
//!   again and again: [`super::calls`] leaves out the routes that no part takes, and says of which
//!   of the others chance sees to that; the rest are premises.
//! - *Numbers of orders.* A source on order has the next part as soon as the one before has left,
//!   no source stops after so many parts, and stock does not run out. Where that is not so it is a
//!   premise.
//! - *Calls.* Every call of a station is answered; [`super::calls`] shows it.
//!
//! A line in which parts of one type may go round in a circle is taken to send each of them out of
//! it in the end; the claim is then that all places go on.

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

pub use decide::{Open, Verdict, decide, examine};
pub use findings::findings;
pub use requirements::{GOES_ON, NO_CIRCULAR_WAIT, NO_OVERFLOW, NO_PART_LOST, ORDERS_ARE_FINISHED};
pub use shape::{Place, PlaceKind, Shape, Ways, Work};
pub use vocabulary::{Model, Phase, Queue, Vars, Vocabulary};

use crate::undecided::Undecided;
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
    /// What is to be shown.
    pub claim: Claim,
}

impl Abstraction {
    /// The abstraction of a line that the resolver has passed, in which parts move at some time
    /// when they can move. That leaves every place's contract a matter of itself and its
    /// neighbours, and allows a little more than the runner does: of two sources that take turns,
    /// one may be late.
    ///
    /// # Errors
    /// When something in the line has no abstraction, or would make it too large.
    pub fn of(line: &Line) -> Result<Self, Undecided> {
        Self::with(line, false)
    }

    /// The same, but parts move at once when they can move, as in the runner: everything that takes
    /// time waits for that.
    ///
    /// # Errors
    /// As [`Abstraction::of`].
    pub fn at_once(line: &Line) -> Result<Self, Undecided> {
        Self::with(line, true)
    }

    fn with(line: &Line, at_once: bool) -> Result<Self, Undecided> {
        let shape = Shape::of(line)?;
        shape.check_time(line)?;
        let vocabulary = Vocabulary::of(line, &shape)?;
        let model = Model {
            shape: &shape,
            vocabulary: &vocabulary,
        };
        let settled = at_once.then(|| model.settled());
        let parts = (0..shape.places.len()).map(|p| parts::part(model, line, p, settled.as_ref()));
        let system = System {
            variables: vocabulary.variables.clone(),
            parts: parts.collect(),
        };
        let claim = claim::claim(model, line, &system);
        Ok(Self {
            shape,
            vocabulary,
            system,
            claim,
        })
    }

    /// What can be said of it.
    pub fn model(&self) -> Model<'_> {
        Model {
            shape: &self.shape,
            vocabulary: &self.vocabulary,
        }
    }
}
