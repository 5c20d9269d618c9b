//! Monitors in operation: stepped along lassos, with the obligations evaluated in every step.

use super::circuit::{Circuit, Wire};
use super::words::{Lanes, Lassos, same};
use linewright::gr1::monitors::{Monitors, Obligation};
use linewright::gr1::{Expr, FormulaKind, Time, VarId};

/// The obligations of one formula by kind.
#[derive(Default)]
struct Wires {
    initial: Vec<Wire>,
    invariants: Vec<Wire>,
    safety: Vec<Wire>,
    justice: Vec<Wire>,
}

/// Monitors and two forms of one formula's obligations, as gates.
pub struct Player {
    circuit: Circuit,
    variables: usize,
    /// The first state input of each monitor, and the wires of its next value.
    states: Vec<(usize, Vec<Wire>)>,
    start: Vec<Lanes>,
    guaranteed: Wires,
    assumed: Wires,
    /// The values of an expression, if one is tracked.
    followed: Vec<(i64, Wire)>,
}

/// Lanes in which a formula's obligations are kept: as guarantees, and split up as assumptions.
pub struct Kept {
    pub guaranteed: Lanes,
    pub assumed: Lanes,
}

impl Player {
    /// Variables are `VarId(0)` and so on; the monitors' ids come after them.
    pub fn new(
        variables: usize,
        monitors: &Monitors,
        obligations: &[Obligation],
        followed: Option<&Expr>,
    ) -> Self {
        let mut circuit = Circuit::new();
        // Inputs: variables now, variables next, states.
        for v in 0..variables {
            circuit.declare(VarId(v as u32), Time::Now, v, 2);
            circuit.declare(VarId(v as u32), Time::Next, variables + v, 2);
        }
        let mut start = Vec::new();
        let lanes = |b: bool| if b { Lanes::ALL } else { Lanes::NONE };
        let mut firsts = Vec::new();
        for monitor in monitors.all() {
            let domain = &monitor.variable.domain;
            assert_eq!(domain.low(), 0);
            let first = 2 * variables + start.len();
            let size = domain.size() as i64;
            circuit.declare(monitor.id, Time::Now, first, size);
            firsts.push(first);
            if size == 2 {
                start.push(lanes(monitor.initial == 1));
            } else {
                start.extend((0..size).map(|x| lanes(x == monitor.initial)));
            }
        }
        let mut states = Vec::new();
        for (monitor, first) in monitors.all().iter().zip(firsts) {
            let value = circuit.value(&monitor.update);
            let domain = &monitor.variable.domain;
            let within = value.iter().all(|(x, w)| domain.contains(*x) || *w == 0);
            assert!(within, "{monitor:?} may leave its domain");
            let of = |x: i64| value.get(&x).copied().unwrap_or(0);
            let wires = if domain.size() == 2 {
                vec![of(1)]
            } else {
                (0..=domain.high()).map(of).collect()
            };
            states.push((first, wires));
        }
        let mut wires_of = |obligations: &[Obligation]| {
            let mut found = Wires::default();
            for obligation in obligations {
                let wire = circuit.truth(&obligation.expr);
                match obligation.kind {
                    FormulaKind::Initial => found.initial.push(wire),
                    FormulaKind::Invariant => found.invariants.push(wire),
                    FormulaKind::Safety => found.safety.push(wire),
                    FormulaKind::Justice => found.justice.push(wire),
                }
            }
            found
        };
        let guaranteed = wires_of(obligations);
        let assumed: Vec<Obligation> = obligations
            .iter()
            .flat_map(|o| monitors.as_assumptions(o))
            .collect();
        for obligation in &assumed {
            obligation.expr.for_each_var(&mut |v, time| {
                let monitor = monitors.get(v).is_some();
                let allowed = match obligation.kind {
                    FormulaKind::Initial | FormulaKind::Invariant => !monitor && time == Time::Now,
                    FormulaKind::Safety => !monitor || time == Time::Now,
                    FormulaKind::Justice => true,
                };
                assert!(allowed, "{obligation:?} mentions {v:?}");
            });
        }
        let assumed = wires_of(&assumed);
        let followed = followed.map(|e| circuit.value(e).into_iter().collect());
        Self {
            circuit,
            variables,
            states,
            start,
            guaranteed,
            assumed,
            followed: followed.unwrap_or_default(),
        }
    }

    fn inputs(&self, now: &[Lanes], next: &[Lanes], state: &[Lanes]) -> Vec<Lanes> {
        let mut inputs = Vec::with_capacity(2 * self.variables + state.len());
        inputs.extend_from_slice(now);
        inputs.extend_from_slice(next);
        inputs.extend_from_slice(state);
        inputs
    }

    fn advance(&self, wires: &[Lanes], state: &mut [Lanes]) {
        for (first, next) in &self.states {
            let first = first - 2 * self.variables;
            for (i, wire) in next.iter().enumerate() {
                state[first + i] = wires[*wire];
            }
        }
    }

    /// The values of the tracked expression in every step of the words, as pairs of a value and the
    /// lanes that have it.
    pub fn follow(&self, word: &[Vec<Lanes>]) -> Vec<Vec<(i64, Lanes)>> {
        let mut state = self.start.clone();
        let mut wires = Vec::new();
        let mut found = Vec::new();
        for letter in word {
            let inputs = self.inputs(letter, letter, &state);
            self.circuit.run(&inputs, &mut wires);
            let values = self.followed.iter();
            found.push(values.map(|(x, wire)| (*x, wires[*wire])).collect());
            self.advance(&wires, &mut state);
        }
        found
    }

    /// Whether the obligations are kept on the lassos. The cycle is repeated until the monitors'
    /// state at its head is an earlier one in every lane; then again, until each lane has returned
    /// to that state, and justice must have held meanwhile.
    pub fn kept(&self, lassos: &Lassos) -> Kept {
        let mut state = self.start.clone();
        let mut wires = Vec::new();
        let mut inputs = Vec::new();
        let mut kept = [Lanes::ALL; 2];
        let sides = [&self.guaranteed, &self.assumed];
        let mut just: [Vec<Lanes>; 2] = sides.map(|s| vec![Lanes::NONE; s.justice.len()]);
        let mut heads: Vec<Vec<Lanes>> = Vec::new();
        let (mut settled, mut returned) = (Lanes::NONE, Lanes::ALL);
        let mut head: Option<Vec<Lanes>> = None;
        let (mut position, mut first) = (0, true);
        loop {
            if position == lassos.back {
                let equal = |other: &Vec<Lanes>| {
                    let pairs = other.iter().zip(&state);
                    pairs.fold(Lanes::ALL, |all, (a, b)| all & same(*a, *b))
                };
                if let Some(head) = &head {
                    returned = returned | equal(head);
                    if returned == Lanes::ALL {
                        break;
                    }
                } else {
                    settled = heads.iter().fold(settled, |s, h| s | equal(h));
                    if settled == Lanes::ALL {
                        head = Some(state.clone());
                        returned = Lanes::NONE;
                    }
                    heads.push(state.clone());
                }
            }
            let next = lassos.after(position);
            inputs.clear();
            inputs.extend_from_slice(&lassos.letters[position]);
            inputs.extend_from_slice(&lassos.letters[next]);
            inputs.extend_from_slice(&state);
            self.circuit.run(&inputs, &mut wires);
            for (i, side) in sides.iter().enumerate() {
                let always = side.invariants.iter().chain(&side.safety);
                kept[i] = always.fold(kept[i], |k, wire| k & wires[*wire]);
                if first {
                    kept[i] = side.initial.iter().fold(kept[i], |k, w| k & wires[*w]);
                }
                if head.is_some() {
                    for (seen, wire) in just[i].iter_mut().zip(&side.justice) {
                        *seen = *seen | (!returned & wires[*wire]);
                    }
                }
            }
            self.advance(&wires, &mut state);
            position = next;
            first = false;
        }
        let [guaranteed, assumed] = [0, 1].map(|i| just[i].iter().fold(kept[i], |k, j| k & *j));
        Kept {
            guaranteed,
            assumed,
        }
    }
}
