//! Formats the result of `check` as text: one line per declaration, and a summary.

use super::document::{Document, LineEntry, SkillsVerdict, Summary, Validity};
use crate::cli::console::count;
use crate::diagnostics::json::Finding;
use crate::engine::lines::LineVerdict;
use crate::engine::machine::RefinementVerdict;
use crate::engine::pipeline::{Examination, Verdict};
use crate::engine::words::{DischargeEntry, DischargeRuleName};
use crate::line::trace::duration;
use crate::taxonomy;
use clap::builder::styling::{AnsiColor, Style};
use std::fmt::{self, Write as _};

const GOOD: Style = AnsiColor::Green.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
const OPEN: Style = AnsiColor::Yellow.on_default().bold();
const DIM: Style = Style::new().dimmed();

const COLUMNS: usize = 8;

/// Mark of a verdict: at the beginning of a table line, or before the verdict on a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Good,
    /// Good, but there are warnings.
    Warned,
    Bad,
    Open,
    Failed,
}

impl Mark {
    fn shown(self) -> (Style, char) {
        match self {
            Self::Good => (GOOD, '✓'),
            Self::Warned => (OPEN, '⚠'),
            Self::Bad => (BAD, '✗'),
            Self::Open => (OPEN, '?'),
            Self::Failed => (BAD, '!'),
        }
    }

    /// The class of the style sheet of pages.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Warned => "warned",
            Self::Open => "open",
            Self::Bad | Self::Failed => "bad",
        }
    }

    /// The mark of something with these findings: warnings are not hidden behind a good one.
    pub(super) fn with(self, findings: &[Finding]) -> Self {
        let has_warnings = findings.iter().any(|f| f.severity == "warning");
        match self {
            Self::Good if has_warnings => Self::Warned,
            other => other,
        }
    }

    /// The mark of a line: of its verdict, or of its proof if the verdict is good.
    pub(super) fn of_line(line: &LineEntry) -> Self {
        match (Self::from(line.verdict), line.proof) {
            (Self::Good, Some(LineVerdict::Open)) => Self::Bad,
            (Self::Good, Some(LineVerdict::Safe | LineVerdict::GaveUp)) => Self::Open,
            (mark, _) => mark,
        }
    }
}

impl From<Verdict> for Mark {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Realizable => Self::Good,
            Verdict::Unrealizable => Self::Bad,
            Verdict::GaveUp => Self::Open,
            Verdict::Invalid | Verdict::InternalError => Self::Failed,
        }
    }
}

impl From<SkillsVerdict> for Mark {
    fn from(verdict: SkillsVerdict) -> Self {
        match verdict {
            SkillsVerdict::Consistent => Self::Good,
            SkillsVerdict::Contradictory => Self::Bad,
            SkillsVerdict::GaveUp => Self::Open,
            SkillsVerdict::Invalid | SkillsVerdict::InternalError => Self::Failed,
        }
    }
}

impl From<Validity> for Mark {
    fn from(verdict: Validity) -> Self {
        match verdict {
            Validity::Valid => Self::Good,
            Validity::GaveUp => Self::Open,
            Validity::Invalid | Validity::InternalError => Self::Failed,
        }
    }
}

/// Formats a verdict for the table: `gave up`.
pub(super) fn in_words(verdict: impl fmt::Display) -> String {
    verdict.to_string().replace('_', " ")
}

/// The number of findings of each severity: `2 warnings, 1 note`; empty if there are none.
pub(super) fn by_severity<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> String {
    let mut counts = [("error", 0), ("warning", 0), ("note", 0)];
    for finding in findings {
        for (severity, number) in &mut counts {
            *number += usize::from(finding.severity == *severity);
        }
    }
    let counts = counts.iter().filter(|(_, number)| *number > 0);
    let counts: Vec<String> = counts.map(|(what, number)| count(*number, what)).collect();
    counts.join(", ")
}

/// A row of the table, before the columns are aligned.
struct Row {
    mark: Mark,
    cells: Vec<String>,
}

/// The table and the summary, in color. With `verbose`, also the files, the kernels, and how each
/// assumption is discharged.
pub(super) fn human(document: &Document, verbose: bool) -> String {
    let mut rows: Vec<Row> = Vec::new();
    let file = |name: &str| {
        if verbose {
            name.to_owned()
        } else {
            String::new()
        }
    };
    for c in &document.contracts {
        rows.push(Row {
            mark: c.verdict.into(),
            cells: vec![
                c.name.clone(),
                match c.format {
                    Some(ending) => format!(".{ending}"),
                    None => term(&c.codes),
                },
                interface(c.input_bits, c.output_bits),
                in_words(c.verdict),
                c.states.map(|n| count(n, "state")).unwrap_or_default(),
                c.seconds.map(|s| format!("{s:.2} s")).unwrap_or_default(),
                file(&c.file),
                file(&c.kernel),
            ],
        });
    }
    let short = |mark: Mark, name: String, size: String, verdict: String, path: &str| {
        let mut cells = vec![String::new(); COLUMNS];
        (cells[0], cells[2], cells[3], cells[6]) = (name, size, verdict, file(path));
        Row { mark, cells }
    };
    for s in &document.skills {
        let name = format!("skills {}", s.name);
        let size = format!("{}, {}", count(s.skills, "skill"), count(s.rules, "rule"));
        let verdict = in_words(s.verdict);
        rows.push(short(s.verdict.into(), name, size, verdict, &s.file));
    }
    for l in &document.layouts {
        let name = format!("layout {}", l.name);
        let size = count(l.resources, "resource");
        let verdict = in_words(l.verdict);
        rows.push(short(l.verdict.into(), name, size, verdict, &l.file));
    }
    for r in &document.recipes {
        let name = format!("recipe {}", r.name);
        let size = count(r.transitions, "transition");
        let verdict = in_words(r.verdict);
        rows.push(short(r.verdict.into(), name, size, verdict, &r.file));
    }
    for r in &document.realizations {
        let mut cells = vec![String::new(); COLUMNS];
        cells[0] = format!("realize {}", r.name);
        cells[3] = in_words(r.verdict);
        let bound = r.lower_bound.map(|least| format!(", at least {least}"));
        cells[4] = (r.worst_case)
            .map(|n| count(n as usize, "step") + &bound.unwrap_or_default())
            .unwrap_or_default();
        cells[6] = file(&r.file);
        rows.push(Row {
            mark: r.verdict.into(),
            cells,
        });
    }
    for m in &document.machines {
        let empty = String::new;
        rows.push(Row {
            mark: m.verdict.into(),
            cells: vec![
                format!("machine {}", m.name),
                term(&m.codes),
                count(m.components.len(), "component"),
                in_words(m.verdict),
                empty(),
                empty(),
                file(&m.file),
                empty(),
            ],
        });
    }
    for l in &document.lines {
        let mut cells = vec![String::new(); COLUMNS];
        cells[0] = format!("line {}", l.name);
        if !l.not_controlled.is_empty() {
            cells[2] = format!(
                "{} not controlled",
                count(l.not_controlled.len(), "station")
            );
        }
        cells[3] = in_words(l.verdict);
        line_verdict(l).clone_into(&mut cells[4]);
        cells[6] = file(&l.file);
        rows.push(Row {
            mark: Mark::of_line(l),
            cells,
        });
    }
    let mut text = align(&rows);
    if !rows.is_empty() {
        text.push('\n');
    }
    text.push_str(&premises(document));
    text.push_str(&summary(document));
    if verbose {
        text.push_str(&not_examined(document));
        text.push_str(&discharges(document));
        text.push_str(&work(document));
    }
    for c in &document.contracts {
        if let Some(statistics) = &c.statistics {
            text.push('\n');
            text.push_str(&statistics.show(&c.name));
        }
    }
    text
}

/// What is proved of a line, in short; empty if it cannot be run.
pub(super) fn line_verdict(line: &LineEntry) -> &'static str {
    match line.proof {
        Some(LineVerdict::Proved) if line.premises.is_empty() => "proved",
        Some(LineVerdict::Proved) => "proved, provided",
        Some(LineVerdict::Safe) => "no global deadlock",
        Some(LineVerdict::Open) => "not proved",
        Some(LineVerdict::GaveUp) => "not decided",
        None => "",
    }
}

/// Lists the premises of the proofs of lines.
fn premises(document: &Document) -> String {
    let mut text = String::new();
    for line in document.lines.iter().filter(|l| !l.premises.is_empty()) {
        let _ = writeln!(text, "the verdict on {} holds provided that", line.name);
        for premise in &line.premises {
            let _ = writeln!(text, "    {}", premise.text);
        }
        text.push('\n');
    }
    text
}

/// One line per declaration: `file: name: verdict`.
pub(super) fn short(document: &Document) -> String {
    let mut text = String::new();
    for c in &document.contracts {
        let _ = writeln!(text, "{}: contract {}: {}", c.file, c.name, c.verdict);
    }
    for s in &document.skills {
        let _ = writeln!(text, "{}: skills {}: {}", s.file, s.name, s.verdict);
    }
    for l in &document.layouts {
        let _ = writeln!(text, "{}: layout {}: {}", l.file, l.name, l.verdict);
    }
    for r in &document.recipes {
        let _ = writeln!(text, "{}: recipe {}: {}", r.file, r.name, r.verdict);
    }
    for r in &document.realizations {
        let _ = writeln!(text, "{}: realize {}: {}", r.file, r.name, r.verdict);
    }
    for m in &document.machines {
        let _ = writeln!(text, "{}: machine {}: {}", m.file, m.name, m.verdict);
    }
    for l in &document.lines {
        let _ = writeln!(text, "{}: line {}: {}", l.file, l.name, l.verdict);
    }
    text
}

fn align(rows: &[Row]) -> String {
    let mut widths = [0; COLUMNS];
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(&row.cells) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = String::new();
    for row in rows {
        let (style, mark) = row.mark.shown();
        let mut line = format!("{style}{mark}{style:#}");
        let mut space = String::from(" ");
        for (i, (cell, width)) in row.cells.iter().zip(widths).enumerate() {
            if width == 0 {
                continue;
            }
            let padding = " ".repeat(width - cell.chars().count());
            // Times are right-aligned.
            let (before, after) = if i == 5 {
                (padding.as_str(), "")
            } else {
                ("", padding.as_str())
            };
            space.push_str(before);
            if !cell.is_empty() {
                let style = match i {
                    0 => Style::new(),
                    3 => style,
                    _ => DIM,
                };
                let _ = write!(line, "{space}{style}{cell}{style:#}");
                space.clear();
            }
            space.push_str(after);
            space.push_str("  ");
        }
        text.push_str(&line);
        text.push('\n');
    }
    text
}

/// `vdi:Drehen Rotating`: the first code with its English term, and the number of further codes.
pub(super) fn term(codes: &[String]) -> String {
    let Some(code) = codes.first() else {
        return String::new();
    };
    let english = taxonomy::find(code).map_or("", |e| e.english.as_str());
    let more = match codes.len() {
        1 => String::new(),
        n => format!(" +{}", n - 1),
    };
    format!("{code} {english}{more}").trim_end().to_owned()
}

fn interface(inputs: Option<u32>, outputs: Option<u32>) -> String {
    match (inputs, outputs) {
        (Some(i), Some(o)) => format!("{i} in, {o} out"),
        _ => String::new(),
    }
}

/// Lists the contracts that were not examined completely.
fn not_examined(document: &Document) -> String {
    let lines = document.contracts.iter().filter_map(|contract| {
        let name = &contract.name;
        match contract.examination? {
            Examination::VerdictOnly => Some(format!(
                "{name}: verdict only; the contract is large, so it was not examined, and its controller was not extracted\n"
            )),
            Examination::Partial => Some(format!(
                "{name}: not examined completely within the work limit, so findings can be missing; raise the limit with --effort FACTOR\n"
            )),
            Examination::Complete => None,
        }
    });
    lines.collect()
}

/// For every line and machine, how each assumption is discharged, and how it refines its contracts.
fn discharges(document: &Document) -> String {
    let mut text = String::new();
    for line in document.lines.iter().filter(|l| !l.discharges.is_empty()) {
        let _ = writeln!(text, "\n{}: how each assumption is discharged", line.name);
        text.push_str(&discharged(&line.discharges));
    }
    for machine in &document.machines {
        if !machine.discharges.is_empty() {
            let _ = writeln!(
                text,
                "\n{}: how each assumption is discharged",
                machine.name
            );
            text.push_str(&discharged(&machine.discharges));
        }
        for refined in &machine.refines {
            let (machine, contract) = (&machine.name, &refined.contract);
            let _ = match refined.verdict {
                RefinementVerdict::Refined => writeln!(text, "\n{machine} refines {contract}"),
                RefinementVerdict::Broken => writeln!(
                    text,
                    "\n{machine} does not refine {contract}; these obligations are discharged"
                ),
                RefinementVerdict::GaveUp => writeln!(
                    text,
                    "\ncould not decide whether {machine} refines {contract}"
                ),
            };
            text.push_str(&discharged(&refined.discharges));
        }
    }
    text
}

/// For every line, how long its machines work on a part, and how much of it is control.
fn work(document: &Document) -> String {
    let mut text = String::new();
    for line in document.lines.iter().filter(|l| !l.work.is_empty()) {
        let _ = writeln!(
            text,
            "\n{}: time of the work on a part, without failures",
            line.name
        );
        let names: Vec<String> = line
            .work
            .iter()
            .map(|work| format!("{}, {}", work.station, work.part))
            .collect();
        let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        for (name, work) in names.iter().zip(&line.work) {
            let _ = writeln!(
                text,
                "  {name:width$}  {}: {} of actions, {} of control",
                seconds(work.seconds),
                seconds(work.action_seconds),
                seconds(work.control_seconds)
            );
        }
    }
    text
}

/// A time with its least and greatest value: `2.8 s`, or `2.8 s to 4 s`.
fn seconds([least, greatest]: [f64; 2]) -> String {
    if least < greatest {
        format!("{} to {}", duration(least), duration(greatest))
    } else {
        duration(least)
    }
}

/// The rule by which an obligation is discharged, in words.
pub(super) fn how(discharge: &DischargeEntry) -> String {
    match (discharge.rule, discharge.turn) {
        (DischargeRuleName::Induction, _) => "step by step".to_owned(),
        (DischargeRuleName::Exported, _) => "environment".to_owned(),
        (rule, Some(turn)) => format!("{rule}, turn {turn}"),
        (rule, None) => rule.to_string(),
    }
}

fn discharged(discharges: &[DischargeEntry]) -> String {
    let name = |d: &DischargeEntry| format!("{}: {}", d.component, d.assumption);
    let width = |text: &dyn Fn(&DischargeEntry) -> String| {
        let widths = discharges.iter().map(|d| text(d).chars().count());
        widths.max().unwrap_or(0)
    };
    let (first, second) = (width(&name), width(&how));
    let lines = discharges
        .iter()
        .map(|d| format!("  {:first$}  {:second$}  {}\n", name(d), how(d), d.by));
    lines.collect()
}

/// The number of contracts by verdict, in words; empty if there are none.
pub(super) fn summary_of_verdicts(s: &Summary) -> String {
    let mut parts = Vec::new();
    for (n, what) in [
        (s.realizable, "realizable"),
        (s.unrealizable, "unrealizable"),
        (s.gave_up, "gave up"),
        (s.invalid, "invalid"),
        (s.internal_error, "internal error"),
    ] {
        if n > 0 {
            parts.push(format!("{n} {what}"));
        }
    }
    parts.join(", ")
}

fn summary(document: &Document) -> String {
    let s = &document.summary;
    let contracts = count(document.contracts.len(), "contract");
    let mut verdicts = summary_of_verdicts(s);
    if !verdicts.is_empty() {
        verdicts.insert_str(0, ": ");
    }
    let in_part = document.contracts.iter();
    let in_part = in_part.filter(|contract| contract.examination.is_some());
    let in_part = match in_part.count() {
        0 => String::new(),
        n => format!("; {n} not examined completely"),
    };
    let findings = count(s.findings, "finding");
    let mut text = format!("{contracts}{verdicts}; {findings}{in_part}.\n");
    if s.realizable + s.unrealizable > 0 {
        let _ = writeln!(
            text,
            "{DIM}Interfaces in bits. Semantics: safety first, strict (Bloem et al. 2012).{DIM:#}"
        );
    }
    text
}
