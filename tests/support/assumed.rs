//! Determines from the meaning of formulas alone which assumption a step violates: what every form
//! of a controller must refuse.

use linewright::gr1::{Formula, Specification, VarId, eval};

/// State of the assumptions in a play.
pub struct Assumed<'a> {
    specification: &'a Specification,
    /// The values of all variables in the last accepted step.
    before: Option<Vec<i64>>,
}

impl<'a> Assumed<'a> {
    pub fn new(specification: &'a Specification) -> Self {
        Self {
            specification,
            before: None,
        }
    }

    /// The name of the first assumption that these inputs violate: of initial conditions and
    /// invariants in step 0, of invariants and safety later.
    pub fn broken(&self, inputs: &[i64]) -> Option<&'a str> {
        let now = self.values(inputs, &[]);
        let side = &self.specification.assumptions;
        let within = |f: &&Formula| !eval::holds(&f.expr, &now, &[]);
        let broken = match &self.before {
            None => side.initial.iter().chain(&side.invariants).find(within),
            Some(before) => {
                let between = |f: &&Formula| !eval::holds(&f.expr, before, &now);
                let invariant = side.invariants.iter().find(within);
                invariant.or_else(|| side.safety.iter().find(between))
            }
        };
        broken.map(|f| f.name.as_str())
    }

    /// Records an accepted step.
    pub fn accepted(&mut self, inputs: &[i64], outputs: &[i64]) {
        self.before = Some(self.values(inputs, outputs));
    }

    /// Returns to before step 0.
    pub fn reset(&mut self) {
        self.before = None;
    }

    fn values(&self, inputs: &[i64], outputs: &[i64]) -> Vec<i64> {
        let mut values = vec![0; self.specification.variables.len()];
        let mut put = |id: VarId, value: &i64| values[id.index()] = *value;
        let (ids, others) = (self.specification.inputs(), self.specification.outputs());
        ids.zip(inputs).for_each(|(id, v)| put(id, v));
        others.zip(outputs).for_each(|(id, v)| put(id, v));
        values
    }
}
