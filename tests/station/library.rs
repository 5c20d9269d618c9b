//! The controllers that are played: contracts of the bundled library and of the examples, and every
//! component of the laboratory's machines in its sizes there, including real size. Of the library
//! these are the case study's, or all with `LINEWRIGHT_CONTRACTS=all`.

use linewright::engine::controller::ExtractionOptions;
use linewright::engine::files::{self, StandardLibrary};
use linewright::engine::machines::of_line;
use linewright::engine::pipeline::{CheckedContract, Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits, Outcome, solve};
use linewright::gr1::Specification;
use linewright::mealy::Controller;
use linewright::mealy::functions::Functions;
use linewright::source::Span;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// Files whose contracts are large.
const LARGE_FILES: [&str; 2] = ["holistic.lw", "real.lw"];

/// Contracts of the library that are played in every run.
const CASE_STUDY: [&str; 11] = [
    "Compose",
    "Convey",
    "Decompose",
    "Inspect",
    "Mill",
    "Move",
    "Pick",
    "Place",
    "Print",
    "Single",
    "Turn",
];

/// Examples that are built from the library's machines only.
const OF_THE_LIBRARY: [&str; 4] = ["battery", "bottling", "machining", "sheet-metal"];

/// Contracts of the line at real size.
const LARGE_NAMES: [&str; 4] = ["Mill", "Inspect", "Move", "Turn"];

/// Its assumptions use every operator.
const WIDE: &str = "
contract Wide {
    input near: -300..300
    input far: -40000..40000
    input mode: {slow, fast, off}
    input other: {slow, fast, off}
    input go: bool
    output place: -70000..70000
    output few: 3..5
    output on: bool
    assume begins: near >= 0 and mode = off
    assume product: always (near * near <= 80000 or mode != off)
    assume smooth: always (abs(next near - near) <= 200 or go)
    assume least: always (min(next near, near) > -290 or max(near, 0) = 0 or place > 0)
    assume rest: always ((near + 300) mod 7 != 3 or next mode = mode or (near + 300) / 3 < 50)
    assume choice: always ((if go then near else 0 - near) < 250)
    assume same: always (mode = other and not next go -> next other != slow)
    assume flag: always ((go <-> on) or next near < 100 or next far > near)
    assume counted: always ((if go then 1 else 0) + (if on then 1 else 0) < 2 or next far != 5)
    assume quotient: always (next near / 7 != near / 7 - 2 and next near / (0 - 7) != 5)
    assume rests: always (next near mod 7 != 2 or near mod (0 - 9) != 0 - 4 or next near mod (few - 9) = near mod (few - 2))
    assume chosen: always (next go -> next mode = (if near < 0 then other else if go then fast else mode) or near / few < 9)
    assume before: always (next true -> not (on and place < 0 and near > 200))
    assume either: always ((if near > far then go else on) or (if next near > 0 then mode else fast) != (if go then other else off))
    guarantee places: always (place = (if far < -39990 then -70000 else if far > 39990 then 70000 else -1))
    guarantee small: always (few = (if near < 0 then 3 else if mode = fast then 4 else 5))
    guarantee lamp: always (next on <-> go)
}
";

/// A contract with its controller.
pub struct Controlled {
    pub specification: Arc<Specification>,
    pub controller: Controller,
}

/// The specifications of the contracts in a folder, and of the components of all its lines.
fn specifications(folder: &Path, found: &mut Vec<Arc<Specification>>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|e| e.expect("an entry").path())
        .collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.as_ref();
        // Some of the contracts to repair have no controller.
        if name == "repair-me" || OF_THE_LIBRARY.contains(&name) {
            continue;
        }
        if path.is_dir() {
            specifications(&path, found);
        } else if path.extension().is_some_and(|e| e == "lw") && !LARGE_FILES.contains(&name) {
            let file = path.display().to_string();
            let loaded = files::load(&[file], &StandardLibrary::default());
            let library = &loaded.library;
            // What is imported only to be refined is not solved here, either.
            let large = |file: &str| LARGE_FILES.iter().any(|large| file.ends_with(large));
            let contracts = library
                .contracts
                .iter()
                .filter(|c| !large(&library.sources.file(c.span.file).name))
                .map(|c| &c.specification);
            let lines = library.lines.iter();
            let machines = lines
                .flat_map(of_line)
                .map(|m| &**m)
                .chain(&library.machines);
            let components = machines.flat_map(|m| m.components.iter().map(|c| &c.specification));
            for specification in contracts.chain(components) {
                let specification = without_places(specification);
                if !found.contains(&specification) {
                    found.push(specification);
                }
            }
        }
    }
}

/// The specification without source places.
fn without_places(specification: &Specification) -> Arc<Specification> {
    let mut specification = specification.clone();
    for variable in &mut specification.variables {
        variable.span = Span::default();
    }
    for side in [
        &mut specification.assumptions,
        &mut specification.guarantees,
    ] {
        let lists = [
            &mut side.initial,
            &mut side.invariants,
            &mut side.safety,
            &mut side.justice,
        ];
        for formula in lists.into_iter().flatten() {
            formula.span = Span::default();
        }
    }
    Arc::new(specification)
}

/// Contracts of the library with their default parameters, the examples, and the components of the
/// laboratory's machines; each once. The cell in one contract is omitted: it takes half a minute to
/// solve.
fn machines_of_the_library() -> (Vec<Controlled>, usize) {
    let mut found = Vec::new();
    specifications(&crate::support::root().join("contracts"), &mut found);
    let are_all = std::env::var("LINEWRIGHT_CONTRACTS").is_ok_and(|which| which == "all");
    if !are_all {
        // Each by default, not as the components of machines.
        let mut known = BTreeSet::new();
        found.retain(|s| CASE_STUDY.contains(&s.name.as_str()) && known.insert(s.name.clone()));
    }
    let library = found.len();
    assert!(library >= CASE_STUDY.len(), "{library} contracts");
    specifications(&crate::support::root().join("examples"), &mut found);
    assert!(found.len() >= library + 3, "{} contracts", found.len());
    let made = controlled(found);
    assert!(made.iter().all(|c| c.controller.machine().is_some()));
    (made, library)
}

/// Made once for all tests, with the number of the bundled library's own.
fn made() -> &'static (Vec<Controlled>, usize) {
    static MADE: OnceLock<(Vec<Controlled>, usize)> = OnceLock::new();
    MADE.get_or_init(machines_of_the_library)
}

fn controlled(specifications: Vec<Arc<Specification>>) -> Vec<Controlled> {
    let mut jobs = Jobs::default().with_extraction(ExtractionOptions {
        functions: true,
        ..ExtractionOptions::default()
    });
    for specification in &specifications {
        jobs.add(specification, Span::default());
    }
    let settings = Settings {
        limits: Limits::default(),
        kernel: KernelChoice::Automatic,
        heuristics: Heuristics::default(),
        cache: None,
        announcer: None,
    };
    let hidden = indicatif::ProgressBar::hidden();
    let checked: Vec<CheckedContract> = jobs.run(&settings, &hidden);
    let pairs = specifications.into_iter().zip(checked);
    let controlled = pairs.map(|(specification, checked)| Controlled {
        controller: checked.controller.expect("a controller"),
        specification,
    });
    controlled.collect()
}

/// Controllers that are machines.
pub fn machines() -> &'static [Controlled] {
    &made().0
}

/// Controllers of the bundled library only.
pub fn bundled() -> &'static [Controlled] {
    let (all, library) = made();
    &all[..*library]
}

/// Components of the line at real size whose controllers are functions because machines would be
/// too large.
pub fn large() -> &'static [Controlled] {
    static LARGE: OnceLock<Vec<Controlled>> = OnceLock::new();
    LARGE.get_or_init(|| {
        let path = crate::support::root().join("examples/ice-lab/real.lw");
        let loaded = files::load(&[path.display().to_string()], &StandardLibrary::default());
        let machines = of_line(&loaded.library.lines[0]);
        let mut found: Vec<Arc<Specification>> = Vec::new();
        for component in machines.iter().flat_map(|m| &m.components) {
            let specification = &component.specification;
            if LARGE_NAMES.contains(&specification.name.as_str()) && !found.contains(specification)
            {
                found.push(Arc::clone(specification));
            }
        }
        assert_eq!(found.len(), LARGE_NAMES.len());
        let made = controlled(found);
        assert!(made.iter().all(|c| c.controller.functions().is_some()));
        made
    })
}

/// A controller as functions, although a machine would be possible.
pub fn as_functions(specification: &Specification) -> Controller {
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(specification, &limits) else {
        panic!("{} is realizable", specification.name);
    };
    Functions::extract(specification, &won, &limits)
        .expect("no limit")
        .into()
}

/// A contract with numbers of every width and sign, and arithmetic on them in its assumptions.
pub fn wide() -> Specification {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wide.lw");
    std::fs::write(&path, WIDE).expect("a file can be written");
    let loaded = files::load(&[path.display().to_string()], &StandardLibrary::default());
    assert_eq!(loaded.findings, []);
    (*loaded.library.contracts[0].specification).clone()
}
