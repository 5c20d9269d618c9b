//! Explanations of unrealizable specifications: cores, counterstrategies, plays and repairs, on
//! random specifications and on the public benchmarks.

mod bench;
mod legal;
mod mended;
mod shared;

use crate::random::{Random, specification};
use crate::support;
use legal::legal;
use linewright::game::{Limits, Outcome, advise, attack, select_guarantees, solve};
use linewright::gr1::Timing;
use linewright::mealy::counter::to_machine;
use linewright::mealy::verify::verify_counterstrategy;

#[test]
fn repairs_of_random_specifications() {
    let limits = Limits::default();
    let (mut lost, mut assumptions, mut weakenings, mut hopeless, mut matter) = (0, 0, 0, 0, 0);
    for seed in 0..500 {
        let spec = specification(&mut Random::new(seed));
        let Outcome::Unrealizable(found) = solve(&spec, &limits) else {
            continue;
        };
        lost += 1;
        let core = found.core.expect("no limit");
        let small = select_guarantees(&spec, &core);
        let attack = attack(&small, &[], &limits).expect("no limit");
        let play = attack.expect("it is lost").play;
        let advice = advise(&spec, &core, &play, &limits).expect("no limit");
        let shown = mended::holds(&spec, &core, &advice);
        assert_eq!(shown, Ok(()), "seed {seed}: {advice:#?}\n{spec:#?}");
        assumptions += u32::from(!advice.assumptions.is_empty());
        weakenings += u32::from(!advice.weakenings.is_empty());
        hopeless += u32::from(advice.contradictory);
        matter += u32::from(!advice.matters.is_empty());
    }
    println!(
        "{lost} lost, {hopeless} hopeless, {assumptions} with assumptions, {weakenings} with weakenings, {matter} where assumptions matter"
    );
    assert!(lost > 200);
}

/// The lines suggested by `check` are contract text that works: each, put into the file, repairs
/// it.
#[test]
fn suggested_lines_can_be_put_into_the_file() {
    let mut tried = 0;
    for file in [
        "tests/cases/table1/coordinator_sensed.lw",
        "tests/cases/cli/unrealizable.lw",
    ]
    .into_iter()
    .map(str::to_owned)
    .chain(["1-clash", "2-hold"].map(|n| format!("examples/repair-me/{n}.lw")))
    {
        let path = support::root().join(&file);
        let text = std::fs::read_to_string(&path).expect("a text");
        let found = checked(&text);
        assert_eq!(found["contracts"][0]["verdict"], "unrealizable", "{file}");
        let suggestions = found["contracts"][0]["suggestions"].as_array();
        for suggestion in suggestions.into_iter().flatten() {
            let line = suggestion["text"].as_str().expect("a text");
            let mended = match suggestion["replaces"].as_str() {
                None if line.starts_with("assume") => {
                    let end = text.rfind('}').expect("an end");
                    format!("{}    {line}\n}}\n", &text[..end])
                }
                Some(name) if line.starts_with("guarantee") => {
                    let old = format!("guarantee {name}:");
                    let Some(old) = text.lines().find(|l| l.trim_start().starts_with(&old)) else {
                        continue;
                    };
                    text.replace(old, line)
                }
                _ => continue,
            };
            tried += 1;
            let again = checked(&mended);
            let verdict = &again["contracts"][0]["verdict"];
            assert_eq!(verdict, "realizable", "{file}: {line}\n{again:#}");
        }
    }
    assert!(tried >= 5, "only {tried}");
}

/// The output of `check` for a text.
fn checked(text: &str) -> serde_json::Value {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.lw"), text).expect("a file");
    let output = support::linewright(folder.path(), &["check", "a.lw", "--format", "json"]);
    serde_json::from_slice(&output.stdout).expect("a document")
}

#[test]
fn counterstrategies_of_random_specifications() {
    let limits = Limits::default();
    let (mut lost, mut moore, mut starved, mut states) = (0, 0, 0, 0);
    for seed in 0..3_000 {
        let spec = specification(&mut Random::new(seed));
        let found = match solve(&spec, &limits) {
            Outcome::Realizable(_) => {
                assert!(
                    attack(&spec, &[], &limits).expect("no limit").is_none(),
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
        for spec in [spec.clone(), select_guarantees(&spec, &core)] {
            let attack = attack(&spec, &[], &limits).expect("no limit");
            let attack = attack.unwrap_or_else(|| panic!("seed {seed}: nothing beats {spec:#?}"));
            let machine = to_machine(&spec, &attack);
            let verdict = verify_counterstrategy(&spec, &machine, &limits).expect("no limit");
            assert_eq!(verdict, Ok(()), "seed {seed}: {machine:#?}\n{spec:#?}");
            let shown = legal(&spec, &attack.play);
            assert_eq!(shown, Ok(()), "seed {seed}: {:#?}\n{spec:#?}", attack.play);
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
