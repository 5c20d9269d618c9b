//! Formulas as gates over tests of single variables, for formats without arithmetic.
//!
//! A comparison is decided variable by variable. Each value of the first variable is substituted,
//! the remaining formula is simplified, and values with the same remaining formula are grouped.
//! `x' = min(x + 1, 5)` becomes one case per value of `x'`, each with a range of values of `x`.
//! Remaining formulas are memoized, so the cost of a sum of many variables grows with the number of
//! distinct sums, not of valuations. The method is sound for all operators, but too expensive for
//! two numbers with thousands of values; formulas with such numbers are refused.

use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Formula, Specification, Time, UnaryOp, VarId};
use std::collections::{BTreeMap, HashMap};

/// Maximum number of values tried for one formula.
const MAX_TRIALS: u64 = 1 << 18;

/// Index of a gate in a [`Gates`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Gate(u32);

/// Operator and operands of a gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Shape {
    Const(bool),
    /// The variable's value is in `low..=high`, which is neither empty nor the whole domain.
    Within(VarId, Time, i64, i64),
    /// A bit of a variable, counted from the lowest one.
    Bit(VarId, Time, u32),
    Not(Gate),
    And(Gate, Gate),
    Or(Gate, Gate),
    /// Exclusive or.
    Xor(Gate, Gate),
}

/// The error for a formula with too many cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TooManyCases;

impl TooManyCases {
    pub fn finding(formula: &Formula) -> Diagnostic {
        Diagnostic::error(
            codes::TOO_LARGE,
            formula.span,
            format!(
                "`{}` has too many cases to be written without arithmetic",
                formula.name
            ),
        )
        .with_help("make the domains of its numbers smaller")
    }
}

/// Gates, without duplicates.
#[derive(Debug, Default)]
pub(super) struct Gates {
    shapes: Vec<Shape>,
    known: HashMap<Shape, Gate>,
    decided: HashMap<Expr, Gate>,
    trials: u64,
}

impl Gates {
    pub fn shape(&self, gate: Gate) -> Shape {
        self.shapes[gate.0 as usize]
    }

    fn gate(&mut self, shape: Shape) -> Gate {
        if let Some(gate) = self.known.get(&shape) {
            return *gate;
        }
        self.shapes.push(shape);
        let gate = Gate(self.shapes.len() as u32 - 1);
        self.known.insert(shape, gate);
        gate
    }

    fn constant(&self, gate: Gate) -> Option<bool> {
        match self.shape(gate) {
            Shape::Const(value) => Some(value),
            _ => None,
        }
    }

    pub fn bool(&mut self, value: bool) -> Gate {
        self.gate(Shape::Const(value))
    }

    pub fn bit(&mut self, v: VarId, time: Time, k: u32) -> Gate {
        self.gate(Shape::Bit(v, time, k))
    }

    pub fn not(&mut self, a: Gate) -> Gate {
        match self.shape(a) {
            Shape::Const(value) => self.bool(!value),
            Shape::Not(inner) => inner,
            _ => self.gate(Shape::Not(a)),
        }
    }

    pub fn and(&mut self, a: Gate, b: Gate) -> Gate {
        match (self.constant(a), self.constant(b)) {
            (Some(false), _) | (_, Some(true)) => a,
            (Some(true), _) | (_, Some(false)) => b,
            _ if a == b => a,
            _ => self.gate(Shape::And(a, b)),
        }
    }

    pub fn or(&mut self, a: Gate, b: Gate) -> Gate {
        match (self.constant(a), self.constant(b)) {
            (Some(true), _) | (_, Some(false)) => a,
            (Some(false), _) | (_, Some(true)) => b,
            _ if a == b => a,
            _ => self.gate(Shape::Or(a, b)),
        }
    }

    pub fn xor(&mut self, a: Gate, b: Gate) -> Gate {
        match (self.constant(a), self.constant(b)) {
            (Some(false), _) => b,
            (_, Some(false)) => a,
            (Some(true), _) => self.not(b),
            (_, Some(true)) => self.not(a),
            _ => self.gate(Shape::Xor(a, b)),
        }
    }

    /// The gate of a formula. The number of values tried is counted from 0 for each formula.
    pub fn formula(
        &mut self,
        specification: &Specification,
        expr: &Expr,
    ) -> Result<Gate, TooManyCases> {
        self.trials = 0;
        self.truth(specification, &expr.simplify())
    }

    fn truth(&mut self, s: &Specification, expr: &Expr) -> Result<Gate, TooManyCases> {
        Ok(match expr {
            Expr::Const(value) => self.bool(*value != 0),
            Expr::Unary(UnaryOp::Not, a) => {
                let a = self.truth(s, a)?;
                self.not(a)
            }
            Expr::Binary(BinaryOp::And, a, b) => {
                let (a, b) = (self.truth(s, a)?, self.truth(s, b)?);
                self.and(a, b)
            }
            Expr::Binary(BinaryOp::Or, a, b) => {
                let (a, b) = (self.truth(s, a)?, self.truth(s, b)?);
                self.or(a, b)
            }
            Expr::Binary(BinaryOp::Implies, a, b) => {
                let (a, b) = (self.truth(s, a)?, self.truth(s, b)?);
                let a = self.not(a);
                self.or(a, b)
            }
            Expr::Binary(op @ (BinaryOp::Eq | BinaryOp::Ne), a, b)
                if is_truth(s, a) && is_truth(s, b) =>
            {
                let (a, b) = (self.truth(s, a)?, self.truth(s, b)?);
                let differ = self.xor(a, b);
                match op {
                    BinaryOp::Ne => differ,
                    _ => self.not(differ),
                }
            }
            Expr::If(c, a, b) if is_truth(s, a) && is_truth(s, b) => {
                let (c, a, b) = (self.truth(s, c)?, self.truth(s, a)?, self.truth(s, b)?);
                let yes = self.and(c, a);
                let c = self.not(c);
                let no = self.and(c, b);
                self.or(yes, no)
            }
            _ => self.decide(s, expr)?,
        })
    }

    /// The gate of a comparison. Tries all values of its first variable.
    fn decide(&mut self, s: &Specification, expr: &Expr) -> Result<Gate, TooManyCases> {
        if let Expr::Const(value) = expr {
            return Ok(self.bool(*value != 0));
        }
        if let Some(gate) = self.decided.get(expr) {
            return Ok(*gate);
        }
        let mut first = None;
        expr.for_each_var(&mut |v, t| {
            first.get_or_insert((v, t));
        });
        let Some((v, t)) = first else {
            // No variable is left, but `simplify` does not fold constants that overflow or divide
            // by zero.
            return Err(TooManyCases);
        };
        let domain = &s.variable(v).domain;
        self.trials += domain.size();
        if self.trials > MAX_TRIALS {
            return Err(TooManyCases);
        }
        // For each remaining formula, the ranges of values that lead to it, in order of first
        // occurrence.
        let mut places: HashMap<Expr, usize> = HashMap::new();
        let mut cases: Vec<(Expr, Vec<(i64, i64)>)> = Vec::new();
        for value in domain.low()..=domain.high() {
            let rest = expr
                .substitute(&mut |w, u| {
                    if (w, u) == (v, t) {
                        Expr::Const(value)
                    } else {
                        Expr::Var(w, u)
                    }
                })
                .simplify();
            let place = *places.entry(rest.clone()).or_insert_with(|| {
                cases.push((rest, Vec::new()));
                cases.len() - 1
            });
            match cases[place].1.last_mut() {
                Some((_, high)) if *high + 1 == value => *high = value,
                _ => cases[place].1.push((value, value)),
            }
        }
        let mut options = Vec::new();
        for (rest, ranges) in cases {
            let rest = self.decide(s, &rest)?;
            if self.constant(rest) == Some(false) {
                continue;
            }
            let tests: Vec<Gate> = ranges
                .into_iter()
                .map(|(l, h)| self.within(v, t, l, h, domain))
                .collect();
            let tests = self.any(tests);
            options.push(self.and(tests, rest));
        }
        let gate = self.any(options);
        self.decided.insert(expr.clone(), gate);
        Ok(gate)
    }

    fn within(&mut self, v: VarId, t: Time, low: i64, high: i64, domain: &Domain) -> Gate {
        if low == domain.low() && high == domain.high() {
            self.bool(true)
        } else {
            self.gate(Shape::Within(v, t, low, high))
        }
    }

    /// The disjunction of the gates, as a balanced tree.
    pub fn any(&mut self, mut gates: Vec<Gate>) -> Gate {
        while gates.len() > 1 {
            gates = gates
                .chunks(2)
                .map(|pair| match *pair {
                    [a, b] => self.or(a, b),
                    _ => pair[0],
                })
                .collect();
        }
        gates.pop().unwrap_or_else(|| self.bool(false))
    }

    /// The operands of nested conjunctions, in order.
    pub fn conjuncts(&self, root: Gate) -> Vec<Gate> {
        self.operands(root, |shape| match shape {
            Shape::And(a, b) => Some((a, b)),
            _ => None,
        })
    }

    /// The operands of nested disjunctions, in order.
    pub fn disjuncts(&self, root: Gate) -> Vec<Gate> {
        self.operands(root, |shape| match shape {
            Shape::Or(a, b) => Some((a, b)),
            _ => None,
        })
    }

    fn operands(&self, root: Gate, taken: impl Fn(Shape) -> Option<(Gate, Gate)>) -> Vec<Gate> {
        let (mut found, mut open) = (Vec::new(), vec![root]);
        while let Some(gate) = open.pop() {
            match taken(self.shape(gate)) {
                Some((a, b)) => open.extend([b, a]),
                None => found.push(gate),
            }
        }
        found
    }

    /// For `root` and each gate below it, the number of its uses.
    pub fn uses(&self, root: Gate) -> BTreeMap<Gate, u64> {
        let mut uses = BTreeMap::new();
        let mut open = vec![root];
        while let Some(gate) = open.pop() {
            let count: &mut u64 = uses.entry(gate).or_default();
            *count += 1;
            if *count == 1 {
                match self.shape(gate) {
                    Shape::Not(a) => open.push(a),
                    Shape::And(a, b) | Shape::Or(a, b) | Shape::Xor(a, b) => open.extend([a, b]),
                    _ => {}
                }
            }
        }
        uses
    }

    /// Number of gates in the tree of `root`, where a shared gate counts once for each use.
    pub fn tree_size(&self, root: Gate) -> u64 {
        // Gates are numbered after their operands.
        let mut sizes: BTreeMap<Gate, u64> = BTreeMap::new();
        for gate in self.uses(root).into_keys() {
            let size = |g: Gate| sizes.get(&g).copied().unwrap_or(1);
            let own = match self.shape(gate) {
                Shape::Not(a) => size(a).saturating_add(1),
                Shape::And(a, b) | Shape::Or(a, b) => {
                    size(a).saturating_add(size(b)).saturating_add(1)
                }
                Shape::Xor(a, b) => size(a).saturating_add(size(b)).saturating_add(1),
                _ => 1,
            };
            sizes.insert(gate, own);
        }
        sizes.get(&root).copied().unwrap_or(1)
    }
}

/// Whether the expression is a truth value. The constants 0 and 1 count as truth values.
pub(crate) fn is_truth(specification: &Specification, expr: &Expr) -> bool {
    use BinaryOp as B;
    match expr {
        Expr::Const(value) => *value == 0 || *value == 1,
        Expr::Var(v, _) => specification.variable(*v).domain == Domain::Bool,
        Expr::Unary(op, _) => *op == UnaryOp::Not,
        Expr::Binary(op, ..) => !matches!(
            op,
            B::Add | B::Sub | B::Mul | B::Div | B::Mod | B::Min | B::Max
        ),
        Expr::If(_, a, b) => is_truth(specification, a) && is_truth(specification, b),
    }
}
