//! Parts that come at the instants of a table.

use crate::models::{Builder, Logged, RunLogged, at, constant};
use linewright::contract::line::{Choice, NodeKind};
use linewright::line::log::EventKind;
use linewright::line::{End, Options};

/// A source with these instants, a buffer with this much room, and a station that takes 10 s.
fn line(instants: &[f64], room: u32) -> Builder {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", at(instants))
        .buffer("buffer", room)
        .station("cell", &["Part"], constant(10.0))
        .sink("sink")
        .route("Part", &["source", "buffer", "cell", "sink"]);
    builder
}

/// When parts left the source, and when they reached the sink.
fn times(trace: &Logged, node: usize, what: EventKind) -> Vec<f64> {
    let log = trace.log.iter();
    let entries = log.filter(|entry| entry.node == node && entry.what == what);
    entries.map(|entry| entry.time).collect()
}

fn entered(trace: &Logged) -> Vec<f64> {
    times(trace, 0, EventKind::Entered)
}

#[test]
fn parts_come_at_their_instants() {
    let instants = [0.0, 0.0, 0.1, 17.25, 17.25, 1e6];
    let trace = line(&instants, 10).run(6);
    assert_eq!(entered(&trace), instants);
    assert_eq!((trace.end, trace.seconds), (End::Products, 1e6 + 10.0));
    let late = line(&[3.5, 4.0], 10).run(2);
    assert_eq!(entered(&late), [3.5, 4.0]);
}

/// Parts whose instant has passed come as soon as there is room. Later ones are not delayed.
#[test]
fn a_source_without_room_catches_up() {
    let trace = line(&[0.0, 1.0, 2.0, 3.0, 100.0], 1).run(5);
    // One part is in the cell, one in the buffer.
    assert_eq!(entered(&trace), [0.0, 1.0, 10.0, 20.0, 100.0]);
    assert_eq!(trace.seconds, 110.0);
}

#[test]
fn after_the_last_row_nothing_comes() {
    let mut builder = line(&[0.0, 5.0], 10);
    let trace = builder.run_until(1000.0);
    assert_eq!(
        (trace.end, trace.products, trace.parts.entered),
        (End::Time, 2, 2)
    );
    let mut builder = line(&[0.0, 5.0], 10);
    let trace = builder.run(3);
    assert_eq!((trace.end, trace.products), (End::Blocked, 2));
    let message = &trace.findings[0].message;
    assert!(
        message.contains("source has made all 2 of its table"),
        "{message}"
    );
}

#[test]
fn a_limit_of_parts_in_the_line_delays_them() {
    let mut builder = line(&[0.0, 1.0, 2.0, 50.0], 10);
    let NodeKind::Source { most, .. } = &mut builder.line.nodes[0].kind else {
        panic!("a source");
    };
    *most = Some(1);
    let trace = builder.run(4);
    assert_eq!(entered(&trace), [0.0, 10.0, 20.0, 50.0]);
}

#[test]
fn a_warm_up_forgets_the_parts_before_it() {
    let mut plant = line(&[0.0, 30.0, 60.0, 90.0], 10).plant(Options {
        until: Some(200.0),
        warm_up: 50.0,
        ..Options::default()
    });
    let trace = plant.run();
    assert_eq!((trace.products, trace.parts.entered), (2, 2));
}

/// A replacement comes at once, and the instants of the others stay as they are.
#[test]
fn replacements_do_not_use_up_rows() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", at(&[0.0, 40.0, 41.0]))
        .station("cell", &["Part"], constant(10.0))
        .sink("sink")
        .scrap("bin", Some("source"))
        .route("Part", &["source", "cell"])
        .route_choice("Part", "cell", &["bin", "sink"], Choice::RoundRobin);
    let trace = builder.run(3);
    // Each second part is rejected.
    assert_eq!(entered(&trace), [0.0, 10.0, 40.0, 50.0, 60.0, 70.0]);
}

#[test]
fn seeds_do_not_change_the_instants() {
    let mut plant = line(&[0.0, 7.0, 7.5], 10).plant(Options {
        parts: Some(3),
        ..Options::default()
    });
    let first = entered(&plant.run_logged());
    assert_eq!(first, [0.0, 7.0, 7.5]);
    assert_eq!(entered(&plant.run_logged_seeded(2)), first);
}
