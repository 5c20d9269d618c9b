//! Conveyors moved by a controller.

use crate::models::{Builder, Shift1, constant, every, span};
use linewright::contract::line::{Defect, InitialValue, Supply};
use linewright::contract::machine::{RealExpr, RealUnary};
use linewright::line::End;
use linewright::line::log::EventKind;
use linewright::station::{CallError, Controller, ErrorCode, Service};

#[test]
fn a_belt_carries_parts_in_their_order() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(4)))
        .belt("belt", 3, Shift1::new(3))
        .sink("sink")
        .route("Part", &["source", "belt", "sink"]);
    let trace = builder.run(4);
    // On at 0, 2, 4, 6 (place 0 must have been seen free), off three periods later.
    let off: Vec<(f64, u64)> = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Finished)
        .filter_map(|e| e.part.map(|p| (e.time, p.0)))
        .collect();
    assert_eq!(off, [(3.0, 1), (5.0, 2), (7.0, 3), (9.0, 4)]);
    let places: Vec<(f64, u32)> = trace
        .log
        .iter()
        .filter_map(|e| match (e.what, e.part) {
            (EventKind::Place(place), Some((2, _))) => Some((e.time, place)),
            _ => None,
        })
        .collect();
    assert_eq!(places, [(3.0, 0), (4.0, 1), (5.0, 2)]);
    assert_eq!(trace.conveyors[0].machine.as_deref(), Some("belt_machine"));
}

#[test]
fn a_belt_sleeps_and_is_woken() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(1000.5, None))
        .belt("belt", 3, Shift1::new(3))
        .station("slow", &["Part"], constant(1500.0))
        .sink("sink")
        .route("Part", &["source", "belt", "slow", "sink"]);
    let trace = builder.run_until(100_000.0);
    // Off at 3, then blocked by the station until 1503, 3003, ...
    assert_eq!(
        trace.products,
        ((100_000.0_f64 - 3.0) / 1500.0).floor() as u64
    );
    // Some twenty steps per part, not one for each of 100 000 seconds.
    assert!(trace.events < 4000, "{}", trace.events);
    assert!(trace.findings.is_empty());
}

#[test]
fn belts_hand_over_to_belts() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(20)))
        .belt("first", 3, Shift1::new(3))
        .belt("second", 2, Shift1::new(2))
        .station("work", &["Part"], constant(3.3))
        .sink("sink")
        .route("Part", &["source", "first", "second", "work", "sink"]);
    let trace = builder.run(20);
    assert_eq!(trace.end, End::Products);
    let order: Vec<u64> = trace
        .log
        .iter()
        .filter(|e| e.what == EventKind::Finished)
        .filter_map(|e| e.part.map(|p| p.0))
        .collect();
    assert_eq!(order, (1..=20).collect::<Vec<_>>());
}

#[test]
fn a_lost_part_is_found() {
    let mut belt = Shift1::new(3);
    belt.loses_at = Some(5);
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .belt("belt", 3, belt)
        .sink("sink")
        .route("Part", &["source", "belt", "sink"]);
    let trace = builder.run(100);
    assert_eq!(trace.end, End::PartLost);
    assert_eq!(trace.findings[0].code.id, "LW407");
    insta::assert_snapshot!(trace.findings[0].message, @r#"belt lost a part at 0:00:05: its controller says that 0 of its places are occupied, but 2 parts are on it"#);
}

#[test]
fn a_belt_whose_assumption_breaks_is_named() {
    struct Refuses(Shift1);
    impl Controller for Refuses {
        fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
            self.0.simulate(operation, values)
        }
        fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
            // The assumption is that nothing comes while it cannot hand over anything.
            if plant == [1, 0] {
                return Err(CallError {
                    code: ErrorCode::Assumption,
                    rule: Some("belt: no jam".to_owned()),
                    message: "belt: the assumption no jam does not hold".to_owned(),
                });
            }
            self.0.step(plant, outputs)
        }
        fn reset(&mut self) {
            self.0.reset();
        }
    }
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(5.0, Some(3)))
        .belt("belt", 3, Refuses(Shift1::new(3)))
        .station("slow", &["Part"], constant(100.0))
        .sink("sink")
        .route("Part", &["source", "belt", "slow", "sink"]);
    let trace = builder.run(3);
    // The first is at the station, the second at the end of the belt, and the third may not come on
    // until that is gone.
    assert_eq!(trace.end, End::Products);
    assert_eq!(trace.violation_count, 1);
    let violation = &trace.violations[0];
    assert_eq!((violation.time, violation.part), (10.0, None));
    assert_eq!(violation.node, builder.node("belt"));
}

/// The shape of the laboratory line: printed bricks are checked, joined with two from the
/// warehouse, checked by the same camera, and stored; contracted belts between all of them.
#[test]
fn a_line_like_the_laboratory() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    let bad = || {
        Some(RealExpr::Unary(
            RealUnary::Not,
            Box::new(RealExpr::Property(0)),
        ))
    };
    builder
        .property("Printed", "ok", InitialValue::Number(1.0))
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .property("Product", "ok", InitialValue::Component(1, 0))
        .source("orders", "Printed", Supply::OnOrder)
        .station("printer", &["Printed"], constant(100.0))
        .with_station("printer", |printer| {
            printer.defects.push(Defect {
                part: 1,
                probability: 0.2,
                properties: vec![0],
                value: RealExpr::Number(0.0),
                span: span(),
            });
        })
        .belt("to_camera", 3, Shift1::new(3))
        .station("camera", &["Printed", "Product"], constant(8.0))
        .belt("to_cell", 3, Shift1::new(3))
        .store("warehouse", &[("Brick", 1000)])
        .belt("bricks", 4, Shift1::new(4))
        .station("cell", &["Product"], constant(40.0))
        .belt("back", 3, Shift1::new(3))
        .belt("away", 2, Shift1::new(2))
        .scrap("scrap", Some("orders"))
        .route("Printed", &["orders", "printer", "to_camera", "camera"])
        .route_if("Printed", "camera", "scrap", bad())
        .route("Printed", &["camera", "to_cell", "cell"])
        .route("Brick", &["warehouse", "bricks", "cell"])
        .route("Product", &["cell", "back", "camera"])
        .route_if("Product", "camera", "scrap", bad())
        .route("Product", &["camera", "away", "warehouse"]);
    let trace = builder.run(50);
    assert_eq!(trace.end, End::Products, "{:?}", trace.findings);
    assert!(trace.findings.is_empty());
    assert_eq!(trace.stored, 50);
    let rejected = trace.parts.rejected;
    assert!((5..30).contains(&rejected), "{rejected}");
    assert_eq!(trace.stations[0].name, "printer");
    assert_eq!(trace.bottleneck.station().unwrap().name, "printer");
    // The printer works without interruption: one print after the other, and then the last one's
    // way through the line.
    let printed = 100.0 * (50 + rejected) as f64;
    assert!(
        (printed..printed + 120.0).contains(&trace.seconds),
        "{}",
        trace.seconds
    );
    let printer = trace.stations[0].shares;
    assert!(printer.busy > 0.95 && printer.blocked < 0.02, "{printer:?}");
}

/// Time counts as moving when a part changes its place, and in the step after one came on or off.
#[test]
fn moving_seconds_of_a_belt() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(1)))
        .belt("belt", 1, Shift1::new(1))
        .sink("sink")
        .route("Part", &["source", "belt", "sink"]);
    let trace = builder.run_until(100.0);
    assert_eq!(
        (trace.products, trace.conveyors[0].moving_seconds),
        (1, 2.0)
    );
}

#[test]
fn a_part_that_goes_back_is_lost() {
    struct Back(u32);
    impl Controller for Back {
        fn simulate(&mut self, _: usize, _: &mut [f64]) -> Result<Service, CallError> {
            unreachable!("a belt has no operations")
        }
        fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
            outputs.copy_from_slice(match self.0 {
                0 => &[0, 0, 1],
                1 => &[0, 1, 0],
                _ => &[1, 0, 0],
            });
            self.0 += u32::from(self.0 > 0 || plant[0] != 0);
            Ok(())
        }
        fn reset(&mut self) {
            self.0 = 0;
        }
    }
    let mut builder = Builder::new(&["B", "A"]);
    builder
        .endless("b", "B")
        .source("a", "A", every(0.0, Some(1)))
        .belt("belt", 2, Back(0))
        .station("slow", &["A", "B"], constant(1000.0))
        .sink("sink")
        .route("A", &["a", "belt", "slow", "sink"])
        .route("B", &["b", "slow", "sink"]);
    let trace = builder.run_until(100.0);
    assert_eq!(trace.end, End::PartLost);
    insta::assert_snapshot!(trace.findings[0].message, @"belt lost a part at 0:00:02: A 3 was on place 1 and would now be behind it, on place 0");
}
