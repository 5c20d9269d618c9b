//! Parses a probe's dump.
//!
//! A dump consists of lines of words. Each time the library is loaded, it writes a header, which
//! begins a session. The calls of the session follow; each call ends with an `end` line:
//!
//! ```text
//! linewright-probe 1
//! platform windows
//! pointers 64
//! profile name = "found"            in the second round: the profile file, line by line
//! call lw_probe_integer_1
//! expects integer:1
//! ret 00000000...                   the bytes at `ret`, or null
//! arg 01000000...
//! points 8 4c696e65...              the bytes at the address that `arg` holds at offset 8
//! end lw_probe_integer_1
//! ```
//!
//! The text is untrusted. Unexpected content gives findings and never makes parsing fail, and the
//! memory use is proportional to the length of the text. If the last call has no `end` line, the
//! dump was cut off there, and the call is ignored.

use super::Value;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};

/// First line of a dump, with the version.
const HEADER: &str = "linewright-probe 1";

/// Maximum sizes, which no probe exceeds.
const MAX_CALLS: usize = 2000;
const MAX_BYTES: usize = 512;
const MAX_POINTERS: usize = 64;
const MAX_VALUES: usize = 8;

/// One session of a dump.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dump {
    /// `windows` or `unix`.
    pub platform: String,
    /// Text of the profile file, in the second round.
    pub profile: Option<String>,
    /// Calls in order.
    pub calls: Vec<Record>,
}

/// Data recorded for a call.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// Name of the export.
    pub name: String,
    /// Arguments of the call.
    pub expects: Vec<Value>,
    /// Bytes at `ret`; empty for a null pointer.
    pub ret: Vec<u8>,
    /// Bytes at `arg`.
    pub arg: Vec<u8>,
    /// Offsets in `arg` that can hold an address, with the bytes at that address.
    pub points: Vec<(usize, Vec<u8>)>,
    /// Line at which the record begins.
    pub place: Span,
}

impl Record {
    /// Bytes at the address that `arg` holds at an offset, if any were recorded.
    pub fn bytes_at_pointer(&self, offset: usize) -> Option<&[u8]> {
        let found = self.points.iter().find(|(at, _)| *at == offset);
        found.map(|(_, bytes)| bytes.as_slice())
    }
}

/// Parses a dump: returns the last session that contains calls, and findings about the text. If a
/// finding is an error, the session must not be used.
pub fn parse(file: FileId, text: &str) -> (Dump, Vec<Diagnostic>) {
    let mut reader = Reader {
        file,
        sessions: Vec::new(),
        open: None,
        findings: Vec::new(),
    };
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let whole = line.ends_with('\n');
        let content = line.trim_end_matches(['\n', '\r']);
        let place = Span::new(file, at, at + content.len());
        at += line.len();
        // The last line might be truncated if it has no line break.
        if !whole {
            reader.cut(place);
        } else if !content.is_empty() {
            reader.line(content, place);
        }
    }
    if let Some((record, _)) = reader.open.take() {
        reader.cut(record.place);
    }
    reader.finish(Span::new(file, 0, text.len().min(1)))
}

struct Reader {
    file: FileId,
    sessions: Vec<Dump>,
    /// The call being read, and whether it is damaged.
    open: Option<(Record, bool)>,
    findings: Vec<Diagnostic>,
}

impl Reader {
    fn damaged(&mut self, place: Span, message: impl Into<String>) {
        if let Some((_, damaged)) = &mut self.open {
            *damaged = true;
        }
        // Report only the first findings.
        if self.findings.len() < 20 {
            self.findings.push(
                Diagnostic::warning(codes::DUMP, place, message)
                    .with_help("the call is ignored; run the probe again to get a complete dump"),
            );
        }
    }

    fn cut(&mut self, place: Span) {
        self.open = None;
        self.findings.push(
            Diagnostic::warning(codes::DUMP, place, "the dump is cut off here")
                .with_help("the incomplete call is ignored; check whether the host crashed in it"),
        );
    }

    fn line(&mut self, content: &str, place: Span) {
        if content == HEADER {
            if self.open.take().is_some() {
                self.cut(place);
            }
            self.sessions.push(Dump::default());
            return;
        }
        let (word, rest) = content.split_once(' ').unwrap_or((content, ""));
        if word == "linewright-probe" {
            self.open = None;
            self.findings.push(
                Diagnostic::error(
                    codes::DUMP,
                    place,
                    format!("the dump has version {}, not 1", shortened(rest)),
                )
                .with_help("read it with the version of linewright that built the probe"),
            );
            return;
        }
        if self.sessions.is_empty() {
            if self.findings.is_empty() {
                self.findings.push(
                    Diagnostic::error(codes::DUMP, place, "this is not a dump of the probe")
                        .with_help("choose the file that the probe wrote next to its library; it begins with `linewright-probe 1`"),
                );
            }
            return;
        }
        let dump = self
            .sessions
            .last_mut()
            .expect("no session was recorded; please report this");
        match word {
            "platform" => dump.platform = shortened(rest),
            "pointers" if rest == "64" => {}
            "pointers" => {
                let message = format!(
                    "the probe ran in a program with {}-bit pointers",
                    shortened(rest)
                );
                self.findings
                    .push(Diagnostic::error(codes::DUMP, place, message).with_help(
                        "run the probe in a 64-bit Plant Simulation; station libraries are 64-bit",
                    ));
            }
            "profile" => {
                let profile = dump.profile.get_or_insert_default();
                profile.push_str(rest);
                profile.push('\n');
            }
            "call" => {
                if self.open.is_some() {
                    self.damaged(place, "a call begins before the previous one has ended");
                }
                let record = Record {
                    name: shortened(rest),
                    place,
                    ..Record::default()
                };
                self.open = Some((record, false));
            }
            _ => self.within_call(word, rest, place),
        }
    }

    fn within_call(&mut self, word: &str, rest: &str, place: Span) {
        let Some((record, _)) = &mut self.open else {
            self.damaged(place, format!("`{}` is not within a call", shortened(word)));
            return;
        };
        let read = match word {
            "expects" => values(rest).map(|v| record.expects = v),
            "ret" => bytes(rest).map(|b| record.ret = b),
            "arg" => bytes(rest).map(|b| record.arg = b),
            "points" => rest.split_once(' ').and_then(|(at, hex)| {
                let at = at.parse().ok().filter(|at| *at < MAX_BYTES)?;
                let bytes = bytes(hex).filter(|_| record.points.len() < MAX_POINTERS)?;
                record.points.push((at, bytes));
                Some(())
            }),
            "end" if rest == record.name => {
                self.end(place);
                return;
            }
            _ => None,
        };
        if read.is_none() {
            self.damaged(
                place,
                format!("`{}` cannot be read", shortened(&format!("{word} {rest}"))),
            );
        }
    }

    fn end(&mut self, place: Span) {
        let Some((record, damaged)) = self.open.take() else {
            return;
        };
        let Some(dump) = self.sessions.last_mut() else {
            return;
        };
        if dump.calls.len() >= MAX_CALLS {
            self.damaged(place, format!("the dump has more than {MAX_CALLS} calls"));
        } else if !damaged {
            dump.calls.push(record);
        }
    }

    fn finish(mut self, start: Span) -> (Dump, Vec<Diagnostic>) {
        let with_calls = self.sessions.iter().rposition(|d| !d.calls.is_empty());
        let errors = linewright_core::diagnostics::has_errors(&self.findings);
        let Some(last) = with_calls else {
            if !errors {
                self.findings.push(
                    Diagnostic::error(codes::DUMP, start, "the dump contains no complete call")
                        .with_help("run the probe's SimTalk method in Plant Simulation"),
                );
            }
            return (Dump::default(), self.findings);
        };
        let earlier = self.sessions[..last]
            .iter()
            .filter(|d| !d.calls.is_empty())
            .count();
        if earlier > 0 {
            let span = Span::new(self.file, 0, 0);
            let message = format!(
                "the dump contains {} sessions; only the last one is used",
                earlier + 1
            );
            self.findings.push(
                Diagnostic::note(codes::DUMP, span, message)
                    .with_help("delete the dump before you run the probe again"),
            );
        }
        (self.sessions.swap_remove(last), self.findings)
    }
}

/// Shortens a text of the dump for a message.
fn shortened(text: &str) -> String {
    let visible = |c: char| if c.is_control() { '?' } else { c };
    let mut short: String = text.chars().take(40).map(visible).collect();
    if text.chars().nth(40).is_some() {
        short.push_str("...");
    }
    short
}

/// Decodes hexadecimal bytes; `null` and an empty text give no bytes.
fn bytes(hex: &str) -> Option<Vec<u8>> {
    if hex == "null" {
        return Some(Vec::new());
    }
    let digit = |b: u8| (b as char).to_digit(16).map(|d| d as u8);
    let hex = hex.as_bytes();
    if !hex.len().is_multiple_of(2) || hex.len() > 2 * MAX_BYTES {
        return None;
    }
    hex.chunks_exact(2)
        .map(|pair| Some(digit(pair[0])? << 4 | digit(pair[1])?))
        .collect()
}

/// Parses the values of a line `expects`.
fn values(text: &str) -> Option<Vec<Value>> {
    let words = text.split_whitespace();
    let values: Option<Vec<Value>> = words.take(MAX_VALUES + 1).map(value).collect();
    values.filter(|v| v.len() <= MAX_VALUES)
}

fn value(word: &str) -> Option<Value> {
    let (kind, text) = word.split_once(':')?;
    let real = || text.parse().ok().filter(|x: &f64| x.is_finite());
    Some(match kind {
        "integer" => Value::Integer(text.parse().ok()?),
        "real" => Value::Real(real()?),
        "time" => Value::Time(real()?),
        "boolean" => Value::Boolean(text.parse().ok()?),
        "text" => Value::Text(String::from_utf8(bytes(text)?).ok()?),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::diagnostics::Severity;

    const GOOD: &str = "linewright-probe 1\nplatform windows\npointers 64\ncall a\nexpects integer:-2 text:4c77 real:1.5\nret 00ff\narg 01\npoints 0 4c7700\nend a\n";

    fn read(text: &str) -> (Dump, Vec<Severity>) {
        let (dump, findings) = parse(FileId(0), text);
        assert!(findings.iter().all(|f| f.help.is_some()));
        (dump, findings.iter().map(|f| f.severity).collect())
    }

    #[test]
    fn a_whole_dump_is_read() {
        let (dump, findings) = read(GOOD);
        assert_eq!(findings, []);
        assert_eq!(dump.platform, "windows");
        let call = &dump.calls[0];
        let text = Value::Text("Lw".to_owned());
        assert_eq!(call.expects, [Value::Integer(-2), text, Value::Real(1.5)]);
        assert_eq!(
            (call.ret.as_slice(), call.bytes_at_pointer(0)),
            (&[0, 255][..], Some(&b"Lw\0"[..]))
        );
        for call in super::super::calls() {
            let words: Vec<String> = call.arguments.iter().map(Value::dump_word).collect();
            assert_eq!(values(&words.join(" ")), Some(call.arguments));
        }
    }

    #[test]
    fn a_dump_that_is_cut_off_keeps_what_is_whole() {
        let two = format!("{GOOD}call b\nexpects integer:1\nret 00\narg 01\nend b\n");
        for length in GOOD.len()..two.len() {
            let (dump, findings) = read(&two[..length]);
            assert_eq!(dump.calls.len(), 1, "{length}");
            assert_eq!(findings.len(), usize::from(length > GOOD.len()), "{length}");
        }
        assert_eq!(read(&two).0.calls.len(), 2);
    }

    #[test]
    fn what_is_no_dump_is_an_error() {
        for text in [
            "",
            "hello\n",
            "linewright-probe 2\n",
            "linewright-probe 1\n",
            "\u{0}\n",
        ] {
            let (dump, findings) = read(text);
            assert_eq!(dump.calls.len(), 0);
            assert_eq!(findings, [Severity::Error], "{text:?}");
        }
        let narrow = GOOD.replace("pointers 64", "pointers 32");
        assert_eq!(read(&narrow).1, [Severity::Error]);
    }

    #[test]
    fn the_last_session_counts() {
        let again = GOOD.replace("call a", "call b").replace("end a", "end b");
        let (dump, findings) = read(&format!("{GOOD}{again}"));
        assert_eq!(dump.calls[0].name, "b");
        assert_eq!(findings, [Severity::Note]);
    }

    #[test]
    fn damaged_lines_lose_their_call_alone() {
        for (from, to) in [
            ("arg 01", "arg 0"),
            ("ret 00ff", "ret zz"),
            ("integer:-2", "integer:x"),
            ("points 0", "points 9999"),
            ("ret 00ff", "what"),
        ] {
            let (dump, findings) = read(&format!(
                "{}{}",
                GOOD.replace("call a", "call b")
                    .replace("end a", "end b")
                    .as_str(),
                GOOD.replace("linewright-probe 1\n", "").replace(from, to)
            ));
            assert_eq!(dump.calls.len(), 1, "{to}");
            assert!(findings.contains(&Severity::Warning));
        }
    }
}
