//! Domains and units of variables, by id.

use crate::contract::shape::{Entry, measured};
use crate::contract::units::Unit;
use crate::contract::value::{Dimension, Term, Type, Value};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::monitors::Monitors;
use linewright_core::gr1::{BinaryOp, Domain, Time, VarId};
use std::collections::BTreeMap;

/// Unit of a real variable: the dimension, and the factor that converts a number to the base unit.
pub(in crate::contract) type RealUnit = (Dimension, f64);

/// Variables of one elaborator, indexed by their ids.
#[derive(Clone, Default)]
pub(in crate::contract) struct VariableTable {
    /// Domains; `None` for real variables.
    pub domains: Vec<Option<Domain>>,
    /// Units of real variables.
    pub units: BTreeMap<VarId, RealUnit>,
    /// Units of variables of whole numbers.
    pub measures: BTreeMap<VarId, Unit>,
}

impl VariableTable {
    /// Adds a variable with a finite domain.
    pub fn add(&mut self, domain: Domain, unit: Option<Unit>) -> VarId {
        let id = VarId(self.domains.len() as u32);
        self.domains.push(Some(domain));
        if let Some(unit) = unit {
            self.measures.insert(id, unit);
        }
        id
    }

    /// Adds a real variable.
    pub fn add_real(&mut self, unit: RealUnit) -> VarId {
        let id = VarId(self.domains.len() as u32);
        self.domains.push(None);
        self.units.insert(id, unit);
        id
    }

    /// Adds the variables of the monitors that were created since the last call.
    pub fn add_monitors(&mut self, monitors: &Monitors) {
        let made = monitors.all();
        let first = made.first().map_or(0, |m| m.id.index());
        let seen = self.domains.len().saturating_sub(first).min(made.len());
        self.domains
            .extend(made[seen..].iter().map(|m| Some(m.variable.domain.clone())));
    }

    /// Returns the range of a variable's values as numbers; `0..1` for a real variable.
    pub fn interval(&self, id: VarId) -> Interval {
        self.domains[id.index()]
            .as_ref()
            .map_or(Interval::BOOL, Interval::of)
    }

    /// Returns the range of an integer term; `None` if the term contains labels, truth values or
    /// real numbers, or its range is too large.
    pub(super) fn range(&self, term: &Term) -> Option<Interval> {
        let expr = term.to_expr()?;
        let mut numbers = true;
        expr.for_each_var(&mut |v, _| {
            let domain = self.domains.get(v.index());
            numbers &= matches!(domain, Some(Some(Domain::Range { .. })));
        });
        if !numbers {
            return None;
        }
        interval(&expr, &|v| self.interval(v)).ok()
    }

    /// Returns the value of a variable of any shape. If `real`, quantities are converted to base
    /// units.
    pub(super) fn entry(&self, entry: &Entry, time: Time, real: bool) -> Value {
        match entry {
            Entry::One(id) => self.scalar(*id, time, real),
            Entry::Many(list) => {
                Value::Array(list.iter().map(|e| self.entry(e, time, real)).collect())
            }
            Entry::Record(members) => Value::Record(
                members
                    .iter()
                    .map(|(name, e)| (name.clone(), self.entry(e, time, real)))
                    .collect(),
            ),
        }
    }

    fn scalar(&self, id: VarId, time: Time, real: bool) -> Value {
        let read = Term::Var(id, time);
        if let Some(domain) = &self.domains[id.index()] {
            return match measured(domain, self.measures.get(&id).copied()) {
                Type::Measured(unit) if real => {
                    let factor = Box::new(Term::Real(unit.factor()));
                    let term = Term::Binary(BinaryOp::Mul, Box::new(read), factor);
                    Value::Scalar(term, Type::Number(unit.dimension()))
                }
                ty => Value::Scalar(read, ty),
            };
        }
        let (dimension, factor) = self
            .units
            .get(&id)
            .copied()
            .unwrap_or((Dimension::None, 1.0));
        #[expect(clippy::float_cmp, reason = "base units have exactly the factor 1")]
        let term = if factor == 1.0 {
            read
        } else {
            Term::Binary(BinaryOp::Mul, Box::new(read), Box::new(Term::Real(factor)))
        };
        Value::Scalar(term, Type::Number(dimension))
    }
}
