//! Builds lines: parts, places and routes.

use super::super::ast::{
    Between, BufferOrder, Column, Copies, Days, Failures, Hours, InterruptedWork, Line, LineItem,
    Name, Outcome, PartCount, Shift, StationItem, Stop, StopChoice, Supply, TimeValue,
};
use super::super::parser::Rule;
use super::expression::binary_op;
use super::{Builder, Children};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use pest::iterators::Pair;

impl Builder {
    pub(super) fn line(&mut self, pair: Pair<'_, Rule>) -> Line {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let mut items = Vec::new();
        let mut unparsed = Vec::new();
        for item in c.rest() {
            self.place(&item);
            let rule = item.as_rule();
            match rule {
                Rule::bad_line_item => {
                    self.bad(&item);
                    unparsed.push(second_word(item.as_str()));
                }
                Rule::const_decl => items.push(LineItem::Const(self.const_decl(item))),
                Rule::l_station => items.push(self.station(item, &mut unparsed)),
                _ => items.push(self.line_item(rule, item)),
            }
        }
        Line {
            doc,
            name,
            items,
            unparsed,
        }
    }

    pub(super) fn counted(&mut self, pair: Pair<'_, Rule>) -> PartCount {
        let mut c = Children::of(pair);
        let count = self.count(&c.next());
        PartCount {
            count,
            name: self.name(&c.next()),
        }
    }

    /// Builds `, at most 6 in the line`.
    fn at_most(&mut self, pair: Pair<'_, Rule>) -> u64 {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        c.next();
        let most = self.count(&c.next());
        if c.pairs.peek().is_none() {
            self.findings.push(
                Diagnostic::error(
                    codes::SYNTAX,
                    span,
                    "`in the line` is missing after this limit",
                )
                .with_help(format!("write `, at most {most} in the line`")),
            );
        }
        most
    }

    pub(super) fn line_item(&mut self, rule: Rule, item: Pair<'_, Rule>) -> LineItem {
        let span = self.span(&item);
        let mut c = Children::of(item);
        Self::doc(&mut c);
        match rule {
            Rule::l_limit => {
                let value = self.expr(c.next());
                LineItem::Limit(value, c.take(Rule::products).is_some())
            }
            Rule::l_shift => LineItem::Shift(self.shift(c)),
            Rule::l_start => LineItem::Start(self.name(&c.next())),
            Rule::l_holiday => {
                let first = self.name(&c.next());
                LineItem::Holiday(first, c.take(Rule::date).map(|last| self.name(&last)))
            }
            Rule::l_product => LineItem::Product(c.rest().map(|name| self.name(&name)).collect()),
            Rule::l_part => {
                let name = self.name(&c.next());
                let bill = c.take(Rule::bill).map(Children::of);
                let bill = bill
                    .map(|b| b.rest().collect::<Vec<_>>())
                    .unwrap_or_default();
                let bill = bill.into_iter().map(|p| self.counted(p)).collect();
                let properties: Vec<_> = c.rest().collect();
                LineItem::Part {
                    name,
                    bill,
                    properties: properties
                        .into_iter()
                        .map(|p| {
                            self.place(&p);
                            self.typed(p)
                        })
                        .collect(),
                }
            }
            Rule::l_source => {
                let name = self.name(&c.next());
                let part = self.name(&c.next());
                let supply = c.next();
                let supply = match supply.as_rule() {
                    Rule::on_order => Supply::OnOrder,
                    Rule::at_column => Supply::At(self.column(Children::of(supply).next())),
                    _ => {
                        let mut c = Children::of(supply);
                        let random = c.take(Rule::random).is_some();
                        let interval = self.duration(c.next());
                        let limit = c.take(Rule::integer).map(|i| self.count(&i));
                        Supply::Every {
                            interval,
                            random,
                            limit,
                        }
                    }
                };
                let most = c.take(Rule::in_line).map(|most| self.at_most(most));
                LineItem::Source {
                    name,
                    part,
                    supply,
                    most,
                }
            }
            Rule::l_store => {
                let name = self.name(&c.next());
                let stock: Vec<_> = c.rest().collect();
                LineItem::Store {
                    name,
                    stock: stock.into_iter().map(|p| self.counted(p)).collect(),
                }
            }
            Rule::l_sink => LineItem::Sink {
                name: self.name(&c.next()),
                rejects: c.take(Rule::rejects).is_some(),
                reorder: c
                    .take(Rule::reorder)
                    .map(|r| self.name(&Children::of(r).next())),
            },
            Rule::l_buffer => {
                let name = self.name(&c.next());
                let capacity = self.count(&c.next());
                let order = if c.take(Rule::lifo).is_some() {
                    Some(BufferOrder::LastIn)
                } else {
                    c.take(Rule::by_property).map(|order| {
                        let mut c = Children::of(order);
                        let highest = c.next().as_rule() == Rule::highest;
                        let property = self.name(&c.next());
                        if highest {
                            BufferOrder::Highest(property)
                        } else {
                            BufferOrder::Lowest(property)
                        }
                    })
                };
                let dwell = c.take(Rule::dwell).map(|dwell| {
                    let mut c = Children::of(dwell);
                    c.take(Rule::dwell_word);
                    self.duration(c.next())
                });
                let shelf_life = c.take(Rule::shelf_life).map(|life| {
                    let mut c = Children::of(life);
                    c.take(Rule::shelf_word);
                    self.expr(c.next())
                });
                LineItem::Buffer {
                    name,
                    capacity,
                    order,
                    dwell,
                    shelf_life,
                }
            }
            Rule::l_conveyor => {
                let name = self.name(&c.next());
                let machine = c.take(Rule::path).map(|p| self.name(&p));
                let arguments = c.take(Rule::arguments);
                let arguments = self.arguments(arguments);
                let options: Vec<_> = c.rest().collect();
                let options = options
                    .into_iter()
                    .map(|o| {
                        let mut c = Children::of(o);
                        (self.name(&c.next()), self.expr(c.next()))
                    })
                    .collect();
                LineItem::Conveyor {
                    name,
                    machine: machine.map(|m| (m, arguments)),
                    options,
                }
            }
            Rule::l_route => {
                let part = self.name(&c.next());
                let mut stops = Vec::new();
                while let Some(stop) = c.take(Rule::stop) {
                    stops.push(self.stop(stop));
                }
                let when = c.take(Rule::expression).map(|e| self.expr(e));
                LineItem::Route { part, stops, when }
            }
            _ => {
                let name = self.name(&c.next());
                let mut metric = Children::of(c.next());
                LineItem::Requirement {
                    name,
                    metric: self.name(&metric.next()),
                    of: metric.take(Rule::word).map(|n| self.name(&n)),
                    op: binary_op(c.next().as_str()),
                    bound: self.expr(c.next()),
                    per_hour: c.take(Rule::per_hour).is_some(),
                    span,
                }
            }
        }
    }

    fn stop(&mut self, pair: Pair<'_, Rule>) -> Stop {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        let mut places = Vec::new();
        while let Some(place) = c.take(Rule::word) {
            places.push(self.name(&place));
        }
        let choice = if let Some(words) = c.take(Rule::choice) {
            Some(match words.as_str().as_bytes()[0] {
                b'f' => StopChoice::FirstFree,
                b's' => StopChoice::ShortestQueue,
                _ => StopChoice::RoundRobin,
            })
        } else {
            c.take(Rule::by_probability).map(|shares| {
                let shares: Vec<_> = Children::of(shares).rest().collect();
                StopChoice::Probability(shares.into_iter().map(|e| self.expr(e)).collect())
            })
        };
        Stop {
            places,
            choice,
            span,
        }
    }

    pub(super) fn station(&mut self, pair: Pair<'_, Rule>, unparsed: &mut Vec<String>) -> LineItem {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let name = self.name(&c.next());
        let machine = c.take(Rule::path).map(|p| self.name(&p));
        let arguments = c.take(Rule::arguments);
        let arguments = self.arguments(arguments);
        let times = c.take(Rule::copies).map(|times| {
            let count = Children::of(times).next();
            Copies {
                count: self.count(&count),
                span: self.span(&count),
            }
        });
        let mut items = Vec::new();
        for item in c.rest() {
            self.place(&item);
            let rule = item.as_rule();
            if rule == Rule::bad_station_item {
                self.bad(&item);
                unparsed.push(second_word(item.as_str()));
                continue;
            }
            let span = self.span(&item);
            let mut c = Children::of(item);
            items.push(match rule {
                Rule::s_perform => {
                    let mut operations = Vec::new();
                    while let Some(p) = c.take(Rule::performed) {
                        operations.push(self.performed(p));
                    }
                    StationItem::Perform {
                        operations,
                        part: self.name(&c.next()),
                    }
                }
                Rule::s_takes => StationItem::Takes {
                    duration: self.duration(c.next()),
                    part: c.take(Rule::word).map(|n| self.name(&n)),
                },
                Rule::s_sets => {
                    let property = self.name(&c.next());
                    let index = c.take(Rule::index);
                    let index = index.map(|i| self.expr(Children::of(i).next()));
                    StationItem::Sets {
                        property,
                        index,
                        value: self.expr(c.next()),
                        part: c.take(Rule::word).map(|n| self.name(&n)),
                    }
                }
                Rule::s_setup => StationItem::Setup(self.duration(c.next())),
                Rule::m_idle => StationItem::IdlePower(self.expr(c.next())),
                Rule::m_power => StationItem::Power(self.expr(c.next())),
                Rule::m_failures => StationItem::Failures(self.failures(c, span)),
                Rule::l_shift => StationItem::Shift(self.shift(c)),
                _ => {
                    let part = self.name(&c.next());
                    let probability = self.expr(c.next());
                    StationItem::Defect {
                        part,
                        probability,
                        one_of: c.take(Rule::one_of).is_some(),
                        property: self.name(&c.next()),
                        value: self.expr(c.next()),
                    }
                }
            });
        }
        LineItem::Station {
            name,
            machine: machine.map(|m| (m, arguments)),
            times,
            items,
        }
    }

    /// Builds a shift from the children of the statement.
    fn shift(&mut self, mut c: Children<'_>) -> Shift {
        let hours = self.hours(c.next());
        let days = c.take(Rule::weekdays).map(Children::of);
        let days = days.into_iter().flat_map(Children::rest).map(|days| {
            let mut c = Children::of(days);
            Days {
                first: self.name(&c.next()),
                last: c.take(Rule::name).map(|last| self.name(&last)),
            }
        });
        let days = days.collect();
        let breaks = c.take(Rule::breaks).map(Children::of);
        let breaks = breaks.into_iter().flat_map(Children::rest);
        Shift {
            hours,
            days,
            breaks: breaks.map(|hours| self.hours(hours)).collect(),
            finish_work: c.take(Rule::finish_work).is_some(),
        }
    }

    fn hours(&mut self, pair: Pair<'_, Rule>) -> Hours {
        let mut c = Children::of(pair);
        let (from, to) = (self.expr(c.next()), self.expr(c.next()));
        let span = from.span.to(to.span);
        Hours { from, to, span }
    }

    /// Builds a duration: a value or a distribution.
    pub(super) fn duration(&mut self, pair: Pair<'_, Rule>) -> TimeValue {
        let inner = Children::of(pair).next();
        let rule = inner.as_rule();
        if !matches!(rule, Rule::drawn | Rule::empirical) {
            return TimeValue::Value(self.expr(inner));
        }
        self.drawn(inner)
    }

    /// Builds a distribution.
    fn drawn(&mut self, pair: Pair<'_, Rule>) -> TimeValue {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        if c.take(Rule::empirical_word).is_some() {
            let column = self.column(c.next());
            return TimeValue::Empirical { column, span };
        }
        let name = self.name(&c.next());
        let mut outcomes = Vec::new();
        while let Some(outcome) = c.take(Rule::outcome) {
            let mut c = Children::of(outcome);
            outcomes.push(Outcome {
                value: self.expr(c.next()),
                weight: c.take(Rule::expression).map(|weight| self.expr(weight)),
            });
        }
        TimeValue::Drawn {
            name,
            outcomes,
            span,
        }
    }

    /// Builds a column of a table, and adds the table to those of the file.
    fn column(&mut self, pair: Pair<'_, Rule>) -> Column {
        let mut c = Children::of(pair);
        let path = self.unquoted(&c.next());
        c.take(Rule::column_word);
        let header = Children::of(c.next()).next();
        self.tree.tables.push(path.clone());
        Column {
            path,
            quoted: header.as_rule() == Rule::string,
            header: self.unquoted(&header),
            unit: self.name(&c.next()),
        }
    }

    /// Builds a name from a word, or from a text in quotes.
    fn unquoted(&self, pair: &Pair<'_, Rule>) -> Name {
        let name = self.name(pair);
        Name {
            text: name.text.trim_matches('"').to_owned(),
            ..name
        }
    }

    /// Builds a number of parts: a count, or a distribution.
    pub(super) fn parts_between(&mut self, pair: Pair<'_, Rule>) -> Between {
        if pair.as_rule() == Rule::integer {
            Between::Parts(self.count(&pair))
        } else {
            Between::DrawnParts(self.drawn(pair))
        }
    }

    /// Builds the failures of a machine or station from the children of the statement.
    pub(super) fn failures(&mut self, mut c: Children<'_>, span: Span) -> Failures {
        let name = c.take(Rule::mode);
        let name = name.map(|mode| self.name(&Children::of(mode).next()));
        let between = match c.take(Rule::after_parts) {
            Some(parts) => self.parts_between(Children::of(parts).next()),
            None => Between::Time(self.duration(c.next())),
        };
        let calendar = c.take(Rule::by_calendar).is_some();
        Failures {
            name,
            between,
            mttr: self.duration(c.next()),
            calendar: c.take(Rule::by_calendar).is_some() || calendar,
            interrupted: if c.take(Rule::restarts).is_some() {
                InterruptedWork::Restarts
            } else if c.take(Rule::scraps).is_some() {
                InterruptedWork::ScrapsPart
            } else {
                InterruptedWork::Resumes
            },
            span,
        }
    }
}

/// Returns the second word of a statement: `queue` of `buffer queue capacity`.
fn second_word(statement: &str) -> String {
    statement
        .split(|c: char| !c.is_alphanumeric() && c != '_')
        .filter(|word| !word.is_empty())
        .nth(1)
        .unwrap_or_default()
        .to_owned()
}
