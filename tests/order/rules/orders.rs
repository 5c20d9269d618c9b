//! Up to six skills at once: compares the sets counted in `crates/language/src/order/serial.rs`
//! with all orders, one after the other.

use super::naive::{Letter, Naive};
use super::random::{Size, program, skills};
use linewright::automata::dfa::REFUSED;
use linewright::deadline::Deadline;
use linewright::order::rule::Alphabet;
use linewright::order::serial::Serial;
use linewright::order::supervisor::{Call, Options, Refusal, State, Supervisor};
use linewright::order::{Rule, Serialisation, Skills, rule};
use proptest::prelude::*;
use proptest::sample::select;

const SIZE: Size = Size {
    components: 6,
    skills: 2,
    rules: 2,
    at_once: 3,
    sequences: 4,
};

/// Maximum number of letters in a call whose orders are all tried.
const MOST_LETTERS: usize = 6;

/// Maximum number of orders tried for each skill that may come next.
const MOST_ORDERS: usize = 1500;

/// Skills, some calls of one or two of them, and a last call of up to six.
fn with_calls() -> impl Strategy<Value = (Skills, Vec<u64>, u64)> {
    skills(SIZE).prop_flat_map(|skills| {
        let before = program(&skills, 2, 0..=2);
        let mut own: Vec<Vec<u64>> = vec![vec![0]; skills.components.len()];
        for (number, skill) in skills.skills.iter().enumerate() {
            // A component is omitted only occasionally.
            own[skill.component].extend([1 << number; 3]);
        }
        let last: Vec<_> = own.into_iter().map(select).collect();
        let last = last.prop_map(|one_each| one_each.iter().sum());
        let last = last.prop_filter("nothing is called", |call: &u64| *call != 0);
        (Just(skills), before, last)
    })
}

fn serialisation(some: bool) -> Serialisation {
    if some {
        Serialisation::Some
    } else {
        Serialisation::Every
    }
}

fn options(serialisation: Serialisation) -> Options {
    Options {
        serialisation,
        ..Options::default()
    }
}

/// The state after the allowed calls, and these calls.
fn after(supervisor: &mut Supervisor<'_>, calls: &[u64]) -> (State, Vec<u64>) {
    let mut state = supervisor.start();
    let mut allowed = Vec::new();
    for call in calls {
        if let Ok(next) = supervisor.call(&state, Call(*call)).expect("it is small") {
            state = next;
            allowed.push(*call);
        }
    }
    (state, allowed)
}

/// As many skills of a call, in ascending order, as do not have too many letters.
fn few(naive: &Naive<'_>, call: u64) -> u64 {
    let skills = (0..64).filter(|s| call >> s & 1 == 1);
    skills.fold(0, |few, skill| {
        let more = few | 1 << skill;
        if naive.letters(more).len() <= MOST_LETTERS {
            more
        } else {
            few
        }
    })
}

/// Letters of the last call, appended one by one to what was called before.
struct Behind<'a> {
    naive: &'a Naive<'a>,
    beginning: &'a [bool],
    word: Vec<Letter>,
    call: usize,
}

impl Behind<'_> {
    /// Whether these skills, with events anywhere among them, violate the rule with the last of
    /// them and no rule before.
    fn breaks_last(&mut self, rule: &Rule, order: &[usize], events: &[u64]) -> bool {
        let skill = order.split_first().map(|(s, rest)| (1 << s, rest, None));
        let event = |at: usize| (events[at], order, Some(at));
        let candidates: Vec<_> = skill
            .into_iter()
            .chain((0..events.len()).map(event))
            .collect();
        candidates.into_iter().any(|(mask, order, event)| {
            self.word.push(Letter {
                mask,
                call: self.call,
            });
            let broken = self.naive.broken(self.beginning, &self.word);
            let is = if broken.is_empty() {
                let mut events = events.to_vec();
                event.map(|at| events.remove(at));
                self.breaks_last(rule, order, &events)
            } else {
                order.is_empty() && broken.contains(&rule)
            };
            self.word.pop();
            is
        })
    }
}

/// Whether some order of the earlier calls is allowed, and this order after it violates a rule with
/// its last skill and none before.
fn is_refused_at_last(
    naive: &Naive<'_>,
    before: &[u64],
    call: u64,
    rule: &Rule,
    order: &[usize],
) -> bool {
    let events = naive.letters(call).into_iter();
    let events: Vec<u64> = events.filter(|e| !e.is_power_of_two()).collect();
    naive.orders(before).into_iter().any(|word| {
        naive.beginnings().any(|beginning| {
            let mut behind = Behind {
                naive,
                beginning,
                word: word.clone(),
                call: before.len(),
            };
            let kept = naive.broken(beginning, &word).is_empty();
            kept && behind.breaks_last(rule, order, &events)
        })
    })
}

fn alone(skills: &Skills, rule: usize) -> Skills {
    Skills {
        rules: vec![skills.rules[rule].clone()],
        ..skills.clone()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn sets_say_what_all_orders_say((skills, before, call) in with_calls(), some in any::<bool>()) {
        let serialisation = serialisation(some);
        let options = options(serialisation);
        let mut supervisor = Supervisor::new(&skills, options).expect("it is small");
        let naive = Naive::new(&skills, options);
        let call = few(&naive, call);
        let (state, mut program) = after(&mut supervisor, &before);
        program.push(call);
        let allowed = supervisor.call(&state, Call(call)).expect("it is small");
        prop_assert_eq!(allowed.is_ok(), naive.allows(&program));
        let Ok(state) = allowed else {
            return Ok(());
        };
        prop_assert_eq!(supervisor.is_complete(&state), naive.may_end(&program));
        // What is then known is everything that the orders leave open. This is tested for every
        // skill, if there are not too many orders.
        let orders = program.iter().map(|call| (1..=naive.letters(*call).len()).product::<usize>());
        if orders.product::<usize>() > MOST_ORDERS {
            return Ok(());
        }
        for skill in 0..skills.skills.len() {
            program.push(1 << skill);
            let next = supervisor.call(&state, Call::one(skill)).expect("it is small");
            prop_assert_eq!(next.is_ok(), naive.allows(&program));
            program.pop();
        }
    }

    #[test]
    fn the_order_that_is_named_is_refused(
        (skills, before, call) in with_calls(),
        some in any::<bool>(),
    ) {
        let serialisation = serialisation(some);
        let options = options(serialisation);
        let mut supervisor = Supervisor::new(&skills, options).expect("it is small");
        let naive = Naive::new(&skills, options);
        let call = few(&naive, call);
        let (state, before) = after(&mut supervisor, &before);
        let refused = supervisor.call(&state, Call(call)).expect("it is small");
        let Err(Refusal::Rule { rule, order }) = refused else {
            return Ok(());
        };
        let mut distinct = order.clone();
        distinct.sort_unstable();
        distinct.dedup();
        prop_assert_eq!(distinct.len(), order.len());
        prop_assert!(order.iter().all(|skill| call >> skill & 1 == 1));
        let program = [before.as_slice(), &[call]].concat();
        if serialisation == Serialisation::Some {
            let rule = &skills.rules[rule];
            prop_assert!(is_refused_at_last(&naive, &before, call, rule, &order));
            return Ok(());
        }
        // Every rule is tested by itself; the first that refuses is named.
        for earlier in 0..rule {
            let alone = alone(&skills, earlier);
            prop_assert!(Naive::new(&alone, options).allows(&program));
        }
        let alone = alone(&skills, rule);
        let naive = Naive::new(&alone, options);
        prop_assert!(is_refused_at_last(&naive, &before, call, &alone.rules[0], &order));
    }

    #[test]
    fn one_rule_by_itself_names_an_order_that_it_refuses(
        (skills, before, call) in with_calls(),
        some in any::<bool>(),
    ) {
        let alphabet = Alphabet::of(&skills);
        for rule in &skills.rules {
            let automaton = rule::automaton(rule, &skills, &alphabet, Deadline::NONE).expect("it is small");
            let dfa = automaton.dfa.clone();
            let mut serial = Serial::new(automaton, serialisation(some));
            let mut known = 0;
            for call in before.iter().chain([&call]) {
                let letters = alphabet.letters(*call);
                let after = serial.call(known, &letters).expect("it is small");
                let order = serial.refused_order(known, &letters).expect("it is small");
                prop_assert_eq!(after.is_some(), order.is_none());
                if let Some(order) = order {
                    prop_assert!(order.iter().all(|l| letters.contains(l)));
                    let is_refused = |state: &u32| {
                        let (last, before) = order.split_last().expect("a letter is refused");
                        let step = |s: u32, l: &usize| Some(dfa.next(s, *l)).filter(|s| *s != REFUSED);
                        let behind = before.iter().try_fold(*state, step);
                        behind.is_some_and(|s| step(s, last).is_none())
                    };
                    prop_assert!(serial.states(known).iter().any(is_refused));
                }
                known = after.unwrap_or(known);
            }
        }
    }
}
