//! Every game over one input and one output with formulas from small lists: nothing is random.

use super::ways::play;
use linewright::gr1::{Domain, Expr, Formula, Owner, Side, Specification, Timing, VarId, Variable};
use linewright::source::Span;
use rayon::prelude::*;
use std::borrow::Cow;

const INPUT: VarId = VarId(0);
const OUTPUT: VarId = VarId(1);

fn x() -> Expr {
    Expr::now(INPUT)
}

fn y() -> Expr {
    Expr::now(OUTPUT)
}

fn next_x() -> Expr {
    Expr::next(INPUT)
}

fn next_y() -> Expr {
    Expr::next(OUTPUT)
}

/// Possible safety of the environment: nothing, a change, a memory, an answer to the machine.
fn assumed_safety() -> Vec<Option<Expr>> {
    vec![
        None,
        Some(next_x().equals(x().not())),
        Some(x().implies(next_x())),
        Some(y().implies(next_x())),
        Some(next_x().equals(y())),
        Some(x().and(y()).not()), // A dead end wherever both hold.
    ]
}

/// Possible safety of the machine.
fn safety() -> Vec<Option<Expr>> {
    vec![
        None,
        Some(next_y().equals(y().not())),
        Some(y().implies(next_y())),
        Some(next_y().equals(next_x())),
        Some(next_y().equals(x())),
        Some(next_x().and(next_y()).not()),
        Some(x().or(y())), // The machine's dead end.
    ]
}

/// Each set of valuations of both, as the formula that holds there; bit `2x + y` says whether the
/// valuation is in it.
fn of_states(set: u32) -> Expr {
    let mut formula = Expr::Const(0);
    for valuation in 0..4 {
        if set >> valuation & 1 == 1 {
            let literal = |e: Expr, positive: bool| if positive { e } else { e.not() };
            let here = literal(x(), valuation & 2 != 0).and(literal(y(), valuation & 1 != 0));
            formula = formula.or(here);
        }
    }
    formula
}

pub fn listed(expr: Option<Expr>) -> Vec<Formula> {
    let formula = expr.map(|expr| Formula {
        defines: false,
        name: "a formula".to_owned(),
        requirement: None,
        text: format!("{expr:?}"),
        expr,
        span: Span::default(),
    });
    formula.into_iter().collect()
}

pub fn variable(name: &str, owner: Owner) -> Variable {
    Variable {
        name: name.to_owned(),
        owner,
        internal: false,
        unit: String::new(),
        domain: Domain::Bool,
        span: Span::default(),
    }
}

/// All of them: both timings, every pair of safety formulas, every set of states as an assumption
/// and as a goal. Each of these has one of three initial conditions, in turn.
fn games() -> Vec<Specification> {
    let mut games = Vec::new();
    let starts = [
        (None, None),
        (Some(x().not()), Some(y().not())),
        (None, Some(x().equals(y()))),
    ];
    for timing in [Timing::Mealy, Timing::Moore] {
        for assumed in assumed_safety() {
            for kept in safety() {
                for justice in 0..16 {
                    for goal in 0..16 {
                        let (theirs, ours) = starts[games.len() % starts.len()].clone();
                        games.push(Specification {
                            name: "exhaustive".to_owned(),
                            timing,
                            variables: vec![
                                variable("x", Owner::Environment),
                                variable("y", Owner::System),
                            ],
                            assumptions: Side {
                                initial: listed(theirs),
                                safety: listed(assumed.clone()),
                                justice: listed(Some(of_states(justice))),
                                ..Side::default()
                            },
                            guarantees: Side {
                                initial: listed(ours),
                                safety: listed(kept.clone()),
                                justice: listed(Some(of_states(goal))),
                                ..Side::default()
                            },
                        });
                    }
                }
            }
        }
    }
    games
}

#[test]
fn all_games_of_two_bits_in_every_way() {
    let games = games();
    let realizable = play(
        games
            .par_iter()
            .enumerate()
            .map(|(n, s)| (n, Cow::Borrowed(s))),
    );
    let count = games.len() as u64;
    assert_eq!(count, 2 * 6 * 7 * 16 * 16);
    assert!(realizable * 3 > count && (count - realizable) * 4 > count);
}
