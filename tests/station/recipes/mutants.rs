//! Machines with one change that makes them wrong. The verifier has to refuse them.

use super::cells::Made;
use linewright::engine::recipes::machine::{RecipeMachine, verify};
use linewright::mealy::Machine;

/// Number of mutants that are refused, and of all.
pub fn refused(made: &Made) -> (usize, usize) {
    let mutants = mutants(&made.built.machine);
    let refused = mutants.iter().filter(|(what, machine)| {
        let mutant = RecipeMachine {
            machine: machine.clone(),
            ..made.built.clone()
        };
        let verdict = verify(&made.layout, &made.recipe, &mutant);
        if verdict.is_ok() {
            println!("{}: accepted: {what}", machine.name);
        }
        verdict.is_err()
    });
    (refused.count(), mutants.len())
}

/// Each mutant with what was changed.
fn mutants(machine: &Machine) -> Vec<(String, Machine)> {
    let mut mutants = Vec::new();
    let last = machine.outputs.len() - 1;
    let mut add = |what: String, machine: Machine| mutants.push((what, machine));
    for state in 0..machine.states.len() {
        let entering = machine
            .initial
            .iter()
            .chain(machine.states.iter().flatten());
        let Some(entering) = entering.into_iter().find(|t| t.to == state) else {
            continue;
        };
        // A resource waits that should do something, wherever the vector is begun or repeated.
        for (resource, label) in entering.output[..last].iter().enumerate() {
            if *label != 0 {
                let mut mutant = machine.clone();
                let all = mutant.initial.iter_mut();
                let all = all.chain(mutant.states.iter_mut().flatten());
                for t in all.filter(|t| t.to == state) {
                    t.output[resource] = 0;
                }
                add(format!("{resource} waits in {state}"), mutant);
            }
        }
        // The recipe ends too early.
        if entering.output[last] == 0 {
            let mut mutant = machine.clone();
            let all = mutant.initial.iter_mut();
            let all = all.chain(mutant.states.iter_mut().flatten());
            for t in all.filter(|t| t.to == state) {
                t.output[last] = 1;
            }
            add(format!("ends in {state}"), mutant);
        }
        for (number, transition) in machine.states[state].iter().enumerate() {
            let mut mutant = machine.clone();
            mutant.states[state].remove(number);
            add(format!("{state} without {number}"), mutant);
            if transition.to == state {
                let mut mutant = machine.clone();
                let held = &mut mutant.states[state][number];
                held.output[last] = 1 - held.output[last];
                add(format!("{state} not held"), mutant);
                continue;
            }
            // A vector is left out: the state after it is reached at once.
            let skipped = &machine.states[transition.to];
            for after in skipped.iter().filter(|t| t.to != transition.to) {
                let mut mutant = machine.clone();
                let skip = &mut mutant.states[state][number];
                (skip.to, skip.output) = (after.to, after.output.clone());
                add(format!("{state} skips {}", transition.to), mutant);
            }
        }
    }
    mutants
}
