//! `run --trace` and `--report`: files about a run.

use super::session::Session;

const LINE: &str = "line L {
    part P
    source rack: P every exponential(5 s)
    buffer queue capacity 3
    station cell { takes exponential(4 s) }
    sink out
    route P: rack -> queue -> cell -> out
    limit 50 products
}
";

fn session() -> Session {
    let session = Session::new();
    std::fs::write(session.path("l.lw"), LINE).expect("a file");
    session
}

fn text(session: &Session, name: &str) -> String {
    std::fs::read_to_string(session.path(name)).expect("a file")
}

/// With replications and with a variant, the first run of the line is logged, whatever else runs.
#[test]
fn the_first_run_is_logged() {
    let session = session();
    std::fs::write(session.path("a.csv"), "something else").expect("a file");
    for (line, name) in [
        ("run l.lw --trace a.csv", "a.csv"),
        ("run l.lw --replications 5 --trace b.csv", "b.csv"),
        ("run l.lw --what-if cell=20% --trace new/c.csv", "new/c.csv"),
    ] {
        let printed = session.run(line);
        assert_eq!(printed.code, 0, "{line}: {}", printed.err);
        assert_eq!(text(&session, name), text(&session, "a.csv"), "{line}");
    }
    let csv = text(&session, "a.csv");
    assert_eq!(csv.matches(",finished,").count(), 50);
    let other = session.run("run l.lw --seed 2 --trace e.csv");
    assert_eq!(other.code, 0, "{}", other.err);
    assert_ne!(csv, text(&session, "e.csv"));
}

/// Several files of one run, the dates of the line, and those that are asked for.
#[test]
fn dates_begin_with_the_epoch() {
    let session = session();
    let line = "run l.lw --trace a.xes --trace a.ocel.json --trace a.parquet";
    assert_eq!(session.run(line).code, 0);
    assert!(text(&session, "a.xes").contains("2026-01-05T00:00:00.000000Z"));
    assert!(text(&session, "a.ocel.json").contains("2026-01-05T00:00:00.000000Z"));
    assert!(session.path("a.parquet").exists());
    session.edit("l.lw", "part P\n", "part P\n    start 2026-11-30\n");
    assert_eq!(session.run("run l.lw --trace a.xes").code, 0);
    assert!(text(&session, "a.xes").contains("2026-11-30T00:00:00.000000Z"));
    let line = "run l.lw --trace a.xes --epoch 2027-01-01T06:30:00";
    assert_eq!(session.run(line).code, 0);
    assert!(text(&session, "a.xes").contains("2027-01-01T06:30:00.000000Z"));
    for line in [
        "run l.lw --trace a.xes --epoch tomorrow",
        "run l.lw --epoch 2027-01-01",
        "run l.lw --trace a.json",
    ] {
        assert_eq!(session.run(line).code, 2, "{line}");
    }
}

/// A file that cannot be written is an error before the run begins.
#[test]
fn a_file_that_cannot_be_written_stops_the_run() {
    let session = session();
    std::fs::write(session.path("taken"), "mine").expect("a file");
    std::fs::create_dir(session.path("folder.csv")).expect("a folder");
    for line in [
        "run l.lw --trace taken/a.csv",
        "run l.lw --trace folder.csv",
        "run l.lw --report taken/a.html",
    ] {
        let printed = session.run(line);
        assert_eq!(printed.code, 2, "{line}: {}", printed.err);
        assert!(printed.err.contains("LW504"), "{}", printed.err);
        assert!(!printed.out.contains("throughput"), "{}", printed.out);
    }
    assert_eq!(text(&session, "taken"), "mine");
}
