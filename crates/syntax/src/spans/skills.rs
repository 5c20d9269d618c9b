//! Removes the source positions from the syntax trees of skills and orders.

use super::super::ast::{
    Deletion, Event, Order, OrderRule, Regex, RegexKind, SkillCalls, SkillItem, SkillSet,
};
use super::{arguments, name, names};
use linewright_core::source::Span;

pub(super) fn skills(set: &mut SkillSet) {
    name(&mut set.name);
    for item in &mut set.items {
        match item {
            SkillItem::Component(c) => {
                name(&mut c.name);
                names(&mut c.situations);
                names(&mut c.initial);
                for skill in &mut c.skills {
                    name(&mut skill.name);
                    names(&mut skill.effect);
                }
            }
            SkillItem::Order(o) => order(o),
        }
    }
}

pub(super) fn skill_calls(calls: &mut SkillCalls) {
    name(&mut calls.set);
    names(&mut calls.level);
    arguments(&mut calls.calls);
}

fn order(o: &mut Order) {
    names(&mut o.name);
    names(&mut o.level);
    (o.body, o.span) = (Span::default(), Span::default());
    match &mut o.rule {
        OrderRule::Never(list) | OrderRule::Twice(list) => events(list),
        OrderRule::After { from, until, never } => {
            events(from);
            events(until);
            events(never);
        }
        OrderRule::Before { first: a, then: b } | OrderRule::OnlyAfter { what: a, after: b } => {
            events(a);
            events(b);
        }
        OrderRule::AtMost { count, of, between } => {
            count.1 = Span::default();
            events(of);
            if let Some((from, until)) = between {
                events(from);
                events(until);
            }
        }
        OrderRule::InARow(places) => places.iter_mut().for_each(|p| events(p)),
        OrderRule::Sequence(r) => regex(r),
    }
    o.deletions.iter_mut().for_each(deletion);
}

fn events(list: &mut [Event]) {
    names(list.iter_mut().flat_map(|e| &mut e.skills));
}

fn deletion(d: &mut Deletion) {
    for situation in d.from.iter_mut().chain(&mut d.to) {
        names(&mut situation.component);
        name(&mut situation.label);
    }
}

fn regex(r: &mut Regex) {
    r.span = Span::default();
    match &mut r.kind {
        RegexKind::Empty | RegexKind::Any => {}
        RegexKind::Skill(n) => name(n),
        RegexKind::AnyBut(list) | RegexKind::AnyOrder(list) => names(list),
        RegexKind::Concat(parts) | RegexKind::Either(parts) => parts.iter_mut().for_each(regex),
        RegexKind::Repeat(of, _) => regex(of),
    }
}
