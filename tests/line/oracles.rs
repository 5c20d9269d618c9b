//! Runs against known results: queueing formulas, Markov chains, and laws of production lines.
//!
//! Each case runs several seeds. The mean must differ from the theory by at most four standard
//! errors. The seeds are fixed, so a case either always passes or never does.

use crate::models::plant_of;
use linewright::line::{Estimate, Options, Trace};

const SEEDS: u64 = 8;

struct Case {
    name: &'static str,
    text: String,
    parts: u64,
    measure: fn(&Trace) -> f64,
    theory: f64,
}

fn per_second(trace: &Trace) -> f64 {
    trace.throughput_per_hour / 3600.0
}

fn sojourn(trace: &Trace) -> f64 {
    trace.lead_time.mean
}

/// A line of one part type, with these places, along this route.
fn line(places: &str, route: &str) -> String {
    format!("line L {{ part P sink out {places} route P: {route} -> out }}")
}

/// A queue with one server: times between arrivals, capacity of the queue, and the station.
fn queue(arrivals: &str, capacity: u32, station: &str) -> String {
    let places = format!(
        "source rack: P every {arrivals} buffer queue capacity {capacity} station server {{ {station} }}"
    );
    line(&places, "rack -> queue -> server")
}

/// Stations in series with buffers of these capacities between them; a capacity of 0 is none. The
/// source always has a part.
fn series(stations: &[&str], capacities: &[u32]) -> String {
    let mut places = vec!["source rack: P every 0 s".to_owned()];
    let mut route = vec!["rack".to_owned()];
    for (at, station) in stations.iter().enumerate() {
        if at > 0 && capacities[at - 1] > 0 {
            places.push(format!("buffer b{at} capacity {}", capacities[at - 1]));
            route.push(format!("b{at}"));
        }
        places.push(format!("station s{at} {{ {station} }}"));
        route.push(format!("s{at}"));
    }
    line(&places.join(" "), &route.join(" -> "))
}

/// Four stations of 2 s, and a constant number of parts in the line (the Penny Fab of Hopp and
/// Spearman, Factory Physics, section 7.3).
fn penny_fab(time: &str, parts: u32) -> String {
    let mut places = vec![format!(
        "source rack: P every 0 s, at most {parts} in the line"
    )];
    let mut route = vec!["rack".to_owned()];
    for n in 1..=4 {
        places.push(format!(
            "buffer b{n} capacity 10 station s{n} {{ takes {time} }}"
        ));
        route.push(format!("b{n} -> s{n}"));
    }
    line(&places.join(" "), &route.join(" -> "))
}

/// Throughput of two exponential machines with these rates, and a buffer between them: a birth and
/// death process.
fn two_machines(first: f64, second: f64, buffer: i32) -> f64 {
    let (x, n) = (first / second, buffer + 2);
    second * x * (1.0 - x.powi(n)) / (1.0 - x.powi(n + 1))
}

/// Probability that all of `servers` servers are busy if `load` of them are on average and nobody
/// waits (Erlang's loss formula).
fn erlang_b(servers: u32, load: f64) -> f64 {
    (1..=servers).fold(1.0, |lost, n| load * lost / (f64::from(n) + load * lost))
}

/// Probability that an arriving part has to wait for one of `servers` servers.
fn erlang_c(servers: u32, load: f64) -> f64 {
    let lost = erlang_b(servers, load);
    let used = load / f64::from(servers);
    lost / (1.0 - used * (1.0 - lost))
}

/// Two types that one server works on, of which A has priority.
fn priorities(product: &str, work: &str) -> String {
    format!(
        "line L {{
            part A {{ property urgency: 0..1 = 1 }} part B {{ property urgency: 0..1 = 0 }}
            product {product}
            source a: A every exponential(1 s / 0.3) source b: B every exponential(1 s / 0.4)
            buffer queue capacity 4000 highest urgency first
            station server {{ {work} }}
            sink out
            route A: a -> queue -> server -> out
            route B: b -> queue -> server -> out
        }}"
    )
}

/// Work with the means 0.5 s and 1 s and the mean squares 1/3 s^2 and 2 s^2.
const GENERAL_WORK: &str = "takes uniform(0 s, 1 s) a A takes lognormal(1 s, 1 s) a B";

/// Mean sojourn of parts that join the shorter of two queues, each before a server with rate 1:
/// the stationary distribution of a Markov chain with the numbers of parts as its state, by
/// iteration of the uniformized chain.
fn shortest_queue(arrivals: f64) -> f64 {
    const SIZE: usize = 50;
    let total = arrivals + 2.0;
    let mut state = vec![0.0; SIZE * SIZE];
    state[0] = 1.0;
    for _ in 0..12_000 {
        let mut next = vec![0.0; SIZE * SIZE];
        for i in 0..SIZE {
            for j in 0..SIZE {
                let here = state[i * SIZE + j] / total;
                let first = i.saturating_sub(1) <= j.saturating_sub(1);
                let (to_i, to_j) = if first { (i + 1, j) } else { (i, j + 1) };
                next[to_i.min(SIZE - 1) * SIZE + to_j.min(SIZE - 1)] += here * arrivals;
                next[i.saturating_sub(1) * SIZE + j] += here;
                next[i * SIZE + j.saturating_sub(1)] += here;
            }
        }
        state = next;
    }
    let parts = state.iter().enumerate();
    let mean: f64 = parts
        .map(|(at, p)| (at / SIZE + at % SIZE) as f64 * p)
        .sum();
    mean / arrivals
}

fn lost(trace: &Trace) -> f64 {
    trace.parts.rejected as f64 / (trace.parts.rejected + trace.products) as f64
}

#[test]
fn known_results_are_reproduced() {
    let cases = [
        Case {
            name: "M/D/1",
            text: queue("exponential(1 s)", 4000, "takes 0.8 s"),
            parts: 60_000,
            measure: sojourn,
            theory: 0.8 + 0.64 / (2.0 * 0.2),
        },
        Case {
            name: "M/M/1",
            text: queue("exponential(4 s)", 4000, "takes exponential(3 s)"),
            parts: 60_000,
            measure: sojourn,
            theory: 12.0,
        },
        Case {
            name: "M/M/1, 95th percentile",
            text: queue("exponential(4 s)", 4000, "takes exponential(3 s)"),
            parts: 60_000,
            measure: |trace| trace.lead_time.p95,
            theory: 12.0 * 20.0_f64.ln(),
        },
        Case {
            // Pollaczek and Khinchine; an Erlang distribution of k stages has the squared
            // coefficient of variation 1/k.
            name: "M/E3/1",
            text: queue("exponential(1 s)", 4000, "takes erlang(3, 0.7 s)"),
            parts: 60_000,
            measure: sojourn,
            theory: 0.7 + 0.49 * (1.0 + 1.0 / 3.0) / (2.0 * 0.3),
        },
        Case {
            name: "M/G/1 with two times",
            text: queue(
                "exponential(1 s)",
                4000,
                "takes discrete(0.5 s: 80 %, 1.5 s: 20 %)",
            ),
            parts: 60_000,
            measure: sojourn,
            theory: 0.7 + (0.8 * 0.25 + 0.2 * 2.25) / (2.0 * 0.3),
        },
        Case {
            // The completion time C has the mean T (1 + r/m) and the variance 2 r^2 T/m.
            name: "M/G/1 with breakdowns",
            text: queue(
                "exponential(1 s)",
                4000,
                "takes 0.6 s failures mtbf 5 s mttr 1 s",
            ),
            parts: 60_000,
            measure: sojourn,
            theory: 0.72 + (0.72 * 0.72 + 0.24) / (2.0 * 0.28),
        },
        Case {
            // A part waits in the source, and one more is due: K = 2 + 3.
            name: "M/M/1/5",
            text: queue("exponential(1 s)", 2, "takes exponential(1 s)"),
            parts: 60_000,
            measure: per_second,
            theory: 5.0 / 6.0,
        },
        Case {
            name: "M/M/1/8",
            text: queue("exponential(1 s)", 5, "takes exponential(0.8 s)"),
            parts: 60_000,
            measure: per_second,
            theory: 1.0 - 0.2 * 0.8_f64.powi(8) / (1.0 - 0.8_f64.powi(9)),
        },
        Case {
            // What finds no room is lost, so K is the server and the queue.
            name: "M/M/1/4 with loss",
            text: line(
                "source rack: P every exponential(1 s) buffer queue capacity 3
                 station server { takes exponential(0.9 s) } sink lost rejects
                 route P: rack -> queue, lost",
                "queue -> server",
            ),
            parts: 60_000,
            measure: lost,
            theory: 0.1 * 0.9_f64.powi(4) / (1.0 - 0.9_f64.powi(5)),
        },
        Case {
            name: "M/M/3",
            text: queue("exponential(1 s)", 4000, "takes exponential(2.4 s)")
                .replace("station server", "station server times 3"),
            parts: 60_000,
            measure: sojourn,
            theory: 2.4 + erlang_c(3, 2.4) / (3.0 / 2.4 - 1.0),
        },
        Case {
            // The loss does not depend on the distribution of the work.
            name: "M/G/2/2 with loss",
            text: line(
                "source rack: P every exponential(1 s)
                 station server times 2 { takes lognormal(1.5 s, 2 s) } sink lost rejects
                 route P: rack -> server, lost",
                "server",
            ),
            parts: 60_000,
            measure: lost,
            theory: erlang_b(2, 1.5),
        },
        Case {
            // Cobham 1954: the mean wait of the first class is R / (1 - r1), with the mean rest of
            // the work in progress R = (l1 + l2) E[S^2] / 2.
            name: "M/M/1 with priorities, first class",
            text: priorities("A", "takes exponential(1 s)"),
            parts: 40_000,
            measure: sojourn,
            theory: 1.0 + 0.7 / 0.7,
        },
        Case {
            name: "M/M/1 with priorities, second class",
            text: priorities("B", "takes exponential(1 s)"),
            parts: 40_000,
            measure: sojourn,
            theory: 1.0 + 0.7 / (0.7 * 0.3),
        },
        Case {
            // R = (0.3 / 3 + 0.4 * 2) / 2 = 0.45 s, and the loads are 0.15 and 0.4.
            name: "M/G/1 with priorities, first class",
            text: priorities("A", GENERAL_WORK),
            parts: 40_000,
            measure: sojourn,
            theory: 0.5 + 0.45 / 0.85,
        },
        Case {
            name: "M/G/1 with priorities, second class",
            text: priorities("B", GENERAL_WORK),
            parts: 40_000,
            measure: sojourn,
            theory: 1.0 + 0.45 / (0.85 * 0.45),
        },
        Case {
            // By a truncated Markov chain. Parts in work do not count as queueing.
            name: "two queues, the shorter one is joined",
            text: "line L {
                part P source rack: P every exponential(0.6 s)
                station x { takes exponential(1 s) } station y { takes exponential(1 s) }
                buffer p capacity 400 buffer q capacity 400
                sink out
                route P: rack -> p, q shortest queue
                route P: p -> x -> out
                route P: q -> y -> out
            }"
            .to_owned(),
            parts: 60_000,
            measure: sojourn,
            theory: shortest_queue(1.0 / 0.6),
        },
        Case {
            name: "two exponential machines",
            text: series(&["takes exponential(1 s)"; 2], &[0]),
            parts: 60_000,
            measure: per_second,
            theory: 2.0 / 3.0,
        },
        Case {
            name: "two exponential machines, five places",
            text: series(&["takes exponential(1 s)"; 2], &[5]),
            parts: 60_000,
            measure: per_second,
            theory: 7.0 / 8.0,
        },
        Case {
            name: "two different exponential machines",
            text: series(
                &["takes exponential(0.8 s)", "takes exponential(1 s)"],
                &[4],
            ),
            parts: 60_000,
            measure: per_second,
            theory: two_machines(1.25, 1.0, 4),
        },
        Case {
            // Two flows are joined as soon as one part of each has come.
            name: "kitting",
            text: "line L {
                part A part B part P from 1 A, 1 B
                source a: A every exponential(1 s) source b: B every exponential(1 s)
                buffer qa capacity 1 buffer qb capacity 1
                station kit { takes 0 s }
                sink out
                route A: a -> qa -> kit route B: b -> qb -> kit route P: kit -> out
            }"
            .to_owned(),
            parts: 60_000,
            measure: per_second,
            theory: 8.0 / 9.0,
        },
        Case {
            // By a max-plus recursion: the interval is .8586 +- .0019.
            name: "two machines with breakdowns",
            text: series(&["takes 1 s failures mtbf 100 s mttr 10 s"; 2], &[10]),
            parts: 60_000,
            measure: per_second,
            theory: 0.8586,
        },
        Case {
            // The stationary distribution of a Markov chain of 1,189 states.
            name: "five exponential machines",
            text: series(&["takes exponential(1 s)"; 5], &[3; 4]),
            parts: 60_000,
            measure: per_second,
            theory: 0.729_947_9,
        },
        Case {
            // Pichitlamken, Nelson and Hong 2006: 12 and 8 places, of which one is the server.
            name: "three exponential machines",
            text: series(
                &[
                    "takes exponential(1 s / 6)",
                    "takes exponential(1 s / 7)",
                    "takes exponential(1 s / 7)",
                ],
                &[11, 7],
            ),
            parts: 60_000,
            measure: per_second,
            theory: 5.776_122,
        },
        Case {
            name: "practical worst case of the Penny Fab",
            text: penny_fab("exponential(2 s)", 6),
            parts: 60_000,
            measure: per_second,
            theory: 6.0 / 9.0 * 0.5,
        },
    ];
    for case in cases {
        let mut values = Vec::new();
        for seed in 1..=SEEDS {
            let options = Options {
                seed,
                parts: Some(case.parts),
                ..Options::default()
            };
            values.push((case.measure)(&plant_of(&case.text, options).run()));
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        let error = (squares / (count - 1.0) / count).sqrt();
        let off = (mean - case.theory).abs() / error;
        println!(
            "{}: {mean:.5} +- {error:.5}, theory {:.5}",
            case.name, case.theory
        );
        assert!(
            off < 4.0,
            "{}: {mean}, theory {}, {off} standard errors",
            case.name,
            case.theory
        );
    }
}

/// Without chance, the results are exact but for the time in which the line fills.
#[test]
fn deterministic_laws_are_exact() {
    for (parts, rate) in [(1, 1.0 / 8.0), (2, 2.0 / 8.0), (4, 0.5), (6, 0.5)] {
        let options = Options {
            parts: Some(20_000),
            ..Options::default()
        };
        let trace = plant_of(&penny_fab("2 s", parts), options).run();
        assert!(
            (per_second(&trace) / rate - 1.0).abs() < 2e-4,
            "{parts}: {}",
            per_second(&trace)
        );
    }
    // Three shifts of 8 h at 7 s: interrupted work continues the next day.
    let places = "source rack: P every 0 s station s { takes 7 s } shift 6 h to 14 h";
    let options = Options {
        until: Some(3.0 * 86_400.0),
        ..Options::default()
    };
    let trace = plant_of(&line(places, "rack -> s"), options).run();
    assert_eq!(trace.products, 12_342);
}

/// Short runs of a line that starts empty are biased; a warm-up removes the bias.
#[test]
fn a_warm_up_removes_the_bias_of_short_runs() {
    let text = series(&["takes exponential(1 s)"; 5], &[3; 4]);
    let theory = 0.729_947_9;
    let mean = |parts, warm_up| {
        let mut plant = plant_of(
            &text,
            Options {
                parts: Some(parts),
                warm_up,
                ..Options::default()
            },
        );
        let rates = (1..=300).map(|seed| per_second(&plant.run_seeded(seed)));
        rates.sum::<f64>() / 300.0
    };
    let (biased, unbiased) = (mean(200, 0.0) / theory, mean(2000, 300.0) / theory);
    assert!(biased < 0.98, "{biased}");
    assert!((unbiased - 1.0).abs() < 0.005, "{unbiased}");
}

/// A 95 % interval contains the true throughput in 95 % of all experiments. With 1,000 experiments,
/// the number that do has a standard deviation of 0.7 %.
#[test]
fn intervals_contain_the_truth_as_often_as_they_say() {
    let text = series(&["takes exponential(1 s)"; 2], &[5]);
    let theory = 7.0 / 8.0;
    let mut plant = plant_of(
        &text,
        Options {
            until: Some(600.0),
            warm_up: 200.0,
            ..Options::default()
        },
    );
    let mut covered = 0;
    for experiment in 0..1_000 {
        let rates = (0..10).map(|run| per_second(&plant.run_seeded(1 + 10 * experiment + run)));
        let estimate = Estimate::of(&rates.collect::<Vec<_>>()).unwrap();
        let half_width = estimate.half_width.unwrap();
        covered += usize::from((estimate.mean - theory).abs() <= half_width);
    }
    assert!((930..=970).contains(&covered), "{covered} of 1000");
    println!("{covered} of 1000 intervals contain the throughput");
}
