//! Setup, breakdowns, shifts, energy, and the booking of time.

use crate::models::{Builder, constant, every, failing, plant_of};
use linewright::contract::distribution::Distribution;
use linewright::line::log::EventKind;
use linewright::line::{Bottleneck, Options, Trace};

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not near {b}");
}

#[test]
fn setup_passes_when_the_type_changes() {
    let mut builder = Builder::new(&["A", "B"]);
    builder
        .source("a", "A", every(0.0, Some(2)))
        .source("b", "B", every(0.0, Some(2)))
        .buffer("mixed", 4)
        .station("cell", &["A", "B"], constant(10.0))
        .with_station("cell", |station| {
            station.setup = Distribution::Constant(3.0);
        })
        .sink("sink")
        .route("A", &["a", "mixed", "cell", "sink"])
        .route("B", &["b", "mixed", "cell", "sink"]);
    let trace = builder.run(2);
    // A A B B: one change.
    assert_eq!(trace.seconds, 43.0);
    let shares = trace.stations[0].shares;
    near(shares.setup, 3.0 / 43.0, 1e-12);
    near(shares.busy, 40.0 / 43.0, 1e-12);
}

#[test]
fn availability_follows_from_mtbf_and_mttr() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(7.0))
        .with_station("cell", |station| station.failures = failing(90.0, 10.0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"]);
    let trace = builder.run_until(2_000_000.0);
    let shares = trace.stations[0].shares;
    near(shares.busy, 0.9, 0.005);
    near(shares.busy + shares.failed, 1.0, 1e-9);
    // No service time is lost or gained.
    near(
        trace.stations[0].busy_seconds / 7.0,
        trace.products as f64,
        1.0,
    );
}

#[test]
fn the_failure_clock_runs_only_at_work() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(40.0, None))
        .station("cell", &["Part"], constant(10.0))
        .with_station("cell", |station| station.failures = failing(50.0, 5.0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"]);
    let trace = builder.run_until(1_000_000.0);
    let failures = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Failed)
        .count() as f64;
    near(trace.stations[0].busy_seconds / failures, 50.0, 2.0);
    near(
        trace.stations[0].shares.failed / trace.stations[0].shares.busy,
        0.1,
        0.01,
    );
}

#[test]
fn off_shift_the_station_stands_still() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(3600.0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"])
        .shift(6.0 * 3600.0, 14.5 * 3600.0);
    let trace = builder.run_until(2.0 * 86_400.0);
    // Eight and a half hours a day; the ninth part is finished in the first half hour of the second
    // day.
    assert_eq!(trace.products, 17);
    near(trace.stations[0].shares.busy, 17.0 / 48.0, 1e-12);
    near(trace.stations[0].shares.idle, 31.0 / 48.0, 1e-12);
    let ends: Vec<f64> = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Finished)
        .map(|e| e.time / 3600.0)
        .collect();
    assert_eq!(
        ends[..9],
        [7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 30.5]
    );
}

#[test]
fn a_shift_from_midnight_and_one_to_midnight() {
    for (from, to, hours) in [
        (0.0, 43_200.0, 36.0),
        (43_200.0, 86_400.0, 24.0),
        (0.0, 86_400.0, 60.0),
    ] {
        let mut builder = Builder::new(&["Part"]);
        builder
            .endless("source", "Part")
            .station("cell", &["Part"], constant(3600.0))
            .sink("sink")
            .route("Part", &["source", "cell", "sink"])
            .shift(from, to);
        let trace = builder.run_until(2.5 * 86_400.0);
        assert_eq!(trace.products as f64, hours, "from {from} to {to}");
    }
}

#[test]
fn energy_of_work_and_of_waiting() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(10.0, Some(3)))
        .station("cell", &["Part"], constant(4.0))
        .machine_watts("cell", 2.0)
        .sink("sink")
        .route("Part", &["source", "cell", "sink"]);
    // Services from 0, 10 and 20; at 22 half of the last one is done.
    let trace = builder.run_until(22.0);
    near(trace.joules, (4.0 + 4.0 + 2.0) * 10.0 + 12.0 * 2.0, 1e-9);
    assert_eq!(trace.machines[0].busy_seconds, 10.0);
}

#[test]
fn an_unvisited_station_is_idle() {
    let mut builder = Builder::new(&["Other", "Part"]);
    builder
        .endless("source", "Part")
        .station("used", &["Part"], constant(4.0))
        .station("unused", &["Other"], constant(4.0))
        .sink("sink")
        .route("Part", &["source", "used", "sink"]);
    let trace = builder.run(3);
    assert_eq!(trace.stations[1].shares.idle, 1.0);
    assert_eq!(trace.bottleneck.station().unwrap().name, "used");
}

/// Results of a manual calculation for a line that has nothing left to do while shifts continue.
#[test]
fn off_shift_stays_idle_when_nothing_is_left_to_do() {
    const HOUR: f64 = 3600.0;
    // Three parts of an hour each, from six o'clock on; the line works eight hours a day.
    for (until, on) in [
        (48.0, 16.0),
        (24.0, 8.0),
        (12.0, 6.0),
        (54.5, 16.5),
        (57.0, 19.0),
        (62.0 + 24.0 * 700.0, 5_624.0),
    ] {
        let mut builder = Builder::new(&["Part"]);
        builder
            .source("source", "Part", every(0.0, Some(3)))
            .station("cell", &["Part"], constant(HOUR))
            .sink("sink")
            .route("Part", &["source", "cell", "sink"])
            .shift(6.0 * HOUR, 14.0 * HOUR);
        let trace = builder.run_until(until * HOUR);
        assert_eq!((trace.products, trace.seconds), (3, until * HOUR));
        let shares = trace.stations[0].shares;
        near(shares.busy, 3.0 / until, 1e-12);
        near(shares.starved, (on - 3.0) / until, 1e-9);
        near(shares.idle, (until - on) / until, 1e-9);
    }
    // A station that waits for a component which never comes: starved on shift, idle off shift.
    let mut builder = Builder::new(&["A", "B", "C"]);
    builder
        .bill("C", &[("A", 1), ("B", 1)])
        .source("a", "A", every(HOUR, Some(1)))
        .store("b", &[("B", 0)])
        .station("cell", &["C"], constant(10.0))
        .sink("sink")
        .route("A", &["a", "cell"])
        .route("B", &["b", "cell"])
        .route("C", &["cell", "sink"])
        .shift(6.0 * HOUR, 14.0 * HOUR);
    let shares = builder.run_until(24.0 * HOUR).stations[0].shares;
    near(shares.idle, 16.0 / 24.0, 1e-12);
    near(shares.starved, 8.0 / 24.0, 1e-12);
}

/// The bottleneck is where time is lost to setups or breakdowns, even if another station works
/// more, whichever is declared first.
#[test]
fn the_bottleneck_counts_setup_and_repair() {
    for order in [["slow", "works"], ["works", "slow"]] {
        let mut builder = Builder::new(&["A", "B"]);
        builder
            .source("a", "A", every(0.0, None))
            .source("b", "B", every(0.0, None));
        for name in order {
            let seconds = if name == "slow" { 4.0 } else { 5.0 };
            builder.station(name, &["A", "B"], constant(seconds));
        }
        builder
            .with_station("slow", |station| {
                station.setup = Distribution::Constant(3.0);
            })
            .sink("sink")
            .route("A", &["a", "slow", "works", "sink"])
            .route("B", &["b", "slow", "works", "sink"]);
        is_the_bottleneck(&builder.run_until(7000.0));
        let mut builder = Builder::new(&["Part"]);
        builder.endless("source", "Part");
        for name in order {
            let seconds = if name == "slow" { 4.0 } else { 5.0 };
            builder.station(name, &["Part"], constant(seconds));
        }
        builder
            .with_station("slow", |station| station.failures = failing(10.0, 20.0))
            .sink("sink")
            .route("Part", &["source", "slow", "works", "sink"]);
        is_the_bottleneck(&builder.run_until(50_000.0));
    }
}

/// The slow station is the bottleneck, and works less than the other one.
fn is_the_bottleneck(trace: &Trace) {
    let position = |name: &str| trace.stations.iter().position(|s| s.name == name);
    let busy = |name: &str| trace.stations[position(name).unwrap()].shares.busy;
    assert!(busy("slow") < busy("works"));
    assert_eq!(trace.bottleneck.station().unwrap().name, "slow");
}

/// What limits a line with a source, a buffer and two stations.
fn limit(every: &str, x: &str, y: &str) -> Bottleneck {
    let text = format!(
        "line L {{
            part P source a: P every {every}
            buffer q capacity 10
            station x {{ takes {x} }} station y times 2 {{ takes {y} }}
            sink k
            route P: a -> q -> x -> y -> k
        }}"
    );
    let options = Options {
        parts: Some(2_000),
        ..Options::default()
    };
    plant_of(&text, options).run().bottleneck
}

#[test]
fn what_limits_a_line_may_be_its_source() {
    // The source brings a part in 5 s, though x works four of them.
    let Bottleneck::Source { names, busiest, .. } = limit("5 s", "4 s", "2 s") else {
        panic!("not the source");
    };
    let busiest = busiest.unwrap();
    assert_eq!((names, busiest.name.as_str()), (vec!["a".to_owned()], "x"));
    assert!((busiest.engaged - 0.8).abs() < 0.01);
    for (every, x, y, name) in [
        ("3 s", "4 s", "2 s", "x"),
        ("0 s", "4 s", "2 s", "x"),
        ("exponential(1 s)", "1.5 s", "4 s", "y"),
    ] {
        let found = limit(every, x, y);
        assert_eq!(found.station().unwrap().name, name, "{found:?}");
    }
    // Both are always busy, or nearly so.
    let Bottleneck::Undecided(equal) = limit("0 s", "2 s", "4 s") else {
        panic!("one of two is chosen");
    };
    let names: Vec<&str> = equal.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["x", "y"]);
}

/// The station that joins is the busiest and waits for the rare part: its source limits the line,
/// although the other source has to wait.
#[test]
fn a_starved_bottleneck_is_limited_by_supply() {
    let line = |rare: &str| {
        let text = format!(
            "line L {{
                part Cap part Body part Toy from 1 Cap, 1 Body
                source caps: Cap every {rare}
                source bodies: Body every 2 s
                station join {{ takes 3 s }} station pack {{ takes 1 s }}
                sink out
                route Cap: caps -> join
                route Body: bodies -> join
                route Toy: join -> pack -> out
            }}"
        );
        let options = Options {
            parts: Some(500),
            ..Options::default()
        };
        plant_of(&text, options).run().bottleneck
    };
    let Bottleneck::Source {
        names,
        busiest,
        parts_wait: true,
    } = line("5 s")
    else {
        panic!("not the source");
    };
    let busiest = busiest.unwrap();
    assert_eq!(
        (names, busiest.name.as_str()),
        (vec!["caps".to_owned()], "join")
    );
    near(busiest.engaged_on_shift, 0.6, 0.01);
    near(busiest.starved_on_shift, 0.4, 0.01);
    // With as many caps as it can use, the station limits the line.
    assert_eq!(line("2 s").station().unwrap().name, "join");
}

/// Parts wait in the source at night, but by day the station waits for them: more supply would make
/// more products, and a faster station would not.
#[test]
fn a_source_that_waits_at_night_limits_the_day() {
    let products = |every: &str, takes: &str| {
        let text = format!(
            "line L {{
                part P source a: P every {every}
                buffer q capacity 10
                station x {{ takes {takes} }}
                sink k
                route P: a -> q -> x -> k
                shift 6 h to 14 h
            }}"
        );
        let options = Options {
            until: Some(86_400.0),
            ..Options::default()
        };
        let trace = plant_of(&text, options).run();
        (trace.products, trace.bottleneck)
    };
    let (made, limit) = products("5 s", "4 s");
    assert!(
        matches!(&limit, Bottleneck::Source { names, .. } if *names == ["a"]),
        "{limit:?}"
    );
    assert!(products("5 s", "3 s").0 <= made + 1);
    assert!(products("4.5 s", "4 s").0 > made * 11 / 10);
}

/// The first station works all of its shift; the second one has more work in a day, but also more
/// time.
#[test]
fn shares_of_a_stations_own_shift_decide() {
    let text = "line L {
        part P source s: P every 0 s
        station a { takes 5 s shift 6 h to 14 h }
        buffer q capacity 4000
        station b { takes 6 s }
        sink k
        route P: s -> a -> q -> b -> k
    }";
    let options = Options {
        until: Some(7.0 * 86_400.0),
        ..Options::default()
    };
    let trace = plant_of(text, options).run();
    let station = trace.bottleneck.station().unwrap();
    assert_eq!(station.name, "a");
    near(station.engaged, 1.0 / 3.0, 1e-3);
    near(station.engaged_on_shift, 1.0, 1e-3);
}

/// A source that loses its parts is not what limits the line.
#[test]
fn a_source_whose_parts_are_lost_does_not_limit_the_line() {
    let text = "line L {
        part P source a: P every 1 s
        station x { takes 3.5 s }
        sink k sink floor rejects
        route P: a -> x, floor
        route P: x -> k
    }";
    let options = Options {
        parts: Some(500),
        ..Options::default()
    };
    let trace = plant_of(text, options).run();
    assert_eq!(trace.bottleneck.station().unwrap().name, "x");
    let source = &trace.sources[0];
    assert_eq!(source.blocked, 0.0);
    assert!((source.lost - 0.75).abs() < 0.01, "{source:?}");
    // Without the overflow, a part always waits in the source.
    let trace = plant_of(
        &text
            .replace("a -> x, floor", "a -> x")
            .replace("sink floor rejects", ""),
        Options {
            parts: Some(500),
            ..Options::default()
        },
    )
    .run();
    let source = &trace.sources[0];
    assert!(source.blocked > 0.99, "{source:?}");
    assert_eq!(trace.bottleneck.station().unwrap().name, "x");
}

/// Work interrupted by the end of a shift counts toward the next breakdown.
#[test]
fn the_failure_clock_goes_on_after_a_shift() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(1e7))
        .with_station("cell", |station| station.failures = failing(100.0, 1.0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"])
        .shift(0.0, 100.0);
    let trace = builder.run_until(2000.0 * 86_400.0);
    let failures = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Failed)
        .count() as f64;
    near(trace.stations[0].busy_seconds / failures, 100.0, 10.0);
}

/// Parts that arrive off shift wait for the morning, as they are or to be joined.
#[test]
fn nothing_begins_off_shift() {
    const HOUR: f64 = 3600.0;
    let mut builder = Builder::new(&["C", "J", "P"]);
    builder
        .bill("J", &[("C", 1)])
        .source("c", "C", every(10.0 * HOUR, None))
        .source("p", "P", every(10.0 * HOUR, None))
        .station("cell", &["J", "P"], constant(600.0))
        .sink("sink")
        .route("C", &["c", "cell"])
        .route("P", &["p", "cell", "sink"])
        .route("J", &["cell", "sink"])
        .shift(6.0 * HOUR, 14.0 * HOUR);
    let trace = builder.run_until(240.0 * HOUR);
    let started = trace.log.iter().filter(|e| e.what == EventKind::Started);
    let hours: Vec<f64> = started.map(|e| e.time / HOUR % 24.0).collect();
    assert!(hours.len() > 40, "{hours:?}");
    // A part that arrives in the last second is accepted.
    assert!(hours.iter().all(|h| (6.0..=14.0).contains(h)), "{hours:?}");
}

/// A blocked station hands its part over at night, and its time off shift is idle.
#[test]
fn a_blocked_station_hands_over_off_shift() {
    const HOUR: f64 = 3600.0;
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(600.0))
        .conveyor("belt", 1, 2.0 * HOUR)
        .sink("sink")
        .route("Part", &["source", "cell", "belt", "sink"])
        .shift(6.0 * HOUR, 14.0 * HOUR);
    let trace = builder.run_until(24.0 * HOUR);
    let at_night = |e: &&_| -> bool { matches!(e, (EventKind::Finished, t) if *t > 14.0 * HOUR) };
    let events: Vec<(EventKind, f64)> = trace.log.iter().map(|e| (e.what, e.time)).collect();
    // The part on the belt when the shift ends, and the one that the station still had.
    assert_eq!(events.iter().filter(at_night).count(), 2);
    near(trace.stations[0].shares.idle, 16.0 / 24.0, 1e-12);
    assert!(trace.stations[0].shares.blocked > 0.2);
}

/// A repair that goes on at night counts as failed, not as idle.
#[test]
fn a_repair_off_shift_is_failed() {
    const HOUR: f64 = 3600.0;
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(600.0))
        .with_station("cell", |station| station.failures = failing(600.0, 1e8))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"])
        .shift(6.0 * HOUR, 14.0 * HOUR);
    let trace = builder.run_until(240.0 * HOUR);
    let shares = &trace.stations[0].shares;
    assert!(shares.failed > 0.8, "{shares:?}");
    assert!(shares.idle < 0.2, "{shares:?}");
}

/// A join's place for a component is filled while the station works, is blocked, and off shift.
#[test]
fn components_come_at_any_time() {
    let arrivals = |shift: Option<(f64, f64)>, out: f64| {
        let mut builder = Builder::new(&["C", "J"]);
        builder
            .bill("J", &[("C", 1)])
            .source("c", "C", every(1.0, None))
            .station("cell", &["J"], constant(10.0))
            .station("next", &["J"], constant(out))
            .sink("sink")
            .route("C", &["c", "cell"])
            .route("J", &["cell", "next", "sink"]);
        if let Some((from, to)) = shift {
            builder.shift(from, to);
        }
        let cell = builder.node("cell");
        let trace = builder.run_until(100.0);
        let here = trace.log.iter().filter(|e| e.node == cell);
        let times = |what| -> Vec<f64> {
            let here = here.clone().filter(|e| e.what == what);
            here.map(|e| e.time).collect()
        };
        [times(EventKind::Arrived), times(EventKind::Started)]
    };
    // The second component comes while the first part is made, and no third one with it.
    let [arrived, started] = arrivals(None, 1.0);
    assert_eq!(started[..2], [0.0, 10.0]);
    assert_eq!(arrived[..3], [0.0, 1.0, 10.0]);
    // Blocked from 20 to 60.
    let [arrived, started] = arrivals(None, 50.0);
    assert_eq!(started[..3], [0.0, 10.0, 60.0]);
    assert_eq!(arrived[..4], [0.0, 1.0, 10.0, 60.0]);
    let [arrived, started] = arrivals(Some((40.0, 90.0)), 1.0);
    assert_eq!(arrived[0], 0.0);
    assert_eq!(started[0], 40.0);
}
