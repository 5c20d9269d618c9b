//! Which machines are built, the names of their files, and that no file replaces that of something
//! else.

use super::session::Session;
use crate::support::root;
use std::collections::BTreeSet;
use std::process::Command;

const BELT: &str = "input a: bool\n output b: bool\n guarantee follows: always (b <-> a)";

fn files(session: &Session, folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(session.path(folder)).expect("a folder");
    let names = entries.map(|e| e.expect("an entry").file_name());
    let mut names: Vec<String> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Names that differ only in case, underscores or umlauts, and one reserved by Windows.
#[test]
fn machines_with_names_alike_have_files_of_their_own() {
    let session = Session::new();
    let machines = ["FastBelt", "Fast_Belt", "Förder", "Fürder", "Con"].map(|name| {
        format!(
            "machine {name} implements vdi:Foerdern {{\n signal a: bool = false\n action follow: Follow\n}}\n"
        )
    });
    let text = format!(
        "contract Follow implements vdi:Foerdern {{\n {BELT}\n}}\n{}",
        machines.concat()
    );
    std::fs::write(session.path("belts.lw"), text).expect("a file");
    let built = session.run("build belts.lw --target source --out out --format json");
    assert_eq!(built.code, 0, "{}", built.err);
    for name in ["FastBelt", "Fast_Belt_2", "Förder", "Fürder_2", "Con"] {
        let machine = format!("\"machine\": \"{name}\"");
        assert!(built.out.contains(&machine), "{name}: {}", built.out);
    }
    let own = ["con_", "f_rder", "f_rder_2", "fast_belt", "fast_belt_2"];
    let found = files(&session, "out");
    let methods: Vec<&String> = found
        .iter()
        .filter(|n| n.ends_with(".simtalk.txt"))
        .collect();
    let wanted = own.map(|name| format!("{name}.simtalk.txt"));
    assert_eq!(methods, wanted.iter().collect::<Vec<_>>());
    // Nor does one use another's handle.
    let marks: BTreeSet<String> = own
        .iter()
        .map(|name| {
            let path = session.path(&format!("out/{name}.c"));
            let text = std::fs::read_to_string(path).expect("a C file");
            let mark = text
                .lines()
                .find(|l| l.starts_with("#define LW_HANDLE_MARK "));
            mark.expect("a mark").to_owned()
        })
        .collect();
    assert_eq!(marks.len(), own.len(), "{marks:?}");
    for name in own {
        assert!(found.contains(&format!("{name}.c")), "{name}: {found:?}");
    }
}

#[test]
fn controllers_with_names_alike_are_not_written_over_each_other() {
    let session = Session::new();
    let text: String = ["FastBelt", "Fastbelt", "Con"]
        .map(|name| format!("contract {name} implements vdi:Foerdern {{\n {BELT}\n}}\n"))
        .concat();
    std::fs::write(session.path("belts.lw"), text).expect("a file");
    let written = session.run("synth belts.lw --emit c --emit st --emit st --out out");
    assert_eq!(written.code, 2, "{}", written.err);
    assert_eq!(
        written.err.matches("error[LW504]").count(),
        2,
        "{}",
        written.err
    );
    assert!(
        written
            .err
            .contains("`FastBelt` and `Fastbelt` would both be written to Fastbelt.h"),
        "{}",
        written.err
    );
    let found = files(&session, "out");
    let wanted = [
        "Con_.c",
        "Con_.h",
        "Con_.st",
        "FastBelt.c",
        "FastBelt.h",
        "FastBelt.st",
    ];
    assert_eq!(found, wanted);
    // The remedy in the message.
    let alone = session.run("synth belts.lw::Fastbelt --emit c --out other");
    assert_eq!(alone.code, 0, "{}", alone.err);
    assert_eq!(files(&session, "other"), ["Fastbelt.c", "Fastbelt.h"]);
}

/// A line's machines are built in the sizes used in it.
#[test]
fn a_line_is_built_machine_by_machine() {
    let session = Session::new();
    let belt = std::fs::read_to_string(root().join("examples/ice-lab/belt.lw"));
    std::fs::write(session.path("belt.lw"), belt.expect("a text")).expect("a file");
    let text = "import \"belt.lw\"
line Two {
    part P
    product P
    source spool: P every 1 s
    sink warehouse
    conveyor one: Belt(places = 2) pitch 1 m speed 1 m/s power 1 W
    conveyor two: Belt(places = 5) pitch 1 m speed 1 m/s power 1 W
    route P: spool -> one -> two -> warehouse
}
";
    std::fs::write(session.path("two.lw"), text).expect("a file");
    let built = session.run("build two.lw --target source --out out");
    assert_eq!(built.code, 0, "{}{}", built.out, built.err);
    let of = |name: &str| std::fs::read_to_string(session.path(name)).expect("a C file");
    let outputs = |name: &str| {
        let text = of(name);
        let line = text.lines().find(|l| l.starts_with("#define LW_OUTPUTS "));
        line.and_then(|l| l.rsplit(' ').next()).map(str::to_owned)
    };
    assert_ne!(outputs("out/belt.c"), outputs("out/belt_2.c"));
    assert!(of("out/belt_2.simtalk.txt").contains("LW_Belt_2_init"));
    let named = session.run("build two.lw::Two --target source --out named");
    assert_eq!(named.code, 0, "{}", named.err);
    assert_eq!(files(&session, "named"), files(&session, "out"));
    // A machine with that name still takes precedence over any line.
    let alone = session.run("build two.lw::Belt --target source --out alone");
    assert_eq!(alone.code, 0, "{}", alone.err);
    assert_eq!(
        files(&session, "alone")
            .iter()
            .filter(|n| n.starts_with("belt"))
            .count(),
        3
    );
    assert!(![outputs("out/belt.c"), outputs("out/belt_2.c")].contains(&outputs("alone/belt.c")));
}

#[test]
fn methods_that_were_edited_are_kept() {
    let session = Session::new();
    let build = "build lamp.lw --target source --out out";
    assert_eq!(session.run(build).code, 0);
    let again = session.run(build);
    assert_eq!(
        (again.code, again.err.contains("LW546")),
        (0, false),
        "{}",
        again.err
    );
    let name = files(&session, "out")
        .into_iter()
        .find(|n| n.ends_with(".simtalk.txt"));
    let name = format!("out/{}", name.expect("methods"));
    session.edit(&name, "C:\\linewright", "D:\\plant");
    let kept = session.run(build);
    assert_eq!(kept.code, 0, "{}", kept.err);
    assert!(kept.err.contains("warning[LW546]"), "{}", kept.err);
    let text = || std::fs::read_to_string(session.path(&name)).expect("a text");
    assert!(text().contains("D:\\plant"));
    let rebuilt = session.run(&format!("{build} --rebuild"));
    assert!(rebuilt.err.contains("warning[LW546]"), "{}", rebuilt.err);
    assert!(text().contains("D:\\plant"));
    std::fs::remove_file(session.path(&name)).expect("it is there");
    assert_eq!(session.run(build).code, 0);
    assert!(text().contains("C:\\linewright"));
}

#[test]
fn a_library_that_was_damaged_is_not_listed() {
    let session = Session::new();
    assert_eq!(session.run("build lamp.lw").code, 0);
    let library = session.library(".linewright");
    std::fs::write(&library, "no library").expect("a file");
    let built = session.run("build lamp.lw");
    assert_eq!((built.code, built.out.as_str()), (2, ""), "{}", built.err);
    assert!(built.err.contains("error[LW503]"), "{}", built.err);
    assert_eq!(session.run("build lamp.lw --rebuild").code, 0);
}

#[test]
fn the_probe_is_no_unit() {
    let session = Session::new();
    let built = session.run("build --probe --target fmu");
    assert_eq!(built.code, 2);
    assert!(built.err.contains("--target windows"), "{}", built.err);
}

/// Whatever headers a host includes before.
#[test]
fn ports_that_are_named_like_macros_of_c_compile() {
    let session = Session::new();
    let text = "contract N {
        input errno, NAN, EOF, SIGTERM, complex: bool
        output stdout, I, E2BIG, EMPTY, DBL_MAX: bool
        guarantee first: always (stdout <-> errno) and always (I <-> NAN) and always (E2BIG <-> EOF)
        guarantee second: always (EMPTY <-> SIGTERM) and always (DBL_MAX <-> complex)
    }";
    std::fs::write(session.path("n.lw"), text).expect("a file");
    let emitted = session.run("synth n.lw --emit c --out out");
    assert_eq!(emitted.code, 0, "{}", emitted.err);
    let headers = ["complex", "errno", "float", "math", "signal", "stdio"];
    let includes: String = headers.map(|h| format!("#include <{h}.h>\n")).concat();
    let host = session.path("out/host.c");
    std::fs::write(&host, format!("{includes}#include \"N.c\"\n")).expect("a file");
    let output = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-c", "-o"])
        .arg(session.path("out/host.o"))
        .arg(&host)
        .output()
        .expect("a compiler");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

/// The automaton of an assumption is no guarantee, and neither is a monitor.
#[test]
fn what_only_defines_a_value_is_not_part_of_the_core() {
    let session = Session::new();
    let head = "spec Busy\nenv boolean e;\nsys boolean y;\ngar GF e & y;\n";
    for rest in [
        "asm trig [e]* |=> true* [!e];\n",
        "monitor boolean m { !m; G next(m) = !e; }\nasm GF m;\n",
        "counter c(0..1) { c = 0; inc: !e; overflow: modulo; }\nasm GF c = 1;\n",
    ] {
        std::fs::write(session.path("busy.spectra"), format!("{head}{rest}")).expect("a file");
        let checked = session.run("check busy.spectra");
        assert_eq!(checked.code, 1, "{}", checked.err);
        let said = checked.out + &checked.err;
        assert_eq!(said.matches("cannot be kept").count(), 1, "{said}");
        for wrong in ["leave out `assumption", "gar m:", "gar c:"] {
            assert!(!said.contains(wrong), "{said}");
        }
    }
}

/// The proof from the contracts and the composition of the controllers come to the same finding.
#[test]
fn an_assumption_that_is_not_met_in_a_nested_machine_is_reported_once() {
    let session = Session::new();
    let text = "
        moore contract Single {
            input job: bool
            output busy, done: bool
            assume held: always (job and not done -> next job)
            guarantee start: not busy and not done
            guarantee goes: always (next busy <-> job and not busy and not done)
            guarantee reports: always (next done <-> busy)
        }
        contract Work {
            input asked: bool
            output finished: bool
            guarantee reports: always (finished <-> asked)
        }
        moore contract Once {
            input job: bool
            output ask, done: bool
            guarantee start: not ask and not done
            guarantee asks: always (next ask <-> job and not ask and not done)
            guarantee reports: always (next done <-> ask)
        }
        machine Inner {
            coordinator control: Single { job = operation = go }
            action work: Work when control.busy { asked = control.busy }
            operation go: work
            done control.done
        }
        machine Outer {
            coordinator control: Once { job = operation = run }
            machine inner: Inner { operation = if control.ask then go else none }
            operation run: inner.go
            done control.done
        }";
    std::fs::write(session.path("nested.lw"), text).expect("a file");
    let checked = session.run("check nested.lw");
    assert_eq!(checked.code, 1, "{}", checked.err);
    let said = checked.out + &checked.err;
    assert_eq!(said.matches("error[LW303]").count(), 1, "{said}");
}

/// Instances of a quantifier, conjuncts and the formulas of an order are judged together.
#[test]
fn a_formula_is_not_called_idle_because_a_part_of_it_is() {
    let session = Session::new();
    for text in [
        "contract C {
            input n: 0..3
            output d: bool
            assume small: always (n != 3)
            guarantee all: forall i in 2..3: always (n = i -> not d)
            guarantee other: always (n = 1 -> d)
        }",
        "contract C {
            input n: 0..3
            input a: bool
            output b: bool
            assume small: always (n != 3)
            guarantee both: always ((a -> b) and (n = 3 -> b))
        }",
    ] {
        std::fs::write(session.path("c.lw"), text).expect("a file");
        let checked = session.run("check c.lw");
        let said = checked.out + &checked.err;
        assert!(!said.contains("LW212") && !said.contains("LW213"), "{said}");
    }
    let idle = "contract C {
        input n: 0..3
        output d: bool
        assume small: always (n != 3)
        guarantee all: always (n = 3 -> not d)
    }";
    std::fs::write(session.path("c.lw"), idle).expect("a file");
    let checked = session.run("check c.lw");
    assert!((checked.out + &checked.err).contains("LW21"));
}
