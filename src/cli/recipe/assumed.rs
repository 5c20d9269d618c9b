//! Plans that assume operations which the layout lacks: the "approximate controller" that L. de
//! Silva et al. leave as future work (RCIM 58, 2019, section 7).

use super::repair::{self, ChangeKind, LayoutChange};
use super::subject;
use crate::contract::recipe::{Layout, Realization, Recipe};
use crate::engine::files::LoadedFiles;
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::{self, Aim, Decision, words};
use crate::recipe::repair::{Change, apply};

/// A statement `realize` with the decision on it.
pub(super) struct Planned<'l> {
    pub realization: &'l Realization,
    pub decision: Decision,
    /// The layout with the operations that are assumed; `None` if none are.
    layout: Option<Layout>,
    /// The operations that are assumed.
    pub assumed: Vec<LayoutChange>,
}

impl<'l> Planned<'l> {
    /// Decides a statement. If its product cannot be made, up to `most` operations are assumed: the
    /// first of the smallest sets with which it can.
    pub fn new(loaded: &'l LoadedFiles, realization: &'l Realization, aim: Aim, most: u8) -> Self {
        let planned = Self {
            realization,
            decision: recipes::plan(&loaded.library, realization, aim),
            layout: None,
            assumed: Vec::new(),
        };
        if most == 0 || planned.decision.verdict != Verdict::Unrealizable {
            return planned;
        }
        let (Some(layout), Some(recipe)) = subject::models(loaded, realization) else {
            return planned;
        };
        let Some(changes) = missing(realization, layout, recipe, aim, most) else {
            return planned;
        };
        let assumed = changes.iter().map(|change| repair::change(layout, change));
        let assumed = assumed.collect();
        let mut extended = layout.clone();
        extended.model = apply(&layout.model, changes.iter());
        // What is added has no place of its own.
        let models = extended.model.resources.iter();
        for (resource, model) in extended.resources.iter_mut().zip(models) {
            let place = resource.name;
            resource.transitions.resize(model.transitions.len(), place);
        }
        let approximate = recipes::plan_on(&extended, &loaded.library, realization, aim);
        Self {
            // The verdict and its causes stay: the layout as it is cannot make the product.
            decision: Decision {
                solution: approximate.solution,
                ..planned.decision
            },
            layout: Some(extended),
            assumed,
            ..planned
        }
    }

    /// The layout of the plan and, for a single recipe, the recipe.
    pub fn models<'s>(
        &'s self,
        loaded: &'s LoadedFiles,
    ) -> (Option<&'s Layout>, Option<&'s Recipe>) {
        let (layout, recipe) = subject::models(loaded, self.realization);
        (self.layout.as_ref().or(layout), recipe)
    }
}

/// The operations that a layout lacks for a recipe; `None` if more than `most` are missing, or if
/// something else is.
fn missing(
    realization: &Realization,
    layout: &Layout,
    recipe: &Recipe,
    aim: Aim,
    most: u8,
) -> Option<Vec<Change>> {
    let models = (&layout.model, &recipe.model);
    let (found, _) = repair::smallest(models, &[ChangeKind::Operations], most, aim.factor)
        .unwrap_or_else(|problems| {
            repair::unreported(&words::title(realization), &problems).raise()
        });
    found.sets.into_iter().next()
}
