//! The discharge tables of the machines that ship, and what happens when a guarantee that one of them names is taken away.

use linewright::algebra::machine::of_machine;
use linewright::algebra::proof::{Claim, Proof, prove};
use linewright::algebra::replay;
use linewright::algebra::system::System;
use linewright::cli::files::{self, StandardLibrary};
use linewright::game::Limits;

/// A table as text: one obligation a line.
fn table(system: &System, claim: &Claim, proof: &Proof) -> String {
    let name = |at| {
        let formula = replay::formula(system, claim, at);
        match at.part {
            Some(part) => format!("{}: {}", system.parts[part].name, formula.name),
            None => formula.name.clone(),
        }
    };
    let mut text = String::new();
    for d in &proof.discharges {
        let by: Vec<String> = d.by.iter().map(|b| name(*b)).collect();
        text += &format!("{} | {:?} | {}\n", name(d.what), d.rule, by.join(", "));
    }
    for o in &proof.open {
        text += &format!(
            "{} | OPEN {:?} | {:?}\n",
            name(o.what),
            o.why,
            replay::accepts(system, claim, proof, o)
        );
    }
    text
}

#[test]
fn tables() {
    for file in ["printer", "milling", "camera", "belt", "cell"] {
        let path = format!("{}/examples/ice-lab/{file}.lw", env!("CARGO_MANIFEST_DIR"));
        let loaded = files::load(&[path], &StandardLibrary::default());
        let all: Vec<_> = loaded
            .findings
            .iter()
            .map(|f| (f.code.id, &f.message))
            .collect();
        assert_eq!(all, []);
        let machine = &loaded.library.machines[0];
        for promised in &machine.refines {
            let clock = std::time::Instant::now();
            let (system, claim) = linewright::algebra::machine::of_promise(machine, promised);
            let proof = prove(&system, &claim, &Limits::default()).unwrap();
            println!(
                "==== {} refines {} {:?}\n{}",
                machine.name,
                promised.contract,
                clock.elapsed(),
                table(&system, &claim, &proof)
            );
        }
        let clock = std::time::Instant::now();
        let (system, claim) = of_machine(machine);
        let proof = prove(&system, &claim, &Limits::default()).unwrap();
        println!(
            "==== {} {:?}\n{}",
            machine.name,
            clock.elapsed(),
            table(&system, &claim, &proof)
        );
    }
}
