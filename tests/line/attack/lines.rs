//! Random lines over some machines, as text: one or two types of parts, or two that are joined,
//! through places that they may share, with branches, circles of rework, rejection and every kind
//! of supply.

use super::machines::{Batch, Model, X};
use super::text::{Chance, Text};
use std::collections::BTreeMap;

/// A place of a line.
struct Place {
    name: String,
    /// Its declaration; for a station, the machine with its arguments.
    head: String,
    /// The statements within a station; `None` for other places.
    inside: Option<Vec<String>>,
    machine: usize,
}

struct Draft {
    /// Properties carried by each type.
    carried: BTreeMap<String, Vec<&'static str>>,
    places: Vec<Place>,
    routes: Vec<String>,
    sinks: Vec<String>,
}

/// A line of this name over a batch's machines.
pub fn line(chance: &mut Chance, name: &str, batch: &Batch) -> String {
    let machines = &batch.machines[..];
    let two = chance.percent(50);
    let joined = two && chance.percent(35);
    let mut draft = Draft {
        carried: BTreeMap::new(),
        places: Vec::new(),
        routes: Vec::new(),
        sinks: vec!["sink k".to_owned()],
    };
    for at in 0..=chance.below(3) {
        draft.place(chance, at, machines, at == 0);
    }
    let mut text = Text::default();
    text.open(&format!("line {name}"));
    let mut types = vec!["P"];
    if two {
        types.push("R");
    }
    for part in &types {
        text.line(&format!(
            "part {part}{}",
            draft.properties(chance, part, batch)
        ));
    }
    if joined {
        let bill = chance.pick(&["1 P, 1 R", "1 P, 1 R", "2 P, 1 R", "1 P, 2 R"]);
        text.line(&format!(
            "part J from {bill}{}",
            draft.properties(chance, "J", batch)
        ));
        types.push("J");
    }
    text.line(&format!(
        "product {}",
        if joined {
            "J"
        } else {
            types[chance.below(types.len())]
        }
    ));
    for (at, part) in types.iter().take(if two { 2 } else { 1 }).enumerate() {
        let name = ["s", "t"][at];
        if chance.percent(4) {
            // A store that is filled from another one, in one instant.
            text.line(&format!("store {name}0: {} {part}", 1 + chance.below(12)));
            text.line(&format!("store {name}"));
            draft
                .routes
                .push(format!("route {part}: {name}0 -> {name}"));
        } else {
            text.line(&supply(chance, name, part));
        }
    }
    if chance.percent(6) {
        // A part type of its own, which leaves in one instant.
        text.line("part Z");
        text.line(chance.pick(&[
            "store z: 3 Z",
            "store z: 12 Z",
            "source z: Z every 60 s",
            "source z: Z every 0 s limit 5",
        ]));
        draft.routes.push("route Z: z -> k".to_owned());
    }
    if joined {
        let at = draft.places.len();
        draft.place(chance, at, machines, true);
        for (at, part) in ["P", "R"].into_iter().enumerate() {
            let from = ["s", "t"][at];
            draft.way(chance, part, from, Some(draft.places.len() - 1), machines);
        }
        draft.task(chance, draft.places.len() - 1, "J", machines);
        let join = draft.places[draft.places.len() - 1].name.clone();
        if chance.percent(10) {
            // A component on which the station can also work as it is.
            draft.task(chance, draft.places.len() - 1, "P", machines);
            draft.routes.push(format!("route P: {join} -> {join}"));
        }
        draft.way(chance, "J", &join, None, machines);
    } else {
        for (at, part) in types.iter().enumerate() {
            draft.way(chance, part, ["s", "t"][at], None, machines);
        }
    }
    for sink in &draft.sinks {
        text.line(sink);
    }
    for place in &draft.places {
        match &place.inside {
            None => text.line(&place.head),
            Some(inside) => {
                text.open(&place.head);
                for statement in inside {
                    text.line(statement);
                }
                text.close();
            }
        }
    }
    if chance.percent(4) {
        text.line(chance.pick(&[
            "shift 0 h to 20 h",
            "shift 6 h to 22 h",
            "shift 0 s to 900 s",
            "shift 22 h to 6 h finish work",
            "shift 6 h to 14 h break 9 h to 9.25 h shift 13 h to 22 h on Monday to Friday",
        ]));
    }
    for route in &draft.routes {
        text.line(route);
    }
    text.close();
    text.0
}

/// The table `arrivals.csv`, beside the files with the lines.
pub const ARRIVALS: &str = "at\n0\n0\n0\n0.5\n7\n30\n30\n90\n91.25\n300\n";

fn supply(chance: &mut Chance, name: &str, part: &str) -> String {
    if chance.percent(6) {
        return format!("store {name}: {} {part}", 1 + chance.below(12));
    }
    let when = match chance.below(8) {
        0..4 => "on order".to_owned(),
        4 | 5 => format!("every {} s", chance.pick(&["1", "5", "20", "60"])),
        6 => format!("every random {} s", chance.pick(&["5", "20"])),
        _ if chance.percent(50) => "at \"arrivals.csv\" column at in s".to_owned(),
        _ => format!("every 10 s limit {}", 3 + chance.below(20)),
    };
    let most = if chance.percent(15) {
        format!(", at most {} in the line", 1 + chance.below(4))
    } else {
        String::new()
    };
    format!("source {name}: {part} {when}{most}")
}

/// Conditions over the properties; some hold for all values, some for none.
const CONDITIONS: [&str; 14] = [
    "x > 1",
    "x = 3",
    "x = 0",
    "q > 4",
    "x + q > 3",
    "x != q",
    "x >= 1",
    "q mod 2 = 1",
    "x < 4",
    "x > 3",
    "q < 0",
    "x >= 0",
    "q > 9",
    "x = 5",
];

impl Draft {
    /// Properties carried by a type: those that its machines read, or some of them. The others have
    /// the machine's default.
    fn properties(&mut self, chance: &mut Chance, part: &str, batch: &Batch) -> String {
        let mut text = Vec::new();
        let mut names = Vec::new();
        if chance.percent(85) {
            names.push("x");
            text.push(format!("property x: {X} = {}", chance.below(4)));
        }
        if chance.percent(70) {
            names.push("q");
            let value = if batch.q == "number" {
                chance
                    .pick(&["0", "0.5", "1.5", "2", "9", "1000000", "0.1"])
                    .to_owned()
            } else {
                chance.below(10).to_string()
            };
            text.push(format!("property q: {} = {value}", batch.q));
        }
        self.carried.insert(part.to_owned(), names);
        if text.is_empty() {
            String::new()
        } else {
            format!(" {{ {} }}", text.join("  "))
        }
    }

    /// A condition on the properties carried by a type.
    fn condition(&self, chance: &mut Chance, part: &str) -> Option<&'static str> {
        let carried = &self.carried[part];
        let fits = |c: &&&str| {
            ["x", "q"]
                .iter()
                .all(|p| carried.contains(p) || !c.contains(p))
        };
        let fitting: Vec<&'static str> = CONDITIONS.iter().filter(fits).copied().collect();
        (!fitting.is_empty()).then(|| fitting[chance.below(fitting.len())])
    }

    fn place(&mut self, chance: &mut Chance, at: usize, machines: &[Model], station: bool) {
        let machine = if chance.percent(35) {
            0
        } else {
            chance.below(machines.len())
        };
        let kind = if station { 0 } else { chance.below(10) };
        let (name, head, inside) = match kind {
            0..6 => {
                let model = &machines[machine];
                let name = format!("st{at}");
                let arguments = if model.timed && chance.percent(40) {
                    format!("(t = {})", chance.pick(&["0", "1", "3", "10", "30"]))
                } else {
                    String::new()
                };
                let times = if chance.percent(10) { " times 2" } else { "" };
                let head = format!("station {name}: {}{arguments}{times}", model.name);
                let mut inside = Vec::new();
                if chance.percent(10) {
                    inside.push("setup 5 s".to_owned());
                }
                if chance.percent(10) {
                    inside.push(
                        chance
                            .pick(&[
                                "failures mtbf 100 s mttr 20 s",
                                "failures mtbf 20 s mttr 50 s",
                                "failures mtbf 60 s mttr 30 s by calendar",
                                "failures every 3 parts mttr 40 s",
                                "failures mtbf 30 s mttr 10 s scrap",
                                "failures mtbf 40 s mttr 20 s by calendar scrap",
                            ])
                            .to_owned(),
                    );
                }
                (name, head, Some(inside))
            }
            6 | 7 => {
                let name = format!("b{at}");
                let order = if chance.percent(10) { " lifo" } else { "" };
                let rest = if chance.percent(20) {
                    chance.pick(&[
                        " dwell 8 s",
                        " dwell uniform(1 s, 30 s)",
                        " shelf life 40 s",
                        " dwell 5 s shelf life 60 s",
                    ])
                } else {
                    ""
                };
                let head = format!(
                    "buffer {name} capacity {}{order}{rest}",
                    1 + chance.below(3)
                );
                (name, head, None)
            }
            8 => {
                let name = format!("v{at}");
                let head = format!(
                    "conveyor {name} places {} pitch 1 m speed 1 m/s",
                    1 + chance.below(3)
                );
                (name, head, None)
            }
            _ => {
                let name = format!("e{at}");
                let head = format!(
                    "conveyor {name}: Belt(places = {}) pitch 1 m speed 0.5 m/s",
                    2 + chance.below(2)
                );
                (name, head, None)
            }
        };
        self.places.push(Place {
            name,
            head,
            inside,
            machine,
        });
    }

    /// A station's work on a type, and its defects.
    fn task(&mut self, chance: &mut Chance, place: usize, part: &str, machines: &[Model]) {
        let model = &machines[self.places[place].machine];
        let mut calls = Vec::new();
        for _ in 0..=chance.below(4) / 3 {
            let operation = &model.operations[chance.below(model.operations.len())];
            calls.push(if model.parameter && chance.percent(40) {
                format!("{operation}(p = {})", chance.below(4))
            } else {
                operation.clone()
            });
        }
        let Some(inside) = &mut self.places[place].inside else {
            return;
        };
        inside.push(format!("perform {} on {part}", calls.join(", ")));
        let carried = &self.carried[part];
        if chance.percent(30) && !carried.is_empty() {
            let property = carried[chance.below(carried.len())];
            let probability = chance.pick(&["100", "30", "5", "60"]);
            let value = chance.pick(&[
                "(it + 1) mod 4",
                "3 - it",
                "min(it + 1, 3)",
                "0",
                "3",
                "max(it - 1, 0)",
                "it + 1",
                "it + 90",
                "it / 2",
                "it - 1",
                "9",
            ]);
            inside.push(format!(
                "defect on {part} probability {probability} %: {property} becomes {value}"
            ));
        }
    }

    /// The way of a type from one place to another, or out of the line.
    fn way(
        &mut self,
        chance: &mut Chance,
        part: &str,
        from: &str,
        to: Option<usize>,
        machines: &[Model],
    ) {
        let most = self.places.len();
        let mut way: Vec<usize> = (0..most)
            .filter(|at| Some(*at) != to && !self.is_join(*at, part))
            .collect();
        // Some places are skipped, some come in another order.
        way.retain(|_| !chance.percent(15));
        if way.len() > 1 && chance.percent(20) {
            way.reverse();
        }
        let mut names = vec![from.to_owned()];
        for &at in &way {
            self.task(chance, at, part, machines);
            names.push(self.places[at].name.clone());
        }
        names.push(to.map_or("k".to_owned(), |to| self.places[to].name.clone()));
        if names.len() == 2 && to.is_none() && !from.starts_with("st") {
            // Nobody works on it.
            self.routes
                .push(format!("route {part}: {}", names.join(" -> ")));
            return;
        }
        for at in 0..names.len() - 1 {
            let (here, next) = (&names[at], &names[at + 1]);
            if chance.percent(12) && next != "k" {
                // One of two places: the next one, and a sink or another one on the way.
                let other = match chance.below(4) {
                    0 => "k".to_owned(),
                    1 => {
                        let sink = format!("bad{}", self.sinks.len());
                        self.sinks.push(format!("sink {sink} rejects"));
                        sink
                    }
                    _ => names[1 + chance.below(names.len() - 1)].clone(),
                };
                let rule = chance.pick(&[
                    "",
                    " first free",
                    " shortest queue",
                    " round robin",
                    " by probability 40 %",
                ]);
                if other != *next && !self.is_only_joined(&other, part, to) {
                    self.routes
                        .push(format!("route {part}: {here} -> {next}, {other}{rule}"));
                    continue;
                }
            }
            let branches = at > 0 && here.starts_with("st") && chance.percent(30);
            if !branches {
                self.routes.push(format!("route {part}: {here} -> {next}"));
                continue;
            }
            let Some(when) = self.condition(chance, part) else {
                self.routes.push(format!("route {part}: {here} -> {next}"));
                continue;
            };
            let other = match chance.below(4) {
                0 => {
                    let sink = format!("bad{}", self.sinks.len());
                    let reorder = chance.pick(&["", " reorder s"]);
                    let reorder = if part == "R" {
                        reorder.replace(" s", " t")
                    } else {
                        reorder.to_owned()
                    };
                    self.sinks.push(format!("sink {sink} rejects{reorder}"));
                    sink
                }
                1 | 2 => names[1 + chance.below(at)].clone(),
                _ => names[names.len() - 1].clone(),
            };
            if other == *here && chance.percent(50) {
                self.routes.push(format!("route {part}: {here} -> {next}"));
                continue;
            }
            self.routes
                .push(format!("route {part}: {here} -> {other} when {when}"));
            let rest = match chance.below(10) {
                0 => format!(" when {}", self.condition(chance, part).unwrap_or(when)),
                1..6 => String::new(),
                _ => " otherwise".to_owned(),
            };
            self.routes
                .push(format!("route {part}: {here} -> {next}{rest}"));
        }
    }

    /// Whether a place is the station to which all parts of a type go to be joined.
    fn is_only_joined(&self, name: &str, part: &str, to: Option<usize>) -> bool {
        part != "J" && to.is_some_and(|to| self.places[to].name == name)
    }

    /// Whether parts are joined at a place that other types do not pass.
    fn is_join(&self, at: usize, part: &str) -> bool {
        let mut inside = self.places[at].inside.iter().flatten();
        inside.any(|s| part != "J" && s.ends_with("on J") || part == "J" && s.ends_with("on J"))
    }
}
