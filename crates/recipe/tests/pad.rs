//! The reconstructed demonstrator of the paper: size of its topology, verdicts, shortest plans.

mod support;

use linewright_recipe::controller::Controller;
use linewright_recipe::realize::{Outcome, SearchLimits, realize};
use linewright_recipe::replay;
use linewright_recipe::topology::{self, TopologySize};
use support::naive::{self, Answer};
use support::pad;

#[test]
fn the_topology_has_the_size_that_the_paper_says() {
    let sizes = [
        (5, 288, 1_300),
        (6, 1_060, 7_673),
        (7, 2_600, 30_284),
        (8, 14_592, 222_502),
        (9, 36_960, 645_264),
        (10, 84_288, 2_354_562),
    ];
    for (resources, states, transitions) in sizes {
        let size = topology::size(&pad::layout(resources), 1 << 20);
        assert_eq!(
            size,
            Ok(TopologySize {
                states,
                transitions
            }),
            "{resources}"
        );
    }
}

fn controller(resources: usize, parallel: bool) -> Option<Controller> {
    let outcome = realize(
        &pad::layout(resources),
        &pad::hinge(parallel),
        SearchLimits::default(),
    );
    match outcome {
        Ok(Outcome::Realizable(controller)) => Some(controller),
        Ok(Outcome::Unrealizable(_)) => None,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_shortest_plans_have_the_lengths_that_were_measured() {
    for (resources, parallel, expected) in [
        (5, false, Some([17, 21, 20])),
        (5, true, None),
        (6, false, Some([16, 20, 19])),
        (6, true, Some([17, 21, 20])),
    ] {
        let found = controller(resources, parallel).map(|c| {
            let first = &c.positions[0].legs[0];
            let tested = &c.positions[first.to];
            let forced = &c.positions[tested.legs[0].to];
            let length = first.vectors.len();
            let removed = length + tested.legs[1].vectors.len();
            let stored = length + tested.legs[0].vectors.len() + forced.legs[0].vectors.len();
            assert_eq!(c.worst_case as usize, stored);
            [length, stored, removed]
        });
        assert_eq!(
            found, expected,
            "{resources} resources, parallel: {parallel}"
        );
    }
}

#[test]
fn every_controller_passes_the_replay() {
    for resources in 5..=12 {
        for parallel in [false, true] {
            let found = controller(resources, parallel);
            assert_eq!(found.is_some(), resources > 5 || !parallel);
            if let Some(found) = found {
                assert!(found.is_least);
                assert_eq!(controller(resources, parallel).as_ref(), Some(&found));
                let (layout, recipe) = (pad::layout(resources), pad::hinge(parallel));
                assert_eq!(replay::verify(&layout, &recipe, &found), Ok(()));
            }
        }
    }
}

/// If the glue robot holds one part only, the glued pin cannot come back while the hinge is at R2.
#[test]
fn capacity_decides() {
    for (capacity, expected) in [(1, false), (2, true)] {
        let mut layout = pad::five();
        layout.resources[2].capacity = capacity;
        let outcome = realize(&layout, &pad::hinge(false), SearchLimits::default());
        let realizable = matches!(outcome, Ok(Outcome::Realizable(_)));
        assert_eq!(realizable, expected, "{capacity}");
    }
}

#[test]
fn the_naive_oracle_says_the_same() {
    for (parallel, expected) in [
        (false, Answer::Realizable(21)),
        (true, Answer::Unrealizable),
    ] {
        let answer = naive::decide(&pad::five(), &pad::hinge(parallel), 100_000);
        assert_eq!(answer, expected);
    }
}

/// Measures large layouts. A release build may take 50 ms for 50 resources, and 500 ms for 100.
#[test]
#[ignore = "measures: cargo test --release -p linewright-recipe --test pad -- --ignored --nocapture"]
fn large_layouts() {
    for resources in [5, 6, 10, 20, 50, 100] {
        let layout = pad::layout(resources);
        let mut restful = layout.clone();
        for state in restful.resources.iter_mut().flat_map(|r| &mut r.states) {
            state.may_wait = true;
        }
        for (text, layout) in [("as drawn", layout), ("all may wait", restful)] {
            let start = std::time::Instant::now();
            let outcome = realize(&layout, &pad::hinge(false), SearchLimits::default());
            let taken = start.elapsed();
            let Ok(Outcome::Realizable(found)) = outcome else {
                panic!("{outcome:?}");
            };
            println!(
                "{resources} resources, {text}: {taken:?}, {} vectors",
                found.worst_case
            );
        }
    }
}
