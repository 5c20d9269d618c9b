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

/// The numbers of parts between failures, in a run of so many seconds of work.
fn gaps(statements: &str, until: f64) -> Vec<u64> {
    let trace = run("0 s", &format!("takes 1 s {statements}"), until);
    let mut gaps = Vec::new();
    let mut parts = 0;
    for entry in &trace.log {
        match entry.what {
            EventKind::Ended => parts += 1,
            EventKind::Failed => gaps.push(std::mem::take(&mut parts)),
            _ => {}
        }
    }
    gaps
}

/// A drawn number of parts is rounded to a whole number, and is at least 1.
#[test]
fn a_number_of_parts_may_be_drawn() {
    let rounded = |count: &str| {
        let failures = format!("failures every {count} parts mttr constant(5 s)");
        gaps(&failures, 40.0)
    };
    assert_eq!(rounded("constant(2)"), rounded("2"));
    assert_eq!(rounded("constant(2.5)"), rounded("3"));
    assert_eq!(rounded("discrete(0: 30 %, 1.45: 70 %)"), rounded("1"));
    assert_eq!(rounded("uniform(1.6, 2.4)"), rounded("2"));
}

/// Of the whole numbers from 50 to 150, the first and the last are half as likely as the others:
/// the mean is 100, and the variance 100^2 / 12 + 1 / 12 + 1 / 12 with Sheppard's correction.
#[test]
fn drawn_numbers_of_parts_have_their_distribution() {
    let gaps = gaps(
        "failures every uniform(50, 150) parts mttr constant(0 s)",
        4e5,
    );
    let count = gaps.len() as f64;
    assert!(count > 3900.0, "{count}");
    assert!(gaps.iter().all(|gap| (50..=150).contains(gap)));
    let mean = gaps.iter().sum::<u64>() as f64 / count;
    let deviation = |gap: &u64| (*gap as f64 - mean).powi(2);
    let variance = gaps.iter().map(deviation).sum::<f64>() / (count - 1.0);
    // Four standard errors; the fourth central moment of the uniform distribution is w^4 / 80.
    let wanted = (1e4_f64 + 1.0) / 12.0;
    let error = 4.0 * (wanted / count).sqrt();
    assert!((mean - 100.0).abs() < error, "{mean}");
    let error = 4.0 * ((1e8 / 80.0 - wanted.powi(2)) / count).sqrt();
    assert!((variance - wanted).abs() < error, "{variance}");
    // Each of ten equal ranges has its share: chi-square with 9 degrees of freedom.
    let mut observed = [0.0; 10];
    for gap in gaps.iter().filter(|gap| (51..150).contains(*gap)) {
        observed[(*gap as usize - 51) / 10] += 1.0;
    }
    let inner = count * 99.0 / 100.0;
    let square = |(range, seen): (usize, &f64)| {
        let expected = inner * if range < 9 { 10.0 } else { 9.0 } / 99.0;
        (seen - expected).powi(2) / expected
    };
    let chi_square: f64 = observed.iter().enumerate().map(square).sum();
    assert!(chi_square < 27.9, "{chi_square}");
}

/// Each mode draws from a stream of its own: another mode changes nothing.
#[test]
fn drawn_numbers_of_parts_do_not_depend_on_other_modes() {
    let blunt = "failures blunt: every weibull(2, 40) parts mttr constant(0 s)";
    let alone = gaps(blunt, 5000.0);
    assert!(alone.len() > 100);
    let other = format!("{blunt} failures oil: every uniform(5000, 9000) parts mttr 1 s");
    assert_eq!(gaps(&other, 5000.0), alone);
    let named = blunt.replace("blunt", "worn");
    assert_ne!(gaps(&named, 5000.0), alone);
}

/// `by calendar` may stand behind either of the two times.
#[test]
fn by_calendar_has_two_places() {
    let failed = |words: &str| {
        let trace = run("0 s", &format!("takes 10 s failures {words}"), 65.0);
        instants(&trace, EventKind::Failed)
    };
    let wanted = [23.0, 51.0];
    assert_eq!(
        failed("mtbf constant(23 s) by calendar mttr constant(5 s)"),
        wanted
    );
    assert_eq!(
        failed("mtbf constant(23 s) mttr constant(5 s) by calendar"),
        wanted
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
