//! Stocks that leave in one instant. In the abstraction a stock never runs out, so that such an
//! instant would never end, and everything would follow from it.

use super::judge::{Judged, judge};

/// A join that is fed by a buffer, into which it also puts what it has made: two `P` in the buffer
/// and two at the join deadlock.
fn line(statements: &str) -> String {
    format!(
        "import std.coordination.single
contract Work {{
    input requested: bool
    output finished: bool
    guarantee fast: always (finished <-> requested)
}}
machine M {{
    step 1 s
    coordinator c: Single {{ job = operation = go  executed = a.finished }}
    action a: Work when c.command {{ requested = c.command  time 5 s }}
    operation go: a
    done c.done
}}
line L {{
    part P
    part A from 1 P
    product A
    sink out
    station join: M {{ perform go on A }}
    buffer loop capacity 2
    route A: join -> loop -> out
    {statements}
}}
"
    )
}

fn judged(statements: &str) -> Judged {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("line.lw");
    std::fs::write(&file, line(statements)).expect("a file");
    let mut report = judge(&file, &folder.path().join("cache"));
    assert_eq!(report.failure, None);
    report.lines.remove("L").expect("the line")
}

const FED: &str = "source s: P every 1 s
    route P: s -> loop -> join";

#[test]
fn a_stock_that_leaves_in_one_instant_hides_no_deadlock() {
    for stock in [
        "",
        "part Box
    store boxes: 3 Box
    route Box: boxes -> out",
        "part Box
    store boxes: 3 Box
    store shelf
    route Box: boxes -> shelf -> out",
    ] {
        let judged = judged(&format!("{FED}\n    {stock}"));
        assert_eq!(judged.proof.as_deref(), Some("open"), "{stock}: {judged:?}");
        assert!(judged.reasons.contains(&"LW408".to_owned()), "{judged:?}");
    }
    let shelf = "store stock: 500 P
    store shelf
    route P: stock -> shelf -> loop -> join";
    let judged = judged(shelf);
    assert_eq!(judged.proof.as_deref(), Some("open"), "{judged:?}");
    assert!(judged.reasons.contains(&"LW408".to_owned()), "{judged:?}");
}

/// By way of a buffer, other parts may be waiting for the same room.
#[test]
fn a_stock_that_passes_a_buffer_in_one_instant_is_not_decided() {
    let through = "part Box
    store boxes: 3 Box
    buffer tray capacity 1
    route Box: boxes -> tray -> out";
    let judged = judged(&format!("{FED}\n    {through}"));
    assert_eq!(judged.proof.as_deref(), Some("gave_up"), "{judged:?}");
    assert!(judged.reasons.contains(&"LW410".to_owned()), "{judged:?}");
}

/// A sink that orders again makes a limited source an endless one, and a run takes a million
/// movements at one instant for no progress.
#[test]
fn parts_that_never_end_are_found_though_their_number_is_limited() {
    let endless = [
        "source boxes: Box every 0 s limit 3
    sink bin rejects reorder boxes
    route Box: boxes -> bin",
        "source boxes: Box every 0 s limit 3000000
    route Box: boxes -> out",
        "store boxes: 3000000 Box
    route Box: boxes -> out",
    ];
    for boxes in endless {
        let judged = judged(&format!("{FED}\n    part Box\n    {boxes}"));
        assert!(judged.errors.contains(&"LW416".to_owned()), "{judged:?}");
        assert!(!judged.is_proved());
    }
    let judged = judged(&format!(
        "{FED}
    part Box
    source boxes: Box every 0 s limit 3
    route Box: boxes -> out"
    ));
    assert!(judged.errors.is_empty(), "{judged:?}");
}
