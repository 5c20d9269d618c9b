//! Random skills and rules of all kinds.

use super::units::{component, rule, skill};
use linewright::automata::regex::Regex;
use linewright::order::supervisor::Options;
use linewright::order::{Component, Event, Kind, Level, Rule, Serialisation, Skill, Skills};
use linewright::source::Span;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{select, subsequence};

/// Components with their skills, without rules.
#[derive(Debug, Clone)]
pub struct Layout {
    components: Vec<Component>,
    skills: Vec<Skill>,
}

/// Limits of the random sets.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    pub components: usize,
    /// Maximum number of skills of a component.
    pub skills: usize,
    /// Maximum number of rules.
    pub rules: usize,
    /// Maximum number of skills of an event.
    pub at_once: usize,
    /// Approximate number of sequences among twenty rules.
    pub sequences: u32,
}

/// A component: its number of situations, its initial situation, and the effects of its skills.
fn one_component(skills: usize) -> impl Strategy<Value = (usize, usize, Vec<Option<usize>>)> {
    (0..=3_usize).prop_flat_map(move |situations| {
        let effect = prop_oneof![
            4 => (0..situations.max(1)).prop_map(Some),
            1 => Just(None),
        ];
        let effect = effect.prop_map(move |e| e.filter(|_| situations > 0));
        (
            Just(situations),
            0..situations.max(1),
            vec(effect, 1..=skills),
        )
    })
}

pub fn layout(size: Size) -> impl Strategy<Value = Layout> {
    let components = vec(one_component(size.skills), 1..=size.components);
    components.prop_map(|drawn| {
        let mut layout = Layout {
            components: Vec::new(),
            skills: Vec::new(),
        };
        for (number, (situations, initial, effects)) in drawn.into_iter().enumerate() {
            let name = format!("c{number}");
            layout
                .components
                .push(component(&name, situations, initial));
            for effect in effects {
                let name = format!("S{}", layout.skills.len());
                layout.skills.push(skill(&name, number, effect));
            }
        }
        layout
    })
}

impl Layout {
    fn with_rules(self, rules: Vec<Rule>) -> Skills {
        Skills {
            name: "Random".to_owned(),
            doc: String::new(),
            components: self.components,
            skills: self.skills,
            rules,
            span: Span::default(),
        }
    }

    /// A skill, or occasionally several of different components.
    fn event(&self, at_once: usize) -> BoxedStrategy<Event> {
        let count = self.skills.len();
        let single = (0..count).prop_map(|s| Event(vec![s]));
        let most = at_once.min(self.components.len());
        if most < 2 {
            return single.boxed();
        }
        let mut own: Vec<Vec<usize>> = vec![Vec::new(); self.components.len()];
        for (number, skill) in self.skills.iter().enumerate() {
            own[skill.component].push(number);
        }
        let several = subsequence(own, 2..=most).prop_flat_map(|components| {
            let one_each: Vec<_> = components.into_iter().map(select).collect();
            // Skills are numbered component by component, so that they are in ascending order.
            one_each.prop_map(Event)
        });
        prop_oneof![4 => single, 1 => several].boxed()
    }

    fn regex(&self) -> impl Strategy<Value = Regex> + use<> {
        let count = self.skills.len();
        let all: Vec<usize> = (0..count).collect();
        let leaf = prop_oneof![
            8 => (0..count).prop_map(Regex::Letter),
            3 => subsequence(all.clone(), 0..=count.min(2)).prop_map(Regex::AnyBut),
            2 => subsequence(all, 1..=count.min(3)).prop_map(Regex::AnyOrder),
            1 => Just(Regex::Empty),
        ];
        let tree = leaf.prop_recursive(3, 10, 3, |inner| {
            let repeat = (inner.clone(), 0..3_u32, proptest::option::of(0..3_u32));
            let repeat = repeat.prop_map(|(of, low, more)| Regex::Repeat {
                of: Box::new(of),
                low,
                high: more.map(|more| low + more),
            });
            prop_oneof![
                3 => vec(inner.clone(), 2..4).prop_map(Regex::Concat),
                2 => vec(inner, 2..4).prop_map(Regex::Either),
                3 => repeat,
            ]
        });
        prop_oneof![40 => tree, 1 => Just(Regex::Nothing)]
    }

    fn kind(&self, size: Size) -> BoxedStrategy<Kind> {
        let Size {
            at_once, sequences, ..
        } = size;
        let some = || vec(self.event(at_once), 1..=2);
        let any = || vec(self.event(at_once), 0..=2);
        let word = vec(vec(self.event(at_once), 1..=2), 1..=3);
        let other = prop_oneof![
            1 => some().prop_map(Kind::Never),
            4 => (some(), any(), some())
                .prop_map(|(from, until, never)| Kind::After { from, until, never }),
            2 => (some(), some()).prop_map(|(first, then)| Kind::Before { first, then }),
            2 => (some(), some()).prop_map(|(what, after)| Kind::OnlyAfter { what, after }),
            3 => (0..3_u32, some(), any(), any()).prop_map(|(count, of, from, until)| {
                Kind::AtMost { count, of, from, until }
            }),
            3 => vec(word, 1..=2).prop_map(Kind::InARow),
        ];
        prop_oneof![
            20 - sequences => other,
            sequences => self.regex().prop_map(Kind::Sequence),
        ]
        .boxed()
    }

    fn rules(&self, size: Size) -> impl Strategy<Value = Vec<Rule>> + use<> {
        let level = prop_oneof![4 => Just(Level::Valid), 1 => Just(Level::Reasonable)];
        let one = (self.kind(size), level).prop_map(|(kind, level)| Rule {
            level,
            ..rule(kind)
        });
        vec(one, 0..=size.rules)
    }
}

/// Skills with rules.
pub fn skills(size: Size) -> impl Strategy<Value = Skills> {
    layout(size).prop_flat_map(move |layout| {
        let rules = layout.rules(size);
        rules.prop_map(move |rules| layout.clone().with_rules(rules))
    })
}

/// The same skills with two sets of rules, some of which are in both.
pub fn two_sets(size: Size) -> impl Strategy<Value = (Skills, Skills)> {
    layout(size).prop_flat_map(move |layout| {
        let rules = || layout.rules(size);
        (rules(), rules(), rules()).prop_map(move |(shared, one, other)| {
            let with = |more: Vec<Rule>| {
                let rules = shared.iter().cloned().chain(more).collect();
                layout.clone().with_rules(rules)
            };
            (with(one), with(other))
        })
    })
}

pub fn options() -> impl Strategy<Value = Options> {
    let level = prop_oneof![
        1 => Just(Level::Arbitrary),
        6 => Just(Level::Valid),
        3 => Just(Level::Reasonable),
    ];
    let serialisation = select(vec![Serialisation::Every, Serialisation::Some]);
    (level, serialisation).prop_map(|(level, serialisation)| Options {
        level,
        serialisation,
        ..Options::default()
    })
}

/// Calls of up to a number of these skills at once, sensible or not.
pub fn program(
    skills: &Skills,
    at_once: usize,
    length: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = Vec<u64>> + use<> {
    let all: Vec<u64> = (0..skills.skills.len()).map(|s| 1 << s).collect();
    let most = at_once.min(all.len());
    let call = prop_oneof![
        2 => select(all.clone()),
        1 => subsequence(all, 1..=most).prop_map(|skills| skills.iter().sum()),
    ];
    vec(call, length)
}
