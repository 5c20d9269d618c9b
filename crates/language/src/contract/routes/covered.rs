//! Routes behind conditions that cover everything: whatever its values are, a part takes an earlier
//! route.

use crate::contract::line::{Line, PartType};
use crate::contract::machine::{RealBinary, RealExpr};
use std::collections::BTreeSet;

/// Maximum number of combinations of values for which conditions are tried.
const MAX_COMBINATIONS: usize = 100_000;

/// Returns whether no part ever takes a route because, whatever values the part has, it takes one
/// of the routes with a condition that come before. If this is too large to be decided, returns
/// false. A route to the place of one of these is no mistake, because routes share their ends.
pub fn is_covered(line: &Line, index: usize) -> bool {
    let route = &line.routes[index];
    let earlier = &line.routes[..line.first_of_way(index)];
    let earlier = earlier
        .iter()
        .filter(|first| (first.part, first.from) == (route.part, route.from));
    if earlier.clone().any(|first| first.condition.is_none()) {
        return false;
    }
    let conditions: Vec<&RealExpr> = earlier
        .clone()
        .filter_map(|first| first.condition.as_ref())
        .collect();
    let mut ends = earlier.map(|first| first.to);
    if conditions.is_empty() || ends.any(|to| to == route.to) {
        return false;
    }
    let part = &line.parts[route.part];
    let Some(tried) = values_to_try(part, &conditions) else {
        return false;
    };
    let mut values = vec![0.0; part.properties.len()];
    let combinations: usize = tried.iter().map(|(_, values)| values.len()).product();
    (0..combinations).all(|number| {
        let mut rest = number;
        for (property, of) in &tried {
            values[*property] = of[rest % of.len()];
            rest /= of.len();
        }
        let mut conditions = conditions.iter();
        conditions.any(|condition| condition.eval(&values, &[]) != 0.0)
    })
}

/// Returns values of the properties in these conditions such that the conditions cover everything
/// if they cover each combination of these: all values, or for real numbers one at, between and
/// beyond the numbers with which they are compared. `None` if that is too many, or if real numbers
/// are used in another way.
fn values_to_try(part: &PartType, conditions: &[&RealExpr]) -> Option<Vec<(usize, Vec<f64>)>> {
    let mut used: BTreeSet<usize> = BTreeSet::new();
    for condition in conditions {
        condition.for_each(&mut |expr| {
            if let RealExpr::Property(property) = expr {
                used.insert(*property);
            }
        });
    }
    let mut combinations: usize = 1;
    let mut all = Vec::new();
    for property in used {
        let values: Vec<f64> = match &part.properties.get(property)?.domain {
            Some(domain) if domain.size() <= MAX_COMBINATIONS as u64 => (domain.low()
                ..=domain.high())
                .map(|value| value as f64)
                .collect(),
            Some(_) => return None,
            None => {
                let mut compared = Vec::new();
                let mut conditions = conditions.iter();
                if !conditions.all(|condition| compares(condition, property, &mut compared)) {
                    return None;
                }
                compared.sort_by(f64::total_cmp);
                let (first, last) = (*compared.first()?, *compared.last()?);
                let between = compared
                    .windows(2)
                    .map(|pair| f64::midpoint(pair[0], pair[1]));
                let between: Vec<f64> = between.collect();
                let beyond = [first - first.abs() - 1.0, last + last.abs() + 1.0];
                compared.into_iter().chain(between).chain(beyond).collect()
            }
        };
        combinations = combinations.saturating_mul(values.len());
        all.push((property, values));
    }
    (combinations <= MAX_COMBINATIONS).then_some(all)
}

/// Collects the numbers with which a property is compared. Returns whether the expression uses the
/// property in no other way.
fn compares(expr: &RealExpr, property: usize, with: &mut Vec<f64>) -> bool {
    use RealBinary::{Eq, Ge, Gt, Le, Lt, Ne};
    match expr {
        RealExpr::Number(_) | RealExpr::Wire(_) => true,
        RealExpr::Property(used) => *used != property,
        RealExpr::Unary(_, a) => compares(a, property, with),
        RealExpr::Binary(op, a, b) => {
            let compared = match (&**a, &**b) {
                (of, RealExpr::Number(number)) | (RealExpr::Number(number), of)
                    if matches!(op, Eq | Ne | Lt | Le | Gt | Ge) =>
                {
                    scale_of(of, property).map(|scale| number / scale)
                }
                _ => None,
            };
            if let Some(bound) = compared {
                // The scale may be rounded.
                with.extend([bound.next_down(), bound, bound.next_up()]);
                return true;
            }
            compares(a, property, with) && compares(b, property, with)
        }
        RealExpr::If(c, a, b) => {
            let mut all = [c, a, b].into_iter();
            all.all(|part| compares(part, property, with))
        }
    }
}

/// By which number an expression multiplies a property, as a unit does; `None` if it is anything
/// else.
fn scale_of(expr: &RealExpr, property: usize) -> Option<f64> {
    let scale = match expr {
        RealExpr::Property(used) if *used == property => 1.0,
        RealExpr::Binary(RealBinary::Mul, a, b) => match (&**a, &**b) {
            (RealExpr::Number(by), of) | (of, RealExpr::Number(by)) => by * scale_of(of, property)?,
            _ => return None,
        },
        RealExpr::Binary(RealBinary::Div, a, b) => match &**b {
            RealExpr::Number(by) => scale_of(a, property)? / by,
            _ => return None,
        },
        _ => return None,
    };
    (scale.is_finite() && scale != 0.0).then_some(scale)
}
