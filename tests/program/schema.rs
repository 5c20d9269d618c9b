//! The schemas of JSON documents: each document is as its schema says, and nothing else is.
//! Wherever tests run the program by `support::linewright` or a `Session`, what it prints is
//! compared with its schema too.

use super::support::files_below;
use crate::support::documents::{assert_files_valid, assert_valid, faults, faults_by};
use crate::support::{PROGRAM, linewright, root, sandbox};
use clap::CommandFactory as _;
use linewright::cli::{Arguments, schema};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Commands that write documents, in a folder with copies of `contracts`, `examples` and, in
/// `cases`, of `tests/cases`. One that fails writes why.
const COMMANDS: &[&str] = &[
    "check --stats contracts examples/repair-me examples/transfer examples/loader",
    "check --no-timing examples/fit-together examples/pick-and-place",
    "check --stats contracts/handling/turn.lw --proof turn.proof.json",
    "check examples/other-tools/arbiter.spc examples/other-tools/arbiter.slugsin",
    "check examples/other-tools/arbiter.spectra examples/other-tools/arbiter.tlsf",
    "check examples/other-tools/arbiter.structuredslugs cases/interchange/formulas.spc",
    "check cases/cli cases/line cases/resolve/types.lw cases/resolve/names.lw --timeout 3",
    "check cases/machine cases/resolve/skills.lw --timeout 20",
    "check --timeout 0 contracts/handling/turn.lw",
    "check nowhere.lw",
    "synth contracts/handling/turn.lw --emit json",
    "synth contracts/handling/turn.lw --emit json --out controllers",
    "synth --counterstrategy examples/repair-me/1-clash.lw",
    "synth examples/repair-me/1-clash.lw",
    "draw contracts/handling/turn.lw::Turn --out contracts/handling/turn.lw",
    "import examples/other-tools/arbiter.spc --out examples/other-tools/arbiter.spc",
    "import cases/cli/nowhere.spc",
    "build examples/loader/line.lw --out built",
    "build examples/loader/line.lw --target source --target fmu --out built",
    "build examples/loader/line.lw --profile examples/loader/line.lw",
    "run examples/loader/line.lw --parts 5 --out built",
    "run examples/loader/line.lw --until 1h --no-timing --out built",
    "run examples/loader/line.lw --until 1h --replications 3 --out built",
    "run examples/loader/line.lw --until 4h --batches 10 --out built",
    "run examples/loader/line.lw --until 1h --replications 2 --what-if fast:loader=10% --what-if slow:loader=-10% --out built",
    "run examples/transfer/cell.lw --parts 2 --out built",
    "run cases/line/blocked.lw --parts 2 --out built",
    "run cases/cli/type.lw",
    "step contracts/handling/turn.lw --script examples/step/turn.txt",
    "step examples/repair-me/1-clash.lw --script moves.txt",
    "step cases/cli/type.lw --script examples/step/turn.txt",
    "fmt --check cases/cli",
    "fmt examples/loader",
    "compose examples/fit-together/safe.lw::Feeder examples/fit-together/safe.lw::Gripper",
    "compose examples/fit-together/circle.lw::Feeder examples/fit-together/circle.lw::Gripper",
    "compose examples/fit-together/loop.lw::Lamp examples/fit-together/loop.lw::Door",
    "compose cases/cli/type.lw cases/cli/lamp.lw",
    "refine contracts contracts",
    "refine contracts examples",
    "refine std.handling.turn std.handling.turn",
    "refine examples/repair-me/fixed/1-clash.lw examples/repair-me/1-clash.lw",
    "refine two.lw::Strong two.lw::Weak",
    "refine two.lw::Weak two.lw::Strong",
    "compat two.lw::Weak two.lw::Strong",
    "compat two.lw::Weak",
    "compat nobody.lw",
    "conjoin two.lw::Weak two.lw::Strong",
    "quotient two.lw::Weak two.lw::Strong",
    "merge two.lw::Weak two.lw::Strong",
    "conjoin cases/cli/type.lw two.lw::Weak",
    "quotient cases/cli/type.lw two.lw::Weak",
    "merge cases/cli/type.lw two.lw::Weak",
    "explain LW203",
    "explain --list",
    "order check examples/pick-and-place/crash.txt examples/pick-and-place/intended.txt",
    "order check --whole program.txt --rules examples/pick-and-place/unit.lw",
    "order check nothing.txt --rules cases/cli/type.lw",
    "order check nothing.txt nonsense.txt --rules examples/pick-and-place/unit.lw",
    "order complete examples/pick-and-place/unit.lw Right Down",
    "order complete examples/pick-and-place/unit.lw Right Down Left --at-once 2",
    "order fsm examples/pick-and-place/unit.lw",
    "order fsm examples/pick-and-place/unit.lw --by-component",
    "order fsm examples/pick-and-place/unit.lw --out examples/pick-and-place/unit.lw",
    "order regex examples/pick-and-place/unit.lw --whole --rule trays",
    "order diff examples/pick-and-place/unit.lw examples/pick-and-place/unit.lw",
    "order diff examples/pick-and-place/unit.lw examples/pick-and-place/unit.lw --other-level reasonable",
    "order strongest examples/pick-and-place/unit.lw",
    "order strongest examples/pick-and-place/unit.lw --longest 1 --useful left",
    "order monitor cases/cli/type.lw",
    "check examples/pad cases/recipe",
    "recipe plan examples/pad/parallel.lw",
    "recipe plan examples/pad/hinge.lw --set r3.holds=0",
    "recipe plan examples/pad/times.lw --least time",
    "recipe plan two-hinges.lw --least energy",
    "recipe topology examples/pad/hinge.lw",
    "recipe topology examples/pad/hinge.lw --max-states 10",
    "recipe run examples/pad/times.lw",
    "recipe run examples/pad/hinge.lw --execution lockstep",
    "recipe run examples/pad/hinge.lw --execution lockstep --coordinator controller",
    "recipe run examples/cell/cell.lw --test measured=finished",
    "recipe diff examples/pad/parallel.lw Pad Six",
    "recipe repair examples/pad/missing-route.lw --only routes",
    "recipe repair cases/cli/type.lw",
    "din show din:3.2.1",
    "din search drehen",
    "din tree",
    "din coverage contracts",
    "din coverage cases/cli",
    "doctor",
    "doctor --profile examples/loader/line.lw",
    "doctor --probe examples/plant-simulation/mock.dump.txt --out found.toml",
    "doctor --probe examples/loader/line.lw",
    "schema",
];

/// Contracts that refine each other or do not, and one for which no environment fits.
const FILES: &[(&str, &str)] = &[
    (
        "two-hinges.lw",
        "import \"examples/pad/times.lw\"\n\nrealize 2 Hinge on Timed\n",
    ),
    (
        "two.lw",
        "contract Strong {\n  input go: bool\n  output lit: bool\n  guarantee follows: always (lit <-> go)\n}\n\n\
         contract Weak {\n  input go: bool\n  output lit: bool\n  assume calm: always eventually go\n  \
         guarantee sometimes: always (go -> lit)\n}\n",
    ),
    (
        "nobody.lw",
        "contract Nobody {\n  input go: bool\n  output lit: bool\n  assume both: always (go and not go)\n  \
         guarantee dark: always not lit\n}\n",
    ),
    ("moves.txt", "moves\nstate\nrandom 3\nwhy\nundo\n"),
    ("program.txt", "Right\n"),
    ("nonsense.txt", "Sideways\n"),
];

/// Fields whose objects have names of the user as keys.
const BY_NAME: [&str; 10] = [
    "cubes",
    "machine",
    "next",
    "output",
    "plant",
    "set",
    "situation",
    "speeds",
    "steps",
    "units",
];

/// Every document that those commands write.
fn written() -> Vec<Value> {
    let folder = sandbox();
    let folder = folder.path();
    copy(&root().join("tests/cases"), &folder.join("cases"));
    for (name, text) in FILES {
        std::fs::write(folder.join(name), text).expect("a file");
    }
    let mut documents = Vec::new();
    for command in COMMANDS {
        let mut words: Vec<&str> = command.split(' ').collect();
        words.extend(["--format", "json"]);
        let output = linewright(folder, &words);
        let said = String::from_utf8_lossy(&output.stderr);
        let code = output.status.code();
        assert!(code.is_some_and(|c| c < 4), "{command}: {code:?}: {said}");
        let printed = assert_valid(&output.stdout);
        let into_a_file = command.contains("synth") && command.contains("--out");
        assert_eq!(printed.is_empty(), into_a_file, "{command}: {said}");
        documents.extend(printed);
    }
    documents.extend(assert_files_valid(folder));
    documents
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), to).expect("a copy");
        }
    }
}

#[test]
fn every_document_is_as_its_schema_says_and_with_another_field_it_is_not() {
    let documents = written();
    let id = |d: &Value| d["schema"].as_str().unwrap_or_default().to_owned();
    let seen: BTreeSet<String> = documents.iter().map(id).collect();
    let missing: Vec<String> = schema::all()
        .iter()
        .map(schema::Described::id)
        .filter(|id| !seen.contains(id))
        .collect();
    // Of these, tests of their own say more; or only a fault of the program writes them; or the
    // test of station libraries compares them.
    let elsewhere = [
        "linewright/completions/1",
        "linewright/functions/1",
        "linewright/log/1",
        "linewright/order/1",
        "linewright/recipe/1",
        "linewright/station/1",
        "linewright/uf-profile/1",
    ];
    assert_eq!(missing, elsewhere);
    for document in &documents {
        for renamed in renamed(document) {
            assert!(
                !faults_by(&id(document), &renamed).is_empty(),
                "{renamed:#}"
            );
        }
    }
}

/// The document with each of its fields renamed; of a list only in its first entry.
fn renamed(document: &Value) -> Vec<Value> {
    match document {
        Value::Object(fields) => {
            let mut all = Vec::new();
            for (name, value) in fields {
                let with = |key: &str, value: Value| {
                    let pairs = fields.iter().map(|(k, v)| {
                        if k == name {
                            (key.to_owned(), value.clone())
                        } else {
                            (k.clone(), v.clone())
                        }
                    });
                    Value::Object(pairs.collect::<Map<String, Value>>())
                };
                all.push(with(&format!("{name}_"), value.clone()));
                if !BY_NAME.contains(&name.as_str()) {
                    let inner = renamed(value).into_iter();
                    all.extend(inner.map(|value| with(name, value)));
                }
            }
            all
        }
        Value::Array(items) => {
            let first = items.first().map(renamed).unwrap_or_default();
            let with = |item: Value| {
                let mut items = items.clone();
                items[0] = item;
                Value::Array(items)
            };
            first.into_iter().map(with).collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn every_name_in_the_sources_and_every_command_has_a_schema() {
    let mut names: BTreeSet<String> = Arguments::command()
        .get_subcommands()
        .map(|c| c.get_name().to_owned())
        .collect();
    for folder in ["src", "crates"] {
        for path in files_below(&root().join(folder), &["rs", "c", "h", "md", "toml"]) {
            let text = std::fs::read_to_string(&path).expect("sources can be read");
            for (start, end) in [
                ("linewright/", "/1"),
                ("schema(\"", "\")"),
                ("Head::of(\"", "\""),
                ("failed(\"", "\""),
            ] {
                let found = text.split(start).skip(1);
                let found = found.filter_map(|after| after.split_once(end));
                let is_name = |name: &str| {
                    let mut letters = name.chars();
                    !name.is_empty() && letters.all(|c| c.is_ascii_lowercase() || c == '-')
                };
                names.extend(
                    found
                        .map(|(name, _)| name.to_owned())
                        .filter(|n| is_name(n)),
                );
            }
        }
    }
    for expected in ["check", "library", "order-regex", "uf-profile"] {
        assert!(names.contains(expected), "{expected} among {names:?}");
    }
    let unknown: Vec<&String> = names.iter().filter(|n| schema::find(n).is_none()).collect();
    assert!(unknown.is_empty(), "without a schema: {unknown:?}");
}

/// The schemas themselves are as draft 2020-12 says.
#[test]
fn every_schema_is_one() {
    for document in schema::all() {
        let schema = document.schema();
        let fault = jsonschema::draft202012::meta::validate(&schema).err();
        assert!(fault.is_none(), "{}: {fault:?}", document.name);
        assert_eq!(schema["title"], document.id());
        assert_eq!(
            schema["$schema"],
            "https://json-schema.org/draft/2020-12/schema"
        );
    }
}

fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = linewright(root(), arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

#[test]
fn the_command_lists_and_prints_schemas() {
    let (code, list, said) = run(&["schema"]);
    assert_eq!((code, said.as_str()), (Some(0), ""));
    for document in schema::all() {
        let mut lines = list.lines();
        let line = lines.find(|l| l.split(' ').next() == Some(document.name));
        assert!(line.is_some_and(|l| l.ends_with(document.title)), "{list}");
    }
    assert_eq!(list.lines().count(), schema::all().len());

    let (code, text, _) = run(&["schema", "check"]);
    assert_eq!(code, Some(0));
    let printed: Value = serde_json::from_str(&text).expect("a schema");
    assert_eq!(printed, schema::find("check").expect("a schema").schema());
    for same in [
        &["schema", "linewright/check/1"][..],
        &["schema", "check", "--format", "json"],
        &["schema", "check", "--format", "short"],
    ] {
        assert_eq!(run(same).1, text, "{same:?}");
    }

    let (code, out, said) = run(&["schema", "chek"]);
    assert_eq!((code, out.as_str()), (Some(2), ""));
    assert_eq!(
        said,
        "error: there is no document `chek`: did you mean `check`? `linewright schema` lists them all\n"
    );
    let (code, _, said) = run(&["schema", "check", "--format", "sarif"]);
    assert_eq!(code, Some(2));
    assert!(
        said.contains("has no findings, so it cannot be written as SARIF"),
        "{said}"
    );
}

fn with_input(arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(PROGRAM)
        .args(arguments)
        .current_dir(root())
        .env("LINEWRIGHT_CACHE", "off")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut pipe = child.stdin.take().expect("its input");
    pipe.write_all(input.as_bytes()).expect("an input");
    drop(pipe);
    child.wait_with_output().expect("it ends")
}

/// The answers of a monitor are many and short, and do not name their schema.
#[test]
fn a_monitor_answers_as_its_schema_says() {
    let rules = "examples/pick-and-place/unit.lw";
    let output = with_input(
        &["order", "monitor", rules, "--format", "json"],
        "Right\nDown\nLeft\nSideways\n",
    );
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let answers: Vec<Value> = text
        .lines()
        .map(|l| serde_json::from_str(l).expect("an answer a line"))
        .collect();
    assert_eq!(answers.len(), 4, "{text}");
    for answer in &answers {
        let faults = faults_by("linewright/order-monitor/1", answer);
        assert!(faults.is_empty(), "{faults}{answer}");
    }
    let other = json!({"line": 1, "allowed": true, "skill": "Right"});
    assert!(!faults_by("linewright/order-monitor/1", &other).is_empty());
}

/// The layout that `doctor --probe` writes, in TOML: of each line, what comes before a comment is
/// a key and a value that JSON has too.
#[test]
fn a_profile_is_as_its_schema_says() {
    let folder = sandbox();
    let dump = "examples/plant-simulation/mock.dump.txt";
    linewright(
        folder.path(),
        &["doctor", "--probe", dump, "--out", "p.toml"],
    );
    let text = std::fs::read_to_string(folder.path().join("p.toml")).expect("a profile");
    let (mut profile, mut table) = (json!({}), None);
    for line in text.lines() {
        let line = line.split(" #").next().unwrap_or_default().trim();
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            profile[name] = json!({});
            table = Some(name.to_owned());
        } else if let Some((key, value)) = line.split_once(" = ") {
            let value: Value = serde_json::from_str(value).expect("a value");
            match &table {
                Some(table) => profile[table][key] = value,
                None => profile[key] = value,
            }
        }
    }
    assert_eq!(faults(&profile), "", "{profile:#}");
    profile["layout"]["packing"] = json!(3);
    assert_ne!(faults(&profile), "");
}

/// What only a fault of the program writes.
#[test]
fn failures_have_the_schema_of_their_command() {
    let finding = json!({"code": "LW001", "severity": "error", "message": "It failed."});
    for command in Arguments::command().get_subcommands() {
        let id = format!("linewright/{}/1", command.get_name());
        let document = json!({"schema": id, "findings": [finding]});
        assert_eq!(faults(&document), "");
        let mut other = document.clone();
        other["findings"][0]["severity"] = json!("bad");
        assert_ne!(faults(&other), "");
    }
}
