//! Uses decision diagrams to answer questions with too many values to enumerate.
//!
//! The wires of a question become the variables of a specification, and its hypotheses and goal
//! become formulas, so that the encoding and variable order are those of the games. The question is
//! whether some values satisfy the hypotheses but not the goal. Each question first goes to the
//! kernel that starts fast. If that kernel reaches its node limit, the kernel that reorders
//! variables answers the question. The limit counts nodes instead of time, so every run selects the
//! same kernel.

use super::query::{Answer, Values, domain};
use super::support;
use linewright_core::gr1::{
    Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use linewright_language::contract::machine::Machine;
use linewright_solver::game::order_by_structure;
use linewright_solver::symbolic::{
    Biodivine, BitSet, Budget, Encoding, Kernel, Limit, Limits, SharedStore,
};

/// Maximum number of nodes for a question in the first kernel, which starts fast. After that, the
/// second kernel is tried.
const FEW_NODES: u64 = 500_000;

/// Decides whether the goal follows from the hypotheses.
pub(super) fn decide(machine: &Machine, goal: &Expr, hypotheses: &[&Expr]) -> Answer {
    let question = Encoded::new(machine, goal, hypotheses);
    let few = Limits {
        max_nodes: Some(FEW_NODES),
        max_created: Some(FEW_NODES),
        ..Limits::default()
    };
    let many = Limits::default().with_budget(Budget::WIRING);
    let answer = question.answer::<Biodivine>(&few);
    answer
        .or_else(|_| question.answer::<SharedStore>(&many))
        .unwrap_or(Answer::TooLarge)
}

/// A question over the variables of a specification.
struct Encoded {
    /// The wire of each variable.
    wires: Vec<VarId>,
    /// The invariants of the assumptions are the hypotheses. The only invariant of the guarantees
    /// is the goal.
    specification: Specification,
    /// The variables to name in a counterexample: those of the goal.
    named: Vec<(VarId, Time)>,
    /// All variables that occur in the hypotheses or in the goal.
    occurring: Vec<(VarId, Time)>,
}

impl Encoded {
    fn new(machine: &Machine, goal: &Expr, hypotheses: &[&Expr]) -> Self {
        let named = support(goal);
        let mut occurring: Vec<(VarId, Time)> =
            hypotheses.iter().flat_map(|h| support(h)).collect();
        occurring.extend(&named);
        occurring.sort_unstable();
        occurring.dedup();
        let mut wires: Vec<VarId> = occurring.iter().map(|(w, _)| *w).collect();
        wires.dedup();
        let variable = |wire: VarId| -> VarId {
            let place = wires.binary_search(&wire).unwrap_or(0);
            VarId(place as u32)
        };
        let formula = |expr: &Expr| Formula {
            defines: false,
            name: String::new(),
            requirement: None,
            expr: expr.substitute(&mut |wire, time| Expr::Var(variable(wire), time)),
            span: Span::default(),
            text: String::new(),
        };
        let side = |invariants: Vec<Formula>| Side {
            invariants,
            ..Side::default()
        };
        let variables = wires.iter().map(|wire| Variable {
            name: machine.wire_name(wire.index()),
            owner: Owner::Environment,
            internal: false,
            domain: domain(machine, *wire),
            unit: String::new(),
            span: Span::default(),
        });
        let specification = Specification {
            name: String::new(),
            timing: Timing::Mealy,
            variables: variables.collect(),
            assumptions: side(hypotheses.iter().map(|h| formula(h)).collect()),
            guarantees: side(vec![formula(goal)]),
        };
        Self {
            occurring: occurring.iter().map(|(w, t)| (variable(*w), *t)).collect(),
            named: named.iter().map(|(w, t)| (variable(*w), *t)).collect(),
            specification,
            wires,
        }
    }

    fn answer<K: Kernel>(&self, limits: &Limits) -> Result<Answer, Limit> {
        let encoding = Encoding::new(&self.specification);
        let m = K::new(&order_by_structure(&self.specification), limits)?;
        let goal = &self.specification.guarantees.invariants[0];
        let Some(known) = self.known(&encoding, &m)? else {
            return Ok(Answer::Holds);
        };
        let mut left = m.not(&encoding.formula(&m, &goal.expr)?)?;
        for (variable, time) in &self.named {
            left = m.and(&left, &encoding.in_domain(&m, *variable, *time)?)?;
        }
        for function in &known {
            left = m.and(&left, function)?;
        }
        let Some(bits) = m.witness(&left) else {
            return Ok(Answer::Holds);
        };
        let values = self.named.iter().map(|(variable, time)| {
            let wire = self.wires[variable.index()];
            ((wire, *time), encoding.value(*variable, *time, &bits))
        });
        Ok(Answer::Fails(Values(values.collect())))
    }

    /// Projects the hypotheses to the goal's variables: returns functions over these variables
    /// whose conjunction is the projection. All other variables are eliminated one by one,
    /// beginning with the one whose functions are smallest. To eliminate a variable, only the
    /// functions that mention it are combined, so the values of loosely related actions are never
    /// combined. Returns `None` if no values satisfy the hypotheses.
    fn known<K: Kernel>(
        &self,
        encoding: &Encoding,
        m: &K,
    ) -> Result<Option<Vec<K::Function>>, Limit> {
        let measured = |function: K::Function| {
            let support = BitSet::new(m.support(&function));
            let size = m.size(&function);
            (function, support, size)
        };
        let mut pool = Vec::new();
        for hypothesis in &self.specification.assumptions.invariants {
            for part in hypothesis.expr.conjuncts() {
                pool.push(measured(encoding.formula(m, part)?));
            }
        }
        let mut others: Vec<(VarId, Time)> = self
            .occurring
            .iter()
            .filter(|w| !self.named.contains(w))
            .copied()
            .collect();
        while !others.is_empty() {
            let mentions = |(variable, time): &(VarId, Time), support: &BitSet| {
                encoding.bits(*variable, *time).any(|b| support.contains(b))
            };
            let cost = |wire: &(VarId, Time)| -> usize {
                let bucket = pool
                    .iter()
                    .filter(|(_, support, _)| mentions(wire, support));
                bucket.map(|(_, _, size)| *size).sum()
            };
            let place = (0..others.len()).min_by_key(|i| cost(&others[*i]));
            let wire = others.swap_remove(place.unwrap_or(0));
            let (mut bucket, rest): (Vec<_>, Vec<_>) = pool
                .into_iter()
                .partition(|(_, support, _)| mentions(&wire, support));
            pool = rest;
            bucket.sort_by_key(|(_, _, size)| *size);
            let mut together = encoding.in_domain(m, wire.0, wire.1)?;
            for (function, ..) in &bucket {
                together = m.and(&together, function)?;
            }
            let left = m.exists(&together, &BitSet::new(encoding.bits(wire.0, wire.1)))?;
            if m.is_false(&left) {
                return Ok(None);
            }
            if !m.is_true(&left) {
                pool.push(measured(left));
            }
        }
        Ok(Some(pool.into_iter().map(|(f, ..)| f).collect()))
    }
}
