//! A plan as text: its value, then a table for each part of its schedule.

use super::quantity::{gap, instant, value};
use super::{Happening, Section, View};
use crate::cli::console::count;
use crate::cli::recipe::aligned;
use crate::recipe::plan::{Execution, Method, Next, Objective, Plan, Progress};
use std::fmt::Write as _;

/// Maximum number of products that are named in the heading of a position.
const MAX_NAMED: usize = 4;

/// Shows the plan of a statement.
pub(in crate::cli::recipe) fn text(title: &str, view: &View<'_>) -> String {
    let plan = view.plan;
    let shown = |raw| value(plan.objective, raw);
    let bound = if plan.is_least() {
        "the least possible".to_owned()
    } else {
        format!(
            "and no plan has less than {} (gap {:.1} %)",
            shown(plan.lower_bound),
            gap(plan) * 100.0
        )
    };
    let mut text = format!(
        "{title}: {} in the worst case, {bound}\n",
        shown(plan.value)
    );
    let _ = writeln!(text, "{}", method(view));
    if let Some(missing) = missing(view) {
        let _ = writeln!(text, "{missing}");
    }
    text + &tables(view)
}

/// Shows the schedule of a plan: a table for each section.
pub(in crate::cli::recipe) fn tables(view: &View<'_>) -> String {
    let mut text = String::new();
    let sections = view.sections();
    for section in &sections {
        text.push('\n');
        if sections.len() > 1 {
            let _ = writeln!(text, "{}  {}", section.number, heading(view, section));
        }
        table(&mut text, view, section);
    }
    if !view.critical.is_empty() {
        text.push_str("\n* on the critical path\n");
    }
    text
}

/// How the plan was found.
fn method(view: &View<'_>) -> String {
    match &view.plan.method {
        Method::Search => "found by a search over all plans".to_owned(),
        Method::JobShop => "found from the schedule with ample buffers".to_owned(),
        Method::OneAfterTheOther(order) => {
            let order = match order.as_slice() {
                [_] => String::new(),
                order => {
                    let names = order.iter().map(|d| view.recipes[*d].name.as_str());
                    format!(" ({})", names.collect::<Vec<_>>().join(", then "))
                }
            };
            format!("made one product after the other{order}; other orders may be better")
        }
    }
}

/// What the layout does not say, if the value is 0 for that reason.
fn missing(view: &View<'_>) -> Option<String> {
    let plan = view.plan;
    let transitions = || view.layout.resources.iter().flat_map(|r| &r.transitions);
    let what = match plan.objective {
        Objective::Time if transitions().all(|t| t.seconds.is_none()) => "duration",
        Objective::Energy if transitions().all(|t| t.watts.is_none()) => "power",
        _ => return None,
    };
    let layout = &view.layout.name;
    Some(format!("no transition of `{layout}` has a {what}"))
}

fn heading(view: &View<'_>, section: &Section<'_>) -> String {
    if let Some(outcome) = section.begins {
        return format!("{}, {}", view.outcome(outcome), at(view.plan, outcome.time));
    }
    if section.position == 0 {
        return "from the start".to_owned();
    }
    let positions = &view.plan.positions;
    let progress = &positions[section.position].progress;
    let ended = progress.iter().filter(|p| **p == Progress::Ended).count();
    let mut parts = Vec::new();
    if ended > 0 {
        parts.push(format!(
            "{ended} of {} finished",
            count(progress.len(), "product")
        ));
    }
    let begun = progress.iter().zip(&positions[0].progress).enumerate();
    let begun = begun.filter(|(_, (now, first))| now != first && **now != Progress::Ended);
    for (product, (now, _)) in begun.take(MAX_NAMED) {
        let recipe = view.recipe(product);
        let of = view.of_product(product);
        parts.push(match now {
            Progress::At(state) => format!("{of}in state {}", recipe.states[*state]),
            Progress::Performing { transition, .. } => {
                let about = &recipe.transitions[*transition];
                format!("{of}from {} to {}", about.from, about.to)
            }
            Progress::Ended => continue,
        });
    }
    if parts.is_empty() {
        "again".to_owned()
    } else {
        parts.join("; ")
    }
}

/// `at 68 s`, or `after step 17`.
fn at(plan: &Plan, time: i64) -> String {
    match plan.execution() {
        Execution::Lockstep => format!("after step {time}"),
        Execution::Timed => format!("at {}", instant(time)),
    }
}

/// Writes what happens in a section, and what follows.
fn table(text: &mut String, view: &View<'_>, section: &Section<'_>) {
    let is_timed = view.plan.execution() == Execution::Timed;
    let times = |h: &Happening<'_>| {
        if is_timed {
            [instant(h.start), instant(h.end)]
        } else {
            [h.end.to_string(), String::new()]
        }
    };
    let product = match view.plan.products.len() {
        0 | 1 => "",
        _ => "product",
    };
    let heads = if is_timed {
        ["start", "end", "", "resource", product, "what"]
    } else {
        ["step", "", "", "resource", product, "what"]
    };
    let mut rows = vec![heads.map(str::to_owned)];
    for happening in view.happenings(section) {
        let [start, end] = times(&happening);
        rows.push([
            start,
            end,
            if happening.is_critical { "*" } else { "" }.to_owned(),
            happening.resource,
            (happening.product.filter(|_| !product.is_empty()))
                .map_or(String::new(), |p| (p + 1).to_string()),
            happening.what,
        ]);
    }
    let (time, follows) = follows(view, section);
    if rows.len() > 1 {
        for line in aligned(&rows, &[0, 1, 4]).lines() {
            let _ = writeln!(text, "  {line}");
        }
    }
    for line in follows {
        let _ = writeln!(text, "  {}  {line}", at(view.plan, time));
    }
}

/// When a section ends, and what follows it.
fn follows(view: &View<'_>, section: &Section<'_>) -> (i64, Vec<String>) {
    match &section.schedule.then {
        Next::End { time } => (*time, vec!["end".to_owned()]),
        Next::Goto {
            time,
            position,
            closes_loop,
        } => {
            let closes = if *closes_loop {
                "a loop is closed, "
            } else {
                ""
            };
            (*time, vec![format!("{closes}go on with {}", position + 1)])
        }
        Next::Test {
            time,
            product,
            outcomes,
        } => {
            let outcomes = outcomes.iter().enumerate().map(|(at, (transition, _))| {
                let outcome = super::Outcome {
                    time: *time,
                    product: *product,
                    transition: *transition,
                };
                format!(
                    "{}: {}",
                    view.outcome(outcome),
                    view.number_after(section, at)
                )
            });
            (*time, outcomes.collect())
        }
    }
}
