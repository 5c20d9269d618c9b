//! Prints layouts and recipes.
//!
//! The actions of a transition are filled into lines, as are the steps of a recipe: a line ends
//! where the author ended it, or where the next step would not fit.

use super::super::ast::{
    ActionKind, CountedName, Dock, Expr, Layout, LayoutItem, Name, PartCapacity, Realize, Recipe,
    RecipeCall, RecipeGuard, RecipeItem, RecipePart, RecipeTransition, Resource, ResourceAction,
    ResourceItem, Transport, TransportRoute,
};
use super::super::binds;
use super::expression::Continuation;
use super::printer::Printer;
use linewright_core::source::Span;

impl Printer<'_> {
    pub(super) fn cell_layout(&mut self, place: Span, layout: &Layout) {
        self.doc(&layout.doc);
        self.put("layout ");
        self.name(&layout.name);
        self.block(place, &layout.items, false, |p, place, item| match item {
            LayoutItem::Resource(r) => p.resource(place, r),
            LayoutItem::Duplicate { name, of } => {
                p.put("resource ");
                p.name(name);
                p.put(" = ");
                p.name(of);
            }
            LayoutItem::Transport(t) => p.transport(place, t),
            LayoutItem::AtStart {
                resource,
                state,
                parts,
            } => {
                p.put("at start ");
                p.name(resource);
                p.put(" ");
                p.name(state);
                if !parts.is_empty() {
                    p.put(" holds ");
                    p.list(parts, |c| c.name.span, Self::counted_name);
                }
            }
            LayoutItem::Const(c) => p.const_decl(c),
        });
    }

    fn counted_name(&mut self, c: &CountedName) {
        self.before(c.name.span);
        if let Some(count) = c.count {
            self.put(&format!("{count} "));
        }
        self.put(&c.name.text);
    }

    fn part_capacity(&mut self, capacity: Option<PartCapacity>) {
        if let Some(capacity) = capacity {
            self.put(" holds ");
            self.before(capacity.span);
            self.put(&capacity.count.to_string());
        }
    }

    fn resource(&mut self, place: Span, r: &Resource) {
        self.doc(&r.doc);
        self.put("resource ");
        self.name(&r.name);
        if let Some(kind) = &r.kind {
            self.put(": ");
            self.name(kind);
        }
        self.put(" at ");
        self.name(&r.initial);
        self.part_capacity(r.capacity);
        self.block(place, &r.items, true, |p, _, item| match item {
            ResourceItem::Nop(states) => {
                p.put("nop ");
                p.list(states, |s| s.span, Self::name);
            }
            ResourceItem::Transition { from, to, actions } => {
                p.name(from);
                p.put(" -> ");
                p.name(to);
                p.put(": ");
                p.list(actions, ResourceAction::whole, Self::action);
            }
        });
    }

    fn action(&mut self, action: &ResourceAction) {
        self.before(action.span);
        match &action.kind {
            ActionKind::Operation(name) => self.name(name),
            ActionKind::Internal(name) => {
                self.put("internal ");
                self.name(name);
            }
            ActionKind::In(label) => self.labelled("in", label.as_ref()),
            ActionKind::Out(label) => self.labelled("out", label.as_ref()),
        }
        self.time_and_power(action.time.as_ref(), action.power.as_ref());
    }

    fn labelled(&mut self, word: &str, label: Option<&Name>) {
        self.put(word);
        if let Some(label) = label {
            self.put(":");
            self.name(label);
        }
    }

    fn time_and_power(&mut self, time: Option<&Expr>, power: Option<&Expr>) {
        for (word, value) in [(" in ", time), (" power ", power)] {
            if let Some(value) = value {
                self.put(word);
                self.operand(value, binds::ADDITIVE, Continuation::Operator);
            }
        }
    }

    fn transport(&mut self, place: Span, t: &Transport) {
        self.doc(&t.doc);
        self.put("transport ");
        self.name(&t.name);
        self.part_capacity(t.capacity);
        self.block(place, &t.routes, true, |p, _, route| {
            p.transport_route(route);
        });
    }

    fn transport_route(&mut self, route: &TransportRoute) {
        self.list(&route.from, Dock::span, Self::dock);
        self.put(" -> ");
        self.list(&route.to, Dock::span, Self::dock);
        self.time_and_power(route.time.as_ref(), route.power.as_ref());
    }

    fn dock(&mut self, dock: &Dock) {
        self.name(&dock.resource);
        if let Some(label) = &dock.label {
            self.put(":");
            self.name(label);
        }
    }

    pub(super) fn recipe(&mut self, place: Span, recipe: &Recipe) {
        self.doc(&recipe.doc);
        self.put("recipe ");
        self.name(&recipe.name);
        self.block(place, &recipe.items, false, |p, _, item| {
            let (word, names) = match item {
                RecipeItem::Transition(t) => return p.recipe_transition(t),
                RecipeItem::Parts(parts) => {
                    p.put("part ");
                    p.list(parts, |part| part.name.span, Self::recipe_part);
                    return;
                }
                RecipeItem::Start(state) => ("start ", std::slice::from_ref(state)),
                RecipeItem::Ends(states) => ("end ", states.as_slice()),
                RecipeItem::Leftover(parts) => ("leftover ", parts.as_slice()),
            };
            p.put(word);
            p.list(names, |n| n.span, Self::name);
        });
    }

    fn recipe_part(&mut self, part: &RecipePart) {
        self.name(&part.name);
        if let Some(kind) = &part.kind {
            self.put(": ");
            self.name(kind);
        }
    }

    fn recipe_transition(&mut self, t: &RecipeTransition) {
        self.name(&t.from);
        self.put(" -> ");
        self.name(&t.to);
        let mut last = t.to.span;
        match &t.guard {
            None => {}
            Some(RecipeGuard::Otherwise(span)) => {
                self.put(" ");
                self.before(*span);
                self.put("otherwise");
                last = *span;
            }
            Some(RecipeGuard::When { test, parts, at }) => {
                self.put(" when ");
                self.name(test);
                self.part_names(parts);
                if !at.is_empty() {
                    self.put(" at ");
                    self.list(at, |n| n.span, Self::name);
                }
                let names = std::iter::once(test).chain(parts).chain(at);
                last = names.last().map_or(last, |n| n.span);
            }
        }
        let Some(first) = t.steps.first().and_then(|step| step.first()) else {
            return;
        };
        self.put(":");
        self.nest = 1;
        if self.broken(last, first.span) {
            self.gap(0, true, true);
        } else {
            self.put(" ");
        }
        self.level(|p, level| {
            let mut before: Option<&RecipeCall> = None;
            for step in &t.steps {
                for (i, call) in step.iter().enumerate() {
                    if let Some(before) = before {
                        p.put(if i > 0 { " ||" } else { ";" });
                        let forced = p.broken(before.span, call.span);
                        p.gap(level, true, forced);
                    }
                    p.recipe_call(call);
                    before = Some(call);
                }
            }
        });
        self.nest = 0;
    }

    fn recipe_call(&mut self, call: &RecipeCall) {
        self.name(&call.name);
        self.part_names(&call.inputs);
        self.part_names(&call.outputs);
    }

    fn part_names(&mut self, names: &[Name]) {
        self.put("(");
        for (i, name) in names.iter().enumerate() {
            self.put(if i > 0 { ", " } else { "" });
            self.name(name);
        }
        self.put(")");
    }

    pub(super) fn realize(&mut self, realize: &Realize) {
        self.put("realize ");
        self.list(&realize.recipes, |c| c.name.span, Self::counted_name);
        self.put(" on ");
        self.name(&realize.layout);
    }
}

impl ResourceAction {
    /// Returns the place of the action with its duration and power.
    fn whole(&self) -> Span {
        let last = self.power.as_ref().or(self.time.as_ref());
        last.map_or(self.span, |e| self.span.to(e.span))
    }
}
