//! From a mock to a verified profile, using only the program: build the probe, run its SimTalk in
//! the mock, read the dump, confirm.

use super::mocks::{Mock, mocks, run};
use super::simtalk::{Expression, Statement, methods};
use crate::support;
use linewright::source::FileId;
use linewright::station::profile::{Layout, Profile, read};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The library and the SimTalk of a probe.
pub struct Probe {
    pub library: PathBuf,
    pub text: String,
}

/// Builds the probe with the program.
pub fn build(folder: &Path, profile: Option<&str>) -> Probe {
    let mut arguments = vec!["build", "--probe", "--out", "probe"];
    arguments.extend(profile.iter().flat_map(|p| ["--profile", p]));
    let output = support::linewright(folder, &arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let printed = String::from_utf8(output.stdout).expect("paths");
    let files: Vec<PathBuf> = printed.lines().map(|l| folder.join(l)).collect();
    let text = files
        .iter()
        .find(|f| f.to_string_lossy().ends_with(".simtalk.txt"));
    Probe {
        library: files[0].clone(),
        text: std::fs::read_to_string(text.expect("a SimTalk text")).expect("a text"),
    }
}

/// The calls of a probe's SimTalk as C for the mock, including those that the user may uncomment.
pub fn as_c(text: &str) -> String {
    let optional = |line: &str| {
        let line = line.replace("-- callLibrary", "callLibrary");
        line.replace("-- var duration", "var duration") + "\n"
    };
    let text: String = text.lines().map(optional).collect();
    let methods = methods(&text);
    let [method] = methods.as_slice() else {
        panic!("the probe is one method")
    };
    let [Statement::Assign(probe, load), Statement::If(_, _, calls)] = method.body.as_slice()
    else {
        panic!(
            "the method loads the library, and calls it if that went well: {:?}",
            method.body
        )
    };
    assert!(matches!(load, Expression::Call(name, _) if name == "loadLibrary"));
    let mut out = String::new();
    for statement in calls {
        match statement {
            Statement::Assign(name, Expression::Number(n)) => {
                let _ = writeln!(out, "variable v_{name} = duration({n});");
            }
            Statement::Assign(name, value) => {
                let _ = writeln!(out, "variable v_{name} = {};", call(probe, value));
            }
            Statement::Do(Expression::Call(name, _)) if name == "freeLibrary" => {}
            Statement::Do(value) => {
                let _ = writeln!(out, "(void){};", call(probe, value));
            }
            other => panic!("unexpected: {other:?}"),
        }
    }
    out
}

fn call(probe: &str, expression: &Expression) -> String {
    let Expression::Call(name, arguments) = expression else {
        panic!("no call: {expression:?}")
    };
    assert_eq!(name, "callLibrary");
    assert_eq!(arguments[0], Expression::Name(probe.to_owned()));
    let Expression::Text(export) = &arguments[1] else {
        panic!("no name of an export: {arguments:?}")
    };
    let values: Vec<String> = arguments[2..]
        .iter()
        .map(|a| match a {
            Expression::Text(t) => format!("string(\"{t}\")"),
            Expression::Name(n) => format!("v_{n}"),
            Expression::Number(n) if n == "true" || n == "false" => {
                format!("truth({})", i32::from(n == "true"))
            }
            Expression::Number(n) if n.contains('.') => format!("real({n})"),
            Expression::Number(n) => format!("integer({n}LL)"),
            other => panic!("no argument: {other:?}"),
        })
        .collect();
    if values.is_empty() {
        format!("CALL_0(\"{export}\")")
    } else {
        format!("CALL(\"{export}\", {})", values.join(", "))
    }
}

/// Runs a probe's SimTalk in a mock; returns the mock's output, and the dump.
pub fn probe(mock: &Mock, probe: &Probe, folder: &Path, dump: &str) -> (String, PathBuf) {
    std::fs::write(folder.join("calls.inc"), as_c(&probe.text)).expect("a file");
    let host = mock.host("probe_host.c", folder, &[]);
    let dump = folder.join(dump);
    let (passed, printed) = run(&host, &probe.library, &[("LINEWRIGHT_PROBE_DUMP", &dump)]);
    assert!(passed, "{}: {printed}", mock.name);
    (printed, dump)
}

/// The result of `doctor --probe` for a dump.
pub fn doctor(folder: &Path, dump: &Path, out: &str) -> (String, Profile) {
    let dump = dump.display().to_string();
    let output = support::linewright(folder, &["doctor", "--probe", &dump, "--out", out]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{said}");
    let profile = std::fs::read_to_string(folder.join(out)).expect("a profile");
    let profile = read::parse(FileId(0), &profile).expect("a sound profile");
    (format!("{text}{said}"), profile)
}

/// The layout of a mock, and the profile found in two rounds.
pub fn find(mock: &Mock, first: &Probe, folder: &Path) -> (Layout, Profile, String) {
    let name = mock.name;
    let (printed, dump) = probe(mock, first, folder, &format!("{name}-1.txt"));
    let (said, profile) = doctor(folder, &dump, &format!("{name}.toml"));
    let layout = mock.layout(&printed);
    assert_eq!(profile.layout, layout, "{name}: {said}");
    assert!(!profile.is_verified(), "{name}: one round verifies nothing");
    assert!(said.contains("(unverified)"), "{said}");
    let second = build(folder, Some(&format!("{name}.toml")));
    let (_, dump) = probe(mock, &second, folder, &format!("{name}-2.txt"));
    let (said, confirmed) = doctor(folder, &dump, &format!("{name}-verified.toml"));
    assert_eq!(confirmed.layout, layout, "{name}");
    assert!(confirmed.is_verified(), "{said}");
    (layout, confirmed, said)
}

#[test]
fn every_layout_is_recovered_and_confirmed() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = build(folder.path(), None);
    let mut layouts = Vec::new();
    for mock in mocks() {
        let (layout, _, said) = find(&mock, &first, folder.path());
        println!("{}: {layout:?}\n{said}", mock.name);
        if mock.name != "cleared" {
            assert!(!layouts.contains(&layout), "{}: twice the same", mock.name);
        }
        layouts.push(layout);
    }
    assert!(layouts.len() > 6);
    for packing in [1, 4, 8] {
        assert!(layouts.iter().any(|l| l.packing == packing));
    }
    for bits in [16, 32, 64] {
        assert!(layouts.iter().any(|l| l.integer_bits == bits));
    }
    assert!(layouts.iter().any(|l| l.value < l.tag.offset));
}

/// The second round with a layout that is not the mock's: nothing is confirmed, whether the host
/// detects it or not.
#[test]
fn a_wrong_layout_is_refuted() {
    let folder = tempfile::tempdir().expect("a folder");
    let mocks = mocks();
    let mock = mocks.iter().find(|m| m.name == "packed_4").expect("a mock");
    let wrong = Profile::assumed().to_toml();
    std::fs::write(folder.path().join("wrong.toml"), wrong).expect("a file");
    let second = build(folder.path(), Some("wrong.toml"));
    std::fs::write(folder.path().join("calls.inc"), as_c(&second.text)).expect("a file");
    let host = mock.host("probe_host.c", folder.path(), &[]);
    let dump = folder.path().join("dump.txt");
    let _ = run(&host, &second.library, &[("LINEWRIGHT_PROBE_DUMP", &dump)]);
    let output = support::linewright(
        folder.path(),
        &["doctor", "--probe", "dump.txt", "--out", "verified.toml"],
    );
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("error[LW545]"), "{said}");
    assert!(!folder.path().join("verified.toml").exists());
}

/// Beside the library, unless a path is given.
#[test]
fn the_dump_lies_beside_the_library() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = build(folder.path(), None);
    std::fs::write(folder.path().join("calls.inc"), as_c(&first.text)).expect("a file");
    let host = mocks()[0].host("probe_host.c", folder.path(), &[]);
    let (passed, printed) = run(&host, &first.library, &[]);
    assert!(passed, "{printed}");
    let dump = format!("{}.dump.txt", first.library.display());
    let output = support::linewright(folder.path(), &["doctor", "--probe", &dump]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    // Without --out the profile itself is printed.
    assert!(
        text.contains("schema = \"linewright/uf-profile/1\""),
        "{text}"
    );
    // An existing file that differs is kept.
    std::fs::write(folder.path().join("mine.toml"), "mine").expect("a file");
    let output = support::linewright(
        folder.path(),
        &["doctor", "--probe", &dump, "--out", "mine.toml"],
    );
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("error[LW546]"), "{said}");
    let kept = std::fs::read_to_string(folder.path().join("mine.toml")).expect("a file");
    assert_eq!(kept, "mine");
}
