//! Tables of written rules, compared with the rules themselves, call by call.

use super::reference::some_call;
use crate::random::Random;
use crate::unit;
use linewright::contract::load;
use linewright::diagnostics::has_errors;
use linewright::order::fsm::calls;
use linewright::order::monitor::{Monitor, RefusalReason, Verdict};
use linewright::order::supervisor::{Call, Options, Refusal, Supervisor};
use linewright::order::table::Table;
use linewright::order::{Level, Serialisation, Skills};
use std::sync::Arc;

const UNIT: &str = "
skills PickAndPlace {
    component x: {left, right} = left {
        Left -> left
        Right -> right
    }
    component z: {up, down} = up {
        Up -> up
        Down -> down
    }
    component gripper: {open, closed} = open {
        Grip -> closed
        Release -> open
    }

    order trays: after Down until Up: never Left, Right
    order transport: after Up until Down: never Release
}
";

/// More rules, of every kind.
const ALL: &str = "
    order tries: at most 2 of Grip between Down and Up
    order apart: never Left & Down
    order homing: Right before Down
    order one_grip: Release only after Grip
    order tidy: never Grip, Release twice in a row
    order cycle: sequence (Right? (Down | Grip | Up | Release | Left){1,9})*
";

fn skills(text: &str) -> Arc<Skills> {
    let files = [("test.lw".to_owned(), text.to_owned())];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(!has_errors(&findings), "{text}\n{findings:#?}");
    Arc::clone(&library.skills[0])
}

/// The table, with a monitor of it compared with the rules.
fn compare(skills: &Skills, options: Options, steps: usize) -> Table {
    let mut supervisor = Supervisor::new(skills, options).expect("small rules");
    let table = Table::explore(&supervisor, calls(skills, 3)).expect("a small table");
    let mut monitor = Monitor::new(&table);
    let mut state = supervisor.start();
    let mut random = Random::new(steps as u64);
    let mut allowed = 0;
    for step in 0..steps {
        let mask = some_call(&table, &mut random) & 0b11_1111;
        if mask == 0 {
            continue;
        }
        let said = monitor.call_at_once(mask);
        match supervisor.call(&state, Call(mask)).expect("few skills") {
            Ok(after) => {
                assert_eq!(said, Verdict::Allowed, "step {step}: {mask:b}");
                allowed += 1;
                state = after;
            }
            Err(refusal) => {
                let why = match refusal {
                    Refusal::SameComponent { .. } => RefusalReason::Together,
                    Refusal::Recall { .. } => RefusalReason::Recall,
                    Refusal::Rule { rule, .. } | Refusal::Deleted { rule } => {
                        RefusalReason::Rule(rule)
                    }
                };
                assert_eq!(said, Verdict::Refused(why), "step {step}: {mask:b}");
            }
        }
        if random.below(200) == 0 {
            monitor.reset();
            state = supervisor.start();
        }
    }
    assert!(allowed > steps / 50, "{allowed} of {steps}");
    table
}

#[test]
fn a_table_of_rules_says_what_the_rules_say() {
    let unit = skills(UNIT);
    let all = skills(&UNIT.replace("never Release\n", &format!("never Release\n{ALL}")));
    assert_eq!(all.rules.len(), 8);
    for skills in [&unit, &all] {
        for level in Level::ALL {
            for serialisation in [Serialisation::Every, Serialisation::Some] {
                let options = Options {
                    level,
                    serialisation,
                    ..Options::default()
                };
                compare(skills, options, 4_000);
            }
        }
    }
}

#[test]
fn the_table_by_hand_is_that_of_the_rules() {
    let unit = skills(UNIT);
    for (level, recalls) in [(Level::Valid, true), (Level::Reasonable, false)] {
        let options = Options {
            level,
            ..Options::default()
        };
        let table = compare(&unit, options, 4_000);
        let by_hand = unit::pick_and_place(recalls);
        // If nothing refers to the situation, the table distinguishes fewer states.
        assert!(table.states <= by_hand.states);
        assert_eq!(table.skills, by_hand.skills);
        let (mut one, mut other) = (Monitor::new(&table), Monitor::new(&by_hand));
        let mut random = Random::new(9);
        for _ in 0..20_000 {
            let call = some_call(&table, &mut random);
            let both = (one.call_at_once(call), other.call_at_once(call));
            // If several reasons hold, either may be named.
            assert_eq!(both.0.is_allowed(), both.1.is_allowed(), "{call:b}");
        }
    }
}
