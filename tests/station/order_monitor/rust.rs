//! The monitor of this process compared with its table.

use super::reference::{Reference, some_call};
use super::tables::random;
use crate::random::Random;
use crate::unit::pick_and_place;
use linewright::order::monitor::{Monitor, Refusal, RefusalReason, Verdict};
use linewright::order::table::Table;

/// The skills of the unit by their first letters; `R` is Right, `r` Release.
fn word(text: &str) -> Vec<u8> {
    let skill = |c| "LRUDGr".find(c).expect("a skill") as u8;
    text.chars().map(skill).collect()
}

#[test]
fn the_unit_is_watched() {
    let table = pick_and_place(true);
    let mut monitor = Monitor::new(&table);
    // The paper's intended sequence, and the one that hits the trays.
    assert_eq!(monitor.run(&word("RDGULDrU")), None);
    monitor.reset();
    let refusal = monitor.run(&word("LUDGRr"));
    let trays = RefusalReason::Rule(0);
    assert_eq!(refusal, Some(Refusal { at: 4, why: trays }));
    assert_eq!(
        trays.text(&table.rules),
        "trays: after Down until Up: never Left, Right"
    );
    // A refused call has no effect.
    assert_eq!(monitor.call(5), Verdict::Allowed);
    assert_eq!(monitor.allowed(), 0b11_1100);
    // Up and Right at once: in one order of the two the arm moves while it is down.
    assert_eq!(monitor.allows(0b110), Verdict::Refused(trays));
    assert_eq!(
        monitor.call_at_once(0b101_0000),
        Verdict::Refused(RefusalReason::Unknown)
    );
    assert_eq!(
        monitor.call_at_once(0b11),
        Verdict::Refused(RefusalReason::Together)
    );
    let strict = pick_and_place(false);
    let mut monitor = Monitor::new(&strict);
    assert_eq!(monitor.call(2), Verdict::Refused(RefusalReason::Recall));
    assert_eq!(monitor.allowed(), 0b01_1010);
}

/// Random calls, and random runs of single skills.
fn compare(table: &Table, steps: usize, seed: u64) {
    let mut random = Random::new(seed);
    let mut monitor = Monitor::new(table);
    let mut reference = Reference::new(table);
    for step in 0..steps {
        if random.below(100) == 0 {
            monitor.reset();
            reference.reset();
        }
        let singles = (0..table.skills.len()).filter(|s| reference.look(1 << s).is_ok());
        assert_eq!(monitor.allowed(), singles.fold(0, |mask, s| mask | 1 << s));
        if random.chance(20) {
            let bound = table.skills.len() as u64 + random.below(2);
            let skill = |_| random.below(bound.min(255)) as u8;
            let calls: Vec<u8> = (0..10).map(skill).collect();
            let mut wanted = None;
            for (at, skill) in calls.iter().enumerate() {
                let unknown = usize::from(*skill) >= table.skills.len();
                let made = if unknown {
                    Err(RefusalReason::Unknown)
                } else {
                    reference.call(1 << skill)
                };
                if let Err(why) = made {
                    wanted = Some(Refusal { at, why });
                    break;
                }
            }
            assert_eq!(monitor.run(&calls), wanted, "step {step}: {calls:?}");
        } else {
            let call = some_call(table, &mut random);
            let wanted = match reference.look(call) {
                Ok(_) => Verdict::Allowed,
                Err(why) => Verdict::Refused(why),
            };
            assert_eq!(monitor.allows(call), wanted, "step {step}: {call:b}");
            let made = if call.is_power_of_two() && random.chance(50) {
                monitor.call(call.trailing_zeros() as u8)
            } else {
                monitor.call_at_once(call)
            };
            assert_eq!(made, wanted, "step {step}: {call:b}");
            assert_eq!(reference.call(call).is_ok(), made.is_allowed());
        }
        assert_eq!(monitor.state(), reference.state(), "step {step}");
    }
}

#[test]
fn it_says_what_the_table_says() {
    for recalls in [false, true] {
        compare(&pick_and_place(recalls), 20_000, 3);
    }
    for seed in 0..200 {
        compare(&random(seed), 300, seed);
    }
}

#[test]
fn no_number_of_a_skill_is_out_of_bounds() {
    let table = pick_and_place(true);
    let mut monitor = Monitor::new(&table);
    for skill in 6..=u8::MAX {
        assert_eq!(
            monitor.call(skill),
            Verdict::Refused(RefusalReason::Unknown)
        );
        let unknown = Refusal {
            at: 1,
            why: RefusalReason::Unknown,
        };
        assert_eq!(monitor.run(&[2, skill, 2]), Some(unknown));
    }
    assert_eq!(
        monitor.call_at_once(u64::MAX),
        Verdict::Refused(RefusalReason::Unknown)
    );
    assert_eq!(
        monitor.call_at_once(1 << 63),
        Verdict::Refused(RefusalReason::Unknown)
    );
}
