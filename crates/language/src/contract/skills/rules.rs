//! Orders: resolves the skills and situations that they mention.

use super::{Resolver, level, near_or_all};
use crate::contract::formula::one_line;
use crate::contract::scope::double;
use crate::order::{Deletion, Event, Kind, Level, Rule};
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, OrderRule, SkillItem};
use std::collections::BTreeMap;

/// Maximum count of `at most N`.
const MOST_COUNT: u64 = 1000;

impl Resolver<'_> {
    /// Resolves the rules that are free of errors.
    pub(super) fn rules(&mut self) -> Vec<Rule> {
        let orders = self.set.items.iter().filter_map(|item| match item {
            SkillItem::Order(order) => Some(order),
            SkillItem::Component(_) => None,
        });
        let mut names: BTreeMap<&str, Span> = BTreeMap::new();
        let mut rules = Vec::new();
        for (index, order) in orders.enumerate() {
            if let Some(name) = &order.name
                && let Some(first) = names.insert(&name.text, name.span)
            {
                self.findings.push(double(name, first));
            }
            let level = self.level(order);
            let kind = self.kind(&order.rule);
            let deletions: Vec<Deletion> = order
                .deletions
                .iter()
                .filter_map(|d| self.deletion(d))
                .collect();
            let (Some(kind), Some(level)) = (kind, level) else {
                continue;
            };
            let made_up = || format!("order {}", index + 1);
            rules.push(Rule {
                name: order.name.as_ref().map_or_else(made_up, |n| n.text.clone()),
                requirement: order.requirement.clone(),
                doc: order.doc.clone(),
                level,
                kind,
                deletions,
                // Without the deletions of a published model.
                span: Span {
                    end: order.body.end,
                    ..order.span
                },
                text: one_line(self.sources.text(order.body)),
            });
        }
        rules
    }

    fn level(&mut self, order: &ast::Order) -> Option<Level> {
        let word = order.level.as_ref();
        if let Some(arbitrary) = word.filter(|w| w.text == Level::Arbitrary.word()) {
            self.error(
                codes::SKILL,
                arbitrary.span,
                "at the level arbitrary nothing is forbidden, so that this order would never be kept",
                "leave `at arbitrary` out, or write `at reasonable` for what is allowed and makes no sense",
            );
            return None;
        }
        level(word, &[Level::Valid, Level::Reasonable], &mut self.findings)
    }

    fn kind(&mut self, rule: &OrderRule) -> Option<Kind> {
        Some(match rule {
            OrderRule::Never(events) => Kind::Never(self.events(events)?),
            OrderRule::After { from, until, never } => {
                let (from, until) = (self.events(from), self.events(until));
                let never = self.events(never);
                Kind::After {
                    from: from?,
                    until: until?,
                    never: never?,
                }
            }
            OrderRule::Before { first, then } => {
                let (first, then) = (self.events(first), self.events(then));
                Kind::Before {
                    first: first?,
                    then: then?,
                }
            }
            OrderRule::OnlyAfter { what, after } => {
                let (what, after) = (self.events(what), self.events(after));
                Kind::OnlyAfter {
                    what: what?,
                    after: after?,
                }
            }
            OrderRule::AtMost { count, of, between } => {
                let count = self.at_most(*count);
                let of = self.events(of);
                let none = (Vec::new(), Vec::new());
                let (from, until) = between.as_ref().unwrap_or(&none);
                let (from, until) = (self.events(from), self.events(until));
                Kind::AtMost {
                    count: count?,
                    of: of?,
                    from: from?,
                    until: until?,
                }
            }
            OrderRule::Twice(events) => {
                let words = self.events(events)?.into_iter();
                Kind::InARow(words.map(|e| vec![vec![e.clone()], vec![e]]).collect())
            }
            OrderRule::InARow(places) => {
                let places: Vec<_> = places.iter().map(|p| self.events(p)).collect();
                Kind::InARow(vec![places.into_iter().collect::<Option<_>>()?])
            }
            OrderRule::Sequence(regex) => Kind::Sequence(self.sequence(regex)?),
        })
    }

    fn at_most(&mut self, (count, span): (u64, Span)) -> Option<u32> {
        if count > MOST_COUNT {
            self.error(
                codes::TOO_LARGE,
                span,
                format!("an order counts up to {MOST_COUNT} at most"),
                "count what is counted here in the machine's contract: `counter done: 0..5000 counts ...`",
            );
            return None;
        }
        u32::try_from(count).ok()
    }

    fn events(&mut self, events: &[ast::Event]) -> Option<Vec<Event>> {
        // All of them are resolved, even if the first is wrong.
        let events: Vec<Option<Event>> = events.iter().map(|e| self.event(e)).collect();
        events.into_iter().collect()
    }

    fn event(&mut self, event: &ast::Event) -> Option<Event> {
        let separate = |a: &str, b: &str| {
            format!("write a comma between them where either is meant: `{a}, {b}`")
        };
        self.at_once(&event.skills, separate).map(Event)
    }

    /// Resolves skills that are called at once, in ascending order: each once, and at most one per
    /// component.
    pub(super) fn at_once(
        &mut self,
        names: &[ast::Name],
        separate: impl Fn(&str, &str) -> String,
    ) -> Option<Vec<usize>> {
        let found: Vec<Option<usize>> = names.iter().map(|n| self.find(n)).collect();
        let found: Vec<usize> = found.into_iter().collect::<Option<_>>()?;
        // By component, which is by skill.
        let mut moved: BTreeMap<usize, usize> = BTreeMap::new();
        let mut sound = true;
        for (place, skill) in found.iter().enumerate() {
            let component = self.skills[*skill].component;
            let Some(first) = moved.insert(component, place) else {
                continue;
            };
            sound = false;
            let (a, b) = (&names[first], &names[place]);
            let of = &self.components[component].name;
            if a.text == b.text {
                self.error(
                    codes::SKILL,
                    b.span,
                    format!("`{}` appears twice in what is called at once", b.text),
                    "leave one of the two out; `never ... twice in a row` refers to calls one after the other",
                );
            } else {
                let message = format!(
                    "`{}` and `{}` belong to `{of}`, and are never called at once",
                    a.text, b.text
                );
                self.error(
                    codes::SKILL,
                    a.span.to(b.span),
                    message,
                    separate(&a.text, &b.text),
                );
            }
        }
        let mut skills = found;
        skills.sort_unstable();
        sound.then_some(skills)
    }

    fn deletion(&mut self, deletion: &ast::Deletion) -> Option<Deletion> {
        let (from, to) = (self.side(&deletion.from), self.side(&deletion.to));
        Some(Deletion {
            from: from?,
            to: to?,
        })
    }

    /// Resolves situations of several components, in their order.
    fn side(&mut self, situations: &[ast::Situation]) -> Option<Vec<(usize, usize)>> {
        let found: Vec<_> = situations.iter().map(|s| self.situation(s)).collect();
        let found: Vec<(usize, usize)> = found.into_iter().collect::<Option<_>>()?;
        let mut places: BTreeMap<usize, usize> = BTreeMap::new();
        let mut sound = true;
        for (place, (component, _)) in found.iter().enumerate() {
            if let Some(first) = places.insert(*component, place) {
                sound = false;
                let (a, b) = (&situations[first], &situations[place]);
                let message = format!(
                    "`{}` and `{}` are situations of `{}`, which is in one at a time",
                    a.label.text, b.label.text, self.components[*component].name
                );
                self.error(
                    codes::SKILL,
                    a.span().to(b.span()),
                    message,
                    "leave one of the two out, or write two transitions with a comma between them",
                );
            }
        }
        let mut sides = found;
        sides.sort_unstable();
        sound.then_some(sides)
    }

    fn situation(&mut self, situation: &ast::Situation) -> Option<(usize, usize)> {
        let label = &situation.label;
        let is = |s: &String| *s == label.text;
        if let Some(name) = &situation.component {
            let Some(index) = self.component_index.get(name.text.as_str()).copied() else {
                self.unknown(name, "component", |r| {
                    r.components.iter().map(|c| c.name.as_str()).collect()
                });
                return None;
            };
            let component = &self.components[index];
            if let Some(place) = component.situations.iter().position(is) {
                return Some((index, place));
            }
            let known: Vec<&str> = component.situations.iter().map(String::as_str).collect();
            let help = if known.is_empty() {
                format!("`{}` is always in the same one: leave it out", name.text)
            } else {
                near_or_all(&label.text, known.into_iter(), "its situations are")
            };
            let message = format!("`{}` has no situation `{}`", name.text, label.text);
            self.error(codes::NAME_UNKNOWN, label.span, message, help);
            return None;
        }
        let with = self.components.iter().enumerate();
        let found: Vec<(usize, usize)> = with
            .filter_map(|(i, c)| Some((i, c.situations.iter().position(is)?)))
            .collect();
        match found.as_slice() {
            [one] => Some(*one),
            [] => {
                self.unknown(label, "situation", |r| {
                    let all = r.components.iter().flat_map(|c| &c.situations);
                    all.map(String::as_str).collect()
                });
                None
            }
            several => {
                let full: Vec<String> = several
                    .iter()
                    .map(|(c, _)| format!("`{}.{}`", self.components[*c].name, label.text))
                    .collect();
                self.error(
                    codes::NAME_UNKNOWN,
                    label.span,
                    format!("`{}` is a situation of several components", label.text),
                    format!("write which one is meant: {}", full.join(" or ")),
                );
                None
            }
        }
    }

    /// Reports an undeclared name, unless a part that could not be parsed may have declared it.
    fn unknown(&mut self, name: &ast::Name, what: &str, known: impl Fn(&Self) -> Vec<&str>) {
        self.tainted = true;
        if self.set.broken {
            return;
        }
        let help = near_or_all(
            &name.text,
            known(self).into_iter(),
            &format!("the {what}s are"),
        );
        let message = format!("`{}` has no {what} `{}`", self.set.name.text, name.text);
        self.error(codes::NAME_UNKNOWN, name.span, message, help);
    }
}
