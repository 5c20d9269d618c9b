//! Tries a repair: first in the core's game, then in the whole game, then checks that an
//! environment remains.

use crate::game::arena::{Formulas, Selection};
use crate::game::findings::{self, EnvironmentFindings, shape};
use crate::game::fixpoint::{Iterations, winning_region};
use crate::game::lasting::together;
use crate::game::reference::{GuaranteeKind, GuaranteeRef};
use crate::game::set_up::SPLIT;
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::{Expr, Specification, Time, Timing};

/// Maximum number of games on the core in the search for repairs of one kind.
const MOST_GAMES: usize = 600;

/// The games of a search.
pub struct Trials<'a, K: Kernel> {
    pub formulas: &'a Formulas<K>,
    pub specification: &'a Specification,
    core: &'a [GuaranteeRef],
    /// Findings about the original environment.
    environment: EnvironmentFindings,
    /// The environment's steps, and all steps: the bases of the shares.
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

    /// Starts a search for another kind of repair.
    pub fn begin(&mut self) {
        self.games = 0;
    }

    /// Whether the number of games is used up.
    pub fn spent(&self) -> bool {
        self.games >= MOST_GAMES
    }

    pub fn encode(&self, expr: &Expr) -> Result<K::Function, Limit> {
        self.formulas
            .encoding()
            .formula(self.formulas.kernel(), expr)
    }

    /// Whether the core can be kept with one more assumption.
    pub fn helps_core(&mut self, kind: GuaranteeKind, expr: &Expr) -> Result<bool, Limit> {
        if self.spent() {
            return Ok(false);
        }
        self.games += 1;
        let more = self.formulas.assuming(kind, self.encode(expr)?);
        wins(&more, &Selection::Only(self.core))
    }

    /// Whether the core can be kept when one of its guarantees is weakened by `unless`, or left
    /// out.
    pub fn helps_core_without(
        &mut self,
        guarantee: GuaranteeRef,
        unless: Option<&Expr>,
    ) -> Result<bool, Limit> {
        if self.spent() {
            return Ok(false);
        }
        self.games += 1;
        wins(
            &self.weakened(guarantee, unless)?,
            &Selection::Only(self.core),
        )
    }

    /// Like `helps_core_without`, for all guarantees.
    pub fn mends_without(
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

    /// Whether these guarantees can be kept together.
    pub fn keeps(&self, guarantees: &[GuaranteeRef]) -> Result<bool, Limit> {
        wins(self.formulas, &Selection::Only(guarantees))
    }

    /// Whether all can be kept with one more assumption, by a plant that exists and is not worse
    /// off than before.
    pub fn mends(&self, kind: GuaranteeKind, expr: &Expr) -> Result<bool, Limit> {
        let more = self.formulas.assuming(kind, self.encode(expr)?);
        if !wins(&more, &Selection::All)? || !Self::possible(&more, &Selection::All)? {
            return Ok(false);
        }
        let arena = more.arena(&Selection::All, SPLIT)?;
        let found = findings::examine(&more, &arena, self.specification)?;
        let before = &self.environment;
        let worse = |now: bool, before: bool| now && !before;
        Ok(!worse(found.cannot_start, before.cannot_start)
            && !worse(
                found.stuck_at_start.is_some(),
                before.stuck_at_start.is_some(),
            )
            && !worse(found.dead_end.is_some(), before.dead_end.is_some())
            // A controller that wins by forcing the plant to fail is no repair.
            && found.forced.is_none())
    }

    /// Whether some play keeps all rules and all justice of both sides.
    pub fn possible(formulas: &Formulas<K>, selection: &Selection<'_>) -> Result<bool, Limit> {
        let arena = formulas.arena_of(selection, SPLIT, Timing::Mealy)?;
        let m = &arena.kernel;
        let first = m.and(&arena.env_initial, &arena.sys_initial)?;
        Ok(!m.is_false(&m.and(&first, &together(&arena)?)?))
    }

    /// Whether a guarantee still demands anything if it need not hold where `unless` does.
    pub fn asks(&self, guarantee: GuaranteeRef, unless: &Expr) -> Result<bool, Limit> {
        let m = self.formulas.kernel();
        let formula = guarantee.formula(&self.specification.guarantees);
        let weak = m.or(&self.encode(&formula.expr)?, &self.encode(unless)?)?;
        if m.is_false(&m.and_not(&self.steps[1], &weak)?) {
            return Ok(false);
        }
        // In some step of some controller its condition holds, but not the exception.
        let less = self.weakened(guarantee, Some(unless))?;
        let arena = less.arena(&Selection::All, SPLIT)?;
        let Some(region) = winning_region(&arena, None, &Iterations::default())? else {
            return Ok(false);
        };
        let (reached, moves) = shape::occurring(&arena, &region)?;
        let mut asked = m.and_not(&m.and(&reached, &moves)?, &self.encode(unless)?)?;
        for part in formula.expr.conjuncts() {
            if let Some(condition) = shape::antecedent(part) {
                asked = m.and(&asked, &self.encode(&condition)?)?;
            }
        }
        Ok(!m.is_false(&asked))
    }

    /// Whether a guarantee mentions the state of a monitor.
    pub fn is_of_monitor(&self, guarantee: GuaranteeRef) -> bool {
        let mut made_up = false;
        let formula = guarantee.formula(&self.specification.guarantees);
        formula
            .expr
            .for_each_var(&mut |v, _| made_up |= self.specification.is_auxiliary(v));
        made_up
    }

    /// The share of the environment's steps in which a formula does not hold.
    pub fn forbids(&self, expr: &Expr) -> Result<f64, Limit> {
        let m = self.formulas.kernel();
        let wrong = m.and_not(&self.steps[0], &self.encode(expr)?)?;
        Ok(self.share(&wrong, &self.steps[0]))
    }

    /// The share of all steps in which a formula holds.
    pub fn holds(&self, expr: &Expr) -> Result<f64, Limit> {
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
