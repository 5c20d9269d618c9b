//! From the stages of a lost game to a function: what the environment gives, by state and pursued
//! assumption.
//!
//! In a forced step it moves into the stage below. Where it withholds a goal from the machine, it
//! moves into the layer below for the pursued assumption; when that assumption's justice is met, it
//! pursues the next one. Among several moves it takes the one that changes the fewest inputs, one
//! input after the other; otherwise the smallest values.

use super::board::{Board, Stage};
use crate::symbolic::{BitSet, Kernel, Limit};
use linewright_core::gr1::{Specification, Time};

/// A deterministic counterstrategy.
pub struct Strategy<K: Kernel> {
    /// For every assumption that may be pursued, the moves: (x, y, x′), or (x, y, y′, x′) if the
    /// machine moves first.
    pub moves: Vec<K::Function>,
    /// For each assumption, the transitions after which the next one is pursued.
    pub met: Vec<K::Function>,
    /// Moves in step 0, over current bits: x, or (x, y) if the machine moves first.
    pub initial: K::Function,
}

impl<K: Kernel> Strategy<K> {
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
        let begin = board.beginnings(&region)?;
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

    /// The assumption pursued after the one that was met.
    pub fn after(&self, aim: usize) -> usize {
        (aim + 1) % self.moves.len()
    }
}

impl<K: Kernel> Stage<K> {
    /// The moves from the states `fresh` of this stage that make progress.
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

/// Restricts the relation to moves that satisfy `wish` wherever there is one.
fn prefer<K: Kernel>(
    board: &Board<K>,
    relation: &K::Function,
    wish: &K::Function,
    chosen: &BitSet,
) -> Result<K::Function, Limit> {
    let m = &board.arena.kernel;
    let wished = m.and(relation, wish)?;
    let possible = m.exists(&wished, chosen)?;
    m.or(&wished, &m.and_not(relation, &possible)?)
}
