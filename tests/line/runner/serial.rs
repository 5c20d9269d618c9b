//! Serial lines with blocking after service, compared with two independent references: the
//! throughput on which other simulators agree, and the recursion over departure times (max-plus).

use crate::models::{Builder, Exponential, Logged, RunLogged, Work, plant_of, took};
use linewright::contract::distribution::Distribution;
use linewright::line::log::EventKind;
use linewright::line::random::{Purpose, Stream};
use linewright::line::sampler::Sampler;
use linewright::line::{Options, Trace};
use proptest::prelude::*;

/// Five stations, exponential services of mean 1, buffers of three, a source that is never empty.
fn five(parts: u64, seed: u64) -> Trace {
    let mut builder = Builder::new(&["Part"]);
    builder.endless("source", "Part");
    let mut way = vec!["source".to_owned()];
    for i in 0..5 {
        if i > 0 {
            builder.buffer(&format!("buffer{i}"), 3);
            way.push(format!("buffer{i}"));
        }
        let name = format!("station{i}");
        builder.station(
            &name,
            &["Part"],
            Exponential::new(&format!("{seed} {name}")),
        );
        way.push(name);
    }
    builder.sink("sink");
    way.push("sink".to_owned());
    let way: Vec<&str> = way.iter().map(String::as_str).collect();
    builder.route("Part", &way);
    builder
        .plant(Options {
            seed,
            parts: Some(parts),
            ..Options::default()
        })
        .run()
}

#[test]
fn throughput_of_five_stations() {
    let trace = five(250_000, 1);
    let throughput = trace.products as f64 / trace.seconds;
    // SimPy, salabim, Ciw, NeXosim and a recursion all give 0.730.
    assert!((throughput / 0.730 - 1.0).abs() < 0.01, "{throughput}");
    let first = &trace.stations[0].shares;
    assert!(first.starved < 1e-9, "the source is never empty");
    let last = &trace.stations[4].shares;
    assert!(last.blocked < 1e-9, "the sink is never full");
}

/// Departure times by the recursion for blocking after service: part `n` begins at station `i` when
/// it has left station `i - 1` and its predecessor has left station `i`; it leaves when it is done
/// and the room behind, a buffer of `b` and a station, is available: when part `n - b - 1` has left
/// station `i + 1`. A buffer is entered at once, so leaving station `i - 1` means entering the
/// buffer, and the beginning waits for the station.
fn recursion(services: &[Vec<f64>], buffers: &[usize]) -> Vec<Vec<f64>> {
    let stations = services.len();
    let parts = services[0].len();
    let mut left = vec![vec![0.0_f64; parts]; stations];
    for n in 0..parts {
        for i in 0..stations {
            let came = if i == 0 { 0.0 } else { left[i - 1][n] };
            let free = if n == 0 { 0.0 } else { left[i][n - 1] };
            let done = came.max(free) + services[i][n];
            let room = match buffers.get(i) {
                Some(&buffer) if n > buffer => left[i + 1][n - buffer - 1],
                _ => 0.0,
            };
            left[i][n] = done.max(room);
        }
    }
    left
}

fn check_against_recursion(stations: usize, buffers: &[usize], parts: usize, seed: u64) {
    let mut stream = Stream::from_seed(seed);
    let services: Vec<Vec<f64>> = (0..stations)
        .map(|_| (0..parts).map(|_| stream.exponential(1.0)).collect())
        .collect();
    let mut builder = Builder::new(&["Part"]);
    builder.endless("source", "Part");
    let mut way = vec!["source".to_owned()];
    for (i, times) in services.iter().enumerate() {
        let name = format!("station{i}");
        let times = times.clone();
        let mut rest = Stream::from_seed(seed + 1);
        builder.station(
            &name,
            &["Part"],
            Work(
                move |call: u64, _: &mut [f64]| {
                    // The source continues after the parts under test.
                    took(
                        times
                            .get(call as usize - 1)
                            .copied()
                            .unwrap_or_else(|| rest.unit()),
                    )
                },
                0,
            ),
        );
        way.push(name);
        if buffers.get(i).is_some_and(|&buffer| buffer > 0) {
            let name = format!("buffer{i}");
            builder.buffer(&name, buffers[i] as u32);
            way.push(name);
        }
    }
    builder.sink("sink");
    way.push("sink".to_owned());
    let way: Vec<&str> = way.iter().map(String::as_str).collect();
    builder.route("Part", &way);
    let trace = builder.run(parts as u64);
    let stations = (0..stations).map(|i| builder.node(&format!("station{i}")));
    let stations: Vec<usize> = stations.collect();
    check_departures(&trace, &stations, &recursion(&services, buffers));
}

/// All departures from these stations are at these times exactly.
fn check_departures(trace: &Logged, stations: &[usize], expected: &[Vec<f64>]) {
    for (node, expected) in stations.iter().zip(expected) {
        let left: Vec<f64> = trace
            .log
            .iter()
            .filter(|e| e.node == *node && e.what == EventKind::Left)
            .map(|e| e.time)
            .take(expected.len())
            .collect();
        assert_eq!(&left, expected, "node {node}: every time exactly");
    }
}

#[test]
fn departures_equal_the_recursion_exactly() {
    check_against_recursion(5, &[3, 3, 3, 3], 2000, 5);
    check_against_recursion(4, &[0, 2, 0], 2000, 6);
}

/// A distribution in the language, and as it is meant.
fn distribution(random: &mut Stream) -> (String, Distribution) {
    let mut tenths = |low: u64, high: u64| (low + random.below(high - low)) as f64 / 10.0;
    let (low, mode, high) = (tenths(1, 10), tenths(10, 20), tenths(21, 40));
    match random.below(6) {
        0 => (format!("{mode} s"), Distribution::Constant(mode)),
        1 => (
            format!("uniform({low} s, {high} s)"),
            Distribution::Uniform { low, high },
        ),
        2 => (
            format!("triangular({low} s, {mode} s, {high} s)"),
            Distribution::Triangular { low, mode, high },
        ),
        3 => (
            format!("lognormal({mode} s, {low} s)"),
            Distribution::Lognormal {
                mean: mode,
                deviation: low,
            },
        ),
        4 => (
            format!("erlang(3, {mode} s)"),
            Distribution::Erlang {
                stages: 3,
                mean: mode,
            },
        ),
        _ => (
            format!("exponential({mode} s)"),
            Distribution::Exponential { mean: mode },
        ),
    }
}

/// 200 lines of two to eight stations that are given by their times, with buffers of up to five.
#[test]
fn departures_of_drawn_times_equal_the_recursion() {
    const PARTS: usize = 150;
    for seed in 1..=200 {
        let mut random = Stream::from_seed(seed);
        let count = 2 + random.below(7) as usize;
        let (mut places, mut way) = (Vec::new(), vec!["source".to_owned()]);
        let (mut services, mut buffers) = (Vec::new(), Vec::new());
        for i in 0..count {
            let (text, time) = distribution(&mut random);
            places.push(format!("station s{i} {{ takes {text} }}"));
            way.push(format!("s{i}"));
            let stream = Stream::new(seed, Purpose::Service, &format!("s{i}.P"));
            let mut sampler = Sampler::new(&time, stream);
            services.push((0..PARTS).map(|_| sampler.draw()).collect());
            if i + 1 < count {
                let capacity = random.below(6) as usize;
                if capacity > 0 {
                    places.push(format!("buffer b{i} capacity {capacity}"));
                    way.push(format!("b{i}"));
                }
                buffers.push(capacity);
            }
        }
        let (places, way) = (places.join(" "), way.join(" -> "));
        let text = format!(
            "line L {{ part P source source: P every 0 s {places} sink k route P: {way} -> k }}"
        );
        let options = Options {
            seed,
            parts: Some(PARTS as u64),
            ..Options::default()
        };
        let mut plant = plant_of(&text, options);
        let nodes = plant.line().nodes.iter().enumerate();
        let stations = nodes.filter(|(_, node)| node.name.starts_with('s'));
        let stations: Vec<usize> = stations
            .filter(|(_, node)| node.name != "source")
            .map(|(index, _)| index)
            .collect();
        assert_eq!(stations.len(), count);
        check_departures(
            &plant.run_logged(),
            &stations,
            &recursion(&services, &buffers),
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn departures_equal_the_recursion_on_any_line(
        buffers in prop::collection::vec(0_usize..5, 1..6),
        seed in 0_u64..1_000_000,
    ) {
        check_against_recursion(buffers.len() + 1, &buffers, 200, seed);
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let text = |seed| format!("{:?}", five(2000, seed));
    assert_eq!(text(3), text(3));
    assert_ne!(text(3), text(4));
}
