//! Expressions as gates over lanes: an integer is one wire per value.

use super::words::Lanes;
use linewright::gr1::{BinaryOp, Expr, Time, UnaryOp, VarId, eval};
use std::collections::{BTreeMap, HashMap};

/// The number of a gate.
pub type Wire = usize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Gate {
    False,
    Input(usize),
    Not(Wire),
    And(Wire, Wire),
    Or(Wire, Wire),
}

/// A value: for each possible integer, the wire that is true for it.
type Value = BTreeMap<i64, Wire>;

/// Gates, each after those it reads.
pub struct Circuit {
    gates: Vec<Gate>,
    known: HashMap<Gate, Wire>,
    /// The first input of a variable's values, and their number (from 0; a boolean has one input
    /// for true).
    inputs: HashMap<(VarId, Time), (usize, i64)>,
}

impl Circuit {
    pub fn new() -> Self {
        let gates = vec![Gate::False];
        Self {
            gates,
            known: HashMap::new(),
            inputs: HashMap::new(),
        }
    }

    /// Declares the inputs for a variable's values: one input if it has two values, otherwise one
    /// per value.
    pub fn declare(&mut self, variable: VarId, time: Time, first: usize, values: i64) {
        self.inputs.insert((variable, time), (first, values));
    }

    fn gate(&mut self, gate: Gate) -> Wire {
        match gate {
            Gate::Not(a) => {
                if let Gate::Not(b) = self.gates[a] {
                    return b;
                }
            }
            Gate::False | Gate::And(0, _) | Gate::And(_, 0) => return 0,
            Gate::Or(0, a) | Gate::Or(a, 0) => return a,
            Gate::And(a, b) | Gate::Or(a, b) if a == b => return a,
            _ => {}
        }
        let gates = &mut self.gates;
        *self.known.entry(gate).or_insert_with(|| {
            gates.push(gate);
            gates.len() - 1
        })
    }

    fn number(&mut self, truth: Wire) -> Value {
        let not = self.gate(Gate::Not(truth));
        BTreeMap::from([(0, not), (1, truth)])
    }

    fn join(&mut self, pairs: Vec<(i64, Wire)>) -> Value {
        let mut value = Value::new();
        for (x, wire) in pairs {
            let before = value.get(&x).copied().unwrap_or(0);
            let wire = self.gate(Gate::Or(before, wire));
            value.insert(x, wire);
        }
        value
    }

    /// The wire of a boolean expression.
    pub fn truth(&mut self, expr: &Expr) -> Wire {
        let value = self.value(expr);
        value.get(&1).copied().unwrap_or(0)
    }

    /// The wires of an expression's values.
    pub fn value(&mut self, expr: &Expr) -> Value {
        match expr {
            Expr::Const(c) => {
                let always = self.gate(Gate::Not(0));
                BTreeMap::from([(*c, always)])
            }
            Expr::Var(v, time) => {
                let (first, values) = self.inputs[&(*v, *time)];
                if values == 2 {
                    let wire = self.gate(Gate::Input(first));
                    return self.number(wire);
                }
                let wires = (0..values).map(|x| (x, Gate::Input(first + x as usize)));
                wires.map(|(x, gate)| (x, self.gate(gate))).collect()
            }
            Expr::Unary(UnaryOp::Not, a) => {
                let wire = self.truth(a);
                let wire = self.gate(Gate::Not(wire));
                self.number(wire)
            }
            Expr::Unary(op, a) => {
                let a = self.value(a).into_iter();
                let pairs = a.map(|(x, wire)| (eval::unary(*op, x), wire)).collect();
                self.join(pairs)
            }
            Expr::Binary(op @ (BinaryOp::And | BinaryOp::Or | BinaryOp::Implies), a, b) => {
                let (a, b) = (self.truth(a), self.truth(b));
                let wire = match op {
                    BinaryOp::And => self.gate(Gate::And(a, b)),
                    BinaryOp::Or => self.gate(Gate::Or(a, b)),
                    _ => {
                        let not = self.gate(Gate::Not(a));
                        self.gate(Gate::Or(not, b))
                    }
                };
                self.number(wire)
            }
            Expr::Binary(op, a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                let mut pairs = Vec::new();
                for (x, wire) in &a {
                    for (y, other) in &b {
                        let both = self.gate(Gate::And(*wire, *other));
                        pairs.push((eval::binary(*op, *x, *y), both));
                    }
                }
                self.join(pairs)
            }
            Expr::If(c, a, b) => {
                let c = self.truth(c);
                let not = self.gate(Gate::Not(c));
                let (a, b) = (self.value(a), self.value(b));
                let mut pairs = Vec::new();
                for (value, condition) in [(a, c), (b, not)] {
                    for (x, wire) in value {
                        pairs.push((x, self.gate(Gate::And(condition, wire))));
                    }
                }
                self.join(pairs)
            }
        }
    }

    /// The values of all wires.
    pub fn run(&self, inputs: &[Lanes], wires: &mut Vec<Lanes>) {
        wires.clear();
        for gate in &self.gates {
            let value = match *gate {
                Gate::False => Lanes::NONE,
                Gate::Input(i) => inputs[i],
                Gate::Not(a) => !wires[a],
                Gate::And(a, b) => wires[a] & wires[b],
                Gate::Or(a, b) => wires[a] | wires[b],
            };
            wires.push(value);
        }
    }
}

/// The gates compared with direct evaluation, with every operator that a lowering uses.
#[test]
fn gates_compute_what_expressions_mean() {
    let (a, b) = (VarId(0), VarId(1));
    let mut circuit = Circuit::new();
    circuit.declare(a, Time::Now, 0, 2);
    circuit.declare(b, Time::Now, 1, 5);
    let var = |v| Box::new(Expr::now(v));
    let less = Expr::binary(BinaryOp::Sub, Expr::now(b), Expr::Const(1));
    let sum = Expr::binary(BinaryOp::Add, Expr::now(b), Expr::now(a));
    let expressions = [
        Expr::If(
            var(a),
            Box::new(less.clone()),
            Box::new(Expr::binary(BinaryOp::Min, sum.clone(), Expr::Const(3))),
        ),
        Expr::binary(BinaryOp::Max, less, Expr::Const(0)),
        Expr::now(a).implies(sum.clone().equals(Expr::Const(2))),
        Expr::binary(BinaryOp::Gt, sum, Expr::Const(2))
            .not()
            .and(Expr::now(a)),
    ];
    let values: Vec<Value> = expressions.iter().map(|e| circuit.value(e)).collect();
    for x in 0..2 {
        for y in 0..5 {
            let lanes = |b: bool| if b { Lanes::ALL } else { Lanes::NONE };
            let inputs: Vec<Lanes> = std::iter::once(lanes(x == 1))
                .chain((0..5).map(|i| lanes(i == y)))
                .collect();
            let mut wires = Vec::new();
            circuit.run(&inputs, &mut wires);
            for (expr, value) in expressions.iter().zip(&values) {
                let expected = eval::eval(expr, &[x, y], &[]);
                for (number, wire) in value {
                    assert_eq!(wires[*wire], lanes(*number == expected), "{expr:?}");
                }
                assert!(value.contains_key(&expected), "{expr:?}");
            }
        }
    }
}
