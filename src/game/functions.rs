//! A strategy as functions: every next output bit as a diagram over what the machine knows, for games whose machine is too
//! large to be written down state by state.
//!
//! The strategy pursues one goal after the other, as in Bloem et al. 2012, section 4: a move that reaches the goal and stays
//! in the winning region, or else one into an earlier layer, or else one that waits where an assumption fails. The goal that
//! is pursued is kept in memory bits; a move that reaches it passes on to the next one.
//!
//! No relation of all moves is ever made. For every goal, the next output bits are eliminated from the parts of the
//! machine's safety and the strategy's target one after the other, from the bottom of the order up, each only from the parts
//! that mention it (bucket elimination; Dechter, "Bucket elimination: a unifying framework for reasoning", Artificial
//! Intelligence 113, 1999). What was conjoined for a bit gives its function over the bits above it: it keeps its value where
//! it may. Whatever is possible for the bits above can be completed below, so that no function has to look back.
//!
//! With the functions goes what shows why they are right: the [`Certificate`] is checked by a path of its own
//! (`mealy::certify`).

use super::arena::Arena;
use super::fixpoint::{Layer, layers};
use crate::gr1::{Specification, Timing};
use crate::symbolic::{Bit, BitSet, Diagram, DiagramNode, Edge, Kernel, Limit, Order};
use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

/// An assumption that a step may break.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Assumed {
    /// An initial condition, by its place.
    Initial(usize),
    /// An invariant.
    Invariant(usize),
    /// A safety formula.
    Safety(usize),
}

/// One way of pursuing a goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// When it is taken, unless an earlier one is: over current bits, and for Mealy next inputs. The last mode's is `true`.
    pub when: Edge,
    /// The next output bits in an order in which they can be computed: each may ask for those before it.
    pub outputs: Vec<(Bit, Edge)>,
    /// The layer it moves into, by its place in [`Certificate::goals`]; `None` when it reaches the goal.
    pub layer: Option<usize>,
}

/// One goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pursuit {
    /// The ways of pursuing it, the best one first.
    pub modes: Vec<Mode>,
    /// Whether a step has reached it, so that the next goal is pursued: over all current and next bits.
    pub reached: Edge,
}

/// Why the functions are right: a set that is never left, and for every goal a rank that only falls.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Certificate {
    /// The functions of states, over current bits.
    pub diagram: Diagram,
    /// The states that are never left.
    pub region: Edge,
    /// For every goal its layers, the nearest first.
    pub goals: Vec<Vec<Stage>>,
}

/// The states of a layer of a goal: those of `reached` that were not in the layer before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stage {
    /// All states up to this layer.
    pub reached: Edge,
    /// The assumption, by its place among the justice, that fails whenever the layer is not left.
    pub assumption: usize,
}

/// A strategy in plain data.
///
/// Bits are laid out as by [`Encoding`](crate::symbolic::Encoding). What a step is given and gives are next bits, in step 0,
/// too; step 0 pursues nothing yet, and the first goal is pursued after it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Controls {
    /// The decisions that all functions share; it has no roots of its own.
    pub diagram: Diagram,
    /// What the assumptions say about step 0.
    pub assumed_first: Vec<(Assumed, Edge)>,
    /// What the assumptions say about a later step.
    pub assumed: Vec<(Assumed, Edge)>,
    /// The output bits of step 0, as [`Mode::outputs`].
    pub first: Vec<(Bit, Edge)>,
    /// The goals.
    pub goals: Vec<Pursuit>,
    /// An order of the pairs in which the functions are known to be small.
    pub order: Order,
    /// Why they are right.
    pub certificate: Certificate,
}

/// Makes functions for the winning region.
pub fn functions<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    region: &K::Function,
) -> Result<Controls, Limit> {
    let m = &arena.kernel;
    // All goals are written down in one order, or they would share nothing.
    m.set_reordering(false);
    let order = m.order();
    let positions = order.positions();
    let mut outputs: Vec<Bit> = arena.outputs_next.iter().collect();
    outputs.sort_unstable_by_key(|b| positions[usize::from(b.pair())]);

    let mut builder = Builder::new(&order);
    let mut states = Builder::new(&order);
    let assumed_first = assumed(arena, specification, true, &mut builder)?;
    let first = initial(arena, region, &outputs, &mut builder)?;
    let parts = safety(arena, specification)?;
    let mut care = region.clone();
    if arena.timing == Timing::Mealy {
        for part in arena.environment.parts() {
            care = m.and(&care, part)?;
        }
    }
    let mut goals = Vec::new();
    let mut ranks = Vec::new();
    for j in 0..arena.goals.len() {
        let layers = layers(arena, j, region)?;
        let modes = modes(arena, j, region, &layers, (&parts, &care), &outputs, &mut builder)?;
        let reached = builder.add(m, [&arena.goals[j]])[0];
        goals.push(Pursuit { modes, reached });
        let edges = states.add(m, layers.iter().map(|l| &l.reached));
        let layers = layers.iter().zip(edges);
        let layers = layers.map(|(layer, reached)| Stage {
            reached,
            assumption: layer.assumption,
        });
        ranks.push(layers.collect());
        m.safe_point()?;
    }
    let pairs = arena.encoding.pairs();
    let order = order.pairs().iter().copied();
    let order = order.filter(|p| usize::from(*p) < pairs).collect();
    let region = states.add(m, [region])[0];
    Ok(Controls {
        assumed_first,
        assumed: assumed(arena, specification, false, &mut builder)?,
        diagram: builder.diagram,
        first,
        goals,
        order: Order::new(order).expect("an order of all pairs; please report this"),
        certificate: Certificate {
            diagram: states.diagram,
            region,
            goals: ranks,
        },
    })
}

/// What the assumptions say about a step.
fn assumed<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    first: bool,
    builder: &mut Builder,
) -> Result<Vec<(Assumed, Edge)>, Limit> {
    let m = &arena.kernel;
    let side = &specification.assumptions;
    let mut found = Vec::new();
    let mut add = |what, function: &K::Function| {
        if !m.is_true(function) {
            found.push((what, builder.add(m, [function])[0]));
        }
    };
    if first {
        for (i, formula) in side.initial.iter().enumerate() {
            let function = arena.encoding.formula(m, &formula.expr)?;
            add(Assumed::Initial(i), &m.prime(&function)?);
        }
    }
    for (i, formula) in side.invariants.iter().enumerate() {
        let function = arena.encoding.formula(m, &formula.expr)?;
        add(Assumed::Invariant(i), &m.prime(&function)?);
    }
    if !first {
        for (i, formula) in side.safety.iter().enumerate() {
            add(Assumed::Safety(i), &arena.encoding.formula(m, &formula.expr)?);
        }
    }
    Ok(found)
}

/// The outputs of step 0. There is no value to keep, so each bit is 0 where it may.
fn initial<K: Kernel>(
    arena: &Arena<K>,
    region: &K::Function,
    outputs: &[Bit],
    builder: &mut Builder,
) -> Result<Vec<(Bit, Edge)>, Limit> {
    let m = &arena.kernel;
    let mut good = m.and(&arena.sys_initial, region)?;
    if arena.timing == Timing::Moore {
        good = m.implies_forall(&arena.env_initial, &good, &arena.inputs_now)?;
    }
    let mut rest = m.prime(&good)?;
    let mut functions = Vec::new();
    for bit in outputs.iter().rev() {
        let low = m.restrict(&rest, &[(*bit, false)])?;
        let high = m.restrict(&rest, &[(*bit, true)])?;
        functions.push(m.not(&low)?);
        rest = m.or(&low, &high)?;
    }
    functions.reverse();
    let edges = builder.add(m, functions.iter());
    Ok(outputs.iter().copied().zip(edges).collect())
}

/// The ways of pursuing goal `j`: reach it, or else move into the lowest layer that is possible.
///
/// In a state of layer k the machine can always reach the goal, or move below, or stay within while the layer's assumption
/// fails. Where a move into some layer is possible, that layer alone says what to aim at, whatever layer the state is in:
/// it is below, or it is the state's own, and then the assumption fails. Only an assumption about next values has to be
/// aimed at, and takes a mode of its own.
fn modes<K: Kernel>(
    arena: &Arena<K>,
    j: usize,
    region: &K::Function,
    layers: &[Layer<K>],
    (parts, care): (&[K::Function], &K::Function),
    outputs: &[Bit],
    builder: &mut Builder,
) -> Result<Vec<Mode>, Limit> {
    let m = &arena.kernel;
    let reach = m.and(&arena.goals[j], &m.prime(region)?)?;
    let yes = m.constant(true);
    let mut aims: Vec<(K::Function, K::Function, Option<usize>)> =
        vec![(yes.clone(), reach.clone(), None)];
    // With Moore timing it may depend on the inputs which of several aims a move achieves.
    let or_reach = |aim: K::Function| match arena.timing {
        Timing::Mealy => Ok(aim),
        Timing::Moore => m.or(&aim, &reach),
    };
    let mut below = m.constant(false);
    for (k, layer) in layers.iter().enumerate() {
        let assumption = &arena.assumptions[layer.assumption];
        let into = m.prime(&layer.reached)?;
        if m.support(assumption).iter().all(|b| *b != b.primed()) {
            aims.push((yes.clone(), or_reach(into)?, Some(k)));
        } else {
            let nearer = m.not(&layer.reached)?;
            aims.push((nearer, or_reach(into.clone())?, Some(k)));
            let idle = m.and_not(&into, assumption)?;
            let stay = m.or(&idle, &m.prime(&below)?)?;
            aims.push((layer.reached.clone(), or_reach(stay)?, Some(k)));
        }
        below = layer.reached.clone();
    }

    let mut todo = care.clone();
    let mut modes = Vec::new();
    for (within, aim, layer) in aims {
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
        let mut care = Care::new(m, &builder.positions, &used);
        let mut all = vec![aim];
        for part in parts {
            let part = care.simplify(m, part)?;
            if !m.is_true(&part) {
                all.push(part);
            }
        }
        let functions = eliminate(m, &all, outputs, &mut care)?;
        let outputs = builder.add_where(m, &functions, &used);
        modes.push(Mode {
            when: builder.add_where(m, &[(Bit(0), when)], &asked)[0].1,
            outputs,
            layer,
        });
        if m.is_false(&todo) {
            break;
        }
    }
    if let Some(last) = modes.last_mut() {
        last.when = Edge::TRUE;
    }
    Ok(modes)
}

/// Eliminates bits from a conjunction of parts, always the one whose parts are smallest, and gives for each a function over
/// the others; those that were eliminated later come first. All that is made is simplified for where it matters.
fn eliminate<K: Kernel>(
    m: &K,
    parts: &[K::Function],
    bits: &[Bit],
    care: &mut Care,
) -> Result<Vec<(Bit, K::Function)>, Limit> {
    let part = |f: K::Function| {
        let support = BitSet::new(m.support(&f));
        let size = m.size(&f);
        (f, support, size)
    };
    let mut parts: Vec<_> = parts.iter().map(|f| part(f.clone())).collect();
    let mut left: Vec<Bit> = bits.to_vec();
    let mut functions = Vec::new();
    while !left.is_empty() {
        let cost = |bit: &Bit| {
            let bucket = parts.iter().filter(|(_, support, _)| support.contains(*bit));
            bucket.map(|(_, _, size)| *size).sum::<usize>()
        };
        // The lowest of the order among equals.
        let place = (0..left.len()).min_by_key(|i| (cost(&left[*i]), std::cmp::Reverse(*i)));
        let bit = left.remove(place.unwrap_or(0));
        let (mut bucket, rest): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|(_, support, _)| support.contains(bit));
        parts = rest;
        bucket.sort_by_key(|(_, _, size)| *size);
        let both = m.all(bucket.iter().map(|(f, ..)| f))?;
        let both = care.simplify(m, &both)?;
        let low = m.restrict(&both, &[(bit, false)])?;
        let high = m.restrict(&both, &[(bit, true)])?;
        let now = m.literal(Bit(bit.0 & !1), true);
        functions.push((bit, m.ite(&now, &high, &m.not(&low)?)?));
        let rest = m.or(&low, &high)?;
        if !m.is_true(&rest) {
            parts.push(part(rest));
        }
    }
    functions.reverse();
    Ok(functions)
}

/// The machine's safety, formula by formula; for Moore, freed of the next inputs.
fn safety<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
) -> Result<Vec<K::Function>, Limit> {
    let m = &arena.kernel;
    let mut parts = Vec::new();
    for formula in &specification.guarantees.safety {
        let function = arena.encoding.formula(m, &formula.expr)?;
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

/// Where functions matter.
struct Care {
    scratch: Builder,
    care: Edge,
    found: Found,
}

impl Care {
    fn new<K: Kernel>(kernel: &K, positions: &[u16], care: &K::Function) -> Self {
        let mut scratch = Builder {
            positions: positions.to_vec(),
            ..Builder::default()
        };
        let care = scratch.add(kernel, [care])[0];
        Self {
            scratch,
            care,
            found: Found::default(),
        }
    }

    /// A function that agrees with `f` where it matters.
    fn simplify<K: Kernel>(&mut self, kernel: &K, f: &K::Function) -> Result<K::Function, Limit> {
        let edge = self.scratch.add(kernel, [f])[0];
        let smaller = self.scratch.restrict(edge, self.care, &mut self.found);
        if self.scratch.size(smaller) >= self.scratch.size(edge) {
            return Ok(f.clone());
        }
        let mut alone = Builder::default();
        let root = alone.copy(&self.scratch.diagram, &[smaller])[0];
        alone.diagram.roots = vec![root];
        let mut functions = kernel.import(&alone.diagram)?;
        Ok(functions.pop().unwrap_or_else(|| f.clone()))
    }
}

/// Collects functions of a kernel in one diagram.
#[derive(Debug, Default)]
struct Builder {
    diagram: Diagram,
    known: FxHashMap<DiagramNode, Edge>,
    /// For every pair its place in the order.
    positions: Vec<u16>,
}

/// What was found by [`Builder::restrict`] and [`Builder::or`].
#[derive(Debug, Default)]
struct Found {
    restricted: FxHashMap<(Edge, Edge), Edge>,
    disjunctions: FxHashMap<(Edge, Edge), Edge>,
}

impl Builder {
    fn new(order: &Order) -> Self {
        Self {
            positions: order.positions(),
            ..Self::default()
        }
    }

    /// Adds functions that matter only where `care` holds.
    fn add_where<K: Kernel>(
        &mut self,
        kernel: &K,
        functions: &[(Bit, K::Function)],
        care: &K::Function,
    ) -> Vec<(Bit, Edge)> {
        let mut scratch = Self {
            positions: self.positions.clone(),
            ..Self::default()
        };
        let edges = scratch.add(kernel, functions.iter().map(|(_, f)| f).chain([care]));
        let (care, edges) = edges.split_last().expect("the care set was added");
        let mut found = Found::default();
        let smaller: Vec<Edge> = edges
            .iter()
            .map(|edge| {
                let smaller = scratch.restrict(*edge, *care, &mut found);
                if scratch.size(smaller) < scratch.size(*edge) { smaller } else { *edge }
            })
            .collect();
        let added = self.copy(&scratch.diagram, &smaller);
        functions.iter().map(|(bit, _)| *bit).zip(added).collect()
    }

    /// Adds the functions of another diagram.
    fn copy(&mut self, diagram: &Diagram, roots: &[Edge]) -> Vec<Edge> {
        let mut needed = vec![false; diagram.nodes.len()];
        for edge in roots {
            if let Some(n) = edge.node() {
                needed[n] = true;
            }
        }
        for n in (0..needed.len()).rev() {
            if needed[n] {
                for edge in [diagram.nodes[n].high, diagram.nodes[n].low] {
                    if let Some(n) = edge.node() {
                        needed[n] = true;
                    }
                }
            }
        }
        let mut edges: Vec<Edge> = Vec::with_capacity(needed.len());
        let at = |edges: &[Edge], edge: Edge| match edge.node() {
            None => edge,
            Some(n) => edges[n].flipped(edge.is_negated()),
        };
        for (node, needed) in diagram.nodes.iter().zip(&needed) {
            let edge = if *needed {
                let (high, low) = (at(&edges, node.high), at(&edges, node.low));
                self.decision(node.bit, high, low)
            } else {
                Edge::FALSE
            };
            edges.push(edge);
        }
        roots.iter().map(|r| at(&edges, *r)).collect()
    }

    /// The number of nodes of a function.
    fn size(&self, root: Edge) -> usize {
        let mut seen = FxHashSet::default();
        let mut stack: Vec<usize> = root.node().into_iter().collect();
        while let Some(n) = stack.pop() {
            if seen.insert(n) {
                let node = self.diagram.nodes[n];
                stack.extend([node.high, node.low].into_iter().filter_map(Edge::node));
            }
        }
        seen.len()
    }

    /// The place of the topmost decision; that of a constant is below all.
    fn level(&self, edge: Edge) -> u32 {
        edge.node().map_or(u32::MAX, |n| {
            let bit = self.diagram.nodes[n].bit;
            2 * u32::from(self.positions[usize::from(bit.pair())]) + u32::from(bit.0 & 1)
        })
    }

    /// Where an edge leads to when the bit at this place is 1, and when it is 0.
    fn cofactors(&self, edge: Edge, level: u32) -> (Edge, Edge) {
        match edge.node() {
            Some(n) if self.level(edge) == level => {
                let node = self.diagram.nodes[n];
                let negate = edge.is_negated();
                (node.high.flipped(negate), node.low.flipped(negate))
            }
            _ => (edge, edge),
        }
    }

    fn bit_of(&self, edge: Edge) -> Option<Bit> {
        edge.node().map(|n| self.diagram.nodes[n].bit)
    }

    fn or(&mut self, a: Edge, b: Edge, found: &mut Found) -> Edge {
        if a == Edge::TRUE || b == Edge::TRUE || a == b.negated() {
            return Edge::TRUE;
        }
        if a == Edge::FALSE || a == b {
            return b;
        }
        if b == Edge::FALSE {
            return a;
        }
        let key = (a.min(b), a.max(b));
        if let Some(known) = found.disjunctions.get(&key) {
            return *known;
        }
        let level = self.level(a).min(self.level(b));
        let top = if self.level(a) == level { a } else { b };
        let bit = self.bit_of(top).expect("a decision, since constants were dealt with");
        let ((a1, a0), (b1, b0)) = (self.cofactors(a, level), self.cofactors(b, level));
        let high = self.or(a1, b1, found);
        let low = self.or(a0, b0, found);
        let result = self.decision(bit, high, low);
        found.disjunctions.insert(key, result);
        result
    }

    /// A function that agrees with `f` where `care` holds, and is likely to be smaller: decisions of which only one side
    /// matters are left out (Coudert and Madre, "A unified framework for the formal verification of sequential circuits",
    /// ICCAD 1990).
    fn restrict(&mut self, f: Edge, care: Edge, found: &mut Found) -> Edge {
        if care == Edge::TRUE || care == Edge::FALSE || f.node().is_none() {
            return f;
        }
        if let Some(known) = found.restricted.get(&(f, care)) {
            return *known;
        }
        let (level, care_level) = (self.level(f), self.level(care));
        let result = if care_level < level {
            let (high, low) = self.cofactors(care, care_level);
            let either = self.or(high, low, found);
            self.restrict(f, either, found)
        } else {
            let bit = self.bit_of(f).expect("a decision, since constants were dealt with");
            let ((f1, f0), (c1, c0)) = (self.cofactors(f, level), self.cofactors(care, level));
            if c1 == Edge::FALSE {
                self.restrict(f0, c0, found)
            } else if c0 == Edge::FALSE {
                self.restrict(f1, c1, found)
            } else {
                let high = self.restrict(f1, c1, found);
                let low = self.restrict(f0, c0, found);
                self.decision(bit, high, low)
            }
        };
        found.restricted.insert((f, care), result);
        result
    }

    /// Adds functions, and gives their edges.
    fn add<'a, K: Kernel>(
        &mut self,
        kernel: &K,
        functions: impl IntoIterator<Item = &'a K::Function>,
    ) -> Vec<Edge> {
        let functions: Vec<&K::Function> = functions.into_iter().collect();
        let exported = kernel.export(&functions);
        self.copy(&exported, &exported.roots)
    }

    /// The edge to a decision. The edge for 1 is never negated, so that a function and its negation are one node.
    fn decision(&mut self, bit: Bit, high: Edge, low: Edge) -> Edge {
        if high == low {
            return high;
        }
        let negate = high.is_negated();
        let node = DiagramNode {
            bit,
            high: high.flipped(negate),
            low: low.flipped(negate),
        };
        let nodes = &mut self.diagram.nodes;
        let edge = *self.known.entry(node).or_insert_with(|| {
            nodes.push(node);
            Edge::to(nodes.len() - 1)
        });
        edge.flipped(negate)
    }
}
