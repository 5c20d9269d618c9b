//! Builds skills, their components, and the orders of their calls.

use super::super::ast::{
    Argument, Deletion, Event, Name, Order, OrderRule, Regex, RegexKind, Situation, Skill,
    SkillCalls, SkillComponent, SkillItem, SkillSet, Times,
};
use super::super::parser::Rule;
use super::{Builder, Children};
use linewright_core::source::Span;
use pest::iterators::Pair;

impl Builder {
    pub(super) fn skills(&mut self, pair: Pair<'_, Rule>) -> SkillSet {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let mut set = SkillSet {
            doc,
            name,
            items: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            match item.as_rule() {
                Rule::skill_component => {
                    let component = self.skill_component(item);
                    set.broken |= component.broken;
                    set.items.push(SkillItem::Component(component));
                }
                Rule::order => set.items.push(SkillItem::Order(self.order(item))),
                _ => {
                    set.broken = true;
                    self.bad(&item);
                }
            }
        }
        set
    }

    fn skill_component(&mut self, pair: Pair<'_, Rule>) -> SkillComponent {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let situations = c.take(Rule::situations);
        let initial = c.take(Rule::initial);
        let mut component = SkillComponent {
            doc,
            name,
            situations: situations.map(|s| self.words(s)).unwrap_or_default(),
            initial: initial.map(|i| self.only_word(i)),
            skills: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            if item.as_rule() == Rule::skill {
                let mut c = Children::of(item);
                component.skills.push(Skill {
                    doc: Self::doc(&mut c),
                    name: self.name(&c.next()),
                    effect: c.take(Rule::effect).map(|e| self.only_word(e)),
                });
            } else {
                component.broken = true;
                self.bad(&item);
            }
        }
        component
    }

    /// Builds `skills Set at level { Left = ... }`.
    pub(super) fn skill_calls(&mut self, pair: Pair<'_, Rule>) -> SkillCalls {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let set = self.name(&c.next());
        let mut calls = SkillCalls {
            set,
            level: c.take(Rule::level).map(|l| self.only_word(l)),
            calls: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            if item.as_rule() == Rule::skill_call {
                let mut c = Children::of(item);
                calls.calls.push(Argument {
                    name: self.name(&c.next()),
                    value: self.expr(c.next()),
                });
            } else {
                calls.broken = true;
                self.bad(&item);
            }
        }
        calls
    }

    fn order(&mut self, pair: Pair<'_, Rule>) -> Order {
        let whole = self.span(&pair);
        // The pair contains the doc comment, but the place of the order begins at its first word.
        let mut words = pair.clone().into_inner();
        let keyword = words.find(|p| p.as_rule() == Rule::k_order);
        let start = keyword.map_or(whole.start, |k| self.span(&k).start);
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = c.take(Rule::order_name).map(|n| self.only_word(n));
        let requirement = c
            .take(Rule::requirement_id)
            .map(|r| Children::of(r).next().as_str().trim().to_owned());
        let level = c.take(Rule::level).map(|l| self.only_word(l));
        let rule = c.next();
        let body = self.span(&rule);
        let rule = self.order_rule(Children::of(rule).next());
        let deletions = c
            .take(Rule::deletes)
            .map(|d| Children::of(d).rest())
            .into_iter()
            .flatten()
            .collect::<Vec<_>>();
        Order {
            doc,
            name,
            requirement,
            level,
            rule,
            body,
            deletions: deletions.into_iter().map(|d| self.deletion(d)).collect(),
            span: Span { start, ..whole },
        }
    }

    fn order_rule(&mut self, pair: Pair<'_, Rule>) -> OrderRule {
        let rule = pair.as_rule();
        let mut c = Children::of(pair);
        match rule {
            Rule::o_after => {
                let from = self.events(c.next());
                let until = c
                    .take(Rule::o_until)
                    .map(|u| self.events(Children::of(u).next()));
                OrderRule::After {
                    from,
                    until: until.unwrap_or_default(),
                    never: self.events(c.next()),
                }
            }
            Rule::o_before => OrderRule::Before {
                first: self.events(c.next()),
                then: self.events(c.next()),
            },
            Rule::o_only_after => OrderRule::OnlyAfter {
                what: self.events(c.next()),
                after: self.events(c.next()),
            },
            Rule::o_at_most => {
                let number = c.next();
                let count = (self.count(&number), self.span(&number));
                let of = self.events(c.next());
                let between = c.take(Rule::o_between).map(|between| {
                    let mut c = Children::of(between);
                    (self.events(c.next()), self.events(c.next()))
                });
                OrderRule::AtMost { count, of, between }
            }
            Rule::o_twice => OrderRule::Twice(self.events(c.next())),
            Rule::o_in_a_row => {
                let places: Vec<_> = c.rest().collect();
                OrderRule::InARow(places.into_iter().map(|p| self.events(p)).collect())
            }
            Rule::o_sequence => {
                let group = c.next();
                let times = c.take(Rule::times);
                OrderRule::Sequence(self.repeated(group, times))
            }
            _ => OrderRule::Never(self.events(c.next())),
        }
    }

    fn events(&mut self, pair: Pair<'_, Rule>) -> Vec<Event> {
        let events = Children::of(pair).rest();
        events
            .map(|event| Event {
                skills: self.words(event),
            })
            .collect()
    }

    fn deletion(&mut self, pair: Pair<'_, Rule>) -> Deletion {
        let mut c = Children::of(pair);
        Deletion {
            from: self.situations(c.next()),
            to: self.situations(c.next()),
        }
    }

    fn situations(&mut self, pair: Pair<'_, Rule>) -> Vec<Situation> {
        let situations = Children::of(pair).rest();
        situations
            .map(|situation| {
                let mut words = Children::of(situation);
                let first = self.name(&words.next());
                match words.take(Rule::word) {
                    Some(label) => Situation {
                        component: Some(first),
                        label: self.name(&label),
                    },
                    None => Situation {
                        component: None,
                        label: first,
                    },
                }
            })
            .collect()
    }

    // ---- regular expressions --------------------------------------------------------------------

    /// Builds `A B | C`. A single part is returned as is, so that brackets around it are not in the
    /// tree.
    fn regex(&mut self, pair: Pair<'_, Rule>) -> Regex {
        let span = self.span(&pair);
        let rule = pair.as_rule();
        let parts: Vec<_> = Children::of(pair).rest().collect();
        let mut parts: Vec<Regex> = parts
            .into_iter()
            .map(|part| match rule {
                Rule::regex => self.regex(part),
                _ => self.element(part),
            })
            .collect();
        if parts.len() == 1 {
            return parts.remove(0);
        }
        let kind = match rule {
            Rule::regex => RegexKind::Either(parts),
            _ => RegexKind::Concat(parts),
        };
        Regex { kind, span }
    }

    fn element(&mut self, pair: Pair<'_, Rule>) -> Regex {
        let mut c = Children::of(pair);
        let of = c.next();
        let times = c.take(Rule::times);
        self.repeated(of, times)
    }

    fn repeated(&mut self, of: Pair<'_, Rule>, times: Option<Pair<'_, Rule>>) -> Regex {
        let of = self.primary(of);
        let Some(times) = times else {
            return of;
        };
        let span = of.span.to(self.span(&times));
        let kind = RegexKind::Repeat(Box::new(of), self.times(times));
        Regex { kind, span }
    }

    fn primary(&mut self, pair: Pair<'_, Rule>) -> Regex {
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::group => match Children::of(pair).pairs.next() {
                // The place includes the brackets, since a repetition begins with them.
                Some(inner) => {
                    let inner = self.regex(inner);
                    return Regex { span, ..inner };
                }
                None => RegexKind::Empty,
            },
            Rule::any_skill => RegexKind::Any,
            Rule::any_but => RegexKind::AnyBut(self.words(pair)),
            Rule::any_order => RegexKind::AnyOrder(self.words(pair)),
            _ => RegexKind::Skill(self.name(&pair)),
        };
        Regex { kind, span }
    }

    fn times(&mut self, pair: Pair<'_, Rule>) -> Times {
        let mut c = Children::of(pair);
        let first = c.next();
        match first.as_rule() {
            Rule::any_times => Times::Any,
            Rule::some_times => Times::Some,
            Rule::maybe => Times::Maybe,
            _ => {
                let low = self.count(&first);
                let high = c.take(Rule::up_to).map(Children::of);
                match high.map(|mut high| high.take(Rule::integer)) {
                    None => Times::Exactly(low),
                    Some(None) => Times::AtLeast(low),
                    Some(Some(high)) => {
                        let high = self.integer(&high).map_or(low, |high| high as u64);
                        Times::Between(low, high)
                    }
                }
            }
        }
    }

    fn words(&mut self, pair: Pair<'_, Rule>) -> Vec<Name> {
        Children::of(pair).rest().map(|w| self.name(&w)).collect()
    }

    fn only_word(&mut self, pair: Pair<'_, Rule>) -> Name {
        self.name(&Children::of(pair).next())
    }
}
