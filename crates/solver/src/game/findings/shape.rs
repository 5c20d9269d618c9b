//! Finds places where a realizable specification demands less than it seems to.
//!
//! Formulas are evaluated on the plays that can occur: those in which the environment satisfies its
//! safety and the machine stays in its winning region, which no correct controller leaves. What
//! never occurs in such a play occurs under no correct controller.

use super::requests::{self, Request};
use super::{PartialValuation, prime_implicant};
use crate::game::arena::Arena;
use crate::game::fixpoint::winning_states;
use crate::game::reachable::reachable;
use crate::game::reference::{AssumptionRef, GuaranteeRef, all};
use crate::game::relation::Relation;
use crate::game::set_up::SPLIT;
use crate::symbolic::{BitSet, Kernel, Limit};
use linewright_core::gr1::{
    BinaryOp, Expr, Formula, FormulaKind as Kind, Owner, Side, Specification, Time, Timing, VarId,
};
use serde::{Deserialize, Serialize};

/// Places where a specification demands less than it seems to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct WeaknessFindings {
    /// Guarantees that cannot be broken, because the domains and the assumptions other than justice
    /// ensure them.
    pub unbreakable: Vec<GuaranteeRef>,
    /// Guarantees `P -> Q` whose P never holds.
    pub unreachable: Vec<GuaranteeRef>,
    /// Assumptions `P -> Q` whose P never holds, so that they have no effect.
    pub unneeded: Vec<AssumptionRef>,
    /// Outputs that no guarantee restricts although some formula mentions them.
    pub unconstrained: Vec<VarId>,
    /// Outputs that never change in any play, with their value.
    pub constant: Vec<(VarId, i64)>,
    /// Outputs that are undetermined in some situations.
    pub unframed: Vec<UnframedOutput>,
    /// Whether a machine that never changes an output keeps all guarantees, although the
    /// specification has justice formulas.
    pub idle: bool,
    /// Requests that need not be completed.
    pub requests: Vec<Request>,
}

/// An output that can take any value in some situation, although a guarantee determines it in
/// others.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnframedOutput {
    /// The output.
    pub variable: VarId,
    /// Current values after which the next value of the output is free.
    pub situation: PartialValuation,
    /// A guarantee that determines the next value of the output in other situations.
    pub fixed_by: GuaranteeRef,
}

/// Finds the places where a specification demands less than it seems to; `region` is the winning
/// region.
pub fn find_weaknesses<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
) -> Result<WeaknessFindings, Limit> {
    let inspection = Inspection::new(arena, specification, region)?;
    Ok(WeaknessFindings {
        unbreakable: inspection.unbreakable()?,
        unreachable: inspection.unreachable(&specification.guarantees)?,
        unneeded: inspection.unreachable(&specification.assumptions)?,
        unconstrained: inspection.unconstrained()?,
        constant: inspection.constant()?,
        unframed: inspection.unframed()?,
        idle: inspection.idle()?,
        requests: requests::uncompleted(
            arena,
            specification,
            &inspection.reached,
            &inspection.moves,
        )?,
    })
}

struct Inspection<'a, K: Kernel> {
    arena: &'a Arena<K>,
    m: &'a K,
    specification: &'a Specification,
    /// The states that can occur.
    reached: K::Function,
    /// All steps from any state: moves of the environment with answers that stay in the winning
    /// region.
    moves: K::Function,
}

impl<'a, K: Kernel> Inspection<'a, K> {
    fn new(
        arena: &'a Arena<K>,
        specification: &'a Specification,
        region: &K::Function,
    ) -> Result<Self, Limit> {
        let m = &arena.kernel;
        let (reached, moves) = reachable_play(arena, region)?;
        Ok(Self {
            arena,
            m,
            specification,
            reached,
            moves,
        })
    }

    fn encode(&self, expr: &Expr) -> Result<K::Function, Limit> {
        self.arena.encoding.formula(self.m, expr)
    }

    /// All guarantees with their references.
    fn guarantees(&self) -> impl Iterator<Item = (GuaranteeRef, &'a Formula)> {
        all(&self.specification.guarantees)
    }

    /// Returns the guarantees that hold in all states or steps that the domains of both sides and
    /// the environment's initial conditions, invariants and safety allow.
    fn unbreakable(&self) -> Result<Vec<GuaranteeRef>, Limit> {
        let (arena, m) = (self.arena, self.m);
        let mut domains = m.constant(true);
        for v in 0..self.specification.variables.len() {
            let within = arena.encoding.in_domain(m, VarId(v as u32), Time::Now)?;
            domains = m.and(&domains, &within)?;
        }
        let mut invariants = domains.clone();
        for formula in &self.specification.assumptions.invariants {
            invariants = m.and(&invariants, &self.encode(&formula.expr)?)?;
        }
        let steps = m.and(&invariants, &m.prime(&domains)?)?;
        let steps = m.and(&steps, &arena.environment_moves()?)?;
        let first = m.and(&domains, &arena.env_initial)?;
        let mut found = Vec::new();
        for (guarantee, formula) in self.guarantees() {
            let allowed = match guarantee.kind {
                Kind::Initial => &first,
                Kind::Invariant => &invariants,
                Kind::Safety | Kind::Justice => &steps,
            };
            let broken = m.and_not(allowed, &self.encode(&formula.expr)?)?;
            if m.is_false(&broken) {
                found.push(guarantee);
            }
        }
        Ok(found)
    }

    /// Returns the steps that can occur.
    fn steps(&self) -> Result<K::Function, Limit> {
        self.m.and(&self.reached, &self.moves)
    }

    /// Returns the formulas of a side whose conjuncts all have a condition that never holds.
    fn unreachable(&self, side: &Side) -> Result<Vec<GuaranteeRef>, Limit> {
        let m = self.m;
        let steps = self.steps()?;
        let first = m.and(
            &m.and(&self.reached, &self.arena.env_initial)?,
            &self.arena.sys_initial,
        )?;
        let mut found = Vec::new();
        for (guarantee, formula) in all(side) {
            let among = match guarantee.kind {
                Kind::Initial => &first,
                Kind::Invariant => &self.reached,
                Kind::Safety | Kind::Justice => &steps,
            };
            let parts = formula.expr.conjuncts().into_iter();
            let Some(antecedents) = parts.map(antecedent).collect::<Option<Vec<Expr>>>() else {
                continue;
            };
            let mut never = true;
            for antecedent in antecedents {
                // A condition on current values also counts in states without a next step.
                let among = if antecedent.mentions_next() || guarantee.kind == Kind::Initial {
                    among
                } else {
                    &self.reached
                };
                let holds = m.and(among, &self.encode(&antecedent)?)?;
                never &= m.is_false(&holds);
            }
            if never {
                found.push(guarantee);
            }
        }
        Ok(found)
    }

    /// Returns the outputs in the machine's interface that have more than one value.
    fn outputs(&self) -> impl Iterator<Item = VarId> {
        let specification = self.specification;
        specification.outputs().filter(|v| {
            let variable = specification.variable(*v);
            !variable.internal && variable.domain.size() > 1
        })
    }

    fn unconstrained(&self) -> Result<Vec<VarId>, Limit> {
        let mut mentioned = vec![false; self.specification.variables.len()];
        let (a, g) = (
            &self.specification.assumptions,
            &self.specification.guarantees,
        );
        for formula in a.all().chain(g.all()) {
            formula
                .expr
                .for_each_var(&mut |v, _| mentioned[v.index()] = true);
        }
        let mut found = Vec::new();
        for v in self.outputs().filter(|v| mentioned[v.index()]) {
            let mut restricted = false;
            for (_, formula) in self.guarantees() {
                let function = self.encode(&formula.expr)?;
                restricted |= self.affects(&function, v, Time::Now)?
                    || self.affects(&function, v, Time::Next)?;
            }
            if !restricted {
                found.push(v);
            }
        }
        Ok(found)
    }

    /// Whether the value of a variable affects a function if all variables have values in their
    /// domains.
    fn affects(&self, function: &K::Function, v: VarId, time: Time) -> Result<bool, Limit> {
        let (m, encoding) = (self.m, &self.arena.encoding);
        let bits = encoding.bit_set([v], time);
        let mut domains = m.constant(true);
        for w in 0..self.specification.variables.len() {
            for t in [Time::Now, Time::Next] {
                let within = encoding.in_domain(m, VarId(w as u32), t)?;
                domains = m.and(&domains, &within)?;
            }
        }
        let holds = m.and_exists(&domains, function, &bits)?;
        let fails = m.exists(&m.and_not(&domains, function)?, &bits)?;
        Ok(!m.is_false(&m.and(&holds, &fails)?))
    }

    fn constant(&self) -> Result<Vec<(VarId, i64)>, Limit> {
        let m = self.m;
        let mut found = Vec::new();
        let Some(bits) = m.witness(&self.reached) else {
            return Ok(found);
        };
        for v in self.outputs() {
            let value = self.arena.encoding.value(v, Time::Now, &bits);
            let is = m.cube(&self.arena.encoding.assignment(v, Time::Now, value))?;
            if m.is_false(&m.and_not(&self.reached, &is)?) {
                found.push((v, value));
            }
        }
        Ok(found)
    }

    fn unframed(&self) -> Result<Vec<UnframedOutput>, Limit> {
        let (arena, m) = (self.arena, self.m);
        let mut found = Vec::new();
        let answers = m.and(&arena.system_moves()?, &m.prime(&arena.states)?)?;
        let mut domains = m.constant(true);
        for v in self.specification.outputs() {
            let within = arena.encoding.in_domain(m, v, Time::Next)?;
            domains = m.and(&domains, &within)?;
        }
        let here = m.and(&self.reached, &arena.environment_moves()?)?;
        for v in self.outputs() {
            let sets_next = |formula: &Formula| {
                let mut sets = false;
                formula
                    .expr
                    .for_each_var(&mut |w, t| sets |= w == v && t == Time::Next);
                sets
            };
            let setting: Vec<(GuaranteeRef, &Formula)> = self
                .guarantees()
                .filter(|(g, f)| g.kind == Kind::Safety && sets_next(f))
                .collect();
            if setting.is_empty() {
                continue;
            }
            let own = arena.encoding.bit_set([v], Time::Next);
            let others = arena.outputs_next.iter();
            let others = BitSet::new(others.filter(|bit| !own.contains(*bit)));
            let within = arena.encoding.in_domain(m, v, Time::Next)?;
            // A situation counts if the formulas about the next value of the output do not restrict
            // this value there, whatever values the other outputs take ...
            let mut allowed = domains.clone();
            for (_, formula) in &setting {
                allowed = m.and(&allowed, &self.encode(&formula.expr)?)?;
            }
            let possible = m.and(&m.exists(&allowed, &own)?, &domains)?;
            let bound = m.exists(&m.and_not(&possible, &allowed)?, &arena.outputs_next)?;
            // ... and if each value of the output is part of some legal answer.
            let answered = m.exists(&answers, &others)?;
            let missing = m.exists(&m.and_not(&within, &answered)?, &own)?;
            let free = m.and_not(&m.and_not(&here, &bound)?, &missing)?;
            let Some(situation) = prime_implicant(arena, self.specification, &free, &here)? else {
                continue;
            };
            let fixed_by = self.determining_guarantee(v, &setting, &here)?;
            if let Some(fixed_by) = fixed_by
                && self.wins_framed(v, &free)?
            {
                found.push(UnframedOutput {
                    variable: v,
                    situation,
                    fixed_by,
                });
            }
        }
        Ok(found)
    }

    /// Whether the machine still wins if an output keeps its value wherever it is free. If the
    /// machine does not win then, the free choice is intended.
    fn wins_framed(&self, v: VarId, free: &K::Function) -> Result<bool, Limit> {
        let (arena, m) = (self.arena, self.m);
        let mut frame = m.or(&m.not(free)?, &arena.encoding.unchanged(m, v)?)?;
        if arena.timing == Timing::Moore {
            frame = arena.for_all_inputs(&frame)?;
        }
        self.wins_with(vec![frame])
    }

    /// Whether the machine wins if it must also satisfy the safety relations `more`.
    fn wins_with(&self, more: Vec<K::Function>) -> Result<bool, Limit> {
        let (arena, m) = (self.arena, self.m);
        let mut parts: Vec<K::Function> = arena.system.parts().cloned().collect();
        parts.extend(more);
        let restricted = Arena {
            system: Relation::new(m, &parts, &arena.outputs_next, SPLIT, arena.heuristics)?,
            ..arena.clone()
        };
        restricted.wins_initially(&winning_states(&restricted)?)
    }

    /// Returns a guarantee that in some possible situation allows only a single next value of an
    /// output, different from its current value. A guarantee that only preserves the value does not
    /// count, because the free choice is intended where the guarantee's condition does not hold.
    fn determining_guarantee(
        &self,
        v: VarId,
        setting: &[(GuaranteeRef, &Formula)],
        here: &K::Function,
    ) -> Result<Option<GuaranteeRef>, Limit> {
        let (arena, m) = (self.arena, self.m);
        let within = arena.encoding.in_domain(m, v, Time::Next)?;
        let unchanged = arena.encoding.unchanged(m, v)?;
        let own: Vec<_> = arena.encoding.bits(v, Time::Next).collect();
        let set = BitSet::new(own.iter().copied());
        for (guarantee, formula) in setting {
            let allows = m.and(&self.encode(&formula.expr)?, &within)?;
            let mut several = m.constant(false);
            for bit in &own {
                let high = m.exists(&m.and(&allows, &m.literal(*bit, true))?, &set)?;
                let low = m.exists(&m.and(&allows, &m.literal(*bit, false))?, &set)?;
                several = m.or(&several, &m.and(&high, &low)?)?;
            }
            let one = m.and_not(&m.exists(&allows, &set)?, &several)?;
            let new = m.exists(&m.and_not(&allows, &unchanged)?, &set)?;
            let one = m.and(&one, &new)?;
            if !m.is_false(&m.and(here, &one)?) {
                return Ok(Some(*guarantee));
            }
        }
        Ok(None)
    }

    /// Whether a machine that never changes an output wins although there are justice formulas.
    fn idle(&self) -> Result<bool, Limit> {
        let (arena, m) = (self.arena, self.m);
        let (a, g) = (
            &self.specification.assumptions,
            &self.specification.guarantees,
        );
        let busy = !a.justice.is_empty() || !g.justice.is_empty();
        if !busy || self.outputs().next().is_none() {
            return Ok(false);
        }
        let mut frames = Vec::new();
        for v in self.specification.outputs() {
            let variable = self.specification.variable(v);
            if variable.owner == Owner::System && !variable.internal {
                frames.push(arena.encoding.unchanged(m, v)?);
            }
        }
        self.wins_with(frames)
    }
}

/// Returns the states that can occur under some controller, and all steps from any state: moves of
/// the environment with answers that stay in the winning region.
pub fn reachable_play<K: Kernel>(
    arena: &Arena<K>,
    region: &K::Function,
) -> Result<(K::Function, K::Function), Limit> {
    let m = &arena.kernel;
    let target = m.prime(region)?;
    let stays = match arena.timing {
        Timing::Mealy => target,
        // A machine that moves first can give only answers that are legal for all inputs.
        Timing::Moore => m.and(&arena.for_all_inputs(&target)?, &target)?,
    };
    let moves = m.and(
        &m.and(&arena.environment_moves()?, &arena.system_moves()?)?,
        &stays,
    )?;
    let mut first = m.and(&arena.sys_initial, region)?;
    if arena.timing == Timing::Moore {
        let right = m.implies_forall(&arena.env_initial, &first, &arena.inputs_now)?;
        first = m.and(&first, &right)?;
    }
    let first = m.and(&first, &arena.env_initial)?;
    let reached = reachable(arena, &first, &moves)?;
    Ok((reached, moves))
}

/// Returns the condition of an implication: P of `P -> Q`, and `P and R` of `P -> (R -> Q)`.
/// Returns `None` for any other formula.
pub fn antecedent(expr: &Expr) -> Option<Expr> {
    let Expr::Binary(BinaryOp::Implies, a, b) = expr else {
        return None;
    };
    Some(match antecedent(b) {
        Some(more) => (**a).clone().and(more),
        None => (**a).clone(),
    })
}
