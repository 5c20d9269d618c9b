//! Random lines, each as text of the language, and as JSON for the oracle.

use crate::attack::text::Chance;
use linewright::contract::distribution::Distribution;
use linewright::line::random::{Purpose, Stream};
use linewright::line::sampler::Sampler;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// A line in both forms, and how long it runs.
pub struct RandomLine {
    pub seed: u64,
    /// The body of the line, in the language.
    pub text: String,
    /// Names and texts of the tables.
    pub tables: Vec<(String, String)>,
    pub json: Value,
    pub parts: Option<u64>,
    pub until: f64,
}

/// A statement in the language, and what it means.
type Both = (String, Value);

/// Draws that the oracle cannot make itself; the longest stream of a line needs fewer.
const TABLE: usize = 400;

/// A place or several places between which parts choose: the names in the text with the number of
/// copies, and what the choice is.
struct Stage {
    names: Vec<(String, usize)>,
    choice: Both,
    shares: Vec<f64>,
    is_station: bool,
}

impl Stage {
    /// All places, with each copy by its own name.
    fn places(&self) -> Vec<String> {
        let copies = |(name, count): &(String, usize)| match count {
            1 => vec![name.clone()],
            _ => (1..=*count).map(|i| format!("{name}[{i}]")).collect(),
        };
        self.names.iter().flat_map(copies).collect()
    }

    fn stop(&self) -> String {
        let names: Vec<&str> = self.names.iter().map(|(name, _)| name.as_str()).collect();
        names.join(", ")
    }
}

struct Generator {
    chance: Chance,
    seed: u64,
    until: f64,
    text: String,
    tables: Vec<(String, String)>,
    nodes: Vec<Value>,
    routes: Vec<Value>,
    types: Vec<String>,
    shifts: Option<Both>,
    /// Whether each type has stages of its own, so that components do not block one another.
    apart: bool,
}

/// The line with this number.
pub fn line(seed: u64) -> RandomLine {
    let mut chance = Chance::new(seed ^ 0x5eed);
    let until = 40.0 + chance.below(260) as f64 + 0.125;
    let types = 1 + chance.below(3);
    let generator = Generator {
        chance,
        seed,
        until,
        text: String::new(),
        tables: Vec::new(),
        nodes: Vec::new(),
        routes: Vec::new(),
        types: ["A", "B", "C"][..types]
            .iter()
            .map(|t| (*t).to_owned())
            .collect(),
        shifts: None,
        apart: false,
    };
    generator.write()
}

impl Generator {
    fn say(&mut self, statement: &str) {
        let _ = writeln!(self.text, "    {statement}");
    }

    /// Seconds with two decimals, from `low` to `high`.
    fn seconds(&mut self, low: f64, high: f64) -> f64 {
        let hundredths = self.chance.below(((high - low) * 100.0) as usize);
        (low * 100.0 + hundredths as f64).round() / 100.0
    }

    /// A time around this mean. The stream is that of the node for this purpose.
    fn time(&mut self, mean: f64, purpose: Purpose, name: &str) -> Both {
        let low = self.seconds(0.1 * mean, 0.7 * mean).max(0.01);
        let mode = self.seconds(0.8 * mean, 1.2 * mean);
        let high = self.seconds(1.3 * mean, 2.0 * mean);
        let table = |distribution: Distribution| {
            let mut sampler = Sampler::new(&distribution, Stream::new(self.seed, purpose, name));
            let draws: Vec<f64> = (0..TABLE).map(|_| sampler.draw()).collect();
            json!(["table", draws])
        };
        match self.chance.below(16) {
            0..=1 => (format!("{mode} s"), json!(["constant", mode])),
            2..=5 => (
                format!("uniform({low} s, {high} s)"),
                json!(["uniform", low, high]),
            ),
            6..=8 => (
                format!("exponential({mode} s)"),
                json!(["exponential", mode]),
            ),
            9 => (
                format!("discrete({low} s: 0.25, {mode} s: 0.5, {high} s: 0.25)"),
                json!(["discrete", [[low, 0.25], [mode, 0.5], [high, 0.25]]]),
            ),
            10 => (
                format!("triangular({low} s, {mode} s, {high} s)"),
                table(Distribution::Triangular { low, mode, high }),
            ),
            11 => (
                format!("lognormal({mode} s, {low} s)"),
                table(Distribution::Lognormal {
                    mean: mode,
                    deviation: low,
                }),
            ),
            12 => (
                format!("erlang(2, {mode} s)"),
                table(Distribution::Erlang {
                    stages: 2,
                    mean: mode,
                }),
            ),
            13..=14 => {
                let count = 1 + self.chance.below(30);
                let rows: Vec<f64> = (0..count).map(|_| self.seconds(low, high)).collect();
                let text = format!("empirical({})", self.table(&rows));
                let mut sorted = rows;
                sorted.sort_by(f64::total_cmp);
                (text, json!(["empirical", sorted]))
            }
            _ => (
                format!("weibull(2, {high} s)"),
                table(Distribution::Weibull {
                    shape: 2.0,
                    scale: high,
                }),
            ),
        }
    }

    /// Makes a table of these numbers, and returns the text that names its column.
    fn table(&mut self, numbers: &[f64]) -> String {
        let name = format!("table{}.csv", self.tables.len());
        let mut text = "note,time\n".to_owned();
        for number in numbers {
            let _ = writeln!(text, "x,{number}");
        }
        self.tables.push((name.clone(), text));
        format!("\"{name}\" column time in s")
    }

    /// Instants of parts, some of them at the same time.
    fn instants(&mut self) -> Vec<f64> {
        let count = 1 + self.chance.below(60);
        let mut time = if self.chance.percent(50) {
            0.0
        } else {
            self.seconds(0.0, 5.0)
        };
        let mut instants = Vec::new();
        for _ in 0..count {
            instants.push(time);
            if self.chance.percent(80) {
                time = ((time + self.seconds(0.0, 8.0)) * 100.0).round() / 100.0;
            }
        }
        instants
    }

    fn write(mut self) -> RandomLine {
        let joins = self.types.len() > 1 && self.chance.percent(35);
        self.apart = joins && self.chance.percent(75);
        let types = self.declare_types(joins);
        let product = if joins { "J" } else { "A" };
        if self.chance.percent(30) {
            self.shifts = Some(self.shift());
        }
        if let Some((text, _)) = &self.shifts {
            let text = text.clone();
            self.say(&text);
        }
        let sources = self.sources();
        let count = 1 + self.chance.below(4);
        let stages: Vec<Stage> = (0..count)
            .map(|number| {
                // Without a station, parts could pass through the line in no time for ever.
                let what = if number + 1 == count {
                    9
                } else {
                    self.chance.below(10)
                };
                self.stage(number, what, &self.types.clone())
            })
            .collect();
        self.say("sink floor rejects");
        self.nodes
            .push(json!({"name": "floor", "kind": "sink", "rejects": true, "reorder": null}));
        let end = if joins { self.joining() } else { self.end() };
        for kind in self.types.clone() {
            self.ways(&kind, &sources[&kind], &stages, &end);
        }
        let parts = self
            .chance
            .percent(25)
            .then(|| 5 + self.chance.below(20) as u64);
        let json = json!({
            "seed": self.seed, "until": self.until, "parts": parts, "product": product,
            "types": types, "nodes": self.nodes, "routes": self.routes,
        });
        RandomLine {
            seed: self.seed,
            text: self.text,
            tables: self.tables,
            json,
            parts,
            until: self.until,
        }
    }

    /// The part types. `v` sorts them, `w` counts rounds of rework.
    fn declare_types(&mut self, joins: bool) -> Vec<Value> {
        let mut types = Vec::new();
        for kind in self.types.clone() {
            let (v, w) = (self.chance.below(5), self.chance.below(3));
            self.say(&format!(
                "part {kind} {{ property v: 0..9 = {v} property w: 0..3 = {w} }}"
            ));
            let values = json!({"v": v as f64, "w": w as f64});
            types.push(json!({"name": kind, "properties": values, "bill": []}));
        }
        if joins {
            let counts: Vec<(usize, String)> = self
                .types
                .clone()
                .into_iter()
                .map(|kind| (1 + self.chance.below(3), kind))
                .collect();
            let bill: Vec<String> = counts
                .iter()
                .map(|(n, kind)| format!("{n} {kind}"))
                .collect();
            let bill = bill.join(", ");
            self.say(&format!(
                "part J from {bill} {{ property v: 0..9 = A.v property w: 0..3 = 0 }}"
            ));
            let values = json!({"v": ["A", "v"], "w": 0.0});
            types.push(json!({"name": "J", "properties": values, "bill": counts}));
        }
        self.say(if joins { "product J" } else { "product A" });
        types
    }

    /// One source for each type, by type.
    fn sources(&mut self) -> std::collections::BTreeMap<String, (String, bool)> {
        let mut sources = std::collections::BTreeMap::new();
        for kind in self.types.clone() {
            let name = format!("source{kind}");
            let (mut text, mut every, mut limit) = ("every 0 s".to_owned(), Value::Null, None);
            let on_order = self.chance.percent(10);
            let at = (!on_order && self.chance.percent(20)).then(|| self.instants());
            if on_order {
                "on order".clone_into(&mut text);
            } else if let Some(instants) = &at {
                text = format!("at {}", self.table(instants));
            } else if self.chance.percent(80) {
                let (written, meant) = self.time(4.0, Purpose::Arrivals, &name);
                (text, every) = (format!("every {written}"), meant);
            }
            if !on_order && at.is_none() && self.chance.percent(20) {
                limit = Some(10 + self.chance.below(30));
                let _ = write!(text, " limit {}", limit.unwrap_or(0));
            }
            let most = self.chance.percent(20).then(|| 2 + self.chance.below(8));
            if let Some(most) = most {
                let _ = write!(text, ", at most {most} in the line");
            }
            self.say(&format!("source {name}: {kind} {text}"));
            let timed = !every.is_null() || at.is_some();
            self.nodes.push(json!({
                "name": name, "kind": "source", "type": kind, "every": every, "limit": limit,
                "most": most, "on_order": on_order, "at": at,
            }));
            sources.insert(kind, (name, timed));
        }
        sources
    }

    /// A stage of buffers, conveyors or stations, by the number `what`.
    fn stage(&mut self, number: usize, what: usize, kinds: &[String]) -> Stage {
        let count = [1, 1, 1, 2, 2, 3][self.chance.below(6)];
        let mut names = Vec::new();
        for i in 0..count {
            let name = format!("p{number}{}", ["x", "y", "z"][i]);
            names.push(match what {
                0..=2 => self.buffer(name),
                3 => self.conveyor(name),
                _ => self.station(name, kinds, None),
            });
        }
        let is_single = names.iter().all(|(_, copies)| *copies == 1);
        let mut shares = Vec::new();
        let choice = match self.chance.below(5) {
            0 if count > 1 => (" shortest queue".to_owned(), json!("shortest")),
            1 if count > 1 => (" round robin".to_owned(), json!("robin")),
            2 | 3 if count > 1 && is_single => {
                shares = if count == 2 {
                    vec![0.25, 0.75]
                } else {
                    vec![0.5, 0.2, 0.3]
                };
                let text: Vec<String> = shares.iter().map(f64::to_string).collect();
                (
                    format!(" by probability {}", text.join(", ")),
                    json!("probability"),
                )
            }
            _ => (String::new(), json!("free")),
        };
        Stage {
            names,
            choice,
            shares,
            is_station: what > 3,
        }
    }

    fn buffer(&mut self, name: String) -> (String, usize) {
        let capacity = 1 + self.chance.below(5);
        let (text, order) = match self.chance.below(6) {
            0 => (" lifo", json!(["lifo", null])),
            1 => (" highest v first", json!(["highest", "v"])),
            2 => (" lowest w first", json!(["lowest", "w"])),
            _ => ("", json!(["fifo", null])),
        };
        self.say(&format!("buffer {name} capacity {capacity}{text}"));
        self.nodes.push(json!({
            "name": name, "kind": "buffer", "capacity": capacity, "order": order,
        }));
        (name, 1)
    }

    fn conveyor(&mut self, name: String) -> (String, usize) {
        let places = 1 + self.chance.below(6);
        let pitch = self.seconds(0.2, 1.5);
        self.say(&format!(
            "conveyor {name} places {places} pitch {pitch} m speed 1 m/s"
        ));
        self.nodes.push(json!({
            "name": name, "kind": "conveyor", "places": places, "period": pitch,
        }));
        (name, 1)
    }

    /// A station with its copies, for these types. It may join parts of type `joins`.
    fn station(&mut self, name: String, kinds: &[String], joins: Option<&str>) -> (String, usize) {
        let copies = if self.chance.percent(15) {
            2 + self.chance.below(2)
        } else {
            1
        };
        let mut text = format!("station {name}");
        if copies > 1 {
            let _ = write!(text, " times {copies}");
        }
        text.push_str(" { ");
        let places: Vec<String> = match copies {
            1 => vec![name.clone()],
            _ => (1..=copies).map(|i| format!("{name}[{i}]")).collect(),
        };
        let mut nodes: Vec<Value> = places
            .iter()
            .map(|place| json!({"name": place, "kind": "station", "joins": joins, "times": {}}))
            .collect();
        for kind in kinds {
            let streams: Vec<String> = places.iter().map(|p| format!("{p}.{kind}")).collect();
            let (time, meant) = self.times(4.0, Purpose::Service, &streams);
            for (node, meant) in nodes.iter_mut().zip(meant) {
                node["times"][kind] = meant;
            }
            let _ = write!(text, "takes {time} a {kind} ");
        }
        let all = [
            ("setup", self.setup(&places)),
            ("failures", self.failures(&places)),
            ("sets", self.sets(kinds)),
            ("defects", self.defects(kinds)),
            ("shifts", self.own_shift()),
        ];
        for (key, (statement, meant)) in all {
            if !statement.is_empty() {
                text.push_str(&statement);
                text.push(' ');
            }
            for (index, node) in nodes.iter_mut().enumerate() {
                node[key] = meant[index % meant.len()].clone();
            }
        }
        self.say(&format!("{text}}}"));
        self.nodes.extend(nodes);
        (name, copies)
    }

    /// For each place the same time, with a stream of its own.
    fn times(&mut self, mean: f64, purpose: Purpose, streams: &[String]) -> (String, Vec<Value>) {
        let from = self.chance.below(usize::MAX) as u64;
        let mut written = String::new();
        let mut meant = Vec::new();
        for stream in streams {
            let own = std::mem::replace(&mut self.chance, Chance::new(from));
            let (text, value) = self.time(mean, purpose, stream);
            self.chance = own;
            written = text;
            meant.push(value);
        }
        (written, meant)
    }

    fn setup(&mut self, places: &[String]) -> (String, Vec<Value>) {
        if !self.chance.percent(25) {
            return (String::new(), vec![Value::Null]);
        }
        let (text, meant) = self.times(1.0, Purpose::Setup, places);
        (format!("setup {text}"), meant)
    }

    fn failures(&mut self, places: &[String]) -> (String, Vec<Value>) {
        let mut text = String::new();
        let mut meant = vec![Vec::new(); places.len()];
        let count = [0, 0, 0, 0, 1, 1, 2][self.chance.below(7)];
        for name in ["", "jam"].into_iter().take(count) {
            let streams: Vec<String> = places
                .iter()
                .map(|place| {
                    if name.is_empty() {
                        place.clone()
                    } else {
                        format!("{place}.{name}")
                    }
                })
                .collect();
            let by = ["work", "calendar", "parts"][self.chance.below(3)];
            let (between, betweens) = if by == "parts" {
                let every = 1 + self.chance.below(6);
                (
                    format!("every {every} parts"),
                    vec![json!(every); places.len()],
                )
            } else {
                let (between, betweens) = self.times(15.0, Purpose::Failures, &streams);
                // A bare time is the mean of an exponential distribution.
                (format!("mtbf {}", self.drawn(&between)), betweens)
            };
            let (repair, repairs) = self.times(3.0, Purpose::Repairs, &streams);
            let restarts = by != "parts" && self.chance.percent(40);
            let name_text = if name.is_empty() {
                String::new()
            } else {
                format!("{name}: ")
            };
            let _ = write!(
                text,
                "failures {name_text}{between} mttr {}{}{} ",
                self.drawn(&repair),
                if by == "calendar" { " by calendar" } else { "" },
                if restarts { " restart" } else { "" },
            );
            for (index, modes) in meant.iter_mut().enumerate() {
                modes.push(json!({
                    "name": name, "by": by, "between": betweens[index],
                    "repair": repairs[index], "restarts": restarts,
                }));
            }
        }
        (text, meant.into_iter().map(Value::from).collect())
    }

    /// A constant time as a distribution.
    #[expect(clippy::unused_self, reason = "reads like the others")]
    fn drawn(&self, time: &str) -> String {
        if time.contains('(') {
            time.to_owned()
        } else {
            format!("constant({time})")
        }
    }

    fn sets(&mut self, kinds: &[String]) -> (String, Vec<Value>) {
        let mut text = "sets w = min(w + 1, 3)".to_owned();
        let mut meant = vec![json!([null, "w", "min(w + 1, 3)"])];
        if self.chance.percent(30) {
            let kind = &kinds[self.chance.below(kinds.len())];
            let _ = write!(text, " sets v = max(v - w, 0) on {kind}");
            meant.push(json!([kind, "v", "max(v - w, 0)"]));
        }
        (text, vec![Value::from(meant)])
    }

    fn defects(&mut self, kinds: &[String]) -> (String, Vec<Value>) {
        let (mut text, mut meant) = (String::new(), Vec::new());
        for kind in kinds {
            if self.chance.percent(30) {
                let _ = write!(
                    text,
                    "defect on {kind} probability 0.3: w becomes max(it - 1, 0) "
                );
                meant.push(json!([kind, 0.3, "w", "max(w - 1, 0)"]));
            }
            if self.chance.percent(30) {
                let _ = write!(
                    text,
                    "defect on {kind} probability 0.6: v becomes min(it + 1, 9) "
                );
                meant.push(json!([kind, 0.6, "v", "min(v + 1, 9)"]));
            }
        }
        (text, vec![Value::from(meant)])
    }

    /// Shifts until the end of the run, as statements and as changes of state.
    fn shift(&mut self) -> Both {
        let (mut text, mut changes) = (Vec::new(), Vec::new());
        let mut time = self.chance.below(2) * (3 + self.chance.below(20));
        changes.push(json!([0.0, time == 0, false]));
        while (time as f64) < self.until {
            let end = time + 20 + self.chance.below(60);
            let finishes = self.chance.percent(40);
            if time > 0 {
                changes.push(json!([time as f64, true, false]));
            }
            let mut statement = format!("shift {time} s to {end} s");
            if self.chance.percent(50) {
                let begin = time + 3 + self.chance.below(8);
                let back = begin + 2 + self.chance.below(6);
                let _ = write!(statement, " break {begin} s to {back} s");
                changes.push(json!([begin as f64, false, finishes]));
                changes.push(json!([back as f64, true, false]));
            }
            if finishes {
                statement.push_str(" finish work");
            }
            changes.push(json!([end as f64, false, finishes]));
            text.push(statement);
            time = end + 3 + self.chance.below(15);
        }
        (text.join(" "), Value::from(changes))
    }

    fn own_shift(&mut self) -> (String, Vec<Value>) {
        if self.chance.percent(12) {
            let (text, changes) = self.shift();
            return (text, vec![changes]);
        }
        let of_line = self.shifts.as_ref().map(|(_, changes)| changes.clone());
        (String::new(), vec![of_line.unwrap_or_else(|| json!([]))])
    }

    /// Sinks at the end of a line: the stage to which parts go.
    fn end(&mut self) -> Stage {
        let bad = self.chance.percent(30);
        self.sink("box", None, false);
        if bad {
            let timed = self
                .nodes
                .iter()
                .find(|n| n["type"] == "A" && !(n["every"].is_null() && n["at"].is_null()));
            let reorder = timed.is_some() && self.chance.percent(50);
            self.sink("bin", reorder.then_some("sourceA"), true);
        }
        let choice = if bad {
            (
                " by probability 0.75, 0.25".to_owned(),
                json!("probability"),
            )
        } else {
            (String::new(), json!("free"))
        };
        let names = if bad { vec!["box", "bin"] } else { vec!["box"] };
        Stage {
            names: names.into_iter().map(|n| (n.to_owned(), 1)).collect(),
            choice,
            shares: if bad { vec![0.75, 0.25] } else { Vec::new() },
            is_station: false,
        }
    }

    fn sink(&mut self, name: &str, reorder: Option<&str>, rejects: bool) {
        let text = match (rejects, reorder) {
            (false, _) => String::new(),
            (true, None) => " rejects".to_owned(),
            (true, Some(source)) => format!(" rejects reorder {source}"),
        };
        self.say(&format!("sink {name}{text}"));
        self.nodes.push(json!({
            "name": name, "kind": "sink", "rejects": rejects, "reorder": reorder,
        }));
    }

    /// A station that joins, and what follows it. Returns the stage to which components go.
    fn joining(&mut self) -> Stage {
        let joined = ["J".to_owned()];
        let (join, copies) = self.station("join".to_owned(), &joined, Some("J"));
        let check = if self.chance.percent(50) {
            let what = self.chance.below(10);
            Some(self.stage(9, what, &joined))
        } else {
            None
        };
        let end = self.end();
        let join = Stage {
            names: vec![(join, copies)],
            choice: (String::new(), json!("free")),
            shares: Vec::new(),
            is_station: true,
        };
        match check {
            Some(check) => {
                self.route("J", &join, &check, None);
                self.route("J", &check, &end, None);
            }
            None => self.route("J", &join, &end, None),
        }
        join
    }

    /// The ways of a type from its source through some of the stages to the end, with rework.
    fn ways(&mut self, kind: &str, source: &(String, bool), stages: &[Stage], end: &Stage) {
        let start = Stage {
            names: vec![(source.0.clone(), 1)],
            choice: (String::new(), json!("free")),
            shares: Vec::new(),
            is_station: false,
        };
        let mut path: Vec<&Stage> = Vec::new();
        let own = self.types.iter().position(|t| t == kind).unwrap_or(0);
        for (index, stage) in stages.iter().enumerate() {
            let is_due = if self.apart {
                index % self.types.len() == own
            } else {
                index == 0 || index + 1 == stages.len() || self.chance.percent(85)
            };
            if is_due {
                path.push(stage);
            }
        }
        let overflow = source.1
            && path
                .first()
                .is_some_and(|first| first.shares.is_empty() && first.choice.1 != "robin");
        if overflow && self.chance.percent(25) {
            let first = path[0];
            let floor = |mut names: Vec<(String, usize)>| {
                names.push(("floor".to_owned(), 1));
                names
            };
            let to = Stage {
                names: floor(first.names.clone()),
                choice: if first.choice.1 == "shortest" {
                    (String::new(), json!("free"))
                } else {
                    first.choice.clone()
                },
                shares: Vec::new(),
                is_station: false,
            };
            self.route(kind, &start, &to, None);
        } else {
            self.route(kind, &start, path.first().copied().unwrap_or(end), None);
        }
        for (index, stage) in path.iter().enumerate() {
            if stage.is_station && self.chance.percent(15) {
                let back = path[self.chance.below(index + 1)];
                self.route(kind, stage, back, Some("w < 2"));
            }
            let next = path.get(index + 1).copied().unwrap_or(end);
            if stage.is_station && self.chance.percent(20) && index + 1 < path.len() {
                self.route(kind, stage, end, Some("v < 2"));
            }
            self.route(kind, stage, next, None);
        }
    }

    fn route(&mut self, kind: &str, from: &Stage, to: &Stage, when: Option<&str>) {
        let condition = when.map_or(String::new(), |when| format!(" when {when}"));
        self.say(&format!(
            "route {kind}: {} -> {}{}{condition}",
            from.stop(),
            to.stop(),
            to.choice.0
        ));
        self.routes.push(json!({
            "type": kind, "from": from.places(), "to": to.places(), "when": when,
            "choice": to.choice.1, "shares": to.shares,
        }));
    }
}
