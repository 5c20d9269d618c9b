//! What the proof of a line says of its calls, clause by clause of the theorem in `docs/proof.md`:
//! small lines with their expected findings.

use crate::support::linewright;
use linewright::contract::load;
use linewright::game::Limits;
use linewright::line::calls::{Bounds, examine};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// A machine that writes a property, and one that takes any part in `t` seconds.
const MACHINES: &str = "import std.coordination.single

contract Work {
    input requested: bool
    input goal: 0..3
    output finished: bool
    output got: 0..3
    guarantee report: always (finished <-> requested)
    guarantee copies: always got = goal
}
machine Adder {
    step 1 s
    property x: 0..9 = 0
    abstract goal: 0..3 = x
    coordinator c: Single {
        job = operation = add
        executed = a.finished
    }
    action a: Work when c.command {
        requested = c.command
        goal = goal
        time 1 s
    }
    operation add: a
    done c.done
    write x = a.got + 1
}

contract Plain {
    input requested: bool
    output finished: bool
    guarantee report: always (finished <-> requested)
}
machine Any(t: 0..9 = 1) {
    step 0 s
    property x: 0..9 = 0
    coordinator c: Single {
        job = operation = take
        executed = a.finished
    }
    action a: Plain when c.command {
        requested = c.command
        time (t + x) * 1 s
    }
    operation take: a
    done c.done
}
";

/// The line's row in the output of `check`.
fn checked(line: &str) -> Value {
    checked_with(MACHINES, line)
}

fn checked_with(machines: &str, line: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("line.lw"), format!("{machines}{line}")).expect("a file");
    let output = linewright(
        folder.path(),
        &["check", "line.lw", "--format", "json", "--no-timing"],
    );
    let document: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
    document["lines"][0].clone()
}

fn codes(row: &Value, severity: &str) -> Vec<String> {
    let findings = row["findings"].as_array().expect("findings");
    let of = findings.iter().filter(|f| f["severity"] == severity);
    of.map(|f| f["code"].as_str().expect("a code").to_owned())
        .collect()
}

fn premises(row: &Value) -> Vec<&str> {
    let premises = row["premises"].as_array().into_iter().flatten();
    premises
        .map(|p| p["name"].as_str().expect("a name"))
        .collect()
}

fn proved(line: &str, expected: &[&str]) {
    let row = checked(line);
    assert_eq!(row["proof"], "proved", "{line}\n{row:#}");
    assert_eq!(premises(&row), expected, "{line}\n{row:#}");
}

/// Not proved, with these errors and these warnings.
fn open(line: &str, errors: &[&str], warnings: &[&str]) -> String {
    let row = checked(line);
    assert_eq!(row["proof"], "open", "{line}\n{row:#}");
    assert_eq!(codes(&row, "error"), errors, "{line}\n{row:#}");
    assert_eq!(codes(&row, "warning"), warnings, "{line}\n{row:#}");
    row.to_string()
}

/// A row of `count` adders; each adds one, and takes no more than 3.
fn adders(count: usize, first: &str) -> String {
    let (mut stations, mut way) = (String::new(), String::new());
    for i in 0..count {
        let _ = writeln!(
            stations,
            "    station m{i}: Adder {{ perform add on P {first} }}"
        );
        let _ = write!(way, " -> m{i}");
    }
    format!(
        "line L {{
    part P {{ property x: 0..9 = 0 }}
    source s: P every 10 s
    sink k
{stations}    route P: s{way} -> k
}}
"
    )
}

#[test]
fn written_values_are_followed_from_station_to_station() {
    proved(&adders(4, ""), &[]);
    let said = open(&adders(5, ""), &["LW414"], &[]);
    let way =
        "made at s with x = 0; m0 makes x = 1; m1 makes x = 2; m2 makes x = 3; m3 makes x = 4";
    assert!(said.contains(way), "{said}");
}

#[test]
fn defects_count_where_they_can_happen() {
    let defect = |percent: &str, value: &str| {
        format!("defect on P probability {percent} %: x becomes {value}")
    };
    proved(&adders(1, &defect("0", "it + 90")), &[]);
    proved(&adders(3, &defect("50", "max(it - 1, 0)")), &[]);
    open(&adders(1, &defect("1", "it + 90")), &["LW415"], &[]);
    open(&adders(1, &defect("100", "0 - 1")), &["LW415"], &[]);
    // Four are reached only by chance.
    let said = open(&adders(4, &defect("5", "it + 1")), &["LW414"; 2], &[]);
    assert!(said.contains("a defect at m"), "{said}");
}

/// A loop of rework: `again` by chance.
fn rework(defect: &str, initial: u8) -> String {
    format!(
        "line L {{
    part P {{ property again: 0..1 = {initial} }}
    source s: P every 10 s, at most 2 in the line
    sink k
    buffer b capacity 5
    station m: Any {{ perform take on P {defect} }}
    route P: s -> b -> m
    route P: m -> b when again = 1
    route P: m -> k otherwise
}}
"
    )
}

#[test]
fn chance_sees_to_a_branch_or_the_proof_says_that_it_rests_on_it() {
    let often = "defect on P probability 30 %: again becomes 1 - it";
    proved(&rework(often, 0), &[]);
    proved(&rework(often, 1), &[]);
    // Nothing ever goes back, and the rest of the loop is a path.
    proved(&rework("", 0), &[]);
    let always = "defect on P probability 100 %: again becomes 1";
    open(&rework(always, 0), &[], &["LW409"]);
    // Two types with the same kind of branch: how a part is made determines what it does, and
    // nothing says that both continue.
    let fixed = "line L {
    part P { property x: 0..9 = 0 }
    source s: P every 10 s
    sink k
    sink l
    station m: Any { perform take on P  defect on P probability 50 %: x becomes 1 }
    station n: Any { perform take on P }
    route P: s -> m
    route P: m -> k when x = 0
    route P: m -> n otherwise
    route P: n -> l
}
";
    proved(fixed, &[]);
}

#[test]
fn premises_are_named() {
    let stock = "line L {
    part P
    store s: 7 P
    sink k
    station m: Any { perform take on P }
    route P: s -> m -> k
}
";
    proved(stock, &["stock_of_P_at_s"]);
    proved(
        &stock.replace("store s: 7 P", "source s: P every 5 s limit 7"),
        &["more_from_s"],
    );
    let scrap = "line L {
    part P { property x: 0..9 = 0 }
    source s: P on order
    sink k
    sink bad rejectsREORDER
    station m: Any { perform take on P  defect on P probability 50 %: x becomes 1 }
    route P: s -> m
    route P: m -> bad when x = 1
    route P: m -> k otherwise
}
";
    proved(&scrap.replace("REORDER", ""), &["more_orders_for_s"]);
    proved(&scrap.replace("REORDER", " reorder s"), &[]);
    // Of the ways from m, only those that lead to different places are a premise.
    let ways = "line L {
    part P { property x: 0..9 = 0 }
    source s: P every 5 s, at most 1 in the line
    buffer b capacity 3
    sink k
    station m: Any { perform take on P  defect on P probability 50 %: x becomes 3 }
    route P: s -> m
    route P: m -> b when x > 1
    route P: m -> b
    route P: b -> m when x > 1
    route P: b -> k
}
";
    proved(ways, &["b_sends_P_to_k"]);
}

/// Work that begins again after each failure may never end. A run in which it does not is no
/// contradiction to the proof only if that is a premise.
#[test]
fn work_that_may_begin_again_for_ever_is_a_premise() {
    let line = |station: &str| {
        format!(
            "line L {{
    part P
    source s: P every 5 s
    sink k
    station m {{ {station} }}
    route P: s -> m -> k
}}
"
        )
    };
    let named = ["work_ends_at_m"];
    for (station, expected) in [
        (
            "takes 1 s failures mtbf constant(0.9 s) mttr 1 s restart",
            &named[..],
        ),
        (
            "takes 1 s failures mtbf constant(0.9 s) mttr 1 s by calendar restart",
            &named,
        ),
        (
            "takes exponential(1 s) failures mtbf uniform(5 s, 7 s) mttr 1 s restart",
            &named,
        ),
        ("takes 1 s failures mtbf constant(0.9 s) mttr 1 s", &[]),
        (
            "takes 1 s failures mtbf constant(1 s) mttr 1 s restart",
            &[],
        ),
        (
            "takes exponential(1 s) failures mtbf 2 s mttr 1 s restart",
            &[],
        ),
        ("takes 1 s failures every 3 parts mttr 1 s restart", &[]),
    ] {
        proved(&line(station), expected);
    }
}

/// After the last ordered parts, other components wait for ever. That is a premise where they can
/// be in the way, or where they are not needed.
#[test]
fn the_last_orders_come_through() {
    let line = |supplies: &str, routes: &str| {
        format!(
            "line L {{
    part A
    part B
    part J from 1 A, 1 B
    product J
    {supplies}
    buffer b capacity 2
    station t: Any {{ perform take on J }}
    sink out
    {routes}
}}
"
        )
    };
    let free = "source a: A every 1 s, at most 3 in the line
    source s: B on order";
    let apart = "route A: a -> t
    route B: s -> t
    route J: t -> b -> out";
    let behind = "route A: a -> b -> t
    route B: s -> t
    route J: t -> b -> out";
    proved(&line(free, apart), &[]);
    proved(&line(free, behind), &["more_orders_for_s"]);
    // As many A as B are ordered.
    let both = "source a: A on order, at most 3 in the line
    source s: B on order";
    proved(&line(both, behind), &[]);
    // The last B can wait at t for another one, which went to u.
    let split = "line L {
    part B { property v: 0..1 = 0 }
    part J from 2 B
    product J
    source s: B on order
    station m: Any { perform take on B  defect on B probability 50 %: v becomes 1 }
    station t: Any { perform take on J }
    station u: Any { perform take on J }
    sink out
    route B: s -> m
    route B: m -> t when v = 0
    route B: m -> u otherwise
    route J: t -> out
    route J: u -> out
}
";
    proved(split, &["more_orders_for_s"]);
}

#[test]
fn joined_parts_take_over_values() {
    let line = |defect: u8| {
        format!(
            "line L {{
    part A {{ property x: 0..9 = 0 }}
    part B
    part P from 1 A, 1 B {{ property x: 0..9 = A.x }}
    product P
    source a: A every 10 s
    source b: B every 10 s
    sink k
    station m: Any {{ perform take on A  defect on A probability 50 %: x becomes {defect} }}
    station j: Adder {{ perform add on P }}
    route A: a -> m -> j
    route B: b -> j
    route P: j -> k
}}
"
        )
    };
    proved(&line(3), &[]);
    let said = open(&line(7), &["LW414"], &[]);
    assert!(said.contains("joined to a P at j with x = 7"), "{said}");
}

#[test]
fn time_has_to_pass_for_all_values() {
    let line = |t: u8, defect: &str| {
        format!(
            "line L {{
    part P {{ property x: 0..9 = 0 }}
    source s: P on order
    sink k
    station m: Any(t = {t}) {{ perform take on P }}
    station n: Any(t = {t}) {{ perform take on P {defect} }}
    route P: s -> n -> m -> k
}}
"
        )
    };
    proved(&line(1, ""), &[]);
    open(&line(0, ""), &["LW416"], &[]);
    // For one part in two the work at `m` takes time, that at `n` never does.
    open(
        &line(0, "defect on P probability 50 %: x becomes 1"),
        &[],
        &["LW416"],
    );
    proved(&line(0, "").replace("on order", "every 1 s"), &[]);
}

/// A duration computed in a station's file may be longer than a run can measure.
#[test]
fn no_work_takes_longer_than_a_run_can_measure() {
    let machines = MACHINES.replace("(t + x) * 1 s", "(t + x) * 1e9 s");
    let line = |t: u8| {
        format!(
            "line L {{
    part P
    source s: P on order
    sink k
    station m: Any(t = {t}) {{ perform take on P }}
    route P: s -> m -> k
}}
"
        )
    };
    let sound = checked_with(&machines, &line(1));
    assert_eq!(sound["proof"], "proved", "{sound:#}");
    let open = checked_with(&machines, &line(2));
    assert_eq!(open["proof"], "open", "{open:#}");
    assert_eq!(codes(&open, "error"), ["LW414"], "{open:#}");
}

/// A part that goes round by its values, or by chance, eventually leaves.
#[test]
fn a_circle_without_time_is_one_that_parts_do_not_leave() {
    let machines = format!(
        "{MACHINES}\nmachine Counter {{
    step 0 s
    property v: 0..3 = 0
    coordinator c: Single {{
        job = operation = take
        executed = a.finished
    }}
    action a: Plain when c.command {{
        requested = c.command
        time 0 s
    }}
    operation take: a
    done c.done
    write v = min(v + 1, 3)
}}
"
    );
    let line = |supply: &str, back: &str, defect: &str| {
        format!(
            "line L {{
    part P {{
        property v: 0..3 = 0
    }}
    source s: P {supply}
    sink k
    store b
    station m: Counter {{
        perform take on P
        {defect}
    }}
    route P: s -> b -> m
    route P: m -> b when {back}
    route P: m -> k otherwise
}}
"
        )
    };
    let said = |text: &str| {
        let row = checked_with(&machines, text);
        let errors: Vec<String> = codes(&row, "error")
            .iter()
            .map(ToString::to_string)
            .collect();
        let warnings: Vec<String> = codes(&row, "warning")
            .iter()
            .map(ToString::to_string)
            .collect();
        (
            row["proof"].as_str().unwrap_or("none").to_owned(),
            errors.join(" "),
            warnings.join(" "),
        )
    };
    let of = |proof: &str, errors: &str, warnings: &str| {
        (proof.to_owned(), errors.to_owned(), warnings.to_owned())
    };
    assert_eq!(said(&line("every 5 s", "v < 3", "")), of("proved", "", ""));
    // From a source that always has another part no time passes, round by round.
    assert_eq!(
        said(&line("on order", "v < 3", "")),
        of("open", "LW416", "")
    );
    // Chance guarantees that they leave, and values that they do not.
    let defect = "defect on P probability 50 %: v becomes 0";
    assert_eq!(said(&line("every 5 s", "v = 1", "")), of("proved", "", ""));
    assert_eq!(
        said(&line("every 5 s", "v = 0", defect)),
        of("open", "", "LW416")
    );
}

/// Stores give out what they took in, and sinks take whatever comes.
#[test]
fn time_has_to_pass_between_stores_too() {
    let line = |ways: &str| {
        format!(
            "line L {{
    part P
    part Q
    product P
    source s: P on order
    sink k
    source q: Q on order
    station m: Any {{ perform take on P  perform take on Q }}
    route P: s -> m -> k
{ways}}}
"
        )
    };
    let said = open(&line("    sink l\n    route Q: q -> l\n"), &["LW416"], &[]);
    assert!(said.contains("from q to l"), "{said}");
    open(
        &line("    store a\n    route Q: q -> a -> a\n"),
        &["LW416"],
        &[],
    );
    open(
        &line("    store a\n    store b\n    route Q: q -> b -> a -> b\n"),
        &["LW416"],
        &[],
    );
    proved(&line("    store b\n    route Q: q -> m -> b\n"), &[]);
    // A store is never full, whatever leaves it; its initial stock is finite.
    let said = open(
        &line("    store a\n    sink l\n    route Q: q -> a -> m -> l\n"),
        &["LW416"],
        &[],
    );
    assert!(said.contains("from q to a"), "{said}");
    proved(
        &line(
            "    store a: 3 P\n    store b\n    route Q: q -> m -> b\n    sink l\n    route P: a -> l\n",
        ),
        &["stock_of_P_at_a"],
    );
}

#[test]
fn every_part_needs_a_way() {
    let line = |condition: &str, defect: &str| {
        format!(
            "line L {{
    part P {{ property x: 0..9 = 0 }}
    source s: P every 5 s
    sink k
    station m: Any {{ perform take on P {defect} }}
    route P: s -> m
    route P: m -> k when {condition}
}}
"
        )
    };
    let half = "defect on P probability 50 %: x becomes 1";
    proved(&line("x <= 1", half), &[]);
    open(&line("x = 0", half), &["LW402"], &[]);
    open(&line("x = 2", half), &["LW402"], &[]);
}

#[test]
fn what_is_too_much_to_follow_is_not_proved() {
    let line = "line L {
    part P { property n: number = 0  property o: number = 0 }
    source s: P every 10 s, at most 2 in the line
    sink k
    buffer b capacity 5
    station m: Any {
        perform take on P
        defect on P probability 50 %: n becomes it + 1
        defect on P probability 50 %: o becomes it + 1
    }
    route P: s -> b -> m
    route P: m -> b when n > o
    route P: m -> k otherwise
}
";
    let row = checked(line);
    assert_eq!(row["proof"], "safe", "{row:#}");
    assert!(
        row["undecided"].to_string().contains("answers_at_"),
        "{row:#}"
    );
    assert_eq!(codes(&row, "note"), ["LW410"], "{row:#}");
}

#[test]
fn a_belt_has_to_keep_its_parts_and_its_assumptions() {
    let with = |change: fn(String) -> String, end: &str| {
        let belt = "moore contract Carry {
    input load, unload_ready: bool
    output s: array[2] of bool
    output ready: bool
    assume waits: always (load and not ready -> next load)
    assume taken: always eventually unload_ready
    define moves = unload_ready or not s[1]
    guarantee empty: not s[0] and not s[1]
    guarantee first: always (next s[0] <-> (load and not s[0]) or (s[0] and not moves))
    guarantee shift: always (next s[1] <-> (if moves then s[0] else s[1]))
    guarantee room: always (ready <-> not s[0])
}
machine Belt {
    signal load: bool = false
    signal unload_ready: bool = true
    action belt: Carry
}
";
        let belt = change(belt.to_owned());
        format!(
            "{belt}line L {{
    part P
    source s: P every 5 s
    sink k
    conveyor v: Belt pitch 1 m speed 1 m/s
    station m: Any {{ perform take on P }}
    route P: s -> v -> {end}
}}
"
        )
    };
    proved(&with(|belt| belt, "m -> k"), &[]);
    // The part on its last place is gone a step later, taken or not.
    let loses = |belt: String| belt.replace("(if moves then s[0] else s[1])", "s[0] and moves");
    let said = open(&with(loses, "m -> k"), &[], &["LW407"]);
    assert!(said.contains("stay on it"), "{said}");
    let demands = |belt: String| {
        belt.replace(
            "assume waits:",
            "assume free: always unload_ready\n    assume waits:",
        )
    };
    let said = open(&with(demands, "m -> k"), &[], &["LW411"]);
    assert!(said.contains("`free`"), "{said}");
}

/// A number that nothing depends on may grow for ever, as long as it stays finite.
#[test]
fn what_nobody_reads_need_not_be_followed() {
    let line = |write: &str, condition: &str| {
        format!(
            "import std.coordination.single
contract Plain {{
    input requested: bool
    output finished: bool
    output weight: 0..3
    guarantee report: always (finished <-> requested)
}}
machine Mill {{
    step 1 s
    property rounds: mm = 0
    property wear: mm = 1
    property good: bool = true
    coordinator c: Single {{
        job = operation = mill
        executed = a.finished
    }}
    action a: Plain when c.command {{
        requested = c.command
    }}
    operation mill: a
    done c.done
    write {write}
}}
line L {{
    part P {{
        property rounds: mm = 0
        property wear: mm = 1
        property good: bool = true
    }}
    source s: P on order, at most 2 in the line
    sink k
    buffer b capacity 2
    station m: Mill {{
        perform mill on P
        defect on P probability 10 %: good becomes false
        defect on P probability 90 %: wear becomes wear - 1 mm
    }}
    route P: m -> b when not good {condition}
    route P: b -> m
    route P: s -> m -> k
}}
"
        )
    };
    let check = |write: &str, condition: &str| checked_with("", &line(write, condition));
    let row = check(
        "rounds = rounds + 1 mm + a.weight * 1 mm  write good = true",
        "",
    );
    assert_eq!(row["proof"], "proved", "{row:#}");
    // It may become infinite: then each value counts, and there may be too many.
    let row = check("rounds = rounds * 3 + 1 mm  write good = true", "");
    assert_eq!(codes(&row, "error"), ["LW414"], "{row:#}");
    let row = check("rounds = rounds * 1.001 + 1 mm  write good = true", "");
    assert_eq!(row["proof"], "safe", "{row:#}");
    // What is read is followed, even indirectly.
    let row = check(
        "rounds = rounds + 1 mm  write wear = rounds  write good = true",
        "and wear < 3 mm",
    );
    assert_eq!(row["proof"], "proved", "{row:#}");
}

/// Nothing works on a product that is never joined, and that is no error of the proof.
#[test]
fn a_task_for_which_nothing_comes_is_none() {
    let said = open(
        "line L {
    part P { property x: 0..9 = 0 }
    part Q { property x: 0..9 = 0 }
    part A from 1 P, 1 Q { property x: 0..9 = P.x }
    product A
    source p: P on order
    source q: Q on order
    sink k
    sink l
    station m: Any(t = 1) { perform take on Q }
    station j: Any(t = 1) { perform take on A }
    station n: Any(t = 1) { perform take on A }
    route P: p -> j
    route Q: q -> m
    route Q: m -> j when x = 3
    route Q: m -> l otherwise
    route A: j -> n -> k
}
",
        &[],
        &["LW409", "LW402"],
    );
    assert!(!said.contains("mistake in Linewright"), "{said}");
}

#[test]
fn a_station_that_no_part_reaches_is_reported() {
    let line = |condition: &str| {
        format!(
            "line L {{
    part P {{ property x: 0..9 = 0 }}
    source s: P on order
    sink k
    station m: Any(t = 1) {{ perform take on P }}
    station n: Any(t = 1) {{ perform take on P }}
    route P: s -> m when {condition}
    route P: s -> n otherwise
    route P: m -> k
    route P: n -> k
}}
"
        )
    };
    let row = checked(&line("x <= 5"));
    assert_eq!(row["proof"], "proved", "{row:#}");
    assert_eq!(codes(&row, "warning"), ["LW402"], "{row:#}");
    assert!(
        row.to_string().contains("no P ever goes from s to n"),
        "{row:#}"
    );
    let row = checked(&line("x > 5"));
    assert_eq!(codes(&row, "warning"), ["LW402"], "{row:#}");
    assert!(
        row.to_string().contains("no P ever goes from s to m"),
        "{row:#}"
    );
}

#[test]
fn no_work_gives_energy_back() {
    let machines = MACHINES.replace("time (t + x) * 1 s", "time 1 s  power (t - x) * 1 W");
    let line = |t: u8| {
        format!(
            "line L {{
    part P {{ property x: 0..9 = 5 }}
    source s: P on order
    sink k
    station m: Any(t = {t}) {{ perform take on P }}
    route P: s -> m -> k
}}
"
        )
    };
    let sound = checked_with(&machines, &line(5));
    assert_eq!(sound["proof"], "proved", "{sound:#}");
    let open = checked_with(&machines, &line(4));
    assert_eq!(codes(&open, "error"), ["LW414"], "{open:#}");
}

#[test]
fn a_store_that_is_always_empty_is_reported() {
    let line = |stock: u8| {
        format!(
            "line L {{
    part P
    part R
    product P
    source s: P on order
    store b: {stock} R
    sink k
    sink l
    station m: Any(t = 1) {{ perform take on P }}
    station n: Any(t = 1) {{ perform take on R }}
    route P: s -> m -> k
    route R: b -> n -> l
}}
"
        )
    };
    let row = checked(&line(0));
    assert_eq!(codes(&row, "warning"), ["LW402"], "{row:#}");
    assert!(row.to_string().contains("no R ever leaves b"), "{row:#}");
    let row = checked(&line(3));
    assert_eq!(codes(&row, "warning"), [""; 0], "{row:#}");
    assert_eq!(premises(&row), ["stock_of_R_at_b"], "{row:#}");
}

/// An incomplete exploration is not taken as complete: many defects of one part, and joins of many
/// values.
#[test]
fn what_was_not_looked_at_is_not_taken_for_nothing() {
    let defects = "        defect on P probability 50 %: one of h becomes 3 - it\n".repeat(6);
    let row = checked(&format!(
        "line L {{
    part P {{
        property x: 0..9 = 0
        property h: array[40] of 0..3 = 0
    }}
    source s: P on order
    sink k
    station m: Any(t = 1) {{
        perform take on P
{defects}    }}
    route P: s -> m
    route P: m -> k when h[0] >= 0
}}
"
    ));
    assert_eq!(row["proof"], "safe", "{row:#}");

    // Four types with thirty values each; the value of the first decides, and 29 of them are
    // refused.
    let mut line = String::from("line L {\n");
    for part in ["P", "Q", "R", "S"] {
        let _ = writeln!(line, "    part {part} {{ property a: 0..29 = 0 }}");
        let _ = writeln!(line, "    source s{part}: {part} on order");
        let _ = writeln!(
            line,
            "    station m{part}: Any(t = 1) {{ perform take on {part}"
        );
        for value in 1..30 {
            let _ = writeln!(
                line,
                "        defect on {part} probability 5 %: a becomes {value}"
            );
        }
        let _ = writeln!(line, "    }}\n    route {part}: s{part} -> m{part} -> j");
    }
    line += "    part A from 1 P, 1 Q, 1 R, 1 S {
        property a: 0..29 = P.a
        property b: 0..29 = Q.a
        property c: 0..29 = R.a
        property d: 0..29 = S.a
    }
    product A
    sink k
    station j: Any(t = 1) { perform take on A }
    route A: j -> k when a + b + c + d < 100
}
";
    let row = checked(&line);
    assert_ne!(row["proof"], "proved", "{row:#}");
}

/// A part that chance has brought into a loop without an exit stays there, though each new part had
/// a chance to leave.
#[test]
fn a_loop_without_a_way_out_is_no_matter_of_chance() {
    let line = |defect: &str| {
        format!(
            "line L {{
    part P {{ property x: 0..9 = 1 }}
    source s: P on order, at most 1 in the line
    sink k
    buffer b capacity 1
    station m: Any(t = 1) {{
        perform take on P
        {defect}
    }}
    route P: s -> m
    route P: m -> b when x = 0
    route P: b -> m
    route P: m -> k otherwise
}}
"
        )
    };
    // Once 0, always 0.
    proved(
        &line("defect on P probability 10 %: x becomes 0"),
        &["m_sends_P_to_k"],
    );
    // From 0 there is a chance to leave.
    proved(&line("defect on P probability 10 %: x becomes 1 - it"), &[]);
}

#[test]
fn a_walk_that_ends_early_says_nothing_of_routes_that_it_did_not_reach() {
    let text = "line L {
    part P
    source s: P every 10 s
    buffer a capacity 1
    buffer b capacity 1
    sink k
    route P: s -> a -> b -> k
}
";
    let files = [("line.lw".to_owned(), text.to_owned())];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(findings.is_empty(), "{findings:?}");
    let bounds = Bounds {
        values: 1_000,
        steps: 1_000,
    };
    let late = Limits {
        deadline: linewright::deadline::Deadline::from_now(std::time::Duration::ZERO),
        ..Limits::default()
    };
    let calls = examine(&library.lines[0], |_| None, &bounds, &late);
    assert!(!calls.undecided.is_empty());
    assert!(calls.findings.is_empty(), "{:?}", calls.findings);
    assert!(calls.remarks.is_empty(), "{:?}", calls.remarks);
    assert_eq!(calls.taken, [true; 3]);
    let calls = examine(&library.lines[0], |_| None, &bounds, &Limits::default());
    assert!(calls.undecided.is_empty(), "{:?}", calls.undecided);
}

/// Lines compute with real numbers: half of 3 is 1.5, and `floor` makes it 1.
#[test]
fn a_line_divides_as_real_numbers_are_divided() {
    let folder = tempfile::tempdir().expect("a folder");
    for (condition, finished) in [
        ("x / 2 = 1", 0),
        ("x / 2 = 1.5", 4),
        ("floor(x / 2) = 1", 4),
    ] {
        let line = format!(
            "{MACHINES}line L {{
    part P {{ property x: 0..9 = 3 }}
    source s: P every 9 s limit 4
    sink k
    sink bin rejects
    station a: Any {{ perform take on P }}
    route P: s -> a
    route P: a -> k when {condition}
    route P: a -> bin otherwise
}}
"
        );
        std::fs::write(folder.path().join("line.lw"), line).expect("a file");
        let words = ["run", "line.lw", "--until", "1h", "--format", "json"];
        let output = linewright(folder.path(), &words);
        let document: Value = serde_json::from_slice(&output.stdout).expect("a document");
        assert_eq!(document["products"], finished, "{condition}: {document:#}");
    }
}

/// A machine with an error of its own is judged where it is used; a file that cannot be parsed is
/// not used at all.
#[test]
fn what_stands_beside_a_line_has_to_be_understood() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = "line L {
    part P
    source s: P every 9 s
    sink k
    station a: Any { perform take on P }
    route P: s -> a -> k
}
";
    // Nothing binds `a` to an order; and an operation that can never end.
    let unbound = "machine Beside {
    step 1 s
    coordinator c: Single { job = operation = go  executed = a.finished }
    action a: Plain when c.command { }
    operation go: a
    done c.done
}
";
    let stuck = &unbound.replace("c.command { }", "c.command { requested = false }");
    for (beside, code, exit) in [(unbound, "LW301", 1), (stuck, "LW303", 0)] {
        let text = format!("{MACHINES}{line}{beside}");
        std::fs::write(folder.path().join("line.lw"), text).expect("a file");
        let run = |words: &[&str]| {
            let output = linewright(folder.path(), words);
            let said = [output.stdout, output.stderr].concat();
            (
                output.status.code(),
                String::from_utf8_lossy(&said).into_owned(),
            )
        };
        let (checked, said) = run(&["check", "line.lw"]);
        assert_eq!(checked, Some(1), "{said}");
        assert!(said.contains(code), "{said}");
        for words in [
            &["run", "line.lw::L", "--parts", "3"][..],
            &["build", "line.lw::Any", "--target", "source"],
        ] {
            let (ended, said) = run(words);
            assert_eq!(ended, Some(exit), "{words:?} beside {code}: {said}");
            assert_eq!(said.contains(code), exit == 1, "{words:?}: {said}");
        }
    }
}

/// Whatever the error of the machine is.
#[test]
fn a_line_with_an_invalid_machine_is_invalid() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |bound: &str, guarantee: &str| {
        format!(
            "contract Turn {{
    input grip: bool
    output turning: bool
    guarantee safe: {guarantee}
}}
machine Table {{
    action turn: Turn {{ {bound} }}
    operation go: turn
    done turn.turning
}}
line L {{
    part P
    source s: P every 10 s
    sink k
    station m: Table {{ perform go on P }}
    route P: s -> m -> k
}}
"
        )
    };
    let bound = "grip = true";
    let keeps = "always (turning <-> grip)";
    for (text, code) in [
        (file("", keeps), "LW301"),
        (file("grip = 3", keeps), "LW103"),
        (file(bound, "always (next grip)"), "LW203"),
        (file(bound, keeps), "LW306"),
    ] {
        std::fs::write(folder.path().join("line.lw"), text).expect("a file");
        let output = linewright(folder.path(), &["check", "line.lw", "--format", "json"]);
        let document: Value = serde_json::from_slice(&output.stdout).expect("a document");
        assert_eq!(document["lines"][0]["verdict"], "invalid", "{document:#}");
        assert!(document.to_string().contains(code), "{document:#}");
    }
}

/// Output of `check`, `build` and `run` for a line, with their exit codes.
fn judged(line: &str) -> [(i32, String); 3] {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("line.lw"), line).expect("a file");
    let deny = ["--deny", "warnings"];
    let commands: [&[&str]; 3] = [
        &["check", "line.lw"],
        &["build", "line.lw", "--target", "source"],
        &["run", "line.lw", "--parts", "3", "--until", "1h"],
    ];
    commands.map(|command| {
        let output = linewright(folder.path(), &[command, &deny].concat());
        let said = [output.stdout, output.stderr].concat();
        let said = format!("{command:?}: {}", String::from_utf8_lossy(&said));
        let built = folder.path().join(".linewright").is_dir() || said.contains("LW315");
        assert!(command[0] != "build" || built, "{said}");
        (output.status.code().expect("an exit code"), said)
    })
}

/// An error in the calls of a line is an error of all commands, although libraries are built and
/// parts are made.
#[test]
fn all_commands_refuse_what_following_the_parts_shows() {
    for code in ["LW414", "LW415", "LW416"] {
        let explained = linewright(Path::new("."), &["explain", code]);
        let page = String::from_utf8_lossy(&explained.stdout);
        let (_, example) = page.split_once("```lw").expect("an example");
        let (example, _) = example.split_once("```").expect("its end");
        let (_, example) = example.split_once('\n').expect("its first line");
        for (exit, said) in judged(example) {
            assert_eq!(exit, 1, "{said}");
            assert!(said.contains(&format!("error[{code}]")), "{said}");
        }
    }
}

/// A machine calls skills whose orders contradict each other.
const CONTRADICTORY: &str = "import std.coordination.single
contract Act {
    input asked: bool
    output executed: bool
    guarantee report: always (executed <-> asked)
}
skills Sk {
    component c: {l, r} = r {
        A -> l
        B -> r
    }
    order o at reasonable: after A: never B
}
machine M {
    step 1 s
    coordinator co: Single {
        job = operation = a
        executed = act.executed
    }
    action act: Act when co.command {
        asked = co.command
        time 2 s
    }
    operation a: act
    done co.done
    skills Sk {
        A = operation = a
        B = false
    }
}
line L {
    part P
    source s: P every 5 s
    sink out
    station m: M { perform a on P }
    route P: s -> m -> out
}
";

/// A machine that cannot begin alone, but can in its outer machine, where its signal is another
/// wire.
const INNER: &str = "import std.coordination.single
contract Act {
    input asked, ready: bool
    output executed: bool
    assume st: not ready
    guarantee report: always (executed <-> asked)
}
moore contract Lead {
    input job, executed: bool
    output ask, done: bool
    assume served: always eventually (not ask or executed)
    guarantee s: not ask and not done
    guarantee ak: always (next ask <-> (if ask then not executed else job and not done))
    guarantee dd: always (next done <-> ask and executed)
    guarantee completes: always eventually not ask
}
machine Inner {
    step 1 s
    signal ready: bool = true
    coordinator co: Single {
        job = operation = a
        executed = act.executed
    }
    action act: Act when co.command {
        asked = co.command
        time 2 s
    }
    operation a: act
    done co.done
}
machine Outer {
    step 1 s
    signal ready: bool = false
    coordinator co: Lead {
        job = operation = b
        executed = inn.done
    }
    machine inn: Inner { operation = if co.ask then a else none }
    operation b: inn.a
    done co.done
}
line L {
    part P
    source s: P every 5 s
    sink out
    station m: Outer { perform b on P }
    route P: s -> m -> out
}
";

#[test]
fn all_commands_judge_skills_and_inner_machines_alike() {
    for (exit, said) in judged(CONTRADICTORY) {
        assert_eq!(exit, 1, "{said}");
        assert!(said.contains("error[LW315]"), "{said}");
    }
    let [check, build, run] = judged(INNER);
    assert!(check.1.contains("warning[LW306]"), "{}", check.1);
    for (exit, said) in [build, run] {
        assert_eq!(exit, 0, "{said}");
    }
}

/// The resolver does not know the values of parts, so it doubts a last route with a condition. If
/// following the parts shows that it always holds, no command reports it.
#[test]
fn all_commands_agree_on_routes_with_conditions() {
    let line = |condition: &str| {
        format!(
            "line L {{
    part P {{ property x: 0..9 = 0 }}
    source s: P on order
    sink k
    station m: Adder {{ perform add on P }}
    route P: s -> m
    route P: m -> k when {condition}
    limit 5 products
}}
"
        )
    };
    for (condition, wanted) in [("x = 1", 0), ("x = 2", 1)] {
        for (exit, said) in judged(&format!("{MACHINES}{}", line(condition))) {
            assert_eq!(exit, wanted, "{condition}: {said}");
            assert_eq!(said.contains("LW402"), wanted == 1, "{condition}: {said}");
        }
    }
}
