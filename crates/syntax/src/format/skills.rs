//! Prints skills and their orders.
//!
//! Each skill is on a separate line without a comma; a component with only one skill can be on one
//! line. Regular expressions have brackets where the grammar needs them. `A & B` among other
//! operands has brackets, too, because it would be easily misread without them.

use super::super::ast::{
    Deletion, Event, Name, Order, OrderRule, Regex, RegexKind, Situation, SkillCalls,
    SkillComponent, SkillItem, SkillSet, Times,
};
use super::printer::Printer;
use linewright_core::source::Span;

/// Context in which a regular expression is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum RegexContext {
    /// Within brackets.
    Brackets,
    /// An alternative of `|`.
    Either,
    /// A part of a concatenation.
    Concat,
    /// Before `*` or another repetition.
    Repeat,
}

impl Printer<'_> {
    pub(super) fn skills(&mut self, place: Span, set: &SkillSet) {
        self.doc(&set.doc);
        self.put("skills ");
        self.name(&set.name);
        self.block(place, &set.items, false, |p, place, item| match item {
            SkillItem::Component(c) => p.skill_component(place, c),
            SkillItem::Order(o) => p.order(o),
        });
    }

    fn skill_component(&mut self, place: Span, c: &SkillComponent) {
        self.doc(&c.doc);
        self.put("component ");
        self.name(&c.name);
        if !c.situations.is_empty() {
            self.put(": ");
            let span = |n: &Name| n.span;
            self.sequence(["{", "}"], c.name.span, &c.situations, span, Self::name);
        }
        if let Some(initial) = &c.initial {
            self.put(" = ");
            self.name(initial);
        }
        self.block(place, &c.skills, true, |p, _, skill| {
            p.doc(&skill.doc);
            p.name(&skill.name);
            if let Some(effect) = &skill.effect {
                p.put(" -> ");
                p.name(effect);
            }
        });
    }

    pub(super) fn skill_calls(&mut self, place: Span, calls: &SkillCalls) {
        self.put("skills ");
        self.name(&calls.set);
        if let Some(level) = &calls.level {
            self.put(" at ");
            self.name(level);
        }
        self.block(place, &calls.calls, true, |p, _, call| {
            p.name(&call.name);
            p.value(call.name.span, &call.value);
        });
    }

    fn order(&mut self, o: &Order) {
        self.doc(&o.doc);
        self.put("order");
        if let Some(name) = &o.name {
            self.put(" ");
            self.name(name);
        }
        if let Some(requirement) = &o.requirement {
            self.put(&format!(" [{requirement}]"));
        }
        if let Some(level) = &o.level {
            self.put(" at ");
            self.name(level);
        }
        self.put(": ");
        self.order_rule(&o.rule);
        if let Some(first) = o.deletions.first() {
            let forced = self.broken(o.body, first.span());
            self.nest = 1;
            self.gap(0, true, forced);
            self.put("deletes ");
            self.list(&o.deletions, Deletion::span, |p, d| {
                p.situations(&d.from);
                p.put(" -> ");
                p.situations(&d.to);
            });
            self.nest = 0;
        }
    }

    fn order_rule(&mut self, rule: &OrderRule) {
        match rule {
            OrderRule::Never(events) => self.words_and_events(&[("never ", events)]),
            OrderRule::After { from, until, never } if until.is_empty() => {
                self.words_and_events(&[("after ", from), (": never ", never)]);
            }
            OrderRule::After { from, until, never } => {
                self.words_and_events(&[("after ", from), (" until ", until), (": never ", never)]);
            }
            OrderRule::Before { first, then } => {
                self.words_and_events(&[("", first), (" before ", then)]);
            }
            OrderRule::OnlyAfter { what, after } => {
                self.words_and_events(&[("", what), (" only after ", after)]);
            }
            OrderRule::AtMost { count, of, between } => {
                self.before(count.1);
                self.words_and_events(&[(&format!("at most {} of ", count.0), of)]);
                if let Some((from, until)) = between {
                    self.words_and_events(&[(" between ", from), (" and ", until)]);
                }
            }
            OrderRule::Twice(events) => {
                self.words_and_events(&[("never ", events)]);
                self.put(" twice in a row");
            }
            OrderRule::InARow(places) => {
                for (i, place) in places.iter().enumerate() {
                    let word = if i == 0 { "never " } else { " then " };
                    self.words_and_events(&[(word, place)]);
                }
            }
            OrderRule::Sequence(regex) => self.sequence_of(regex),
        }
    }

    fn words_and_events(&mut self, parts: &[(&str, &[Event])]) {
        for (word, events) in parts {
            self.put(word);
            self.list(events, Event::span, |p, event| {
                for (i, skill) in event.skills.iter().enumerate() {
                    p.put(if i > 0 { " & " } else { "" });
                    p.name(skill);
                }
            });
        }
    }

    fn situations(&mut self, situations: &[Situation]) {
        for (i, situation) in situations.iter().enumerate() {
            self.put(if i > 0 { " & " } else { "" });
            if let Some(component) = &situation.component {
                self.name(component);
                self.put(".");
            }
            self.name(&situation.label);
        }
    }

    // ---- regular expressions --------------------------------------------------------------------

    /// Prints `sequence (...)*`, always with brackets, so that the end is clear.
    fn sequence_of(&mut self, regex: &Regex) {
        self.put("sequence ");
        match &regex.kind {
            RegexKind::Repeat(of, times) => self.repeated(of, *times, true),
            _ => self.in_brackets(regex),
        }
    }

    fn in_brackets(&mut self, regex: &Regex) {
        self.before(regex.span);
        self.put("(");
        self.regex(regex, RegexContext::Brackets);
        self.put(")");
    }

    fn repeated(&mut self, of: &Regex, times: Times, brackets: bool) {
        if brackets {
            self.in_brackets(of);
        } else {
            self.regex(of, RegexContext::Repeat);
        }
        self.put(&times.to_string());
    }

    fn regex(&mut self, regex: &Regex, around: RegexContext) {
        use RegexKind::{Any, AnyBut, AnyOrder, Concat, Either, Empty, Repeat, Skill};
        let brackets = match &regex.kind {
            Skill(_) | Any => false,
            // The empty word is printed as `()`.
            Empty => around != RegexContext::Brackets,
            AnyBut(_) | Repeat(..) => around == RegexContext::Repeat,
            Concat(_) | AnyOrder(_) => around >= RegexContext::Concat,
            Either(_) => around >= RegexContext::Either,
        };
        if brackets {
            self.in_brackets(regex);
            return;
        }
        self.before(regex.span);
        match &regex.kind {
            Empty => {}
            Skill(name) => self.name(name),
            Any => self.put("."),
            AnyBut(skills) => {
                self.put("not ");
                self.joined(skills, " | ", skills.len() > 1);
            }
            AnyOrder(skills) => self.joined(skills, " & ", false),
            Concat(parts) => self.parts_of_regex(parts, "", RegexContext::Concat),
            Either(parts) => self.parts_of_regex(parts, " |", RegexContext::Either),
            Repeat(of, times) => self.repeated(of, *times, false),
        }
    }

    fn joined(&mut self, skills: &[Name], sign: &str, brackets: bool) {
        self.put(if brackets { "(" } else { "" });
        for (i, skill) in skills.iter().enumerate() {
            self.put(if i > 0 { sign } else { "" });
            self.name(skill);
        }
        self.put(if brackets { ")" } else { "" });
    }

    fn parts_of_regex(&mut self, parts: &[Regex], sign: &str, around: RegexContext) {
        self.level(|p, level| {
            for (i, part) in parts.iter().enumerate() {
                if i > 0 {
                    p.put(sign);
                    p.nest += usize::from(i == 1);
                    let forced = p.broken(parts[i - 1].span, part.span);
                    p.gap(level, true, forced);
                }
                p.regex(part, around);
            }
        });
    }
}
