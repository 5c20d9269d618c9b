//! A script with its answers, as a file for the host; `tests/station/libraries/host/plan.c` defines
//! its format.

use super::machines::Subject;
use super::walk::{Answer, Call, Script};
use linewright::gr1::Domain;
use linewright::station::{CallError, Package};
use std::fmt::Write as _;

/// The plan of a machine.
pub fn plan(subject: &Subject, package: &Package, script: &Script) -> String {
    let machine = &*subject.machine;
    assert!(!package.description.contains('\n'), "a line of the plan");
    let mut text = format!(
        "machine {}\ndescription {}\n",
        machine.name, package.description
    );
    for input in &machine.plant {
        let domain = &input.domain;
        let _ = writeln!(
            text,
            "plant {} {} {}",
            domain.low(),
            domain.high(),
            input.name
        );
    }
    for component in &machine.components {
        let specification = &component.specification;
        for variable in specification.outputs().map(|v| specification.variable(v)) {
            let name = format!("{}.{}", component.name, variable.name);
            port(&mut text, "output", &name, Some(&variable.domain));
        }
    }
    for property in &machine.properties {
        port(
            &mut text,
            "property",
            &property.name,
            property.domain.as_ref(),
        );
    }
    for operation in &machine.operations {
        let _ = writeln!(text, "operation {}", operation.name);
    }
    for (call, answer) in script.calls.iter().zip(&script.answers) {
        line(&mut text, call, answer);
    }
    text
}

fn port(text: &mut String, kind: &str, name: &str, domain: Option<&Domain>) {
    let (low, high) = domain.map_or((1, 0), |d| (d.low(), d.high()));
    let _ = writeln!(text, "{kind} {low} {high} {name}");
    if let Some(Domain::Enum { labels, .. }) = domain {
        for label in labels {
            let _ = writeln!(text, "label {label}");
        }
    }
}

fn line(text: &mut String, call: &Call, answer: &Answer) {
    match call {
        Call::Reset => text.push_str("reset"),
        Call::Step(plant) => {
            text.push_str("step");
            integers(text, plant);
        }
        Call::Operation(operation, values) => {
            let _ = write!(text, "simulate {operation}");
            reals(text, values);
        }
    }
    match answer {
        Answer::Reset => {}
        Answer::Outputs(outputs) => {
            text.push_str(" =");
            integers(text, outputs);
        }
        Answer::Service(service, after) => {
            text.push_str(" =");
            reals(text, &[service.seconds, service.joules]);
            let _ = write!(text, " {}", service.steps);
            reals(text, after);
        }
        Answer::Error(CallError {
            code,
            rule,
            message,
        }) => {
            let rule = rule.as_deref().unwrap_or_default();
            let unclear = |t: &str| t.contains(['\t', '\n']);
            assert!(!unclear(rule) && !unclear(message), "{message}");
            let _ = write!(text, " ! {}\t{rule}\t{message}", *code as i32);
        }
    }
    text.push('\n');
}

fn integers(text: &mut String, values: &[i64]) {
    for value in values {
        let _ = write!(text, " {value}");
    }
}

fn reals(text: &mut String, values: &[f64]) {
    for value in values {
        let _ = write!(text, " {:016x}", value.to_bits());
    }
}
