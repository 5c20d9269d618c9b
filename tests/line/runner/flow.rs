//! Sources, stores, joining, and routes by verdict.

use crate::models::{Builder, constant, every, refusing, verdict};
use linewright::contract::line::{Defect, InitialValue, NodeKind, Supply};
use linewright::contract::machine::{RealBinary, RealExpr};
use linewright::line::End;
use linewright::line::log::EventKind;
use linewright::line::trace::{PartCounts, Reject};

#[expect(clippy::unnecessary_wraps, reason = "what a route has")]
fn is(property: usize, value: f64) -> Option<RealExpr> {
    Some(RealExpr::Binary(
        RealBinary::Eq,
        Box::new(RealExpr::Property(property)),
        Box::new(RealExpr::Number(value)),
    ))
}

#[test]
fn two_bricks_and_a_printed_one_make_the_product() {
    let mut builder = Builder::new(&["Brick", "Printed", "Product"]);
    builder
        .property("Printed", "mark", InitialValue::Number(7.0))
        .bill("Product", &[("Brick", 2), ("Printed", 1)])
        .property("Product", "mark", InitialValue::Component(1, 0))
        .store("warehouse", &[("Brick", 100)])
        .source("printer", "Printed", Supply::OnOrder)
        .station("cell", &["Product"], constant(10.0))
        .sink("wrong")
        .route("Brick", &["warehouse", "cell"])
        .route("Printed", &["printer", "cell"])
        .route_if("Product", "cell", "warehouse", is(0, 7.0))
        .route("Product", &["cell", "wrong"]);
    let trace = builder.run(5);
    assert_eq!(trace.end, End::Products);
    assert_eq!(trace.seconds, 50.0);
    assert_eq!(trace.products, 5);
    // Only five printed parts were ordered. The cell keeps the components of one bill ahead: 2
    // bricks more.
    assert_eq!(
        trace.parts,
        PartCounts {
            before: 0,
            entered: 5 * 4 + 2,
            finished: 5,
            rejected: 0,
            consumed: 15,
            in_progress: 2
        }
    );
    let warehouse = builder.node("warehouse");
    let stored = trace
        .log
        .iter()
        .filter(|e| e.node == warehouse && e.what == EventKind::Finished);
    assert_eq!(stored.count(), 5, "the mark came from the printed one");
    // Components wait in the cell for one service, except the first ones.
    assert_eq!(trace.lead_time.max, 20.0);
    assert_eq!(trace.lead_time.mean, 18.0);
}

#[test]
fn a_source_on_order_counts_what_a_product_needs() {
    let mut builder = Builder::new(&["Leg", "Table"]);
    builder
        .bill("Table", &[("Leg", 4)])
        .source("saw", "Leg", Supply::OnOrder)
        .station("cell", &["Table"], constant(1.0))
        .sink("sink")
        .route("Leg", &["saw", "cell"])
        .route("Table", &["cell", "sink"]);
    let trace = builder.run(3);
    assert_eq!(trace.end, End::Products);
    assert_eq!(trace.parts.entered, 15);
    assert_eq!(trace.parts.in_progress, 0);
}

#[test]
fn bad_parts_are_rejected_and_ordered_again() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "ok", InitialValue::Number(-1.0))
        .source("printer", "Part", Supply::OnOrder)
        .station(
            "camera",
            &["Part"],
            verdict(2.0, |call| f64::from(call % 3 != 0)),
        )
        .machine_properties("camera", &["ok"])
        .sink("good")
        .scrap("bad", Some("printer"))
        .route("Part", &["printer", "camera"])
        .route_if("Part", "camera", "bad", is(0, 0.0))
        .route("Part", &["camera", "good"]);
    let trace = builder.run(10);
    // Calls 3, 6, 9, 12 are bad; the tenth good one is call 14.
    assert_eq!(trace.seconds, 28.0);
    assert_eq!((trace.parts.entered, trace.parts.rejected), (14, 4));
    assert_eq!(
        trace.rejects,
        [Reject {
            part: 0,
            count: 4,
            reordered: 4
        }]
    );
    assert!(trace.findings.is_empty());
}

#[test]
fn defects_come_at_their_rate_and_with_their_value() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "a", InitialValue::Number(0.0))
        .property("Part", "b", InitialValue::Number(0.0))
        .endless("source", "Part")
        .station("printer", &["Part"], constant(1.0))
        .with_station("printer", |printer| {
            printer.defects.push(Defect {
                part: 0,
                probability: 0.25,
                properties: vec![0, 1],
                // 1 - chosen
                value: RealExpr::Binary(
                    RealBinary::Sub,
                    Box::new(RealExpr::Number(1.0)),
                    Box::new(RealExpr::Property(2)),
                ),
                span: crate::models::span(),
            });
        })
        .sink("good")
        .scrap("bad_a", None)
        .scrap("bad_b", None)
        .route("Part", &["source", "printer"])
        .route_if("Part", "printer", "bad_a", is(0, 1.0))
        .route_if("Part", "printer", "bad_b", is(1, 1.0))
        .route("Part", &["printer", "good"]);
    let trace = builder.run_until(40_000.0);
    let count = |name: &str| {
        let node = builder.node(name);
        trace
            .log
            .iter()
            .filter(|e| e.node == node && e.what == EventKind::Rejected)
            .count() as f64
    };
    for name in ["bad_a", "bad_b"] {
        assert!((count(name) / 40_000.0 - 0.125).abs() < 0.006);
    }
}

#[test]
fn a_violation_rejects_the_part_and_the_line_goes_on() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("printer", "Part", Supply::OnOrder)
        .station(
            "cell",
            &["Part"],
            refusing(5.0, |call| call == 2 || call == 4),
        )
        .sink("sink")
        .scrap("scrap", Some("printer"))
        .route("Part", &["printer", "cell", "sink"]);
    let trace = builder.run(4);
    assert_eq!(trace.end, End::Products);
    assert_eq!(trace.seconds, 20.0, "a refused part takes no time");
    assert_eq!((trace.parts.finished, trace.parts.rejected), (4, 2));
    assert_eq!(trace.violation_count, 2);
    let violation = &trace.violations[1];
    assert_eq!(violation.rule.as_deref(), Some("turn: gripped"));
    assert_eq!(violation.part, Some((4, 0)));
    assert_eq!(violation.time, 10.0);
    assert_eq!(trace.findings.len(), 1, "one finding a rule and station");
    insta::assert_snapshot!(trace.findings[0].message, @"cell refused Part 2 at 0:00:05: turn: the assumption gripped does not hold in step 3 (the first of 2 times)");
    assert_eq!(trace.findings[0].code.id, "LW405");
}

#[test]
fn a_source_by_time_keeps_its_rhythm() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(10.0, Some(4)))
        .station("fast", &["Part"], constant(3.0))
        .sink("sink")
        .route("Part", &["source", "fast", "sink"]);
    let trace = builder.run(4);
    assert_eq!(trace.seconds, 33.0);
    assert_eq!(trace.lead_time.max, 3.0);
    // A slow station: the source keeps one part, and makes the next when that one has left.
    let mut builder = Builder::new(&["Part"]);
    builder
        .source("source", "Part", every(10.0, Some(4)))
        .station("slow", &["Part"], constant(12.0))
        .sink("sink")
        .route("Part", &["source", "slow", "sink"]);
    let trace = builder.run(4);
    assert_eq!(trace.seconds, 48.0);
}

#[test]
fn who_has_waited_longest_goes_first() {
    let mut builder = Builder::new(&["A", "B"]);
    builder
        .source("a", "A", every(0.0, Some(3)))
        .source("b", "B", every(0.0, Some(3)))
        .station("cell", &["A", "B"], constant(1.0))
        .sink("sink")
        .route("A", &["a", "cell", "sink"])
        .route("B", &["b", "cell", "sink"]);
    let trace = builder.run(2);
    let cell = builder.node("cell");
    let order: Vec<usize> = trace
        .log
        .iter()
        .filter(|e| e.node == cell && e.what == EventKind::Started)
        .filter_map(|e| e.part.map(|p| p.1))
        .collect();
    // The second A began to wait before the first B did, both at 0; from then on they take turns.
    assert_eq!(order, [0, 0, 1, 0, 1]);
}

#[test]
fn a_store_in_the_middle_hands_parts_on() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "mark", InitialValue::Number(0.0))
        .store("start", &[("Part", 3)])
        .station("marks", &["Part"], verdict(1.0, |call| call as f64))
        .machine_properties("marks", &["mark"])
        .store("middle", &[])
        .station("slow", &["Part"], constant(5.0))
        .sink("sink")
        .route("Part", &["start", "marks", "middle", "slow", "sink"]);
    let trace = builder.run_until(100.0);
    assert_eq!(trace.products, 3);
    assert_eq!(trace.makespan, 16.0);
    assert_eq!((trace.end, trace.seconds), (End::Time, 100.0));
    assert!(trace.findings.is_empty(), "all is done");
}

#[test]
fn an_order_raises_the_limit_of_a_source_by_time() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "ok", InitialValue::Number(0.0))
        .source("source", "Part", every(10.0, Some(2)))
        .station(
            "camera",
            &["Part"],
            verdict(25.0, |call| f64::from(call > 2)),
        )
        .machine_properties("camera", &["ok"])
        .sink("good")
        .scrap("bad", Some("source"))
        .route("Part", &["source", "camera"])
        .route_if("Part", "camera", "bad", is(0, 0.0))
        .route("Part", &["camera", "good"]);
    let trace = builder.run(2);
    // Both parts of the limit are bad; the third is due at 20 and made when the first is rejected,
    // at 25.
    assert_eq!((trace.end, trace.seconds), (End::Products, 100.0));
    assert_eq!(trace.parts.rejected, 2);
}

#[test]
fn a_station_joins_products_and_works_on_them_again() {
    let mut builder = Builder::new(&["Brick", "Product"]);
    builder
        .bill("Product", &[("Brick", 2)])
        .property("Product", "rounds", InitialValue::Number(0.0))
        .store("warehouse", &[("Brick", 100)])
        .station("cell", &["Product"], {
            crate::models::Work(
                |_, values: &mut [f64]| {
                    values[0] += 1.0;
                    crate::models::took(10.0)
                },
                0,
            )
        })
        .machine_properties("cell", &["rounds"])
        .station("camera", &["Product"], constant(1.0))
        .route("Brick", &["warehouse", "cell"])
        .route("Product", &["cell", "camera"])
        .buffer("again", 10)
        .route_if("Product", "camera", "again", is(0, 1.0))
        .route("Product", &["again", "cell"])
        .route("Product", &["camera", "warehouse"]);
    let trace = builder.run(1);
    // Made by 10 and checked by 11. The bricks of the third product have waited in the cell since
    // 10, so that one is made from 20 to 30; those of the fourth came later than the first product,
    // which is in work until 40 and checked by 41.
    assert_eq!((trace.end, trace.seconds), (End::Products, 41.0));
    assert_eq!(trace.stored, 1);
    assert_eq!(trace.lead_time.max, 41.0);
}

/// A rejected product takes everything that was joined into it out of the line, so all of that is
/// ordered again.
#[test]
fn a_rejected_product_orders_all_that_is_in_it() {
    let mut builder = Builder::new(&["Leg", "Frame", "Table"]);
    builder
        .bill("Frame", &[("Leg", 2)])
        .bill("Table", &[("Frame", 2), ("Leg", 1)])
        .property("Table", "ok", InitialValue::Number(-1.0))
        .source("saw", "Leg", Supply::OnOrder)
        .buffer("legs", 10)
        .station("frames", &["Frame"], constant(1.0))
        .station("cell", &["Table"], constant(1.0))
        .station(
            "camera",
            &["Table"],
            verdict(1.0, |call| f64::from(call % 2 == 0)),
        )
        .machine_properties("camera", &["ok"])
        .sink("sink")
        .scrap("scrap", Some("saw"))
        .route("Leg", &["saw", "legs"])
        .route("Leg", &["legs", "frames"])
        .route("Frame", &["frames", "cell"])
        .route("Table", &["cell", "camera"])
        .route_if("Table", "camera", "scrap", is(0, 0.0))
        .route("Table", &["camera", "sink"]);
    // A table has five legs: the fifth comes from its own source.
    builder
        .source("fifth", "Leg", every(0.0, None))
        .route("Leg", &["fifth", "cell"]);
    let trace = builder.run(4);
    assert_eq!(trace.end, End::Products, "{:?}", trace.findings);
    assert_eq!(trace.products, 4);
    assert_eq!(trace.rejects[0].count, 4);
    // By the bill: two frames of two legs, and one leg.
    assert_eq!(trace.rejects[0].reordered, 20);
}

/// A store that gives out stock keeps the parts that came in meanwhile.
#[test]
fn stock_and_what_came_in_are_kept_apart() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .property("Part", "mark", InitialValue::Number(0.0))
        .store("pool", &[("Part", 2)])
        .station("marks", &["Part"], verdict(1.0, |call| call as f64))
        .machine_properties("marks", &["mark"])
        .sink("sink")
        .route("Part", &["pool", "marks"])
        .route_if("Part", "marks", "pool", is(0, 1.0))
        .route_if("Part", "marks", "pool", is(0, 2.0))
        .route("Part", &["marks", "sink"]);
    let trace = builder.run(2);
    assert_eq!((trace.end, trace.seconds), (End::Products, 4.0));
}

/// The replacement of a part removed by a violation is ordered from the source that makes it.
#[test]
fn a_replacement_comes_from_its_own_source() {
    let mut builder = Builder::new(&["B", "A"]);
    builder
        .source("a", "A", Supply::OnOrder)
        .source("b", "B", Supply::OnOrder)
        .station("cell", &["A", "B"], refusing(5.0, |call| call == 1))
        .sink("sink")
        .scrap("scrap_b", Some("b"))
        .scrap("scrap_a", Some("a"))
        .route("A", &["a", "cell", "sink"])
        .route("B", &["b", "cell", "sink"]);
    let trace = builder.run(3);
    assert_eq!(trace.end, End::Products, "{:?}", trace.findings);
    assert_eq!(trace.rejects[0].part, 1);
}

/// A source with a limit of work in process admits no more than that.
#[test]
fn at_most_limits_the_parts_in_the_line() {
    let mut builder = Builder::new(&["Part"]);
    builder
        .endless("source", "Part")
        .buffer("buffer", 10)
        .station("slow", &["Part"], constant(5.0))
        .sink("sink")
        .route("Part", &["source", "buffer", "slow", "sink"]);
    let source = builder.node("source");
    if let NodeKind::Source { most, .. } = &mut builder.line.nodes[source].kind {
        *most = Some(2);
    }
    let trace = builder.run_until(100.0);
    let (mut there, mut greatest) = (0, 0);
    for entry in &trace.log {
        there += i32::from(entry.what == EventKind::Entered)
            - i32::from(entry.what == EventKind::Finished);
        greatest = greatest.max(there);
    }
    assert_eq!((greatest, trace.products), (2, 20));
}
