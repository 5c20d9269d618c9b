//! Syntax trees of layouts and recipes: the inverse of their resolution.
//!
//! ```text
//! model::Layout, model::Recipe ─tree→ ast::File ─syntax::format→ text ─load→ the same models
//! ```
//!
//! Transports and duplicates are resources of a model, so they are written as resources. Three
//! things of a model cannot be written and mean nothing: states that no transition mentions, the
//! transitions of a resource whose first state has none, and those of a recipe that begins at an
//! end.

mod names;

use super::machines::out_of_range;
use super::recipes::MAX_CAPACITY;
use super::value::Dimension;
use linewright_core::source::{FileId, Span};
use linewright_recipe::model::{
    Action, Guard, Layout, OperationCall, Recipe, RecipeTransition, Resource, Transition,
};
use linewright_syntax::ast::{
    self, ActionKind, CountedName, Expr, ExprKind, Item, LayoutItem, Name, PartCapacity,
    RecipeGuard, RecipeItem, RecipePart, ResourceItem,
};
use linewright_syntax::format::{self, FormatError};
use linewright_syntax::parse;
use names::Words;
use rustc_hash::FxHashSet;

/// The syntax tree of layouts and recipes.
#[derive(Debug, Clone, PartialEq)]
pub struct RecipeTree {
    /// The layouts, then the recipes. If there is one layout, a statement `realize` for each recipe
    /// follows. All places are empty.
    pub file: ast::File,
    /// Names that are no words of the language, or that occur twice among those of the layouts and
    /// recipes, with the words that replace them. The same name has the same word everywhere,
    /// except in a label.
    pub renamed: Vec<(String, String)>,
}

impl RecipeTree {
    /// Returns the text of the tree, formatted, behind lines of comments.
    ///
    /// # Errors
    /// The text would have another meaning, which is a fault of this program.
    pub fn text(&self, comments: &[String]) -> Result<String, FormatError> {
        let comments = comments.iter().map(|line| format!("// {line}\n"));
        let mut text: String = comments.collect();
        text.push('\n');
        text.push_str(&format::format(&self.file, ""));
        let (file, findings) = parse(FileId::default(), &text);
        let items = |file: &ast::File| file.clone().without_spans().items;
        if !findings.is_empty() || items(&file) != items(&self.file) {
            return Err(FormatError::Tree);
        }
        format::format_checked(&file, &text)
    }
}

/// Why a layout or recipe cannot be written in the language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unwritable {
    /// What cannot be written, as a sentence without a full stop.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

impl Unwritable {
    fn new(message: String, help: impl Into<String>) -> Self {
        let help = help.into();
        Self { message, help }
    }
}

/// Returns all that cannot be written of a layout: numbers beyond the limits of the language. The
/// layout has no [`problems`](Layout::problems) but warnings.
pub fn unwritable_in_layout(layout: &Layout) -> Vec<Unwritable> {
    let mut found = Vec::new();
    for resource in &layout.resources {
        let (name, capacity) = (&resource.name, resource.capacity);
        if !(1..=MAX_CAPACITY).contains(&(capacity as u64)) {
            let message =
                format!("`{name}` has room for {capacity} parts, which is no possible capacity");
            let help = format!("give it a capacity of 1 to {MAX_CAPACITY} parts");
            found.push(Unwritable::new(message, help));
        }
        for transition in &resource.transitions {
            for (value, dimension) in [
                (transition.seconds, Dimension::Time),
                (transition.watts, Dimension::Power),
            ] {
                let refused = value.and_then(|v| out_of_range(v, dimension));
                found.extend(refused.map(|(message, help)| {
                    let (from, to) = (&transition.from, &transition.to);
                    Unwritable::new(format!("`{name}`, `{from}` to `{to}`: {message}"), help)
                }));
            }
        }
    }
    found
}

/// Returns what cannot be written of a recipe: that it never ends. The recipe has no
/// [`problems`](Recipe::problems) but warnings.
pub fn unwritable_in_recipe(recipe: &Recipe) -> Vec<Unwritable> {
    if Reduced::of(recipe).ends.is_empty() {
        let message = format!("no transition of `{}` leads to an end", recipe.name);
        let help = "let a transition enter one of the states where it ends";
        return vec![Unwritable::new(message, help)];
    }
    Vec::new()
}

/// Returns the syntax tree of layouts and recipes in which nothing is
/// [unwritable](unwritable_in_layout). Takes time proportional to their size, times the logarithm
/// of the number of names.
pub fn tree(layouts: &[Layout], recipes: &[Recipe]) -> RecipeTree {
    let words = Words::of(layouts, recipes);
    let mut items = Vec::new();
    for (number, layout) in layouts.iter().enumerate() {
        items.push(Item::Layout(words.layout_tree(number, layout)));
    }
    for (number, recipe) in recipes.iter().enumerate() {
        let name = words.recipe(layouts.len(), number);
        items.push(Item::Recipe(words.recipe_tree(name, recipe)));
    }
    if layouts.len() == 1 {
        for number in 0..recipes.len() {
            let wanted = CountedName {
                count: None,
                name: word(words.recipe(layouts.len(), number)),
            };
            items.push(Item::Realize(ast::Realize {
                recipes: vec![wanted],
                layout: word(words.layout(0)),
            }));
        }
    }
    RecipeTree {
        file: ast::File {
            items,
            ..ast::File::default()
        },
        renamed: words.renamed,
    }
}

fn word(text: impl Into<String>) -> Name {
    Name {
        text: text.into(),
        span: Span::default(),
    }
}

fn quantity(value: f64, unit: &str) -> Expr {
    Expr {
        kind: ExprKind::Quantity(value, unit.to_owned()),
        span: Span::default(),
    }
}

/// The part of a recipe that means something.
struct Reduced<'a> {
    transitions: &'a [RecipeTransition],
    ends: Vec<&'a String>,
}

impl<'a> Reduced<'a> {
    fn of(recipe: &'a Recipe) -> Self {
        if recipe.ends.contains(&recipe.start) {
            return Self {
                transitions: &[],
                ends: vec![&recipe.start],
            };
        }
        let transitions = recipe.transitions.as_slice();
        let entered: FxHashSet<&String> = transitions.iter().map(|t| &t.to).collect();
        let ends = recipe.ends.iter();
        Self {
            transitions,
            ends: ends.filter(|end| entered.contains(end)).collect(),
        }
    }
}

impl Words {
    fn names(&self, names: &[String]) -> Vec<Name> {
        names.iter().map(|n| word(self.plain(n))).collect()
    }

    fn layout_tree(&self, number: usize, layout: &Layout) -> ast::Layout {
        let resources = layout.resources.iter();
        let mut items: Vec<LayoutItem> = resources
            .map(|r| LayoutItem::Resource(self.resource(r)))
            .collect();
        for resource in layout.resources.iter().filter(|r| !r.holds.is_empty()) {
            items.push(LayoutItem::AtStart {
                resource: word(self.plain(&resource.name)),
                state: word(self.plain(&resource.initial)),
                parts: self.stock(&resource.holds),
            });
        }
        ast::Layout {
            doc: String::new(),
            name: word(self.layout(number)),
            items,
            broken: false,
        }
    }

    /// Parts at the start; the same ones in succession are counted.
    fn stock(&self, holds: &[String]) -> Vec<CountedName> {
        let groups = holds.chunk_by(|a, b| a == b);
        groups
            .map(|group| CountedName {
                count: (group.len() > 1).then_some(group.len() as u64),
                name: word(self.plain(&group[0])),
            })
            .collect()
    }

    fn resource(&self, resource: &Resource) -> ast::Resource {
        let transitions = resource.transitions.iter();
        let mut known: FxHashSet<&String> = transitions.flat_map(|t| [&t.from, &t.to]).collect();
        let transitions = if known.insert(&resource.initial) {
            // It stays in its first state.
            known = FxHashSet::from_iter([&resource.initial]);
            &[]
        } else {
            resource.transitions.as_slice()
        };
        let joined = transitions.chunk_by(|a, b| a.from == b.from && a.to == b.to);
        let mut items: Vec<ResourceItem> = joined
            .map(|group| ResourceItem::Transition {
                from: word(self.plain(&group[0].from)),
                to: word(self.plain(&group[0].to)),
                actions: group.iter().map(|t| self.action(t)).collect(),
            })
            .collect();
        let waiting = resource.states.iter().filter(|s| s.may_wait);
        let waiting = waiting.filter(|s| known.contains(&s.name));
        let waiting: Vec<Name> = waiting.map(|s| word(self.plain(&s.name))).collect();
        if !waiting.is_empty() {
            items.push(ResourceItem::Nop(waiting));
        }
        let capacity = PartCapacity {
            count: resource.capacity as u64,
            span: Span::default(),
        };
        ast::Resource {
            doc: String::new(),
            name: word(self.plain(&resource.name)),
            kind: None,
            initial: word(self.plain(&resource.initial)),
            capacity: Some(capacity).filter(|c| c.count != 1),
            items,
        }
    }

    fn action(&self, transition: &Transition) -> ast::ResourceAction {
        let kind = match &transition.action {
            Action::Operation(name) => ActionKind::Operation(word(self.plain(name))),
            Action::Internal(name) => ActionKind::Internal(word(self.plain(name))),
            Action::In(label) => ActionKind::In(Some(word(self.label(label)))),
            Action::Out(label) => ActionKind::Out(Some(word(self.label(label)))),
        };
        ast::ResourceAction {
            kind,
            time: transition.seconds.map(|s| quantity(s, "s")),
            power: transition.watts.map(|w| quantity(w, "W")),
            span: Span::default(),
        }
    }

    fn recipe_tree(&self, name: &str, recipe: &Recipe) -> ast::Recipe {
        let Reduced { transitions, ends } = Reduced::of(recipe);
        let mut items = Vec::new();
        let parts = recipe.parts.iter().map(|part| RecipePart {
            name: word(self.plain(&part.name)),
            kind: (part.kind != part.name).then(|| word(self.plain(&part.kind))),
        });
        let parts: Vec<RecipePart> = parts.collect();
        if !parts.is_empty() {
            items.push(RecipeItem::Parts(parts));
        }
        items.push(RecipeItem::Start(word(self.plain(&recipe.start))));
        let transitions = transitions.iter();
        items.extend(transitions.map(|t| RecipeItem::Transition(self.recipe_transition(t))));
        let ends = ends.into_iter().map(|e| word(self.plain(e)));
        items.push(RecipeItem::Ends(ends.collect()));
        if !recipe.leftover.is_empty() {
            items.push(RecipeItem::Leftover(self.names(&recipe.leftover)));
        }
        ast::Recipe {
            doc: String::new(),
            name: word(name),
            items,
            broken: false,
        }
    }

    fn recipe_transition(&self, transition: &RecipeTransition) -> ast::RecipeTransition {
        let guard = match &transition.guard {
            Guard::Always => None,
            Guard::Otherwise => Some(RecipeGuard::Otherwise(Span::default())),
            Guard::Test { name, inputs, at } => Some(RecipeGuard::When {
                test: word(self.plain(name)),
                parts: self.names(inputs),
                at: self.names(at),
            }),
        };
        let steps = transition.steps.iter();
        let steps = steps.map(|s| s.operations.iter().map(|c| self.call(c)).collect());
        ast::RecipeTransition {
            from: word(self.plain(&transition.from)),
            to: word(self.plain(&transition.to)),
            guard,
            steps: steps.collect(),
        }
    }

    fn call(&self, call: &OperationCall) -> ast::RecipeCall {
        ast::RecipeCall {
            name: word(self.plain(&call.name)),
            inputs: self.names(&call.inputs),
            outputs: self.names(&call.outputs),
            span: Span::default(),
        }
    }
}
