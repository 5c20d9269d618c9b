//! Station libraries: compile time, size, and the time of a step and of an operation, by level of optimisation. These are the
//! figures behind the choice of flags in `src/station/toolchain.rs`.
//!
//! Prints one line a machine and level; compile times are by the clock, on a second build.

#[path = "../station/explicit.rs"]
mod explicit;
#[expect(dead_code, reason = "the tests use more of it")]
#[path = "../station/fixtures.rs"]
mod fixtures;

use linewright::station::load::Library;
use linewright::station::{Controller as _, Package, Toolchain};

fn main() {
    for (machine, controllers) in [fixtures::manipulator(), fixtures::belt()] {
        let package = Package::emit(&machine, &controllers);
        for level in ["-O0", "-Og", "-O1", "-O2"] {
            let folder = tempfile::tempdir().expect("a folder for temporary files");
            let flags = [
                "-std=c99",
                level,
                "-fPIC",
                "-shared",
                "-fvisibility=hidden",
                "-ffp-contract=off",
            ];
            let toolchain = Toolchain::host().with_flags(&flags);
            toolchain.build(&package, folder.path(), true).unwrap();
            let begin = std::time::Instant::now();
            let built = toolchain.build(&package, folder.path(), true).unwrap();
            let compile = begin.elapsed();
            let size = std::fs::metadata(&built.path).unwrap().len();
            let mut instance = Library::open(&built.path).unwrap().instance().unwrap();
            let mut outputs = vec![0; machine.wire_count() - machine.plant.len()];
            let mut plant: Vec<i64> = machine.plant.iter().map(|_| 0).collect();
            let begin = std::time::Instant::now();
            let steps = 1_000_000_u32;
            for i in 0..steps {
                *plant.last_mut().unwrap() = i64::from(i % 2);
                instance.step(&plant, &mut outputs).unwrap();
            }
            let step = begin.elapsed() / steps;
            println!(
                "{} {level}: {compile:?} to build, {size} bytes, {step:?} a step",
                machine.name
            );
            if !machine.operations.is_empty() {
                let begin = std::time::Instant::now();
                let calls = 50_000_u32;
                let mut sum = 0;
                for _ in 0..calls {
                    instance.reset();
                    sum += instance.simulate(0, &mut [270.0, 1.0, 0.3]).unwrap().steps;
                }
                println!(
                    "    {:?} an operation of {} steps",
                    begin.elapsed() / calls,
                    sum / u64::from(calls)
                );
            }
        }
    }
}
