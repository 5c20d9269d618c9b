//! The game arena: a specification's formulas as functions of bits, and the relations that the
//! fixpoint uses.
//!
//! [`Formulas`] are encoded once. An [`Arena`] conjoins a selection of them, so that the search for
//! a core does not encode them again. The variable order is found by [`super::structure`] and by
//! the kernel's sifting.

use super::clusters::{Clustering, conjunction};
use super::heuristics::{Heuristic, Heuristics};
use super::reference::{AssumptionRef, GuaranteeRef};
use super::relation::Relation;
use super::structure::{self, Orientation};
use crate::symbolic::{BitSet, Encoding, Kernel, Limit, Limits, Order};
use linewright_core::gr1::{
    Expr, Formula, FormulaKind, Owner, Side, Specification, Time, Timing, VarId,
};
use std::collections::BTreeSet;

/// The formulas of one side.
#[derive(Debug, Clone)]
struct Encoded<K: Kernel> {
    initial: Vec<K::Function>,
    invariants: Vec<K::Function>,
    /// The conjuncts of each formula.
    safety: Vec<Vec<K::Function>>,
    justice: Vec<K::Function>,
    /// The valuations, over current bits, in which the side's variables have values in their
    /// domains.
    domains: K::Function,
}

/// All formulas of a specification, encoded.
#[derive(Debug, Clone)]
pub struct Formulas<K: Kernel> {
    kernel: K,
    heuristics: Heuristics,
    encoding: Encoding,
    timing: Timing,
    environment: Encoded<K>,
    system: Encoded<K>,
    inputs: Vec<VarId>,
    outputs: Vec<VarId>,
}

/// Selects the formulas of a game. Domains are always included.
#[derive(Debug, Clone, Copy)]
pub enum Selection<'a> {
    /// All assumptions and guarantees.
    All,
    /// All assumptions, and only these guarantees.
    Only(&'a [GuaranteeRef]),
    /// Only these guarantees, and only these assumptions.
    Both(&'a [GuaranteeRef], &'a [AssumptionRef]),
}

impl Selection<'_> {
    fn has_guarantee(&self, kind: FormulaKind, index: usize) -> bool {
        match self {
            Self::All => true,
            Self::Only(refs) | Self::Both(refs, _) => refs.contains(&GuaranteeRef { kind, index }),
        }
    }

    fn has_assumption(&self, kind: FormulaKind, index: usize) -> bool {
        match self {
            Self::All | Self::Only(_) => true,
            Self::Both(_, refs) => refs.contains(&GuaranteeRef { kind, index }),
        }
    }
}

/// Returns the initial order: by the structure of the formulas if that heuristic is enabled,
/// otherwise by declaration.
pub fn initial_order(specification: &Specification, heuristics: Heuristics) -> Order {
    oriented_order(specification, heuristics, Orientation::Preferred)
}

/// Returns the initial order with this orientation; without the heuristic, the orientation has no
/// effect.
pub fn oriented_order(
    specification: &Specification,
    heuristics: Heuristics,
    orientation: Orientation,
) -> Order {
    let encoding = Encoding::new(specification);
    // One additional pair at the bottom holds the strategy's flag: how many goals a step reaches.
    let pairs = encoding.pairs() + 1;
    if heuristics.has(Heuristic::Structure) {
        structure::order(specification, &encoding, pairs, orientation)
    } else {
        Order::natural(pairs)
    }
}

/// Number of nodes up to which a conjunct of a safety formula is not divided further.
const PART_NODES: usize = 1_000;

impl<K: Kernel> Encoded<K> {
    /// Returns references to all formulas, in order.
    fn all(&self) -> Vec<GuaranteeRef> {
        use FormulaKind::{Initial, Invariant, Justice, Safety};
        let lists = [
            (Initial, self.initial.len()),
            (Invariant, self.invariants.len()),
            (Safety, self.safety.len()),
            (Justice, self.justice.len()),
        ];
        let refs = lists
            .into_iter()
            .flat_map(|(kind, length)| (0..length).map(move |index| GuaranteeRef { kind, index }));
        refs.collect()
    }
}

impl<K: Kernel> Formulas<K> {
    /// Encodes all formulas, starting from this order of the pairs of bits.
    pub fn encode(
        specification: &Specification,
        order: &Order,
        heuristics: Heuristics,
        limits: &Limits,
    ) -> Result<Self, Limit> {
        let encoding = Encoding::new(specification);
        let kernel = K::new(order, limits)?;
        kernel.set_reordering(heuristics.has(Heuristic::Resifting));
        let list = |formulas: &[Formula]| -> Result<Vec<K::Function>, Limit> {
            let encoded = formulas.iter().map(|f| encoding.formula(&kernel, &f.expr));
            encoded.collect()
        };
        // If the machine moves first, assumptions can mention its next outputs (as they do after
        // the roles are swapped). An output code that stands for no value counts as satisfying
        // these assumptions. Otherwise the machine could win with such a code by leaving the
        // environment without a move.
        let answers = |owner: Owner, expr: &Expr, time: Time, mut function: K::Function| {
            if owner == Owner::Environment && specification.timing == Timing::Moore {
                let mut answered = BTreeSet::new();
                expr.for_each_var(&mut |v, t| {
                    if t == time && specification.variable(v).owner == Owner::System {
                        answered.insert(v);
                    }
                });
                for v in answered {
                    let within = encoding.in_domain(&kernel, v, time)?;
                    function = kernel.or(&function, &kernel.not(&within)?)?;
                }
            }
            Ok(function)
        };
        // The result of a formula on codes that stand for no value is irrelevant but takes nodes,
        // especially in negations. So in large games, formulas are restricted to codes that stand
        // for a value.
        let confined = order.pairs().len() > structure::MANY_PAIRS;
        let part = |part: &Expr| -> Result<K::Function, Limit> {
            let mut function = encoding.formula(&kernel, part)?;
            if confined {
                let mut variables = Vec::new();
                part.for_each_var(&mut |v, t| variables.push((v, t)));
                variables.sort_unstable();
                variables.dedup();
                for (v, t) in variables {
                    function = kernel.and(&function, &encoding.in_domain(&kernel, v, t)?)?;
                }
            }
            Ok(function)
        };
        let side = |side: &Side, owner: Owner| -> Result<Encoded<K>, Limit> {
            let mut domains = kernel.constant(true);
            for (i, variable) in specification.variables.iter().enumerate().rev() {
                if variable.owner == owner {
                    let within = encoding.in_domain(&kernel, VarId(i as u32), Time::Now)?;
                    domains = kernel.and(&domains, &within)?;
                }
            }
            // A conjunct that is too large as a whole stays in its parts.
            let conjuncts = |formula: &Formula| -> Result<Vec<K::Function>, Limit> {
                let mut found = Vec::new();
                for conjunct in formula.expr.conjuncts() {
                    let parts: Vec<K::Function> = conjunct
                        .parts()
                        .iter()
                        .map(|p| answers(owner, p, Time::Next, part(p)?))
                        .collect::<Result<_, _>>()?;
                    match conjunction(&kernel, &parts, PART_NODES)? {
                        Some(whole) => found.push(whole),
                        None => found.extend(parts),
                    }
                }
                Ok(found)
            };
            let of_states = |formulas: &[Formula]| -> Result<Vec<K::Function>, Limit> {
                let encoded = formulas.iter().zip(list(formulas)?);
                encoded
                    .map(|(f, function)| answers(owner, &f.expr, Time::Now, function))
                    .collect()
            };
            Ok(Encoded {
                initial: of_states(&side.initial)?,
                invariants: of_states(&side.invariants)?,
                safety: side
                    .safety
                    .iter()
                    .map(conjuncts)
                    .collect::<Result<_, _>>()?,
                justice: list(&side.justice)?,
                domains,
            })
        };
        let environment = side(&specification.assumptions, Owner::Environment)?;
        let system = side(&specification.guarantees, Owner::System)?;
        Ok(Self {
            environment,
            system,
            timing: specification.timing,
            inputs: specification.inputs().collect(),
            outputs: specification.outputs().collect(),
            encoding,
            heuristics,
            kernel,
        })
    }

    /// The kernel that holds the formulas.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// References to all guarantees, in order.
    pub fn guarantees(&self) -> Vec<GuaranteeRef> {
        self.system.all()
    }

    /// References to all assumptions, in order.
    pub fn assumptions(&self) -> Vec<AssumptionRef> {
        self.environment.all()
    }

    /// Returns the formulas with one more assumption.
    #[must_use]
    pub fn with_assumption(&self, kind: FormulaKind, function: K::Function) -> Self {
        let mut more = self.clone();
        let side = &mut more.environment;
        match kind {
            FormulaKind::Initial => side.initial.push(function),
            FormulaKind::Invariant => side.invariants.push(function),
            FormulaKind::Safety => side.safety.push(vec![function]),
            FormulaKind::Justice => side.justice.push(function),
        }
        more
    }

    /// Returns the formulas with one guarantee weakened: it also holds wherever `function` holds.
    pub fn weakened(&self, guarantee: GuaranteeRef, function: &K::Function) -> Result<Self, Limit> {
        let mut less = self.clone();
        let (m, side, index) = (&self.kernel, &mut less.system, guarantee.index);
        let one = match guarantee.kind {
            FormulaKind::Initial => &mut side.initial[index],
            FormulaKind::Invariant => &mut side.invariants[index],
            FormulaKind::Justice => &mut side.justice[index],
            FormulaKind::Safety => {
                let whole = m.all(&side.safety[index])?;
                side.safety[index] = vec![m.or(&whole, function)?];
                return Ok(less);
            }
        };
        *one = m.or(one, function)?;
        Ok(less)
    }

    /// Returns the same formulas with other limits.
    pub fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            kernel: self.kernel.with_limits(limits),
            ..self.clone()
        }
    }

    /// The encoding of the variables.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// Returns the guarantees that a single answer can break. If `at_start`, they are the
    /// guarantees about step 0, over next bits. Otherwise they are the guarantees about a later
    /// step, over current and next bits.
    pub fn step_guarantees(
        &self,
        at_start: bool,
    ) -> Result<Vec<(GuaranteeRef, K::Function)>, Limit> {
        use FormulaKind::{Initial, Invariant, Safety};
        let m = &self.kernel;
        let mut rules = Vec::new();
        let mut add = |kind, list: &[K::Function]| -> Result<(), Limit> {
            for (index, f) in list.iter().enumerate() {
                rules.push((GuaranteeRef { kind, index }, m.prime(f)?));
            }
            Ok(())
        };
        if at_start {
            add(Initial, &self.system.initial)?;
        }
        add(Invariant, &self.system.invariants)?;
        if !at_start {
            for (index, parts) in self.system.safety.iter().enumerate() {
                let kind = Safety;
                rules.push((GuaranteeRef { kind, index }, m.all(parts)?));
            }
        }
        Ok(rules)
    }

    /// Peak number of live nodes.
    pub fn peak_nodes(&self) -> u64 {
        self.kernel.peak_nodes()
    }

    /// Builds the game with the selected formulas and combines the parts of its relations into
    /// clusters.
    pub fn arena(
        &self,
        selection: &Selection<'_>,
        clustering: Clustering,
    ) -> Result<Arena<K>, Limit> {
        self.arena_with_timing(selection, clustering, self.timing)
    }

    /// Like [`Self::arena`], but with this timing instead of the specification's.
    pub fn arena_with_timing(
        &self,
        selection: &Selection<'_>,
        clustering: Clustering,
        timing: Timing,
    ) -> Result<Arena<K>, Limit> {
        let m = &self.kernel;
        let chosen = |kind: FormulaKind, list: &[K::Function]| -> Vec<K::Function> {
            let list = list.iter().enumerate();
            list.filter(|(i, _)| selection.has_guarantee(kind, *i))
                .map(|(_, f)| f.clone())
                .collect()
        };
        let assumed = |kind: FormulaKind, list: &[K::Function]| -> Vec<K::Function> {
            let list = list.iter().enumerate();
            list.filter(|(i, _)| selection.has_assumption(kind, *i))
                .map(|(_, f)| f.clone())
                .collect()
        };
        let or_true = |list: Vec<K::Function>| {
            if list.is_empty() {
                vec![m.constant(true)]
            } else {
                list
            }
        };
        let env = &self.environment;
        let sys = &self.system;

        let invariants = assumed(FormulaKind::Invariant, &env.invariants);
        let legal_inputs = m.and(&env.domains, &m.all(&invariants)?)?;
        let invariants = chosen(FormulaKind::Invariant, &sys.invariants);
        let legal_outputs = m.and(&sys.domains, &m.all(&invariants)?)?;
        let states = m.and(&legal_inputs, &legal_outputs)?;
        let initial = chosen(FormulaKind::Initial, &sys.initial);
        let env_first = assumed(FormulaKind::Initial, &env.initial);
        let env_initial = m.and(&legal_inputs, &m.all(&env_first)?)?;
        let sys_initial = m.and(&legal_outputs, &m.all(&initial)?)?;

        let env_safety = env
            .safety
            .iter()
            .enumerate()
            .filter(|(i, _)| selection.has_assumption(FormulaKind::Safety, *i));
        let mut env_parts: Vec<K::Function> = env_safety.flat_map(|(_, f)| f.clone()).collect();
        env_parts.push(m.prime(&legal_inputs)?);
        let safety = sys
            .safety
            .iter()
            .enumerate()
            .filter(|(i, _)| selection.has_guarantee(FormulaKind::Safety, *i));
        let mut sys_parts: Vec<K::Function> = safety.flat_map(|(_, f)| f.clone()).collect();

        let bits = |vars: &[VarId], time| self.encoding.bit_set(vars.iter().copied(), time);
        let inputs_next = bits(&self.inputs, Time::Next);
        let outputs_next = bits(&self.outputs, Time::Next);
        let environment = Relation::new(m, &env_parts, &inputs_next, clustering, self.heuristics)?;
        if timing == Timing::Moore {
            // ∀x'. ρe → (a ∧ b) equals (∀x'. ρe → a) ∧ (∀x'. ρe → b), so x' can be eliminated from
            // each part of the machine's safety in advance.
            for part in &mut sys_parts {
                *part = m.not(&environment.product(m, &m.not(part)?)?)?;
            }
        }
        let system = Relation::new(m, &sys_parts, &outputs_next, clustering, self.heuristics)?;
        Ok(Arena {
            kernel: m.clone(),
            heuristics: self.heuristics,
            timing,
            states,
            env_initial,
            sys_initial,
            environment,
            system,
            assumptions: or_true(assumed(FormulaKind::Justice, &env.justice)),
            goals: or_true(chosen(FormulaKind::Justice, &sys.justice)),
            inputs_now: bits(&self.inputs, Time::Now),
            inputs_next,
            outputs_now: bits(&self.outputs, Time::Now),
            outputs_next,
            encoding: self.encoding.clone(),
        })
    }
}

/// A game: its initial choices, moves and justice, as functions of bits.
#[derive(Debug, Clone)]
pub struct Arena<K: Kernel> {
    /// The BDD kernel.
    pub kernel: K,
    /// Enabled heuristics.
    pub heuristics: Heuristics,
    /// Encoding of the variables.
    pub encoding: Encoding,
    /// Which side moves first.
    pub timing: Timing,
    /// Valuations that satisfy the invariants and domains of both sides.
    pub states: K::Function,
    /// Initial choices of the environment: its initial conditions, invariants and domains. Over
    /// current bits.
    pub env_initial: K::Function,
    /// Initial choices of the machine: its initial conditions, invariants and domains. Over current
    /// bits.
    pub sys_initial: K::Function,
    /// Moves of the environment: its safety, and its invariants and domains in the next step.
    pub environment: Relation<K>,
    /// The machine's safety (for Moore, with the next inputs eliminated). The machine's invariants
    /// and domains are part of [`Self::states`], and every target of the game lies within these
    /// states.
    pub system: Relation<K>,
    /// Justice of the environment; never empty.
    pub assumptions: Vec<K::Function>,
    /// Justice of the machine; never empty.
    pub goals: Vec<K::Function>,
    /// Bits of the current inputs.
    pub inputs_now: BitSet,
    /// Bits of the next inputs.
    pub inputs_next: BitSet,
    /// Bits of the current outputs.
    pub outputs_now: BitSet,
    /// Bits of the next outputs.
    pub outputs_next: BitSet,
}

impl<K: Kernel> Arena<K> {
    /// Returns the same game with other limits.
    pub fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            kernel: self.kernel.with_limits(limits),
            ..self.clone()
        }
    }

    /// Whether no justice formula mentions next values.
    pub fn has_state_justice(&self) -> bool {
        let mut formulas = self.assumptions.iter().chain(&self.goals);
        formulas.all(|f| {
            let support = self.kernel.support(f);
            support.iter().all(|b| *b != b.primed())
        })
    }

    /// `∀x'. ρe(x, y, x') → f`
    pub fn for_all_inputs(&self, f: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.kernel;
        m.not(&self.environment.product(m, &m.not(f)?)?)
    }

    /// Returns the controllable predecessor of a set of transitions: the states in which the
    /// machine can answer every move of the environment with a transition of `target` that keeps
    /// the machine's safety.
    ///
    /// ```text
    /// Mealy:  ∀x'. ρe(x, y, x') → ∃y'. ρs(x, y, x', y') ∧ target(x, y, x', y')
    /// Moore:  ∃y'. ∀x'. ρe(x, y, x') → ρs(x, y, x', y') ∧ target(x, y, x', y')
    /// ```
    pub fn controllable_predecessor(&self, target: &K::Function) -> Result<K::Function, Limit> {
        let m = &self.kernel;
        match self.timing {
            Timing::Mealy => self.for_all_inputs(&self.system.product(m, target)?),
            Timing::Moore => self.system.product(m, &self.for_all_inputs(target)?),
        }
    }

    /// Returns all moves of the environment as one relation.
    pub fn environment_moves(&self) -> Result<K::Function, Limit> {
        self.environment.whole(&self.kernel)
    }

    /// Returns the machine's safety as one relation (for Moore, with the next inputs eliminated).
    pub fn system_moves(&self) -> Result<K::Function, Limit> {
        self.system.whole(&self.kernel)
    }

    /// Whether the machine can answer every initial choice of the environment so that step 0 lies
    /// in `region`.
    ///
    /// ```text
    /// Mealy:  ∀x. θe(x) → ∃y. θs(x, y) ∧ region(x, y)
    /// Moore:  ∃y. ∀x. θe(x) → θs(x, y) ∧ region(x, y)
    /// ```
    pub fn wins_initially(&self, region: &K::Function) -> Result<bool, Limit> {
        let m = &self.kernel;
        let answers = match self.timing {
            Timing::Mealy => {
                let some = m.and_exists(&self.sys_initial, region, &self.outputs_now)?;
                m.implies_forall(&self.env_initial, &some, &self.inputs_now)?
            }
            Timing::Moore => {
                let good = m.and(&self.sys_initial, region)?;
                let good = m.implies_forall(&self.env_initial, &good, &self.inputs_now)?;
                m.exists(&good, &self.outputs_now)?
            }
        };
        Ok(!m.is_false(&answers))
    }
}
