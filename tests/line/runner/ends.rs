//! The end of a run, its checks, and lines that are refused before they run.

use crate::models::{Builder, at_random, constant, every, plant_of, span};
use linewright::contract::line::{Comparison, Limit, Measure, Metric, Requirement};
use linewright::deadline::Deadline;
use linewright::line::replicate::replicate;
use linewright::line::{Count, End, Options, Plant, Trace};
use std::sync::Arc;
use std::time::Duration;

fn simple() -> Builder {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(10.0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"]);
    builder
}

#[test]
fn the_options_go_before_the_line_s_limit() {
    let run = |parts, until, limit| {
        let mut builder = simple();
        builder.limit(limit);
        let trace = builder
            .plant(Options {
                parts,
                until,
                ..Options::default()
            })
            .run();
        (trace.end, trace.products, trace.seconds)
    };
    let limit = Limit::Products(3);
    assert_eq!(run(None, None, limit), (End::Products, 3, 30.0));
    assert_eq!(run(Some(5), None, limit), (End::Products, 5, 50.0));
    assert_eq!(run(None, Some(45.0), limit), (End::Time, 4, 45.0));
    assert_eq!(run(Some(5), Some(45.0), limit), (End::Time, 4, 45.0));
    assert_eq!(run(Some(4), Some(45.0), limit), (End::Products, 4, 40.0));
    assert_eq!(run(Some(0), None, limit), (End::Products, 0, 0.0));
    assert_eq!(run(None, None, Limit::Seconds(25.0)), (End::Time, 2, 25.0));
}

#[test]
fn a_run_without_an_end_is_refused() {
    let mut builder = simple();
    let refused = Plant::new(
        Arc::new(builder.line.clone()),
        std::mem::take(&mut builder.controllers),
        Options::default(),
    );
    let findings = refused.err().unwrap();
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].code.id, "LW404");
}

#[test]
fn a_broken_line_is_refused_not_run() {
    let mut builder = simple();
    builder.line.routes[0].to = 99;
    builder.line.routes[1].part = 7;
    builder.controllers.clear();
    let refused = Plant::new(
        Arc::new(builder.line.clone()),
        std::mem::take(&mut builder.controllers),
        Options {
            parts: Some(1),
            ..Options::default()
        },
    );
    assert_eq!(refused.err().unwrap().len(), 3);
}

#[test]
fn requirements_are_checked() {
    let mut builder = simple();
    for (name, metric, comparison, bound) in [
        ("fast", Measure::Throughput.into(), Comparison::Ge, 400.0),
        ("busy", Measure::Busy.at(1..2), Comparison::Eq, 1.0),
        ("clean", Measure::Rejected.into(), Comparison::Le, 0.0),
        ("frugal", Measure::Energy.into(), Comparison::Lt, 1.0),
    ] {
        builder.require(Requirement {
            name: name.to_owned(),
            metric,
            comparison,
            bound,
            span: span(),
        });
    }
    let trace = builder.run(10);
    let holds: Vec<bool> = trace.requirements.iter().map(|r| r.holds).collect();
    assert_eq!(holds, [false, true, true, true]);
    assert_eq!(trace.findings.len(), 1);
    assert_eq!(trace.findings[0].code.id, "LW406");
    insta::assert_snapshot!(trace.findings[0].message, @r#"the requirement fast does not hold: the throughput in products an hour is 360, and should be at least 400"#);
}

/// The help for a requirement names the bottleneck only where the pace matters.
#[test]
fn the_help_for_a_requirement_fits_its_metric() {
    let help = |metric: Metric, comparison, bound| {
        let mut builder = simple();
        builder.require(Requirement {
            name: "asked".to_owned(),
            metric,
            comparison,
            bound,
            span: span(),
        });
        let trace = builder.run(10);
        trace.findings[0].help.clone().unwrap_or_default()
    };
    let pace = help(Measure::Throughput.into(), Comparison::Ge, 1e6);
    assert!(pace.contains("The bottleneck of"), "{pace}");
    let energy = help(Measure::Energy.into(), Comparison::Lt, 0.0);
    assert!(energy.contains("% of the energy of"), "{energy}");
    let share = help(Measure::Busy.at(1..2), Comparison::Lt, 0.0);
    assert_eq!(share, "Change the line or the requirement.");
}

#[test]
fn replications_use_different_seeds() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", at_random(5.0, None))
        .buffer("buffer", 1000)
        .station("cell", &["Part"], constant(1.0))
        .sink("sink")
        .route("Part", &["source", "buffer", "cell", "sink"]);
    let mut plant = builder.plant(Options {
        parts: Some(200),
        ..Options::default()
    });
    let (traces, figures) = plant.replicate(20);
    assert_eq!(figures.seeds, (1..=20).collect::<Vec<_>>());
    assert_eq!(traces.len(), 20);
    assert_ne!(traces[0].seconds.to_bits(), traces[1].seconds.to_bits());
    let throughput = figures.throughput_per_hour.expect("it is measured");
    let half = throughput.half_width.unwrap();
    assert!((throughput.mean - 720.0).abs() < 2.0 * half && half > 0.0);
    // Repeated: a run leaves nothing behind.
    assert_eq!(plant.replicate(20).1, figures);
    let _ = every(0.0, None);
}

/// Once the deadline is past no further run begins, and a finding says so.
#[test]
fn replications_keep_the_time_limit() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .station("cell", &["Part"], constant(1.0))
        .sink("sink")
        .route("Part", &["source", "cell", "sink"]);
    let mut plant = builder.plant(Options {
        parts: Some(1),
        deadline: Deadline::from_now(Duration::ZERO),
        ..Options::default()
    });
    let (traces, figures) = plant.replicate(5);
    assert_eq!(traces.len(), 1);
    let last = figures.findings.last().unwrap();
    assert_eq!(last.code.id, "LW204");
    assert_eq!(
        last.message,
        "the time limit was reached: 1 of 5 runs were complete"
    );
}

/// A run that is cut off at the limit is in no mean, and no requirement is judged by it.
#[test]
fn a_run_that_was_cut_off_counts_nowhere() {
    let mut builder = simple();
    builder.require(Requirement {
        name: "few".to_owned(),
        metric: Measure::Rejected.into(),
        comparison: Comparison::Le,
        bound: 0.0,
        span: span(),
    });
    let mut plant = builder.plant(Options {
        until: Some(4e9),
        deadline: Deadline::from_now(Duration::ZERO),
        ..Options::default()
    });
    let (traces, figures) = plant.replicate(3);
    assert_eq!(traces[0].end, End::GaveUp);
    assert_eq!(
        (traces[0].requirements.len(), figures.requirements.len()),
        (0, 0)
    );
    let last = figures.findings.last().unwrap();
    assert!(
        last.message.ends_with("0 of 3 runs were complete"),
        "{}",
        last.message
    );

    let soon = Deadline::from_now(Duration::from_millis(300));
    let mut plant = simple().plant(Options {
        until: Some(2e4),
        deadline: soon,
        ..Options::default()
    });
    let (traces, figures) = plant.replicate(1_000_000);
    let over = traces.iter().filter(|t| t.end != End::GaveUp).count();
    assert!(over == traces.len() || traces.len() == 1);
    let last = figures.findings.last().unwrap();
    let wanted = format!("{over} of 1000000 runs were complete");
    assert!(last.message.ends_with(&wanted), "{}", last.message);
}

/// Without a product there is no lead time, so no bound on it is kept.
#[test]
fn what_was_not_measured_holds_of_nothing() {
    let run = |seconds: f64| -> Vec<bool> {
        let mut builder = simple();
        for metric in [
            Measure::LeadTime.into(),
            Measure::Makespan.into(),
            Measure::Rejected.into(),
        ] {
            builder.require(Requirement {
                name: "few".to_owned(),
                metric,
                comparison: Comparison::Le,
                bound: 100.0,
                span: span(),
            });
        }
        let trace = builder.run_until(seconds);
        trace.requirements.iter().map(|r| r.holds).collect()
    };
    assert_eq!(run(5.0), [false, false, true]);
    assert_eq!(run(15.0), [true, true, true]);
}

/// A queue with random arrivals and services.
const QUEUE: &str = "line L {
    part P
    source rack: P every exponential(10 s)
    buffer queue capacity 50
    station cell { takes exponential(7 s) }
    sink out
    route P: rack -> queue -> cell -> out
}";

#[test]
fn replications_do_not_depend_on_the_number_of_threads() {
    let options = Options {
        parts: Some(300),
        ..Options::default()
    };
    let make = |_: bool| Ok(plant_of(QUEUE, options));
    let (traces, figures) = plant_of(QUEUE, options).replicate(23);
    for threads in [1, 2, 3, 8, 40] {
        let (other, same) = replicate(threads, make, Count::Fixed(23), None).expect("it runs");
        assert_eq!(figures, same, "{threads} threads");
        let seconds = |traces: &[Trace]| -> Vec<f64> { traces.iter().map(|t| t.seconds).collect() };
        assert_eq!(seconds(&traces), seconds(&other), "{threads} threads");
    }
}

#[test]
fn replications_go_on_until_they_are_precise() {
    let options = Options {
        parts: Some(300),
        ..Options::default()
    };
    let make = |_: bool| Ok(plant_of(QUEUE, options));
    let count = Count::Until {
        precision: 0.05,
        most: 1000,
    };
    let (_, figures) = replicate(2, make, count, None).expect("it runs");
    let runs = figures.seeds.len();
    assert!((20..1000).contains(&runs), "{runs}");
    for estimate in [figures.throughput_per_hour, figures.lead_time] {
        let estimate = estimate.expect("it is measured");
        assert!(estimate.half_width.expect("several runs") <= 0.05 * estimate.mean);
    }
    assert!(figures.findings.is_empty());
    // The same runs as with a fixed number.
    let (_, fixed) = replicate(3, make, Count::Fixed(runs as u64), None).expect("it runs");
    assert_eq!(fixed, figures);

    let count = Count::Until {
        precision: 0.001,
        most: 30,
    };
    let (_, figures) = replicate(2, make, count, None).expect("it runs");
    assert_eq!(figures.seeds.len(), 30);
    assert_eq!(figures.findings.len(), 1);
    assert!(figures.findings[0].message.contains("cannot give"));
}
