//! The unrealizable ones of the public benchmarks.

use crate::{legal::legal, support};
use linewright::game::{Limits, Outcome, attack, reduced, solve_with};
use linewright::interchange::{Format, read};
use linewright::mealy::counter::machine;
use linewright::mealy::verify::verify_counterstrategy;
use linewright::source::FileId;
use std::path::PathBuf;
use std::time::Instant;

fn files() -> Option<Vec<PathBuf>> {
    let folder = std::env::var_os("LINEWRIGHT_SPECS").map_or_else(
        || support::root().join("../shared/bench/specs"),
        PathBuf::from,
    );
    if !folder.is_dir() {
        support::skip(
            "specs",
            "the benchmark specifications are not beside the repository",
        );
        return None;
    }
    let mut files = Vec::new();
    for sub in ["slugs", "gr1c", "syntech15-unrealizable"] {
        for entry in std::fs::read_dir(folder.join(sub)).expect("a folder") {
            files.push(entry.expect("an entry").path());
        }
    }
    files.sort();
    Some(files)
}

#[test]
fn benchmarks() {
    let Some(files) = files() else { return };
    let limits = Limits::default();
    let mut count = 0;
    for file in files {
        let Some(format) = Format::of_path(&file.to_string_lossy()) else {
            continue;
        };
        let text = std::fs::read_to_string(&file).expect("a text");
        let reading = read(format, "test", FileId(0), &text);
        let Some(spec) = reading.specification else {
            continue;
        };
        let name = file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let options = linewright::game::Options {
            without_core: true,
            ..Default::default()
        };
        let clock = Instant::now();
        if !matches!(
            solve_with(&spec, &options).outcome,
            Outcome::Unrealizable(_)
        ) {
            continue;
        }
        let check = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let Outcome::Unrealizable(lost) = linewright::game::solve(&spec, &limits) else {
            panic!()
        };
        let core_time = clock.elapsed().as_secs_f64();
        let core = lost.core.expect("no limit");
        let small = reduced(&spec, &core);
        let clock = Instant::now();
        let found = attack(&small, &limits)
            .expect("no limit")
            .expect("a counterstrategy");
        let attack_time = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let advice =
            linewright::game::advise(&spec, &core, &found.play, &limits).expect("no limit");
        let advice_time = clock.elapsed().as_secs_f64();
        println!(
            "   {advice_time:.3} matters {} contradictory {} assumptions {} weakenings {} {:?}",
            advice.matters.len(),
            advice.contradictory,
            advice.assumptions.len(),
            advice.weakenings.len(),
            crate::mended::holds(&spec, &core, &advice)
        );
        let machine = machine(&small, &found);
        let clock = Instant::now();
        let verdict = verify_counterstrategy(&small, &machine, &limits);
        let verify_time = clock.elapsed().as_secs_f64();
        println!(
            "{name}: vars {} guarantees {} core {} check {check:.3} core {core_time:.3} ({:.1}) attack {attack_time:.3} states {} transitions {} play {} {:?} verify {verify_time:.3} {:?} {:?}",
            spec.variables.len(),
            spec.guarantees.all().count(),
            core.len(),
            core_time / check,
            machine.states.len(),
            machine.transition_count(),
            found.play.steps.len(),
            found.play.ending,
            verdict.map(|v| v.map_err(|v| v.rule)),
            legal(&small, &found.play)
        );
        count += 1;
    }
    println!("{count}");
}
