//! What coordinates a run: a plan, or the synthesized controller.

use crate::contract::Library;
use crate::contract::recipe::{Layout, Realization};
use crate::diagnostics::Diagnostic;
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::machine::{RecipeMachine, build};
use crate::engine::recipes::{self, Aim, Solution, words};
use crate::game::BudgetFactor;
use crate::recipe::plan::{Objective, Plan};
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

/// What coordinates the resources of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinator {
    /// The plan with least time or least steps.
    Plan,
    /// The synthesized controller, vector by vector.
    Controller,
}

/// Fails if a statement cannot be coordinated like this.
pub(super) fn check(coordinator: Coordinator, realization: &Realization) -> anyhow::Result<()> {
    if coordinator == Coordinator::Controller && !realization.is_single() {
        anyhow::bail!(
            "`{}` asks for several products, and a controller coordinates one: leave out `--coordinator controller`",
            words::title(realization)
        );
    }
    Ok(())
}

/// Returns where a run begins for which no plan was found with the times of the layout: the plan
/// with least steps. A controller can make the product all the same, if resources wait.
pub(super) fn start(
    layout: &Layout,
    library: &Library,
    realization: &Realization,
    aim: Aim,
) -> Option<Plan> {
    let steps = Aim {
        objective: Objective::Steps,
        ..aim
    };
    let decision = recipes::plan_on(layout, library, realization, steps);
    let plan = decision.solution.as_ref().and_then(Solution::plan)?;
    Some(Plan {
        objective: aim.objective,
        ..plan.clone()
    })
}

/// Returns the verified controller of a statement for one product, or why there is none.
pub(super) fn controller(
    layout: &Layout,
    library: &Library,
    realization: &Realization,
    factor: BudgetFactor,
) -> Result<RecipeMachine, (Verdict, Vec<Diagnostic>)> {
    let aim = Aim {
        objective: Objective::Steps,
        factor,
        as_plan: false,
    };
    let decision = recipes::plan_on(layout, library, realization, aim);
    let wanted = realization.recipes.first();
    let recipe = wanted.and_then(|wanted| library.recipe_at(wanted.declared));
    let (Some(Solution::Controller(controller)), Some(recipe)) = (decision.solution, recipe) else {
        return Err((decision.verdict, decision.findings));
    };
    build(&layout.model, &recipe.model, &controller).map_err(|fault| {
        let finding = fault.finding(Some(realization.span));
        (Verdict::InternalError, vec![finding])
    })
}
