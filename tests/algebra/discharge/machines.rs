//! Discharge tables of the shipped machines, and the effect of removing a guarantee named in one.

use super::mutants::nothing_can_be_left_out;
use super::tables::table;
use linewright::algebra::machine::{of_machine, of_refined_contract};
use linewright::algebra::proof::{Claim, Proof, prove};
use linewright::algebra::system::System;
use linewright::contract::machine::Machine;
use linewright::engine::files::{self, StandardLibrary};
use linewright::game::Limits;
use std::fmt::Write as _;

/// The machine of a file of the ICE laboratory.
fn machine(file: &str) -> Machine {
    let path = format!("{}/examples/ice-lab/{file}.lw", env!("CARGO_MANIFEST_DIR"));
    let loaded = files::load(&[path], &StandardLibrary::default());
    let found: Vec<_> = loaded
        .findings
        .iter()
        .map(|f| (f.code.id, &f.message))
        .collect();
    assert_eq!(found, []);
    loaded.library.machines[0].clone()
}

/// Everything to be proved of a machine.
fn claims(machine: &Machine) -> Vec<(System, Claim)> {
    let promises = machine
        .refines
        .iter()
        .map(|p| of_refined_contract(machine, p));
    [of_machine(machine)].into_iter().chain(promises).collect()
}

#[track_caller]
fn proved(system: &System, claim: &Claim) -> Proof {
    prove(system, claim, &Limits::default()).expect("no limit")
}

#[test]
fn the_five_machines_of_the_ice_laboratory_are_proved() {
    let mut text = String::new();
    for file in ["printer", "milling", "camera", "belt", "cell"] {
        let machine = machine(file);
        for (i, (system, claim)) in claims(&machine).into_iter().enumerate() {
            let proof = proved(&system, &claim);
            assert!(proof.holds(), "{}", table(&system, &claim, &proof));
            let _ = match i {
                0 => writeln!(text, "== {}", machine.name),
                i => {
                    let contract = &machine.refines[i - 1].contract;
                    writeln!(text, "== {} refines {contract}", machine.name)
                }
            };
            text += &table(&system, &claim, &proof);
        }
    }
    insta::assert_snapshot!(text);
}

/// The sizes of the holistic contract in its own file.
#[test]
fn the_cell_refines_the_holistic_contract_at_its_own_size() {
    let root = env!("CARGO_MANIFEST_DIR");
    let folder = tempfile::tempdir().expect("a folder");
    for file in ["cell.lw", "coordinator.lw", "holistic.lw", "jobs.lw"] {
        let text = std::fs::read_to_string(format!("{root}/examples/ice-lab/{file}"));
        let mut text = text.expect("an example");
        if file == "cell.lw" {
            for (small, own) in [
                ("cells: 2..360 = 8", "cells: 2..360 = 24"),
                ("2..64 = 3", "2..64 = 8"),
            ] {
                assert!(text.contains(small));
                text = text.replace(small, own);
            }
        }
        std::fs::write(folder.path().join(file), text).expect("a copy");
    }
    let path = folder.path().join("cell.lw").display().to_string();
    let loaded = files::load(&[path], &StandardLibrary::default());
    let promised = &loaded.library.machines[0].refines[0];
    let whole = loaded
        .library
        .contracts
        .iter()
        .find(|c| c.name == "HolisticCell")
        .expect("the contract");
    // The contract as in its file, not another size of it.
    assert_eq!(promised.specification, whole.specification);
    let (system, claim) = of_refined_contract(&loaded.library.machines[0], promised);
    let proof = proved(&system, &claim);
    assert!(proof.holds(), "{}", table(&system, &claim, &proof));
    let kept = proof
        .discharges
        .iter()
        .filter(|d| d.what.component.is_none());
    assert_eq!(kept.count(), claim.goal.all().count());
    assert!(claim.goal.all().count() > 80);
}

/// Every line of every table: what it names suffices, and without any single item the proof fails,
/// with a counterexample that the evaluator accepts.
#[test]
fn nothing_that_a_table_names_can_be_left_out() {
    let (mut lines, mut mutants) = (0, 0);
    for file in ["printer", "milling", "camera", "belt", "cell"] {
        let machine = machine(file);
        for (system, claim) in claims(&machine) {
            let proof = proved(&system, &claim);
            let counts = nothing_can_be_left_out(&system, &claim, &proof);
            lines += counts.0;
            mutants += counts.1;
        }
    }
    println!("{lines} lines of tables, {mutants} mutants, all of them fail");
    assert!(
        lines > 140 && mutants > 200,
        "{lines} lines, {mutants} mutants"
    );
}
