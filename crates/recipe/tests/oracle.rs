//! The search against an oracle on random small cells: same verdict, same least number of vectors.
//! Each controller is replayed, and so are mutants of it, which have to be refused.
//!
//! `LINEWRIGHT_RECIPE_CELLS` sets the number of cells; the long form is
//! `LINEWRIGHT_RECIPE_CELLS=100000 cargo test --release -p linewright-recipe --test oracle`.
//! `LINEWRIGHT_RECIPE_SEED` sets the first cell.

mod support;

use linewright_recipe::realize::{Outcome, SearchLimits, is_realizable, realize};
use linewright_recipe::replay;
use support::mutants;
use support::naive::{self, Answer};
use support::random::{self, Random};

fn setting(name: &str, default: u64) -> u64 {
    let text = std::env::var(name).unwrap_or_default();
    text.parse().unwrap_or(default)
}

#[test]
fn the_search_agrees_with_the_oracle() {
    let cells = setting("LINEWRIGHT_RECIPE_CELLS", 2_000);
    let first = setting("LINEWRIGHT_RECIPE_SEED", 0);
    // The oracle's time grows with the square of the size.
    let max_nodes = if cells > 10_000 { 2_000 } else { 500 };
    let (mut realizable, mut searched, mut loops, mut skipped) = (0, 0, 0, 0);
    let (mut longest, mut refused) = (0, 0);
    let mut random = Random(first);
    for seed in first..first + cells {
        let (layout, recipe) = random::cell(seed);
        let answer = naive::decide(&layout, &recipe, max_nodes);
        let outcome = realize(&layout, &recipe, SearchLimits::default());
        let outcome = outcome.unwrap_or_else(|problems| panic!("{seed}: {problems:?}"));
        let verdict = is_realizable(&layout, &recipe, SearchLimits::default());
        let expected = matches!(outcome, Outcome::Realizable(_));
        assert_eq!(verdict, Ok(Some(expected)), "{seed}");
        if answer == Answer::TooLarge {
            skipped += 1;
            continue;
        }
        match outcome {
            Outcome::Realizable(controller) => {
                let worst_case = controller.worst_case as usize;
                assert_eq!(answer, Answer::Realizable(worst_case), "{seed}");
                assert!(controller.is_least, "{seed}");
                let replayed = replay::verify(&layout, &recipe, &controller);
                assert_eq!(replayed, Ok(()), "{seed}");
                for _ in 0..8 {
                    let mutant = mutants::mutate(&layout, &controller, &mut random);
                    let Some(mutant) = mutant else { continue };
                    let replayed = replay::verify(&layout, &recipe, &mutant);
                    assert!(replayed.is_err(), "{seed}: {controller:#?} {mutant:#?}");
                    refused += 1;
                }
                realizable += 1;
                loops += usize::from(recipe.closes_loop().contains(&true));
                longest = longest.max(worst_case);
            }
            Outcome::Unrealizable(refusal) => {
                assert_eq!(answer, Answer::Unrealizable, "{seed}");
                searched += usize::from(refusal.obstacles.is_empty());
            }
            Outcome::GaveUp(size) => panic!("{seed}: {size:?}"),
        }
    }
    println!(
        "{cells} cells: {realizable} realizable ({loops} with loops, longest {longest}), \
         {searched} unrealizable by search, {skipped} skipped, {refused} mutants refused"
    );
}
