//! The tested machines: all shipped ones, and fixtures for what those never do.

use crate::{counting, fixtures, laboratory};
use linewright::contract::machine::Machine;
use linewright::mealy;
use std::sync::{Arc, OnceLock};

/// The lines whose machines are all tested.
const LINES: [&str; 3] = [
    "examples/ice-lab/line.lw",
    "examples/ice-lab/milled.lw",
    "examples/loader/line.lw",
];

/// A machine, and a controller for each of its components.
#[derive(Clone)]
pub struct Subject {
    pub machine: Arc<Machine>,
    pub controllers: Arc<Vec<mealy::Controller>>,
}

impl Subject {
    fn of((machine, controllers): (Arc<Machine>, Arc<Vec<mealy::Controller>>)) -> Self {
        Self {
            machine,
            controllers,
        }
    }

    pub fn name(&self) -> &str {
        &self.machine.name
    }
}

/// Every machine of the laboratory and the loader.
pub fn shipped() -> &'static [Subject] {
    static SHIPPED: OnceLock<Vec<Subject>> = OnceLock::new();
    SHIPPED.get_or_init(|| {
        let machines = laboratory::of_lines(&LINES).into_iter();
        let subjects: Vec<Subject> = machines
            .map(|c| Subject::of((c.machine, c.controllers)))
            .collect();
        let mut names: Vec<&str> = subjects.iter().map(Subject::name).collect();
        names.sort_unstable();
        let wanted = [
            "AssemblyCell",
            "Belt",
            "Loader",
            "Milling",
            "Printer",
            "QualityCheck",
        ];
        assert_eq!(names, wanted);
        subjects
    })
}

/// Every machine of the bundled library.
pub fn of_library() -> Vec<Subject> {
    let machines = laboratory::of_library().iter();
    let subjects = machines.map(|c| {
        let controllers = Arc::clone(&c.controllers);
        Subject::of((Arc::clone(&c.machine), controllers))
    });
    subjects.collect()
}

/// One of those that are shipped with the examples.
pub fn named(name: &str) -> Subject {
    let found = shipped().iter().find(|s| s.name() == name);
    found.expect("a machine of that name").clone()
}

/// The same machine with functions as controllers.
pub fn as_functions(subject: &Subject) -> Subject {
    let controlled = laboratory::as_functions(&laboratory::Controlled {
        machine: Arc::clone(&subject.machine),
        controllers: Arc::clone(&subject.controllers),
    });
    Subject::of((controlled.machine, controlled.controllers))
}

/// An operation that need not end, Moore actions, negative numbers, texts beyond ASCII, and no
/// operation at all.
pub fn fixtures() -> Vec<Subject> {
    vec![
        Subject::of(fixtures::manipulator()),
        Subject::of(fixtures::jammed()),
        Subject::of(counting::counting()),
        Subject::of(fixtures::belt()),
    ]
}
