//! Patterns and past operators in Linewright's language: each is lowered to the same monitors as by
//! the interface.
//!
//! Other tests check the meaning of those monitors on every lasso. Here only the positions of
//! operands, scopes and bounds can be wrong, so whole lists of formulas are compared.

use super::monitors_of;
use super::patterns::{Case, cases};
use linewright::contract;
use linewright::diagnostics::Severity;
use linewright::gr1::monitors::{Monitors, Origin, Pattern, Scope};
use linewright::gr1::{Expr, Side, Specification, VarId};

/// The specification of a contract with these boolean inputs and one formula.
fn read(names: &[char], formula: &str) -> Specification {
    let names: Vec<String> = names.iter().map(char::to_string).collect();
    let inputs = names.join(", ");
    let text = format!("contract Test {{\n    input {inputs}: bool\n    {formula}\n}}\n");
    let files = [("test.lw".to_owned(), text.clone())];
    let (library, findings) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    let mut errors = findings.iter().filter(|f| f.severity == Severity::Error);
    assert!(errors.next().is_none(), "{text}\n{findings:?}");
    (*library.contracts[0].specification).clone()
}

/// The formulas of a side without names and places.
fn said(side: &Side) -> [Vec<Expr>; 4] {
    [&side.initial, &side.invariants, &side.safety, &side.justice]
        .map(|list| list.iter().map(|f| f.expr.simplify()).collect())
}

fn letter(names: &[char], e: &Expr) -> char {
    match e {
        Expr::Var(id, _) => names[id.index()],
        other => panic!("{other:?} is no letter"),
    }
}

/// A pattern in a scope, as text.
fn written(case: &Case) -> String {
    let of = |e: &Expr| letter(&case.names, e);
    let steps = |n: &Option<u32>| n.map_or(String::new(), |n| format!(" within {n} steps"));
    let pattern = match &case.pattern {
        Pattern::Absence(p) => format!("never {}", of(p)),
        Pattern::Existence(p, n) => format!("eventually {}{}", of(p), steps(n)),
        Pattern::Universality(p) => format!("always {}", of(p)),
        Pattern::Precedence { first, then } => format!("{} precedes {}", of(first), of(then)),
        Pattern::Response {
            trigger,
            answer,
            within,
        } => format!(
            "{} responds to {}{}",
            of(answer),
            of(trigger),
            steps(within)
        ),
    };
    match &case.scope {
        Scope::Globally => pattern,
        Scope::Before(r) => format!("{pattern} before {}", of(r)),
        Scope::After(q) => format!("{pattern} after {}", of(q)),
        Scope::Between(q, r) => format!("{pattern} between {} and {}", of(q), of(r)),
        Scope::AfterUntil(q, r) => format!("{pattern} after {} until {}", of(q), of(r)),
    }
}

#[test]
fn patterns_are_read_as_they_are_written() {
    for case in cases(1..=3) {
        // `always p` is no pattern in the language, but the invariant itself.
        if (
            &case.scope,
            matches!(case.pattern, Pattern::Universality(_)),
        ) == (&Scope::Globally, true)
        {
            continue;
        }
        let text = written(&case);
        let (monitors, _) = monitors_of(&case);
        let mut again = Monitors::new(VarId(case.names.len() as u32), []);
        let obligations = again.pattern(&case.pattern, &case.scope, &Origin::default());
        let (mut plain, mut assumed) = (Side::default(), Side::default());
        for obligation in &obligations {
            obligation.add_to(&mut plain, &Origin::default());
            for part in again.as_assumptions(obligation) {
                part.add_to(&mut assumed, &Origin::default());
            }
        }
        let mut defined = Side::default();
        monitors.define(&mut defined);

        let specification = read(&case.names, &format!("assume {text}"));
        assert_eq!(
            said(&specification.assumptions),
            said(&assumed),
            "assume {text}"
        );
        assert_eq!(
            said(&specification.guarantees),
            said(&defined),
            "assume {text}"
        );

        let specification = read(&case.names, &format!("guarantee {text}"));
        monitors.define(&mut plain);
        assert_eq!(
            said(&specification.guarantees),
            said(&plain),
            "guarantee {text}"
        );
        let names = specification.variables.iter().map(|v| v.name.as_str());
        let own = monitors.all().iter().map(|m| m.variable.name.as_str());
        assert!(names.skip(case.names.len()).eq(own), "{text}");
    }
}

/// A response and a plain `eventually` in temporal logic are the same as the patterns.
#[test]
fn formulas_of_temporal_logic_are_patterns() {
    let pairs = [
        ("always (p -> eventually s)", "s responds to p"),
        ("G (p -> F s)", "s responds to p"),
        ("F p", "eventually p"),
        ("always not p", "never p"),
    ];
    for (logic, pattern) in pairs {
        let (a, b) = (
            read(&['p', 's'], &format!("guarantee {logic}")),
            read(&['p', 's'], &format!("guarantee {pattern}")),
        );
        assert_eq!(said(&a.guarantees), said(&b.guarantees), "{logic}");
    }
}

#[test]
fn past_operators_are_read_as_they_are_written() {
    type Make = fn(&mut Monitors, &Expr, &Expr) -> Expr;
    let table: [(&str, Make); 9] = [
        ("previous p", |m, p, _| m.previous(p, &Origin::default())),
        ("once p", |m, p, _| m.once(p, &Origin::default())),
        ("historically p", |m, p, _| {
            m.historically(p, &Origin::default())
        }),
        ("p since s", |m, p, s| m.since(p, s, &Origin::default())),
        ("s since p", |m, p, s| m.since(s, p, &Origin::default())),
        ("once p within 3 steps", |m, p, _| {
            m.once_within(p, 3, &Origin::default())
        }),
        ("historically p within 2 steps", |m, p, _| {
            m.historically_within(p, 2, &Origin::default())
        }),
        ("once (p and previous s)", |m, p, s| {
            let s = m.previous(s, &Origin::default());
            m.once(&p.clone().and(s), &Origin::default())
        }),
        ("(p since s) since p", |m, p, s| {
            let since = m.since(p, s, &Origin::default());
            m.since(&since, p, &Origin::default())
        }),
    ];
    for (text, make) in table {
        let mut monitors = Monitors::new(VarId(2), []);
        let (p, s) = (Expr::now(VarId(0)), Expr::now(VarId(1)));
        let value = make(&mut monitors, &p, &s);
        for (formula, next) in [
            (format!("always ({text})"), false),
            (format!("always (p -> next ({text}))"), true),
        ] {
            let specification = read(&['p', 's'], &format!("guarantee {formula}"));
            let mut side = Side::default();
            if next {
                let later = monitors.one_step_later(&value);
                let list = p.clone().implies(later);
                assert_eq!(
                    specification.guarantees.safety[0].expr.simplify(),
                    list.simplify(),
                    "{formula}"
                );
            } else {
                assert_eq!(
                    specification.guarantees.invariants[0].expr.simplify(),
                    value.simplify(),
                    "{formula}"
                );
            }
            monitors.define(&mut side);
            assert_eq!(
                said(&specification.guarantees)[0],
                said(&side)[0],
                "{formula}"
            );
        }
    }
}
