//! Cost of a controller as a function of each size of the laboratory's contracts, one parameter at
//! a time, and the total cost of the line at real size.
//!
//! Each row is one `linewright synth` as a user runs it, on a copy of the contract with another
//! default for the parameter: user and system time of the process, the peak number of BDD nodes,
//! the controller's states or decisions, and the bytes of its C compiled like the station
//! libraries. Nothing is cached between rows. Times come from the shell's `times`, as in
//! `pipeline`.
//!
//!     cargo bench --bench sizes            all rows, then the line
//!     cargo bench --bench sizes -- Turn    the rows of one contract

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A contract, its file, and the replacements of its parameters, row by row.
struct Series {
    contract: &'static str,
    file: &'static str,
    /// The parameters as in the file.
    defaults: &'static [&'static str],
    rows: &'static [&'static [u32]],
}

const SERIES: [Series; 5] = [
    Series {
        contract: "Turn",
        file: "handling/turn.lw",
        defaults: &["cells: 2..360 = 5"],
        rows: &[&[8], &[45], &[90], &[180], &[360]],
    },
    Series {
        contract: "Move",
        file: "handling/move.lw",
        defaults: &["width: 1..64 = 3", "height: 1..64 = 3"],
        rows: &[&[3, 3], &[8, 8], &[16, 16], &[32, 32], &[64, 64]],
    },
    Series {
        contract: "Print",
        file: "primary_shaping/print.lw",
        defaults: &["columns: 1..16 = 2", "height: 1..16 = 2"],
        rows: &[
            &[2, 2],
            &[4, 4],
            &[8, 2],
            &[8, 4],
            &[8, 6],
            &[8, 7],
            &[8, 8],
        ],
    },
    Series {
        contract: "Mill",
        file: "separating/mill.lw",
        defaults: &["columns: 1..16 = 2", "height: 1..16 = 2"],
        rows: &[&[2, 2], &[4, 4], &[8, 4], &[8, 8], &[16, 8]],
    },
    Series {
        contract: "Inspect",
        file: "handling/inspect.lw",
        defaults: &["cells: 1..64 = 4"],
        rows: &[&[4], &[9], &[16], &[36], &[64]],
    },
];

/// Copies a folder of contracts.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("contracts").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

/// Runs a program; returns its output and the processor time in seconds, including everything it
/// started.
fn timed(arguments: &[&str], folder: &Path) -> (String, f64) {
    let output = Command::new("sh")
        .args(["-c", r#""$@" 2>&1; times"#, "sh"])
        .args(arguments)
        .env("LINEWRIGHT_CACHE", "off")
        .current_dir(folder)
        .output()
        .expect("sh starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let last = text.lines().last().unwrap_or_default();
    let seconds = last.split_whitespace().map(|time| {
        let (minutes, rest) = time.split_once('m').expect("minutes");
        let number = |t: &str| t.parse::<f64>().expect("a number");
        number(minutes) * 60.0 + number(rest.trim_end_matches('s'))
    });
    let seconds = seconds.sum();
    (text, seconds)
}

fn row(series: &Series, sizes: &[u32]) {
    let folder = tempfile::tempdir().expect("a folder");
    let contracts = Path::new(env!("CARGO_MANIFEST_DIR")).join("contracts");
    copy(&contracts, folder.path());
    let path = folder.path().join(series.file);
    let mut text = std::fs::read_to_string(&path).expect("the contract");
    for (default, size) in series.defaults.iter().zip(sizes) {
        let (parameter, _) = default.split_once('=').expect("a default");
        assert!(text.contains(default), "{} has `{default}`", series.file);
        text = text.replace(default, &format!("{parameter}= {size}"));
    }
    std::fs::write(&path, text).expect("the contract is written");
    let program = env!("CARGO_BIN_EXE_linewright");
    let emit = ["--emit", "json", "--emit", "c", "--out", "out", "--stats"];
    let mut arguments = vec![program, "synth", series.file];
    arguments.extend(emit);
    let (said, seconds) = timed(&arguments, folder.path());
    let peak = said.lines().find_map(|l| l.trim().strip_prefix("peak"));
    let peak = peak.unwrap_or("?").trim().trim_end_matches(" nodes");
    let out = folder.path().join("out");
    let json = std::fs::read_to_string(out.join(format!("{}.json", series.contract)));
    let document: Value = serde_json::from_str(&json.expect("a controller")).expect("JSON");
    assert_eq!(document["verified"], true);
    let form = match (document["states"].as_u64(), document["nodes"].as_array()) {
        (Some(states), _) => format!("{states} states"),
        (None, decisions) => format!("{} decisions", decisions.map_or(0, Vec::len)),
    };
    let source = format!("{}.c", series.contract);
    let compile = ["cc", "-std=c99", "-O0", "-c", &source, "-o", "it.o"];
    let (said, compiling) = timed(&compile, &out);
    let object = std::fs::metadata(out.join("it.o")).unwrap_or_else(|_| panic!("{said}"));
    let sizes: Vec<String> = sizes.iter().map(u32::to_string).collect();
    println!(
        "| {} {} | {peak} | {form} | {seconds:.2} s | {compiling:.2} s | {} KiB |",
        series.contract,
        sizes.join(" x "),
        object.len().div_ceil(1024)
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // `cargo test --benches` only checks that it runs.
    if arguments.iter().any(|a| a == "--test" || a == "--list") {
        return;
    }
    let asked: Vec<&String> = arguments.iter().filter(|a| !a.starts_with("--")).collect();
    println!(
        "| contract | peak nodes | controller | synth | cc | object |\n|---|---:|---:|---:|---:|---:|"
    );
    for series in &SERIES {
        if asked.is_empty() || asked.iter().any(|a| *a == series.contract) {
            for sizes in series.rows {
                row(series, sizes);
            }
        }
    }
    if asked.is_empty() {
        let program = env!("CARGO_BIN_EXE_linewright");
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for line in ["line", "real"] {
            let out = tempfile::tempdir().expect("a folder");
            let file = format!("examples/ice-lab/{line}.lw");
            let folder = out.path().display().to_string();
            let run = [program, "run", &file, "--parts", "20", "--out", &folder];
            let (said, seconds) = timed(&run, root);
            assert!(said.contains("violations   none"), "{said}");
            println!(
                "{file}, 20 products, from an empty build folder: {seconds:.2} s of processor time"
            );
        }
    }
}
