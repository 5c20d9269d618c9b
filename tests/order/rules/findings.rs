//! Findings about rules, compared with the words that they allow.

use super::naive::Naive;
use super::random::{Size, skills};
use super::units::{
    DOWN, GRIP, LEFT, RELEASE, RIGHT, UP, after, any, at_most, before, only_after, together, unit,
};
use linewright::deadline::Deadline;
use linewright::diagnostics::{Diagnostic, codes};
use linewright::order::findings::examine;
use linewright::order::program::{DifferenceOptions, difference};
use linewright::order::supervisor::{Options, Supervisor};
use linewright::order::{Kind, Level, Skills, fsm};
use linewright::source::{FileId, Span};
use proptest::prelude::*;

const SIZE: Size = Size {
    components: 2,
    skills: 2,
    rules: 3,
    at_once: 2,
    sequences: 2,
};

/// Maximum length of words that are tried one by one.
const LONGEST: usize = 4;

/// Every allowed word of these calls, up to `longest` calls.
fn words(naive: &Naive<'_>, calls: &[u64], longest: usize) -> Vec<Vec<u64>> {
    let mut all = vec![Vec::new()];
    let mut last = all.clone();
    for _ in 0..longest {
        let longer = last.iter().flat_map(|word: &Vec<u64>| {
            let word = word.clone();
            calls
                .iter()
                .map(move |call| [word.as_slice(), &[*call]].concat())
        });
        last = longer.filter(|word| naive.allows(word)).collect();
        all.extend(last.iter().cloned());
    }
    all
}

/// The skills of `` `Left & Down` ``, the first of the names in backticks that are skills.
fn named(message: &str, skills: &Skills) -> u64 {
    let parts = message.split('`').skip(1).step_by(2);
    let place = |name: &str| skills.skills.iter().position(|s| s.name == name);
    let masks = parts.filter_map(|part| {
        let places = part.split(" & ").map(place);
        places.map(|p| p.map(|p| 1 << p)).sum::<Option<u64>>()
    });
    masks.last().expect("a skill is named")
}

/// The same with names and places that distinguish the rules, all at the level valid.
fn numbered(mut skills: Skills) -> Skills {
    for (number, rule) in skills.rules.iter_mut().enumerate() {
        rule.name = format!("r{number}");
        rule.span = Span::new(FileId(0), 10 * number, 10 * number + 1);
        rule.level = Level::Valid;
    }
    skills
}

fn is(finding: &Diagnostic, what: &str) -> bool {
    finding.message.contains(what)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn findings_are_true(skills in skills(SIZE)) {
        let skills = numbered(skills);
        let options = Options::default();
        let naive = Naive::new(&skills, options);
        let calls: Vec<u64> = fsm::calls(&skills, 2).into_iter().map(|c| c.0).collect();
        let words = words(&naive, &calls, LONGEST);
        let found = examine(&skills, Deadline::NONE);
        prop_assert!(found.iter().all(|f| f.code != codes::TOO_LARGE));
        let nothing = found.iter().any(|f| f.code == codes::ORDER_EMPTY);
        let first = words.iter().any(|w| w.len() == 1 && w[0].is_power_of_two());
        prop_assert!(!(nothing && first), "{found:#?}");
        for finding in &found {
            if is(finding, "can never be called") {
                let mask = named(&finding.message, &skills);
                let called = words.iter().flatten().any(|call| call & mask == mask);
                prop_assert!(!called, "{finding:#?}");
            }
        }
        if nothing {
            return Ok(());
        }
        for rule in 0..skills.rules.len() {
            let name = &skills.rules[rule].name;
            let excludes_nothing = format!("the rule `{name}` excludes nothing");
            let flagged = found.iter().any(|f| is(f, &excludes_nothing));
            let others: Vec<usize> = (0..skills.rules.len()).filter(|r| *r != rule).collect();
            let without = skills.with_rules(&others);
            if flagged {
                let without = Naive::new(&without, options);
                let more = self::words(&without, &calls, LONGEST);
                prop_assert_eq!(&more, &words, "{}", name);
            } else if !found.iter().any(|f| f.code == codes::ORDER_CONTRADICTION) {
                let (all, fewer) = (
                    Supervisor::new(&skills, options).expect("it is small"),
                    Supervisor::new(&without, options).expect("it is small"),
                );
                let apart = DifferenceOptions { whole: true, ..DifferenceOptions::default() };
                let apart = difference(&all, &fewer, &fsm::calls(&skills, 2), apart);
                prop_assert!(apart.expect("it is small").is_some(), "{} in {:#?}", name, found);
            }
        }
    }
}

fn messages(kind: Kind) -> Vec<String> {
    let found = examine(&unit([kind]), Deadline::NONE);
    found.into_iter().map(|f| f.message).collect()
}

#[test]
fn skills_at_once_that_a_rule_never_allows_are_reported() {
    let both = || together(&[LEFT, DOWN]);
    for refused in [
        before(both(), any(&[DOWN])),
        after(both(), any(&[UP]), any(&[LEFT])),
        after(any(&[DOWN]), any(&[UP]), both()),
    ] {
        let found = messages(refused);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].ends_with("`Left & Down` can never be called"),
            "{found:?}"
        );
    }
    for sound in [
        before(both(), any(&[RELEASE, GRIP])),
        after(both(), any(&[UP]), any(&[RIGHT])),
        only_after(any(&[GRIP]), both()),
        at_most(2, both(), any(&[GRIP]), any(&[RELEASE])),
        at_most(0, both(), Vec::new(), Vec::new()),
        Kind::Never(both()),
        Kind::Never(together(&[LEFT, DOWN, GRIP])),
        after(together(&[RIGHT, DOWN, GRIP]), Vec::new(), any(&[LEFT])),
        at_most(1, together(&[RIGHT, DOWN, GRIP]), Vec::new(), Vec::new()),
    ] {
        assert_eq!(messages(sound), Vec::<String>::new());
    }
}
