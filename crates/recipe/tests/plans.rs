//! Plans of several products against oracles on random small cells: lockstep against a fixpoint over
//! all vectors, timed plans against a simulation in steps of one second. Every plan is replayed.
//!
//! `LINEWRIGHT_RECIPE_PLANS` multiplies the number of cells; the long form is
//! `LINEWRIGHT_RECIPE_PLANS=20 cargo test --release -p linewright-recipe --test plans`.

mod support;

use linewright_recipe::model::{Demand, Guard, Layout};
use linewright_recipe::plan::{Method, Objective, PlanLimits, PlanOutcome, plan};
use linewright_recipe::realize::{Outcome, SearchLimits, realize};
use linewright_recipe::replay_plan;
use support::naive::Answer;
use support::naive_timed::{Timed, least_time};
use support::{naive_plan, random};

fn scale() -> u64 {
    let text = std::env::var("LINEWRIGHT_RECIPE_PLANS").unwrap_or_default();
    text.parse().unwrap_or(1)
}

fn limits(nodes: usize) -> PlanLimits {
    PlanLimits {
        nodes,
        ..PlanLimits::default()
    }
}

fn planned(layout: &Layout, demands: &[Demand], objective: Objective, nodes: usize) -> PlanOutcome {
    let outcome = plan(layout, demands, objective, limits(nodes));
    let outcome = outcome.unwrap_or_else(|problems| panic!("{problems:?}"));
    if let PlanOutcome::Planned(found) = &outcome {
        assert_eq!(replay_plan::verify(layout, demands, found), Ok(()));
        assert!(found.lower_bound <= found.value);
    }
    outcome
}

#[test]
fn one_product_takes_the_vectors_of_its_controller() {
    let (mut realizable, mut unrealizable, mut given_up) = (0, 0, 0);
    for seed in 0..600 * scale() {
        let (layout, recipe) = random::cell(seed);
        let controller = realize(&layout, &recipe, SearchLimits::default());
        let outcome = planned(&layout, &[Demand::new(recipe, 1)], Objective::Steps, 3_000);
        match (controller.expect("there are no problems"), outcome) {
            (Outcome::Realizable(controller), PlanOutcome::Planned(plan)) => {
                assert_eq!(plan.value, i64::from(controller.worst_case), "{seed}");
                assert!(plan.is_least(), "{seed}");
                realizable += 1;
            }
            (Outcome::Unrealizable(_), PlanOutcome::Unrealizable { .. }) => unrealizable += 1,
            (_, PlanOutcome::GaveUp { .. }) => given_up += 1,
            (controller, outcome) => panic!("{seed}: {controller:?} {outcome:?}"),
        }
    }
    println!("{realizable} realizable, {unrealizable} not, {given_up} given up");
    assert!(given_up * 20 < realizable + unrealizable);
}

/// Returns a random layout with two or three products.
fn demands(seed: u64) -> (Layout, Vec<Demand>) {
    let (layout, recipe) = random::cell(seed);
    let demands = match seed % 3 {
        0 => vec![Demand::new(recipe, 2)],
        1 => vec![
            Demand::new(recipe, 1),
            Demand::new(random::second_recipe(seed, &layout), 1),
        ],
        _ => vec![Demand::new(recipe, 3)],
    };
    (layout, demands)
}

#[test]
fn several_products_in_lockstep_agree_with_the_oracle() {
    let (mut realizable, mut unrealizable, mut given_up, mut together) = (0, 0, 0, 0);
    for seed in 0..400 * scale() {
        let (layout, demands) = demands(seed);
        let answer = naive_plan::decide(&layout, &demands, 400);
        if answer == Answer::TooLarge {
            continue;
        }
        match (answer, planned(&layout, &demands, Objective::Steps, 3_000)) {
            (Answer::Realizable(vectors), PlanOutcome::Planned(plan)) => {
                assert!(plan.lower_bound <= vectors as i64, "{seed}");
                assert!(vectors as i64 <= plan.value, "{seed}");
                if plan.nodes < 3_000 {
                    assert_eq!(plan.value, vectors as i64, "{seed}");
                    assert!(plan.is_least(), "{seed}");
                    together += usize::from(plan.method == Method::Search);
                }
                realizable += 1;
            }
            (Answer::Unrealizable, PlanOutcome::Unrealizable { .. }) => unrealizable += 1,
            (_, PlanOutcome::GaveUp { .. }) => given_up += 1,
            (answer, outcome) => panic!("{seed}: {answer:?} {outcome:?}"),
        }
    }
    println!(
        "{realizable} realizable ({together} better than one after the other), \
         {unrealizable} not, {given_up} given up"
    );
    assert!(realizable > 10 && unrealizable > 10);
}

#[test]
fn least_times_agree_with_the_oracle() {
    let (mut realizable, mut unrealizable, mut given_up) = (0, 0, 0);
    let (mut tests, mut exact, mut together) = (0, 0, 0);
    for seed in 0..700 * scale() {
        let (mut layout, mut demands) = demands(seed);
        if seed % 2 == 0 {
            demands.truncate(1);
            demands[0].count = 1;
        }
        let recipes = || demands.iter().map(|d| &d.recipe);
        if recipes().any(|r| r.closes_loop().contains(&true)) {
            continue;
        }
        let has_tests = recipes().any(|r| r.transitions.iter().any(|t| t.guard != Guard::Always));
        random::set_times(seed, &mut layout, has_tests);
        let answer = least_time(&layout, &demands, 3_000);
        if answer == Timed::TooLarge {
            continue;
        }
        match (answer, planned(&layout, &demands, Objective::Time, 3_000)) {
            (Timed::Realizable(seconds), PlanOutcome::Planned(plan)) => {
                let nanoseconds = seconds as i64 * 1_000_000_000;
                assert!(
                    plan.lower_bound <= nanoseconds,
                    "{seed}: {seconds} {plan:#?}"
                );
                assert!(nanoseconds <= plan.value, "{seed}: {seconds} {plan:#?}");
                realizable += 1;
                tests += usize::from(has_tests);
                exact += usize::from(plan.is_least());
                together += usize::from(plan.products.len() > 1);
            }
            (Timed::Unrealizable, PlanOutcome::Unrealizable { .. }) => unrealizable += 1,
            (_, PlanOutcome::GaveUp { .. }) => given_up += 1,
            (answer, outcome) => panic!("{seed}: {answer:?} {outcome:?}"),
        }
    }
    println!(
        "{realizable} realizable ({exact} proved, {tests} with tests, {together} of several products), \
         {unrealizable} not, {given_up} given up"
    );
    assert!(exact * 10 >= realizable * 9);
}
