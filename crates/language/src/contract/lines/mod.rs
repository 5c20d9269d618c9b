//! Resolution of lines: instantiates the machines of stations and conveyors, and resolves part
//! types, places and routes.

mod calendars;
mod copies;
mod parts;
mod places;
mod statements;
mod stations;
mod ways;

use super::distribution::Distribution;
use super::elaborate::{Elaborator, nearest};
use super::line::{BufferOrder, Line, Node, NodeKind, PartType};
use super::machine::Machine;
use super::machines::PropertyType;
use super::metric::PlaceKind;
use super::routes;
use super::scope::{self, Decl, Scope, duplicate_name};
use calendars::Days;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, LineItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A part type, with the types of its properties.
struct Part {
    model: PartType,
    /// For each property, its name, the index of its first element, and its type.
    types: Vec<(String, usize, PropertyType)>,
}

struct Builder<'a, 's> {
    scope: &'s Scope<'a>,
    sources: &'s SourceMap,
    e: Elaborator<'a>,
    /// Names that are declared in statements with syntax errors. Their uses are not reported as
    /// unknown.
    unparsed: &'a [String],
    parts: Vec<Part>,
    /// Machines by name, arguments, and place if the declaration is for one place only. Stations
    /// with the same machine and arguments share an instance.
    machines: BTreeMap<(String, String, Option<Span>), Arc<Machine>>,
    part_index: BTreeMap<String, usize>,
    node_index: BTreeMap<String, usize>,
    /// By node: the number of stations that it stands for, if this is written.
    times: BTreeMap<usize, usize>,
    /// By node: the time of work on parts of any type, `takes d`, and its place.
    common_times: BTreeMap<usize, (Distribution, Span)>,
    /// The first day of a run, and the closed days.
    days: Days,
    /// Kinds of the nodes that metrics can be about.
    kinds: BTreeMap<usize, PlaceKind>,
}

/// Resolves a line. Returns `None` if there is an error, which is added to the findings.
pub(super) fn line<'a>(
    scope: &Scope<'a>,
    sources: &SourceMap,
    decl: &'a ast::Line,
    findings: &mut Vec<Diagnostic>,
) -> Option<Line> {
    let mut e = scope.elaborator();
    e.dialect.real = true;
    let mut builder = Builder {
        scope,
        sources,
        e,
        unparsed: &decl.unparsed,
        parts: Vec::new(),
        machines: BTreeMap::new(),
        part_index: BTreeMap::new(),
        node_index: BTreeMap::new(),
        times: BTreeMap::new(),
        common_times: BTreeMap::new(),
        days: Days::default(),
        kinds: BTreeMap::new(),
    };
    let mut model = builder.build(decl);
    let times = builder.times;
    let mut e = builder.e;
    if !e.findings.has_errors() && decl.unparsed.is_empty() {
        routes::check(&model, &mut e.findings.list);
        copies::expand(&mut model, &times);
    }
    let broken = e.findings.has_errors() || !decl.unparsed.is_empty();
    findings.append(&mut e.findings.list);
    (!broken).then_some(model)
}

impl<'a> Builder<'a, '_> {
    fn build(&mut self, decl: &'a ast::Line) -> Line {
        let constants: Vec<_> = decl
            .items
            .iter()
            .filter_map(|item| match item {
                LineItem::Const(c) => Some(Decl::Constant(c)),
                _ => None,
            })
            .collect();
        scope::evaluate_all(&mut self.e, &constants);
        self.declare_names(decl);
        self.declare_parts(decl);
        let mut model = Line {
            name: decl.name.text.clone(),
            doc: decl.doc.clone(),
            parts: Vec::new(),
            products: Vec::new(),
            nodes: Vec::new(),
            routes: Vec::new(),
            choices: Vec::new(),
            requirements: Vec::new(),
            limit: None,
            calendar: None,
            first_day: None,
            span: decl.name.span,
        };
        model.first_day = self.declare_days(decl);
        model.calendar = self.line_calendar(decl);
        for item in &decl.items {
            if let Some((name, kind)) = self.node(item) {
                model.nodes.push(Node {
                    name: name.text.clone(),
                    kind,
                    span: name.span,
                });
            } else if is_node(item) {
                // A placeholder keeps the indices correct. The line is rejected because of the
                // error.
                model.nodes.push(Node {
                    name: String::new(),
                    kind: NodeKind::Buffer {
                        capacity: 1,
                        order: BufferOrder::FirstIn,
                        dwell: Distribution::default(),
                        shelf_life: None,
                    },
                    span: decl.name.span,
                });
            }
        }
        self.products(decl, &mut model);
        self.report_duplicates(decl);
        for item in &decl.items {
            self.statement(item, &mut model);
        }
        self.add_common_times(&mut model);
        self.check_buffers(decl, &model);
        model.parts = std::mem::take(&mut self.parts)
            .into_iter()
            .map(|p| p.model)
            .collect();
        model
    }

    fn declare_names(&mut self, decl: &'a ast::Line) {
        let mut spans: BTreeMap<&str, Span> = BTreeMap::new();
        let mut nodes = 0;
        let mut parts = 0;
        for item in &decl.items {
            let (name, node) = match item {
                LineItem::Part { name, .. } => (name, false),
                LineItem::Source { name, .. }
                | LineItem::Store { name, .. }
                | LineItem::Sink { name, .. }
                | LineItem::Buffer { name, .. }
                | LineItem::Conveyor { name, .. }
                | LineItem::Station { name, .. } => (name, true),
                _ => continue,
            };
            if let Some(first) = spans.get(name.text.as_str()) {
                self.e.findings.push(duplicate_name(name, *first));
            }
            spans.insert(&name.text, name.span);
            let kind = match item {
                LineItem::Station { .. } => Some(PlaceKind::Station),
                LineItem::Source { .. } => Some(PlaceKind::Source),
                LineItem::Buffer { .. } => Some(PlaceKind::Buffer),
                LineItem::Conveyor { .. } => Some(PlaceKind::Conveyor),
                _ => None,
            };
            self.kinds.extend(kind.map(|kind| (nodes, kind)));
            let (index, counter) = if node {
                (&mut self.node_index, &mut nodes)
            } else {
                (&mut self.part_index, &mut parts)
            };
            index.insert(name.text.clone(), *counter);
            *counter += 1;
        }
    }

    fn find_part(&mut self, name: &ast::Name) -> Option<usize> {
        if let Some(i) = self.part_index.get(&name.text) {
            return Some(*i);
        }
        if self.unparsed.contains(&name.text) {
            return None;
        }
        let help = match nearest(&name.text, self.part_index.keys().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("declare it: `part {} {{ ... }}`", name.text),
        };
        self.e.findings.error_with(
            codes::LINE_UNKNOWN,
            name.span,
            format!("there is no part type `{}`", name.text),
            help,
        );
        None
    }

    fn find_node(&mut self, name: &ast::Name) -> Option<usize> {
        if let Some(i) = self.node_index.get(&name.text) {
            return Some(*i);
        }
        if self.unparsed.contains(&name.text) {
            return None;
        }
        let help = match nearest(&name.text, self.node_index.keys().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "declare it as a `station`, `conveyor`, `buffer`, `source`, `sink` or `store`"
                .to_owned(),
        };
        self.e.findings.error_with(
            codes::LINE_UNKNOWN,
            name.span,
            format!("this line has no place called `{}`", name.text),
            help,
        );
        None
    }
}

fn is_node(item: &LineItem) -> bool {
    matches!(
        item,
        LineItem::Source { .. }
            | LineItem::Store { .. }
            | LineItem::Sink { .. }
            | LineItem::Buffer { .. }
            | LineItem::Conveyor { .. }
            | LineItem::Station { .. }
    )
}
