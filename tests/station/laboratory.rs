//! The machines of `examples/ice-lab` with their controllers, made once for all tests: load → solve
//! → extract → verify.

use linewright::contract::machine::Machine;
use linewright::diagnostics::has_errors;
use linewright::engine::files::{self, StandardLibrary};
use linewright::engine::machines::of_line;
use linewright::game::{Limits, Outcome, solve};
use linewright::gr1::Specification;
use linewright::mealy::certify::certify;
use linewright::mealy::functions::Functions;
use linewright::mealy::{self, extract::extract, verify::verify};
use std::sync::{Arc, OnceLock};

/// The line of the paper's product, and the one with the milled part.
pub const LINES: [&str; 2] = ["examples/ice-lab/line.lw", "examples/ice-lab/milled.lw"];

/// A machine and one controller per component.
pub struct Controlled {
    pub machine: Arc<Machine>,
    pub controllers: Arc<Vec<mealy::Controller>>,
}

/// All machines of both lines, each once, in order of occurrence.
pub fn machines() -> &'static [Controlled] {
    static MACHINES: OnceLock<Vec<Controlled>> = OnceLock::new();
    MACHINES.get_or_init(|| {
        let machines = of_lines(&LINES);
        let mut names: Vec<&str> = machines.iter().map(|m| m.machine.name.as_str()).collect();
        names.sort_unstable();
        let wanted = ["AssemblyCell", "Belt", "Milling", "Printer", "QualityCheck"];
        assert_eq!(names, wanted);
        machines
    })
}

/// All machines of some lines, each once, in order of occurrence.
pub fn of_lines(paths: &[&str]) -> Vec<Controlled> {
    let mut done = Vec::new();
    let mut machines: Vec<Controlled> = Vec::new();
    for path in paths {
        let file = crate::support::root().join(path).display().to_string();
        let loaded = files::load(&[file], &StandardLibrary::default());
        assert!(
            !has_errors(&loaded.findings),
            "{path}: {:?}",
            loaded.findings
        );
        let [line] = loaded.library.lines.as_slice() else {
            panic!("{path} declares one line");
        };
        for machine in of_line(line) {
            if machines.iter().any(|m| m.machine.name == machine.name) {
                continue;
            }
            machines.push(controlled(machine, &mut done));
        }
    }
    machines
}

/// All machines of the bundled library, in order of their files.
pub fn of_library() -> &'static [Controlled] {
    static MACHINES: OnceLock<Vec<Controlled>> = OnceLock::new();
    MACHINES.get_or_init(|| {
        let folder = crate::support::root().join("contracts");
        let loaded = files::load(&[folder.display().to_string()], &StandardLibrary::default());
        assert!(!has_errors(&loaded.findings), "{:?}", loaded.findings);
        let mut done = Vec::new();
        let machines = loaded.library.machines.iter();
        machines
            .map(|m| controlled(&Arc::new(m.clone()), &mut done))
            .collect()
    })
}

/// Controllers that were found, with their contracts.
type Done = Vec<(Arc<Specification>, mealy::Machine)>;

/// A machine with a controller for each of its components.
fn controlled(machine: &Arc<Machine>, done: &mut Done) -> Controlled {
    let controllers = machine.components.iter();
    let controllers = controllers.map(|c| controller(&c.specification, done).into());
    Controlled {
        machine: Arc::clone(machine),
        controllers: Arc::new(controllers.collect()),
    }
}

/// The same machine with certified functions for each of its components.
pub fn as_functions(controlled: &Controlled) -> Controlled {
    let limits = Limits::default();
    let components = controlled.machine.components.iter();
    let controllers = components.map(|c| {
        let Outcome::Realizable(won) = solve(&c.specification, &limits) else {
            panic!("{} is realizable", c.name);
        };
        let functions = Functions::extract(&c.specification, &won, &limits).expect("no limit");
        let verdict = certify(&c.specification, &functions, &limits).expect("no limit");
        assert_eq!(verdict, Ok(()), "{}", c.name);
        functions.into()
    });
    Controlled {
        controllers: Arc::new(controllers.collect()),
        machine: Arc::clone(&controlled.machine),
    }
}

/// A verified controller; equal contracts are solved once.
fn controller(specification: &Arc<Specification>, done: &mut Done) -> mealy::Machine {
    if let Some((_, machine)) = done.iter().find(|(s, _)| s == specification) {
        return machine.clone();
    }
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(specification, &limits) else {
        panic!("{} is realizable", specification.name);
    };
    let machine = extract(specification, &won, &limits).expect("no limit");
    let verdict = verify(specification, &machine, &limits).expect("no limit");
    assert_eq!(verdict, Ok(()), "{}", specification.name);
    done.push((Arc::clone(specification), machine.clone()));
    machine
}
