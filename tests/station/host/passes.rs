//! The host passes on the library of every machine, on this computer and under Wine.
//!
//! Ten million calls are made once natively and once under Wine, on the machine with the most
//! components; on the others enough that each kind of call is frequent, and all together stay
//! within a minute and a half.

use super::machines::{Subject, as_functions, fixtures, named, of_library, shipped};
use super::programs::{Host, Prepared};

/// Number of calls of the long run, of the others, and of those on the many machines of the
/// library.
const MANY: u64 = 10_000_000;
const SOME: u64 = 200_000;
const FEW: u64 = 20_000;

/// The machine of the long run.
const LONG: &str = "AssemblyCell";

fn calls(subject: &Subject) -> u64 {
    if subject.name() == LONG { MANY } else { SOME }
}

#[test]
fn on_this_computer() {
    let host = Host::native();
    let mut subjects = shipped().to_vec();
    subjects.extend(fixtures());
    for subject in &subjects {
        host.passes(&Prepared::new(subject), calls(subject));
    }
    // The same machines with functions in place of tables.
    for name in ["QualityCheck", "AssemblyCell"] {
        host.passes(&Prepared::new(&as_functions(&named(name))), SOME);
    }
}

#[test]
fn on_windows() {
    let Some(host) = Host::windows() else { return };
    for subject in shipped() {
        host.passes(&Prepared::new(subject), calls(subject));
    }
}

#[test]
fn the_library_on_this_computer() {
    let host = Host::native();
    for subject in of_library() {
        host.passes(&Prepared::new(&subject), FEW);
    }
}

/// Every third machine, or all with `LINEWRIGHT_MACHINES=all`: starting Wine takes long.
#[test]
fn the_library_on_windows() {
    let Some(host) = Host::windows() else { return };
    let are_all = std::env::var("LINEWRIGHT_MACHINES").is_ok_and(|which| which == "all");
    for subject in of_library().iter().step_by(if are_all { 1 } else { 3 }) {
        host.passes(&Prepared::new(subject), FEW);
    }
}

/// A plan that passes few rows would find little.
#[test]
fn plans_come_by_every_row_that_is_met() {
    for subject in shipped() {
        let script = &Prepared::new(subject).script;
        let (covered, rows) = (script.covered.len(), script.rows);
        let others = if script.whole {
            "no other can be met"
        } else {
            "others may be met"
        };
        println!("{}: {covered} of {rows} rows; {others}", subject.name());
        let least = match subject.name() {
            "Printer" => 76,
            "Milling" => 62,
            "QualityCheck" => 31,
            "AssemblyCell" => 440,
            "Belt" => 13,
            "Loader" => 43,
            name => panic!("{name} is new: say how many rows its plan comes by"),
        };
        assert!(covered >= least, "{}: {covered} of {rows}", subject.name());
        let small = ["Printer", "Milling", "Belt", "Loader"];
        assert!(script.whole || !small.contains(&subject.name()));
    }
}
