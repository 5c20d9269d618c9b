//! The board: a specification's formulas as functions of bits, and the relations the fixpoint works with.
//!
//! Formulas are encoded once ([`Formulas`]); an [`Arena`] conjoins a selection of the guarantees, so that looking for a core
//! does not encode again. A side's transition relation is a list of clusters: conjuncts put together up to a bound, which is
//! between one large relation (good for some specifications, bad for others) and one relation a formula (the reverse).

use super::{GuaranteeKind, GuaranteeRef};
use crate::gr1::{Formula, Owner, Side, Specification, Time, Timing, VarId};
use crate::symbolic::{BitSet, Encoding, Function, Limit, Limits, Manager};

/// Conjuncts are put together until they have this many nodes.
const CLUSTER_NODES: usize = 1_000;

/// The formulas of one side.
#[derive(Debug)]
struct Encoded {
    initial: Vec<Function>,
    invariants: Vec<Function>,
    safety: Vec<Function>,
    justice: Vec<Function>,
    /// That the side's variables have values of their domains; over current bits.
    domains: Function,
}

/// All formulas of a specification, encoded.
#[derive(Debug)]
pub struct Formulas {
    manager: Manager,
    encoding: Encoding,
    timing: Timing,
    environment: Encoded,
    system: Encoded,
    inputs: Vec<VarId>,
    outputs: Vec<VarId>,
}

/// Which guarantees are in the game. Domains and assumptions always are.
#[derive(Debug)]
pub enum Selection<'a> {
    /// All of them.
    All,
    /// Only these.
    Only(&'a [GuaranteeRef]),
}

impl Selection<'_> {
    fn contains(&self, kind: GuaranteeKind, index: usize) -> bool {
        match self {
            Self::All => true,
            Self::Only(refs) => refs.contains(&GuaranteeRef { kind, index }),
        }
    }
}

impl Formulas {
    /// Encodes everything.
    pub fn encode(specification: &Specification, limits: &Limits) -> Result<Self, Limit> {
        let encoding = Encoding::new(specification);
        // One more pair than the variables need: the strategy's flag "the goal was reached".
        let manager = Manager::new(encoding.pairs() + 1, limits)?;
        let list = |formulas: &[Formula]| -> Result<Vec<Function>, Limit> {
            let encoded = formulas.iter().map(|f| encoding.formula(&manager, &f.expr));
            encoded.collect()
        };
        let side = |side: &Side, owner: Owner| -> Result<Encoded, Limit> {
            let mut domains = manager.constant(true);
            for (i, variable) in specification.variables.iter().enumerate().rev() {
                if variable.owner == owner {
                    let within = encoding.in_domain(&manager, VarId(i as u32), Time::Now)?;
                    domains = manager.and(&domains, &within)?;
                }
            }
            Ok(Encoded {
                initial: list(&side.initial)?,
                invariants: list(&side.invariants)?,
                safety: list(&side.safety)?,
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
            manager,
        })
    }

    /// The guarantees of the specification, in order.
    pub fn guarantees(&self) -> Vec<GuaranteeRef> {
        use GuaranteeKind::{Initial, Invariant, Justice, Safety};
        let lists = [
            (Initial, self.system.initial.len()),
            (Invariant, self.system.invariants.len()),
            (Safety, self.system.safety.len()),
            (Justice, self.system.justice.len()),
        ];
        let refs = lists
            .into_iter()
            .flat_map(|(kind, length)| (0..length).map(move |index| GuaranteeRef { kind, index }));
        refs.collect()
    }

    /// The largest number of nodes that were alive at once.
    pub fn peak_nodes(&self) -> u64 {
        self.manager.peak_nodes()
    }

    /// The game with the selected guarantees.
    pub fn arena(&self, selection: &Selection<'_>) -> Result<Arena, Limit> {
        let m = &self.manager;
        let chosen = |kind: GuaranteeKind, list: &[Function]| -> Vec<Function> {
            let list = list.iter().enumerate();
            list.filter(|(i, _)| selection.contains(kind, *i))
                .map(|(_, f)| f.clone())
                .collect()
        };
        let or_true = |list: Vec<Function>| {
            if list.is_empty() {
                vec![m.constant(true)]
            } else {
                list
            }
        };
        let env = &self.environment;
        let sys = &self.system;

        let legal_inputs = m.and(&env.domains, &m.all(&env.invariants)?)?;
        let invariants = chosen(GuaranteeKind::Invariant, &sys.invariants);
        let legal_outputs = m.and(&sys.domains, &m.all(&invariants)?)?;
        let states = m.and(&legal_inputs, &legal_outputs)?;
        let initial = chosen(GuaranteeKind::Initial, &sys.initial);
        let env_initial = m.and(&legal_inputs, &m.all(&env.initial)?)?;
        let sys_initial = m.and(&legal_outputs, &m.all(&initial)?)?;

        let mut env_parts = env.safety.clone();
        env_parts.push(m.prime(&legal_inputs)?);
        let sys_parts = chosen(GuaranteeKind::Safety, &sys.safety);

        let mut arena = Arena {
            manager: m.with_limits(&m.limits()),
            timing: self.timing,
            states,
            env_initial,
            sys_initial,
            env_clusters: clusters(m, env_parts)?,
            sys_clusters: clusters(m, sys_parts)?,
            assumptions: or_true(env.justice.clone()),
            goals: or_true(chosen(GuaranteeKind::Justice, &sys.justice)),
            inputs_now: self
                .encoding
                .bit_set(self.inputs.iter().copied(), Time::Now),
            inputs_next: self
                .encoding
                .bit_set(self.inputs.iter().copied(), Time::Next),
            outputs_now: self
                .encoding
                .bit_set(self.outputs.iter().copied(), Time::Now),
            outputs_next: self
                .encoding
                .bit_set(self.outputs.iter().copied(), Time::Next),
            early: Vec::new(),
            encoding: self.encoding.clone(),
        };
        arena.prepare()?;
        Ok(arena)
    }
}

/// The game.
#[derive(Debug)]
pub struct Arena {
    /// Makes functions.
    pub manager: Manager,
    /// The bits of the variables.
    pub encoding: Encoding,
    /// Who answers first.
    pub timing: Timing,
    /// The valuations that satisfy the invariants and domains of both sides.
    pub states: Function,
    /// What the environment may begin with: its initial conditions, invariants and domains. Over current inputs.
    pub env_initial: Function,
    /// What the machine may begin with: its initial conditions, invariants and domains.
    pub sys_initial: Function,
    /// What the environment may do next: its safety, and its invariants and domains of the next step.
    pub env_clusters: Vec<Function>,
    /// The machine's safety. Its invariants and domains are in [`Self::states`], in which every target of the game lies.
    pub sys_clusters: Vec<Function>,
    /// The environment's justice; never empty.
    pub assumptions: Vec<Function>,
    /// The machine's justice; never empty.
    pub goals: Vec<Function>,
    /// Bits of the current inputs.
    pub inputs_now: BitSet,
    /// Bits of the next inputs.
    pub inputs_next: BitSet,
    /// Bits of the current outputs.
    pub outputs_now: BitSet,
    /// Bits of the next outputs.
    pub outputs_next: BitSet,
    /// For Mealy, the next outputs that no cluster after the i-th mentions: eliminated together with it.
    early: Vec<BitSet>,
}

impl Arena {
    /// The same game with other limits.
    pub fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            manager: self.manager.with_limits(limits),
            encoding: self.encoding.clone(),
            timing: self.timing,
            states: self.states.clone(),
            env_initial: self.env_initial.clone(),
            sys_initial: self.sys_initial.clone(),
            env_clusters: self.env_clusters.clone(),
            sys_clusters: self.sys_clusters.clone(),
            assumptions: self.assumptions.clone(),
            goals: self.goals.clone(),
            inputs_now: self.inputs_now.clone(),
            inputs_next: self.inputs_next.clone(),
            outputs_now: self.outputs_now.clone(),
            outputs_next: self.outputs_next.clone(),
            early: self.early.clone(),
        }
    }

    fn prepare(&mut self) -> Result<(), Limit> {
        if self.timing == Timing::Moore {
            // ∀x'. ρe → (a ∧ b) is (∀x'. ρe → a) ∧ (∀x'. ρe → b): the machine's safety can be freed of x' once and for all.
            let mut blind = Vec::new();
            for cluster in &self.sys_clusters {
                blind.push(self.for_all_inputs(cluster)?);
            }
            self.sys_clusters = clusters(&self.manager, blind)?;
        }
        let mut seen = BitSet::default();
        let mut early = Vec::new();
        for cluster in self.sys_clusters.iter().rev() {
            let bits = cluster.support().into_iter();
            let fresh =
                BitSet::new(bits.filter(|b| self.outputs_next.contains(*b) && !seen.contains(*b)));
            for bit in fresh.iter() {
                seen.insert(bit);
            }
            early.push(fresh);
        }
        early.reverse();
        self.early = early;
        Ok(())
    }

    /// `∀x'. ρe(x, y, x') → f`
    pub fn for_all_inputs(&self, f: &Function) -> Result<Function, Limit> {
        let m = &self.manager;
        let (first, rest) = self
            .env_clusters
            .split_first()
            .expect("the environment's domains make at least one cluster");
        let mut allowed = f.clone();
        for cluster in rest {
            allowed = m.implies(cluster, &allowed)?;
        }
        m.implies_forall(first, &allowed, &self.inputs_next)
    }

    /// The controllable predecessor of a set of transitions: the states in which the machine can always answer with a
    /// transition of `target` that keeps its safety.
    ///
    /// ```text
    /// Mealy:  ∀x'. ρe(x, y, x') → ∃y'. ρs(x, y, x', y') ∧ target(x, y, x', y')
    /// Moore:  ∃y'. ∀x'. ρe(x, y, x') → ρs(x, y, x', y') ∧ target(x, y, x', y')
    /// ```
    pub fn controllable_predecessor(&self, target: &Function) -> Result<Function, Limit> {
        match self.timing {
            Timing::Mealy => self.for_all_inputs(&self.some_output(target)?),
            Timing::Moore => self.some_output(&self.for_all_inputs(target)?),
        }
    }

    /// `∃y'. ρs ∧ f`, cluster by cluster, each next output eliminated as soon as no later cluster mentions it.
    fn some_output(&self, f: &Function) -> Result<Function, Limit> {
        let m = &self.manager;
        let mut result = f.clone();
        for (cluster, bits) in self.sys_clusters.iter().zip(&self.early) {
            result = m.and_exists(&result, cluster, bits)?;
        }
        m.exists(&result, &self.outputs_next)
    }

    /// All that the environment may do, as one relation.
    pub fn environment_moves(&self) -> Result<Function, Limit> {
        self.manager.all(&self.env_clusters)
    }

    /// The machine's safety as one relation (for Moore: freed of the next inputs).
    pub fn system_moves(&self) -> Result<Function, Limit> {
        self.manager.all(&self.sys_clusters)
    }

    /// Whether the machine has an answer to every initial choice from within `region`.
    ///
    /// ```text
    /// Mealy:  ∀x. θe(x) → ∃y. θs(x, y) ∧ region(x, y)        Moore:  ∃y. ∀x. θe(x) → θs(x, y) ∧ region(x, y)
    /// ```
    pub fn wins_initially(&self, region: &Function) -> Result<bool, Limit> {
        let m = &self.manager;
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
        Ok(!answers.is_false())
    }
}

/// Puts conjuncts together, in order, until a cluster is large. Gives at least one.
fn clusters(m: &Manager, parts: Vec<Function>) -> Result<Vec<Function>, Limit> {
    let mut result: Vec<Function> = Vec::new();
    for part in parts {
        match result.last_mut() {
            Some(last) if last.size() + part.size() <= CLUSTER_NODES => {
                *last = m.and(last, &part)?;
            }
            _ => result.push(part),
        }
    }
    if result.is_empty() {
        result.push(m.constant(true));
    }
    Ok(result)
}
