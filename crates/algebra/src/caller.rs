//! A machine and its caller: the operations that a line requests, against the assumptions that the
//! machine hands on to its caller.
//!
//! On its own, a machine may hand on its assumptions about the requested operations
//! ([`super::proof::Exports`]). In a line, operations are requested in sequences, one per part,
//! repeatedly and in any order of parts. This module adds a caller beside the components that does
//! exactly this and sets every input that the machine does not set. Then nothing is handed on any
//! more: an assumption is either proved, or there is a series of parts after which it is broken.

use super::machine::of_machine;
use super::proof::Claim;
use super::system::{ContractSide, FormulaRef, Part, System, formulas};
use linewright_core::gr1::{Domain, Expr, Formula, Owner, Side, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, PlantSource, PropertyKind, RealExpr};
use linewright_solver::game::RuleKind;

/// A machine with its caller, and what is to be shown about it.
#[derive(Debug, Clone)]
pub struct CalledMachine {
    /// The machine's components and the caller.
    pub system: System,
    /// Additional givens. The components' assumptions are to be shown.
    pub claim: Claim,
    /// The components' assumptions about the requested operations, except those about infinitely
    /// many calls.
    pub asked: Vec<FormulaRef>,
    /// Those of `asked` that depend on properties of parts, which are unknown here. If one is not
    /// shown, nothing is reported.
    pub unsure: Vec<FormulaRef>,
    /// Variable of the requested operation.
    pub operation: VarId,
}

/// A request for an operation.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct OperationRequest {
    /// Index among the machine's operations.
    pub operation: usize,
    /// Known values of other inputs while it runs, by index among the machine's plant inputs.
    pub known: Vec<(usize, i64)>,
}

impl OperationRequest {
    /// Creates a request with these values of parameters (index into the machine's properties,
    /// value). A property that no part carries here has its default; one that parts carry is
    /// unknown.
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
    /// Builds a machine that is called with these sequences of operations, one after the other.
    /// `None` if it has no assumptions about requested operations.
    pub fn of(machine: &Machine, sequences: &[Vec<OperationRequest>]) -> Option<Self> {
        let done = machine.done.as_ref()?;
        let mut plant = machine.plant.iter();
        let operation = plant.position(|p| matches!(p.source, PlantSource::Operation))?;
        let operation = VarId(operation as u32);
        let (mut system, claim) = of_machine(machine);
        let steps = || sequences.iter().flatten();
        let mut unknown: Vec<VarId> = Vec::new();
        for (place, input) in machine.plant.iter().enumerate() {
            let is_known = |asks: &OperationRequest| asks.known.iter().any(|(at, _)| *at == place);
            if matches!(input.source, PlantSource::Property(_)) && !steps().all(is_known) {
                unknown.push(VarId(place as u32));
            }
        }
        let (asked, unsure) = asked(&system, operation, &unknown);
        if asked.is_empty() || sequences.iter().all(Vec::is_empty) {
            return None;
        }
        // Nothing here is about justice.
        for part in &mut system.parts {
            part.assumptions.justice.clear();
            part.guarantees.justice.clear();
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
        system.parts.push(Part {
            name: "caller".to_owned(),
            timing: Timing::Moore,
            drives,
            assumptions: Side::default(),
            guarantees: Side::default(),
            definitions: calls(machine, sequences, done, operation, place),
        });
        let claim = Claim {
            goal: Side::default(),
            ..claim
        };
        Some(Self {
            system,
            claim,
            asked,
            unsure,
            operation,
        })
    }

    /// Returns the operations requested on a run, as indices into the machine's operations.
    pub fn asked_for(&self, machine: &Machine, run: &[Vec<i64>]) -> Vec<usize> {
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

/// Returns the assumptions that mention the requested operation, and those of them that also
/// mention something unknown.
fn asked(
    system: &System,
    operation: VarId,
    unknown: &[VarId],
) -> (Vec<FormulaRef>, Vec<FormulaRef>) {
    let (mut asked, mut unsure) = (Vec::new(), Vec::new());
    for (place, part) in system.parts.iter().enumerate() {
        for (kind, index, formula) in formulas(&part.assumptions) {
            let (mut speaks, mut is_unsure) = (false, false);
            formula.expr.for_each_var(&mut |v, _| {
                speaks |= v == operation;
                is_unsure |= unknown.contains(&v);
            });
            let at = FormulaRef {
                part: Some(place),
                half: ContractSide::Assumptions,
                kind,
                index,
            };
            if speaks && kind != RuleKind::Justice {
                asked.push(at);
                if is_unsure {
                    unsure.push(at);
                }
            }
        }
    }
    (asked, unsure)
}

/// Builds the sequences, one after the other: the position in them, and the operation there.
fn calls(
    machine: &Machine,
    sequences: &[Vec<OperationRequest>],
    done: &Expr,
    operation: VarId,
    place: VarId,
) -> Side {
    let rule = |text: &str, expr: &Expr, span: Span| Formula {
        defines: false,
        name: "asked in sequences".to_owned(),
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
        for (index, asked) in sequence.iter().enumerate() {
            let here = at(first + index);
            let value = machine.operations[asked.operation].value;
            let mut asks_here = Expr::now(operation).equals(Expr::Const(value));
            for (input, value) in &asked.known {
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
        invariants: vec![rule("the operation at the place in it", &asks, span)],
        safety: vec![rule(
            "the next one once an operation is done, and then any sequence",
            &moves,
            span,
        )],
        ..Side::default()
    }
}
