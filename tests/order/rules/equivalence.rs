//! Random rules: the automaton and its regular expression have the same words, which are those that
//! the rules mean; minimizing an automaton keeps its words.

use super::naive::{Letter, Naive};
use super::random::{Size, options, skills, two_sets};
use super::units::{any, at_most, unit};
use linewright::automata::bound::{BoundExceeded, MAX_DFA_STATES};
use linewright::automata::dfa::{Dfa, REFUSED};
use linewright::automata::{eliminate, regex};
use linewright::deadline::Deadline;
use linewright::order::fsm::Fsm;
use linewright::order::supervisor::Options;
use proptest::prelude::{ProptestConfig, prop_assert, prop_assert_eq, proptest};

const SIZE: Size = Size {
    components: 3,
    skills: 2,
    rules: 3,
    at_once: 3,
    sequences: 4,
};

/// Number of skills called one after the other.
const LENGTH: usize = 5;

/// Length of the words that are all compared.
const SHORT: usize = 4;

/// The automaton of the expression made of an automaton; `None` if that would be too long.
fn expressed(dfa: &Dfa) -> Option<Dfa> {
    let expression = eliminate::regex(dfa, Deadline::NONE).ok()?;
    Some(
        regex::automaton(&expression, dfa.letter_count(), MAX_DFA_STATES)
            .expect("it was small before"),
    )
}

/// Calls `seen` with every word up to a length that the automaton accepts, the state after it, and
/// the skill that it refuses there, if any.
fn each_word(
    dfa: &Dfa,
    state: u32,
    word: &mut Vec<usize>,
    left: usize,
    seen: &mut impl FnMut(&[usize], Result<u32, usize>),
) {
    seen(word, Ok(state));
    for letter in 0..dfa.letter_count() {
        if left == 0 {
            return;
        }
        match dfa.next(state, letter) {
            REFUSED => seen(word, Err(letter)),
            to => {
                word.push(letter);
                each_word(dfa, to, word, left - 1, seen);
                word.pop();
            }
        }
    }
}

fn accepts(dfa: &Dfa, word: &[usize]) -> bool {
    dfa.run(word).is_some_and(|state| dfa.is_complete(state))
}

/// Every pair of states is distinguished by some word: refused after one, or ending there, but not
/// after the other.
fn is_smallest(dfa: &Dfa) -> bool {
    let states = dfa.state_count() as u32;
    let number = |a: u32, b: u32| (a * states + b) as usize;
    let mut apart = vec![false; (states * states) as usize];
    let mut grown = true;
    while grown {
        grown = false;
        for (a, b) in (0..states).flat_map(|a| (0..states).map(move |b| (a, b))) {
            let by_letter = |letter| match (dfa.next(a, letter), dfa.next(b, letter)) {
                (REFUSED, REFUSED) => false,
                (REFUSED, _) | (_, REFUSED) => true,
                (a, b) => apart[number(a, b)],
            };
            let are =
                dfa.is_complete(a) != dfa.is_complete(b) || (0..dfa.letter_count()).any(by_letter);
            if are && !apart[number(a, b)] {
                apart[number(a, b)] = true;
                grown = true;
            }
        }
    }
    (0..states).all(|a| (0..states).all(|b| a == b || apart[number(a, b)]))
}

/// Six counters, with 4096 states in total: an answer comes at once.
#[test]
fn what_is_too_large_for_an_expression_is_refused() {
    let counter = |skill| at_most(3, any(&[skill]), Vec::new(), Vec::new());
    let skills = unit((0..6).map(counter));
    let dfa = Fsm::of(&skills, Options::default(), 1).expect("it is small");
    let refused = eliminate::regex(&dfa.one_by_one(), Deadline::NONE).expect_err("it is too large");
    let limit = eliminate::MAX_ELIMINATED_STATES;
    assert!(matches!(refused, BoundExceeded::Count { limit: at, .. } if at == limit));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn words_are_those_that_the_rules_mean(skills in skills(SIZE), options in options()) {
        let dfa = Fsm::of(&skills, options, 1).expect("it is small").one_by_one();
        let naive = Naive::new(&skills, options);
        let letters = |word: &[usize]| -> Vec<Letter> {
            let word = word.iter().enumerate();
            word.map(|(call, skill)| Letter { mask: 1 << skill, call }).collect()
        };
        let allows = |word: &[usize]| {
            let program: Vec<u64> = word.iter().map(|s| 1 << s).collect();
            naive.keeps(&letters(word)) && naive.suits_components(&program)
        };
        each_word(&dfa, 0, &mut Vec::new(), LENGTH, &mut |word, after| match after {
            Ok(state) => {
                assert!(allows(word), "{word:?}");
                assert_eq!(dfa.is_complete(state), naive.is_whole(&letters(word)), "{word:?}");
            }
            Err(refused) => assert!(!allows(&[word, &[refused]].concat()), "{word:?} {refused}"),
        });
    }

    #[test]
    fn an_expression_has_the_words_of_its_automaton(skills in skills(SIZE), options in options()) {
        let dfa = Fsm::of(&skills, options, 1).expect("it is small").one_by_one();
        for dfa in [dfa.clone(), dfa.prefix_closed()] {
            if let Some(again) = expressed(&dfa) {
                prop_assert_eq!(again.difference(&dfa), None);
                // The product is not the only evidence.
                each_word(&dfa, 0, &mut Vec::new(), LENGTH, &mut |word, after| match after {
                    Ok(state) => {
                        assert_eq!(dfa.is_complete(state), accepts(&again, word), "{word:?}");
                    }
                    Err(refused) => {
                        let word = [word, &[refused]].concat();
                        assert!(again.run(&word).is_none(), "{word:?}");
                    }
                });
            }
        }
    }

    #[test]
    fn smaller_automata_have_the_same_words(skills in skills(SIZE), options in options()) {
        let dfa = Fsm::of(&skills, options, 1).expect("it is small").one_by_one();
        let (minimal, trimmed) = (dfa.minimal(), dfa.clone().trimmed());
        prop_assert!(minimal.state_count() <= dfa.state_count());
        prop_assert!(is_smallest(&minimal));
        prop_assert_eq!(minimal.difference(&dfa), None);
        let lean = Fsm::of_language(&skills, options, 2).expect("it is smaller");
        let whole = Fsm::of(&skills, options, 2).expect("it is small");
        prop_assert!(lean.states.len() <= whole.states.len());
        prop_assert_eq!(lean.dfa.difference(&whole.dfa), None);
        prop_assert_eq!(lean.dfa.prefix_closed().difference(&whole.dfa.prefix_closed()), None);
        prop_assert_eq!(trimmed.difference(&dfa), None);
        each_word(&dfa, 0, &mut Vec::new(), LENGTH, &mut |word, after| match after {
            Ok(state) => {
                assert!(minimal.run(word).is_some(), "{word:?}");
                let whole = dfa.is_complete(state);
                assert_eq!(accepts(&minimal, word), whole, "{word:?}");
                assert_eq!(accepts(&trimmed, word), whole, "{word:?}");
            }
            Err(refused) => {
                let word = [word, &[refused]].concat();
                assert!(minimal.run(&word).is_none(), "{word:?}");
                assert!(trimmed.run(&word).is_none(), "{word:?}");
            }
        });
        // The rest can be completed from everywhere; only the start is always kept.
        for state in 1..trimmed.state_count() as u32 {
            let successors = |state: &u32| -> Vec<((), u32)> {
                let all = (0..trimmed.letter_count()).map(|l| trimmed.next(*state, l));
                all.filter(|to| *to != REFUSED).map(|to| ((), to)).collect()
            };
            let whole = |state: &u32| trimmed.is_complete(*state);
            prop_assert!(linewright::automata::search::shortest(state, successors, whole).is_some());
        }
    }

    #[test]
    fn automata_differ_in_the_first_word_that_tells_them_apart(
        (one, other) in two_sets(SIZE),
        options in options(),
    ) {
        let [one, other] = [one, other].map(|skills| {
            Fsm::of(&skills, options, 1).expect("it is small").one_by_one()
        });
        let found = one.difference(&other);
        prop_assert_eq!(&other.difference(&one), &found);
        let length = found.as_ref().map_or(SHORT, Vec::len).min(SHORT);
        let mut words = vec![Vec::new()];
        let mut first = None;
        for _ in 0..=length {
            first = words.iter().find(|w| accepts(&one, w) != accepts(&other, w)).cloned();
            if first.is_some() {
                break;
            }
            let longer = |word: &Vec<usize>| {
                let word = word.clone();
                (0..one.letter_count()).map(move |l| [word.as_slice(), &[l]].concat())
            };
            words = words.iter().flat_map(longer).collect();
        }
        prop_assert_eq!(first, found.filter(|word| word.len() <= SHORT));
    }
}
