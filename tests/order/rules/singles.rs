//! All words of single skills up to a length: the supervisor's automaton, the regular expression
//! made of it, and the naive evaluator agree on every one.

use super::naive::{Letter, Naive};
use super::units::{
    DOWN, GRIP, LEFT, RELEASE, RIGHT, UP, after, any, at_most, before, loose_sequence, never_twice,
    only_after, pick_and_place_sequence, together, transport, trays, unit, unit_at, word,
};
use linewright::automata::bound::MAX_DFA_STATES;
use linewright::automata::dfa::{Dfa, REFUSED};
use linewright::automata::eliminate;
use linewright::automata::regex::{self, Regex};
use linewright::deadline::Deadline;
use linewright::order::fsm::Fsm;
use linewright::order::supervisor::Options;
use linewright::order::{Kind, Level, Serialisation, Skills};

/// Length up to which rules from the paper, and rules that refuse much, are enumerated.
const FULL: usize = 8;

/// Length for all other rules.
const SHORTER: usize = 7;

/// An automaton in the middle of a word; nothing follows a refused skill.
#[derive(Clone, Copy)]
struct Reader<'a> {
    dfa: &'a Dfa,
    state: u32,
}

impl<'a> Reader<'a> {
    fn new(dfa: &'a Dfa) -> Self {
        Self { dfa, state: 0 }
    }

    fn read(self, letter: usize) -> Self {
        let state = match self.state {
            REFUSED => REFUSED,
            state => self.dfa.next(state, letter),
        };
        Self { state, ..self }
    }

    fn goes_on(self) -> bool {
        self.state != REFUSED
    }

    fn may_end(self) -> bool {
        self.goes_on() && self.dfa.is_complete(self.state)
    }
}

/// The readers of a word.
#[derive(Clone, Copy)]
struct Readers<'a> {
    fsm: Reader<'a>,
    /// The regular expression of complete programs.
    whole: Reader<'a>,
    /// The regular expression of prefixes of programs.
    begun: Reader<'a>,
}

fn expressed(dfa: &Dfa) -> Dfa {
    let expression = eliminate::regex(dfa, Deadline::NONE).expect("it is short enough");
    let again =
        regex::automaton(&expression, dfa.letter_count(), MAX_DFA_STATES).expect("it is small");
    assert_eq!(again.difference(dfa), None, "{expression:?}");
    again
}

/// Enumerates all words up to the length; returns the number allowed.
fn agree(skills: &Skills, options: Options, length: usize) -> usize {
    let fsm = Fsm::of(skills, options, 1).expect("it is small");
    let dfa = fsm.one_by_one();
    let whole = expressed(&dfa);
    let begun = expressed(&dfa.clone().prefix_closed());
    let naive = Naive::new(skills, options);
    let readers = Readers {
        fsm: Reader::new(&dfa),
        whole: Reader::new(&whole),
        begun: Reader::new(&begun),
    };
    let allowed = below(&naive, readers, &mut Path::default(), length);
    assert!(allowed > 0, "nothing is allowed: {:?}", skills.rules);
    allowed
}

/// The calls so far, as a program and as their only possible order.
#[derive(Default)]
struct Path {
    program: Vec<u64>,
    word: Vec<Letter>,
}

fn below(naive: &Naive<'_>, readers: Readers<'_>, path: &mut Path, length: usize) -> usize {
    let may_end = naive.is_whole(&path.word);
    assert_eq!(readers.fsm.may_end(), may_end, "{:?}", path.program);
    assert_eq!(readers.whole.may_end(), may_end, "{:?}", path.program);
    let call = path.program.len();
    if call == length {
        return 0;
    }
    let mut count = 0;
    for skill in 0..readers.fsm.dfa.letter_count() {
        let mask = 1 << skill;
        path.program.push(mask);
        path.word.push(Letter { mask, call });
        let after = Readers {
            fsm: readers.fsm.read(skill),
            whole: readers.whole.read(skill),
            begun: readers.begun.read(skill),
        };
        let allowed = naive.keeps(&path.word) && naive.suits_components(&path.program);
        assert_eq!(after.fsm.goes_on(), allowed, "{:?}", path.program);
        assert_eq!(after.begun.goes_on(), allowed, "{:?}", path.program);
        assert!(allowed || !after.whole.goes_on(), "{:?}", path.program);
        if allowed {
            count += 1 + below(naive, after, path, length);
        }
        path.program.pop();
        path.word.pop();
    }
    count
}

fn valid(length: usize, kinds: impl IntoIterator<Item = Kind>) -> usize {
    agree(&unit(kinds), Options::default(), length)
}

#[test]
fn without_rules_everything_is_allowed() {
    assert_eq!(valid(SHORTER, []), (6_usize.pow(8) - 6) / 5);
}

#[test]
fn the_papers_unit() {
    valid(FULL, [trays()]);
    valid(FULL, [transport()]);
    valid(FULL, [trays(), transport()]);
}

#[test]
fn the_papers_unit_standing_elsewhere() {
    for initial in [[1, 1, 0], [0, 1, 1]] {
        let skills = unit_at(initial, [trays(), transport()]);
        agree(&skills, Options::default(), 7);
    }
}

#[test]
fn the_level_reasonable() {
    let mut skills = unit([trays(), transport(), before(any(&[GRIP]), any(&[LEFT]))]);
    skills.rules[1].level = Level::Reasonable;
    let reasonable = Options {
        level: Level::Reasonable,
        ..Options::default()
    };
    let allowed = agree(&skills, reasonable, FULL);
    assert!(allowed < agree(&skills, Options::default(), 7));
    let arbitrary = Options {
        level: Level::Arbitrary,
        ..Options::default()
    };
    agree(&skills, arbitrary, 5);
}

#[test]
fn never_and_windows() {
    valid(FULL, [Kind::Never(any(&[RELEASE, LEFT]))]);
    // A window that is never closed, and one that the same call closes and opens.
    valid(FULL, [after(any(&[GRIP]), Vec::new(), any(&[GRIP, RIGHT]))]);
    valid(
        FULL,
        [after(any(&[DOWN, UP]), any(&[UP, LEFT]), any(&[RIGHT, UP]))],
    );
}

#[test]
fn what_comes_first() {
    valid(
        SHORTER,
        [before(any(&[DOWN]), any(&[GRIP, RELEASE])), trays()],
    );
    valid(SHORTER, [before(any(&[GRIP, DOWN]), any(&[GRIP, RIGHT]))]);
    // Up has been called, Down has not.
    valid(
        SHORTER,
        [
            before(any(&[UP]), any(&[LEFT])),
            before(any(&[DOWN]), any(&[RIGHT])),
        ],
    );
}

#[test]
fn each_of_its_own() {
    valid(SHORTER, [only_after(any(&[GRIP]), any(&[DOWN]))]);
    valid(
        SHORTER,
        [
            only_after(any(&[RELEASE]), any(&[GRIP])),
            only_after(any(&[GRIP]), any(&[RELEASE])),
        ],
    );
    valid(
        SHORTER,
        [only_after(any(&[LEFT, DOWN]), any(&[RIGHT, DOWN, UP]))],
    );
}

#[test]
fn counted_calls() {
    valid(
        SHORTER,
        [at_most(2, any(&[GRIP]), any(&[DOWN]), any(&[UP]))],
    );
    valid(
        SHORTER,
        [at_most(3, any(&[LEFT, RIGHT]), Vec::new(), Vec::new())],
    );
    valid(
        SHORTER,
        [at_most(1, any(&[LEFT, UP]), any(&[UP]), any(&[UP, GRIP]))],
    );
    valid(
        SHORTER,
        [at_most(0, any(&[LEFT]), any(&[DOWN, UP]), any(&[UP]))],
    );
    valid(
        SHORTER,
        [at_most(1, any(&[GRIP]), Vec::new(), any(&[LEFT])), trays()],
    );
}

#[test]
fn in_a_row() {
    valid(SHORTER, [never_twice(&[LEFT, RIGHT, GRIP])]);
    valid(
        SHORTER,
        [Kind::InARow(vec![
            vec![any(&[LEFT]), any(&[RIGHT]), any(&[LEFT]), any(&[UP])],
            vec![any(&[RIGHT, UP]), any(&[LEFT, DOWN]), any(&[RIGHT])],
            vec![any(&[GRIP])],
        ])],
    );
}

#[test]
fn sequences() {
    valid(FULL, [Kind::Sequence(pick_and_place_sequence())]);
    valid(FULL, [Kind::Sequence(loose_sequence())]);
    let ends_up = word([
        super::units::repeat(Regex::AnyBut(Vec::new()), 0, None),
        Regex::Letter(DOWN),
        Regex::Letter(UP),
    ]);
    valid(FULL, [Kind::Sequence(ends_up), trays()]);
    // Two at a time: some words of each lead nowhere in the other.
    valid(
        FULL,
        [
            Kind::Sequence(loose_sequence()),
            Kind::Sequence(super::units::repeat(Regex::AnyBut(vec![DOWN]), 2, Some(7))),
        ],
    );
}

#[test]
fn all_kinds_together() {
    valid(
        FULL,
        [
            trays(),
            before(any(&[DOWN]), any(&[GRIP])),
            only_after(any(&[RELEASE]), any(&[GRIP])),
            at_most(2, any(&[LEFT]), any(&[UP]), any(&[DOWN])),
            never_twice(&[UP, DOWN]),
            Kind::Never(together(&[LEFT, DOWN])),
        ],
    );
}

#[test]
fn one_order_is_every_order_of_single_skills() {
    let some = Options {
        serialisation: Serialisation::Some,
        ..Options::default()
    };
    let kinds = [trays(), transport(), never_twice(&[GRIP])];
    agree(&unit(kinds), some, 7);
}
