//! Overall equipment effectiveness, first-pass yield and scrap: against calculations by hand, and
//! against known probabilities.

use crate::models::plant_of;
use linewright::line::trace::Oee;
use linewright::line::{Batches, Options, Trace};

fn run(text: &str, options: Options) -> Trace {
    plant_of(text, options).run()
}

/// A shift of an hour, followed by an hour off shift. A plate takes 10 min. The station fails
/// 23 min after each repair, also off shift, for 5 min, and begins its work again:
///
/// | minutes | |
/// |---|---|
/// | 0-20 | two plates |
/// | 20-23, 23-28 | work that is lost, and the repair |
/// | 28-48 | two plates |
/// | 48-51, 51-56 | work that is lost, and the repair |
/// | 56-60 | work that is lost by the failure at 79 |
/// | 60-120 | off shift, with two repairs |
///
/// One of the four plates is of a kind that is rejected.
#[test]
fn the_factors_are_those_of_a_calculation_by_hand() {
    let text = "line L {
        part P
        part Q
        product P
        shift 0 h to 1 h
        source first: P every 0 s limit 3
        source second: Q every 5 min limit 4
        buffer both capacity 9
        station cell {
            takes 10 min
            failures mtbf constant(23 min) mttr constant(5 min) by calendar restart
        }
        sink out
        sink bin rejects
        route P: first -> both -> cell -> out
        route Q: second -> both -> cell -> bin
    }";
    let options = Options {
        until: Some(7200.0),
        ..Options::default()
    };
    let trace = run(text, options);
    let cell = &trace.stations[0];
    let minutes = |share: f64| (share * 120.0 * 1e6).round() / 1e6;
    assert_eq!((cell.processed, cell.busy_seconds / 60.0), (4, 50.0));
    assert_eq!(minutes(cell.shares.failed), 20.0);
    assert_eq!(minutes(cell.shares.idle), 50.0);
    assert_eq!(cell.scrapped, 1);
    let oee = cell.oee.unwrap();
    let expected = Oee {
        availability: 50.0 / 60.0,
        effectiveness: 40.0 / 50.0,
        quality: 3.0 / 4.0,
    };
    assert!(
        (oee.availability - expected.availability).abs() < 1e-12,
        "{oee:?}"
    );
    assert!(
        (oee.effectiveness - expected.effectiveness).abs() < 1e-12,
        "{oee:?}"
    );
    assert_eq!(oee.quality, expected.quality);
    assert!((oee.index() - 0.5).abs() < 1e-12, "{oee:?}");
    assert_eq!(cell.work_time.unwrap().seconds, 600.0);
    assert_eq!(trace.yields.first_pass_yield(), Some(0.75));
    assert_eq!(trace.yields.scrap_ratio(), Some(0.25));
}

/// Overtime is planned, so the availability is not greater than 1.
#[test]
fn overtime_is_planned() {
    let text = "line L {
        part P
        shift 0 h to 1 h finish work
        source rack: P every 0 s
        station cell { takes 50 min }
        sink out
        route P: rack -> cell -> out
    }";
    let options = Options {
        until: Some(3.0 * 3600.0),
        ..Options::default()
    };
    let trace = run(text, options);
    let cell = &trace.stations[0];
    assert_eq!((cell.processed, cell.busy_seconds / 60.0), (2, 100.0));
    assert_eq!(cell.oee.unwrap().availability, 1.0);
}

/// A defect is charged to the station that made it, not to the one that finds it. Without a defect,
/// the station that worked on the part last is charged.
#[test]
fn scrap_is_charged_to_the_station_that_caused_it() {
    let line = |defect: &str, way: &str| {
        format!(
            "line L {{
                part P {{ property flawed: bool = false }}
                source rack: P every 0 s
                station printer {{ takes 1 s {defect} }}
                station camera {{ takes 1 s }}
                sink out
                sink bin rejects
                route P: rack -> printer -> camera
                {way}
            }}"
        )
    };
    let options = || Options {
        until: Some(100.5),
        ..Options::default()
    };
    let scrap = |text: &str| {
        let trace = run(text, options());
        let of_stations = trace.stations.iter().map(|s| s.scrapped);
        (of_stations.collect::<Vec<_>>(), trace.yields.scrapped)
    };
    let found = line(
        "defect on P probability 100 %: flawed becomes true",
        "route P: camera -> bin when flawed route P: camera -> out otherwise",
    );
    assert_eq!(scrap(&found), (vec![99, 0], 99));
    let last = line(
        "",
        "route P: camera -> out when flawed route P: camera -> bin otherwise",
    );
    assert_eq!(scrap(&last), (vec![0, 99], 99));
}

/// Parts that find no room and leave the source for a sink that rejects are not scrap: nothing has
/// been made yet.
#[test]
fn lost_orders_are_not_scrap() {
    let text = "line L {
        part P
        source rack: P every 1 s
        buffer queue capacity 1
        station cell { takes 2 s }
        sink out
        sink lost rejects
        route P: rack -> queue, lost
        route P: queue -> cell -> out
    }";
    let options = Options {
        until: Some(100.0),
        ..Options::default()
    };
    let trace = run(text, options);
    assert!(trace.parts.rejected > 40, "{:?}", trace.parts);
    assert_eq!(trace.yields.scrapped, 0);
    assert_eq!(trace.yields.first_pass_yield(), Some(1.0));
}

/// Parts that are bought and only joined to others do not count, though the joined part is worked
/// on: one toy in two has a cap that was turned twice.
#[test]
fn parts_that_no_station_worked_on_do_not_raise_the_first_pass_yield() {
    let text = "line L {
        part Cap { property rough: bool = false }
        part Screw
        part Toy from 1 Cap, 8 Screw
        source caps: Cap every 0 s, at most 2 in the line
        source screws: Screw every 0 s, at most 20 in the line
        station lathe {
            takes 1 s
            sets rough = false on Cap
            defect on Cap probability 50 %: rough becomes true
        }
        station join { takes 1 s }
        sink out
        buffer again capacity 2
        route Cap: caps -> lathe
        route Cap: lathe -> again -> lathe when rough
        route Cap: lathe -> join otherwise
        route Screw: screws -> join
        route Toy: join -> out
    }";
    let options = Options {
        parts: Some(4_000),
        ..Options::default()
    };
    let trace = run(text, options);
    assert_eq!(trace.yields.finished, 4_000);
    let first_pass = trace.yields.first_pass_yield().unwrap();
    assert!((first_pass - 0.5).abs() < 0.03, "{first_pass}");
    assert_eq!(trace.yields_by_type[2], trace.yields);
}

/// At each pass, a part is scrapped with probability 0.1; of the others, 30 % are worked on again.
/// The first-pass yield is 0.9 * 0.7, and of all parts 0.1 / (1 - 0.9 * 0.3) are scrapped. With
/// 100 000 parts, the standard errors are 0.0016 and 0.0011.
#[test]
fn yields_are_those_of_the_probabilities() {
    let text = "line L {
        part P { property broken: bool = false property rough: bool = false }
        source rack: P every 0 s, at most 2 in the line
        station cell times 2 {
            takes 1 s
            sets rough = false on P
            defect on P probability 10 %: broken becomes true
            defect on P probability 30 %: rough becomes true
        }
        sink out
        sink bin rejects
        buffer again capacity 2
        route P: rack -> cell
        route P: cell -> bin when broken
        route P: cell -> again -> cell when rough
        route P: cell -> out otherwise
    }";
    let options = Options {
        until: Some(70_000.0),
        ..Options::default()
    };
    let trace = run(text, options);
    let parts = trace.yields.finished + trace.yields.scrapped;
    assert!((80_000..110_000).contains(&parts), "{parts}");
    let first_pass = trace.yields.first_pass_yield().unwrap();
    assert!((first_pass - 0.63).abs() < 0.005, "{first_pass}");
    let scrap = trace.yields.scrap_ratio().unwrap();
    assert!((scrap - 0.1 / 0.73).abs() < 0.0035, "{scrap}");
}

/// Yields of one product count the parts that left the line as this product, in runs and batches.
#[test]
fn yields_of_one_product() {
    let text = "line L {
        part A { property bad: bool = false } part B product A, B
        source a: A every 10 s source b: B every 20 s
        station cell { takes 2 s defect on A probability 20 %: bad becomes true }
        sink out sink bin rejects
        route A: a -> cell route B: b -> cell -> out
        route A: cell -> bin when bad route A: cell -> out otherwise
        requirement good: first_pass_yield(A) >= 70 %
        requirement other: first_pass_yield(B) = 100 %
        requirement scrap: scrap(A) <= 30 %
        requirement all: scrap >= 5 %
    }";
    let options = Options {
        until: Some(40_000.0),
        batches: Some(10),
        ..Options::default()
    };
    let trace = plant_of(text, options).run();
    let values: Vec<f64> = trace.requirements.iter().filter_map(|r| r.value).collect();
    let [good, other, scrap, all] = values[..] else {
        panic!("{values:?}");
    };
    assert!(
        (good - 0.8).abs() < 0.03 && (good + scrap - 1.0).abs() < 1e-12,
        "{values:?}"
    );
    assert_eq!(other, 1.0);
    assert!((all - scrap * 2.0 / 3.0).abs() < 1e-3, "{values:?}");
    let batches = Batches::of(plant_of(text, options).line(), &trace).expect("batches");
    let means = batches.requirements.iter().filter_map(|r| r.value);
    for (mean, value) in means.zip(values) {
        assert!((mean.mean - value).abs() < 1e-9, "{mean:?} {value}");
    }
}
