//! How the environment wins a game that the machine loses: the dual of the three-nested fixpoint, with its record.
//!
//! ```text
//! Z = μZ. ⋁ⱼ νY. ⋀ᵢ μX. EPre( Z′ ∨ (¬Gⱼ ∧ Y′ ∧ (Aᵢ ∨ X′)) )
//! ```
//!
//! `EPre` holds the states in which the environment has a legal move after which every legal answer of the machine lies in
//! its argument; none of them being legal counts. The set is the complement of the machine's winning region
//! ([`super::fixpoint`]; after Könighofer, Hofferek and Bloem, "Debugging formal specifications: a practical approach using
//! model-based diagnosis and counterstrategies", STTT 15, 2013). The steps of Z are kept as [`Stage`]s: either one more forced
//! step, or a goal that can be kept from the machine for ever while every assumption's justice is met again and again.
//! The search ends with the first stage from which the environment can begin, so the last stage is as low as can be.

mod explore;
mod play;
mod strategy;

use super::arena::{Arena, Formulas, Selection};
use super::set_up::{self, SPLIT};
use super::{Explicit, GuaranteeRef};
use crate::symbolic::{Kernel, Limit, Limits};
use linewright_core::gr1::{Formula, Specification, Timing};
pub use play::{Ending, Play};

/// A counterstrategy in plain data, and the play that it and a machine that resists as long as it can lead to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attack {
    /// The counterstrategy. Conditions are about the machine's outputs, by their place among them; the `output` of a row is
    /// what the environment gives. Where the environment moves first, all rows of a state give the same.
    pub explicit: Explicit,
    /// A play in which the environment wins as early as it can, and the machine resists as long as it can.
    pub play: Play,
}

/// The counterstrategy of a specification, or `None` if the machine wins.
pub(super) fn attack_on<K: Kernel>(
    specification: &Specification,
    beginning: &[Formula],
    limits: &Limits,
) -> Result<Option<Attack>, Limit> {
    let (formulas, _) = set_up::usual::<K>(specification, limits)?;
    let board = Board::new(&formulas, specification.timing)?;
    let Some(stages) = board.stages()? else {
        return Ok(None);
    };
    let strategy = strategy::Strategy::new(&board, specification, &stages)?;
    let explicit = explore::explore(&board, specification, &strategy, limits)?;
    let m = formulas.kernel();
    let mut begin = m.constant(true);
    for formula in beginning {
        begin = m.and(&begin, &formulas.encoding().formula(m, &formula.expr)?)?;
    }
    let play = play::play(&board, specification, &formulas, &strategy, &stages, &begin)?;
    Ok(Some(Attack { explicit, play }))
}

/// The game as the environment sees it.
pub(super) struct Board<K: Kernel> {
    /// The relations as they are, also for a machine that answers first.
    pub arena: Arena<K>,
    /// Who answers first.
    pub timing: Timing,
    /// The environment's safety, and its invariants and domains of the next step.
    pub environment: K::Function,
    /// The machine's safety, and its invariants and domains of the next step.
    pub answers: K::Function,
}

/// One step of Z.
pub(super) struct Stage<K: Kernel> {
    /// Z before it.
    pub before: K::Function,
    /// Z after it.
    pub reached: K::Function,
    /// The goal that is kept from the machine; `None` for a forced step.
    pub starve: Option<Starve<K>>,
}

/// How a goal is kept from the machine.
pub(super) struct Starve<K: Kernel> {
    /// Which goal.
    pub goal: usize,
    /// For every assumption the Xs of its least fixpoint: from each, the environment comes into the one before, or meets
    /// the assumption.
    pub layers: Vec<Vec<K::Function>>,
}

impl<K: Kernel> Board<K> {
    pub fn new(formulas: &Formulas<K>, timing: Timing) -> Result<Self, Limit> {
        let arena = formulas.arena_of(&Selection::All, SPLIT, Timing::Mealy)?;
        let m = &arena.kernel;
        Ok(Self {
            environment: arena.environment_moves()?,
            answers: m.and(&arena.system_moves()?, &m.prime(&arena.states)?)?,
            timing,
            arena,
        })
    }

    /// The transitions (x, y, x′, y′) that the machine may take and that are not in `target`; for a machine that answers
    /// second, whether it has one (x, y, x′).
    pub fn evasions(&self, target: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        match self.timing {
            Timing::Mealy => m.and_exists(&self.answers, &m.not(target)?, &self.arena.outputs_next),
            Timing::Moore => m.and_not(&self.answers, target),
        }
    }

    /// The environment's moves into `target`: (x, y, x′), or (x, y, y′, x′) where the machine answers first.
    pub fn moves(&self, target: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        m.and_not(&self.environment, &self.evasions(target)?)
    }

    /// `EPre`
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

    /// The environment's choices in step 0 from which it wins in `region`: x, or (x, y) where the machine answers first.
    pub fn beginnings(&self, region: &K::Function) -> Result<K::Function, Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let lost = m.and_not(&arena.sys_initial, region)?;
        match self.timing {
            Timing::Mealy => m.and_not(&arena.env_initial, &m.exists(&lost, &arena.outputs_now)?),
            Timing::Moore => m.and_not(&arena.env_initial, &lost),
        }
    }

    fn wins_initially(&self, region: &K::Function) -> Result<bool, Limit> {
        let (arena, m) = (&self.arena, &self.arena.kernel);
        let begin = self.beginnings(region)?;
        Ok(match self.timing {
            Timing::Mealy => !m.is_false(&begin),
            Timing::Moore => {
                let some = m.exists(&begin, &arena.inputs_now)?;
                m.is_true(&m.forall(&some, &arena.outputs_now)?)
            }
        })
    }

    /// The stages up to the first from which the environment can begin; `None` if there is none.
    fn stages(&self) -> Result<Option<Vec<Stage<K>>>, Limit> {
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
                starve: Some(Starve { goal, layers }),
            });
            region = reached;
        }
    }

    /// The states from which a goal can be kept from the machine for ever, or `region` be reached; with the layers by assumption.
    #[expect(clippy::type_complexity, reason = "a set and its layers")]
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

/// The specification with these of its guarantees only.
pub fn reduced(specification: &Specification, guarantees: &[GuaranteeRef]) -> Specification {
    use super::GuaranteeKind as Kind;
    let all = &specification.guarantees;
    let keep = |kind: Kind, list: &[linewright_core::gr1::Formula]| {
        let list = list.iter().enumerate();
        list.filter(|(index, _)| {
            guarantees.contains(&GuaranteeRef {
                kind,
                index: *index,
            })
        })
        .map(|(_, f)| f.clone())
        .collect()
    };
    Specification {
        guarantees: linewright_core::gr1::Side {
            initial: keep(Kind::Initial, &all.initial),
            invariants: keep(Kind::Invariant, &all.invariants),
            safety: keep(Kind::Safety, &all.safety),
            justice: keep(Kind::Justice, &all.justice),
        },
        ..specification.clone()
    }
}
