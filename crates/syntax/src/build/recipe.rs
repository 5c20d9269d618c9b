//! Builds layouts, recipes and `realize`.

use super::super::ast::{
    ActionKind, CountedName, Dock, Expr, Layout, LayoutItem, Name, PartCapacity, Realize, Recipe,
    RecipeCall, RecipeGuard, RecipeItem, RecipePart, RecipeTransition, Resource, ResourceAction,
    ResourceItem, Transport, TransportRoute,
};
use super::super::parser::Rule;
use super::{Builder, Children};
use pest::iterators::Pair;

impl Builder {
    pub(super) fn layout(&mut self, pair: Pair<'_, Rule>) -> Layout {
        let mut c = Children::of(pair);
        let mut layout = Layout {
            doc: Self::doc(&mut c),
            name: self.name(&c.next()),
            items: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            let broken = &mut layout.broken;
            layout.items.push(match item.as_rule() {
                Rule::resource => LayoutItem::Resource(self.resource(item, broken)),
                Rule::transport => LayoutItem::Transport(self.transport(item, broken)),
                Rule::const_decl => LayoutItem::Const(self.const_decl(item)),
                Rule::duplicate => {
                    let mut c = Children::of(item);
                    Self::doc(&mut c);
                    LayoutItem::Duplicate {
                        name: self.name(&c.next()),
                        of: self.name(&c.next()),
                    }
                }
                Rule::at_start => {
                    let mut c = Children::of(item);
                    Self::doc(&mut c);
                    LayoutItem::AtStart {
                        resource: self.name(&c.next()),
                        state: self.name(&c.next()),
                        parts: c.rest().map(|part| self.counted_name(part)).collect(),
                    }
                }
                _ => {
                    *broken = true;
                    self.bad(&item);
                    continue;
                }
            });
        }
        layout
    }

    fn counted_name(&mut self, pair: Pair<'_, Rule>) -> CountedName {
        let mut c = Children::of(pair);
        CountedName {
            count: c.take(Rule::integer).map(|count| self.count(&count)),
            name: self.name(&c.next()),
        }
    }

    fn part_capacity(&mut self, c: &mut Children<'_>) -> Option<PartCapacity> {
        let number = Children::of(c.take(Rule::holds)?).next();
        Some(PartCapacity {
            count: self.count(&number),
            span: self.span(&number),
        })
    }

    fn resource(&mut self, pair: Pair<'_, Rule>, broken: &mut bool) -> Resource {
        let mut c = Children::of(pair);
        let doc = Self::doc(&mut c);
        let name = self.name(&c.next());
        let kind = c.take(Rule::resource_kind);
        let mut resource = Resource {
            doc,
            name,
            kind: kind.map(|kind| self.name(&Children::of(kind).next())),
            initial: self.name(&Children::of(c.next()).next()),
            capacity: self.part_capacity(&mut c),
            items: Vec::new(),
        };
        for item in c.rest() {
            self.place(&item);
            let rule = item.as_rule();
            if rule == Rule::bad_resource_item {
                *broken = true;
                self.bad(&item);
                continue;
            }
            let mut c = Children::of(item);
            Self::doc(&mut c);
            resource.items.push(if rule == Rule::nop {
                ResourceItem::Nop(c.rest().map(|state| self.name(&state)).collect())
            } else {
                ResourceItem::Transition {
                    from: self.name(&c.next()),
                    to: self.name(&c.next()),
                    actions: c.rest().map(|action| self.action(action)).collect(),
                }
            });
        }
        resource
    }

    fn action(&mut self, pair: Pair<'_, Rule>) -> ResourceAction {
        let mut c = Children::of(pair);
        let kind = c.next();
        let span = self.span(&kind);
        let rule = kind.as_rule();
        let kind = if rule == Rule::word {
            ActionKind::Operation(self.name(&kind))
        } else {
            let name = Children::of(kind).pairs.next();
            let name = name.map(|name| self.name(&name));
            match (rule, name) {
                (Rule::taking, label) => ActionKind::In(label),
                (Rule::hidden, Some(name)) => ActionKind::Internal(name),
                (_, label) => ActionKind::Out(label),
            }
        };
        ResourceAction {
            kind,
            time: self.quantity_after(&mut c, Rule::lasts),
            power: self.quantity_after(&mut c, Rule::draws),
            span,
        }
    }

    fn quantity_after(&mut self, c: &mut Children<'_>, rule: Rule) -> Option<Expr> {
        let value = Children::of(c.take(rule)?).next();
        Some(self.expr(value))
    }

    fn transport(&mut self, pair: Pair<'_, Rule>, broken: &mut bool) -> Transport {
        let mut c = Children::of(pair);
        let mut transport = Transport {
            doc: Self::doc(&mut c),
            name: self.name(&c.next()),
            capacity: self.part_capacity(&mut c),
            routes: Vec::new(),
        };
        for item in c.rest() {
            self.place(&item);
            if item.as_rule() == Rule::bad_transport_item {
                *broken = true;
                self.bad(&item);
                continue;
            }
            let mut c = Children::of(item);
            Self::doc(&mut c);
            transport.routes.push(TransportRoute {
                from: self.docks(c.next()),
                to: self.docks(c.next()),
                time: self.quantity_after(&mut c, Rule::lasts),
                power: self.quantity_after(&mut c, Rule::draws),
            });
        }
        transport
    }

    fn docks(&mut self, pair: Pair<'_, Rule>) -> Vec<Dock> {
        let docks = Children::of(pair).rest().map(|dock| {
            let mut c = Children::of(dock);
            Dock {
                resource: self.name(&c.next()),
                label: c.take(Rule::transfer_label).map(|label| self.name(&label)),
            }
        });
        docks.collect()
    }

    pub(super) fn recipe(&mut self, pair: Pair<'_, Rule>) -> Recipe {
        let mut c = Children::of(pair);
        let mut recipe = Recipe {
            doc: Self::doc(&mut c),
            name: self.name(&c.next()),
            items: Vec::new(),
            broken: false,
        };
        for item in c.rest() {
            self.place(&item);
            let rule = item.as_rule();
            if rule == Rule::bad_recipe_item {
                recipe.broken = true;
                self.bad(&item);
                continue;
            }
            let mut c = Children::of(item);
            Self::doc(&mut c);
            recipe.items.push(match rule {
                Rule::recipe_parts => {
                    let parts = c.rest().map(|part| {
                        let mut c = Children::of(part);
                        RecipePart {
                            name: self.name(&c.next()),
                            kind: c.take(Rule::word).map(|kind| self.name(&kind)),
                        }
                    });
                    RecipeItem::Parts(parts.collect())
                }
                Rule::recipe_start => RecipeItem::Start(self.name(&c.next())),
                Rule::recipe_ends => RecipeItem::Ends(self.names(c)),
                Rule::leftover => RecipeItem::Leftover(self.names(c)),
                _ => RecipeItem::Transition(self.recipe_transition(c)),
            });
        }
        recipe
    }

    fn names(&self, c: Children<'_>) -> Vec<Name> {
        c.rest().map(|name| self.name(&name)).collect()
    }

    fn recipe_transition(&mut self, mut c: Children<'_>) -> RecipeTransition {
        let from = self.name(&c.next());
        let to = self.name(&c.next());
        let guard = match c.take(Rule::otherwise) {
            Some(word) => Some(RecipeGuard::Otherwise(self.span(&word))),
            None => c.take(Rule::recipe_guard).map(|guard| {
                let mut c = Children::of(guard);
                let test = self.name(&c.next());
                let parts = self.names(Children::of(c.next()));
                let at = c.take(Rule::tested_at).map(Children::of);
                RecipeGuard::When {
                    test,
                    parts,
                    at: at.map(|at| self.names(at)).unwrap_or_default(),
                }
            }),
        };
        let steps = c.rest().map(|step| {
            let calls = Children::of(step).rest();
            calls.map(|call| self.recipe_call(call)).collect()
        });
        RecipeTransition {
            from,
            to,
            guard,
            steps: steps.collect(),
        }
    }

    fn recipe_call(&self, pair: Pair<'_, Rule>) -> RecipeCall {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        RecipeCall {
            name: self.name(&c.next()),
            inputs: self.names(Children::of(c.next())),
            outputs: self.names(Children::of(c.next())),
            span,
        }
    }

    pub(super) fn realize(&mut self, pair: Pair<'_, Rule>) -> Realize {
        let mut c = Children::of(pair);
        Self::doc(&mut c);
        let mut recipes = Vec::new();
        while let Some(wanted) = c.take(Rule::wanted) {
            recipes.push(self.counted_name(wanted));
        }
        Realize {
            recipes,
            layout: self.name(&c.next()),
        }
    }
}
