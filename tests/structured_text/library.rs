//! The controllers that are played: every contract of the bundled library and of the examples, and every component of the
//! laboratory's machines with the sizes it has there, at real size too.

use linewright::cli::controller::Wish;
use linewright::cli::files::{self, StandardLibrary};
use linewright::cli::machines::of_line;
use linewright::cli::pipeline::{CheckedContract, Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits, Outcome, solve};
use linewright::gr1::Specification;
use linewright::mealy::Controller;
use linewright::mealy::functions::Functions;
use linewright::source::Span;
use std::path::Path;
use std::sync::{Arc, OnceLock};

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
        if path.is_dir() {
            specifications(&path, found);
        } else if path.extension().is_some_and(|e| e == "lw") {
            let file = path.display().to_string();
            let loaded = files::load(&[file], &StandardLibrary::default());
            let library = &loaded.library;
            let contracts = library.contracts.iter().map(|c| &c.specification);
            let lines = library.lines.iter();
            let machines = lines.flat_map(of_line).map(|m| &**m).chain(&library.machines);
            let components = machines.flat_map(|m| m.components.iter().map(|c| &c.specification));
            for specification in contracts.chain(components) {
                if !found.contains(specification) {
                    found.push(Arc::clone(specification));
                }
            }
        }
    }
}

/// The library with its default parameters, and what the laboratory's machines make of it; each once. The second list is the
/// laboratory at real size and its cell in one contract, where controllers are large.
fn all() -> &'static (Vec<Controlled>, Vec<Controlled>) {
    static ALL: OnceLock<(Vec<Controlled>, Vec<Controlled>)> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut found = Vec::new();
        specifications(&crate::support::root().join("contracts"), &mut found);
        let library = found.len();
        assert!(library >= 11, "{library} contracts");
        specifications(&crate::support::root().join("examples"), &mut found);
        assert!(found.len() >= library + 10, "{} contracts", found.len());
        let mut jobs = Jobs::default().wishing(Wish {
            functions: true,
            ..Wish::default()
        });
        for specification in &found {
            jobs.add(specification, Span::default());
        }
        let settings = Settings {
            limits: Limits::default(),
            kernel: KernelChoice::Automatic,
            heuristics: Heuristics::default(),
            cache: None,
        };
        let hidden = indicatif::ProgressBar::hidden();
        let checked: Vec<CheckedContract> = jobs.run(&settings, &hidden).expect("sound controllers");
        let pairs = found.into_iter().zip(checked);
        let controlled = pairs.map(|(specification, checked)| Controlled {
            controller: checked.controller.expect("a controller"),
            specification,
        });
        controlled.partition(|c| c.controller.machine().is_some())
    })
}

/// Those whose controllers are machines.
pub fn machines() -> &'static [Controlled] {
    &all().0
}

/// Those whose controllers are functions because machines would be too large.
pub fn functions() -> &'static [Controlled] {
    &all().1
}

/// A controller as functions, although a machine would do.
pub fn as_functions(specification: &Specification) -> Controller {
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(specification, &limits) else {
        panic!("{} is realizable", specification.name);
    };
    Functions::extract(specification, &won, &limits)
        .expect("no limit")
        .into()
}
