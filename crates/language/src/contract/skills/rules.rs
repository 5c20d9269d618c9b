//! Resolution of orders: the skills and situations that they mention.

use super::{Resolver, level, near_or_all};
use crate::contract::formula::one_line;
use crate::contract::scope::duplicate_name;
use crate::order::{Deletion, Event, Kind, Level, Rule};
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, OrderRule, SkillItem};
use std::collections::BTreeMap;

/// Maximum `N` in an order `at most N of ...`.
const MAX_COUNT: u64 = 1000;

impl Resolver<'_> {
    /// Resolves the orders. Orders with errors are reported and omitted.
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
                self.findings.push(duplicate_name(name, first));
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
            let generated = || format!("order {}", index + 1);
            rules.push(Rule {
                name: order
                    .name
                    .as_ref()
                    .map_or_else(generated, |n| n.text.clone()),
                requirement: order.requirement.clone(),
                doc: order.doc.clone(),
                level,
                kind,
                deletions,
                // The span excludes the deletions of a published model.
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
        if let Some(arbitrary) = word.filter(|w| w.text == Level::Arbitrary.keyword()) {
            self.error(
                codes::SKILL,
                arbitrary.span,
                "the level arbitrary forbids nothing, so this order would never apply",
                "remove `at arbitrary`, or write `at reasonable` to forbid calls that are harmless but pointless",
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
        if count > MAX_COUNT {
            self.error(
                codes::TOO_LARGE,
                span,
                format!("an order can count to at most {MAX_COUNT}"),
                "count these calls in the machine's contract: `counter done: 0..5000 counts ...`",
            );
            return None;
        }
        u32::try_from(count).ok()
    }

    fn events(&mut self, events: &[ast::Event]) -> Option<Vec<Event>> {
        // All events are resolved, to report all findings at once.
        let events: Vec<Option<Event>> = events.iter().map(|e| self.event(e)).collect();
        events.into_iter().collect()
    }

    fn event(&mut self, event: &ast::Event) -> Option<Event> {
        let separate =
            |a: &str, b: &str| format!("write a comma between them if either is meant: `{a}, {b}`");
        self.at_once(&event.skills, separate).map(Event)
    }

    /// Resolves skills that are called at once, and returns them in ascending order. Reports two
    /// skills of one component; `separate` returns the help text for this error.
    pub(super) fn at_once(
        &mut self,
        names: &[ast::Name],
        separate: impl Fn(&str, &str) -> String,
    ) -> Option<Vec<usize>> {
        let found: Vec<Option<usize>> = names.iter().map(|n| self.find(n)).collect();
        let found: Vec<usize> = found.into_iter().collect::<Option<_>>()?;
        // For each component, the position of its skill in `names`.
        let mut positions: BTreeMap<usize, usize> = BTreeMap::new();
        let mut is_valid = true;
        for (place, skill) in found.iter().enumerate() {
            let component = self.skills[*skill].component;
            let Some(first) = positions.insert(component, place) else {
                continue;
            };
            is_valid = false;
            let (a, b) = (&names[first], &names[place]);
            let of = &self.components[component].name;
            if a.text == b.text {
                self.error(
                    codes::SKILL,
                    b.span,
                    format!("`{}` appears twice in one call", b.text),
                    "remove one of the two; for two calls in a row, write `never ... twice in a row`",
                );
            } else {
                let message = format!(
                    "`{}` and `{}` belong to `{of}`, so they cannot be called at once",
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
        is_valid.then_some(skills)
    }

    fn deletion(&mut self, deletion: &ast::Deletion) -> Option<Deletion> {
        let (from, to) = (self.side(&deletion.from), self.side(&deletion.to));
        Some(Deletion {
            from: from?,
            to: to?,
        })
    }

    /// Resolves situations of several components, and returns them sorted by component. Reports two
    /// situations of one component.
    fn side(&mut self, situations: &[ast::Situation]) -> Option<Vec<(usize, usize)>> {
        let found: Vec<_> = situations.iter().map(|s| self.situation(s)).collect();
        let found: Vec<(usize, usize)> = found.into_iter().collect::<Option<_>>()?;
        let mut places: BTreeMap<usize, usize> = BTreeMap::new();
        let mut is_valid = true;
        for (place, (component, _)) in found.iter().enumerate() {
            if let Some(first) = places.insert(*component, place) {
                is_valid = false;
                let (a, b) = (&situations[first], &situations[place]);
                let message = format!(
                    "`{}` and `{}` are situations of `{}`, which can be in only one of them at a time",
                    a.label.text, b.label.text, self.components[*component].name
                );
                self.error(
                    codes::SKILL,
                    a.span().to(b.span()),
                    message,
                    "remove one of the two, or write two transitions with a comma between them",
                );
            }
        }
        let mut sides = found;
        sides.sort_unstable();
        is_valid.then_some(sides)
    }

    fn situation(&mut self, situation: &ast::Situation) -> Option<(usize, usize)> {
        let label = &situation.label;
        let is = |s: &String| *s == label.text;
        if let Some(name) = &situation.component {
            let Some(index) = self.component_index.get(name.text.as_str()).copied() else {
                self.report_unknown(name, "component", |r| {
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
                format!("`{}` has no situations: remove it", name.text)
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
                self.report_unknown(label, "situation", |r| {
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
                    format!("write {}", full.join(" or ")),
                );
                None
            }
        }
    }

    /// Reports an unknown name, unless it might be declared in text that could not be parsed.
    fn report_unknown(&mut self, name: &ast::Name, what: &str, known: impl Fn(&Self) -> Vec<&str>) {
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
