//! The play that shows why a game is lost: the environment wins as early as it can, the machine
//! resists as long as it can.
//!
//! In every step the machine takes the legal answer that leads to the highest stage, so that a play
//! that ends in a clash is as long as the machine can make it; among equals it changes the fewest
//! outputs. The play ends where no answer is legal, and names the guarantees that clash there; or
//! it returns to an earlier step, and then a goal is withheld from the machine for ever.

use super::board::{Board, Stage};
use super::strategy::Strategy;
use crate::game::arena::Formulas;
use crate::game::reference::{GuaranteeKind, GuaranteeRef};
use crate::symbolic::{Bit, BitSet, Kernel, Limit};
use linewright_core::gr1::{Specification, Time, Timing, VarId};
use serde::{Deserialize, Serialize};

/// A play lost by the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Play {
    /// The valuations step by step, with one value per variable of the specification. In the last
    /// step of a play that ends in a clash, only the inputs are meaningful; for a machine that
    /// moves first, its outputs too.
    pub steps: Vec<Vec<i64>>,
    /// How it ends.
    pub ending: Ending,
}

/// How a lost play ends.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// In the last step no answer keeps all of these guarantees, but some answer keeps any proper
    /// subset of them.
    Clash(Vec<GuaranteeRef>),
    /// The play repeats from this step for ever, and never meets this guarantee.
    Starved {
        /// Index of the step to which it returns.
        from: usize,
        /// The guarantee that is never met.
        goal: GuaranteeRef,
    },
}

impl Play {
    /// Converts the guarantees of a [reduced](super::reduced) specification to those of the whole;
    /// `core` lists the ones that were kept.
    #[must_use]
    pub fn within(mut self, core: &[GuaranteeRef]) -> Self {
        let whole = |guarantee: &mut GuaranteeRef| {
            let mut alike = core.iter().filter(|g| g.kind == guarantee.kind);
            if let Some(original) = alike.nth(guarantee.index) {
                *guarantee = *original;
            }
        };
        match &mut self.ending {
            Ending::Clash(rules) => rules.iter_mut().for_each(whole),
            Ending::Starved { goal, .. } => whole(goal),
        }
        self
    }
}

/// Computes a play. The machine starts within `beginning` if it can.
pub fn play<K: Kernel>(
    board: &Board<K>,
    specification: &Specification,
    formulas: &Formulas<K>,
    strategy: &Strategy<K>,
    stages: &[Stage<K>],
    beginning: &K::Function,
) -> Result<Play, Limit> {
    let player = Player {
        board,
        m: &board.arena.kernel,
        specification,
        stages,
    };
    let mut steps: Vec<Vec<i64>> = Vec::new();
    let mut seen: Vec<(usize, Vec<i64>)> = Vec::new();
    let mut aim = 0;
    let m = player.m;
    // Moves of the upcoming step, over next bits, and the legal ones among them.
    let mut given = m.prime(&strategy.initial)?;
    let mut legal = m.prime(&board.arena.sys_initial)?;
    let wished = m.and(&legal, &m.prime(beginning)?)?;
    if !m.is_false(&m.and(&given, &wished)?) {
        legal = wished;
    }
    let mut met = m.constant(false);
    loop {
        m.limits().check_time()?;
        let possible = m.and(&given, &legal)?;
        let Some(step) = player.resist(&possible, steps.last())? else {
            let bits = player.offered(&given, steps.last())?;
            let last = player.valuation(&bits);
            let clash = player.clash(formulas, steps.last(), &last)?;
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
}

impl<K: Kernel> Player<'_, K> {
    /// Among these steps, over next bits, the one with which the machine holds out longest.
    fn resist(
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
            best = self.quiet(best, output, before)?;
        }
        let bits = m.witness(&best).unwrap_or_default();
        Ok(Some(self.valuation(&bits)))
    }

    /// For each variable, restricts moves to those that do not change it, or else to those that set
    /// its smallest value, if there are any.
    fn quiet(
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

    /// What is given when no answer is legal; for a machine that moves first, with its quietest
    /// answer.
    fn offered(&self, given: &K::Function, before: Option<&Vec<i64>>) -> Result<Vec<bool>, Limit> {
        let m = self.m;
        let mut moves = m.and(given, &m.prime(&self.domains()?)?)?;
        for output in self.specification.outputs() {
            moves = self.quiet(moves, output, before)?;
        }
        Ok(m.witness(&moves).unwrap_or_default())
    }

    /// Every output has a value in its domain.
    fn domains(&self) -> Result<K::Function, Limit> {
        let (m, encoding) = (self.m, &self.board.arena.encoding);
        let mut within = m.constant(true);
        for output in self.specification.outputs() {
            within = m.and(&within, &encoding.in_domain(m, output, Time::Now)?)?;
        }
        Ok(within)
    }

    /// A minimal set of guarantees that no answer keeps together.
    fn clash(
        &self,
        formulas: &Formulas<K>,
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
        let mut left = Vec::new();
        for (guarantee, function) in formulas.rules(before.is_none())? {
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

    /// The goal withheld from the machine in a state.
    fn goal(&self, state: &[i64]) -> Result<GuaranteeRef, Limit> {
        let m = self.m;
        let cube = self.cube(state, Time::Now)?;
        for stage in self.stages {
            if !m.is_false(&m.and(&stage.reached, &cube)?) {
                let index = stage.starve.as_ref().map_or(0, |s| s.goal);
                return Ok(GuaranteeRef {
                    kind: GuaranteeKind::Justice,
                    index,
                });
            }
        }
        unreachable!("a play left what the environment wins; please report this")
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
    /// Bits of the current step.
    pub fn now(&self) -> BitSet {
        let arena = &self.arena;
        BitSet::new(arena.inputs_now.iter().chain(arena.outputs_now.iter()))
    }
}
