//! Why a specification is unrealizable: cores, counterstrategies, plays and repairs, on random specifications and on the
//! public benchmarks.

#[path = "explained/bench.rs"]
mod bench;
#[path = "explained/legal.rs"]
mod legal;
#[expect(dead_code, reason = "the oracle's tests use more of it")]
#[path = "oracle/random.rs"]
mod random;
mod support;

use legal::legal;
use linewright::game::{Limits, Outcome, attack, reduced, solve};
use linewright::gr1::Timing;
use linewright::mealy::counter::machine;
use linewright::mealy::verify::verify_counterstrategy;
use random::{Random, specification};

#[test]
fn counterstrategies_of_random_specifications() {
    let limits = Limits::default();
    let (mut lost, mut moore, mut starved, mut states) = (0, 0, 0, 0);
    for seed in 0..3_000 {
        let spec = specification(&mut Random::new(seed));
        let found = match solve(&spec, &limits) {
            Outcome::Realizable(_) => {
                assert!(
                    attack(&spec, &limits).expect("no limit").is_none(),
                    "seed {seed}"
                );
                continue;
            }
            Outcome::Unrealizable(found) => found,
            Outcome::GaveUp(limit) => panic!("gave up without a limit: {limit}"),
        };
        lost += 1;
        moore += u32::from(spec.timing == Timing::Moore);
        let core = found.core.expect("no limit");
        for spec in [spec.clone(), reduced(&spec, &core)] {
            let attack = attack(&spec, &limits).expect("no limit");
            let attack = attack.unwrap_or_else(|| panic!("seed {seed}: nothing beats {spec:#?}"));
            let machine = machine(&spec, &attack);
            let verdict = verify_counterstrategy(&spec, &machine, &limits).expect("no limit");
            assert_eq!(verdict, Ok(()), "seed {seed}: {machine:#?}\n{spec:#?}");
            let told = legal(&spec, &attack.play);
            assert_eq!(told, Ok(()), "seed {seed}: {:#?}\n{spec:#?}", attack.play);
            starved += u32::from(matches!(
                attack.play.ending,
                linewright::game::Ending::Starved { .. }
            ));
            states = states.max(machine.states.len());
        }
    }
    println!("{lost} lost, {moore} of them Moore, {starved} by starving, at most {states} states");
    assert!(lost > 700 && moore > 200 && starved > 100);
}
