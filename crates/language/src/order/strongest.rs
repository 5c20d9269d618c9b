//! Computation of the strongest level: finds the recalls and detours that can be forbidden without
//! losing reachable situations.
//!
//! Brandenbourger et al. leave the reasonable level to "an engineer understanding the system and
//! not systematically following a method", and the strongest level to future work. The method here:
//!
//! 1. *Candidates.* A recall is a call of a skill whose component is already in the skill's target
//!    situation. A detour is a word of a few skills that has the same result as some shorter word,
//!    wherever it is allowed (`Left Right`, after which nothing has changed, or `Grip Left
//!    Release`, which has the result of `Left`). The result is the situation and the states of all
//!    rules.
//! 2. *Test.* A candidate is added as a rule. It is kept if two conditions hold in every state that
//!    is still reachable: every useful situation that was reachable from there before any candidate
//!    became a rule is still reachable, and every program that could be completed before can still
//!    be completed. Otherwise the word is needed, and the result names the situation that would be
//!    lost.
//! 3. *Order.* Recalls come first, then detours, short ones first, in the order of the skills'
//!    declaration; each candidate is tested together with all that have been kept. So no rejected
//!    candidate can be added to the result. The result is a maximal set of candidates, though
//!    perhaps not the only one.
//!
//! The engineer can specify candidates to drop, and the situations that are useful. The result is
//! then recomputed.

use super::fsm::Fsm;
use super::supervisor::{Call, Options};
use super::{Event, Kind, Level, Rule, Skills};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::{Dfa, REFUSED};
use linewright_automata::search::shortest;
use std::collections::BTreeSet;

/// A partial situation that selects useful situations: pairs (component, situation).
pub type Pattern = Vec<(usize, usize)>;

/// Parameters of the search.
#[derive(Debug, Clone)]
pub struct Request {
    /// Options that select the rules to which candidates are added.
    pub options: Options,
    /// Maximum number of skills in a detour; if it is 1, only recalls are tested.
    pub longest: usize,
    /// Patterns of useful situations; a situation is useful if it matches one of them. If empty,
    /// all situations are useful.
    pub useful: Vec<Pattern>,
    /// Names of candidates that the engineer rejects.
    pub dropped: BTreeSet<String>,
}

/// A candidate rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// Rule that forbids the word. Its text is source text that declares the rule at the requested
    /// level.
    pub rule: Rule,
    /// Skills of the word.
    pub word: Vec<usize>,
    /// Result of the test.
    pub verdict: Verdict,
}

/// Result of testing a candidate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The word can be forbidden: the rule is part of the strongest level.
    Kept,
    /// The word is needed: without it, a situation could not be reached after some calls.
    Needed {
        /// Shortest sequence of calls after which a situation can no longer be reached, or a
        /// program can no longer be completed.
        after: Vec<Call>,
        /// Situation that could no longer be reached; `None` if no program could be completed.
        lost: Option<Vec<usize>>,
    },
    /// The engineer rejects the rule.
    Dropped,
}

/// Result of the search for the strongest level.
#[derive(Debug, Clone)]
pub struct Strongest {
    /// All tested candidates, in the order of the tests. A candidate that forbids nothing new is
    /// not tested.
    pub candidates: Vec<Candidate>,
    /// Skill set with its rules and the kept candidates as further rules.
    pub skills: Skills,
}

/// Finds the strongest level.
///
/// # Errors
/// When an automaton is too large, or the deadline has passed.
pub fn strongest(skills: &Skills, request: &Request) -> Result<Strongest, BoundExceeded> {
    let base = Fsm::of(skills, request.options, 1)?;
    let mut search = Search {
        request,
        goals: ReachabilityGoals::new(&base, &request.useful),
        allowed: base.dfa.clone().prefix_closed(),
        base,
        found: Strongest {
            candidates: Vec::new(),
            skills: skills.clone(),
        },
    };
    let level = request.options.level;
    let recalls =
        (0..skills.skills.len()).filter_map(|s| recall(skills, s, level).map(|r| (vec![s], r)));
    for (word, rule) in recalls {
        search.test_candidate(word, rule)?;
    }
    for length in 2..=request.longest {
        request.options.until.check()?;
        for word in detours(&search.base, length) {
            let rule = detour(skills, &word, level);
            search.test_candidate(word, rule)?;
        }
    }
    Ok(search.found)
}

/// Returns the rule that forbids recalls of a skill: after a skill with the same target situation,
/// the skill must not be called until another skill leads the component elsewhere. The text of the
/// rule declares it at `level`. Returns `None` if the skill has no target situation.
pub(super) fn recall(skills: &Skills, skill: usize, level: Level) -> Option<Rule> {
    let of = &skills.skills[skill];
    let effect = of.effect?;
    let all = skills.skills.iter().enumerate();
    let own: Vec<_> = all.filter(|(_, s)| s.component == of.component).collect();
    let (same, other): (Vec<_>, Vec<_>) = own.iter().partition(|(_, s)| s.effect == Some(effect));
    let events = |of: &[&(usize, &super::Skill)]| of.iter().map(|(s, _)| Event(vec![*s])).collect();
    let names = |of: &[&(usize, &super::Skill)]| {
        let names: Vec<&str> = of.iter().map(|(_, s)| s.name.as_str()).collect();
        names.join(", ")
    };
    let until = match other.len() {
        0 => String::new(),
        _ => format!(" until {}", names(&other)),
    };
    Some(derived(
        level,
        format!("recall_{}", of.name),
        &format!("after {}{until}: never {}", names(&same), of.name),
        Kind::After {
            from: events(&same),
            until: events(&other),
            never: vec![Event(vec![skill])],
        },
    ))
}

fn detour(skills: &Skills, word: &[usize], level: Level) -> Rule {
    let names: Vec<&str> = word
        .iter()
        .map(|s| skills.skills[*s].name.as_str())
        .collect();
    let places = word.iter().map(|s| vec![Event(vec![*s])]).collect();
    derived(
        level,
        format!("detour_{}", names.join("_")),
        &format!("never {}", names.join(" then ")),
        Kind::InARow(vec![places]),
    )
}

fn derived(level: Level, name: String, body: &str, kind: Kind) -> Rule {
    // A rule in a file applies from the level `valid` upwards, unless it is marked `at reasonable`.
    let at = match level {
        Level::Arbitrary | Level::Valid => String::new(),
        Level::Reasonable => format!(" at {}", level.keyword()),
    };
    Rule {
        text: format!("order {name}{at}: {body}"),
        name,
        requirement: None,
        doc: String::new(),
        // The rule applies at every level.
        level: Level::Arbitrary,
        kind,
        deletions: Vec::new(),
        span: linewright_core::source::Span::default(),
    }
}

/// Returns the words of this length that are allowed in some state and have the result of a shorter
/// word in every state in which they are allowed.
fn detours(base: &Fsm, length: usize) -> Vec<Vec<usize>> {
    let skills = base.dfa.letter_count();
    let near: Vec<BTreeSet<u32>> = (0..base.states.len() as u32)
        .map(|from| within(base, from, length - 1))
        .collect();
    let mut found = Vec::new();
    let mut word = vec![0; length];
    // Pairs of the state before the word and the state after the current prefix.
    let all: Vec<(u32, u32)> = (0..base.states.len() as u32).map(|s| (s, s)).collect();
    lengthen(base, &near, &mut word, 0, &all, skills, &mut found);
    found
}

fn lengthen(
    base: &Fsm,
    near: &[BTreeSet<u32>],
    word: &mut Vec<usize>,
    at: usize,
    reached: &[(u32, u32)],
    skills: usize,
    found: &mut Vec<Vec<usize>>,
) {
    if reached.is_empty() {
        return;
    }
    if at == word.len() {
        if reached
            .iter()
            .all(|(from, to)| near[*from as usize].contains(to))
        {
            found.push(word.clone());
        }
        return;
    }
    for skill in 0..skills {
        let next: Vec<(u32, u32)> = reached
            .iter()
            .map(|(from, to)| (*from, base.dfa.next(*to, skill)))
            .filter(|(_, to)| *to != REFUSED)
            .collect();
        word[at] = skill;
        lengthen(base, near, word, at + 1, &next, skills, found);
    }
}

/// Returns the states that can be reached from a state by at most `most` calls.
fn within(base: &Fsm, from: u32, most: usize) -> BTreeSet<u32> {
    let mut seen = BTreeSet::from([from]);
    let mut last = vec![from];
    for _ in 0..most {
        let mut next = Vec::new();
        for state in last {
            for skill in 0..base.dfa.letter_count() {
                let to = base.dfa.next(state, skill);
                if to != REFUSED && seen.insert(to) {
                    next.push(to);
                }
            }
        }
        last = next;
    }
    seen
}

/// Goals that must remain reachable, because they can be reached without candidates.
struct ReachabilityGoals {
    /// Useful situations, in ascending order.
    situations: Vec<Vec<usize>>,
    /// For each state, the situations that can be reached by one call or more; the last bit tells
    /// whether a program can be completed.
    reached: Vec<Bits>,
}

impl ReachabilityGoals {
    fn new(base: &Fsm, useful: &[Pattern]) -> Self {
        let fits = |situation: &[usize]| {
            let mut patterns = useful.iter();
            useful.is_empty() || patterns.any(|p| p.iter().all(|(c, s)| situation[*c] == *s))
        };
        let situations: BTreeSet<Vec<usize>> = base
            .states
            .iter()
            .map(|s| s.situation.clone())
            .filter(|s| fits(s))
            .collect();
        let situations: Vec<Vec<usize>> = situations.into_iter().collect();
        let reached = reached(base, &situations);
        Self {
            situations,
            reached,
        }
    }
}

/// Returns, for each state, which of these situations can be reached by one call or more; the last
/// bit tells whether a program can be completed.
fn reached(fsm: &Fsm, situations: &[Vec<usize>]) -> Vec<Bits> {
    let states = fsm.states.len();
    let place: Vec<Option<usize>> = fsm
        .states
        .iter()
        .map(|s| situations.binary_search(&s.situation).ok())
        .collect();
    let mut reached = vec![Bits::new(situations.len() + 1); states];
    for (state, reached) in reached.iter_mut().enumerate() {
        if fsm.dfa.is_complete(state as u32) {
            reached.insert(situations.len());
        }
    }
    loop {
        let mut changed = false;
        for from in (0..states).rev() {
            let mut here = std::mem::take(&mut reached[from]);
            for skill in 0..fsm.dfa.letter_count() {
                let to = fsm.dfa.next(from as u32, skill);
                if to == REFUSED {
                    continue;
                }
                let to = to as usize;
                if let Some(place) = place[to] {
                    changed |= here.insert(place);
                }
                if to != from {
                    changed |= here.insert_all(&reached[to]);
                }
            }
            reached[from] = here;
        }
        if !changed {
            return reached;
        }
    }
}

/// A set of small numbers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Bits(Vec<u64>);

impl Bits {
    /// Creates the empty set of numbers below `count`.
    fn new(count: usize) -> Self {
        Self(vec![0; count.div_ceil(64)])
    }

    /// Adds a number; returns whether it is new.
    fn insert(&mut self, number: usize) -> bool {
        let word = &mut self.0[number / 64];
        let before = *word;
        *word |= 1 << (number % 64);
        *word != before
    }

    /// Adds all numbers of another set; returns whether any is new.
    fn insert_all(&mut self, other: &Self) -> bool {
        let mut changed = false;
        for (word, more) in self.0.iter_mut().zip(&other.0) {
            changed |= *more & !*word != 0;
            *word |= more;
        }
        changed
    }

    /// Returns the smallest number in this set that is not in `other`.
    fn first_missing_in(&self, other: &Self) -> Option<usize> {
        let mut words = self.0.iter().zip(&other.0).enumerate();
        words.find_map(|(at, (word, other))| match word & !other {
            0 => None,
            more => Some(at * 64 + more.trailing_zeros() as usize),
        })
    }
}

/// State of the search.
struct Search<'a> {
    request: &'a Request,
    /// Automaton of the level without candidates.
    base: Fsm,
    goals: ReachabilityGoals,
    found: Strongest,
    /// Words allowed by the rules and the candidates kept so far.
    allowed: Dfa,
}

impl Search<'_> {
    /// Tests a candidate. Ignores it if it forbids only what is already forbidden.
    fn test_candidate(&mut self, word: Vec<usize>, rule: Rule) -> Result<(), BoundExceeded> {
        let mut with = self.found.skills.clone();
        with.rules.push(rule.clone());
        let fsm = Fsm::of(&with, self.request.options, 1)?;
        let allowed = fsm.dfa.clone().prefix_closed();
        if self.allowed.difference(&allowed).is_none() {
            return Ok(());
        }
        let verdict = if self.request.dropped.contains(&rule.name) {
            Verdict::Dropped
        } else {
            loss(&fsm, &self.base, &self.goals)
        };
        if verdict == Verdict::Kept {
            self.found.skills = with;
            self.allowed = allowed;
        }
        self.found.candidates.push(Candidate {
            rule,
            word,
            verdict,
        });
        Ok(())
    }
}

/// Returns the verdict on a candidate: `Needed` with the first loss, or `Kept`. Explores pairs of
/// states that the same calls reach: one in the automaton with the candidate, one in the automaton
/// without candidates.
fn loss(fsm: &Fsm, base: &Fsm, goals: &ReachabilityGoals) -> Verdict {
    let left = reached(fsm, &goals.situations);
    let missing = |&(now, before): &(u32, u32)| {
        goals.reached[before as usize].first_missing_in(&left[now as usize])
    };
    let successors = |&(now, before): &(u32, u32)| -> Vec<(usize, (u32, u32))> {
        let letters = 0..fsm.dfa.letter_count();
        let to = letters.map(|l| (l, (fsm.dfa.next(now, l), base.dfa.next(before, l))));
        to.filter(|(_, (now, _))| *now != REFUSED).collect()
    };
    let Some(word) = shortest((0, 0), successors, |pair| missing(pair).is_some()) else {
        return Verdict::Kept;
    };
    let end = word.iter().fold((0, 0), |(now, before), l| {
        (fsm.dfa.next(now, *l), base.dfa.next(before, *l))
    });
    let lost = missing(&end).and_then(|i| goals.situations.get(i).cloned());
    Verdict::Needed {
        after: word.into_iter().map(|l| fsm.calls[l]).collect(),
        lost,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::order::fsm::tests::pick_and_place;

    fn found(longest: usize, useful: Vec<Pattern>, dropped: &[&str]) -> String {
        let skills = pick_and_place();
        let request = Request {
            options: Options::default(),
            longest,
            useful,
            dropped: dropped.iter().map(|d| (*d).to_owned()).collect(),
        };
        let result = strongest(&skills, &request).expect("it is small");
        let lines = result.candidates.iter().map(|c| match &c.verdict {
            Verdict::Kept => format!("{}\n", c.rule.text),
            Verdict::Dropped => format!("dropped: {}\n", c.rule.text),
            Verdict::Needed { after, lost } => {
                let after: Vec<_> = after.iter().map(|c| c.text(&skills)).collect();
                let lost = lost
                    .as_ref()
                    .map_or_else(String::new, |l| skills.situation_text(l));
                format!("needed: {} ({}: {lost})\n", c.rule.text, after.join(" "))
            }
        });
        let fsm = Fsm::of(&result.skills, Options::default(), 3).expect("it is small");
        let count = fsm.transitions().len();
        format!(
            "{}{} states, {count} transitions",
            lines.collect::<String>(),
            fsm.states.len()
        )
    }

    #[test]
    fn recalls_and_detours_of_the_papers_unit() {
        insta::assert_snapshot!(found(2, Vec::new(), &[]), @r"
        order recall_Left: after Left until Right: never Left
        order recall_Right: after Right until Left: never Right
        order recall_Up: after Up until Down: never Up
        order recall_Down: after Down until Up: never Down
        order recall_Release: after Release until Grip: never Release
        order recall_Grip: after Grip until Release: never Grip
        order detour_Left_Right: never Left then Right
        order detour_Right_Left: never Right then Left
        order detour_Up_Down: never Up then Down
        order detour_Down_Up: never Down then Up
        order detour_Release_Grip: never Release then Grip
        order detour_Grip_Release: never Grip then Release
        23 states, 35 transitions
        ");
        insta::assert_snapshot!(found(3, Vec::new(), &["detour_Left_Right"]), @r"
        order recall_Left: after Left until Right: never Left
        order recall_Right: after Right until Left: never Right
        order recall_Up: after Up until Down: never Up
        order recall_Down: after Down until Up: never Down
        order recall_Release: after Release until Grip: never Release
        order recall_Grip: after Grip until Release: never Grip
        dropped: order detour_Left_Right: never Left then Right
        order detour_Right_Left: never Right then Left
        order detour_Up_Down: never Up then Down
        order detour_Down_Up: never Down then Up
        order detour_Release_Grip: never Release then Grip
        order detour_Grip_Release: never Grip then Release
        needed: order detour_Left_Right_Down: never Left then Right then Down (Right Grip Left Right: left, up, open)
        order detour_Left_Right_Grip: never Left then Right then Grip
        order detour_Left_Grip_Right: never Left then Grip then Right
        order detour_Right_Grip_Left: never Right then Grip then Left
        order detour_Up_Left_Right: never Up then Left then Right
        order detour_Up_Grip_Down: never Up then Grip then Down
        needed: order detour_Down_Grip_Up: never Down then Grip then Up (Down: left, up, open)
        order detour_Release_Up_Grip: never Release then Up then Grip
        needed: order detour_Grip_Down_Release: never Grip then Down then Release (Right Grip: left, up, open)
        23 states, 30 transitions
        ");
    }
}
