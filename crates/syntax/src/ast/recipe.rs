//! Layouts of resources, recipes, and what is to be made where.

use super::{ConstDecl, Expr, Name};
use linewright_core::source::Span;

/// `layout ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the layout.
    pub name: Name,
    /// Items within the braces.
    pub items: Vec<LayoutItem>,
    /// Whether some part could not be parsed; this was reported.
    pub broken: bool,
}

/// An item of a layout.
#[derive(Debug, Clone, PartialEq)]
pub enum LayoutItem {
    /// `resource r3: GlueRobot at s0 { ... }`
    Resource(Resource),
    /// `resource r6 = r3`
    Duplicate {
        /// Name of the duplicate.
        name: Name,
        /// Name of the original.
        of: Name,
    },
    /// `transport shuttle { ... }`
    Transport(Transport),
    /// `at start r2 s3 holds h`
    AtStart {
        /// Name of the resource.
        resource: Name,
        /// Name of its state.
        state: Name,
        /// What it holds.
        parts: Vec<CountedName>,
    },
    /// `const ...`
    Const(ConstDecl),
}

/// `resource r3: GlueRobot at s0 holds 2 { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Resource {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the resource.
    pub name: Name,
    /// Type of the resource, or its machine, if written.
    pub kind: Option<Name>,
    /// Name of the state at the start.
    pub initial: Name,
    /// Capacity in parts, if written.
    pub capacity: Option<PartCapacity>,
    /// Items within the braces.
    pub items: Vec<ResourceItem>,
}

/// `holds 2`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartCapacity {
    /// Maximum number of parts.
    pub count: u64,
    /// Place of the number.
    pub span: Span,
}

/// An item of a resource.
#[derive(Debug, Clone, PartialEq)]
pub enum ResourceItem {
    /// `s1 -> s2: glue in 12 s, engrave in 8 s`
    Transition {
        /// State that it leaves.
        from: Name,
        /// State that it enters.
        to: Name,
        /// What happens; one of these.
        actions: Vec<ResourceAction>,
    },
    /// `nop s0, s1`: states in which the resource may wait.
    Nop(Vec<Name>),
}

/// `glue in 12 s power 300 W`
#[derive(Debug, Clone, PartialEq)]
pub struct ResourceAction {
    /// What happens.
    pub kind: ActionKind,
    /// Duration, if written.
    pub time: Option<Expr>,
    /// Electrical power, if written.
    pub power: Option<Expr>,
    /// Place of the action without its duration and power.
    pub span: Span,
}

/// Kinds of actions of a resource.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ActionKind {
    /// `glue`
    Operation(Name),
    /// `internal turn`
    Internal(Name),
    /// `in:3`, or `in`, whose label is the name of the resource.
    In(Option<Name>),
    /// `out:3` or `out`
    Out(Option<Name>),
}

/// `transport shuttle holds 1 { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Transport {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the transport.
    pub name: Name,
    /// Number of parts that it carries at once, if written.
    pub capacity: Option<PartCapacity>,
    /// Routes.
    pub routes: Vec<TransportRoute>,
}

/// `r2 -> r3, r4 in 6 s power 100 W`
#[derive(Debug, Clone, PartialEq)]
pub struct TransportRoute {
    /// Where it takes a part; at least one.
    pub from: Vec<Dock>,
    /// Where it gives the part; at least one.
    pub to: Vec<Dock>,
    /// Duration, if written.
    pub time: Option<Expr>,
    /// Electrical power, if written.
    pub power: Option<Expr>,
}

/// `r3`, or `r3:left`: an end of a route.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dock {
    /// Name of the resource.
    pub resource: Name,
    /// Label of the resource's transfers, if written.
    pub label: Option<Name>,
}

impl Dock {
    /// Returns the place of the dock.
    pub fn span(&self) -> Span {
        let last = self.label.as_ref().unwrap_or(&self.resource);
        self.resource.span.to(last.span)
    }
}

/// `3 Hinge`, or `Hinge`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CountedName {
    /// Number, if written.
    pub count: Option<u64>,
    /// What is counted.
    pub name: Name,
}

/// `recipe ...`
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// Doc comment without slashes.
    pub doc: String,
    /// Name of the recipe.
    pub name: Name,
    /// Items within the braces.
    pub items: Vec<RecipeItem>,
    /// Whether some part could not be parsed; this was reported.
    pub broken: bool,
}

/// An item of a recipe.
#[derive(Debug, Clone, PartialEq)]
pub enum RecipeItem {
    /// `part f: Fixture, p: Pin`
    Parts(Vec<RecipePart>),
    /// `start a`
    Start(Name),
    /// `end d, e`
    Ends(Vec<Name>),
    /// `leftover p, Screw`
    Leftover(Vec<Name>),
    /// `a -> b when visionOk(h2): force(h2)(h2)`
    Transition(RecipeTransition),
}

/// `f: Fixture`, or `Fixture`, whose type has the same name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipePart {
    /// Name of the part.
    pub name: Name,
    /// Type of the part, if written.
    pub kind: Option<Name>,
}

/// `a -> b when visionOk(h2): force(h2)(h2); remove(h2)()`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipeTransition {
    /// State that it leaves.
    pub from: Name,
    /// State that it enters.
    pub to: Name,
    /// When it is taken; `None` for always.
    pub guard: Option<RecipeGuard>,
    /// Steps in sequence, each with its parallel operations.
    pub steps: Vec<Vec<RecipeCall>>,
}

impl RecipeTransition {
    /// Returns the place of the states, without the guard and the steps.
    pub fn span(&self) -> Span {
        self.from.span.to(self.to.span)
    }
}

/// The guard of a transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecipeGuard {
    /// `when visionOk(h2) at r4`
    When {
        /// Name of the test.
        test: Name,
        /// Tested parts.
        parts: Vec<Name>,
        /// Resources that can perform the test; empty if not written.
        at: Vec<Name>,
    },
    /// `otherwise`, and its place.
    Otherwise(Span),
}

/// `insert(p, h)(h2)`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipeCall {
    /// Name of the operation.
    pub name: Name,
    /// Parts that it needs.
    pub inputs: Vec<Name>,
    /// Parts that it makes.
    pub outputs: Vec<Name>,
    /// Place of the whole call.
    pub span: Span,
}

/// `realize 3 Hinge, 2 Plate on Pad`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Realize {
    /// Recipes and how often each is made.
    pub recipes: Vec<CountedName>,
    /// Name of the layout.
    pub layout: Name,
}
