//! Tests of queries about runs that only a side search answers within the allowed work: all
//! reachable states of a long counter would take far more.

use super::super::runs::{Rule, RunQuery, Runs, SafetyViolationQuery};
use crate::symbolic::{Limit, Limits};
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, FormulaKind, Owner, Time, UnaryOp, VarId, Variable,
};
use linewright_core::source::Span;

const COUNT: VarId = VarId(0);
const FLAG: VarId = VarId(1);

/// A counter, which takes `2^bits` steps to return to 0, and a flag.
fn variables(bits: u32) -> Vec<Variable> {
    let variable = |name: &str, domain| Variable {
        name: name.to_owned(),
        owner: Owner::System,
        internal: false,
        unit: String::new(),
        domain,
        span: Span::default(),
    };
    let high = (1 << bits) - 1;
    vec![
        variable("count", Domain::Range { low: 0, high }),
        variable("flag", Domain::Bool),
    ]
}

fn binary(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    Expr::Binary(op, Box::new(a), Box::new(b))
}

fn equal(a: Expr, b: Expr) -> Expr {
    binary(BinaryOp::Eq, a, b)
}

fn not(a: Expr) -> Expr {
    Expr::Unary(UnaryOp::Not, Box::new(a))
}

/// The counter starts at 0 and counts up by one in each step, as long as it is not at its end.
fn counting(bits: u32) -> Vec<Rule> {
    let (now, next) = (Expr::Var(COUNT, Time::Now), Expr::Var(COUNT, Time::Next));
    let end = Expr::Const((1 << bits) - 1);
    let up = equal(
        next.clone(),
        binary(BinaryOp::Add, now.clone(), Expr::Const(1)),
    );
    let at_end = equal(now.clone(), end);
    let rule = |kind, expr| Rule { kind, expr };
    vec![
        rule(FormulaKind::Initial, equal(now, Expr::Const(0))),
        rule(
            FormulaKind::Safety,
            Expr::If(
                Box::new(at_end),
                Box::new(equal(next, Expr::Const(0))),
                Box::new(up),
            ),
        ),
    ]
}

/// Runs of a counter with two further rules, with limited work.
fn runs(bits: u32, rules: [(FormulaKind, Expr); 2]) -> Runs {
    let more = rules.map(|(kind, expr)| Rule { kind, expr });
    let rules = counting(bits).into_iter().chain(more).collect();
    let limits = Limits {
        max_work: Some(1_000_000),
        ..Limits::default()
    };
    Runs::new(&variables(bits), rules, &limits).expect("few bits")
}

/// Sizes of the counter for the small kernel and for the large one.
const SIZES: [u32; 2] = [16, 30];

#[test]
fn a_violation_that_no_state_leads_to_is_excluded() {
    for bits in SIZES {
        let flag = |time| Expr::Var(FLAG, time);
        let stays = binary(
            BinaryOp::Implies,
            not(flag(Time::Now)),
            not(flag(Time::Next)),
        );
        let never = not(flag(Time::Now));
        let rules = [
            (FormulaKind::Safety, stays),
            (FormulaKind::Invariant, never.clone()),
        ];
        let mut runs = runs(bits, rules);
        runs.add(Rule {
            kind: FormulaKind::Initial,
            expr: never,
        });
        let query = |keep: Vec<usize>| SafetyViolationQuery {
            before: keep.clone(),
            last: keep,
            broken: 3,
        };
        assert_eq!(runs.find_violation(&query(vec![0, 1, 2, 4])), Ok(None));
        // Without the initial condition, the first state is a violation.
        let found = runs.find_violation(&query(vec![0, 1, 2])).unwrap();
        assert_eq!(found, Some(vec![vec![0, 1]]));
        // Without the rule, the flag can rise in any step.
        let found = runs.find_violation(&query(vec![0, 1, 4])).unwrap();
        assert_eq!(found, Some(vec![vec![0, 0], vec![1, 1]]));
    }
}

#[test]
fn a_cycle_that_exists_nowhere_is_excluded() {
    for bits in SIZES {
        let flag = |time| Expr::Var(FLAG, time);
        let stays = binary(BinaryOp::Implies, flag(Time::Now), flag(Time::Next));
        let rises = binary(BinaryOp::And, not(flag(Time::Now)), flag(Time::Next));
        let rules = [(FormulaKind::Safety, stays), (FormulaKind::Justice, rises)];
        let mut runs = runs(bits, rules);
        let query = |keep: Vec<usize>| RunQuery {
            keep,
            infinitely_often: vec![3],
            finitely_often: Vec::new(),
        };
        assert_eq!(runs.has_lasso(&query(vec![0, 1, 2])), Ok(false));
        assert_eq!(runs.find_lasso(&query(vec![0, 1, 2])), Ok(None));
        // Without the rule, the flag rises once in each round of the counter.
        let found = runs.find_lasso(&query(vec![0, 1]));
        assert!(matches!(found, Err(Limit::Work(_))), "{found:?}");
    }
}
