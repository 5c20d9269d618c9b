//! Counterexamples, checked by code that only evaluates formulas.

use linewright::algebra::proof::Refutation;
use linewright::gr1::eval::holds;
use linewright::gr1::{FormulaKind, Side};
use linewright::line::abstraction::{Abstraction, Open};

/// Whether this run keeps all sides, including justice if it is a cycle.
pub fn kept(sides: &[&Side], run: &[&[i64]], cycle: Option<&[&[i64]]>) -> Result<(), String> {
    for side in sides {
        for formula in &side.initial {
            if !holds(&formula.expr, run[0], &[]) {
                return Err(format!("{} in step 0", formula.name));
            }
        }
        for formula in &side.invariants {
            if let Some(step) = run.iter().position(|s| !holds(&formula.expr, s, &[])) {
                return Err(format!("{} in step {step}", formula.name));
            }
        }
        for formula in &side.safety {
            if let Some(step) = run
                .windows(2)
                .position(|w| !holds(&formula.expr, w[0], w[1]))
            {
                return Err(format!("{} from step {step} on", formula.name));
            }
        }
        for formula in cycle.iter().flat_map(|_| &side.justice) {
            if !cycle
                .unwrap()
                .windows(2)
                .any(|w| holds(&formula.expr, w[0], w[1]))
            {
                return Err(format!("{} is not met again and again", formula.name));
            }
        }
    }
    Ok(())
}

/// Whether a counterexample is valid: every place keeps its guarantees, what is given holds, and
/// the goal is missed.
pub fn accepts(abstraction: &Abstraction, open: &Open) -> Result<(), String> {
    let mut sides: Vec<&Side> = abstraction
        .system
        .components
        .iter()
        .map(|p| &p.guarantees)
        .collect();
    sides.push(&abstraction.claim.given);
    let goal = abstraction.goal(open.what);
    for (variable, domain) in abstraction
        .system
        .variables
        .iter()
        .map(|v| &v.domain)
        .enumerate()
    {
        let within = |state: &[i64]| domain.contains(state[variable]);
        let all = match &open.why {
            Refutation::Trace(trace) => trace.iter().all(|s| within(s)),
            Refutation::Lasso(lasso) => lasso.prefix.iter().chain(&lasso.cycle).all(|s| within(s)),
        };
        if !all {
            return Err(format!("variable {variable} leaves its domain"));
        }
    }
    match &open.why {
        Refutation::Trace(trace) => {
            let run: Vec<&[i64]> = trace.iter().map(Vec::as_slice).collect();
            kept(&sides, &run, None)?;
            let last = run[run.len() - 1];
            let before = run.len().checked_sub(2).map_or(last, |i| run[i]);
            let missed = if open.what.kind == FormulaKind::Safety {
                !holds(&goal.expr, before, last)
            } else {
                !holds(&goal.expr, last, &[])
            };
            missed.then_some(()).ok_or("the goal is kept".to_owned())
        }
        Refutation::Lasso(lasso) => {
            let mut cycle: Vec<&[i64]> = lasso.cycle.iter().map(Vec::as_slice).collect();
            cycle.push(&lasso.cycle[0]);
            let mut run: Vec<&[i64]> = lasso.prefix.iter().map(Vec::as_slice).collect();
            run.extend(&cycle);
            kept(&sides, &run, Some(&cycle))?;
            let met = cycle.windows(2).any(|w| holds(&goal.expr, w[0], w[1]));
            (!met).then_some(()).ok_or("the goal is met".to_owned())
        }
    }
}
