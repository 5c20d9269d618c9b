//! Turns: the oldest request that a node would accept, including belts.

use crate::models::{Builder, Logged, Shift1, at_random, constant, every};
use linewright::contract::line::Supply;
use linewright::line::End;
use linewright::line::log::EventKind;
use linewright::line::random::Stream;
use linewright::station::{CallError, Controller, ErrorCode, Service};
use std::collections::BTreeMap;

/// A source on order has a part whenever the station is free, and a belt hands over only at its
/// steps: its parts come through nevertheless.
#[test]
fn a_belt_is_served_beside_a_source_that_always_has_a_part() {
    let mut builder = Builder::new(&["P0", "A0", "P1"]);
    builder
        .bill("A0", &[("P0", 1)])
        .station("st1", &["A0", "P1"], constant(0.0))
        .endless("p0", "P0")
        .conveyor("conv2", 4, 2.0)
        .source("p1", "P1", every(1.0, None))
        .station("st3", &["P1"], constant(55.0))
        .belt("belt4", 2, Shift1::new(2))
        .conveyor("conv5", 1, 5.0)
        .station("st6", &["A0"], constant(55.0))
        .sink("out")
        .route("P0", &["p0", "conv2", "st1"])
        .route("A0", &["st1", "conv5", "st6", "out"])
        .route("P1", &["p1", "st3", "belt4", "st1", "out"]);
    let trace = builder.run_until(10_000.0);
    // The station is free once in 55 s. Every other time the components of the next A0 were present
    // before the P1.
    assert!(trace.products > 85, "{} products", trace.products);
    let joined = builder.part("A0");
    let finished = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Finished && e.part.is_some_and(|(_, kind)| kind == joined))
        .count();
    assert!(finished > 150, "{finished} joined");
}

/// The next part of a source comes at the instant in which a bill becomes complete. If it went
/// first, it would be in the way of the bill, and have no room to go on.
#[test]
fn a_newcomer_does_not_overtake_a_complete_bill() {
    let mut builder = Builder::new(&["A", "J"]);
    builder
        .bill("J", &[("A", 2)])
        .station("t", &["A", "J"], constant(10.0))
        .endless("s", "A")
        .sink("out")
        .route("A", &["s", "t", "t"])
        .route("J", &["t", "out"]);
    let trace = builder.run_until(1_000.0);
    assert_eq!(trace.end, End::Time, "{:#?}", trace.findings);
    assert_eq!(trace.products, 100);
}

/// A belt that refuses every step in which its part could leave.
struct Refuses(Shift1);

impl Controller for Refuses {
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
        self.0.simulate(operation, values)
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        if plant[1] != 0 && outputs[0] + outputs[1] > 0 {
            return Err(CallError {
                code: ErrorCode::Assumption,
                rule: Some("belt: no way off".to_owned()),
                message: "belt: the assumption no way off does not hold".to_owned(),
            });
        }
        self.0.step(plant, outputs)
    }

    fn reset(&mut self) {
        self.0.reset();
    }
}

/// A belt that keeps its first part at its entry.
struct Keeps(bool);

impl Controller for Keeps {
    fn simulate(&mut self, _: usize, _: &mut [f64]) -> Result<Service, CallError> {
        unreachable!("a belt has no operations")
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        outputs.copy_from_slice(&[i64::from(self.0), 0, i64::from(!self.0)]);
        self.0 |= plant[0] != 0;
        Ok(())
    }

    fn reset(&mut self) {
        self.0 = false;
    }
}

/// A belt that keeps its part in the same way, and changes its outputs in every step in which it
/// could leave.
struct Wavers(Keeps, bool);

impl Controller for Wavers {
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
        self.0.simulate(operation, values)
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        let on = self.0.0;
        self.0.step(plant, outputs)?;
        self.1 ^= plant[1] != 0;
        outputs[2] |= i64::from(on && self.1);
        Ok(())
    }

    fn reset(&mut self) {
        *self = Self(Keeps(false), false);
    }
}

/// Room is not reserved for ever for a belt that does not hand over.
#[test]
fn a_belt_that_does_not_hand_over_loses_its_turn() {
    let run = |controller: Box<dyn Controller>, supply: Supply| -> (Logged, u64) {
        let mut builder = Builder::new(&["A", "B"]);
        builder
            .source("a", "A", every(0.0, Some(1)))
            .belt("belt", 2, Shift1::new(2))
            .source("b", "B", supply)
            .station("cell", &["A", "B"], constant(1.5))
            .sink("sink")
            .route("A", &["a", "belt", "cell", "sink"])
            .route("B", &["b", "cell", "sink"]);
        let belt = builder.node("belt");
        builder.controllers.insert(belt, controller);
        let trace = builder.run_until(600.0);
        let on = trace
            .log
            .iter()
            .filter(|e| e.node == belt && e.what == EventKind::Arrived);
        let on = on.count() as u64;
        (trace, on)
    };
    let (trace, on) = run(Box::new(Refuses(Shift1::new(2))), every(0.0, None));
    assert_eq!((trace.end, on), (End::Time, 1));
    // One step of the belt for each B, at the next full second.
    assert!(trace.products >= 299, "{} products", trace.products);
    assert!(trace.violation_count > 100, "it is asked again and again");
    // Alone it has one turn, and another when something has changed.
    let alone = every(10_000.0, None);
    let (trace, _) = run(Box::new(Refuses(Shift1::new(2))), alone);
    assert!(
        (1..=3).contains(&trace.violation_count),
        "{}",
        trace.violation_count
    );
    let keeps: [fn() -> Box<dyn Controller>; 2] = [
        || Box::new(Keeps(false)),
        || Box::new(Wavers(Keeps(false), false)),
    ];
    for keeps in keeps {
        let (trace, on) = run(keeps(), every(0.0, None));
        assert_eq!((trace.end, on), (End::Time, 1));
        // As many steps as it has places, plus three, for each B.
        assert!(trace.products >= 85, "{} products", trace.products);
        // A part that comes to a free station gives way to the belt, and is not forgotten.
        let (trace, _) = run(keeps(), every(10.0, None));
        assert!(trace.products >= 55, "{} products", trace.products);
    }
}

/// The place before a belt, where another one hands over, takes turns with a source that always has
/// a part.
#[test]
fn a_belt_before_a_belt_is_served_in_its_turn() {
    let mut builder = Builder::new(&["A", "B"]);
    builder
        .endless("a", "A")
        .belt("first", 2, Shift1::new(2))
        .endless("b", "B")
        .belt("second", 3, Shift1::new(3))
        .sink("sink")
        .route("A", &["a", "first", "second", "sink"])
        .route("B", &["b", "second", "sink"]);
    let trace = builder.run_until(1000.0);
    let of = |kind: usize| {
        let finished = trace.log.iter().filter(|e| e.what == EventKind::Finished);
        finished
            .filter(|e| e.part.is_some_and(|p| p.1 == kind))
            .count() as i64
    };
    let (a, b) = (of(0), of(1));
    assert!(a > 200 && (a - b).abs() <= 4, "{a} and {b}");
}

/// A station fed by several nodes, each with its own part type.
struct Fed {
    trace: Logged,
    station: usize,
    /// By part type: its source node, and the kind of feeder.
    feeders: BTreeMap<usize, (usize, Feeder)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Feeder {
    /// A source that always has a part.
    Source,
    Buffer,
    /// A belt with this many places.
    Belt(u32),
    /// Joined at the station.
    Joined,
}

fn fed(seed: u64) -> Fed {
    let mut stream = Stream::from_seed(seed);
    let count = 2 + stream.below(3) as usize;
    let names: Vec<String> = (0..count).map(|i| format!("P{i}")).collect();
    let mut types: Vec<&str> = vec!["C"];
    types.extend(names.iter().map(String::as_str));
    let mut builder = Builder::new(&types);
    let mut kinds = Vec::new();
    let mut feeders = BTreeMap::new();
    let mut joined = false;
    for name in &names {
        let source = format!("source_{name}");
        let before = format!("before_{name}");
        let mut way = vec![source.as_str()];
        let feeder = match stream.below(4) {
            0 => Feeder::Source,
            1 => Feeder::Buffer,
            2 if !joined => Feeder::Joined,
            _ => Feeder::Belt(1 + stream.below(3) as u32),
        };
        let supply = if feeder == Feeder::Source || stream.below(2) == 0 {
            every(0.0, None)
        } else {
            at_random(1.0 + stream.unit() * 4.0, None)
        };
        match feeder {
            Feeder::Joined => {
                joined = true;
                builder.bill(name, &[("C", 1 + stream.below(2) as u32)]);
                builder.source(&source, "C", supply);
            }
            _ => {
                builder.source(&source, name, supply);
            }
        }
        match feeder {
            Feeder::Buffer => {
                builder.buffer(&before, 1 + stream.below(3) as u32);
                way.push(&before);
            }
            Feeder::Belt(places) => {
                builder.belt(&before, places, Shift1::new(places as usize));
                way.push(&before);
            }
            Feeder::Source | Feeder::Joined => {}
        }
        let last = builder.node(way[way.len() - 1]);
        feeders.insert(builder.part(name), (last, feeder));
        let way: Vec<String> = way.iter().map(|&node| node.to_owned()).collect();
        kinds.push((name.as_str(), way));
    }
    let parts: Vec<&str> = names.iter().map(String::as_str).collect();
    let seconds = [0.3, 1.0, 2.7][stream.below(3) as usize];
    builder.station("cell", &parts, constant(seconds));
    builder.sink("sink");
    for (name, way) in &kinds {
        let mut way: Vec<&str> = way.iter().map(String::as_str).collect();
        way.push("cell");
        let kind = builder.part(name);
        let part = if feeders[&kind].1 == Feeder::Joined {
            "C"
        } else {
            name
        };
        builder.route(part, &way);
        builder.route(name, &["cell", "sink"]);
    }
    Fed {
        trace: builder.run_until(150.0),
        station: builder.node("cell"),
        feeders,
    }
}

/// By part number: when each began to wait for the station, derived from the log by the definition
/// of the rule.
fn requests(fed: &Fed) -> BTreeMap<u64, f64> {
    let mut requests = BTreeMap::new();
    // By node: when its last part left. By station: when the last component arrived.
    let mut left: BTreeMap<usize, f64> = BTreeMap::new();
    let mut component = 0.0;
    let mut arrived: BTreeMap<u64, f64> = BTreeMap::new();
    let mut queues: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
    for entry in &fed.trace.log {
        let Some((number, kind)) = entry.part else {
            continue;
        };
        if entry.what == EventKind::Arrived && entry.node == fed.station && kind == 0 {
            component = entry.time;
        }
        let Some(&(node, feeder)) = fed.feeders.get(&kind) else {
            continue;
        };
        match (feeder, entry.what) {
            // It offers the next part as soon as one has left.
            (Feeder::Source, EventKind::Entered) => {
                requests.insert(number, left.get(&node).copied().unwrap_or(0.0));
            }
            (Feeder::Belt(places), EventKind::Place(place)) if place + 1 == places => {
                requests.insert(number, entry.time);
            }
            (Feeder::Buffer, EventKind::Arrived) if entry.node == node => {
                let queue = queues.entry(node).or_default();
                queue.push(number);
                arrived.insert(number, entry.time);
                if queue.len() == 1 {
                    requests.insert(number, entry.time);
                }
            }
            (Feeder::Buffer, EventKind::Left) if entry.node == node => {
                let queue = queues.entry(node).or_default();
                queue.remove(0);
                if let Some(&front) = queue.first() {
                    requests.insert(front, entry.time.max(arrived[&front]));
                }
            }
            (Feeder::Joined, EventKind::Started) => {
                requests.insert(number, component);
            }
            _ => {}
        }
        if entry.what == EventKind::Left && entry.node == node {
            left.insert(node, entry.time);
        }
    }
    requests
}

/// No request is overtaken by a later one, whether it is served eventually or still waits. Since
/// each feeder waits with one part at a time, this bounds the number that go before it by those
/// that waited earlier.
#[test]
fn no_request_is_overtaken_by_a_later_one() {
    let (mut waits, mut belts) = (0, 0);
    for seed in 0..400 {
        let fed = fed(seed);
        let requests = requests(&fed);
        let mut started: Vec<(u64, usize)> = Vec::new();
        for entry in &fed.trace.log {
            if entry.what == EventKind::Started {
                started.extend(entry.part);
            }
        }
        let mut latest: Option<(f64, u64)> = None;
        let mut open = requests.clone();
        for &(number, kind) in &started {
            let asked = requests[&number];
            open.remove(&number);
            if let Some((later, first)) = latest {
                assert!(
                    asked >= later,
                    "seed {seed}: part {first} asked at {later} and began before part {number}, which asked at {asked}"
                );
            }
            latest = Some((asked, number));
            waits += 1;
            belts += u32::from(matches!(fed.feeders[&kind].1, Feeder::Belt(_)));
        }
        if let Some((later, first)) = latest {
            for (number, asked) in open {
                assert!(
                    asked >= later,
                    "seed {seed}: part {number} has waited since {asked}, part {first} asked at {later} and began"
                );
            }
        }
        assert!(fed.trace.findings.is_empty(), "{:?}", fed.trace.findings);
    }
    println!("{waits} services, {belts} of parts from belts");
    assert!(belts > 5_000);
}
