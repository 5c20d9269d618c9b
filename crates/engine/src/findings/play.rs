//! A play as a table: a row per variable, a column per step.

use super::list;
use super::shape::sets;
use linewright_core::gr1::{Formula, Owner, Specification, Timing, VarId};
use linewright_solver::game::{Ending, GuaranteeRef, Play};
use std::fmt::Write as _;

/// Maximum width of the table in characters.
const MAX_WIDTH: usize = 96;

/// Maximum number of steps of a play that is shown completely.
const MAX_STEPS: usize = 40;

/// One row of a table: the owner and name of a variable, and its value in every step.
pub struct Row {
    /// `plant`, `machine`, or a component's name.
    pub side: String,
    /// The variable's name.
    pub name: String,
    /// One value per step.
    pub cells: Vec<String>,
}

/// Returns the table of a play and a sentence about its ending. `shown` selects the variables.
pub fn table(specification: &Specification, shown: &[VarId], play: &Play) -> String {
    let s = specification;
    let last = play.steps.len() - 1;
    let clash = matches!(play.ending, Ending::Clash(_));
    let rows = shown.iter().map(|v| {
        let variable = s.variable(*v);
        let cell = |(step, values): (usize, &Vec<i64>)| -> String {
            // In the last step of a clash the machine has no possible answer, so its outputs have
            // no values.
            let unknown = clash
                && step == last
                && variable.owner == Owner::System
                && s.timing == Timing::Mealy;
            if unknown {
                "?".to_owned()
            } else {
                variable.domain.show(values[v.index()])
            }
        };
        Row {
            side: match variable.owner {
                Owner::Environment => "plant".to_owned(),
                Owner::System => "machine".to_owned(),
            },
            name: variable.name.clone(),
            cells: play.steps.iter().enumerate().map(cell).collect(),
        }
    });
    let rows: Vec<Row> = rows.collect();
    grid(&rows, last) + &ending(s, play)
}

/// Formats rows as a table over the steps 0 to `last`, split into pieces of limited width.
pub fn grid(rows: &[Row], last: usize) -> String {
    let widest = |texts: &mut dyn Iterator<Item = &String>| texts.map(|t| t.chars().count()).max();
    let sides = widest(&mut rows.iter().map(|r| &r.side))
        .unwrap_or(0)
        .max("machine".len());
    let names = widest(&mut rows.iter().map(|r| &r.name))
        .unwrap_or(0)
        .max("step".len());
    let steps = columns(last);
    let widths: Vec<usize> = steps
        .iter()
        .map(|step| {
            let Some(step) = *step else {
                return "...".len();
            };
            let cells = rows.iter().map(|r| r.cells[step].chars().count());
            cells.max().unwrap_or(0).max(step.to_string().len())
        })
        .collect();
    let mut text = String::new();
    let mut from = 0;
    while from < steps.len() {
        let mut width = sides + 2 + names;
        let mut to = from;
        while to < steps.len() && (to == from || width + 2 + widths[to] <= MAX_WIDTH) {
            width += 2 + widths[to];
            to += 1;
        }
        let mut row = |side: &str, name: &str, cells: &dyn Fn(usize) -> String| {
            let mut line = format!("{side:<sides$}  {name:<names$}");
            for (step, width) in steps[from..to].iter().zip(&widths[from..to]) {
                let cell = step.map_or("...".to_owned(), cells);
                let _ = write!(line, "  {cell:<width$}");
            }
            text.push_str(line.trim_end());
            text.push('\n');
        };
        row("", "step", &|step| step.to_string());
        for r in rows {
            row(&r.side, &r.name, &|step| r.cells[step].clone());
        }
        from = to;
        if from < steps.len() {
            text.push('\n');
        }
    }
    text
}

/// Steps to show; for a long play the first and the last ones, with a gap (`None`) between them.
fn columns(last: usize) -> Vec<Option<usize>> {
    if last < MAX_STEPS {
        return (0..=last).map(Some).collect();
    }
    let first = (0..MAX_STEPS / 2).map(Some);
    let rest = (last + 1 - MAX_STEPS / 4..=last).map(Some);
    first.chain([None]).chain(rest).collect()
}

/// How the play ends, as a sentence.
fn ending(s: &Specification, play: &Play) -> String {
    let last = play.steps.len() - 1;
    let name = |g: &GuaranteeRef| format!("`{}`", g.formula(&s.guarantees).name);
    match &play.ending {
        Ending::Clash(rules) => {
            let mut names: Vec<String> = Vec::new();
            // Definitions never clash by themselves; the formulas that read them do.
            let asking = |rule: &&GuaranteeRef| !rule.formula(&s.guarantees).defines;
            for rule in rules.iter().filter(asking) {
                if !names.contains(&name(rule)) {
                    names.push(name(rule));
                }
            }
            match (names.as_slice(), s.timing) {
                ([], _) => format!("in step {last} the machine has no answer"),
                ([one], Timing::Moore) => {
                    format!(
                        "whatever the machine does in step {last}, the plant can answer so that {one} is violated"
                    )
                }
                ([one], _) => format!("in step {last} no answer keeps {one}"),
                _ => format!("in step {last} no answer keeps {} together", list(&names)),
            }
        }
        Ending::Starved { from, goal } => {
            let round = if *from == last {
                format!("step {last} repeats for ever")
            } else {
                format!("after step {last} the play repeats from step {from} for ever")
            };
            format!("{round}, without meeting {}", name(goal))
        }
    }
}

/// Variables that the formulas mention, directly or through the definitions of auxiliary variables,
/// which are left out themselves. The plant's variables come first, then the machine's, each in
/// declaration order.
pub fn mentioned<'f>(
    specification: &'f Specification,
    formulas: impl Iterator<Item = &'f Formula>,
) -> Vec<VarId> {
    let mut found = vec![false; specification.variables.len()];
    let mut open: Vec<&Formula> = formulas.collect();
    while let Some(formula) = open.pop() {
        formula.expr.for_each_var(&mut |v, _| {
            if !std::mem::replace(&mut found[v.index()], true) && specification.is_auxiliary(v) {
                let defining = specification.guarantees.all();
                open.extend(defining.filter(|f| f.defines && sets(&f.expr, v)));
            }
        });
    }
    let ids = (0..found.len() as u32).map(VarId);
    let own = |v: &VarId| found[v.index()] && !specification.is_auxiliary(*v);
    let mut shown: Vec<VarId> = ids.filter(own).collect();
    // Values set by the plant come first, then the machine's answers.
    shown.sort_by_key(|v| specification.variable(*v).owner == Owner::System);
    shown
}
