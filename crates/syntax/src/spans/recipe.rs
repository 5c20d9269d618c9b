//! Removes the source positions from the syntax trees of layouts and recipes.

use super::super::ast::{
    ActionKind, CountedName, Dock, Layout, LayoutItem, PartCapacity, Realize, Recipe, RecipeGuard,
    RecipeItem, RecipeTransition, Resource, ResourceItem, Transport,
};
use super::{const_decl, exprs, name, names};
use linewright_core::source::Span;

pub(super) fn layout(layout: &mut Layout) {
    name(&mut layout.name);
    for item in &mut layout.items {
        match item {
            LayoutItem::Resource(r) => resource(r),
            LayoutItem::Duplicate { name: n, of } => names([n, of]),
            LayoutItem::Transport(t) => transport(t),
            LayoutItem::AtStart {
                resource,
                state,
                parts,
            } => {
                names([resource, state]);
                counted(parts);
            }
            LayoutItem::Const(c) => const_decl(c),
        }
    }
}

fn counted(list: &mut [CountedName]) {
    names(list.iter_mut().map(|c| &mut c.name));
}

fn capacity(capacity: &mut Option<PartCapacity>) {
    if let Some(capacity) = capacity {
        capacity.span = Span::default();
    }
}

fn resource(r: &mut Resource) {
    names([&mut r.name, &mut r.initial]);
    names(&mut r.kind);
    capacity(&mut r.capacity);
    for item in &mut r.items {
        match item {
            ResourceItem::Nop(states) => names(states),
            ResourceItem::Transition { from, to, actions } => {
                names([from, to]);
                for action in actions {
                    match &mut action.kind {
                        ActionKind::Operation(n) | ActionKind::Internal(n) => name(n),
                        ActionKind::In(label) | ActionKind::Out(label) => names(label),
                    }
                    exprs(&mut action.time);
                    exprs(&mut action.power);
                    action.span = Span::default();
                }
            }
        }
    }
}

fn transport(t: &mut Transport) {
    name(&mut t.name);
    capacity(&mut t.capacity);
    for route in &mut t.routes {
        route.from.iter_mut().for_each(dock);
        route.to.iter_mut().for_each(dock);
        exprs(&mut route.time);
        exprs(&mut route.power);
    }
}

fn dock(d: &mut Dock) {
    name(&mut d.resource);
    names(&mut d.label);
}

pub(super) fn recipe(recipe: &mut Recipe) {
    name(&mut recipe.name);
    for item in &mut recipe.items {
        match item {
            RecipeItem::Parts(parts) => {
                for part in parts {
                    name(&mut part.name);
                    names(&mut part.kind);
                }
            }
            RecipeItem::Start(state) => name(state),
            RecipeItem::Ends(list) | RecipeItem::Leftover(list) => names(list),
            RecipeItem::Transition(t) => transition(t),
        }
    }
}

fn transition(t: &mut RecipeTransition) {
    names([&mut t.from, &mut t.to]);
    match &mut t.guard {
        Some(RecipeGuard::When { test, parts, at }) => {
            name(test);
            names(parts);
            names(at);
        }
        Some(RecipeGuard::Otherwise(span)) => *span = Span::default(),
        None => {}
    }
    for call in t.steps.iter_mut().flatten() {
        name(&mut call.name);
        names(&mut call.inputs);
        names(&mut call.outputs);
        call.span = Span::default();
    }
}

pub(super) fn realize(realize: &mut Realize) {
    counted(&mut realize.recipes);
    name(&mut realize.layout);
}
