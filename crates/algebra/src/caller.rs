//! Composition of a machine with its caller, to check that the operations requested by a line keep
//! the assumptions that the machine exports to its caller.
//!
//! The proof of a machine alone can export its assumptions about the requested operations
//! ([`super::proof::Exports`]). In a line, operations are requested in sequences, one sequence for
//! each part, repeatedly and with the parts in any order. This module adds a caller to the
//! components. The caller makes exactly these requests, and sets every input that the machine does
//! not set. Then nothing is exported any more: each assumption is either proved, or refuted by a
//! series of parts after which it is broken.

use super::machine::of_machine;
use super::proof::Claim;
use super::system::{Component, ContractSide, FormulaRef, System};
use linewright_core::gr1::{
    Domain, Expr, Formula, FormulaKind, Owner, Side, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, PlantSource, PropertyKind, RealExpr};

/// A machine with its caller, and the claim about it.
#[derive(Debug, Clone)]
pub struct CalledMachine {
    /// The machine's components and the caller.
    pub system: System,
    /// Claim with the givens and without a goal: the obligations are the assumptions of the
    /// components.
    pub claim: Claim,
    /// Assumptions of the components about the requested operations, without justice.
    pub operation_assumptions: Vec<FormulaRef>,
    /// The assumptions in `operation_assumptions` that depend on properties of parts, which are
    /// unknown here. If the proof of one fails, that is not a finding.
    pub uncertain_assumptions: Vec<FormulaRef>,
    /// Variable with the requested operation.
    pub operation: VarId,
}

/// A request for an operation.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct OperationRequest {
    /// Index among the machine's operations.
    pub operation: usize,
    /// Known values of other inputs while the operation runs: index among the machine's plant
    /// inputs, and value.
    pub known: Vec<(usize, i64)>,
}

impl OperationRequest {
    /// Creates a request. `parameters` are pairs of an index among the machine's properties and a
    /// value. A property for which `carried` is true belongs to a part, so its value is unknown;
    /// any other property without a given value has its default.
    pub fn new(
        machine: &Machine,
        operation: usize,
        parameters: &[(usize, f64)],
        carried: impl Fn(usize) -> bool,
    ) -> Self {
        let given = |at: usize| parameters.iter().find(|(of, _)| *of == at);
        let values = machine.properties.iter().enumerate();
        let values: Vec<f64> = values
            .map(|(at, property)| given(at).map_or(property.default, |(_, value)| *value))
            .collect();
        let mut known = Vec::new();
        for (place, input) in machine.plant.iter().enumerate() {
            let PlantSource::Property(expr) = &input.source else {
                continue;
            };
            let mut is_known = true;
            expr.for_each(&mut |of| match of {
                RealExpr::Property(at) => {
                    let own = machine.properties[*at].kind == PropertyKind::Parameter;
                    is_known &= own || !carried(*at);
                }
                _ => is_known = false,
            });
            let value = if is_known {
                expr.eval(&values, &[])
            } else {
                f64::NAN
            };
            #[expect(
                clippy::cast_possible_truncation,
                reason = "it was compared with a domain"
            )]
            if input.domain.low() as f64 <= value && value <= input.domain.high() as f64 {
                known.push((place, value.round() as i64));
            }
        }
        Self { operation, known }
    }
}

impl CalledMachine {
    /// Composes a machine with a caller that requests these sequences, each any number of times and
    /// in any order. Returns `None` if no assumption is about the requested operations, or if there
    /// are no requests.
    pub fn of(machine: &Machine, sequences: &[Vec<OperationRequest>]) -> Option<Self> {
        let done = machine.done.as_ref()?;
        let mut plant = machine.plant.iter();
        let operation = plant.position(|p| matches!(p.source, PlantSource::Operation))?;
        let operation = VarId(operation as u32);
        let (mut system, claim) = of_machine(machine);
        let steps = || sequences.iter().flatten();
        let mut unknown: Vec<VarId> = Vec::new();
        for (place, input) in machine.plant.iter().enumerate() {
            let is_known =
                |request: &OperationRequest| request.known.iter().any(|(at, _)| *at == place);
            if matches!(input.source, PlantSource::Property(_)) && !steps().all(is_known) {
                unknown.push(VarId(place as u32));
            }
        }
        let (operation_assumptions, uncertain_assumptions) =
            operation_assumptions(&system, operation, &unknown);
        if operation_assumptions.is_empty() || sequences.iter().all(Vec::is_empty) {
            return None;
        }
        // Justice is not examined here.
        for component in &mut system.components {
            component.assumptions.justice.clear();
            component.guarantees.justice.clear();
        }
        let place = VarId(system.variables.len() as u32);
        let count = sequences.iter().map(Vec::len).sum::<usize>() as i64;
        system.variables.push(Variable {
            name: system.fresh_name("place in the sequence"),
            owner: Owner::System,
            internal: true,
            domain: Domain::Range {
                low: 0,
                high: count - 1,
            },
            unit: String::new(),
            span: machine.span,
        });
        let all = (0..system.variables.len() as u32).map(VarId);
        let drives = all.filter(|v| system.driver(*v).is_none()).collect();
        system.components.push(Component {
            name: "caller".to_owned(),
            timing: Timing::Moore,
            drives,
            assumptions: Side::default(),
            guarantees: Side::default(),
            definitions: calls(machine, sequences, done, operation, place),
            completions: Side::default(),
        });
        let claim = Claim {
            goal: Side::default(),
            ..claim
        };
        Some(Self {
            system,
            claim,
            operation_assumptions,
            uncertain_assumptions,
            operation,
        })
    }

    /// Returns the operations requested on a run, as indices among the machine's operations.
    pub fn requested_operations(&self, machine: &Machine, run: &[Vec<i64>]) -> Vec<usize> {
        let is_done = |values: &[i64]| {
            let done = machine.done.as_ref();
            done.is_some_and(|d| linewright_core::gr1::eval::holds(d, values, &[]))
        };
        let begins = (0..run.len()).filter(|at| *at == 0 || is_done(&run[at - 1]));
        let value = |at: usize| run[at][self.operation.index()];
        let operation = |at| machine.operations.iter().position(|o| o.value == value(at));
        begins.filter_map(operation).collect()
    }
}

/// Returns the assumptions that mention the requested operation, without justice, and those of them
/// that also mention an unknown input.
fn operation_assumptions(
    system: &System,
    operation: VarId,
    unknown: &[VarId],
) -> (Vec<FormulaRef>, Vec<FormulaRef>) {
    let (mut found, mut uncertain) = (Vec::new(), Vec::new());
    for (place, component) in system.components.iter().enumerate() {
        for (kind, index, formula) in component.assumptions.formulas() {
            let (mut mentions_operation, mut is_uncertain) = (false, false);
            formula.expr.for_each_var(&mut |v, _| {
                mentions_operation |= v == operation;
                is_uncertain |= unknown.contains(&v);
            });
            let at = FormulaRef {
                component: Some(place),
                half: ContractSide::Assumptions,
                kind,
                index,
            };
            if mentions_operation && kind != FormulaKind::Justice {
                found.push(at);
                if is_uncertain {
                    uncertain.push(at);
                }
            }
        }
    }
    (found, uncertain)
}

/// Returns the definitions of the caller: the position in the sequences, and the operation
/// requested at each position.
fn calls(
    machine: &Machine,
    sequences: &[Vec<OperationRequest>],
    done: &Expr,
    operation: VarId,
    place: VarId,
) -> Side {
    let rule = |text: &str, expr: &Expr, span: Span| Formula {
        defines: false,
        name: "requests in sequences".to_owned(),
        requirement: None,
        expr: expr.simplify(),
        span,
        text: text.to_owned(),
    };
    let at = |value: usize| Expr::now(place).equals(Expr::Const(value as i64));
    let then = |value: usize| Expr::next(place).equals(Expr::Const(value as i64));
    let mut first = 0;
    let (mut starts, mut ends) = (Vec::new(), Vec::new());
    let (mut asks, mut moves) = (Expr::TRUE, Expr::TRUE);
    for sequence in sequences.iter().filter(|s| !s.is_empty()) {
        for (index, request) in sequence.iter().enumerate() {
            let here = at(first + index);
            let value = machine.operations[request.operation].value;
            let mut asks_here = Expr::now(operation).equals(Expr::Const(value));
            for (input, value) in &request.known {
                let input = Expr::now(VarId(*input as u32));
                asks_here = asks_here.and(input.equals(Expr::Const(*value)));
            }
            asks = asks.and(here.clone().implies(asks_here));
            if index + 1 < sequence.len() {
                moves = moves.and(here.implies(then(first + index + 1)));
            } else {
                ends.push(here);
            }
        }
        starts.push(first);
        first += sequence.len();
    }
    let any = |all: Vec<Expr>| all.into_iter().fold(Expr::FALSE, Expr::or);
    let anew = any(starts.iter().map(|s| then(*s)).collect());
    moves = moves.and(any(ends).implies(anew));
    let stays = Expr::next(place).equals(Expr::now(place));
    let moves = done
        .clone()
        .implies(moves)
        .and(done.clone().not().implies(stays));
    let span = machine.span;
    Side {
        initial: vec![rule(
            "a sequence begins",
            &any(starts.iter().map(|s| at(*s)).collect()),
            span,
        )],
        invariants: vec![rule("the operation at its current position", &asks, span)],
        safety: vec![rule(
            "the next position when an operation is done, and any sequence after the last",
            &moves,
            span,
        )],
        ..Side::default()
    }
}
