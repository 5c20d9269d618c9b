//! Guarantees that read the same monitor: none of them is to blame for the demands of another.

use crate::random::Random;
use linewright::contract;
use linewright::game::{Limits, LostGame, Outcome, advise, attack, select_guarantees, solve};
use linewright::gr1::Specification;
use std::fmt::Write as _;

/// Forms of guarantees; `P` is one of few past formulas, so that most contracts use one of them
/// twice.
const WORDS: [&str; 10] = [
    "always (x <-> P)",
    "always not P",
    "always (P -> y)",
    "always (P -> not x)",
    "always (a -> next y)",
    "always (x or y)",
    "always not (x and y)",
    "always eventually (P or x)",
    "always eventually not P",
    "always (b -> not y)",
];
const PAST: [&str; 4] = ["previous a", "once b", "(not a since b)", "historically a"];

fn specification(guarantees: &[String]) -> Specification {
    let mut text = String::from("contract C {\n    input a, b: bool\n    output x, y: bool\n");
    for (i, guarantee) in guarantees.iter().enumerate() {
        let _ = writeln!(text, "    guarantee g{i}: {guarantee}");
    }
    text += "}\n";
    let files = [("c.lw".to_owned(), text.clone())];
    let (library, _) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    assert_eq!(library.contracts.len(), 1, "{text}");
    (*library.contracts[0].specification).clone()
}

fn lost(guarantees: &[String]) -> Option<(Specification, LostGame)> {
    let specification = specification(guarantees);
    match solve(&specification, &Limits::default()) {
        Outcome::Unrealizable(lost) => Some((specification, lost)),
        Outcome::Realizable(_) => None,
        Outcome::GaveUp(_) => panic!("{guarantees:?}"),
    }
}

/// The guarantees with these names; others are removed from the text.
fn only(guarantees: &[String], kept: impl Fn(&str) -> bool) -> Vec<String> {
    let numbered = guarantees.iter().enumerate();
    numbered
        .map(|(i, g)| {
            if kept(&format!("g{i}")) {
                g.clone()
            } else {
                "true".to_owned()
            }
        })
        .collect()
}

/// Every core is correct by name: its guarantees alone clash, and without any one of them the
/// others do not. Leaving out what is suggested repairs the whole.
#[test]
fn cores_name_no_guarantee_for_a_monitor_that_it_shares() {
    let limits = Limits::default();
    let (mut found, mut smaller, mut left_out) = (0, 0, 0);
    for seed in 0..400 {
        let mut r = Random::new(seed);
        let past = [PAST[r.below(4) as usize], PAST[r.below(4) as usize]];
        let guarantees: Vec<String> = (0..3 + r.below(3))
            .map(|_| {
                let words = WORDS[r.below(WORDS.len() as u64) as usize];
                words.replace('P', past[usize::from(r.below(4) == 0)])
            })
            .collect();
        let Some((specification, lost_game)) = lost(&guarantees) else {
            continue;
        };
        found += 1;
        let core = lost_game.core_formulas(&specification).into_iter();
        let names: Vec<String> = core.map(|f| f.name.clone()).collect();
        let shown = format!("seed {seed}: {guarantees:?}, core {names:?}");
        let is_in = |name: &str| names.iter().any(|n| n == name);
        assert!(lost(&only(&guarantees, is_in)).is_some(), "{shown}");
        for one in &names {
            let others = only(&guarantees, |name| is_in(name) && name != one);
            assert!(lost(&others).is_none(), "{shown} without {one}");
        }
        smaller += u32::from(names.len() < guarantees.len());
        let core = lost_game.core.expect("no limit");
        let attack =
            attack(&select_guarantees(&specification, &core), &[], &limits).expect("no limit");
        let play = attack.expect("it is lost").play;
        let advice = advise(&specification, &core, &play, &limits).expect("no limit");
        for weakening in advice.weakenings.iter().filter(|w| w.unless.is_none()) {
            let name = &weakening.guarantee.formula(&specification.guarantees).name;
            assert!(
                lost(&only(&guarantees, |n| n != name)).is_none(),
                "{shown}: {name}"
            );
            left_out += 1;
        }
        let all_but = |n: &str| {
            let mut left = advice.leave_out.iter();
            left.all(|g| g.formula(&specification.guarantees).name != n)
        };
        if !advice.leave_out.is_empty() {
            assert!(lost(&only(&guarantees, all_but)).is_none(), "{shown}");
        }
    }
    println!("{found} unrealizable, {smaller} with a smaller core, {left_out} to be left out");
    assert!(found > 150 && smaller > 100 && left_out > 100);
}
