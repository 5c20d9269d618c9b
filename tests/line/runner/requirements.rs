//! Requirements: what they speak of, and how several runs are judged.

use crate::models::plant_of;
use linewright::line::trace::Oee;
use linewright::line::{Options, Replications, Trace, Verdict};
use linewright::report;

fn runs(text: &str, count: u64, until: f64) -> (Vec<Trace>, Replications) {
    let options = Options {
        until: Some(until),
        ..Options::default()
    };
    plant_of(text, options).replicate(count)
}

fn verdicts(figures: &Replications) -> Vec<&'static str> {
    let requirements = figures.requirements.iter();
    requirements.map(|r| r.verdict.word()).collect()
}

/// M/D/1 with one arrival a second: 3600 parts an hour are neither reached nor missed.
const M_D_1: &str = "line L {
    part P
    source rack: P every random 1 s
    buffer queue capacity 1000
    station cell { takes 0.8 s }
    sink out
    route P: rack -> queue -> cell -> out
    requirement pace: throughput >= 3600 per hour
    requirement half: throughput >= 1800 per hour
    requirement twice: throughput >= 7200 per hour
    requirement quick: lead_time <= 2.4 s
    requirement sound: violations = 0
    requirement made: products >= 1
}";

#[test]
fn a_bound_in_the_interval_is_undecided() {
    let (traces, figures) = runs(M_D_1, 6, 2e4);
    assert_eq!(
        verdicts(&figures),
        ["undecided", "holds", "fails", "undecided", "holds", "holds"]
    );
    let findings: Vec<_> = figures
        .findings
        .iter()
        .map(|f| (f.code.id, f.gave_up))
        .collect();
    assert_eq!(
        findings,
        [("LW406", true), ("LW406", false), ("LW406", true)]
    );
    assert_eq!(traces.len(), 6);
}

/// The number of further runs is an estimate: with as many, the interval is narrow enough if the
/// mean does not move towards the bound.
#[test]
fn more_runs_decide() {
    let text = M_D_1.replace(">= 3600 per", ">= 3570 per");
    let (_, figures) = runs(&text, 4, 2e4);
    let Verdict::Undecided { more: Some(more) } = figures.requirements[0].verdict else {
        panic!("{:?}", figures.requirements[0]);
    };
    let (_, figures) = runs(&text, 4 + 2 * more, 2e4);
    assert_eq!(verdicts(&figures)[0], "holds");
}

/// Some runs have no rejected part. Their interval contains 0, but the mean is greater than 0.
#[test]
fn what_cannot_be_negative_is_not_undecided_at_zero() {
    let text = "line L {
        part P
        source rack: P every random 10 s
        buffer queue capacity 1
        station cell { takes 5 s }
        sink out
        sink floor rejects
        route P: rack -> queue, floor
        route P: queue -> cell -> out
        requirement none: rejected = 0
        requirement few: rejected <= 0
        requirement some: rejected > 0
        requirement free: lost(rack) <= 0 %
        requirement always_full: full(queue) >= 100 %
    }";
    let (traces, figures) = runs(text, 10, 150.0);
    let rejected: Vec<u64> = traces.iter().map(|t| t.parts.rejected).collect();
    assert!(
        rejected.contains(&0) && rejected.iter().any(|n| *n > 0),
        "{rejected:?}"
    );
    assert_eq!(
        verdicts(&figures),
        ["fails", "fails", "holds", "fails", "fails"]
    );
    let first = &figures.findings[0].message;
    assert!(first.contains("does not hold in "), "{first}");
}

/// Every figure of the report can be required.
#[test]
fn requirements_speak_of_all_measures() {
    let text = "line L {
        part P
        source rack: P every exponential(10 s)
        buffer queue capacity 3
        buffer rest capacity 9 shelf life 20 s
        conveyor belt places 4 power 100 W
        station cell times 2 { takes exponential(15 s) power 1 kW failures mtbf 5 min mttr 10 s }
        station last { takes exponential(6 s) }
        sink out
        sink floor rejects
        route P: rack -> queue, floor
        route P: queue -> cell -> belt -> rest -> last -> out
        requirement a: throughput_on_shift >= 0 per hour
        requirement b: lead_time_median >= 0 s
        requirement c: lead_time_p95 >= 0 s
        requirement d: lead_time_max >= 0 s
        requirement e: wip >= 0
        requirement f: wip_max >= 0
        requirement g: energy_per_product >= 0 kWh
        requirement h: starved(cell) >= 0 %
        requirement i: blocked(cell) >= 0 %
        requirement j: failed(cell) >= 0 %
        requirement k: setup(cell) >= 0 %
        requirement l: idle(cell) >= 0 %
        requirement m: busy(cell) >= 0 %
        requirement n: length(queue) >= 0
        requirement o: length_max(queue) >= 0
        requirement p: full(queue) >= 0 %
        requirement q: wait(queue) >= 0 s
        requirement r: wait_max(queue) >= 0 s
        requirement s: lost(rack) >= 0 %
        requirement t: first_pass_yield >= 0 %
        requirement u: scrap >= 0 %
        requirement v: oee(cell) >= 0 %
        requirement w: availability(cell) >= 0 %
        requirement x: effectiveness(cell) >= 0 %
        requirement y: quality(cell) >= 0 %
        requirement z: expired(rest) >= 0
        requirement aa: energy(cell) >= 0 kWh
        requirement ab: energy(belt) >= 0 kWh
        requirement ac: length(belt) >= 0
        requirement ad: length_max(belt) >= 0
        requirement ae: throughput(P) >= 0 per hour
        requirement af: lead_time(P) >= 0 s
        requirement ag: products(P) >= 0
        requirement ah: lead_time_p50 >= 0 s
    }";
    let mut plant = plant_of(
        text,
        Options {
            until: Some(1e5),
            ..Options::default()
        },
    );
    let trace = plant.run();
    let values: Vec<f64> = trace
        .requirements
        .iter()
        .map(|r| r.value.unwrap())
        .collect();
    let (queue, source) = (&trace.buffers[0], &trace.sources[0]);
    let share = |of: fn(&linewright::line::trace::ByState) -> f64| {
        let cells = trace.stations.iter().take(2);
        cells.map(|s| of(&s.shares)).sum::<f64>() / 2.0
    };
    let factor = |of: fn(&Oee) -> f64| {
        let cells = trace.stations.iter().take(2);
        cells.map(|s| of(s.oee.as_ref().unwrap())).sum::<f64>() / 2.0
    };
    let belt = &trace.conveyors[0];
    let expected = [
        trace.throughput_per_hour,
        trace.lead_time.p50,
        trace.lead_time.p95,
        trace.lead_time.max,
        trace.wip.mean,
        trace.wip.max as f64,
        trace.joules / 3.6e6 / trace.products as f64,
        share(|s| s.starved),
        share(|s| s.blocked),
        share(|s| s.failed),
        share(|s| s.setup),
        share(|s| s.idle),
        share(|s| s.busy),
        queue.length,
        queue.longest as f64,
        queue.full,
        queue.wait,
        queue.longest_wait,
        source.lost,
        trace.yields.first_pass_yield().unwrap(),
        trace.yields.scrap_ratio().unwrap(),
        trace
            .stations
            .iter()
            .take(2)
            .map(|s| s.oee.as_ref().unwrap().index())
            .sum::<f64>()
            / 2.0,
        factor(|oee| oee.availability),
        factor(|oee| oee.effectiveness),
        factor(|oee| oee.quality),
        trace.buffers[1].expired as f64,
        f64::midpoint(trace.stations[0].joules, trace.stations[1].joules) / 3.6e6,
        belt.joules / 3.6e6,
        belt.length,
        belt.longest as f64,
        trace.throughput_per_hour,
        trace.lead_time.mean,
        trace.products as f64,
        trace.lead_time.p50,
    ];
    for (index, (value, expected)) in values.iter().zip(expected).enumerate() {
        assert!(
            (value - expected).abs() < 1e-12,
            "{index}: {value} {expected}"
        );
    }
    assert!(values[9] > 0.0 && values[18] > 0.0 && values[25] > 0.0 && values[28] > 0.0);
    let table = report::table(plant.line(), &trace, None);
    for row in [
        "mean wait in s in queue >= 0",
        "starved share of cell[1] to cell[2] >= 0",
        "energy per product in kWh >= 0",
        "95th percentile of lead time in s >= 0",
        "50th percentile of lead time in s >= 0",
        "energy in kWh of belt >= 0",
        "mean lead time in s of type P >= 0",
    ] {
        assert!(table.contains(row), "{row}\n{table}");
    }
}

/// Of two products with known lead times and a known wait, everything can be required of one.
#[test]
fn requirements_speak_of_one_product_and_of_any_percentile() {
    // An A comes every 10 s and needs 4 s. A B comes with every second A, goes first, and needs
    // 2 s.
    let text = "line L {
        part A
        part B
        source a: A every 10 s
        source b: B every 20 s
        buffer queue capacity 3
        station cell { takes 4 s an A takes 2 s a B power 90 W idle power 9 W }
        sink out
        product A, B
        route A: a -> queue -> cell -> out
        route B: b -> queue -> cell -> out
        requirement a: throughput(A) = 360 per hour
        requirement b: throughput_on_shift(B) = 180 per hour
        requirement c: products(B) = 500
        requirement d: lead_time(A) = 5 s
        requirement e: lead_time_p99(B) = 2 s
        requirement f: lead_time_p90 = 6 s
        requirement g: wait_p60(queue) = 0 s
        requirement h: wait_p70(queue) = 2 s
        requirement i: lead_time_max(A) = 6 s
        requirement j: lead_time_median(B) = 2 s
    }";
    let mut plant = plant_of(
        text,
        Options {
            until: Some(10_008.0),
            warm_up: 8.0,
            ..Options::default()
        },
    );
    let trace = plant.run();
    let unmet: Vec<_> = trace.requirements.iter().filter(|r| !r.holds).collect();
    assert!(unmet.is_empty(), "{unmet:?}");
    // 4 s of 10 s, and 2 s of 20 s.
    let joules = trace.stations[0].joules_by_state;
    assert!(
        (joules.busy - 10_000.0 * 0.5 * 90.0).abs() < 1e-3,
        "{joules:?}"
    );
    assert!((joules.starved - 10_000.0 * 0.5 * 9.0).abs() < 1e-3);
    let all: f64 = joules.figures().iter().sum();
    assert!((all - trace.stations[0].joules).abs() < 1e-6);
    // A bin has three of the periods of 20 s.
    let over_time = trace.wip_over_time.expect("WIP over time");
    assert!((over_time.bin_seconds - 60.0).abs() < 1e-9);
    assert_eq!(over_time.means.len(), 167);
    for mean in &over_time.means[1..166] {
        assert!((mean - trace.wip.mean).abs() < 1e-9, "{mean}");
    }
}

#[test]
fn a_wait_that_nothing_had_is_not_measured() {
    let text = "line L {
        part P
        source rack: P every 1 h limit 1
        buffer queue capacity 3
        station cell { takes 1 d }
        sink out
        route P: rack -> cell -> queue -> out
        requirement brief: wait(queue) <= 1 min
    }";
    let (traces, _) = runs(text, 1, 60.0);
    assert_eq!(
        traces[0].findings[0].message,
        "the requirement brief does not hold: the mean wait in seconds in queue was not measured, since no part left it, \
         and should be at most 60"
    );
}

/// With few short runs, Student's interval reaches beyond what is possible. It is cut to the range
/// of the measure; verdicts are those of the whole interval.
#[test]
fn intervals_lie_in_the_range_of_the_measure() {
    let (_, figures) = runs(
        "line L {
            part P
            source rack: P every random 10 s
            buffer queue capacity 5 shelf life 1 min
            station cell { takes exponential(8 s) failures mtbf 3 min mttr 2 min }
            sink out sink lost rejects
            route P: rack -> queue, lost
            route P: queue -> cell -> out
            requirement free: full(queue) <= 30 %
            requirement young: expired(queue) <= 2
        }",
        3,
        300.0,
    );
    let mut cut = 0;
    for of in &figures.measures {
        let Some((value, (low, high))) = of.value.and_then(|v| Some((v, v.interval()?))) else {
            continue;
        };
        let half = value.half_width.expect("an interval");
        let greatest = of.subject.measure().info().unit.greatest();
        assert!(
            low >= 0.0 && high <= greatest.unwrap_or(f64::INFINITY),
            "{of:?}"
        );
        assert!((low..=high).contains(&value.mean), "{of:?}");
        cut += usize::from(low > value.mean - half || high < value.mean + half);
    }
    assert!(cut > 5, "{cut}");
    for requirement in &figures.requirements {
        let value = requirement.value.expect("a value");
        let (low, _) = value.interval().expect("an interval");
        assert!(low >= 0.0);
        assert!(
            value.mean - value.half_width.expect("an interval") < 0.0,
            "{requirement:?}"
        );
        assert_eq!(requirement.verdict.word(), "undecided");
    }
}
