//! Tables of times: where they are read from, and that a change of one is noticed.

use super::session::{Printed, Session};
use crate::support::linewright;
use serde_json::Value;

const LINE: &str = r#"line Filling {
    part Bottle
    source infeed: Bottle at "data/orders.csv" column due in min
    buffer waiting capacity 100
    station filler {
        takes empirical("data/times.csv" column seconds in s)
    }
    sink box
    route Bottle: infeed -> waiting -> filler -> box
}
"#;

/// A session with a line in a folder, and its tables in a folder below.
fn session() -> Session {
    let session = Session::new();
    std::fs::create_dir_all(session.path("plant/data")).expect("a folder");
    for (name, text) in [
        ("plant/filling.lw", LINE),
        ("plant/data/orders.csv", "due\n0\n2\n5\n"),
        ("plant/data/times.csv", "seconds,slow\n30,3\n30,3\n"),
    ] {
        std::fs::write(session.path(name), text).expect("a file");
    }
    session
}

/// The makespan of a run in seconds, and the whole document.
fn run(session: &Session, more: &[&str]) -> (f64, Value) {
    let folder = session.path("cache").display().to_string();
    let mut command = session.command("run plant/filling.lw --parts 3 --format json --no-timing");
    let output = command.args(more).env("LINEWRIGHT_CACHE", folder).output();
    let output = output.expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let document: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    let makespan = document["makespan_seconds"].as_f64();
    (makespan.unwrap_or_else(|| panic!("{text}")), document)
}

#[test]
fn a_run_reads_a_changed_table() {
    let session = session();
    let (first, document) = run(&session, &[]);
    assert!((first - 330.0).abs() < 1e-9, "{first}");
    assert_eq!(run(&session, &[]).1, document);
    session.edit("plant/data/times.csv", "30,3", "60,3");
    assert!((run(&session, &[]).0 - 360.0).abs() < 1e-9);
    session.edit("plant/data/orders.csv", "5", "7.5");
    assert!((run(&session, &[]).0 - 510.0).abs() < 1e-9);
}

/// A number that is set elsewhere changes nothing; a column that is set is found from the line's
/// file, wherever the command runs.
#[test]
fn settings_and_tables_go_together() {
    let session = session();
    let (_, mut plain) = run(&session, &[]);
    let (_, mut set) = run(&session, &["--set", "waiting.capacity=100"]);
    for document in [&mut plain, &mut set] {
        let fields = document.as_object_mut().expect("an object");
        fields.remove("set");
    }
    assert_eq!(plain, set);
    let slow = "filler.takes=empirical(\"data/times.csv\" column slow in min)";
    let (makespan, document) = run(&session, &["--set", slow]);
    assert!((makespan - 540.0).abs() < 1e-9, "{makespan}");
    assert_eq!(
        document["set"]["filler.takes"],
        "empirical(\"data/times.csv\" column slow in min)"
    );
}

fn refused(printed: &Printed, wanted: &[&str]) {
    assert_eq!(printed.code, 1);
    let all = format!("{}{}", printed.out, printed.err);
    for wanted in wanted {
        assert!(all.contains(wanted), "{wanted}: {all}");
    }
}

#[test]
fn tables_that_cannot_be_read_are_reported() {
    let session = session();
    std::fs::write(session.path("plant/data/times.csv"), b"seconds\n\xff\n").expect("a file");
    std::fs::remove_file(session.path("plant/data/orders.csv")).expect("it was there");
    std::fs::create_dir(session.path("plant/data/orders.csv")).expect("a folder");
    refused(
        &session.run("check plant"),
        &[
            "cannot read the table `data/orders.csv`: it is a folder",
            "cannot read the table `data/times.csv`: it is not a UTF-8 text file",
            "plant/filling.lw:3:30",
        ],
    );
}

/// A file of the library finds its tables in the library.
#[test]
fn a_library_has_tables_of_its_own() {
    let session = session();
    let folder = session.path("own");
    std::fs::create_dir(&folder).expect("a folder");
    let text = LINE.replace("data/", "");
    std::fs::write(folder.join("filling.lw"), text).expect("a file");
    for name in ["orders.csv", "times.csv"] {
        std::fs::copy(session.path("plant/data").join(name), folder.join(name)).expect("a copy");
    }
    std::fs::write(session.path("main.lw"), "import std.filling\n").expect("a file");
    let arguments = ["check", "main.lw", "--library", "own", "--no-timing"];
    let output = linewright(session.folder(), &arguments);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("infeed continues beyond the 3 rows of its table"),
        "{text}"
    );
    std::fs::remove_file(folder.join("times.csv")).expect("it was there");
    let output = linewright(session.folder(), &arguments);
    assert!(!output.status.success());
}
