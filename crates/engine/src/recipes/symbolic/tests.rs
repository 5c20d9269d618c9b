//! The symbolic game and the explicit search agree.

#[expect(dead_code, reason = "only some of the cells are used here")]
#[path = "../../../../recipe/tests/support/random.rs"]
mod random;

use super::*;
use linewright_recipe::model::{Action, Resource, State, Transition};
use linewright_recipe::realize::{SearchLimits, realize};
use linewright_recipe::replay;

/// Random cells with loops, several guards, stock and parallel steps: the verdicts are the same,
/// and each controller passes the replay.
#[test]
fn verdicts_are_those_of_the_explicit_search() {
    // The largest cells would take seconds each.
    let factor = BudgetFactor::new(0.02).expect("a factor");
    let (mut yes, mut no) = (0, 0);
    for seed in 0..600 {
        let (layout, recipe) = random::cell(seed);
        let Ok(explicit) = realize(&layout, &recipe, SearchLimits::default()) else {
            continue;
        };
        let Some(symbolic) = decide(&layout, &recipe, factor) else {
            continue;
        };
        match (explicit, symbolic) {
            (Outcome::Realizable(least), Outcome::Realizable(controller)) => {
                replay::verify(&layout, &recipe, &controller)
                    .unwrap_or_else(|fault| panic!("{seed}: {fault}"));
                assert!(least.worst_case <= controller.worst_case, "{seed}");
                yes += 1;
            }
            (Outcome::Unrealizable(_), Outcome::Unrealizable(_)) => no += 1,
            (explicit, symbolic) => panic!("{seed}: {explicit:?}, but {symbolic:?}"),
        }
    }
    println!("{yes} realizable, {no} not");
    assert!(yes > 50 && no > 50, "{yes} {no}");
}

/// Resources that work on nothing but themselves have 2^30 configurations together.
#[test]
fn resources_that_act_on_their_own_are_no_obstacle() {
    let (mut layout, recipe) = (0..1000)
        .map(random::cell)
        .find(|(layout, recipe)| {
            let waits = |r: &Resource| r.states.iter().all(|s| s.may_wait);
            let outcome = realize(layout, recipe, SearchLimits::default());
            layout.resources.iter().all(waits) && matches!(outcome, Ok(Outcome::Realizable(_)))
        })
        .expect("a cell");
    for number in 0..30 {
        let state = |name: &str| State {
            name: name.to_owned(),
            may_wait: true,
        };
        let turn = |from: &str, to: &str| Transition {
            from: from.to_owned(),
            to: to.to_owned(),
            action: Action::Internal("turn".to_owned()),
            seconds: None,
            watts: None,
        };
        let table = Resource {
            name: format!("table{number}"),
            states: vec![state("left"), state("right")],
            initial: "left".to_owned(),
            transitions: vec![turn("left", "right"), turn("right", "left")],
            capacity: 1,
            holds: Vec::new(),
        };
        layout.resources.push(table);
    }
    let decided = decide(&layout, &recipe, BudgetFactor::default());
    let Some(Outcome::Realizable(controller)) = decided else {
        panic!("{decided:?}");
    };
    replay::verify(&layout, &recipe, &controller).expect("a controller");
}
