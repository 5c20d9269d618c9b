//! Patterns end to end: as guarantees of machines that are then played, and as assumptions.

use super::logic;
use super::patterns::{Case, cases};
use super::words::{Lanes, Lassos, every_lasso};
use linewright::game::{Limits, Outcome, solve};
use linewright::gr1::monitors::{Monitors, Obligation, Origin, Pattern, Scope};
use linewright::gr1::{
    Domain, Expr, Formula, FormulaKind, Owner, Side, Specification, Timing, VarId, Variable,
};
use linewright::mealy::{Machine, extract::extract, verify::verify};
use linewright::source::Span;

fn specification(
    names: &[String],
    timing: Timing,
    output: &dyn Fn(usize) -> bool,
) -> Specification {
    let variable = |(i, name): (usize, &String)| Variable {
        name: name.clone(),
        owner: if output(i) {
            Owner::System
        } else {
            Owner::Environment
        },
        internal: false,
        unit: String::new(),
        domain: Domain::Bool,
        span: Span::default(),
    };
    Specification {
        name: "Pattern".to_owned(),
        timing,
        variables: names.iter().enumerate().map(variable).collect(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    }
}

fn add_obligations(obligations: &[Obligation], side: &mut Side) {
    for obligation in obligations {
        obligation.add_to(side, &Origin::default());
    }
}

/// The machine, verified, or `None` if there is none.
fn machine_of(specification: &Specification) -> Option<Machine> {
    let limits = Limits::default();
    let won = match solve(specification, &limits) {
        Outcome::Realizable(won) => won,
        Outcome::Unrealizable(_) => return None,
        Outcome::GaveUp(limit) => panic!("gave up without a limit: {limit}"),
    };
    let machine = extract(specification, &won, &limits).expect("no limit");
    let verdict = verify(specification, &machine, &limits).expect("no limit");
    assert_eq!(verdict, Ok(()), "{specification:#?}");
    Some(machine)
}

/// The letters of a play of the machine on a lasso of inputs, up to its repetition. `owner[v]` says
/// that variable `v` is an output.
fn play(machine: &Machine, inputs: &[Vec<i64>], back: usize, outputs: &[bool]) -> Lassos {
    let lanes = |x: i64| if x == 1 { Lanes::ALL } else { Lanes::NONE };
    let mut letters = Vec::new();
    let mut heads: Vec<(Option<usize>, usize)> = Vec::new();
    let (mut state, mut position) = (None, 0);
    loop {
        if position == back {
            if let Some((_, step)) = heads.iter().find(|(s, _)| *s == state) {
                return Lassos {
                    letters,
                    back: *step,
                };
            }
            heads.push((state, letters.len()));
        }
        let step = machine
            .step(state, &inputs[position])
            .expect("no input is illegal");
        let (mut given, mut answered) = (inputs[position].iter(), step.output.iter());
        let letter = outputs.iter().map(|output| {
            let from = if *output { &mut answered } else { &mut given };
            lanes(*from.next().expect("a value for each variable"))
        });
        letters.push(letter.collect());
        state = Some(step.to);
        position += 1;
        if position == inputs.len() {
            position = back;
        }
    }
}

/// Which side can keep a pattern globally, given the owners of its letters.
fn expected(case: &Case, outputs: &[bool]) -> Option<bool> {
    let controls = |e: &Expr| matches!(e, Expr::Var(v, _) if outputs[v.index()]);
    match (&case.scope, &case.pattern) {
        _ if outputs.iter().all(|o| *o) => Some(true),
        _ if outputs.iter().all(|o| !o) => Some(false),
        (
            Scope::Globally,
            Pattern::Precedence { first: a, then: b }
            | Pattern::Response {
                answer: a,
                trigger: b,
                ..
            },
        ) => Some(controls(a) || controls(b)),
        _ => None,
    }
}

/// Adds that every letter holds again and again: an assumption for an input, a guarantee for an
/// output.
fn enliven(specification: &mut Specification, outputs: &[bool]) {
    for (v, output) in outputs.iter().enumerate() {
        let often = Obligation {
            kind: FormulaKind::Justice,
            expr: Expr::now(VarId(v as u32)),
        };
        let side = if *output {
            &mut specification.guarantees
        } else {
            &mut specification.assumptions
        };
        add_obligations(&[often], side);
    }
}

/// With all divisions of the letters into inputs and outputs; once as they are, where a side may
/// win by never opening a scope, and once with every letter recurring.
#[test]
fn machines_keep_the_patterns_they_guarantee() {
    let (mut realizable, mut unrealizable, mut plays) = ([0, 0], [0, 0], [0, 0]);
    for case in cases(2..=2) {
        let count = case.names.len();
        let names: Vec<String> = case.names.iter().map(char::to_string).collect();
        let meaning = logic::read(&case.meaning, &case.names);
        for choice in 0..4_u32 << count {
            let (lively, moore) = (choice & 1 == 1, choice & 2 == 2);
            let timing = if moore { Timing::Moore } else { Timing::Mealy };
            let outputs: Vec<bool> = (0..count).map(|v| choice >> (v + 2) & 1 == 1).collect();
            let mut specification = specification(&names, timing, &|v| outputs[v]);
            let mut monitors = Monitors::new(VarId(count as u32), names.clone());
            let obligations = monitors.pattern(&case.pattern, &case.scope, &Origin::default());
            monitors.add_to(&mut specification);
            add_obligations(&obligations, &mut specification.guarantees);
            if lively {
                enliven(&mut specification, &outputs);
            }
            let machine = machine_of(&specification);
            if let Some(expected) = expected(&case, &outputs).filter(|_| !lively) {
                assert_eq!(machine.is_some(), expected, "{} {outputs:?}", case.name);
            }
            let Some(machine) = machine else {
                unrealizable[usize::from(lively)] += 1;
                continue;
            };
            realizable[usize::from(lively)] += 1;
            let inputs = outputs.iter().filter(|o| !**o).count();
            let longest = [1, 4, 3, 2, 2][inputs];
            every_lasso(inputs, longest, &mut |lassos| {
                let length = lassos.letters.len();
                for lane in 0..1 << (inputs * length) {
                    let letters = lassos.letters.iter();
                    let letters: Vec<Vec<i64>> = letters
                        .map(|l| l.iter().map(|v| i64::from(v.at(lane))).collect())
                        .collect();
                    let cycle = &letters[lassos.back..];
                    let fair = (0..inputs).all(|v| cycle.iter().any(|l| l[v] == 1));
                    if lively && !fair {
                        continue;
                    }
                    let run = play(&machine, &letters, lassos.back, &outputs);
                    plays[usize::from(lively)] += 1;
                    let shown = || {
                        let lasso = run.show(0, &case.names);
                        format!("{} with outputs {outputs:?}: {lasso}", case.name)
                    };
                    assert!(meaning.on(&run)[0] == Lanes::ALL, "{}", shown());
                    let cycle = &run.letters[run.back..];
                    let all = (0..count).all(|v| cycle.iter().any(|l| l[v] == Lanes::ALL));
                    assert!(!lively || all, "{}", shown());
                }
            });
        }
    }
    println!("{realizable:?} machines, {unrealizable:?} unrealizable, {plays:?} plays");
    assert!(realizable.iter().all(|n| *n > 150) && unrealizable.iter().all(|n| *n > 50));
    assert!(plays.iter().all(|n| *n > 2_000));
}

/// An assumption about the inputs can be guaranteed for their copies (or, if the machine answers
/// first, for the inputs themselves), but not without the assumption.
#[test]
fn machines_can_rely_on_the_patterns_they_assume() {
    for case in cases(1..=2) {
        let count = case.names.len();
        for timing in [Timing::Mealy, Timing::Moore] {
            let mut names: Vec<String> = case.names.iter().map(char::to_string).collect();
            let copies = timing == Timing::Mealy;
            if copies {
                names.extend(case.names.iter().map(|n| format!("copy_of_{n}")));
            }
            let shift = if copies { count as u32 } else { 0 };
            let mut monitors = Monitors::new(VarId(names.len() as u32), names.clone());
            let origin = Origin::default();
            let promised = monitors.pattern(&case.pattern, &case.scope, &origin);
            let (pattern, scope) = shifted(&case, shift);
            let owed = monitors.pattern(&pattern, &scope, &origin);
            let mut specification = specification(&names, timing, &|v| v >= count);
            for v in 0..shift {
                let copy = Expr::now(VarId(v + shift)).equals(Expr::now(VarId(v)));
                specification.guarantees.invariants.push(Formula {
                    defines: false,
                    name: "copy".to_owned(),
                    requirement: None,
                    expr: copy,
                    span: Span::default(),
                    text: String::new(),
                });
            }
            monitors.add_to(&mut specification);
            add_obligations(&owed, &mut specification.guarantees);
            assert!(machine_of(&specification).is_none(), "{}", case.name);
            for obligation in promised {
                add_obligations(
                    &monitors.as_assumptions(&obligation),
                    &mut specification.assumptions,
                );
            }
            assert!(machine_of(&specification).is_some(), "{}", case.name);
        }
    }
}

/// The pattern with variables shifted by `shift`.
fn shifted(case: &Case, shift: u32) -> (Pattern, Scope) {
    let of = |e: &Expr| e.substitute(&mut |v, time| Expr::Var(VarId(v.0 + shift), time));
    let pattern = match &case.pattern {
        Pattern::Absence(p) => Pattern::Absence(of(p)),
        Pattern::Existence(p, within) => Pattern::Existence(of(p), *within),
        Pattern::Universality(p) => Pattern::Universality(of(p)),
        Pattern::Precedence { first, then } => Pattern::Precedence {
            first: of(first),
            then: of(then),
        },
        Pattern::Response {
            trigger,
            answer,
            within,
        } => Pattern::Response {
            trigger: of(trigger),
            answer: of(answer),
            within: *within,
        },
    };
    let scope = match &case.scope {
        Scope::Globally => Scope::Globally,
        Scope::Before(r) => Scope::Before(of(r)),
        Scope::After(q) => Scope::After(of(q)),
        Scope::Between(q, r) => Scope::Between(of(q), of(r)),
        Scope::AfterUntil(q, r) => Scope::AfterUntil(of(q), of(r)),
    };
    (pattern, scope)
}
