//! The line at real size: every controller verified, both forms of controllers, libraries equal to
//! the interpreter, no violation.

use crate::differential::differential;
use crate::support::{linewright_with_cache, root};
use linewright::engine::cache::Cache;
use linewright::engine::controlled::compose;
use linewright::engine::controller::ExtractionOptions;
use linewright::engine::files::{self, StandardLibrary};
use linewright::engine::machines::{MachinePlan, of_line};
use linewright::engine::pipeline::{Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits};
use linewright::station::ErrorCode;
use linewright::station::composition::Discharger;
use serde_json::Value;
use std::sync::Arc;

const LINE: &str = "examples/ice-lab/real.lw";

/// Contracts whose controllers are tables at this size; all others are functions.
const TABLES: [&str; 7] = [
    "CellCoordinator",
    "Compose",
    "Convey",
    "Decompose",
    "Pick",
    "Place",
    "Single",
];

#[test]
fn the_line_at_real_size_runs() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let path = root().join(LINE).display().to_string();
    let loaded = files::load(&[path], &StandardLibrary::default());
    assert_eq!(loaded.findings, []);
    let machines = of_line(&loaded.library.lines[0]);
    let mut jobs = Jobs::default().with_extraction(ExtractionOptions {
        functions: true,
        ..ExtractionOptions::default()
    });
    let planned: Vec<MachinePlan<'_>> = machines
        .iter()
        .map(|m| MachinePlan::new(m, &mut jobs))
        .collect();
    let settings = Settings {
        // The command line's default, so that its run below finds the cached results.
        limits: Limits {
            memory_mib: Some(4096),
            ..Limits::default()
        },
        kernel: KernelChoice::Automatic,
        heuristics: Heuristics::default(),
        cache: Some(Cache::in_folder(&cache)),
        announcer: None,
    };
    // Everything from the pipeline was verified, or certified.
    let checked = jobs.run(&settings, &indicatif::ProgressBar::hidden());
    let mut tables: Vec<&str> = Vec::new();
    for (machine, plan) in machines.iter().zip(&planned) {
        let controlled = plan.controlled(&checked).expect("a controller each");
        let composition = compose(&controlled);
        assert_eq!(composition.findings, [], "{}", machine.name);
        let by_others =
            |by: &Discharger| matches!(by, Discharger::Guarantee(_) | Discharger::Coordinator);
        assert_eq!(
            machine.coordinator().is_some(),
            composition.discharges.iter().any(|d| by_others(&d.by)),
            "{}",
            machine.name
        );
        for controller in &controlled.controllers {
            if controller.machine().is_some() && !tables.contains(&controller.name()) {
                tables.push(controller.name());
            }
        }
        let controllers = controlled.controllers.iter().map(|c| (*c).clone());
        let controllers = Arc::new(controllers.collect());
        let counts = differential(machine, &controllers, 500, 3, folder.path());
        let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
        assert_eq!(faults, 0, "{}: {counts:?}", machine.name);
        assert!(counts.ok > 50, "{}: {counts:?}", machine.name);
    }
    tables.sort_unstable();
    assert_eq!(tables, TABLES);

    let libraries = folder.path().display().to_string();
    let arguments = ["run", LINE, "--parts", "3", "--out", &libraries];
    let form = ["--format", "json", "--no-timing"];
    let output = linewright_with_cache(&cache, root(), &[&arguments[..], &form].concat());
    let text = String::from_utf8_lossy(&output.stdout);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert_eq!(document["products"], 3);
    assert_eq!(document["violations"], Value::Array(Vec::new()));
}
