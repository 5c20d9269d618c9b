//! Resolution of layouts: transports, duplicates, and the work that is there at the start.
//!
//! The resources that are written come first, then routes between them, then the duplicates, each
//! with the routes of its original, and at last the routes that name a duplicate.

use super::transport::EMPTY;
use super::{findings, unknown};
use crate::contract::elaborate::Elaborator;
use crate::contract::recipe::{Layout, ResourceInfo};
use crate::contract::scope::{self, Decl, Scope, duplicate_name, duplicate_statement};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_recipe::model::{self, Resource, State};
use linewright_syntax::ast::{self, CountedName, LayoutItem, Name, PartCapacity};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of parts that a resource can hold.
pub(in crate::contract) const MAX_CAPACITY: u64 = 10_000;
/// Maximum number of parts that a transport carries at once: each is a resource.
const MAX_CARRIED: u64 = 100;

/// A layout while it is resolved.
pub(super) struct Builder<'a, 's> {
    pub scope: &'s Scope<'a>,
    pub e: Elaborator<'a>,
    pub layout: Layout,
    /// Resources that are declared more than once are resolved only once.
    declared: BTreeMap<&'a str, Span>,
    /// Number of resources that a transport for several parts stands for.
    slots: BTreeMap<&'a str, usize>,
    /// States that a resource can be in at the start.
    pub starts: Vec<(usize, String)>,
}

/// Resolves a layout. Returns `None` if there is an error, which is added to the findings.
pub(in crate::contract) fn layout<'a>(
    scope: &Scope<'a>,
    decl: &'a ast::Layout,
    findings: &mut Vec<Diagnostic>,
) -> Option<Layout> {
    let mut e = scope.elaborator();
    e.dialect.real = true;
    let mut builder = Builder {
        scope,
        e,
        layout: Layout {
            doc: decl.doc.clone(),
            model: model::Layout {
                name: decl.name.text.clone(),
                resources: Vec::new(),
            },
            resources: Vec::new(),
            span: decl.name.span,
        },
        declared: BTreeMap::new(),
        slots: BTreeMap::new(),
        starts: Vec::new(),
    };
    builder.build(decl);
    let Builder { mut e, layout, .. } = builder;
    // What could not be parsed might be what is missing.
    if !decl.broken && !e.findings.has_errors() {
        let problems = layout.model.problems();
        let found = problems.iter().map(|p| findings::of_layout(p, &layout));
        e.findings.list.extend(found);
    }
    let is_usable = !decl.broken && !e.findings.has_errors();
    findings.append(&mut e.findings.list);
    is_usable.then_some(layout)
}

impl<'a> Builder<'a, '_> {
    fn build(&mut self, decl: &'a ast::Layout) {
        let constants = decl.items.iter().filter_map(|item| match item {
            LayoutItem::Const(c) => Some(Decl::Constant(c)),
            _ => None,
        });
        scope::evaluate_all(&mut self.e, &constants.collect::<Vec<_>>());
        let mut duplicates = Vec::new();
        let mut transports = Vec::new();
        for item in &decl.items {
            let name = match item {
                LayoutItem::Resource(r) => &r.name,
                LayoutItem::Transport(t) => &t.name,
                LayoutItem::Duplicate { name, .. } => name,
                LayoutItem::AtStart { .. } | LayoutItem::Const(_) => continue,
            };
            if let Some(first) = self.declared.get(name.text.as_str()) {
                self.e.findings.push(duplicate_name(name, *first));
                continue;
            }
            self.declared.insert(&name.text, name.span);
            match item {
                LayoutItem::Resource(r) => self.resource(r),
                LayoutItem::Transport(t) => {
                    self.transport(t);
                    transports.push(t);
                }
                LayoutItem::Duplicate { name, of } => duplicates.push((name, of)),
                LayoutItem::AtStart { .. } | LayoutItem::Const(_) => {}
            }
        }
        let later: BTreeSet<&str> = duplicates.iter().map(|(n, _)| n.text.as_str()).collect();
        self.routes(&transports, |name| later.contains(name), false);
        self.duplicates(duplicates);
        self.routes(&transports, |name| later.contains(name), true);
        let mut first: BTreeMap<&str, Span> = BTreeMap::new();
        for item in &decl.items {
            if let LayoutItem::AtStart {
                resource,
                state,
                parts,
            } = item
            {
                self.at_start(resource, state, parts, &mut first);
            }
        }
        for item in &decl.items {
            if let LayoutItem::Resource(r) = item {
                self.report_unreached(r);
            }
        }
    }

    /// Returns the resources with a name: several for a transport that carries several parts.
    pub(super) fn indices(&self, name: &str) -> Vec<usize> {
        let Some(first) = self.layout.model.resource(name) else {
            return Vec::new();
        };
        let count = self.slots.get(name).copied().unwrap_or(1);
        (first..first + count).collect()
    }

    pub(super) fn report_unknown_resource(&mut self, name: &Name) {
        // A declaration with an error was reported.
        if self.declared.contains_key(name.text.as_str()) {
            self.e.findings.tainted = true;
            return;
        }
        let finding = unknown(
            name,
            format!(
                "`{}` has no resource `{}`",
                self.layout.model.name, name.text
            ),
            self.declared.keys().copied(),
            "its resources are",
        );
        self.e.findings.push(finding);
    }

    pub(super) fn capacity(&mut self, written: Option<PartCapacity>, most: u64) -> usize {
        let Some(capacity) = written else {
            return 1;
        };
        if !(1..=most).contains(&capacity.count) {
            self.e.findings.error_with(
                codes::ARGUMENT,
                capacity.span,
                format!("{} parts are not a possible capacity", capacity.count),
                format!("write a number from 1 to {most}"),
            );
            return 1;
        }
        capacity.count as usize
    }

    // ---- transports and duplicates --------------------------------------------------------------

    fn transport(&mut self, decl: &'a ast::Transport) {
        let count = self.capacity(decl.capacity, MAX_CARRIED);
        self.slots.insert(&decl.name.text, count);
        for slot in 0..count {
            self.layout.model.resources.push(Resource {
                name: slot_name(&decl.name.text, slot),
                ..Resource::new("", &[EMPTY], &[])
            });
            self.layout.resources.push(ResourceInfo {
                name: decl.name.span,
                is_transport: true,
                capacity: decl.capacity.map(|c| c.span),
                states: vec![decl.name.span],
                ..ResourceInfo::default()
            });
        }
    }

    /// Adds the routes between original resources, or those with an end at a duplicate.
    fn routes(
        &mut self,
        transports: &[&'a ast::Transport],
        is_duplicate: impl Fn(&str) -> bool,
        of_duplicates: bool,
    ) {
        for transport in transports {
            for route in &transport.routes {
                let ride = if of_duplicates {
                    // The values were checked before.
                    let before = self.e.findings.list.len();
                    let ride = self.ride_of(route.time.as_ref(), route.power.as_ref());
                    self.e.findings.list.truncate(before);
                    ride
                } else {
                    self.ride_of(route.time.as_ref(), route.power.as_ref())
                };
                for from in &route.from {
                    for to in &route.to {
                        let names = [&from.resource.text, &to.resource.text];
                        if names.iter().any(|n| is_duplicate(n)) == of_duplicates {
                            self.route(&transport.name, from, to, ride);
                        }
                    }
                }
            }
        }
    }

    /// Adds the duplicates, each after its original.
    fn duplicates(&mut self, mut open: Vec<(&'a Name, &'a Name)>) {
        loop {
            let before = open.len();
            open.retain(|(name, of)| !self.duplicate(name, of));
            if open.len() == before {
                break;
            }
        }
        for (name, of) in &open {
            let is_circular = open.iter().any(|(n, _)| n.text == of.text);
            if is_circular {
                self.e.findings.error_with(
                    codes::NAME_DUPLICATE,
                    name.span,
                    format!("`{}` is defined in terms of itself", name.text),
                    "make it a duplicate of a resource with transitions",
                );
            } else {
                self.report_unknown_resource(of);
            }
        }
    }

    /// Adds a duplicate; returns whether its original exists.
    fn duplicate(&mut self, name: &'a Name, of: &Name) -> bool {
        let originals = self.indices(&of.text);
        for (slot, original) in originals.iter().enumerate() {
            let model = &mut self.layout.model;
            let of = model.resources[*original].name.clone();
            let copy = slot_name(&name.text, slot);
            if model.duplicate(&of, &copy).is_err() {
                continue;
            }
            let info = self.layout.resources[*original].clone();
            self.layout.resources.push(ResourceInfo {
                name: name.span,
                holds: Vec::new(),
                ..info
            });
            let resources = self.layout.model.resources.iter();
            for (resource, info) in resources.zip(&mut self.layout.resources) {
                info.states.resize(resource.states.len(), name.span);
                info.transitions
                    .resize(resource.transitions.len(), name.span);
            }
        }
        self.slots.insert(&name.text, originals.len().max(1));
        !originals.is_empty()
    }

    // ---- the start ------------------------------------------------------------------------------

    fn at_start(
        &mut self,
        resource: &'a Name,
        state: &Name,
        parts: &[CountedName],
        first: &mut BTreeMap<&'a str, Span>,
    ) {
        let slots = self.indices(&resource.text);
        if slots.is_empty() {
            self.report_unknown_resource(resource);
            return;
        }
        // Each statement about a transport fills the next of its places.
        let is_free = |at: &&usize| slots.len() > 1 && !self.starts.iter().any(|(of, _)| of == *at);
        let next = slots.iter().find(is_free).copied();
        let at = next.unwrap_or(slots[0]);
        if next.is_none()
            && let Some(first) = first.get(resource.text.as_str())
        {
            self.e.findings.push(duplicate_statement(
                &format!("at start {}", resource.text),
                resource.span,
                *first,
                "say in one statement in which state it is and what it holds",
            ));
            return;
        }
        first.insert(&resource.text, resource.span);
        let model = &self.layout.model.resources[at];
        let of_duplicate = format!("@{}", state.text);
        let found = model.state(&state.text).or_else(|| {
            // A transport is in a state that is named after the resource at which it took the part.
            let is_transport = self.layout.resources[at].is_transport;
            let named = |s: &State| is_transport && s.name.ends_with(&of_duplicate);
            model.states.iter().position(named)
        });
        let Some(found) = found else {
            let model = model.clone();
            self.report_unknown_state(resource, state, &model);
            return;
        };
        let name = model.states[found].name.clone();
        self.starts.push((at, name.clone()));
        self.layout.model.resources[at].initial = name;
        for part in parts {
            let count = part.count.unwrap_or(1);
            if count > MAX_CAPACITY {
                self.e.findings.error_with(
                    codes::ARGUMENT,
                    part.name.span,
                    format!("{count} parts are too many"),
                    format!("write a number up to {MAX_CAPACITY}"),
                );
                continue;
            }
            for _ in 0..count {
                let text = part.name.text.clone();
                self.layout.model.resources[at].holds.push(text);
                self.layout.resources[at].holds.push(part.name.span);
            }
        }
    }
}

/// Returns the name of one of the resources that a transport for several parts stands for.
fn slot_name(name: &str, slot: usize) -> String {
    match slot {
        0 => name.to_owned(),
        _ => format!("{name}#{}", slot + 1),
    }
}
