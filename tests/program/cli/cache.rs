//! Results of an unchanged contract are not computed again; nothing else about a run changes.

use super::session::{Printed, Session};
use crate::support::root;
use serde_json::Value;
use std::path::PathBuf;

/// Runs with a cache in the session's folder.
fn run(session: &Session, line: &str) -> Printed {
    let folder = session.path("cache");
    session.run_with(line, &[("LINEWRIGHT_CACHE", &folder.display().to_string())])
}

fn files(session: &Session) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(session.path("cache"));
    let mut files: Vec<PathBuf> = entries
        .map(|entries| entries.map(|e| e.expect("an entry").path()).collect())
        .unwrap_or_default();
    files.sort();
    files
}

/// For every contract whether it came from the cache.
fn cached(session: &Session, line: &str) -> Vec<bool> {
    let printed = run(session, &format!("{line} --format json --stats"));
    let document: Value = serde_json::from_str(&printed.out).expect("a document");
    let contracts = document["contracts"].as_array().expect("contracts");
    let one = |c: &Value| c["statistics"]["cached"].as_bool().expect("a truth value");
    contracts.iter().map(one).collect()
}

#[test]
fn the_second_run_prints_the_same() {
    for line in [
        "check lamp.lw warning.lw unrealizable.lw --no-timing",
        "check lamp.lw warning.lw unrealizable.lw --no-timing --format json",
        "synth lamp.lw::Light",
        "synth lamp.lw::Light --emit dot",
        "synth unrealizable.lw",
    ] {
        let session = Session::new();
        let first = run(&session, line);
        assert!(!files(&session).is_empty(), "{line}");
        let second = run(&session, line);
        let anew = session.run(line);
        assert_eq!(
            (first.code, &first.out, &first.err),
            (second.code, &second.out, &second.err)
        );
        assert_eq!(
            (first.code, &first.out, &first.err),
            (anew.code, &anew.out, &anew.err)
        );
    }
}

/// Names of the cached proofs.
fn proofs(session: &Session) -> Vec<String> {
    let names = files(session).into_iter().filter_map(|path| {
        let name = path.file_name()?.to_string_lossy().into_owned();
        name.starts_with("proof-").then_some(name)
    });
    names.collect()
}

#[test]
fn proofs_of_machines_and_lines_are_read_again() {
    let line = root().join("examples/loader/line.lw");
    let line = format!("check {} --no-timing -v", line.display());
    let session = Session::new();
    let anew = session.run(&line);
    let first = run(&session, &line);
    let stored = proofs(&session);
    assert!(stored.len() > 1, "{stored:?}");
    let second = run(&session, &line);
    assert_eq!(
        (first.code, &first.out, &first.err),
        (second.code, &second.out, &second.err)
    );
    assert_eq!((first.code, &first.out), (anew.code, &anew.out));
    assert_eq!(proofs(&session), stored);
    // Only a proof that is missing is searched for and stored anew.
    std::fs::remove_file(session.path("cache").join(&stored[0])).expect("it exists");
    run(&session, &line);
    assert_eq!(proofs(&session), stored);
    // Another limit of work is another question.
    run(&session, &format!("{line} --effort 2"));
    assert_eq!(proofs(&session).len(), 2 * stored.len());
}

#[test]
fn a_proof_that_ran_out_of_time_is_not_stored() {
    let line = root().join("examples/ice-lab/line.lw");
    let session = Session::new();
    let line = format!("check {}", line.display());
    run(&session, &format!("{line} --timeout 0.001"));
    assert_eq!(proofs(&session), [""; 0]);
}

#[test]
fn a_hit_can_be_seen() {
    let session = Session::new();
    let line = "check unrealizable.lw warning.lw";
    assert_eq!(cached(&session, line), [false, false]);
    assert_eq!(cached(&session, line), [true, true]);
    let printed = run(&session, &format!("{line} --stats"));
    assert_eq!(
        printed.out.matches("from the cache").count(),
        2,
        "{}",
        printed.out
    );
    // Everything that a verdict depends on.
    assert_eq!(
        cached(&session, &format!("{line} --kernel shared")),
        [false, false]
    );
    assert_eq!(
        cached(&session, &format!("{line} --without recycling")),
        [false, false]
    );
    assert_eq!(
        cached(&session, &format!("{line} --memory 100")),
        [false, false]
    );
    assert_eq!(
        cached(&session, &format!("{line} --no-cache")),
        [false, false]
    );
    assert_eq!(
        cached(&session, &format!("{line} --timeout 60")),
        [true, true]
    );
}

#[test]
fn a_changed_contract_is_solved_again() {
    let session = Session::new();
    let line = "check unrealizable.lw";
    assert_eq!(cached(&session, line), [false]);
    // Its place in the file does not matter.
    let text = std::fs::read_to_string(session.path("unrealizable.lw")).expect("a text");
    std::fs::write(session.path("unrealizable.lw"), format!("\n\n{text}")).expect("a file");
    assert_eq!(cached(&session, line), [true]);
    let moved = run(&session, "check unrealizable.lw --no-timing");
    assert_eq!(
        moved.out,
        session.run("check unrealizable.lw --no-timing").out
    );
    std::fs::write(
        session.path("unrealizable.lw"),
        text.replace("always (", "always (not "),
    )
    .expect("a file");
    assert_eq!(cached(&session, line), [false]);
}

/// `check` of a machine's component and `synth` need more than a verdict: an entry with less is no
/// hit.
#[test]
fn a_controller_is_there_where_it_is_needed() {
    let session = Session::new();
    assert_eq!(
        run(&session, "build lamp.lw --target source --out built").code,
        0
    );
    let first = run(&session, "check lamp.lw --no-timing");
    assert_eq!(first.out, session.run("check lamp.lw --no-timing").out);
    assert_eq!(
        run(&session, "build lamp.lw --target source --out built").code,
        0
    );
}

#[test]
fn damaged_and_deleted_entries_are_made_again() {
    let session = Session::new();
    let line = "check lamp.lw unrealizable.lw --no-timing";
    let first = run(&session, line);
    let names = files(&session);
    for (number, path) in names.iter().enumerate() {
        let bytes = std::fs::read(path).expect("a file");
        let damaged = match number % 3 {
            0 => Vec::new(),
            1 => bytes[..bytes.len() / 2].to_vec(),
            _ => bytes.iter().map(|b| b ^ 1).collect(),
        };
        std::fs::write(path, damaged).expect("a file");
    }
    let second = run(&session, line);
    assert_eq!(
        (first.code, &first.out, &first.err),
        (second.code, &second.out, &second.err)
    );
    assert!(cached(&session, "check unrealizable.lw").iter().all(|c| *c));
    std::fs::remove_dir_all(session.path("cache")).expect("deleted");
    assert_eq!(run(&session, line).out, first.out);
    assert_eq!(files(&session), names);
}

#[test]
fn runs_beside_each_other_do_not_harm() {
    let session = Session::new();
    let line = "check lamp.lw unrealizable.lw warning.lw --no-timing";
    let expected = session.run(line).out;
    std::thread::scope(|scope| {
        let runs: Vec<_> = (0..6)
            .map(|_| scope.spawn(|| run(&session, line)))
            .collect();
        for one in runs {
            assert_eq!(one.join().expect("a run").out, expected);
        }
    });
    let left = files(&session);
    let names = left
        .iter()
        .map(|p| p.file_name().unwrap_or_default().to_string_lossy());
    let is_complete = |n: &str| ["entry-", "proof-"].iter().any(|kind| n.starts_with(kind));
    assert!(names.clone().all(|n| is_complete(&n)), "{left:?}");
}

/// Problems with the cache's folder are never reported.
#[test]
fn a_place_that_cannot_be_written_is_no_matter() {
    let session = Session::new();
    let line = "check lamp.lw --no-timing";
    let expected = session.run(line);
    std::fs::write(session.path("file"), "mine").expect("a file");
    for place in ["file", "file/below", "/proc/none", "off", ""] {
        let home = session.path("home").display().to_string();
        let environment = [
            ("LINEWRIGHT_CACHE", place),
            ("HOME", &home),
            ("XDG_CACHE_HOME", ""),
        ];
        let printed = session.run_with(line, &environment);
        assert_eq!((printed.code, &printed.out), (0, &expected.out), "{place}");
        assert_eq!(printed.err, expected.err, "{place}");
    }
    // Only the last one did not name a folder.
    assert!(cfg!(not(target_os = "linux")) || session.path("home/.cache/linewright").is_dir());
}

/// The questions about the start of a file are answered by games of their own. They are not taken
/// for its previous version.
#[test]
fn a_changed_file_of_another_tool_begins_with_the_results_of_its_last_check() {
    let session = Session::new();
    let text = |goals: &str| {
        let lines = |line: fn(usize) -> String| (0..30).map(line).collect::<Vec<_>>().join("\n");
        format!(
            "[INPUT]\n{}\n[OUTPUT]\n{}\n[ENV_INIT]\n! i0\n[SYS_TRANS]\n{}\n[SYS_LIVENESS]\n{goals}",
            lines(|i| format!("i{i}")),
            lines(|i| format!("o{i}")),
            lines(|i| format!("! ^ o{i} i{i}"))
        )
    };
    let check = |goals: &str| {
        std::fs::write(session.path("copy.slugsin"), text(goals)).expect("the file is written");
        run(&session, "check --stats copy.slugsin").out
    };
    let first = check("| o0 ! o0\n");
    assert!(!first.contains("began with"), "{first}");
    let second = check("| o0 ! o0\n| o1 ! o1\n");
    assert!(
        second.contains("began with    the order and the winning region of the previous version"),
        "{second}"
    );
}

/// An examination that used up its work budget is said to be incomplete, the second time as well.
/// With a larger budget it is done again.
#[test]
fn what_was_examined_in_part_is_said_to_be() {
    let session = Session::new();
    let file = root().join("contracts/handling/branch.lw");
    let examination = |effort: &str| {
        let file = file.display();
        let line = format!("check {file} --no-timing --format json --effort {effort}");
        let document: Value = serde_json::from_str(&run(&session, &line).out).expect("a document");
        document["contracts"][0]["examination"].clone()
    };
    assert_eq!(examination("0.01"), "partial");
    assert_eq!(examination("0.01"), "partial");
    assert!(examination("1").is_null());
}
