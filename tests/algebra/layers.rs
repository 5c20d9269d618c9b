//! Machines within machines: the flat machine compared with its parts, proofs by promises with
//! proofs of everything, and errors in a machine of machines. `station/layers.rs` tests that their
//! libraries agree with the interpreter.

use crate::support;
use crate::support::root;
use linewright::algebra::machine::{of_machine, of_refined_contract};
use linewright::algebra::proof::{Claim, Proof, prove, prove_stepwise};
use linewright::algebra::replay;
use linewright::algebra::system::{ContractSide, System};
use linewright::contract;
use linewright::contract::machine::{Machine, Role};
use linewright::engine::files::{self, StandardLibrary};
use linewright::game::Limits;
use linewright::gr1::Side;
use std::path::Path;
use std::sync::Arc;

fn load(path: &Path) -> Vec<Machine> {
    let loaded = files::load(&[path.display().to_string()], &StandardLibrary::default());
    let found: Vec<_> = loaded
        .findings
        .iter()
        .map(|f| (f.code.id, &f.message))
        .collect();
    assert_eq!(found, []);
    loaded.library.machines
}

fn machine(file: &str, name: &str) -> Machine {
    let machines = load(&root().join(file));
    let found = machines.into_iter().find(|m| m.name == name);
    found.expect("a machine of that name")
}

fn cell() -> Machine {
    machine("examples/transfer/cell.lw", "TransferCell")
}

fn hall() -> Machine {
    machine("tests/algebra/layers/hall.lw", "Hall")
}

#[track_caller]
fn proved(system: &System, claim: &Claim) -> Proof {
    prove(system, claim, &Limits::default()).expect("no limit")
}

fn names(machine: &Machine) -> Vec<&str> {
    machine.components.iter().map(|c| c.name.as_str()).collect()
}

#[test]
fn what_runs_is_flat_and_what_is_proved_is_not() {
    let cell = cell();
    assert_eq!(
        names(&cell),
        [
            "cell",
            "pick.control",
            "table.control",
            "pick.pick",
            "pick.place",
            "table.rotate"
        ]
    );
    assert_eq!(names(cell.abstraction()), ["cell", "pick", "table"]);
    let hall = hall();
    assert_eq!(
        names(&hall),
        [
            "lead",
            "cell.cell",
            "cell.pick.control",
            "cell.table.control",
            "cell.pick.pick",
            "cell.pick.place",
            "cell.table.rotate"
        ]
    );
    assert_eq!(names(hall.abstraction()), ["lead", "cell"]);
    // Coordinators of all layers come first.
    let roles: Vec<Role> = hall.components.iter().map(|c| c.role).collect();
    assert!(roles.is_sorted_by_key(|r| *r == Role::Action));
    // The sequence of an operation, by the actions' own names.
    let runs = |m: &Machine| -> Vec<String> {
        let sequence = m.operations[0].sequence.iter();
        sequence.map(|i| m.components[*i].name.clone()).collect()
    };
    assert_eq!(
        runs(&hall),
        [
            "cell.pick.pick",
            "cell.pick.place",
            "cell.table.rotate",
            "cell.pick.pick",
            "cell.pick.place"
        ]
    );
    // Everything that the units draw beside their actions is drawn by the cell.
    assert!((cell.base_watts - (20.0 + 40.0 + 30.0)).abs() < 1e-9);
    assert!((hall.base_watts - cell.base_watts).abs() < 1e-9);
    assert!((cell.idle_watts - 15.0).abs() < 1e-9);
}

/// Everything to be proved of a machine, with inner machines as their promises, and with all their
/// components.
fn both_ways(machine: &Machine) -> Vec<[(System, Claim); 2]> {
    let short = machine.abstraction();
    let mut all = vec![[of_machine(short), of_machine(machine)]];
    for (short_one, long) in short.refines.iter().zip(&machine.refines) {
        all.push([
            of_refined_contract(short, short_one),
            of_refined_contract(machine, long),
        ]);
    }
    all
}

#[test]
fn what_promises_show_the_components_show_too() {
    for machine in [cell(), hall()] {
        for [short, long] in both_ways(&machine) {
            let (a, b) = (proved(&short.0, &short.1), proved(&long.0, &long.1));
            assert!(a.holds(), "{}: {:?}", machine.name, a.open);
            assert!(b.holds(), "{}: {:?}", machine.name, b.open);
            println!(
                "{}: {} obligations over {} variables by promises, {} over {} flat",
                machine.name,
                a.discharges.len(),
                short.0.variables.len(),
                b.discharges.len(),
                long.0.variables.len()
            );
            assert!(a.discharges.len() < b.discharges.len());
            assert!(short.0.variables.len() < long.0.variables.len());
        }
    }
}

/// Without one guarantee of a coordinator: whatever still follows from promises follows from the
/// components as well.
#[test]
fn of_a_damaged_coordinator_promises_never_show_more() {
    let cell = cell();
    let count = cell.components[0].specification.guarantees.all().count();
    let (mut kept, mut lost, mut only_flat) = (0, 0, 0);
    for index in 0..count {
        let mut damaged = cell.clone();
        without(&mut damaged, 0, index);
        let mut short = cell.abstraction().clone();
        without(&mut short, 0, index);
        damaged.layers.abstraction = Some(Arc::new(short));
        for [short, long] in both_ways(&damaged) {
            let (a, b) = (proved(&short.0, &short.1), proved(&long.0, &long.1));
            assert!(!a.holds() || b.holds(), "guarantee {index}: {:?}", b.open);
            for (pair, proof) in [(&short, &a), (&long, &b)] {
                for open in &proof.open {
                    assert_eq!(replay::accepts(&pair.0, &pair.1, proof, open), Ok(()));
                }
            }
            match (a.holds(), b.holds()) {
                (true, _) => kept += 1,
                (false, false) => lost += 1,
                (false, true) => only_flat += 1,
            }
        }
    }
    println!("{kept} hold both ways, {lost} neither, {only_flat} flat only");
    assert!(lost >= 5, "{kept} {lost} {only_flat}");
}

/// Removes the guarantee with this index from a component.
fn without(machine: &mut Machine, component: usize, index: usize) {
    let component = &mut machine.components[component];
    let specification = Arc::make_mut(&mut component.specification);
    remove(&mut specification.guarantees, index);
}

fn remove(side: &mut Side, mut index: usize) {
    for list in [
        &mut side.initial,
        &mut side.invariants,
        &mut side.safety,
        &mut side.justice,
    ] {
        if index < list.len() {
            list.remove(index);
            return;
        }
        index -= list.len();
    }
    panic!("no such formula");
}

/// Every guarantee of a unit that the cell's table names is needed.
#[test]
fn without_a_promise_that_a_table_names_the_proof_fails() {
    let mut tried = 0;
    for machine in [cell(), hall()] {
        let short = machine.abstraction();
        let (system, claim) = of_machine(short);
        let proof = proved(&system, &claim);
        let inner = |part: usize| {
            machine
                .layers
                .inner
                .iter()
                .any(|i| i.name == system.components[part].name)
        };
        let mut named: Vec<_> = proof
            .discharges
            .iter()
            .flat_map(|d| d.by.iter().copied())
            .filter(|at| at.half == ContractSide::Guarantees && at.component.is_some_and(inner))
            .collect();
        named.sort_unstable();
        named.dedup();
        assert!(
            !named.is_empty(),
            "the table of {} names promises",
            machine.name
        );
        for at in named {
            let mut less = system.clone();
            let part = &mut less.components[at.component.expect("a part")];
            let formula = part.guarantees.list(at.kind)[at.index].name.clone();
            part.guarantees.list_mut(at.kind).remove(at.index);
            let again = proved(&less, &claim);
            assert!(!again.holds(), "{} does not need {formula}", machine.name);
            assert!(!again.open.is_empty());
            for open in &again.open {
                assert_eq!(replay::accepts(&less, &claim, &again, open), Ok(()));
            }
            tried += 1;
        }
    }
    println!("{tried} promises, each of them needed");
    assert!(tried >= 6, "{tried}");
}

#[test]
fn promises_are_kept_step_by_step() {
    for machine in [cell(), hall()] {
        for inner in &machine.layers.inner {
            let (system, claim) =
                of_refined_contract(inner.machine.abstraction(), &inner.machine.refines[0]);
            let proof = prove_stepwise(&system, &claim, &Limits::default()).expect("no limit");
            assert!(proof.holds(), "{}: {:?}", inner.name, proof.open);
        }
    }
}

/// A copy of the example with a replacement.
fn changed(file: &str, from: &str, to: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["units.lw", "cell.lw"] {
        let text = std::fs::read_to_string(root().join("examples/transfer").join(name));
        let mut text = text.expect("an example");
        if name == file {
            assert!(text.contains(from), "{name} has no {from}");
            text = text.replace(from, to);
        }
        std::fs::write(folder.path().join(name), text).expect("a copy");
    }
    folder
}

fn checked(folder: &Path, file: &str) -> (Option<i32>, String) {
    let output = support::linewright(folder, &["check", file, "--format", "short"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text)
}

#[test]
fn a_unit_that_keeps_its_contract_no_more_is_found_at_the_unit_and_at_the_cell() {
    let folder = changed(
        "units.lw",
        "guarantee report: always (next done <-> finished)",
        "guarantee report: always (next done <-> finished or done)",
    );
    let (code, text) = checked(folder.path(), "units.lw");
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("error[LW310]: `pulse` of `PickAndPlace` is not kept"),
        "{text}"
    );
    let (code, text) = checked(folder.path(), "cell.lw");
    assert_eq!(code, Some(1), "{text}");
    let words = "`pick` does not keep `PickAndPlace`, on which the proof of `TransferCell` relies";
    assert!(text.contains(words), "{text}");
}

/// With its arguments in the cell, not those of its own file.
#[test]
fn a_unit_is_proved_in_the_size_that_it_has() {
    let folder = changed(
        "units.lw",
        "guarantee report: always (next done <-> finished)",
        "guarantee report: always (next done <-> finished or (done and not small))",
    );
    let units = folder.path().join("units.lw");
    let text = std::fs::read_to_string(&units).expect("the copy");
    let text = text
        .replace(
            "moore contract PickControl implements",
            "moore contract PickControl(small: bool = true) implements",
        )
        .replace(
            "coordinator control: PickControl {",
            "coordinator control: PickControl(small = stages < 3) {",
        );
    std::fs::write(&units, text).expect("the copy");
    assert_eq!(checked(folder.path(), "units.lw").0, Some(0));
    let (code, text) = checked(folder.path(), "cell.lw");
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("`pick` does not keep `PickAndPlace`"),
        "{text}"
    );
}

/// Whatever the contract does not mention is free in the proof, and the finding names the remedy.
#[test]
fn what_no_contract_speaks_of_is_free() {
    let from = "picked = pick.done";
    let harmless = "picked = pick.done and pick.control.command = none";
    let folder = changed("cell.lw", from, harmless);
    let output = support::linewright(folder.path(), &["check", "cell.lw"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned()
        + &String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("`pick.control.command`, which `PickAndPlace` does not mention"),
        "{text}"
    );
    // And it can be shown from the components.
    let machines = load(&folder.path().join("cell.lw"));
    let cell = machines.iter().find(|m| m.name == "TransferCell");
    let [short, long] = &both_ways(cell.expect("the cell"))[0];
    assert!(!proved(&short.0, &short.1).holds());
    assert!(proved(&long.0, &long.1).holds());
    // The same wire under another name is the contract's own.
    let folder = changed("cell.lw", from, "picked = pick.control.done");
    assert_eq!(checked(folder.path(), "cell.lw").0, Some(0));
    // If the unit refines nothing, its components are used.
    let text = std::fs::read_to_string(folder.path().join("units.lw")).expect("a copy");
    let start = text.find("\n    refines PickAndPlace").expect("a promise");
    let end = start + text[start..].find("    }\n").expect("its end") + 6;
    let bare = format!("{}{}", &text[..start], &text[end..]);
    std::fs::write(folder.path().join("units.lw"), bare).expect("a copy");
    let machines = load(&folder.path().join("cell.lw"));
    let cell = machines
        .iter()
        .find(|m| m.name == "TransferCell")
        .expect("the cell");
    assert_eq!(
        names(cell.abstraction()),
        ["cell", "pick.control", "pick.pick", "pick.place", "table"]
    );
    let [short, _] = &both_ways(cell)[0];
    assert!(proved(&short.0, &short.1).holds());
}

const SMALL: &str = "
contract Count { input go: bool  output n: 0..3  guarantee start: n = 0
    guarantee step: always (next n = (if go then (n + 1) mod 4 else n)) }
contract Ask { input go, seen: bool  output done: bool  guarantee done: always (done <-> go and seen) }
machine Inner {
    signal go: bool = true
    parameter weight: kg = 1
    action tally: Count when go { power 1 W * (weight / 1 kg) }
    action ask: Ask { seen = tally.n = 3 }
    operation run: tally
    operation stop: tally
    done ask.done
}
machine Outer {
    signal on: bool = true
    parameter heavy: kg = 2
    machine inner: Inner { operation = if operation = all then run else stop  go = on  weight = heavy }
    operation all: inner.run
    done inner.done
}
";

/// The ids and messages of the findings when `from` is replaced by `to`.
fn found(from: &str, to: &str) -> Vec<String> {
    assert!(SMALL.contains(from), "the text has no {from}");
    let files = [("small.lw".to_owned(), SMALL.replace(from, to))];
    let (_, findings) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    findings
        .iter()
        .map(|f| format!("{}: {}", f.code.id, f.message))
        .collect()
}

#[test]
fn mistakes_in_machines_of_machines_are_found() {
    let no_change = "machine Outer";
    assert_eq!(found(no_change, no_change), [""; 0]);
    for (from, to, wanted) in [
        (
            "go = on  ",
            "",
            "LW301: the input `go` of `inner` is not bound",
        ),
        (
            "  weight = heavy",
            "",
            "LW301: the property `weight` of `inner` is not bound, but times or powers of its actions depend on it",
        ),
        (
            "go = on  ",
            "go = on  gone = on  ",
            "LW101: `Inner` has no input `gone`",
        ),
        (
            "inner: Inner {",
            "inner: Inside {",
            "LW101: there is no machine `Inside`",
        ),
        (
            "inner: Inner {",
            "inner: Count {",
            "LW101: there is no machine `Count`",
        ),
        (
            "inner: Inner {",
            "inner: Inner when on {",
            "LW306: `inner` is a machine; `when` is allowed only for actions",
        ),
        (
            "go = on  ",
            "go = on  power 3 W  ",
            "LW306: `inner` is a machine; `power` is allowed only for actions",
        ),
        (
            "all: inner.run",
            "all: inner",
            "LW306: no operation of `inner` is selected",
        ),
        (
            "all: inner.run",
            "all: inner.rum",
            "LW101: `inner` has no operation `rum`",
        ),
        (
            "go = on  ",
            "go = inner.done  ",
            "LW302: `inner` reads its own output in the same step",
        ),
        (
            "machine inner: Inner {",
            "machine inner: Outer {",
            "LW313: `Outer` contains itself: Outer -> Outer",
        ),
        (
            "action tally: Count when go",
            "machine deep: Outer { operation = none  on = go  heavy = weight }\n    action tally: Count when go",
            "LW313: `Inner` contains itself: Inner -> Outer -> Inner",
        ),
    ] {
        let found = found(from, to);
        assert!(
            found.iter().any(|f| f == wanted),
            "{from} -> {to}: {found:#?}"
        );
    }
}

/// An input read only by Moore components may come from a component that answers later.
#[test]
fn a_coordinator_within_may_be_led_by_what_answers_later() {
    let text = "
        moore contract Lead { input go: bool  output on: bool  guarantee on: always (next on <-> go) }
        contract Echo { input go: bool  output back: bool  guarantee back: always (back <-> go) }
        machine Inner { signal go: bool = true  coordinator lead: Lead  action echo: Echo { go = lead.on } }
        machine Outer {
            machine inner: Inner { go = late.back }
            action late: Echo { go = inner.echo.back }
        }
        machine Odd {
            machine inner: Inner { go = not inner.lead.on }
            machine second: Inner { go = inner.echo.back }
        }";
    let files = [("late.lw".to_owned(), text.to_owned())];
    let (library, findings) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    assert_eq!(findings.len(), 0, "{findings:?}");
    assert_eq!(library.machines.len(), 3);
}
