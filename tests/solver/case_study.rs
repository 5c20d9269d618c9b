//! The case study's contracts from specification to verified machine.

use crate::fixtures;
use linewright::deadline::{Deadline, StopReason};
use linewright::game::{Limit, Limits, Outcome, examine_environment, solve};
use linewright::gr1::{Domain, Specification, show_value};
use linewright::mealy::{Machine, extract::extract, gr1c, json, picture, verify::verify};
use std::collections::BTreeSet;
use std::time::Instant;

#[test]
fn every_contract_has_a_machine_that_passes_the_verifier() {
    let limits = Limits::default();
    for specification in fixtures::contracts() {
        let begin = Instant::now();
        let won = match solve(&specification, &limits) {
            Outcome::Realizable(won) => won,
            Outcome::Unrealizable(lost) => {
                let core = lost.core_formulas(&specification);
                panic!("{}: {core:#?}", specification.name)
            }
            Outcome::GaveUp(limit) => panic!("{}: {limit}", specification.name),
        };
        let solved = Instant::now();
        let machine = extract(&specification, &won, &limits).expect("no limit");
        let extracted = Instant::now();
        let verdict = verify(&specification, &machine, &limits).expect("no limit");
        let verified = Instant::now();
        assert_eq!(verdict, Ok(()), "{}", specification.name);
        let findings = examine_environment(&specification, &limits).expect("no limit");
        println!(
            "{:14} {:4} states {:5} rows; solve {:8.2?} extract {:8.2?} verify {:8.2?} findings {:8.2?}; peak {} nodes; separated {} dead end {:?}",
            specification.name,
            machine.states.len(),
            machine.transition_count(),
            solved - begin,
            extracted - solved,
            verified - extracted,
            verified.elapsed(),
            won.peak_nodes,
            findings.is_well_separated(),
            findings.dead_end.is_some(),
        );
    }
}

/// The machine of a realizable specification.
fn machine(specification: &Specification) -> Machine {
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(specification, &limits) else {
        panic!("{} is realizable", specification.name)
    };
    extract(specification, &won, &limits).expect("no limit")
}

#[test]
fn every_format_is_written_and_always_the_same() {
    for specification in fixtures::contracts() {
        let (first, second) = (machine(&specification), machine(&specification));
        assert_eq!(first, second);
        let goals = specification.guarantees.justice.len().max(1);
        let is_known = |own: &Vec<usize>| !own.is_empty() && own.iter().all(|goal| *goal < goals);
        assert_eq!(first.goals.len(), first.states.len());
        assert!(first.goals.iter().all(is_known), "{:?}", first.goals);
        let json = json::to_json(&first, true);
        assert_eq!(json["schema"], "linewright/machine/1");
        assert_eq!(json["states"], first.states.len());
        let rows = json["transitions"].as_array().expect("a list").len();
        assert_eq!(rows + first.initial.len(), first.transition_count());
        assert_eq!(picture::to_dot(&first), picture::to_dot(&second));
        let svg = picture::to_svg(&first, Some(&specification));
        assert_eq!(svg, picture::to_svg(&second, Some(&specification)));
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        if let Ok(folder) = std::env::var("LINEWRIGHT_SVG") {
            let name = format!("{folder}/{}", specification.name);
            std::fs::write(format!("{name}.svg"), &svg).expect("writable");
            std::fs::write(format!("{name}.dot"), picture::to_dot(&first)).expect("writable");
            std::fs::write(format!("{name}.json"), json.to_string()).expect("writable");
        }
    }
}

/// In the graph of an output's values, an edge leads from what the output is after one transition
/// to what it is after a next one, if that differs.
#[test]
fn the_graph_of_an_output_has_all_changes_of_its_value() {
    for specification in fixtures::contracts() {
        let machine = machine(&specification);
        let from = machine.states.iter().flatten().chain(&machine.initial);
        let pairs = from.flat_map(|first| machine.states[first.to].iter().map(move |t| (first, t)));
        let pairs: Vec<_> = pairs.collect();
        for (output, port) in machine.outputs.iter().enumerate() {
            let show = |value: i64| match port.domain {
                Domain::Bool if value == 0 => format!("!{}", port.name),
                Domain::Bool => port.name.clone(),
                ref domain => {
                    let value = show_value(domain, value, &port.unit);
                    format!("{} = {value}", port.name)
                }
            };
            let changes = pairs.iter().filter_map(|(first, second)| {
                let (from, to) = (first.output[output], second.output[output]);
                (from != to).then(|| (Some(show(from)), show(to)))
            });
            let starts = machine.initial.iter();
            let starts = starts.map(|first| (None, show(first.output[output])));
            let wanted: BTreeSet<(Option<String>, String)> = changes.chain(starts).collect();

            let graph = picture::to_graph_of_outputs(&machine, &[output]);
            let name = |state: usize| graph.states[state].concat();
            let edges = graph.edges.iter();
            let edges: Vec<_> = edges.map(|e| (e.from.map(name), name(e.to))).collect();
            assert_eq!(edges.len(), wanted.len(), "{} {}", machine.name, port.name);
            assert_eq!(BTreeSet::from_iter(edges), wanted);
        }
    }
}

/// The meaning of gr1c's format, step by step: from each node, every successor is what the machine
/// does on its inputs.
#[test]
fn the_gr1c_automaton_is_the_machine() {
    let specification = fixtures::pick(2);
    let pick = machine(&specification);
    let json = gr1c::to_json(&pick, &specification).expect("small");
    assert_eq!(json["version"], 1);
    assert_eq!(json["ENV"][1]["grip"], "boolean");
    assert_eq!(json["ENV"][0]["cmd"], serde_json::json!([0, 6]));
    let nodes = json["nodes"].as_object().expect("an object");
    let inputs = pick.inputs.len();
    let values = |node: &serde_json::Value| -> Vec<i64> {
        let state = node["state"].as_array().expect("a list").iter();
        state.map(|v| v.as_i64().expect("a number")).collect()
    };
    // Both are followed from the start: what is reached together stays together.
    let mut pairs = Vec::new();
    for (name, node) in nodes {
        if node["initial"] == true {
            let valuation = values(node);
            let step = pick.step(None, &valuation[..inputs]).expect("a transition");
            assert_eq!(step.output, valuation[inputs..]);
            pairs.push((name.clone(), step.to));
        }
    }
    assert!(!pairs.is_empty());
    let mut i = 0;
    while i < pairs.len() {
        let (name, state) = pairs[i].clone();
        for next in nodes[&name]["trans"].as_array().expect("a list") {
            let next = next.as_str().expect("a name").to_owned();
            let valuation = values(&nodes[&next]);
            let step = pick
                .step(Some(state), &valuation[..inputs])
                .expect("a transition");
            assert_eq!(step.output, valuation[inputs..]);
            let pair = (next, step.to);
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        i += 1;
    }
    assert_eq!(pairs.len(), nodes.len());
    // A camera grid of 6 cells with its reference has too many letters.
    let specification = fixtures::quality_check(6);
    let grid = machine(&specification);
    assert_eq!(gr1c::to_json(&grid, &specification), Err(Limit::Size));
}

#[test]
fn limits_are_respected() {
    let specification = fixtures::printer3d(2, 3);
    let late = Limits {
        deadline: Deadline::from_now(std::time::Duration::ZERO),
        memory_mib: None,
        ..Limits::default()
    };
    assert!(matches!(
        solve(&specification, &late),
        Outcome::GaveUp(Limit::Stopped(StopReason::Time))
    ));
    let small = Limits {
        deadline: Deadline::NONE,
        memory_mib: Some(0),
        ..Limits::default()
    };
    assert!(matches!(
        solve(&specification, &small),
        Outcome::GaveUp(Limit::Memory)
    ));
    let Outcome::Realizable(won) = solve(&specification, &Limits::default()) else {
        panic!("realizable")
    };
    assert_eq!(
        extract(&specification, &won, &late),
        Err(Limit::Stopped(StopReason::Time))
    );
    let done = machine(&specification);
    assert_eq!(
        verify(&specification, &done, &late),
        Err(Limit::Stopped(StopReason::Time))
    );
}
