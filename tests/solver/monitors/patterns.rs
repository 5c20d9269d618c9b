//! Every pattern in every scope, with and without a bound, and its meaning.

use linewright::gr1::monitors::{Pattern, Scope};
use linewright::gr1::{Expr, VarId};

/// One pattern in one scope.
pub struct Case {
    pub name: String,
    /// The letters of the formula, in order; each is the variable with its index.
    pub names: Vec<char>,
    pub pattern: Pattern,
    pub scope: Scope,
    /// The formula of temporal logic.
    pub meaning: String,
}

/// Pattern, scope, meaning; `n` is the bound.
const TABLE: [(&str, &str, &str); 35] = [
    ("absence", "globally", "G !p"),
    ("absence", "before", "F r -> (!p U r)"),
    ("absence", "after", "G (q -> G !p)"),
    ("absence", "between", "G ((q & !r & F r) -> (!p U r))"),
    ("absence", "until", "G ((q & !r) -> (!p W r))"),
    ("existence", "globally", "F p"),
    ("existence", "before", "!r W (p & !r)"),
    ("existence", "after", "G !q or F (q & F p)"),
    ("existence", "between", "G ((q & !r) -> (!r W (p & !r)))"),
    ("existence", "until", "G ((q & !r) -> (!r U (p & !r)))"),
    ("universality", "globally", "G p"),
    ("universality", "before", "F r -> (p U r)"),
    ("universality", "after", "G (q -> G p)"),
    ("universality", "between", "G ((q & !r & F r) -> (p U r))"),
    ("universality", "until", "G ((q & !r) -> (p W r))"),
    ("precedence", "globally", "!p W s"),
    ("precedence", "before", "F r -> (!p U (s or r))"),
    // Not Dwyer's formula, which GR(1) cannot express: see `after_q_the_first_q_is_meant`.
    ("precedence", "after", "!q W (q & (!p W s))"),
    (
        "precedence",
        "between",
        "G ((q & !r & F r) -> (!p U (s or r)))",
    ),
    ("precedence", "until", "G ((q & !r) -> (!p W (s or r)))"),
    ("response", "globally", "G (p -> F s)"),
    ("response", "before", "F r -> ((p -> (!r U (s & !r))) U r)"),
    ("response", "after", "G (q -> G (p -> F s))"),
    (
        "response",
        "between",
        "G ((q & !r & F r) -> ((p -> (!r U (s & !r))) U r))",
    ),
    (
        "response",
        "until",
        "G ((q & !r) -> ((p -> (!r U (s & !r))) W r))",
    ),
    ("existence n", "globally", "F<=n p"),
    ("existence n", "before", "F r -> (!r U<=n (p & !r))"),
    ("existence n", "after", "!q W (q & F<=n p)"),
    (
        "existence n",
        "between",
        "G ((q & !r & F r) -> (!r U<=n (p & !r)))",
    ),
    ("existence n", "until", "G ((q & !r) -> (!r U<=n (p & !r)))"),
    ("response n", "globally", "G (p -> F<=n s)"),
    (
        "response n",
        "before",
        "F r -> ((p -> (!r U<=n (s & !r))) U r)",
    ),
    ("response n", "after", "G (q -> G (p -> F<=n s))"),
    (
        "response n",
        "between",
        "G ((q & !r & F r) -> ((p -> (!r U<=n (s & !r))) U r))",
    ),
    (
        "response n",
        "until",
        "G ((q & !r) -> ((p -> (!r U<=n (s & !r))) W r))",
    ),
];

/// Every line of the table; those with a bound once for each of `bounds`.
pub fn cases(bounds: std::ops::RangeInclusive<u32>) -> Vec<Case> {
    let mut found = Vec::new();
    for (pattern, scope, meaning) in TABLE {
        if pattern.ends_with('n') && pattern.contains(' ') {
            found.extend(
                bounds
                    .clone()
                    .map(|n| case(pattern, scope, meaning, Some(n))),
            );
        } else {
            found.push(case(pattern, scope, meaning, None));
        }
    }
    found
}

fn case(pattern: &str, scope: &str, meaning: &str, within: Option<u32>) -> Case {
    let meaning = within.map_or(meaning.to_owned(), |n| {
        meaning.replace("<=n", &format!("<={n}"))
    });
    let names: Vec<char> = ('p'..='s').filter(|c| meaning.contains(*c)).collect();
    let of = |name: char| {
        let place = names.iter().position(|n| *n == name);
        Expr::now(VarId(place.expect("in the formula") as u32))
    };
    Case {
        name: format!("{pattern}, {scope}, {within:?}"),
        pattern: match pattern.split(' ').next() {
            Some("absence") => Pattern::Absence(of('p')),
            Some("existence") => Pattern::Existence(of('p'), within),
            Some("universality") => Pattern::Universality(of('p')),
            Some("precedence") => Pattern::Precedence {
                first: of('s'),
                then: of('p'),
            },
            Some("response") => Pattern::Response {
                trigger: of('p'),
                answer: of('s'),
                within,
            },
            _ => panic!("{pattern} is no pattern"),
        },
        scope: match scope {
            "globally" => Scope::Globally,
            "before" => Scope::Before(of('r')),
            "after" => Scope::After(of('q')),
            "between" => Scope::Between(of('q'), of('r')),
            "until" => Scope::AfterUntil(of('q'), of('r')),
            _ => panic!("{scope} is no scope"),
        },
        names,
        meaning,
    }
}
