//! The entries of layouts and recipes, and of what is to be made.

use super::assembly::Assembly;
use super::document::{LayoutEntry, RealizationEntry, RecipeEntry, Validity};
use super::view::FileView;
use crate::cli::outline::Declaration;
use crate::diagnostics::{Diagnostic, has_errors, json};
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::{self, Solution};

impl Assembly<'_> {
    pub(super) fn layout(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &[Diagnostic],
    ) -> LayoutEntry {
        let library = &self.loaded.library;
        let layout = (library.layouts.iter())
            .find(|l| declaration.holds(l.span))
            .filter(|_| !file.broken && !has_errors(findings));
        LayoutEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            verdict: validity(layout.is_some()),
            resources: layout.map_or(0, |l| l.model.resources.len()),
            findings: json::findings(&library.sources, findings),
        }
    }

    pub(super) fn recipe(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &[Diagnostic],
    ) -> RecipeEntry {
        let library = &self.loaded.library;
        let recipe = (library.recipes.iter())
            .find(|r| declaration.holds(r.span))
            .filter(|_| !file.broken && !has_errors(findings));
        RecipeEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            verdict: validity(recipe.is_some()),
            states: recipe.map_or(0, |r| r.model.states.len()),
            transitions: recipe.map_or(0, |r| r.model.transitions.len()),
            findings: json::findings(&library.sources, findings),
        }
    }

    /// Decides whether the products of a statement can be made, unless there is an error in it or
    /// in what it names.
    pub(super) fn realization(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &mut Vec<Diagnostic>,
    ) -> RealizationEntry {
        let library = &self.loaded.library;
        let realization = (library.realizations.iter())
            .find(|r| declaration.holds(r.span))
            .filter(|_| !file.broken && !has_errors(findings));
        let factor = self.prover.limits().budget_factor;
        let decision = realization.map(|r| recipes::decide(library, r, factor));
        let (verdict, solution) = match decision {
            Some(mut decision) => {
                findings.append(&mut decision.findings);
                (decision.verdict, decision.solution)
            }
            None => (Verdict::Invalid, None),
        };
        RealizationEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            verdict,
            worst_case: solution.as_ref().map(Solution::value),
            is_least: solution.as_ref().map(Solution::is_least),
            lower_bound: solution.as_ref().and_then(lower_bound),
            findings: json::findings(&library.sources, findings),
        }
    }
}

/// The least number of steps that is not excluded, of a plan that may not be the best.
fn lower_bound(solution: &Solution) -> Option<u64> {
    let plan = solution.plan().filter(|plan| !plan.is_least())?;
    u64::try_from(plan.lower_bound).ok()
}

fn validity(is_usable: bool) -> Validity {
    if is_usable {
        Validity::Valid
    } else {
        Validity::Invalid
    }
}
