//! The unrealizable public benchmarks.

use super::{legal::legal, mended};
use crate::support;
use linewright::game::{
    Ending, Limits, Options, Outcome, advise, attack, select_guarantees, solve, solve_with,
};
use linewright::gr1::Specification;
use linewright::interchange::{Format, read};
use linewright::mealy::counter::to_machine;
use linewright::mealy::verify::verify_counterstrategy;
use linewright::source::FileId;
use std::path::PathBuf;
use std::time::Instant;

/// The files, if they are in a folder beside the repository.
fn files() -> Option<Vec<PathBuf>> {
    let folder = support::specs()?;
    let mut files = Vec::new();
    for sub in [
        "anzu",
        "gr1c",
        "slugs",
        "synt15",
        "syntech15",
        "syntech15-unrealizable",
    ] {
        for entry in std::fs::read_dir(folder.join(sub)).expect("a folder") {
            files.push(entry.expect("an entry").path());
        }
    }
    files.sort();
    Some(files)
}

/// Runs something; returns its seconds.
fn timed<T>(what: impl FnOnce() -> T) -> (f64, T) {
    let clock = Instant::now();
    let result = what();
    (clock.elapsed().as_secs_f64(), result)
}

/// Large ones are all realizable (`tests/interchange/formats.rs` decides them); deciding each again
/// would take minutes.
const MOST_VARIABLES: usize = 60;

fn specification(file: &PathBuf) -> Option<Specification> {
    let format = Format::from_path(&file.to_string_lossy())?;
    let text = std::fs::read_to_string(file).expect("a text");
    let spec = read(format, "test", FileId(0), &text).specification?;
    (spec.variables.len() <= MOST_VARIABLES).then_some(spec)
}

/// Some benchmarks come in three formats; one of them is enough for the ordinary test.
#[test]
fn every_unrealizable_benchmark_is_explained() {
    let Some(mut files) = files() else { return };
    files.retain(|file| {
        let other = file.with_extension("spectra");
        *file == other || !other.exists()
    });
    assert!(explain(files) >= 10);
}

#[test]
#[ignore = "takes minutes: cargo test --test solver explained:: -- --ignored"]
fn every_unrealizable_benchmark_is_explained_in_each_format() {
    let Some(files) = files() else { return };
    assert!(explain(files) >= 18);
}

/// Cores, counterstrategies, plays and repairs of the unrealizable ones of these files; prints the
/// table of `tests/README.md`. Returns the number of files that are explained.
fn explain(files: Vec<PathBuf>) -> usize {
    let limits = Limits::default();
    let mut ratios = Vec::new();
    let mut suggested = 0;
    println!(
        "| file | guarantees | core | matter | states | play | assume | weaken | check s | core s | counterstrategy s | repairs s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for file in files {
        let Some(spec) = specification(&file) else {
            continue;
        };
        let options = Options {
            without_core: true,
            ..Options::default()
        };
        let (check, solved) = timed(|| solve_with(&spec, &options).outcome);
        if matches!(solved, Outcome::Realizable(_)) {
            continue;
        }
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let (with_core, lost) = timed(|| solve(&spec, &limits));
        let Outcome::Unrealizable(lost) = lost else {
            panic!("{name}: two verdicts");
        };
        let core = lost.core.expect("no limit");
        let small = select_guarantees(&spec, &core);
        let (attacked, found) = timed(|| attack(&small, &[], &limits).expect("no limit"));
        let found = found.expect("a counterstrategy");
        let counterstrategy = to_machine(&small, &found);
        let verdict = verify_counterstrategy(&small, &counterstrategy, &limits).expect("no limit");
        assert_eq!(verdict, Ok(()), "{name}");
        assert_eq!(legal(&small, &found.play), Ok(()), "{name}");
        let (advised, advice) = timed(|| advise(&spec, &core, &found.play, &limits));
        let advice = advice.expect("no limit");
        assert_eq!(
            mended::holds(&spec, &core, &advice),
            Ok(()),
            "{name}: {advice:#?}"
        );
        suggested += usize::from(!advice.assumptions.is_empty());
        ratios.push((with_core - check).max(0.0) / check);
        let end = match found.play.ending {
            Ending::Clash(_) => "clash",
            Ending::Starved { .. } => "round",
        };
        println!(
            "| {name} | {} | {} | {} | {} | {} {end} | {} | {} | {check:.3} | {:.3} | {attacked:.3} | {advised:.2} |",
            spec.guarantees.all().count(),
            core.len(),
            advice.matters.len(),
            counterstrategy.states.len(),
            found.play.steps.len(),
            advice.assumptions.len(),
            advice.weakenings.len(),
            (with_core - check).max(0.0),
        );
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "{} files; a core costs {:.1} checks in the median, {:.1} at most; {suggested} with assumptions that help",
        ratios.len(),
        ratios[ratios.len() / 2],
        ratios[ratios.len() - 1]
    );
    ratios.len()
}
