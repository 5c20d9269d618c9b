//! Plays: every script in `tests/cases/step` with its transcript, legal moves compared with direct
//! evaluation, and scripts written by a play itself. The first line of a script says what is
//! played.

use crate::support;
use crate::support::assumed::Assumed;
use linewright::contract::load;
use linewright::game::{Limits, Outcome, solve};
use linewright::gr1::{Specification, VarId};
use linewright::mealy::Controller;
use linewright::mealy::extract::extract;
use linewright::play::{Opponent, Session};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn folder() -> PathBuf {
    support::root().join("tests/cases/step")
}

/// A folder with copies of the cases, since plays can write files.
fn sandbox() -> tempfile::TempDir {
    let sandbox = tempfile::tempdir().expect("a folder");
    for entry in std::fs::read_dir(folder()).expect("cases") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            let name = path.file_name().expect("a name");
            std::fs::copy(&path, sandbox.path().join(name)).expect("a copy");
        }
    }
    sandbox
}

fn scripts() -> Vec<String> {
    let entries = std::fs::read_dir(folder()).expect("cases");
    let names = entries.map(|e| {
        e.expect("an entry")
            .file_name()
            .to_string_lossy()
            .into_owned()
    });
    let mut names: Vec<String> = names
        .filter(|n| n.rsplit('.').next() == Some("txt"))
        .collect();
    names.sort();
    names
}

fn shown(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    format!(
        "exit code {}\n--- standard output\n{}--- standard error\n{}",
        output.status.code().unwrap_or(-1),
        text(&output.stdout),
        text(&output.stderr)
    )
}

#[test]
fn transcripts() {
    let sandbox = sandbox();
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../cases/step/snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for script in scripts() {
        let text = std::fs::read_to_string(folder().join(&script)).expect("a script");
        let first = text.lines().next().and_then(|l| l.strip_prefix("# "));
        let mut arguments: Vec<&str> = first.expect("what is played").split(' ').collect();
        arguments.extend(["--script", &script]);
        let output = support::linewright(sandbox.path(), &arguments);
        settings.bind(|| insta::assert_snapshot!(script.trim_end_matches(".txt"), shown(&output)));
    }
}

fn piped(folder: &Path, arguments: &[&str], commands: &str) -> Output {
    let mut child = Command::new(support::PROGRAM)
        .arg("step")
        .args(arguments)
        .current_dir(folder)
        .env("LINEWRIGHT_CACHE", folder.join(".cache"))
        .env("NO_COLOR", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut input = child.stdin.take().expect("its input");
    input.write_all(commands.as_bytes()).expect("commands");
    drop(input);
    let output = child.wait_with_output().expect("it ends");
    support::documents::assert_valid(&output.stdout);
    output
}

#[test]
fn what_a_play_has_saved_replays_it() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    for name in [
        "Press", "Clash", "Starved", "Follow", "Guess", "Copy", "Delay",
    ] {
        let contract = format!("press.lw::{name}");
        let output = piped(
            folder,
            &[&contract, "--seed", "7"],
            "random 6\nstate\nsave plain.txt\nsave test test.txt\n",
        );
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let state = |output: &Output| {
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            text.split_once("> state\n")
                .expect("a state")
                .1
                .lines()
                .next()
                .map(str::to_owned)
        };
        let first = state(&output);
        for file in ["plain.txt", "test.txt"] {
            let again = piped(folder, &[&contract], &format!("replay {file}\nstate\n"));
            assert_eq!(again.status.code(), Some(0), "{name}: {}", shown(&again));
            assert_eq!(state(&again), first);
        }
        let script = piped(folder, &[&contract, "--script", "test.txt"], "");
        assert_eq!(script.status.code(), Some(0));

        // A different value is detected and named.
        let text = std::fs::read_to_string(folder.join("test.txt")).expect("a script");
        let (values, wrong) = match text.rsplit_once("true") {
            Some((before, after)) => (before, format!("{before}false{after}")),
            None => (text.as_str(), text.replacen("= 0", "= 1", 1)),
        };
        if values
            .rsplit('\n')
            .next()
            .is_some_and(|l| l.starts_with("expect"))
        {
            std::fs::write(folder.join("wrong.txt"), wrong).expect("a script");
            let output = piped(folder, &[&contract], "replay wrong.txt\n");
            assert_eq!(output.status.code(), Some(1), "{name}");
            let words = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(words.contains(": expected "), "{words}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_play() {
    let sandbox = sandbox();
    let play = |seed: &str| {
        let arguments = ["press.lw::Press", "--seed", seed, "--format", "json"];
        piped(sandbox.path(), &arguments, "random 20\n").stdout
    };
    assert_eq!(play("3"), play("3"));
    assert_ne!(play("3"), play("4"));
    let text = String::from_utf8(play("3")).expect("a text");
    assert_eq!(text.lines().filter(|l| l.contains("\"step\":")).count(), 20);
}

#[test]
fn what_cannot_be_played_is_reported() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    for (arguments, code, words) in [
        (
            &["press.lw"][..],
            2,
            "only one contract can be played at a time",
        ),
        (&["press.lw::Pres"], 2, "has no contract `Pres`"),
        (&["missing.lw"], 2, "missing.lw"),
        (
            &["press.lw::Press", "--format", "sarif"],
            2,
            "--format json",
        ),
        (
            &["press.lw::Press", "--script", "missing.txt"],
            2,
            "missing.txt cannot be read",
        ),
        (&["press.lw::Press", "--timeout", "0.000001"], 3, "LW204"),
    ] {
        let output = piped(folder, arguments, "");
        assert_eq!(output.status.code(), Some(code), "{}", shown(&output));
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(shown.contains(words), "{arguments:?}: {shown}");
    }
}

/// Random numbers (xorshift).
struct Chance(u64);

impl Chance {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }
}

/// The contracts of the library, played as the plant: a move is refused exactly if direct
/// evaluation says that it violates an assumption.
#[test]
fn moves_are_refused_when_they_break_an_assumption_and_only_then() {
    let mut report = String::new();
    let (mut played, mut accepted, mut refused) = (0, 0, 0);
    for path in contracts(&support::root().join("contracts")) {
        let text = std::fs::read_to_string(&path).expect("a contract");
        let name = path.to_string_lossy().into_owned();
        let read = |wanted: &str, from: &str| {
            let path = Path::new(from).parent().expect("a folder").join(wanted);
            let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
            Ok((path.to_string_lossy().into_owned(), text))
        };
        let (library, _) = load(&[(name, text)], &read);
        for contract in &library.contracts {
            let specification = &*contract.specification;
            if specification.variables.iter().any(|v| v.internal) {
                continue;
            }
            let limits = Limits::default();
            let Outcome::Realizable(won) = solve(specification, &limits) else {
                continue;
            };
            let Ok(machine) = extract(specification, &won, &limits) else {
                continue;
            };
            played += 1;
            let opponent = Opponent::Controller(Controller::Machine(machine));
            let mut session = Session::new(specification, &library.sources, opponent, 1);
            let mut assumed = Assumed::new(specification);
            let mut chance = Chance(0x1234_5678_9abc_def1);
            for _ in 0..60 {
                let (line, inputs) = some_move(specification, &mut chance);
                let broken = assumed.broken(&inputs);
                let reply = session.run(&line);
                if reply.is_ok() != broken.is_none() {
                    let _ = writeln!(report, "{}: {line}: {broken:?} {reply:?}", contract.name);
                }
                let reply = if let Ok(reply) = reply {
                    accepted += 1;
                    reply
                } else {
                    refused += 1;
                    session.run("random").expect("a legal move")
                };
                let step = &reply.lines[0];
                let of = |id: VarId, side: &str| {
                    let variable = specification.variable(id);
                    let value = &step[side][&variable.name];
                    let domain = &variable.domain;
                    let all = domain.low()..=domain.high();
                    let is = |v: &i64| domain.show(*v) == value.to_string().trim_matches('"');
                    all.into_iter().find(is).expect("a value")
                };
                let inputs: Vec<i64> = specification.inputs().map(|v| of(v, "plant")).collect();
                let outputs: Vec<i64> = specification.outputs().map(|v| of(v, "machine")).collect();
                assert_eq!(assumed.broken(&inputs), None, "{}", contract.name);
                assumed.accepted(&inputs, &outputs);
            }
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(
        played > 5 && accepted > 50 && refused > 50,
        "{played} {accepted} {refused}"
    );
}

/// Any values of all inputs, as a line and as numbers.
fn some_move(specification: &Specification, chance: &mut Chance) -> (String, Vec<i64>) {
    let (mut parts, mut inputs) = (Vec::new(), Vec::new());
    for id in specification.inputs() {
        let variable = specification.variable(id);
        let value = variable.domain.low() + chance.below(variable.domain.size()) as i64;
        parts.push(format!(
            "{} = {}",
            variable.name,
            variable.domain.show(value)
        ));
        inputs.push(value);
    }
    (parts.join(", "), inputs)
}

fn contracts(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(contracts(&path));
        } else if path.extension().is_some_and(|e| e == "lw") {
            found.push(path);
        }
    }
    found.sort();
    found
}
