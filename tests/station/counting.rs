//! A machine that writes integers.

use crate::fixtures;
use linewright::contract::machine::{Machine, Property, PropertyKind, RealExpr};
use linewright::gr1::Domain;
use linewright::mealy;
use linewright::source::Span;
use std::sync::Arc;

/// The manipulator with an integer that every operation sets to the value of another property,
/// whatever it is.
pub fn counting() -> (Arc<Machine>, Arc<Vec<mealy::Controller>>) {
    let (machine, controllers) = fixtures::manipulator();
    let mut machine = (*machine).clone();
    "Counting".clone_into(&mut machine.name);
    let wish = machine.properties.len();
    let whole = Domain::Range { low: -3, high: 6 };
    for (name, domain) in [("wish", None), ("count", Some(whole))] {
        machine.properties.push(Property {
            domain,
            name: name.to_owned(),
            unit: String::new(),
            default: 0.0,
            kind: PropertyKind::Part,
            span: Span::default(),
        });
    }
    // Longer than any text that a library stores, with characters of three bytes.
    let coordinator = Arc::make_mut(&mut machine.components[0].specification);
    for formula in &mut coordinator.assumptions.safety {
        formula.requirement = Some("\u{2192}".repeat(500));
    }
    machine.writes.push((wish + 1, RealExpr::Property(wish)));
    (Arc::new(machine), controllers)
}
