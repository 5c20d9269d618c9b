//! The reconstructed demonstrator of the paper: size of its topology, verdicts, shortest plans.

mod support;

use linewright_recipe::controller::Controller;
use linewright_recipe::realize::{Outcome, SearchLimits, realize};
use linewright_recipe::topology::{self, TopologySize};
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
        let start = std::time::Instant::now();
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
        eprintln!("{resources} {parallel} {:?}", start.elapsed());
        assert_eq!(
            found, expected,
            "{resources} resources, parallel: {parallel}"
        );
    }
}

#[test]
#[ignore]
fn large() {
    for n in [10, 20, 50, 100] {
        let start = std::time::Instant::now();
        let c = controller(n, false);
        eprintln!("{n}: {:?} {:?}", start.elapsed(), c.map(|c| c.worst_case));
        let start = std::time::Instant::now();
        let mut layout = pad::layout(n);
        for r in &mut layout.resources {
            for s in &mut r.states {
                s.may_wait = true;
            }
        }
        let c = realize(&layout, &pad::hinge(false), SearchLimits::default());
        let Ok(Outcome::Realizable(c)) = c else {
            panic!("{c:?}")
        };
        eprintln!(
            "   all may wait {n}: {:?} {:?}",
            start.elapsed(),
            c.worst_case
        );
    }
}
