//! Checks advice: every claim is checked by solving again.

use linewright::game::{Advice, AssumptionRef, GuaranteeRef, Limits, Options, Outcome, solve_with};
use linewright::gr1::{Expr, Formula, Owner, Side, Specification};
use linewright::source::Span;

/// Whether there is a controller.
pub fn realizable(spec: &Specification) -> bool {
    let options = Options {
        limits: Limits::default(),
        without_core: true,
        ..Options::default()
    };
    match solve_with(spec, &options).outcome {
        Outcome::Realizable(_) => true,
        Outcome::Unrealizable(_) => false,
        Outcome::GaveUp(limit) => panic!("gave up: {limit}"),
    }
}

/// Whether some play keeps everything, with both sides as one player.
pub fn satisfiable(spec: &Specification) -> bool {
    let mut one = spec.clone();
    for variable in &mut one.variables {
        variable.owner = Owner::System;
    }
    let (a, g) = (std::mem::take(&mut one.assumptions), &mut one.guarantees);
    g.append(&a);
    realizable(&one)
}

/// The specification with these formulas only.
pub fn only(
    spec: &Specification,
    assumptions: Option<&[AssumptionRef]>,
    guarantees: &[GuaranteeRef],
) -> Specification {
    let keep = |side: &Side, refs: &[GuaranteeRef]| {
        let mut kept = Side::default();
        for r in refs {
            kept.list_mut(r.kind).push(r.formula(side).clone());
        }
        kept
    };
    Specification {
        guarantees: keep(&spec.guarantees, guarantees),
        assumptions: match assumptions {
            Some(refs) => keep(&spec.assumptions, refs),
            None => spec.assumptions.clone(),
        },
        ..spec.clone()
    }
}

fn formula(expr: &Expr) -> Formula {
    Formula {
        defines: false,
        name: "suggested".to_owned(),
        requirement: None,
        expr: expr.clone(),
        span: Span::default(),
        text: String::new(),
    }
}

/// Whether a set of guarantees clashes, and no proper subset does.
pub fn minimal(
    spec: &Specification,
    assumptions: Option<&[AssumptionRef]>,
    core: &[GuaranteeRef],
) -> Result<(), String> {
    if realizable(&only(spec, assumptions, core)) {
        return Err("the core does not clash".to_owned());
    }
    for i in 0..core.len() {
        let rest = [&core[..i], &core[i + 1..]].concat();
        if !realizable(&only(spec, assumptions, &rest)) {
            return Err(format!("element {i} of the core can be left out"));
        }
    }
    Ok(())
}

/// Checks advice; returns an error description.
pub fn holds(spec: &Specification, core: &[GuaranteeRef], advice: &Advice) -> Result<(), String> {
    minimal(spec, None, core)?;
    minimal(spec, Some(&advice.matters), core)?;
    for i in 0..advice.matters.len() {
        let rest = [&advice.matters[..i], &advice.matters[i + 1..]].concat();
        if minimal(spec, Some(&rest), core).is_ok() {
            return Err(format!("assumption {i} does not matter"));
        }
    }
    if satisfiable(spec) == advice.contradictory {
        return Err("contradictory or not".to_owned());
    }
    for suggested in &advice.assumptions {
        let mut more = spec.clone();
        more.assumptions
            .list_mut(suggested.kind)
            .push(formula(&suggested.formula));
        if !realizable(&more) {
            return Err(format!("{suggested:?} does not help"));
        }
        if !satisfiable(&more) {
            return Err(format!("{suggested:?} cannot be kept"));
        }
    }
    for weakening in &advice.weakenings {
        let mut less = spec.clone();
        let guarantees = less.guarantees.list_mut(weakening.guarantee.kind);
        match &weakening.unless {
            None => {
                guarantees.remove(weakening.guarantee.index);
            }
            Some(unless) => {
                let weak = &mut guarantees[weakening.guarantee.index];
                weak.expr = weak.expr.clone().or(unless.clone());
            }
        }
        if !realizable(&less) {
            return Err(format!("{weakening:?} does not help"));
        }
    }
    Ok(())
}
