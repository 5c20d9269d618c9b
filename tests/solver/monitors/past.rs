//! Past operators and counters, step by step.

use super::LONGEST;
use super::logic::{Logic as L, Logic, read};
use super::play::Player;
use super::words::{Lanes, every_lasso, same};
use linewright::gr1::monitors::{Monitors, Obligation, Origin};
use linewright::gr1::{BinaryOp, Domain, Expr, FormulaKind, VarId};

/// A past formula, operator by operator through the interface used by importers.
fn lower(monitors: &mut Monitors, formula: &Logic) -> Expr {
    let origin = Origin::default();
    match formula {
        L::Var(v) => Expr::now(VarId(*v as u32)),
        L::Not(a) => lower(monitors, a).not(),
        L::And(a, b) => {
            let a = lower(monitors, a);
            a.and(lower(monitors, b))
        }
        L::Or(a, b) => {
            let a = lower(monitors, a);
            a.or(lower(monitors, b))
        }
        L::Previous(a) => {
            let a = lower(monitors, a);
            monitors.previous(&a, &origin)
        }
        L::Once(a) => {
            let a = lower(monitors, a);
            monitors.once(&a, &origin)
        }
        L::OnceWithin(n, a) => {
            let a = lower(monitors, a);
            monitors.once_within(&a, *n as u32, &origin)
        }
        L::Historically(a) => {
            let a = lower(monitors, a);
            monitors.historically(&a, &origin)
        }
        L::HistoricallyWithin(n, a) => {
            let a = lower(monitors, a);
            monitors.historically_within(&a, *n as u32, &origin)
        }
        L::Since(a, b) => {
            let (a, b) = (lower(monitors, a), lower(monitors, b));
            monitors.since(&a, &b, &origin)
        }
        _ => panic!("{formula:?} refers to the future"),
    }
}

/// Compares values step by step on every lasso, repeating its cycle `rounds` times; then the
/// formula as an invariant, guaranteed and assumed.
fn agree(formula: &Logic, rounds: usize) {
    let mut monitors = Monitors::new(VarId(2), []);
    let expr = lower(&mut monitors, formula);
    let always = Obligation {
        kind: FormulaKind::Invariant,
        expr: expr.clone(),
    };
    let player = Player::new(2, &monitors, &[always], Some(&expr));
    every_lasso(2, LONGEST, &mut |lassos| {
        let length = lassos.letters.len();
        let word = lassos.unrolled(lassos.back + rounds * (length - lassos.back));
        let expected = formula.in_the_past_of(&word);
        for (t, (values, expected)) in player.follow(&word).iter().zip(&expected).enumerate() {
            let found = values.iter().find(|(x, _)| *x == 1);
            let found = found.map_or(Lanes::NONE, |(_, lanes)| *lanes);
            if let Some(lane) = (!same(*expected, found)).first() {
                let lasso = lassos.show(lane, &['p', 'q']);
                panic!("{formula:?} in step {t} of {lasso}: {}", found.at(lane));
            }
        }
        let always = expected.iter().fold(Lanes::ALL, |all, x| all & *x);
        let kept = player.kept(lassos);
        for (what, found) in [("kept", kept.guaranteed), ("assumed", kept.assumed)] {
            if let Some(lane) = (!same(always, found)).first() {
                let lasso = lassos.show(lane, &['p', 'q']);
                panic!("always {formula:?} on {lasso}: {what} {}", found.at(lane));
            }
        }
    });
}

#[test]
fn past_operators_have_the_value_of_their_definition() {
    for text in [
        "Y p",
        "O p",
        "H p",
        "p S q",
        "q S p",
        "!p S (q & !p)",
        "Y p & H<=1 p",
        "H<=1 p or Y Y p",
    ] {
        agree(&read(text, &['p', 'q']), 4);
    }
    for n in 0..=5 {
        for operator in ["O", "H"] {
            // As many rounds as the counter has values, plus two.
            agree(&read(&format!("{operator}<={n} p"), &['p', 'q']), n + 3);
        }
    }
}

/// Every formula of at most two operators, including nested ones.
#[test]
fn past_operators_can_be_nested() {
    let atoms = vec![L::Var(0), L::Var(1)];
    let unary = |a: &Logic| {
        let a = Box::new(a.clone());
        [
            L::Not(a.clone()),
            L::Previous(a.clone()),
            L::Once(a.clone()),
            L::OnceWithin(2, a.clone()),
            L::Historically(a.clone()),
            L::HistoricallyWithin(1, a),
        ]
    };
    let binary = |a: &Logic, b: &Logic| {
        let (a, b) = (Box::new(a.clone()), Box::new(b.clone()));
        [L::And(a.clone(), b.clone()), L::Since(a, b)]
    };
    let mut ones: Vec<Logic> = atoms.iter().flat_map(unary).collect();
    for a in &atoms {
        ones.extend(atoms.iter().flat_map(|b| binary(a, b)));
    }
    let mut twos: Vec<Logic> = ones.iter().flat_map(unary).collect();
    for a in &ones {
        for b in &atoms {
            twos.extend(binary(a, b));
            twos.extend(binary(b, a));
        }
    }
    for formula in ones.iter().chain(&twos) {
        agree(formula, 5);
    }
    assert_eq!((ones.len(), twos.len()), (20, 280));
}

/// The truth of p and q in the steps before and in this one.
type Steps<'a> = &'a [(bool, bool)];

/// Compares an expression's value with the expected one.
fn agree_with(
    monitors: &Monitors,
    expr: &Expr,
    rounds: usize,
    expected: &dyn Fn(Steps<'_>) -> i64,
) {
    let player = Player::new(2, monitors, &[], Some(expr));
    every_lasso(2, LONGEST, &mut |lassos| {
        let length = lassos.letters.len();
        let word = lassos.unrolled(lassos.back + rounds * (length - lassos.back));
        let found = player.follow(&word);
        for lane in 0..1 << (2 * length).min(8) {
            let letters: Vec<(bool, bool)> = word
                .iter()
                .map(|l| (l[0].at(lane), l[1].at(lane)))
                .collect();
            for (t, values) in found.iter().enumerate() {
                let taken: Vec<i64> = values
                    .iter()
                    .filter(|(_, lanes)| lanes.at(lane))
                    .map(|(x, _)| *x)
                    .collect();
                let wanted = expected(&letters[..=t]);
                assert_eq!(taken, [wanted], "step {t} of {letters:?}");
            }
        }
    });
}

#[test]
fn counters_count() {
    for high in 0..=4 {
        let mut monitors = Monitors::new(VarId(2), []);
        let (p, q) = (Expr::now(VarId(0)), Expr::now(VarId(1)));
        let counter = monitors.counter(&p, &q, high, &Origin::default());
        agree_with(&monitors, &counter, high as usize + 3, &|steps| {
            let before = &steps[..steps.len() - 1];
            let reset = before.iter().rposition(|(_, resets)| *resets);
            let counted = &before[reset.map_or(0, |r| r + 1)..];
            let count = counted.iter().filter(|(counts, _)| *counts).count();
            (count as i64).min(i64::from(high))
        });
    }
}

#[test]
fn values_are_remembered_for_a_step() {
    let mut monitors = Monitors::new(VarId(2), []);
    let (p, q) = (Expr::now(VarId(0)), Expr::now(VarId(1)));
    let twice = Expr::binary(BinaryOp::Add, q.clone(), q);
    let number = Expr::binary(BinaryOp::Add, p, twice);
    let domain = Domain::Range { low: 0, high: 3 };
    let before = monitors.previous_value(&number, domain, 2, &Origin::default());
    agree_with(&monitors, &before, 3, &|steps| match steps {
        [.., (p, q), _] => i64::from(*p) + 2 * i64::from(*q),
        _ => 2,
    });
}
