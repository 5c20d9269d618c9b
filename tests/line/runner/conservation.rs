//! Random small lines with all features: no part is lost, all time is booked, and the same seed
//! gives the same run.

use crate::models::{Builder, Logged, RunLogged, Shift1, Work, at_random, every, failing, took};
use linewright::contract::distribution::Distribution;
use linewright::contract::line::{Defect, InitialValue, Supply};
use linewright::contract::machine::{RealBinary, RealExpr};
use linewright::line::random::Stream;
use linewright::line::{End, Options, Plant};
use linewright::station::{CallError, ErrorCode};
use proptest::prelude::*;

/// Two ways of parts, from a source and a store, to a joining station, a camera that sends some
/// back, and a store; with random nodes between them. With an `ample` supply the line can always
/// continue: products have a way out, and rejected parts are replaced.
pub fn line(seed: u64, ample: bool) -> Builder {
    let mut stream = Stream::from_seed(seed);
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .property("Printed", "bad", InitialValue::Number(0.0))
        .bill(
            "Product",
            &[("Brick", 1 + stream.below(2) as u32), ("Printed", 1)],
        )
        .property("Product", "bad", InitialValue::Component(1, 0));
    let supply = match stream.below(if ample { 3 } else { 4 }) {
        0 => Supply::OnOrder,
        1 => every(0.0, None),
        2 => every(1.0 + stream.unit() * 5.0, None),
        _ => at_random(3.0, Some(40)),
    };
    builder
        .store(
            "warehouse",
            &[(
                "Brick",
                if ample {
                    10_000
                } else {
                    10 + stream.below(100)
                },
            )],
        )
        .source("printer", "Printed", supply);
    let between = |builder: &mut Builder, stream: &mut Stream, name: &str| {
        let size = 1 + stream.below(4) as u32;
        match stream.below(4) {
            0 => builder.buffer(name, size),
            1 => builder.conveyor(name, size, 0.3 + stream.unit()),
            2 => builder.belt(name, size, Shift1::new(size as usize)),
            _ => return false,
        };
        true
    };
    let mut paths: Vec<Vec<String>> = Vec::new();
    for (from, name, to) in [
        ("warehouse", "bricks", "cell"),
        ("printer", "prints", "cell"),
        ("cell", "products", "camera"),
    ] {
        let mut path = vec![from.to_owned()];
        if between(&mut builder, &mut stream, name) {
            path.push(name.to_owned());
        }
        let second = format!("{name}2");
        if between(&mut builder, &mut stream, &second) {
            path.push(second);
        }
        path.push(to.to_owned());
        paths.push(path);
    }
    // The camera may also check printed parts before they go to the cell. That makes a circle,
    // which can fill up.
    let early = stream.below(2) == 0 && !ample;
    for (name, parts) in [
        ("cell", &["Product"][..]),
        ("camera", &["Product", "Printed"]),
    ] {
        let mut times = Stream::from_seed(stream.bits());
        let refuses = stream.below(3) == 0;
        builder.station(
            name,
            parts,
            Work(
                move |call: u64, _: &mut [f64]| {
                    if refuses && call.is_multiple_of(7) {
                        return Err(CallError {
                            code: ErrorCode::Guarantee,
                            rule: Some("pick: held".to_owned()),
                            message: "no".to_owned(),
                        });
                    }
                    took(times.exponential(2.0))
                },
                0,
            ),
        );
    }
    let broken = stream.below(2) == 0;
    let defects = stream.unit() * 0.3;
    let setup = stream.unit();
    builder.with_station("cell", |cell| {
        cell.setup = Distribution::Constant(setup);
        if broken {
            cell.failures = failing(20.0, 4.0);
        }
        cell.defects.push(Defect {
            part: 2,
            probability: defects,
            properties: vec![0],
            value: RealExpr::Number(1.0),
            span: crate::models::span(),
        });
    });
    builder.scrap("scrap", Some("printer"));
    if stream.below(3) == 0 {
        builder.shift(100.0, 50_000.0);
    }
    let products = paths.pop().unwrap();
    for (part, path) in ["Brick", "Printed"].iter().zip(&paths) {
        let mut path: Vec<&str> = path.iter().map(String::as_str).collect();
        if early && *part == "Printed" {
            builder.buffer("checked", 2);
            path.splice(path.len() - 1.., ["camera", "checked", "cell"]);
        }
        builder.route(part, &path);
    }
    let bad = RealExpr::Binary(
        RealBinary::Gt,
        Box::new(RealExpr::Property(0)),
        Box::new(RealExpr::Number(0.5)),
    );
    let products: Vec<&str> = products.iter().map(String::as_str).collect();
    builder
        .route("Product", &products)
        .route_if("Product", "camera", "scrap", Some(bad))
        .route("Product", &["camera", "warehouse"]);
    builder
}

fn check(trace: &Logged) -> Result<(), TestCaseError> {
    // Every run itself asserts that the accounts agree with the existing parts.
    let p = trace.parts;
    prop_assert_eq!(
        p.entered,
        p.finished + p.rejected + p.consumed + p.in_progress
    );
    prop_assert_eq!(trace.products, p.finished);
    prop_assert_eq!(
        p.rejected,
        trace.rejects.iter().map(|r| r.count).sum::<u64>()
    );
    for station in &trace.stations {
        let s = station.shares;
        let all = [s.busy, s.starved, s.blocked, s.failed, s.idle, s.setup];
        prop_assert!(
            all.iter().all(|share| (0.0..=1.0).contains(share)),
            "{all:?}"
        );
        prop_assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        prop_assert!((s.busy * trace.seconds - station.busy_seconds).abs() < 1e-6);
    }
    for conveyor in &trace.conveyors {
        prop_assert!((0.0..=trace.seconds + 1e-9).contains(&conveyor.moving_seconds));
    }
    prop_assert!(trace.joules >= 0.0 && trace.lead_time.max >= trace.lead_time.mean - 1e-9);
    let mut last = 0.0;
    for entry in &trace.log {
        prop_assert!(entry.time >= last);
        last = entry.time;
    }
    Ok(())
}

fn plant(seed: u64, until: Option<f64>, ample: bool) -> Plant {
    line(seed, ample).plant(Options {
        seed,
        parts: Some(20),
        until,
        ..Options::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn no_part_and_no_time_is_lost(seed in 0_u64..1_000_000_000, until in prop::option::of(0.0..500.0)) {
        let trace = plant(seed, until, false).run_logged();
        check(&trace)?;
        prop_assert!(trace.end == End::Products || until.is_some() || trace.findings.iter().any(|f| f.code.id == "LW403"));
        prop_assert_eq!(format!("{trace:?}"), format!("{:?}", plant(seed, until, false).run_logged()));
    }

    #[test]
    fn a_line_with_ample_supply_never_stands_still(seed in 0_u64..1_000_000_000) {
        let trace = plant(seed, None, true).run_logged();
        check(&trace)?;
        prop_assert_eq!(trace.end, End::Products, "{:?}", trace.findings);
    }
}
