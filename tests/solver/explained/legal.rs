//! Checks whether a play is what it claims to be, by evaluating the formulas on its steps.

use linewright::game::{Ending, GuaranteeRef, Play};
use linewright::gr1::eval::holds;
use linewright::gr1::{Formula, FormulaKind, Specification, Timing, VarId};

/// The formulas of a side that step `at` of a play violates, according to their kinds.
fn broken<'a>(
    initial: &'a [Formula],
    invariants: &'a [Formula],
    safety: &'a [Formula],
    steps: &[Vec<i64>],
    at: usize,
) -> Vec<&'a Formula> {
    let now = &steps[at];
    let of_one = |list: &'a [Formula]| list.iter().filter(|f| !holds(&f.expr, now, now));
    let mut found: Vec<&Formula> = of_one(invariants).collect();
    if at == 0 {
        found.extend(of_one(initial));
    } else {
        found.extend(
            safety
                .iter()
                .filter(|f| !holds(&f.expr, &steps[at - 1], now)),
        );
    }
    found
}

/// Checks a play; returns an error description.
pub fn legal(spec: &Specification, play: &Play) -> Result<(), String> {
    let clash = matches!(play.ending, Ending::Clash(_));
    let last = play.steps.len() - 1;
    let (a, g) = (&spec.assumptions, &spec.guarantees);
    for (at, step) in play.steps.iter().enumerate() {
        for (v, value) in spec.variables.iter().zip(step) {
            if !v.domain.contains(*value) {
                return Err(format!("step {at}: {} leaves its domain", v.name));
            }
        }
        // Safety assumptions may mention the machine's next values, which are meaningless in the
        // step of a clash.
        let of_inputs = |f: &&Formula| {
            let mut inputs = true;
            f.expr.for_each_var(&mut |v, t| {
                let next = at > 0 && t == linewright::gr1::Time::Next || at == 0;
                inputs &= !next || spec.inputs().any(|i| i == v);
            });
            inputs
        };
        let assumed = broken(&a.initial, &a.invariants, &a.safety, &play.steps, at);
        if let Some(f) = assumed
            .iter()
            .find(|f| !(clash && at == last) || of_inputs(f))
        {
            return Err(format!("step {at} breaks assumption {}", f.name));
        }
        let kept = broken(&g.initial, &g.invariants, &g.safety, &play.steps, at);
        if !(clash && at == last)
            && let Some(f) = kept.first()
        {
            return Err(format!("step {at} breaks guarantee {}", f.name));
        }
    }
    match &play.ending {
        Ending::Clash(rules) => clashes(spec, play, rules),
        Ending::Starved { from, goal } => {
            let round: Vec<(&Vec<i64>, &Vec<i64>)> = (*from..=last)
                .map(|at| {
                    let next = if at == last { *from } else { at + 1 };
                    (&play.steps[at], &play.steps[next])
                })
                .collect();
            let meets = |f: &Formula| round.iter().any(|(now, next)| holds(&f.expr, now, next));
            if let Some(f) = a.justice.iter().find(|f| !meets(f)) {
                return Err(format!("assumption {} is starved", f.name));
            }
            // The step back to the start of the cycle must be legal, too.
            let back = [play.steps[last].clone(), play.steps[*from].clone()];
            let steps = broken(&a.initial, &a.invariants, &a.safety, &back, 1);
            let answers = broken(&g.initial, &g.invariants, &g.safety, &back, 1);
            if let Some(f) = steps.iter().chain(&answers).next() {
                return Err(format!("the way back breaks {}", f.name));
            }
            if meets(goal.formula(g)) {
                return Err("the goal is met".to_owned());
            }
            Ok(())
        }
    }
}

/// No answer in the last step keeps all of the rules; for each rule some answer keeps all others.
fn clashes(spec: &Specification, play: &Play, rules: &[GuaranteeRef]) -> Result<(), String> {
    let last = play.steps.len() - 1;
    let given = &play.steps[last];
    let outputs: Vec<VarId> = match spec.timing {
        Timing::Mealy => spec.outputs().collect(),
        Timing::Moore => Vec::new(),
    };
    let mut mentioned = vec![false; spec.variables.len()];
    for rule in rules {
        let formula = rule.formula(&spec.guarantees);
        formula
            .expr
            .for_each_var(&mut |v, _| mentioned[v.index()] = true);
    }
    let outputs: Vec<VarId> = outputs
        .into_iter()
        .filter(|v| mentioned[v.index()])
        .collect();
    let keeps = |rule: &GuaranteeRef, answer: &[i64]| {
        let formula = rule.formula(&spec.guarantees);
        // A safety guarantee without next values binds the step that is left. Unless the machine
        // moves first, a play ends in the step that violates it.
        let of_next = formula.expr.mentions_next() || spec.timing == Timing::Moore;
        let before = match rule.kind {
            FormulaKind::Safety if of_next => &play.steps[last - 1],
            _ => answer,
        };
        holds(&rule.formula(&spec.guarantees).expr, before, answer)
    };
    let mut answers = vec![given.clone()];
    for v in outputs {
        let domain = &spec.variable(v).domain;
        answers = answers
            .into_iter()
            .flat_map(|answer| {
                (domain.low()..=domain.high()).map(move |value| {
                    let mut next = answer.clone();
                    next[v.index()] = value;
                    next
                })
            })
            .collect();
        if answers.len() > 1_000_000 {
            return Err("too many answers to enumerate".to_owned());
        }
    }
    if answers.iter().any(|a| rules.iter().all(|r| keeps(r, a))) {
        return Err("an answer keeps all rules that clash".to_owned());
    }
    for left_out in rules {
        let others = |a: &Vec<i64>| rules.iter().all(|r| r == left_out || keeps(r, a));
        if !answers.iter().any(others) {
            return Err(format!(
                "{} has no part in the clash",
                left_out.formula(&spec.guarantees).name
            ));
        }
    }
    Ok(())
}
