//! A graph that is too large for a drawing in layers, as a table of its states and a matrix of its
//! edges, as Ghoniem, Fekete and Castagliola recommend for more than some twenty nodes ("A
//! comparison of the readability of graphs using node-link and matrix-based representations",
//! 2004).

use super::Graph;
use super::canvas::{CELL, Canvas, LABEL_FONT};
use super::layers::{Point, Size};
use super::legend::{Entry, columns, with_keys};
use super::outline::Outline;
use super::text;
use std::collections::BTreeMap;

/// Maximum number of rows and columns of a matrix.
const MAX_ROWS: usize = 200;

/// Maximum number of edges whose labels are listed below the matrix.
const MAX_LABELS: usize = 400;

/// Maximum width of a name in the matrix in SVG units; if one is wider, numbers stand for names.
const MAX_NAME: f64 = 44.0;

/// Height of a row of the matrix, and padding of a cell, in SVG units.
const ROW: f64 = 16.0;
const PADDING: f64 = 4.0;

/// Distance between blocks, in SVG units.
const GAP: f64 = 24.0;

/// Draws a graph as a table and a matrix within a width in SVG units. `reason` says why it is not
/// drawn in layers.
pub(super) fn draw(graph: &Graph, outline: &Outline, reason: &str, limit: f64) -> Canvas {
    let mut canvas = Canvas::default();
    caption(
        &mut canvas,
        &format!("{}: {reason}", outline.caption(graph)),
    );
    let names = names(graph);
    canvas.add_below(GAP / 2.0, columns(&outline.rows(graph, &names.long), limit));
    let mut part = Canvas::default();
    if graph.states.len() > MAX_ROWS {
        let left_out = format!(
            "There is no matrix of the edges, because there are more than {MAX_ROWS} states."
        );
        caption(&mut part, &left_out);
        canvas.add_below(GAP, part);
        return canvas;
    }
    let (cells, legend) = cells(graph);
    let meaning = if legend.is_empty() {
        "Edges from the row to the column, by their number"
    } else {
        "Edges from the row to the column, by the letters of their labels, which are listed below"
    };
    caption(&mut part, meaning);
    canvas.add_below(GAP, part);
    for block in blocks(&names.short, &cells, limit) {
        canvas.add_below(GAP / 2.0, block);
    }
    canvas.add_below(GAP, columns(&legend, limit));
    canvas
}

/// Writes a line in bold below what is there.
pub(super) fn caption(canvas: &mut Canvas, text: &str) {
    let mut line = Canvas::default();
    line.write(0.0, 0.8 * LABEL_FONT, true, text);
    canvas.add_below(PADDING, line);
}

/// Names of states: in the matrix, and in the table.
struct Names {
    short: Vec<String>,
    long: Vec<String>,
}

fn names(graph: &Graph) -> Names {
    let headings = graph.states.iter();
    let headings: Vec<String> = headings
        .map(|label| label.first().cloned().unwrap_or_default())
        .collect();
    let fits = |name: &String| text::width(name, LABEL_FONT, true) <= MAX_NAME;
    if headings.iter().all(fits) {
        return Names {
            short: headings.clone(),
            long: headings,
        };
    }
    let numbered = headings.iter().enumerate();
    Names {
        short: (0..headings.len()).map(|n| format!("#{n}")).collect(),
        long: numbered.map(|(n, name)| format!("#{n} {name}")).collect(),
    }
}

/// The texts of the cells of a matrix by row and column. Row 0 is the start, and state n has row
/// n + 1.
type Cells = BTreeMap<(usize, usize), String>;

/// Returns the cells, and the legend of the keys in them: if there are few edges, and no two
/// between the same states, a cell has the key of its label; else the number of edges.
fn cells(graph: &Graph) -> (Cells, Vec<Entry>) {
    let mut counts: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let ends = |from: Option<usize>, to: usize| (from.map_or(0, |from| from + 1), to);
    for edge in &graph.edges {
        *counts.entry(ends(edge.from, edge.to)).or_default() += 1;
    }
    if graph.edges.len() > MAX_LABELS || counts.values().any(|count| *count > 1) {
        let counts = counts.into_iter();
        let cells = counts.map(|(ends, count)| (ends, count.to_string()));
        return (cells.collect(), Vec::new());
    }
    let (keyed, legend) = with_keys(graph);
    let key = |label: &[String]| label.first().cloned().unwrap_or_else(|| "1".to_owned());
    let cells = keyed.edges.iter();
    let cells = cells.map(|edge| (ends(edge.from, edge.to), key(&edge.label)));
    (cells.collect(), legend)
}

/// Draws a matrix in blocks of columns that fit into a width. A block has only the rows in which
/// it has an edge.
fn blocks(names: &[String], cells: &Cells, limit: f64) -> Vec<Canvas> {
    let width = |text: &String| text::width(text, LABEL_FONT, true);
    let head_width = width(&"start".to_owned()).max(MAX_NAME) + PADDING;
    let contents = names.iter().chain(cells.values()).map(width);
    let cell_width = contents.fold(0.0, f64::max) + 2.0 * PADDING;
    let fitting = (1..=names.len())
        .take_while(|count| head_width + *count as f64 * cell_width <= limit)
        .last()
        .unwrap_or(1);
    // Blocks of about equal width.
    let count = names.len().div_ceil(fitting).max(1);
    let per_block = names.len().div_ceil(count).max(1);

    let numbers: Vec<usize> = (0..names.len()).collect();
    let block = |columns: &[usize]| {
        let mut canvas = Canvas::default();
        let is_in = |row: usize| columns.iter().any(|to| cells.contains_key(&(row, *to)));
        let rows: Vec<usize> = (0..=names.len()).filter(|row| is_in(*row)).collect();
        let center = |column: usize, row: usize| Point {
            x: head_width + (column as f64 + 0.5) * cell_width,
            y: (row as f64 + 0.5) * ROW,
        };
        canvas.size = Size {
            width: head_width + columns.len() as f64 * cell_width,
            height: (rows.len() as f64 + 1.0) * ROW,
        };
        for (place, to) in columns.iter().enumerate() {
            let name = std::slice::from_ref(&names[*to]);
            canvas.lines(center(place, 0), name, LABEL_FONT, true);
        }
        for (line, row) in rows.iter().enumerate() {
            let name = match row.checked_sub(1) {
                None => "start",
                Some(state) => &names[state],
            };
            let base = center(0, line + 1).y + 0.35 * LABEL_FONT;
            canvas.write(0.0, base, true, name);
            for (place, to) in columns.iter().enumerate() {
                if let Some(text) = cells.get(&(*row, *to)) {
                    let at = center(place, line + 1);
                    let size = Size {
                        width: cell_width,
                        height: ROW,
                    };
                    canvas.rectangle(at, size, CELL);
                    canvas.lines(at, std::slice::from_ref(text), LABEL_FONT, false);
                }
            }
        }
        canvas
    };
    numbers.chunks(per_block).map(block).collect()
}
