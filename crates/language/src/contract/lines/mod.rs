//! Resolution of lines: instantiates machines, and resolves part types, stations and routes.

mod parts;
mod places;
mod statements;

use super::elaborate::{Elaborator, nearest};
use super::line::{Line, Node, NodeKind, PartType};
use super::machine::Machine;
use super::machines::PropertyType;
use super::routes;
use super::scope::{self, Decl, Scope, double};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, LineItem};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A part type with its properties as seen by expressions.
struct Part {
    model: PartType,
    /// First element and type, by name.
    types: Vec<(String, usize, PropertyType)>,
}

struct Builder<'a, 's> {
    scope: &'s Scope<'a>,
    sources: &'s SourceMap,
    e: Elaborator<'a>,
    parts: Vec<Part>,
    /// Machines by name and arguments: equal stations share one, and its library.
    machines: BTreeMap<(String, String), Arc<Machine>>,
    part_index: BTreeMap<String, usize>,
    node_index: BTreeMap<String, usize>,
    /// Indices of the nodes that are stations, and of those that are sources.
    stations: BTreeSet<usize>,
    sources_of_parts: BTreeSet<usize>,
}

/// Resolves a line. `None` if there is an error; the findings give it.
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
        parts: Vec::new(),
        machines: BTreeMap::new(),
        part_index: BTreeMap::new(),
        node_index: BTreeMap::new(),
        stations: BTreeSet::new(),
        sources_of_parts: BTreeSet::new(),
    };
    let model = builder.build(decl);
    let mut e = builder.e;
    if !e.findings.refused() {
        routes::check(&model, &mut e.findings.list);
    }
    let broken = e.findings.refused();
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
        scope::settle(&mut self.e, &constants);
        self.declare_names(decl);
        self.declare_parts(decl);
        let mut model = Line {
            name: decl.name.text.clone(),
            doc: decl.doc.clone(),
            parts: Vec::new(),
            product: 0,
            nodes: Vec::new(),
            routes: Vec::new(),
            requirements: Vec::new(),
            limit: None,
            shift: None,
            span: decl.name.span,
        };
        for item in &decl.items {
            if let Some((name, kind)) = self.node(item) {
                model.nodes.push(Node {
                    name: name.text.clone(),
                    kind,
                    span: name.span,
                });
            } else if is_node(item) {
                // Keeps the indices correct; the findings stop the line anyway.
                model.nodes.push(Node {
                    name: String::new(),
                    kind: NodeKind::Buffer { capacity: 1 },
                    span: decl.name.span,
                });
            }
        }
        self.product(decl, &mut model);
        self.no_doubles(decl);
        for item in &decl.items {
            self.statement(item, &mut model);
        }
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
                self.e.findings.push(double(name, *first));
            }
            spans.insert(&name.text, name.span);
            match item {
                LineItem::Station { .. } => self.stations.insert(nodes),
                LineItem::Source { .. } => self.sources_of_parts.insert(nodes),
                _ => false,
            };
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
