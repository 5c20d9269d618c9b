//! The verdict on a game, and the results available from a won game, whatever its kernel.

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
    /// A machine exists.
    Realizable(WonGame),
    /// No machine exists.
    Unrealizable(LostGame),
    /// A limit was reached; nothing is known.
    GaveUp(Limit),
}

/// A realizable specification. [`WonGame::explore`] makes a strategy of it.
#[derive(Debug)]
pub struct WonGame {
    pub(super) game: Box<dyn Game>,
    /// Peak number of live nodes.
    pub peak_nodes: u64,
}

/// An unrealizable specification.
#[derive(Debug)]
pub struct LostGame {
    /// Guarantees that cannot be kept together under the assumptions, although any proper subset
    /// could: a minimal core. `None` if a limit was reached first.
    pub core: Option<Vec<GuaranteeRef>>,
    /// Peak number of live nodes.
    pub peak_nodes: u64,
}

/// Operations on a won game, whatever its kernel.
pub trait Game: Debug + Send + Sync {
    /// See [`WonGame::explore`].
    fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<Explicit, Limit>;

    /// See [`WonGame::functions`].
    fn functions(&self, specification: &Specification, limits: &Limits) -> Result<Controls, Limit>;

    /// See [`WonGame::examine_environment`].
    fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit>;

    /// See [`WonGame::shape`].
    fn shape(&self, specification: &Specification, limits: &Limits) -> Result<Shape, Limit>;

    /// See [`WonGame::ranking`].
    fn ranking(&self, specification: &Specification, limits: &Limits) -> Result<Ranking, Limit>;

    /// See [`WonGame::region`].
    fn region(&self) -> Diagram;
}

impl LostGame {
    /// Names of the core's formulas, except definitions; empty if the core is not known.
    pub fn core_names(&self, specification: &Specification) -> Vec<String> {
        let core = self.core.iter().flatten();
        core.map(|r| r.formula(&specification.guarantees))
            .filter(|f| !f.defines)
            .map(|f| f.name.clone())
            .collect()
    }
}

impl WonGame {
    /// Returns a strategy as explicit states with guards, as plain data.
    pub fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<Explicit, Limit> {
        self.game.explore(specification, preference, limits)
    }

    /// Returns a strategy as functions, as plain data: for machines that are too large for
    /// [`WonGame::explore`].
    pub fn functions(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Controls, Limit> {
        self.game.functions(specification, limits)
    }

    /// Checks the assumptions; see [`super::examine_environment`].
    pub fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit> {
        self.game.examine_environment(specification, limits)
    }

    /// Finds where the specification demands less than it seems to; see [`Shape`].
    pub fn shape(&self, specification: &Specification, limits: &Limits) -> Result<Shape, Limit> {
        self.game.shape(specification, limits)
    }

    /// Returns the reason why it is won, for an independent check.
    pub fn ranking(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Ranking, Limit> {
        self.game.ranking(specification, limits)
    }

    /// Returns the states from which the machine wins, over current bits, as the only root.
    pub fn region(&self) -> Diagram {
        self.game.region()
    }
}
