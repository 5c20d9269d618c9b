//! Conveyors that a controller moves.

use crate::support::{Builder, Shift1, constant, every};
use linewright::line::End;
use linewright::line::trace::What;

#[test]
fn a_belt_carries_parts_in_their_order() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(4)))
        .belt("belt", 3, Shift1::new(3))
        .sink("sink")
        .route("Part", &["source", "belt", "sink"]);
    let trace = builder.run(4);
    // On at 0, 2, 4, 6 (place 0 must have been seen free), off three periods later.
    let off: Vec<(f64, u64)> = trace
        .log
        .iter()
        .filter(|e| e.what == What::Finished)
        .filter_map(|e| e.part.map(|p| (e.time, p.0)))
        .collect();
    assert_eq!(off, [(3.0, 1), (5.0, 2), (7.0, 3), (9.0, 4)]);
    let places: Vec<(f64, u32)> = trace
        .log
        .iter()
        .filter_map(|e| match (e.what, e.part) {
            (What::Place(place), Some((2, _))) => Some((e.time, place)),
            _ => None,
        })
        .collect();
    assert_eq!(places, [(3.0, 0), (4.0, 1), (5.0, 2)]);
    assert_eq!(trace.conveyors[0].machine.as_deref(), Some("belt_machine"));
}

#[test]
fn a_belt_sleeps_and_is_woken() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(1000.5, None))
        .belt("belt", 3, Shift1::new(3))
        .station("slow", &["Part"], constant(1500.0))
        .sink("sink")
        .route("Part", &["source", "belt", "slow", "sink"]);
    let trace = builder.run_until(100_000.0);
    // Off at 3, then blocked by the station until 1503, 3003, ...
    assert_eq!(
        trace.products,
        ((100_000.0_f64 - 3.0) / 1500.0).floor() as u64
    );
    // Some twenty steps a part, not one for each of 100 000 seconds.
    assert!(trace.events < 4000, "{}", trace.events);
    assert!(trace.findings.is_empty());
}

#[test]
fn belts_hand_over_to_belts() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(20)))
        .belt("first", 3, Shift1::new(3))
        .belt("second", 2, Shift1::new(2))
        .station("work", &["Part"], constant(3.3))
        .sink("sink")
        .route("Part", &["source", "first", "second", "work", "sink"]);
    let trace = builder.run(20);
    assert_eq!(trace.end, End::Products);
    let order: Vec<u64> = trace
        .log
        .iter()
        .filter(|e| e.what == What::Finished)
        .filter_map(|e| e.part.map(|p| p.0))
        .collect();
    assert_eq!(order, (1..=20).collect::<Vec<_>>());
}

#[test]
fn a_lost_part_is_found() {
    let mut belt = Shift1::new(3);
    belt.loses_at = Some(5);
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .belt("belt", 3, belt)
        .sink("sink")
        .route("Part", &["source", "belt", "sink"]);
    let trace = builder.run(100);
    assert_eq!(trace.end, End::PartLost);
    assert_eq!(trace.findings[0].code.id, "LW407");
    insta::assert_snapshot!(trace.findings[0].message, @r#"belt lost a part at 0:00:05: its controller says that 0 of its places are occupied, but 2 parts are on it"#);
}
