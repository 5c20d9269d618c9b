//! Faulty libraries: the host does not pass on them. Without these, a passing host would prove
//! little.

use super::images::{as_32_bit, real_32_bit};
use super::machines::{named, shipped};
use super::mutants::{KINDS, Kind, are_read_back, coverage, mutate};
use super::programs::{Host, Prepared};
use crate::differential::Random;
use linewright::station::Toolchain;

/// Changed entries of each kind on which the host is run, for each machine.
const EACH: usize = 2;

/// Maximum number of attempts to find as many.
const TRIES: usize = 60;

/// Exports, of which one is omitted at a time.
const EXPORTS: [&str; 3] = ["lw_last_rule", "get_real", "lw_step"];

#[test]
fn one_entry_of_a_table_changed() {
    let host = Host::native();
    // Quickly built, and compiled from the same C.
    let toolchain = Toolchain::host();
    let mut unseen = Vec::new();
    let (mut refused, mut tried) = (0, 0);
    for subject in shipped() {
        let prepared = Prepared::new(subject);
        host.passes(&prepared, 0);
        assert!(are_read_back(&prepared), "{}", subject.name());
        let (met, all) = coverage(&prepared);
        println!("{}: {met} of {all} splits and leaves", subject.name());
        let mut random = Random(97);
        for kind in KINDS {
            let mut found = 0;
            for _ in 0..TRIES {
                if found == EACH {
                    break;
                }
                tried += 1;
                match mutate(&prepared, kind, &mut random) {
                    Ok(mutant) => {
                        let name = format!("{kind:?}{found}");
                        let library = prepared.changed(&toolchain, mutant.c_source, &name);
                        let finished = host.refuses(&prepared, &library, &mutant.what);
                        let said = finished.output.lines().rev().nth(1).unwrap_or_default();
                        assert!(said.contains("of the plan"), "{said}");
                        println!("{}: {}\n    {said}", subject.name(), mutant.what);
                        found += 1;
                    }
                    Err(what) => unseen.push((kind, what)),
                }
            }
            assert_eq!(found, EACH, "{}: {kind:?}", subject.name());
            refused += found;
        }
    }
    println!("{refused} refused of {tried}; not to be seen: {unseen:#?}");
    // The answer of a row is always detected.
    let answers = unseen.iter().filter(|(kind, _)| *kind == Kind::Answer);
    assert_eq!(answers.count(), 0);
}

#[test]
fn one_entry_of_a_table_changed_for_windows() {
    let Some(host) = Host::windows() else { return };
    let prepared = Prepared::new(&named("Printer"));
    host.passes(&prepared, 0);
    let mut random = Random(5);
    for kind in KINDS {
        let mutant = (0..TRIES).find_map(|_| mutate(&prepared, kind, &mut random).ok());
        let mutant = mutant.expect("a change that is seen");
        let library = prepared.changed(&host.toolchain, mutant.c_source, &format!("{kind:?}"));
        host.refuses(&prepared, &library, &mutant.what);
    }
}

fn without_an_export(host: &Host) {
    let prepared = Prepared::new(&named("Printer"));
    host.passes(&prepared, 0);
    for name in EXPORTS {
        // As if it had another name; calls inside the library are not affected.
        let source = format!(
            "#define {name} {name}_of_another_name\n{}",
            prepared.package.c_source
        );
        let library = prepared.changed(&host.toolchain, source, name);
        let finished = host.refuses(&prepared, &library, name);
        let wanted = format!("{name} is not exported\n1 exports are missing");
        assert!(finished.output.contains(&wanted), "{}", finished.output);
    }
}

#[test]
fn an_export_missing() {
    without_an_export(Host::native());
}

#[test]
fn an_export_missing_for_windows() {
    if let Some(host) = Host::windows() {
        without_an_export(host);
    }
}

fn of_32_bit(host: &Host) {
    let prepared = Prepared::new(&named("Printer"));
    host.passes(&prepared, 0);
    let library = prepared.library(&host.toolchain);
    let whole = std::fs::read(&library).expect("the library");
    let patched = library.with_file_name("patched.dll");
    std::fs::write(&patched, as_32_bit(&whole)).expect("a file");
    let mut libraries = vec![patched];
    libraries.extend(real_32_bit(&prepared, host.toolchain.platform()));
    for library in libraries {
        let finished = host.refuses(&prepared, &library, "32 bit");
        assert!(
            finished.output.contains("cannot be loaded"),
            "{}",
            finished.output
        );
    }
}

#[test]
fn a_32_bit_library() {
    of_32_bit(Host::native());
}

#[test]
fn a_32_bit_library_for_windows() {
    if let Some(host) = Host::windows() {
        of_32_bit(host);
    }
}
