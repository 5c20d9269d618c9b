//! Past operators, counters, monitors, triggers and regular expressions compared with their
//! meaning, computed on a long part of the run.

use super::lassos::{Lasso, agrees, agrees_assumed};
use linewright::interchange::{Format, read};
use linewright::source::FileId;
use rayon::prelude::*;

/// Number of steps to examine: enough for all memory here to repeat.
pub fn horizon(lasso: &Lasso) -> usize {
    lasso.letters.len() + 12 * lasso.period()
}

/// Operators over the past, by their definitions.
#[derive(Debug, Clone)]
enum Past {
    Input(usize),
    Not(Box<Past>),
    And(Box<Past>, Box<Past>),
    Previous(Box<Past>),
    Once(Box<Past>),
    Historically(Box<Past>),
    Since(Box<Past>, Box<Past>),
    Triggered(Box<Past>, Box<Past>),
    /// `PREV` of an input that has changed.
    Changed(usize),
}

fn past(formula: &Past, lasso: &Lasso, t: usize) -> bool {
    let at = |f: &Past, t| past(f, lasso, t);
    match formula {
        Past::Input(v) => lasso.at(t)[*v] == 1,
        Past::Not(a) => !at(a, t),
        Past::And(a, b) => at(a, t) && at(b, t),
        Past::Previous(a) => t > 0 && at(a, t - 1),
        Past::Once(a) => (0..=t).any(|k| at(a, k)),
        Past::Historically(a) => (0..=t).all(|k| at(a, k)),
        Past::Since(a, b) => (0..=t).any(|k| at(b, k) && (k + 1..=t).all(|j| at(a, j))),
        Past::Triggered(a, b) => (0..=t).all(|k| at(b, k) || (k + 1..=t).any(|j| at(a, j))),
        Past::Changed(v) => t > 0 && lasso.at(t)[*v] == 1 && lasso.at(t - 1)[*v] == 0,
    }
}

#[test]
fn past_operators() {
    let input = |v| Box::new(Past::Input(v));
    let (p, q) = (|| input(0), || input(1));
    let cases = [
        ("PREV p", Past::Previous(p())),
        ("Y Y p", Past::Previous(Box::new(Past::Previous(p())))),
        ("ONCE p", Past::Once(p())),
        ("O PREV p", Past::Once(Box::new(Past::Previous(p())))),
        ("HISTORICALLY p", Past::Historically(p())),
        (
            "PREV (H p)",
            Past::Previous(Box::new(Past::Historically(p()))),
        ),
        ("p SINCE q", Past::Since(p(), q())),
        (
            "p S q S p",
            Past::Since(Box::new(Past::Since(p(), q())), p()),
        ),
        ("p TRIGGERED q", Past::Triggered(p(), q())),
        (
            "PREV p T q",
            Past::Triggered(Box::new(Past::Previous(p())), q()),
        ),
        (
            "ONCE (p & PREV q) & !PREV p",
            Past::And(
                Box::new(Past::Once(Box::new(Past::And(
                    p(),
                    Box::new(Past::Previous(q())),
                )))),
                Box::new(Past::Not(Box::new(Past::Previous(p())))),
            ),
        ),
        ("PREV (!p & next(p))", Past::Changed(0)),
    ];
    cases.par_iter().for_each(|(text, meaning)| {
        let head = "spec t\nenv boolean p;\nenv boolean q;\n";
        for negated in [false, true] {
            let sign = if negated { "!" } else { "" };
            let holds = |lasso: &Lasso, t| past(meaning, lasso, t) != negated;
            agrees(
                &format!("{head}gar alw {sign}({text});"),
                &[2, 2],
                |lasso| (0..horizon(lasso)).all(|t| holds(lasso, t)),
            );
            agrees_assumed(
                &format!("{head}asm alw {sign}({text});"),
                &[2, 2],
                |lasso| (0..horizon(lasso)).all(|t| holds(lasso, t)),
            );
            let repeated = |lasso: &Lasso| {
                let end = horizon(lasso);
                (end - lasso.period()..end).any(|t| holds(lasso, t))
            };
            agrees(&format!("{head}gar GF {sign}({text});"), &[2, 2], repeated);
            agrees_assumed(&format!("{head}asm GF {sign}({text});"), &[2, 2], repeated);
        }
        agrees(&format!("{head}gar ini {text} | p;"), &[2, 2], |lasso| {
            past(meaning, lasso, 0) || lasso.at(0)[0] == 1
        });
        if !text.contains("next") {
            // Its next value, given its current one.
            agrees(
                &format!("{head}gar G next({text}) | q;"),
                &[2, 2],
                |lasso| {
                    (0..horizon(lasso)).all(|t| past(meaning, lasso, t + 1) || lasso.at(t)[1] == 1)
                },
            );
        }
    });
}

/// The counter's value after this many steps; `None` where it could not continue.
fn counted(lasso: &Lasso, steps: usize, over: &str, under: &str, reset: bool) -> Option<i64> {
    let mut value = 1;
    for t in 0..steps {
        let (up, down) = (lasso.at(t)[0] == 1, lasso.at(t)[1] == 1);
        let back = reset && lasso.at(t)[2] == 1;
        let mut wanted = Vec::new();
        let turned = |mode: &str, end: i64, other: i64| match mode {
            "keep" => Some(end),
            "modulo" => Some(other),
            _ => None,
        };
        if up {
            wanted.push(if value == 2 {
                turned(over, 2, 0)
            } else {
                Some(value + 1)
            });
        }
        if down {
            wanted.push(if value == 0 {
                turned(under, 0, 2)
            } else {
                Some(value - 1)
            });
        }
        if back {
            wanted.push(Some(0));
        }
        let first = wanted.first().copied().unwrap_or(Some(value));
        if wanted.iter().any(|w| *w != first) {
            return None;
        }
        value = first?;
    }
    Some(value)
}

#[test]
fn counters() {
    let modes = ["keep", "modulo", "false"];
    let cases: Vec<(&str, &str, bool)> = modes
        .iter()
        .flat_map(|o| {
            modes
                .iter()
                .flat_map(move |u| [(*o, *u, false), (*o, *u, true)])
        })
        .collect();
    cases.par_iter().for_each(|(over, under, reset)| {
        let line = if *reset { "reset: r;" } else { "" };
        let text = format!(
            "spec t\nenv boolean p;\nenv boolean q;\nenv boolean r;\n\
             counter c(0..2) {{ c = 1; inc: p; dec: q; {line} overflow: {over}; underflow: {under}; }}\n\
             gar GF c = 2;\n"
        );
        agrees(&text, &[2, 2, 2], |lasso| {
            let end = horizon(lasso) + 6 * lasso.period();
            counted(lasso, end, over, under, *reset).is_some()
                && (end - 6 * lasso.period()..end)
                    .any(|t| counted(lasso, t, over, under, *reset) == Some(2))
        });
    });
}

#[test]
fn a_counter_without_modes_must_not_leave_its_range() {
    let text = "spec t\nenv boolean p;\nenv boolean q;\nenv boolean r;\ncounter c(0..2) { c = 1; inc: p; dec: q; }\ngar alw c != 0;\n";
    agrees(text, &[2, 2, 2], |lasso| {
        (0..=horizon(lasso)).all(|t| counted(lasso, t, "", "", false).is_some_and(|c| c != 0))
    });
}

#[test]
fn monitors() {
    // A switch toggled by each p.
    let text = "spec t\nenv boolean p;\nmonitor boolean on { !on; G next(on) <-> (on xor p); }\ngar GF on;\ngar GF !on;\n";
    agrees(text, &[2], |lasso| {
        (lasso.back..lasso.letters.len()).any(|t| lasso.at(t)[0] == 1)
    });
    // The value one step ago, as in the monitor's own clause for step 0.
    let text = "spec t\nenv Int(0..2) x;\nmonitor Int(0..2) last { last = x; trans next(last) = x; }\ngar alw x >= last;\n";
    agrees(text, &[3], |lasso| {
        (0..horizon(lasso)).all(|t| t == 0 || lasso.at(t)[0] >= lasso.at(t - 1)[0])
    });
    let text = "spec t\nenv boolean p;\nmonitor boolean copy { alw copy <-> !p; }\ngar GF copy;\n";
    agrees(text, &[2], |lasso| {
        (lasso.back..lasso.letters.len()).any(|t| lasso.at(t)[0] == 0)
    });
}

/// Regular expressions by the sets of steps at which their matches end.
#[derive(Debug, Clone)]
enum Re {
    Empty,
    Any,
    Never,
    Step(usize, i64),
    Then(Box<Re>, Box<Re>),
    Or(Box<Re>, Box<Re>),
    And(Box<Re>, Box<Re>),
    Not(Box<Re>),
    Repeat(Box<Re>, usize, Option<usize>),
}

/// For each step, the steps at which a match that begins there ends, as a set of bits.
fn ends(re: &Re, lasso: &Lasso, limit: usize) -> Vec<u64> {
    let at = |from: usize, holds: bool| if holds && from < limit { 2 << from } else { 0 };
    let of = |a: &Re| ends(a, lasso, limit);
    let then = |a: &[u64], b: &[u64]| -> Vec<u64> {
        let from = |from: usize| {
            let (mut open, mut found) = (a[from], 0);
            while open != 0 {
                found |= b[open.trailing_zeros() as usize];
                open &= open - 1;
            }
            found
        };
        (0..=limit).map(from).collect()
    };
    let pairs = |a: &Re, b: &Re, op: &dyn Fn(u64, u64) -> u64| -> Vec<u64> {
        of(a).iter().zip(&of(b)).map(|(a, b)| op(*a, *b)).collect()
    };
    let empty: Vec<u64> = (0..=limit).map(|from| 1 << from).collect();
    match re {
        Re::Empty => empty,
        Re::Never => vec![0; limit + 1],
        Re::Any => (0..=limit).map(|t| at(t, true)).collect(),
        Re::Step(v, value) => (0..=limit)
            .map(|t| at(t, lasso.at(t)[*v] == *value))
            .collect(),
        Re::Then(a, b) => then(&of(a), &of(b)),
        Re::Or(a, b) => pairs(a, b, &|a, b| a | b),
        Re::And(a, b) => pairs(a, b, &|a, b| a & b),
        Re::Not(a) => {
            let later = |from: usize| (u64::MAX >> (63 - limit)) & (u64::MAX << from);
            let others = of(a);
            (0..=limit).map(|t| later(t) & !others[t]).collect()
        }
        Re::Repeat(a, low, high) => {
            let once = of(a);
            let mut now = empty;
            for _ in 0..*low {
                now = then(&now, &once);
            }
            let mut all = now.clone();
            // Matches longer than the run are not needed.
            for _ in *low..high.unwrap_or(low + limit) {
                now = then(&now, &once);
                let before = all.clone();
                for (all, now) in all.iter_mut().zip(&now) {
                    *all |= now;
                }
                if high.is_none() && before == all {
                    break;
                }
            }
            all
        }
    }
}

/// Whether a trigger is kept: matches are searched one after the other.
fn triggered(from: &Re, to: &Re, lasso: &Lasso) -> bool {
    let limit = (lasso.letters.len() + 9 * lasso.period()).min(62);
    // An effect that begins here has enough time to occur.
    let last = lasso.letters.len() + 4 * lasso.period();
    let (causes, effects) = (ends(from, lasso, limit), ends(to, lasso, limit));
    if effects[0] & 1 == 1 {
        return true;
    }
    let mut at = 0;
    while at <= last {
        let cause = causes[at].trailing_zeros() as usize;
        if cause > last {
            return true;
        }
        if effects[cause] == 0 {
            return false;
        }
        at = effects[cause].trailing_zeros() as usize;
    }
    true
}

#[test]
fn triggers_and_regular_expressions() {
    let step = |v| Box::new(Re::Step(v, 1));
    let (p, q) = (|| step(0), || step(1));
    let any = || Box::new(Re::Repeat(Box::new(Re::Any), 0, None));
    let many = |r: Box<Re>, low, high| Box::new(Re::Repeat(r, low, high));
    let then = |a, b| Box::new(Re::Then(a, b));
    let or = |a, b| Box::new(Re::Or(a, b));
    let and = |a, b| Box::new(Re::And(a, b));
    let not = |a| Box::new(Re::Not(a));
    let expressions = [
        ("[p]", p()),
        ("[p] [q]", then(p(), q())),
        ("[p] | [q] [p]", then(or(p(), q()), p())),
        ("[p] | ([q] [p])", or(p(), then(q(), p()))),
        (
            "([p] true) & (true [q])",
            and(then(p(), Box::new(Re::Any)), then(Box::new(Re::Any), q())),
        ),
        ("[p]* [q]", then(many(p(), 0, None), q())),
        (
            "[p]+ [!p]",
            then(many(p(), 1, None), Box::new(Re::Step(0, 0))),
        ),
        ("[p]? [q]", then(many(p(), 0, Some(1)), q())),
        ("[p]{2}", many(p(), 2, Some(2))),
        (
            "true{2,} & ([p] true*)",
            and(many(Box::new(Re::Any), 2, None), then(p(), any())),
        ),
        ("[p]{1,3} [q]", then(many(p(), 1, Some(3)), q())),
        (
            "~([p] true*) & true+",
            and(not(then(p(), any())), many(Box::new(Re::Any), 1, None)),
        ),
        ("(~[p])[q]", then(not(p()), q())),
        ("~~[p] ~~~[q]", then(p(), not(q()))),
        ("true* [p & q]", then(any(), and(p(), q()))),
        ("both", then(any(), then(p(), q()))),
        ("false | [q]", or(Box::new(Re::Never), q())),
        ("() | [p] [p]", then(or(Box::new(Re::Empty), p()), p())),
        (
            "([p] [q])* [q] [q]",
            then(then(many(then(p(), q()), 0, None), q()), q()),
        ),
    ];
    let head = "spec t\nenv boolean p;\nenv boolean q;\nregexp both := true* [p] [q];\n";
    let cause = [
        ("true* [p]", then(any(), p())),
        ("[q] [p]*", then(q(), many(p(), 0, None))),
    ];
    expressions.par_iter().for_each(|(text, re)| {
        for (from, from_re) in &cause {
            agrees(
                &format!("{head}gar trig {from} |=> {text};"),
                &[2, 2],
                |lasso| triggered(from_re, re, lasso),
            );
            agrees(
                &format!("{head}gar trig {text} |=> {from};"),
                &[2, 2],
                |lasso| triggered(re, from_re, lasso),
            );
            agrees_assumed(
                &format!("{head}asm trig {from} |=> {text};"),
                &[2, 2],
                |lasso| triggered(from_re, re, lasso),
            );
        }
        agrees(&format!("{head}gar G regexp({text});"), &[2, 2], |lasso| {
            triggered(&any(), re, lasso)
        });
        let repeated = then(any(), re.clone());
        agrees(&format!("{head}gar GF regexp({text});"), &[2, 2], |lasso| {
            triggered(&any(), &repeated, lasso)
        });
    });
}

#[test]
fn conditionals() {
    let text = "spec t\nenv boolean p;\nenv boolean q;\ngar alw ite(p, q, !q);\n";
    agrees(text, &[2, 2], |lasso| {
        (0..horizon(lasso)).all(|t| (lasso.at(t)[0] == 1) == (lasso.at(t)[1] == 1))
    });
    let text =
        "spec t\nenv boolean p;\nenv Int(0..3) x;\ngar alw x = ite(p, 1, ite(x > 1, 2, 3));\n";
    agrees(text, &[2, 4], |lasso| {
        (0..horizon(lasso)).all(|t| match lasso.at(t) {
            [1, x] => *x == 1,
            [_, x] => *x == 2,
            _ => unreachable!("two inputs"),
        })
    });
}

/// Formulas that leave everything else free define values; the others restrict the system.
#[test]
fn definitions_are_distinguished_from_demands() {
    let defining = [
        "monitor boolean on { !on; G next(on) <-> (on xor p); }",
        "monitor boolean on { G on <-> p; }",
        "monitor Int(0..2) last { last = x; trans next(last) = x; }",
        "counter c(0..3) { c = 0; inc: p; overflow: modulo; }",
        "counter c(0..3) { inc: p; overflow: keep; }",
        "gar GF regexp(true* [p] [!p]);",
        "asm trig [p]* |=> true* [!p];",
        "pattern often(q) { var boolean s; ini !s; G next(s) <-> q; GF s; }\nasm often(p);",
    ];
    let demanding = [
        "monitor boolean on { !on; G next(on) <-> on; G on <-> p; }",
        "monitor Int(0..2) last { last = 0; trans next(last) = x + 1; }",
        "counter c(0..3) { c = 0; inc: p; }",
        "counter c(0..3) { c = 0; inc: p; reset: x = 1; overflow: modulo; }",
        "pattern never(q) { var boolean s; ini !s; G next(s) <-> q; G !s; }\ngar never(p);",
    ];
    for (cases, wanted) in [(&defining[..], true), (&demanding[..], false)] {
        for case in cases {
            let text =
                format!("spec t\nenv boolean p;\nenv Int(0..2) x;\nsys boolean y;\n{case}\n");
            let reading = read(Format::Spectra, "test", FileId(0), &text);
            let specification = reading.specification.expect(case);
            let side = &specification.guarantees;
            let lists = [&side.initial, &side.invariants, &side.safety];
            let mut formulas = lists.into_iter().flatten();
            assert_eq!(formulas.all(|f| f.defines), wanted, "{case}");
        }
    }
}
