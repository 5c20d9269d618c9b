//! The monitor as a function block, run by the interpreter for the other function blocks, beside
//! the monitor of this process.

use super::tables::random;
use crate::iec::document::text_of;
use crate::iec::interpreter::{Program, Variable};
use crate::random::Random;
use crate::unit::pick_and_place;
use linewright::order::monitor::{Monitor, RefusalReason, Verdict};
use linewright::order::table::Table;
use linewright::station::monitor::structured_text::block;

fn compiled(text: &str) -> Program {
    let unit = crate::iec::syntax::parse(text);
    let program = unit.and_then(|unit| Program::new(&unit));
    program.unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A rule's name as a `STRING`.
fn ascii(text: &str) -> String {
    let letters = text.chars().map(|c| match c {
        'Ü' => "Ue".to_owned(),
        ' '..='~' => c.to_string(),
        _ => "?".to_owned(),
    });
    letters.collect()
}

/// Inputs that rise, fall and stay, cycle by cycle. Returns the numbers of cycles with a refusal,
/// and with a grant.
fn compare(program: &Program, table: &Table, cycles: usize, seed: u64) -> (usize, usize) {
    let skills = table.skills.len();
    let of = |name: &String| program.variables[name].clone();
    let variables: Vec<Variable> = program.order.iter().map(of).collect();
    let (reset, inputs) = (&variables[0], &variables[1..=skills]);
    let [allowed, violated, rule] = &variables[skills + 1..skills + 4] else {
        panic!("three outputs")
    };
    let granted = &variables[skills + 4..2 * skills + 4];
    let mut instance = program.instance();
    let mut monitor = Monitor::new(table);
    let mut random = Random::new(seed);
    let (mut given, mut standing) = (0_u64, 0_u64);
    let (mut broken, mut reason) = (false, String::new());
    let (mut refused, mut taken) = (0, 0);
    for cycle in 0..cycles {
        let all = u64::MAX >> (64 - skills);
        // A small change: most inputs stay, a call ends soon.
        for skill in 0..skills {
            let bit = 1 << skill;
            let flips = if given & bit == 0 {
                random.below(4 * skills as u64) == 0
            } else {
                random.chance(50)
            };
            given ^= if flips { bit } else { 0 };
        }
        if random.below(20) == 0 {
            given = table.calls[random.below(table.calls.len() as u64) as usize];
        }
        let resets = random.below(60) == 0;
        instance.set(reset, i64::from(resets));
        for (skill, input) in inputs.iter().enumerate() {
            instance.set(input, (given >> skill & 1) as i64);
        }
        instance.call().unwrap_or_else(|f| panic!("{}", f.0));
        let fine = if resets {
            monitor.reset();
            (standing, broken) = (0, false);
            reason.clear();
            false
        } else {
            let risen = given & !standing & all;
            let verdict = monitor.call_at_once(risen);
            match verdict {
                Verdict::Allowed => {
                    taken += usize::from(risen != 0);
                    standing = given;
                }
                Verdict::Refused(why) => {
                    refused += 1;
                    standing &= given;
                    broken = true;
                    let text = match why {
                        RefusalReason::Rule(rule) => table.rules[rule].name.clone(),
                        other => other.text(&table.rules),
                    };
                    reason = ascii(&text);
                }
            }
            verdict.is_allowed()
        };
        let found: u64 = (0..skills)
            .map(|s| (instance.get(&granted[s]) as u64) << s)
            .sum();
        assert_eq!(found, standing, "cycle {cycle}");
        assert_eq!(instance.get(allowed) != 0, fine, "cycle {cycle}");
        assert_eq!(instance.get(violated) != 0, broken, "cycle {cycle}");
        let said = &program.texts[instance.get(rule) as usize];
        assert_eq!(*said, reason, "cycle {cycle}");
    }
    (refused, taken)
}

#[test]
fn the_unit_as_a_function_block() {
    for recalls in [true, false] {
        let table = pick_and_place(recalls);
        let program = compiled(&block(&table).to_text());
        let (refused, taken) = compare(&program, &table, 20_000, 5);
        assert!(refused > 1_000 && taken > 1_000, "{refused} {taken}");
    }
}

#[test]
fn any_table_as_a_function_block() {
    for seed in 0..60 {
        let table = random(seed);
        for text in [
            block(&table).to_text(),
            text_of(&block(&table).to_plcopen()),
        ] {
            let program = compiled(&text);
            let (refused, taken) = compare(&program, &table, 400, seed);
            assert!(refused + taken > 20, "{refused} {taken}");
        }
    }
}

#[test]
fn what_the_block_looks_like() {
    let block = block(&pick_and_place(false));
    assert_eq!(block.name, "FB_PickAndPlaceOrder");
    insta::assert_snapshot!("block", block.to_text());
}
