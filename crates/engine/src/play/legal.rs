//! The legal moves of a side in the upcoming step.
//!
//! Evaluates the specification's own formulas, never a controller. Known values of the step are
//! substituted into the formulas. Moves are then searched variable by variable; a branch is cut as
//! soon as interval arithmetic shows that a formula is false. The search stops after a maximum
//! number of tries.

use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{BinaryOp, Expr, Formula, Owner, Specification, Time, VarId};
use std::ops::ControlFlow;

/// Maximum number of values tried in one search.
const MAX_TRIES: u32 = 100_000;

/// A rule with known values substituted.
#[derive(Debug, Clone)]
pub(super) struct Rule<'a> {
    /// The original rule.
    pub formula: &'a Formula,
    /// The remaining formula about next values that are not known yet.
    pub residual: Expr,
}

/// Moves of a side in the upcoming step.
#[derive(Debug)]
pub(super) struct Moves<'a> {
    specification: &'a Specification,
    /// Rules that a move must satisfy.
    pub rules: Vec<Rule<'a>>,
    /// Rules for leaving the step: parts of safety formulas that mention only the step itself, and
    /// that must hold before another step can follow. A move that violates one of them is legal,
    /// but no step can follow it.
    pub leaving: Vec<Rule<'a>>,
    /// Variables whose values are not known yet, each with the value to try first.
    open: Vec<(VarId, i64)>,
}

/// The maximum number of tries was exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EnumerationLimit;

/// Values of variables.
pub(super) type Values = Vec<(VarId, i64)>;

/// Visits a move, and decides whether the search continues.
type Visit<'v> = dyn FnMut(&[(VarId, i64)]) -> ControlFlow<()> + 'v;

impl<'a> Moves<'a> {
    /// The moves of `side` after the step `before`, or in step 0, given the known values of the
    /// upcoming step.
    pub fn new(
        specification: &'a Specification,
        side: Owner,
        before: Option<&[i64]>,
        known: &[Option<i64>],
    ) -> Self {
        let formulas = match side {
            Owner::Environment => &specification.assumptions,
            Owner::System => &specification.guarantees,
        };
        let upcoming = |v: VarId| match known[v.index()] {
            Some(value) => Expr::Const(value),
            None => Expr::next(v),
        };
        // Initial conditions and invariants refer to the current step, which here is the upcoming
        // one.
        let within = |f: &'a Formula| Rule {
            formula: f,
            residual: f.expr.substitute(&mut |v, _| upcoming(v)).simplify(),
        };
        let mut rules: Vec<Rule<'a>> = Vec::new();
        if let Some(before) = before {
            rules.extend(formulas.invariants.iter().map(within));
            rules.extend(formulas.safety.iter().map(|f| {
                let residual = f.expr.substitute(&mut |v, time| match time {
                    Time::Now => Expr::Const(before[v.index()]),
                    Time::Next => upcoming(v),
                });
                Rule {
                    formula: f,
                    residual: residual.simplify(),
                }
            }));
        } else {
            rules.extend(formulas.initial.iter().map(within));
            rules.extend(formulas.invariants.iter().map(within));
        }
        let leaving = formulas.safety.iter().flat_map(|f| {
            let conditions = conditions_of_leaving(&f.expr).into_iter();
            conditions.map(move |conjunct| Rule {
                formula: f,
                residual: conjunct.substitute(&mut |v, _| upcoming(v)).simplify(),
            })
        });
        let leaving: Vec<Rule<'a>> = leaving.filter(|r| r.residual != Expr::TRUE).collect();
        // The side's own variables come first; for those of the other side, any possible value
        // suffices.
        let all = (0..specification.variables.len() as u32).map(VarId);
        let (own, other): (Vec<VarId>, Vec<VarId>) =
            all.partition(|v| specification.variable(*v).owner == side);
        let open = own
            .into_iter()
            .chain(other)
            .filter(|v| known[v.index()].is_none());
        let first = |v: VarId| match before {
            Some(before) => before[v.index()],
            None => specification.variable(v).domain.low(),
        };
        Self {
            specification,
            rules,
            leaving,
            open: open.map(|v| (v, first(v))).collect(),
        }
    }

    /// Whether any rule, including those for leaving the step, depends on a variable's value.
    pub fn matters(&self, variable: VarId) -> bool {
        let mut rules = self.rules.iter().chain(&self.leaving);
        rules.any(|r| mentions(&r.residual, variable))
    }

    /// The rules for leaving the step that a move with these values violates.
    pub fn violated_on_leaving(&self, values: &[(VarId, i64)]) -> Vec<&Rule<'a>> {
        let domain = |v: VarId| Interval::of(&self.specification.variable(v).domain);
        let residuals = residuals(self.leaving.iter(), values);
        let broken = residuals
            .iter()
            .map(|e| interval(e, &domain).unwrap_or(Interval::BOOL).high == 0);
        let rules = self.leaving.iter().zip(broken);
        rules
            .filter_map(|(rule, broken)| broken.then_some(rule))
            .collect()
    }

    /// A legal move with the values `fixed` that another step can follow; if there is none, any
    /// legal move with these values. `None` if no such move is legal.
    pub fn find_with_successor(
        &self,
        fixed: &[(VarId, i64)],
    ) -> Result<Option<Values>, EnumerationLimit> {
        let all = self.rules.iter().chain(&self.leaving);
        match self.find_under(all, fixed) {
            Ok(Some(values)) => Ok(Some(values)),
            Ok(None) | Err(EnumerationLimit) => self.find(fixed),
        }
    }

    /// Sets the values that a search tries first.
    pub fn prefer(&mut self, values: impl Fn(VarId) -> i64) {
        for (variable, first) in &mut self.open {
            *first = values(*variable);
        }
    }

    /// A legal move with the values `fixed`, as values of all open variables; `None` if there is
    /// none.
    pub fn find(&self, fixed: &[(VarId, i64)]) -> Result<Option<Values>, EnumerationLimit> {
        self.find_under(self.rules.iter(), fixed)
    }

    /// Like [`Moves::find`], but only the given rules apply.
    pub fn find_under<'r>(
        &self,
        rules: impl Iterator<Item = &'r Rule<'a>>,
        fixed: &[(VarId, i64)],
    ) -> Result<Option<Values>, EnumerationLimit>
    where
        'a: 'r,
    {
        let mut found = None;
        let mut search = Search::new(self, false);
        let _ = search.run(residuals(rules, fixed), &self.rest(fixed), &mut |values| {
            found = Some([fixed, values].concat());
            ControlFlow::Break(())
        })?;
        Ok(found)
    }

    /// Calls `visit` for each legal move, given as values of the variables that matter, until
    /// `visit` stops the search.
    pub fn each(&self, visit: &mut Visit<'_>) -> Result<(), EnumerationLimit> {
        let open = self.open.iter().copied();
        let matter: Values = open.filter(|(v, _)| self.matters(*v)).collect();
        let mut search = Search::new(self, true);
        let left = residuals(self.rules.iter(), &[]);
        search.run(left, &matter, visit).map(|_| ())
    }

    fn rest(&self, fixed: &[(VarId, i64)]) -> Values {
        let fixed = |v: VarId| fixed.iter().any(|(f, _)| *f == v);
        self.open
            .iter()
            .copied()
            .filter(|(v, _)| !fixed(*v))
            .collect()
    }
}

/// The remaining formulas of rules with these values substituted.
fn residuals<'a: 'r, 'r>(
    rules: impl Iterator<Item = &'r Rule<'a>>,
    fixed: &[(VarId, i64)],
) -> Vec<Expr> {
    let fix = |left: &Expr| {
        let fixed = fixed.iter();
        fixed.fold(left.clone(), |left, (v, value)| {
            substitute(&left, *v, *value).unwrap_or(left)
        })
    };
    rules.map(|r| fix(&r.residual)).collect()
}

/// A depth-first search.
struct Search<'a> {
    specification: &'a Specification,
    /// Whether to also try all values of variables on which no remaining formula depends.
    every: bool,
    values: Values,
    tries: u32,
}

impl<'a> Search<'a> {
    fn new(moves: &Moves<'a>, every: bool) -> Self {
        Self {
            specification: moves.specification,
            every,
            values: Vec::new(),
            tries: 0,
        }
    }

    fn run(
        &mut self,
        mut left: Vec<Expr>,
        open: &[(VarId, i64)],
        visit: &mut Visit<'_>,
    ) -> Result<ControlFlow<()>, EnumerationLimit> {
        let domain = |v: VarId| Interval::of(&self.specification.variable(v).domain);
        let bounds = |e: &Expr| interval(e, &domain).unwrap_or(Interval::BOOL);
        if left.iter().any(|e| bounds(e).high == 0) {
            return Ok(ControlFlow::Continue(()));
        }
        left.retain(|e| bounds(e).low == 0);
        let Some(((variable, first), rest)) = open.split_first() else {
            return Ok(visit(&self.values));
        };
        let domain = &self.specification.variable(*variable).domain;
        let (low, high) = (domain.low(), domain.high());
        let matters = self.every || left.iter().any(|e| mentions(e, *variable));
        let others = (first + 1..=high).chain(low..*first).filter(|_| matters);
        for value in std::iter::once(*first).chain(others) {
            self.tries += 1;
            if self.tries > MAX_TRIES {
                return Err(EnumerationLimit);
            }
            let with = |e: &Expr| substitute(e, *variable, value).unwrap_or_else(|| e.clone());
            let left: Vec<Expr> = left.iter().map(with).collect();
            self.values.push((*variable, value));
            let flow = self.run(left, rest, visit)?;
            self.values.pop();
            if flow.is_break() {
                return Ok(flow);
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}

/// Conjuncts of a safety formula that mention only the step being left. The recursion is as deep as
/// the formula.
fn conditions_of_leaving(expr: &Expr) -> Vec<&Expr> {
    match expr {
        Expr::Binary(BinaryOp::And, a, b) => {
            [conditions_of_leaving(a), conditions_of_leaving(b)].concat()
        }
        expr if expr.mentions_next() => Vec::new(),
        expr => vec![expr],
    }
}

/// The formula with a value substituted for a variable; `None` if the formula does not mention the
/// variable.
fn substitute(left: &Expr, variable: VarId, value: i64) -> Option<Expr> {
    mentions(left, variable).then(|| {
        let known = left.substitute(&mut |v, time| {
            if v == variable {
                Expr::Const(value)
            } else {
                Expr::Var(v, time)
            }
        });
        known.simplify()
    })
}

fn mentions(expr: &Expr, variable: VarId) -> bool {
    let mut found = false;
    expr.for_each_var(&mut |v, _| found |= v == variable);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::gr1::{Domain, Side, Timing, Variable, eval};
    use linewright_core::source::{FileId, Span};

    fn variable(name: &str, owner: Owner, high: i64) -> Variable {
        Variable {
            name: name.to_owned(),
            owner,
            internal: false,
            domain: Domain::Range { low: 0, high },
            unit: String::new(),
            span: Span::new(FileId(0), 0, 0),
        }
    }

    fn formula(expr: Expr) -> Formula {
        Formula {
            defines: false,
            name: "rule".to_owned(),
            requirement: None,
            expr,
            span: Span::new(FileId(0), 0, 0),
            text: String::new(),
        }
    }

    /// Inputs `a` (0..3) and `b` (0..4), an output `c` (0..2): `a + b <= 5` always,
    /// `next a + next b >= c + a` from step to step, `a = 1` at first.
    fn specification() -> Specification {
        let [a, b, c] = [0, 1, 2].map(VarId);
        let binary = Expr::binary;
        let sum = |time| binary(BinaryOp::Add, Expr::Var(a, time), Expr::Var(b, time));
        let low = binary(BinaryOp::Le, sum(Time::Now), Expr::Const(5));
        let start = Expr::now(a).equals(Expr::Const(1));
        let needed = binary(BinaryOp::Add, Expr::now(c), Expr::now(a));
        let more = binary(BinaryOp::Ge, sum(Time::Next), needed);
        Specification {
            name: "A".to_owned(),
            timing: Timing::Mealy,
            variables: vec![
                variable("a", Owner::Environment, 3),
                variable("b", Owner::Environment, 4),
                variable("c", Owner::System, 2),
            ],
            assumptions: Side {
                initial: vec![formula(start)],
                invariants: vec![formula(low)],
                safety: vec![formula(more)],
                justice: Vec::new(),
            },
            guarantees: Side::default(),
        }
    }

    /// The search agrees with direct evaluation, from every step.
    #[test]
    fn legal_moves_keep_every_rule() {
        let specification = specification();
        let side = &specification.assumptions;
        let mut steps: Vec<Option<Vec<i64>>> = vec![None];
        for (a, b, c) in
            (0..4).flat_map(|a| (0..5).flat_map(move |b| (0..3).map(move |c| (a, b, c))))
        {
            steps.push(Some(vec![a, b, c]));
        }
        for before in steps {
            let moves = Moves::new(
                &specification,
                Owner::Environment,
                before.as_deref(),
                &[None; 3],
            );
            let mut found = Vec::new();
            let all = moves.each(&mut |values| {
                found.push((values[0].1, values[1].1));
                ControlFlow::Continue(())
            });
            assert_eq!(all, Ok(()));
            found.sort_unstable();
            let mut wanted = Vec::new();
            for (a, b) in (0..4).flat_map(|a| (0..5).map(move |b| (a, b))) {
                let now = [a, b, 0];
                let within = |f: &Formula| eval::holds(&f.expr, &now, &[]);
                let between = match &before {
                    None => side.initial.iter().all(within),
                    Some(before) => side
                        .safety
                        .iter()
                        .all(|f| eval::holds(&f.expr, before, &now)),
                };
                let legal = between && side.invariants.iter().all(within);
                if legal {
                    wanted.push((a, b));
                }
                let fixed = [(VarId(0), a), (VarId(1), b)];
                let one = moves.find(&fixed).expect("few tries");
                assert_eq!(one.is_some(), legal, "{before:?} {a} {b}");
            }
            assert_eq!(found, wanted, "{before:?}");
            let some = moves.find(&[]).expect("few tries");
            assert_eq!(some.is_some(), !wanted.is_empty());
        }
    }
    #[test]
    fn numbers_far_outside_a_domain_are_never_found() {
        for number in [4, 1 << 31, (1 << 31) + 1, 1 << 40] {
            let mut specification = specification();
            let [a, b] = [0, 1].map(VarId);
            let never = Expr::now(a).equals(Expr::Const(number));
            let rule = never.and(Expr::now(b).equals(Expr::Const(0)));
            specification.assumptions.initial = vec![formula(rule)];
            let moves = Moves::new(&specification, Owner::Environment, None, &[None; 3]);
            assert_eq!(moves.find(&[]), Ok(None), "{number}");
        }
    }
}
