//! The machines of the line with all their controllers as functions, although tables would be
//! possible: library and interpreter agree, the contracts are kept, and operations have the same
//! results as with tables.

use crate::differential::{Random, differential};
use crate::laboratory::{Controlled, as_functions, machines};
use linewright::station::interpret::Interpreter;
use linewright::station::{Controller, ErrorCode};
use std::sync::Arc;

const STEPS: usize = 20_000;

#[test]
fn libraries_of_functions_agree_with_the_interpreter() {
    let folder = tempfile::tempdir().unwrap();
    for controlled in machines() {
        let name = &controlled.machine.name;
        let functions = as_functions(controlled);
        let counts = differential(
            &controlled.machine,
            &functions.controllers,
            STEPS,
            23,
            folder.path(),
        );
        let faults = counts.of(ErrorCode::Internal) + counts.of(ErrorCode::Guarantee);
        assert_eq!(faults, 0, "{name}: {counts:?}");
        assert!(counts.ok > STEPS / 3, "{name}: {counts:?}");
        assert!(
            counts.of(ErrorCode::Assumption) > STEPS / 10,
            "{name}: {counts:?}"
        );
    }
}

#[test]
fn operations_come_to_the_same_with_tables_and_with_functions() {
    let (mut done, mut refused) = (0, 0);
    for controlled in machines()
        .iter()
        .filter(|c| !c.machine.operations.is_empty())
    {
        let functions = as_functions(controlled);
        let interpreter =
            |c: &Controlled| Interpreter::new(Arc::clone(&c.machine), Arc::clone(&c.controllers));
        let (mut tables, mut functions) = (interpreter(controlled), interpreter(&functions));
        let machine = &controlled.machine;
        let mut random = Random(29);
        let mut values: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
        for call in 0..400 {
            for (property, value) in machine.properties.iter().zip(&mut values) {
                if let (Some(domain), 0) = (&property.domain, random.below(3)) {
                    *value = random.within(domain) as f64;
                }
            }
            let operation = random.below(machine.operations.len() as u64) as usize;
            let (mut ours, mut theirs) = (values.clone(), values.clone());
            let first = tables.simulate(operation, &mut ours);
            let second = functions.simulate(operation, &mut theirs);
            let place = format!("{} call {call}: {operation} {values:?}", machine.name);
            assert_eq!(ours, theirs, "{place}");
            match (first, second) {
                (Ok(_), Ok(_)) => done += 1,
                (Err(a), Err(b)) => {
                    assert_eq!((a.code, a.rule), (b.code, b.rule), "{place}");
                    refused += 1;
                }
                other => panic!("{place}: {other:?}"),
            }
            values = ours;
        }
    }
    assert!(done > 400 && refused > 100, "{done} {refused}");
}
