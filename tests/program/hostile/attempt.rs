//! One command on one file, and the faults in its behavior.

use crate::support::{PROGRAM, documents};
use linewright::line::random::Stream;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// `--timeout` of every command, in seconds.
const TIMEOUT: &str = "2";
/// Duration after which a command has exceeded its limit. The margin is for startup, a last
/// question, a C compiler, and other load.
const OVERRUN: Duration = Duration::from_secs(10);
/// Time after which a command counts as hung, and is killed.
const HANG: Duration = Duration::from_mins(1);

/// A command to run on a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attempt {
    pub arguments: Vec<String>,
    /// Standard input.
    pub typed: String,
}

/// A fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Equal for equal faults: the message without numbers and names, and the place.
    pub key: String,
    pub said: String,
}

const COMMANDS: [&str; 12] = [
    "random 3",
    "moves",
    "why",
    "state",
    "random",
    "undo 2",
    "why not true, 0",
    "0, 0, 0",
    "true, false",
    "reset",
    "expect x = 1",
    "random 40",
];

impl Attempt {
    /// A command that fits the file's kind.
    pub fn any(stream: &mut Stream, foreign: bool, names: &Names) -> Self {
        let choice = stream.below(100);
        let mut typed = String::new();
        let mut name = |list: &[String]| {
            let at = stream.below(list.len().max(1) as u64) as usize;
            list.get(at).map_or(String::new(), |n| format!("::{n}"))
        };
        let words: Vec<String> = match choice {
            0..42 => vec!["check".into(), "FILE".into()],
            42..46 => vec![
                "check".into(),
                "--verbose".into(),
                "--format".into(),
                "json".into(),
                "FILE".into(),
            ],
            46..60 if !foreign => vec![
                "build".into(),
                "FILE".into(),
                "--target".into(),
                "source".into(),
                "--out".into(),
                "OUT".into(),
            ],
            60..72 if !foreign => {
                let line = name(&names.lines);
                vec![
                    "run".into(),
                    format!("FILE{line}"),
                    "--until".into(),
                    "200".into(),
                    "--out".into(),
                    "OUT".into(),
                ]
            }
            72..86 if !foreign => vec!["fmt".into(), "FILE".into()],
            _ => {
                let contract = name(&names.contracts);
                for _ in 0..=stream.below(8) {
                    typed.push_str(COMMANDS[stream.below(COMMANDS.len() as u64) as usize]);
                    typed.push('\n');
                }
                vec!["step".into(), format!("FILE{contract}")]
            }
        };
        Self {
            arguments: words,
            typed,
        }
    }

    pub fn shown(&self) -> String {
        self.arguments.join(" ").replace('\n', " ")
    }

    fn is(&self, command: &str) -> bool {
        self.arguments.first().is_some_and(|a| a == command)
    }

    /// Writes the file, runs the command on it, and returns the fault.
    pub fn make(&self, place: &Place, bytes: &[u8]) -> Result<(), Fault> {
        self.once(place, bytes, OVERRUN).or_else(|fault| {
            // A busy computer is no fault of the program.
            if fault.key.starts_with("overrun") || fault.key.starts_with("hang") {
                self.once(place, bytes, 2 * OVERRUN)
            } else {
                Err(fault)
            }
        })
    }

    fn once(&self, place: &Place, bytes: &[u8], patience: Duration) -> Result<(), Fault> {
        std::fs::write(&place.file, bytes).expect("the file is written");
        let start = Instant::now();
        let status = self.run(place);
        let took = start.elapsed();
        let said = place.said();
        let fault = |key: String| {
            Err(Fault {
                key,
                said: said.clone(),
            })
        };
        let Some(status) = status else {
            return fault(format!("hang: {}", self.arguments[0]));
        };
        if let Some(key) = internal(&said) {
            return fault(key);
        }
        let Some(code @ 0..=3) = status.code() else {
            return fault(format!("{} ends with {status}", self.arguments[0]));
        };
        if let Some(faults) = place.faulty_document() {
            let first = faults.lines().next().unwrap_or_default();
            let key = format!("not as its schema says: {}", general(first));
            return Err(Fault { key, said: faults });
        }
        if took > patience {
            return fault(format!(
                "overrun: {} takes longer than --timeout allows",
                self.arguments[0]
            ));
        }
        let after = std::fs::read(&place.file).unwrap_or_default();
        let formatted = self.is("fmt") && code == 0;
        if !formatted && after != bytes {
            return fault(format!(
                "{} changes its input (exit code {code})",
                self.arguments[0]
            ));
        }
        if formatted {
            return Self::is_formatted(place, bytes, &after);
        }
        Ok(())
    }

    /// A file written by `fmt` is formatted, and declares the same.
    fn is_formatted(place: &Place, before: &[u8], after: &[u8]) -> Result<(), Fault> {
        let fault = |key: &str| {
            Err(Fault {
                key: key.to_owned(),
                said: String::new(),
            })
        };
        let again = Self {
            arguments: vec!["fmt".into(), "--check".into(), "FILE".into()],
            typed: String::new(),
        };
        let status = again.run(place);
        if status.is_none_or(|s| s.code() != Some(0)) {
            return fault("fmt --check is not content with what fmt has written");
        }
        let solid = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            (Names::of(&text), text.matches("//").count())
        };
        if solid(before) != solid(after) {
            return fault("fmt changes what a file declares, or its comments");
        }
        Ok(())
    }

    fn run(&self, place: &Place) -> Option<ExitStatus> {
        let name = place.file.file_name().expect("a name").to_string_lossy();
        let out = place.out.to_string_lossy();
        let arguments = self.arguments.iter().map(|a| match a.as_str() {
            "OUT" => out.to_string(),
            a => a.replacen("FILE", &name, 1),
        });
        let output = || File::create(&place.output).expect("a file for the output");
        std::fs::write(&place.input, &self.typed).expect("a file for the input");
        let mut child = Command::new(PROGRAM)
            .args(arguments)
            .args(["--no-timing", "--timeout", TIMEOUT, "--memory", "1024"])
            .current_dir(place.file.parent().expect("a folder"))
            .env("LINEWRIGHT_CACHE", &place.cache)
            .env("NO_COLOR", "1")
            .env("RUST_BACKTRACE", "0")
            .env_remove("CLICOLOR_FORCE")
            .stdin(Stdio::from(File::open(&place.input).expect("the input")))
            .stdout(Stdio::from(output()))
            .stderr(Stdio::from(
                File::create(&place.errors).expect("a file for the errors"),
            ))
            .spawn()
            .expect("the program starts");
        let start = Instant::now();
        let mut pause = Duration::from_millis(1);
        loop {
            if let Some(status) = child.try_wait().expect("the program is waited for") {
                return Some(status);
            }
            if start.elapsed() > HANG {
                child.kill().expect("the program is killed");
                child.wait().expect("the program is waited for");
                return None;
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(20));
        }
    }
}

/// Names in a file for use in commands.
#[derive(Debug, PartialEq, Eq)]
pub struct Names {
    pub contracts: Vec<String>,
    pub machines: Vec<String>,
    pub lines: Vec<String>,
}

impl Names {
    pub fn of(text: &str) -> Self {
        let declared = |word| super::corpus::Seed::declared(text, word);
        Self {
            contracts: declared("contract"),
            machines: declared("machine"),
            lines: declared("line"),
        }
    }
}

/// Place where commands are run one after the other.
pub struct Place {
    /// The file.
    pub file: PathBuf,
    pub out: PathBuf,
    pub cache: PathBuf,
    input: PathBuf,
    output: PathBuf,
    errors: PathBuf,
}

impl Place {
    pub fn new(folder: &Path, file: PathBuf) -> Self {
        Self {
            file,
            out: folder.join("out"),
            cache: folder.join("cache"),
            input: folder.join("input"),
            output: folder.join("output"),
            errors: folder.join("errors"),
        }
    }

    /// What is wrong with a document on standard output, by its schema.
    fn faulty_document(&self) -> Option<String> {
        let output = std::fs::read(&self.output).unwrap_or_default();
        let documents = documents::documents(&output);
        let mut faults = documents.iter().map(documents::faults);
        faults.find(|f| !f.is_empty())
    }

    fn said(&self) -> String {
        let read = |path: &Path| {
            let bytes = std::fs::read(path).unwrap_or_default();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        read(&self.errors) + &read(&self.output)
    }
}

/// The key of a panic, or of another fault that the program detects itself.
fn internal(said: &str) -> Option<String> {
    let mut lines = said.lines();
    while let Some(line) = lines.next() {
        if let Some((_, place)) = line.split_once(" panicked at ") {
            let message = lines.next().unwrap_or_default();
            return Some(format!("panic at {place} {}", general(message)));
        }
    }
    let asks = |l: &&str| l.contains("please report") || l.contains("internal error");
    let line = said.lines().find(asks)?;
    Some(format!("internal: {}", general(line)))
}

/// A message without its numbers and names.
fn general(message: &str) -> String {
    let mut general = String::new();
    let mut quoted = false;
    let mut number = false;
    for c in message.chars() {
        if c == '`' || c == '"' {
            quoted = !quoted;
            general.push(c);
        } else if c.is_ascii_digit() {
            if !number && !quoted {
                general.push('N');
            }
        } else if !quoted {
            general.push(c);
        }
        number = c.is_ascii_digit();
    }
    general.chars().take(160).collect()
}
