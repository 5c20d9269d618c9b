//! All sequences of calls of one skill or of two at once, up to a total number of skills: allowed
//! if every order of the pairs is, looked up one by one in a table of all words of single skills;
//! or if some is.

use super::naive::{Letter, Naive};
use super::units::{
    DOWN, GRIP, LEFT, RELEASE, RIGHT, UP, any, at_most, before, loose_sequence, never_twice,
    only_after, pick_and_place_sequence, transport, trays, unit,
};
use linewright::automata::dfa::REFUSED;
use linewright::order::fsm::Fsm;
use linewright::order::supervisor::Options;
use linewright::order::{Kind, Serialisation, Skills};

const SKILLS: usize = 6;

/// For all words of single skills, by length, whether they keep the rules. A word is a number whose
/// digits are its skills.
struct Words(Vec<Vec<bool>>);

impl Words {
    fn new(naive: &Naive<'_>, length: usize) -> Self {
        let sizes = (0..=length).map(|n| vec![false; SKILLS.pow(n as u32)]);
        let mut words = Self(sizes.collect());
        words.fill(naive, &mut Vec::new(), 0);
        words
    }

    fn fill(&mut self, naive: &Naive<'_>, word: &mut Vec<Letter>, number: usize) {
        // Continuations of a refused word are refused; that the naive evaluator agrees is not
        // tested.
        if !naive.keeps(word) {
            return;
        }
        let call = word.len();
        self.0[call][number] = true;
        if call + 1 == self.0.len() {
            return;
        }
        for skill in 0..SKILLS {
            let mask = 1 << skill;
            word.push(Letter { mask, call });
            self.fill(naive, word, number * SKILLS + skill);
            word.pop();
        }
    }
}

/// The sequential orders of what has been called, as numbers; the number of skills; and the state
/// of the automaton.
struct Called {
    orders: Vec<usize>,
    skills: usize,
    state: u32,
}

struct Compared {
    fsm: Fsm,
    words: Words,
    serialisation: Serialisation,
    /// Number of allowed sequences, and of refused ones with an allowed prefix.
    allowed: usize,
    refused: usize,
}

impl Compared {
    fn new(skills: &Skills, serialisation: Serialisation, length: usize) -> Self {
        let options = Options {
            serialisation,
            ..Options::default()
        };
        let naive = Naive::new(skills, options);
        let mut compared = Self {
            fsm: Fsm::of(skills, options, 2).expect("it is small"),
            words: Words::new(&naive, length),
            serialisation,
            allowed: 0,
            refused: 0,
        };
        assert_eq!(compared.fsm.calls.len(), 18);
        let start = Called {
            orders: vec![0],
            skills: 0,
            state: 0,
        };
        compared.below(&start, &mut Vec::new());
        compared
    }

    fn below(&mut self, before: &Called, program: &mut Vec<u64>) {
        for column in 0..self.fsm.calls.len() {
            let call = self.fsm.calls[column];
            let together: Vec<usize> = call.skills().collect();
            let count = before.skills + together.len();
            let Some(table) = self.words.0.get(count) else {
                continue;
            };
            let orders: Vec<usize> = match together.as_slice() {
                [one] => before.orders.iter().map(|o| o * SKILLS + one).collect(),
                [a, b] => before
                    .orders
                    .iter()
                    .flat_map(|o| [(a, b), (b, a)].map(|(a, b)| (o * SKILLS + a) * SKILLS + b))
                    .collect(),
                _ => panic!("two at most"),
            };
            let allowed = match self.serialisation {
                Serialisation::Every => orders.iter().all(|o| table[*o]),
                Serialisation::Some => orders.iter().any(|o| table[*o]),
            };
            program.push(call.0);
            let state = self.fsm.dfa.next(before.state, column);
            assert_eq!(state != REFUSED, allowed, "{program:?}");
            if allowed {
                self.allowed += 1;
                let called = Called {
                    orders,
                    skills: count,
                    state,
                };
                self.below(&called, program);
            } else {
                self.refused += 1;
            }
            program.pop();
        }
    }
}

/// Compares with every order, and with some order.
fn agree(kinds: impl IntoIterator<Item = Kind>, length: usize) {
    let skills = unit(kinds);
    let every = Compared::new(&skills, Serialisation::Every, length);
    let some = Compared::new(&skills, Serialisation::Some, length);
    assert!(every.refused > 0);
    assert!(every.allowed <= some.allowed);
}

#[test]
fn without_rules_everything_is_allowed() {
    let compared = Compared::new(&unit([]), Serialisation::Every, 7);
    // The last call is one of six skills or of twelve pairs: f(n) = 6 f(n - 1) + 12 f(n - 2).
    let mut counts = vec![1, 6];
    for n in 2..=7 {
        counts.push(6 * counts[n - 1] + 12 * counts[n - 2]);
    }
    assert_eq!(compared.allowed, counts[1..].iter().sum::<usize>());
    assert_eq!(compared.refused, 0);
}

#[test]
fn the_papers_unit() {
    agree([trays(), transport()], 8);
}

#[test]
fn one_rule_of_the_papers_unit() {
    agree([trays()], 7);
    agree([transport()], 7);
}

#[test]
fn what_comes_first_and_how_often() {
    agree(
        [
            before(any(&[DOWN]), any(&[GRIP])),
            only_after(any(&[RELEASE]), any(&[GRIP])),
            at_most(2, any(&[LEFT, RIGHT]), any(&[UP]), any(&[DOWN])),
        ],
        7,
    );
}

#[test]
fn in_a_row() {
    agree(
        [
            never_twice(&[LEFT, GRIP]),
            Kind::InARow(vec![vec![any(&[RIGHT, UP]), any(&[DOWN]), any(&[RIGHT])]]),
        ],
        7,
    );
}

#[test]
fn sequences() {
    agree([Kind::Sequence(loose_sequence())], 8);
    agree([Kind::Sequence(pick_and_place_sequence())], 8);
}
