//! Accumulating conveyors, compared with a simulation by positions that is independent of the
//! runner's closed form.

use crate::models::{Builder, Work, constant, every, took};
use linewright::line::log::EventKind;
use linewright::line::random::Stream;
use proptest::prelude::*;

#[test]
fn a_part_needs_its_time_and_the_next_one_its_distance() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(3)))
        .conveyor("belt", 4, 2.0)
        .sink("sink")
        .route("Part", &["source", "belt", "sink"]);
    let trace = builder.run(3);
    let off: Vec<f64> = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Finished)
        .map(|e| e.time)
        .collect();
    assert_eq!(off, [8.0, 10.0, 12.0]);
    assert_eq!(trace.conveyors[0].moving_seconds, 12.0);
    assert_eq!(trace.joules, 1200.0);
    assert_eq!(trace.conveyors[0].carried, 3);
}

#[test]
fn a_blocked_conveyor_closes_up_and_stops() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .conveyor("belt", 3, 1.0)
        .station("slow", &["Part"], constant(100.0))
        .sink("sink")
        .route("Part", &["source", "belt", "slow", "sink"]);
    // On at 0, 1, 2, and at 3 when the first goes off; those close up by 6, and another one comes
    // at 103 with the next.
    let trace = builder.run_until(103.5);
    assert_eq!(trace.parts.in_progress, 4);
    assert_eq!(trace.conveyors[0].moving_seconds, 4.0 + 0.5);
}

/// The same conveyor step by step in units of `1 / fine` of a pitch, as positions of parts.
fn by_positions(
    arrivals: &[u64],
    services: &[u64],
    places: u64,
    fine: u64,
    until: u64,
) -> Vec<u64> {
    let length = places * fine;
    let mut on: Vec<u64> = Vec::new();
    let (mut next, mut served, mut free_at) = (0, 0, 0);
    let mut off = Vec::new();
    for now in 0..until {
        if on.first() == Some(&length) && now >= free_at {
            on.remove(0);
            off.push(now);
            free_at = now + services.get(served).copied().unwrap_or(1);
            served += 1;
        }
        // A part may come on behind one that is at least a pitch along, if all the rest still fits.
        let room = on.last().is_none_or(|&last| last >= fine) && (on.len() as u64) < places;
        if next < arrivals.len() && arrivals[next] <= now && room {
            on.push(0);
            next += 1;
        }
        let mut limit = length;
        for position in &mut on {
            if *position < limit {
                *position += 1;
            }
            // The next one keeps a pitch behind; this is evaluated before its own move, so it moves
            // with this one.
            limit = position.saturating_sub(fine);
        }
    }
    off
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(80) })]

    #[test]
    fn the_closed_form_equals_the_positions(
        places in 1_u64..5,
        fine in 1_u64..5,
        seed in 0_u64..1_000_000,
    ) {
        let mut stream = Stream::from_seed(seed);
        let count = 30;
        let mut time = 0;
        // A store's parts come on whenever there is room; a timed source before it determines their
        // times.
        let gaps: Vec<u64> = (0..count).map(|_| stream.below(4 * fine)).collect();
        let services: Vec<u64> = (0..count).map(|_| 1 + stream.below(4 * fine)).collect();
        let arrivals: Vec<u64> = gaps.iter().map(|gap| { time += gap; time }).collect();
        let until = 1000;
        let expected = by_positions(&arrivals, &services, places, fine, until);

        let (clock, work) = (gaps.clone(), services.clone());
        let mut builder = Builder::new(&["Part"]);
        builder
            .source("source", "Part", every(0.0, Some(count as u64)))
            .station("clock", &["Part"], Work(move |call: u64, _: &mut [f64]| took(clock[call as usize - 1] as f64), 0))
            .buffer("buffer", 1000)
            .conveyor("belt", places as u32, fine as f64)
            .station("work", &["Part"], Work(move |call: u64, _: &mut [f64]| took(work[call as usize - 1] as f64), 0))
            .sink("sink")
            .route("Part", &["source", "clock", "buffer", "belt", "work", "sink"]);
        let trace = builder.run_until(until as f64);
        let belt = builder.node("belt");
        let off: Vec<u64> = trace
            .log
            .iter()
            .filter(|e| e.node == belt && e.what == EventKind::Left)
            .map(|e| e.time as u64)
            .collect();
        prop_assert_eq!(off, expected);
    }
}
