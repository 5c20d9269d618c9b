//! `run` with several replications: verdicts on requirements.

use super::session::Session;
use crate::support::{PROGRAM, skip};
use serde_json::Value;
use std::process::{Command, Stdio};

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
    let two = M_D_1.replace("cell { takes 0.8 s }", "cell times 2 { takes 1.6 s }");
    std::fs::write(session.path("two.lw"), two).expect("a file");
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

/// A warm-up by products ends in each replication at its own time; table and document give both,
/// and the number of threads changes nothing.
#[test]
fn a_warm_up_may_be_given_by_products() {
    let session = session();
    let run = |arguments: &str, threads: &str| {
        let mut command = session.command(&format!("run md1.lw --parts 500 {arguments}"));
        command.args(["--warm-up", "50 parts"]);
        let output = command.env("RAYON_NUM_THREADS", threads).output();
        let output = output.expect("the program starts");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    for arguments in [
        "--replications 5",
        "--replications 5 --format json --no-timing",
        "--what-if cell=10% --replications 3",
        "--batches 10",
    ] {
        let text = run(arguments, "1");
        assert_eq!(text, run(arguments, "4"), "{arguments}");
        let shown = text.contains(" (until 50 products), ") && text.contains(", not counted");
        assert_eq!(shown, !arguments.contains("json"), "{text}");
    }
    let document: Value =
        serde_json::from_str(&run("--no-timing --format json", "2")).expect("JSON");
    assert_eq!(document["warm_up_products"], 50);
    assert_eq!(document["products"], 500);
    assert!(document["warm_up_seconds"].as_f64() > Some(40.0));

    for wrong in ["0 parts", "1.5 parts", "many parts", "-5 parts"] {
        let mut command = session.command("run md1.lw --parts 500");
        let output = command.args(["--warm-up", wrong]).output();
        let output = output.expect("the program starts");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("write for example `500 parts`"), "{error}");
    }
}

/// Table, document and exit code of a run in batches; a run has either batches or replications.
#[test]
fn batches_give_intervals() {
    let session = session();
    let line = "run md1.lw --until 11000 --warm-up 1000 --batches 20";
    let table = session.run(line);
    assert_eq!(table.code, 3, "{}", table.err);
    let rows: Vec<&str> = table.out.lines().map(str::trim_start).collect();
    let head = rows
        .iter()
        .find(|row| row.starts_with("20 batches of 0:08:20, 95 %"));
    assert!(
        head.is_some_and(|head| head.ends_with("from       to lag 1")),
        "{}",
        table.out
    );
    let row = rows.iter().find(|row| row.starts_with("pace "));
    assert!(
        row.is_some_and(|row| row.starts_with("pace        undecided ")),
        "{row:?}"
    );
    assert!(
        table
            .err
            .contains(", 20 batches), and should be at least 3600"),
        "{}",
        table.err
    );
    let json = session.run(&format!("{line} --format json"));
    let document: Value = serde_json::from_str(&json.out).expect("JSON");
    assert_eq!(json.code, 3);
    let batches = &document["batches"];
    assert_eq!(
        (&batches["count"], &batches["seconds"]),
        (&20.into(), &500.0.into())
    );
    // Batches of equal length have the figure of the run as their mean.
    let (of_run, mean) = (
        &document["throughput_per_hour"],
        &batches["throughput_per_hour"]["mean"],
    );
    let difference = of_run
        .as_f64()
        .zip(mean.as_f64())
        .map(|(a, b)| (a - b).abs());
    assert!(
        difference.is_some_and(|difference| difference < 2e-6),
        "{of_run} {mean}"
    );
    assert_eq!(document["requirements"][0]["batches"], 20);
    for other in ["--replications 3", "--precision 1%", "--what-if cell=10%"] {
        let refused = session.run(&format!("{line} {other}"));
        assert_eq!(refused.code, 2);
        let option = other.split(' ').next().unwrap_or_default();
        assert!(
            refused.err.contains("'--batches <N>' cannot be used with")
                && refused.err.contains(option),
            "{}",
            refused.err
        );
    }
}

/// On a terminal, a line says how far the run is; in a pipe nothing does, and the report is the
/// same.
#[test]
fn progress_is_shown_on_a_terminal_only() {
    let session = session();
    let line = "run md1.lw --until 2000000 --no-timing --format json";
    let piped = session.run(line);
    assert!(!piped.err.contains("running"), "{}", piped.err);
    let command = format!("{PROGRAM} {line} > shown.json");
    let folder = session.path(".");
    // That of util-linux: elsewhere the command is given in another way.
    let shown = Command::new("script")
        .args(["--quiet", "--return", "--command", &command, "terminal.txt"])
        .current_dir(&folder)
        .env("LINEWRIGHT_CACHE", "off")
        .env("TERM", "xterm")
        .stdin(Stdio::null())
        .output();
    let shown = match shown {
        Ok(output) if !String::from_utf8_lossy(&output.stderr).contains("option") => output,
        Ok(_) => return skip("script", "it is not that of util-linux"),
        Err(error) => return skip("script", &error.to_string()),
    };
    assert_eq!(shown.status.code(), Some(piped.code));
    let terminal = std::fs::read(session.path("terminal.txt")).expect("what was shown");
    let terminal = String::from_utf8_lossy(&terminal);
    assert!(
        terminal.contains("running: ") && terminal.contains(" %), WIP "),
        "{terminal:?}"
    );
    let document = std::fs::read_to_string(session.path("shown.json")).expect("the report");
    assert_eq!(document, piped.out);
}

/// A station that is 10 % faster: the same as its time divided by 1.1, and the difference of the
/// lead times is far from noise although the intervals of the two overlap.
#[test]
fn a_variant_is_compared_under_the_same_seeds() {
    let session = session();
    let what_if = |change: &str| -> Value {
        let line = format!("run md1.lw --until 3000 --format json --what-if {change}");
        let printed = session.run(&line);
        assert!(printed.code != 2, "{}{}", printed.out, printed.err);
        serde_json::from_str(&printed.out).expect("JSON")
    };
    let document = what_if("cell=10%");
    assert_eq!(document["what_if"]["speeds"]["cell"], 1.1);
    assert_eq!(document["replications"]["count"], 10);
    let measures = document["what_if"]["measures"]
        .as_array()
        .expect("measures");
    let of = |name: &str| {
        measures
            .iter()
            .find(|m| m["name"] == name)
            .expect("it is there")
    };
    let lead_time = of("lead_time");
    assert_eq!(lead_time["more_than_noise"], true, "{lead_time}");
    let difference = &lead_time["difference"];
    assert!(difference["high"].as_f64() < Some(0.0), "{difference}");
    let replications = &document["replications"]["lead_time_seconds"];
    let width =
        |interval: &Value| interval["high"].as_f64().unwrap() - interval["low"].as_f64().unwrap();
    assert!(width(difference) < width(replications), "{document}");
    // 0.8 s / 1.1; and the other direction, 0.8 s / 0.9.
    let by_time = what_if("cell.takes=0.7272727272727273s");
    assert_eq!(
        by_time["what_if"]["measures"],
        document["what_if"]["measures"]
    );
    assert_eq!(
        by_time["what_if"]["set"]["cell.takes"],
        "0.7272727272727273s"
    );
    let slower = what_if("cell=-10%");
    assert_eq!(slower["what_if"]["speeds"]["cell"], 0.9);
    assert!(slower["what_if"]["measures"][1]["difference"]["low"].as_f64() > Some(0.0));
}

/// Variants with names are compared with the line one by one, in the order in which they are named.
#[test]
fn several_variants_have_names() {
    let session = session();
    let all = "--what-if slow:cell=-10% --what-if fast:cell=10% --what-if slow:cell.takes=0.75s";
    let of = |rest: &str| session.run(&format!("run md1.lw --until 1000 --replications 3 {rest}"));
    let printed = of(&format!("{all} --format json"));
    let document: Value = serde_json::from_str(&printed.out).expect("JSON");
    let variants = document["variants"].as_array().expect("variants");
    let names: Vec<&str> = variants.iter().filter_map(|v| v["name"].as_str()).collect();
    assert_eq!(names, ["slow", "fast"]);
    assert_eq!(document["what_if"], variants[0]);
    assert_eq!(variants[0]["speeds"]["cell"], 0.9);
    assert_eq!(variants[0]["set"]["cell.takes"], "0.75s");
    // Each is the same as if it were the only one.
    let alone = of("--what-if cell=10% --format json");
    let alone: Value = serde_json::from_str(&alone.out).expect("JSON");
    assert_eq!(variants[1]["measures"], alone["what_if"]["measures"]);
    assert!(alone["variants"].is_null() && alone["what_if"]["name"].is_null());
    let text = of(all).out;
    let slow = text.find("  variant      slow\n").expect("a variant");
    let fast = text.find("  variant      fast\n").expect("a variant");
    assert!(slow < fast, "{text}");
    assert_eq!(text.matches("same seeds, 3 pairs").count(), 2, "{text}");
    for wrong in ["--what-if :cell=10%", "--what-if fast:=10%"] {
        let refused = of(wrong);
        assert_eq!(refused.code, 1, "{wrong}");
        assert!(
            refused
                .err
                .contains("write the name of a variant, `:` and a number"),
            "{}",
            refused.err
        );
    }
    let unknown = of("--what-if fast:cel.takes=1s");
    assert!(
        unknown.err.contains("did you mean `cell.takes`"),
        "{}",
        unknown.err
    );
}

/// What does not change anything has differences of 0, and mistakes are answered.
#[test]
fn variants_in_words() {
    let session = session();
    let same = session.run("run md1.lw --until 1000 --replications 3 --what-if cell=0%");
    let text = &same.out;
    assert!(
        text.contains("what if      cell works 0 % faster (its times are divided by 1)"),
        "{text}"
    );
    assert!(text.contains("same seeds, 3 pairs"), "{text}");
    let mut rows = text.lines().filter(|l| l.contains("mean lead time in s "));
    let row: Vec<&str> = rows
        .next_back()
        .expect("a row")
        .split_whitespace()
        .collect();
    assert_eq!(row[row.len() - 4..], ["0.000", "0.000", "0.000", "no"]);
    let refused = session.run("run md1.lw --until 1000 --what-if cell=-100%");
    assert_eq!(refused.code, 1);
    assert!(
        refused
            .err
            .contains("by how many percent the station is faster")
            && refused.err.contains("--> --what-if cell:1:6"),
        "{}",
        refused.err
    );
    // All mistakes are found at once, before anything runs.
    let queue = session
        .run("run md1.lw --until 1e9 --what-if queue=10% --what-if cell=1 --what-if cell=2%");
    assert_eq!(
        queue.err.matches("error[LW105]").count(),
        2,
        "{}",
        queue.err
    );
    assert!(
        queue
            .err
            .contains("`queue` is no station, so it does not work faster"),
        "{}",
        queue.err
    );
    let single = session.run("run md1.lw --until 1000 --replications 1 --what-if cell=5%");
    assert_eq!(single.code, 2);
    assert!(
        single.err.contains("at least 2 replications"),
        "{}",
        single.err
    );
    let unknown = session.run("run md1.lw --until 1000 --what-if cel.takes=1s");
    assert!(
        unknown.err.contains("did you mean `cell.takes`")
            && unknown.err.contains("--> --what-if cel.takes:1:1"),
        "{}",
        unknown.err
    );
    for twice in [
        "cell=10% --what-if cell=20%",
        "cell.takes=1s --what-if cell.takes=2s",
    ] {
        let line = format!("run md1.lw --until 1000 --replications 2 --what-if {twice}");
        let refused = session.run(&line);
        assert_eq!(refused.code, 1, "{}", refused.err);
        assert!(
            refused.err.contains("error[LW102]: `cell") && refused.err.contains("is set twice"),
            "{}",
            refused.err
        );
    }
    for option in ["--set cell[2].takes=1s", "--what-if cell[2]=10%"] {
        let copy = session.run(&format!("run md1.lw --until 1000 {option}"));
        assert!(
            copy.err.contains("`L` has no station `cell[2]`")
                && copy
                    .err
                    .contains("`cell` is a single station; `cell.times=2` makes two of it"),
            "{}",
            copy.err
        );
    }
    let two = session.run("run two.lw --until 1000 --set cell[2].takes=1s");
    assert!(
        two.err.contains("`cell[2]` has no numbers of its own")
            && two.err.contains("set together: `cell.times`, `cell.takes`"),
        "{}",
        two.err
    );
    let third = session.run("run two.lw --until 1000 --what-if cell[3]=10%");
    assert!(
        third
            .err
            .contains("its stations are `cell[1]` to `cell[2]`"),
        "{}",
        third.err
    );
    let number = session.run("run md1.lw --until 1000 --what-if cell=15");
    assert_eq!(number.code, 1);
    assert!(
        number
            .err
            .contains("write `cell=15%` if the station is to be 15 % faster"),
        "{}",
        number.err
    );
    // The line uses no energy.
    let compared = text.split("same seeds, 3 pairs").nth(1);
    assert!(
        compared.is_some_and(|table| !table.contains("energy")),
        "{text}"
    );
}

/// The interval of every measure is in the document, and with `-v` in the table.
#[test]
fn every_measure_has_an_interval() {
    let session = session();
    let station = "takes 0.8 s power 10 W idle power 1 W";
    let text = M_D_1.replace("takes 0.8 s", station);
    std::fs::write(session.path("energy.lw"), text).expect("a file");
    for (way, extra) in [("--replications 4", 0), ("--batches 10 --warm-up 100", 1)] {
        let line = format!("run energy.lw --until 2100 {way}");
        let json = session.run(&format!("{line} --format json"));
        let document: Value = serde_json::from_str(&json.out).expect("JSON");
        let part = ["replications", "batches"][extra];
        let measures = document[part]["measures"].as_array().expect("measures");
        let row = |name: &str, place: Value, state: Value, has_cause: bool| {
            let found = measures.iter().find(|row| {
                (row["name"] == name && row["place"] == place && row["state"] == state)
                    && row["cause"].is_object() == has_cause
            });
            let found = found.unwrap_or_else(|| panic!("no {name} of {place} in {measures:?}"));
            let value = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{found}"));
            assert!(value("low") <= value("mean") && value("mean") <= value("high"));
            value("mean")
        };
        row("throughput", Value::Null, Value::Null, false);
        row("lead_time_median", Value::Null, Value::Null, false);
        row("wait", "queue".into(), Value::Null, false);
        row("oee", "cell".into(), Value::Null, false);
        let starved = row("starved", "cell".into(), Value::Null, false);
        let by_rack = row("starved", "cell".into(), Value::Null, true);
        assert!((starved - by_rack).abs() < 1e-6, "{starved} {by_rack}");
        let all = row("energy", "cell".into(), Value::Null, false);
        let busy = row("energy", "cell".into(), "busy".into(), false);
        let idle = row("energy", "cell".into(), "starved".into(), false);
        assert!((all - busy - idle).abs() < 1e-9, "{all} {busy} {idle}");

        let table = session.run(&format!("{line} -v"));
        for text in [
            "Wh by state",
            "all measures, 95 %",
            "starved share of cell, by rack",
            "energy in Wh of cell, busy",
            "energy per product in J",
        ] {
            assert!(table.out.contains(text), "{text}: {}", table.out);
        }
    }
    let json = session.run("run energy.lw --until 2100 --format json");
    let document: Value = serde_json::from_str(&json.out).expect("JSON");
    let (all, products) = (&document["energy_kwh"], &document["products"]);
    let each = all.as_f64().unwrap_or(0.0) / products.as_f64().unwrap_or(1.0);
    let shown = document["energy_per_product_kwh"].as_f64().expect("energy");
    assert!(
        (shown - each).abs() < 1e-11 && shown > 1e-6,
        "{shown} {each}"
    );
    let over_time = &document["wip"]["over_time"];
    assert_eq!(over_time["bin_seconds"], 10.0);
    assert_eq!(over_time["means"].as_array().map(Vec::len), Some(210));
}

/// Runs that end before their warm-up are one finding with the seeds: a warning if other runs
/// counted something, an error if none did. The table has the range of the warm-ups.
#[test]
fn short_runs_are_one_finding() {
    let session = session();
    let run = |until: &str| {
        let mut command = session.command(&format!("run md1.lw --replications 8 --until {until}"));
        command.args(["--warm-up", "100 parts"]);
        let output = command.output().expect("the program runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr),
        )
    };
    let (code, table, findings) = run("100");
    assert_eq!(findings.matches("LW404").count(), 1, "{findings}");
    assert!(findings.contains("warning[LW404]"), "{findings}");
    assert!(
        findings.contains(" of 8 runs ended like this, also with seed"),
        "{findings}"
    );
    assert!(
        table.contains("(until 100 products), in all runs 0:01:"),
        "{table}"
    );
    assert_ne!(code, Some(0));
    let (code, _, findings) = run("50");
    assert_eq!(findings.matches("LW404").count(), 1, "{findings}");
    assert!(findings.contains("error[LW404]"), "{findings}");
    assert!(
        findings.contains("8 of 8 runs ended like this"),
        "{findings}"
    );
    assert_eq!(code, Some(2));
}
