//! Libraries with one entry of a controller's table changed, in the C and in the machine in this process alike.
//!
//! That both are changed tells which changes can be seen at all: a row that leads to a state which cannot be told apart from its own
//! in this machine is no fault. Only changes that the script shows on the changed machine are given to the host.

use crate::differential::Random;
use crate::machines::Subject;
use crate::programs::Prepared;
use crate::walk::{Row, answer, interpreter};
use linewright::mealy::{self, Guard, Test, Transition};
use std::sync::Arc;

/// What is changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A value of an answer.
    Answer,
    /// The place that a row leads to.
    Target,
    /// A bound of a test.
    Bound,
}

pub const KINDS: [Kind; 3] = [Kind::Answer, Kind::Target, Kind::Bound];

/// A changed library.
pub struct Mutant {
    /// What was changed.
    pub what: String,
    /// The C with the change.
    pub c_source: String,
}

/// One row of a table, taken apart.
struct Entry<'a> {
    place: Option<usize>,
    transition: usize,
    cube: usize,
    machine: &'a mealy::Machine,
}

impl Entry<'_> {
    fn new(machine: &mealy::Machine, row: usize) -> Entry<'_> {
        let mut left = row;
        let places = std::iter::once(None).chain((0..machine.states.len()).map(Some));
        for place in places {
            for (transition, t) in machine.transitions(place).iter().enumerate() {
                if left < t.guard.0.len() {
                    return Entry {
                        place,
                        transition,
                        cube: left,
                        machine,
                    };
                }
                left -= t.guard.0.len();
            }
        }
        panic!("there is no row {row}");
    }

    fn transition(&self) -> &Transition {
        &self.machine.transitions(self.place)[self.transition]
    }

    /// The machine with the row's transition replaced by others, in order.
    fn replaced(&self, by: Vec<Transition>) -> mealy::Machine {
        let mut machine = self.machine.clone();
        let transitions = match self.place {
            None => &mut machine.initial,
            Some(state) => &mut machine.states[state],
        };
        transitions.splice(self.transition..=self.transition, by);
        machine
    }

    /// The row alone with something changed, between the rows of the same transition before and after it.
    fn apart(&self, change: impl FnOnce(&mut Transition)) -> mealy::Machine {
        let whole = self.transition();
        let part = |cubes: &[mealy::Cube]| Transition {
            guard: Guard(cubes.to_vec()),
            ..whole.clone()
        };
        let cubes = &whole.guard.0;
        let mut own = part(&cubes[self.cube..=self.cube]);
        change(&mut own);
        let parts = vec![
            part(&cubes[..self.cube]),
            own,
            part(&cubes[self.cube + 1..]),
        ];
        let kept = parts.into_iter().filter(|t| !t.guard.0.is_empty());
        self.replaced(kept.collect())
    }
}

/// The lines between the braces of a table in the C, by their numbers; comments of their own line left out.
fn table(lines: &[String], name: &str) -> Vec<usize> {
    let begins = |line: &String| {
        line.starts_with("static const") && line.contains(&format!(" {name}[] = {{"))
    };
    let begin = lines.iter().position(begins).expect("the table is there") + 1;
    let end = lines[begin..]
        .iter()
        .position(|l| l == "};")
        .expect("its end");
    (begin..begin + end)
        .filter(|l| !lines[*l].trim_start().starts_with("/*"))
        .collect()
}

/// Replaces number `index` (of those before the line's comment).
fn replace_number(line: &str, index: usize, value: i64) -> String {
    let (numbers, comment) = line.split_once("/*").unwrap_or((line, ""));
    let mut made = String::new();
    let mut seen = 0;
    let mut rest = numbers;
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit() || c == '-') {
        let end = rest[at..].find(|c: char| !c.is_ascii_digit() && c != '-');
        let end = end.map_or(rest.len(), |e| at + e);
        made += &rest[..at];
        made += &if seen == index {
            value.to_string()
        } else {
            rest[at..end].to_owned()
        };
        seen += 1;
        rest = &rest[end..];
    }
    assert!(seen > index, "number {index} of `{line}`");
    format!(
        "{made}{rest}{}{comment}",
        if comment.is_empty() { "" } else { "/*" }
    )
}

/// Changes an entry that the script comes by; `None` where the script does not show it, with what it was.
pub fn mutate(prepared: &Prepared, kind: Kind, random: &mut Random) -> Result<Mutant, String> {
    let subject = &prepared.subject;
    let covered: Vec<Row> = prepared.script.covered.iter().copied().collect();
    let (c, row) = covered[random.below(covered.len() as u64) as usize];
    let component = &subject.machine.components[c];
    let machine = subject.controllers[c].machine().expect("a table");
    let entry = Entry::new(machine, row);
    let mut lines: Vec<String> = prepared
        .package
        .c_source
        .lines()
        .map(str::to_owned)
        .collect();
    let prefix = format!("c{c}_{}", component.name);
    let rows = table(&lines, &format!("{prefix}_rows"));
    let what;
    let changed = match kind {
        Kind::Answer => {
            let output = entry.transition().output.clone();
            let port = random.below(output.len() as u64) as usize;
            let domain = &machine.outputs[port].domain;
            let value = if output[port] == domain.high() {
                domain.low()
            } else {
                output[port] + 1
            };
            // Every row with the same answer shares it.
            let mut changed = machine.clone();
            let states = changed.states.iter_mut().flatten();
            for t in changed.initial.iter_mut().chain(states) {
                if t.output == output {
                    t.output[port] = value;
                }
            }
            let answer: usize = number(&lines[rows[row]], 2) as usize;
            let line = table(&lines, &format!("{prefix}_answers"))[answer];
            what = format!(
                "{prefix}: answer {answer}, {} becomes {value}",
                machine.outputs[port].name
            );
            lines[line] = replace_number(&lines[line], port, value);
            changed
        }
        Kind::Target => {
            let others = machine.states.len() as u64 - 1;
            if others == 0 {
                return Err(format!("{prefix} has one state"));
            }
            let from = entry.transition().to;
            let to = (from + 1 + random.below(others) as usize) % machine.states.len();
            what = format!("{prefix}: row {row} leads to state {to} instead of {from}");
            lines[rows[row]] = replace_number(&lines[rows[row]], 3, to as i64 + 1);
            entry.apart(|t| t.to = to)
        }
        Kind::Bound => {
            let tests = &entry.transition().guard.0[entry.cube].0;
            if tests.is_empty() {
                return Err(format!("{prefix}: row {row} has no test"));
            }
            let test = random.below(tests.len() as u64) as usize;
            let Test { input, low, high } = tests[test];
            // The bound that says something.
            let below = low > machine.inputs[input].domain.low();
            let (new_low, new_high) = if below {
                (low - 1, high)
            } else {
                (low, high + 1)
            };
            let (new_low, new_high) = match random.below(2) {
                0 if below => (low + 1, high),
                0 => (low, high - 1),
                _ => (new_low, new_high),
            };
            let first = number(&lines[rows[row]], 0) as usize;
            what = format!(
                "{prefix}: row {row}, {} in {low}..{high} becomes {new_low}..{new_high}",
                machine.inputs[input].name
            );
            let mut passed = 0;
            for line in table(&lines, &format!("{prefix}_tests")) {
                let here = lines[line].matches('{').count();
                if passed + here > first + test {
                    let begin = 3 * (first + test - passed);
                    lines[line] = replace_number(&lines[line], begin + 1, new_low);
                    lines[line] = replace_number(&lines[line], begin + 2, new_high);
                    break;
                }
                passed += here;
            }
            entry.apart(|t| {
                t.guard.0[0].0[test] = Test {
                    input,
                    low: new_low,
                    high: new_high,
                };
            })
        }
    };
    let mut controllers = (*subject.controllers).clone();
    controllers[c] = changed.into();
    let changed = Subject {
        machine: Arc::clone(&subject.machine),
        controllers: Arc::new(controllers),
    };
    let c_source = lines.join("\n") + "\n";
    assert_ne!(c_source, prepared.package.c_source, "{what}");
    if is_shown(prepared, &changed) {
        Ok(Mutant { what, c_source })
    } else {
        Err(what)
    }
}

fn number(line: &str, index: usize) -> i64 {
    let words = line.split(|c: char| !c.is_ascii_digit() && c != '-');
    let mut numbers = words.filter(|w| !w.is_empty());
    numbers
        .nth(index)
        .expect("a number")
        .parse()
        .expect("a number")
}

/// Whether the script shows that a machine is another one.
fn is_shown(prepared: &Prepared, changed: &Subject) -> bool {
    let mut interpreter = interpreter(changed);
    let mut script = prepared.script.calls.iter().zip(&prepared.script.answers);
    script.any(|(call, expected)| {
        let seen = answer(&changed.machine, &mut interpreter, call);
        format!("{seen:?}") != format!("{expected:?}")
    })
}
