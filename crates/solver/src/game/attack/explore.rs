//! A counterstrategy as explicit states with guards over the machine's outputs.
//!
//! As with strategies ([`crate::game::explore`]), a state is what will be done next: the residual
//! of the strategy for the known current step, and what is still missing for the pursued
//! assumption. So if the environment moves first, there are at most as many states as inputs that
//! it ever gives, times assumptions.

use super::board::Board;
use super::strategy::Strategy;
use crate::game::cover::Cover;
use crate::game::explore::{Explicit, Row};
use crate::symbolic::{Bit, Kernel, Limit, Limits};
use linewright_core::gr1::{Specification, Time, Timing, VarId};
use std::collections::{HashMap, VecDeque};

/// Maximum number of rows.
const MOST_ROWS: usize = 200_000;

/// Maximum number of states.
const MOST_STATES: usize = 20_000;

/// The upcoming move, over next bits.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key<F> {
    aim: usize,
    /// The inputs x′; as a function of the answer y′ if the machine moves first.
    given: F,
    /// The steps (x′, y′) that meet the pursued assumption.
    met: F,
}

/// A subset of the machine's answers, with the environment's next state.
struct Class<K: Kernel> {
    /// The valuations (x, y), as far as the given inputs allow; over current bits.
    step: K::Function,
    to: usize,
}

/// Given inputs, and the successors for the machine's answers.
type Step<K> = (Vec<i64>, Vec<Class<K>>);

/// Given inputs, and the bits that represent them.
type Given = (Vec<i64>, Vec<(Bit, bool)>);

struct Explorer<'a, K: Kernel> {
    board: &'a Board<K>,
    m: &'a K,
    strategy: &'a Strategy<K>,
    inputs: Vec<VarId>,
    limits: &'a Limits,
    keys: Vec<Key<K::Function>>,
    /// The steps (x′, y′) open to the machine, over next bits.
    legal: Vec<K::Function>,
    numbers: HashMap<Key<K::Function>, usize>,
}

/// Writes a counterstrategy state by state.
pub fn explore<K: Kernel>(
    board: &Board<K>,
    specification: &Specification,
    strategy: &Strategy<K>,
    limits: &Limits,
) -> Result<Explicit, Limit> {
    let m = &board.arena.kernel;
    let mut explorer = Explorer {
        board,
        m,
        strategy,
        inputs: specification.inputs().collect(),
        limits,
        keys: Vec::new(),
        legal: Vec::new(),
        numbers: HashMap::new(),
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
    let mut room = MOST_ROWS;
    let mut rows = Vec::new();
    let lost = explorer.keys.len();
    for state in 0..lost {
        rows.push(explorer.rows(state, lost, &cover, &mut room)?);
    }
    // If every answer breaks a guarantee, nothing more is needed.
    let given = rows[start].first().map_or(Vec::new(), |r| r.output.clone());
    rows.push(vec![Row {
        cubes: vec![Vec::new()],
        output: given,
        to: lost,
    }]);
    // The first state is that of step 0; no relevant transition leads back to it.
    let initial = rows[start].clone();
    Ok(trimmed(&Explicit {
        initial,
        states: rows,
    }))
}

impl<K: Kernel> Explorer<'_, K> {
    /// Returns the state of a key, adds new legal steps to it, and returns whether there were any.
    fn enter(
        &mut self,
        key: Key<K::Function>,
        legal: &K::Function,
    ) -> Result<(usize, bool), Limit> {
        let legal = self.m.and(legal, &key.given)?;
        let next = self.keys.len();
        let number = *self.numbers.entry(key.clone()).or_insert(next);
        if number == next {
            if next >= MOST_STATES {
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

    /// For each input given in a state, the successors for the machine's answers.
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
                // The step becomes the current one.
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

    /// Splits the current steps by the residuals they lead to.
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
            // Only steps that may be given matter.
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

    /// Adds the legal steps that follow a class. Returns whether any were new.
    fn extend(&mut self, class: &Class<K>) -> Result<bool, Limit> {
        let now = self.board.now();
        let legal = self.m.and_exists(&class.step, &self.board.answers, &now)?;
        let key = self.keys[class.to].clone();
        Ok(self.enter(key, &legal)?.1)
    }

    /// The distinct inputs (x′) of a set of steps, with their bits.
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
        // Answers that break a guarantee: if the machine moves first, the environment needs an
        // input for them.
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

/// Removes unreachable states.
fn trimmed(explicit: &Explicit) -> Explicit {
    let mut numbers: HashMap<usize, usize> = HashMap::new();
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
    Explicit {
        initial: renumber(&explicit.initial),
        states: order
            .iter()
            .map(|s| renumber(&explicit.states[*s]))
            .collect(),
    }
}
