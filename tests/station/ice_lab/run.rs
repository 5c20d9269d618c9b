//! The command of the main job: 50 products, as a table and as a document.

use crate::support::{linewright, linewright_with_cache, root, sandbox};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// A folder with the controllers and the libraries of both lines, so that only the first of these
/// tests has to solve and to compile.
fn libraries() -> &'static Path {
    static FOLDER: std::sync::OnceLock<tempfile::TempDir> = std::sync::OnceLock::new();
    FOLDER
        .get_or_init(|| tempfile::tempdir().expect("a folder"))
        .path()
}

fn run(line: &str, more: &[&str]) -> Output {
    let folder = libraries().display().to_string();
    let line = format!("examples/ice-lab/{line}");
    let mut arguments = vec!["run", &line, "--out", &folder];
    arguments.extend(more);
    linewright_with_cache(&libraries().join(".cache"), root(), &arguments)
}

fn document(line: &str, more: &[&str]) -> (Value, String) {
    let mut arguments = vec!["--format", "json", "--no-timing"];
    arguments.extend(more);
    let output = run(line, &arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    let findings = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}{findings}");
    assert_eq!(findings, "");
    (serde_json::from_str(&text).unwrap(), text)
}

#[test]
fn fifty_products_as_a_table() {
    let output = run("line.lw", &["--parts", "50"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    insta::assert_snapshot!("table", String::from_utf8(output.stdout).unwrap());
}

#[test]
fn fifty_products_as_a_document() {
    let (document, text) = document("line.lw", &["--parts", "50"]);
    check_schema(&document);
    assert_eq!(document["line"], "IceLab");
    assert_eq!(document["seed"], 1);
    assert_eq!(document["products"], 50);
    assert_eq!(document["stored"], 50);
    assert_eq!(document["bottleneck"], "printer");
    assert_eq!(document["violations"], Value::Array(Vec::new()));
    let rejected = document["parts"]["rejected"].as_u64().unwrap();
    assert!(rejected >= 1, "with the default seed a brick is rejected");
    let rejects = document["rejects"].as_array().unwrap();
    let sum = |field: &str| -> u64 { rejects.iter().map(|r| r[field].as_u64().unwrap()).sum() };
    assert_eq!(sum("count"), rejected);
    assert_eq!(sum("reordered"), rejected, "each is printed again");
    for requirement in document["requirements"].as_array().unwrap() {
        assert_eq!(requirement["holds"], true, "{requirement}");
    }
    let station = |name: &str| {
        let stations = document["stations"].as_array().unwrap();
        stations.iter().find(|s| s["name"] == name).unwrap().clone()
    };
    // One brick per product, and one for each rejected product (except for those in process at the
    // end).
    let printed = station("printer")["processed"].as_u64().unwrap();
    assert!(printed >= 50 + rejected, "{printed} printed");
    assert!(station("cell")["processed"].as_u64().unwrap() >= 50);
    assert!(station("camera")["processed"].as_u64().unwrap() >= 100 + rejected);
    // Milling is loaded, idle, and shown.
    assert_eq!(station("milling")["processed"], 0);
    assert_eq!(station("milling")["idle"], 1.0);
    assert!(station("milling")["energy_kwh"].as_f64().unwrap() > 0.0);
    insta::assert_snapshot!("document", text);
}

#[test]
fn a_seed_decides_everything() {
    let (_, one) = document("line.lw", &["--parts", "50"]);
    let (_, same) = document("line.lw", &["--parts", "50", "--seed", "1"]);
    assert_eq!(one, same);
    let (other, two) = document("line.lw", &["--parts", "50", "--seed", "2"]);
    check_schema(&other);
    assert_eq!(other["products"], 50);
    let without_seed = |text: &str| text.replace("\"seed\": 1", "").replace("\"seed\": 2", "");
    assert_ne!(without_seed(&one), without_seed(&two));
    let table = |seed: &str| run("line.lw", &["--parts", "50", "--seed", seed]).stdout;
    assert_eq!(table("1"), table("1"));
    assert_ne!(table("1"), table("2"));
}

#[test]
fn wall_seconds_are_there_unless_left_out() {
    let (document, _) = document("milled.lw", &["--parts", "1"]);
    assert_eq!(document.get("wall_seconds"), None);
    let output = run("milled.lw", &["--parts", "1", "--format", "json"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(document["wall_seconds"].as_f64().unwrap() >= 0.0);
}

#[test]
fn the_milled_part_runs() {
    let (document, text) = document("milled.lw", &["--parts", "20"]);
    check_schema(&document);
    assert_eq!(document["line"], "Milled");
    assert_eq!(document["products"], 20);
    let stations = document["stations"].as_array().unwrap();
    let milling = stations.iter().find(|s| s["name"] == "milling").unwrap();
    assert!(milling["processed"].as_u64().unwrap() >= 20);
    assert!(milling["busy"].as_f64().unwrap() > 0.5);
    assert_eq!(document["violation_count"], 0);
    insta::assert_snapshot!("milled", text);
}

#[test]
fn libraries_stand_beside_the_line_unless_said_otherwise() {
    let sandbox = sandbox();
    let line = ["run", "examples/ice-lab/milled.lw", "--parts", "1"];
    let output = linewright(sandbox.path(), &line);
    assert_eq!(output.status.code(), Some(0));
    let folder = sandbox.path().join("examples/ice-lab/.linewright");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    // A library and its manifest per machine, and no partial files.
    assert_eq!(names.len(), 6, "{names:?}");
    for stem in ["belt", "milling", "quality_check"] {
        let own: Vec<_> = names.iter().filter(|n| n.starts_with(stem)).collect();
        assert_eq!(own.len(), 2, "{names:?}");
    }
}

/// Every documented field is present with its type, and the figures add up.
fn check_schema(document: &Value) {
    assert_eq!(document["schema"], "linewright/run/1");
    assert!(document["line"].is_string(), "{document}");
    for field in ["seed", "events", "products"] {
        assert!(document[field].is_u64(), "{field}: {document}");
    }
    for field in ["simulated_seconds", "throughput_per_hour", "energy_kwh"] {
        let value = document[field].as_f64();
        assert!(value.is_some_and(|v| v > 0.0), "{field}: {document}");
    }
    let part = |field: &str| {
        let value = document["parts"][field].as_u64();
        value.unwrap_or_else(|| panic!("parts.{field}: {document}"))
    };
    let gone = part("finished") + part("rejected") + part("consumed") + part("in_progress");
    assert_eq!(part("entered"), gone);
    let lead = |field: &str| document["lead_time"][field].as_f64().unwrap();
    assert!(lead("p50") <= lead("p95") && lead("p95") <= lead("max"));
    assert!(0.0 < lead("mean") && lead("mean") <= lead("max"));
    let stations = document["stations"].as_array().unwrap();
    assert!(!stations.is_empty());
    for station in stations {
        assert!(station["name"].is_string() && station["processed"].is_u64());
        assert!(station["energy_kwh"].as_f64().is_some_and(|e| e >= 0.0));
        let shares = ["busy", "starved", "blocked", "failed", "idle", "setup"].map(|share| {
            let value = station[share].as_f64();
            let value = value.unwrap_or_else(|| panic!("{share}: {station}"));
            assert!((0.0..=1.0).contains(&value), "{share}: {station}");
            value
        });
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{station}");
    }
    let sum = |list: &str| -> f64 {
        let list = document[list].as_array().unwrap();
        list.iter().map(|s| s["energy_kwh"].as_f64().unwrap()).sum()
    };
    let energy = document["energy_kwh"].as_f64().unwrap();
    assert!((sum("stations") + sum("conveyors") - energy).abs() < 1e-6);
    assert!((sum("machines") - energy).abs() < 1e-6);
    for violation in document["violations"].as_array().unwrap() {
        assert!(violation.is_object());
    }
    for requirement in document["requirements"].as_array().unwrap() {
        assert!(requirement["name"].is_string() && requirement["holds"].is_boolean());
        assert!(requirement["value"].is_number());
    }
}
