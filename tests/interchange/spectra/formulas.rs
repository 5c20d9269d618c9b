//! Arrays, definitions, quantifiers, numbers, enumerations and initial conditions compared with
//! their meaning.

use super::constructs::horizon;
use super::lassos::{Lasso, agrees, agrees_assumed, game, lassos};

#[test]
fn arrays_defines_predicates_and_quantifiers() {
    let head = "spec t\nenv Int(0..2) i;\nenv boolean[3] a;\n";
    let at = |lasso: &Lasso, t: usize, k: i64| lasso.at(t)[1 + k as usize] == 1;
    let sizes = [3, 2, 2, 2];
    let always = |lasso: &Lasso, holds: &dyn Fn(usize) -> bool| (0..horizon(lasso)).all(holds);
    agrees(&format!("{head}gar alw a[i];"), &sizes, |l| {
        always(l, &|t| at(l, t, l.at(t)[0]))
    });
    agrees(
        &format!("{head}gar G next(a[(i + 1) mod 3]);"),
        &sizes,
        |l| always(l, &|t| at(l, t + 1, (l.at(t + 1)[0] + 1) % 3)),
    );
    let text = format!(
        "{head}define d[2][2] := {{{{a[0], a[1]}}, {{a[2], true}}}};\n n := 2;\ngar alw i < n -> d[i][i] | a.all;"
    );
    agrees(&text.replace("d[i][i]", "d[1][0]"), &sizes, |l| {
        always(l, &|t| {
            l.at(t)[0] >= 2 || at(l, t, 2) || (0..3).all(|k| at(l, t, k))
        })
    });
    let text = format!(
        "{head}predicate free(Int(0..2) k, boolean[3] b): !b[k];\ngar alw exists k in Int(0..2) . (k != i & free(k, a));"
    );
    agrees(&text, &sizes, |l| {
        always(l, &|t| (0..3).any(|k| k != l.at(t)[0] && !at(l, t, k)))
    });
    let text =
        format!("{head}gar each{{Int(0..2) k}}: alw i = k -> (a[k] xor a.any | (i in {{1-2}}));");
    agrees(&text, &sizes, |l| {
        always(l, &|t| {
            let i = l.at(t)[0];
            let xor = at(l, t, i) != (0..3).any(|k| at(l, t, k));
            xor || (1..=2).contains(&i)
        })
    });
}

#[test]
fn numbers_and_enumerations() {
    let head =
        "spec t\ntype C = {red, green, blue};\nenv C c;\nenv {blue, red} d;\nenv Int((-1)..1) x;\n";
    let sizes = [3, 2, 3];
    let always = |lasso: &Lasso, holds: &dyn Fn(&[i64]) -> bool| {
        (0..horizon(lasso)).all(|t| holds(lasso.at(t)))
    };
    // Letters count from 0.
    let shifted = |text: &str, holds: &(dyn Fn(i64, i64, i64) -> bool + Sync)| {
        let text = format!("{head}gar alw {text};").replace("Int((-1)..1)", "Int(0..2)");
        agrees(&text, &sizes, |l| always(l, &|v| holds(v[0], v[1], v[2])));
    };
    shifted("c = green | c != d", &|c, d, _| {
        c == 1 || !((c == 0 && d == 1) || (c == 2 && d == 0))
    });
    shifted("c in {red, blue}", &|c, _, _| c != 1);
    shifted(
        "(c not in {red, blue}) -> x * x + 1 <= 5 - x / 2",
        &|c, _, x| c != 1 || x * x < 5 - x / 2,
    );
    shifted("(x + 3) mod 2 = 1 <-> x != 1", &|_, _, x| {
        ((x + 3) % 2 == 1) == (x != 1)
    });
    shifted(
        "!(x > 1) & -x <= 0 iff x < 2 implies c = red",
        &|c, _, x| (x <= 1 && -x <= 0) != (x < 2) || c == 0,
    );
}

#[test]
fn functions_of_arrays() {
    let head = "spec t\nenv Int(0..2)[3] a;\nenv boolean[2] b;\n";
    let always = |lasso: &Lasso, holds: &dyn Fn(&[i64], &[i64]) -> bool| {
        (0..horizon(lasso)).all(|t| {
            let (a, b) = lasso.at(t).split_at(3);
            holds(a, b)
        })
    };
    let check = |text: &str, holds: &dyn Fn(&[i64], &[i64]) -> bool| {
        agrees(&format!("{head}gar alw {text};"), &[3, 3, 3, 2, 2], |l| {
            always(l, holds)
        });
    };
    check("a.sum <= 4", &|a, _| a.iter().sum::<i64>() <= 4);
    check("a.prod in {0, 1, 4-8}", &|a, _| {
        let product: i64 = a.iter().product();
        product <= 1 || product >= 4
    });
    check("a.max - a.min < 2", &|a, _| {
        a.iter().max().expect("three") - a.iter().min().expect("three") < 2
    });
    check("b.any & !b.all", &|_, b| b[0] != b[1]);
}

#[test]
fn arrays_of_arrays_by_variables() {
    let head = "spec t\nenv Int(0..1) i;\nenv Int(0..1) j;\nenv boolean[2][2] m;\ndefine d[2][2] := {{m[1][1], !m[0][1]}, {i = j, true}};\n";
    let sizes = [2, 2, 2, 2, 2, 2];
    let cell = |l: &Lasso, t: usize, i: i64, j: i64| l.at(t)[2 + (2 * i + j) as usize] == 1;
    let defined = |l: &Lasso, t: usize, i: i64, j: i64| match (i, j) {
        (0, 0) => cell(l, t, 1, 1),
        (0, _) => !cell(l, t, 0, 1),
        (_, 0) => l.at(t)[0] == l.at(t)[1],
        _ => true,
    };
    let at = |l: &Lasso, t: usize| (l.at(t)[0], l.at(t)[1]);
    agrees(&format!("{head}gar alw m[i][j];"), &sizes, |l| {
        (0..horizon(l)).all(|t| cell(l, t, at(l, t).0, at(l, t).1))
    });
    agrees(&format!("{head}gar alw d[j][i];"), &sizes, |l| {
        (0..horizon(l)).all(|t| defined(l, t, at(l, t).1, at(l, t).0))
    });
    // The next index into the array of this step.
    agrees(
        &format!("{head}gar G m[next(i)][1 - j] | next(d[i][0]);"),
        &sizes,
        |l| {
            (0..horizon(l)).all(|t| {
                cell(l, t, at(l, t + 1).0, 1 - at(l, t).1) || defined(l, t + 1, at(l, t + 1).0, 0)
            })
        },
    );
    agrees_assumed(
        &format!("{head}asm G next(m[i][j]) -> d[i][j];"),
        &sizes,
        |l| {
            (0..horizon(l)).all(|t| {
                let (after, now) = (at(l, t + 1), at(l, t));
                !cell(l, t + 1, after.0, after.1) || defined(l, t, now.0, now.1)
            })
        },
    );
}

#[test]
fn quantifiers_over_patterns_and_regular_expressions_and_several_parameters() {
    let head = "import \"DwyerPatterns.spectra\"\nspec t\ntype C = {red, green};\nenv boolean[2] a;\nenv C c;\n";
    let sizes = [2, 2, 2];
    let cycle = |l: &Lasso| l.back..l.letters.len();
    agrees(
        &format!("{head}gar forall i in Int(0..1) . pRespondsToS(a[i], c = red);"),
        &sizes,
        |l| {
            let answers = |t: usize| l.at(t)[2] == 0;
            let asks = |t: usize| l.at(t)[0] == 1 || l.at(t)[1] == 1;
            (0..l.letters.len()).all(|t| !asks(t) || (t..horizon(l)).any(answers))
        },
    );
    agrees(
        &format!("{head}gar GF forall i in Int(0..1) . forall k in C . regexp([a[i] & c = k]);"),
        &sizes,
        |l| {
            let seen = |i: usize, k: i64| cycle(l).any(|t| l.at(t)[i] == 1 && l.at(t)[2] == k);
            (0..2).all(|i| (0..2).all(|k| seen(i, k)))
        },
    );
    agrees(
        &format!("{head}gar both{{Int(0..1) i, C k}}: GF a[i] & c = k;"),
        &sizes,
        |l| {
            let seen = |i: usize, k: i64| cycle(l).any(|t| l.at(t)[i] == 1 && l.at(t)[2] == k);
            (0..2).all(|i| (0..2).all(|k| seen(i, k)))
        },
    );
    agrees(
        &format!("{head}gar alw exists k in C . forall i in Int(0..1) . (a[i] & c = k);"),
        &sizes,
        |l| (0..horizon(l)).all(|t| l.at(t)[0] == 1 && l.at(t)[1] == 1),
    );
}

#[test]
fn values_of_enumerations_are_compared_by_their_places() {
    let text = "spec t\ntype C = {red, green, blue};\nenv C c;\nenv C d;\ngar alw c <= d;\ngar G next(c) > d | !(c < d);\n";
    agrees_noted(text, &[3, 3], |l| {
        (0..horizon(l)).all(|t| {
            let (now, after) = (l.at(t), l.at(t + 1));
            now[0] <= now[1] && (after[0] > now[1] || now[0] >= now[1])
        })
    });
}

#[test]
fn predicates_may_be_called_as_quantifiers_are() {
    let text = "spec t\nenv boolean[2] a;\npredicate exists(Int(0..1) i): a[i];\npredicate forall(boolean p): p & exists(1);\n\
        gar alw (exists(0) -> forall (a[1])) & (exists i in Int(0..1) . exists(i));\n";
    agrees(text, &[2, 2], |l| {
        (0..horizon(l)).all(|t| {
            let (a, b) = (l.at(t)[0] == 1, l.at(t)[1] == 1);
            let implied = !a || b;
            implied && (a || b)
        })
    });
}

#[test]
fn initial_conditions_about_the_second_step() {
    let head = "spec t\nenv boolean p;\nenv boolean q;\ndefine rises := !p & next(p);\n";
    let meant = |l: &Lasso| (l.at(0)[0] == 0 && l.at(1)[0] == 1) || l.at(0)[1] == 1;
    agrees_noted(&format!("{head}gar rises | q;"), &[2, 2], meant);
    let text = format!("{head}asm ini rises | q;");
    let mut game = game(&text);
    for lasso in lassos(&[2, 2], 6) {
        assert_eq!(game.assumed(&lasso), meant(&lasso), "{text}\n{lasso:?}");
    }
}

#[test]
fn initial_assumptions_leave_the_machines_values_open() {
    // The environment keeps what some values of the machine would make true.
    let cases = [
        ("s & x = 1", 1..=1),
        ("n < 2 -> x = 0", 0..=3),
        ("n = x & !s", 0..=2),
        ("n + x > 4 & (s | x = 3)", 3..=3),
    ];
    for (formula, left) in cases {
        let text = format!(
            "spec t\nenv Int(0..3) x;\naux boolean s;\ncounter n(0..2) {{ n = 0; inc: x = 1; overflow: keep; }}\n\
             define d := {formula};\ngar !s;\ngar G next(s) = s;\nasm d;\n"
        );
        let mut game = game(&text);
        for lasso in lassos(&[4], 6) {
            assert_eq!(
                game.assumed(&lasso),
                left.contains(&lasso.at(0)[0]),
                "{text}"
            );
        }
    }
}

/// Like [`agrees`], for a text with findings.
fn agrees_noted(text: &str, sizes: &[i64], naive: impl Fn(&Lasso) -> bool) {
    let (count, kept) = agrees(text, sizes, naive);
    assert!(kept > 0 && kept < count);
}
