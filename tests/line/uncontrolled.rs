//! What the proof of a line takes from stations that are given by their times: the values that they
//! set, and whether their work takes time. Clauses C2 to C4 of `docs/proof.md`.

use linewright::contract::load;
use linewright::game::Limits;
use linewright::line::calls::{Bounds, Calls, examine};

/// Follows the parts of a line with this body. The name of a table is its content: `0 1 1.csv`.
fn follow(body: &str) -> Calls {
    let text = format!("line L {{ {body} }}");
    let files = [("line.lw".to_owned(), text.clone())];
    let (library, _) = load(&files, &|path, _| match path.split_once(".csv") {
        Some((table, "")) => Ok((
            path.to_owned(),
            format!("t\n{}\n", table.replace(' ', "\n")),
        )),
        _ => Err("no imports".to_owned()),
    });
    assert_eq!(library.lines.len(), 1, "{text}");
    let bounds = Bounds {
        values: 1_000,
        steps: 1_000,
    };
    let calls = examine(&library.lines[0], |_| None, &bounds, &Limits::default());
    assert!(calls.undecided.is_empty(), "{text}: {:?}", calls.undecided);
    calls
}

fn codes(calls: &Calls) -> Vec<&str> {
    calls.findings.iter().map(|f| f.code.id).collect()
}

/// A part goes round until the second station has set its property.
#[test]
fn values_that_a_station_sets_decide_the_way() {
    let looping = |set: &str| {
        follow(&format!(
            "part P {{ property v: 0..3 = 0 property w: 0..3 = 1 }}
             source a: P every 1 s
             station s {{ takes 1 s {set} }}
             sink k
             route P: a -> s
             route P: s -> k when v = 3
             route P: s -> s otherwise"
        ))
    };
    let counts = looping("sets v = min(v + 1, 3)");
    assert_eq!(codes(&counts), [""; 0]);
    assert_eq!(counts.taken, [true, true, true]);
    assert!(counts.by_chance[1]);
    // Nobody sets it, so the route to the sink is never taken.
    assert_eq!(looping("").taken, [true, false, true]);
    // Both are computed from the values before: they are exchanged.
    let swapped = looping("sets v = w sets w = v + 2");
    assert_eq!(codes(&swapped), ["LW415"]);
    let swapped = looping("sets v = w + 1 sets w = 2");
    assert_eq!(swapped.taken, [true, true, true]);
}

#[test]
fn a_value_out_of_range_is_found() {
    let calls = follow(
        "part P { property v: 0..3 = 0 }
         source a: P every 1 s
         station s { takes 1 s sets v = v + 1 }
         sink k
         route P: a -> s
         route P: s -> k when v = 3
         route P: s -> s otherwise",
    );
    assert_eq!(codes(&calls), [""; 0]);
    let calls = follow(
        "part P { property v: 0..3 = 0 }
         source a: P every 1 s
         station s { takes 1 s sets v = v + 2 }
         sink k
         route P: a -> s
         route P: s -> k when v = 3
         route P: s -> s otherwise",
    );
    assert_eq!(codes(&calls), ["LW415"]);
}

/// Work of 0 s, even if only some draws are 0, lets parts go round without time passing.
#[test]
fn work_without_time_is_found() {
    let looping = |time: &str| {
        let calls = follow(&format!(
            "part P {{ property v: bool = false }}
             source a: P every 1 s
             station s {{ takes {time} defect on P probability 50 %: v becomes true }}
             sink k
             route P: a -> s
             route P: s -> k when v
             route P: s -> s otherwise"
        ));
        calls.timeless.map(|found| (found.always, found.stations))
    };
    for time in ["0 s", "uniform(0 s, 0 s)", "exponential(0 s)"] {
        assert_eq!(looping(time), Some((false, vec![1])), "{time}");
    }
    let discrete = "discrete(0 s: 1 %, 1 s: 99 %)";
    assert_eq!(looping(discrete), Some((false, vec![1])));
    let empirical = "empirical(\"0 1 2.csv\" column t in s)";
    assert_eq!(looping(empirical), Some((false, vec![1])));
    for time in [
        "1 s",
        "empirical(\"1 1 2.csv\" column t in s)",
        "uniform(0 s, 1 s)",
        "exponential(1 s)",
        "discrete(0 s: 0 %, 1 s: 100 %)",
        "gamma(0.5, 1 s)",
    ] {
        assert_eq!(looping(time), None, "{time}");
    }
}

/// Parts of a table follow one another at once only if very many come together, or if a sink that
/// they reach at once orders replacements.
#[test]
fn many_parts_at_one_instant_are_found() {
    let calls = |instants: &str, sinks: &str| {
        follow(&format!(
            "part P {{ property v: 0..3 = 0 }}
             source a: P at \"{instants}.csv\" column t in min
             station s {{ takes 1 s }}
             sink k
             {sinks}
             route P: a -> s, bin
             route P: s -> k"
        ))
    };
    let ends = |calls: Calls| calls.timeless.map(|found| (found.from, found.to));
    let rejects = "sink bin rejects sink other rejects reorder a route P: s -> other when v = 1";
    assert_eq!(ends(calls("0 0 1", rejects)), None);
    let reorders = "sink bin rejects reorder a";
    assert_eq!(ends(calls("0 0 1", reorders)), Some((0, 3)));
    let together = |count: usize| vec!["7"; count].join(" ");
    assert_eq!(ends(calls(&together(49_999), "sink bin rejects")), None);
    assert_eq!(
        ends(calls(&together(50_000), "sink bin rejects")),
        Some((0, 3))
    );
}
