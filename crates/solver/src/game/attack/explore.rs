//! Converts a counterstrategy to explicit states with guards over the machine's outputs.
//!
//! As for strategies ([`crate::game::explore`]), a state is defined by the next behavior: the
//! residual of the counterstrategy for the current step, and the steps that meet the pursued
//! assumption. So if the environment moves first, the number of states is at most the number of
//! different inputs that it gives, times the number of assumptions.

use super::board::Board;
use super::strategy::Strategy;
use crate::game::cover::Cover;
use crate::game::explore::{ExplicitStrategy, Row};
use crate::symbolic::{Bit, Kernel, Limit, Limits};
use linewright_core::gr1::{Specification, Time, Timing, VarId};
use rustc_hash::FxHashMap;
use std::collections::VecDeque;

/// Maximum number of rows.
const MAX_ROWS: usize = 200_000;

/// Maximum number of states.
const MAX_STATES: usize = 20_000;

/// A state of the counterstrategy: its next move, over next bits.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key<F> {
    /// Index of the pursued assumption.
    aim: usize,
    /// The inputs x′; as a function of the answer y′ if the machine moves first.
    given: F,
    /// The steps (x′, y′) that meet the pursued assumption.
    met: F,
}

/// A set of steps, with the environment's next state.
struct Class<K: Kernel> {
    /// The valuations (x, y) of the step that are legal with the given inputs; over current bits.
    step: K::Function,
    to: usize,
}

/// The inputs that the environment gives in a step, and the next states, grouped by the machine's
/// answers.
type Step<K> = (Vec<i64>, Vec<Class<K>>);

/// The inputs that the environment gives, and the bits that encode them.
type Given = (Vec<i64>, Vec<(Bit, bool)>);

struct Explorer<'a, K: Kernel> {
    board: &'a Board<K>,
    m: &'a K,
    strategy: &'a Strategy<K>,
    inputs: Vec<VarId>,
    limits: &'a Limits,
    /// The states.
    keys: Vec<Key<K::Function>>,
    /// For each state, the steps (x′, y′) that are legal for the machine, over next bits.
    legal: Vec<K::Function>,
    /// Index of each state.
    numbers: FxHashMap<Key<K::Function>, usize>,
}

/// Converts a counterstrategy to explicit states. The last state is entered after answers that
/// break a guarantee.
pub fn explore<K: Kernel>(
    board: &Board<K>,
    specification: &Specification,
    strategy: &Strategy<K>,
    limits: &Limits,
) -> Result<ExplicitStrategy, Limit> {
    let m = &board.arena.kernel;
    let mut explorer = Explorer {
        board,
        m,
        strategy,
        inputs: specification.inputs().collect(),
        limits,
        keys: Vec::new(),
        legal: Vec::new(),
        numbers: FxHashMap::default(),
    };
    let first = Key {
        aim: 0,
        given: m.prime(&strategy.initial)?,
        met: m.constant(false),
    };
    let allowed = m.prime(&board.arena.sys_initial)?;
    let start = explorer.enter(first, &allowed)?.0;
    let mut queue = VecDeque::from([start]);
    while let Some(state) = queue.pop_front() {
        for (_, classes) in explorer.steps(state)? {
            for class in classes {
                if explorer.extend(&class)? && !queue.contains(&class.to) {
                    queue.push_back(class.to);
                }
            }
        }
    }

    let cover = Cover::of_outputs(m, &board.arena.encoding, specification);
    let mut room = MAX_ROWS;
    let mut rows = Vec::new();
    let lost = explorer.keys.len();
    for state in 0..lost {
        rows.push(explorer.rows(state, lost, &cover, &mut room)?);
    }
    // After an answer that breaks a guarantee, the environment can give any inputs.
    let given = rows[start].first().map_or(Vec::new(), |r| r.output.clone());
    rows.push(vec![Row {
        cubes: vec![Vec::new()],
        output: given,
        to: lost,
    }]);
    // The first state is that of step 0; no transition leads back to it.
    let initial = rows[start].clone();
    Ok(remove_unreachable(&ExplicitStrategy {
        initial,
        states: rows,
        goals: Vec::new(),
    }))
}

impl<K: Kernel> Explorer<'_, K> {
    /// Finds or creates the state of a key and adds legal steps to it. Returns its index, and
    /// whether the state or any of the steps are new.
    fn enter(
        &mut self,
        key: Key<K::Function>,
        legal: &K::Function,
    ) -> Result<(usize, bool), Limit> {
        let legal = self.m.and(legal, &key.given)?;
        let next = self.keys.len();
        let number = *self.numbers.entry(key.clone()).or_insert(next);
        if number == next {
            if next >= MAX_STATES {
                return Err(Limit::Size);
            }
            self.keys.push(key);
            self.legal.push(legal);
            return Ok((number, true));
        }
        let all = self.m.or(&self.legal[number], &legal)?;
        let fresh = all != self.legal[number];
        self.legal[number] = all;
        Ok((number, fresh))
    }

    /// Returns, for each input valuation that the environment gives in a state, the next states,
    /// grouped by the machine's answers.
    fn steps(&mut self, state: usize) -> Result<Vec<Step<K>>, Limit> {
        let m = self.m;
        let key = self.keys[state].clone();
        let mut steps = Vec::new();
        for (values, fixed) in self.given(&self.legal[state].clone())? {
            self.limits.check_time()?;
            let cube = m.cube(&fixed)?;
            let legal = m.and(&self.legal[state], &cube)?;
            let mut classes = Vec::new();
            let met = m.and(&legal, &key.met)?;
            let open = m.and_not(&legal, &key.met)?;
            for (part, aim) in [(met, self.strategy.after(key.aim)), (open, key.aim)] {
                if m.is_false(&part) {
                    continue;
                }
                // The next step becomes the current one.
                let part = m.unprime(&part)?;
                let now: Vec<(Bit, bool)> = fixed
                    .iter()
                    .map(|(bit, value)| (Bit(bit.0 & !1), *value))
                    .collect();
                let moves = m.restrict(&self.strategy.moves[aim], &now)?;
                let met = m.restrict(&self.strategy.met[aim], &now)?;
                self.split(aim, moves, &met, part, &mut classes)?;
            }
            steps.push((values, classes));
        }
        Ok(steps)
    }

    /// Splits the set `part` of current steps by the states to which the steps lead.
    fn split(
        &mut self,
        aim: usize,
        moves: K::Function,
        met: &K::Function,
        part: K::Function,
        classes: &mut Vec<Class<K>>,
    ) -> Result<(), Limit> {
        let m = self.m;
        if m.is_false(&part) {
            return Ok(());
        }
        let outputs = &self.board.arena.outputs_now;
        let mut bits = m.support(&moves);
        bits.extend(m.support(met));
        if let Some(bit) = bits.into_iter().find(|b| outputs.contains(*b)) {
            for value in [false, true] {
                let part = m.and(&part, &m.literal(bit, value))?;
                let moves = m.restrict(&moves, &[(bit, value)])?;
                let met = m.restrict(met, &[(bit, value)])?;
                self.split(aim, moves, &met, part, classes)?;
            }
            return Ok(());
        }
        let key = Key {
            aim,
            // Only steps with the given inputs matter.
            met: m.and(met, &moves)?,
            given: moves,
        };
        let nothing = m.constant(false);
        let (to, _) = self.enter(key, &nothing)?;
        match classes.iter_mut().find(|c| c.to == to) {
            Some(class) => class.step = m.or(&class.step, &part)?,
            None => classes.push(Class { step: part, to }),
        }
        Ok(())
    }

    /// Adds the legal steps that follow a class. Returns whether any of them are new.
    fn extend(&mut self, class: &Class<K>) -> Result<bool, Limit> {
        let now = self.board.now();
        let legal = self.m.and_exists(&class.step, &self.board.answers, &now)?;
        let key = self.keys[class.to].clone();
        Ok(self.enter(key, &legal)?.1)
    }

    /// Returns the different inputs (x′) of a set of steps, with their bits.
    fn given(&self, steps: &K::Function) -> Result<Vec<Given>, Limit> {
        let m = self.m;
        let arena = &self.board.arena;
        let mut rest = m.exists(steps, &arena.outputs_next)?;
        let mut found = Vec::new();
        while let Some(bits) = m.witness(&rest) {
            let value = |v: &VarId| arena.encoding.value(*v, Time::Next, &bits);
            let values: Vec<i64> = self.inputs.iter().map(value).collect();
            let pairs = self.inputs.iter().zip(&values);
            let fixed: Vec<(Bit, bool)> = pairs
                .flat_map(|(v, value)| arena.encoding.assignment(*v, Time::Next, *value))
                .collect();
            rest = m.and_not(&rest, &m.cube(&fixed)?)?;
            found.push((values, fixed));
        }
        Ok(found)
    }

    /// Returns the rows of a state. `lost` is the state after answers that break a guarantee.
    fn rows(
        &mut self,
        state: usize,
        lost: usize,
        cover: &Cover<'_, K>,
        room: &mut usize,
    ) -> Result<Vec<Row>, Limit> {
        let m = self.m;
        let inputs_next = self.board.arena.inputs_next.clone();
        let mut rows = Vec::new();
        for (values, classes) in self.steps(state)? {
            for class in classes {
                let guard = m.exists(&m.prime(&class.step)?, &inputs_next)?;
                let cubes = cover.cubes(&guard, *room)?;
                *room -= cubes.len();
                rows.push(Row {
                    cubes,
                    output: values.clone(),
                    to: class.to,
                });
            }
        }
        // Answers that break a guarantee need rows in two cases: if the machine moves first,
        // because the environment still gives inputs, and if every answer breaks a guarantee.
        let broken = m.and_not(&self.keys[state].given, &self.legal[state])?;
        let everything = m.is_false(&self.legal[state]);
        if everything || self.board.timing == Timing::Moore {
            for (values, fixed) in self.given(&broken)? {
                let here = m.and(&broken, &m.cube(&fixed)?)?;
                let guard = m.exists(&here, &inputs_next)?;
                let cubes = cover.cubes(&guard, *room)?;
                *room -= cubes.len();
                rows.push(Row {
                    cubes,
                    output: values,
                    to: lost,
                });
            }
        }
        Ok(rows)
    }
}

/// Removes unreachable states and numbers the others breadth-first.
fn remove_unreachable(explicit: &ExplicitStrategy) -> ExplicitStrategy {
    let mut numbers: FxHashMap<usize, usize> = FxHashMap::default();
    let mut order = Vec::new();
    let mut queue: VecDeque<usize> = explicit.initial.iter().map(|r| r.to).collect();
    while let Some(state) = queue.pop_front() {
        if numbers.contains_key(&state) {
            continue;
        }
        numbers.insert(state, order.len());
        order.push(state);
        queue.extend(explicit.states[state].iter().map(|r| r.to));
    }
    let renumber = |rows: &[Row]| -> Vec<Row> {
        let rows = rows.iter().cloned();
        rows.map(|r| Row {
            to: numbers[&r.to],
            ..r
        })
        .collect()
    };
    ExplicitStrategy {
        initial: renumber(&explicit.initial),
        states: order
            .iter()
            .map(|s| renumber(&explicit.states[*s]))
            .collect(),
        goals: Vec::new(),
    }
}
