//! The meaning of each construct of the formats, on all valuations of a few variables.

use super::{read_text, shown, verdict};
use linewright::diagnostics::has_errors;
use linewright::gr1::eval::holds;
use linewright::gr1::{Domain, Specification};
use linewright::interchange::{Format, inquiries};
use std::time::Instant;

fn sound(format: Format, text: &str) -> Specification {
    let reading = read_text(format, text);
    assert!(
        !has_errors(&reading.findings),
        "{text}\n{}",
        shown(&reading, text)
    );
    reading.specification.expect("there is no error")
}

fn codes(format: Format, text: &str) -> Vec<&'static str> {
    read_text(format, text)
        .findings
        .iter()
        .map(|f| f.code.id)
        .collect()
}

/// Compares the only transition of a specification with a function of current and next values, on
/// all valuations.
fn everywhere(specification: &Specification, text: &str, wanted: &dyn Fn(&[i64], &[i64]) -> bool) {
    let domains: Vec<&Domain> = specification.variables.iter().map(|v| &v.domain).collect();
    let mut valuations: Vec<Vec<i64>> = vec![Vec::new()];
    for domain in &domains {
        valuations = valuations
            .iter()
            .flat_map(|v| {
                (domain.low()..=domain.high())
                    .map(|x| v.iter().copied().chain([x]).collect::<Vec<_>>())
            })
            .collect();
    }
    let [formula] = specification.guarantees.safety.as_slice() else {
        panic!("one transition in {text}");
    };
    for now in &valuations {
        for next in &valuations {
            assert_eq!(
                holds(&formula.expr, now, next),
                wanted(now, next),
                "{text}: {now:?} {next:?}"
            );
        }
    }
}

/// A formula over Booleans a, b, c and a number x of `0..5`.
fn spc(formula: &str, wanted: impl Fn(&[i64], &[i64]) -> bool) {
    let text = format!("ENV: a b;\nSYS: c x [0,5];\nSYSTRANS: []({formula});\n");
    everywhere(&sound(Format::Spc, &text), &text, &wanted);
}

/// A formula over Booleans a, b, c and numbers x of `0..5` and y of `2..4`.
fn structured(formula: &str, wanted: impl Fn(&[i64], &[i64]) -> bool) {
    let text = format!("[INPUT]\na\nb\n[OUTPUT]\nc\nx: 0...5\ny:2...4\n[SYS_TRANS]\n{formula}\n");
    everywhere(&sound(Format::StructuredSlugs, &text), &text, &wanted);
}

/// A formula over Booleans a, b, c.
fn slugsin(formula: &str, wanted: impl Fn(&[i64], &[i64]) -> bool) {
    let text = format!("[INPUT]\na\nb\n[OUTPUT]\nc\n[SYS_TRANS]\n{formula}\n");
    everywhere(&sound(Format::Slugsin, &text), &text, &wanted);
}

const A: usize = 0;
const B: usize = 1;
const C: usize = 2;
const X: usize = 3;
const Y: usize = 4;

fn is(values: &[i64], index: usize) -> bool {
    values[index] != 0
}

#[test]
fn gr1c_formulas() {
    spc("True", |_, _| true);
    spc("a & !False", |v, _| is(v, A));
    spc("a | b & c", |v, _| (is(v, A) || is(v, B)) && is(v, C));
    spc("a & b | c", |v, _| (is(v, A) && is(v, B)) || is(v, C));
    spc("a -> b -> c", |v, _| (is(v, A) && !is(v, B)) || is(v, C));
    spc("a -> b & c", |v, _| !is(v, A) || (is(v, B) && is(v, C)));
    spc("a <-> b -> c", |v, _| is(v, A) == (!is(v, B) || is(v, C)));
    spc("!a & b'", |v, n| !is(v, A) && is(n, B));
    spc("!x=3", |v, _| v[X] != 3);
    spc("x != 3 & x' < 4", |v, n| v[X] != 3 && n[X] < 4);
    spc("x' <= 2 | x > 4", |v, n| n[X] <= 2 || v[X] > 4);
    spc("x >= 2 -> x' = 9", |v, _| v[X] < 2);
    spc("a = 1 | b' = 0", |v, n| is(v, A) || !is(n, B));
    spc("((a)) # a comment\n & c", |v, _| is(v, A) && is(v, C));
}

#[test]
fn structured_formulas() {
    structured("a | b & c", |v, _| is(v, A) || (is(v, B) && is(v, C)));
    structured("a ^ b | c", |v, _| is(v, A) != (is(v, B) || is(v, C)));
    structured("a -> b ^ c", |v, _| !is(v, A) || (is(v, B) != is(v, C)));
    structured("a -> b -> c", |v, _| (is(v, A) && !is(v, B)) || is(v, C));
    structured("a <-> b -> c", |v, _| is(v, A) == (!is(v, B) || is(v, C)));
    structured("a && b || ~ c", |v, _| (is(v, A) && is(v, B)) || !is(v, C));
    structured("a /\\ b \\/ c", |v, _| (is(v, A) && is(v, B)) || is(v, C));
    structured("a --> b", |v, _| !is(v, A) || is(v, B));
    structured("a <--> TRUE", |v, _| is(v, A));
    structured("! [! (a | b)] & (c | FALSE)", |v, _| {
        (is(v, A) || is(v, B)) && is(v, C)
    });
    structured("X (a & c) | next b", |_, n| {
        (is(n, A) && is(n, C)) || is(n, B)
    });
    structured("() c & c", |v, n| is(n, C) && is(v, C));
    structured("X x = 3", |_, n| n[X] == 3);
    structured("! x = 3", |v, _| v[X] != 3);
    structured("x' = x + 1", |v, n| n[X] == v[X] + 1);
    structured("x + 3 >= y' + y", |v, n| v[X] + 3 >= n[Y] + v[Y]);
    structured("x - 1 - y < 1", |v, _| v[X] - 1 - v[Y] < 1);
    structured("(x + 1) * 2 != y'", |v, n| (v[X] + 1) * 2 != n[Y]);
    structured("x > y & y <= 3 | x < 1", |v, _| {
        (v[X] > v[Y] && v[Y] <= 3) || v[X] < 1
    });
    // 1 is one bit: it replaces the lowest bit of x.
    structured("1 LEASTSIGNIFICANTBITOVERWRITES x = x'", |v, n| {
        v[X] / 2 * 2 + 1 == n[X]
    });
    // In prefix notation.
    structured("| ! a' ! b'", |_, n| !is(n, A) || !is(n, B));
    structured("^ a c", |v, _| is(v, A) != is(v, C));
    structured("& x@0.0.5 x@2'", |v, n| v[X] % 2 == 1 && n[X] >= 4);
    // y is stored as its distance from 2.
    structured("| y@0.2.4 y@1", |v, _| v[Y] != 2);
}

#[test]
fn prefix_formulas() {
    slugsin("1", |_, _| true);
    slugsin("! & a b'", |v, n| !(is(v, A) && is(n, B)));
    slugsin("| ^ a b c", |v, _| (is(v, A) != is(v, B)) || is(v, C));
    slugsin("$ 1 a", |v, _| is(v, A));
    slugsin("$ 3 ^ a b ! ? 0 & ? 0 c", |v, _| {
        (is(v, A) != is(v, B)) && is(v, C)
    });
    slugsin("& $ 2 ! a | ? 0 b c", |v, _| {
        (!is(v, A) || is(v, B)) && is(v, C)
    });
    // An inner buffer hides the outer one, which is visible again after it.
    slugsin("$ 2 a & $ 2 b ! ? 0 ? 0", |v, _| !is(v, B) && is(v, A));
    slugsin("& a & b & c & a' & b' c'", |v, n| {
        v.iter().chain(n).all(|x| *x != 0)
    });
}

#[test]
fn variables_and_sections() {
    let specification = sound(
        Format::Spc,
        "SYSGOAL: []<>y=1 &\n[]<> x;ENV:;SYS: x y [0,2];\nENV: a.b;\nSYSTRANS:;ENVGOAL: []<>a.b | x';\nSYSINIT: x & (y=0 | y=2) & !(x & y=1);",
    );
    let names: Vec<(&str, u64)> = specification
        .variables
        .iter()
        .map(|v| (v.name.as_str(), v.domain.size()))
        .collect();
    assert_eq!(names, [("x", 2), ("y", 3), ("a.b", 2)]);
    let texts: Vec<(&str, &str)> = specification
        .guarantees
        .all()
        .map(|f| (f.name.as_str(), f.text.as_str()))
        .collect();
    assert_eq!(
        texts,
        [
            ("SYSINIT 1", "x"),
            ("SYSINIT 2", "(y=0 | y=2)"),
            ("SYSINIT 3", "!(x & y=1)"),
            ("SYSGOAL 1", "[]<>y=1"),
            ("SYSGOAL 2", "[]<> x"),
        ]
    );
    assert_eq!(specification.assumptions.justice.len(), 1);
    let specification = sound(
        Format::Slugsin,
        "# text\n[SYS_TRANS]\n\n! b\n  # more\n[INPUT]\n a \n[OUTPUT]\nb\n[SYS_TRANS]\n| b  b'\n[SYS_INIT]\n^ a b\n",
    );
    let texts: Vec<(&str, &str)> = specification
        .guarantees
        .all()
        .map(|f| (f.name.as_str(), f.text.as_str()))
        .collect();
    assert_eq!(
        texts,
        [
            ("SYS_INIT 1", "^ a b"),
            ("SYS_TRANS 1", "! b"),
            ("SYS_TRANS 2", "| b b'")
        ]
    );
    assert!(specification.guarantees.invariants.is_empty());
}

#[test]
fn initial_conditions() {
    // The machine answers the environment's first move.
    let answers = |init: &str| {
        let text = format!("[INPUT]\na\n[OUTPUT]\nb\n[SYS_INIT]\n{init}\n");
        verdict(&sound(Format::Slugsin, &text))
    };
    assert!(answers("^ a b"));
    assert!(!answers("& a b"));
    assert!(!answers("& b ! b"));
    // A transition does not restrict the last step before the environment is stuck; an initial
    // condition does.
    let stuck = |section: &str| {
        let text = format!("[INPUT]\na\n[OUTPUT]\nb\n[ENV_TRANS]\n0\n[{section}]\n0\n");
        verdict(&sound(Format::Slugsin, &text))
    };
    assert!(stuck("SYS_TRANS"));
    assert!(!stuck("SYS_INIT"));
}

#[test]
fn reachability_games() {
    let wins = |sections: &str| {
        let text = format!("ENV: x;\nSYS: y z [0,2];\n{sections}");
        verdict(&sound(Format::Spc, &text))
    };
    assert!(wins("SYSINIT: !y; SYSGOAL: <>y;"));
    assert!(!wins("SYSINIT: !y; SYSTRANS: [](!y -> !y'); SYSGOAL: <>y;"));
    // Reached at the start, and nothing is required afterward.
    assert!(wins("SYSINIT: y; SYSTRANS: [](False); SYSGOAL: <>y;"));
    assert!(!wins("SYSINIT: !y; SYSTRANS: [](False); SYSGOAL: <>y;"));
    // The transition into the goal must be kept, the one out of it need not.
    let steps = "SYSINIT: z = 0; SYSTRANS: [](z = 0 -> z' = 1) & [](z = 1 -> z' = 2) & [](z < 2);";
    assert!(wins(&format!("{steps} SYSGOAL: <>(z = 2);")));
    assert!(!wins(&format!("{steps} SYSGOAL: <>(z = 2 & x);")));
    // Blocked, or kept from its goal for ever.
    assert!(!wins("SYSGOAL: <>False;"));
    assert!(wins(
        "ENVTRANS: [](y -> x') & [](y -> !x'); SYSGOAL: <>False;"
    ));
    assert!(!wins(
        "ENVTRANS: [](y -> x') & [](y -> !x'); SYSTRANS: [](!y'); SYSINIT: !y; SYSGOAL: <>False;"
    ));
    assert!(wins(
        "ENVTRANS: [](y -> !x'); ENVGOAL: []<>x; SYSGOAL: <>False;"
    ));
    assert!(wins("ENVGOAL: []<>x; SYSGOAL: <>x;"));
    assert!(!wins("SYSGOAL: <>x;"));
    // Without the sign the goal is an ordinary one.
    assert!(wins("SYSGOAL:;"));
    assert!(wins("SYSGOAL: []<>y;"));
    let reading = read_text(Format::Spc, "SYS: y;\nSYSGOAL: <>y;");
    assert!(reading.reachability);
    let internal: Vec<bool> = reading
        .specification
        .iter()
        .flat_map(|s| s.variables.iter().map(|v| v.internal))
        .collect();
    assert_eq!(internal, [false, true]);
}

/// Notes about the file's own tool, given the result of solving.
fn notes(format: Format, text: &str) -> Vec<String> {
    let reading = read_text(format, text);
    let specification = reading.specification.as_ref().expect("it is read");
    let realizable = verdict(specification);
    let found = inquiries(&reading).into_iter().filter_map(|inquiry| {
        let answers: Vec<bool> = inquiry.questions.iter().map(verdict).collect();
        inquiry.note(realizable, &answers).map(|f| f.message)
    });
    let shown = reading.findings.iter().map(|f| f.message.clone());
    shown.chain(found).collect()
}

#[test]
fn own_tools() {
    let said = |format, text: &str, start: &str| {
        let notes = notes(format, text);
        match start {
            "" => assert!(notes.is_empty(), "{text}\n{notes:?}"),
            _ => assert!(
                notes.len() == 1 && notes[0].starts_with(start),
                "{text}\n{notes:?}"
            ),
        }
    };
    said(
        Format::Spc,
        "SYS: y;\nSYSINIT: y & !y;",
        "gr1c answers \"realizable\": SYSINIT contradicts itself",
    );
    said(Format::Spc, "SYS: y;\nSYSINIT: y;", "");
    // It is unrealizable, but not for that.
    said(Format::Spc, "SYS: y;\nSYSINIT: y;\nSYSGOAL: []<>False;", "");
    said(
        Format::Spc,
        "ENV: x; SYS: y;\nSYSINIT: y = 1 & x;",
        "gr1c refuses a SYSINIT",
    );
    said(
        Format::Spc,
        "SYS: y;\nSYSGOAL: []<>y';",
        "gr1c refuses primed variables in goals",
    );
    said(
        Format::Spc,
        "ENV: x;\nENVINIT: x & !x;",
        "gr1c answers \"realizable\" too",
    );
    said(
        Format::Slugsin,
        "[INPUT]\nx\n[ENV_INIT]\n& x ! x",
        "slugs answers \"realizable\" too",
    );
    said(Format::Slugsin, "[INPUT]\nx\n[ENV_INIT]\nx", "");
    said(
        Format::Slugsin,
        "[OUTPUT]\ny\n[SYS_INIT]\n& y ! y\n[SYS_LIVENESS]\ny'",
        "",
    );
    said(
        Format::StructuredSlugs,
        "[OUTPUT]\ny:0...3\n[SYS_INIT]\ny - 1 = 2",
        "slugs' translator refuses `-`",
    );
    let frozen = "SYSTRANS: [](y <-> y'); SYSGOAL: <>y;";
    said(
        Format::Spc,
        &format!("SYS: y; {frozen}"),
        "rg answers \"unrealizable\"",
    );
    said(Format::Spc, &format!("SYS: y; SYSINIT: y; {frozen}"), "");
    said(Format::Spc, &format!("SYS: y; SYSINIT: !y; {frozen}"), "");
    said(
        Format::Spc,
        "ENV: x; SYS: y; ENVINIT: x & !x; SYSGOAL: <>y;",
        "rg answers \"unrealizable\"",
    );
    said(
        Format::Spc,
        "ENV: x; SYS: y; SYSINIT: y & !y; SYSGOAL: <>y;",
        "",
    );
}

#[test]
fn huge_and_deep_texts_take_linear_time() {
    let n = 100_000;
    let slugs = |formula: &str| format!("[INPUT]\na\n[OUTPUT]\nb\n[SYS_TRANS]\n{formula}\n");
    let spc = |formula: &str| format!("ENV: a;\nSYS: b;\nSYSTRANS: []({formula});\n");
    let doubling = (0..n / 10).fold(String::new(), |text, i| {
        text + &format!(" ^ ? {i} & a ? {i}")
    });
    let texts = [
        (
            Format::Slugsin,
            slugs(&format!("{}a", "! ".repeat(n))),
            true,
        ),
        (
            Format::Slugsin,
            slugs(&format!("{}a{}", "& ".repeat(n), " b".repeat(n))),
            true,
        ),
        (
            Format::Slugsin,
            slugs(&format!("{}a", "& b ".repeat(n))),
            true,
        ),
        (
            Format::Slugsin,
            slugs(&format!("{}a", "& b | a ".repeat(n))),
            false,
        ),
        (
            Format::Slugsin,
            slugs(&format!("{}a", "$ 1 ".repeat(n))),
            true,
        ),
        (
            Format::Slugsin,
            slugs(&format!("$ {} b{doubling}", n / 10 + 1)),
            false,
        ),
        (Format::Slugsin, slugs(&"& ".repeat(n)), false),
        (
            Format::Spc,
            spc(&format!("{}a{}", "(".repeat(n), ")".repeat(n))),
            true,
        ),
        (Format::Spc, spc(&format!("{}a", "!".repeat(n))), true),
        (Format::Spc, spc(&"(".repeat(n)), false),
        (Format::Spc, spc(&format!("a{}", " & b".repeat(n))), true),
        (Format::Spc, spc(&format!("a{}", " -> b".repeat(n))), false),
        (
            Format::Spc,
            spc(&format!("{}a{}", "a -> (".repeat(n), ")".repeat(n))),
            false,
        ),
        (
            Format::Spc,
            format!("ENV: a;\nSYSTRANS: [](a){};", " & [](a)".repeat(n / 10)),
            true,
        ),
        (
            Format::Spc,
            format!("ENV: a; {}", "ENVINIT ".repeat(n)),
            false,
        ),
        (
            Format::StructuredSlugs,
            slugs(&format!("{}a{}", "([".repeat(n), "])".repeat(n))),
            true,
        ),
        (
            Format::StructuredSlugs,
            slugs(&format!("{}a", "X ".repeat(n))),
            false,
        ),
        (
            Format::StructuredSlugs,
            slugs(&format!("a{}", " & X a".repeat(n))),
            true,
        ),
        (
            Format::StructuredSlugs,
            slugs(&format!("1{} = 2", " + 1".repeat(n))),
            true,
        ),
        (
            Format::StructuredSlugs,
            slugs(&format!("2{} = 2", " * 2".repeat(n))),
            false,
        ),
    ];
    for (format, text, readable) in texts {
        let start = Instant::now();
        let reading = read_text(format, &text);
        let spent = start.elapsed().as_secs_f64();
        let head: String = text.chars().take(80).collect();
        assert_eq!(
            reading.specification.is_some(),
            readable,
            "{head}: {:?}",
            reading.findings.first().map(|f| &f.message)
        );
        assert!(
            reading.findings.len() < 10,
            "{head}: {} findings",
            reading.findings.len()
        );
        assert!(spent < 5.0, "{head}: {spent} s");
    }
}

#[test]
fn what_another_game_asks_for_is_refused() {
    assert_eq!(
        codes(
            Format::StructuredSlugs,
            "[UNOBSERVABLE_INPUT]\na\n[OUTPUT]\nb\n"
        ),
        ["LW201"]
    );
    assert_eq!(
        codes(
            Format::Slugsin,
            "[INPUT]\na\n[OUTPUT]\nb\n[ENV_TRANS]\n| b' a'\n"
        ),
        ["LW209"]
    );
    assert_eq!(
        codes(
            Format::Slugsin,
            "[INPUT]\na\n[OUTPUT]\nb\n[ENV_LIVENESS]\n| b' a'\n"
        ),
        [""; 0]
    );
    assert_eq!(
        codes(Format::Slugsin, "[INPUT]\na\n[OUTPUT]\nb\n[ENV_INIT]\nb\n"),
        ["LW202"]
    );
    assert_eq!(codes(Format::Spc, ""), ["LW002"]);
    for operand in ["x", "y < 1", "!x", "y' >= 1"] {
        let text = format!("ENV: a c;\nSYS: x y [0,3];\nSYSTRANS: [](a | {operand} & c);\n");
        assert_eq!(codes(Format::Spc, &text), ["LW005"], "{operand}");
    }
    // What an export that failed leaves is no specification.
    assert_eq!(codes(Format::Slugsin, ""), ["LW002"]);
    assert_eq!(codes(Format::StructuredSlugs, "# nothing\n"), ["LW002"]);
    assert_eq!(
        codes(Format::Slugsin, "\u{feff}[INPUT]\r\na\r\n[OUTPUT]\r\nb\r\n"),
        [""; 0]
    );
    assert_eq!(
        codes(
            Format::Slugsin,
            "[INPUT]\ra\r[OUTPUT]\rg\r[SYS_TRANS]\r| ! a g\r"
        ),
        [""; 0]
    );
    assert_eq!(
        codes(Format::Spc, "\u{feff}ENV: a;\r\nSYS: b;\r\n"),
        [""; 0]
    );
}

/// Bit k of a number is a bit of its distance from the smallest value; the number of bits is that
/// of the largest distance: `x: 4...7` has two, though 7 has three.
#[test]
fn bits_of_numbers_count_from_the_smallest_value() {
    for low in -5..=6_i64 {
        for width in 0..=9_i64 {
            let high = low + width;
            let file = |bit: &str| {
                format!(
                    "[OUTPUT]\nx: {low}...{high}\n[SYS_TRANS]\n& {bit} 1\n[SYS_LIVENESS]\n{bit}'\n"
                )
            };
            for k in 0..=4 {
                let bit = match k {
                    0 => format!("x@0.{low}.{high}"),
                    k => format!("x@{k}"),
                };
                let text = file(&bit);
                if width >> k == 0 {
                    let found = codes(Format::StructuredSlugs, &text);
                    assert_eq!(found, ["LW101", "LW101"], "{text}");
                    continue;
                }
                let specification = sound(Format::StructuredSlugs, &text);
                everywhere(&specification, &text, &|v, _| (v[0] - low) >> k & 1 == 1);
                let [goal] = specification.guarantees.justice.as_slice() else {
                    panic!("one goal in {text}");
                };
                for next in low..=high {
                    let wanted = (next - low) >> k & 1 == 1;
                    assert_eq!(holds(&goal.expr, &[low], &[next]), wanted, "{text}: {next}");
                }
            }
            // The lowest bit is named with the bounds, and with no others.
            for bit in [
                format!("x@0.{}.{high}", low + 1),
                format!("x@0.{low}.{}", high + 1),
                "x@0".to_owned(),
                format!("x@1.{low}.{high}"),
                "x@-1".to_owned(),
            ] {
                let found = codes(Format::StructuredSlugs, &file(&bit));
                assert!(!found.is_empty(), "{bit} of {low}...{high}");
            }
        }
    }
}
