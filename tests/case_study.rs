//! The case study's contracts from specification to verified machine.

mod fixtures;

use linewright::game::{Limits, Outcome, examine_environment, solve};
use linewright::mealy::{extract::extract, verify::verify};
use std::time::Instant;

#[test]
fn every_contract_has_a_machine_that_passes_the_verifier() {
    let limits = Limits::default();
    for specification in fixtures::contracts() {
        let begin = Instant::now();
        let won = match solve(&specification, &limits) {
            Outcome::Realizable(won) => won,
            Outcome::Unrealizable(lost) => {
                panic!(
                    "{}: {:?}",
                    specification.name,
                    lost.core_names(&specification)
                )
            }
            Outcome::GaveUp(limit) => panic!("{}: {limit}", specification.name),
        };
        let solved = Instant::now();
        let machine = extract(&specification, &won, &limits).expect("no limit");
        let extracted = Instant::now();
        let verdict = verify(&specification, &machine, &limits).expect("no limit");
        let verified = Instant::now();
        assert_eq!(verdict, Ok(()), "{}", specification.name);
        let findings = examine_environment(&specification, &limits).expect("no limit");
        println!(
            "{:14} {:4} states {:5} rows; solve {:8.2?} extract {:8.2?} verify {:8.2?} findings {:8.2?}; peak {} nodes; separated {} dead end {:?}",
            specification.name,
            machine.states.len(),
            machine.transition_count(),
            solved - begin,
            extracted - solved,
            verified - extracted,
            verified.elapsed(),
            won.peak_nodes,
            findings.well_separated(),
            findings.dead_end.is_some(),
        );
    }
}
