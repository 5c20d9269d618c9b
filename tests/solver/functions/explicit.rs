//! The explicit machine of functions, with a state for each value of their memory.

use linewright::gr1::Domain;
use linewright::mealy::functions::{Functions, State};
use linewright::mealy::{Cube, Guard, Machine, Test, Transition};
use std::collections::HashMap;

/// The machine, with a transition for every single input that is not refused.
pub fn machine(functions: &Functions) -> Machine {
    let mut numbers: HashMap<State, usize> = HashMap::new();
    let mut todo: Vec<State> = Vec::new();
    let domains: Vec<&Domain> = functions.inputs.iter().map(|p| &p.domain).collect();
    let letters = letters(&domains);
    let mut transitions = |state: &State, todo: &mut Vec<State>| -> Vec<Transition> {
        let mut found = Vec::new();
        for letter in &letters {
            let mut next = state.clone();
            let Ok(output) = functions.step(&mut next, letter) else {
                assert_eq!(next, *state, "a refused step changes nothing");
                continue;
            };
            let fresh = numbers.len();
            let to = *numbers.entry(next.clone()).or_insert(fresh);
            if to == fresh {
                todo.push(next);
            }
            let test = |(input, value): (usize, &i64)| Test {
                input,
                low: *value,
                high: *value,
            };
            let cube = Cube(letter.iter().enumerate().map(test).collect());
            found.push(Transition {
                guard: Guard(vec![cube]),
                output,
                to,
            });
        }
        found
    };
    let initial = transitions(&functions.initial_state(), &mut todo);
    let mut states = Vec::new();
    while let Some(state) = todo.get(states.len()).cloned() {
        states.push(transitions(&state, &mut todo));
    }
    Machine {
        name: functions.name.clone(),
        timing: functions.timing,
        inputs: functions.inputs.clone(),
        outputs: functions.outputs.clone(),
        initial,
        states,
        goals: Vec::new(),
    }
}

fn letters(domains: &[&Domain]) -> Vec<Vec<i64>> {
    let mut letters = vec![Vec::new()];
    for domain in domains {
        letters = letters
            .into_iter()
            .flat_map(|letter| {
                (domain.low()..=domain.high()).map(move |value| {
                    let mut longer = letter.clone();
                    longer.push(value);
                    longer
                })
            })
            .collect();
    }
    letters
}
