//! Formats the figures as a Markdown table.

use crate::compare::{Figures, Row, Verdict};
use std::time::Duration;

/// A name to sort by: numbers count as numbers.
pub fn natural(name: &str) -> Vec<(String, u64)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let text = rest
            .find(|c: char| c.is_ascii_digit())
            .unwrap_or(rest.len());
        let (word, after) = rest.split_at(text);
        let digits = after
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(after.len());
        let (number, after) = after.split_at(digits);
        parts.push((word.to_owned(), number.parse().unwrap_or(0)));
        rest = after;
    }
    parts
}

/// A row shown while the bench runs.
pub fn line(row: &Row) -> String {
    let one = |f: &Figures| format!("{} in {:.2} s", f.verdict.word(), f.seconds);
    let theirs = row.theirs.as_ref().map(one);
    let theirs = theirs.map_or(String::new(), |t| format!("; peer: {t}"));
    let (ours, whole) = (one(&row.ours), row.whole.seconds);
    format!("{}: {ours} (whole check {whole:.2} s){theirs}", row.name)
}

/// The table of one format, with the tool of this name.
pub fn print(rows: &[Row], peer: Option<&str>, limit: Duration) {
    let mut table: Vec<Vec<String>> = Vec::new();
    let mut head = vec![
        "file",
        "verdict",
        "linewright",
        "peak",
        "whole check",
        "peak",
    ];
    if let Some(peer) = peer {
        head.extend([peer, "peak", "times our time", "times our memory"]);
    }
    table.push(head.into_iter().map(str::to_owned).collect());
    for row in rows {
        let verdict = match row.theirs.map(|t| t.verdict).filter(|v| v.is_decided()) {
            Some(theirs) if !row.ours.verdict.is_decided() => theirs.word(),
            Some(theirs) if theirs != row.ours.verdict => "**they differ**",
            _ => row.ours.verdict.word(),
        };
        let mut cells = vec![row.name.clone(), verdict.to_owned()];
        cells.extend(figures(&row.ours, limit));
        cells.extend(figures(&row.whole, limit));
        if let Some(theirs) = &row.theirs {
            cells.extend(figures(theirs, limit));
            cells.extend(ratios(&row.ours, theirs));
        }
        table.push(cells);
    }
    let columns = table[0].len();
    let width = |c: usize| {
        let cells = table.iter().filter_map(|r| r.get(c));
        cells.map(|t| t.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for (i, cells) in table.iter().enumerate() {
        let aligned = |(c, width): (usize, &usize)| {
            let cell = cells.get(c).map_or("", String::as_str);
            if c < 2 {
                format!(" {cell:width$} |")
            } else {
                format!(" {cell:>width$} |")
            }
        };
        let text: String = widths.iter().enumerate().map(aligned).collect();
        println!("|{text}");
        if i == 0 {
            let rule = |(c, w): (usize, &usize)| {
                let dashes = "-".repeat(w + 1);
                if c < 2 {
                    format!("{dashes}-|")
                } else {
                    format!("{dashes}:|")
                }
            };
            let rules: String = widths.iter().enumerate().map(rule).collect();
            println!("|{rules}");
        }
    }
}

/// Time and memory, or the reason why there are none.
fn figures(f: &Figures, limit: Duration) -> [String; 2] {
    let memory = format!("{:.0} MiB", f.mebibytes);
    match f.verdict {
        Verdict::Realizable | Verdict::Unrealizable => [format!("{:.2} s", f.seconds), memory],
        Verdict::TimedOut => [format!("over {} s", limit.as_secs_f64()), memory],
        Verdict::GaveUp | Verdict::Killed => [f.verdict.word().to_owned(), memory],
        Verdict::Refused => [f.verdict.word().to_owned(), String::new()],
    }
}

/// Ratios of the other tool's time and memory to ours. A tool that was stopped would have taken
/// more.
fn ratios(ours: &Figures, theirs: &Figures) -> [String; 2] {
    let ratio = |a: f64, b: f64| format!("{:.1}", a / b.max(0.001));
    let time = ratio(theirs.seconds, ours.seconds);
    let memory = ratio(theirs.mebibytes, ours.mebibytes);
    match (ours.verdict.is_decided(), theirs.verdict) {
        (true, v) if v.is_decided() => [time, memory],
        (true, Verdict::TimedOut) => [format!("over {time}"), memory],
        _ => [String::new(), String::new()],
    }
}
