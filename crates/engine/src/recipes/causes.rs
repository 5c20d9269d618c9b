//! Why a recipe cannot be made: the causes that need no search, or what alone would mend it, or the
//! step that can never be performed.

use super::findings::Subject;
use super::relaxed::{Relaxation, relaxations};
use super::words::quoted;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_recipe::realize::{Refusal, SearchLimits};

/// Returns the findings for a recipe that cannot be made; at least one is an error.
pub(super) fn find(of: &Subject<'_>, refusal: &Refusal, limits: SearchLimits) -> Vec<Diagnostic> {
    if !refusal.obstacles.is_empty() {
        return refusal.obstacles.iter().map(|o| of.finding(o)).collect();
    }
    let relaxed = relaxations(of, limits);
    if relaxed.is_empty() {
        return vec![of.unrealizable(&refusal.furthest_steps)];
    }
    relaxed.iter().map(|r| finding(of, r)).collect()
}

fn finding(of: &Subject<'_>, relaxation: &Relaxation) -> Diagnostic {
    let (layout, recipe) = (of.layout, of.recipe);
    let title = format!(
        "`{}` cannot be made on `{}`",
        recipe.model.name, layout.model.name
    );
    match relaxation {
        Relaxation::Leftover(parts) => {
            let first = parts.first().and_then(|p| recipe.model.part(p));
            of.error(
                codes::RECIPE_LEFTOVER,
                first.map_or(recipe.span, |at| recipe.parts[at]),
                format!(
                    "{title} without {} remaining in the cell",
                    quoted(parts.iter().map(String::as_str))
                ),
                format!(
                    "take it out with an operation, or allow it to remain: `leftover {}`",
                    parts.join(", ")
                ),
            )
        }
        Relaxation::Waiting(at, state) => {
            let resource = &layout.model.resources[*at];
            let name = &resource.states[*state].name;
            of.error(
                codes::RECIPE_WAIT,
                layout.resources[*at].states[*state],
                format!(
                    "{title} because `{}` may not wait in state `{name}`",
                    resource.name
                ),
                format!("let it wait there: `nop {name}`"),
            )
        }
        Relaxation::WaitingEverywhere => of.error(
            codes::RECIPE_WAIT,
            layout.span,
            format!("{title} because several resources may not wait in some of their states"),
            "let them wait there with `nop`".to_owned(),
        ),
        Relaxation::Room(at) => {
            let resource = &layout.model.resources[*at];
            let room = resource.capacity;
            let info = &layout.resources[*at];
            of.error(
                codes::RECIPE_ROOM,
                info.capacity.unwrap_or(info.name),
                format!(
                    "{title} because `{}` has room for {room} only",
                    resource.name
                ),
                format!("give it room: `holds {}`", room + 1),
            )
        }
    }
}
