//! The meaning of rules without automata: every kind by quantifiers over the positions of a word,
//! several skills at once by trying all orders.
//!
//! It follows the text of `crates/language/src/order/mod.rs` and shares only data types with
//! `crates/language/src/order`. What that text leaves open is decided here as follows:
//!
//! - The call that ends a window is inside it, the one that begins it is not:
//!   `at most 2 of X between Y and X` counts the last `X`.
//! - `X before X` has no effect, and `X only after X` never allows an `X`.
//! - An event of several skills has not been called at the start, wherever the components are.
//! - Which of two skills that hold at the start was called last is not known. With `Every` all
//!   orders must be suitable.
//! - Events of several skills occur anywhere among the skills of their call. Only skills count for
//!   consecutive calls: `Left & Down` occurs where the two follow each other in one call.

use super::expression;
use linewright::order::supervisor::Options;
use linewright::order::{Event, Kind, Level, Rule, Serialisation, Skills};
use std::collections::BTreeSet;

/// A skill, or an event of several, at its place in some order of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Letter {
    /// Mask of the skills.
    pub mask: u64,
    /// Index of the call.
    pub call: usize,
}

/// Positions in a word at which one of some events occurs, as a mask.
#[derive(Clone, Copy)]
struct Places(u64);

impl Places {
    fn of(events: &[Event], word: &[Letter]) -> Self {
        let places = word.iter().enumerate();
        let places = places.filter(|(_, letter)| has(events, letter.mask));
        Self(places.map(|(p, _)| 1 << p).sum())
    }

    fn has(self, place: usize) -> bool {
        self.0 >> place & 1 == 1
    }

    fn none(self, mut range: std::ops::Range<usize>) -> bool {
        range.all(|p| !self.has(p))
    }
}

/// The rules of a level, as written.
pub struct Naive<'a> {
    skills: &'a Skills,
    options: Options,
    rules: Vec<&'a Rule>,
    deleting: Vec<&'a Rule>,
    /// Events of several skills.
    at_once: Vec<u64>,
    /// What may hold at the start: for every rule, whether it begins as if called. One entry for
    /// every order in which the initial skills may have been called.
    beginnings: BTreeSet<Vec<bool>>,
}

fn mask(event: &Event) -> u64 {
    event.0.iter().map(|s| 1 << s).sum()
}

fn has(events: &[Event], mask_of_one: u64) -> bool {
    events.iter().any(|e| mask(e) == mask_of_one)
}

/// The skills of a mask, in ascending order.
pub fn members(mask: u64) -> Vec<usize> {
    (0..64).filter(|s| mask >> s & 1 == 1).collect()
}

/// All orders of some things.
pub fn permutations<T: Copy>(things: &[T]) -> Vec<Vec<T>> {
    if things.is_empty() {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for first in 0..things.len() {
        let mut rest = things.to_vec();
        let thing = rest.remove(first);
        for mut order in permutations(&rest) {
            order.insert(0, thing);
            all.push(order);
        }
    }
    all
}

impl<'a> Naive<'a> {
    pub fn new(skills: &'a Skills, options: Options) -> Self {
        let kept = skills.rules.iter().filter(|r| r.level <= options.level);
        let (deleting, rules): (Vec<_>, Vec<_>) =
            kept.partition(|r| options.paper && !r.deletions.is_empty());
        let standing = skills.skills.iter().enumerate();
        let standing = standing
            .filter(|(_, s)| s.effect == Some(skills.components[s.component].initial))
            .map(|(place, _)| 1_u64 << place);
        let standing: Vec<u64> = standing.collect();
        let beginnings = permutations(&standing);
        let beginnings = beginnings
            .iter()
            .map(|called| rules.iter().map(|r| begins(&r.kind, called)).collect())
            .collect();
        let mut at_once = BTreeSet::new();
        for rule in &rules {
            for event in events(&rule.kind) {
                if event.0.len() > 1 {
                    at_once.insert(mask(event));
                }
            }
        }
        Self {
            skills,
            options,
            rules,
            deleting,
            at_once: at_once.into_iter().collect(),
            beginnings,
        }
    }

    /// Whether all these calls are allowed, one after the other.
    pub fn allows(&self, program: &[u64]) -> bool {
        self.suits_components(program) && self.asks(program, Self::keeps)
    }

    /// Whether an allowed program may end here: no sequence is in the middle of a word.
    pub fn may_end(&self, program: &[u64]) -> bool {
        self.asks(program, |naive, word| {
            naive.is_whole(word)
                && (naive.options.serialisation == Serialisation::Every || naive.keeps(word))
        })
    }

    /// The rules, by index, that prevent an allowed program from ending here: what every order
    /// leaves unfinished; if that is empty or every order must be suitable, what some order leaves
    /// unfinished.
    pub fn unfinished(&self, program: &[u64]) -> Vec<usize> {
        if self.may_end(program) {
            return Vec::new();
        }
        let mut orders = self.orders(program);
        orders.retain(|word| self.keeps(word));
        let sequences = self.skills.rules.iter().enumerate();
        let sequences = sequences.filter(|(_, rule)| rule.level <= self.options.level);
        let open = |rule: &Rule, word: &Vec<Letter>| match &rule.kind {
            Kind::Sequence(regex) => !self.word(&called(word)).is_whole(regex),
            _ => false,
        };
        let every = sequences
            .clone()
            .filter(|(_, r)| orders.iter().all(|w| open(r, w)));
        let some = sequences.filter(|(_, r)| orders.iter().any(|w| open(r, w)));
        let every: Vec<usize> = every.map(|(place, _)| place).collect();
        if every.is_empty() || self.options.serialisation == Serialisation::Every {
            return some.map(|(place, _)| place).collect();
        }
        every
    }

    /// Number of calls allowed before the first refused one.
    pub fn allowed(&self, program: &[u64]) -> usize {
        let all = (1..=program.len()).take_while(|n| self.allows(&program[..*n]));
        all.count()
    }

    /// The letters of a call: its skills, and the events that it contains.
    pub fn letters(&self, call: u64) -> Vec<u64> {
        let events = self.at_once.iter().copied();
        let skills = members(call).into_iter().map(|s| 1 << s);
        skills.chain(events.filter(|e| e & call == *e)).collect()
    }

    /// Tests all orders, or some order, as required.
    fn asks(&self, program: &[u64], is: impl Fn(&Self, &[Letter]) -> bool) -> bool {
        let every = self.options.serialisation == Serialisation::Every;
        let mut found = false;
        let mut word = Vec::new();
        self.each_order(program, 0, &mut word, &mut |word| {
            found = is(self, word);
            // The answer is known with the first refusal, or with the first allowed order.
            found == every
        });
        found
    }

    /// All orders of the letters of these calls.
    pub fn orders(&self, program: &[u64]) -> Vec<Vec<Letter>> {
        let mut orders = Vec::new();
        self.each_order(program, 0, &mut Vec::new(), &mut |word| {
            orders.push(word.to_vec());
            true
        });
        orders
    }

    /// Passes on every order of the letters of every call, as long as more are requested.
    fn each_order(
        &self,
        program: &[u64],
        call: usize,
        word: &mut Vec<Letter>,
        more: &mut impl FnMut(&[Letter]) -> bool,
    ) -> bool {
        let Some(skills) = program.get(call) else {
            return more(word);
        };
        permutations(&self.letters(*skills)).iter().all(|order| {
            let before = word.len();
            word.extend(order.iter().map(|&mask| Letter { mask, call }));
            let wanted = self.each_order(program, call + 1, word, more);
            word.truncate(before);
            wanted
        })
    }

    /// What may hold at the start.
    pub fn beginnings(&self) -> impl Iterator<Item = &[bool]> {
        self.beginnings.iter().map(Vec::as_slice)
    }

    /// The rules kept at this level that one order violates.
    pub fn broken(&self, beginning: &[bool], word: &[Letter]) -> Vec<&'a Rule> {
        let rules = self.rules.iter().copied().zip(beginning);
        let broken = rules.filter(|(rule, begun)| !self.keeps_one(&rule.kind, **begun, word));
        broken.map(|(rule, _)| rule).collect()
    }

    /// Whether one order keeps all rules.
    pub fn keeps(&self, word: &[Letter]) -> bool {
        let keeps = |beginning: &Vec<bool>| {
            let mut rules = self.rules.iter().zip(beginning);
            rules.all(|(rule, begun)| self.keeps_one(&rule.kind, *begun, word))
        };
        match self.options.serialisation {
            Serialisation::Every => self.beginnings.iter().all(keeps),
            Serialisation::Some => self.beginnings.iter().any(keeps),
        }
    }

    /// Whether one order leaves no sequence in the middle of a word.
    pub fn is_whole(&self, word: &[Letter]) -> bool {
        let called = called(word);
        self.rules.iter().all(|rule| match &rule.kind {
            Kind::Sequence(regex) => self.word(&called).is_whole(regex),
            _ => true,
        })
    }

    fn word<'w>(&self, called: &'w [usize]) -> expression::Word<'w> {
        expression::Word {
            called,
            skills: self.skills.skills.len(),
        }
    }

    fn keeps_one(&self, kind: &Kind, begun: bool, word: &[Letter]) -> bool {
        let n = word.len();
        let places = |events: &[Event]| Places::of(events, word);
        match kind {
            Kind::Never(never) => places(never).none(0..n),
            Kind::After { from, until, never } => {
                let (from, until, never) = (places(from), places(until), places(never));
                (0..n).filter(|p| never.has(*p)).all(|p| {
                    let since_start = begun && until.none(0..p);
                    !since_start && !(0..p).any(|q| from.has(q) && until.none(q + 1..p))
                })
            }
            Kind::Before { first, then } => {
                let (first, then) = (places(first), places(then));
                let mut waiting = (0..n).filter(|p| then.has(*p));
                waiting.all(|p| begun || !first.none(0..p + 1))
            }
            Kind::OnlyAfter { what, after } => {
                let (what, after) = (places(what), places(after));
                (0..n).filter(|p| what.has(*p)).all(|p| {
                    let since_start = begun && what.none(0..p);
                    since_start || (0..p).any(|q| after.has(q) && what.none(q + 1..p))
                })
            }
            Kind::AtMost {
                count,
                of,
                from,
                until,
            } => {
                let (of, from, until) = (places(of), places(from), places(until));
                let few = |begin: usize| {
                    let last = (begin..n).find(|p| until.has(*p));
                    let window = begin..last.map_or(n, |p| p + 1);
                    window.filter(|p| of.has(*p)).count() <= *count as usize
                };
                (!begun || few(0)) && (0..n).filter(|p| from.has(*p)).all(|p| few(p + 1))
            }
            Kind::InARow(words) => {
                let single: Vec<Letter> = word
                    .iter()
                    .copied()
                    .filter(|l| l.mask.is_power_of_two())
                    .collect();
                let stands = |p: usize| words.iter().any(|w| stands_in_front(w, &single[p..]));
                !(0..single.len()).any(stands)
            }
            Kind::Sequence(regex) => n == 0 || self.word(&called(word)).is_begun(regex),
        }
    }

    /// Whether components allow these calls: no two skills of one at once, no forbidden recall, no
    /// deleted transition.
    pub fn suits_components(&self, program: &[u64]) -> bool {
        let components = 0..self.skills.components.len();
        let mut situation: Vec<usize> = components
            .map(|c| self.skills.components[c].initial)
            .collect();
        for call in program {
            let before = situation.clone();
            let mut moved = BTreeSet::new();
            for skill in members(*call) {
                let skill = &self.skills.skills[skill];
                let is_recall = skill.effect == Some(before[skill.component]);
                if is_recall && self.options.level == Level::Reasonable {
                    return false;
                }
                if !moved.insert(skill.component) {
                    return false;
                }
                situation[skill.component] = skill.effect.unwrap_or(before[skill.component]);
            }
            let is = |at: &[(usize, usize)], situation: &[usize]| {
                at.iter().all(|(c, s)| situation[*c] == *s)
            };
            let mut deletions = self.deleting.iter().flat_map(|r| &r.deletions);
            if deletions.any(|d| is(&d.from, &before) && is(&d.to, &situation)) {
                return false;
            }
        }
        true
    }
}

/// The skills of a word, without events.
fn called(word: &[Letter]) -> Vec<usize> {
    let single = word.iter().filter(|l| l.mask.is_power_of_two());
    single.map(|l| l.mask.trailing_zeros() as usize).collect()
}

/// Whether a rule begins as if its first part had been called, when these skills have been called
/// before the start.
fn begins(kind: &Kind, standing: &[u64]) -> bool {
    let is = |p: usize, events: &[Event]| has(events, standing[p]);
    let all = 0..standing.len();
    match kind {
        Kind::AtMost { from, .. } if from.is_empty() => true,
        Kind::After { from, until, .. } | Kind::AtMost { from, until, .. } => {
            let open = |p: usize| !(p + 1..standing.len()).any(|q| is(q, until));
            all.into_iter().any(|p| is(p, from) && open(p))
        }
        Kind::Before { first: asked, .. } | Kind::OnlyAfter { after: asked, .. } => {
            all.into_iter().any(|p| is(p, asked))
        }
        Kind::Never(_) | Kind::InARow(_) | Kind::Sequence(_) => false,
    }
}

/// Whether these skills begin with the consecutive places of a word.
fn stands_in_front(places: &[Vec<Event>], skills: &[Letter]) -> bool {
    let Some((place, others)) = places.split_first() else {
        return true;
    };
    place.iter().any(|event| {
        let Some((these, rest)) = skills.split_at_checked(event.0.len()) else {
            return false;
        };
        let together = these.iter().all(|l| l.call == these[0].call);
        let all: u64 = these.iter().fold(0, |all, l| all | l.mask);
        together && all == mask(event) && stands_in_front(others, rest)
    })
}

/// Every event of a rule.
fn events(kind: &Kind) -> Vec<&Event> {
    let lists: Vec<&Vec<Event>> = match kind {
        Kind::Never(events) => vec![events],
        Kind::After { from, until, never } => vec![from, until, never],
        Kind::Before { first, then } => vec![first, then],
        Kind::OnlyAfter { what, after } => vec![what, after],
        Kind::AtMost {
            of, from, until, ..
        } => vec![of, from, until],
        Kind::InARow(words) => words.iter().flatten().collect(),
        Kind::Sequence(_) => Vec::new(),
    };
    lists.into_iter().flatten().collect()
}
