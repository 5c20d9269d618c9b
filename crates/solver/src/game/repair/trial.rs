//! Tries out repairs: on the core, on the whole specification, and on the remaining environment.

use crate::game::arena::{Formulas, Selection};
use crate::game::findings::{self, EnvironmentFindings, shape};
use crate::game::fixpoint::{Iterations, winning_region};
use crate::game::lasting::cooperating;
use crate::game::reference::GuaranteeRef;
use crate::game::set_up::SPLIT;
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::{Expr, FormulaKind, Specification, Time, Timing};

/// Maximum number of games that a search for repairs of one kind solves for the core.
const MAX_GAMES: usize = 600;

/// Games for trying out repairs, with a limit on their number.
pub struct Trials<'a, K: Kernel> {
    pub formulas: &'a Formulas<K>,
    pub specification: &'a Specification,
    core: &'a [GuaranteeRef],
    /// Findings about the original environment.
    environment: EnvironmentFindings,
    /// The environment's steps, and all steps. Shares are relative to these sets.
    steps: [K::Function; 2],
    games: usize,
}

impl<'a, K: Kernel> Trials<'a, K> {
    pub fn new(
        formulas: &'a Formulas<K>,
        specification: &'a Specification,
        core: &'a [GuaranteeRef],
    ) -> Result<Self, Limit> {
        let arena = formulas.arena(&Selection::All, SPLIT)?;
        let m = formulas.kernel();
        let environment = findings::examine(formulas, &arena, specification)?;
        let free = formulas.arena(&Selection::Only(&[]), SPLIT)?;
        let moves = m.and(&free.states, &free.environment_moves()?)?;
        let mut all = m.constant(true);
        for (v, _) in specification.variables.iter().enumerate() {
            let id = linewright_core::gr1::VarId(v as u32);
            for time in [Time::Now, Time::Next] {
                all = m.and(&all, &formulas.encoding().in_domain(m, id, time)?)?;
            }
        }
        Ok(Self {
            formulas,
            specification,
            core,
            environment,
            steps: [moves, all],
            games: 0,
        })
    }

    /// Resets the number of games, before the search for another kind of repair.
    pub fn reset_games(&mut self) {
        self.games = 0;
    }

    /// Whether the maximum number of games is reached.
    pub fn is_exhausted(&self) -> bool {
        self.games >= MAX_GAMES
    }

    pub fn encode(&self, expr: &Expr) -> Result<K::Function, Limit> {
        self.formulas
            .encoding()
            .formula(self.formulas.kernel(), expr)
    }

    /// Whether one more assumption makes the core realizable. Returns false once the maximum number
    /// of games is reached.
    pub fn helps_core(&mut self, kind: FormulaKind, expr: &Expr) -> Result<bool, Limit> {
        if self.is_exhausted() {
            return Ok(false);
        }
        self.games += 1;
        let more = self.formulas.with_assumption(kind, self.encode(expr)?);
        wins(&more, &Selection::Only(self.core))
    }

    /// Whether the core becomes realizable if `guarantee` need not hold where `unless` holds, or is
    /// left out if `unless` is `None`. Returns false once the maximum number of games is reached.
    pub fn helps_core_without(
        &mut self,
        guarantee: GuaranteeRef,
        unless: Option<&Expr>,
    ) -> Result<bool, Limit> {
        if self.is_exhausted() {
            return Ok(false);
        }
        self.games += 1;
        wins(
            &self.weakened(guarantee, unless)?,
            &Selection::Only(self.core),
        )
    }

    /// Whether the whole specification becomes realizable if `guarantee` need not hold where
    /// `unless` holds, or is left out if `unless` is `None`.
    pub fn helps_whole_without(
        &self,
        guarantee: GuaranteeRef,
        unless: Option<&Expr>,
    ) -> Result<bool, Limit> {
        wins(&self.weakened(guarantee, unless)?, &Selection::All)
    }

    fn weakened(
        &self,
        guarantee: GuaranteeRef,
        unless: Option<&Expr>,
    ) -> Result<Formulas<K>, Limit> {
        let unless = match unless {
            Some(expr) => self.encode(expr)?,
            None => self.formulas.kernel().constant(true),
        };
        self.formulas.weakened(guarantee, &unless)
    }

    /// Whether the specification is realizable with only these guarantees.
    pub fn is_realizable(&self, guarantees: &[GuaranteeRef]) -> Result<bool, Limit> {
        wins(self.formulas, &Selection::Only(guarantees))
    }

    /// Whether one more assumption makes the whole specification realizable, is compatible with the
    /// other formulas, adds no dead end, and leaves the assumptions well-separated.
    pub fn helps_whole(&self, kind: FormulaKind, expr: &Expr) -> Result<bool, Limit> {
        let more = self.formulas.with_assumption(kind, self.encode(expr)?);
        if !wins(&more, &Selection::All)? || !Self::is_satisfiable(&more, &Selection::All)? {
            return Ok(false);
        }
        let arena = more.arena(&Selection::All, SPLIT)?;
        let found = findings::examine(&more, &arena, self.specification)?;
        let before = &self.environment;
        let is_worse = |now: bool, before: bool| now && !before;
        Ok(!is_worse(found.cannot_start, before.cannot_start)
            && !is_worse(
                found.stuck_at_start.is_some(),
                before.stuck_at_start.is_some(),
            )
            && !is_worse(found.dead_end.is_some(), before.dead_end.is_some())
            // A controller must not win by forcing the environment to break an assumption.
            && found.forced.is_none())
    }

    /// Whether some play keeps all selected formulas of both sides.
    pub fn is_satisfiable(
        formulas: &Formulas<K>,
        selection: &Selection<'_>,
    ) -> Result<bool, Limit> {
        let arena = formulas.arena_with_timing(selection, SPLIT, Timing::Mealy)?;
        let m = &arena.kernel;
        let first = m.and(&arena.env_initial, &arena.sys_initial)?;
        Ok(!m.is_false(&m.and(&first, &cooperating(&arena)?)?))
    }

    /// Whether a guarantee still demands something in a step that can occur, if it need not hold
    /// where `unless` holds.
    pub fn still_demands(&self, guarantee: GuaranteeRef, unless: &Expr) -> Result<bool, Limit> {
        let m = self.formulas.kernel();
        let formula = guarantee.formula(&self.specification.guarantees);
        let weak = m.or(&self.encode(&formula.expr)?, &self.encode(unless)?)?;
        if m.is_false(&m.and_not(&self.steps[1], &weak)?) {
            return Ok(false);
        }
        // Searches for a step that can occur in which the guarantee's condition holds but the
        // exception does not.
        let less = self.weakened(guarantee, Some(unless))?;
        let arena = less.arena(&Selection::All, SPLIT)?;
        let Some(region) = winning_region(&arena, None, &Iterations::default())? else {
            return Ok(false);
        };
        let (reached, moves) = shape::reachable_play(&arena, &region)?;
        let mut demanding = m.and_not(&m.and(&reached, &moves)?, &self.encode(unless)?)?;
        for part in formula.expr.conjuncts() {
            if let Some(condition) = shape::antecedent(part) {
                demanding = m.and(&demanding, &self.encode(&condition)?)?;
            }
        }
        Ok(!m.is_false(&demanding))
    }

    /// Whether a guarantee mentions the state of a monitor.
    pub fn mentions_monitor(&self, guarantee: GuaranteeRef) -> bool {
        let mut mentions = false;
        let formula = guarantee.formula(&self.specification.guarantees);
        formula
            .expr
            .for_each_var(&mut |v, _| mentions |= self.specification.is_auxiliary(v));
        mentions
    }

    /// Whether a guarantee belongs to the declaration of an internal variable, such as a counter of
    /// Spectra.
    pub fn declares(&self, guarantee: GuaranteeRef) -> bool {
        let formula = guarantee.formula(&self.specification.guarantees);
        let mut variables = self.specification.variables.iter();
        variables.any(|v| v.internal && v.name == formula.name)
    }

    /// Returns the share of the environment's steps in which a formula does not hold.
    pub fn forbidden_share(&self, expr: &Expr) -> Result<f64, Limit> {
        let m = self.formulas.kernel();
        let wrong = m.and_not(&self.steps[0], &self.encode(expr)?)?;
        Ok(self.share(&wrong, &self.steps[0]))
    }

    /// Returns the share of all steps in which a formula holds.
    pub fn holding_share(&self, expr: &Expr) -> Result<f64, Limit> {
        let m = self.formulas.kernel();
        let right = m.and(&self.steps[1], &self.encode(expr)?)?;
        Ok(self.share(&right, &self.steps[1]))
    }

    fn share(&self, part: &K::Function, whole: &K::Function) -> f64 {
        let shares = self.formulas.kernel().export(&[part, whole]).shares();
        if shares[1] > 0.0 {
            shares[0] / shares[1]
        } else {
            0.0
        }
    }
}

fn wins<K: Kernel>(formulas: &Formulas<K>, selection: &Selection<'_>) -> Result<bool, Limit> {
    let arena = formulas.arena(selection, SPLIT)?;
    Ok(winning_region(&arena, None, &Iterations::default())?.is_some())
}
