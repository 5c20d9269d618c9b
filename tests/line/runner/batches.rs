//! Batches of a run: their sums, their intervals, and the test of their correlation.

use crate::models::plant_of;
use linewright::contract::metric::Measure;
use linewright::diagnostics::{Severity, codes};
use linewright::line::batches::{Batches, critical_lag_1, lag_1};
use linewright::line::estimates::{Estimated, Subject};
use linewright::line::metric::measure;
use linewright::line::trace::{Trace, WaitKind};
use linewright::line::{End, Options, Verdict};

/// Everything that has figures: a queue, a join, a conveyor, failures, setup, overflow and rejects.
const ALL: &str = "line L {
    part A { property heavy: bool = false }
    part B
    source a: A every random 10 s
    source b: B every random 20 s
    buffer tray capacity 5
    conveyor belt places 4 power 50 W
    station press {
        takes exponential(6 s)
        power 200 W
        idle power 20 W
        setup 2 s
        failures mtbf 10 min mttr 40 s
    }
    station check { takes 3 s power 10 W }
    sink out
    sink floor rejects
    product A, B
    route A: a -> tray, floor
    route B: b -> tray, floor
    route A: tray -> press -> belt -> check
    route B: tray -> press -> belt -> check
    route A: check -> out, floor by probability 95 %
    route B: check -> out
    requirement p1: throughput >= 1 per hour
    requirement p2: lead_time <= 1 h
    requirement p3: wip <= 100
    requirement p4: energy <= 100 kWh
    requirement p5: energy_per_product <= 1 kWh
    requirement p6: rejected <= 100000
    requirement p7: products >= 1
    requirement p8: busy(press) >= 0.01
    requirement p9: starved(press) <= 1
    requirement q1: blocked(press) <= 1
    requirement q2: failed(press) <= 1
    requirement q3: setup(press) <= 1
    requirement q4: idle(press) <= 1
    requirement q5: length(tray) <= 5
    requirement q6: full(tray) <= 1
    requirement q7: wait(tray) <= 1 h
    requirement q8: lost(a) <= 1
    requirement r1: availability(press) <= 1
    requirement r2: effectiveness(press) <= 1
    requirement r3: quality(check) <= 1
    requirement r4: first_pass_yield <= 1
    requirement r5: scrap <= 1
    requirement r6: energy(press) <= 100 kWh
    requirement r7: energy(belt) <= 100 kWh
    requirement r8: length(belt) <= 4
    requirement r9: throughput(A) >= 1 per hour
    requirement s1: products(B) >= 1
    requirement s2: lead_time(A) <= 1 h
    requirement s3: expired(tray) <= 0
}";

fn run(text: &str, options: Options) -> (Trace, Batches) {
    let mut plant = plant_of(text, options);
    let trace = plant.run();
    let batches = Batches::of(plant.line(), &trace).expect("batches");
    (trace, batches)
}

fn until(seconds: f64, warm_up: f64, batches: u32) -> Options {
    Options {
        until: Some(seconds),
        warm_up,
        batches: Some(batches),
        ..Options::default()
    }
}

fn parts(count: u64, warm_up: f64, batches: u32) -> Options {
    Options {
        parts: Some(count),
        warm_up,
        batches: Some(batches),
        ..Options::default()
    }
}

/// The mean of the batches is the figure of the run, for every measure that has one, whether time
/// or products end the batches.
#[test]
fn batches_add_up_to_the_run() {
    for options in [
        until(40_000.0, 1000.0, 13),
        until(40_000.0, 0.0, 20),
        parts(3000, 1000.0, 17),
        parts(3000, 0.0, 10),
    ] {
        let (trace, batches) = run(ALL, options);
        let plant = plant_of(ALL, options);
        assert_eq!(Some(batches.count as u32), options.batches);
        let products: u64 = trace.batches.iter().map(|batch| batch.products).sum();
        assert_eq!(products, trace.products);
        let seconds: f64 = trace.batches.iter().map(|batch| batch.seconds).sum();
        assert!((seconds - (trace.seconds - trace.warm_up)).abs() < 1e-6);
        for (requirement, result) in plant.line().requirements.iter().zip(&batches.requirements) {
            let of_run = measure(&requirement.metric, &trace).expect("a value");
            let mean = result.value.expect("a value").mean;
            assert!(
                (mean - of_run).abs() <= 1e-9 * of_run.abs(),
                "{}: {mean} and {of_run}",
                requirement.name
            );
            assert_eq!(result.runs, batches.count, "{}", requirement.name);
        }
    }
}

/// Every measure has an interval, over batches and over replications. The shares of the causes add
/// up to the blocked and starved time, and the energy by state to all energy.
#[test]
fn all_measures_have_intervals() {
    let options = until(40_000.0, 1000.0, 13);
    let (trace, batches) = run(ALL, options);
    let runs = Options {
        batches: None,
        ..options
    };
    let mut plant = plant_of(ALL, runs);
    let (traces, replications) = plant.replicate(5);
    assert!(traces[0].wip_over_time.is_some());
    assert!(
        traces[1..]
            .iter()
            .all(|trace| trace.wip_over_time.is_none())
    );
    for (measures, is_exact) in [(&batches.measures, true), (&replications.measures, false)] {
        let value = |wanted: &dyn Fn(&Subject) -> bool| {
            let found = measures.iter().filter(|of| wanted(&of.subject));
            found.map(|of| of.value.expect("a value").mean).sum::<f64>()
        };
        for of in measures {
            let estimate = of.value.expect("a value");
            assert!(estimate.half_width.is_some(), "{of:?}");
        }
        let node = trace.stations[0].node;
        for (kind, measure) in [
            (WaitKind::Blocked, Measure::Blocked),
            (WaitKind::Starved, Measure::Starved),
        ] {
            let whole = value(&|of| *of == Subject::Metric(measure.at(node..node + 1)));
            let causes = value(
                &|of| matches!(of, Subject::Wait(cause) if cause.node == node && cause.kind == kind),
            );
            assert!((whole - causes).abs() < 1e-9, "{whole} {causes}");
        }
        let whole = value(&|of| *of == Subject::Metric(Measure::Energy.at(node..node + 1)));
        let states = value(&|of| matches!(of, Subject::Energy { node: of, .. } if *of == node));
        assert!((whole - states).abs() < 1e-9 * whole, "{whole} {states}");
        if is_exact {
            let kwh = trace.stations[0].joules / 3.6e6;
            assert!((whole - kwh).abs() < 1e-9 * kwh, "{whole} {kwh}");
        }
    }
    let names = |measures: &[Estimated]| -> Vec<Measure> {
        let measures = measures.iter();
        measures.map(|of| of.subject.measure()).collect()
    };
    let (of_batches, of_runs) = (names(&batches.measures), names(&replications.measures));
    assert!(of_batches.contains(&Measure::Oee) && of_batches.contains(&Measure::Wait));
    assert!(of_runs.contains(&Measure::WaitMax) && of_runs.contains(&Measure::LeadTimeMedian));
    assert!(!of_batches.contains(&Measure::WipMax));
}

/// Apart from the batches, a run with them is the same as one without.
#[test]
fn batches_do_not_change_the_run() {
    for options in [
        until(20_000.0, 1000.0, 20),
        parts(500, 0.0, 10),
        // It rests from some time on.
        until(1e6, 0.0, 10),
    ] {
        let text = ALL.replace("every random 20 s", "every random 20 s limit 300");
        let text = text.replace("every random 10 s", "every random 10 s limit 700");
        let (with, _) = run(&text, options);
        let without = plant_of(
            &text,
            Options {
                batches: None,
                ..options
            },
        )
        .run();
        assert_eq!(with.batches.len() as u32, options.batches.unwrap_or(0));
        let printed = |trace: &Trace| {
            let plant = plant_of(&text, options);
            linewright::report::json(plant.line(), trace, None, None).to_string()
        };
        assert_eq!(printed(&with), printed(&without));
    }
}

/// The statistic by hand: 1..=10 has squared deviations 82.5 and nine steps of 1, so it is
/// 1 - 9 / 165; alternating signs give 1 - 9 * 4 / 20.
#[test]
fn the_lag_1_autocorrelation_of_known_values() {
    let growing: Vec<f64> = (1..=10).map(f64::from).collect();
    assert!((lag_1(&growing).expect("a value") - (1.0 - 9.0 / 165.0)).abs() < 1e-12);
    let alternating: Vec<f64> = (0..10).map(|i| f64::from(1 - 2 * (i % 2))).collect();
    assert!((lag_1(&alternating).expect("a value") + 0.8).abs() < 1e-12);
    // 1.644854 * sqrt(8 / 99) and 1.644854 * sqrt(18 / 399).
    assert!((critical_lag_1(10) - 0.467_578).abs() < 1e-6);
    assert!((critical_lag_1(20) - 0.349_363).abs() < 1e-6);
    assert_eq!(lag_1(&[0.1; 20]), None);
    assert_eq!(lag_1(&growing[..7]), None);
}

/// A queue with exponential arrivals and services, and a station that is busy half of the time.
const QUEUE: &str = "line L {
    part P
    source rack: P every random 10 s
    buffer queue capacity 100000
    station cell { takes exponential(5 s) }
    sink out
    route P: rack -> queue -> cell -> out
    requirement pace: throughput >= 360 per hour
    requirement fast: lead_time <= 10 s
    requirement kept: wip <= 1
}";

/// The intervals cover the true values of M/M/1 about as often as they say: mean time 1 / (mu -
/// lambda), mean number rho / (1 - rho), in batches of some 500 parts.
#[test]
fn intervals_cover_the_truth() {
    const RUNS: u64 = 1000;
    let truth = [360.0, 10.0, 1.0];
    for options in [until(105_000.0, 5000.0, 20), parts(10_000, 5000.0, 20)] {
        let mut plant = plant_of(QUEUE, options);
        let (mut covered, mut warned) = ([0_u64; 3], 0_u64);
        for seed in 1..=RUNS {
            let trace = plant.run_seeded(seed);
            let batches = Batches::of(plant.line(), &trace).expect("batches");
            for (result, (covered, truth)) in batches
                .requirements
                .iter()
                .zip(covered.iter_mut().zip(truth))
            {
                let value = result.value.expect("a value");
                let half = value.half_width.expect("an interval");
                *covered += u64::from((value.mean - truth).abs() <= half);
            }
            let is_warning = |f: &&linewright::diagnostics::Diagnostic| f.code == codes::LINE_LIMIT;
            warned += u64::from(batches.findings.iter().any(|f| is_warning(&f)));
        }
        for covered in covered {
            let share = covered as f64 / RUNS as f64;
            assert!((0.93..=0.97).contains(&share), "{options:?}: {share}");
        }
        // Several measures are tested at 5 % each.
        assert!(warned < RUNS / 5, "{warned}");
    }
}

/// With batches of 25 parts, a queue at 95 % shows in the test, and the finding says what to do.
#[test]
fn short_batches_are_reported() {
    let text = QUEUE.replace("exponential(5 s)", "exponential(9.5 s)");
    let (_, batches) = run(&text, until(6000.0, 1000.0, 20));
    let finding = batches
        .findings
        .iter()
        .find(|f| f.code == codes::LINE_LIMIT);
    let finding = finding.expect("a finding");
    assert_eq!(finding.severity, Severity::Warning);
    assert!(
        finding
            .message
            .contains("the batches of L may be too short")
            && finding
                .message
                .contains("the mean lead time in seconds (0."),
        "{}",
        finding.message
    );
    let help = finding.help.as_deref().expect("a help");
    assert!(
        help.contains("Let the run last longer, take fewer batches"),
        "{help}"
    );
}

/// A bound in the interval is undecided, one outside of it is not; maxima and violations are judged
/// by the run.
#[test]
fn requirements_are_judged_by_the_interval() {
    let text = QUEUE.replace(
        "requirement kept",
        "requirement most: wip_max <= 1000
    requirement few: wip_max <= 2
    requirement whole: violations = 0
    requirement good: rejected = 0
    requirement slow: throughput >= 400 per hour
    requirement kept",
    );
    let (trace, batches) = run(&text, until(305_000.0, 5000.0, 20));
    let words: Vec<_> = batches
        .requirements
        .iter()
        .map(|r| (r.name.as_str(), r.verdict.word(), r.runs))
        .collect();
    assert_eq!(
        words,
        [
            ("pace", "undecided", 20),
            ("fast", "undecided", 20),
            ("most", "holds", 1),
            ("few", "fails", 1),
            ("whole", "holds", 1),
            ("good", "holds", 20),
            ("slow", "fails", 20),
            ("kept", "undecided", 20),
        ]
    );
    let pace = &batches.requirements[0];
    let (Verdict::Undecided { more: Some(more) }, Some(times)) =
        (pace.verdict, pace.times_as_long())
    else {
        panic!("{pace:?}");
    };
    assert!((times - (20 + more) as f64 / 20.0).abs() < 1e-12);
    let of = |name: &str| {
        let findings = batches.findings.iter().map(|f| &f.message);
        let mut found = findings.filter(|m| m.contains(&format!("requirement {name} ")));
        found.next().cloned().unwrap_or_default()
    };
    assert!(of("slow").contains("20 batches), and should be at least 400"));
    assert_eq!(
        of("few"),
        format!(
            "the requirement few does not hold: the maximum WIP in parts is {}, and should be at most 2",
            trace.wip.max
        )
    );
}

/// A batch in which no product was finished shows nothing: the requirement is undecided.
#[test]
fn a_batch_without_a_product_decides_nothing() {
    let text = QUEUE.replace("every random 10 s", "every 100 s limit 5");
    let (trace, batches) = run(&text, until(1000.0, 0.0, 10));
    assert_eq!((trace.end, trace.products), (End::Time, 5));
    let fast = &batches.requirements[1];
    assert_eq!(fast.verdict, Verdict::Undecided { more: None });
    assert_eq!(fast.value.and_then(|value| value.half_width), None);
    let finding = batches
        .findings
        .iter()
        .find(|f| f.message.contains("requirement fast"));
    let finding = finding.expect("a finding");
    assert!(
        finding
            .message
            .contains("nothing to measure in some of 10 batches"),
        "{}",
        finding.message
    );
}

#[test]
fn batches_need_one_end_and_products() {
    let refused = |options: Options| {
        let line = plant_of(QUEUE, until(100.0, 0.0, 10)).line().clone();
        let found =
            linewright::line::Plant::new(line.into(), std::collections::BTreeMap::new(), options);
        let mut found = found.err().expect("findings");
        found.remove(0)
    };
    let both = refused(Options {
        until: Some(1000.0),
        ..parts(1000, 0.0, 20)
    });
    assert!(both.message.contains("has two ends"), "{}", both.message);
    let few = refused(parts(100, 0.0, 20));
    assert_eq!(few.code, codes::LINE_LIMIT);
    assert!(
        few.help
            .as_deref()
            .is_some_and(|help| help.contains("`--parts 200`")),
        "{few:?}"
    );
}

/// Batches that are not whole days see other shifts.
#[test]
fn batches_of_a_line_with_shifts_are_whole_days() {
    let text = QUEUE.replace("requirement pace", "shift 6 h to 14 h\n requirement pace");
    let warned = |text: &str, days: f64| {
        let (_, batches) = run(text, until(days * 86_400.0, 0.0, 10));
        let mut findings = batches.findings.iter();
        let found = findings.find(|f| f.message.contains("each sees other shifts"));
        found.and_then(|finding| finding.help.clone())
    };
    assert_eq!(warned(&text, 10.0), None);
    let help = warned(&text, 5.0).expect("a finding");
    assert_eq!(help, "Let each batch last whole days: `--until 864000`.");
    let weekly = text.replace("14 h\n", "14 h on Monday to Friday\n");
    let help = warned(&weekly, 10.0).expect("a finding");
    assert_eq!(help, "Let each batch last whole weeks: `--until 6048000`.");
    assert_eq!(warned(&weekly, 70.0), None);
}
