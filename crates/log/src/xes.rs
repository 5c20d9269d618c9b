//! Event logs by cases: XES (IEEE 1849-2016).
//!
//! A case is a part that leaves the line, finished or rejected, with everything that was joined
//! into it. Its trace is written when it leaves. Parts that are in the line at the end have none.

use crate::epoch::Dates;
use crate::{Context, EventWriter};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_line::log::{EventKind, LogEntry, Moment, Other};
use linewright_line::trace::{End, Violation};
use quick_xml::escape::escape;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Writes XES.
pub(crate) struct XesWriter<'a, W> {
    file: W,
    line: &'a Line,
    dates: Dates,
    /// By number of the part in the line: its steps and those of its components.
    cases: BTreeMap<u64, Vec<Step>>,
}

/// An event of a trace.
#[derive(Debug, Clone, Copy)]
struct Step {
    time: f64,
    node: usize,
    part: (u64, usize),
    /// Whether something begins here; if not, it is complete.
    starts: bool,
}

const HEADER: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<log xes.version="1849.2016" xes.features="" xmlns="http://www.xes-standard.org/">
<extension name="Concept" prefix="concept" uri="http://www.xes-standard.org/concept.xesext"/>
<extension name="Lifecycle" prefix="lifecycle" uri="http://www.xes-standard.org/lifecycle.xesext"/>
<extension name="Organizational" prefix="org" uri="http://www.xes-standard.org/org.xesext"/>
<extension name="Time" prefix="time" uri="http://www.xes-standard.org/time.xesext"/>
<global scope="trace">
<string key="concept:name" value="name"/>
</global>
<global scope="event">
<string key="concept:name" value="name"/>
<string key="lifecycle:transition" value="complete"/>
<string key="org:resource" value="name"/>
<date key="time:timestamp" value="1970-01-01T00:00:00.000000Z"/>
</global>
<classifier name="Activity" keys="concept:name"/>
<classifier name="Activity and transition" keys="concept:name lifecycle:transition"/>
"#;

impl<'a, W: Write> XesWriter<'a, W> {
    pub(crate) fn new(mut file: W, context: Context<'a>) -> io::Result<Self> {
        let line = context.line;
        file.write_all(HEADER.as_bytes())?;
        string(&mut file, "concept:name", &line.name)?;
        file.write_all(b"<string key=\"lifecycle:model\" value=\"standard\"/>\n")?;
        Ok(Self {
            file,
            line,
            dates: Dates::new(context.epoch),
            cases: BTreeMap::new(),
        })
    }

    fn step(&mut self, entry: &LogEntry, starts: bool) {
        if let Some(part) = entry.part {
            self.cases.entry(part.0).or_default().push(Step {
                time: entry.time,
                node: entry.node,
                part,
                starts,
            });
        }
    }

    fn write_trace(&mut self, entry: &LogEntry, outcome: &str) -> io::Result<()> {
        let Some((number, kind)) = entry.part else {
            return Ok(());
        };
        let mut steps = self.cases.remove(&number).unwrap_or_default();
        // Steps of one part stay in their order, because the sort is stable.
        steps.sort_by(|a, b| a.time.total_cmp(&b.time));
        let file = &mut self.file;
        file.write_all(b"<trace>\n")?;
        let kind = &self.line.parts[kind].name;
        string(file, "concept:name", &format!("{kind} {number}"))?;
        string(file, "part:type", kind)?;
        string(file, "outcome", outcome)?;
        for step in steps {
            let name = &self.line.nodes[step.node].name;
            file.write_all(b"<event>\n")?;
            string(file, "concept:name", name)?;
            let transition = if step.starts { "start" } else { "complete" };
            string(file, "lifecycle:transition", transition)?;
            string(file, "org:resource", name)?;
            let date = self.dates.format(step.time);
            writeln!(file, "<date key=\"time:timestamp\" value=\"{date}\"/>")?;
            string(file, "part:type", &self.line.parts[step.part.1].name)?;
            writeln!(file, "<int key=\"part:number\" value=\"{}\"/>", step.part.0)?;
            file.write_all(b"</event>\n")?;
        }
        file.write_all(b"</trace>\n")
    }
}

fn string(file: &mut impl Write, key: &str, value: &str) -> io::Result<()> {
    writeln!(file, "<string key=\"{key}\" value=\"{}\"/>", escape(value))
}

impl<W: Write> EventWriter for XesWriter<'_, W> {
    fn entry(&mut self, entry: &LogEntry) -> io::Result<()> {
        let is_station = matches!(self.line.nodes[entry.node].kind, NodeKind::Station(_));
        match entry.what {
            EventKind::Entered | EventKind::Arrived if !is_station => self.step(entry, false),
            EventKind::Started => self.step(entry, true),
            EventKind::Ended => self.step(entry, false),
            EventKind::Consumed => {
                if let (Some((number, _)), Some(Other::Part(joined_to))) = (entry.part, entry.other)
                    && let Some(steps) = self.cases.remove(&number)
                {
                    self.cases.entry(joined_to).or_default().extend(steps);
                }
            }
            EventKind::Finished => self.write_trace(entry, "finished")?,
            EventKind::Rejected => self.write_trace(entry, "rejected")?,
            _ => {}
        }
        Ok(())
    }

    fn violation(&mut self, _: &Violation) -> io::Result<()> {
        Ok(())
    }

    fn counting(&mut self, _: Moment) -> io::Result<()> {
        Ok(())
    }

    fn end(&mut self, _: Moment, _: End) -> io::Result<()> {
        self.file.write_all(b"</log>\n")?;
        self.file.flush()
    }
}
