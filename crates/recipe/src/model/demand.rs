//! Demands: how many products of which recipe are to be made on one layout.

use super::{Layout, Problem, Recipe};

/// Maximum number of products that are made together.
const MAX_PRODUCTS: usize = 10_000;

/// How many products of a recipe are to be made.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Demand {
    /// The recipe.
    pub recipe: Recipe,
    /// Number of products, 0 to 10,000.
    pub count: usize,
}

impl Demand {
    /// Creates a demand.
    pub fn new(recipe: Recipe, count: usize) -> Self {
        Self { recipe, count }
    }
}

/// Returns all problems of a layout and of the recipes that are to be made on it.
pub fn demand_problems(layout: &Layout, demands: &[Demand]) -> Vec<Problem> {
    let mut problems = layout.problems();
    for demand in demands {
        problems.extend(demand.recipe.problems());
        problems.extend(demand.recipe.problems_on(layout));
    }
    let products: usize = demands.iter().map(|d| d.count.min(MAX_PRODUCTS + 1)).sum();
    let parts = demands
        .iter()
        .map(|d| (d.count.min(MAX_PRODUCTS) + 1) * d.recipe.parts.len());
    if products > MAX_PRODUCTS || parts.sum::<usize>() > 50_000 {
        problems.push(Problem::TooLarge {
            what: "products or parts of products",
            limit: MAX_PRODUCTS.min(50_000),
        });
    }
    problems
}
