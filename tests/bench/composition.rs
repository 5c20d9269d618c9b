//! The assembly cell in one piece and in parts: the holistic contract solved as a game, against its
//! parts solved one by one and the proof that together they refine it.
//!
//! Each row is `linewright check` as a user runs it, on copies with other default sizes: user and
//! system time of the process, with everything solved and proved anew. The paper's tool had not
//! finished its own holistic contract of such a cell after six hours.
//!
//!     cargo bench --bench composition

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Number of cells on the wrist's circle, and side length of the grid.
const SIZES: [(u32, u32); 4] = [(8, 3), (12, 4), (24, 8), (48, 16)];

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("examples").flatten() {
        std::fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
    }
}

/// Replaces defaults in a file.
fn resize(path: &Path, defaults: &[(&str, u32)]) {
    let mut text = std::fs::read_to_string(path).expect("the file");
    for (parameter, size) in defaults {
        let start = text.find(parameter).expect("the parameter") + parameter.len();
        let length = text[start..].find([',', ')']).expect("an end");
        text.replace_range(start..start + length, &size.to_string());
    }
    std::fs::write(path, text).expect("the file is written");
}

/// The document of a check, and the processor time in seconds of the same check for people: for
/// programs, it also counts the states of the closed composition.
fn check(file: &str, folder: &Path) -> (Value, f64) {
    let program = env!("CARGO_BIN_EXE_linewright");
    let timed = Command::new("sh")
        .args(["-c", r#""$@" > /dev/null 2>&1; times"#, "sh"])
        .args([program, "check", file])
        .env("LINEWRIGHT_CACHE", "off")
        .current_dir(folder)
        .output()
        .expect("sh starts");
    let text = String::from_utf8_lossy(&timed.stdout).into_owned();
    let last = text.lines().last().unwrap_or_default();
    let seconds = last.split_whitespace().map(|time| {
        let (minutes, rest) = time.split_once('m').expect("minutes");
        let number = |t: &str| t.parse::<f64>().expect("a number");
        number(minutes) * 60.0 + number(rest.trim_end_matches('s'))
    });
    let output = Command::new(program)
        .args(["check", "--format", "json", file])
        .env("LINEWRIGHT_CACHE", "off")
        .current_dir(folder)
        .output()
        .expect("the program starts");
    let document = serde_json::from_slice(&output.stdout).expect("JSON");
    (document, seconds.sum())
}

fn row((cells, grid): (u32, u32)) {
    let folder = tempfile::tempdir().expect("a folder");
    copy(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/ice-lab"),
        folder.path(),
    );
    resize(
        &folder.path().join("cell.lw"),
        &[("cells: 2..360 = ", cells), ("grid: 2..64 = ", grid)],
    );
    resize(
        &folder.path().join("holistic.lw"),
        &[
            ("cells: 2..360 = ", cells),
            ("width: 2..64 = ", grid),
            ("height: 2..64 = ", grid),
        ],
    );
    let (whole, holistic) = check("holistic.lw", folder.path());
    assert_eq!(whole["contracts"][0]["verdict"], "realizable");
    let (parts, decomposed) = check("cell.lw", folder.path());
    assert_eq!(parts["machines"][0]["refines"][0]["verdict"], "refined");
    println!(
        "| {cells} cells, {grid} by {grid} | {holistic:.2} s | {decomposed:.2} s | {:.1} |",
        holistic / decomposed
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // `cargo test --benches` only checks that it runs.
    if arguments.iter().any(|a| a == "--test") {
        return;
    }
    println!(
        "| size | holistic | decomposed, with the proof that it refines the holistic one | ratio |"
    );
    println!("|---|---|---|---|");
    SIZES.into_iter().for_each(row);
}
