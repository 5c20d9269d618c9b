//! Libraries with one entry of a controller's tables changed.
//!
//! The tables are read back from the C text and become a controller for the machine in this
//! process. So it is known in advance which changes the plan shows: a bound that moves where the
//! assumptions allow nothing, or a place that cannot be distinguished from another in this machine,
//! is no fault. Only the others are given to the host.

use super::machines::Subject;
use super::programs::Prepared;
use super::walk::{answer, interpreter};
use crate::differential::Random;
use linewright::mealy::{self, Cube, Guard, Test, Transition};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Kind of change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A value of an answer.
    Answer,
    /// The target of a leaf.
    Target,
    /// The bound of a split.
    Bound,
}

pub const KINDS: [Kind; 3] = [Kind::Answer, Kind::Target, Kind::Bound];

/// A changed library.
pub struct Mutant {
    /// Description of the change.
    pub what: String,
    /// The changed C.
    pub c_source: String,
}

/// A table in the C text: its rows, each with its line and its fields.
type Table = Vec<(usize, Vec<String>)>;

/// The tables of one component, as defined in `ffi/machine.h`.
struct Tables {
    /// For every variable of the component, its name in C and the index of its input.
    inputs: Vec<(String, Option<usize>)>,
    splits: Table,
    leaves: Table,
    answers: Table,
    ways: Table,
}

fn field(row: &(usize, Vec<String>), field: usize) -> i64 {
    row.1[field].parse().expect("a number")
}

/// The rows of a table: everything between its braces, without comments.
fn table(lines: &[String], name: &str) -> Table {
    let begin = format!(" {name}[] = {{");
    let begins = |line: &String| line.starts_with("static const") && line.ends_with(&begin);
    let begin = lines.iter().position(begins).expect("the table is there") + 1;
    let rows = lines[begin..].iter().take_while(|line| *line != "};");
    let fields = |line: &String| {
        let text = line.split("/*").next().unwrap_or_default();
        let fields = text.split([',', '{', '}']).map(str::trim);
        fields
            .filter(|f| !f.is_empty())
            .map(str::to_owned)
            .collect()
    };
    rows.enumerate()
        .map(|(i, line)| (begin + i, fields(line)))
        .collect()
}

/// Replaces a field of a line.
fn replace(lines: &mut [String], row: &(usize, Vec<String>), field: usize, value: i64) {
    let (line, fields) = row;
    let (text, comment) = match lines[*line].split_once("/*") {
        Some((text, comment)) => (text.to_owned(), format!("/*{comment}")),
        None => (lines[*line].clone(), String::new()),
    };
    let mut fields = fields.clone();
    fields[field] = value.to_string();
    let joined = fields.join(", ");
    let made = if text.contains('{') {
        format!("    {{ {joined} }}, ")
    } else {
        format!("    {joined}, ")
    };
    lines[*line] = made + &comment;
}

impl Tables {
    fn read(subject: &Subject, c: usize, lines: &[String]) -> Self {
        let component = &subject.machine.components[c];
        let prefix = format!("c{c}_{}", component.name);
        let specification = &component.specification;
        let inputs: Vec<usize> = specification
            .inputs()
            .map(linewright::gr1::VarId::index)
            .collect();
        let named = format!("    v{c}_{}_", component.name);
        let names = lines
            .iter()
            .filter(|l| l.starts_with(&named) && l.contains(", /*"));
        let inputs = names
            .take(specification.variables.len())
            .enumerate()
            .map(|(v, line)| {
                let name = line.trim().split(',').next().unwrap_or_default();
                (name.to_owned(), inputs.iter().position(|i| *i == v))
            })
            .collect();
        let mut splits = table(lines, &format!("{prefix}_splits"));
        // An empty table has a placeholder.
        splits.retain(|(_, fields)| fields.len() == 4);
        Self {
            inputs,
            splits,
            leaves: table(lines, &format!("{prefix}_leaves")),
            answers: table(lines, &format!("{prefix}_answers")),
            ways: table(lines, &format!("{prefix}_root")),
        }
    }

    /// The input that a split tests.
    fn input(&self, split: usize) -> usize {
        let name = &self.splits[split].1[0];
        let found = self.inputs.iter().find(|(n, _)| n == name);
        found.and_then(|(_, input)| *input).expect("an input")
    }

    /// The splits passed by some inputs at a place, and the leaf at the end.
    fn way(&self, place: usize, inputs: &[i64]) -> (Vec<usize>, usize) {
        let mut way = field(&self.ways[place], 0);
        let mut splits = Vec::new();
        while way >= 0 {
            let split = way as usize;
            splits.push(split);
            let row = &self.splits[split];
            let above = inputs[self.input(split)] > field(row, 3);
            way = field(row, if above { 2 } else { 1 });
        }
        (splits, (-1 - way) as usize)
    }

    /// The controller described by the tables.
    fn controller(&self, original: &mealy::Machine) -> mealy::Machine {
        let mut places = self.ways.iter().map(|row| {
            let mut transitions = Vec::new();
            let mut ranges: Vec<(i64, i64)> = original
                .inputs
                .iter()
                .map(|p| (p.domain.low(), p.domain.high()))
                .collect();
            self.unfold(field(row, 0), original, &mut ranges, &mut transitions);
            transitions
        });
        mealy::Machine {
            initial: places.next().expect("a place before step 0"),
            states: places.collect(),
            ..original.clone()
        }
    }

    fn unfold(
        &self,
        way: i64,
        original: &mealy::Machine,
        ranges: &mut [(i64, i64)],
        transitions: &mut Vec<Transition>,
    ) {
        if ranges.iter().any(|(low, high)| low > high) {
            return;
        }
        if way >= 0 {
            let row = &self.splits[way as usize];
            let input = self.input(way as usize);
            let (kept, bound) = (ranges[input], field(row, 3));
            ranges[input].1 = kept.1.min(bound);
            self.unfold(field(row, 1), original, ranges, transitions);
            ranges[input] = (kept.0.max(bound + 1), kept.1);
            self.unfold(field(row, 2), original, ranges, transitions);
            ranges[input] = kept;
            return;
        }
        let leaf = &self.leaves[(-1 - way) as usize];
        if field(leaf, 1) < 0 {
            return;
        }
        let answer = &self.answers[field(leaf, 0) as usize];
        let tests = ranges.iter().enumerate();
        let tests = tests.map(|(input, &(low, high))| Test { input, low, high });
        transitions.push(Transition {
            guard: Guard(vec![Cube(tests.collect())]),
            output: (0..original.outputs.len())
                .map(|o| field(answer, o))
                .collect(),
            to: field(leaf, 1) as usize - 1,
        });
    }
}

fn lines(text: &str) -> Vec<String> {
    text.lines().map(str::to_owned).collect()
}

/// The machine with the controller from a component's tables in this C text.
fn with_tables(subject: &Subject, c: usize, lines: &[String]) -> Subject {
    let original = subject.controllers[c].machine().expect("a table");
    let mut controllers = (*subject.controllers).clone();
    let read = Tables::read(subject, c, lines).controller(original);
    controllers[c] = read.into();
    Subject {
        machine: Arc::clone(&subject.machine),
        controllers: Arc::new(controllers),
    }
}

/// Whether the tables in the C text, read back, are the machine: the script does not distinguish
/// them.
pub fn are_read_back(prepared: &Prepared) -> bool {
    let lines = lines(&prepared.package.c_source);
    let subject = &prepared.subject;
    (0..subject.controllers.len()).all(|c| !is_shown(prepared, &with_tables(subject, c, &lines)))
}

/// Number of splits and leaves that the script passes, and their total.
pub fn coverage(prepared: &Prepared) -> (usize, usize) {
    let lines = lines(&prepared.package.c_source);
    let subject = &prepared.subject;
    let (mut met, mut all) = (0, 0);
    for c in 0..subject.controllers.len() {
        let tables = Tables::read(subject, c, &lines);
        let (splits, leaves) = came_by(prepared, c, &tables);
        met += splits.len() + leaves.len();
        all += tables.splits.len() + tables.leaves.len();
    }
    (met, all)
}

/// The splits and leaves of a component that the script passes.
fn came_by(prepared: &Prepared, c: usize, tables: &Tables) -> (Vec<usize>, Vec<usize>) {
    let (mut splits, mut leaves) = (BTreeSet::new(), BTreeSet::new());
    for (component, place, inputs) in &prepared.script.questions {
        if *component == c {
            let (way, leaf) = tables.way(place.map_or(0, |p| p + 1), inputs);
            splits.extend(way);
            leaves.insert(leaf);
        }
    }
    (splits.into_iter().collect(), leaves.into_iter().collect())
}

fn one_of(list: &[usize], random: &mut Random) -> Option<usize> {
    let index = random.below(list.len().max(1) as u64) as usize;
    list.get(index).copied()
}

/// Changes an entry that the script passes; returns a description as an error if the script does
/// not show the change.
pub fn mutate(prepared: &Prepared, kind: Kind, random: &mut Random) -> Result<Mutant, String> {
    let subject = &prepared.subject;
    let c = random.below(subject.controllers.len() as u64) as usize;
    let name = &subject.machine.components[c].name;
    let original = subject.controllers[c].machine().expect("a table");
    let mut lines = lines(&prepared.package.c_source);
    let tables = Tables::read(subject, c, &lines);
    let (splits, leaves) = came_by(prepared, c, &tables);
    let leaf = one_of(&leaves, random).expect("a leaf that the script comes by");
    let what = match kind {
        Kind::Answer => {
            let number = field(&tables.leaves[leaf], 0) as usize;
            let answer = &tables.answers[number];
            let port = random.below(original.outputs.len() as u64) as usize;
            let (domain, before) = (&original.outputs[port].domain, field(answer, port));
            let value = if before == domain.high() {
                domain.low()
            } else {
                before + 1
            };
            replace(&mut lines, answer, port, value);
            let port = &original.outputs[port].name;
            format!("{name}: answer {number}, {port} becomes {value}")
        }
        Kind::Target => {
            let places = original.states.len() as u64;
            let before = field(&tables.leaves[leaf], 1);
            if places < 2 {
                return Err(format!("{name} has one state"));
            }
            let value = (before + random.below(places - 1) as i64) % places as i64 + 1;
            replace(&mut lines, &tables.leaves[leaf], 1, value);
            format!("{name}: leaf {leaf} leads to place {value} instead of {before}")
        }
        Kind::Bound => {
            let Some(split) = one_of(&splits, random) else {
                return Err(format!("{name} has no split"));
            };
            let before = field(&tables.splits[split], 3);
            let domain = &original.inputs[tables.input(split)].domain;
            let up = before < domain.high() && random.below(2) == 0;
            let value = if up { before + 1 } else { before - 1 };
            replace(&mut lines, &tables.splits[split], 3, value);
            format!("{name}: split {split}, bound {value} instead of {before}")
        }
    };
    let c_source = lines.join("\n") + "\n";
    assert_ne!(c_source, prepared.package.c_source, "{what}");
    if is_shown(prepared, &with_tables(subject, c, &lines)) {
        Ok(Mutant { what, c_source })
    } else {
        Err(what)
    }
}

/// Whether the script shows that a machine differs.
fn is_shown(prepared: &Prepared, changed: &Subject) -> bool {
    let mut interpreter = interpreter(changed);
    let mut script = prepared.script.calls.iter().zip(&prepared.script.answers);
    script.any(|(call, expected)| {
        let seen = answer(&changed.machine, &mut interpreter, call);
        // Compared as text: a NaN does not equal itself.
        format!("{seen:?}") != format!("{expected:?}")
    })
}
