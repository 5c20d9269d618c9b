//! `run` with several replications: verdicts on requirements.

use super::session::Session;
use serde_json::Value;

/// M/D/1 with one arrival a second: 3600 parts an hour are neither reached nor missed.
const M_D_1: &str = "line L {
    part P
    source rack: P every random 1 s
    buffer queue capacity 1000
    station cell { takes 0.8 s }
    sink out
    route P: rack -> queue -> cell -> out
    requirement pace: throughput >= 3600 per hour
}
";

fn session() -> Session {
    let session = Session::new();
    std::fs::write(session.path("md1.lw"), M_D_1).expect("a file");
    session
}

/// Table, document, findings and exit code agree.
#[test]
fn near_the_bound_nothing_is_decided() {
    let session = session();
    let line = "run md1.lw --until 20000 --replications 6";
    let table = session.run(line);
    assert_eq!(table.code, 3, "{}", table.err);
    let row = table
        .out
        .lines()
        .find(|l| l.trim_start().starts_with("pace"));
    let row = row.expect("a row");
    assert!(
        row.contains(" undecided throughput per hour >= 3600 "),
        "{row}"
    );
    let finding =
        "warning[LW406]: the requirement pace is undecided: the throughput in products an hour is ";
    assert!(table.err.contains(finding), "{}", table.err);

    let json = session.run(&format!("{line} --format json"));
    assert_eq!(json.code, 3);
    let document: Value = serde_json::from_str(&json.out).expect("JSON");
    let pace = &document["requirements"][0];
    assert_eq!(pace["verdict"], "undecided");
    assert_eq!(pace["holds"], false);
    let (low, high) = (pace["low"].as_f64(), pace["high"].as_f64());
    assert!(low < Some(3600.0) && Some(3600.0) < high, "{pace}");
    let findings = document["findings"].as_array().expect("findings");
    let codes: Vec<_> = findings.iter().map(|f| &f["code"]).collect();
    assert_eq!(codes, ["LW406"]);
    let help = findings[0]["help"].as_str().expect("help");
    match pace["more_replications"].as_u64() {
        Some(more) => assert!(
            help.contains(&format!("`--replications {}`", 6 + more)),
            "{help}"
        ),
        None => assert!(
            help.contains("10000 replications would not decide it"),
            "{help}"
        ),
    }
}
