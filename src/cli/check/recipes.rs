//! The entries of layouts and recipes, and of what is to be made.

use super::assembly::Assembly;
use super::document::{LayoutEntry, RealizationEntry, RecipeEntry, Validity};
use super::view::FileView;
use crate::cli::outline::Declaration;
use crate::diagnostics::{Diagnostic, has_errors, json};
use crate::engine::pipeline::Verdict;
use crate::engine::recipes;

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
        let limits = recipes::limits(self.prover.limits().budget_factor);
        let decision = realization.map(|r| recipes::decide(library, r, limits));
        let (verdict, controller) = match decision {
            Some(mut decision) => {
                findings.append(&mut decision.findings);
                (decision.verdict, decision.controller)
            }
            None => (Verdict::Invalid, None),
        };
        RealizationEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            verdict,
            worst_case: controller.as_ref().map(|c| c.worst_case),
            is_least: controller.as_ref().map(|c| c.is_least),
            findings: json::findings(&library.sources, findings),
        }
    }
}

fn validity(is_usable: bool) -> Validity {
    if is_usable {
        Validity::Valid
    } else {
        Validity::Invalid
    }
}
