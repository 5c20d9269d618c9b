//! The algebra on the command line: operands, ports, verdicts and exit codes, the documents, one
//! controller for all parts, two states of a library.

use crate::support;
use crate::support::linewright;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

fn at_root(arguments: &[&str]) -> Output {
    linewright(support::root(), arguments)
}

fn document(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)))
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

const SAFE: [&str; 2] = [
    "examples/fit-together/safe.lw::Feeder",
    "examples/fit-together/safe.lw::Gripper",
];

#[test]
fn compose_says_by_whom_and_how_each_assumption_is_met() {
    let output = at_root(&["compose", SAFE[0], SAFE[1], "--format", "json"]);
    assert_eq!(output.status.code(), Some(0));
    let document = document(&output);
    assert_eq!(document["schema"], "linewright/compose/1");
    assert_eq!(document["verdict"], "composed");
    assert_eq!(document["semantics"], "strict");
    let first = &document["proof"]["discharges"][0];
    assert_eq!(first["of"], "Feeder");
    assert_eq!(first["name"], "careful");
    assert_eq!(first["rule"], "induction");
    assert_eq!(first["by"][0]["name"], "grips");
    assert_eq!(document["pairs"][1]["name"], "Gripper");
}

#[test]
fn what_is_open_comes_with_a_run_and_a_circle_with_its_members() {
    let file = "examples/fit-together/circle.lw";
    let (a, b) = (format!("{file}::Feeder"), format!("{file}::Gripper"));
    let output = at_root(&["compose", &a, &b, "--format", "json"]);
    assert_eq!(output.status.code(), Some(1));
    let document = document(&output);
    assert_eq!(document["verdict"], "open");
    let open = &document["proof"]["open"];
    assert_eq!(open.as_array().map(Vec::len), Some(2));
    assert_eq!(open[0]["counterexample"]["kind"], "lasso");
    assert_eq!(open[0]["counterexample"]["steps"][0]["reaching"], "false");
    assert_eq!(
        document["proof"]["circles"][0].as_array().map(Vec::len),
        Some(2)
    );
    let codes: Vec<&str> = document["findings"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|f| f["code"].as_str())
        .collect();
    assert!(
        codes.contains(&"LW303") && codes.contains(&"LW309"),
        "{codes:?}"
    );
}

#[test]
fn a_loop_within_a_step_is_refused() {
    let file = "examples/fit-together/loop.lw";
    let (a, b) = (format!("{file}::Lamp"), format!("{file}::Door"));
    let output = at_root(&["compose", &a, &b, "--format", "json"]);
    assert_eq!(output.status.code(), Some(1));
    let loops = &document(&output)["proof"]["loops"];
    assert_eq!(loops, &serde_json::json!([["shut", "lit"]]));
}

#[test]
fn what_fits_is_synthesized_as_one() {
    let file = "examples/fit-together/mended.lw";
    let (a, b) = (format!("{file}::Feeder"), format!("{file}::Gripper"));
    let output = at_root(&["compose", &a, &b, "--synth"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let machine = document(&output);
    assert_eq!(machine["schema"], "linewright/machine/1");
    assert_eq!(machine["verified"], true);
    assert_eq!(machine["inputs"], serde_json::json!([]));
    // What does not fit is rejected.
    let file = "examples/fit-together/circle.lw";
    let (a, b) = (format!("{file}::Feeder"), format!("{file}::Gripper"));
    let output = at_root(&["compose", &a, &b, "--synth"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        text(&output).contains("nothing is synthesized"),
        "{output:?}"
    );
}

/// The environment of the whole gives the inputs of a step before it sees its outputs.
#[test]
fn no_machine_is_made_under_an_assumption_about_its_own_outputs() {
    let folder = tempfile::tempdir().expect("a folder");
    let synthesize = |feeder: &str, assumption: &str| {
        let contracts = format!(
            "{feeder} {{
    input full: bool
    output fed: bool
    guarantee again: always eventually fed
}}
contract Gripper {{
    input fed, seen: bool
    output closed: bool
    assume shown: {assumption}
    guarantee on_sight: always (closed -> seen)
}}
"
        );
        fs::write(folder.path().join("own.lw"), contracts).expect("a file");
        linewright(
            folder.path(),
            &["compose", "own.lw::Feeder", "own.lw::Gripper", "--synth"],
        )
    };
    for feeder in ["contract Feeder", "moore contract Feeder"] {
        for assumption in [
            "always (fed -> seen)",
            "(fed -> seen)",
            "always ((closed -> next seen) and not next fed)",
            "always (next fed -> next seen)",
        ] {
            let output = synthesize(feeder, assumption);
            let shown = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{assumption}: {shown}");
            assert!(
                shown.contains(
                    "error[LW202]: `shown` of `Gripper` remains an assumption about the environment, but constrains `fed`, which `Feeder` sets"
                ),
                "{assumption}: {shown}"
            );
        }
        // It sees the previous step.
        for assumption in [
            "always (fed -> next seen)",
            "always (previous fed -> seen)",
            "always eventually (fed -> seen)",
        ] {
            let output = synthesize(feeder, assumption);
            assert_eq!(output.status.code(), Some(0), "{assumption}: {output:?}");
            assert_eq!(document(&output)["verified"], true);
        }
    }
}

/// A contract that is `moore` already is not advised to become so.
#[test]
fn moore_contracts_that_wait_for_each_other_get_other_advice() {
    let folder = tempfile::tempdir().expect("a folder");
    let contracts = "moore contract A {
    input b, c: bool
    output a: bool
    assume free: not b
    guarantee both: always (b and a)
    guarantee absent: always (b -> (c xor c))
}
moore contract B {
    input a: bool
    output b, c: bool
    assume free: always not a
    guarantee none: not c and c and a
}
";
    let advice = |contracts: &str| {
        fs::write(folder.path().join("own.lw"), contracts).expect("a file");
        let output = linewright(folder.path(), &["compose", "own.lw::A", "own.lw::B"]);
        let shown = text(&output);
        assert!(
            shown.contains("error[LW302]: within one step, `b` of B and `a` of A wait"),
            "{shown}"
        );
        shown
            .lines()
            .find_map(|line| line.split_once("= help: "))
            .expect("a help text")
            .1
            .to_owned()
    };
    let of_moore = advice(contracts);
    assert!(
        of_moore.starts_with("let what one of the contracts assumes or guarantees refer to"),
        "{of_moore}"
    );
    let of_mealy = advice(&contracts.replace("moore contract B", "contract B"));
    assert!(
        of_mealy.starts_with("make one of the contracts `moore`"),
        "{of_mealy}"
    );
}

#[test]
fn ports_that_do_not_fit_are_reported_and_can_be_renamed() {
    let output = at_root(&["compose", "std.handling.pick", "std.handling.place"]);
    assert_eq!(output.status.code(), Some(1));
    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        shown.contains("LW311") && shown.contains("`stage` is set by"),
        "{shown}"
    );
    let renamed = ["--rename", "Place.stage=place_stage"];
    let output = at_root(&[
        "compose",
        "std.handling.pick",
        "std.handling.place",
        renamed[0],
        renamed[1],
    ]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    for (rename, why) in [
        ("Place.stages=x", "has no variable `stages`"),
        ("Nobody.stage=x", "the contracts here are"),
        ("stage", "write CONTRACT.PORT=NAME"),
    ] {
        let output = at_root(&[
            "compose",
            "std.handling.pick",
            "std.handling.place",
            "--rename",
            rename,
        ]);
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(shown.contains(why), "{rename}: {shown}");
        assert_ne!(output.status.code(), Some(0));
    }
}

#[test]
fn a_contract_refines_itself_and_expressions_are_operands() {
    let turn = "std.handling.turn";
    let output = at_root(&["refine", turn, turn, "--format", "json"]);
    assert_eq!(output.status.code(), Some(0));
    let document = document(&output);
    assert_eq!(document["verdict"], "refined");
    assert_eq!(document["semantics"], "runs");
    assert_eq!(document["guarantees"]["open"], serde_json::json!([]));
    // What two promise together, each promises.
    let both = format!("conjoin({}, {})", SAFE[0], SAFE[1]);
    for one in SAFE {
        let output = at_root(&["refine", one, &both]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
    // But not vice versa.
    let output = at_root(&["refine", &both, SAFE[0], "--format", "json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(document["counterexample"]["kind"], "lasso");
}

/// Without an environment that keeps the old assumptions every contract refines the old one: the
/// output says so explicitly. For `check`, which compares safety step by step, no machine keeps the
/// old one.
#[test]
fn that_nothing_was_promised_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let contracts = "
contract Old {
    input part: bool
    output grip: bool
    assume both: always eventually (part and not part)
    guarantee holds: always (grip and part)
}
contract New {
    input part: bool
    output grip: bool
}
";
    fs::write(folder.path().join("grip.lw"), contracts).expect("a file");
    let output = linewright(
        folder.path(),
        &["refine", "grip.lw::Old", "grip.lw::New", "--format", "json"],
    );
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let document = document(&output);
    assert_eq!(document["verdict"], "refined");
    let checked = linewright(folder.path(), &["check", "grip.lw"]);
    assert_eq!(checked.status.code(), Some(1), "{checked:?}");
    let findings = document["findings"].as_array().expect("findings");
    let said = findings.iter().find(|f| f["code"] == "LW206");
    let said = said.unwrap_or_else(|| panic!("{document}"));
    assert_eq!(said["severity"], "warning");
    assert_eq!(
        said["message"],
        "no environment keeps the assumptions of `Old`, so every contract refines it"
    );
}

/// A guarantee that looks like the definition of a monitor is an ordinary one: it must be kept.
#[test]
fn what_is_asked_of_the_past_is_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let contract = |name: &str, guarantee: &str| {
        format!(
            "contract {name} {{\n    input a: bool\n    output x: bool\n    guarantee g: {guarantee}\n}}\n"
        )
    };
    let contracts = contract("Written", "always ((previous x) = false)")
        + &contract("Same", "always not previous x")
        + &contract("Other", "always (x <-> a)");
    fs::write(folder.path().join("past.lw"), contracts).expect("a file");
    for (old, new, code) in [
        ("Written", "Same", 0),
        ("Same", "Written", 0),
        ("Written", "Other", 1),
        ("Same", "Other", 1),
    ] {
        let operands = [old, new].map(|name| format!("past.lw::{name}"));
        let output = linewright(folder.path(), &["refine", &operands[0], &operands[1]]);
        assert_eq!(output.status.code(), Some(code), "{old} {new}: {output:?}");
    }
}

#[test]
fn a_quotient_is_proved_by_composing_it_back() {
    let output = at_root(&["quotient", SAFE[0], SAFE[1]]);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        text(&output).contains("Proved: composed with `Gripper` it refines `Feeder`."),
        "{output:?}"
    );
    let output = at_root(&["merge", SAFE[0], SAFE[1], "--format", "json"]);
    assert_eq!(document(&output)["verdict"], "proved");
}

/// Whether NEW is a contract, a composition or another expression.
#[test]
fn whatever_refines_a_contract_without_an_environment_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let contracts = "contract W {\n    input a: bool\n    output y, z: bool\n    assume always eventually (a and not a)\n    guarantee always eventually y\n}\n\
                     contract P {\n    input a: bool\n    output y: bool\n    assume always a\n    guarantee always eventually y\n}\n\
                     contract Q {\n    input a: bool\n    output z: bool\n    guarantee always eventually z\n}\n";
    fs::write(folder.path().join("own.lw"), contracts).expect("a file");
    for new in [
        "own.lw::P",
        "compose(own.lw::P, own.lw::Q)",
        "conjoin(own.lw::P, own.lw::Q)",
    ] {
        let output = linewright(
            folder.path(),
            &["refine", "own.lw::W", new, "--format", "json"],
        );
        assert_eq!(output.status.code(), Some(0), "{new}: {output:?}");
        let document = document(&output);
        assert_eq!(document["verdict"], "refined", "{new}");
        assert_eq!(document["semantics"], "runs", "{new}");
        assert_eq!(document["findings"][0]["code"], "LW206", "{new}");
    }
}

/// The output of `compat` for a contract in a separate file, in JSON.
fn compat_of(contract: &str) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("own.lw"), contract).expect("a file");
    linewright(folder.path(), &["compat", "own.lw", "--format", "json"])
}

#[test]
fn an_environment_that_cannot_be_is_shown_by_a_play() {
    let output = compat_of(
        "
moore contract Robot {
    input door: bool
    output inside: bool
    assume open: always (inside -> next door)
    assume shut: always (inside -> next not door)
}
",
    );
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let document = document(&output);
    assert_eq!(document["verdict"], "incompatible");
    assert_eq!(document["counterexample"]["kind"], "trace");
    let output = at_root(&["compat", SAFE[0], SAFE[1]]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// `B` can never keep its guarantee, but it answers after the environment, which has to keep the
/// assumption first. A `moore` contract that has nothing to do with it changes nothing.
#[test]
fn an_unrelated_contract_does_not_excuse_the_environment() {
    let unrelated = "
moore contract A {
    input t: bool
    output a: bool
    guarantee always (t -> next a)
}
";
    let impossible = "
contract B {
    input y: bool
    output b: bool
    assume always (y and not y)
    guarantee always (b and not b)
}
";
    let stuck_later = "
moore contract A0 {
    input t: bool
    output a0: bool
    guarantee always eventually a0
}
contract B {
    input y: bool
    output b: bool
    assume y
    assume always (b -> next y and not next y)
    guarantee b
    guarantee always (b -> next b and not next b)
}
";
    for (text, contracts) in [
        (impossible, &["B"][..]),
        (impossible, &["A", "B"]),
        (stuck_later, &["A", "A0", "B"]),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("own.lw");
        fs::write(path, format!("{unrelated}{text}")).expect("a file");
        let named = contracts.iter().map(|name| format!("own.lw::{name}"));
        let named: Vec<String> = named.collect();
        let arguments = ["compat", "--format", "json"].into_iter();
        let arguments: Vec<&str> = arguments.chain(named.iter().map(String::as_str)).collect();
        let output = linewright(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(1), "{contracts:?}: {output:?}");
        let document = document(&output);
        assert_eq!(document["verdict"], "incompatible", "{contracts:?}");
    }
}

/// Two contracts have an `assumption 1`; the finding says whose it is, and points at it.
#[test]
fn an_assumption_is_named_with_its_contract() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "
moore contract C0 {
    input b: bool
    output a: bool
    guarantee always not a
}
contract C1 {
    input a: bool
    output b: bool
    assume a
    guarantee b
}
";
    fs::write(folder.path().join("own.lw"), text).expect("a file");
    let output = linewright(folder.path(), &["compat", "own.lw::C0", "own.lw::C1"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let shown = String::from_utf8_lossy(&output.stdout);
    assert!(
        shown.contains("`assumption 1` of C1 can be broken"),
        "{output:?}"
    );
    assert!(shown.contains("own.lw:10:"), "{shown}");
}

/// The outside sees `y` before it answers, and copies it. A promise that `x` holds again and again
/// restricts no single step.
#[test]
fn a_promise_about_inputs_does_not_blind_the_environment() {
    let output = compat_of(
        "
moore contract Copied {
    input x: bool
    output y: bool
    assume mirror: always (next true -> (x <-> y))
    guarantee again: always eventually x
}
",
    );
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// A copy of the library with a replacement in one file.
fn changed(folder: &Path, name: &str, file: &str, from: &str, to: &str) {
    let target = folder.join(name);
    copy(&support::root().join("contracts"), &target);
    let path = target.join(file);
    let text = fs::read_to_string(&path).expect("a contract");
    assert!(text.contains(from), "{file} has no {from}");
    fs::write(path, text.replace(from, to)).expect("a file");
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

#[test]
fn two_states_of_a_library_are_compared_contract_by_contract() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    copy(&support::root().join("contracts"), &at.join("old"));
    let turn = "handling/turn.lw";
    let gripped = "assume gripped: always (requested -> grip)";
    changed(at, "more", turn, gripped, "assume gripped: always grip");
    changed(at, "less", turn, gripped, "");
    let verdicts = |new: &str| {
        let output = linewright(at, &["refine", "old", new, "--format", "json"]);
        let document = document(&output);
        let contracts = document["contracts"]
            .as_array()
            .cloned()
            .unwrap_or_default();
        let of = contracts
            .into_iter()
            .find(|c| c["name"] == "Turn")
            .expect("Turn");
        (
            output.status.code(),
            of["verdict"].clone(),
            of["open"][0].clone(),
        )
    };
    // More is assumed: a user of the old one may violate it.
    let (code, verdict, open) = verdicts("more");
    assert_eq!((code, verdict), (Some(1), "broken".into()));
    assert_eq!(open["name"], "gripped");
    assert_eq!(open["counterexample"]["kind"], "trace");
    // Less is assumed: that is allowed.
    let (code, verdict, _) = verdicts("less");
    assert_eq!((code, verdict), (Some(0), "refined".into()));
    let (code, verdict, _) = verdicts("old");
    assert_eq!((code, verdict), (Some(0), "same".into()));
    // A removed contract is reported. No machine of the library uses this one.
    fs::remove_file(at.join("less/separating/grind.lw")).expect("a file");
    let output = linewright(at, &["refine", "old", "less"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("removed"), "{output:?}");
}

#[test]
fn operands_that_are_none_are_refused() {
    for (arguments, why) in [
        (vec!["compose", "nowhere.lw"], "nowhere.lw"),
        (
            vec!["compose", "examples/fit-together/safe.lw"],
            "declares several contracts: write `examples/fit-together/safe.lw::NAME`, where NAME is one of Feeder, Gripper",
        ),
        (
            vec!["compose", "examples/fit-together/safe.lw::Nobody"],
            "has no contract `Nobody`",
        ),
        (
            vec!["refine", "compose(a.lw)", "b.lw"],
            "at least two contracts",
        ),
    ] {
        let output = at_root(&arguments);
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {shown}");
        assert!(shown.contains(why), "{arguments:?}: {shown}");
    }
}

/// A safety guarantee that is broken first does not hold because of a justice assumption that can
/// no longer be kept afterwards.
#[test]
fn a_composition_keeps_safety_step_by_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let contracts = "
        contract W {
            input x: bool
            output y, z: bool
            assume always (z -> next not x)
            assume always eventually x
            guarantee quiet: always not z
        }
        moore contract P {
            input z: bool
            output y: bool
            guarantee always y
        }
        contract Q {
            input x, y: bool
            output z: bool
            guarantee always z
        }";
    fs::write(folder.path().join("w.lw"), contracts).expect("a file");
    let output = linewright(
        folder.path(),
        &["refine", "w.lw::W", "compose(w.lw::P, w.lw::Q)"],
    );
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("P ⊗ Q does not refine `W`"));

    // The same for a machine and its controllers.
    let machine = format!(
        "{contracts}
        machine M {{
            signal x: bool = true
            signal y: bool = true
            action q: Q {{ x = x  y = y }}
            refines W {{ x = x  y = y  z = q.z }}
        }}"
    );
    fs::write(folder.path().join("m.lw"), machine).expect("a file");
    let output = linewright(folder.path(), &["check", "m.lw"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let said = String::from_utf8_lossy(&output.stderr).into_owned() + &text(&output);
    assert!(said.contains("`quiet` of `W` is not kept"), "{said}");
}
