//! The paper's pick-and-place unit, and the sets of rules that are enumerated over it.

use linewright::automata::regex::Regex;
use linewright::order::{Component, Deletion, Event, Kind, Level, Rule, Skill, Skills};
use linewright::source::Span;

pub const LEFT: usize = 0;
pub const RIGHT: usize = 1;
pub const UP: usize = 2;
pub const DOWN: usize = 3;
pub const RELEASE: usize = 4;
pub const GRIP: usize = 5;

/// A component with this number of situations and this initial one.
pub fn component(name: &str, situations: usize, initial: usize) -> Component {
    Component {
        name: name.to_owned(),
        doc: String::new(),
        situations: (0..situations).map(|s| format!("{name}_{s}")).collect(),
        initial,
        span: Span::default(),
    }
}

pub fn skill(name: &str, component: usize, effect: Option<usize>) -> Skill {
    Skill {
        name: name.to_owned(),
        doc: String::new(),
        component,
        effect,
        span: Span::default(),
    }
}

pub fn rule(kind: Kind) -> Rule {
    Rule {
        name: "rule".to_owned(),
        requirement: None,
        doc: String::new(),
        level: Level::Valid,
        kind,
        deletions: Vec::new(),
        span: Span::default(),
        text: String::new(),
    }
}

/// The paper's unit, initially left, up and open, with these rules.
pub fn unit(kinds: impl IntoIterator<Item = Kind>) -> Skills {
    unit_at([0, 0, 0], kinds)
}

/// The same with another initial situation.
pub fn unit_at(initial: [usize; 3], kinds: impl IntoIterator<Item = Kind>) -> Skills {
    let names = [["Left", "Right"], ["Up", "Down"], ["Release", "Grip"]];
    let skills = names.iter().enumerate().flat_map(|(component, both)| {
        let both = both.iter().enumerate();
        both.map(move |(effect, name)| skill(name, component, Some(effect)))
    });
    let components = ["x", "z", "gripper"].into_iter().zip(initial);
    Skills {
        name: "Unit".to_owned(),
        doc: String::new(),
        components: components
            .map(|(name, at)| component(name, 2, at))
            .collect(),
        skills: skills.collect(),
        rules: kinds.into_iter().map(rule).collect(),
        span: Span::default(),
    }
}

/// Any of these skills, one at a time.
pub fn any(skills: &[usize]) -> Vec<Event> {
    skills.iter().map(|s| Event(vec![*s])).collect()
}

/// These skills at once.
pub fn together(skills: &[usize]) -> Vec<Event> {
    vec![Event(skills.to_vec())]
}

/// `after (from) until (until): never (never)`
pub fn after(from: Vec<Event>, until: Vec<Event>, never: Vec<Event>) -> Kind {
    Kind::After { from, until, never }
}

pub fn before(first: Vec<Event>, then: Vec<Event>) -> Kind {
    Kind::Before { first, then }
}

pub fn only_after(what: Vec<Event>, after: Vec<Event>) -> Kind {
    Kind::OnlyAfter { what, after }
}

/// `at most (count) of (of) between (from) and (until)`
pub fn at_most(count: u32, of: Vec<Event>, from: Vec<Event>, until: Vec<Event>) -> Kind {
    Kind::AtMost {
        count,
        of,
        from,
        until,
    }
}

/// None of these skills twice in a row.
pub fn never_twice(skills: &[usize]) -> Kind {
    Kind::InARow(skills.iter().map(|s| vec![any(&[*s]); 2]).collect())
}

/// "Do not hit the trays."
pub fn trays() -> Kind {
    after(any(&[DOWN]), any(&[UP]), any(&[LEFT, RIGHT]))
}

/// "Do not release a workpiece while transporting."
pub fn transport() -> Kind {
    after(any(&[UP]), any(&[DOWN]), any(&[RELEASE]))
}

/// The paper's unit with its rules and the transitions that the paper deletes for them.
pub fn pick_and_place() -> Skills {
    let mut skills = unit([trays(), transport()]);
    let (x, z, gripper) = (0, 1, 2);
    let delete = |from: &[(usize, usize)], to: &[(usize, usize)]| Deletion {
        from: from.to_vec(),
        to: to.to_vec(),
    };
    skills.rules[0].deletions = vec![
        delete(&[(z, 1), (x, 0)], &[(x, 1)]),
        delete(&[(z, 1), (x, 1)], &[(x, 0)]),
    ];
    skills.rules[1].deletions = vec![
        delete(&[(z, 0), (gripper, 1)], &[(gripper, 0)]),
        delete(&[(z, 1), (gripper, 1)], &[(z, 0), (gripper, 0)]),
    ];
    skills
}

/// A sequence of expressions.
pub fn word(parts: impl IntoIterator<Item = Regex>) -> Regex {
    Regex::Concat(parts.into_iter().collect())
}

pub fn repeat(of: Regex, low: u32, high: Option<u32>) -> Regex {
    Regex::Repeat {
        of: Box::new(of),
        low,
        high,
    }
}

/// The intended sequence of the paper, any number of times: Right, Down, Grip, Up, Left, Down,
/// Release, Up.
pub fn pick_and_place_sequence() -> Regex {
    let skills = [RIGHT, DOWN, GRIP, UP, LEFT, DOWN, RELEASE, UP];
    repeat(word(skills.map(Regex::Letter)), 0, None)
}

/// A cycle with some freedom: down and grip in any order or not at all, at most two other calls,
/// and up.
pub fn loose_sequence() -> Regex {
    let optional = repeat(Regex::AnyOrder(vec![DOWN, GRIP]), 0, Some(1));
    let others = repeat(Regex::AnyBut(vec![DOWN, GRIP, UP]), 1, Some(2));
    let close = Regex::Either(vec![
        Regex::Letter(UP),
        word([Regex::Letter(GRIP), Regex::Letter(UP)]),
    ]);
    repeat(word([optional, others, close]), 0, None)
}
