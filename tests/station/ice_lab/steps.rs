//! Library and interpreter on random steps: the same outputs and the same errors, for every machine
//! of the line.
//!
//! At least a tenth of the steps violate an assumption. A value outside its domain is another error
//! and is not counted. The lists below name every assumption that a plant can violate through a
//! machine's own wires; the others concern the coordinator's outputs, which keep them whatever the
//! plant does.

use crate::differential::differential;
use crate::laboratory::machines;
use linewright::station::ErrorCode;

const STEPS: usize = 100_000;

/// The rules that a walk must have violated, by machine.
fn breakable(machine: &str) -> &'static [&'static str] {
    match machine {
        "Printer" => &["layers: target_held"],
        "Milling" => &[
            "cutter: begins_full",
            "cutter: clamped_while_cutting",
            "cutter: fresh",
            "cutter: target_held",
        ],
        "QualityCheck" => &["look: still"],
        "AssemblyCell" => &[
            "cell: both_hold_for",
            "cell: first_job",
            "cell: job_held",
            "cell: open_a_for",
            "cell: open_for",
            "cell: screw_needs_part",
            "move_a: target_held",
            "pick_a: part_stays",
            "pick_b: part_stays",
            "place_a: target_stays",
            "place_b: target_stays",
            "turn_a: target_held",
        ],
        "Belt" => &["belt: waits"],
        _ => panic!("{machine} is new: say which of its assumptions the plant can break"),
    }
}

#[test]
fn library_and_interpreter_agree_on_every_machine() {
    let folder = tempfile::tempdir().unwrap();
    for controlled in machines() {
        let name = controlled.machine.name.as_str();
        let counts = differential(
            &controlled.machine,
            &controlled.controllers,
            STEPS,
            17,
            folder.path(),
        );
        println!("{name}: {counts:#?}");
        let all = counts.ok + counts.errors.values().sum::<usize>();
        assert_eq!(all, STEPS);
        assert!(
            counts.of(ErrorCode::Assumption) >= STEPS / 10,
            "{name}: {counts:?}"
        );
        assert!(counts.of(ErrorCode::Domain) > 0, "{name}: {counts:?}");
        assert!(counts.ok > STEPS / 3, "{name}: {counts:?}");
        let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
        assert_eq!(faults, 0, "{name}: {counts:?}");
        let rules: Vec<&str> = counts.rules.keys().map(String::as_str).collect();
        assert_eq!(rules, breakable(name), "{name}");
    }
}
