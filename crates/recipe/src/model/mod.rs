//! Layouts and recipes as plain data, with names as the user wrote them.

mod duplicate;
mod layout;
mod problem;
mod recipe;
mod validate;

pub use duplicate::DuplicateError;
pub use layout::{Action, Layout, Resource, State, Transition};
pub use problem::Problem;
pub use recipe::{Guard, OperationCall, Part, Recipe, RecipeTransition, Step};
