//! Short keys in place of long labels, and lists of entries in columns, such as the legend that
//! explains the keys.

use super::Graph;
use super::canvas::{Canvas, LABEL_FONT};
use super::text::{self, LINE};

/// Distance between columns, and between a key and its text, in SVG units.
const GAP: f64 = 12.0;

/// Distance between entries, in lines.
const SEPARATION: f64 = 0.4;

/// Maximum number of characters in a line of an entry.
pub(super) const WIDTH: usize = 48;

/// A row of a list: a key in bold, and the lines that belong to it.
pub(super) struct Entry {
    pub key: String,
    pub lines: Vec<String>,
}

/// Returns the number-th key: a to z, then aa, ab and so on.
fn key(number: usize) -> String {
    let letter = char::from(b'a' + (number % 26) as u8);
    match number / 26 {
        0 => letter.to_string(),
        rest => format!("{}{letter}", key(rest - 1)),
    }
}

/// Replaces each label of an edge by a key, and returns the legend. Equal labels have the same key.
pub(super) fn with_keys(graph: &Graph) -> (Graph, Vec<Entry>) {
    let mut labels: Vec<&Vec<String>> = Vec::new();
    let mut keyed = graph.clone();
    for (edge, original) in keyed.edges.iter_mut().zip(&graph.edges) {
        if original.label.is_empty() {
            continue;
        }
        let known = labels.iter().position(|label| **label == original.label);
        let number = known.unwrap_or(labels.len());
        if known.is_none() {
            labels.push(&original.label);
        }
        edge.label = vec![key(number)];
    }
    let entries = labels.iter().enumerate().map(|(number, label)| Entry {
        key: key(number),
        lines: text::wrap(label, WIDTH),
    });
    (keyed, entries.collect())
}

/// Writes entries in columns of about equal height, as many as fit into a width in SVG units.
pub(super) fn columns(entries: &[Entry], limit: f64) -> Canvas {
    let width = |line: &String, is_bold: bool| text::width(line, LABEL_FONT, is_bold);
    let keys = entries.iter().map(|entry| width(&entry.key, true));
    let key_width = keys.fold(0.0, f64::max) + GAP;
    let lines = entries.iter().flat_map(|entry| &entry.lines);
    let column_width = key_width + lines.map(|line| width(line, false)).fold(0.0, f64::max);
    let height = |entry: &Entry| (entry.lines.len().max(1) as f64 + SEPARATION) * LINE;

    let most = ((limit + 2.0 * GAP) / (column_width + 2.0 * GAP)).floor();
    let count = (1..=entries.len()).take_while(|count| *count as f64 <= most);
    let count = count.last().unwrap_or(1);
    let target = entries.iter().map(height).sum::<f64>() / count as f64;

    let mut canvas = Canvas::default();
    let (mut column, mut top) = (0, 0.0);
    for entry in entries {
        if top >= target && column + 1 < count {
            column += 1;
            top = 0.0;
        }
        let x = column as f64 * (column_width + 2.0 * GAP);
        let base = |line: usize| (top + line as f64 * LINE + 0.8) * LABEL_FONT;
        canvas.write(x, base(0), true, &entry.key);
        for (index, line) in entry.lines.iter().enumerate() {
            canvas.write(x + key_width, base(index), false, line);
        }
        top += height(entry);
    }
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_go_on_after_z() {
        let keys: Vec<String> = [0, 25, 26, 51, 52, 701, 702].map(key).into();
        assert_eq!(keys, ["a", "z", "aa", "az", "ba", "zz", "aaa"]);
    }

    #[test]
    fn columns_keep_to_the_width() {
        let entry = |number: usize| Entry {
            key: key(number),
            lines: vec!["command != move & grip".to_owned(); number % 4],
        };
        let entries: Vec<Entry> = (0..50).map(entry).collect();
        let one = columns(&entries, 100.0).size;
        let many = columns(&entries, 800.0).size;
        assert!(many.width <= 800.0 && many.width > 2.0 * one.width);
        assert!(many.height < one.height / 2.0);
    }
}
