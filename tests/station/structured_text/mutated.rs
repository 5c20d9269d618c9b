//! The comparison itself: a block with one state, guard, output, assumption or decision changed
//! must be detected.

use super::play::{compare, compiled};
use crate::library::{Controlled, as_functions, machines};
use linewright::mealy::Controller;
use linewright::station::structured_text::{block, block_with_tables};

const STEPS: usize = 100_000;

fn turn() -> &'static Controlled {
    let found = machines().iter().find(|c| c.controller.name() == "Turn");
    found.expect("a contract of the library")
}

/// Whether a changed text is rejected, or behaves differently.
fn differs(text: &str, controller: &Controller) -> bool {
    let specification = &turn().specification;
    match compiled(text) {
        Ok(program) => compare(&program, controller, specification, STEPS, 13).is_err(),
        Err(_) => true,
    }
}

/// The text with the line at this index changed.
fn with_line(text: &str, number: usize, line: &str) -> String {
    let lines = text.lines().enumerate();
    lines.fold(String::new(), |out, (i, old)| {
        out + if i == number { line } else { old } + "\n"
    })
}

/// A change of one line of a step, if there is something to change.
fn changed(line: &str) -> Option<String> {
    let words = line.trim_start();
    for (right, wrong) in [
        (":= TRUE;", ":= FALSE;"),
        (":= FALSE;", ":= TRUE;"),
        (" AND ", " OR "),
    ] {
        if line.contains(right) {
            return Some(line.replacen(right, wrong, 1));
        }
    }
    for (right, wrong) in [
        (" <> ", " = "),
        (" >= ", " > "),
        (" <= ", " < "),
        ("(desired = ", "(desired <> "),
    ] {
        if words.contains("IF ") && line.contains(right) {
            return Some(line.replacen(right, wrong, 1));
        }
    }
    for name in ["state := ", "angle := "] {
        if let Some(value) = words.strip_prefix(name) {
            let value: i64 = value.trim_end_matches(';').parse().ok()?;
            let other = if value == 1 { 2 } else { 1 };
            return Some(line.replace(words, &format!("{name}{other};")));
        }
    }
    None
}

#[test]
fn changed_lines_of_a_case_are_found() {
    let controlled = turn();
    let text = block(&controlled.controller, &controlled.specification).to_text();
    assert!(!differs(&text, &controlled.controller));
    let begin = text
        .lines()
        .position(|l| l.contains("CASE state OF"))
        .expect("a CASE");
    let end = text
        .lines()
        .position(|l| l.contains("END_CASE;"))
        .expect("its end");
    let (mut tried, mut found) = (0, 0);
    for (number, line) in text.lines().enumerate() {
        let Some(other) = changed(line).filter(|_| begin < number && number < end) else {
            continue;
        };
        let mutant = with_line(&text, number, &other);
        tried += 1;
        found += usize::from(differs(&mutant, &controlled.controller));
    }
    // The others change the behavior on inputs that the assumptions exclude, which are refused
    // before.
    assert!(
        tried > 150 && found * 100 >= tried * 85,
        "{found} of {tried}"
    );
}

/// The texts with one number of a table changed.
fn with_other_numbers(text: &str, table: &str, change: impl Fn(i64) -> i64) -> Vec<String> {
    let begin = text.find(&format!("    {table} : ARRAY")).expect("a table");
    let open = begin + text[begin..].find(":= [").expect("its values") + 4;
    let close = open + text[open..].find(']').expect("their end");
    let values: Vec<i64> = text[open..close]
        .split(',')
        .map(|v| v.trim().parse().expect("a number"))
        .collect();
    let mutants = (0..values.len()).map(|place| {
        let mut values = values.clone();
        values[place] = change(values[place]);
        let values: Vec<String> = values.iter().map(i64::to_string).collect();
        format!("{}{}{}", &text[..open], values.join(", "), &text[close..])
    });
    mutants.collect()
}

#[test]
fn changed_assumptions_are_found() {
    let controlled = turn();
    let text = block(&controlled.controller, &controlled.specification).to_text();
    let lines = text.lines().enumerate();
    let asked = lines
        .skip_while(|(_, l)| !l.contains("Assumptions. *)"))
        .take_while(|(_, l)| !l.contains("CASE state OF"));
    let mut tried = 0;
    for (number, line) in asked {
        if let Some(other) = changed(line) {
            let mutant = with_line(&text, number, &other);
            let found = differs(&mutant, &controlled.controller);
            assert!(found, "{line} -> {other}");
            tried += 1;
        }
    }
    assert!(tried > 2, "{tried}");
}

#[test]
fn changed_answers_and_targets_of_the_tables_are_found() {
    let controlled = turn();
    let machine = controlled.controller.machine().expect("a machine");
    let text = block_with_tables(machine, &controlled.specification).to_text();
    assert!(!differs(&text, &controlled.controller));
    let mutants = [
        with_other_numbers(&text, "answers", |v| i64::from(v == 0)),
        with_other_numbers(&text, "transition_to", |v| if v == 1 { 2 } else { 1 }),
        with_other_numbers(&text, "transition_answer", |v| if v == 3 { 6 } else { 3 }),
        with_other_numbers(&text, "test_high", |v| if v == 0 { 1 } else { v - 1 }),
    ];
    let mutants = mutants.concat();
    let found = mutants.iter();
    let found = found.filter(|m| differs(m, &controlled.controller)).count();
    // The others change the behavior on inputs that the assumptions exclude.
    let all = mutants.len();
    assert!(found * 100 >= all * 98, "{found} of {all}");
}

#[test]
fn changed_decisions_are_found() {
    let controlled = turn();
    let controller = as_functions(&controlled.specification);
    let text = block(&controller, &controlled.specification).to_text();
    assert!(!differs(&text, &controller));
    // Promises, and the outputs of step 0, are evaluated in every play.
    for mutant in with_other_numbers(&text, "assumption", |v| v ^ 1) {
        assert!(differs(&mutant, &controller));
    }
    let first = controller
        .functions()
        .expect("functions")
        .controls
        .first
        .len();
    let mutants = with_other_numbers(&text, "output_edge", |v| v ^ 1);
    for mutant in &mutants[..first] {
        assert!(differs(mutant, &controller));
    }
    // Of later steps, some change outputs that are never read.
    let found = mutants[first..]
        .iter()
        .filter(|m| differs(m, &controller))
        .count();
    let rest = mutants.len() - first;
    assert!(found * 10 >= rest * 6, "{found} of {rest}");
}
