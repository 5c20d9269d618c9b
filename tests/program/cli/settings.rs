//! `run --set NAME=VALUE`: numbers of a line from the command line.

use super::session::Session;
use crate::support::files_below;
use crate::support::{PROGRAM, documents, root};
use linewright::contract::Library;
use linewright::contract::line::Line;
use linewright::contract::set::{Owner, SettableNumber, Setting, Settings};
use linewright::engine::files::{self, LoadedFiles, StandardLibrary};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

const PACKING: &str = "\
const CYCLE = 2 s

line Packing {
    part Bottle
    part Carton from 6 Bottle
    source infeed: Bottle every random 2 s
    buffer tray capacity 4
    station capper {
        takes CYCLE
        failures jam: mtbf 1 h mttr 2 min
        failures oil: mtbf 4 h mttr 10 min
    }
    station packer {
        takes 8 s a Carton
    }
    conveyor belt places 3 pitch 0.5 m speed 0.25 m/s
    sink box
    route Bottle: infeed -> tray -> capper -> belt -> packer
    route Carton: packer -> box
    requirement pace: throughput >= 20 per hour
    limit 50 products
}
";

/// Two stations and a conveyor with machines; the stations share theirs.
const DRILLING: &str = "\
import std.handling.convey

contract Drill {
    input requested: bool
    output finished: bool
    guarantee reports: always (finished <-> requested)
}

machine Press {
    parameter depth: number = 2
    action spindle: Drill when operation = drill {
        requested = operation = drill
        time 3 s + 1 s * depth
        power 1 kW
    }
    operation drill: spindle
    done spindle.finished
}

machine Belt(places: 2..64 = 3) {
    signal load: bool = false
    signal unload_ready: bool = true
    action belt: Convey(places = places)
}

line Drilling {
    part Plate
    source rack: Plate every 10 s
    station first: Press {
        perform drill on Plate
    }
    conveyor belt: Belt
    station second: Press {
        perform drill(depth = 1) on Plate
    }
    sink box
    route Plate: rack -> first -> belt -> second -> box
    limit 5 products
}
";

fn session() -> Session {
    let session = Session::new();
    std::fs::write(session.path("packing.lw"), PACKING).expect("a file");
    std::fs::write(session.path("drilling.lw"), DRILLING).expect("a file");
    session
}

/// The program with these settings, and what it prints as a snapshot shows it.
fn shown(session: &Session, line: &str, settings: &[&str]) -> String {
    let mut command = session.command(line);
    let mut text = format!("$ linewright {line}");
    for setting in settings {
        command.args(["--set", setting]);
        let _ = write!(text, " --set '{setting}'");
    }
    let output = command.output().expect("the program starts");
    documents::assert_valid(&output.stdout);
    let _ = writeln!(
        text,
        "\nexit code {}",
        output.status.code().expect("a code")
    );
    for (name, stream) in [
        ("standard output", output.stdout),
        ("standard error", output.stderr),
    ] {
        if !stream.is_empty() {
            let stream = String::from_utf8(stream).expect("UTF-8");
            let _ = write!(text, "--- {name}\n{stream}");
        }
    }
    text
}

/// What it prints after the command and without the rows of the settings.
fn results(shown: &str) -> String {
    let lines = shown.lines().skip(1);
    let lines = lines.filter(|line| !line.starts_with("  set  "));
    lines.fold(String::new(), |text, line| text + line + "\n")
}

#[test]
fn a_run_shows_what_was_set() {
    let session = session();
    let settings = ["capper.takes=3 s", "belt.places=8"];
    let table = shown(&session, "run packing.lw", &settings);
    insta::assert_snapshot!("set_shown", table);
    // The order of the options does not matter.
    let reversed = ["belt.places = 8", " capper.takes =  3 s "];
    let other = shown(&session, "run packing.lw", &reversed);
    assert_eq!(
        table.split_once('\n').map(|(_, rest)| rest),
        other.split_once('\n').map(|(_, rest)| rest)
    );
    let line = "run packing.lw --no-timing --format json";
    let json = shown(&session, line, &settings);
    let (_, json) = json
        .split_once("--- standard output\n")
        .expect("a document");
    let json: serde_json::Value = serde_json::from_str(json).expect("JSON");
    assert_eq!(
        json["set"],
        serde_json::json!({"belt.places": "8", "capper.takes": "3 s"})
    );
    let plain = shown(&session, line, &[]);
    assert!(!plain.contains("\"set\""), "{plain}");
}

#[test]
fn wrong_settings_are_reported_together() {
    let session = session();
    let settings = [
        "caper.takes=3 s",
        "capper.taks=3 s",
        "capper.mtbf=2 h",
        "box.capacity=3",
        "milling.time=3 s",
        "packer.takes.Carton=3 m",
        "capper.jam.mttr=3 s s",
        "capper.setup=normal(3 s)",
        "capper.power=",
        "tray.capacity=0",
        "infeed.limit=1.5",
        "belt.speed=0 m/s",
        "belt.places=2",
        "belt.places=3",
        "pace=3 min per hour",
        "limit=0",
    ];
    insta::assert_snapshot!("set_wrong", shown(&session, "run packing.lw", &settings));
}

#[test]
fn wrong_settings_of_machines() {
    let session = session();
    let settings = [
        "first.time=3",
        "first.spindle.power=3 s",
        "first.duration=3 s",
        "belt.time=3 s",
        "belt.places=100",
        "second.depth=3 s",
    ];
    insta::assert_snapshot!(
        "set_wrong_machine",
        shown(&session, "run drilling.lw", &settings)
    );
}

#[test]
fn an_option_without_a_value() {
    let session = session();
    insta::assert_snapshot!(
        "set_malformed",
        shown(&session, "run packing.lw", &["capper.takes", "=3 s"])
    );
}

/// A number of a machine is set for one station, and other times need no other library.
#[test]
fn a_machine_is_set_for_one_station() {
    let session = session();
    let libraries = || {
        let found = std::fs::read_dir(session.path(".linewright")).expect("a folder");
        let names = found.map(|e| e.expect("an entry").path());
        let is_library = |p: &PathBuf| {
            p.extension()
                .is_some_and(|e| e == std::env::consts::DLL_EXTENSION)
        };
        names.filter(is_library).count()
    };
    let line = "run drilling.lw --no-timing";
    let plain = shown(&session, line, &[]);
    let first = shown(&session, line, &["first.time=8 s"]);
    insta::assert_snapshot!("set_one_station", first);
    let before = libraries();
    let second = shown(&session, line, &["first.time=9 s", "second.power=2 kW"]);
    let third = shown(&session, line, &["second.depth=3", "first.depth=1"]);
    assert_eq!(libraries(), before, "{second}{third}");
    assert_ne!(results(&first), results(&second));
    assert_eq!(results(&plain), results(&shown(&session, line, &[])));
}

/// A line in a file, with the numbers that can be set.
struct Case {
    path: PathBuf,
    line: String,
    numbers: Vec<SettableNumber>,
}

/// The lines of the examples and of the documentation, as files below a folder.
fn cases(folder: &Path) -> Vec<Case> {
    let mut paths = Vec::new();
    for from in files_below(&root().join("examples"), &["lw"]) {
        let to = folder.join(from.strip_prefix(root()).expect("below"));
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        std::fs::copy(&from, &to).expect("a copy");
        paths.push(to);
    }
    let pages = files_below(&root().join("docs"), &["md"]);
    for (page, from) in pages.iter().enumerate() {
        let folder = folder.join(page.to_string());
        std::fs::create_dir_all(&folder).expect("a folder");
        let text = std::fs::read_to_string(from).expect("a text");
        let blocks = text.split("\n```lw").skip(1);
        for (number, block) in blocks.enumerate() {
            let (name, text) = block.split_once('\n').expect("a block");
            let (text, _) = text.split_once("\n```").expect("the end of a block");
            let path = match name.trim() {
                "" => folder.join(format!("{number}.lw")),
                name => folder.join(name),
            };
            std::fs::write(&path, text).expect("a file");
            paths.push(path);
        }
    }
    paths.sort();
    paths.dedup();
    let cases = paths.into_par_iter().flat_map(|path| {
        let name = path.display().to_string();
        let loaded = load(&path, Settings::default());
        let lines = loaded.library.lines.into_iter();
        let sources = loaded.library.sources;
        let own = lines.filter(|l| sources.file(l.span.file).name == name);
        let cases = own.map(|line| Case {
            numbers: files::settable(
                &name,
                &StandardLibrary::default(),
                Owner::Line,
                Some(&line.name),
            )
            .expect("a file"),
            path: path.clone(),
            line: line.name,
        });
        cases.collect::<Vec<_>>()
    });
    cases.collect()
}

fn load(path: &Path, settings: Settings<'_>) -> LoadedFiles {
    files::load_with(
        &[path.display().to_string()],
        &StandardLibrary::default(),
        settings,
    )
}

/// A line without places in files, as text; `None` if it has errors.
fn model(library: &Library, name: &str) -> Option<String> {
    let line: &Line = library.lines.iter().find(|l| l.name == name)?;
    let text = format!("{line:?}");
    let mut pieces = text.split("Span { ");
    let first = pieces.next().unwrap_or_default().to_owned();
    let rest = pieces.map(|piece| piece.split_once(" }").expect("the end of a place").1);
    Some(rest.fold(first, |text, piece| text + piece))
}

fn setting(name: &str, value: &str) -> Setting {
    format!("{name}={value}").parse().expect("a setting")
}

fn with(case: &Case, list: &[Setting]) -> Option<String> {
    let settings = Settings {
        of: Owner::Line,
        name: Some(&case.line),
        list,
    };
    model(&load(&case.path, settings).library, &case.line)
}

/// Every number can be set to its own text, by its shortest and by its full name, and nothing
/// changes.
#[test]
fn own_values_change_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = cases(folder.path());
    let count: usize = cases.iter().map(|c| c.numbers.len()).sum();
    assert!(cases.len() > 30 && count > 300, "{} {count}", cases.len());
    cases.par_iter().for_each(|case| {
        let plain = load(&case.path, Settings::default());
        let plain = model(&plain.library, &case.line);
        let own = |name: fn(&[String]) -> Option<&String>| -> Vec<Setting> {
            let numbers = case.numbers.iter();
            let own = numbers.filter_map(|n| Some(setting(name(&n.names)?, n.value.as_ref()?)));
            own.collect()
        };
        for settings in [own(<[String]>::first), own(<[String]>::last)] {
            let same = with(case, &settings);
            assert!(plain == same, "{}: {settings:?}", case.path.display());
        }
    });
}

/// The text without comments, texts in quotes and dates: blanks are in their place.
fn without_remarks(text: &str) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_date = |text: &str| {
            let digits: Vec<&str> = text.splitn(3, '-').collect();
            let numbers = digits.len() == 3 && digits[0].len() == 4 && digits[1].len() == 2;
            numbers && digits.concat().chars().all(|c| c.is_ascii_digit())
        };
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if first == '"' {
            rest[1..].find('"').map_or(rest.len(), |end| end + 2)
        } else if rest.get(..10).is_some_and(is_date) {
            10
        } else {
            kept.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        };
        kept.push_str(&" ".repeat(skipped));
        rest = &rest[skipped..];
    }
    kept
}

/// Where numbers begin in a text, with their digits.
fn literals(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut before = ' ';
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        if c.is_ascii_digit() && !before.is_alphanumeric() && before != '_' {
            let rest = &text[at..];
            let end = rest.find(|c: char| !c.is_ascii_digit());
            let digits = &rest[..end.unwrap_or(rest.len())];
            found.push((at, digits));
            // Digits after a point belong to the number.
            let fraction = rest[digits.len()..].strip_prefix('.');
            let fraction = fraction.filter(|f| f.starts_with(|c: char| c.is_ascii_digit()));
            let end = fraction.map_or(digits.len(), |f| {
                let end = f.find(|c: char| !c.is_ascii_digit()).unwrap_or(f.len());
                digits.len() + 1 + end
            });
            at += end;
            before = '0';
        } else {
            at += c.len_utf8();
            before = c;
        }
    }
    found
}

/// Every number in the text of a line has a name for `--set`, but for dates and for the indices of
/// arrays.
#[test]
fn every_number_of_a_line_can_be_set() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut count, mut missing) = (0, Vec::new());
    for case in cases(folder.path()) {
        let loaded = load(&case.path, Settings::default());
        let name = case.path.display().to_string();
        let line = loaded.library.lines.iter().find(|l| l.name == case.line);
        let start = line.expect("the line").span.start as usize;
        let text = std::fs::read_to_string(&case.path).expect("a text");
        let text = without_remarks(&text);
        let end = text[start..]
            .find("\n}")
            .map_or(text.len(), |end| start + end);
        let sources = &loaded.library.sources;
        let places: Vec<_> = case.numbers.iter().filter_map(|n| n.place).collect();
        let is_here = |file| sources.file(file).name == name;
        // Whole numbers have no place, so each stands for one that is as large.
        let unplaced = case.numbers.iter().filter(|n| n.place.is_none());
        let mut counts: Vec<&str> = unplaced.filter_map(|n| n.value.as_deref()).collect();
        for (at, digits) in literals(&text[start..end]) {
            count += 1;
            let at = start + at;
            let covers = |p: &linewright::source::Span| {
                is_here(p.file) && (p.start as usize..p.end as usize).contains(&at)
            };
            if places.iter().any(covers) {
                continue;
            }
            if let Some(index) = counts.iter().position(|value| *value == digits) {
                counts.swap_remove(index);
                continue;
            }
            let is_index = text[..at].ends_with('[') && text[at + digits.len()..].starts_with(']');
            if !is_index {
                let row = text[..at].matches('\n').count() + 1;
                missing.push(format!("{name}:{row}: {digits}"));
            }
        }
    }
    assert!(count > 500, "{count}");
    assert!(missing.is_empty(), "{missing:#?}");
}

/// Numbers of routes, shifts and values take effect, and wrong ones are reported as in the file.
#[test]
fn routes_shifts_and_values_can_be_set() {
    let session = session();
    let text = "line L {
    part P {
        property rounds: 0..9 = 0
        property bad: bool = false
    }
    source rack: P every 10 s
    station test {
        takes 4 s
        defect on P probability 50 %: bad becomes true
    }
    buffer flaws capacity 5
    station mend {
        takes 4 s
        sets rounds = min(rounds + 1, 9)
        sets bad = false
        shift 0 h to 8 h
    }
    sink box
    sink bin rejects
    route P: rack -> test
    route P: test -> box when not bad
    route P: test -> flaws, bin when rounds < 2
    route P: test -> bin otherwise
    route P: flaws -> mend, bin by probability 90 %
    route P: mend -> test
    shift 0 h to 8 h break 2 h to 3 h
    shift 12 h to 20 h break 14 h to 15 h
    limit 1 d
}
";
    std::fs::write(session.path("l.lw"), text).expect("a file");
    let settings = [
        "test.P.when.2=rounds < 1",
        "flaws.probability.mend=40 %",
        "mend.sets.rounds=rounds + 2",
        "test.defect.becomes=false",
        "shift.2.to=16 h",
        "shift.2.break.to=14.5 h",
        "shift.1.break.1.from=1 h",
        "mend.shift.from=1 h",
        "P.rounds.max=7",
    ];
    let line = "run l.lw";
    let plain = results(&shown(&session, line, &[]));
    for setting in settings {
        let set = shown(&session, line, &[setting]);
        assert!(set.contains("\nexit code 0"), "{set}");
        // The wider range changes no number, since fewer rounds than before are allowed.
        assert_eq!(
            results(&set) == plain,
            setting.starts_with("P.rounds"),
            "{set}"
        );
    }
    let wrong = [
        "test.when=rounds < 1",
        "test.P.when.3=rounds < 1",
        "test.P.when.2=rouns < 1",
        "flaws.probability.mend=120 %",
        "mend.sets.bad=3",
        "shift.1.to=0 h",
        "shift.2.to=25 h",
        "shift.to=9 h",
        "shift.1.break.to=9 h",
        "mend.shift.to=9 m",
    ];
    insta::assert_snapshot!("set_wrong_routes", shown(&session, line, &wrong));
}

/// One number of this many is compared with an edited file.
const EVERY: usize = 5;

/// A value from the command line has the same effect as the value in the file.
#[test]
fn values_are_as_in_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut compared = 0;
    for (first, case) in cases(folder.path()).into_iter().enumerate() {
        let loaded = load(&case.path, Settings::default());
        // A sample, because each number takes two loads.
        for number in case.numbers.iter().skip(first % EVERY).step_by(EVERY) {
            let (Some(value), Some(place)) = (&number.value, number.place) else {
                continue;
            };
            let Some(other) = increased(value) else {
                continue;
            };
            if is_shared(&loaded.library, &case.line, place) {
                continue;
            }
            let set = with(&case, &[setting(&number.names[0], &other)]);
            let file = loaded.library.sources.file(place.file);
            if !std::path::Path::new(&file.name).is_file() {
                // The bundled library is not edited.
                continue;
            }
            let (start, end) = (place.start as usize, place.end as usize);
            let edited = [&file.text[..start], &other, &file.text[end..]].concat();
            std::fs::write(&file.name, edited).expect("a file");
            let edited = model(&load(&case.path, Settings::default()).library, &case.line);
            std::fs::write(&file.name, &*file.text).expect("a file");
            let name = &number.names[0];
            assert!(set == edited, "{}: {name}={other}", case.path.display());
            compared += 1;
        }
    }
    assert!(compared > 30, "{compared}");
}

/// The text with 1 more in place of its first number.
fn increased(value: &str) -> Option<String> {
    let start = value.find(|c: char| c.is_ascii_digit())?;
    let rest = &value[start..];
    let end = rest.find(|c: char| !c.is_ascii_digit());
    let (digits, rest) = rest.split_at(end.unwrap_or(rest.len()));
    let number: u64 = digits.parse().ok()?;
    Some(format!("{}{}{rest}", &value[..start], number + 1))
}

/// Whether a place is in a machine that several places of the line use.
fn is_shared(library: &Library, line: &str, place: linewright::source::Span) -> bool {
    let starts = (library.machines.iter().map(|m| m.span))
        .chain(library.lines.iter().map(|l| l.span))
        .chain(library.contracts.iter().map(|c| c.span));
    let before = starts.filter(|s| s.file == place.file && s.start <= place.start);
    let Some(item) = before.max_by_key(|s| s.start) else {
        return false;
    };
    let lines = library.lines.iter().filter(|l| l.name == line);
    let nodes = lines.flat_map(|l| &l.nodes);
    let machines = nodes.filter_map(|node| node.machine());
    machines.filter(|m| m.span == item).count() > 1
}

/// A run with all numbers set to their own text prints the same, although its libraries are others.
#[test]
fn runs_with_own_values_are_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    // The controllers of the real laboratory take minutes.
    let is_small = |case: &Case| !case.path.ends_with("real.lw");
    let all: Vec<Case> = cases(folder.path()).into_iter().filter(is_small).collect();
    all.par_iter().for_each(|case| {
        let run = |settings: &[String]| {
            let selection = format!("{}::{}", case.path.display(), case.line);
            let mut command = Command::new(PROGRAM);
            command.env("LINEWRIGHT_CACHE", &cache).env("NO_COLOR", "1");
            command.args(["run", &selection, "--parts", "2", "--until", "1h"]);
            command.args(["--no-timing", "--format", "json"]);
            for setting in settings {
                command.args(["--set", setting]);
            }
            let output = command.output().expect("the program starts");
            let text = String::from_utf8(output.stdout).expect("UTF-8");
            let mut document: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
            if let Some(document) = document.as_object_mut() {
                document.remove("set");
                // Findings about a value point to the option.
                document.remove("findings");
            }
            (output.status.code(), document)
        };
        let values = case.numbers.iter().filter_map(|number| {
            let value = number.value.as_ref()?;
            Some(format!("{}={value}", number.names[0]))
        });
        let values: Vec<String> = values.collect();
        let name = case.path.display();
        assert_eq!(run(&[]), run(&values), "{name}: {values:?}");
    });
}
