//! Cost of a controller as a function of each size of the laboratory's contracts, one parameter at
//! a time, of one contract of each group of DIN 8580 at two sizes, and the total cost of the line
//! at real size.
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

/// One contract of each group of DIN 8580, by default and at the size of a plant. Group 1.10 is
/// [`SERIES`]'s `Print`.
const GROUPS: [Series; 42] = [
    Series {
        contract: "DieCast",
        file: "primary_shaping/die_cast.lw",
        defaults: &["cavities: 1..32 = 1"],
        rows: &[&[1], &[16]],
    },
    Series {
        contract: "InjectionMold",
        file: "primary_shaping/injection_mold.lw",
        defaults: &["dose: 1..20 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "SlipCast",
        file: "primary_shaping/slip_cast.lw",
        defaults: &["time: 1..60 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "PowderPress",
        file: "primary_shaping/powder_press.lw",
        defaults: &["deepest: 1..40 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "BoardPress",
        file: "primary_shaping/board_press.lw",
        defaults: &["close_steps: 1..60 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "VaporDeposit",
        file: "primary_shaping/vapor_deposit.lw",
        defaults: &["after: 1..20 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "Electroform",
        file: "primary_shaping/electroform.lw",
        defaults: &["target: 1..500 = 5"],
        rows: &[&[5], &[40]],
    },
    Series {
        contract: "ReversingMill",
        file: "forming/reversing_mill.lw",
        defaults: &["slab: 2..300 mm = 7"],
        rows: &[&[7], &[56]],
    },
    Series {
        contract: "DeepDraw",
        file: "forming/deep_draw.lw",
        defaults: &["full: 1..60 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "StretchForm",
        file: "forming/stretch_form.lw",
        defaults: &["final: 2..100 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "PressBrake",
        file: "forming/press_brake.lw",
        defaults: &["sync: 1..9 = 1"],
        rows: &[&[1], &[8]],
    },
    Series {
        contract: "TwistCrank",
        file: "forming/twist_crank.lw",
        defaults: &["turn: 1..36 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "Shear",
        file: "separating/shear.lw",
        defaults: &["room: 1..100 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "PeckDrill",
        file: "separating/peck_drill.lw",
        defaults: &["holes: 1..50 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "Grind",
        file: "separating/grind.lw",
        defaults: &["interval: 1..200 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "LaserCut",
        file: "separating/laser_cut.lw",
        defaults: &["patience: 1..20 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "Unscrew",
        file: "separating/unscrew.lw",
        defaults: &["screws: 1..12 = 2"],
        rows: &[&[2], &[6]],
    },
    Series {
        contract: "Wash",
        file: "separating/wash.lw",
        defaults: &["bath_time: 1..20 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "InsertPeg",
        file: "joining/insert_peg.lw",
        defaults: &["rings: 1..50 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "FillBottle",
        file: "joining/fill_bottle.lw",
        defaults: &["drip_time: 1..20 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "DriveScrew",
        file: "joining/drive_screw.lw",
        defaults: &["longest: 1..50 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "PotUnderVacuum",
        file: "joining/pot_under_vacuum.lw",
        defaults: &["pot_life: 2..100 = 7"],
        rows: &[&[7], &[56]],
    },
    Series {
        contract: "ClinchSheets",
        file: "joining/clinch_sheets.lw",
        defaults: &["streak: 2..10 = 2"],
        rows: &[&[2], &[10]],
    },
    Series {
        contract: "SpotWeld",
        file: "joining/spot_weld.lw",
        defaults: &["spots: 1..500 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "Braze",
        file: "joining/braze.lw",
        defaults: &["liquid_time: 2..50 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "BondParts",
        file: "joining/bond_parts.lw",
        defaults: &["open_time: 2..200 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "SewSeam",
        file: "joining/sew_seam.lw",
        defaults: &["stitches: 1..500 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "InkJetMark",
        file: "coating/ink_jet_mark.lw",
        defaults: &["serials: 2..999 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "FillSurface",
        file: "coating/fill_surface.lw",
        defaults: &["layers: 1..9 = 2"],
        rows: &[&[2], &[9]],
    },
    Series {
        contract: "PrintPaste",
        file: "coating/print_paste.lw",
        defaults: &["stiffens: search+2..90 = 6"],
        rows: &[&[6], &[48]],
    },
    Series {
        contract: "PowderCoat",
        file: "coating/powder_coat.lw",
        defaults: &["bake_time: 1..60 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "CladWeld",
        file: "coating/clad_weld.lw",
        defaults: &["beads: 1..40 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "BrazeHardface",
        file: "coating/braze_hardface.lw",
        defaults: &["wetting: 1..60 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "Sputter",
        file: "coating/sputter.lw",
        defaults: &["layers: 1..12 = 2"],
        rows: &[&[2], &[12]],
    },
    Series {
        contract: "Electroplate",
        file: "coating/electroplate.lw",
        defaults: &["dose: 2..60 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "ShotPeen",
        file: "changing_properties/shot_peen.lw",
        defaults: &["most: strokes..100 = 3"],
        rows: &[&[3], &[24]],
    },
    Series {
        contract: "Carburize",
        file: "changing_properties/carburize.lw",
        defaults: &["wanted: 1..50 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "PressHarden",
        file: "changing_properties/press_harden.lw",
        defaults: &["cavities: 1..8 = 2"],
        rows: &[&[2], &[8]],
    },
    Series {
        contract: "Sinter",
        file: "changing_properties/sinter.lw",
        defaults: &["quiet: 1..60 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "Magnetize",
        file: "changing_properties/magnetize.lw",
        defaults: &["pulses: 1..20 = 2"],
        rows: &[&[2], &[16]],
    },
    Series {
        contract: "UvCure",
        file: "changing_properties/uv_cure.lw",
        defaults: &["most: least+1..400 = 4"],
        rows: &[&[4], &[32]],
    },
    Series {
        contract: "ExposeResist",
        file: "changing_properties/expose_resist.lw",
        defaults: &["development: 1..100 = 2"],
        rows: &[&[2], &[16]],
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
    for series in SERIES.iter().chain(&GROUPS) {
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
