//! The layout of tables, and the numbers in them.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Terminal width in columns.
const TERMINAL: usize = 100;

/// Headings of text columns, which are left-aligned like the first column. All other columns
/// contain numbers and are right-aligned.
const TEXT_COLUMNS: [&str; 5] = ["machine", "verdict", "required", "waits", "for"];

/// Writes a blank line and a table; nothing if there are no rows. Long texts are cut only if the
/// rows would otherwise be wider than the terminal.
pub(super) fn columns(out: &mut String, heads: &[&str], rows: &[Vec<String>]) {
    if rows.is_empty() {
        return;
    }
    let widths = |widest: usize| -> Vec<usize> {
        (0..heads.len())
            .map(|column| {
                rows.iter()
                    .filter_map(|row| row.get(column))
                    .map(|cell| cell.chars().count().min(widest))
                    .chain([heads[column].chars().count()])
                    .max()
                    .unwrap_or(0)
            })
            .collect()
    };
    let widest = (8..=60)
        .rev()
        .find(|&widest| widths(widest).iter().map(|w| w + 1).sum::<usize>() < TERMINAL)
        .unwrap_or(8);
    let widths = widths(widest);
    let mut write = |cells: &[&str]| {
        let mut text = String::from(" ");
        for (column, cell) in cells.iter().enumerate() {
            let cell = cut(cell, widest);
            let pad = " ".repeat(widths[column].saturating_sub(cell.chars().count()));
            text.push(' ');
            if column > 0 && !TEXT_COLUMNS.contains(&heads[column]) {
                text.push_str(&pad);
                text.push_str(&cell);
            } else {
                text.push_str(&cell);
                text.push_str(&pad);
            }
        }
        let _ = writeln!(out, "{}", text.trim_end());
    };
    write(&[]);
    write(heads);
    for row in rows {
        write(&row.iter().map(String::as_str).collect::<Vec<_>>());
    }
}

/// Cuts a text that is longer than `widest` characters to that length, including an ellipsis at the
/// end.
fn cut(text: &str, widest: usize) -> Cow<'_, str> {
    if text.chars().count() <= widest {
        return text.into();
    }
    let mut short: String = text.chars().take(widest - 1).collect();
    short.push('…');
    short.into()
}

/// Formats a number with three decimal places, or with three significant digits if these would not
/// show it.
pub(super) fn small(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    if value == 0.0 || magnitude >= -2.0 {
        return format!("{value:.3}");
    }
    let places = (2.0 - magnitude).min(15.0) as usize;
    format!("{value:.places$}")
}

/// Formats a number, or `-` if nothing was measured.
pub(super) fn measured(value: Option<f64>, places: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.places$}"))
}

/// Formats a share as a percentage, or `-` if nothing was measured.
pub(super) fn percent(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |share| format!("{:.1} %", share * 100.0))
}
