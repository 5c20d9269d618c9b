//! Finds next values that can leave their domain: `next made = made + 1` if `made` is at the end of
//! its range.
//!
//! All arithmetic is exact and nothing wraps around, so no controller can keep such a formula in
//! such a step. Intervals alone would also report `made < 9 -> next made = made + 1`, which is
//! correct. So the search collects the conditions of an equation, and tries all values of the
//! variables in the equation and its conditions. If there are too many valuations, nothing is
//! reported: this is only a hint, and the game decides exactly.

use super::interval::{Interval, interval};
use super::{BinaryOp, Expr, Formula, Specification, Time, UnaryOp, VarId};
use crate::gr1::eval::{eval, holds};

/// Maximum number of valuations tried per equation.
const MAX_VALUATIONS: u64 = 1 << 16;

/// An equation whose right side can leave the domain of the next value on its left side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Overflow<'a> {
    /// Formula that contains the equation.
    pub formula: &'a Formula,
    /// Variable whose next value the equation sets.
    pub variable: VarId,
    /// Value outside the variable's domain.
    pub value: i64,
    /// Current values that lead to this next value.
    pub example: Vec<(VarId, i64)>,
}

/// Returns one overflow for each safety formula that can require a next value outside its domain,
/// guarantees first.
pub fn overflows(specification: &Specification) -> Vec<Overflow<'_>> {
    let (g, a) = (&specification.guarantees, &specification.assumptions);
    let safety = g.safety.iter().chain(&a.safety);
    safety
        .filter_map(|formula| {
            let mut search = Search {
                specification,
                formula,
                conditions: Vec::new(),
            };
            search.check(&formula.expr)
        })
        .collect()
}

struct Search<'a> {
    specification: &'a Specification,
    formula: &'a Formula,
    /// Conditions under which the expression being checked has to hold.
    conditions: Vec<Expr>,
}

impl<'a> Search<'a> {
    /// Checks an expression that has to hold.
    fn check(&mut self, expr: &Expr) -> Option<Overflow<'a>> {
        match expr {
            Expr::Binary(BinaryOp::And, a, b) => self.check(a).or_else(|| self.check(b)),
            Expr::Binary(BinaryOp::Implies, a, b) => self.under((**a).clone(), b),
            Expr::Binary(BinaryOp::Or, a, b) => {
                let not = |e: &Expr| match e {
                    Expr::Unary(UnaryOp::Not, inner) => (**inner).clone(),
                    other => other.clone().not(),
                };
                self.under(not(a), b).or_else(|| self.under(not(b), a))
            }
            Expr::If(c, a, b) => self
                .under((**c).clone(), a)
                .or_else(|| self.under((**c).clone().not(), b)),
            Expr::Binary(BinaryOp::Eq, a, b) => match (&**a, &**b) {
                (Expr::Var(v, Time::Next), e) | (e, Expr::Var(v, Time::Next)) => self.assign(*v, e),
                _ => None,
            },
            _ => None,
        }
    }

    /// Checks an expression that has to hold if `condition` holds.
    fn under(&mut self, condition: Expr, expr: &Expr) -> Option<Overflow<'a>> {
        self.conditions.push(condition);
        let found = self.check(expr);
        self.conditions.pop();
        found
    }

    /// Checks `next variable = value`.
    fn assign(&mut self, variable: VarId, value: &Expr) -> Option<Overflow<'a>> {
        if let Expr::If(c, a, b) = value {
            self.conditions.push((**c).clone());
            let found = self.assign(variable, a);
            self.conditions.pop();
            if found.is_some() {
                return found;
            }
            self.conditions.push((**c).clone().not());
            let found = self.assign(variable, b);
            self.conditions.pop();
            return found;
        }
        let domain = &self.specification.variable(variable).domain;
        let of = |v: VarId| Interval::of(&self.specification.variable(v).domain);
        let range = interval(value, &of).ok()?;
        if domain.contains(range.low) && domain.contains(range.high) {
            return None;
        }
        self.try_values(variable, value)
    }

    /// Tries all current values of the variables that the equation and its conditions mention.
    /// Returns `None` if the value or a condition reads next values, or if there are too many
    /// valuations.
    fn try_values(&self, variable: VarId, value: &Expr) -> Option<Overflow<'a>> {
        if value.mentions_next() {
            return None;
        }
        let conditions: Vec<&Expr> = self.conditions.iter().collect();
        if conditions.iter().any(|c| c.mentions_next()) {
            return None;
        }
        let mut used: Vec<VarId> = Vec::new();
        for expr in conditions.iter().copied().chain([value]) {
            expr.for_each_var(&mut |v, _| {
                if !used.contains(&v) {
                    used.push(v);
                }
            });
        }
        used.sort_unstable();
        let domain_of = |v: VarId| &self.specification.variable(v).domain;
        let count = used
            .iter()
            .try_fold(1u64, |n, v| n.checked_mul(domain_of(*v).size()))?;
        if count > MAX_VALUATIONS {
            return None;
        }
        let variables = self.specification.variables.iter();
        let mut now: Vec<i64> = variables.map(|v| v.domain.low()).collect();
        loop {
            if conditions.iter().all(|c| holds(c, &now, &[])) {
                let result = eval(value, &now, &[]);
                if !domain_of(variable).contains(result) {
                    return Some(Overflow {
                        formula: self.formula,
                        variable,
                        value: result,
                        example: used.iter().map(|v| (*v, now[v.index()])).collect(),
                    });
                }
            }
            // Advance to the next valuation, like an odometer.
            let mut digits = used.iter();
            loop {
                let v = digits.next()?;
                let value = &mut now[v.index()];
                if *value < domain_of(*v).high() {
                    *value += 1;
                    break;
                }
                *value = domain_of(*v).low();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Domain, Owner, Side, Timing, Variable};
    use super::*;
    use crate::source::Span;

    const MADE: VarId = VarId(0);
    const PART: VarId = VarId(1);

    fn specification(expr: Expr) -> Specification {
        let variable = |name: &str, owner, domain| Variable {
            name: name.to_owned(),
            owner,
            internal: false,
            unit: String::new(),
            domain,
            span: Span::default(),
        };
        Specification {
            name: "Counter".to_owned(),
            timing: Timing::Mealy,
            variables: vec![
                variable("made", Owner::System, Domain::Range { low: 0, high: 9 }),
                variable("part", Owner::Environment, Domain::Bool),
            ],
            assumptions: Side::default(),
            guarantees: Side {
                safety: vec![Formula {
                    defines: false,
                    name: "counts".to_owned(),
                    requirement: None,
                    expr,
                    span: Span::default(),
                    text: String::new(),
                }],
                ..Side::default()
            },
        }
    }

    fn plus_one() -> Expr {
        Expr::binary(BinaryOp::Add, Expr::now(MADE), Expr::Const(1))
    }

    fn found(expr: Expr) -> Option<(i64, Vec<(VarId, i64)>)> {
        let specification = specification(expr);
        let found = overflows(&specification).first().cloned();
        found.map(|o| (o.value, o.example))
    }

    #[test]
    fn a_counter_that_overflows_is_found() {
        let expr = Expr::now(PART).implies(Expr::next(MADE).equals(plus_one()));
        assert_eq!(found(expr), Some((10, vec![(MADE, 9), (PART, 1)])));
        let down = Expr::binary(BinaryOp::Sub, Expr::now(MADE), Expr::Const(1));
        assert_eq!(
            found(down.equals(Expr::next(MADE))),
            Some((-1, vec![(MADE, 0)]))
        );
    }

    #[test]
    fn a_counter_that_saturates_or_is_guarded_is_not() {
        let bounded = Expr::binary(BinaryOp::Min, plus_one(), Expr::Const(9));
        assert_eq!(found(Expr::next(MADE).equals(bounded)), None);
        let below = Expr::binary(BinaryOp::Lt, Expr::now(MADE), Expr::Const(9));
        let equation = || Expr::next(MADE).equals(plus_one());
        assert_eq!(found(below.clone().implies(equation())), None);
        assert_eq!(found(below.clone().not().or(equation())), None);
        let choice = Expr::If(
            Box::new(below),
            Box::new(plus_one()),
            Box::new(Expr::Const(0)),
        );
        assert_eq!(found(Expr::next(MADE).equals(choice)), None);
    }
}
