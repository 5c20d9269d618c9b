//! What is to be made on a layout: the decision, its verification, and the causes in words.
//!
//! ```text
//! contract::recipe::Realization ─decide→ Decision (controller, verified by a replay) or findings
//! ```

mod causes;
mod findings;
mod relaxed;
pub mod words;

use crate::internal::{self, Fault};
use crate::pipeline::Verdict;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::Library;
use linewright_language::contract::recipe::{Layout, Realization, Recipe};
use linewright_recipe::controller::Controller;
use linewright_recipe::realize::{Outcome, SearchLimits, SearchSize, realize};
use linewright_recipe::replay;
use linewright_solver::game::BudgetFactor;

/// Decision about a statement `realize`.
#[derive(Debug, Clone)]
pub struct Decision {
    /// The verdict.
    pub verdict: Verdict,
    /// If realizable: the controller, which has passed the replay.
    pub controller: Option<Controller>,
    /// Why it cannot be made, or is not decided.
    pub findings: Vec<Diagnostic>,
}

impl Decision {
    fn without_controller(verdict: Verdict, findings: Vec<Diagnostic>) -> Self {
        Self {
            verdict,
            controller: None,
            findings,
        }
    }
}

/// Returns the limits of a search: those of the crate `recipe` times the factor.
pub fn limits(factor: BudgetFactor) -> SearchLimits {
    let scaled = |count: usize| usize::try_from(factor.scale(count as u64)).unwrap_or(usize::MAX);
    let SearchLimits { nodes, vectors } = SearchLimits::default();
    SearchLimits {
        nodes: scaled(nodes),
        vectors: scaled(vectors),
    }
}

/// Decides whether the products of a statement can be made, and names the causes if not. A
/// controller is replayed; one that the replay refuses is an internal error.
///
/// Takes the time of [`realize`]; for an unrealizable recipe, also that of at most some dozen
/// searches for a verdict.
pub fn decide(library: &Library, realization: &Realization, limits: SearchLimits) -> Decision {
    let doing = || format!("deciding whether {} can be made", words::title(realization));
    internal::caught(doing, || decided(library, realization, limits)).unwrap_or_else(|fault| {
        let finding = fault.finding(Some(realization.span));
        Decision::without_controller(Verdict::InternalError, vec![finding])
    })
}

fn decided(library: &Library, realization: &Realization, limits: SearchLimits) -> Decision {
    let Some(layout) = library.layout_at(realization.layout_declared) else {
        return Decision::without_controller(Verdict::Invalid, Vec::new());
    };
    let [wanted] = realization.recipes.as_slice() else {
        return several(realization);
    };
    if wanted.count > 1 {
        return several(realization);
    }
    let Some(recipe) = library.recipe_at(wanted.declared) else {
        return Decision::without_controller(Verdict::Invalid, Vec::new());
    };
    on_layout(layout, recipe, realization, limits)
}

/// Decides whether one product of a recipe can be made on a layout. The realization is only named
/// in findings.
fn on_layout(
    layout: &Layout,
    recipe: &Recipe,
    realization: &Realization,
    limits: SearchLimits,
) -> Decision {
    match attempt(layout, recipe, limits) {
        Ok(Outcome::Realizable(controller)) => Decision {
            verdict: Verdict::Realizable,
            controller: Some(controller),
            findings: Vec::new(),
        },
        Ok(Outcome::Unrealizable(refusal)) => {
            let of = findings::Subject {
                layout,
                recipe,
                realization,
            };
            let found = causes::find(&of, &refusal, limits);
            Decision::without_controller(Verdict::Unrealizable, found)
        }
        Ok(Outcome::GaveUp(size)) => {
            Decision::without_controller(Verdict::GaveUp, vec![gave_up(realization, size)])
        }
        Err(fault) => {
            let finding = fault.finding(Some(realization.span));
            Decision::without_controller(Verdict::InternalError, vec![finding])
        }
    }
}

/// Decides whether one product of a recipe can be made on a layout, and replays the controller.
///
/// # Errors
/// The replay refuses the controller, or the models have problems that the resolver should have
/// reported.
pub fn attempt(layout: &Layout, recipe: &Recipe, limits: SearchLimits) -> Result<Outcome, Fault> {
    let (layout, recipe) = (&layout.model, &recipe.model);
    let doing = || format!("making `{}` on `{}`", recipe.name, layout.name);
    let outcome = realize(layout, recipe, limits).map_err(|problems| {
        let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
        Fault::detected(doing(), problems.join("; "))
    })?;
    if let Outcome::Realizable(controller) = &outcome {
        replay::verify(layout, recipe, controller)
            .map_err(|fault| Fault::detected(doing(), format!("the replay failed: {fault}")))?;
    }
    Ok(outcome)
}

/// The decision about several products.
fn several(realization: &Realization) -> Decision {
    let finding = Diagnostic::warning(
        codes::RECIPE_UNDECIDED,
        realization.span,
        "it is not decided yet whether several products can be made at once",
    )
    .with_help("ask for one product of one recipe in each statement")
    .giving_up(true);
    Decision::without_controller(Verdict::GaveUp, vec![finding])
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
