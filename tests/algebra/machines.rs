//! The discharge tables of the machines that ship, and what happens when a guarantee that one of them names is taken away.

use super::tables::{name, table};
use linewright::algebra::machine::{of_machine, of_promise};
use linewright::algebra::proof::{Claim, Proof, prove};
use linewright::algebra::replay;
use linewright::algebra::system::{FormulaRef, Half, System};
use linewright::cli::files::{self, StandardLibrary};
use linewright::contract::machine::Machine;
use linewright::game::{Limits, RuleKind};
use std::collections::BTreeSet;

/// The machine of a file of the ICE laboratory.
fn machine(file: &str) -> Machine {
    let path = format!("{}/examples/ice-lab/{file}.lw", env!("CARGO_MANIFEST_DIR"));
    let loaded = files::load(&[path], &StandardLibrary::default());
    let found: Vec<_> = { loaded.findings.iter() }
        .map(|f| (f.code.id, &f.message))
        .collect();
    assert_eq!(found, []);
    loaded.library.machines[0].clone()
}

/// Everything that is to be proved of a machine.
fn claims(machine: &Machine) -> Vec<(System, Claim)> {
    let promises = machine.refines.iter().map(|p| of_promise(machine, p));
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
            text += &match i {
                0 => format!("== {}\n", machine.name),
                i => format!(
                    "== {} refines {}\n",
                    machine.name,
                    machine.refines[i - 1].contract
                ),
            };
            text += &table(&system, &claim, &proof);
        }
    }
    insta::assert_snapshot!(text);
}

/// The same system without one guarantee.
fn without(system: &System, at: FormulaRef) -> System {
    let mut less = system.clone();
    let part = at.part.expect("a guarantee of a part");
    let side = &mut less.parts[part].guarantees;
    match at.kind {
        RuleKind::Initial => side.initial.remove(at.index),
        RuleKind::Invariant => side.invariants.remove(at.index),
        RuleKind::Safety => side.safety.remove(at.index),
        RuleKind::Justice => side.justice.remove(at.index),
    };
    less
}

#[test]
fn mutants() {
    for file in ["printer", "milling", "camera", "cell"] {
        let machine = machine(file);
        for (system, claim) in claims(&machine) {
            let proof = proved(&system, &claim);
            let named: BTreeSet<FormulaRef> = { proof.discharges.iter() }
                .flat_map(|d| &d.by)
                .copied()
                .filter(|at| at.part.is_some() && at.half == Half::Guarantees)
                .collect();
            for at in named {
                let clock = std::time::Instant::now();
                let less = without(&system, at);
                let proof = proved(&less, &claim);
                println!(
                    "{} {} {} {} {:?}",
                    machine.name,
                    name(&system, &claim, at),
                    proof.holds(),
                    proof.open.len(),
                    clock.elapsed()
                );
                for open in &proof.open {
                    assert_eq!(replay::accepts(&less, &claim, &proof, open), Ok(()));
                }
            }
        }
    }
}
