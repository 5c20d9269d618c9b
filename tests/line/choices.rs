//! Several places of which each part goes to one, parallel stations, and the order of parts in a
//! buffer.

use crate::models::{Builder, Logged, RunLogged, Shift1, constant, every, plant_of};
use linewright::contract::line::{Choice, NodeKind};
use linewright::contract::load;
use linewright::game::Limits;
use linewright::line::abstraction::{Verdict, examine};
use linewright::line::log::EventKind;
use linewright::line::{End, Options};

fn options(parts: u64) -> Options {
    Options {
        parts: Some(parts),
        ..Options::default()
    }
}

fn run(body: &str, parts: u64) -> Logged {
    plant_of(&format!("line L {{ {body} }}"), options(parts)).run_logged()
}

/// The numbers of the parts that an event happened to at a node, with its times.
fn events(body: &str, trace: &Logged, node: &str, what: EventKind) -> Vec<(f64, u64)> {
    let plant = plant_of(&format!("line L {{ {body} }}"), options(1));
    let nodes = &plant.line().nodes;
    let node = nodes.iter().position(|n| n.name == node).expect(node);
    let entries = trace.log.iter();
    entries
        .filter(|e| e.node == node && e.what == what)
        .map(|e| (e.time, e.part.unwrap().0))
        .collect()
}

fn numbers(body: &str, trace: &Logged, node: &str, what: EventKind) -> Vec<u64> {
    let events = events(body, trace, node, what).into_iter();
    events.map(|(_, number)| number).collect()
}

/// A line with two stations that take this long, and this way to them.
fn two(x: &str, y: &str, way: &str) -> String {
    format!(
        "part P source a: P every 1 s
         buffer q capacity 3
         station x {{ takes {x} }} station y {{ takes {y} }}
         sink k
         route P: a -> q -> {way} -> k"
    )
}

#[test]
fn a_part_goes_to_the_first_place_that_is_free() {
    for way in ["x, y", "x, y first free"] {
        let body = two("2.5 s", "2.5 s", way);
        let trace = run(&body, 8);
        let begun = |node| events(&body, &trace, node, EventKind::Started);
        // At 2 s both are at work, so the third part waits until x is done.
        assert_eq!(begun("x")[..3], [(0.0, 1), (2.5, 3), (5.0, 5)]);
        assert_eq!(begun("y")[..3], [(1.0, 2), (3.5, 4), (6.0, 6)]);
    }
    // While the first place suffices, the second one gets nothing.
    let body = two("0.9 s", "1 s", "x, y");
    let trace = run(&body, 50);
    assert_eq!(numbers(&body, &trace, "y", EventKind::Started), [0; 0]);
}

#[test]
fn round_robin_waits_for_the_place_whose_turn_it_is() {
    let body = two("1 s", "4 s", "x, y round robin");
    let trace = run(&body, 20);
    let x = numbers(&body, &trace, "x", EventKind::Started);
    let y = numbers(&body, &trace, "y", EventKind::Started);
    assert_eq!(x[..4], [1, 3, 5, 7]);
    assert_eq!(y[..4], [2, 4, 6, 8]);
    // The slower one decides the pace of both.
    assert_eq!(
        events(&body, &trace, "x", EventKind::Started)[..3],
        [(0.0, 1), (2.0, 3), (5.0, 5)]
    );
}

#[test]
fn the_shortest_queue_is_the_one_with_the_fewest_parts() {
    let body = "part P source a: P every 1 s
        buffer p capacity 9 buffer q capacity 9
        station x { takes 1.5 s } station y { takes 6 s }
        sink k
        route P: a -> p, q shortest queue
        route P: p -> x -> k
        route P: q -> y -> k";
    let trace = run(body, 40);
    let arrived = |node| numbers(body, &trace, node, EventKind::Arrived);
    // Until 4 s, x has always taken the part before.
    assert_eq!(arrived("p")[..4], [1, 2, 3, 4]);
    assert_eq!(arrived("q")[..1], [5]);
    // A place with room is chosen, however long its queue.
    let body = "part P source a: P every 1 s
        station x { takes 9 s } buffer q capacity 9 station y { takes 2 s }
        sink k
        route P: a -> x, q shortest queue
        route P: q -> y -> k
        route P: x -> k";
    let trace = run(body, 12);
    assert_eq!(numbers(body, &trace, "x", EventKind::Started)[..2], [1, 10]);
}

#[test]
fn parts_go_by_probability() {
    let body = "part P source a: P every 1 s sink k sink m sink n
        station s { takes 0.5 s }
        route P: a -> s
        route P: s -> m, n, k by probability 30 %, 0.5";
    let trace = run(body, 4_000);
    let count = |node| numbers(body, &trace, node, EventKind::Finished).len() as f64;
    let total = count("m") + count("n") + count("k");
    let squares = [("m", 0.3), ("n", 0.5), ("k", 0.2)].map(|(node, share)| {
        let expected = share * total;
        (count(node) - expected).powi(2) / expected
    });
    // The 99.9 % quantile of the chi-square distribution with two degrees of freedom.
    assert!(squares.iter().sum::<f64>() < 13.8, "{squares:?}");
}

/// Parts that overtake one another must not change the shares: what was drawn holds for the next
/// part that leaves, whichever it is.
#[test]
fn overtaking_does_not_change_the_probabilities() {
    let body = "part P source a: P every exponential(1 s)
        buffer q capacity 1000 lifo
        station x { takes 4 s } station y { takes 0.1 s }
        sink k
        route P: a -> q -> x, y by probability 20 % -> k";
    let trace = run(body, 20_000);
    let x = numbers(body, &trace, "x", EventKind::Started).len() as f64;
    let share = x / 20_000.0;
    // Three standard errors.
    assert!((share - 0.2).abs() < 0.0085, "{share}");
}

#[test]
fn what_finds_no_room_overflows() {
    // There is room at 0 s, 1 s, 3 s and 6 s.
    let body = "part P source a: P every 1 s
        buffer q capacity 1
        station x { takes 3 s }
        sink lost rejects sink k
        route P: a -> q, lost
        route P: q -> x -> k";
    let trace = run(body, 10);
    assert_eq!(
        numbers(body, &trace, "lost", EventKind::Rejected)[..4],
        [3, 5, 6, 8]
    );
    assert_eq!(trace.end, End::Products);
}

/// Numbers of the first parts that a slow station takes from a buffer with this order.
fn order(discipline: &str) -> Vec<u64> {
    let body = format!(
        "part P {{ property due: 0..9 = 0 }}
         source a: P every 1 s
         buffer q capacity 99 {discipline}
         station x {{ takes 4.4 s }}
         sink k
         route P: a -> q -> x -> k"
    );
    let trace = run(&body, 12);
    numbers(&body, &trace, "x", EventKind::Started)[..4].to_vec()
}

#[test]
fn buffers_have_an_order() {
    // The station takes a part at 0 s, 4.4 s, 8.8 s and 13.2 s, after 1, 5, 9 and 14 have come.
    assert_eq!(order(""), [1, 2, 3, 4]);
    assert_eq!(order("lifo"), [1, 5, 9, 14]);
    // All are alike, so the first one in is the first one out.
    assert_eq!(order("highest due first"), [1, 2, 3, 4]);
    assert_eq!(order("lowest due first"), [1, 2, 3, 4]);
}

#[test]
fn a_property_decides_which_part_leaves_first() {
    let body = |first: &str| {
        format!(
            "part A {{ property due: 0..9 = 7 }} part B {{ property due: 0..9 = 3 }} product B
             source a: A every 1 s limit 4 source b: B every 2 s limit 3
             buffer q capacity 20 {first}
             station x {{ takes 10 s }}
             sink k
             route A: a -> q -> x -> k
             route B: b -> q -> x -> k"
        )
    };
    let types = |first| {
        let body = body(first);
        let plant = plant_of(&format!("line L {{ {body} }}"), options(1));
        let station = plant.line().nodes.iter().position(|n| n.name == "x");
        let mut plant = plant_of(
            &format!("line L {{ {body} }}"),
            Options {
                until: Some(100.0),
                ..Options::default()
            },
        );
        let trace = plant.run_logged();
        let begun = trace
            .log
            .iter()
            .filter(|e| Some(e.node) == station && e.what == EventKind::Started);
        begun
            .map(|e| ["A", "B"][e.part.unwrap().1])
            .collect::<String>()
    };
    assert_eq!(types(""), "ABABAAB");
    assert_eq!(types("lowest due first"), "BBBAAAA");
    assert_eq!(types("highest due first"), "AAAABBB");
}

/// A part that overtakes another takes its turn. Otherwise, the queue in which parts overtake one
/// another would never be served.
#[test]
fn a_part_that_overtakes_keeps_the_turn() {
    let body = "part A part B product B
        source a: A every 1 s source b: B every 0 s
        buffer q capacity 1000 lifo buffer r capacity 2
        station x { takes 2 s }
        sink k
        route A: a -> q -> x -> k
        route B: b -> r -> x -> k";
    let trace = run(body, 100);
    let of = |node| numbers(body, &trace, node, EventKind::Left).len();
    assert!(of("q").abs_diff(of("r")) <= 1, "{} {}", of("q"), of("r"));
}

/// A conveyor with a machine hands over in its own steps, also to one of several places.
#[test]
fn a_belt_serves_several_places() {
    for choice in [
        Choice::FirstFree,
        Choice::ShortestQueue,
        Choice::RoundRobin,
        Choice::Probability {
            shares: vec![0.5, 0.5],
        },
    ] {
        let mut builder = Builder::new(&["P"]);
        builder
            .source("a", "P", every(1.0, None))
            .belt("belt", 3, Shift1::new(3))
            .station("x", &["P"], constant(5.0))
            .station("y", &["P"], constant(3.0))
            .sink("out")
            .route("P", &["a", "belt"])
            .route_choice("P", "belt", &["x", "y"], choice.clone())
            .route("P", &["x", "out"])
            .route("P", &["y", "out"]);
        let trace = builder.run(300);
        assert_eq!(trace.end, End::Products, "{choice:?}: {:?}", trace.findings);
        let processed: Vec<u64> = trace.stations.iter().map(|s| s.processed).collect();
        let expected = match choice {
            Choice::RoundRobin => 150..=150,
            Choice::Probability { .. } => 120..=180,
            _ => 100..=125,
        };
        assert!(
            expected.contains(&processed[0]),
            "{choice:?}: {processed:?}"
        );
    }
}

/// A conveyor with a machine looks for the shortest queue, too.
#[test]
fn a_belt_finds_the_shortest_queue() {
    for (choice, even) in [(Choice::ShortestQueue, true), (Choice::FirstFree, false)] {
        let mut builder = Builder::new(&["P"]);
        builder
            .source("a", "P", every(1.0, None))
            .belt("belt", 3, Shift1::new(3))
            .buffer("p", 1000)
            .buffer("q", 1000)
            .station("x", &["P"], constant(50.0))
            .station("y", &["P"], constant(50.0))
            .sink("out")
            .route("P", &["a", "belt"])
            .route_choice("P", "belt", &["p", "q"], choice)
            .route("P", &["p", "x", "out"])
            .route("P", &["q", "y", "out"]);
        let trace = builder.run_until(400.0);
        let longest: Vec<u64> = trace.buffers.iter().map(|b| b.longest).collect();
        assert_eq!(longest[0].abs_diff(longest[1]) <= 2, even, "{longest:?}");
    }
}

/// Two belts are alternatives; both carry parts, and none is lost.
#[test]
fn a_part_waits_for_one_of_two_belts() {
    let mut builder = Builder::new(&["P"]);
    builder
        .endless("a", "P")
        .belt("b", 2, Shift1::new(2))
        .belt("c", 2, Shift1::new(2))
        .station("x", &["P"], constant(5.0))
        .sink("out")
        .route_choice("P", "a", &["b", "c"], Choice::FirstFree)
        .route("P", &["b", "x", "out"])
        .route("P", &["c", "x"]);
    let trace = builder.run(200);
    assert_eq!(trace.end, End::Products);
    assert!(trace.conveyors.iter().all(|c| c.carried > 80), "{trace:?}");
}

#[test]
fn one_declaration_stands_for_several_stations() {
    let body = "part P source a: P every 1 s
        station x times 3 { takes 2.5 s sets v = 1 }
        station y { takes 0.5 s }
        sink k
        requirement used: busy(x) >= 80 %
        route P: a -> x -> y -> k"
        .replace("part P", "part P { property v: 0..1 = 0 }");
    let plant = plant_of(&format!("line L {{ {body} }}"), options(600));
    let line = plant.line();
    let names: Vec<&str> = line.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["a", "x[1]", "x[2]", "x[3]", "y", "k"]);
    let is_station = |n: &&linewright::contract::line::Node| matches!(n.kind, NodeKind::Station(_));
    assert_eq!(line.nodes.iter().filter(is_station).count(), 4);
    let trace = run(&body, 600);
    let busy = trace.stations[..3].iter().map(|s| s.shares.busy);
    let mean = busy.sum::<f64>() / 3.0;
    assert!((mean - 2.5 / 3.0).abs() < 0.01, "{mean}");
    assert!((trace.requirements[0].value.unwrap() - mean).abs() < 1e-12);
    // They share the probability of the one that was written.
    let body = "part P source a: P every 1 s
        station x times 2 { takes 0.1 s } station y { takes 0.1 s }
        sink k
        route P: a -> x, y by probability 60 % -> k";
    let trace = run(body, 5_000);
    let shares: Vec<f64> = trace
        .stations
        .iter()
        .map(|s| s.processed as f64 / 5_000.0)
        .collect();
    for (share, expected) in shares.iter().zip([0.3, 0.3, 0.4]) {
        assert!((share - expected).abs() < 0.021, "{shares:?}");
    }
}

#[test]
fn a_line_that_stands_still_names_all_places() {
    let body = "part P source a: P on order
        buffer q capacity 1 buffer r capacity 1
        station x { takes 1 s }
        sink k
        route P: a -> x
        route P: x -> q, r
        route P: q -> x
        route P: r -> x";
    let text = format!("line L {{ {body} route P: x -> k }}");
    let files = [("line.lw".to_owned(), text)];
    let (_, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(
        findings.iter().any(|f| f.code.id == "LW402"),
        "a route that is never taken: {findings:?}"
    );
    let body = body.replace(
        "route P: x -> q",
        "route P: x -> k when v = 1 route P: x -> q",
    );
    let body = body.replace("part P", "part P { property v: 0..1 = 0 }");
    let trace = run(&body, 5);
    assert_eq!(trace.end, End::Blocked);
    let message = &trace.findings[0].message;
    assert!(
        message.contains("x waits for room in q or room in r"),
        "{message}"
    );
}

fn decided(body: &str) -> Result<Verdict, String> {
    let files = [("line.lw".to_owned(), format!("line L {{ {body} }}"))];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(!library.lines.is_empty(), "{findings:?}");
    examine(&library.lines[0], &Limits::default(), 1_000)
        .map(|(_, verdict)| verdict)
        .map_err(|reason| reason.why)
}

/// Rework that may fill the cell is a deadlock, unless there is a place where it can overflow.
#[test]
fn an_overflow_prevents_a_deadlock() {
    let line = |way: &str| {
        format!(
            "part P {{ property bad: bool = false }}
             source a: P every 1 s
             station x {{ takes 1 s }} station y {{ takes 1 s }}
             sink floor rejects sink k
             route P: a -> x
             route P: x -> {way} when bad
             route P: x -> k otherwise
             route P: y -> x"
        )
    };
    assert!(!decided(&line("y")).unwrap().holds());
    assert!(decided(&line("y, floor")).unwrap().holds());
    // By turns, a part waits for a place although another one is free.
    assert!(!decided(&line("y, floor round robin")).unwrap().holds());
}

/// A proof leaves out which parts overtake, so this must not matter.
#[test]
fn buffers_with_an_order_are_proved_where_it_does_not_matter() {
    let line = |way: &str| {
        format!(
            "part P {{ property v: 0..1 = 0 }}
             source a: P every 1 s
             buffer q capacity 3 lifo
             station x {{ takes 1 s }} station y {{ takes 1 s }}
             sink k
             route P: a -> q -> {way} -> k"
        )
    };
    assert!(decided(&line("x")).unwrap().holds());
    assert!(decided(&line("x, y")).unwrap().holds());
    let reason = decided(&line("x, y round robin")).unwrap_err();
    assert!(reason.contains("overtake"), "{reason}");
}
