//! Properties that nothing depends on: no condition, range, time or controller reads them, not even
//! indirectly.
//!
//! Such a property, for example a count of rework rounds, can take arbitrarily many values, so its
//! values are not followed one by one. It suffices to show that they stay finite. The proof is by
//! induction, in double-precision arithmetic: every change maps values within ±[`BOUND`] to values
//! within ±[`BOUND`]. If the induction fails, the property is followed like the others.

use linewright_language::contract::line::{InitialValue, Line, NodeKind, Task};
use linewright_language::contract::machine::{
    ActionTime, Machine, PlantSource, RealBinary, RealExpr, RealUnary,
};
use std::collections::BTreeSet;

/// A bound so large that increments are lost in rounding long before a value reaches it.
const BOUND: f64 = 1e300;

/// By part type and property: whether nothing depends on it.
pub(super) fn unread(line: &Line) -> Vec<Vec<bool>> {
    let flows = Flows::of(line);
    let needed = flows.needed();
    let parts = line.parts.iter().zip(&flows.first);
    parts
        .map(|(part, first)| {
            let properties = 0..part.properties.len();
            properties.map(|p| !needed.contains(&(first + p))).collect()
        })
        .collect()
}

/// Index of a number that can change: a property of a part type, or of a machine during a task.
type Slot = usize;

/// A value that a slot can receive.
enum Value<'a> {
    Number(f64),
    Copy(Slot),
    /// The value of this expression, computed from these slots and the wires of the machine, if
    /// any.
    Computed(&'a RealExpr, Vec<Slot>, Option<&'a Machine>),
}

/// All slots, with the values that they can receive.
struct Flows<'a> {
    /// By part type: the slot of its first property.
    first: Vec<Slot>,
    changes: Vec<(Slot, Value<'a>)>,
    /// Slots that are read.
    read: BTreeSet<Slot>,
    /// By slot: its range if it is known in advance, because the slot only receives constants or
    /// has the range of a part's property.
    ranges: Vec<Option<Interval>>,
}

impl<'a> Flows<'a> {
    fn of(line: &'a Line) -> Self {
        let mut flows = Self {
            first: Vec::new(),
            changes: Vec::new(),
            read: BTreeSet::new(),
            ranges: Vec::new(),
        };
        for part in &line.parts {
            flows.first.push(flows.ranges.len());
            for property in &part.properties {
                if property.domain.is_some() {
                    flows.read.insert(flows.ranges.len());
                }
                flows.ranges.push(None);
            }
        }
        for (part, &first) in line.parts.iter().zip(&flows.first) {
            for (p, property) in part.properties.iter().enumerate() {
                let value = match property.initial {
                    InitialValue::Number(number) => Value::Number(number),
                    InitialValue::Component(kind, number) => {
                        Value::Copy(flows.first[kind] + number)
                    }
                };
                flows.changes.push((first + p, value));
            }
        }
        for route in &line.routes {
            if let Some(condition) = &route.condition {
                let first = flows.first[route.part];
                flows.reads(condition, |p| first + p);
            }
        }
        for node in &line.nodes {
            let NodeKind::Station(station) = &node.kind else {
                continue;
            };
            if let Some(machine) = &station.machine {
                for task in &station.tasks {
                    flows.task(line, machine, task);
                }
            }
            for setting in &station.settings {
                let first = flows.first[setting.part];
                let count = line.parts[setting.part].properties.len();
                let slots = (first..first + count).collect();
                let value = Value::Computed(&setting.value, slots, None);
                flows.changes.push((first + setting.property, value));
            }
            for defect in &station.defects {
                let first = flows.first[defect.part];
                let count = line.parts[defect.part].properties.len();
                for &property in &defect.properties {
                    let mut slots: Vec<Slot> = (first..first + count).collect();
                    slots.push(first + property);
                    let value = Value::Computed(&defect.value, slots, None);
                    flows.changes.push((first + property, value));
                }
            }
        }
        flows.constants();
        flows
    }

    fn task(&mut self, line: &Line, machine: &'a Machine, task: &Task) {
        let first = self.ranges.len();
        for (m, property) in machine.properties.iter().enumerate() {
            let slot = first + m;
            if property.domain.is_some() {
                self.read.insert(slot);
            }
            self.ranges.push(None);
            let Some(carried) = task.properties[m] else {
                self.changes.push((slot, Value::Number(property.default)));
                continue;
            };
            let part = self.first[task.part] + carried;
            self.changes.push((slot, Value::Copy(part)));
            self.changes.push((part, Value::Copy(slot)));
            // The station works on a part only if its values are in range, so the copied value is,
            // too.
            let domain = &line.parts[task.part].properties[carried].domain;
            let is_written = machine.writes.iter().any(|(written, _)| *written == m);
            self.ranges[slot] = domain.as_ref().filter(|_| !is_written).map(Interval::of);
        }
        for (m, value) in task.operations.iter().flat_map(|(_, given)| given) {
            self.changes.push((first + m, Value::Number(*value)));
        }
        for (m, value) in &machine.writes {
            let slots = (first..first + machine.properties.len()).collect();
            let value = Value::Computed(value, slots, Some(machine));
            self.changes.push((first + m, value));
        }
        for input in &machine.plant {
            if let PlantSource::Property(value) = &input.source {
                self.reads(value, |m| first + m);
            }
        }
        for component in &machine.components {
            self.reads(&component.watts, |m| first + m);
            if let Some(ActionTime::PerStep(time) | ActionTime::PerExecution(time)) =
                &component.time
            {
                self.reads(time, |m| first + m);
            }
        }
    }

    fn reads(&mut self, value: &RealExpr, slot: impl Fn(usize) -> Slot) {
        value.for_each(&mut |leaf| {
            if let RealExpr::Property(p) = leaf {
                self.read.insert(slot(*p));
            }
        });
    }

    /// Slots whose values are needed: those that are read, those that can leave the bound, and all
    /// others that these depend on.
    fn needed(&self) -> BTreeSet<Slot> {
        let mut needed = self.read.clone();
        loop {
            let before = needed.len();
            for (target, value) in &self.changes {
                if needed.contains(target) {
                    match value {
                        Value::Number(_) => {}
                        Value::Copy(slot) => {
                            needed.insert(*slot);
                        }
                        Value::Computed(value, slots, _) => value.for_each(&mut |leaf| {
                            if let RealExpr::Property(p) = leaf {
                                needed.insert(slots[*p]);
                            }
                        }),
                    }
                } else if !self.stays_within(value, &needed) {
                    needed.insert(*target);
                }
            }
            if needed.len() == before {
                return needed;
            }
        }
    }

    fn stays_within(&self, value: &Value<'_>, needed: &BTreeSet<Slot>) -> bool {
        let interval = match value {
            Value::Number(number) => Interval::new(*number, *number),
            Value::Copy(slot) => Some(self.interval(*slot, needed)),
            Value::Computed(value, slots, machine) => {
                Interval::eval(value, &|p| self.interval(slots[p], needed), &|wire| {
                    machine.map_or(Interval::ALL, |m| Interval::of(m.wire_domain(wire)))
                })
            }
        };
        interval.is_some_and(|i| -BOUND <= i.low && i.high <= BOUND)
    }

    fn interval(&self, slot: Slot, needed: &BTreeSet<Slot>) -> Interval {
        let within = Interval {
            low: -BOUND,
            high: BOUND,
        };
        let otherwise = if needed.contains(&slot) {
            Interval::ALL
        } else {
            within
        };
        self.ranges[slot].unwrap_or(otherwise)
    }

    /// Sets the ranges of the slots that only receive constants.
    fn constants(&mut self) {
        let mut hulls: Vec<Option<Interval>> = vec![None; self.ranges.len()];
        let mut changing = vec![false; self.ranges.len()];
        for (slot, value) in &self.changes {
            match value {
                Value::Number(number) if number.is_finite() => {
                    let one = Interval {
                        low: *number,
                        high: *number,
                    };
                    hulls[*slot] = Some(hulls[*slot].map_or(one, |hull| hull.with(one)));
                }
                _ => changing[*slot] = true,
            }
        }
        for ((range, hull), changing) in self.ranges.iter_mut().zip(hulls).zip(changing) {
            if !changing {
                *range = hull;
            }
        }
    }
}

/// Finite numbers from `low` to `high`, with the arithmetic of doubles.
/// [`linewright_core::gr1::interval`] is the counterpart for integers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    const ALL: Self = Self {
        low: f64::MIN,
        high: f64::MAX,
    };
    const TRUTH: Self = Self {
        low: 0.0,
        high: 1.0,
    };

    /// Creates an interval; `None` if a bound is not finite.
    fn new(low: f64, high: f64) -> Option<Self> {
        (low.is_finite() && high.is_finite()).then_some(Self { low, high })
    }

    fn of(domain: &linewright_core::gr1::Domain) -> Self {
        Self {
            low: domain.low() as f64,
            high: domain.high() as f64,
        }
    }

    /// The smallest interval that contains both.
    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The smallest interval that contains all results of a function that is monotone in each
    /// operand.
    fn corners(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Option<Self> {
        let ends = [
            f(self.low, other.low),
            f(self.low, other.high),
            f(self.high, other.low),
            f(self.high, other.high),
        ];
        let least = |a: f64, b: f64| {
            if a.is_nan() || b.is_nan() {
                f64::NAN
            } else {
                a.min(b)
            }
        };
        let most = |a: f64, b: f64| {
            if a.is_nan() || b.is_nan() {
                f64::NAN
            } else {
                a.max(b)
            }
        };
        Self::new(
            ends.into_iter().reduce(least)?,
            ends.into_iter().reduce(most)?,
        )
    }

    /// Range of an expression; `None` if a value might not be finite. Rounding is monotone, so it
    /// suffices to evaluate the ends of the operands' ranges.
    fn eval(
        value: &RealExpr,
        property: &impl Fn(usize) -> Self,
        wire: &impl Fn(usize) -> Self,
    ) -> Option<Self> {
        let part = |value: &RealExpr| Self::eval(value, property, wire);
        match value {
            RealExpr::Number(number) => Self::new(*number, *number),
            RealExpr::Property(p) => Some(property(*p)),
            RealExpr::Wire(w) => Some(wire(*w)),
            RealExpr::Unary(op, a) => {
                let a = part(a)?;
                let ends = |f: fn(f64) -> f64| Self::new(f(a.low), f(a.high));
                match op {
                    RealUnary::Not => Some(Self::TRUTH),
                    RealUnary::Neg => Self::new(-a.high, -a.low),
                    RealUnary::Abs => {
                        let most = a.low.abs().max(a.high.abs());
                        Self::new(0.0, most)
                    }
                    RealUnary::Floor => ends(f64::floor),
                    RealUnary::Ceil => ends(f64::ceil),
                    RealUnary::Round => ends(f64::round),
                }
            }
            RealExpr::Binary(op, a, b) => {
                let (a, b) = (part(a)?, part(b)?);
                let quotient = || {
                    let apart = b.low > 0.0 || b.high < 0.0;
                    apart.then(|| a.corners(b, |a, b| a / b)).flatten()
                };
                match op {
                    RealBinary::And
                    | RealBinary::Or
                    | RealBinary::Implies
                    | RealBinary::Eq
                    | RealBinary::Ne
                    | RealBinary::Lt
                    | RealBinary::Le
                    | RealBinary::Gt
                    | RealBinary::Ge => Some(Self::TRUTH),
                    RealBinary::Add => a.corners(b, |a, b| a + b),
                    RealBinary::Sub => a.corners(b, |a, b| a - b),
                    RealBinary::Mul => a.corners(b, |a, b| a * b),
                    RealBinary::Div => quotient(),
                    RealBinary::Mod => {
                        let floor = quotient()?;
                        let whole = Self::new(floor.low.floor(), floor.high.floor())?;
                        let multiple = b.corners(whole, |a, b| a * b)?;
                        a.corners(multiple, |a, b| a - b)
                    }
                    RealBinary::Min => a.corners(b, f64::min),
                    RealBinary::Max => a.corners(b, f64::max),
                }
            }
            RealExpr::If(c, a, b) => {
                part(c)?;
                Some(part(a)?.with(part(b)?))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn expressions() -> impl Strategy<Value = RealExpr> {
        let leaf = prop_oneof![
            prop_oneof![-3.0..3.0, Just(1e300), Just(0.0)].prop_map(RealExpr::Number),
            (0..3usize).prop_map(RealExpr::Property),
        ];
        leaf.prop_recursive(4, 20, 3, |inner| {
            let unary = prop_oneof![
                Just(RealUnary::Not),
                Just(RealUnary::Neg),
                Just(RealUnary::Abs),
                Just(RealUnary::Floor),
                Just(RealUnary::Ceil),
                Just(RealUnary::Round),
            ];
            let binary = prop_oneof![
                Just(RealBinary::Add),
                Just(RealBinary::Sub),
                Just(RealBinary::Mul),
                Just(RealBinary::Div),
                Just(RealBinary::Mod),
                Just(RealBinary::Min),
                Just(RealBinary::Max),
                Just(RealBinary::Lt),
                Just(RealBinary::And),
            ];
            prop_oneof![
                (unary, inner.clone()).prop_map(|(op, a)| RealExpr::Unary(op, Box::new(a))),
                (binary, inner.clone(), inner.clone()).prop_map(|(op, a, b)| RealExpr::Binary(
                    op,
                    Box::new(a),
                    Box::new(b)
                )),
                (inner.clone(), inner.clone(), inner).prop_map(|(c, a, b)| RealExpr::If(
                    Box::new(c),
                    Box::new(a),
                    Box::new(b)
                )),
            ]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]
        /// Every value of an expression lies in its interval.
        #[test]
        fn intervals_hold_all_values(
            value in expressions(),
            ranges in prop::array::uniform3((-9.0..9.0f64, 0.0..9.0f64)),
            shares in prop::array::uniform3(0.0..=1.0f64),
        ) {
            let properties: Vec<f64> = ranges.iter().zip(shares)
                .map(|((low, width), share)| (low + width * share).min(low + width)).collect();
            let property = |p: usize| Interval { low: ranges[p].0, high: ranges[p].0 + ranges[p].1 };
            if let Some(found) = Interval::eval(&value, &property, &|_| Interval::ALL) {
                let exact = value.eval(&properties, &[]);
                prop_assert!(found.low <= exact && exact <= found.high, "{exact} is not in {found:?}");
            }
        }
    }
}
