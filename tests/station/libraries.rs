//! Station libraries: the emitted C, the toolchain and the loader, compared with the interpreter.

mod building;
mod calls;
mod expressions;
mod functions;
mod layers;

use crate::differential::{Random, assert_same, differential};
use crate::{counting, fixtures, laboratory};
use linewright::mealy;
use linewright::station::interpret::Interpreter;
use linewright::station::load::Library;
use linewright::station::{Controller, ErrorCode, Package, Toolchain};
use std::sync::Arc;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for temporary files")
}

#[test]
fn library_and_interpreter_agree_step_by_step() {
    let folder = folder();
    for (machine, controllers) in [fixtures::manipulator(), fixtures::belt()] {
        let steps = 100_000;
        let counts = differential(&machine, &controllers, steps, 7, folder.path());
        println!("{}: {counts:?}", machine.name);
        assert!(counts.of(ErrorCode::Assumption) >= steps / 10, "{counts:?}");
        assert!(
            counts.of(ErrorCode::Domain) > 0 && counts.ok > steps / 3,
            "{counts:?}"
        );
        assert_eq!(
            counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee),
            0
        );
    }
}

#[test]
fn machines_of_the_bundled_library_agree_step_by_step() {
    let folder = folder();
    for controlled in laboratory::of_library() {
        let (machine, controllers) = (&controlled.machine, &controlled.controllers);
        let steps = 100_000;
        let counts = differential(machine, controllers, steps, 23, folder.path());
        println!("{}: {counts:?}", machine.name);
        let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
        assert_eq!(faults, 0, "{}: {counts:?}", machine.name);
        assert!(counts.ok > steps / 4, "{}: {counts:?}", machine.name);
        let is_refused = counts.of(ErrorCode::Domain) > 0;
        assert!(is_refused, "{}: {counts:?}", machine.name);
    }
}

#[test]
fn library_and_interpreter_agree_on_operations() {
    let folder = folder();
    for (machine, controllers) in [fixtures::manipulator(), fixtures::jammed()] {
        let package = Package::emit(&machine, &controllers);
        let built = Toolchain::host()
            .build(&package, folder.path(), false)
            .unwrap();
        let mut instance = Library::open(&built.path).unwrap().instance().unwrap();
        let mut interpreter = Interpreter::new(Arc::clone(&machine), Arc::clone(&controllers));
        let mut random = Random(11);
        let mut seen = std::collections::BTreeMap::new();
        let mut values = [0.0, 1.0, 0.3];
        for call in 0..20_000 {
            if random.below(3) != 0 {
                let angle = [
                    0.0,
                    90.0,
                    180.0,
                    270.0,
                    90.0 + 4e-8,
                    90.0 + 2e-7,
                    45.0,
                    360.0,
                    -90.0,
                    f64::NAN,
                ];
                let grip = [1.0, 1.0, 1.0, 0.0, 0.5, 2.0];
                values[0] = angle[random.below(10) as usize];
                values[1] = grip[random.below(6) as usize];
                values[2] = [0.3, 1.7, -5.0, 1e300, f64::INFINITY][random.below(5) as usize];
            }
            let operation = random.below(5) as usize / 2;
            let (mut ours, mut theirs) = (values, values);
            let expected = interpreter.simulate(operation, &mut ours);
            let answer = instance.simulate(operation, &mut theirs);
            let place = format!("{} call {call} {operation} {values:?}", machine.name);
            assert_same(&expected, &answer, &place);
            assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits), "{place}");
            let key = expected
                .as_ref()
                .map_or_else(|e| e.message.clone(), |_| "ok".to_owned());
            *seen.entry(key).or_insert(0) += 1;
            if let (Ok(a), Ok(b)) = (&expected, &answer) {
                assert_eq!(a.seconds.to_bits(), b.seconds.to_bits(), "{place}");
                assert_eq!(a.joules.to_bits(), b.joules.to_bits(), "{place}");
                assert_eq!(a.steps, b.steps, "{place}");
                let control = [a, b].map(|s| s.control_seconds.to_bits());
                assert_eq!(control[0], control[1], "{place}");
                values = ours;
            }
        }
        println!("{}: {seen:#?}", machine.name);
        assert!(seen["ok"] > 500);
        if machine.name == "Jammed" {
            let limit = seen.keys().filter(|m| m.contains("did not end")).count();
            assert!(limit > 0);
        }
    }
}

/// The machines of a fixture's controllers.
fn machines(controllers: &[mealy::Controller]) -> Vec<mealy::Machine> {
    let machines = controllers.iter().map(|c| c.machine().cloned());
    machines.collect::<Option<_>>().expect("machines")
}

#[test]
fn faults_of_a_controller_are_caught_alike() {
    let folder = folder();
    let (machine, controllers) = fixtures::manipulator();
    // Every third output of the turner is wrong, and every second state of the picker has no
    // transition.
    let mut faulty = machines(&controllers);
    for (i, t) in faulty[1].states.iter_mut().flatten().enumerate() {
        if i % 3 == 0 {
            t.output[0] = (t.output[0] + 1) % 4;
        }
    }
    let picker = faulty[2].states.iter_mut().skip(1).step_by(2);
    picker.for_each(Vec::clear);
    let faulty = Arc::new(faulty.into_iter().map(Into::into).collect());
    let counts = differential(&machine, &faulty, 30_000, 3, folder.path());
    println!("{counts:?}");
    assert!(counts.of(ErrorCode::Guarantee) > 100);
    assert!(counts.of(ErrorCode::Internal) > 100);
    // A Moore machine that has no answer at all.
    let mut stuck = machines(&controllers);
    stuck[0].states.iter_mut().for_each(Vec::clear);
    let stuck = Arc::new(stuck.into_iter().map(Into::into).collect());
    let counts = differential(&machine, &stuck, 2_000, 3, folder.path());
    assert!(counts.of(ErrorCode::Assumption) > 100);
    assert!(counts.of(ErrorCode::Internal) == 0);
}

/// An integer property ends as an integer in its range, or the operation is refused; a previous
/// value may remain.
#[test]
fn whole_numbers_stay_whole_and_in_range() {
    let folder = folder();
    let (machine, controllers) = counting::counting();
    let package = Package::emit(&machine, &controllers);
    let built = Toolchain::host()
        .build(&package, folder.path(), false)
        .unwrap();
    let mut instance = Library::open(&built.path).unwrap().instance().unwrap();
    let mut interpreter = Interpreter::new(Arc::clone(&machine), Arc::clone(&controllers));
    // The wish, the previous count, and whether that is allowed.
    let cases = [
        (2.0, 0.0, true),
        (-3.0, 0.0, true),
        (6.0, 0.0, true),
        (-4.0, 0.0, false),
        (7.0, 0.0, false),
        (2.5, 0.0, false),
        (-2.5, 0.0, false),
        (5.999_999_999, 0.0, false),
        (0.5, 0.5, true),
        (9.0, 9.0, true),
        (9.0, 8.0, false),
    ];
    for (wish, before, allowed) in cases {
        let values = [0.0, 1.0, 0.3, wish, before];
        let (mut ours, mut theirs) = (values, values);
        let expected = interpreter.simulate(0, &mut ours);
        let answer = instance.simulate(0, &mut theirs);
        let place = format!("{before} becomes {wish}");
        assert_same(&expected, &answer, &place);
        assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits), "{place}");
        match answer {
            Ok(_) => assert!(allowed && theirs[4].to_bits() == wish.to_bits(), "{place}"),
            Err(error) => {
                assert!(!allowed, "{place}: {error}");
                assert_eq!(error.code, ErrorCode::Domain);
                assert!(
                    error
                        .message
                        .contains("`count` would get a value outside its range"),
                    "{error}"
                );
                assert_eq!(theirs.map(f64::to_bits), values.map(f64::to_bits));
            }
        }
    }
}

/// A text that is too long for a library is truncated, but never within a character.
#[test]
fn long_texts_are_cut_between_characters() {
    let folder = folder();
    for offset in 0..3 {
        let (machine, controllers) = fixtures::manipulator();
        let mut machine = (*machine).clone();
        machine.name = format!("Long{offset}");
        for component in &mut machine.components {
            let specification = Arc::make_mut(&mut component.specification);
            for formula in &mut specification.assumptions.safety {
                // Characters of three bytes, starting at three offsets.
                let long = format!("{}{}", "x".repeat(offset), "\u{2192}".repeat(500));
                formula.requirement = Some(long);
            }
        }
        let counts = differential(&Arc::new(machine), &controllers, 500, 5, folder.path());
        assert!(counts.of(ErrorCode::Assumption) > 20, "{counts:?}");
    }
}
