//! Events of several skills, `Left & Down`, wherever a rule can mention them, on all short
//! sequences of calls of one skill or of two at once; and calls of three skills at once.

use super::naive::Naive;
use super::units::{
    DOWN, GRIP, LEFT, RELEASE, RIGHT, UP, after, any, at_most, before, loose_sequence, never_twice,
    only_after, pick_and_place, together, transport, trays, unit, unit_at,
};
use linewright::automata::dfa::REFUSED;
use linewright::order::fsm::Fsm;
use linewright::order::supervisor::Options;
use linewright::order::{Event, Kind, Level, Serialisation, Skills};
use proptest::prelude::*;

/// Total number of skills called.
const LENGTH: usize = 5;

const BOTH: [Serialisation; 2] = [Serialisation::Every, Serialisation::Some];

struct Compared<'a> {
    fsm: Fsm,
    naive: Naive<'a>,
    refused: usize,
}

impl Compared<'_> {
    fn below(&mut self, state: u32, program: &mut Vec<u64>, left: usize) {
        assert_eq!(
            self.fsm.dfa.is_complete(state),
            self.naive.may_end(program),
            "{program:?}"
        );
        for column in 0..self.fsm.calls.len() {
            let call = self.fsm.calls[column];
            let Some(left) = left.checked_sub(call.skills().count()) else {
                continue;
            };
            program.push(call.0);
            let to = self.fsm.dfa.next(state, column);
            let allowed = self.naive.allows(program);
            assert_eq!(to != REFUSED, allowed, "{program:?}");
            if allowed {
                self.below(to, program, left);
            } else {
                self.refused += 1;
            }
            program.pop();
        }
    }
}

fn agree_on(skills: &Skills) {
    agree_at(skills, Level::Valid, false);
}

fn agree_at(skills: &Skills, level: Level, paper: bool) {
    for serialisation in BOTH {
        let options = Options {
            level,
            serialisation,
            paper,
            ..Options::default()
        };
        let mut compared = Compared {
            fsm: Fsm::of(skills, options, 2).expect("it is small"),
            naive: Naive::new(skills, options),
            refused: 0,
        };
        compared.below(0, &mut Vec::new(), LENGTH);
        // Some order may always avoid what all together do not.
        let is_some = serialisation == Serialisation::Some;
        assert!(is_some || compared.refused > 0, "{:?}", skills.rules);
    }
}

fn agree(kinds: impl IntoIterator<Item = Kind>) {
    agree_on(&unit(kinds));
}

/// Either of two lists of events.
fn or(one: Vec<Event>, other: Vec<Event>) -> Vec<Event> {
    [one, other].concat()
}

#[test]
fn never_at_once() {
    agree([Kind::Never(together(&[LEFT, DOWN]))]);
    agree([
        Kind::Never(or(together(&[UP, RELEASE]), any(&[GRIP]))),
        trays(),
    ]);
}

#[test]
fn windows_begun_ended_and_filled_at_once() {
    agree([after(together(&[LEFT, DOWN]), any(&[UP]), any(&[GRIP]))]);
    agree([after(
        any(&[DOWN]),
        together(&[LEFT, UP]),
        any(&[GRIP, LEFT]),
    )]);
    agree([after(any(&[DOWN]), any(&[UP]), together(&[RIGHT, GRIP]))]);
    agree([after(
        together(&[LEFT, DOWN]),
        any(&[LEFT]),
        any(&[RELEASE]),
    )]);
    agree([after(
        any(&[RIGHT]),
        together(&[RIGHT, DOWN]),
        or(together(&[RIGHT, DOWN]), any(&[UP])),
    )]);
}

#[test]
fn first_and_of_its_own_at_once() {
    agree([before(together(&[LEFT, DOWN]), any(&[GRIP]))]);
    agree([before(any(&[RIGHT]), together(&[RIGHT, DOWN]))]);
    agree([only_after(any(&[GRIP]), together(&[RIGHT, DOWN]))]);
    agree([only_after(together(&[RIGHT, DOWN]), any(&[GRIP, DOWN]))]);
}

#[test]
fn counted_at_once() {
    agree([at_most(
        1,
        together(&[LEFT, DOWN]),
        any(&[UP]),
        any(&[GRIP]),
    )]);
    agree([at_most(
        1,
        any(&[LEFT]),
        together(&[LEFT, DOWN]),
        together(&[LEFT, UP]),
    )]);
    let two = or(together(&[LEFT, GRIP]), any(&[LEFT]));
    agree([at_most(2, two, Vec::new(), together(&[LEFT, DOWN]))]);
}

#[test]
fn at_once_twice_in_a_row() {
    agree([Kind::InARow(vec![vec![together(&[LEFT, DOWN]); 2]])]);
}

#[test]
fn at_once_before_and_behind_single_skills_in_a_row() {
    agree([Kind::InARow(vec![vec![
        together(&[LEFT, DOWN]),
        any(&[GRIP]),
    ]])]);
    agree([Kind::InARow(vec![vec![
        any(&[GRIP]),
        together(&[LEFT, DOWN]),
    ]])]);
    agree([Kind::InARow(vec![vec![
        together(&[LEFT, DOWN]),
        any(&[LEFT]),
    ]])]);
}

#[test]
fn at_once_between_others_in_a_row() {
    agree([Kind::InARow(vec![vec![
        any(&[GRIP, UP]),
        together(&[LEFT, DOWN]),
        any(&[GRIP, RIGHT]),
    ]])]);
    agree([Kind::InARow(vec![vec![
        any(&[GRIP]),
        or(together(&[LEFT, DOWN]), any(&[LEFT])),
        or(together(&[LEFT, DOWN]), any(&[DOWN])),
    ]])]);
}

#[test]
fn words_in_a_row_do_not_hide_one_another() {
    agree([Kind::InARow(vec![
        vec![any(&[RIGHT]), any(&[LEFT]), any(&[DOWN]), any(&[UP])],
        vec![together(&[LEFT, DOWN]), together(&[RIGHT, DOWN])],
    ])]);
}

#[test]
fn beside_a_sequence() {
    agree([
        Kind::Sequence(loose_sequence()),
        Kind::Never(together(&[DOWN, GRIP])),
    ]);
}

#[test]
fn what_has_been_called_at_once_at_the_start_is_not_known() {
    let skills = unit_at(
        [0, 1, 0],
        [
            after(together(&[LEFT, DOWN]), any(&[UP]), any(&[GRIP])),
            before(together(&[LEFT, DOWN]), any(&[RELEASE])),
        ],
    );
    agree_on(&skills);
}

#[test]
fn what_has_been_called_last_at_the_start_is_not_known() {
    // It is at left and up.
    agree([after(any(&[LEFT]), any(&[UP]), any(&[GRIP]))]);
    agree([after(any(&[LEFT, UP]), any(&[UP]), any(&[GRIP]))]);
    agree([after(any(&[UP]), any(&[UP]), any(&[GRIP]))]);
    agree([at_most(0, any(&[GRIP]), any(&[LEFT]), any(&[UP, LEFT]))]);
    // One of the two has been called later than the other, whatever was called last.
    agree([
        after(any(&[LEFT]), any(&[UP]), any(&[GRIP])),
        after(any(&[UP]), any(&[LEFT]), any(&[GRIP])),
        after(any(&[RELEASE]), Vec::new(), any(&[RIGHT])),
    ]);
}

#[test]
fn deleted_transitions_and_recalls() {
    agree_at(&pick_and_place(), Level::Valid, true);
    agree_at(&pick_and_place(), Level::Reasonable, true);
    agree_at(&pick_and_place(), Level::Reasonable, false);
}

/// A sequence of calls of one, two or three skills of the unit, some eight skills in total.
fn program() -> impl Strategy<Value = Vec<u64>> {
    let at = |low: u64| prop_oneof![Just(0), Just(1 << low), Just(2 << low)];
    let call = (at(LEFT as u64), at(UP as u64), at(RELEASE as u64));
    let call = call.prop_map(|(x, z, gripper)| x | z | gripper);
    let call = call.prop_filter("nothing", |call| *call != 0);
    prop::collection::vec(call, 1..5)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn three_at_once(program in program()) {
        let sets = [
            unit([trays(), transport()]),
            unit([before(any(&[DOWN]), any(&[GRIP])), never_twice(&[RIGHT, GRIP])]),
            unit([at_most(1, any(&[LEFT, GRIP]), any(&[UP]), any(&[DOWN]))]),
            unit([after(together(&[RIGHT, DOWN]), any(&[UP]), any(&[RELEASE]))]),
            unit([Kind::Sequence(loose_sequence())]),
        ];
        for skills in &sets {
            for serialisation in BOTH {
                let options = Options { serialisation, ..Options::default() };
                let fsm = Fsm::of(skills, options, 3).expect("it is small");
                let columns = program.iter().map(|call| {
                    let column = fsm.calls.iter().position(|c| c.0 == *call);
                    column.expect("a call of the unit")
                });
                let columns: Vec<usize> = columns.collect();
                let naive = Naive::new(skills, options);
                let allowed = naive.allowed(&program);
                prop_assert!(fsm.dfa.run(&columns[..allowed]).is_some());
                prop_assert!(
                    allowed == columns.len() || fsm.dfa.run(&columns[..=allowed]).is_none()
                );
            }
        }
    }
}
