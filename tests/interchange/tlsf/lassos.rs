//! What formulas become, compared with their meaning on lassos: runs that are a finite prefix and a
//! repeated part.

use super::{file, read_text, shown, sound};
use linewright::gr1::eval::{eval, holds};
use linewright::gr1::{BinaryOp, Expr, Formula, Specification, Time, VarId};
use std::collections::BTreeMap;
use std::fmt;

/// A formula over `a`, an input, and `b`, an output.
#[derive(Debug, Clone)]
pub enum L {
    A,
    B,
    Not(Box<L>),
    And(Box<L>, Box<L>),
    Or(Box<L>, Box<L>),
    Implies(Box<L>, Box<L>),
    Iff(Box<L>, Box<L>),
    X(Box<L>),
    F(Box<L>),
    G(Box<L>),
    U(Box<L>, Box<L>),
    W(Box<L>, Box<L>),
    R(Box<L>, Box<L>),
}

impl fmt::Display for L {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::A => write!(f, "a"),
            Self::B => write!(f, "b"),
            Self::Not(x) => write!(f, "!({x})"),
            Self::And(x, y) => write!(f, "(({x}) && ({y}))"),
            Self::Or(x, y) => write!(f, "(({x}) || ({y}))"),
            Self::Implies(x, y) => write!(f, "(({x}) -> ({y}))"),
            Self::Iff(x, y) => write!(f, "(({x}) <-> ({y}))"),
            Self::X(x) => write!(f, "X ({x})"),
            Self::F(x) => write!(f, "F ({x})"),
            Self::G(x) => write!(f, "G ({x})"),
            Self::U(x, y) => write!(f, "(({x}) U ({y}))"),
            Self::W(x, y) => write!(f, "(({x}) W ({y}))"),
            Self::R(x, y) => write!(f, "(({x}) R ({y}))"),
        }
    }
}

/// Steps as values of `a` (1) and `b` (2), and the step that follows the last one.
#[derive(Debug, Clone)]
struct Lasso {
    steps: Vec<u8>,
    back: usize,
}

impl Lasso {
    fn next(&self, t: usize) -> usize {
        if t + 1 < self.steps.len() {
            t + 1
        } else {
            self.back
        }
    }
}

impl L {
    /// Its value in every step, by definition.
    fn on(&self, run: &Lasso) -> Vec<bool> {
        let n = run.steps.len();
        let two = |x: &L, y: &L, op: &dyn Fn(bool, bool) -> bool| -> Vec<bool> {
            x.on(run)
                .into_iter()
                .zip(y.on(run))
                .map(|(a, b)| op(a, b))
                .collect()
        };
        // Least or greatest solution of `v = step(v of the next step)`.
        let solve = |start: bool, step: &dyn Fn(usize, bool) -> bool| {
            let mut v = vec![start; n];
            for _ in 0..=n {
                for t in (0..n).rev() {
                    v[t] = step(t, v[run.next(t)]);
                }
            }
            v
        };
        match self {
            Self::A => run.steps.iter().map(|s| s & 1 != 0).collect(),
            Self::B => run.steps.iter().map(|s| s & 2 != 0).collect(),
            Self::Not(x) => x.on(run).into_iter().map(|v| !v).collect(),
            Self::And(x, y) => two(x, y, &|a, b| a && b),
            Self::Or(x, y) => two(x, y, &|a, b| a || b),
            Self::Implies(x, y) => two(x, y, &|a, b| !a || b),
            Self::Iff(x, y) => two(x, y, &|a, b| a == b),
            Self::X(x) => {
                let x = x.on(run);
                (0..n).map(|t| x[run.next(t)]).collect()
            }
            Self::F(x) => {
                let x = x.on(run);
                solve(false, &|t, next| x[t] || next)
            }
            Self::G(x) => {
                let x = x.on(run);
                solve(true, &|t, next| x[t] && next)
            }
            Self::U(x, y) => {
                let (x, y) = (x.on(run), y.on(run));
                solve(false, &|t, next| y[t] || x[t] && next)
            }
            Self::W(x, y) => {
                let (x, y) = (x.on(run), y.on(run));
                solve(true, &|t, next| y[t] || x[t] && next)
            }
            Self::R(x, y) => {
                let (x, y) = (x.on(run), y.on(run));
                solve(true, &|t, next| y[t] && (x[t] || next))
            }
        }
    }

    /// Whether it mentions the output.
    pub fn mentions_b(&self) -> bool {
        self.to_string().contains('b')
    }

    /// Its value in the first of two steps, which is as far as it refers.
    pub fn on_two(&self, now: u8, next: u8) -> bool {
        let run = Lasso {
            steps: vec![now, next],
            back: 1,
        };
        self.on(&run)[0]
    }
}

pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, n: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    pub fn formula(&mut self, depth: u32) -> L {
        let one = |d: &mut Self| Box::new(d.formula(depth - 1));
        if depth == 0 {
            return if self.below(2) == 0 { L::A } else { L::B };
        }
        match self.below(14) {
            0 => L::A,
            1 => L::B,
            2 => L::Not(one(self)),
            3 => L::And(one(self), one(self)),
            4 => L::Or(one(self), one(self)),
            5 | 6 => L::Implies(one(self), one(self)),
            7 => L::Iff(one(self), one(self)),
            8 => L::X(one(self)),
            9 => L::F(one(self)),
            10 => L::G(one(self)),
            11 => L::U(one(self), one(self)),
            12 => L::W(one(self), one(self)),
            _ => L::R(one(self), one(self)),
        }
    }

    /// A formula about a step and the next one.
    pub fn step(&mut self, depth: u32, next: bool) -> L {
        let one = |d: &mut Self| Box::new(d.step(depth - 1, next));
        let leaf = |d: &mut Self| {
            let v = if d.below(2) == 0 { L::A } else { L::B };
            if next && d.below(2) == 0 {
                L::X(Box::new(v))
            } else {
                v
            }
        };
        if depth == 0 {
            return leaf(self);
        }
        match self.below(7) {
            0 | 1 => leaf(self),
            2 => L::Not(one(self)),
            3 => L::And(one(self), one(self)),
            4 => L::Or(one(self), one(self)),
            5 => L::Implies(one(self), one(self)),
            _ => L::Iff(one(self), one(self)),
        }
    }

    fn lasso(&mut self, longest: u64) -> Lasso {
        let n = 1 + self.below(longest);
        Lasso {
            steps: (0..n).map(|_| self.below(4) as u8).collect(),
            back: self.below(n) as usize,
        }
    }
}

fn all_lassos(longest: u32) -> Vec<Lasso> {
    let mut found = Vec::new();
    for n in 1..=longest {
        for word in 0..4_u32.pow(n) {
            let steps: Vec<u8> = (0..n).map(|k| (word >> (2 * k) & 3) as u8).collect();
            found.extend((0..n as usize).map(|back| Lasso {
                steps: steps.clone(),
                back,
            }));
        }
    }
    found
}

/// A specification as a judge of runs: monitors are computed, a broken promise is admitted never or
/// from the beginning.
struct Judge {
    specification: Specification,
    initial: BTreeMap<VarId, i64>,
    updates: BTreeMap<VarId, Expr>,
    broken: Option<VarId>,
}

impl Judge {
    fn new(specification: Specification) -> Self {
        let internal = |v: &VarId| specification.variable(*v).internal;
        let (mut initial, mut updates) = (BTreeMap::new(), BTreeMap::new());
        for f in &specification.guarantees.safety {
            if let Expr::Binary(BinaryOp::Eq, left, update) = &f.expr
                && let Expr::Var(v, Time::Next) = **left
                && internal(&v)
            {
                updates.insert(v, (**update).clone());
            }
        }
        for f in &specification.guarantees.initial {
            if let Expr::Binary(BinaryOp::Eq, left, value) = &f.expr
                && let (Expr::Var(v, Time::Now), Expr::Const(value)) = (&**left, &**value)
                && internal(v)
            {
                initial.insert(*v, *value);
            }
        }
        let all = (0..specification.variables.len() as u32).map(VarId);
        let broken = all.filter(internal).find(|v| !updates.contains_key(v));
        Self {
            specification,
            initial,
            updates,
            broken,
        }
    }

    fn accepts(&self, run: &Lasso) -> bool {
        self.accepts_while(run, &[])
    }

    /// With constant values for the elements of a bus `c`.
    fn accepts_while(&self, run: &Lasso, c: &[bool]) -> bool {
        [0, 1]
            .into_iter()
            .any(|broken| self.accepts_with(run, broken, c))
    }

    fn accepts_with(&self, run: &Lasso, broken: i64, c: &[bool]) -> bool {
        let s = &self.specification;
        let mut values: Vec<i64> = vec![0; s.variables.len()];
        for (v, value) in &self.initial {
            values[v.index()] = *value;
        }
        if let Some(v) = self.broken {
            values[v.index()] = broken;
        }
        let (mut rows, mut seen, mut t) = (Vec::new(), BTreeMap::new(), 0);
        let start = loop {
            for (k, variable) in s.variables.iter().enumerate() {
                match variable.name.as_str() {
                    "a" => values[k] = i64::from(run.steps[t] & 1 != 0),
                    "b" => values[k] = i64::from(run.steps[t] & 2 != 0),
                    name => {
                        let element = name.strip_prefix("c[").and_then(|n| n.strip_suffix(']'));
                        let element = element.and_then(|n| n.parse::<usize>().ok());
                        if let Some(value) = element.and_then(|n| c.get(n)) {
                            values[k] = i64::from(*value);
                        }
                    }
                }
            }
            if let Some(start) = seen.insert((t, values.clone()), rows.len()) {
                break start;
            }
            rows.push(values.clone());
            let next: Vec<(VarId, i64)> = self
                .updates
                .iter()
                .map(|(v, e)| (*v, eval(e, &values, &[])))
                .collect();
            for (v, value) in next {
                values[v.index()] = value;
            }
            t = run.next(t);
        };
        let after = |t: usize| {
            if t + 1 < rows.len() {
                &rows[t + 1]
            } else {
                &rows[start]
            }
        };
        let every = |list: &[Formula]| {
            list.iter()
                .all(|f| (0..rows.len()).all(|t| holds(&f.expr, &rows[t], after(t))))
        };
        let safe = |side: &linewright::gr1::Side| {
            side.initial.iter().all(|f| holds(&f.expr, &rows[0], &[]))
                && every(&side.invariants)
                && every(&side.safety)
        };
        let fair = |side: &linewright::gr1::Side| {
            side.justice
                .iter()
                .all(|f| (start..rows.len()).any(|t| holds(&f.expr, &rows[t], after(t))))
        };
        let (assumed, promised) = (&s.assumptions, &s.guarantees);
        !safe(assumed) || (safe(promised) && (!fair(assumed) || fair(promised)))
    }
}

const SIGNALS: &str = "INPUTS { a; } OUTPUTS { b; }";

fn same(text: &str, wanted: &L, runs: &[Lasso]) -> bool {
    let reading = read_text(text);
    let Some(specification) = reading.specification else {
        assert!(
            reading
                .findings
                .iter()
                .all(|f| matches!(f.code.id, "LW201" | "LW202")),
            "{text}\n{}",
            shown(&read_text(text), text)
        );
        return false;
    };
    let judge = Judge::new(specification);
    for run in runs {
        assert_eq!(
            judge.accepts(run),
            wanted.on(run)[0],
            "{wanted}\n{run:?}\n{text}\n{:#?}",
            judge.specification
        );
    }
    true
}

/// Random promises alone: what is accepted means the same on all lassos up to length 4 and on
/// longer ones.
#[test]
fn random_promises() {
    let short = all_lassos(4);
    let (mut dice, mut accepted) = (Dice(1), 0);
    for _ in 0..4000 {
        let formula = dice.formula(4);
        let mut runs: Vec<Lasso> = (0..100).map(|_| dice.lasso(6)).collect();
        runs.extend((0..150).map(|_| short[dice.below(short.len() as u64) as usize].clone()));
        let main = format!("{SIGNALS} GUARANTEE {{ {formula}; }}");
        accepted += u32::from(same(&file("Mealy", "Mealy", &main), &formula, &runs));
    }
    println!("{accepted} of 4000 accepted");
    assert!(accepted > 1500, "{accepted}");
}

/// Random assumptions and promises: a plain file is their implication.
#[test]
fn random_implications() {
    let (mut dice, mut accepted) = (Dice(2), 0);
    for round in 0..3000 {
        let (p, q) = (dice.formula(3), dice.formula(3));
        let runs: Vec<Lasso> = (0..200).map(|_| dice.lasso(6)).collect();
        let main = format!("{SIGNALS} ASSUME {{ {p}; }} GUARANTEE {{ {q}; }}");
        let whole = L::Implies(Box::new(p), Box::new(q));
        let semantics = if round % 2 == 0 { "Mealy" } else { "Moore" };
        accepted += u32::from(same(&file(semantics, semantics, &main), &whole, &runs));
    }
    println!("{accepted} of 3000 accepted");
    assert!(accepted > 1000, "{accepted}");
}

fn n(x: L) -> L {
    L::Not(Box::new(x))
}
fn x(y: L) -> L {
    L::X(Box::new(y))
}
fn f(y: L) -> L {
    L::F(Box::new(y))
}
fn g(y: L) -> L {
    L::G(Box::new(y))
}
fn imp(p: L, q: L) -> L {
    L::Implies(Box::new(p), Box::new(q))
}
fn and(p: L, q: L) -> L {
    L::And(Box::new(p), Box::new(q))
}
fn or(p: L, q: L) -> L {
    L::Or(Box::new(p), Box::new(q))
}
fn w(p: L, q: L) -> L {
    L::W(Box::new(p), Box::new(q))
}

/// The forms that must be accepted, on all lassos up to length 6.
#[test]
fn accepted_forms() {
    use L::{A, B};
    let chain = w(n(B), and(A, x(w(n(B), and(A, x(w(n(B), A)))))));
    let forms = [
        g(imp(A, x(B))),
        g(imp(A, f(B))),
        g(imp(A, x(x(f(B))))),
        g(imp(A, x(x(x(B))))),
        g(imp(and(A, x(n(A))), x(x(B)))),
        g(and(imp(A, x(B)), and(imp(n(A), B), imp(B, f(A))))),
        g(f(and(A, x(B)))),
        g(imp(A, x(w(n(B), A)))),
        g(imp(A, x(chain.clone()))),
        chain,
        g(imp(A, L::U(Box::new(n(B)), Box::new(and(A, B))))),
        g(imp(A, x(L::R(Box::new(A), Box::new(B))))),
        g(imp(A, x(L::U(Box::new(B), Box::new(and(B, x(A))))))),
        L::U(Box::new(A), Box::new(B)),
        f(and(A, x(x(B)))),
        x(x(B)),
        x(g(imp(A, f(B)))),
        n(f(g(n(B)))),
        imp(g(f(A)), g(f(B))),
        imp(
            and(g(f(A)), g(imp(A, x(n(A))))),
            and(g(f(B)), g(imp(B, x(n(B))))),
        ),
        L::Or(Box::new(g(A)), Box::new(f(B))),
        L::Or(Box::new(f(g(A))), Box::new(g(f(B)))),
        // Given safety, an answer starting in different steps, long-run properties.
        imp(g(imp(A, x(w(n(A), n(B))))), g(imp(B, f(A)))),
        imp(and(g(imp(A, w(B, A))), g(f(A))), and(g(n(B)), f(B))),
        or(g(imp(A, w(B, A))), f(B)),
        f(and(A, x(L::U(Box::new(B), Box::new(n(A)))))),
        f(and(A, x(f(B)))),
        g(imp(A, or(x(x(f(B))), f(and(B, n(A)))))),
        g(or(imp(A, f(B)), f(g(A)))),
        g(f(and(A, f(B)))),
        g(f(L::R(Box::new(A), Box::new(B)))),
        f(w(A, B)),
        f(and(n(A), g(f(B)))),
        x(g(or(A, g(f(B))))),
        L::U(Box::new(or(A, g(f(B)))), Box::new(B)),
        L::U(Box::new(A), Box::new(or(B, g(f(B))))),
        L::R(Box::new(and(A, g(f(B)))), Box::new(B)),
        w(and(A, g(f(B))), B),
        w(A, and(B, g(f(A)))),
        f(g(f(A))),
        n(f(and(A, x(g(n(B)))))),
        and(
            g(or(A, B)),
            imp(
                and(g(imp(A, x(n(A)))), g(f(A))),
                and(g(imp(B, x(A))), g(f(B))),
            ),
        ),
        and(
            g(imp(A, x(B))),
            imp(g(imp(B, x(w(A, B)))), and(w(A, B), f(n(B)))),
        ),
    ];
    let runs = all_lassos(6);
    println!("{} forms on {} lassos", forms.len(), runs.len());
    for form in forms {
        let main = format!("{SIGNALS} GUARANTEE {{ {form}; }}");
        let text = file("Mealy", "Mealy", &main);
        sound(&text);
        same(&text, &form, &runs);
    }
}

/// `W` and `R` between formulas about too many conditions for an automaton: over `a`, `b` and nine
/// inputs.
#[test]
fn weak_until_and_release_of_large_conditions() {
    let (mut dice, mut count) = (Dice(7), 0);
    let large = |dice: &mut Dice| {
        let parts: Vec<String> = (0..9)
            .map(|k| format!("(c[{k}] -> {})", dice.step(1, true)))
            .collect();
        format!("({})", parts.join(" && "))
    };
    for op in ["W", "R"] {
        for _ in 0..50 {
            let formula = format!("{} {op} {}", large(&mut dice), large(&mut dice));
            let main = format!("INPUTS {{ a; c[9]; }} OUTPUTS {{ b; }} GUARANTEE {{ {formula}; }}");
            let judge = Judge::new(sound(&file("Mealy", "Mealy", &main)));
            // c does not change: the formula with its values is one over a and b.
            for _ in 0..20 {
                let c: Vec<bool> = (0..9).map(|_| dice.below(2) == 0).collect();
                let run = dice.lasso(5);
                let text = c.iter().enumerate().fold(formula.clone(), |t, (k, v)| {
                    t.replace(&format!("c[{k}]"), if *v { "true" } else { "false" })
                });
                let small = format!("{SIGNALS} GUARANTEE {{ {text}; }}");
                let small = Judge::new(sound(&file("Mealy", "Mealy", &small)));
                assert_eq!(
                    judge.accepts_while(&run, &c),
                    small.accepts(&run),
                    "{text}\n{run:?}"
                );
                count += 1;
            }
        }
    }
    println!("{count} runs");
}
