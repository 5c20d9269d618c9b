//! Plans as B2MML documents, for all commands that write controllers of recipes.

use super::subject;
use crate::cli::results::{Results, file_name};
use crate::contract::recipe::Realization;
use crate::diagnostics::Diagnostic;
use crate::engine::files::LoadedFiles;
use crate::engine::recipes::{self, Decision, Solution, words};

/// Adds the documents of a decision with a controller to the files that are to be written:
/// `Hinge-on-Pad.schedule.xml` and so on. Returns a finding if they cannot be written.
pub(in crate::cli) fn add_documents(
    loaded: &LoadedFiles,
    realization: &Realization,
    decision: &Decision,
    results: &mut Results,
) -> Option<Diagnostic> {
    let ((Some(layout), Some(recipe)), Some(Solution::Controller(controller))) =
        (subject::models(loaded, realization), &decision.solution)
    else {
        return None;
    };
    let title = words::title(realization);
    let name = title.replace(' ', "-");
    match recipes::documents(&layout.model, &recipe.model, controller) {
        Ok(documents) => {
            let files = documents.into_iter();
            let files = files.map(|d| (file_name(&name, d.ending), d.text));
            results.add(&title, realization.span, files.collect())
        }
        Err(fault) => Some(fault.finding(Some(realization.span))),
    }
}
