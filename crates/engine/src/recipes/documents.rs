//! Plans as B2MML documents.

use crate::internal::Fault;
use linewright_b2mml::{Schedule, WriteError, write};
use linewright_recipe::controller::Controller;
use linewright_recipe::model::{Layout, Recipe};

/// A document of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanDocument {
    /// Last part of its file name, without a dot in front: `schedule.xml`.
    pub ending: &'static str,
    /// The document.
    pub text: String,
}

/// Returns the documents of a plan: the layout as `EquipmentInformation`, the recipe as
/// `OperationsDefinition`, and as `WorkflowSpecification`, too, if it has choices or loops, and the
/// controller as `OperationsSchedule`, unless there is nothing to do.
///
/// Takes time proportional to the size of the controller, the layout and the recipe.
///
/// # Errors
/// The controller is not one of this layout and recipe, or these have problems.
pub fn documents(
    layout: &Layout,
    recipe: &Recipe,
    controller: &Controller,
) -> Result<Vec<PlanDocument>, Fault> {
    let fault = |reason: String| {
        let doing = format!("writing `{}` on `{}` as B2MML", recipe.name, layout.name);
        Fault::detected(doing, reason)
    };
    let refused = |error: WriteError| fault(error.to_string());
    let mut documents = Vec::new();
    let mut add = |ending, text| documents.push(PlanDocument { ending, text });
    add("equipment.xml", write::equipment(layout).map_err(refused)?);
    add(
        "definition.xml",
        write::definition(recipe).map_err(refused)?,
    );
    if has_choices_or_loops(recipe) {
        add("workflow.xml", write::workflow(recipe).map_err(refused)?);
    }
    let schedule =
        Schedule::of(layout, recipe, controller).map_err(|error| fault(error.to_string()))?;
    if !schedule.requests.is_empty() {
        add("schedule.xml", write::schedule(&schedule).map_err(refused)?);
    }
    Ok(documents)
}

fn has_choices_or_loops(recipe: &Recipe) -> bool {
    let mut left: Vec<&str> = recipe.transitions.iter().map(|t| t.from.as_str()).collect();
    let count = left.len();
    left.sort_unstable();
    left.dedup();
    left.len() < count || recipe.closes_loop().contains(&true)
}
