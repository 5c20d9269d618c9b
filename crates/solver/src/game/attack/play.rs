//! Computes a play that shows why a game is lost: the environment wins as early as possible, and
//! the machine resists as long as possible.
//!
//! In every step, the machine takes a legal answer that leads to the highest stage, so that a play
//! that ends in a clash is as long as possible. Of several such answers, it prefers those that keep
//! the value of an output. The play ends in one of two ways. Either it reaches a step without a
//! legal answer; then it names the guarantees that clash there. Or it returns to an earlier step;
//! then the environment withholds a goal from the machine for ever.
//!
//! A safety guarantee without next values restricts the current step of a transition. So an answer
//! that violates such a guarantee is legal, but no step can follow. With [`PlayEnd::Violation`],
//! such an answer counts as illegal, so that the play ends in the step that violates the guarantee.
//! The machine does not lose a better answer this way, since the environment never gets stuck in a
//! game that it wins.

use super::board::{Board, Stage};
use super::strategy::Strategy;
use crate::game::arena::Formulas;
use crate::game::reference::GuaranteeRef;
use crate::symbolic::{Bit, BitSet, Kernel, Limit};
use linewright_core::gr1::{FormulaKind, Specification, Time, Timing, VarId};
use serde::{Deserialize, Serialize};

/// A play lost by the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Play {
    /// The valuations step by step, with one value per variable of the specification. In the last
    /// step of a play that ends in a clash, only the inputs are meaningful; if the machine moves
    /// first, the outputs are meaningful, too.
    pub steps: Vec<Vec<i64>>,
    /// How the play ends.
    pub ending: Ending,
}

/// The step in which a play ends if it violates a safety guarantee without next values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlayEnd {
    /// The step that violates the guarantee.
    Violation,
    /// The step after the violation, for which no legal move exists.
    NoMove,
}

/// How a lost play ends.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// In the last step, no answer keeps all of these guarantees, although every proper subset of
    /// them can be kept.
    Clash(Vec<GuaranteeRef>),
    /// The play repeats its steps from step `from` on for ever and never meets a justice guarantee.
    Starved {
        /// Index of the step to which the play returns.
        from: usize,
        /// The justice guarantee that is never met.
        goal: GuaranteeRef,
    },
}

impl Play {
    /// Converts references to guarantees of a [reduced](super::select_guarantees) specification
    /// into references to the original one. `core` lists the selected guarantees in ascending
    /// order.
    #[must_use]
    pub fn with_original_references(mut self, core: &[GuaranteeRef]) -> Self {
        let restore = |guarantee: &mut GuaranteeRef| {
            let mut of_kind = core.iter().filter(|g| g.kind == guarantee.kind);
            if let Some(original) = of_kind.nth(guarantee.index) {
                *guarantee = *original;
            }
        };
        match &mut self.ending {
            Ending::Clash(rules) => rules.iter_mut().for_each(restore),
            Ending::Starved { goal, .. } => restore(goal),
        }
        self
    }
}

/// Computes a play. The machine starts in a state of `start` if possible.
pub fn play<K: Kernel>(
    board: &Board<K>,
    specification: &Specification,
    formulas: &Formulas<K>,
    strategy: &Strategy<K>,
    stages: &[Stage<K>],
    start: &K::Function,
    end: PlayEnd,
) -> Result<Play, Limit> {
    let player = Player {
        board,
        m: &board.arena.kernel,
        specification,
        stages,
        end,
    };
    let mut steps: Vec<Vec<i64>> = Vec::new();
    let mut seen: Vec<(usize, Vec<i64>)> = Vec::new();
    let mut aim = 0;
    let m = player.m;
    // The environment's moves in the upcoming step and the machine's legal answers, over next bits.
    let mut given = m.prime(&strategy.initial)?;
    let mut legal = m.prime(&board.arena.sys_initial)?;
    let current_safety = player.current_safety(formulas)?;
    let kept = m.all(current_safety.iter().map(|(_, f)| f))?;
    let preferred = m.and(&legal, &m.prime(start)?)?;
    if !m.is_false(&m.and(&given, &preferred)?) {
        legal = preferred;
    }
    let mut met = m.constant(false);
    loop {
        m.limits().check_time()?;
        let possible = m.all([&given, &legal, &kept])?;
        let Some(step) = player.best_step(&possible, steps.last())? else {
            let bits = player.last_step(&given, steps.last())?;
            let last = player.valuation(&bits);
            let clash = player.clash(formulas, &current_safety, steps.last(), &last)?;
            steps.push(last);
            return Ok(Play {
                steps,
                ending: Ending::Clash(clash),
            });
        };
        let next = player.cube(&step, Time::Next)?;
        if !m.is_false(&m.and(&met, &next)?) {
            aim = strategy.after(aim);
        }
        let position = (aim, step.clone());
        if let Some(from) = seen.iter().position(|s| *s == position) {
            let goal = player.goal(&step)?;
            return Ok(Play {
                steps,
                ending: Ending::Starved { from, goal },
            });
        }
        seen.push(position);
        let now = player.assignment(&step, Time::Now);
        given = m.restrict(&strategy.moves[aim], &now)?;
        met = m.restrict(&strategy.met[aim], &now)?;
        legal = m.restrict(&board.answers, &now)?;
        steps.push(step);
    }
}

struct Player<'a, K: Kernel> {
    board: &'a Board<K>,
    m: &'a K,
    specification: &'a Specification,
    stages: &'a [Stage<K>],
    end: PlayEnd,
}

impl<K: Kernel> Player<'_, K> {
    /// Returns the step of the set `possible` (over next bits) with which the machine resists
    /// longest; `None` if the set is empty.
    fn best_step(
        &self,
        possible: &K::Function,
        before: Option<&Vec<i64>>,
    ) -> Result<Option<Vec<i64>>, Limit> {
        let m = self.m;
        if m.is_false(possible) {
            return Ok(None);
        }
        let mut best = possible.clone();
        for stage in self.stages.iter().rev() {
            let here = m.and_not(&m.prime(&stage.reached)?, &m.prime(&stage.before)?)?;
            let here = m.and(possible, &here)?;
            if !m.is_false(&here) {
                best = here;
                break;
            }
        }
        for output in self.specification.outputs() {
            best = self.keep_value(best, output, before)?;
        }
        let bits = m.witness(&best).unwrap_or_default();
        Ok(Some(self.valuation(&bits)))
    }

    /// Restricts moves to those that keep the value of `variable`, or else to those that give it
    /// the smallest possible value.
    fn keep_value(
        &self,
        moves: K::Function,
        variable: VarId,
        before: Option<&Vec<i64>>,
    ) -> Result<K::Function, Limit> {
        let (m, encoding) = (self.m, &self.board.arena.encoding);
        if let Some(before) = before {
            let value = before[variable.index()];
            let same = m.cube(&encoding.assignment(variable, Time::Next, value))?;
            let same = m.and(&moves, &same)?;
            if !m.is_false(&same) {
                return Ok(same);
            }
        }
        let mut moves = moves;
        for bit in encoding.bits(variable, Time::Next) {
            let low = m.and(&moves, &m.literal(bit, false))?;
            if !m.is_false(&low) {
                moves = low;
            }
        }
        Ok(moves)
    }

    /// Returns the safety guarantees without next values, as conditions on the next step: a play
    /// can continue after a step only if the step keeps them. Returns none if the machine moves
    /// first, because the inputs can then decide whether a step keeps them. Also returns none for
    /// [`PlayEnd::NoMove`].
    fn current_safety(
        &self,
        formulas: &Formulas<K>,
    ) -> Result<Vec<(GuaranteeRef, K::Function)>, Limit> {
        if self.end == PlayEnd::NoMove || self.board.timing == Timing::Moore {
            return Ok(Vec::new());
        }
        let safety = &self.specification.guarantees.safety;
        let mut found = Vec::new();
        for (guarantee, function) in formulas.step_guarantees(false)? {
            if guarantee.kind == FormulaKind::Safety
                && !safety[guarantee.index].expr.mentions_next()
            {
                found.push((guarantee, self.m.prime(&function)?));
            }
        }
        Ok(found)
    }

    /// Returns the valuation of the last step if no answer is legal; its outputs keep their values
    /// where possible.
    fn last_step(
        &self,
        given: &K::Function,
        before: Option<&Vec<i64>>,
    ) -> Result<Vec<bool>, Limit> {
        let m = self.m;
        let mut moves = m.and(given, &m.prime(&self.domains()?)?)?;
        for output in self.specification.outputs() {
            moves = self.keep_value(moves, output, before)?;
        }
        Ok(m.witness(&moves).unwrap_or_default())
    }

    /// Returns the valuations in which every output has a value in its domain.
    fn domains(&self) -> Result<K::Function, Limit> {
        let (m, encoding) = (self.m, &self.board.arena.encoding);
        let mut within = m.constant(true);
        for output in self.specification.outputs() {
            within = m.and(&within, &encoding.in_domain(m, output, Time::Now)?)?;
        }
        Ok(within)
    }

    /// Returns a minimal set of guarantees that no answer keeps together in the last step.
    fn clash(
        &self,
        formulas: &Formulas<K>,
        current_safety: &[(GuaranteeRef, K::Function)],
        before: Option<&Vec<i64>>,
        last: &[i64],
    ) -> Result<Vec<GuaranteeRef>, Limit> {
        let m = self.m;
        let mut fixed = Vec::new();
        if let Some(before) = before {
            fixed.extend(self.assignment(before, Time::Now));
        }
        for input in self.specification.inputs() {
            let value = last[input.index()];
            fixed.extend(
                self.board
                    .arena
                    .encoding
                    .assignment(input, Time::Next, value),
            );
        }
        if self.board.timing == Timing::Moore {
            for output in self.specification.outputs() {
                let value = last[output.index()];
                fixed.extend(
                    self.board
                        .arena
                        .encoding
                        .assignment(output, Time::Next, value),
                );
            }
        }
        let mut rules = formulas.step_guarantees(before.is_none())?;
        rules.retain(|(guarantee, _)| current_safety.iter().all(|(g, _)| g != guarantee));
        rules.extend_from_slice(current_safety);
        let mut left = Vec::new();
        for (guarantee, function) in rules {
            left.push((guarantee, m.restrict(&function, &fixed)?));
        }
        left.retain(|(_, f)| !m.is_true(f));
        let domains = m.prime(&self.domains()?)?;
        let domains = m.restrict(&domains, &fixed)?;
        let mut at = 0;
        while at < left.len() {
            let others = left.iter().enumerate().filter(|(i, _)| *i != at);
            let all = m.all(others.map(|(_, (_, f))| f))?;
            if m.is_false(&m.and(&all, &domains)?) {
                left.remove(at);
            } else {
                at += 1;
            }
        }
        Ok(left.into_iter().map(|(guarantee, _)| guarantee).collect())
    }

    /// Returns the goal that the environment withholds from the machine in a state.
    fn goal(&self, state: &[i64]) -> Result<GuaranteeRef, Limit> {
        let m = self.m;
        let cube = self.cube(state, Time::Now)?;
        for stage in self.stages {
            if !m.is_false(&m.and(&stage.reached, &cube)?) {
                let index = stage.starve.as_ref().map_or(0, |s| s.goal);
                return Ok(GuaranteeRef {
                    kind: FormulaKind::Justice,
                    index,
                });
            }
        }
        unreachable!("the play left the environment's winning region; please report this")
    }

    fn valuation(&self, bits: &[bool]) -> Vec<i64> {
        let encoding = &self.board.arena.encoding;
        let ids = (0..self.specification.variables.len()).map(|v| VarId(v as u32));
        ids.map(|v| encoding.value(v, Time::Next, bits)).collect()
    }

    fn assignment(&self, values: &[i64], time: Time) -> Vec<(Bit, bool)> {
        let encoding = &self.board.arena.encoding;
        let pairs = values.iter().enumerate();
        pairs
            .flat_map(|(v, value)| encoding.assignment(VarId(v as u32), time, *value))
            .collect()
    }

    fn cube(&self, values: &[i64], time: Time) -> Result<K::Function, Limit> {
        self.m.cube(&self.assignment(values, time))
    }
}

impl<K: Kernel> Board<K> {
    /// Returns the bits of the current step.
    pub fn now(&self) -> BitSet {
        let arena = &self.arena;
        BitSet::new(arena.inputs_now.iter().chain(arena.outputs_now.iter()))
    }
}
