//! Machines in files, with the controllers that the program would make for them.

use linewright::contract::machine::Machine;
use linewright::engine::controller::ExtractionOptions;
use linewright::engine::files::{self, StandardLibrary};
use linewright::engine::machines::MachinePlan;
use linewright::engine::pipeline::{Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits};
use linewright::mealy;
use std::path::Path;
use std::sync::Arc;

/// A machine in a file with the controllers that `build` would make.
pub fn controlled(
    file: &str,
    name: &str,
    wish: ExtractionOptions,
) -> (Arc<Machine>, Arc<Vec<mealy::Controller>>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let loaded = files::load(&[file.display().to_string()], &StandardLibrary::default());
    let machine = loaded.library.machines.iter().find(|m| m.name == name);
    let machine = Arc::new(machine.expect("a machine").clone());
    let mut jobs = Jobs::examining().with_extraction(wish);
    let planned = MachinePlan::new(&machine, &mut jobs);
    let settings = Settings {
        limits: Limits::default(),
        kernel: KernelChoice::Automatic,
        heuristics: Heuristics::default(),
        cache: None,
        announcer: None,
    };
    let checked = jobs.run(&settings, &indicatif::ProgressBar::hidden());
    let controlled = planned.controlled(&checked).expect("a controller each");
    let controllers = controlled.controllers.into_iter().cloned().collect();
    (Arc::clone(&machine), Arc::new(controllers))
}
