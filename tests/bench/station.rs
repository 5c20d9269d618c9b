//! Station libraries: cost of a step and of an operation, and the effect of each form of a
//! controller and each optimization level. These are the figures behind
//! `crates/station/src/toolchain/mod.rs` and `src/cli/controller.rs`.
//!
//!     cargo bench --bench station                 all three tables
//!     cargo bench --bench station -- shipped      every machine of the laboratory, and at real size: steps, operations, what surrounds them
//!     cargo bench --bench station -- forms        tables and functions for growing machines
//!     cargo bench --bench station -- levels       optimization levels
//!
//! Steps are those of random walks that keep the assumptions, replayed through `lw_step`;
//! operations go through `simulate`, as in Plant Simulation. Every time is the best of nine, since
//! the computer has other load.

#[expect(dead_code, reason = "a walk needs its random numbers only")]
#[path = "../station/differential.rs"]
mod differential;
#[path = "../station/explicit.rs"]
mod explicit;
#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../station/fixtures.rs"]
mod fixtures;
#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../station/laboratory.rs"]
mod laboratory;
#[path = "../support/mod.rs"]
mod support;

use differential::Random;
use indicatif::ProgressBar;
use laboratory::Controlled;
use linewright::contract::machine::Machine;
use linewright::engine::controller::ExtractionOptions;
use linewright::engine::files::{self, StandardLibrary};
use linewright::engine::machines::{MachinePlan, of_line};
use linewright::engine::pipeline::{Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits, Outcome, solve};
use linewright::mealy::{self, extract::extract, functions::Functions};
use linewright::station::interpret::Interpreter;
use linewright::station::load::{Instance, Library};
use linewright::station::{Controller as _, Package, Toolchain};
use std::sync::Arc;
use std::time::{Duration, Instant};

const WALK: usize = 4_000;

fn main() {
    let named: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let wanted = |name: &str| named.is_empty() || named.iter().any(|n| n == name);
    if wanted("shipped") {
        shipped();
    }
    if wanted("forms") {
        forms();
    }
    if wanted("levels") {
        levels();
    }
}

/// Nanoseconds per item, for `count` items handled by `work`.
fn best(count: usize, mut work: impl FnMut()) -> f64 {
    let times = (0..9).map(|_| {
        let begin = Instant::now();
        work();
        begin.elapsed()
    });
    let least = times.min().unwrap_or(Duration::MAX);
    least.as_nanos() as f64 / count.max(1) as f64
}

/// A library, its size in bytes, and its build time.
struct Built {
    instance: Instance,
    bytes: u64,
    seconds: f64,
}

fn build(machine: &Machine, controllers: &[mealy::Controller], toolchain: &Toolchain) -> Built {
    // Unlinked on drop; the loaded library stays.
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let package = Package::emit(machine, controllers);
    let begin = Instant::now();
    let built = toolchain
        .build(&package, folder.path(), true)
        .expect("a library");
    let seconds = begin.elapsed().as_secs_f64();
    let library = Library::open(&built.path).expect("a library that loads");
    Built {
        instance: library.instance().expect("an instance"),
        bytes: std::fs::metadata(&built.path).expect("a file").len(),
        seconds,
    }
}

/// Plant wires of successive steps that keep all assumptions; an empty entry is a reset.
fn walk(controlled: &Controlled) -> Vec<Vec<i64>> {
    let machine = &controlled.machine;
    let mut interpreter =
        Interpreter::new(Arc::clone(machine), Arc::clone(&controlled.controllers));
    let mut outputs = vec![0; machine.wire_count() - machine.plant.len()];
    let mut random = Random(7);
    let mut steps = Vec::new();
    let mut plant: Vec<i64> = machine.plant.iter().map(|p| p.domain.low()).collect();
    let mut refused = 0;
    while steps.len() < WALK {
        // Usually only a wire or two change: what an operation needs tends to stay.
        let before = plant.clone();
        for (value, input) in plant.iter_mut().zip(&machine.plant) {
            if random.below(4) == 0 {
                *value = random.within(&input.domain);
            }
        }
        if interpreter.step(&plant, &mut outputs).is_ok() {
            steps.push(plant.clone());
            refused = 0;
        } else {
            plant = before;
            refused += 1;
        }
        if refused > 200 {
            interpreter.reset();
            steps.push(Vec::new());
            refused = 0;
        }
    }
    steps
}

/// Nanoseconds per step of a walk.
fn step_time(instance: &mut Instance, machine: &Machine, steps: &[Vec<i64>]) -> f64 {
    let mut outputs = vec![0; machine.wire_count() - machine.plant.len()];
    best(steps.len(), || {
        instance.reset();
        for plant in steps {
            if plant.is_empty() {
                instance.reset();
            } else {
                instance
                    .step(plant, &mut outputs)
                    .expect("a step of the walk");
            }
        }
    })
}

/// The machines of the line at real size, with the controllers that `build` chooses.
fn at_real_size() -> Vec<Controlled> {
    let file = support::root().join("examples/ice-lab/real.lw");
    let file = file.display().to_string();
    let loaded = files::load(&[file], &StandardLibrary::default());
    let [line] = loaded.library.lines.as_slice() else {
        panic!("{:?}", loaded.findings);
    };
    let mut jobs = Jobs::default().with_extraction(ExtractionOptions {
        functions: true,
        ..ExtractionOptions::default()
    });
    let machines = of_line(line);
    let planned: Vec<MachinePlan<'_>> = machines
        .iter()
        .map(|m| MachinePlan::new(m, &mut jobs))
        .collect();
    let settings = Settings {
        limits: Limits::default(),
        kernel: KernelChoice::default(),
        heuristics: Heuristics::default(),
        cache: None,
        announcer: None,
    };
    let checked = jobs.run(&settings, &ProgressBar::hidden());
    let controlled = planned.iter().zip(&machines).map(|(plan, machine)| {
        let found = plan.controlled(&checked).expect("a controller each");
        Controlled {
            machine: Arc::clone(machine),
            controllers: Arc::new(found.controllers.into_iter().cloned().collect()),
        }
    });
    controlled.collect()
}

/// All shipped machines of the laboratory, and those of its line at real size.
fn shipped() {
    println!(
        "| machine | controllers | library | a step | a controller's share | an operation | its steps | `simulate` | `reset` |"
    );
    println!("|---|---:|---:|---:|---:|---|---:|---:|---:|");
    let real = at_real_size();
    let at_real_size = |machine: &Machine| {
        real.iter()
            .any(|c| std::ptr::eq(&raw const *c.machine, machine))
    };
    for controlled in laboratory::machines().iter().chain(&real) {
        let machine = &controlled.machine;
        let mut built = build(machine, &controlled.controllers, &Toolchain::shipping());
        let steps = walk(controlled);
        let step = step_time(&mut built.instance, machine, &steps);
        let components = machine.components.len();
        let start = format!(
            "| {}{} | {components} | {} KiB | {step:.0} ns | {:.0} ns |",
            machine.name,
            if at_real_size(machine) {
                ", real size"
            } else {
                ""
            },
            built.bytes >> 10,
            step / components as f64
        );
        // The operation closest to ten steps.
        let values: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
        let mut found: Option<(usize, u64)> = None;
        for operation in 0..machine.operations.len() {
            built.instance.reset();
            let made = built.instance.simulate(operation, &mut values.clone());
            let Ok(service) = made else { continue };
            let nearer = |other: u64| service.steps.abs_diff(10) < other.abs_diff(10);
            if found.is_none_or(|(_, other)| nearer(other)) {
                found = Some((operation, service.steps));
            }
        }
        let Some((operation, count)) = found else {
            println!("{start} | | | |");
            continue;
        };
        let calls = 2_000;
        let reset = best(calls, || (0..calls).for_each(|_| built.instance.reset()));
        let whole = best(calls, || {
            for _ in 0..calls {
                built.instance.reset();
                assert!(built.instance.serve(operation, &values).is_ok());
            }
        });
        println!(
            "{start} {} | {count} | {:.0} ns | {reset:.0} ns |",
            machine.operations[operation].name,
            whole - reset
        );
    }
}

/// A file of the laboratory with a machine whose size is a parameter: its default, and its
/// replacements.
struct Series {
    machine: &'static str,
    file: &'static str,
    default: &'static str,
    sizes: &'static [&'static str],
}

const SERIES: [Series; 4] = [
    Series {
        machine: "AssemblyCell",
        file: "cell.lw",
        default: "cells: 2..360 = 8, grid: 2..64 = 3",
        sizes: &[
            "cells: 2..360 = 8, grid: 2..64 = 3",
            "cells: 2..360 = 45, grid: 2..64 = 6",
            "cells: 2..360 = 90, grid: 2..64 = 8",
        ],
    },
    Series {
        machine: "Printer",
        file: "printer.lw",
        default: "columns: 1..8 = 2, height: 1..8 = 2",
        sizes: &[
            "columns: 1..8 = 2, height: 1..8 = 2",
            "columns: 1..8 = 3, height: 1..8 = 2",
            "columns: 1..8 = 3, height: 1..8 = 3",
            "columns: 1..8 = 8, height: 1..8 = 8",
        ],
    },
    Series {
        machine: "Milling",
        file: "milling.lw",
        default: "columns: 1..8 = 2, height: 1..8 = 2",
        sizes: &[
            "columns: 1..8 = 2, height: 1..8 = 2",
            "columns: 1..8 = 3, height: 1..8 = 3",
            "columns: 1..8 = 8, height: 1..8 = 8",
        ],
    },
    Series {
        machine: "QualityCheck",
        file: "camera.lw",
        default: "columns: 1..8 = 2, height: 1..8 = 2",
        sizes: &[
            "columns: 1..8 = 2, height: 1..8 = 2",
            "columns: 1..8 = 3, height: 1..8 = 2",
            "columns: 1..8 = 8, height: 1..8 = 8",
        ],
    },
];

/// Compares tables and functions.
fn forms() {
    println!(
        "| machine | tables | library | built in | a step | functions | library | built in | a step |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    for series in &SERIES {
        for size in series.sizes {
            let machine = sized(series, size);
            print!("| {} {} |", machine.name, size);
            for form in [tables, functions] {
                let Some((controllers, amount)) = form(&machine) else {
                    print!(" too large | | | |");
                    continue;
                };
                let controlled = Controlled {
                    machine: Arc::clone(&machine),
                    controllers: Arc::new(controllers),
                };
                let toolchain = Toolchain::shipping();
                let mut built = build(&machine, &controlled.controllers, &toolchain);
                let steps = walk(&controlled);
                let step = step_time(&mut built.instance, &machine, &steps);
                print!(
                    " {amount} | {} KiB | {:.2} s | {step:.0} ns |",
                    built.bytes >> 10,
                    built.seconds
                );
            }
            println!();
        }
    }
}

/// The machine of a series at a size.
fn sized(series: &Series, size: &str) -> Arc<Machine> {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let from = support::root().join("examples/ice-lab");
    for file in [series.file, "coordinator.lw", "jobs.lw"] {
        let text = std::fs::read_to_string(from.join(file)).expect("a file of the laboratory");
        assert!(
            file != series.file || text.contains(series.default),
            "{file}"
        );
        std::fs::write(folder.path().join(file), text.replace(series.default, size)).unwrap();
    }
    let path = folder.path().join(series.file).display().to_string();
    let loaded = files::load(&[path], &StandardLibrary::default());
    let mut machines = loaded.library.machines.into_iter();
    let machine = machines.find(|m| m.name == series.machine);
    Arc::new(machine.unwrap_or_else(|| panic!("{:?}", loaded.findings)))
}

/// Explicit machines, and the number of bytes of their splits and leaves; `None` if they grow too
/// large.
fn tables(machine: &Machine) -> Option<(Vec<mealy::Controller>, String)> {
    let limits = Limits {
        max_nodes: Some(1_000_000),
        ..Limits::default()
    };
    let mut bytes = 0;
    let mut controllers = Vec::new();
    for component in &machine.components {
        let Outcome::Realizable(won) = solve(&component.specification, &limits) else {
            return None;
        };
        let machine = extract(&component.specification, &won, &limits).ok()?;
        bytes += linewright::station::emit::table_bytes(&machine);
        controllers.push(machine.into());
    }
    Some((controllers, format!("{} KiB", bytes.div_ceil(1024))))
}

/// Functions, and the number of their decisions.
fn functions(machine: &Machine) -> Option<(Vec<mealy::Controller>, String)> {
    let limits = Limits::default();
    let mut decisions = 0;
    let mut controllers = Vec::new();
    for component in &machine.components {
        let Outcome::Realizable(won) = solve(&component.specification, &limits) else {
            return None;
        };
        let functions = Functions::extract(&component.specification, &won, &limits).ok()?;
        decisions += functions.controls.diagram.nodes.len();
        controllers.push(functions.into());
    }
    Some((controllers, format!("{decisions} decisions")))
}

/// Compares optimization levels.
fn levels() {
    println!("| machine | level | built in | library | a step |");
    println!("|---|---|---:|---:|---:|");
    let cell = laboratory::machines()
        .iter()
        .find(|m| m.machine.name == "AssemblyCell");
    let (manipulator, controllers) = fixtures::manipulator();
    let manipulator = Controlled {
        machine: manipulator,
        controllers,
    };
    for controlled in [cell.expect("the line has an assembly cell"), &manipulator] {
        let machine = &controlled.machine;
        let steps = walk(controlled);
        for level in ["-O0", "-Og", "-O1", "-O2", "-O3"] {
            let flags = [
                "-std=c99",
                level,
                "-fPIC",
                "-shared",
                "-fvisibility=hidden",
                "-ffp-contract=off",
            ];
            let toolchain = Toolchain::shipping().with_flags(&flags);
            let mut built = build(machine, &controlled.controllers, &toolchain);
            let step = step_time(&mut built.instance, machine, &steps);
            println!(
                "| {} | {level} | {:.2} s | {} KiB | {step:.0} ns |",
                machine.name,
                built.seconds,
                built.bytes >> 10
            );
        }
    }
}
