//! The three-nested fixpoint of a GR(1) game, and the layers from which a strategy is built.
//!
//! The fixpoint is that of Bloem et al. 2012, section 3, with justice on transitions, so that goals
//! can mention next values:
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. ⋁ᵢ νX. Z ∧ CPre( (Gⱼ ∧ Z′) ∨ Y′ ∨ (¬Aᵢ ∧ X′) )
//! ```
//!
//! `Gⱼ` are the machine's goals, `Aᵢ` the environment's assumptions, `CPre` is
//! [`Arena::controllable_predecessor`]. If no justice formula mentions next values, predecessors of
//! states suffice:
//!
//! ```text
//! Z = νZ. ⋀ⱼ μY. ⋁ᵢ νX. Z ∧ ( (Gⱼ ∧ CPre(Z′)) ∨ CPre(Y′) ∨ (¬Aᵢ ∧ CPre(X′)) )
//! ```
//!
//! The conjunction with Z does not change the result, because the final Z contains all of its
//! layers. It lets every X start from Z instead of from all states. Each goal starts from the Z
//! that the previous goal left. In later rounds for the same goal, each X starts where the X at the
//! same position of the previous round ended (fixpoint recycling; Browne, Clarke, Jha, Long and
//! Marrero, "An improved algorithm for the evaluation of fixpoint expressions", TCS 178, 1997).
//! This is sound because Z only shrinks, and every X with it. While the winning region is computed,
//! nothing else is stored: [`layers`] repeats the two inner fixpoints for the final Z.

use super::arena::Arena;
use super::heuristics::Heuristic;
use super::statistics::Statistics;
use crate::symbolic::{Kernel, Limit};
use std::sync::atomic::{AtomicU64, Ordering};

/// Iteration counts and progress of the fixpoints, readable from other threads.
#[derive(Debug, Default)]
pub struct Iterations {
    /// Outermost iterations, one per goal and round.
    pub outer: AtomicU64,
    /// Middle iterations, one per assumption and round.
    pub middle: AtomicU64,
    /// Innermost iterations.
    pub inner: AtomicU64,
    /// Number of controllable predecessors computed.
    pub predecessors: AtomicU64,
    /// Number of goals.
    pub goals: AtomicU64,
    /// Number of goals in a row that have left the region unchanged.
    pub settled: AtomicU64,
    /// Most recently sampled node count.
    pub nodes: AtomicU64,
}

impl Iterations {
    /// Resets the counts.
    pub fn reset(&self) {
        for counter in [
            &self.outer,
            &self.middle,
            &self.inner,
            &self.predecessors,
            &self.goals,
            &self.settled,
            &self.nodes,
        ] {
            counter.store(0, Ordering::Relaxed);
        }
    }

    /// Writes the counts to the statistics.
    pub fn write_to(&self, statistics: &mut Statistics) {
        statistics.outer = self.outer.load(Ordering::Relaxed);
        statistics.middle = self.middle.load(Ordering::Relaxed);
        statistics.inner = self.inner.load(Ordering::Relaxed);
        statistics.predecessors = self.predecessors.load(Ordering::Relaxed);
        let nodes = self.nodes.load(Ordering::Relaxed);
        statistics.peak_nodes = statistics.peak_nodes.max(nodes);
    }
}

fn count(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}

/// Returns the states from which the machine wins, or `None` if it loses from some initial choice
/// of the environment. The search starts from `within`, which must contain the winning region, or
/// from all states.
pub fn winning_region<K: Kernel>(
    arena: &Arena<K>,
    within: Option<&K::Function>,
    iterations: &Iterations,
) -> Result<Option<K::Function>, Limit> {
    let early = arena.heuristics.has(Heuristic::EarlyStop);
    if early && !arena.wins_initially(&arena.states)? {
        return Ok(None);
    }
    let can_still_win = |z: &K::Function| {
        if early {
            arena.wins_initially(z)
        } else {
            Ok(true)
        }
    };
    let region = Fixpoint::new(arena, iterations).region(within, can_still_win)?;
    Ok(match region {
        Some(z) if arena.wins_initially(&z)? => Some(z),
        _ => None,
    })
}

/// Returns the states from which the machine wins, regardless of the initial states.
pub fn winning_states<K: Kernel>(arena: &Arena<K>) -> Result<K::Function, Limit> {
    let iterations = Iterations::default();
    let region = Fixpoint::new(arena, &iterations).region(None, |_| Ok(true))?;
    Ok(region.unwrap_or_else(|| arena.kernel.constant(false)))
}

/// Data kept between rounds.
struct Fixpoint<'a, K: Kernel> {
    arena: &'a Arena<K>,
    iterations: &'a Iterations,
    /// Whether predecessors of sets of states suffice, instead of predecessors of sets of
    /// transitions.
    by_state: bool,
    /// For every goal, the Xs of its last round, in the order of computation.
    last: Vec<Vec<K::Function>>,
    /// Cache of sets of states with their controllable predecessors, the most recently used last.
    recent: Vec<(K::Function, K::Function)>,
}

/// Number of cached predecessors. The cache is useful for the predecessors of the last Xs (one of
/// them becomes the next Y), of `false`, and of Z.
const CACHED_PREDECESSORS: usize = 16;

impl<'a, K: Kernel> Fixpoint<'a, K> {
    fn new(arena: &'a Arena<K>, iterations: &'a Iterations) -> Self {
        let by_state =
            arena.heuristics.has(Heuristic::StatePredecessors) && arena.has_state_justice();
        Self {
            arena,
            iterations,
            by_state,
            last: vec![Vec::new(); arena.goals.len()],
            recent: Vec::new(),
        }
    }

    /// Computes the outermost fixpoint; returns `None` as soon as `good` returns false for a Z.
    fn region(
        &mut self,
        within: Option<&K::Function>,
        good: impl Fn(&K::Function) -> Result<bool, Limit>,
    ) -> Result<Option<K::Function>, Limit> {
        let m = &self.arena.kernel;
        let goals = self.arena.goals.len();
        let carrying = self.arena.heuristics.has(Heuristic::Carrying);
        let mut z = match within {
            Some(within) => m.and(&self.arena.states, within)?,
            None => self.arena.states.clone(),
        };
        let at = self.iterations;
        at.goals.store(goals as u64, Ordering::Relaxed);
        if self.arena.heuristics.has(Heuristic::SafetyFirst) {
            loop {
                let smaller = m.and(&z, &self.predecessor(&z)?)?;
                if smaller == z {
                    break;
                }
                if !good(&smaller)? {
                    return Ok(None);
                }
                z = smaller;
                m.safe_point()?;
            }
        }
        let mut settled = 0; // Number of goals in a row that have left Z unchanged.
        let mut round = z.clone();
        for (place, j) in self.goal_order().into_iter().enumerate().cycle() {
            count(&self.iterations.outer);
            at.settled.store(settled as u64, Ordering::Relaxed);
            let smaller = self.reach_goal(j, &z, &mut |_, _| ())?;
            if carrying {
                round = smaller;
            } else {
                round = m.and(&round, &smaller)?;
                if place + 1 < goals {
                    continue;
                }
                settled = goals - 1;
            }
            if round == z {
                settled += 1;
                if settled >= goals {
                    break;
                }
            } else {
                if !good(&round)? {
                    return Ok(None);
                }
                z = round.clone();
                settled = 0;
            }
        }
        Ok(Some(z))
    }

    /// Returns the goals in the order of processing.
    fn goal_order(&self) -> Vec<usize> {
        let arena = self.arena;
        let mut order: Vec<usize> = (0..arena.goals.len()).collect();
        if arena.heuristics.has(Heuristic::GoalOrder) {
            order.sort_by_cached_key(|j| arena.kernel.support(&arena.goals[*j]).len());
        }
        order
    }

    /// Computes the middle and inner fixpoints for goal `j`. Calls `found(i, X)` for every X that
    /// adds states to Y, where `i` is the index of the assumption.
    fn reach_goal(
        &mut self,
        j: usize,
        z: &K::Function,
        found: &mut impl FnMut(usize, &K::Function),
    ) -> Result<K::Function, Limit> {
        let arena = self.arena;
        let m = &arena.kernel;
        let assumptions = arena.assumptions.len();
        let goal = &arena.goals[j];
        let at_goal = if self.by_state {
            m.and(goal, &self.predecessor(z)?)?
        } else {
            m.and(goal, &m.prime(z)?)?
        };
        let mut y = m.constant(false);
        let mut idle = 0; // Number of assumptions in a row that added no states.
        for (place, i) in (0..assumptions).cycle().enumerate() {
            count(&self.iterations.middle);
            let progress = if self.by_state {
                m.or(&at_goal, &self.predecessor(&y)?)?
            } else {
                m.or(&at_goal, &m.prime(&y)?)?
            };
            let waiting = m.not(&arena.assumptions[i])?;
            let mut x = self.start(j, place, z)?;
            loop {
                count(&self.iterations.inner);
                let smaller = if m.is_false(&waiting) {
                    if self.by_state {
                        m.and(z, &progress)?
                    } else {
                        m.and(z, &self.predecessor_of_transitions(&progress)?)?
                    }
                } else if self.by_state {
                    let wait = m.and(&waiting, &self.predecessor(&x)?)?;
                    m.and(z, &m.or(&progress, &wait)?)?
                } else {
                    let wait = m.and(&waiting, &m.prime(&x)?)?;
                    let target = m.or(&progress, &wait)?;
                    m.and(z, &self.predecessor_of_transitions(&target)?)?
                };
                if smaller == x {
                    break;
                }
                x = smaller;
                m.safe_point()?;
                if m.is_false(&waiting) {
                    break; // The result does not depend on X.
                }
            }
            if arena.heuristics.has(Heuristic::Recycling) {
                let last = &mut self.last[j];
                match last.get_mut(place) {
                    Some(known) => *known = x.clone(),
                    None => last.push(x.clone()),
                }
            }
            let larger = m.or(&y, &x)?;
            m.safe_point()?;
            if larger == y {
                idle += 1;
                if idle >= assumptions {
                    break;
                }
            } else {
                found(i, &x);
                idle = 0;
                y = larger;
                if y == *z {
                    break; // All states of Z are reached.
                }
            }
        }
        Ok(y)
    }

    /// Returns the start value of the X at a position in a goal's round.
    fn start(&self, j: usize, place: usize, z: &K::Function) -> Result<K::Function, Limit> {
        let arena = self.arena;
        let begin = if arena.heuristics.has(Heuristic::InnerStart) {
            z
        } else {
            &arena.states
        };
        match self.last[j].get(place) {
            Some(known) => arena.kernel.and(begin, known),
            None => Ok(begin.clone()),
        }
    }

    /// Returns the controllable predecessor of a set of states, from the cache if possible.
    fn predecessor(&mut self, states: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        if let Some(place) = self.recent.iter().position(|(s, _)| s == states) {
            self.recent[place..].rotate_left(1);
            return Ok(self.recent[self.recent.len() - 1].1.clone());
        }
        let result = self.predecessor_of_transitions(&m.prime(states)?)?;
        if self.arena.heuristics.has(Heuristic::PredecessorCache) {
            if self.recent.len() >= CACHED_PREDECESSORS {
                self.recent.remove(0);
            }
            self.recent.push((states.clone(), result.clone()));
        }
        Ok(result)
    }

    fn predecessor_of_transitions(&self, target: &K::Function) -> Result<K::Function, Limit> {
        count(&self.iterations.predecessors);
        let nodes = self.arena.kernel.nodes();
        self.iterations.nodes.store(nodes, Ordering::Relaxed);
        self.arena.controllable_predecessor(target)
    }
}

/// One layer of states on the way to a goal.
#[derive(Debug)]
pub struct Layer<K: Kernel> {
    /// Index of the assumption that fails in every step that waits in the layer.
    pub assumption: usize,
    /// The X of this layer: in its states, the machine makes progress or waits while that
    /// assumption fails.
    pub wait: K::Function,
    /// The Y after this layer: the states of this layer and of all layers before it.
    pub reached: K::Function,
}

/// Returns the layers of goal `j` within the winning region, the one nearest to the goal first. A
/// move into an earlier layer is progress.
pub fn layers<K: Kernel>(
    arena: &Arena<K>,
    j: usize,
    region: &K::Function,
) -> Result<Vec<Layer<K>>, Limit> {
    let m = &arena.kernel;
    let iterations = Iterations::default();
    let mut steps = Vec::new();
    Fixpoint::new(arena, &iterations)
        .reach_goal(j, region, &mut |i, x| steps.push((i, x.clone())))?;
    let mut y = m.constant(false);
    let mut layers = Vec::new();
    for (assumption, wait) in steps {
        y = m.or(&y, &wait)?;
        layers.push(Layer {
            assumption,
            wait,
            reached: y.clone(),
        });
    }
    Ok(layers)
}
