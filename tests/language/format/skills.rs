//! Random sets of skills whose names are words elsewhere.

use super::{Choices, name};
use linewright::source::Span;
use linewright::syntax::ast::*;

/// Among skills the words of orders are ordinary names, and so are the letters of temporal
/// operators.
const WORDS: &[&str] = &[
    "Left",
    "Up_2",
    "order",
    "component",
    "at",
    "most",
    "after",
    "until",
    "before",
    "only",
    "twice",
    "sequence",
    "deletes",
    "between",
    "skills",
    "G",
    "X",
    "Größe",
];

impl Choices<'_> {
    fn word(&mut self) -> Name {
        name(WORDS[self.pick(WORDS.len())])
    }

    pub(super) fn skill_set(&mut self) -> SkillSet {
        SkillSet {
            doc: self.doc(),
            name: self.name(),
            items: self.list(0, 5, |c| match c.pick(3) {
                0 => SkillItem::Component(c.skill_component()),
                _ => SkillItem::Order(c.order()),
            }),
            broken: false,
        }
    }

    fn skill_component(&mut self) -> SkillComponent {
        let situations = self.list(0, 3, Self::word);
        SkillComponent {
            doc: self.doc(),
            name: self.word(),
            initial: (!situations.is_empty())
                .then(|| self.option(Self::word))
                .flatten(),
            situations,
            skills: self.list(0, 3, |c| Skill {
                doc: c.doc(),
                name: c.word(),
                effect: c.option(Self::word),
            }),
            broken: false,
        }
    }

    pub(super) fn skill_calls(&mut self) -> SkillCalls {
        SkillCalls {
            set: self.name(),
            level: self.option(Self::word),
            calls: self.list(0, 4, |c| Argument {
                name: c.word(),
                value: c.expr(),
            }),
            broken: false,
        }
    }

    fn order(&mut self) -> Order {
        Order {
            doc: self.doc(),
            name: self.option(Self::word),
            requirement: self.option(|c| ["R-7", "a, b"][c.pick(2)].to_owned()),
            level: self.option(Self::word),
            rule: self.order_rule(),
            body: Span::default(),
            deletions: self.list(0, 3, |c| Deletion {
                from: c.list(1, 3, Self::situation),
                to: c.list(1, 3, Self::situation),
            }),
            span: Span::default(),
        }
    }

    fn situation(&mut self) -> Situation {
        Situation {
            component: self.option(Self::word),
            label: self.word(),
        }
    }

    fn events(&mut self) -> Vec<Event> {
        self.list(1, 3, |c| Event {
            skills: c.list(1, 3, Self::word),
        })
    }

    fn order_rule(&mut self) -> OrderRule {
        match self.pick(8) {
            0 => OrderRule::Never(self.events()),
            1 => OrderRule::After {
                from: self.events(),
                until: self.option(Self::events).unwrap_or_default(),
                never: self.events(),
            },
            2 => OrderRule::Before {
                first: self.events(),
                then: self.events(),
            },
            3 => OrderRule::OnlyAfter {
                what: self.events(),
                after: self.events(),
            },
            4 => OrderRule::AtMost {
                count: (self.count(), Span::default()),
                of: self.events(),
                between: self.option(|c| (c.events(), c.events())),
            },
            5 => OrderRule::Twice(self.events()),
            6 => OrderRule::InARow(self.list(2, 4, Self::events)),
            _ => OrderRule::Sequence(self.regex()),
        }
    }

    fn regex(&mut self) -> Regex {
        use RegexKind::{Any, AnyBut, AnyOrder, Concat, Either, Empty, Repeat};
        self.depth += 1;
        let leaf = self.depth > 8;
        let kind = match self.pick(if leaf { 5 } else { 8 }) {
            0 => RegexKind::Skill(self.word()),
            1 => Empty,
            2 => Any,
            3 => AnyBut(self.list(1, 3, Self::word)),
            4 => AnyOrder(self.list(2, 3, Self::word)),
            5 => Concat(self.list(2, 4, Self::regex)),
            6 => Either(self.list(2, 3, Self::regex)),
            _ => Repeat(Box::new(self.regex()), self.times()),
        };
        self.depth -= 1;
        Regex {
            kind,
            span: Span::default(),
        }
    }

    fn times(&mut self) -> Times {
        match self.pick(6) {
            0 => Times::Any,
            1 => Times::Some,
            2 => Times::Maybe,
            3 => Times::Exactly(self.count()),
            4 => Times::AtLeast(self.count()),
            _ => Times::Between(self.count(), self.count()),
        }
    }
}
