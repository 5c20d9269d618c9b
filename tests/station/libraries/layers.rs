//! Machines of machines: the library of the flat machine compared with the interpreter, step by
//! step and operation by operation.

use super::folder;
use crate::controlled::controlled;
use crate::differential::{assert_same, differential};
use linewright::engine::controller::ExtractionOptions;
use linewright::station::interpret::Interpreter;
use linewright::station::load::Library;
use linewright::station::{Controller, ErrorCode, Package, Toolchain};
use std::sync::Arc;

const STEPS: usize = 20_000;

#[test]
fn libraries_of_three_and_four_layers_agree_with_the_interpreter_step_by_step() {
    let folder = folder();
    for (file, name) in [
        ("examples/transfer/cell.lw", "TransferCell"),
        ("tests/algebra/layers/hall.lw", "Hall"),
        ("tests/algebra/layers/names.lw", "Both"),
    ] {
        let (machine, controllers) = controlled(file, name, ExtractionOptions::default());
        let counts = differential(&machine, &controllers, STEPS, 5, folder.path());
        println!("{name}: {counts:?}");
        let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
        assert_eq!(faults, 0, "{name}: {counts:?}");
        assert!(counts.ok > STEPS / 3, "{name}: {counts:?}");
    }
}

/// The operation of three layers, and the same of four: additional steps for the hall's requests
/// and reports, the same angle in the part, the same times and powers of the actions.
#[test]
fn operations_of_all_layers_run_to_their_end() {
    let folder = folder();
    let mut took = Vec::new();
    for (file, name) in [
        ("examples/transfer/cell.lw", "TransferCell"),
        ("tests/algebra/layers/hall.lw", "Hall"),
    ] {
        let (machine, controllers) = controlled(file, name, ExtractionOptions::default());
        let package = Package::emit(&machine, &controllers);
        let built = Toolchain::host()
            .build(&package, folder.path(), false)
            .unwrap();
        let mut instance = Library::open(&built.path).unwrap().instance().unwrap();
        let mut interpreter = Interpreter::new(Arc::clone(&machine), Arc::clone(&controllers));
        for target in [90.0, 180.0, 0.0, 45.0, 315.0, 50.0] {
            let (mut ours, mut theirs) = ([10.0, target], [10.0, target]);
            let expected = interpreter.simulate(0, &mut ours);
            let answer = instance.simulate(0, &mut theirs);
            assert_same(&expected, &answer, &format!("{name} to {target}"));
            if let (Ok(a), Ok(b)) = (&expected, &answer) {
                println!("{name} to {target}: {a:?}");
                assert_eq!(
                    (a.steps, a.seconds, a.joules),
                    (b.steps, b.seconds, b.joules)
                );
                assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits));
                assert!((ours[0] - (target / 45.0_f64).round() * 45.0).abs() < 1e-9);
                // Two picks and two places of 4 steps each, and the table; in addition 20, 40 and
                // 30 W.
                let turning = 0.5 + 0.01 * (target - 10.0).abs();
                let joules = 120.0 * 8.0 * (0.8 + 0.6) + 90.0 * turning + 90.0 * a.seconds;
                assert!((a.joules - joules).abs() < 1e-6, "{a:?}, not {joules} J");
                took.push((a.steps, a.seconds));
            } else {
                panic!("{name} to {target}: {expected:?}");
            }
        }
    }
    let (cell, hall) = took.split_at(took.len() / 2);
    for ((steps, seconds), (more, longer)) in cell.iter().zip(hall) {
        assert_eq!(steps + 2, *more);
        assert!((seconds + 2.0 * 0.2 - longer).abs() < 1e-9);
    }
}
