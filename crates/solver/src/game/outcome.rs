//! The verdict on a game, and the results of a won game, independent of its kernel.

use super::explore::ExplicitStrategy;
use super::findings::EnvironmentFindings;
use super::findings::shape::WeaknessFindings;
use super::functions::StrategyFunctions;
use super::ranking::Ranking;
use super::reference::GuaranteeRef;
use super::strategy::Preference;
use crate::symbolic::{Diagram, Limit, Limits};
use linewright_core::gr1::{Formula, Specification};
use std::fmt::Debug;

/// The verdict on a specification.
#[derive(Debug)]
pub enum Outcome {
    /// A machine exists.
    Realizable(WonGame),
    /// No machine exists.
    Unrealizable(LostGame),
    /// A limit was reached before a verdict.
    GaveUp(Limit),
}

/// A won game: the specification is realizable. [`WonGame::explore`] returns a strategy.
#[derive(Debug)]
pub struct WonGame {
    pub(super) game: Box<dyn Game>,
    /// Peak number of live nodes.
    pub peak_nodes: u64,
}

/// A lost game: the specification is unrealizable.
#[derive(Debug)]
pub struct LostGame {
    /// A minimal core: guarantees that cannot be kept together under the assumptions, although
    /// every proper subset can. `None` if the search was skipped or reached a limit.
    pub core: Option<Vec<GuaranteeRef>>,
    /// Limit that ended the search for the core.
    pub stopped_by: Option<Limit>,
    /// Peak number of live nodes.
    pub peak_nodes: u64,
}

/// Operations on a won game, independent of its kernel.
pub trait Game: Debug + Send + Sync {
    /// See [`WonGame::explore`].
    fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<ExplicitStrategy, Limit>;

    /// See [`WonGame::functions`].
    fn functions(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<StrategyFunctions, Limit>;

    /// See [`WonGame::examine_environment`].
    fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit>;

    /// See [`WonGame::find_weaknesses`].
    fn find_weaknesses(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<WeaknessFindings, Limit>;

    /// See [`WonGame::ranking`].
    fn ranking(&self, specification: &Specification, limits: &Limits) -> Result<Ranking, Limit>;

    /// See [`WonGame::region`].
    fn region(&self) -> Diagram;

    /// See [`WonGame::work`].
    fn work(&self) -> u64;
}

impl LostGame {
    /// Returns the core's guarantees, except definitions; empty if the core is unknown.
    pub fn core_formulas<'s>(&self, specification: &'s Specification) -> Vec<&'s Formula> {
        let core = self.core.iter().flatten();
        core.map(|r| r.formula(&specification.guarantees))
            .filter(|f| !f.defines)
            .collect()
    }
}

impl WonGame {
    /// Returns a strategy as plain data: explicit states with guards.
    pub fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<ExplicitStrategy, Limit> {
        self.game.explore(specification, preference, limits)
    }

    /// Returns a strategy as plain data: functions of bits, for machines that are too large for
    /// [`WonGame::explore`].
    pub fn functions(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<StrategyFunctions, Limit> {
        self.game.functions(specification, limits)
    }

    /// Examines the assumptions; see [`super::examine_environment`].
    pub fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit> {
        self.game.examine_environment(specification, limits)
    }

    /// Finds where the specification demands less than it seems to; see [`WeaknessFindings`].
    pub fn find_weaknesses(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<WeaknessFindings, Limit> {
        self.game.find_weaknesses(specification, limits)
    }

    /// Returns the evidence that the game is won, for an independent check; see [`Ranking`].
    pub fn ranking(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Ranking, Limit> {
        self.game.ranking(specification, limits)
    }

    /// Returns a diagram over current bits whose only root is the winning region.
    pub fn region(&self) -> Diagram {
        self.game.region()
    }

    /// Returns the units of work done so far on the kernel that holds the game; see
    /// [`Limits::with_budget_after`].
    pub fn work(&self) -> u64 {
        self.game.work()
    }
}
