//! Controllers of recipes: those of the selected statements `realize`.

use super::{Arguments, Emit, Synthesized, write_files};
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::recipe::subject;
use crate::cli::results::Results;
use crate::contract::recipe::Realization;
use crate::diagnostics::Diagnostic;
use crate::engine::files::LoadedFiles;
use crate::engine::recipes::{self, Solution, machine, words};
use crate::mealy::Controller;

/// Fails if an argument makes no sense for a recipe.
pub(super) fn check_arguments(
    arguments: &Arguments,
    realizations: &[&Realization],
) -> anyhow::Result<()> {
    let Some(first) = realizations.first() else {
        return Ok(());
    };
    if let Some(many) = realizations.iter().find(|r| !r.is_single()) {
        anyhow::bail!(
            "`{}` asks for several products, and a controller makes one: `linewright recipe plan` shows their plan",
            words::title(many)
        );
    }
    let emit = arguments.emit.iter().find(|e| e.target().is_some());
    let missing = if arguments.counterstrategy {
        Some(("counterstrategy", "leave out --counterstrategy"))
    } else if arguments.report.is_some() {
        Some(("report", "use --emit svg, or `linewright recipe plan`"))
    } else {
        emit.map(|_| {
            (
                "GR(1) specification",
                "use --emit json, c, st, plcopen, dot or svg",
            )
        })
    };
    if let Some((what, instead)) = missing {
        anyhow::bail!("`{}` has no {what}: {instead}", words::title(first));
    }
    Ok(())
}

/// Decides the statements, and adds the files of their controllers and the findings. Returns the
/// exit code for the verdicts.
pub(super) fn write(
    loaded: &LoadedFiles,
    realizations: &[&Realization],
    forms: &[Emit],
    options: &GlobalOptions,
    written: &mut Results,
    findings: &mut Vec<Diagnostic>,
) -> ExitCode {
    let mut code = ExitCode::Success;
    for realization in realizations {
        let decision = recipes::decide(&loaded.library, realization, options.effort);
        code = code.and(decision.verdict.into());
        findings.extend(decision.findings);
        let ((Some(layout), Some(recipe)), Some(Solution::Controller(controller))) =
            (subject::models(loaded, realization), decision.solution)
        else {
            continue;
        };
        let (layout, recipe) = (&layout.model, &recipe.model);
        let built = match machine::build(layout, recipe, &controller) {
            Ok(built) => built,
            Err(fault) => {
                findings.push(fault.finding(Some(realization.span)));
                continue;
            }
        };
        let specification = built.specification();
        let origin = built.origin(layout, recipe);
        let controller = Controller::Machine(built.machine);
        let synthesized = Synthesized {
            controller: &controller,
            specification: &specification,
            origin,
            span: realization.span,
        };
        for emit in forms {
            match write_files(&synthesized, *emit) {
                Ok(files) => {
                    let title = words::title(realization);
                    findings.extend(written.add(&title, realization.span, files));
                }
                Err(finding) => findings.push(*finding),
            }
        }
    }
    code
}
