//! Parts that are lost in the line: scrap after a failure, and parts that expire. Also dwell times,
//! and lines that make several products.

use crate::models::{Logged, RunLogged, plant_of};
use linewright::line::log::EventKind;
use linewright::line::trace::Trace;
use linewright::line::{Estimate, Options};

fn run(text: &str, options: Options) -> Logged {
    plant_of(text, options).run_logged()
}

fn until(seconds: f64) -> Options {
    Options {
        until: Some(seconds),
        ..Options::default()
    }
}

/// The instants of these events at a place, or anywhere.
fn instants(trace: &Logged, what: EventKind) -> Vec<f64> {
    let events = trace.log.iter().filter(|entry| entry.what == what);
    events.map(|entry| entry.time).collect()
}

#[test]
fn a_failure_scraps_the_part_in_work() {
    let trace = run(
        "line L {
            part P
            source rack: P every 0 s
            station cell {
                takes 10 s
                power 100 W
                failures mtbf constant(23 s) mttr constant(5 s) scrap
            }
            sink out
            route P: rack -> cell -> out
        }",
        until(50.0),
    );
    assert_eq!(instants(&trace, EventKind::Failed), [23.0]);
    assert_eq!(instants(&trace, EventKind::Rejected), [23.0]);
    assert_eq!(instants(&trace, EventKind::Ended), [10.0, 20.0, 38.0, 48.0]);
    assert_eq!((trace.parts.finished, trace.parts.rejected), (4, 1));
    // Four parts, 3 s of the one that was scrapped, and 2 s of the last one.
    assert_eq!(trace.stations[0].busy_seconds, 45.0);
    assert_eq!(trace.stations[0].joules, 4500.0);
    // The part that was scrapped counts as made.
    assert_eq!(trace.stations[0].scrapped, 1);
    assert_eq!(trace.stations[0].oee.map(|oee| oee.quality), Some(0.8));
}

#[test]
fn a_failure_during_setup_scraps_nothing() {
    let trace = run(
        "line L {
            part A part B product B
            source a: A every 100 s
            source b: B every 100 s
            station cell {
                takes 10 s
                setup 20 s
                failures mtbf constant(15 s) mttr constant(5 s) by calendar scrap
            }
            sink out
            route A: a -> cell -> out
            route B: b -> cell -> out
        }",
        until(90.0),
    );
    // A until 10 s, setup until 30 s with a failure from 15 s to 20 s: until 35 s, when the next
    // failure comes at the instant at which the work would begin.
    assert_eq!(instants(&trace, EventKind::SetupStarted), [10.0]);
    assert_eq!(instants(&trace, EventKind::Failed)[..2], [15.0, 35.0]);
    let scrapped = instants(&trace, EventKind::Rejected);
    assert!(scrapped.iter().all(|time| *time >= 35.0), "{scrapped:?}");
}

#[test]
fn scrap_is_ordered_again() {
    let trace = run(
        "line L {
            part P
            source rack: P on order
            station cell { takes 10 s failures mtbf 40 s mttr 5 s scrap }
            sink out
            sink bin rejects reorder rack
            route P: rack -> cell
            route P: cell -> out, bin by probability 90 %
        }",
        Options {
            parts: Some(200),
            ..Options::default()
        },
    );
    assert_eq!(trace.products, 200);
    assert!(trace.parts.rejected > 40, "{:?}", trace.parts);
    assert_eq!(trace.rejects[0].reordered, trace.parts.rejected);
}

#[test]
fn a_part_rests_before_it_is_ready() {
    let line = |capacity: u32, options: &str| {
        format!(
            "line L {{
                part P
                source rack: P every 10 s
                buffer tray capacity {capacity} {options}
                sink out
                route P: rack -> tray -> out
            }}"
        )
    };
    let trace = run(&line(5, "dwell 25 s"), until(100.0));
    let finished: Vec<f64> = (0..8).map(|n| 25.0 + 10.0 * f64::from(n)).collect();
    assert_eq!(instants(&trace, EventKind::Finished), finished);
    let tray = &trace.buffers[0];
    assert_eq!(
        (tray.wait, tray.longest_wait, tray.longest),
        (25.0, 25.0, 3)
    );
    // With room for two parts, only two pass in 25 s: the room is the bottleneck.
    let trace = run(&line(2, "dwell 25 s"), until(1000.0));
    assert_eq!(trace.products, 79);
    // The order is that of the parts that are ready: the last of them leaves first.
    let trace = run(&line(5, "lifo dwell uniform(5 s, 30 s)"), until(1000.0));
    assert!(trace.buffers[0].longest_wait <= 30.0);
}

#[test]
fn parts_expire_after_their_shelf_life() {
    let text = |order: &str| {
        format!(
            "line L {{
                part P
                source rack: P every 5 s
                buffer queue capacity 100 {order} shelf life 12 s
                station cell {{ takes 10 s }}
                sink out
                route P: rack -> queue -> cell -> out
            }}"
        )
    };
    let trace = run(&text(""), until(1000.0));
    // From the third part on, every second one waits too long; nobody waits longer than 12 s.
    let queue = &trace.buffers[0];
    assert!(queue.longest_wait <= 12.0, "{queue:?}");
    assert_eq!(queue.expired, trace.parts.rejected);
    assert_eq!(trace.products, 100);
    assert!(queue.expired >= 97, "{queue:?}");
    // Parts that are overtaken expire, too.
    let trace = run(&text("lifo"), until(1000.0));
    assert_eq!(trace.products, 100);
    assert!(trace.buffers[0].longest_wait <= 12.0);
    // A part that rests expires as well: those that would rest for longer than 8 s.
    let trace = run(
        "line L {
            part P
            source rack: P every 1 s
            buffer tray capacity 100 dwell uniform(4 s, 12 s) shelf life 8 s
            sink out
            route P: rack -> tray -> out
        }",
        until(20_000.0),
    );
    let share = trace.parts.rejected as f64 / 20_000.0;
    assert!((share - 0.5).abs() < 0.02, "{share}");
}

/// A part that expires has waited until then: the mean number of parts in the buffer is the rate at
/// which parts leave or expire times their mean wait, whatever the order and the warm-up.
#[test]
fn parts_that_expire_count_in_the_waits() {
    let text = |order: &str| {
        format!(
            "line L {{
                part P
                source rack: P every 1 s limit 400
                buffer queue capacity 100 {order} shelf life 12 s
                station cell {{ takes 4 s }}
                sink out
                route P: rack -> queue -> cell -> out
                requirement mean: wait(queue) <= 1 h
                requirement median: wait_p50(queue) <= 1 h
                requirement longest: wait_max(queue) <= 1 h
            }}"
        )
    };
    for (order, median) in [("", 12.0), ("lifo", 12.0), ("dwell 3 s", 12.0)] {
        let trace = run(&text(order), until(1000.0));
        let queue = &trace.buffers[0];
        assert!(queue.expired > 250 && queue.passed > 90, "{queue:?}");
        let parts = (queue.passed + queue.expired) as f64;
        assert!(
            (queue.length * 1000.0 / (parts * queue.wait) - 1.0).abs() < 1e-9,
            "{queue:?}"
        );
        let values: Vec<f64> = trace.requirements.iter().filter_map(|r| r.value).collect();
        assert_eq!(values, [queue.wait, median, 12.0], "{order}");
        // Where all parts expire, their wait is known, too.
        let all = text(order).replace("takes 4 s", "takes 4 s shift 23 h to 24 h");
        let trace = run(&all, until(1000.0));
        let queue = &trace.buffers[0];
        assert_eq!((queue.passed, queue.expired), (0, 400), "{order}");
        assert!((queue.wait - 12.0).abs() < 1e-9, "{queue:?}");
        // Parts that were there when counting began have waited before.
        let options = Options {
            warm_up: 50.5,
            ..until(300.0)
        };
        assert!(run(&text(order), options).buffers[0].longest_wait <= 12.0);
    }
}

/// Independent replications of a measure against theory, within four standard errors.
fn agrees(name: &str, text: &str, measure: impl Fn(&Trace) -> f64, theory: f64) {
    let mut plant = plant_of(
        text,
        Options {
            until: Some(60_000.0),
            warm_up: 500.0,
            ..Options::default()
        },
    );
    let values: Vec<f64> = (1..=8)
        .map(|seed| measure(&plant.run_seeded(seed)))
        .collect();
    let estimate = Estimate::of(&values).unwrap();
    // The 97.5 % quantile of Student's t distribution with 7 degrees of freedom.
    let error = estimate.half_width.unwrap() / 2.364_624;
    assert!(
        (estimate.mean - theory).abs() <= 4.0 * error,
        "{name}: {} instead of {theory}, standard error {error}",
        estimate.mean
    );
}

/// Parts that rest are a queue with a server for each (M/G/∞): their mean number is the arrival
/// rate times the mean dwell time, for every distribution.
#[test]
fn resting_parts_are_a_queue_with_a_server_for_each() {
    for dwell in ["40 s", "exponential(40 s)", "uniform(0 s, 80 s)"] {
        let text = format!(
            "line L {{
                part P
                source rack: P every exponential(5 s)
                buffer oven capacity 1000 dwell {dwell}
                sink out
                route P: rack -> oven -> out
            }}"
        );
        agrees(dwell, &text, |trace| trace.buffers[0].length, 8.0);
    }
}

/// An M/M/1 queue in which parts wait no longer than a time: the share of parts that is lost
/// (Barrer, "Queuing with impatient customers and ordered service", 1957), from the balance of the
/// virtual waiting time.
#[test]
fn a_queue_of_impatient_parts_loses_the_share_of_barrer() {
    for (interval, patience) in [(10.0, 15.0), (12.5, 10.0), (8.0, 30.0_f64)] {
        let (arrivals, service) = (1.0 / interval, 0.1_f64);
        let gap = service - arrivals;
        let waits = if gap == 0.0 {
            arrivals * patience
        } else {
            arrivals * (1.0 - (-gap * patience).exp()) / gap
        };
        let beyond = arrivals / service * (-gap * patience).exp();
        let theory = beyond / (1.0 + waits + beyond);
        let text = format!(
            "line L {{
                part P
                source rack: P every exponential({interval} s)
                buffer queue capacity 1000 shelf life {patience} s
                station cell {{ takes exponential(10 s) }}
                sink out
                route P: rack -> queue -> cell -> out
            }}"
        );
        let lost = |trace: &Trace| {
            let rejected = trace.parts.rejected as f64;
            rejected / (rejected + trace.parts.finished as f64)
        };
        agrees(&format!("{interval} s, {patience} s"), &text, lost, theory);
    }
}

#[test]
fn a_line_makes_several_products() {
    let trace = run(
        "line L {
            part A part B part C product A, C
            source a: A every 10 s
            source b: B every 10 s
            source c: C every 30 s
            station cell { takes 2 s takes 4 s a C }
            sink out
            route A: a -> cell -> out
            route B: b -> cell -> out
            route C: c -> cell -> out
        }",
        Options {
            parts: Some(40),
            ..Options::default()
        },
    );
    assert_eq!(trace.products, 40);
    let counts: Vec<(usize, u64)> = trace.by_type.iter().map(|p| (p.part, p.products)).collect();
    assert_eq!(counts, [(0, 30), (2, 10)]);
    assert_eq!(
        trace.parts.finished, 69,
        "29 B are finished by then, but not counted"
    );
    let rates = trace.by_type.iter().map(|p| p.throughput_per_hour);
    assert!((rates.sum::<f64>() - trace.throughput_per_hour).abs() < 1e-9);
    let times = trace
        .by_type
        .iter()
        .map(|p| p.lead_time.mean * p.products as f64);
    assert!((times.sum::<f64>() / 40.0 - trace.lead_time.mean).abs() < 1e-9);
}

/// Sources on order have orders without end if there are several products, because the run does not
/// ask for one of them.
#[test]
fn orders_for_several_products_do_not_end() {
    let text = "line L {
        part A part B product A, B
        source a: A on order
        source b: B every 7 s limit 2
        station cell { takes 2 s }
        sink out
        route A: a -> cell -> out
        route B: b -> cell -> out
    }";
    let options = Options {
        parts: Some(50),
        warm_up: 20.0,
        ..Options::default()
    };
    let trace = run(text, options);
    assert_eq!(trace.products, 50);
    assert!(trace.findings.is_empty(), "{:?}", trace.findings);
}
