//! Evaluates big operators: their ranges, iterations and results.

use super::super::ast::{BigOperator, Binary, Kind, Tree};
use super::super::ltl::Place;
use super::super::value::{ScopeBinding, Value};
use super::{Expander, MAX_SET, Result, Scope};
use linewright_core::diagnostics::codes;
use std::collections::BTreeSet;
use std::rc::Rc;

impl<'f> Expander<'f, '_> {
    /// Evaluates the body once for each combination of elements, one from each range. The recursion
    /// depth is the number of ranges.
    pub(super) fn iterate(
        &mut self,
        ranges: &'f [Tree],
        body: &'f Tree,
        scope: Scope<'_>,
        site: u32,
        values: &mut Vec<Value>,
    ) -> Result<()> {
        let Some((range, rest)) = ranges.split_first() else {
            values.push(self.value(body, scope, site)?);
            return Ok(());
        };
        let (name, elements) = self.range(range, scope, site)?;
        for value in elements {
            let with = match &value {
                Value::Number(n) => format!("{name} = {n}"),
                _ => String::new(),
            };
            let inner = self.site(&range.range, site, with);
            let bound = ScopeBinding {
                name,
                value,
                outer: scope,
            };
            self.iterate(rest, body, Some(&bound), inner, values)?;
        }
        Ok(())
    }

    /// The variable and the elements of a range `0 <= i < n` or `i IN S`.
    pub(super) fn range(
        &mut self,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<(&'f str, Vec<Value>)> {
        use Binary as B;
        match &tree.kind {
            Kind::Binary(B::Element, name, set) => {
                if let Kind::Name(name) = &name.kind {
                    let set = self.set(set, scope, site)?;
                    return Ok((name, set.iter().cloned().collect()));
                }
            }
            Kind::Binary(upper @ (B::Less | B::LessEqual), inner, high) => {
                if let Kind::Binary(lower @ (B::Less | B::LessEqual), low, name) = &inner.kind
                    && let Kind::Name(name) = &name.kind
                {
                    let low = self.numeric(low, scope, site)?;
                    let high = self.numeric(high, scope, site)?;
                    let low = low.saturating_add(i64::from(*lower == B::Less));
                    let high = high.saturating_sub(i64::from(*upper == B::Less));
                    if high.saturating_sub(low) >= MAX_SET {
                        return self.large_set(tree, site);
                    }
                    return Ok((name, (low..=high).map(Value::Number).collect()));
                }
            }
            _ => {}
        }
        self.fail(
            codes::SYNTAX,
            &tree.range,
            site,
            "this is not a range to iterate over",
            "write `&&[0 <= i < n]` or `&&[i IN {1,2,5}]`",
        )
    }

    pub(super) fn combine(
        &mut self,
        op: BigOperator,
        values: &[Value],
        tree: &'f Tree,
        body: &'f Tree,
        site: u32,
    ) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        match op {
            BigOperator::And | BigOperator::Or => {
                let mut parts = Vec::new();
                for value in values {
                    parts.push(self.as_formula(value, body, site)?);
                }
                Ok(Value::Formula(if op == BigOperator::And {
                    self.formulas.and(parts, place)
                } else {
                    self.formulas.or(parts, place)
                }))
            }
            BigOperator::Sum | BigOperator::Product => {
                let mut result = Some(i64::from(op == BigOperator::Product));
                for value in values {
                    let Value::Number(n) = value else {
                        return self.fail(
                            codes::TYPE_MISMATCH,
                            &body.range,
                            site,
                            format!("this is {}, where a number is needed", value.word()),
                            "use `SUM` and `PROD` with numbers",
                        );
                    };
                    result = result.and_then(|r| {
                        if op == BigOperator::Sum {
                            r.checked_add(*n)
                        } else {
                            r.checked_mul(*n)
                        }
                    });
                }
                self.checked_number(result, tree, site)
            }
            BigOperator::Cup | BigOperator::Cap => {
                let mut result: Option<BTreeSet<Value>> = None;
                for value in values {
                    let Value::Set(set) = value else {
                        return self.fail(
                            codes::TYPE_MISMATCH,
                            &body.range,
                            site,
                            format!("this is {}, where a set is needed", value.word()),
                            "use `CUP` and `CAP` with sets",
                        );
                    };
                    result = Some(match result {
                        None => (**set).clone(),
                        Some(r) if op == BigOperator::Cup => r.union(set).cloned().collect(),
                        Some(r) => r.intersection(set).cloned().collect(),
                    });
                }
                if op == BigOperator::Cap && result.is_none() {
                    return self.fail(
                        codes::DOMAIN_EMPTY,
                        &tree.range,
                        site,
                        "the intersection of no sets is undefined",
                        "iterate over at least one set",
                    );
                }
                Ok(Value::Set(Rc::new(result.unwrap_or_default())))
            }
        }
    }

    pub(super) fn checked_number(
        &mut self,
        result: Option<i64>,
        tree: &Tree,
        site: u32,
    ) -> Result<Value> {
        match result {
            Some(n) => Ok(Value::Number(n)),
            None => self.fail(
                codes::NUMBER_RANGE,
                &tree.range,
                site,
                "this number is too large",
                "use numbers that fit in 64 bits",
            ),
        }
    }
}
