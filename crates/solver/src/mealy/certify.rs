//! Checks whether a controller in the form of [`Functions`] keeps its contract: an independent
//! inductive check of its certificate.
//!
//! The functions and the sets of the [`Certificate`](crate::game::Certificate) are built from plain
//! data in a fresh kernel, the specification is encoded anew, and every obligation is one
//! implication between functions. The check does not depend on how the game was solved or the
//! functions were chosen. A wrong certificate can make the check fail, but never makes it accept
//! wrong functions.
//!
//! - Step 0: for inputs that keep the assumptions, the outputs keep the initial conditions and lie
//!   in the region.
//! - The region lies within the machine's invariants and domains.
//! - Every step from the region, on inputs that keep the assumptions, keeps the machine's safety
//!   and leads into the region.
//! - While a goal is pursued, every step reaches the goal, or leads to a lower layer, or stays in
//!   its layer while the layer's assumption fails. So a play that never reaches the goal stays in
//!   some layer for ever, and breaks that layer's assumption. Exactly the steps that reach the goal
//!   switch to the next one.
//! - A step is refused exactly if it breaks an assumption. For Moore, no output depends on the
//!   step's inputs.
//!
//! The steps of a mode form one relation: the mode's condition, conjoined with the functions of all
//! outputs. This relation is small, because it is restricted to the relevant states and inputs from
//! the start.

use super::Port;
use super::functions::Functions;
use crate::game::{Aim, AssumedFormula, Limit, Limits};
use crate::symbolic::{Biodivine, Bit, BitSet, Diagram, Edge, Encoding, Kernel, SharedStore};
use linewright_core::gr1::{Expr, Owner, Specification, Time, Timing, VarId};
use std::fmt;
use std::ops::Range;

/// Functions with more nodes than this are checked on the shared store instead of biodivine's.
const SMALL_NODES: usize = 2_000;

/// A violated clause of the certified property.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The violated clause.
    pub clause: Clause,
}

/// A clause of the certified property.
///
/// The name of a variant names the violation; its documentation states what must hold. Clauses
/// about formulas of the contract carry the name of a violated formula; clauses about layers carry
/// the name of the goal.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Clause {
    /// Ports, their bits, timing and the number of goals equal those of the contract.
    Ports,
    /// Diagrams refer only to earlier nodes and existing bits.
    Diagram,
    /// Sets of states depend only on current bits.
    SetOfStates,
    /// The assumption of every layer exists.
    LayerAssumption,
    /// Every output depends only on values that are known when it is computed.
    OutputDependency,
    /// Only outputs are computed, and none of them twice.
    OutputTwice,
    /// Every output is computed.
    OutputMissing,
    /// The condition of every mode depends only on values that are known before the outputs.
    ModeDependency,
    /// The target layer of every mode exists.
    ModeLayer,
    /// The last mode of every goal applies to all states.
    ModeMissing,
    /// The check of every assumption depends only on current values and next inputs, and names an
    /// existing formula.
    AssumptionCheck,
    /// The region lies within the domains of all outputs; carries the name of an output that can
    /// leave its domain.
    Domain(String),
    /// The region lies within every guaranteed invariant.
    Invariant(String),
    /// Every layer lies within the next one, and the last one within the region.
    Layers,
    /// Inputs that keep the assumptions are not refused.
    LegalInputRefused,
    /// Inputs that break an assumption are refused.
    IllegalInputAccepted,
    /// Step 0 keeps every guaranteed initial condition.
    Initial(String),
    /// Step 0 leads into the region.
    InitialRegion,
    /// Every step keeps every guaranteed safety formula.
    Safety(String),
    /// The next goal is pursued exactly after the steps that reach the pursued goal.
    GoalSwitch(String),
    /// Every step of a mode with [`Aim::Goal`] reaches the goal and leads into the region.
    GoalMissed(String),
    /// Every step that does not reach the goal leads into its target layer.
    LayerMissed(String),
    /// No step starts in a layer below its target layer.
    MovesAway(String),
    /// A step that waits in a layer does so only while the layer's assumption fails.
    UnjustifiedWait(String),
    /// Every step that must make progress starts in some layer.
    OutsideLayers(String),
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ports => "the functions belong to another contract",
            Self::Diagram => "a diagram refers to a node or bit that does not exist",
            Self::SetOfStates => "a set of states refers to next values",
            Self::LayerAssumption => "a layer refers to an assumption that does not exist",
            Self::OutputDependency => "an output depends on a value that is not known yet",
            Self::OutputTwice => "an output is computed twice",
            Self::OutputMissing => "an output is not computed",
            Self::ModeDependency => {
                "the condition of a mode depends on a value that is not known yet"
            }
            Self::ModeLayer => "a mode leads to a layer that does not exist",
            Self::ModeMissing => "the last mode of a goal does not apply to all states",
            Self::AssumptionCheck => {
                "the check of an assumption uses an unknown value or a formula that does not exist"
            }
            Self::Domain(output) => return write!(f, "`{output}` can leave its domain"),
            Self::Layers => "a layer does not lie within the next one or the region",
            Self::LegalInputRefused => "inputs that keep the assumptions are refused",
            Self::IllegalInputAccepted => "inputs that break an assumption are accepted",
            Self::InitialRegion => "step 0 leads out of the certified region",
            Self::Invariant(name)
            | Self::Initial(name)
            | Self::Safety(name)
            | Self::GoalSwitch(name)
            | Self::GoalMissed(name)
            | Self::LayerMissed(name)
            | Self::MovesAway(name)
            | Self::UnjustifiedWait(name)
            | Self::OutsideLayers(name) => name,
        })
    }
}

/// Checks functions against their specification, on a kernel chosen by their size.
pub fn certify(
    specification: &Specification,
    functions: &Functions,
    limits: &Limits,
) -> Result<Result<(), Fault>, Limit> {
    if functions.controls.diagram.nodes.len() <= SMALL_NODES {
        certify_on::<Biodivine>(specification, functions, limits)
    } else {
        certify_on::<SharedStore>(specification, functions, limits)
    }
}

/// Checks functions against their specification on kernel `K`.
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

/// Checks that all references are valid and that each function depends only on values already
/// known.
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
                return fault(Clause::OutputDependency);
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
                return fault(Clause::ModeDependency);
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
    let inputs_only = |first: bool, list: &[(AssumedFormula, Edge)]| {
        list.iter().all(|(_, edge)| {
            let mut signals = supports.of(*edge);
            signals.all(|b| next_inputs.contains(b) || (!first && b != b.primed()))
        })
    };
    let side = &specification.assumptions;
    let named = |list: &[(AssumedFormula, Edge)], names: &[String]| {
        let name = |(assumed, _): &(AssumedFormula, Edge)| match assumed {
            AssumedFormula::Initial(i) => side.initial.get(*i).map(|f| &f.name),
            AssumedFormula::Invariant(i) => side.invariants.get(*i).map(|f| &f.name),
            AssumedFormula::Safety(i) => side.safety.get(*i).map(|f| &f.name),
        };
        list.iter().map(name).eq(names.iter().map(Some))
    };
    if !inputs_only(true, &controls.assumed_first)
        || !inputs_only(false, &controls.assumed)
        || !named(&controls.assumed_first, &functions.names_first)
        || !named(&controls.assumed, &functions.names)
    {
        return fault(Clause::AssumptionCheck);
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

/// Formulas of the machine's safety are combined as long as their node counts add up to at most
/// this number.
const CLUSTER_NODES: usize = 3_000;

/// Outputs are combined until their conjunction has more nodes than this.
const OUTPUT_NODES: usize = 500;

/// A check in progress, with the functions that it uses.
struct Check<'a, K: Kernel> {
    specification: &'a Specification,
    functions: &'a Functions,
    encoding: Encoding,
    kernel: K,
    /// The function of each node of the controller's diagram.
    nodes: Vec<K::Function>,
    region: K::Function,
    /// Layers of every goal.
    layers: Vec<Vec<K::Function>>,
    /// Conjuncts of the environment's moves in step 0, over next bits.
    initial_moves: Vec<K::Function>,
    /// Conjuncts of the environment's moves in later steps.
    later_moves: Vec<K::Function>,
    /// The formulas of the machine's safety.
    safety: Vec<K::Function>,
    /// Conjunctions of consecutive formulas of `safety`, with their indices.
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
        // The order is kept, because the functions are small in the order that comes with them.
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
        let region = sets.next().expect("a root is missing; please report this");

        let side = &specification.assumptions;
        let mut legal = Vec::new();
        for input in specification.inputs() {
            legal.push(encoding.in_domain(&m, input, Time::Next)?);
        }
        for formula in &side.invariants {
            legal.push(m.prime(&encoding.formula(&m, &formula.expr)?)?);
        }
        let mut initial_moves = legal.clone();
        for formula in &side.initial {
            initial_moves.push(m.prime(&encoding.formula(&m, &formula.expr)?)?);
        }
        let mut later_moves = legal;
        for formula in &side.safety {
            later_moves.push(encoding.formula(&m, &formula.expr)?);
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
            initial_moves,
            later_moves,
            safety,
            clusters,
            kernel: m,
        })
    }

    /// Returns the function of an edge of the controller's diagram.
    fn at(&self, edge: Edge) -> Result<K::Function, Limit> {
        match edge.node() {
            None => Ok(self.kernel.constant(edge.is_negated())),
            Some(n) if edge.is_negated() => self.kernel.not(&self.nodes[n]),
            Some(n) => Ok(self.nodes[n].clone()),
        }
    }

    /// Whether some step of `steps` satisfies all `rules`.
    fn possible(&self, steps: K::Function, rules: &[K::Function]) -> Result<bool, Limit> {
        let mut left = steps;
        for rule in rules {
            if self.kernel.is_false(&left) {
                return Ok(false);
            }
            left = self.kernel.and(&left, rule)?;
        }
        Ok(!self.kernel.is_false(&left))
    }

    /// Returns the steps of `from` with the computed outputs, as a relation. Several small outputs
    /// are combined before they are conjoined with `from`, so that the large relation is rebuilt
    /// only a few times.
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

    /// Returns the index of a formula of the machine's safety that some of these steps breaks;
    /// `None` if they break no formula.
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

    /// Checks that the region lies within the machine's invariants and domains, that every layer
    /// lies within the next one, and the last layer within the region.
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

    /// Checks that a step is refused exactly if it breaks an assumption.
    fn assumptions(&mut self) -> StageResult {
        let m = &self.kernel;
        let controls = &self.functions.controls;
        let stages = [
            (
                &controls.assumed_first,
                &self.initial_moves,
                m.constant(true),
            ),
            (&controls.assumed, &self.later_moves, self.region.clone()),
        ];
        for (assumed, rules, at) in stages {
            let mut checked = Vec::new();
            for (_, edge) in assumed {
                checked.push(self.at(*edge)?);
            }
            for function in checked.iter().filter(|f| !rules.contains(f)) {
                if self.possible(m.and_not(&at, function)?, rules)? {
                    return Ok(fault(Clause::LegalInputRefused));
                }
            }
            // Values outside an input's domain are refused before the assumptions are checked.
            for input in self.specification.inputs() {
                checked.push(self.encoding.in_domain(m, input, Time::Next)?);
            }
            for rule in rules.iter().filter(|p| !checked.contains(p)) {
                if self.possible(m.and_not(&at, rule)?, &checked)? {
                    return Ok(fault(Clause::IllegalInputAccepted));
                }
            }
        }
        Ok(Ok(()))
    }

    /// Checks that step 0 keeps the initial conditions and leads into the region.
    fn first(&mut self) -> StageResult {
        let m = &self.kernel;
        let steps = self.steps(m.all(&self.initial_moves)?, &self.functions.controls.first)?;
        for formula in &self.specification.guarantees.initial {
            let function = m.prime(&self.encoding.formula(m, &formula.expr)?)?;
            if !m.is_false(&m.and_not(&steps, &function)?) {
                return Ok(fault(Clause::Initial(formula.name.clone())));
            }
        }
        if !m.is_false(&m.and_not(&steps, &m.prime(&self.region)?)?) {
            return Ok(fault(Clause::InitialRegion));
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
        let mut rest = m.and(&self.region, &m.all(&self.later_moves)?)?;
        for mode in &pursuit.modes {
            let when = self.at(mode.when)?;
            let steps = self.steps(m.and(&rest, &when)?, &mode.outputs)?;
            rest = m.and_not(&rest, &when)?;
            if let Some(i) = self.broken(&steps)? {
                let broken = &self.specification.guarantees.safety[i];
                return Ok(fault(Clause::Safety(broken.name.clone())));
            }
            if !m.is_false(&m.and(&steps, &wrong)?) {
                return Ok(fault(Clause::GoalSwitch(name())));
            }
            let missed = m.and_not(&steps, &reach)?;
            let progress_fault = match mode.aim {
                Aim::Goal => (!m.is_false(&missed)).then_some(ProgressFault::GoalMissed),
                Aim::Layer(layer) => self.fault_in_layer(goal, layer, &missed)?,
                Aim::Nearer => self.fault_in_any_layer(goal, &missed)?,
            };
            if let Some(progress_fault) = progress_fault {
                return Ok(fault(match progress_fault {
                    ProgressFault::GoalMissed => Clause::GoalMissed(name()),
                    ProgressFault::LayerMissed => Clause::LayerMissed(name()),
                    ProgressFault::MovesAway => Clause::MovesAway(name()),
                    ProgressFault::UnjustifiedWait => Clause::UnjustifiedWait(name()),
                    ProgressFault::OutsideLayers => Clause::OutsideLayers(name()),
                }));
            }
            m.safe_point()?;
        }
        Ok(Ok(()))
    }

    /// Checks `steps`, none of which reaches the goal. Each of them must move from its layer to a
    /// lower one, or wait while the layer's assumption fails. Returns the fault of a step that does
    /// neither; `None` if there is no such step.
    fn fault_in_any_layer(
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
                return Ok(Some(ProgressFault::UnjustifiedWait));
            }
            if waits != kept {
                return Ok(Some(ProgressFault::LayerMissed));
            }
            below = reached.clone();
        }
        Ok((!m.is_false(&rest)).then_some(ProgressFault::OutsideLayers))
    }

    /// Checks `steps`, none of which reaches the goal. Each of them must move into the target layer
    /// `layer`, or wait in it while the layer's assumption fails. Returns the fault of a step that
    /// does neither; `None` if there is no such step.
    fn fault_in_layer(
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
        // From above the layer, every move into it is correct. From within the layer, every move to
        // a lower layer is correct, and so is waiting while the layer's assumption fails. Only the
        // wrong steps are computed, and sets of states are combined first, so that the large set of
        // correct steps is never built. The second check ensures that no step starts below the
        // layer. So for the third check, the steps that start in `reached` start in the layer
        // itself.
        if !m.is_false(&m.and_not(steps, &m.prime(reached)?)?) {
            return Ok(Some(ProgressFault::LayerMissed));
        }
        if !m.is_false(&m.and(steps, &below)?) {
            return Ok(Some(ProgressFault::MovesAway));
        }
        let wakes = m.and(reached, &self.assumptions[assumption])?;
        let stays = m.and_not(&m.and(steps, &wakes)?, &m.prime(&below)?)?;
        Ok((!m.is_false(&stays)).then_some(ProgressFault::UnjustifiedWait))
    }
}

/// A fault of a step toward a goal; see the [clauses](Clause) with the same names.
enum ProgressFault {
    GoalMissed,
    LayerMissed,
    MovesAway,
    UnjustifiedWait,
    OutsideLayers,
}
