//! Prints lines.

use super::super::ast::{
    BufferOrder, Days, Hours, Line, LineItem, PartCount, Shift, StationItem, Stop, StopChoice,
    Supply,
};
use super::super::binds;
use super::expression::Continuation;
use super::printer::Printer;
use linewright_core::source::Span;

impl Printer<'_> {
    pub(super) fn plant_line(&mut self, place: Span, l: &Line) {
        self.doc(&l.doc);
        self.put("line ");
        self.name(&l.name);
        self.block(place, &l.items, false, Self::line_item);
    }

    fn counted(&mut self, c: &PartCount) {
        self.before(c.name.span);
        self.put(&format!("{} {}", c.count, c.name.text));
    }

    fn line_item(&mut self, place: Span, item: &LineItem) {
        match item {
            LineItem::Part {
                name,
                bill,
                properties,
            } => {
                self.put("part ");
                self.name(name);
                if !bill.is_empty() {
                    self.put(" from ");
                    self.list(bill, |c| c.name.span, Self::counted);
                }
                if !properties.is_empty() {
                    self.block(place, properties, true, |p, _, t| p.typed("property ", t));
                }
            }
            LineItem::Product(names) => {
                self.put("product ");
                self.list(names, |n| n.span, Self::name);
            }
            LineItem::Source {
                name,
                part,
                supply,
                most,
            } => {
                self.put("source ");
                self.name(name);
                self.put(": ");
                self.name(part);
                self.supply(supply);
                if let Some(most) = most {
                    self.put(&format!(", at most {most} in the line"));
                }
            }
            LineItem::Store { name, stock } => {
                self.put("store ");
                self.name(name);
                if !stock.is_empty() {
                    self.put(": ");
                    self.list(stock, |c| c.name.span, Self::counted);
                }
            }
            LineItem::Sink {
                name,
                rejects,
                reorder,
            } => {
                self.put("sink ");
                self.name(name);
                self.put(if *rejects { " rejects" } else { "" });
                if let Some(source) = reorder {
                    self.put(" reorder ");
                    self.name(source);
                }
            }
            LineItem::Buffer {
                name,
                capacity,
                order,
                dwell,
                shelf_life,
            } => {
                self.put("buffer ");
                self.name(name);
                self.put(&format!(" capacity {capacity}"));
                match order {
                    None => {}
                    Some(BufferOrder::LastIn) => self.put(" lifo"),
                    Some(BufferOrder::Highest(property) | BufferOrder::Lowest(property)) => {
                        let highest = matches!(order, Some(BufferOrder::Highest(_)));
                        self.put(if highest { " highest " } else { " lowest " });
                        self.name(property);
                        self.put(" first");
                    }
                }
                if let Some(dwell) = dwell {
                    self.put(" dwell ");
                    self.duration(dwell);
                }
                if let Some(life) = shelf_life {
                    self.put(" shelf life ");
                    self.expression(life);
                }
            }
            LineItem::Conveyor {
                name,
                machine,
                options,
            } => {
                self.put("conveyor ");
                self.name(name);
                let mut before = name.span;
                if let Some((machine, arguments)) = machine {
                    self.put(": ");
                    self.name(machine);
                    self.arguments(machine.span, arguments);
                    before = arguments.last().map_or(machine.span, |a| a.value.span);
                }
                for (word, value) in options {
                    self.clause(&format!("{} ", word.text), before, value);
                    before = value.span;
                }
            }
            LineItem::Station {
                name,
                machine,
                times,
                items,
            } => {
                self.put("station ");
                self.name(name);
                if let Some((machine, arguments)) = machine {
                    self.put(": ");
                    self.name(machine);
                    self.arguments(machine.span, arguments);
                }
                if let Some(times) = times {
                    self.put(&format!(" times {}", times.count));
                }
                if !items.is_empty() {
                    self.block(place, items, true, |p, _, item| p.station_item(item));
                }
            }
            LineItem::Route { part, stops, when } => {
                self.put("route ");
                self.name(part);
                self.put(": ");
                self.level(|p, level| {
                    for (i, stop) in stops.iter().enumerate() {
                        if i > 0 {
                            p.put(" ->");
                            p.nest += usize::from(i == 1);
                            let forced = p.broken(stops[i - 1].span, stop.span);
                            p.gap(level, true, forced);
                        }
                        p.stop(stop);
                    }
                });
                let last = stops.last().map_or(part.span, |s| s.span);
                if let Some(when) = when {
                    self.clause("when ", last, when);
                } else if self
                    .words_between(last.end, place.end)
                    .any(|w| w == "otherwise")
                {
                    // This word is optional and has no effect, so it is not in the tree.
                    self.put(" otherwise");
                }
            }
            LineItem::Requirement {
                name,
                metric,
                of,
                op,
                bound,
                per_hour,
                ..
            } => {
                self.put("requirement ");
                self.name(name);
                self.put(": ");
                self.name(metric);
                if let Some(of) = of {
                    self.put("(");
                    self.name(of);
                    self.put(")");
                }
                self.put(&format!(" {} ", op.sign()));
                self.expression(bound);
                self.put(if *per_hour { " per hour" } else { "" });
            }
            LineItem::Shift(shift) => self.shift(shift),
            LineItem::Start(date) => {
                self.put("start ");
                self.name(date);
            }
            LineItem::Holiday(first, last) => {
                self.put("holiday ");
                self.name(first);
                if let Some(last) = last {
                    self.put(" to ");
                    self.name(last);
                }
            }
            LineItem::Limit(e, products) => {
                self.setting("limit ", e);
                self.put(if *products { " products" } else { "" });
            }
            LineItem::Const(c) => self.const_decl(c),
        }
    }

    fn supply(&mut self, supply: &Supply) {
        match supply {
            Supply::OnOrder => self.put(" on order"),
            Supply::At(column) => {
                self.put(" at ");
                self.column(column);
            }
            Supply::Every {
                interval,
                random,
                limit,
            } => {
                self.put(if *random { " every random " } else { " every " });
                self.duration(interval);
                if let Some(limit) = limit {
                    self.put(&format!(" limit {limit}"));
                }
            }
        }
    }

    fn stop(&mut self, stop: &Stop) {
        for (i, place) in stop.places.iter().enumerate() {
            self.put(if i > 0 { ", " } else { "" });
            self.name(place);
        }
        let Some(choice) = &stop.choice else { return };
        self.put(&format!(" {}", choice.words()));
        if let StopChoice::Probability(shares) = choice {
            for (i, share) in shares.iter().enumerate() {
                self.put(if i > 0 { ", " } else { " " });
                self.operand(share, binds::ADDITIVE, Continuation::Operator);
            }
        }
    }

    fn shift(&mut self, shift: &Shift) {
        self.put("shift ");
        self.hours(&shift.hours);
        let mut last = shift.hours.span;
        if let Some(first) = shift.days.first() {
            self.option("on ", last, first.span());
            self.list(&shift.days, Days::span, |p, days| {
                p.name(&days.first);
                if let Some(last) = &days.last {
                    p.put(" to ");
                    p.name(last);
                }
            });
            last = shift.days.last().map_or(last, Days::span);
        }
        if let Some(first) = shift.breaks.first() {
            self.option("break ", last, first.span);
            self.list(&shift.breaks, |hours| hours.span, Self::hours);
        }
        self.put(if shift.finish_work {
            " finish work"
        } else {
            ""
        });
    }

    fn hours(&mut self, hours: &Hours) {
        self.expression(&hours.from);
        self.setting(" to ", &hours.to);
    }

    /// Prints the first word of an option, on a new line if it does not fit or the author ended the
    /// line there.
    fn option(&mut self, word: &str, before: Span, first: Span) {
        let forced = self.broken(before, first);
        self.nest = 1;
        self.gap(0, true, forced);
        self.put(word);
        self.nest = 0;
    }

    fn station_item(&mut self, item: &StationItem) {
        match item {
            StationItem::Perform { operations, part } => {
                self.put("perform ");
                self.list(operations, |p| p.name.span, Self::performed);
                self.put(" on ");
                self.name(part);
            }
            StationItem::Takes { duration, part } => {
                self.put("takes ");
                self.duration(duration);
                if let Some(part) = part {
                    self.put(if begins_with_vowel(&part.text) {
                        " an "
                    } else {
                        " a "
                    });
                    self.name(part);
                }
            }
            StationItem::Sets {
                property,
                index,
                value,
                part,
            } => {
                self.put("sets ");
                self.name(property);
                if let Some(index) = index {
                    self.setting("[", index);
                    self.put("]");
                }
                self.setting(" = ", value);
                if let Some(part) = part {
                    self.put(" on ");
                    self.name(part);
                }
            }
            StationItem::Setup(duration) => {
                self.put("setup ");
                self.duration(duration);
            }
            StationItem::IdlePower(e) => self.setting("idle power ", e),
            StationItem::Power(e) => self.setting("power ", e),
            StationItem::Failures(f) => self.failures(f),
            StationItem::Shift(shift) => self.shift(shift),
            StationItem::Defect {
                part,
                probability,
                one_of,
                property,
                value,
            } => {
                self.put("defect on ");
                self.name(part);
                self.setting(" probability ", probability);
                self.put(": ");
                if *one_of {
                    self.put("one of ");
                }
                self.name(property);
                self.setting(" becomes ", value);
            }
        }
    }
}

/// Whether a name is written after `an` rather than `a`.
fn begins_with_vowel(name: &str) -> bool {
    name.starts_with(['a', 'e', 'i', 'o', 'u', 'A', 'E', 'I', 'O', 'U'])
}
