//! Tests of the forms of common shapes by engineers and in papers, and of their meaning: formula
//! and form are evaluated by the textbook semantics on many runs that end in a loop.

use super::*;
use Strength::{Assumed, Equivalent, Stronger, Weaker};
use linewright_core::source::FileId;
use linewright_syntax::ast::{ContractItem, Item, PastOp, Pattern, Quantifier, UntilOp};
use std::fmt::Write as _;

fn formula(text: &str) -> Expr {
    let text = format!("contract A {{ guarantee {text} }}");
    let (file, findings) = linewright_syntax::parse(FileId::default(), &text);
    assert_eq!(findings, [], "{text}");
    let Some(Item::Contract(contract)) = file.items.into_iter().next() else {
        panic!("{text}");
    };
    match contract.items.into_iter().next() {
        Some(ContractItem::Formula { expr, .. }) => expr,
        other => panic!("{other:?}"),
    }
}

/// `i` and `j` are inputs, all other variables are the machine's.
fn input(e: &Expr) -> bool {
    let mut only = true;
    e.for_each_path(&mut |names| only &= matches!(names[0].text.as_str(), "i" | "j"));
    only
}

const GUARANTEES: &[(&str, Strength, &[&str])] = &[
    // Persistence.
    (
        "eventually always p",
        Stronger,
        &[
            "always (settled -> next settled)",
            "always (settled -> p)",
            "always eventually settled",
        ],
    ),
    (
        "always (p -> eventually always q)",
        Stronger,
        &[
            "always (settled -> next settled)",
            "always (settled -> q)",
            "always eventually (once p -> settled)",
        ],
    ),
    // Negations.
    ("not always p", Equivalent, &["eventually not p"]),
    ("not eventually p", Equivalent, &["always not p"]),
    ("not never p", Equivalent, &["eventually p"]),
    (
        "not (p precedes q)",
        Equivalent,
        &["eventually (q and not once p)"],
    ),
    (
        "not eventually always p",
        Equivalent,
        &["always eventually not p"],
    ),
    // Disjunctions.
    (
        "always (p or eventually q)",
        Equivalent,
        &["always (not p -> eventually q)"],
    ),
    (
        "always (p or always eventually q)",
        Equivalent,
        &["always eventually (q or historically p)"],
    ),
    (
        "always (p or always q)",
        Equivalent,
        &["always (once not p -> q)"],
    ),
    (
        "(always p) or (always q)",
        Equivalent,
        &["always (historically p or historically q)"],
    ),
    (
        "(always p) or (eventually q)",
        Equivalent,
        &["always eventually (historically p or once q)"],
    ),
    (
        "(always eventually p) or (always eventually q)",
        Equivalent,
        &["always eventually (p or q)"],
    ),
    (
        "(eventually p) or (eventually q)",
        Equivalent,
        &["eventually (p or q)"],
    ),
    (
        "always (p or (always q) or always r)",
        Equivalent,
        &["always (historically (once not p -> q) or historically (once not p -> r))"],
    ),
    (
        "always (p -> eventually q) or always eventually r",
        Equivalent,
        &["always eventually (not q since (p and not q) -> r)"],
    ),
    (
        "(always (p -> eventually q)) or (always r)",
        Equivalent,
        &["always eventually (not q since (p and not q) -> historically r)"],
    ),
    // Implications.
    (
        "p -> eventually q",
        Equivalent,
        &["always (p and not previous true -> eventually q)"],
    ),
    (
        "p -> always q",
        Equivalent,
        &["always (once (p and not previous true) -> q)"],
    ),
    (
        "p -> always eventually q",
        Equivalent,
        &["always eventually (once (p and not previous true) -> q)"],
    ),
    (
        "always (p -> always q)",
        Equivalent,
        &["always (once p -> q)"],
    ),
    (
        "always (p -> always (q -> eventually r))",
        Equivalent,
        &["always (once p and q -> eventually r)"],
    ),
    (
        "(always p) -> (always q)",
        Equivalent,
        &["always eventually (historically p -> historically q)"],
    ),
    (
        "(eventually p) -> (always q)",
        Equivalent,
        &["always (once p -> historically q)"],
    ),
    (
        "(eventually p) -> (eventually q)",
        Equivalent,
        &["always eventually (once p -> once q)"],
    ),
    (
        "(always eventually i) -> (always eventually p)",
        Assumed,
        &["assume always eventually i", "always eventually p"],
    ),
    (
        "always ((always eventually i) -> eventually p)",
        Assumed,
        &["assume always eventually i", "always eventually p"],
    ),
    (
        "(always eventually p) -> (always eventually q)",
        Stronger,
        &[
            "always (settled -> next settled)",
            "always (settled -> not p)",
            "always eventually (settled or q)",
        ],
    ),
    ("p <-> always q", Equivalent, &[]),
    ("if p then always q else always r", Equivalent, &[]),
    // Chains.
    (
        "eventually (p and eventually q)",
        Equivalent,
        &["eventually (q and once p)"],
    ),
    (
        "always eventually (p and eventually q)",
        Equivalent,
        &["always eventually p", "always eventually q"],
    ),
    (
        "always (p -> eventually (q and eventually r))",
        Stronger,
        &["always (p -> eventually q)", "always (q -> eventually r)"],
    ),
    // Until.
    (
        "p until q",
        Equivalent,
        &["always (p or once q)", "eventually q"],
    ),
    ("p W q", Equivalent, &["always (p or once q)"]),
    ("p R q", Equivalent, &["always (q or once (p and q))"]),
    (
        "not (p U q)",
        Equivalent,
        &["always (q -> once (not p and not q))"],
    ),
    (
        "always (p U q)",
        Equivalent,
        &["always (p or q)", "always eventually q"],
    ),
    ("always (p W q)", Equivalent, &["always (p or q)"]),
    (
        "always (p -> q W r)",
        Equivalent,
        &["always q after p until r"],
    ),
    (
        "always (p -> q U r)",
        Equivalent,
        &["always q after p until r", "always (p -> eventually r)"],
    ),
    // Next.
    (
        "next p",
        Equivalent,
        &["always (not previous true -> next p)"],
    ),
    (
        "p -> next q",
        Equivalent,
        &["always (not previous true -> p -> next q)"],
    ),
    (
        "always next (eventually p)",
        Equivalent,
        &["always eventually p"],
    ),
    (
        "always (p -> next (eventually q))",
        Equivalent,
        &["always (previous p -> eventually q)"],
    ),
    (
        "always (p -> next (always q))",
        Equivalent,
        &["always (once previous p -> q)"],
    ),
    (
        "next (always p)",
        Equivalent,
        &["always (previous true -> p)"],
    ),
    (
        "next (eventually p)",
        Equivalent,
        &["eventually (p and previous true)"],
    ),
];

const ASSUMPTIONS: &[(&str, Strength, &[&str])] = &[
    (
        "eventually always i",
        Weaker,
        &["assume always eventually i"],
    ),
    (
        "always (i -> eventually always j)",
        Weaker,
        &["assume always eventually (once i -> j)"],
    ),
    (
        "always (i -> eventually (j and eventually not i))",
        Weaker,
        &["assume always (i -> eventually j)"],
    ),
    (
        "always (i -> always j)",
        Equivalent,
        &["assume always (once i -> j)"],
    ),
    (
        "(always eventually i) -> (always eventually j)",
        Weaker,
        &["assume always eventually (i -> j)"],
    ),
];

/// Formulas without a form, or without one known here.
const NONE: &[&str] = &[
    "eventually (p and always q)",
    "always (p or (always q) or eventually r)",
    "always (p -> eventually (q and eventually (r and eventually p)))",
    "(eventually always p) and (p U (always q))",
    "always (p -> (q and next p) U r)",
    "exists k in 0..1: always p",
];

#[test]
fn shapes_have_these_forms() {
    let mut report = String::new();
    let sides = [(GUARANTEES, true), (ASSUMPTIONS, false)];
    for (text, strength, rules, guarantee) in sides
        .iter()
        .flat_map(|(list, side)| list.iter().map(move |(t, s, r)| (*t, *s, *r, *side)))
    {
        let original = formula(text);
        let Some(form) = of(&original, guarantee, &input, Some("settled")) else {
            let _ = writeln!(report, "{text}: no form");
            continue;
        };
        let found: Vec<String> = form
            .rules
            .iter()
            .map(|(guarantee, e)| {
                let word = if *guarantee { "" } else { "assume " };
                format!("{word}{}", format::format_expression(e))
            })
            .collect();
        if form.strength != strength || !rules.is_empty() && found != rules {
            let _ = writeln!(report, "{text}: {:?} {found:#?}", form.strength);
        }
        // The form is parsed back as itself.
        for (_, rule) in &form.rules {
            let again = formula(&format::format_expression(rule));
            assert_eq!(
                format::format_expression(&again),
                format::format_expression(rule),
                "{text}"
            );
        }
        if let Some(run) = counterexample(&original, &form) {
            let _ = writeln!(report, "{text} is not {found:#?} on {run:?}");
        }
    }
    assert!(report.is_empty(), "{report}");
}

#[test]
fn what_has_no_form_gets_none() {
    for text in NONE {
        let form = of(&formula(text), true, &input, Some("settled"));
        assert!(
            form.is_none(),
            "{text}: {}",
            form.map_or(String::new(), |f| f.text())
        );
    }
}

/// Every formula over an input and an output with up to four LTL operators, as an assumption and as
/// a guarantee: the form offered for it compares as claimed, on all short lassos.
#[test]
fn every_form_of_a_small_formula_means_what_is_said() {
    let mut formulas: Vec<Vec<String>> = vec![Vec::new(), vec!["p".to_owned(), "i".to_owned()]];
    for size in 2..=4 {
        let mut found = Vec::new();
        for inner in &formulas[size - 1] {
            for op in ["always", "eventually", "not", "next"] {
                found.push(format!("{op} ({inner})"));
            }
        }
        for left in 1..size - 1 {
            for (a, b) in formulas[left]
                .iter()
                .flat_map(|a| formulas[size - 1 - left].iter().map(move |b| (a, b)))
            {
                for op in ["and", "or", "->", "U", "W"] {
                    found.push(format!("({a}) {op} ({b})"));
                }
            }
        }
        formulas.push(found);
    }
    // Shapes with more operators.
    let shapes = ["p", "i", "not p"].into_iter().flat_map(|a| {
        ["i", "p"].into_iter().flat_map(move |b| {
            [
                format!("always ({a} -> eventually always {b})"),
                format!("always ({a} -> eventually ({b} and eventually p))"),
                format!("(always eventually {a}) -> (always eventually {b})"),
                format!("always (eventually always {a})"),
                format!("always ({a} or (p W {b}))"),
            ]
        })
    });
    let shapes: Vec<String> = shapes.collect();
    let runs = [Run::all(&["p", "i"]), Run::all(&["p", "i", "settled"])];
    let mut offered = [0; 4];
    let mut report = String::new();
    for text in formulas.iter().flatten().chain(&shapes) {
        let original = formula(text);
        if !temporal(&original) && !mentions_next(&original) {
            continue;
        }
        for guarantee in [false, true] {
            let Some(form) = of(&original, guarantee, &input, Some("settled")) else {
                continue;
            };
            offered[form.strength as usize] += 1;
            assert!(
                guarantee || form.rules.iter().all(|(guarantee, _)| !guarantee),
                "{text}: assumed as a guarantee"
            );
            assert!(
                form.strength == Assumed || form.rules.iter().all(|(side, _)| *side == guarantee),
                "{text}: on the other side"
            );
            // A guarantee can be stronger than necessary, and an assumption weaker.
            let fits = match form.strength {
                Equivalent => true,
                Stronger | Assumed => guarantee,
                Weaker => !guarantee,
            };
            assert!(fits, "{text}: {:?}", form.strength);
            let runs = &runs[usize::from(form.variable.is_some())];
            let wrong = runs
                .iter()
                .find(|run| deviates(run.holds(&original)[0], run, &form));
            if let Some(run) = wrong {
                let _ = writeln!(report, "{text} is not {} on {run:?}", form.text());
            }
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(offered.iter().all(|n| *n > 5), "{offered:?}");
}

// ---- direct evaluation --------------------------------------------------------------------------

const NAMES: [&str; 6] = ["p", "q", "r", "i", "j", "settled"];

/// The letters of a run, the last ones repeated for ever; unrolled until the past operators have
/// settled.
#[derive(Debug)]
struct Run {
    letters: Vec<u8>,
    period: usize,
}

impl Run {
    fn random(state: &mut u64) -> Self {
        let mut pick = |n: u64| {
            *state ^= *state << 13;
            *state ^= *state >> 7;
            *state ^= *state << 17;
            (*state >> 24) % n
        };
        let (stem, period) = (pick(5), 1 + pick(4) as usize);
        // Sparse runs break other formulas than busy ones.
        let sparse = pick(3);
        let mut letter = || {
            let all = pick(64);
            (if sparse == 0 {
                all & pick(64)
            } else if sparse == 1 {
                all | pick(64)
            } else {
                all
            }) as u8
        };
        let mut letters: Vec<u8> = (0..stem).map(|_| letter()).collect();
        let cycle: Vec<u8> = (0..period).map(|_| letter()).collect();
        for _ in 0..8 {
            letters.extend(&cycle);
        }
        Self { letters, period }
    }

    /// Returns all runs over these names with up to three letters before the loop ends.
    fn all(names: &[&str]) -> Vec<Self> {
        let bit = |name: &&str| {
            let bit = NAMES.iter().position(|n| n == name);
            1_u8 << bit.expect("a name")
        };
        let bits: Vec<u8> = names.iter().map(bit).collect();
        let letters_of = 1_usize << names.len();
        let letter = |n: usize| {
            let on = bits.iter().enumerate().filter(|(k, _)| n >> k & 1 == 1);
            on.map(|(_, bit)| bit).sum::<u8>()
        };
        let mut found = Vec::new();
        for length in 1..=3 {
            for period in 1..=length {
                for word in 0..letters_of.pow(length as u32) {
                    let at = |k: usize| word / letters_of.pow(k as u32) % letters_of;
                    let once: Vec<u8> = (0..length).map(|k| letter(at(k))).collect();
                    let mut letters = once.clone();
                    for _ in 0..3 {
                        letters.extend(&once[length - period..]);
                    }
                    found.push(Self { letters, period });
                }
            }
        }
        found
    }

    /// Returns whether all rules of a form hold, on either side; with an assumed premise, whether
    /// the guarantees hold if the assumptions do.
    fn keeps(&self, form: &Form) -> bool {
        let all = |side: bool| {
            let mut rules = form
                .rules
                .iter()
                .filter(|(guarantee, _)| *guarantee == side);
            rules.all(|(_, e)| self.holds(e)[0])
        };
        match form.strength {
            Assumed => !all(false) || all(true),
            _ => all(false) && all(true),
        }
    }

    fn next(&self, i: usize) -> usize {
        let n = self.letters.len();
        if i + 1 < n { i + 1 } else { n - self.period }
    }

    /// Returns the steps from `i` on, each once.
    fn from(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        let n = self.letters.len();
        i.min(n - self.period)..n
    }

    fn holds(&self, e: &Expr) -> Vec<bool> {
        let n = self.letters.len();
        let all = |f: &dyn Fn(usize) -> bool| -> Vec<bool> { (0..n).map(f).collect() };
        match &e.kind {
            ExprKind::Bool(value) => vec![*value; n],
            ExprKind::Path(names) => {
                let bit = NAMES
                    .iter()
                    .position(|x| *x == names[0].text)
                    .expect("a name");
                all(&|i| self.letters[i] >> bit & 1 == 1)
            }
            ExprKind::Not(a) => self.holds(a).into_iter().map(|x| !x).collect(),
            ExprKind::Binary(op, a, b) => {
                let (a, b) = (self.holds(a), self.holds(b));
                all(&|i| match op {
                    BinaryOp::And => a[i] && b[i],
                    BinaryOp::Or => a[i] || b[i],
                    BinaryOp::Implies => !a[i] || b[i],
                    BinaryOp::Iff => a[i] == b[i],
                    other => panic!("{other:?}"),
                })
            }
            ExprKind::If(c, a, b) => {
                let (c, a, b) = (self.holds(c), self.holds(a), self.holds(b));
                all(&|i| if c[i] { a[i] } else { b[i] })
            }
            ExprKind::Next(a) => {
                let a = self.holds(a);
                all(&|i| a[self.next(i)])
            }
            ExprKind::Always(a) => {
                let a = self.holds(a);
                all(&|i| self.from(i).all(|j| a[j]))
            }
            ExprKind::Eventually(a) => {
                let a = self.holds(a);
                all(&|i| self.from(i).any(|j| a[j]))
            }
            ExprKind::Until(op, a, b) => {
                let (a, b) = (self.holds(a), self.holds(b));
                let until = |a: &[bool], b: &[bool], weak: bool, i: usize| {
                    let mut at = i;
                    for _ in 0..=n {
                        if b[at] {
                            return true;
                        }
                        if !a[at] {
                            return false;
                        }
                        at = self.next(at);
                    }
                    weak
                };
                let both: Vec<bool> = a.iter().zip(&b).map(|(a, b)| *a && *b).collect();
                all(&|i| match op {
                    UntilOp::Strong => until(&a, &b, false, i),
                    UntilOp::Weak => until(&a, &b, true, i),
                    UntilOp::Release => until(&b, &both, true, i),
                })
            }
            ExprKind::Past(op, a, None) => {
                let a = self.holds(a);
                all(&|i| match op {
                    PastOp::Previous => i > 0 && a[i - 1],
                    PastOp::Once => a[..=i].iter().any(|x| *x),
                    PastOp::Historically => a[..=i].iter().all(|x| *x),
                })
            }
            ExprKind::Since(a, b) => {
                let (a, b) = (self.holds(a), self.holds(b));
                all(&|i| (0..=i).any(|j| b[j] && a[j + 1..=i].iter().all(|x| *x)))
            }
            ExprKind::Pattern(Pattern {
                kind: PatternKind::Universality(p),
                scope: Scope::AfterUntil(q, r),
                ..
            }) => {
                let (p, q, r) = (self.holds(p), self.holds(q), self.holds(r));
                let open = all(&|i| (0..=i).any(|j| q[j] && r[j..=i].iter().all(|x| !x)));
                all(&|i| self.from(i).all(|j| !open[j] || p[j]))
            }
            ExprKind::Pattern(Pattern { kind, .. }) => match kind {
                PatternKind::Absence(p) => {
                    let p = self.holds(p);
                    all(&|i| !self.from(i).any(|j| p[j]))
                }
                PatternKind::Precedence(s, p) => {
                    let (s, p) = (self.holds(s), self.holds(p));
                    all(&|_| (0..n).all(|j| !p[j] || s[..=j].iter().any(|x| *x)))
                }
                other => panic!("{other:?}"),
            },
            ExprKind::Quantifier(Quantifier::Forall, _, _, body) => self.holds(body),
            other => panic!("{other:?}"),
        }
    }
}

/// Returns a run on which the form does not compare as claimed.
fn counterexample(original: &Expr, form: &Form) -> Option<Run> {
    let mut state = 0x9E37_79B9_7F4A_7C15;
    (0..4_000)
        .map(|_| Run::random(&mut state))
        .find(|run| deviates(run.holds(original)[0], run, form))
}

/// Returns whether a form does not compare as claimed with a formula whose value on a run is
/// `wanted`.
fn deviates(wanted: bool, run: &Run, form: &Form) -> bool {
    let found = run.keeps(form);
    match form.strength {
        Equivalent | Assumed => found != wanted,
        Stronger => found && !wanted,
        Weaker => wanted && !found,
    }
}
