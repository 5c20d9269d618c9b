//! Converts a strategy to explicit states with guards, without enumerating valuations of the
//! inputs.
//!
//! Between two steps, the machine has to remember only how it will behave next. So a state *is* the
//! residual function `R(x′, y′, g)`: the strategy for the pursued goal, with the current outputs
//! fixed and the current inputs fixed as far as the strategy depends on them. Equal residuals have
//! identical diagrams. Only those next inputs matter that some reachable valuation of the state
//! allows. Among these, the machine tells apart those that lead to different outputs or to
//! different next residuals. Inputs that affect neither are omitted from the guards. So a guard can
//! also hold on inputs that break an assumption: it describes what the machine checks, not what the
//! environment guarantees.

use super::arena::Arena;
use super::cover::{Condition, Cover};
use super::strategy::Strategy;
use crate::symbolic::{Bit, BitSet, Kernel, Limit, Limits};
use linewright_core::gr1::{Specification, Time, VarId};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// Maximum number of rows.
const MAX_ROWS: usize = 200_000;

/// One row of an explicit strategy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// Disjoint cubes of conditions on the inputs.
    pub cubes: Vec<Vec<Condition>>,
    /// Values of the outputs in the step, in the order of the specification.
    pub output: Vec<i64>,
    /// Index of the next state.
    pub to: usize,
}

/// An explicit strategy. The rows of a state are disjoint and cover all inputs that keep the
/// assumptions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExplicitStrategy {
    /// Rows of step 0.
    pub initial: Vec<Row>,
    /// Rows of each state, for all later steps.
    pub states: Vec<Vec<Row>>,
    /// The goal that the machine pursues in each state: the index of a justice guarantee, or 0 if
    /// there is none. Empty for a strategy of the environment.
    pub goals: Vec<usize>,
}

/// A state: the pursued goal, and the residual strategy.
struct State<K: Kernel> {
    goal: usize,
    residual: K::Function,
    /// Next inputs that keep the assumptions.
    legal: K::Function,
}

/// The states that the machine can enter with one output: disjoint sets of inputs, over *next*
/// bits, each with the index of the state to which these inputs lead.
type Classes<K> = Vec<(<K as Kernel>::Function, usize)>;

/// An output of a step: its values, the bits that encode them, and the states that the machine can
/// enter with it.
type Answer<'a, K> = (Vec<i64>, Vec<(Bit, bool)>, &'a Classes<K>);

struct Explorer<'a, K: Kernel> {
    arena: &'a Arena<K>,
    m: &'a K,
    strategy: &'a Strategy<K>,
    environment: K::Function,
    inputs: Vec<VarId>,
    outputs: Vec<VarId>,
    limits: &'a Limits,
    states: Vec<State<K>>,
    /// Index of each state by goal and residual.
    numbers: FxHashMap<(usize, K::Function), usize>,
    /// States by pursued goal and outputs of the last step.
    classes: FxHashMap<(usize, Vec<i64>), Classes<K>>,
}

/// Converts a strategy to explicit states.
pub fn explore<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    strategy: &Strategy<K>,
    limits: &Limits,
) -> Result<ExplicitStrategy, Limit> {
    let m = &arena.kernel;
    let mut explorer = Explorer {
        arena,
        m,
        strategy,
        environment: arena.environment_moves()?,
        inputs: specification.inputs().collect(),
        outputs: specification.outputs().collect(),
        limits,
        states: Vec::new(),
        numbers: FxHashMap::default(),
        classes: FxHashMap::default(),
    };
    explorer.find_states()?;

    let cover = Cover::new(m, &arena.encoding, specification);
    let mut room = MAX_ROWS;
    let first = m.prime(&strategy.initial)?;
    let legal = m.prime(&arena.env_initial)?;
    let initial = explorer.rows(&first, &legal, None, &cover, &mut room)?;
    let mut states = Vec::new();
    for state in &explorer.states {
        let rows = explorer.rows(
            &state.residual,
            &state.legal,
            Some(state.goal),
            &cover,
            &mut room,
        )?;
        states.push(rows);
    }
    Ok(ExplicitStrategy {
        initial,
        states,
        goals: explorer.states.iter().map(|state| state.goal).collect(),
    })
}

impl<K: Kernel> Explorer<'_, K> {
    /// Fills `states`, `numbers` and `classes` with all reachable states.
    fn find_states(&mut self) -> Result<(), Limit> {
        for goal in 0..self.strategy.moves.len() {
            let reachable = self.strategy.reachable[goal].clone();
            let mut rest = self.m.exists(&reachable, &self.arena.inputs_now)?;
            while let Some(bits) = self.m.witness(&rest) {
                self.limits.check_time()?;
                let output = self.output_of(&bits, Time::Now);
                let fixed = self.assignment(&output, Time::Now);
                rest = self.m.and_not(&rest, &self.cube(&fixed)?)?;

                let residual = self.m.restrict(&self.strategy.moves[goal], &fixed)?;
                let inputs = self.m.restrict(&reachable, &fixed)?;
                let environment = self.m.restrict(&self.environment, &fixed)?;
                let mut classes = Vec::new();
                let anything = self.m.constant(true);
                self.split(
                    goal,
                    &residual,
                    &inputs,
                    &anything,
                    &environment,
                    &mut classes,
                )?;
                for (inputs, _) in &mut classes {
                    *inputs = self.m.prime(inputs)?;
                }
                self.classes.insert((goal, output), classes);
            }
        }
        Ok(())
    }

    /// Splits the set `inputs` of current inputs by the residual to which they lead. `path` holds
    /// the literals fixed so far.
    fn split(
        &mut self,
        goal: usize,
        residual: &K::Function,
        inputs: &K::Function,
        path: &K::Function,
        environment: &K::Function,
        classes: &mut Classes<K>,
    ) -> Result<(), Limit> {
        if self.m.is_false(inputs) {
            return Ok(());
        }
        let bits = self.m.support(residual);
        if let Some(bit) = bits.iter().find(|b| self.arena.inputs_now.contains(**b)) {
            for value in [false, true] {
                let literal = self.m.literal(*bit, value);
                let part = self.m.and(inputs, &literal)?;
                let path = self.m.and(path, &literal)?;
                let fixed = self.m.restrict(residual, &[(*bit, value)])?;
                self.split(goal, &fixed, &part, &path, environment, classes)?;
            }
            return Ok(());
        }
        let legal = self
            .m
            .and_exists(inputs, environment, &self.arena.inputs_now)?;
        let next = self.states.len();
        let number = *self.numbers.entry((goal, residual.clone())).or_insert(next);
        if number == next {
            if next >= MAX_ROWS {
                return Err(Limit::Size);
            }
            self.states.push(State {
                goal,
                residual: residual.clone(),
                legal,
            });
        } else {
            let known = &mut self.states[number].legal;
            *known = self.m.or(known, &legal)?;
        }
        match classes.iter_mut().find(|(_, n)| *n == number) {
            Some((known, _)) => *known = self.m.or(known, path)?,
            None => classes.push((path.clone(), number)),
        }
        Ok(())
    }

    /// Returns the rows of a residual (x′, y′, g) for the legal inputs; `goal` is the pursued goal,
    /// or `None` in step 0. `room` is decremented by the number of cubes.
    fn rows(
        &self,
        residual: &K::Function,
        legal: &K::Function,
        goal: Option<usize>,
        cover: &Cover<'_, K>,
        room: &mut usize,
    ) -> Result<Vec<Row>, Limit> {
        let answers = self.answers(residual, legal, goal)?;
        let mut matters: BTreeSet<Bit> = self.m.support(residual).into_iter().collect();
        for (_, _, classes) in &answers {
            matters.extend(classes.iter().flat_map(|(class, _)| self.m.support(class)));
        }
        let mut idle = BitSet::default();
        for input in &self.inputs {
            let bits: Vec<Bit> = self.arena.encoding.bits(*input, Time::Next).collect();
            if !bits.iter().any(|b| matters.contains(b)) {
                for bit in bits {
                    idle.insert(bit);
                }
            }
        }
        let legal = self.m.exists(legal, &idle)?;

        let mut rows = Vec::new();
        for (output, fixed, classes) in answers {
            let inputs = self.m.restrict(residual, &fixed)?;
            let inputs = self.m.and(&self.forget_flag(&inputs)?, &legal)?;
            for (class, to) in classes {
                let guard = self.m.and(&inputs, class)?;
                if self.m.is_false(&guard) {
                    continue;
                }
                let cubes = cover.cubes(&guard, *room)?;
                *room -= cubes.len();
                rows.push(Row {
                    cubes,
                    output: output.clone(),
                    to: *to,
                });
            }
        }
        Ok(rows)
    }

    /// Returns the outputs of a residual on legal inputs.
    fn answers(
        &self,
        residual: &K::Function,
        legal: &K::Function,
        goal: Option<usize>,
    ) -> Result<Vec<Answer<'_, K>>, Limit> {
        let goals = self.strategy.moves.len();
        let flag = self.strategy.flag;
        let mut rest = self
            .m
            .and_exists(residual, legal, &self.arena.inputs_next)?;
        let mut answers = Vec::new();
        while let Some(bits) = self.m.witness(&rest) {
            self.limits.check_time()?;
            let output = self.output_of(&bits, Time::Next);
            let mut fixed = self.assignment(&output, Time::Next);
            let mut to_goal = 0;
            if let Some(goal) = goal {
                let mut reached = 0;
                for bit in flag {
                    let value = bits[bit.index()];
                    fixed.push((bit, value));
                    reached = 2 * reached + usize::from(value);
                }
                to_goal = (goal + reached) % goals;
            }
            rest = self.m.and_not(&rest, &self.cube(&fixed)?)?;
            let classes = self
                .classes
                .get(&(to_goal, output.clone()))
                .expect("a successor is not among the reachable states; please report this");
            answers.push((output, fixed, classes));
        }
        Ok(answers)
    }

    /// Eliminates the flag. Nothing depends on it in step 0, and it is already fixed in later
    /// steps.
    fn forget_flag(&self, inputs: &K::Function) -> Result<K::Function, Limit> {
        self.m.exists(inputs, &BitSet::new(self.strategy.flag))
    }

    fn output_of(&self, bits: &[bool], time: Time) -> Vec<i64> {
        let outputs = self.outputs.iter();
        outputs
            .map(|v| self.arena.encoding.value(*v, time, bits))
            .collect()
    }

    fn assignment(&self, output: &[i64], time: Time) -> Vec<(Bit, bool)> {
        let pairs = self.outputs.iter().zip(output);
        pairs
            .flat_map(|(v, value)| self.arena.encoding.assignment(*v, time, *value))
            .collect()
    }

    fn cube(&self, fixed: &[(Bit, bool)]) -> Result<K::Function, Limit> {
        let mut cube = self.m.constant(true);
        for (bit, value) in fixed.iter().rev() {
            cube = self.m.and(&cube, &self.m.literal(*bit, *value))?;
        }
        Ok(cube)
    }
}
