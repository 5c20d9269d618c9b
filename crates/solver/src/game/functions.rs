//! A strategy as functions: every next output bit as a diagram over the machine's known values, for
//! games whose machine is too large to be written state by state.
//!
//! The strategy pursues one goal after the other, as in Bloem et al. 2012, section 4: a move that
//! reaches the goal and stays in the winning region, or else one into an earlier layer, or else one
//! that waits while an assumption fails. The pursued goal is stored in memory bits; a move that
//! reaches it switches to the next one.
//!
//! No relation of all moves is ever built. For every goal, the next output bits are eliminated from
//! the parts of the machine's safety and the strategy's target one after the other, from the bottom
//! of the order up, each only from the parts that mention it (bucket elimination; Dechter, "Bucket
//! elimination: a unifying framework for reasoning", Artificial Intelligence 113, 1999). The
//! conjunction for a bit yields its function over the bits above it: it keeps its value where it
//! may. Every choice for the bits above can be completed below, so no backtracking is needed.
//!
//! The functions are accompanied by a proof of their correctness: the [`Certificate`] is checked
//! independently (`mealy::certify`).

use super::arena::Arena;
use super::diagram_builder::{Choices, DiagramBuilder};
use super::fixpoint::{Layer, layers};
use crate::symbolic::{Bit, Diagram, Edge, Kernel, Limit, Order};
use linewright_core::gr1::{Specification, Timing};
use serde::{Deserialize, Serialize};

/// Node count at which the builder is emptied between two goals.
const CROWDED_NODES: usize = 1 << 15;

/// Minimum number of layers for which to examine whether one way suffices.
const FEW_LAYERS: usize = 2;

/// An assumption that a step may break.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Assumed {
    /// An initial condition, by index.
    Initial(usize),
    /// An invariant.
    Invariant(usize),
    /// A safety formula.
    Safety(usize),
}

/// One way of pursuing a goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// Condition under which it is taken, unless an earlier mode applies: over current bits, and
    /// for Mealy next inputs. For the last mode it is `true`.
    pub when: Edge,
    /// The next output bits in an order in which they can be computed: each may depend on those
    /// before it.
    pub outputs: Vec<(Bit, Edge)>,
    /// Effect of its steps.
    pub aim: Aim,
}

/// Effect of the steps of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Aim {
    /// They reach the goal.
    Goal,
    /// They move into this layer, an index into [`Certificate::goals`], or wait in it while its
    /// assumption fails.
    Layer(usize),
    /// Each step makes progress by itself: it reaches the goal, or leaves its layer for a lower
    /// one, or waits while the layer's assumption fails.
    Nearer,
}

/// One goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pursuit {
    /// The ways of pursuing it, the best one first.
    pub modes: Vec<Mode>,
    /// Whether a step has reached it, so that the next goal is pursued: over all current and next
    /// bits.
    pub reached: Edge,
}

/// Why the functions are correct: a set that is never left, and for every goal a rank that only
/// decreases.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Certificate {
    /// Functions of states, over current bits.
    pub diagram: Diagram,
    /// The states that are never left.
    pub region: Edge,
    /// For every goal, its layers, the nearest first.
    pub goals: Vec<Vec<Stage>>,
}

/// The states of a layer of a goal: those of `reached` that were not in the layer before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stage {
    /// All states up to this layer.
    pub reached: Edge,
    /// Index of the justice assumption that fails whenever the layer is not left.
    pub assumption: usize,
}

/// A strategy as plain data.
///
/// Bits are laid out as by [`Encoding`](crate::symbolic::Encoding). A step's inputs and outputs are
/// next bits, also in step 0. Step 0 pursues no goal; the first goal is pursued after it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Controls {
    /// The decisions that all functions share; it has no roots of its own.
    pub diagram: Diagram,
    /// Assumptions about step 0.
    pub assumed_first: Vec<(Assumed, Edge)>,
    /// Assumptions about later steps.
    pub assumed: Vec<(Assumed, Edge)>,
    /// Output bits of step 0, as in [`Mode::outputs`].
    pub first: Vec<(Bit, Edge)>,
    /// The goals.
    pub goals: Vec<Pursuit>,
    /// An order of the pairs in which the functions are known to be small.
    pub order: Order,
    /// The proof of correctness.
    pub certificate: Certificate,
}

/// Computes functions for the winning region.
pub fn functions<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
) -> Result<Controls, Limit> {
    let m = &arena.kernel;
    // All goals use one order; otherwise they would share nothing.
    m.set_reordering(false);
    let order = m.order();
    let positions = order.positions();
    let mut outputs: Vec<Bit> = arena.outputs_next.iter().collect();
    outputs.sort_unstable_by_key(|b| positions[usize::from(b.pair())]);

    let limits = m.limits();
    let bench = || DiagramBuilder::new(&order, &limits);
    let mut work = Work {
        bench: bench(),
        kept: bench(),
        parts: Vec::new(),
        outputs,
    };
    let mut states = bench();
    let assumed_first = assumed(arena, specification, true, &mut work.kept)?;
    let first = initial(arena, region, &mut work)?;
    work.parts = work.bench.add(m, &safety(arena, specification)?)?;
    let mut care = region.clone();
    if arena.timing == Timing::Mealy {
        for part in arena.environment.parts() {
            care = m.and(&care, part)?;
        }
    }
    // The kernel's work for all goals comes first, so that both phases find their nodes in the
    // processor's caches.
    let mut plans = bench();
    let mut ways = Vec::new();
    let mut stages = Vec::new();
    let mut plain: Option<Plain<K>> = None;
    for j in 0..arena.goals.len() {
        let layers = layers(arena, j, region)?;
        let mut nearer = false;
        if may_come_nearer(arena, j, region, &layers, &care)? {
            let plain = match &mut plain {
                Some(plain) => plain,
                none => none.insert(work.plain(arena, region, &care)?),
            };
            nearer = comes_nearer(arena, j, &layers, &plain.steps)?;
        }
        ways.push(if nearer {
            None
        } else {
            Some(self::ways(arena, j, region, &layers, &care, &mut plans)?)
        });
        let edges = states.add(m, layers.iter().map(|l| &l.reached))?;
        let layers = layers.iter().zip(edges).map(|(layer, reached)| Stage {
            reached,
            assumption: layer.assumption,
        });
        stages.push(layers.collect());
        m.safe_point()?;
    }
    let mut goals = Vec::new();
    for (goal, ways) in arena.goals.iter().zip(ways) {
        let modes = match (ways, &plain) {
            (None, Some(plain)) => vec![Mode {
                when: Edge::TRUE,
                outputs: plain.outputs.clone(),
                aim: Aim::Nearer,
            }],
            (ways, _) => work.modes(&mut plans, ways.unwrap_or_default())?,
        };
        let reached = work.kept.add(m, [goal])?[0];
        goals.push(Pursuit { modes, reached });
        work.tidy(bench)?;
    }
    let assumed = assumed(arena, specification, false, &mut work.kept)?;
    let pairs = arena.encoding.pairs();
    let pairs = order
        .pairs()
        .iter()
        .copied()
        .filter(|p| usize::from(*p) < pairs)
        .collect();
    let region = states.add(m, [region])?[0];
    Ok(Controls {
        assumed_first,
        assumed,
        diagram: work.kept.into_diagram(),
        first,
        goals,
        order: Order::new(pairs).expect("an order of all pairs; please report this"),
        certificate: Certificate {
            diagram: states.into_diagram(),
            region,
            goals: stages,
        },
    })
}

/// The assumptions about a step.
fn assumed<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    first: bool,
    kept: &mut DiagramBuilder,
) -> Result<Vec<(Assumed, Edge)>, Limit> {
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
            add(Assumed::Initial(i), &m.prime(&function)?)?;
        }
    }
    for (i, formula) in side.invariants.iter().enumerate() {
        let function = arena.encoding.formula(m, &formula.expr)?;
        add(Assumed::Invariant(i), &m.prime(&function)?)?;
    }
    if !first {
        for (i, formula) in side.safety.iter().enumerate() {
            add(
                Assumed::Safety(i),
                &arena.encoding.formula(m, &formula.expr)?,
            )?;
        }
    }
    Ok(found)
}

/// The outputs of step 0. There is no value to keep, so each bit is 0 where possible.
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
    let mut rest = work.bench.add(m, [&m.prime(&good)?])?[0];
    let mut functions = Vec::new();
    for bit in work.outputs.iter().rev() {
        let choices = work.bench.choices(rest, *bit)?;
        rest = choices.possible;
        let must = work.bench.and(choices.may_set, choices.forced)?;
        functions.push((*bit, work.bench.simplify(must, rest)?));
    }
    functions.reverse();
    work.keep(&functions)
}

/// A way of pursuing a goal without functions so far.
struct Way {
    /// Purpose of a step: over all current and next bits.
    aim: Edge,
    /// Where it is taken: it is possible and no earlier way is.
    used: Edge,
    /// Where it is possible.
    when: Edge,
    /// Where no earlier way is possible.
    asked: Edge,
    /// See [`Mode::aim`].
    achieves: Aim,
}

/// The ways of pursuing goal `j`: reach it, or else move into the lowest layer that is possible.
///
/// In a state of layer k the machine can always reach the goal, or move below, or stay within while
/// the layer's assumption fails. If a move into some layer is possible, that layer alone determines
/// the aim, whatever layer the state is in: it is below, or it is the state's own, and then the
/// assumption fails. Only an assumption about next values has to be aimed at, and needs a mode of
/// its own.
///
/// If safety allows only steps that make progress, as in work done piece by piece in some order, no
/// aim is needed, and none of this is: see [`Plain`].
fn ways<K: Kernel>(
    arena: &Arena<K>,
    j: usize,
    region: &K::Function,
    layers: &[Layer<K>],
    care: &K::Function,
    plans: &mut DiagramBuilder,
) -> Result<Vec<Way>, Limit> {
    let m = &arena.kernel;
    let reach = m.and(&arena.goals[j], &m.prime(region)?)?;
    let yes = m.constant(true);
    let mut aims: Vec<(K::Function, K::Function, Aim)> =
        vec![(yes.clone(), reach.clone(), Aim::Goal)];
    // With Moore timing, which of several aims a move achieves may depend on the inputs.
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
    let mut ways = Vec::new();
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
        let asked = std::mem::replace(&mut todo, left);
        let added = plans.add(m, [&aim, &used, &when, &asked])?;
        ways.push(Way {
            aim: added[0],
            used: added[1],
            when: added[2],
            asked: added[3],
            achieves,
        });
        if m.is_false(&todo) {
            break;
        }
    }
    Ok(ways)
}

/// Functions that only stay in the region, and the steps that they take.
struct Plain<K: Kernel> {
    outputs: Vec<(Bit, Edge)>,
    steps: K::Function,
}

/// Whether possibly every step allowed by safety and the region makes progress toward goal `j`:
/// decided only for the layers next to the goal. [`comes_nearer`] decides it for the others.
///
/// Only for goals about current values: if a step may or may not reach the goal, reaching it is
/// better than making progress. And only for Mealy: a Moore machine's step is a step for all
/// inputs.
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

/// Whether all these steps make progress toward goal `j`; see [`Aim::Nearer`].
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

/// Working storage for functions, and the store for finished ones.
struct Work {
    bench: DiagramBuilder,
    kept: DiagramBuilder,
    /// The machine's safety, formula by formula.
    parts: Vec<Edge>,
    /// The next output bits by their position in the order.
    outputs: Vec<Bit>,
}

impl Work {
    /// Stores finished functions.
    fn keep(&mut self, functions: &[(Bit, Edge)]) -> Result<Vec<(Bit, Edge)>, Limit> {
        let roots: Vec<Edge> = functions.iter().map(|(_, f)| *f).collect();
        let kept = self.kept.copy(&mut self.bench, &roots)?;
        Ok(functions.iter().map(|(bit, _)| *bit).zip(kept).collect())
    }

    /// Computes the functions that only stay in the region.
    fn plain<K: Kernel>(
        &mut self,
        arena: &Arena<K>,
        region: &K::Function,
        care: &K::Function,
    ) -> Result<Plain<K>, Limit> {
        let m = &arena.kernel;
        let edges = self.bench.add(m, [&m.prime(region)?, care])?;
        let functions = self.eliminate(edges[0], edges[1])?;
        let roots: Vec<Edge> = functions.iter().map(|(_, f)| *f).collect();
        let mut apart = DiagramBuilder::new(&m.order(), &m.limits());
        let roots = apart.copy(&mut self.bench, &roots)?;
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

    /// Computes the functions of a goal.
    fn modes(&mut self, plans: &mut DiagramBuilder, ways: Vec<Way>) -> Result<Vec<Mode>, Limit> {
        let mut modes = Vec::new();
        for way in ways {
            let edges = [way.aim, way.used, way.when, way.asked];
            let edges = self.bench.copy(plans, &edges)?;
            let functions = self.eliminate(edges[0], edges[1])?;
            let when = self.bench.simplify(edges[2], edges[3])?;
            modes.push(Mode {
                when: self.kept.copy(&mut self.bench, &[when])?[0],
                outputs: self.keep(&functions)?,
                aim: way.achieves,
            });
        }
        match modes.last_mut() {
            Some(last) => last.when = Edge::TRUE,
            // No step can be demanded at all.
            None => modes.push(Mode {
                when: Edge::TRUE,
                outputs: self.outputs.iter().map(|b| (*b, Edge::FALSE)).collect(),
                aim: Aim::Goal,
            }),
        }
        Ok(modes)
    }

    /// Empties the working storage when it has grown large.
    fn tidy(&mut self, fresh: impl FnOnce() -> DiagramBuilder) -> Result<(), Limit> {
        if self.bench.nodes() > CROWDED_NODES {
            let mut bench = fresh();
            self.parts = bench.copy(&mut self.bench, &self.parts)?;
            self.bench = bench;
        }
        Ok(())
    }

    /// Eliminates the outputs from the safety and an aim, always choosing the one with the smallest
    /// parts. Gives for each a function over the others; those eliminated later come first. The
    /// functions matter only where `care` holds.
    fn eliminate(&mut self, aim: Edge, care: Edge) -> Result<Vec<(Bit, Edge)>, Limit> {
        let Self {
            bench,
            parts,
            outputs,
            ..
        } = self;
        let part = |bench: &mut DiagramBuilder, f: Edge| {
            let (support, size) = bench.measure(f, outputs);
            (f, support, size)
        };
        let mut pool = vec![part(bench, aim)];
        // Simplified by `care`, parts and buckets would each be smaller, but share less with each
        // other and with other goals.
        pool.extend(parts.iter().map(|f| part(bench, *f)));
        let mut left = outputs.clone();
        let mut functions = Vec::new();
        while !left.is_empty() {
            let cost = |bit: &Bit| {
                let bucket = pool.iter().filter(|(_, support, _)| support.contains(*bit));
                bucket.map(|(_, _, size)| *size).sum::<usize>()
            };
            // Among equals, the lowest in the order.
            let place = (0..left.len()).min_by_key(|i| (cost(&left[*i]), std::cmp::Reverse(*i)));
            let bit = left.remove(place.unwrap_or(0));
            let (mut bucket, rest): (Vec<_>, Vec<_>) = pool
                .into_iter()
                .partition(|(_, support, _)| support.contains(bit));
            pool = rest;
            bucket.sort_by_key(|(_, _, size)| *size);
            let mut both = Edge::TRUE;
            for (f, ..) in bucket {
                both = bench.and(both, f)?;
            }
            let Choices {
                may_set,
                possible,
                forced,
            } = bench.choices(both, bit)?;
            // Where either value is allowed, it is chosen to make the function small: keeping the
            // bit's value there makes it two to three times as large.
            let function = bench.simplify(may_set, forced)?;
            functions.push((bit, bench.simplify(function, care)?));
            if possible != Edge::TRUE {
                pool.push(part(bench, possible));
            }
        }
        functions.reverse();
        Ok(functions)
    }
}

/// The machine's safety, conjunct by conjunct; for Moore, with the next inputs eliminated.
fn safety<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
) -> Result<Vec<K::Function>, Limit> {
    let m = &arena.kernel;
    let mut parts = Vec::new();
    let formulas = specification.guarantees.safety.iter();
    for part in formulas.flat_map(|f| f.expr.conjuncts()) {
        let function = arena.encoding.formula(m, part)?;
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
