//! Computes a strategy as functions, for games whose machine is too large to be listed state by
//! state. Each output bit of the next step is a diagram over the values that the machine knows.
//!
//! The strategy pursues one goal after the other, as in Bloem et al. 2012, section 4. It takes a
//! move that reaches the goal and stays in the winning region, or else a move into an earlier
//! layer, or else a move that waits while an assumption fails. The number of the pursued goal is
//! the only memory; a move that reaches the goal switches to the next goal.
//!
//! No relation of all moves is ever built. For every goal, the output bits of the next step are
//! eliminated one after the other, the cheapest bit first. A bit is eliminated only from those
//! parts of the machine's safety and the strategy's target that mention it (bucket elimination;
//! Dechter, "Bucket elimination: a unifying framework for reasoning", Artificial Intelligence 113,
//! 1999). The conjunction of these parts yields the bit's function over the bits that are
//! eliminated later. The later bits only ever get values for which this bit has a suitable value,
//! too, so no backtracking is needed.
//!
//! A [`Certificate`] proves that the functions are correct; `mealy::certify` checks it
//! independently.

use super::arena::Arena;
use super::diagram_builder::{Choices, DiagramBuilder};
use super::fixpoint::{Layer, layers};
use crate::symbolic::{Bit, Diagram, Edge, Kernel, Limit, Limits, Order};
use linewright_core::gr1::{Specification, Timing};
use serde::{Deserialize, Serialize};

/// Node count above which the working storage is emptied between two goals.
const CROWDED_NODES: usize = 1 << 15;

/// A goal with at most this number of layers always gets the modes of [`plan_modes`], never the
/// single mode of [`Plain`].
const FEW_LAYERS: usize = 2;

/// An assumption about a single step, given by its index among the assumptions of its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum AssumedFormula {
    /// An initial condition.
    Initial(usize),
    /// An invariant.
    Invariant(usize),
    /// A safety formula.
    Safety(usize),
}

/// One mode of pursuing a goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// Condition under which the mode is used, unless an earlier mode applies. Over current bits
    /// and, for Mealy, next inputs; `true` for the last mode.
    pub when: Edge,
    /// The output bits of the next step with their functions, in the order of computation: each
    /// function can depend on the bits before it.
    pub outputs: Vec<(Bit, Edge)>,
    /// Progress that the mode's steps make.
    pub aim: Aim,
}

/// Progress that the steps of a mode make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Aim {
    /// Each step reaches the goal.
    Goal,
    /// Each step moves into the layer with this index (see [`Certificate::goals`]), or waits in it
    /// while its assumption fails.
    Layer(usize),
    /// Each step reaches the goal, or moves from its layer to a lower one, or waits in its layer
    /// while the layer's assumption fails.
    Nearer,
}

/// The strategy for one goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoalStrategy {
    /// The modes of pursuing the goal, the best one first.
    pub modes: Vec<Mode>,
    /// Whether a step reaches the goal, so that the next goal is pursued. Over all current and next
    /// bits.
    pub reached: Edge,
}

/// Evidence that the functions are correct: a set of states that the strategy never leaves, and for
/// every goal a list of layers that a play can only descend.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Certificate {
    /// A diagram of the sets of states, over current bits. The edges in the other fields refer to
    /// it.
    pub diagram: Diagram,
    /// The winning region, which the strategy never leaves.
    pub region: Edge,
    /// Layers of every goal, the one nearest to the goal first.
    pub goals: Vec<Vec<CertifiedLayer>>,
}

/// A layer of a goal: the states of `reached` that do not belong to an earlier layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct CertifiedLayer {
    /// The states of this layer and of all layers before it.
    pub reached: Edge,
    /// Index of the justice assumption that fails in every step that stays in the layer.
    pub assumption: usize,
}

/// A strategy as plain data.
///
/// [`Encoding`](crate::symbolic::Encoding) defines the bits. In every step, the inputs and outputs
/// are the *next* bits, even in step 0, which has no predecessor. No goal is pursued in step 0; the
/// first goal is pursued from step 1 on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StrategyFunctions {
    /// The nodes of all functions; without roots.
    pub diagram: Diagram,
    /// The assumptions about step 0, with the functions that check them.
    pub assumed_first: Vec<(AssumedFormula, Edge)>,
    /// The assumptions about later steps, with the functions that check them.
    pub assumed: Vec<(AssumedFormula, Edge)>,
    /// The output bits of step 0 with their functions, as in [`Mode::outputs`].
    pub first: Vec<(Bit, Edge)>,
    /// The strategies for the goals, in the order of pursuit.
    pub goals: Vec<GoalStrategy>,
    /// The variable order in which the functions were computed.
    pub order: Order,
    /// The proof of correctness.
    pub certificate: Certificate,
}

/// Computes a strategy as functions; `region` is the winning region.
pub fn functions<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
) -> Result<StrategyFunctions, Limit> {
    let limits = Limits {
        max_work: None,
        ..arena.kernel.limits()
    };
    functions_for(arena, specification, region, arena.goals.len(), &limits)
}

/// Computes the part of a strategy that pursues the first goal. Its size shows which of two
/// variable orders is better: on the genbuf, AMBA and SYNTECH benchmarks, the order with fewer
/// nodes for the first goal had fewer nodes for all goals.
///
/// # Errors
/// [`Limit::Work`] if it takes more than `work` units of work of the kernel or of a
/// [`DiagramBuilder`].
pub fn first_goal<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
    work: u64,
) -> Result<StrategyFunctions, Limit> {
    let limits = arena.kernel.limits();
    let bounded = arena.with_limits(&Limits {
        max_work: Some(arena.kernel.work() + work),
        ..limits
    });
    let limits = Limits {
        max_work: Some(work),
        ..limits
    };
    functions_for(&bounded, specification, region, 1, &limits)
}

/// Computes the part of a strategy that pursues the first `goals` goals. `limits` are those of each
/// [`DiagramBuilder`].
fn functions_for<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
    goals: usize,
    limits: &Limits,
) -> Result<StrategyFunctions, Limit> {
    let m = &arena.kernel;
    // The order is the same for all goals, so that their functions share nodes.
    m.set_reordering(false);
    let order = m.order();
    let positions = order.positions();
    let mut outputs: Vec<Bit> = arena.outputs_next.iter().collect();
    outputs.sort_unstable_by_key(|b| positions[usize::from(b.pair())]);

    let new_builder = || DiagramBuilder::new(&order, limits);
    let mut work = Work {
        scratch: new_builder(),
        finished: new_builder(),
        parts: Vec::new(),
        outputs,
    };
    let mut states = new_builder();
    let assumed_first = assumed(arena, specification, true, &mut work.finished)?;
    let first = initial(arena, region, &mut work)?;
    work.parts = work.scratch.add(m, &safety(arena, specification)?)?;
    let mut care = region.clone();
    if arena.timing == Timing::Mealy {
        for part in arena.environment.parts() {
            care = m.and(&care, part)?;
        }
    }
    // The kernel works on all goals first, then the builder, so that the nodes of each phase stay
    // in the processor's caches.
    let mut plans = new_builder();
    let mut modes_of_goals = Vec::new();
    let mut stages = Vec::new();
    let mut plain: Option<Plain<K>> = None;
    for j in 0..arena.goals.len().min(goals) {
        let layers = layers(arena, j, region)?;
        let mut nearer = false;
        if may_come_nearer(arena, j, region, &layers, &care)? {
            let plain = match &mut plain {
                Some(plain) => plain,
                none => none.insert(work.plain(arena, region, &care)?),
            };
            nearer = comes_nearer(arena, j, &layers, &plain.steps)?;
        }
        modes_of_goals.push(if nearer {
            None
        } else {
            Some(plan_modes(arena, j, region, &layers, &care, &mut plans)?)
        });
        let edges = states.add(m, layers.iter().map(|l| &l.reached))?;
        let layers = layers
            .iter()
            .zip(edges)
            .map(|(layer, reached)| CertifiedLayer {
                reached,
                assumption: layer.assumption,
            });
        stages.push(layers.collect());
        m.safe_point()?;
    }
    let mut goals = Vec::new();
    for (goal, planned) in arena.goals.iter().zip(modes_of_goals) {
        let modes = match (planned, &plain) {
            (None, Some(plain)) => vec![Mode {
                when: Edge::TRUE,
                outputs: plain.outputs.clone(),
                aim: Aim::Nearer,
            }],
            (planned, _) => work.modes(&mut plans, planned.unwrap_or_default())?,
        };
        let reached = work.finished.add(m, [goal])?[0];
        goals.push(GoalStrategy { modes, reached });
        work.tidy(new_builder)?;
    }
    let assumed = assumed(arena, specification, false, &mut work.finished)?;
    let pairs = arena.encoding.pairs();
    let pairs = order
        .pairs()
        .iter()
        .copied()
        .filter(|p| usize::from(*p) < pairs)
        .collect();
    let region = states.add(m, [region])?[0];
    Ok(StrategyFunctions {
        assumed_first,
        assumed,
        diagram: work.finished.into_diagram(),
        first,
        goals,
        order: Order::new(pairs)
            .expect("the order is not a permutation of the pairs; please report this"),
        certificate: Certificate {
            diagram: states.into_diagram(),
            region,
            goals: stages,
        },
    })
}

/// Returns the assumptions about step 0 if `first`, otherwise those about later steps, each with
/// its function. Omits assumptions that are constantly true.
fn assumed<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    first: bool,
    kept: &mut DiagramBuilder,
) -> Result<Vec<(AssumedFormula, Edge)>, Limit> {
    let m = &arena.kernel;
    let side = &specification.assumptions;
    let mut found = Vec::new();
    let mut add = |what, function: &K::Function| -> Result<(), Limit> {
        if !m.is_true(function) {
            found.push((what, kept.add(m, [function])?[0]));
        }
        Ok(())
    };
    if first {
        for (i, formula) in side.initial.iter().enumerate() {
            let function = arena.encoding.formula(m, &formula.expr)?;
            add(AssumedFormula::Initial(i), &m.prime(&function)?)?;
        }
    }
    for (i, formula) in side.invariants.iter().enumerate() {
        let function = arena.encoding.formula(m, &formula.expr)?;
        add(AssumedFormula::Invariant(i), &m.prime(&function)?)?;
    }
    if !first {
        for (i, formula) in side.safety.iter().enumerate() {
            add(
                AssumedFormula::Safety(i),
                &arena.encoding.formula(m, &formula.expr)?,
            )?;
        }
    }
    Ok(found)
}

/// Computes the outputs of step 0; each bit is 0 where possible.
fn initial<K: Kernel>(
    arena: &Arena<K>,
    region: &K::Function,
    work: &mut Work,
) -> Result<Vec<(Bit, Edge)>, Limit> {
    let m = &arena.kernel;
    let mut good = m.and(&arena.sys_initial, region)?;
    if arena.timing == Timing::Moore {
        good = m.implies_forall(&arena.env_initial, &good, &arena.inputs_now)?;
    }
    let mut rest = work.scratch.add(m, [&m.prime(&good)?])?[0];
    let mut functions = Vec::new();
    for bit in work.outputs.iter().rev() {
        let choices = work.scratch.choices(rest, *bit)?;
        rest = choices.possible;
        let must = work.scratch.and(choices.may_set, choices.forced)?;
        functions.push((*bit, work.scratch.simplify(must, rest)?));
    }
    functions.reverse();
    work.keep(&functions)
}

/// A mode whose output functions are not computed yet.
struct Plan {
    /// Condition on the steps, over all current and next bits.
    aim: Edge,
    /// Where the mode is used: where it is possible and no earlier mode is.
    used: Edge,
    /// Where the mode is possible.
    when: Edge,
    /// Where no earlier mode is possible.
    remaining: Edge,
    /// See [`Mode::aim`].
    achieves: Aim,
}

/// Plans the modes of pursuing goal `j`: reach it, or else move into the lowest possible layer.
///
/// In a state of layer k, the machine can always reach the goal, or move to a lower layer, or stay
/// while the assumption of layer k fails. So the mode depends only on the lowest layer into which a
/// move is possible, not on the layer of the state: either the target layer is lower, or it is the
/// state's own layer and the assumption fails. An assumption about next values depends on the move
/// itself, so its layer needs an additional mode.
///
/// If safety allows only steps that make progress, a single mode without aims suffices: see
/// [`Plain`].
fn plan_modes<K: Kernel>(
    arena: &Arena<K>,
    j: usize,
    region: &K::Function,
    layers: &[Layer<K>],
    care: &K::Function,
    plans: &mut DiagramBuilder,
) -> Result<Vec<Plan>, Limit> {
    let m = &arena.kernel;
    let reach = m.and(&arena.goals[j], &m.prime(region)?)?;
    let yes = m.constant(true);
    let mut aims: Vec<(K::Function, K::Function, Aim)> =
        vec![(yes.clone(), reach.clone(), Aim::Goal)];
    // With Moore timing, the inputs can decide whether a move reaches the goal or the layer.
    let or_reach = |aim: K::Function| match arena.timing {
        Timing::Mealy => Ok(aim),
        Timing::Moore => m.or(&aim, &reach),
    };
    let mut below = m.constant(false);
    for (k, layer) in layers.iter().enumerate() {
        let assumption = &arena.assumptions[layer.assumption];
        let into = m.prime(&layer.reached)?;
        if m.support(assumption).iter().all(|b| *b != b.primed()) {
            aims.push((yes.clone(), or_reach(into)?, Aim::Layer(k)));
        } else {
            let nearer = m.not(&layer.reached)?;
            aims.push((nearer, or_reach(into.clone())?, Aim::Layer(k)));
            let idle = m.and_not(&into, assumption)?;
            let stay = m.or(&idle, &m.prime(&below)?)?;
            aims.push((layer.reached.clone(), or_reach(stay)?, Aim::Layer(k)));
        }
        below = layer.reached.clone();
    }

    let mut todo = care.clone();
    let mut modes = Vec::new();
    for (within, aim, achieves) in aims {
        let aim = match arena.timing {
            Timing::Mealy => aim,
            Timing::Moore => arena.for_all_inputs(&aim)?,
        };
        let when = m.and(&within, &arena.system.product(m, &aim)?)?;
        let left = m.and_not(&todo, &when)?;
        if left == todo {
            continue;
        }
        let used = m.and(&todo, &when)?;
        let remaining = std::mem::replace(&mut todo, left);
        let added = plans.add(m, [&aim, &used, &when, &remaining])?;
        modes.push(Plan {
            aim: added[0],
            used: added[1],
            when: added[2],
            remaining: added[3],
            achieves,
        });
        if m.is_false(&todo) {
            break;
        }
    }
    Ok(modes)
}

/// Functions that merely keep the play in the region, and the steps that they take. If all these
/// steps make progress toward a goal, these functions form the only mode of the goal.
struct Plain<K: Kernel> {
    outputs: Vec<(Bit, Edge)>,
    steps: K::Function,
}

/// Whether, in the layers nearest to goal `j`, every step that safety and the region allow makes
/// progress toward the goal. [`comes_nearer`] checks all layers.
///
/// Returns false for goals about next values, because reaching such a goal is better than making
/// progress, and for Moore machines, because their steps must be right for all inputs.
fn may_come_nearer<K: Kernel>(
    arena: &Arena<K>,
    j: usize,
    region: &K::Function,
    layers: &[Layer<K>],
    care: &K::Function,
) -> Result<bool, Limit> {
    let m = &arena.kernel;
    let goal = &arena.goals[j];
    if layers.len() <= FEW_LAYERS
        || arena.timing == Timing::Moore
        || m.support(goal).iter().any(|b| *b == b.primed())
    {
        return Ok(false);
    }
    let waiting = m.and_not(care, goal)?;
    let kept = m.prime(region)?;
    let mut below = m.constant(false);
    for layer in &layers[..=FEW_LAYERS] {
        let here = m.and_not(&m.and(&waiting, &layer.reached)?, &below)?;
        let away = m.and_not(&kept, &m.prime(&below)?)?;
        let idle = m.and_not(
            &m.prime(&layer.reached)?,
            &arena.assumptions[layer.assumption],
        )?;
        let wrong = m.and(&here, &m.and_not(&away, &idle)?)?;
        if !m.is_false(&arena.system.product(m, &wrong)?) {
            return Ok(false);
        }
        below = layer.reached.clone();
    }
    Ok(true)
}

/// Whether all of `steps` make progress toward goal `j`; see [`Aim::Nearer`].
fn comes_nearer<K: Kernel>(
    arena: &Arena<K>,
    j: usize,
    layers: &[Layer<K>],
    steps: &K::Function,
) -> Result<bool, Limit> {
    let m = &arena.kernel;
    let mut left = m.and_not(steps, &arena.goals[j])?;
    let mut below = m.constant(false);
    for layer in layers {
        let here = m.and(&left, &layer.reached)?;
        let away = m.and_not(&here, &m.prime(&below)?)?;
        let idle = m.and_not(
            &m.prime(&layer.reached)?,
            &arena.assumptions[layer.assumption],
        )?;
        if !m.is_false(&m.and_not(&away, &idle)?) {
            return Ok(false);
        }
        left = m.and_not(&left, &layer.reached)?;
        below = layer.reached.clone();
    }
    Ok(m.is_false(&left))
}

/// Working storage for functions under construction, and storage for finished ones.
struct Work {
    scratch: DiagramBuilder,
    finished: DiagramBuilder,
    /// The machine's safety, formula by formula.
    parts: Vec<Edge>,
    /// The output bits of the next step, sorted by their position in the order.
    outputs: Vec<Bit>,
}

impl Work {
    /// Copies finished functions to their storage.
    fn keep(&mut self, functions: &[(Bit, Edge)]) -> Result<Vec<(Bit, Edge)>, Limit> {
        let roots: Vec<Edge> = functions.iter().map(|(_, f)| *f).collect();
        let kept = self.finished.copy(&mut self.scratch, &roots)?;
        Ok(functions.iter().map(|(bit, _)| *bit).zip(kept).collect())
    }

    /// Computes the functions that merely keep the play in the region.
    fn plain<K: Kernel>(
        &mut self,
        arena: &Arena<K>,
        region: &K::Function,
        care: &K::Function,
    ) -> Result<Plain<K>, Limit> {
        let m = &arena.kernel;
        let edges = self.scratch.add(m, [&m.prime(region)?, care])?;
        let functions = self.eliminate(edges[0], edges[1])?;
        let roots: Vec<Edge> = functions.iter().map(|(_, f)| *f).collect();
        let mut apart = DiagramBuilder::new(&m.order(), &m.limits());
        let roots = apart.copy(&mut self.scratch, &roots)?;
        let mut diagram = apart.into_diagram();
        diagram.roots = roots;
        let mut steps = care.clone();
        for ((bit, _), function) in functions.iter().zip(m.import(&diagram)?) {
            let same = m.iff(&m.literal(*bit, true), &function)?;
            steps = m.and(&steps, &same)?;
        }
        Ok(Plain {
            outputs: self.keep(&functions)?,
            steps,
        })
    }

    /// Computes the functions of a goal's modes.
    fn modes(
        &mut self,
        plans: &mut DiagramBuilder,
        planned: Vec<Plan>,
    ) -> Result<Vec<Mode>, Limit> {
        let mut modes = Vec::new();
        for plan in planned {
            let edges = [plan.aim, plan.used, plan.when, plan.remaining];
            let edges = self.scratch.copy(plans, &edges)?;
            let functions = self.eliminate(edges[0], edges[1])?;
            let when = self.scratch.simplify(edges[2], edges[3])?;
            modes.push(Mode {
                when: self.finished.copy(&mut self.scratch, &[when])?[0],
                outputs: self.keep(&functions)?,
                aim: plan.achieves,
            });
        }
        match modes.last_mut() {
            Some(last) => last.when = Edge::TRUE,
            // The environment has no move from the region, so any outputs will do.
            None => modes.push(Mode {
                when: Edge::TRUE,
                outputs: self.outputs.iter().map(|b| (*b, Edge::FALSE)).collect(),
                aim: Aim::Goal,
            }),
        }
        Ok(modes)
    }

    /// Empties the working storage, except for the safety, if it has grown large.
    fn tidy(&mut self, fresh: impl FnOnce() -> DiagramBuilder) -> Result<(), Limit> {
        if self.scratch.nodes() > CROWDED_NODES {
            let mut scratch = fresh();
            self.parts = scratch.copy(&mut self.scratch, &self.parts)?;
            self.scratch = scratch;
        }
        Ok(())
    }

    /// Eliminates the output bits from the safety and an aim. The next bit is always the one for
    /// which the parts that mention it have the smallest total size. Returns each bit with a
    /// function for its value. The bits are in reverse order of elimination, so each function
    /// depends only on known values and on bits that come earlier in the result. The functions
    /// matter only where `care` holds.
    fn eliminate(&mut self, aim: Edge, care: Edge) -> Result<Vec<(Bit, Edge)>, Limit> {
        let Self {
            scratch,
            parts,
            outputs,
            ..
        } = self;
        let part = |scratch: &mut DiagramBuilder, f: Edge| {
            let (support, size) = scratch.measure(f, outputs);
            (f, support, size)
        };
        let mut pool = vec![part(scratch, aim)];
        // Parts and buckets are not simplified with `care`: each would be smaller, but they would
        // share fewer nodes with each other and with other goals.
        pool.extend(parts.iter().map(|f| part(scratch, *f)));
        let mut left = outputs.clone();
        let mut functions = Vec::new();
        while !left.is_empty() {
            let cost = |bit: &Bit| {
                let bucket = pool.iter().filter(|(_, support, _)| support.contains(*bit));
                bucket.map(|(_, _, size)| *size).sum::<usize>()
            };
            // Of equally cheap bits, takes the lowest one in the order.
            let place = (0..left.len()).min_by_key(|i| (cost(&left[*i]), std::cmp::Reverse(*i)));
            let bit = left.remove(place.unwrap_or(0));
            let (mut bucket, rest): (Vec<_>, Vec<_>) = pool
                .into_iter()
                .partition(|(_, support, _)| support.contains(bit));
            pool = rest;
            bucket.sort_by_key(|(_, _, size)| *size);
            let mut both = Edge::TRUE;
            for (f, ..) in bucket {
                both = scratch.and(both, f)?;
            }
            let Choices {
                may_set,
                possible,
                forced,
            } = scratch.choices(both, bit)?;
            // Where both values are allowed, the value is chosen to make the function small.
            // Keeping the bit's current value there would make the function two to three times as
            // large.
            let function = scratch.simplify(may_set, forced)?;
            functions.push((bit, scratch.simplify(function, care)?));
            if possible != Edge::TRUE {
                pool.push(part(scratch, possible));
            }
        }
        functions.reverse();
        Ok(functions)
    }
}

/// Returns the conjuncts of the machine's safety; for Moore, with the next inputs eliminated.
fn safety<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
) -> Result<Vec<K::Function>, Limit> {
    let m = &arena.kernel;
    let mut parts = Vec::new();
    let formulas = specification.guarantees.safety.iter();
    for part in formulas.flat_map(|f| f.expr.parts()) {
        let function = arena.encoding.formula(m, &part)?;
        let function = match arena.timing {
            Timing::Mealy => function,
            Timing::Moore => arena.for_all_inputs(&function)?,
        };
        if !m.is_true(&function) {
            parts.push(function);
        }
    }
    Ok(parts)
}
