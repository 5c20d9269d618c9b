//! Checks whether a controller that exists only as [`Functions`] keeps its contract: an independent
//! inductive check of its certificate.
//!
//! The functions and the sets of the [`Certificate`](crate::game::Certificate) are built from plain
//! data in a fresh kernel, the specification is encoded anew, and every obligation is one
//! implication between functions. The check is independent of how the game was solved and the
//! functions were chosen; a wrong certificate can only make it fail.
//!
//! - Step 0: for inputs that keep the assumptions, the outputs keep the initial conditions and lie
//!   in the region.
//! - The region lies within the machine's invariants and domains.
//! - Every step from the region, on inputs that keep the assumptions, keeps the machine's safety
//!   and lies in the region.
//! - While a goal is pursued, every step reaches it, or leads to a lower layer, or stays in its
//!   layer while the layer's assumption fails. So a play that never reaches it stays in some layer
//!   for ever, and breaks that layer's assumption. A step that reaches the goal, and no other step,
//!   switches to the next goal.
//! - A step is refused exactly when it breaks an assumption; for Moore, no output depends on the
//!   step's inputs.
//!
//! The steps of a mode are combined into one relation: its condition, conjoined with the functions
//! of all outputs. It is small, since it starts from the relevant states and inputs.

use super::Port;
use super::functions::Functions;
use crate::game::{Aim, Assumed, Limit, Limits};
use crate::symbolic::{Biodivine, Bit, BitSet, Diagram, Edge, Encoding, Kernel, OxiDd};
use linewright_core::gr1::{Expr, Owner, Specification, Time, Timing, VarId};
use std::fmt;
use std::ops::Range;

/// Number of nodes above which functions are checked on the kernel for large games.
const SMALL_NODES: usize = 2_000;

/// A rule that functions break, or that their certificate does not show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The violated clause of the definition.
    pub clause: Clause,
}

/// A clause of the certified property, by the way it can be violated. If a contract's formula is
/// violated, the clause carries its name; the clauses about layers carry the name of the goal.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Clause {
    /// Ports, their bits, timing and the number of goals equal those of the contract.
    Ports,
    /// Diagrams refer only to earlier nodes and existing bits.
    Diagram,
    /// Sets of states depend only on current bits.
    SetOfStates,
    /// A layer waits for an existing assumption.
    LayerAssumption,
    /// An output depends only on values known when it is computed.
    OutputKnown,
    /// Only outputs are computed, each once.
    OutputTwice,
    /// Every output is computed.
    OutputMissing,
    /// A mode's condition depends only on values known before the outputs.
    ModeKnown,
    /// A mode leads to an existing layer.
    ModeLayer,
    /// One mode of a goal applies to all states.
    ModeMissing,
    /// An assumption to check depends only on values that the driver knows, and has the name of a
    /// formula.
    AssumptionKnown,
    /// The region lies within the domains; carries the output's name.
    Domain(String),
    /// The region lies within each guaranteed invariant.
    Invariant(String),
    /// Layers lie within each other and the region.
    Layers,
    /// Inputs that keep the assumptions are not refused.
    Refused,
    /// Inputs that break an assumption are refused.
    NotRefused,
    /// Step 0 keeps each initial condition.
    Initial(String),
    /// Step 0 leads into the region.
    Start,
    /// Every step keeps each safety formula.
    Safety(String),
    /// The next goal is pursued exactly after steps that reach this one.
    Reached(String),
    /// A step of a mode that reaches the goal does so, and stays in the region.
    Missed(String),
    /// A step leads into its target layer.
    Strays(String),
    /// A step does not lead back up from below its target layer.
    Back(String),
    /// A step waits only where the layer's assumption fails.
    Waits(String),
    /// A step that must make progress starts in a layer.
    Nowhere(String),
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ports => "the functions are not those of this contract",
            Self::Diagram => "a diagram refers to what does not exist",
            Self::SetOfStates => "a set of states refers to next values",
            Self::LayerAssumption => "a layer waits for an assumption that does not exist",
            Self::OutputKnown => "an output asks for what is not known yet",
            Self::OutputTwice => "an output is computed twice",
            Self::OutputMissing => "an output is not computed",
            Self::ModeKnown => "a mode asks for what is not known yet",
            Self::ModeLayer => "a mode leads to a layer that does not exist",
            Self::ModeMissing => "a goal has no mode for all states",
            Self::AssumptionKnown => "an assumption asks for what is not known yet, or has no name",
            Self::Domain(output) => return write!(f, "`{output}` can leave its domain"),
            Self::Layers => "the layers do not lie within each other",
            Self::Refused => "inputs that keep the assumptions are refused",
            Self::NotRefused => "inputs that break an assumption are not refused",
            Self::Start => "step 0 leads to a state of which nothing is known",
            Self::Invariant(name)
            | Self::Initial(name)
            | Self::Safety(name)
            | Self::Reached(name)
            | Self::Missed(name)
            | Self::Strays(name)
            | Self::Back(name)
            | Self::Waits(name)
            | Self::Nowhere(name) => name,
        })
    }
}

/// Checks functions against their specification.
pub fn certify(
    specification: &Specification,
    functions: &Functions,
    limits: &Limits,
) -> Result<Result<(), Fault>, Limit> {
    if functions.controls.diagram.nodes.len() <= SMALL_NODES {
        certify_on::<Biodivine>(specification, functions, limits)
    } else {
        certify_on::<OxiDd>(specification, functions, limits)
    }
}

/// Checks functions on a kernel.
pub fn certify_on<K: Kernel>(
    specification: &Specification,
    functions: &Functions,
    limits: &Limits,
) -> Result<Result<(), Fault>, Limit> {
    if let Err(fault) = well_formed(specification, functions) {
        return Ok(Err(fault));
    }
    let mut check = Check::<K>::new(specification, functions, limits)?;
    for stage in [Check::region, Check::assumptions, Check::first] {
        if let Err(fault) = stage(&mut check)? {
            return Ok(Err(fault));
        }
    }
    for goal in 0..functions.controls.goals.len() {
        if let Err(fault) = check.goal(goal)? {
            return Ok(Err(fault));
        }
    }
    Ok(Ok(()))
}

fn fault<T>(clause: Clause) -> Result<T, Fault> {
    Err(Fault { clause })
}

/// Whether all references are valid and each function depends only on values already known.
fn well_formed(specification: &Specification, functions: &Functions) -> Result<(), Fault> {
    let encoding = Encoding::new(specification);
    let bits_of = |v: VarId| -> Vec<Bit> { encoding.bits(v, Time::Now).collect() };
    let controls = &functions.controls;
    let pairs = encoding.pairs();
    let bits = 2 * pairs;
    let goals = specification.guarantees.justice.len().max(1);
    let same = |ids: Vec<VarId>, ports: &[Port], port_bits: &[Vec<Bit>]| {
        let variables = ids.iter().map(|v| specification.variable(*v));
        ids.len() == ports.len()
            && variables
                .zip(ports)
                .all(|(v, p)| v.name == p.name && v.domain == p.domain)
            && ids
                .iter()
                .map(|v| bits_of(*v))
                .eq(port_bits.iter().cloned())
    };
    let inputs = specification.inputs().collect();
    let outputs = specification.outputs().collect();
    if !same(inputs, &functions.inputs, &functions.input_bits)
        || !same(outputs, &functions.outputs, &functions.output_bits)
        || functions.timing != specification.timing
        || controls.order.pairs().len() != pairs
        || controls.goals.len() != goals
        || controls.certificate.goals.len() != goals
    {
        return fault(Clause::Ports);
    }
    let assumed = controls.assumed_first.iter().chain(&controls.assumed);
    let modes = || controls.goals.iter().flat_map(|g| &g.modes);
    let outputs = modes().flat_map(|m| &m.outputs).chain(&controls.first);
    let edges = assumed
        .map(|(_, e)| *e)
        .chain(outputs.map(|(_, e)| *e))
        .chain(modes().map(|m| m.when))
        .chain(controls.goals.iter().map(|g| g.reached));
    let sound = |diagram: &Diagram, mut edges: Box<dyn Iterator<Item = Edge> + '_>| {
        diagram.is_sound(bits) && edges.all(|e| e.node().is_none_or(|n| n < diagram.nodes.len()))
    };
    let ranks = controls
        .certificate
        .goals
        .iter()
        .flatten()
        .map(|r| r.reached);
    let sets = ranks.chain([controls.certificate.region]);
    if !sound(&controls.diagram, Box::new(edges))
        || !sound(&controls.certificate.diagram, Box::new(sets.clone()))
    {
        return fault(Clause::Diagram);
    }
    let states = Supports::new(&controls.certificate.diagram, bits);
    if !sets
        .clone()
        .all(|set| states.of(set).all(|b| b != b.primed()))
    {
        return fault(Clause::SetOfStates);
    }
    let assumptions = specification.assumptions.justice.len().max(1);
    let mut ranks = controls.certificate.goals.iter().flatten();
    if ranks.any(|r| r.assumption >= assumptions) {
        return fault(Clause::LayerAssumption);
    }

    let supports = Supports::new(&controls.diagram, bits);
    let set = |owner: Owner, time: Time| {
        let variables = specification.variables.iter().enumerate();
        let owned = variables.filter(|(_, v)| v.owner == owner);
        encoding.bit_set(owned.map(|(i, _)| VarId(i as u32)), time)
    };
    let next_inputs = set(Owner::Environment, Time::Next);
    let next_outputs = set(Owner::System, Time::Next);
    let current: Vec<Bit> = (0..pairs).map(|p| Bit(2 * p as u16)).collect();
    let known = |first: bool| {
        let mut known = BitSet::default();
        if !first {
            for bit in &current {
                known.insert(*bit);
            }
        }
        if specification.timing == Timing::Mealy {
            for bit in next_inputs.iter() {
                known.insert(bit);
            }
        }
        known
    };
    let computed = |outputs: &[(Bit, Edge)], mut known: BitSet| {
        let mut count = 0;
        for (bit, edge) in outputs {
            if !supports.of(*edge).all(|b| known.contains(b)) {
                return fault(Clause::OutputKnown);
            }
            if !next_outputs.contains(*bit) || known.contains(*bit) {
                return fault(Clause::OutputTwice);
            }
            known.insert(*bit);
            count += 1;
        }
        if count == next_outputs.iter().count() {
            Ok(())
        } else {
            fault(Clause::OutputMissing)
        }
    };
    computed(&controls.first, known(true))?;
    for (goal, ranks) in controls.goals.iter().zip(&controls.certificate.goals) {
        for mode in &goal.modes {
            if !supports.of(mode.when).all(|b| known(false).contains(b)) {
                return fault(Clause::ModeKnown);
            }
            if matches!(mode.aim, Aim::Layer(k) if k >= ranks.len()) {
                return fault(Clause::ModeLayer);
            }
            computed(&mode.outputs, known(false))?;
        }
        if goal.modes.last().is_none_or(|m| m.when != Edge::TRUE) {
            return fault(Clause::ModeMissing);
        }
    }
    let inputs_only = |first: bool, list: &[(Assumed, Edge)]| {
        list.iter().all(|(_, edge)| {
            let mut signals = supports.of(*edge);
            signals.all(|b| next_inputs.contains(b) || (!first && b != b.primed()))
        })
    };
    let side = &specification.assumptions;
    let named = |list: &[(Assumed, Edge)], names: &[String]| {
        let name = |(assumed, _): &(Assumed, Edge)| match assumed {
            Assumed::Initial(i) => side.initial.get(*i).map(|f| &f.name),
            Assumed::Invariant(i) => side.invariants.get(*i).map(|f| &f.name),
            Assumed::Safety(i) => side.safety.get(*i).map(|f| &f.name),
        };
        list.iter().map(name).eq(names.iter().map(Some))
    };
    if !inputs_only(true, &controls.assumed_first)
        || !inputs_only(false, &controls.assumed)
        || !named(&controls.assumed_first, &functions.names_first)
        || !named(&controls.assumed, &functions.names)
    {
        return fault(Clause::AssumptionKnown);
    }
    Ok(())
}

/// The bits that each node of a diagram depends on.
struct Supports {
    words: usize,
    masks: Vec<u64>,
}

impl Supports {
    fn new(diagram: &Diagram, bits: usize) -> Self {
        let words = bits.div_ceil(64);
        let mut masks: Vec<u64> = Vec::with_capacity(words * diagram.nodes.len());
        for (i, node) in diagram.nodes.iter().enumerate() {
            masks.resize(words * (i + 1), 0);
            for child in [node.high, node.low].into_iter().filter_map(Edge::node) {
                for w in 0..words {
                    masks[words * i + w] |= masks[words * child + w];
                }
            }
            masks[words * i + node.bit.index() / 64] |= 1 << (node.bit.index() % 64);
        }
        Self { words, masks }
    }

    fn of(&self, edge: Edge) -> impl Iterator<Item = Bit> {
        let range = edge
            .node()
            .map_or(0..0, |n| n * self.words..(n + 1) * self.words);
        let words = self.masks[range].iter().enumerate();
        words.flat_map(|(w, mask)| {
            let bits = (0..64).filter(move |b| mask >> b & 1 == 1);
            bits.map(move |b| Bit((64 * w + b) as u16))
        })
    }
}

/// Node count up to which formulas of the machine's safety are combined.
const CLUSTER_NODES: usize = 3_000;

/// Node count up to which outputs are combined.
const OUTPUT_NODES: usize = 500;

struct Check<'a, K: Kernel> {
    specification: &'a Specification,
    functions: &'a Functions,
    encoding: Encoding,
    kernel: K,
    /// Functions by node of the diagram.
    nodes: Vec<K::Function>,
    region: K::Function,
    /// For every goal, its layers.
    layers: Vec<Vec<K::Function>>,
    /// Moves of the environment in step 0, over next bits.
    may_begin: Vec<K::Function>,
    /// Moves of the environment in later steps.
    may_do: Vec<K::Function>,
    /// The machine's safety: single formulas by index, and conjunctions of several with their
    /// indices.
    safety: Vec<K::Function>,
    clusters: Vec<(K::Function, Range<usize>)>,
    assumptions: Vec<K::Function>,
    goals: Vec<K::Function>,
}

/// Result of a stage.
type StageResult = Result<Result<(), Fault>, Limit>;

impl<'a, K: Kernel> Check<'a, K> {
    fn new(
        specification: &'a Specification,
        functions: &'a Functions,
        limits: &Limits,
    ) -> Result<Self, Limit> {
        let controls = &functions.controls;
        let encoding = Encoding::new(specification);
        let m = K::new(&controls.order, limits)?;
        // The order that comes with the functions is good.
        m.set_reordering(false);
        let mut all = controls.diagram.clone();
        all.roots = (0..all.nodes.len()).map(Edge::to).collect();
        let nodes = m.import(&all)?;
        drop(all);

        let mut sets = controls.certificate.diagram.clone();
        let ranks = controls
            .certificate
            .goals
            .iter()
            .flat_map(|list| list.iter().map(|r| r.reached));
        sets.roots = ranks.chain([controls.certificate.region]).collect();
        let mut sets = m.import(&sets)?.into_iter();
        let layers = controls.certificate.goals.iter();
        let layers = layers
            .map(|list| sets.by_ref().take(list.len()).collect())
            .collect();
        let region = sets.next().expect("a root each; please report this");

        let side = &specification.assumptions;
        let mut legal = Vec::new();
        for input in specification.inputs() {
            legal.push(encoding.in_domain(&m, input, Time::Next)?);
        }
        for formula in &side.invariants {
            legal.push(m.prime(&encoding.formula(&m, &formula.expr)?)?);
        }
        let mut may_begin = legal.clone();
        for formula in &side.initial {
            may_begin.push(m.prime(&encoding.formula(&m, &formula.expr)?)?);
        }
        let mut may_do = legal;
        for formula in &side.safety {
            may_do.push(encoding.formula(&m, &formula.expr)?);
        }
        let mut safety = Vec::new();
        let mut clusters: Vec<(K::Function, Range<usize>)> = Vec::new();
        for (i, formula) in specification.guarantees.safety.iter().enumerate() {
            let function = encoding.formula(&m, &formula.expr)?;
            if let Some((last, places)) = clusters.last_mut()
                && m.size(last) + m.size(&function) <= CLUSTER_NODES
            {
                *last = m.and(last, &function)?;
                places.end += 1;
            } else {
                clusters.push((function.clone(), i..i + 1));
            }
            safety.push(function);
        }
        let justice =
            |formulas: &[linewright_core::gr1::Formula]| -> Result<Vec<K::Function>, Limit> {
                if formulas.is_empty() {
                    return Ok(vec![encoding.formula(&m, &Expr::TRUE)?]);
                }
                formulas
                    .iter()
                    .map(|f| encoding.formula(&m, &f.expr))
                    .collect()
            };
        Ok(Self {
            assumptions: justice(&side.justice)?,
            goals: justice(&specification.guarantees.justice)?,
            specification,
            functions,
            encoding,
            nodes,
            region,
            layers,
            may_begin,
            may_do,
            safety,
            clusters,
            kernel: m,
        })
    }

    fn at(&self, edge: Edge) -> Result<K::Function, Limit> {
        match edge.node() {
            None => Ok(self.kernel.constant(edge.is_negated())),
            Some(n) if edge.is_negated() => self.kernel.not(&self.nodes[n]),
            Some(n) => Ok(self.nodes[n].clone()),
        }
    }

    /// Whether something can happen while the environment keeps its promises.
    fn possible(&self, what: K::Function, promises: &[K::Function]) -> Result<bool, Limit> {
        let mut left = what;
        for promise in promises {
            if self.kernel.is_false(&left) {
                return Ok(false);
            }
            left = self.kernel.and(&left, promise)?;
        }
        Ok(!self.kernel.is_false(&left))
    }

    /// The steps that start here, as a relation. Several small outputs are combined before they are
    /// conjoined with the many states, so that the large relation is rebuilt only a few times.
    fn steps(&self, from: K::Function, outputs: &[(Bit, Edge)]) -> Result<K::Function, Limit> {
        let m = &self.kernel;
        let mut steps = from;
        let mut several = m.constant(true);
        for (bit, edge) in outputs {
            let same = m.iff(&m.literal(*bit, true), &self.at(*edge)?)?;
            several = m.and(&several, &same)?;
            if m.size(&several) > OUTPUT_NODES {
                let large = std::mem::replace(&mut several, m.constant(true));
                steps = m.and(&steps, &large)?;
            }
        }
        m.and(&steps, &several)
    }

    /// The formula of the machine's safety that a step breaks.
    fn broken(&self, steps: &K::Function) -> Result<Option<usize>, Limit> {
        let m = &self.kernel;
        for (cluster, places) in &self.clusters {
            if !m.is_false(&m.and_not(steps, cluster)?) {
                for i in places.clone() {
                    if !m.is_false(&m.and_not(steps, &self.safety[i])?) {
                        return Ok(Some(i));
                    }
                }
            }
        }
        Ok(None)
    }

    /// The region lies within the machine's invariants and domains, and layers lie within each
    /// other and the region.
    fn region(&mut self) -> StageResult {
        let m = &self.kernel;
        let within = |set: &K::Function, bound: &K::Function| -> Result<bool, Limit> {
            Ok(m.is_false(&m.and_not(set, bound)?))
        };
        for output in self.specification.outputs() {
            let domain = self.encoding.in_domain(m, output, Time::Now)?;
            if !within(&self.region, &domain)? {
                let name = &self.specification.variable(output).name;
                return Ok(fault(Clause::Domain(name.clone())));
            }
        }
        for formula in &self.specification.guarantees.invariants {
            if !within(&self.region, &self.encoding.formula(m, &formula.expr)?)? {
                return Ok(fault(Clause::Invariant(formula.name.clone())));
            }
        }
        for layers in &self.layers {
            let bounds = layers.iter().skip(1).chain([&self.region]);
            for (layer, bound) in layers.iter().zip(bounds) {
                if !within(layer, bound)? {
                    return Ok(fault(Clause::Layers));
                }
            }
        }
        Ok(Ok(()))
    }

    /// A step is refused exactly when it breaks an assumption.
    fn assumptions(&mut self) -> StageResult {
        let m = &self.kernel;
        let controls = &self.functions.controls;
        let stages = [
            (&controls.assumed_first, &self.may_begin, m.constant(true)),
            (&controls.assumed, &self.may_do, self.region.clone()),
        ];
        for (assumed, promises, at) in stages {
            let mut asked = Vec::new();
            for (_, edge) in assumed {
                asked.push(self.at(*edge)?);
            }
            for function in asked.iter().filter(|f| !promises.contains(f)) {
                if self.possible(m.and_not(&at, function)?, promises)? {
                    return Ok(fault(Clause::Refused));
                }
            }
            // An input lies in its domain; this is checked earlier.
            for input in self.specification.inputs() {
                asked.push(self.encoding.in_domain(m, input, Time::Next)?);
            }
            for promise in promises.iter().filter(|p| !asked.contains(p)) {
                if self.possible(m.and_not(&at, promise)?, &asked)? {
                    return Ok(fault(Clause::NotRefused));
                }
            }
        }
        Ok(Ok(()))
    }

    /// Step 0 keeps the initial conditions and lies in the region.
    fn first(&mut self) -> StageResult {
        let m = &self.kernel;
        let steps = self.steps(m.all(&self.may_begin)?, &self.functions.controls.first)?;
        for formula in &self.specification.guarantees.initial {
            let function = m.prime(&self.encoding.formula(m, &formula.expr)?)?;
            if !m.is_false(&m.and_not(&steps, &function)?) {
                return Ok(fault(Clause::Initial(formula.name.clone())));
            }
        }
        if !m.is_false(&m.and_not(&steps, &m.prime(&self.region)?)?) {
            return Ok(fault(Clause::Start));
        }
        Ok(Ok(()))
    }

    /// Checks all steps in pursuit of a goal.
    fn goal(&mut self, goal: usize) -> StageResult {
        let m = &self.kernel;
        let pursuit = &self.functions.controls.goals[goal];
        let justice = &self.specification.guarantees.justice;
        let name = justice.get(goal).map_or("true", |f| f.name.as_str());
        let name = || name.to_owned();
        let wrong = m.xor(&self.at(pursuit.reached)?, &self.goals[goal])?;
        let reach = m.and(&self.goals[goal], &m.prime(&self.region)?)?;
        let mut rest = m.and(&self.region, &m.all(&self.may_do)?)?;
        for mode in &pursuit.modes {
            let when = self.at(mode.when)?;
            let steps = self.steps(m.and(&rest, &when)?, &mode.outputs)?;
            rest = m.and_not(&rest, &when)?;
            if let Some(i) = self.broken(&steps)? {
                let broken = &self.specification.guarantees.safety[i];
                return Ok(fault(Clause::Safety(broken.name.clone())));
            }
            if !m.is_false(&m.and(&steps, &wrong)?) {
                return Ok(fault(Clause::Reached(name())));
            }
            let missed = m.and_not(&steps, &reach)?;
            let late = match mode.aim {
                Aim::Goal => (!m.is_false(&missed)).then_some(ProgressFault::Missed),
                Aim::Layer(layer) => self.late(goal, layer, &missed)?,
                Aim::Nearer => self.late_anywhere(goal, &missed)?,
            };
            if let Some(late) = late {
                return Ok(fault(match late {
                    ProgressFault::Missed => Clause::Missed(name()),
                    ProgressFault::Strays => Clause::Strays(name()),
                    ProgressFault::Back => Clause::Back(name()),
                    ProgressFault::Waits => Clause::Waits(name()),
                    ProgressFault::Nowhere => Clause::Nowhere(name()),
                }));
            }
            m.safe_point()?;
        }
        Ok(Ok(()))
    }

    /// Problem with one of the steps: it neither makes progress from its starting layer, nor waits
    /// in it where it may.
    fn late_anywhere(
        &self,
        goal: usize,
        steps: &K::Function,
    ) -> Result<Option<ProgressFault>, Limit> {
        let m = &self.kernel;
        let stages = &self.functions.controls.certificate.goals[goal];
        let mut below = m.constant(false);
        let mut rest = steps.clone();
        for (reached, stage) in self.layers[goal].iter().zip(stages) {
            let here = m.and(&rest, reached)?;
            rest = m.and_not(&rest, reached)?;
            let kept = m.and_not(&here, &m.prime(&below)?)?;
            let waits = m.and(&kept, &m.prime(reached)?)?;
            if !m.is_false(&m.and(&waits, &self.assumptions[stage.assumption])?) {
                return Ok(Some(ProgressFault::Waits));
            }
            if waits != kept {
                return Ok(Some(ProgressFault::Strays));
            }
            below = reached.clone();
        }
        Ok((!m.is_false(&rest)).then_some(ProgressFault::Nowhere))
    }

    /// Problem with one of the steps: it neither makes progress toward the goal nor waits where it
    /// may. A step that leaves the region strays.
    fn late(
        &self,
        goal: usize,
        layer: usize,
        steps: &K::Function,
    ) -> Result<Option<ProgressFault>, Limit> {
        let m = &self.kernel;
        let layers = &self.layers[goal];
        let reached = &layers[layer];
        let below = match layer.checked_sub(1) {
            Some(below) => layers[below].clone(),
            None => m.constant(false),
        };
        let assumption = self.functions.controls.certificate.goals[goal][layer].assumption;
        // From above, all moves into the layer are correct; from within, all moves below it and
        // those that wait. The set of correct steps is never built: sets of states are combined
        // first, and only the wrong steps are computed. Once none of them starts below the layer,
        // those that start in it are all that it has reached.
        if !m.is_false(&m.and_not(steps, &m.prime(reached)?)?) {
            return Ok(Some(ProgressFault::Strays));
        }
        if !m.is_false(&m.and(steps, &below)?) {
            return Ok(Some(ProgressFault::Back));
        }
        let wakes = m.and(reached, &self.assumptions[assumption])?;
        let stays = m.and_not(&m.and(steps, &wakes)?, &m.prime(&below)?)?;
        Ok((!m.is_false(&stays)).then_some(ProgressFault::Waits))
    }
}

/// Problem with a step toward a goal: see the [clauses](Clause) of these names.
enum ProgressFault {
    Missed,
    Strays,
    Back,
    Waits,
    Nowhere,
}
