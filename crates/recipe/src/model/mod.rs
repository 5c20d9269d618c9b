//! Layouts and recipes as plain data, with names as the user wrote them.

mod demand;
mod duplicate;
mod layout;
mod problem;
mod recipe;
mod validate;

pub use demand::{Demand, demand_problems};
pub use duplicate::DuplicateError;
pub use layout::{Action, Layout, Resource, State, Transition};
pub use problem::Problem;
pub use recipe::{Guard, OperationCall, Part, Recipe, RecipeTransition, Step};
