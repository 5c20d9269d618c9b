//! Controllers as functions, with everything that the laboratory's machines have none of: domains that do not begin at 0, constants,
//! copies of many inputs, several goals, and outputs before the inputs are known.

use crate::differential::differential;
use linewright::cli::controller::Wish;
use linewright::cli::files::{self, StandardLibrary};
use linewright::cli::machines::Planned;
use linewright::cli::pipeline::{Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits};
use linewright::station::ErrorCode;
use std::path::Path;
use std::sync::Arc;

const STEPS: usize = 60_000;

#[test]
fn odd_functions_agree_with_the_interpreter() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/station/odd.lw");
    let loaded = files::load(&[file.display().to_string()], &StandardLibrary::default());
    let machine = loaded.library.machines.iter().find(|m| m.name == "Oddity");
    let machine = Arc::new(machine.expect("a machine").clone());
    // As `check` and `build` do it; tables of these would have no end.
    let mut jobs = Jobs::examining().wishing(Wish {
        functions: true,
        ..Wish::default()
    });
    let planned = Planned::new(&machine, &mut jobs);
    let settings = Settings {
        limits: Limits::default(),
        kernel: KernelChoice::Automatic,
        heuristics: Heuristics::default(),
        cache: None,
    };
    let checked = jobs
        .run(&settings, &indicatif::ProgressBar::hidden())
        .expect("controllers that keep their contracts");
    let controlled = planned.controlled(&checked).expect("a controller each");
    let forms: Vec<bool> = controlled
        .controllers
        .iter()
        .map(|c| c.functions().is_some())
        .collect();
    assert_eq!(forms, [false, true, true]);
    let controllers = Arc::new(controlled.controllers.into_iter().cloned().collect());
    let folder = tempfile::tempdir().expect("a folder");
    let counts = differential(&machine, &controllers, STEPS, 11, folder.path());
    let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
    assert_eq!(faults, 0, "{counts:?}");
    assert!(counts.ok > STEPS / 3, "{counts:?}");
    for rule in ["odd: mended", "odd: gentle"] {
        assert!(
            counts.rules.get(rule).is_some_and(|n| *n > 100),
            "{counts:?}"
        );
    }
}
