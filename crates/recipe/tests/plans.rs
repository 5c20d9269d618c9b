//! Plans of several products against oracles on random small cells: lockstep against a fixpoint
//! over all vectors, timed plans against a simulation in steps of one second. Every plan is
//! replayed.
//!
//! `LINEWRIGHT_RECIPE_PLANS` multiplies the number of cells; the long form is
//! `LINEWRIGHT_RECIPE_PLANS=20 cargo test --release -p linewright-recipe --test plans`.

mod support;

use linewright_recipe::model::{Demand, Guard, Layout};
use linewright_recipe::plan::{Method, Objective, PlanLimits, PlanOutcome, plan};
use linewright_recipe::realize::{Outcome, SearchLimits, realize};
use linewright_recipe::replay_plan;
use support::naive::Answer;
use support::naive_timed::{Timed, least};
use support::{naive_plan, plan_mutants, random};

fn scale() -> u64 {
    let text = std::env::var("LINEWRIGHT_RECIPE_PLANS").unwrap_or_default();
    text.parse().unwrap_or(1)
}

fn limits(nodes: usize) -> PlanLimits {
    PlanLimits {
        nodes,
        together: nodes,
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
    for seed in 0..300 * scale() {
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

/// Compares plans on random cells with the oracle. Returns how many of them are proved optimal.
fn compare(objective: Objective, seeds: std::ops::Range<u64>) {
    let unit = match objective {
        Objective::Time => 1_000_000_000,
        Objective::Energy => 1_000_000,
        _ => 1,
    };
    let (mut realizable, mut unrealizable, mut given_up) = (0, 0, 0);
    let (mut tests, mut exact, mut together) = (0, 0, 0);
    for seed in seeds {
        let (mut layout, mut demands) = demands(seed);
        if seed % 2 == 0 {
            demands.truncate(1);
            demands[0].count = 1;
        }
        for demand in &mut demands {
            let recipe = &mut demand.recipe;
            let closes = recipe.closes_loop();
            for (transition, _) in recipe.transitions.iter_mut().zip(closes).filter(|c| c.1) {
                transition.to.clone_from(&recipe.ends[0]);
            }
        }
        let recipes = || demands.iter().map(|d| &d.recipe);
        let has_tests = recipes().any(|r| r.transitions.iter().any(|t| t.guard != Guard::Always));
        random::set_times(seed, &mut layout, has_tests);
        if recipes().any(|r| r.problems().iter().any(|p| !p.is_warning())) {
            continue;
        }
        let answer = least(&layout, &demands, objective, 2_000);
        if answer == Timed::TooLarge {
            continue;
        }
        match (answer, planned(&layout, &demands, objective, 2_000)) {
            (Timed::Realizable(cost), PlanOutcome::Planned(plan)) => {
                let cost = cost as i64 * unit;
                assert!(plan.lower_bound <= cost, "{seed}: {cost} {plan:#?}");
                assert!(cost <= plan.value, "{seed}: {cost} {plan:#?}");
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
        "{objective:?}: {realizable} realizable ({exact} proved, {tests} with tests, {together} of \
         several products), {unrealizable} not, {given_up} given up"
    );
    assert!(exact * 10 >= realizable * 9 && realizable > 10);
}

#[test]
fn least_times_agree_with_the_oracle() {
    compare(Objective::Time, 0..300 * scale());
}

#[test]
fn least_energies_and_transfers_agree_with_the_oracle() {
    compare(Objective::Energy, 0..150 * scale());
    compare(Objective::Transfers, 1_000_000..1_000_000 + 150 * scale());
}

#[test]
fn changed_plans_are_refused() {
    let mut random = random::Random(7);
    let mut refused = 0;
    for seed in 0..250 * scale() {
        let (mut layout, demands) = demands(seed);
        random::set_times(seed, &mut layout, false);
        for objective in [Objective::Steps, Objective::Time] {
            let PlanOutcome::Planned(found) = planned(&layout, &demands, objective, 1_000) else {
                continue;
            };
            for _ in 0..20 {
                let mutant = plan_mutants::mutate(&layout, &found, &mut random);
                let Some(mutant) = mutant else { continue };
                let replayed = replay_plan::verify(&layout, &demands, &mutant);
                assert!(replayed.is_err(), "{seed}: {found:#?} {mutant:#?}");
                refused += 1;
            }
        }
    }
    println!("{refused} changed plans refused");
    assert!(refused > 500);
}
