//! Lines that stand still, and what they say about it.

use crate::support::{Builder, Shift1, constant, every, refusing};
use linewright::contract::line::{InitialValue, Supply};
use linewright::contract::machine::RealExpr;
use linewright::line::{End, Trace};

fn text(trace: &Trace) -> String {
    trace
        .findings
        .iter()
        .map(|f| {
            format!(
                "{}: {}\n  {}\n",
                f.code.id,
                f.message,
                f.help.as_deref().unwrap_or("")
            )
        })
        .collect()
}

#[test]
fn a_circle_of_full_places() {
    let mut builder = Builder::new(&["Raw", "Done"]);
    builder
        .bill("Done", &[("Raw", 1)])
        .property("Raw", "again", InitialValue::Number(1.0))
        .endless("source", "Raw")
        .conveyor("belt_in", 2, 1.0)
        .station("cell", &["Raw"], constant(2.0))
        .conveyor("belt_out", 2, 1.0)
        .station("camera", &["Raw"], constant(1.0))
        .sink("sink")
        .route("Raw", &["source", "belt_in", "cell", "belt_out", "camera"])
        .route_if("Raw", "camera", "belt_in", Some(RealExpr::Property(0)))
        .route("Raw", &["camera", "sink"]);
    let trace = builder.run(3);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn a_circle_is_found_behind_contracted_belts_too() {
    let mut builder = Builder::new(&["Raw"]);
    builder
        .property("Raw", "again", InitialValue::Number(1.0))
        .endless("source", "Raw")
        .belt("belt_in", 2, Shift1::new(2))
        .station("cell", &["Raw"], constant(2.0))
        .belt("belt_out", 2, Shift1::new(2))
        .sink("sink")
        .route("Raw", &["source", "belt_in", "cell", "belt_out"])
        .route_if("Raw", "belt_out", "cell", Some(RealExpr::Property(0)))
        .route("Raw", &["belt_out", "sink"]);
    let trace = builder.run_until(1e6);
    assert_eq!(trace.end, End::Blocked);
    assert!(trace.seconds < 100.0);
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn a_component_that_never_comes() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .store("warehouse", &[("Brick", 100)])
        .source("printer", "Printed", every(5.0, Some(3)))
        .station("cell", &["Product"], constant(1.0))
        .sink("sink")
        .route("Brick", &["warehouse", "cell"])
        .route("Printed", &["printer", "cell"])
        .route("Product", &["cell", "sink"]);
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn a_component_behind_what_is_not_wanted() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .store("warehouse", &[("Brick", 100)])
        .source("printer", "Printed", every(60.0, None))
        .conveyor("belt", 4, 1.0)
        .station("cell", &["Product"], constant(1.0))
        .sink("sink")
        .route("Brick", &["warehouse", "belt", "cell"])
        .route("Printed", &["printer", "belt", "cell"])
        .route("Product", &["cell", "sink"]);
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn rejected_parts_that_nobody_orders_again() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station("cell", &["Part"], refusing(1.0, |call| call == 2))
        .sink("sink")
        .route("Part", &["printer", "cell", "sink"]);
    let trace = builder.run(5);
    assert_eq!((trace.end, trace.products), (End::Blocked, 4));
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn a_part_without_a_way() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "good", InitialValue::Number(0.0))
        .endless("source", "Part")
        .station("cell", &["Part"], constant(1.0))
        .sink("sink")
        .route("Part", &["source", "cell"])
        .route_if("Part", "cell", "sink", Some(RealExpr::Property(0)));
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn a_circle_without_time_ends() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(0.0, Some(1)))
        .buffer("a", 1)
        .buffer("b", 1)
        .sink("sink")
        .route("Part", &["source", "a", "b", "a"]);
    let trace = builder.run(1);
    assert_eq!(trace.end, End::Blocked);
    insta::assert_snapshot!(text(&trace), @"");
}

#[test]
fn a_station_that_refuses_everything_ends() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station("cell", &["Part"], refusing(1.0, |_| true))
        .sink("sink")
        .scrap("scrap", Some("printer"))
        .route("Part", &["printer", "cell", "sink"]);
    let trace = builder.run(1);
    assert_eq!(trace.end, End::Blocked);
    assert_eq!(trace.findings.len(), 2);
    assert!(trace.violations.len() == 1000 && trace.violation_count > 1000);
}
