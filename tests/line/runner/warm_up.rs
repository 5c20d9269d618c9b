//! Warm-up, work in process, and buffers.

use crate::models::{RunLogged, plant_of};
use linewright::diagnostics::Severity;
use linewright::line::{End, Options, Trace};

fn run(text: &str, options: Options) -> Trace {
    plant_of(text, options).run()
}

fn until(seconds: f64, warm_up: f64) -> Options {
    Options {
        until: Some(seconds),
        warm_up,
        ..Options::default()
    }
}

const LINE: &str = "line L {
    part P
    source rack: P every 10 s
    buffer queue capacity 3
    station cell { takes 15 s power 100 W idle power 10 W }
    conveyor belt places 2 pitch 1 m speed 0.5 m/s power 5 W
    sink out
    route P: rack -> queue -> cell -> belt -> out
}";

/// The cell is always busy from 0 on. Parts leave it at 15, 30, ..., and the line 4 s later.
#[test]
fn only_what_comes_after_the_warm_up_counts() {
    let whole = run(LINE, until(330.0, 0.0));
    let rest = run(LINE, until(330.0, 100.0));
    assert_eq!((whole.seconds, rest.seconds), (330.0, 330.0));
    assert_eq!(rest.warm_up, 100.0);
    // 19, 34, ..., 319, and of these 109, ..., 319.
    assert_eq!((whole.products, rest.products), (21, 15));
    assert_eq!(rest.throughput_per_hour, 15.0 * 3600.0 / 230.0);
    assert_eq!(rest.makespan, 319.0);
    let cell = &rest.stations[0];
    assert_eq!((cell.processed, cell.busy_seconds), (16, 230.0));
    assert!((cell.joules - 23_000.0).abs() < 1e-6, "{}", cell.joules);
    assert_eq!(cell.shares.busy, 1.0);
    assert_eq!(rest.conveyors[0].carried, 15);
    // In each 15 s, the belt moves for 4 s. From 100 to 330 there are fifteen of these: the first
    // begins at 105.
    assert_eq!(rest.conveyors[0].moving_seconds, 60.0 + 0.0);
    let parts = rest.parts;
    assert_eq!(
        parts.before + parts.entered,
        parts.finished + parts.rejected + parts.consumed + parts.in_progress
    );
    assert!(parts.before > 0);
}

/// The run itself is the same: the warm-up changes nothing but the counts.
#[test]
fn a_warm_up_does_not_change_the_run() {
    let text = "line L {
        part P
        source rack: P every exponential(10 s)
        buffer queue capacity 3
        station cell { takes gamma(2, 4 s) failures mtbf 5 min mttr 20 s }
        sink out
        route P: rack -> queue -> cell -> out
    }";
    let logged = |warm_up| {
        let logged = plant_of(text, until(5000.0, warm_up)).run_logged();
        logged.movements().copied().collect::<Vec<_>>()
    };
    assert_eq!(logged(0.0), logged(1234.5));
}

/// The products that are asked for count from the end of the warm-up, and sources on order make
/// parts for them.
#[test]
fn a_number_of_products_counts_from_the_end_of_the_warm_up() {
    let text = LINE.replace("every 10 s", "on order");
    let options = Options {
        parts: Some(10),
        warm_up: 100.0,
        ..Options::default()
    };
    let trace = run(&text, options);
    assert_eq!((trace.end, trace.products), (End::Products, 10));
    // Parts leave the line at 19, 34, ...: the tenth after 100 s at 244.
    assert_eq!(trace.seconds, 244.0);
}

/// A warm-up until a number of products counts as one until the instant of the last of them.
#[test]
fn a_warm_up_may_be_given_by_products() {
    let options = |warm_up_products| Options {
        until: Some(330.0),
        warm_up_products,
        ..Options::default()
    };
    // Products leave at 19, 34, 49, 64, 79, ...
    let by_parts = run(LINE, options(5));
    assert_eq!((by_parts.warm_up, by_parts.warm_up_products), (79.0, 5));
    let by_time = run(LINE, until(330.0, 79.0));
    let same = Trace {
        warm_up_products: 0,
        ..by_parts
    };
    assert_eq!(format!("{same:?}"), format!("{by_time:?}"));
    // The line itself runs as without a warm-up.
    let logged = |warm_up_products| {
        let logged = plant_of(LINE, options(warm_up_products)).run_logged();
        logged.movements().copied().collect::<Vec<_>>()
    };
    assert_eq!(logged(0), logged(5));
}

/// The wanted products come after those of the warm-up, also from sources on order.
#[test]
fn products_count_from_the_end_of_a_warm_up_by_products() {
    for supply in ["every 10 s", "on order"] {
        let text = LINE.replace("every 10 s", supply);
        let options = Options {
            parts: Some(10),
            warm_up_products: 5,
            ..Options::default()
        };
        let trace = run(&text, options);
        assert_eq!((trace.end, trace.products), (End::Products, 10), "{supply}");
        assert_eq!(trace.seconds, 79.0 + 150.0, "{supply}");
    }
}

/// Batches of products begin after the warm-up.
#[test]
fn batches_begin_after_a_warm_up_by_products() {
    let options = Options {
        parts: Some(20),
        warm_up_products: 5,
        batches: Some(2),
        ..Options::default()
    };
    let trace = run(LINE, options);
    let seconds: Vec<f64> = trace.batches.iter().map(|batch| batch.seconds).collect();
    assert_eq!(seconds, [150.0, 150.0]);
}

/// A run that ends during its warm-up has measured nothing, so it meets no requirement and is not
/// part of any mean.
#[test]
fn a_run_that_ends_during_its_warm_up_has_no_values() {
    let text = LINE.trim_end().strip_suffix('}').expect("a line");
    let text = format!("{text}    requirement few: wip <= 1000\n}}\n");
    let options = |warm_up_products| Options {
        until: Some(330.0),
        warm_up_products,
        ..Options::default()
    };
    let judged = |warm_up_products| {
        let trace = run(&text, options(warm_up_products));
        (trace.requirements[0].value, trace.requirements[0].holds)
    };
    assert!(judged(5).1);
    assert_eq!(judged(1000), (None, false));
    let means = |warm_up_products| {
        let mut plant = plant_of(&text, options(warm_up_products));
        plant.replicate(2).1
    };
    let all = means(1000);
    assert_eq!(all.throughput_per_hour, None);
    assert!(all.measures.iter().all(|of| of.value.is_none()));
    assert!(means(5).throughput_per_hour.is_some());
}

#[test]
fn a_run_with_too_few_products_for_its_warm_up_says_so() {
    let text = LINE.replace("every 10 s", "every 10 s limit 2");
    for until in [None, Some(1000.0)] {
        let options = Options {
            parts: Some(2),
            until,
            warm_up_products: 3,
            ..Options::default()
        };
        let trace = run(&text, options);
        assert_eq!(trace.products, 0);
        let messages: Vec<&str> = trace.findings.iter().map(|f| f.message.as_str()).collect();
        let wanted = "before its warm-up of 3 products (2 made) was over";
        assert!(messages.iter().any(|m| m.contains(wanted)), "{messages:?}");
    }
}

/// Without requirements, too, a command without any figures does not look like success.
#[test]
fn runs_without_any_figures_are_an_error() {
    let text = LINE.replace("every 10 s", "every 10 s limit 2");
    let options = Options {
        parts: Some(2),
        warm_up_products: 3,
        ..Options::default()
    };
    for count in [1, 3] {
        let (_, figures) = plant_of(&text, options).replicate(count);
        let short = figures.findings.iter().filter(|f| f.code.id == "LW404");
        let short: Vec<_> = short.collect();
        assert_eq!(short.len(), 1, "{:?}", figures.findings);
        assert_eq!(short[0].severity, Severity::Error);
        assert_eq!(short[0].notes.is_empty(), count == 1);
    }
}

/// However many products are made during the warm-up, they do not end the run.
#[test]
fn products_of_the_warm_up_do_not_end_a_run() {
    for supply in ["every 10 s", "on order"] {
        let text = LINE.replace("every 10 s", supply);
        let options = Options {
            parts: Some(10),
            warm_up: 1000.0,
            ..Options::default()
        };
        let trace = run(&text, options);
        assert_eq!((trace.end, trace.products), (End::Products, 10), "{supply}");
        // Parts leave the line at 19, 34, ..., 1009, 1024 and so on.
        assert_eq!(trace.seconds, 1009.0 + 9.0 * 15.0, "{supply}");
    }
}

#[test]
fn a_run_that_ends_during_the_warm_up_says_so() {
    let text = LINE.replace("every 10 s", "every 10 s limit 2");
    let options = Options {
        parts: Some(2),
        warm_up: 1000.0,
        ..Options::default()
    };
    let trace = run(&text, options);
    assert_eq!((trace.end, trace.products), (End::Blocked, 0));
    let messages: Vec<&str> = trace.findings.iter().map(|f| f.message.as_str()).collect();
    assert!(
        messages
            .iter()
            .any(|m| m.contains("before its warm-up was over")),
        "{messages:?}"
    );
}

/// A line without anything left to do waits for its end; the warm-up ends meanwhile.
#[test]
fn the_warm_up_of_an_empty_line_ends() {
    let text = LINE.replace("every 10 s", "every 10 s limit 2");
    let trace = run(&text, until(1000.0, 400.0));
    assert_eq!(
        (trace.end, trace.warm_up, trace.products),
        (End::Time, 400.0, 0)
    );
    assert_eq!(trace.stations[0].shares.starved, 1.0);
    assert!((trace.joules - 6000.0).abs() < 1e-6, "{}", trace.joules);
    assert_eq!(trace.wip.mean, 0.0);
}

/// Parts come at 0, 10, 20, ...; the cell takes 15 s, so they queue up to three.
#[test]
fn buffers_and_work_in_process_are_measured() {
    let trace = run(LINE, until(30.0, 0.0));
    let queue = &trace.buffers[0];
    // In the cell: from 0 to 15, from 15 to 30. In the queue: one from 10 to 15, one from 20 on.
    assert_eq!((queue.passed, queue.longest), (3, 1));
    assert_eq!(queue.length, (5.0 + 10.0) / 30.0);
    assert_eq!(
        (queue.wait, queue.longest_wait),
        ((0.0 + 5.0 + 10.0) / 3.0, 10.0)
    );
    // On the belt: one part from 15 to 19.
    assert_eq!(trace.wip.mean, (30.0 + 15.0 + 4.0) / 30.0);
    assert_eq!(trace.wip.max, 3);
    let later = run(LINE, until(330.0, 200.0));
    assert_eq!(later.buffers[0].longest, 3);
    assert!(later.buffers[0].full > 0.5, "{}", later.buffers[0].full);
}

/// Little's law is checked in every run, so it is enough to run lines with joins, rejects and
/// stores.
#[test]
fn littles_law_holds_with_joins_and_rejects() {
    let text = "line L {
        part A
        part B { property bad: bool = false }
        part C from 2 A, 1 B
        source a: A every exponential(5 s)
        source b: B every exponential(10 s)
        buffer qa capacity 4
        buffer qb capacity 4
        station test { takes uniform(1 s, 9 s) defect on B probability 20 %: bad becomes true }
        station join { takes exponential(6 s) }
        sink bin rejects
        sink out
        route A: a -> qa -> join
        route B: b -> test
        route B: test -> bin when bad
        route B: test -> qb otherwise
        route B: qb -> join
        route C: join -> out
    }";
    for warm_up in [0.0, 777.0] {
        let trace = run(text, until(20_000.0, warm_up));
        assert!(trace.parts.rejected > 100 && trace.parts.consumed > 1000);
        assert!(trace.wip.mean > 2.0);
    }
}

#[test]
fn throughput_on_shift_counts_working_time() {
    let text = "line L {
        part P
        source rack: P every 0 s
        station cell { takes 7 s }
        sink out
        shift 6 h to 14 h
        route P: rack -> cell -> out
    }";
    let trace = run(text, until(3.0 * 86_400.0, 86_400.0));
    let on_shift = trace.throughput_on_shift.expect("the line has a shift");
    assert!((on_shift - 3600.0 / 7.0).abs() < 0.1, "{on_shift}");
    assert!((trace.throughput_per_hour - on_shift / 3.0).abs() < 1e-9);
}

/// The line fills for some two hundred seconds. The pilot run finds this, and the runs that follow
/// leave it out.
#[test]
fn the_warm_up_is_found() {
    let text = "line L {
        part P
        source rack: P every exponential(10 s)
        conveyor belt places 200 pitch 1 m speed 0.5 m/s
        buffer queue capacity 100
        station cell { takes exponential(8 s) }
        sink out
        route P: rack -> belt -> queue -> cell -> out
    }";
    let mut plant = plant_of(text, until(40_000.0, 0.0));
    let found = plant.find_warm_up().expect("the run is long enough");
    // Nothing leaves the belt within 400 s.
    assert!((400.0..10_000.0).contains(&found), "{found}");
    let trace = plant.run();
    assert_eq!(trace.warm_up, found);
    // The pilot run leaves nothing behind.
    let mut again = plant_of(text, until(40_000.0, found));
    assert_eq!(again.run().products, trace.products);
    assert_eq!(plant.find_warm_up().ok(), Some(found));
}

#[test]
fn a_line_that_never_becomes_steady_has_no_warm_up() {
    let text = "line L {
        part P
        source rack: P every 5 s
        buffer queue capacity 4000
        station cell { takes 10 s }
        sink out
        route P: rack -> queue -> cell -> out
    }";
    let found = plant_of(text, until(10_000.0, 0.0)).find_warm_up();
    let finding = found.expect_err("lead times grow without end");
    assert!(
        finding.message.contains("does not become steady"),
        "{}",
        finding.message
    );
}
