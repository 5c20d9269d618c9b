//! The entries of layouts and recipes.

use super::assembly::Assembly;
use super::document::{LayoutEntry, RecipeEntry, Validity};
use super::view::FileView;
use crate::cli::outline::Declaration;
use crate::diagnostics::{Diagnostic, has_errors, json};

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
}

fn validity(is_usable: bool) -> Validity {
    if is_usable {
        Validity::Valid
    } else {
        Validity::Invalid
    }
}
