//! The verdict on a game, and what can be had from a game that is won, whatever its kernel.

use super::explore::Explicit;
use super::findings::EnvironmentFindings;
use super::findings::shape::Shape;
use super::functions::Controls;
use super::ranking::Ranking;
use super::reference::GuaranteeRef;
use super::strategy::Preference;
use crate::symbolic::{Diagram, Limit, Limits};
use linewright_core::gr1::Specification;
use std::fmt::Debug;

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
    pub(super) game: Box<dyn Game>,
    /// The largest number of nodes that were alive at once.
    pub peak_nodes: u64,
}

/// What is known of a specification that is not.
#[derive(Debug)]
pub struct Lost {
    /// Guarantees that cannot be kept together under the assumptions, although any smaller set of
    /// them could: a minimal core. `None` when a limit was reached before it was known.
    pub core: Option<Vec<GuaranteeRef>>,
    /// The largest number of nodes that were alive at once.
    pub peak_nodes: u64,
}

/// What a won game can do, whatever its kernel.
pub trait Game: Debug + Send + Sync {
    /// See [`Won::explore`].
    fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<Explicit, Limit>;

    /// See [`Won::functions`].
    fn functions(&self, specification: &Specification, limits: &Limits) -> Result<Controls, Limit>;

    /// See [`Won::examine_environment`].
    fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit>;

    /// See [`Won::shape`].
    fn shape(&self, specification: &Specification, limits: &Limits) -> Result<Shape, Limit>;

    /// See [`Won::ranking`].
    fn ranking(&self, specification: &Specification, limits: &Limits) -> Result<Ranking, Limit>;

    /// See [`Won::region`].
    fn region(&self) -> Diagram;
}

impl Lost {
    /// The names of the core's formulas, but for definitions; empty when the core is not known.
    pub fn core_names(&self, specification: &Specification) -> Vec<String> {
        let core = self.core.iter().flatten();
        core.map(|r| r.formula(&specification.guarantees))
            .filter(|f| !f.defines)
            .map(|f| f.name.clone())
            .collect()
    }
}

impl Won {
    /// A strategy as explicit states with guards, in plain data.
    pub fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<Explicit, Limit> {
        self.game.explore(specification, preference, limits)
    }

    /// A strategy as functions, in plain data: for machines that are too large for
    /// [`Won::explore`].
    pub fn functions(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Controls, Limit> {
        self.game.functions(specification, limits)
    }

    /// What is odd about the assumptions; see [`super::examine_environment`].
    pub fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit> {
        self.game.examine_environment(specification, limits)
    }

    /// Where it asks for less than it seems to; see [`Shape`].
    pub fn shape(&self, specification: &Specification, limits: &Limits) -> Result<Shape, Limit> {
        self.game.shape(specification, limits)
    }

    /// Why it is won, for whoever wants to check it.
    pub fn ranking(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Ranking, Limit> {
        self.game.ranking(specification, limits)
    }

    /// The states from which the machine wins, over current bits, as the only root.
    pub fn region(&self) -> Diagram {
        self.game.region()
    }
}
