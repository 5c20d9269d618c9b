//! Random programs over random rules: the first refusal, possible continuations, possible endings,
//! and differences between two sets of rules.

use super::naive::Naive;
use super::random::{Size, options, program, skills, two_sets};
use super::units::{LEFT, RIGHT, unit, word};
use linewright::automata::regex::Regex;
use linewright::order::program::{Difference, DifferenceOptions, check, difference};
use linewright::order::supervisor::{Call, Options, Refusal, Supervisor};
use linewright::order::{Kind, Serialisation, Skills, fsm};
use proptest::prelude::*;

const SIZE: Size = Size {
    components: 3,
    skills: 2,
    rules: 2,
    at_once: 2,
    sequences: 4,
};

/// Only sequences determine which programs may end.
const SEQUENCES: Size = Size {
    sequences: 16,
    ..SIZE
};

/// Maximum length of ways that are tried one by one.
const LONGEST: usize = 4;

fn calls(masks: &[u64]) -> Vec<Call> {
    masks.iter().map(|mask| Call(*mask)).collect()
}

fn masks(calls: &[Call]) -> Vec<u64> {
    calls.iter().map(|call| call.0).collect()
}

/// The length of the shortest allowed way of single skills after a program, up to a limit, after
/// which something holds.
fn shortest_way(
    naive: &Naive<'_>,
    skills: usize,
    program: &[u64],
    most: usize,
    holds: impl Fn(&[u64]) -> bool,
) -> Option<usize> {
    let mut ways = vec![program.to_vec()];
    for length in 0..=most {
        if ways.iter().any(|way| holds(way)) {
            return Some(length);
        }
        let longer = ways
            .iter()
            .flat_map(|way| (0..skills).map(|skill| [way.as_slice(), &[1 << skill]].concat()));
        ways = longer.filter(|way| naive.allows(way)).collect();
    }
    None
}

/// A way that was found is allowed, has the required effect, and none of those tried is shorter.
fn is_shortest(
    naive: &Naive<'_>,
    skills: usize,
    program: &[u64],
    found: Option<&[Call]>,
    holds: impl Fn(&[u64]) -> bool,
) {
    let most = found.map_or(LONGEST, <[Call]>::len).min(LONGEST);
    let shortest = shortest_way(naive, skills, program, most, &holds);
    match found {
        None => assert_eq!(shortest, None, "there is a way: {program:?}"),
        Some(way) => {
            let whole = [program, &masks(way)].concat();
            assert!(naive.allows(&whole), "{program:?} {way:?}");
            assert!(holds(&whole), "{program:?} {way:?}");
            if way.len() <= LONGEST {
                assert_eq!(shortest, Some(way.len()), "{program:?} {way:?}");
            } else {
                assert_eq!(shortest, None, "{program:?} {way:?}");
            }
        }
    }
}

/// The length of the shortest sequence of calls that distinguishes two sets of rules, up to a
/// limit, by trying all that both allow.
fn shortest_difference(
    naive: [&Naive<'_>; 2],
    columns: &[u64],
    most: usize,
    apart: DifferenceOptions,
) -> Option<usize> {
    let differ = |[first, second]: [bool; 2]| first != second && (first || !apart.one_way);
    let mut both: Vec<Vec<u64>> = vec![Vec::new()];
    for length in 0..=most {
        if apart.whole && both.iter().any(|p| differ(naive.map(|n| n.may_end(p)))) {
            return Some(length);
        }
        let mut longer = Vec::new();
        for program in &both {
            for call in columns {
                let program = [program.as_slice(), &[*call]].concat();
                let allow = naive.map(|n| n.allows(&program));
                if differ(allow) {
                    return (length < most).then_some(length + 1);
                }
                if allow == [true, true] {
                    longer.push(program);
                }
            }
        }
        both = longer;
    }
    None
}

/// A difference is correct: both allow it up to the last call, and then only the stated one.
fn tells_apart(naive: [&Naive<'_>; 2], found: &Difference, apart: DifferenceOptions) {
    let program = masks(&found.calls);
    let both = |program: &[u64]| naive.map(|n| n.allows(program));
    let first = found.first_allows;
    assert!(first || !apart.one_way);
    if found.refusal.is_some() {
        let (_, before) = program.split_last().expect("a call is refused");
        assert_eq!(both(before), [true, true]);
        assert_eq!(both(&program), [first, !first]);
    } else {
        assert_eq!(both(&program), [true, true]);
        assert_eq!(naive.map(|n| n.may_end(&program)), [first, !first]);
    }
}

/// Skills with rules, and a program for them.
fn with_program() -> impl Strategy<Value = (Skills, Vec<u64>)> {
    let skills = prop_oneof![3 => skills(SIZE), 1 => skills(SEQUENCES)];
    skills.prop_flat_map(|skills| {
        let program = program(&skills, 3, 1..=4);
        (Just(skills), program)
    })
}

fn supervisor(skills: &Skills, options: Options) -> Supervisor<'_> {
    Supervisor::new(skills, options).expect("it is small")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn the_first_violation_and_the_way_on((skills, program) in with_program(), options in options()) {
        let naive = Naive::new(&skills, options);
        let checked = check(&mut supervisor(&skills, options), &calls(&program));
        let checked = checked.expect("it is small");
        let allowed = naive.allowed(&program);
        prop_assert_eq!(checked.allowed, allowed);
        let before = &program[..allowed];
        let count = skills.skills.len();
        let Some(violation) = checked.violation else {
            prop_assert_eq!(allowed, program.len());
            let complete = naive.may_end(&program);
            prop_assert_eq!(checked.unfinished, naive.unfinished(&program));
            let completion = checked.completion.as_ref().expect("it is small").as_deref();
            if complete {
                prop_assert_eq!(completion, None);
            } else {
                is_shortest(&naive, count, &program, completion, |way| naive.may_end(way));
            }
            return Ok(());
        };
        prop_assert_eq!(violation.step, allowed);
        prop_assert_eq!(violation.call.0, program[allowed]);
        is_shortest(&naive, count, before, violation.detour.as_ref().expect("it is small").as_deref(), |way| {
            naive.allows(&[way, &[violation.call.0]].concat())
        });
        let at_once = violation.call.skills().count();
        for call in fsm::calls(&skills, at_once) {
            let allowed = naive.allows(&[before, &[call.0]].concat());
            prop_assert_eq!(violation.instead.contains(&call), allowed);
        }
    }

    #[test]
    fn what_is_refused_is_blamed_on_what_refuses_it(
        (skills, program) in with_program(),
        options in options(),
    ) {
        let checked = check(&mut supervisor(&skills, options), &calls(&program));
        let checked = checked.expect("it is small");
        let Some(violation) = checked.violation else {
            return Ok(());
        };
        let call = violation.call;
        match violation.refusal {
            Refusal::SameComponent { component, skills: two } => {
                prop_assert!(two[0] != two[1]);
                for skill in two {
                    prop_assert_eq!(skills.skills[skill].component, component);
                    prop_assert!(call.skills().any(|s| s == skill));
                }
            }
            Refusal::Recall { skill } => {
                let skill = &skills.skills[skill];
                let stands = checked.state.situation[skill.component];
                prop_assert_eq!(skill.effect, Some(stands));
            }
            Refusal::Rule { rule, .. } => {
                // With every order, the rule alone refuses the program there.
                let alone = Skills { rules: vec![skills.rules[rule].clone()], ..skills.clone() };
                if options.serialisation == Serialisation::Every {
                    let naive = Naive::new(&alone, options);
                    prop_assert_eq!(naive.allowed(&program), violation.step);
                }
            }
            Refusal::Deleted { .. } => prop_assert!(false, "nothing is deleted"),
        }
    }
}

/// After `Left` only a call distinguishes them, after `Right` the fact that a program may end.
#[test]
fn an_end_is_found_before_a_longer_difference() {
    let one = |skill| Regex::Letter(skill);
    let twice = |skill| word([one(skill), one(skill)]);
    let sequence = |parts: Vec<Regex>| unit([Kind::Sequence(Regex::Either(parts))]);
    let first = sequence(vec![one(LEFT), twice(LEFT), twice(RIGHT)]);
    let second = sequence(vec![one(LEFT), one(RIGHT), twice(RIGHT)]);
    let columns = fsm::calls(&first, 1);
    let options = Options::default();
    let found = difference(
        &supervisor(&first, options),
        &supervisor(&second, options),
        &columns,
        DifferenceOptions {
            whole: true,
            ..DifferenceOptions::default()
        },
    );
    let expected = Difference {
        calls: vec![Call::one(RIGHT)],
        first_allows: false,
        refusal: None,
    };
    assert_eq!(found, Ok(Some(expected)));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn a_difference_is_a_shortest_one(
        (one, other) in prop_oneof![two_sets(SIZE), two_sets(SEQUENCES)],
        options in options(),
        (whole, one_way) in any::<(bool, bool)>(),
    ) {
        let apart = DifferenceOptions { whole, one_way, ..DifferenceOptions::default() };
        let columns = fsm::calls(&one, 2);
        let found = difference(
            &supervisor(&one, options),
            &supervisor(&other, options),
            &columns,
            apart,
        );
        let found = found.expect("it is small");
        let naive = [&Naive::new(&one, options), &Naive::new(&other, options)];
        // All sequences of up to three calls of two skills, or four, would be too many.
        let longest = if columns.len() > 8 { 2 } else { 3 };
        let most = found.as_ref().map_or(longest, |d| d.calls.len()).min(longest);
        let shortest = shortest_difference(naive, &masks(&columns), most, apart);
        if let Some(found) = &found {
            tells_apart(naive, found, apart);
        }
        // A longer one cannot be compared with all sequences.
        let length = found.map(|d| d.calls.len());
        prop_assert_eq!(shortest, length.filter(|l| *l <= longest));
    }
}
