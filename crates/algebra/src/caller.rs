//! A machine and who calls it: what a line asks for, against what the machine hands on to its
//! caller.
//!
//! A machine by itself may hand on what it assumes of the operations that it is asked for
//! ([`super::proof::Exports`]). In a line these come in sequences, one a part, again and again and
//! in any order of parts. With a part beside the components that calls so, and sets all that the
//! machine does not, nothing is handed on any more: it is shown, or there are parts after which it
//! is not kept.

use super::machine::of_machine;
use super::proof::Claim;
use super::system::{FormulaRef, Half, Part, System, formulas};
use linewright_core::gr1::{Domain, Expr, Formula, Owner, Side, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, PlantSource, PropertyKind, RealExpr};
use linewright_solver::game::RuleKind;

/// A machine that is called, and what is to be shown of it.
#[derive(Debug, Clone)]
pub struct Called {
    /// The machine's components, and who calls it.
    pub system: System,
    /// What is given beside; what is to be shown are the components' assumptions.
    pub claim: Claim,
    /// What its components assume of the operations that it is asked for. What is assumed of
    /// infinitely many calls is not among it.
    pub asked: Vec<FormulaRef>,
    /// Those of them that depend on properties of parts, of which nothing is known here: where they
    /// are not shown, nothing is said.
    pub unsure: Vec<FormulaRef>,
    /// Which operation is asked for.
    pub operation: VarId,
}

/// An operation that is asked for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Asks {
    /// By its index among the machine's operations.
    pub operation: usize,
    /// What is known of other inputs while it runs: by the places of the machine's plant inputs,
    /// their values.
    pub known: Vec<(usize, i64)>,
}

impl Asks {
    /// An operation with these values of parameters (index into the machine's properties, value).
    /// Of a property that no part carries here the default is known, of one that parts carry
    /// nothing is.
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

impl Called {
    /// A machine that is asked for one of these sequences of operations after the other. `None`
    /// where it assumes nothing about that.
    pub fn of(machine: &Machine, sequences: &[Vec<Asks>]) -> Option<Self> {
        let done = machine.done.as_ref()?;
        let mut plant = machine.plant.iter();
        let operation = plant.position(|p| matches!(p.source, PlantSource::Operation))?;
        let operation = VarId(operation as u32);
        let (mut system, claim) = of_machine(machine);
        let steps = || sequences.iter().flatten();
        let mut unknown: Vec<VarId> = Vec::new();
        for (place, input) in machine.plant.iter().enumerate() {
            let is_known = |asks: &Asks| asks.known.iter().any(|(at, _)| *at == place);
            if matches!(input.source, PlantSource::Property(_)) && !steps().all(is_known) {
                unknown.push(VarId(place as u32));
            }
        }
        let (asked, unsure) = asked(&system, operation, &unknown);
        if asked.is_empty() || sequences.iter().all(Vec::is_empty) {
            return None;
        }
        // Nothing here is about what comes again and again.
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

    /// The operations that are asked for on a run, as indices into the machine's operations.
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

/// Assumptions that speak of the operation that is asked for, and those of them that speak of
/// something unknown as well.
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
                half: Half::Assumptions,
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

/// One sequence after the other: the place in them, and the operation that stands there.
fn calls(
    machine: &Machine,
    sequences: &[Vec<Asks>],
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
