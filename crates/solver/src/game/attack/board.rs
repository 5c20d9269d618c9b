//! The game from the environment's point of view, and the stages in which its winning region grows;
//! [`super`] gives the formula.

use crate::game::arena::{Arena, Formulas, Selection};
use crate::game::set_up::SPLIT;
use crate::symbolic::{Kernel, Limit};
use linewright_core::gr1::Timing;

/// The game from the environment's point of view.
pub(super) struct Board<K: Kernel> {
    /// The game with Mealy timing, so that no inputs are eliminated from the machine's safety.
    pub arena: Arena<K>,
    /// Timing of the specification.
    pub timing: Timing,
    /// The environment's safety, and its invariants and domains in the next step.
    pub environment: K::Function,
    /// The machine's safety, and its invariants and domains in the next step.
    pub answers: K::Function,
}

/// One iteration of the outer fixpoint Z.
pub(super) struct Stage<K: Kernel> {
    /// Z before the iteration.
    pub before: K::Function,
    /// Z after the iteration.
    pub reached: K::Function,
    /// How a goal is withheld from the machine; `None` for a forced step.
    pub starve: Option<StarvationStrategy<K>>,
}

/// How a goal is withheld from the machine.
pub(super) struct StarvationStrategy<K: Kernel> {
    /// Index of the goal.
    pub goal: usize,
    /// For every assumption, the successive Xs of its least fixpoint. From each X, the environment
    /// reaches the previous X, or meets the assumption, or reaches an earlier stage.
    pub layers: Vec<Vec<K::Function>>,
}

impl<K: Kernel> Board<K> {
    /// Builds the game with all formulas.
    pub fn new(formulas: &Formulas<K>, timing: Timing) -> Result<Self, Limit> {
        let arena = formulas.arena_with_timing(&Selection::All, SPLIT, Timing::Mealy)?;
        let m = &arena.kernel;
        Ok(Self {
            environment: arena.environment_moves()?,
            answers: m.and(&arena.system_moves()?, &m.prime(&arena.states)?)?,
            timing,
            arena,
        })
    }

    /// Returns the machine's legal transitions that are not in `target`: (x, y, x′, y′) if the
    /// machine moves first, otherwise the (x, y, x′) after which the machine has such an answer.
    pub fn evasions(&self, target: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        match self.timing {
            Timing::Mealy => m.and_exists(&self.answers, &m.not(target)?, &self.arena.outputs_next),
            Timing::Moore => m.and_not(&self.answers, target),
        }
    }

    /// Returns the environment's moves that force a transition of `target`: (x, y, x′), or (x, y,
    /// y′, x′) if the machine moves first.
    pub fn moves(&self, target: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        m.and_not(&self.environment, &self.evasions(target)?)
    }

    /// Returns `EPre(target)`; see [`super`].
    pub fn predecessor(&self, target: &K::Function) -> Result<K::Function, Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let free = m.not(&self.evasions(target)?)?;
        let some = arena.environment.product(m, &free)?;
        let forced = match self.timing {
            Timing::Mealy => some,
            Timing::Moore => m.forall(&some, &arena.outputs_next)?,
        };
        m.and(&forced, &arena.states)
    }

    /// Returns the environment's choices in step 0 that force the play into `region`: x, or (x, y)
    /// if the machine moves first.
    pub fn winning_starts(&self, region: &K::Function) -> Result<K::Function, Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let escapes = m.and_not(&arena.sys_initial, region)?;
        match self.timing {
            Timing::Mealy => {
                m.and_not(&arena.env_initial, &m.exists(&escapes, &arena.outputs_now)?)
            }
            Timing::Moore => m.and_not(&arena.env_initial, &escapes),
        }
    }

    /// Whether the environment can force the play into `region` in step 0.
    fn wins_initially(&self, region: &K::Function) -> Result<bool, Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let begin = self.winning_starts(region)?;
        Ok(match self.timing {
            Timing::Mealy => !m.is_false(&begin),
            Timing::Moore => {
                let some = m.exists(&begin, &arena.inputs_now)?;
                m.is_true(&m.forall(&some, &arena.outputs_now)?)
            }
        })
    }

    /// Returns the stages up to the first one into which the environment can force the play in step
    /// 0; `None` if the machine wins.
    pub fn stages(&self) -> Result<Option<Vec<Stage<K>>>, Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let mut stages: Vec<Stage<K>> = Vec::new();
        let mut region = m.constant(false);
        loop {
            if self.wins_initially(&region)? {
                return Ok(Some(stages));
            }
            m.safe_point()?;
            let forced = m.or(&region, &self.predecessor(&m.prime(&region)?)?)?;
            if forced != region {
                stages.push(Stage {
                    before: region,
                    reached: forced.clone(),
                    starve: None,
                });
                region = forced;
                continue;
            }
            let mut found = None;
            for goal in 0..arena.goals.len() {
                let kept = self.starve(goal, &region)?;
                if kept.0 != region {
                    found = Some((goal, kept));
                    break;
                }
            }
            let Some((goal, (reached, layers))) = found else {
                return Ok(None);
            };
            stages.push(Stage {
                before: region,
                reached: reached.clone(),
                starve: Some(StarvationStrategy { goal, layers }),
            });
            region = reached;
        }
    }

    /// Returns the states from which the environment can either withhold a goal from the machine
    /// for ever or reach `region`. Also returns the layers for each assumption.
    #[expect(clippy::type_complexity, reason = "a pair of a set and its layers")]
    fn starve(
        &self,
        goal: usize,
        region: &K::Function,
    ) -> Result<(K::Function, Vec<Vec<K::Function>>), Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let mut y = arena.states.clone();
        let goal = m.not(&arena.goals[goal])?;
        loop {
            m.safe_point()?;
            let stay = m.and(&goal, &m.prime(&y)?)?;
            let mut smaller = y.clone();
            let mut all = Vec::new();
            for assumption in &arena.assumptions {
                let mut layers: Vec<K::Function> = Vec::new();
                let mut x = region.clone();
                loop {
                    let near = m.or(assumption, &m.prime(&x)?)?;
                    let target = m.or(&m.prime(region)?, &m.and(&stay, &near)?)?;
                    let more = m.or(&x, &self.predecessor(&target)?)?;
                    if more == x {
                        break;
                    }
                    layers.push(more.clone());
                    x = more;
                    m.safe_point()?;
                }
                smaller = m.and(&smaller, &x)?;
                all.push(layers);
            }
            if smaller == y {
                return Ok((y, all));
            }
            y = smaller;
        }
    }
}
