//! Resolution of layouts, recipes and `realize`, to the models of the crate `recipe`.
//!
//! All problems are reported at once. A declaration with errors is left out of the library.

mod findings;
mod layout;
mod process;
mod resource;
mod transport;

use super::recipe::{Layout, Realization, Recipe, WantedRecipe};
use super::scope::Scope;
use super::skills::near_or_all;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_syntax::ast;

pub(super) use layout::{MAX_CAPACITY, layout};
pub(super) use process::recipe;

/// Maximum number of products of one recipe that a statement can ask for.
const MAX_PRODUCTS: u64 = 10_000;

/// Returns the finding for a name that is not declared. `they_are` introduces the list of known
/// names, if none of them is similar.
fn unknown<'n>(
    name: &ast::Name,
    message: String,
    known: impl Iterator<Item = &'n str> + Clone,
    they_are: &str,
) -> Diagnostic {
    let finding = Diagnostic::error(codes::NAME_UNKNOWN, name.span, message);
    if known.clone().next().is_none() {
        return finding.with_help("declare it, or correct the name");
    }
    finding.with_help(near_or_all(&name.text, known, they_are))
}

/// Resolves the names of a statement `realize`. Returns `None` if there is an error, which is added
/// to the findings.
pub(super) fn realize(
    scope: &Scope<'_>,
    decl: &ast::Realize,
    findings: &mut Vec<Diagnostic>,
) -> Option<Realization> {
    let layout = scope.layouts.get(decl.layout.text.as_str());
    if layout.is_none() {
        findings.push(unknown(
            &decl.layout,
            format!("there is no layout `{}`", decl.layout.text),
            scope.layouts.keys().copied(),
            "the layouts are",
        ));
    }
    let mut recipes = Vec::new();
    for wanted in &decl.recipes {
        let name = &wanted.name;
        let count = wanted.count.unwrap_or(1);
        if !(1..=MAX_PRODUCTS).contains(&count) {
            findings.push(
                Diagnostic::error(
                    codes::ARGUMENT,
                    name.span,
                    format!("{count} products cannot be made together"),
                )
                .with_help(format!("write a number from 1 to {MAX_PRODUCTS}")),
            );
        }
        match scope.recipes.get(name.text.as_str()) {
            Some(declared) => recipes.push(WantedRecipe {
                count,
                name: name.text.clone(),
                declared: *declared,
                span: name.span,
            }),
            None => findings.push(unknown(
                name,
                format!("there is no recipe `{}`", name.text),
                scope.recipes.keys().copied(),
                "the recipes are",
            )),
        }
    }
    let first = decl
        .recipes
        .first()
        .map_or(decl.layout.span, |r| r.name.span);
    let is_complete = recipes.len() == decl.recipes.len();
    Some(Realization {
        layout: decl.layout.text.clone(),
        layout_declared: *layout.filter(|_| is_complete)?,
        recipes,
        span: first.to(decl.layout.span),
    })
}

/// Reports what does not fit between a recipe and a layout on which it is to be made.
pub(super) fn report_misfits(recipe: &Recipe, layout: &Layout, findings: &mut Vec<Diagnostic>) {
    for problem in recipe.model.problems_on(&layout.model) {
        findings.push(findings::of_recipe(&problem, recipe, Some(layout)));
    }
}
