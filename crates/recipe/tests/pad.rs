//! The reconstructed demonstrator of the paper: size of its topology, verdicts, shortest plans.

mod support;

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
