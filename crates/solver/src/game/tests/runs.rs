//! Tests of queries about runs that only a side search answers within the allowed work: all
//! reachable states of a long counter would take far more.

use super::super::runs::{Rule, RunQuery, Runs, SafetyViolationQuery};
use crate::symbolic::{Limit, Limits};
use linewright_core::gr1::{BinaryOp, Domain, Expr, FormulaKind, Owner, VarId, Variable};
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

/// The counter starts at 0 and counts up by one in each step, as long as it is not at its end.
fn counting(bits: u32) -> Vec<Rule> {
    let (now, next) = (Expr::now(COUNT), Expr::next(COUNT));
    let is_at_end = now.clone().equals(Expr::Const((1 << bits) - 1));
    let starts_again = next.clone().equals(Expr::Const(0));
    let up = Expr::binary(BinaryOp::Add, now.clone(), Expr::Const(1));
    let counts = Expr::If(
        Box::new(is_at_end),
        Box::new(starts_again),
        Box::new(next.equals(up)),
    );
    let rule = |kind, expr| Rule { kind, expr };
    vec![
        rule(FormulaKind::Initial, now.equals(Expr::Const(0))),
        rule(FormulaKind::Safety, counts),
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
        let never = Expr::now(FLAG).not();
        let stays = never.clone().implies(Expr::next(FLAG).not());
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
        let stays = Expr::now(FLAG).implies(Expr::next(FLAG));
        let rises = Expr::now(FLAG).not().and(Expr::next(FLAG));
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

/// The rings of this exploration are so large that they are not kept: `x` starts at `y * y`, and
/// the sets of pairs have about 700 nodes.
#[test]
fn runs_are_found_although_the_rings_were_dropped() {
    let mut variables = variables(12);
    variables[1].domain = Domain::Range { low: 0, high: 63 };
    let (x, y) = (COUNT, FLAG);
    let square = Expr::binary(BinaryOp::Mul, Expr::now(y), Expr::now(y));
    let mut rules = counting(12);
    rules[0].expr = Expr::now(x).equals(square);
    let mut add = |kind, expr| {
        rules.push(Rule { kind, expr });
        rules.len() - 1
    };
    let is_at = |at: i64, of: i64| {
        Expr::now(x)
            .equals(Expr::Const(at))
            .and(Expr::now(y).equals(Expr::Const(of)))
    };
    let stays = add(FormulaKind::Safety, Expr::next(y).equals(Expr::now(y)));
    let goals = [(105, 10), (2525, 50), (3630, 60)];
    let broken = goals.map(|(at, of)| add(FormulaKind::Invariant, is_at(at, of).not()));
    let again = add(FormulaKind::Justice, is_at(4095, 63));

    let mut runs = Runs::new(&variables, rules, &Limits::default()).expect("few bits");
    let keep = vec![0, 1, stays];
    let query = |broken| SafetyViolationQuery {
        before: keep.clone(),
        last: keep.clone(),
        broken,
    };
    for ((at, of), broken) in goals.into_iter().zip(broken).rev() {
        assert_eq!(runs.has_violation(&query(broken)), Ok(true));
        let run = runs.find_violation(&query(broken)).unwrap();
        let expected = (of * of..=at).map(|x| vec![x, of]).collect();
        assert_eq!(run, Some(expected));
    }
    let lasso = runs.find_lasso(&RunQuery {
        keep: keep.clone(),
        infinitely_often: vec![again],
        finitely_often: Vec::new(),
    });
    // The counter goes round.
    let lasso = lasso.unwrap().expect("a run");
    assert_eq!((lasso.prefix.len(), lasso.cycle.len()), (0, 4096));
    assert_eq!(lasso.cycle[0], [63 * 63, 63]);
}
