//! Layouts and recipes with names resolved, and what is to be made where.
//!
//! The models are those of the crate `recipe`, which know no text. Beside each model are the places
//! of its elements, so that a finding can point to a resource, a transition or a call.

use linewright_core::source::Span;
use linewright_recipe::model;

/// A layout of resources.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Doc comment without slashes.
    pub doc: String,
    /// Resources: those that are written and the transports, then the duplicates.
    pub model: model::Layout,
    /// What the model does not say of each resource, in the same order.
    pub resources: Vec<ResourceInfo>,
    /// Place of the name.
    pub span: Span,
}

/// What a layout says of a resource beside its model.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ResourceInfo {
    /// Place of the name.
    pub name: Span,
    /// Type of the resource, if written.
    pub kind: Option<String>,
    /// If the type is a machine in sight, whose station library does the work: the place of the
    /// machine's name.
    pub machine: Option<Span>,
    /// Whether the resource is a transport, or a duplicate of one.
    pub is_transport: bool,
    /// Place of the capacity, if written.
    pub capacity: Option<Span>,
    /// Place of each state: where the text mentions it first. A state that a duplicate of another
    /// resource has brought has the place of that duplicate.
    pub states: Vec<Span>,
    /// Place of each transition: its action, or the end of the route to which it belongs.
    pub transitions: Vec<Span>,
    /// Place of each part at the start.
    pub holds: Vec<Span>,
}

/// A recipe.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recipe {
    /// Doc comment without slashes.
    pub doc: String,
    /// Parts, states and transitions.
    pub model: model::Recipe,
    /// Place of each part.
    pub parts: Vec<Span>,
    /// Place of each state: where the text mentions it first.
    pub states: Vec<Span>,
    /// Places of each transition.
    pub transitions: Vec<TransitionPlaces>,
    /// Place of the name.
    pub span: Span,
}

/// Places of a transition of a recipe.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TransitionPlaces {
    /// Place of its two states.
    pub span: Span,
    /// Place of the name of its test or of the word `otherwise`, if it has a guard.
    pub guard: Option<Span>,
    /// Places of the tested parts.
    pub tested: Vec<Span>,
    /// Places of the resources that can perform the test.
    pub testers: Vec<Span>,
    /// For each step, the places of its calls.
    pub steps: Vec<Vec<CallPlaces>>,
}

/// Places of a call of an operation.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CallPlaces {
    /// Place of the whole call.
    pub span: Span,
    /// Place of the operation's name.
    pub name: Span,
    /// Place of each input.
    pub inputs: Vec<Span>,
    /// Place of each output.
    pub outputs: Vec<Span>,
}

/// What is to be made on a layout: `realize 3 Hinge, 2 Plate on Pad`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Realization {
    /// Recipes, each with the number of products.
    pub recipes: Vec<WantedRecipe>,
    /// Name of the layout.
    pub layout: String,
    /// Place of the layout's declaration: [`Layout::span`].
    pub layout_declared: Span,
    /// Place of the statement.
    pub span: Span,
}

impl Realization {
    /// Returns the statement for one product of a recipe on a layout. No file has it, so its place
    /// is that of the recipe.
    pub fn of(recipe: &Recipe, layout: &Layout) -> Self {
        let wanted = WantedRecipe {
            count: 1,
            name: recipe.model.name.clone(),
            declared: recipe.span,
            span: recipe.span,
        };
        Self {
            recipes: vec![wanted],
            layout: layout.model.name.clone(),
            layout_declared: layout.span,
            span: recipe.span,
        }
    }

    /// Returns whether one product is to be made.
    pub fn is_single(&self) -> bool {
        matches!(self.recipes.as_slice(), [wanted] if wanted.count == 1)
    }
}

/// A recipe that is to be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WantedRecipe {
    /// Number of products.
    pub count: u64,
    /// Name of the recipe.
    pub name: String,
    /// Place of the recipe's declaration: [`Recipe::span`].
    pub declared: Span,
    /// Place of the name in the statement.
    pub span: Span,
}
