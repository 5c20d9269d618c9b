//! Preferences of a machine: it is correct whatever is preferred, and preferring few states never
//! gives more.

use super::{benchmark, fixtures, random};
use linewright::game::{Limits, Outcome, Preference, solve};
use linewright::gr1::Specification;
use linewright::mealy::extract::{extract, extract_with_preference};
use linewright::mealy::gr1c;
use linewright::mealy::verify::verify;

/// The number of states of the verified machine for each preference: short reactions, few states.
fn states(specification: &Specification) -> Option<[usize; 2]> {
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(specification, &limits) else {
        return None;
    };
    let made = [Preference::Reaction, Preference::States].map(|preference| {
        let machine =
            extract_with_preference(preference, specification, &won, &limits).expect("no limit");
        let verdict = verify(specification, &machine, &limits).expect("no limit");
        assert!(
            verdict.is_ok(),
            "{}, {preference:?}: {verdict:?}",
            specification.name
        );
        machine.states.len()
    });
    assert!(made[1] <= made[0], "{}: {made:?}", specification.name);
    Some(made)
}

#[test]
fn few_states_are_never_more() {
    let mut specifications = fixtures::contracts();
    specifications
        .extend((0..300).map(|seed| random::specification(&mut random::Random::new(seed))));
    specifications.extend(
        (0..300).map(|seed| random::specification_with_goals(&mut random::Random::new(seed))),
    );
    let found: Vec<[usize; 2]> = specifications.iter().filter_map(states).collect();
    let fewer = found.iter().filter(|[quick, few]| few < quick).count();
    let sum = |i: usize| found.iter().map(|made| made[i]).sum::<usize>();
    println!(
        "{} machines: {} states for short reactions; {} for few states, {fewer} of them smaller",
        found.len(),
        sum(0),
        sum(1)
    );
    assert!(found.len() > 150 && fewer > 0);
}

/// gr1c's own automaton for this specification has 14,070 nodes.
#[test]
fn a_large_machine_has_fewer_nodes_than_that_of_gr1c() {
    let Some(specification) = benchmark("genbuf5.slugsin") else {
        return;
    };
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(&specification, &limits) else {
        panic!("genbuf5 is realizable");
    };
    let machine = extract(&specification, &won, &limits).expect("no limit");
    assert_eq!(verify(&specification, &machine, &limits), Ok(Ok(())));
    let automaton = gr1c::to_json(&machine, &specification).expect("no limit");
    let nodes = automaton["nodes"].as_object().expect("nodes").len();
    println!("{} states, {nodes} nodes", machine.states.len());
    assert!(nodes < 14_070);
}
