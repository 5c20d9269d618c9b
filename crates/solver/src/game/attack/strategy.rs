//! Computes a deterministic counterstrategy from the stages of a lost game: the inputs that the
//! environment gives, by state and pursued assumption.
//!
//! In a stage with a forced step, the environment moves into an earlier stage. In a stage that
//! withholds a goal from the machine, it moves into an earlier layer of the pursued assumption;
//! when that assumption is met, it pursues the next one. Of several moves, it prefers those that
//! keep the value of an input, one input after the other, and then those with the smallest values.

use super::board::{Board, Stage};
use crate::symbolic::{BitSet, Kernel, Limit};
use linewright_core::gr1::{Specification, Time};

/// A deterministic counterstrategy.
pub struct Strategy<K: Kernel> {
    /// For each assumption that can be pursued, the moves: (x, y, x′), or (x, y, y′, x′) if the
    /// machine moves first.
    pub moves: Vec<K::Function>,
    /// For each assumption, the transitions that meet it. After such a transition, the next
    /// assumption is pursued.
    pub met: Vec<K::Function>,
    /// Moves in step 0, over current bits: x, or (x, y) if the machine moves first.
    pub initial: K::Function,
}

impl<K: Kernel> Strategy<K> {
    /// Computes the counterstrategy from all stages.
    pub fn new(
        board: &Board<K>,
        specification: &Specification,
        stages: &[Stage<K>],
    ) -> Result<Self, Limit> {
        let (arena, m) = (&board.arena, &board.arena.kernel);
        let starves = stages.iter().any(|s| s.starve.is_some());
        let aims = if starves { arena.assumptions.len() } else { 1 };
        let mut moves = Vec::new();
        for aim in 0..aims {
            let mut relation = m.constant(false);
            for stage in stages {
                let fresh = m.and_not(&stage.reached, &stage.before)?;
                relation = m.or(&relation, &stage.moves(board, aim, &fresh)?)?;
            }
            moves.push(choose(board, specification, relation)?);
        }
        let region = match stages.last() {
            Some(stage) => stage.reached.clone(),
            None => m.constant(false),
        };
        let begin = board.winning_starts(&region)?;
        Ok(Self {
            moves,
            met: if starves {
                arena.assumptions.clone()
            } else {
                vec![m.constant(false)]
            },
            initial: smallest(board, specification, begin, Time::Now)?,
        })
    }

    /// Returns the assumption that is pursued once `aim` has been met.
    pub fn after(&self, aim: usize) -> usize {
        (aim + 1) % self.moves.len()
    }
}

impl<K: Kernel> Stage<K> {
    /// Returns the moves from the states `fresh` of this stage that make progress while assumption
    /// `aim` is pursued.
    fn moves(
        &self,
        board: &Board<K>,
        aim: usize,
        fresh: &K::Function,
    ) -> Result<K::Function, Limit> {
        let (arena, m) = (&board.arena, &board.arena.kernel);
        let below = m.prime(&self.before)?;
        let Some(starve) = &self.starve else {
            return m.and(fresh, &board.moves(&below)?);
        };
        let goal = m.not(&arena.goals[starve.goal])?;
        let stay = m.and(&goal, &m.prime(&self.reached)?)?;
        let assumption = &arena.assumptions[aim];
        let mut relation = m.constant(false);
        let mut inner = self.before.clone();
        for layer in &starve.layers[aim] {
            let near = m.or(assumption, &m.prime(&inner)?)?;
            let target = m.or(&below, &m.and(&stay, &near)?)?;
            let here = m.and(fresh, &m.and_not(layer, &inner)?)?;
            relation = m.or(&relation, &m.and(&here, &board.moves(&target)?)?)?;
            inner = layer.clone();
        }
        Ok(relation)
    }
}

/// Restricts moves to one per state: inputs keep their value where possible, and otherwise take the
/// smallest possible value.
fn choose<K: Kernel>(
    board: &Board<K>,
    specification: &Specification,
    mut relation: K::Function,
) -> Result<K::Function, Limit> {
    let (arena, m) = (&board.arena, &board.arena.kernel);
    for input in specification.inputs() {
        let same = arena.encoding.unchanged(m, input)?;
        relation = prefer(board, &relation, &same, &arena.inputs_next)?;
    }
    smallest(board, specification, relation, Time::Next)
}

/// Restricts the relation to the smallest current or next inputs, one input after the other.
fn smallest<K: Kernel>(
    board: &Board<K>,
    specification: &Specification,
    mut relation: K::Function,
    time: Time,
) -> Result<K::Function, Limit> {
    let (arena, m) = (&board.arena, &board.arena.kernel);
    let chosen = match time {
        Time::Now => &arena.inputs_now,
        Time::Next => &arena.inputs_next,
    };
    for input in specification.inputs() {
        for bit in arena.encoding.bits(input, time) {
            relation = prefer(board, &relation, &m.literal(bit, false), chosen)?;
        }
    }
    Ok(relation)
}

/// Restricts the relation to moves that satisfy `preferred`, wherever there are any.
fn prefer<K: Kernel>(
    board: &Board<K>,
    relation: &K::Function,
    preferred: &K::Function,
    chosen: &BitSet,
) -> Result<K::Function, Limit> {
    let m = &board.arena.kernel;
    let satisfying = m.and(relation, preferred)?;
    let possible = m.exists(&satisfying, chosen)?;
    m.or(&satisfying, &m.and_not(relation, &possible)?)
}
