//! Random layouts and recipes.

use super::{Choices, name};
use linewright::source::Span;
use linewright::syntax::ast::*;

/// Names, most of which are words of a layout or a recipe.
const WORDS: &[&str] = &[
    "a",
    "resource",
    "at",
    "start",
    "end",
    "holds",
    "nop",
    "out",
    "on",
    "when",
    "otherwise",
    "leftover",
    "part",
    "layout",
    "recipe",
    "realize",
    "transport",
    "power",
    "G",
    "Größe",
];

impl Choices<'_> {
    fn free_word(&mut self) -> Name {
        name(WORDS[self.pick(WORDS.len())])
    }

    /// A word that is no keyword of an action.
    fn operation(&mut self) -> Name {
        let word = self.free_word();
        if word.text == "out" {
            name("glue")
        } else {
            word
        }
    }

    fn capacity(&mut self) -> Option<PartCapacity> {
        self.option(|c| PartCapacity {
            count: c.count(),
            span: Span::default(),
        })
    }

    fn counted_name(&mut self) -> CountedName {
        CountedName {
            count: self.option(Self::count),
            name: self.free_word(),
        }
    }

    fn label(&mut self) -> Option<Name> {
        self.option(|c| name(["1", "left", "03", "4b"][c.pick(4)]))
    }

    fn action(&mut self) -> ResourceAction {
        ResourceAction {
            kind: match self.pick(4) {
                0 => ActionKind::Operation(self.operation()),
                1 => ActionKind::Internal(self.free_word()),
                2 => ActionKind::In(self.label()),
                _ => ActionKind::Out(self.label()),
            },
            time: self.option(Self::expr),
            power: self.option(Self::expr),
            span: Span::default(),
        }
    }

    fn resource_item(&mut self) -> ResourceItem {
        if self.maybe() {
            return ResourceItem::Nop(self.list(1, 3, Self::free_word));
        }
        ResourceItem::Transition {
            from: self.free_word(),
            to: self.free_word(),
            actions: self.list(1, 3, Self::action),
        }
    }

    fn dock(&mut self) -> Dock {
        Dock {
            resource: self.free_word(),
            label: self.label(),
        }
    }

    fn transport_route(&mut self) -> TransportRoute {
        TransportRoute {
            from: self.list(1, 3, Self::dock),
            to: self.list(1, 3, Self::dock),
            time: self.option(Self::expr),
            power: self.option(Self::expr),
        }
    }

    fn layout_item(&mut self) -> LayoutItem {
        match self.pick(5) {
            0 => LayoutItem::Resource(Resource {
                doc: self.doc(),
                name: self.free_word(),
                kind: self.option(Self::free_word),
                initial: self.free_word(),
                capacity: self.capacity(),
                items: self.list(0, 4, Self::resource_item),
            }),
            1 => LayoutItem::Duplicate {
                name: self.free_word(),
                of: self.free_word(),
            },
            2 => LayoutItem::Transport(Transport {
                doc: self.doc(),
                name: self.free_word(),
                capacity: self.capacity(),
                routes: self.list(0, 3, Self::transport_route),
            }),
            3 => LayoutItem::AtStart {
                resource: self.free_word(),
                state: self.free_word(),
                parts: self.list(0, 3, Self::counted_name),
            },
            _ => LayoutItem::Const(self.const_decl()),
        }
    }

    pub(super) fn layout(&mut self) -> Layout {
        Layout {
            doc: self.doc(),
            name: self.free_word(),
            items: self.list(0, 4, Self::layout_item),
            broken: false,
        }
    }

    fn words(&mut self) -> Vec<Name> {
        self.list(1, 3, Self::free_word)
    }

    fn call(&mut self) -> RecipeCall {
        RecipeCall {
            name: self.free_word(),
            inputs: self.list(0, 2, Self::free_word),
            outputs: self.list(0, 2, Self::free_word),
            span: Span::default(),
        }
    }

    fn guard(&mut self) -> RecipeGuard {
        if self.maybe() {
            return RecipeGuard::Otherwise(Span::default());
        }
        RecipeGuard::When {
            test: self.free_word(),
            parts: self.list(0, 2, Self::free_word),
            at: self.list(0, 2, Self::free_word),
        }
    }

    fn recipe_item(&mut self) -> RecipeItem {
        match self.pick(6) {
            0 => RecipeItem::Parts(self.list(1, 3, |c| RecipePart {
                name: c.free_word(),
                kind: c.option(Self::free_word),
            })),
            1 => RecipeItem::Start(self.free_word()),
            2 => RecipeItem::Ends(self.words()),
            3 => RecipeItem::Leftover(self.words()),
            _ => RecipeItem::Transition(RecipeTransition {
                from: self.free_word(),
                to: self.free_word(),
                guard: self.option(Self::guard),
                steps: self.list(0, 4, |c| c.list(1, 3, Self::call)),
            }),
        }
    }

    pub(super) fn recipe(&mut self) -> Recipe {
        Recipe {
            doc: self.doc(),
            name: self.free_word(),
            items: self.list(0, 5, Self::recipe_item),
            broken: false,
        }
    }

    pub(super) fn realize(&mut self) -> Realize {
        Realize {
            recipes: self.list(1, 3, Self::counted_name),
            layout: self.free_word(),
        }
    }
}
