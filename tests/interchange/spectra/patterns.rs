//! Every published pattern compared with its formula, evaluated step by step.

use super::lassos::{Lasso, agrees};
use rayon::prelude::*;

/// Names, parameters and formulas as documented in the published file; `V` is release.
const PATTERNS: [(&str, &str, &str); 56] = [
    ("P_is_false_globally", "p", "G !p"),
    ("P_is_false_before_R", "pr", "(!p U r) | !F r"),
    ("P_is_false_after_Q", "pq", "G (!q | G !p)"),
    (
        "P_is_false_between_Q_and_R",
        "pqr",
        "G ((!p U r) | !(q & !r & F r))",
    ),
    (
        "P_is_false_after_Q_until_R",
        "pqr",
        "G (!(q & !r) | (r V (!p | r)))",
    ),
    ("P_becomes_true_globally", "p", "F p"),
    (
        "P_becomes_true_before_R",
        "pr",
        "(p & !r) V (!r | (p & !r))",
    ),
    ("P_becomes_true_After_Q", "qp", "G !q | F (q & F p)"),
    (
        "P_becomes_true_between_Q_and_R",
        "pqr",
        "G (!(q & !r) | ((p & !r) V (!r | (p & !r))))",
    ),
    (
        "P_becomes_true_after_Q_until_R",
        "pqr",
        "G (!(q & !r) | (!r U (p & !r)))",
    ),
    (
        "P_occures_at_most_twice_globally",
        "p",
        "!F (p & X F (!p & X F (p & X F (!p & X F p))))",
    ),
    (
        "P_occures_at_most_twice_before_R",
        "pr",
        "((!p & !r) U (r | ((p & !r) U (r | ((!p & !r) U (r | ((p & !r) U (r | (!p U r))))))))) | !F r",
    ),
    (
        "P_occures_at_most_twice_after_Q",
        "pq",
        "(!q U (q & !F (p & X F (!p & X F (p & X F (!p & X F p)))))) | !F q",
    ),
    (
        "P_occures_at_most_twice_between_Q_and_R",
        "pqr",
        "G (((!p & !r) U (r | ((p & !r) U (r | ((!p & !r) U (r | ((p & !r) U (r | (!p U r))))))))) | !(q & F r))",
    ),
    ("P_is_true_globally", "p", "G p"),
    ("P_is_true_before_R", "pr", "(p U r) | !F r"),
    ("P_is_true_after_Q", "pq", "G (!q | G p)"),
    (
        "P_is_true_between_Q_and_R",
        "pqr",
        "G ((p U r) | !(q & !r & F r))",
    ),
    (
        "P_is_true_After_Q_until_R",
        "pqr",
        "G (!(q & !r) | (r V (p | r)))",
    ),
    ("S_precedes_to_P_globally", "sp", "s V (!p | s)"),
    ("S_precedes_to_P_before_R", "spr", "(!p U (r | s)) | !F r"),
    (
        "S_precedes_to_P_between_Q_and_R",
        "spqr",
        "G ((!p U (r | s)) | !(q & !r & F r))",
    ),
    (
        "S_precedes_to_P_after_Q_until_R",
        "spqr",
        "G (!(q & !r) | ((r | s) V (!p | r | s)))",
    ),
    ("S_responds_to_P_globally", "sp", "G (!p | F s)"),
    (
        "S_responds_to_P_before_R",
        "spr",
        "((!p | (!r U (!r & s))) U r) | !F r",
    ),
    ("S_responds_to_P_after_Q", "spq", "G (!q | G (!p | F s))"),
    (
        "S_responds_to_P_between_Q_and_R",
        "spqr",
        "G (((!p | (!r U (!r & s))) U r) | !(q & !r & F r))",
    ),
    (
        "S_responds_to_P_after_Q_until_R",
        "spqr",
        "G (!(q & !r) | (r V (!p | r | (!r U (!r & s)))))",
    ),
    (
        "S_and_T_precedes_to_P_globally",
        "stp",
        "(!p U (!p & s & X (!p U t))) | !F p",
    ),
    (
        "S_and_T_precedes_to_P_before_R",
        "stpr",
        "(!p U (r | (!p & s & X (!p U t)))) | !F r",
    ),
    (
        "S_and_T_precedes_to_P_after_Q",
        "stpq",
        "G !q | (!q U ((!p U (!p & s & X (!p U t))) | !(q & F p)))",
    ),
    (
        "S_and_T_precedes_to_P_between_Q_and_R",
        "stpqr",
        "G ((!p U (r | (!p & s & X (!p U t)))) | !(q & F r))",
    ),
    (
        "S_and_T_precedes_to_P_after_Q_until_R",
        "stpqr",
        "G (!q | (!p U (r | (!p & s & X (!p U t)))) | !F p)",
    ),
    (
        "P_precedes_S_and_T_globally",
        "pst",
        "(!s U p) | !F (s & X F t)",
    ),
    (
        "P_precedes_S_and_T_before_R",
        "pstr",
        "(!(!r & s & X (!r U (!r & t))) U (p | r)) | !F r",
    ),
    (
        "P_precedes_S_and_T_after_q",
        "pstq",
        "G !q | (!q U (q & ((!s U p) | !F (s & X F t))))",
    ),
    (
        "P_precedes_S_and_T_between_q_and_R",
        "pstqr",
        "G ((!(!r & s & X (!r U (!r & t))) U (p | r)) | !(q & F r))",
    ),
    (
        "P_precedes_S_and_T_after_q_until_R",
        "pstqr",
        "G (!q | (!(!r & s & X (!r U (!r & t))) U (p | r)) | G !(s & X F t))",
    ),
    (
        "P_responds_to_S_and_T_globally",
        "pst",
        "G (X F (t & F p) | !(s & X F t))",
    ),
    (
        "P_responds_to_S_and_T_before_r",
        "pstr",
        "((X (!r U (t & F p)) | !(s & X (!r U t))) U r) | !F r",
    ),
    (
        "P_responds_to_S_and_T_after_Q",
        "pstq",
        "G (!q | G (X (!t U (t & F p)) | !(s & X F t)))",
    ),
    (
        "P_responds_to_S_and_T_between_Q_and_R",
        "pstqr",
        "G (((X (!r U (t & F p)) | !(s & X (!r U t))) U r) | !(q & F r))",
    ),
    (
        "P_responds_to_S_and_T_after_Q_until_R",
        "pstqr",
        "G (!q | ((X (!r U (t & F p)) | !(s & X (!r U t))) U (r | G (X (!r U (t & F p)) | !(s & X (!r U t))))))",
    ),
    (
        "S_and_T_responds_to_P_globally",
        "stp",
        "G (!p | F (s & X F t))",
    ),
    (
        "S_and_T_responds_to_P_before_R",
        "stpr",
        "((!p | (!r U (!r & s & X (!r U t)))) U r) | !F r",
    ),
    (
        "S_and_T_responds_to_P_after_q",
        "stpq",
        "G (!q | G (!p | (s & X F t)))",
    ),
    (
        "S_and_T_responds_to_P_between_q_and_R",
        "stpqr",
        "G (((!p | (!r U (!r & s & X (!r U t)))) U r) | !(q & F r))",
    ),
    (
        "S_and_T_without_Z_responds_to_P_globally",
        "stzp",
        "G (!p | F (s & !z & X (!z U t)))",
    ),
    (
        "S_and_T_without_Z_responds_to_P_before_R",
        "stzpr",
        "((!p | (!r U (!r & s & !z & X ((!r & !z) U t)))) U r) | !F r",
    ),
    (
        "S_and_T_without_Z_responds_to_P_after_Q",
        "stzpq",
        "G (!q | G (!p | (s & !z & X (!z U t))))",
    ),
    (
        "S_and_T_without_Z_responds_to_P_between_Q_and_R",
        "stzpqr",
        "G (((!p | (!r U (!r & s & !z & X ((!r & !z) U t)))) U r) | !(q & F r))",
    ),
    ("notP_globally", "p", "G !p"),
    ("notP_beforeR", "pr", "(!p U r) | !F r"),
    (
        "pBecomesTrue_betweenQandR",
        "pqr",
        "G (!(q & !r) | ((p & !r) V (!r | (p & !r))))",
    ),
    (
        "pHolds_afterQuntilR",
        "pqr",
        "G (!(q & !r) | (r V (p | r)))",
    ),
    ("pRespondsToS", "ps", "G (p -> F s)"),
];

/// The truth of a formula at each position of a lasso, parsed from its text: positions are
/// numbered, and the last is followed by `back`.
struct Reader<'a> {
    text: &'a [u8],
    parameters: &'a str,
    lasso: &'a Lasso,
}

type Truth = Vec<bool>;

impl Reader<'_> {
    fn take(&mut self, sign: &str) -> bool {
        self.text = self.text.trim_ascii_start();
        let found = self.text.starts_with(sign.as_bytes());
        if found {
            self.text = &self.text[sign.len()..];
        }
        found
    }

    fn formula(&mut self) -> Truth {
        let mut left = self.conjunction();
        loop {
            if self.take("->") {
                let right = self.conjunction();
                left = zip(&left, &right, |a, b| !a || b);
            } else if self.take("|") {
                let right = self.conjunction();
                left = zip(&left, &right, |a, b| a || b);
            } else {
                return left;
            }
        }
    }

    fn conjunction(&mut self) -> Truth {
        let mut left = self.binary();
        while self.take("&") {
            let right = self.binary();
            left = zip(&left, &right, |a, b| a && b);
        }
        left
    }

    fn binary(&mut self) -> Truth {
        let left = self.unary();
        if self.take("U") {
            let right = self.unary();
            self.until(&left, &right)
        } else if self.take("V") {
            let right = self.unary();
            let not = |t: &Truth| t.iter().map(|v| !v).collect::<Truth>();
            not(&self.until(&not(&left), &not(&right)))
        } else {
            left
        }
    }

    fn after(&self, position: usize) -> usize {
        if position + 1 < self.lasso.letters.len() {
            position + 1
        } else {
            self.lasso.back
        }
    }

    /// Some later position satisfies b, and all before it satisfy a: searched one by one.
    fn until(&self, a: &Truth, b: &Truth) -> Truth {
        let count = a.len();
        let from = |start: usize| {
            let mut at = start;
            for _ in 0..2 * count {
                if b[at] {
                    return true;
                }
                if !a[at] {
                    return false;
                }
                at = self.after(at);
            }
            false
        };
        (0..count).map(from).collect()
    }

    fn unary(&mut self) -> Truth {
        if self.take("!") {
            return self.unary().into_iter().map(|v| !v).collect();
        }
        if self.take("X") {
            let inner = self.unary();
            return (0..inner.len()).map(|i| inner[self.after(i)]).collect();
        }
        if self.take("F") {
            let inner = self.unary();
            return self.until(&vec![true; inner.len()], &inner);
        }
        if self.take("G") {
            let not: Truth = self.unary().into_iter().map(|v| !v).collect();
            let found = self.until(&vec![true; not.len()], &not);
            return found.into_iter().map(|v| !v).collect();
        }
        if self.take("(") {
            let inner = self.formula();
            assert!(self.take(")"));
            return inner;
        }
        let letter = char::from(self.text[0]);
        self.text = &self.text[1..];
        let place = self.parameters.find(letter).expect("a parameter");
        let letters = self.lasso.letters.iter();
        letters.map(|l| l[place] == 1).collect()
    }
}

fn zip(a: &Truth, b: &Truth, op: impl Fn(bool, bool) -> bool) -> Truth {
    a.iter().zip(b).map(|(a, b)| op(*a, *b)).collect()
}

#[test]
fn published_patterns_mean_their_formulas() {
    let counts: Vec<(usize, usize)> = PATTERNS
        .par_iter()
        .map(|(name, parameters, formula)| {
            let names: Vec<String> = parameters.chars().map(|c| c.to_string()).collect();
            let mut inputs = String::new();
            for name in &names {
                inputs += "env boolean ";
                inputs += name;
                inputs += ";\n";
            }
            let text = format!(
                "import \"DwyerPatterns.spectra\"\nspec t\n{inputs}gar {name}({});\n",
                names.join(", ")
            );
            let counts = agrees(&text, &vec![2; names.len()], |lasso| {
                let mut reader = Reader {
                    text: formula.as_bytes(),
                    parameters,
                    lasso,
                };
                reader.formula()[0]
            });
            assert!(counts.1 > 0 && counts.1 < counts.0, "{name}: {counts:?}");
            counts
        })
        .collect();
    assert_eq!(counts.len(), 56);
}

#[test]
fn a_pattern_of_the_file_goes_before_a_published_one() {
    let text = "import \"DwyerPatterns.spectra\"\nspec t\nenv boolean p;\nenv boolean s;\n\
        pattern pRespondsToS(a, b) { var boolean done; done; G next(done) <-> (b | (done & !a)); GF done; }\n\
        gar pRespondsToS(p, s);\n";
    agrees(text, &[2, 2], |lasso| {
        let cycle = lasso.back..lasso.letters.len();
        let answers = cycle.clone().any(|i| lasso.at(i)[1] == 1);
        let last = |place: usize| {
            (0..lasso.letters.len())
                .rev()
                .find(|i| lasso.at(*i)[place] == 1)
        };
        // Without answers in the cycle: no request in it, and none after the last answer before it.
        answers || last(0).is_none_or(|p| p < lasso.back && last(1).is_some_and(|s| s >= p))
    });
}

/// The text that `check` prints about a file.
fn checked(text: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.spectra"), text).expect("a file can be written");
    let output = crate::support::linewright(folder.path(), &["check", "a.spectra", "--no-timing"]);
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// `G p` binds the step that is left: a play ends where it is violated, not one step later.
#[test]
fn a_play_ends_in_the_step_that_violates_a_guarantee() {
    let text = checked(
        "spec A\nenv boolean e;\nsys boolean r;\nasm blink: G next(e) <-> !e;\nasm first: ini e;\n\
         gar low: G e -> r;\ngar high: G e -> !r;\n",
    );
    let wanted = "in step 0 no answer keeps `low` and `high` together";
    assert!(text.contains(wanted), "{text}");
}

/// A name that is given twice becomes two names, so that only the guarantees of the core are
/// marked.
#[test]
fn a_core_distinguishes_guarantees_of_one_name() {
    let text = checked(
        "spec A\nenv boolean a;\nsys boolean b;\nsys boolean c;\ngar same: G a -> b;\n\
         gar same: G c | !c;\ngar same: GF c;\ngar no: G a -> !b;\n",
    );
    assert_eq!(text.matches("cannot be kept").count(), 2, "{text}");
    assert!(text.contains("`same` and `no` together"), "{text}");
}

#[test]
fn next_values_in_justice_guarantees_have_a_note() {
    let text = checked("spec A\nenv boolean a;\nsys boolean b;\ngar t: GF next(b);\n");
    assert!(text.contains("note[LW006]"), "{text}");
}

/// The list in the guide has every pattern, with its parameters in order.
#[test]
fn the_guide_lists_all_patterns() {
    let page = std::fs::read_to_string(crate::support::root().join("docs/guide/other-tools.md"));
    let page = page.expect("a page");
    for (name, parameters, _) in PATTERNS {
        let parameters: Vec<String> = parameters.chars().map(String::from).collect();
        let line = format!("\n{name}({})\n", parameters.join(", "));
        assert!(page.contains(&line), "{line}");
    }
}

/// Counters have a row in the table of a play, and monitors one in the table of `step`.
#[test]
fn counters_and_monitors_are_shown() {
    let text = checked(
        "spec A\nenv boolean e;\nsys boolean o;\n\
         counter moves(0..5) { moves = 0; inc: !o; reset: o; overflow: false; }\n\
         gar never: G !o;\n",
    );
    assert!(text.contains("machine  moves  0"), "{text}");
    let folder = tempfile::tempdir().expect("a folder");
    let file = "spec A\nenv boolean tick;\nsys boolean lamp;\n\
                monitor Int(0..3) count {\n  ini count = 0;\n  G next(count) = count;\n}\n\
                gar o: GF lamp;\n";
    std::fs::write(folder.path().join("a.spectra"), file).expect("a file can be written");
    std::fs::write(folder.path().join("s.txt"), "tick = true\nstate\n").expect("a script");
    let arguments = ["step", "a.spectra", "--script", "s.txt"];
    let output = crate::support::linewright(folder.path(), &arguments);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.lines().any(|l| l.starts_with("count ")), "{text}");
}

/// `G p` binds each step that has a successor, `always p` every step. Here the environment has no
/// step after the first.
#[test]
fn g_and_always_differ_in_the_last_step() {
    let text = |operator: &str| {
        checked(&format!(
            "spec A\nenv boolean e;\nsys boolean o;\nasm dead: G next(e) & !next(e);\n\
             gar p: {operator} (o & !o);\n"
        ))
    };
    assert!(text("G").contains("  realizable"), "{}", text("G"));
    assert!(
        text("always").contains("unrealizable"),
        "{}",
        text("always")
    );
}

/// In `step`, a violated `G p` is shown with the values of the step that violates it.
#[test]
fn a_violated_guarantee_is_shown_with_the_values_of_its_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = "spec A\nenv boolean e;\nsys boolean r;\nasm blink: G next(e) <-> !e;\n\
                asm first: ini e;\ngar low: G e -> r;\ngar high: G e -> !r;\n";
    std::fs::write(folder.path().join("a.spectra"), file).expect("a file can be written");
    std::fs::write(folder.path().join("s.txt"), "r = true\n").expect("a script");
    let arguments = ["step", "a.spectra", "--script", "s.txt"];
    let output = crate::support::linewright(folder.path(), &arguments);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("before e = true, r = true"), "{text}");
}
