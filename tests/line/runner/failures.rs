//! Failure modes, on lines with constant times: the instants can be computed by hand.

use crate::models::{Logged, RunLogged, plant_of};
use linewright::line::log::EventKind;
use linewright::line::{End, Options};

/// Runs a station with these statements; parts come every `interval`.
fn run(interval: &str, statements: &str, until: f64) -> Logged {
    let text = format!(
        "line L {{
            part P
            source rack: P every {interval}
            station cell {{ {statements} }}
            sink out
            route P: rack -> cell -> out
        }}"
    );
    let options = Options {
        until: Some(until),
        ..Options::default()
    };
    plant_of(&text, options).run_logged()
}

/// The instants of these events.
fn instants(trace: &Logged, what: EventKind) -> Vec<f64> {
    let events = trace.log.iter().filter(|entry| entry.what == what);
    events.map(|entry| entry.time).collect()
}

#[test]
fn failures_by_the_calendar_interrupt_work() {
    let trace = run(
        "0 s",
        "takes 10 s failures mtbf constant(23 s) mttr constant(5 s) by calendar",
        65.0,
    );
    assert_eq!(instants(&trace, EventKind::Failed), [23.0, 51.0]);
    assert_eq!(instants(&trace, EventKind::Repaired), [28.0, 56.0]);
    assert_eq!(
        instants(&trace, EventKind::Ended),
        [10.0, 20.0, 35.0, 45.0, 60.0]
    );
    assert_eq!(trace.stations[0].shares.failed, 10.0 / 65.0);
}

#[test]
fn restarted_work_is_done_twice() {
    let trace = run(
        "0 s",
        "takes 10 s power 100 W failures mtbf constant(23 s) mttr constant(5 s) by calendar restart",
        66.0,
    );
    assert_eq!(
        instants(&trace, EventKind::Ended),
        [10.0, 20.0, 38.0, 48.0, 66.0]
    );
    // Five parts, and twice 3 s of work that was lost.
    assert_eq!(trace.stations[0].busy_seconds, 56.0);
    assert!((trace.joules - 5600.0).abs() < 1e-9, "{}", trace.joules);
}

#[test]
fn restarted_setup_is_done_twice() {
    let text = "line L {
        part P
        part Q
        product Q
        source first: P every 0 s limit 1
        source second: Q every 0 s limit 1
        buffer both capacity 2
        station cell {
            takes 10 s
            setup 10 s
            failures mtbf constant(13 s) mttr constant(5 s) by calendar restart
        }
        sink out
        route P: first -> both -> cell -> out
        route Q: second -> both -> cell -> out
    }";
    let options = Options {
        parts: Some(1),
        ..Options::default()
    };
    let trace = plant_of(text, options).run_logged();
    // P until 10, setup from 10 to 13 and from 18 to 28; Q from 28 to 31, and from 36 to 46.
    assert_eq!(instants(&trace, EventKind::Ended), [10.0, 46.0]);
    assert!((trace.stations[0].shares.setup - 13.0 / 46.0).abs() < 1e-12);
}

#[test]
fn failures_after_a_number_of_parts_strike_at_the_end_of_work() {
    let trace = run(
        "0 s",
        "takes 10 s failures every 2 parts mttr constant(5 s)",
        65.0,
    );
    assert_eq!(instants(&trace, EventKind::Failed), [20.0, 45.0]);
    assert_eq!(
        instants(&trace, EventKind::Ended),
        [10.0, 20.0, 35.0, 45.0, 60.0]
    );
    // The finished part leaves a broken station.
    assert_eq!(
        instants(&trace, EventKind::Finished),
        [10.0, 20.0, 35.0, 45.0, 60.0]
    );
}

#[test]
fn repairs_of_several_modes_follow_each_other() {
    let trace = run(
        "0 s",
        "takes 10 s
         failures blunt: every 1 part mttr constant(5 s)
         failures power: mtbf constant(12 s) mttr constant(7 s) by calendar",
        55.0,
    );
    // The second mode strikes at 12 and 34, during repairs that end at 15 and 37.
    assert_eq!(
        instants(&trace, EventKind::Failed),
        [10.0, 15.0, 32.0, 37.0, 54.0]
    );
    assert_eq!(instants(&trace, EventKind::Ended), [10.0, 32.0, 54.0]);
}

#[test]
fn a_broken_station_takes_no_part() {
    let trace = run(
        "30 s",
        "takes 1 s failures mtbf constant(29 s) mttr constant(4 s) by calendar",
        70.0,
    );
    assert_eq!(instants(&trace, EventKind::Started), [0.0, 33.0, 60.0]);
    assert_eq!(instants(&trace, EventKind::Ended), [1.0, 34.0, 61.0]);
}

#[test]
fn each_mode_of_working_time_has_its_own_clock() {
    let trace = run(
        "20 s",
        "takes 10 s
         failures a: mtbf constant(15 s) mttr constant(1 s)
         failures b: mtbf constant(22 s) mttr constant(2 s)",
        85.0,
    );
    // Parts come at 0, 20, 40, 60 and 80. After 15 s of work, at 25, a strikes; after 22 s, at 42,
    // b. After 30 s, at 52, work ends just when a is due, so a strikes when the next work begins.
    // After 44 s, at 84, b strikes again.
    assert_eq!(
        instants(&trace, EventKind::Failed),
        [25.0, 42.0, 60.0, 84.0]
    );
    assert_eq!(instants(&trace, EventKind::Repaired), [26.0, 44.0, 61.0]);
}

/// Failures to come do not keep a line going that stands still.
#[test]
fn a_blocked_line_with_failures_ends() {
    let text = "line L {
        part P
        source rack: P every 5 s limit 2
        station cell { takes 1 s failures mtbf constant(1 h) mttr constant(5 s) by calendar }
        sink out
        route P: rack -> cell -> out
    }";
    let options = Options {
        parts: Some(5),
        ..Options::default()
    };
    let trace = plant_of(text, options).run_logged();
    assert_eq!(trace.end, End::Blocked);
    assert_eq!(trace.seconds, 6.0);
}

/// Another failure mode leaves the failures of the others as they are.
#[test]
fn modes_have_random_numbers_of_their_own() {
    let one = "takes 10 s failures a: mtbf 50 s mttr 5 s by calendar";
    let two = format!("{one} failures b: mtbf 1e8 s mttr 1 s by calendar");
    let (one, two) = (run("0 s", one, 2000.0), run("0 s", &two, 2000.0));
    let failed = |trace: &Logged| instants(trace, EventKind::Failed);
    assert!(failed(&one).len() > 20);
    assert_eq!(failed(&one), failed(&two));
}

/// Each failure makes the planned end of the work outdated. A million such events at one instant
/// are no livelock.
#[test]
fn outdated_events_are_no_livelock() {
    let text = "line L {
        part P
        source rack: P every 10 s
        station cell {
            takes 2 s
            failures mtbf constant(1e-6 s) mttr constant(0 s) by calendar
        }
        sink out
        route P: rack -> cell -> out
    }";
    let options = Options {
        until: Some(2.1),
        ..Options::default()
    };
    let trace = plant_of(text, options).run_logged();
    assert_eq!((trace.end, trace.products), (End::Time, 1));
}
