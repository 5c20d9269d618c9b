//! Random machines as text: contracts with odd assumptions, one or two actions, wires that depend
//! on properties, parameters and scripts, writes, times and limits that may or may not fit, and
//! machines within machines.

use super::text::{Chance, Text};
use std::collections::BTreeSet;

/// Data on a machine for generating lines.
#[derive(Debug, Clone)]
pub struct Model {
    pub name: String,
    /// Its text, with its own contracts.
    pub text: String,
    /// Its inner machine, if there is one.
    inner: Option<String>,
    pub operations: Vec<String>,
    /// Whether it has the parameter `p: 0..3`.
    pub parameter: bool,
    /// Whether it has the argument `t`, which determines its time.
    pub timed: bool,
}

/// Some machines in one file.
#[derive(Debug, Clone)]
pub struct Batch {
    /// The values of `q`: a range, or any number.
    pub q: &'static str,
    pub machines: Vec<Model>,
}

impl Batch {
    /// The whole file, without lines.
    pub fn text(&self) -> String {
        let texts = self.machines.iter().map(|m| m.text.as_str());
        HEAD.to_owned() + &texts.collect::<String>()
    }

    /// Removes the machines that are not sound, and those that contain one, to any depth. A machine
    /// comes after the one that it contains.
    pub fn keep(&mut self, sound: impl Fn(&str) -> bool) {
        let mut kept = BTreeSet::new();
        self.machines.retain(|m| {
            let is_whole = m.inner.as_ref().is_none_or(|inner| kept.contains(inner));
            let is_kept = sound(&m.name) && is_whole;
            if is_kept {
                kept.insert(m.name.clone());
            }
            is_kept
        });
    }
}

/// The values of `x`, which most parts carry, in every machine.
pub const X: &str = "0..3";

const HEAD: &str = "import std.coordination.single
import std.handling.convey

machine Belt(places: 2..64 = 3) implements vdi:Foerdern {
    signal load: bool = false
    signal unload_ready: bool = true
    action belt: Convey(places = places)
}

moore contract Seq {
    input job, da, db: bool
    output ca, cb, done: bool
    output phase: 0..2
    assume sa: always eventually (not ca or da)
    assume sb: always eventually (not cb or db)
    guarantee start: phase = 0 and not done
    guarantee ga: always (ca <-> phase = 1)
    guarantee gb: always (cb <-> phase = 2)
    guarantee g0: always (phase = 0 -> next phase = (if job and not done then 1 else 0))
    guarantee g1: always (phase = 1 -> next phase = (if da then 2 else 1))
    guarantee g2: always (phase = 2 -> next phase = (if db then 0 else 2))
    guarantee rep: always (next done <-> phase = 2 and db)
    guarantee fin: always eventually phase = 0
}
";

/// A number of machines with their own contracts.
pub fn batch(chance: &mut Chance, count: usize) -> Batch {
    let mut machines: Vec<Model> = Vec::new();
    // One machine of every batch is as simple as possible, so that some lines are sound.
    let q = if chance.percent(20) { "number" } else { "0..9" };
    machines.push(Model {
        name: "Plain".to_owned(),
        text: plain(q),
        inner: None,
        operations: vec!["go".to_owned()],
        parameter: false,
        timed: true,
    });
    for at in 1..count {
        let inner = machines.iter().skip(1).rfind(|m| m.operations.len() == 2);
        machines.push(match inner.cloned() {
            Some(inner) if chance.percent(15) => nested(chance, at, &inner, q),
            _ => single(chance, at, q),
        });
    }
    Batch { q, machines }
}

fn plain(q: &str) -> String {
    let mut text = Text::default();
    text.open("contract Work");
    text.line("input requested: bool");
    text.line("output finished: bool");
    text.line("assume held: always (requested and not finished -> next requested)");
    text.line("guarantee idle: always (not requested -> not finished)");
    text.line("guarantee fast: always (requested -> finished)");
    text.close();
    text.open("machine Plain(t: 0..1000 = 2)");
    text.line("step 1 s");
    text.line("property x: 0..3 = 0");
    text.line(&format!("property q: {q} = 0"));
    text.open("coordinator c: Single");
    text.line("job = operation = go");
    text.line("executed = a.finished");
    text.close();
    text.open("action a: Work when c.command");
    text.line("requested = c.command");
    text.line("time t * 1 s");
    text.close();
    text.line("operation go: a");
    text.line("done c.done");
    text.close();
    text.0
}

const ATOMS: [&str; 9] = [
    "s",
    "not s",
    "o",
    "not o",
    "requested",
    "x = 3",
    "x <= 1",
    "x != 0",
    "not requested",
];

fn formula(chance: &mut Chance) -> String {
    let a = chance.pick(&ATOMS).to_owned();
    let b = chance.pick(&ATOMS);
    match chance.below(6) {
        0 | 1 => a,
        2 => format!("({a} and {b})"),
        3 => format!("({a} or {b})"),
        4 => format!("({a} -> {b})"),
        _ => format!("({a} <-> {b})"),
    }
}

/// A contract with the interface common to all actions here. Returns whether it is a Moore machine.
fn contract(chance: &mut Chance, name: &str) -> String {
    let moore = chance.percent(30);
    let mut text = Text::default();
    text.open(&format!(
        "{}contract {name}",
        if moore { "moore " } else { "" }
    ));
    text.line("input requested, s, o: bool");
    text.line("input x: 0..3");
    text.line("output finished, z: bool");
    text.line("output y: 0..3");
    let mut assumptions = Vec::new();
    if chance.percent(50) {
        assumptions.push("always (requested and not finished -> next requested)".to_owned());
    }
    if chance.percent(40) {
        assumptions.push("always (requested and next requested -> next x = x)".to_owned());
    }
    if chance.percent(25) {
        assumptions.push("always eventually (s or not requested)".to_owned());
    }
    if chance.percent(30) {
        // Assumptions that a property, a parameter, a constant or a script may or may not keep.
        assumptions.push(match chance.below(4) {
            0 => format!("always (requested -> x <= {})", 1 + chance.below(3)),
            1 => format!("always (x <= {})", 1 + chance.below(3)),
            2 => format!("x != {}", chance.below(4)),
            _ => format!("always (requested -> {})", formula(chance)),
        });
    }
    if chance.percent(20) {
        let inner = formula(chance);
        assumptions.push(match chance.below(4) {
            0 => inner,
            1 => format!("always {inner}"),
            2 => format!("always ({inner} -> next {})", formula(chance)),
            _ => format!("always eventually {inner}"),
        });
    }
    if chance.percent(6) {
        assumptions.push(
            chance
                .pick(&["(not o and o)", "always (x = 3 and x = 0)", "always false"])
                .to_owned(),
        );
    }
    for (at, assumption) in assumptions.iter().enumerate() {
        text.line(&format!("assume a{at}: {assumption}"));
    }
    let guarantees: &[&str] = match (chance.below(5), moore) {
        (0 | 1, false) => &[
            "always (finished <-> requested)",
            "always (finished -> y = x)",
        ],
        (2, false) => &[
            "always (finished <-> requested and z)",
            "always eventually (not requested or finished)",
            "always (z -> (s or not o))",
        ],
        (3, false) => &[
            "always (requested -> finished or next y != y)",
            "always eventually (not requested or finished)",
            "always (not requested -> not finished)",
        ],
        (4, _) => &[
            "y = 0",
            "always (next y = (if requested then min(y + 1, 3) else 0))",
            "always (finished <-> y = 3)",
        ],
        _ => &[
            "not finished and y = 0",
            "always (next finished <-> requested and not finished)",
            "always (requested and not finished -> next y = x)",
        ],
    };
    for (at, guarantee) in guarantees.iter().enumerate() {
        text.line(&format!("guarantee g{at}: {guarantee}"));
    }
    text.close();
    text.0
}

fn abstraction(chance: &mut Chance) -> &'static str {
    chance.pick(&[
        "0",
        "1",
        "3",
        "x",
        "x",
        "x",
        "3 - x",
        "min(x + q, 3)",
        "min(q, 3)",
        "max(x, 1)",
        "(x + 1) mod 4",
        "(x + p) mod 4",
        "p",
        "floor(x / 2)",
        "floor(q / 3)",
        "round(q / 4)",
        "abs(x - 1)",
        "if x > 1 then 3 else 0",
        "q mod 4",
        // For some values these leave the domain, or are no integers.
        "q",
        "x + 1",
        "x - 1",
        "x / 2",
        "2 * x",
        "floor(6 / x)",
        "x + p",
        "q - x",
    ])
}

fn time(chance: &mut Chance) -> &'static str {
    chance.pick(&[
        "time 1 s",
        "time 2 s",
        "time t * 1 s",
        "time t * 1 s",
        "time t * 0.5 s",
        "time 1 s per step",
        "time t * 1 s per step",
        "time (x + 1) * 1 s",
        "time (q + 1) * 0.5 s per step",
        "time max(x, 1) * 2 s",
        "time 6 s / (x + 1)",
        // For some values these are 0, negative or infinite.
        "time 0 s",
        "time x * 1 s",
        "time x * 1 s per step",
        "time (x - 1) * 1 s",
        "time 6 s / x",
        "time 5 s / q",
        "time 1 s / t",
        "time 1 s / (q - x)",
    ])
}

fn write(chance: &mut Chance, with: &str) -> String {
    let value = chance.pick(&[
        "Y",
        "Y",
        "3 - Y",
        "min(Y + 1, 3)",
        "if Z then 0 else 3",
        "(x + 1) mod 4",
        "min(x + 1, 3)",
        "x",
        "3",
        // These may leave the domain.
        "Y + 1",
        "x + 1",
        "q - 1",
        "Y / 2",
        "Y * 4",
    ]);
    value
        .replace('Y', &format!("{with}.y"))
        .replace('Z', &format!("{with}.z"))
}

/// A machine with one or two actions.
fn single(chance: &mut Chance, at: usize, q: &str) -> Model {
    let two = chance.percent(25);
    let mut text = Text::default();
    for a in 0..=usize::from(two) {
        text.0.push_str(&contract(chance, &format!("C{at}_{a}")));
    }
    let name = format!("M{at}");
    text.open(&format!(
        "machine {name}(t: 0..1000 = {})",
        1 + chance.below(5)
    ));
    head(chance, &mut text, q);
    if chance.percent(15) {
        // `go` takes at least two steps.
        text.line(&format!(
            "limit {} steps",
            chance.pick(&["1", "2", "3", "4", "6", "12", "100"])
        ));
    }
    if two {
        text.line(
            "coordinator c: Seq { job = operation != none  da = a0.finished  db = a1.finished }",
        );
    } else {
        let job = chance.pick(&[
            "operation != none",
            "operation in {go, go2}",
            "operation = go or operation = go2",
        ]);
        text.line(&format!(
            "coordinator c: Single {{ job = {job}  executed = a0.finished }}"
        ));
    }
    for a in 0..=usize::from(two) {
        let command = if two {
            ["c.ca", "c.cb"][a]
        } else {
            "c.command"
        };
        text.open(&format!("action a{a}: C{at}_{a} when {command}"));
        text.line(&format!("requested = {command}"));
        let bits = [
            "true",
            "true",
            "sg",
            "not sg",
            command,
            "false",
            "ax = 3",
            "operation = go2",
        ];
        text.line(&format!("s = {}", chance.pick(&bits)));
        text.line(&format!("o = {}", chance.pick(&bits)));
        let numbers: &[&str] = if a == 0 {
            &["ax", "ax", "ax", "2"]
        } else {
            &["ax", "a0.y", "if sg then ax else 0"]
        };
        text.line(&format!("x = {}", chance.pick(numbers)));
        if chance.percent(90) {
            text.line(time(chance));
        }
        if chance.percent(20) {
            text.line(chance.pick(&["power 100 W", "power x * 10 W", "power (q + 1) * 5 W"]));
        }
        text.close();
    }
    let actions = if two { "a0, a1" } else { "a0" };
    text.line(&format!("operation go: {actions}"));
    text.line(&format!("operation go2: {actions}"));
    text.line("done c.done");
    tail(chance, &mut text, if two { "a1" } else { "a0" });
    text.close();
    model(name, text.0, None)
}

fn model(name: String, text: String, inner: Option<String>) -> Model {
    Model {
        name,
        text,
        inner,
        operations: vec!["go".to_owned(), "go2".to_owned()],
        parameter: true,
        timed: true,
    }
}

/// Beginning of a machine.
fn head(chance: &mut Chance, text: &mut Text, q: &str) {
    text.line(chance.pick(&["step 1 s", "step 1 s", "step 1 s", "step 0.1 s", "step 0 s"]));
    text.line(&format!("property x: {X} = {}", chance.below(4)));
    text.line(&format!("property q: {q} = {}", chance.below(10)));
    text.line(&format!("parameter p: 0..3 = {}", chance.below(4)));
    let script = chance.pick(&[
        "true",
        "true",
        "false",
        "true, false",
        "false, true, true",
        "true, true, false",
    ]);
    text.line(&format!("signal sg: bool = {script}"));
    text.line(&format!("abstract ax: 0..3 = {}", abstraction(chance)));
}

/// End of a machine.
fn tail(chance: &mut Chance, text: &mut Text, last: &str) {
    for property in ["x", "q"] {
        if chance.percent(35) {
            text.line(&format!("write {property} = {}", write(chance, last)));
        }
    }
}

/// A machine that contains another one.
fn nested(chance: &mut Chance, at: usize, inner: &Model, q: &str) -> Model {
    let name = format!("M{at}");
    let mut text = Text::default();
    text.open(&format!(
        "machine {name}(t: 0..1000 = {})",
        1 + chance.below(5)
    ));
    head(chance, &mut text, q);
    text.line("coordinator c: Single { job = operation != none  executed = inner.done }");
    text.open(&format!("machine inner: {}(t = t)", inner.name));
    text.line(chance.pick(&[
        "operation = if c.command then go else none",
        "operation = if c.command and ax > 1 then go else if c.command then go2 else none",
    ]));
    if chance.percent(40) {
        text.line(chance.pick(&["sg = c.command", "sg = sg", "sg = true"]));
    }
    text.close();
    text.line("operation go: inner.go");
    text.line("operation go2: inner.go2");
    text.line("done c.done");
    tail(chance, &mut text, "inner.a0");
    text.close();
    model(name, text.0, Some(inner.name.clone()))
}
