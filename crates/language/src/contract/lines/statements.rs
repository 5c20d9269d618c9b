//! Resolution of requirements, limits and the end products.

use super::Builder;
use crate::contract::elaborate::nearest;
use crate::contract::line::{Comparison, Limit, Line, Requirement};
use crate::contract::machines::non_negative;
use crate::contract::metric::{MEASURES, Measure, MeasureInfo, MeasureUnit, Metric};
use crate::contract::scope::{duplicate_name, duplicate_statement};
use crate::contract::value::Dimension;
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, LineItem};
use std::collections::BTreeMap;

impl<'a> Builder<'a, '_> {
    /// Sets the end products of the line. If none is declared, it is the only part type with a bill
    /// of materials or, if no part type has a bill, the only part type.
    pub(super) fn products(&mut self, decl: &'a ast::Line, model: &mut Line) {
        let mut named = decl.items.iter().filter_map(|i| match i {
            LineItem::Product(names) => Some(names),
            _ => None,
        });
        let joined: Vec<usize> = (0..self.parts.len())
            .filter(|i| !self.parts[*i].model.bill.is_empty())
            .collect();
        match (named.next(), joined.as_slice()) {
            (Some(names), _) => {
                let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
                for name in names {
                    let Some(part) = self.find_part(name) else {
                        continue;
                    };
                    if let Some(first) = seen.insert(part, name.span) {
                        self.e.findings.push(duplicate_name(name, first));
                    } else {
                        model.products.push(part);
                    }
                }
            }
            (None, [one]) => model.products.push(*one),
            (None, []) if self.parts.len() == 1 => model.products.push(0),
            _ => self.e.findings.error_with(
                codes::LINE_UNKNOWN,
                decl.name.span,
                "the end product is not declared",
                "add `product P`",
            ),
        }
    }

    /// Reports second occurrences of statements that are allowed only once.
    pub(super) fn report_duplicates(&mut self, decl: &'a ast::Line) {
        let mut once: BTreeMap<&str, Span> = BTreeMap::new();
        let mut requirements: BTreeMap<&str, Span> = BTreeMap::new();
        for item in &decl.items {
            let (word, span, help) = match item {
                LineItem::Product(names) => (
                    "product",
                    names[0].span,
                    "list all products that a run counts in one statement: `product P, Q`",
                ),
                LineItem::Limit(value, _) => {
                    ("limit", value.span, "keep the limit at which a run ends")
                }
                LineItem::Start(date) => ("start", date.span, "keep the first day of a run"),
                LineItem::Requirement { name, .. } => {
                    if let Some(first) = requirements.insert(&name.text, name.span) {
                        self.e.findings.push(duplicate_name(name, first));
                    }
                    continue;
                }
                _ => continue,
            };
            if let Some(first) = once.insert(word, span) {
                self.e
                    .findings
                    .push(duplicate_statement(word, span, first, help));
            }
        }
    }

    pub(super) fn statement(&mut self, item: &'a LineItem, model: &mut Line) {
        match item {
            LineItem::Route { part, stops, when } => self.route(part, stops, when.as_ref(), model),
            LineItem::Limit(value, true) => {
                if let Some(n) = self.e.constant_int(value) {
                    if n < 1 {
                        self.e.findings.error_with(
                            codes::ARGUMENT,
                            value.span,
                            "the limit must be at least one product",
                            "write the number of end products after which a run ends: `limit 50 products`",
                        );
                    }
                    model.limit = Some(Limit::Products(n.max(1) as u64));
                }
            }
            LineItem::Limit(value, false) => {
                let is_bare = match &value.kind {
                    ast::ExprKind::Int(count) => *count > 0,
                    ast::ExprKind::Quantity(_, unit) => unit.is_empty(),
                    _ => false,
                };
                if is_bare {
                    self.e.findings.error_with(
                        codes::TYPE_MISMATCH,
                        value.span,
                        "this limit is neither a time nor a number of products",
                        "write when a run ends, `limit 8 h` or `limit 50 products`; how many parts a source makes is a whole number",
                    );
                } else if let Some(s) = non_negative(&mut self.e, value, Dimension::Time) {
                    model.limit = Some(Limit::Seconds(s));
                }
            }
            LineItem::Requirement {
                name,
                metric,
                of,
                op,
                bound,
                per_hour,
                span,
            } => {
                let Some(metric) = self.metric(metric, of.as_ref(), &model.products) else {
                    return;
                };
                let unit = metric.measure.info().unit;
                if *per_hour != (unit == MeasureUnit::PerHour) {
                    self.e.findings.error_with(
                        codes::TYPE_MISMATCH,
                        *span,
                        if *per_hour {
                            "`per hour` is allowed only for `throughput`"
                        } else {
                            "a throughput needs `per hour`"
                        },
                        "write `throughput >= 20 per hour`",
                    );
                }
                let comparison = match op {
                    ast::BinaryOp::Lt => Comparison::Lt,
                    ast::BinaryOp::Le => Comparison::Le,
                    ast::BinaryOp::Eq => Comparison::Eq,
                    ast::BinaryOp::Ge => Comparison::Ge,
                    ast::BinaryOp::Gt => Comparison::Gt,
                    _ => {
                        self.e.findings.error_with(
                            codes::TYPE_MISMATCH,
                            *span,
                            "a requirement has to compare with <, <=, =, >= or >",
                            "use one of these operators",
                        );
                        return;
                    }
                };
                if let Some(value) = self.e.constant_quantity(bound, unit.dimension()) {
                    if unit == MeasureUnit::Share && !(0.0..=1.0).contains(&value) {
                        self.e.findings.error_with(
                            codes::ARGUMENT,
                            bound.span,
                            "a share lies between 0 and 1",
                            "write it in percent, such as `20 %`",
                        );
                        return;
                    }
                    model.requirements.push(Requirement {
                        name: name.text.clone(),
                        metric,
                        comparison,
                        bound: value / unit.in_base_units(),
                        span: *span,
                    });
                }
            }
            _ => {}
        }
    }

    /// Resolves a metric of a line with these end products.
    fn metric(
        &mut self,
        name: &ast::Name,
        of: Option<&ast::Name>,
        products: &[usize],
    ) -> Option<Metric> {
        let Some((measure, percentile)) = Measure::named(&name.text) else {
            let all: Vec<String> = MEASURES.iter().flat_map(MeasureInfo::forms).collect();
            let metrics = format!(
                "the metrics are {}; a percentile is a number from 1 to 99",
                all.join(", ")
            );
            let help = match nearest(&name.text, MEASURES.iter().map(|info| info.name)) {
                Some(near) => {
                    let near = Measure::named(near);
                    let near = near.map_or_else(String::new, |(near, _)| forms(near.info()));
                    format!("did you mean {near}? {metrics}")
                }
                None => metrics,
            };
            self.e.findings.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("there is no metric `{}`", name.text),
                help,
            );
            return None;
        };
        let metric = Metric {
            percentile,
            ..measure.into()
        };
        let info = measure.info();
        let Some(of) = of else {
            if !info.of_line {
                self.e.findings.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("there is no metric `{}` of the whole line", info.name),
                    format!("write {}", forms(info)),
                );
                return None;
            }
            return Some(metric);
        };
        if info.of_product {
            return Some(Metric {
                product: Some(self.end_product(of, info, products)?),
                ..metric
            });
        }
        if info.places.is_empty() {
            self.e.findings.error_with(
                codes::LINE_UNKNOWN,
                of.span,
                format!("`{}` is measured for the whole line", info.name),
                format!("write `{}` without a place", info.name),
            );
            return None;
        }
        let node = self.find_node(of)?;
        let kind = self.kinds.get(&node);
        if !kind.is_some_and(|kind| info.places.contains(kind)) {
            let words = info.about();
            let plural = words.replace(" or ", "s and ");
            self.e.findings.error_with(
                codes::LINE_UNKNOWN,
                of.span,
                format!("`{}` is not a {words}", of.text),
                format!("name a {words}: only {plural}s have this metric"),
            );
            return None;
        }
        Some(Metric {
            nodes: node..node + 1,
            ..metric
        })
    }

    /// Finds the end product that a metric is about.
    fn end_product(
        &mut self,
        of: &ast::Name,
        info: &MeasureInfo,
        products: &[usize],
    ) -> Option<usize> {
        let is_place = self.node_index.contains_key(&of.text);
        let part = if is_place {
            self.part_index.get(&of.text).copied()
        } else {
            Some(self.find_part(of)?)
        };
        if let Some(part) = part.filter(|part| products.contains(part)) {
            return Some(part);
        }
        let known: Vec<String> = products
            .iter()
            .map(|product| format!("`{}`", self.parts[*product].model.name))
            .collect();
        // Without a product, the line has another error.
        if !known.is_empty() {
            self.e.findings.error_about(
                codes::LINE_UNKNOWN,
                of,
                "is not an end product",
                format!(
                    "`{}` is measured for the whole line or for an end product: {}",
                    info.name,
                    known.join(", ")
                ),
            );
        }
        None
    }
}

/// How a metric is written: `` `length(buffer)` or `length(conveyor)` ``.
fn forms(info: &MeasureInfo) -> String {
    format!("`{}`", info.forms().join("` or `"))
}
