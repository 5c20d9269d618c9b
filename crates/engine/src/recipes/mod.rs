//! What is to be made on a layout: the decision, its verification, and the causes in words.
//!
//! ```text
//! contract::recipe::Realization ─decide→ Decision (controller or plan, verified by a replay) or findings
//! B2MML ─import→ text; controller ─documents→ B2MML
//! ```

mod causes;
mod documents;
mod findings;
pub mod import;
pub mod machine;
mod relaxed;
pub mod run;
mod several;
pub mod stations;
mod symbolic;
pub mod words;

pub use documents::{PlanDocument, documents};

use crate::internal::{self, Fault};
use crate::pipeline::Verdict;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::Library;
use linewright_language::contract::recipe::{Layout, Realization, Recipe};
use linewright_recipe::controller::Controller;
use linewright_recipe::plan::{Objective, Plan};
use linewright_recipe::realize::{Outcome, SearchLimits, SearchSize, realize};
use linewright_recipe::replay;
use linewright_solver::game::BudgetFactor;

/// Decision about a statement `realize`.
#[derive(Debug, Clone)]
pub struct Decision {
    /// The verdict.
    pub verdict: Verdict,
    /// If realizable: how, confirmed by a replay.
    pub solution: Option<Solution>,
    /// Why it cannot be made, or is not decided.
    pub findings: Vec<Diagnostic>,
}

/// How the products of a statement are made.
#[derive(Debug, Clone)]
pub enum Solution {
    /// One product, with least steps.
    Controller(Controller),
    /// Several products, or least time, energy or transfers.
    Plan(Plan),
}

impl Solution {
    /// Returns the value in the worst case over the outcomes of the tests: for least steps, their
    /// number.
    pub fn value(&self) -> u64 {
        match self {
            Self::Controller(controller) => u64::from(controller.worst_case),
            Self::Plan(plan) => plan.value.unsigned_abs(),
        }
    }

    /// Returns whether it is proved that no other has a smaller value.
    pub fn is_least(&self) -> bool {
        match self {
            Self::Controller(controller) => controller.is_least,
            Self::Plan(plan) => plan.is_least(),
        }
    }

    /// Returns the plan, if it is one.
    pub fn plan(&self) -> Option<&Plan> {
        match self {
            Self::Controller(_) => None,
            Self::Plan(plan) => Some(plan),
        }
    }
}

/// What is searched for, and how hard.
#[derive(Debug, Clone, Copy)]
pub struct Aim {
    /// What the solution has least of.
    pub objective: Objective,
    /// Factor of the limits.
    pub factor: BudgetFactor,
    /// Whether a plan is wanted even of one product with least steps, which else has a controller.
    pub as_plan: bool,
}

impl Decision {
    fn realizable(solution: Solution) -> Self {
        Self {
            verdict: Verdict::Realizable,
            solution: Some(solution),
            findings: Vec::new(),
        }
    }

    fn without_solution(verdict: Verdict, findings: Vec<Diagnostic>) -> Self {
        Self {
            verdict,
            solution: None,
            findings,
        }
    }
}

/// Returns the limits of a search for one product: those of the crate `recipe` times the factor.
pub fn search_limits(factor: BudgetFactor) -> SearchLimits {
    let scaled = |count: usize| usize::try_from(factor.scale(count as u64)).unwrap_or(usize::MAX);
    let SearchLimits { nodes, vectors } = SearchLimits::default();
    SearchLimits {
        nodes: scaled(nodes),
        vectors: scaled(vectors),
    }
}

/// Decides whether the products of a statement can be made, and names the causes if not. Of several
/// products, the first plan suffices. A solution that its replay refuses is an internal error.
///
/// Takes the time of [`realize`], or of [`linewright_recipe::plan::plan`]; for an unrealizable
/// recipe, also that of at most some dozen searches for a verdict.
pub fn decide(library: &Library, realization: &Realization, factor: BudgetFactor) -> Decision {
    let aim = Aim {
        objective: Objective::Steps,
        factor,
        as_plan: false,
    };
    let layout = library.layout_at(realization.layout_declared);
    decide_with(library, realization, layout, aim, true)
}

/// Decides like [`decide`], and looks for the best plan of the products.
pub fn plan(library: &Library, realization: &Realization, aim: Aim) -> Decision {
    let layout = library.layout_at(realization.layout_declared);
    decide_with(library, realization, layout, aim, false)
}

/// Plans like [`plan`] on the layout of the statement with other times, such as those of
/// [`stations::timed_layout`].
pub fn plan_on(
    layout: &Layout,
    library: &Library,
    realization: &Realization,
    aim: Aim,
) -> Decision {
    decide_with(library, realization, Some(layout), aim, false)
}

fn decide_with(
    library: &Library,
    realization: &Realization,
    layout: Option<&Layout>,
    aim: Aim,
    first: bool,
) -> Decision {
    let doing = || format!("deciding whether {} can be made", words::title(realization));
    internal::caught(doing, || decided(library, realization, layout, aim, first))
        .and_then(|decision| decision)
        .unwrap_or_else(|fault| {
            let finding = fault.finding(Some(realization.span));
            Decision::without_solution(Verdict::InternalError, vec![finding])
        })
}

fn decided(
    library: &Library,
    realization: &Realization,
    layout: Option<&Layout>,
    aim: Aim,
    first: bool,
) -> Result<Decision, Fault> {
    let recipes = (realization.recipes.iter())
        .map(|wanted| library.recipe_at(wanted.declared))
        .collect::<Option<Vec<&Recipe>>>();
    let (Some(layout), Some(recipes)) = (layout, recipes) else {
        return Ok(Decision::without_solution(Verdict::Invalid, Vec::new()));
    };
    let is_single = realization.is_single() && aim.objective == Objective::Steps;
    match recipes.as_slice() {
        [recipe] if is_single && !aim.as_plan => on_layout(layout, recipe, realization, aim.factor),
        recipes => {
            let order = several::Order {
                layout,
                recipes,
                realization,
            };
            several::decide(&order, aim, first)
        }
    }
}

/// Decides whether one product of a recipe can be made on a layout. The realization is only named
/// in findings.
fn on_layout(
    layout: &Layout,
    recipe: &Recipe,
    realization: &Realization,
    factor: BudgetFactor,
) -> Result<Decision, Fault> {
    Ok(match attempt(layout, recipe, factor)? {
        Outcome::Realizable(controller) => Decision::realizable(Solution::Controller(controller)),
        Outcome::Unrealizable(refusal) => {
            let of = findings::Subject {
                layout,
                recipe,
                realization,
            };
            let found = causes::find(&of, &refusal, search_limits(factor));
            Decision::without_solution(Verdict::Unrealizable, found)
        }
        Outcome::GaveUp(size) => {
            Decision::without_solution(Verdict::GaveUp, vec![gave_up(realization, size)])
        }
    })
}

/// Decides whether one product of a recipe can be made on a layout, and replays the controller.
/// Where the explicit search reaches its limits, a symbolic game is tried.
///
/// # Errors
/// The replay refuses the controller, or the models have problems that the resolver should have
/// reported.
pub fn attempt(layout: &Layout, recipe: &Recipe, factor: BudgetFactor) -> Result<Outcome, Fault> {
    let (layout, recipe) = (&layout.model, &recipe.model);
    let doing = || format!("making `{}` on `{}`", recipe.name, layout.name);
    let mut outcome = realize(layout, recipe, search_limits(factor)).map_err(|problems| {
        let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
        Fault::detected(doing(), problems.join("; "))
    })?;
    if let Outcome::GaveUp(_) = outcome
        && let Some(decided) = symbolic::decide(layout, recipe, factor)
    {
        outcome = decided;
    }
    if let Outcome::Realizable(controller) = &outcome {
        replay::verify(layout, recipe, controller)
            .map_err(|fault| Fault::detected(doing(), format!("the replay failed: {fault}")))?;
    }
    Ok(outcome)
}

fn gave_up(realization: &Realization, size: SearchSize) -> Diagnostic {
    Diagnostic::warning(
        codes::RECIPE_UNDECIDED,
        realization.span,
        format!(
            "it is not decided whether {} can be made: the search ended at {} configurations and {} steps",
            words::title(realization),
            size.nodes,
            size.vectors
        ),
    )
    .with_help("`--effort 10` lets it try ten times as many")
    .giving_up(true)
}
