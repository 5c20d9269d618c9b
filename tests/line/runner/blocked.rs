//! Lines that stand still, and their findings.

use crate::attack::text::Chance;
use crate::models::{Builder, Shift1, constant, every, plant_of, refusing};
use linewright::contract::line::{InitialValue, NodeKind, Supply};
use linewright::contract::load;
use linewright::contract::machine::RealExpr;
use linewright::deadline::Deadline;
use linewright::diagnostics::{Diagnostic, Severity};
use linewright::line::{Bottleneck, End, Options, Plant, Trace};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Duration;

fn text(trace: &Trace) -> String {
    let line = |f: &Diagnostic| {
        let help = f.help.as_deref().unwrap_or("");
        format!("{}: {}\n  {help}", f.code.id, f.message)
    };
    let lines: Vec<_> = trace.findings.iter().map(line).collect();
    lines.join("\n")
}

#[test]
fn a_circle_of_full_places() {
    let mut builder = Builder::new(&["Raw", "Done"]);
    builder
        .bill("Done", &[("Raw", 1)])
        .property("Raw", "again", InitialValue::Number(1.0))
        .endless("source", "Raw")
        .conveyor("belt_in", 2, 1.0)
        .station("cell", &["Raw"], constant(2.0))
        .conveyor("belt_out", 2, 1.0)
        .station("camera", &["Raw"], constant(1.0))
        .sink("sink")
        .route("Raw", &["source", "belt_in", "cell", "belt_out", "camera"])
        .route_if("Raw", "camera", "belt_in", Some(RealExpr::Property(0)))
        .route("Raw", &["camera", "sink"]);
    let trace = builder.run(3);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"
    LW403: the line can no longer advance at 0:00:10, with 0 of 3 products made: belt_in waits for cell, cell waits for room on belt_out, belt_out waits for camera, camera waits for room on belt_in
      Keep the cycle from filling up: add room in belt_in, admit fewer parts at a time, or add another route out of it.
    ");
}

#[test]
fn a_circle_is_found_behind_contracted_belts_too() {
    let mut builder = Builder::new(&["Raw"]);
    builder
        .property("Raw", "again", InitialValue::Number(1.0))
        .endless("source", "Raw")
        .belt("belt_in", 2, Shift1::new(2))
        .station("cell", &["Raw"], constant(2.0))
        .belt("belt_out", 2, Shift1::new(2))
        .sink("sink")
        .route("Raw", &["source", "belt_in", "cell", "belt_out"])
        .route_if("Raw", "belt_out", "cell", Some(RealExpr::Property(0)))
        .route("Raw", &["belt_out", "sink"]);
    let trace = builder.run_until(1e6);
    assert_eq!(trace.end, End::Blocked);
    assert!(trace.seconds < 100.0);
    insta::assert_snapshot!(text(&trace), @"
    LW403: the line can no longer advance at 0:00:14: cell waits for room on belt_out, belt_out waits for cell
      Keep the cycle from filling up: add room in belt_out, admit fewer parts at a time, or add another route out of it.
    ");
}

#[test]
fn a_component_that_never_comes() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .store("warehouse", &[("Brick", 100)])
        .source("printer", "Printed", every(5.0, Some(3)))
        .station("cell", &["Product"], constant(1.0))
        .sink("sink")
        .route("Brick", &["warehouse", "cell"])
        .route("Printed", &["printer", "cell"])
        .route("Product", &["cell", "sink"]);
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @r#"
    LW403: the line can no longer advance at 0:00:11, with 3 of 5 products made: warehouse waits for cell, cell waits for a part of type Printed, but printer has made all 3 of its limit
      Make sure that enough of the missing parts are made or stocked and that rejected parts are reordered, or require fewer products.
    "#);
}

#[test]
fn a_component_behind_what_is_not_wanted() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .store("warehouse", &[("Brick", 100)])
        .source("printer", "Printed", every(60.0, None))
        .conveyor("belt", 4, 1.0)
        .station("cell", &["Product"], constant(1.0))
        .sink("sink")
        .route("Brick", &["warehouse", "belt", "cell"])
        .route("Printed", &["printer", "belt", "cell"])
        .route("Product", &["cell", "sink"]);
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"
    LW403: the line can no longer advance at 0:02:00, with 1 of 5 products made: belt waits for cell, cell waits for a part of type Printed, which is at printer, printer waits for room on belt
      Keep the cycle from filling up: add room in belt, admit fewer parts at a time, or add another route out of it.
    ");
}

#[test]
fn rejected_parts_that_nobody_orders_again() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station("cell", &["Part"], refusing(1.0, |call| call == 2))
        .sink("sink")
        .route("Part", &["printer", "cell", "sink"]);
    let trace = builder.run(5);
    assert_eq!((trace.end, trace.products), (End::Blocked, 4));
    insta::assert_snapshot!(text(&trace), @"
    LW405: cell refused Part 2 at 0:00:01: turn: the assumption gripped does not hold in step 3
      `turn` is a component of the machine cell_machine. Compare the rule with the properties of the part, and with the inputs that the machine gives to `turn`.
    LW403: the line can no longer advance at 0:00:04, with 4 of 5 products made: nothing is left to do: printer has made all 5 that were ordered, and 1 part was rejected and not ordered again
      Let a source make more parts (a sink that rejects parts can order replacements), or require fewer products.
    ");
}

#[test]
fn a_part_without_a_way() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "good", InitialValue::Number(0.0))
        .endless("source", "Part")
        .station("cell", &["Part"], constant(1.0))
        .sink("sink")
        .route("Part", &["source", "cell"])
        .route_if("Part", "cell", "sink", Some(RealExpr::Property(0)));
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"
    LW402: Part 1 has no way onward from cell at 0:00:01
      After the other routes for Part, add one without a condition.
    LW403: the line can no longer advance at 0:00:01, with 0 of 5 products made: source waits for cell, cell holds Part 1, which has no way onward
      Give every part a route onward from every place that it can reach.
    ");
}

#[test]
fn a_circle_without_time_ends() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(1)))
        .buffer("a", 1)
        .buffer("b", 1)
        .sink("sink")
        .route("Part", &["source", "a", "b", "a"]);
    let trace = builder.run(1);
    assert_eq!(trace.end, End::NoProgress);
    insta::assert_snapshot!(text(&trace), @"
    LW403: the line makes no progress (livelock): at 0:00:00, parts keep moving without any time passing
      Look for a source without an interval, a cycle of routes without a station, or a station that refuses every part and has it reordered.
    ");
}

#[test]
fn a_station_that_refuses_everything_ends() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station("cell", &["Part"], refusing(1.0, |_| true))
        .sink("sink")
        .scrap("scrap", Some("printer"))
        .route("Part", &["printer", "cell", "sink"]);
    let trace = builder.run(1);
    assert_eq!(trace.end, End::NoProgress);
    assert_eq!(trace.findings.len(), 2);
    assert!(trace.violations.len() == 1000 && trace.violation_count > 1000);
}

#[test]
fn a_line_that_only_makes_scrap_ends() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station("cell", &["Part"], constant(1.0))
        .scrap("scrap", Some("printer"))
        .route("Part", &["printer", "cell", "scrap"]);
    let options = Options {
        parts: Some(1),
        ..Options::default()
    };
    let trace = builder.plant(options).run();
    assert_eq!(trace.end, End::NoProgress);
    insta::assert_snapshot!(text(&trace), @"
    LW403: the line makes no progress: it made no product in 5000000 events; 1 was asked for
      Find the rule that refuses the parts, or the reason why all are rejected; --until ends a run at a given time.
    ");
}

#[test]
fn a_deadline_of_the_real_clock_ends_a_run() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station("cell", &["Part"], constant(1.0))
        .scrap("scrap", Some("printer"))
        .route("Part", &["printer", "cell", "scrap"]);
    let options = Options {
        until: Some(4e9),
        deadline: Deadline::from_now(Duration::ZERO),
        ..Options::default()
    };
    let trace = builder.plant(options).run();
    assert_eq!(trace.end, End::GaveUp);
    assert!(trace.events < 100);
    assert_eq!(trace.findings[0].code.id, "LW204");
}

#[test]
fn for_a_time_only_a_starved_line_is_no_error() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .store("warehouse", &[("Brick", 100)])
        .source("printer", "Printed", every(5.0, Some(3)))
        .station("cell", &["Product"], constant(1.0))
        .sink("sink")
        .route("Brick", &["warehouse", "cell"])
        .route("Printed", &["printer", "cell"])
        .route("Product", &["cell", "sink"]);
    let trace = builder.run_until(1000.0);
    assert_eq!((trace.end, trace.seconds), (End::Time, 1000.0));
    assert_eq!(trace.findings[0].severity, Severity::Note);
    insta::assert_snapshot!(text(&trace), @r#"
    LW403: nothing moves any more from 0:00:11 on: warehouse waits for cell, cell waits for a part of type Printed, but printer has made all 3 of its limit
      Make sure that enough of the missing parts are made or stocked and that rejected parts are reordered, or require fewer products.
    "#);
}

/// A source that its limit keeps from making a part is named: the cause may be the limit.
#[test]
fn a_source_paused_by_its_limit_is_named() {
    let mut builder = Builder::new(&["Raw", "Toy"]);
    builder
        .bill("Toy", &[("Raw", 2)])
        .endless("source", "Raw")
        .conveyor("belt", 4, 1.0)
        .station("cell", &["Toy"], constant(2.0))
        .sink("sink")
        .route("Raw", &["source", "belt", "cell"])
        .route("Toy", &["cell", "sink"]);
    let nodes = &mut builder.line.nodes;
    let source = nodes.iter_mut().find(|n| n.name == "source");
    if let NodeKind::Source { most, .. } = &mut source.expect("a source").kind {
        *most = Some(1);
    }
    let trace = builder.run(3);
    assert_eq!(trace.end, End::Blocked);
    let finding = &trace.findings[0];
    let note = "source makes no part while 1 Raw is in the line or held by a source";
    assert!(finding.notes.iter().any(|n| n == note), "{finding:?}");
}

/// Rework that fills the loop of `x` and `y`, and other parts of the line that go on.
const LOOP: &str = "part P { property rounds: 0..9 = 0 }
    station x { takes 2 s sets rounds = min(rounds + 1, 9) }
    station y { takes 1 s }
    sink k
    route P: a -> x
    route P: x -> y when rounds <= 2
    route P: x -> k otherwise
    route P: y -> x";

fn run_text(body: &str, parts: Option<u64>, until: Option<f64>) -> Trace {
    let options = Options {
        parts,
        until,
        ..Options::default()
    };
    plant_of(&format!("line L {{ {body} }}"), options).run()
}

/// The deadlock that a run found, as places and the time since when it lasts.
fn deadlock(trace: &Trace) -> Option<(Vec<&str>, f64)> {
    match &trace.bottleneck {
        Bottleneck::Deadlock(deadlock) => {
            let places = deadlock.places.iter().map(String::as_str);
            Some((places.collect(), deadlock.since))
        }
        _ => None,
    }
}

/// The first part comes back to `x` while the second is there: from 3 s on, nothing but the source
/// moves, whose parts are lost.
#[test]
fn a_deadlock_is_found_while_a_source_overflows() {
    let overflow = LOOP.replace(
        "route P: a -> x",
        "buffer q capacity 3 sink lost rejects
         source a: P every 2 s
         route P: a -> q, lost
         route P: q -> x",
    );
    let trace = run_text(&overflow, None, Some(7200.0));
    assert_eq!((trace.end, trace.products), (End::Time, 0));
    assert_eq!(deadlock(&trace), Some((vec!["x", "y"], 4.0)));
    insta::assert_snapshot!(text(&trace), @"
    LW403: parts of the line can never move again (deadlock since 0:00:04), although the rest goes on: x waits for y, y waits for x
      Let fewer parts into the line than fill the cycle, or add another route out of it.
    ");
    // A run that waits for products ends long before five million events.
    let trace = run_text(&overflow, Some(10), None);
    assert_eq!((trace.end, trace.products), (End::Blocked, 0));
    assert!(trace.events < 200_000);
    assert_eq!(deadlock(&trace), Some((vec!["x", "y"], 4.0)));
    insta::assert_snapshot!(text(&trace), @"
    LW403: no product can be finished any more, with 0 of 10 products made: parts can never move again (deadlock since 0:00:04): x waits for y, y waits for x
      Let fewer parts into the line than fill the cycle, or add another route out of it.
    ");
}

/// What goes on is the shelf life of a buffer before the deadlock, shifts and failures elsewhere,
/// or a branch that makes products.
#[test]
fn a_deadlock_is_found_whatever_goes_on() {
    let expiring = LOOP.replace(
        "route P: a -> x",
        "source a: P every 2 s
         buffer q capacity 3 shelf life 10 s
         route P: a -> q -> x",
    );
    let branch = format!(
        "part Q source b: Q every 5 s station z {{ takes 4 s failures mtbf 1 min mttr 10 s shift 8 h to 16 h }}
         source a: P every 2 s
         {LOOP}
         route Q: b -> z -> k
         product P, Q"
    );
    for (body, products) in [(expiring, 0..1), (branch, 1..9999)] {
        let trace = run_text(&body, None, Some(86_400.0));
        assert_eq!(trace.end, End::Time);
        assert!(products.contains(&trace.products), "{}", trace.products);
        let found = deadlock(&trace);
        assert_eq!(
            found.map(|(places, _)| places),
            Some(vec!["x", "y"]),
            "{body}"
        );
        let errors = trace
            .findings
            .iter()
            .filter(|f| f.severity == Severity::Error);
        assert_eq!(errors.map(|f| f.code.id).collect::<Vec<_>>(), ["LW403"]);
    }
}

/// The station lacks a part that it could only get through a buffer, which is full of parts that
/// wait for the station.
#[test]
fn a_deadlock_is_found_where_the_missing_part_finds_no_room() {
    for queue in ["", "lifo", "highest p first"] {
        let body = format!(
            "part A {{ property p: 0..1 = 0 }} part B {{ property p: 0..1 = 1 }} part W from 1 A, 1 B product W
             source sa: A every 10 s source sb: B every 25 s
             buffer mix capacity 3 {queue}
             station j {{ takes 1 s a W }}
             sink box sink over rejects
             route A: sa -> mix, over route B: sb -> mix, over
             route A: mix -> j route B: mix -> j route W: j -> box"
        );
        let trace = run_text(&body, None, Some(7200.0));
        assert_eq!(trace.end, End::Time);
        let mut places = deadlock(&trace).expect("a deadlock").0;
        places.sort_unstable();
        assert_eq!(places, ["j", "mix"], "{queue}");
    }
}

/// Parts that wait for others of which none can come, because the `at most N in the line` of their
/// source is used up by parts that wait themselves.
#[test]
fn a_deadlock_is_found_where_a_limit_stops_a_source() {
    let goes_on =
        "part Q source more: Q every 5 s station z { takes 1 s } sink k route Q: more -> z -> k";
    let bodies = [
        // One part of two is there, and no other may come.
        (
            "part P part W from 2 P source a: P every 1 s, at most 1 in the line station pair { takes 1 s a W }
             route P: a -> pair route W: pair -> k product W, Q",
            vec!["a", "pair"],
            "pair waits for a part of type P, which a makes, a makes no part while 1 P is in the line",
        ),
        // Both parts B wait for an E, which is made of a D, which needs another B.
        (
            "part A part B part D from 1 A, 1 B part E from 1 D part F from 1 B, 1 E
             source a: A every 7 s source b: B every 3 s, at most 2 in the line
             station first { takes 1 s a D } station last { takes 1 s a F }
             station turn { takes 1 s a E } buffer q capacity 2 sink lost rejects
             route A: a -> first, lost route B: b -> q, first route B: q -> last
             route D: first -> turn route E: turn -> last route F: last -> k product F, Q",
            vec!["first", "last", "q", "turn"],
            "q waits for last, last waits for a part of type E, which turn makes, turn waits for a part of type D, \
             which first makes, first waits for a part of type B, which is in q",
        ),
    ];
    for (body, expected, why) in bodies {
        let trace = run_text(&format!("{goes_on} {body}"), None, Some(7200.0));
        let mut places = deadlock(&trace).expect("a deadlock").0;
        places.sort_unstable();
        assert_eq!((places, trace.end), (expected, End::Time), "{body}");
        assert!(text(&trace).contains(why), "{}", text(&trace));
    }
}

/// Parts that only wait long do not count: for a repair, a shift, the end of a rest, a part that a
/// station lacks and that is on its way, or a buffer whose parts expire.
#[test]
fn no_deadlock_is_found_where_parts_only_wait_long() {
    let bodies = [
        // The whole of y's loop waits for a repair of y that takes long.
        "part P source a: P every 1 s sink lost rejects buffer q capacity 1
         station x { takes 1 s } station y { takes 1 s failures mtbf 10 s mttr 900 s } sink k
         route P: a -> x, lost route P: x -> q -> y -> k",
        // Off shift at the end.
        "part P source a: P every 1 s sink lost rejects buffer q capacity 1
         station x { takes 1 s } station y { takes 1 s shift 0 h to 0.2 h } sink k
         route P: a -> x, lost route P: x -> q -> y -> k",
        // Full of parts that rest.
        "part P source a: P every 1 s sink lost rejects
         station x { takes 1 s } buffer q capacity 4 dwell 980 s station y { takes 1 s } sink k
         route P: a -> x, lost route P: x -> q -> y -> k",
        // A carton waits for the bottles that come late.
        "part B part C part F from 2 B, 1 C source b: B every 600 s source c: C every 1 s
         sink lost rejects buffer q capacity 2 station s { takes 1 s a F } sink k
         route B: b -> s route C: c -> q, lost route C: q -> s route F: s -> k",
        // A loop whose buffer scraps parts that are too old.
        "part P { property again: bool = true } source a: P every 1 s sink lost rejects
         buffer q capacity 1 shelf life 600 s station x { takes 1 s } sink k
         route P: a -> x, lost
         route P: x -> q when again route P: x -> k otherwise route P: q -> x",
    ];
    for body in bodies {
        for until in [950.0, 999.5] {
            let trace = run_text(body, None, Some(until));
            assert_eq!((trace.end, deadlock(&trace)), (End::Time, None), "{body}");
            assert_eq!(text(&trace), "", "{body}");
        }
    }
}

/// The stock of a component is used up: the rest waits for ever, and nothing in a circle. This is a
/// note; a run that waits for products ends.
#[test]
fn parts_that_wait_for_what_never_comes_are_a_note() {
    let body = "part B part C part F from 1 B, 1 C source b: B every 1 s, at most 1000 in the line
         source c: C every 1 s limit 3
         sink lost rejects buffer q capacity 2 station s { takes 1 s a F } sink k
         route B: b -> q, lost route B: q -> s route C: c -> s route F: s -> k";
    let trace = run_text(body, None, Some(950.0));
    assert_eq!((trace.end, deadlock(&trace)), (End::Time, None));
    assert_eq!(trace.findings[0].severity, Severity::Note);
    insta::assert_snapshot!(text(&trace), @"
    LW403: parts of the line can never move again, although the rest goes on: q waits for s, s waits for a part of type C, but c has made all 3 of its limit
      Make sure that enough of the missing parts are made or stocked and that rejected parts are reordered, or require fewer products.
    ");
    let trace = run_text(body, Some(10), None);
    assert_eq!((trace.end, trace.products), (End::Blocked, 3));
    assert_eq!(trace.findings[0].severity, Severity::Error);
    insta::assert_snapshot!(text(&trace), @"
    LW403: no product can be finished any more, with 3 of 10 products made: q waits for s, s waits for a part of type C, but c has made all 3 of its limit
      Make sure that enough of the missing parts are made or stocked and that rejected parts are reordered, or require fewer products.
    ");
}

/// A random line in which parts go round, some of them without end, while sources go on.
fn random_line(chance: &mut Chance) -> String {
    let (stations, buffers, belts) = (2 + chance.below(3), chance.below(3), chance.below(2));
    let mut text = String::from(
        "part P { property n: 0..9 = 0 } part B product P source a: P every 3 s sink k sink lost rejects ",
    );
    let mut places = Vec::new();
    let joins = chance.percent(30);
    for station in 0..stations {
        let name = format!("s{station}");
        let times = chance.pick(&["1 s", "2 s", "exponential(3 s)", "uniform(1 s, 5 s)"]);
        let more = chance.pick(&[
            "",
            "",
            "failures mtbf 40 s mttr 9 s",
            "shift 0 h to 0.02 h shift 0.03 h to 24 h",
        ]);
        let _ = write!(
            text,
            "station {name} {{ takes {times} sets n = min(n + 1, 9) on P {more} }} "
        );
        places.push(name);
    }
    for buffer in 0..buffers {
        let name = format!("q{buffer}");
        let more = chance.pick(&["", "", "lifo", "highest n", "dwell 5 s", "shelf life 40 s"]);
        let _ = write!(
            text,
            "buffer {name} capacity {} {more} ",
            1 + chance.below(3)
        );
        places.push(name);
    }
    for belt in 0..belts {
        let name = format!("c{belt}");
        let _ = write!(
            text,
            "conveyor {name} places {} pitch 1 m speed 1 m/s ",
            1 + chance.below(3)
        );
        places.push(name);
    }
    let first = places[chance.below(places.len())].clone();
    let overflow = chance.pick(&["", ", lost", ", lost"]);
    let _ = write!(text, "route P: a -> {first}{overflow} ");
    if chance.percent(30) {
        let most = format!("every 3 s, at most {} in the line", 1 + chance.below(5));
        text = text.replacen("every 3 s", &most, 1);
    }
    if joins {
        // A pair that waits for a part of the other type, which may be scarce.
        let every = chance.pick(&["2 s", "30 s", "1000 s", "4 s limit 3"]);
        let _ = write!(
            text,
            "part F from 1 P, 1 B source b: B every {every} station pair {{ takes 1 s a F }}
             route B: b -> pair, lost route F: pair -> k "
        );
        places.push("pair".to_owned());
    }
    for place in places.iter().filter(|place| *place != "pair") {
        let onward = |chance: &mut Chance| loop {
            let to = &places[chance.below(places.len())];
            // A cycle of buffers alone would be a livelock.
            let is_ahead = to > place || !to.starts_with('q');
            if place.starts_with('s') || to != place && is_ahead {
                return to.clone();
            }
        };
        let (one, other) = (onward(chance), onward(chance));
        let choice = if chance.percent(20) && other != one {
            format!("{one}, {other}")
        } else {
            one
        };
        let rounds = chance.below(6);
        let end = if chance.percent(60) {
            "k".to_owned()
        } else {
            onward(chance)
        };
        let _ = write!(
            text,
            "route P: {place} -> {choice} when n <= {rounds} route P: {place} -> {end} otherwise "
        );
    }
    text
}

/// Where a deadlock is found, nothing in it moves any more, however long the run goes on. Where
/// nothing moves for long although a part is blocked, one is found, unless parts wait for what
/// never comes.
#[test]
fn deadlocks_of_random_lines_last() {
    let mut chance = Chance::new(28);
    let (mut found, mut still) = (0, 0);
    for number in 0..4000 {
        let text = random_line(&mut chance);
        let files = [("line.lw".to_owned(), format!("line L {{ {text} }}"))];
        let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
        if findings.iter().any(|f| f.severity == Severity::Error) {
            continue;
        }
        let line = Arc::new(library.lines[0].clone());
        let run = |until: f64| {
            let options = Options {
                until: Some(until),
                ..Options::default()
            };
            let plant = Plant::new(Arc::clone(&line), BTreeMap::new(), options);
            plant.expect("a plant").run()
        };
        let short = run(400.0);
        if short.end != End::Time {
            continue;
        }
        let long = run(4000.0);
        if long.end != End::Time {
            continue;
        }
        let worked = |trace: &Trace, place: &str| {
            let station = trace.stations.iter().find(|s| s.name == place);
            let belt = trace.conveyors.iter().find(|c| c.name == place);
            let buffer = trace.buffers.iter().find(|b| b.name == place);
            let source = trace.sources.iter().find(|s| s.name == place);
            let moved = station.map(|s| s.processed).or(belt.map(|c| c.carried));
            let moved = moved.or(source.map(|s| s.passed));
            moved.or(buffer.map(|b| b.passed))
        };
        if let Some((places, since)) = deadlock(&short) {
            found += 1;
            assert!(since <= 400.0);
            for place in places {
                let both = (worked(&short, place), worked(&long, place));
                assert_eq!(both.0, both.1, "{number}: {place} of {text}");
            }
            assert!(deadlock(&long).is_some(), "{number}: {text}");
        }
        let later = run(8000.0);
        let rests = long
            .stations
            .iter()
            .zip(&later.stations)
            .all(|(a, b)| a.processed == b.processed);
        let is_blocked = later.stations.iter().any(|s| s.shares.blocked > 0.5);
        let waits_for_parts = text.contains("pair");
        if rests && is_blocked && !waits_for_parts && later.end == End::Time {
            still += 1;
            assert!(deadlock(&long).is_some(), "{number}: {text}");
        }
    }
    println!("{found} deadlocks, {still} lines that stand still");
    assert!(found > 100 && still > 50, "{found} {still}");
}

/// The search for a warm-up says why a line does not become steady, and a run that ends in its
/// warm-up because of a deadlock is not advised to last longer.
#[test]
fn a_deadlock_during_the_warm_up_is_its_own_finding() {
    let body = LOOP.replace("route P: a -> x", "source a: P every 2 s route P: a -> x");
    let options = |warm_up_products| Options {
        until: Some(7200.0),
        warm_up_products,
        ..Options::default()
    };
    let plant =
        |warm_up_products| plant_of(&format!("line L {{ {body} }}"), options(warm_up_products));
    let found = plant(0).find_warm_up().expect_err("a deadlock");
    assert_eq!(found.code.id, "LW403");
    let trace = plant(100).run();
    let codes: Vec<&str> = trace.findings.iter().map(|f| f.code.id).collect();
    assert_eq!(codes, ["LW403", "LW404"]);
    assert_eq!(
        trace.findings[1].help.as_deref(),
        Some("First repair what made the line stand still.")
    );
}

/// Lead times are differences of instants: as doubles, 0.4 - 0.1 is a little more than 0.3.
#[test]
fn a_requirement_holds_at_its_bound() {
    let trace = run_text(
        "part P product P source a: P every 0.1 s limit 3
         buffer q capacity 10 station s { takes 0.2 s } sink k
         route P: a -> q -> s -> k
         requirement longest: wait_max(q) <= 0.2 s
         requirement exactly: lead_time = 0.3 s
         requirement below: wait_max(q) < 0.2 s
         requirement above: lead_time > 0.3 s",
        None,
        Some(100.0),
    );
    let holds = trace.requirements.iter().map(|r| r.holds);
    assert_eq!(holds.collect::<Vec<_>>(), [true, true, false, false]);
}
