//! Blocks and what goes from one to another: the components of a machine with their wires, or the
//! places of a line with their routes.

use super::canvas::Canvas;
use super::layered::Form;
use super::legend::{Entry, WIDTH, columns};
use super::svg::{GAP, in_layers};
use super::{BoxStyle, Edge, Graph, table, text};
use std::collections::BTreeMap;

/// Draws blocks within a width in SVG units.
pub(super) fn picture(graph: &Graph, form: Form, limit: f64) -> Canvas {
    let reason = match in_layers(graph, form, limit) {
        Ok(canvas) => return canvas,
        Err(reason) => reason,
    };
    if !graph.frames.is_empty()
        && let Ok(drawn) = in_layers(&collapsed(graph), form, limit)
    {
        let mut canvas = Canvas::default();
        let shown = "The blocks of each frame are shown as one";
        table::caption(&mut canvas, &format!("{shown}: {reason}"));
        canvas.add_below(GAP, drawn);
        return canvas;
    }
    list(graph, &reason, limit)
}

/// Makes one block of each outermost frame.
fn collapsed(graph: &Graph) -> Graph {
    let mut outermost: Vec<usize> = Vec::new();
    for (number, frame) in graph.frames.iter().enumerate() {
        outermost.push(frame.parent.map_or(number, |parent| outermost[parent]));
    }
    let mut frame_of: Vec<Option<usize>> = vec![None; graph.states.len()];
    for (frame, outermost) in graph.frames.iter().zip(&outermost) {
        for state in &frame.states {
            frame_of[*state] = Some(*outermost);
        }
    }
    let mut whole = Graph::default();
    let mut block_of_frame: BTreeMap<usize, usize> = BTreeMap::new();
    let mut block_of: Vec<usize> = Vec::new();
    for (state, label) in graph.states.iter().enumerate() {
        let new = whole.states.len();
        let block = match frame_of[state] {
            None => new,
            Some(frame) => *block_of_frame.entry(frame).or_insert(new),
        };
        if block == new {
            let (label, style) = match frame_of[state] {
                None => (label.clone(), graph.style(state)),
                Some(frame) => (vec![graph.frames[frame].title.clone()], BoxStyle::Block),
            };
            whole.states.push(label);
            whole.styles.push(style);
        }
        block_of.push(block);
    }
    let mut merged: BTreeMap<(Option<usize>, usize), Vec<String>> = BTreeMap::new();
    for edge in &graph.edges {
        let ends = (edge.from.map(|from| block_of[from]), block_of[edge.to]);
        // What goes from block to block within a frame is not shown.
        let is_inside = ends.0 == Some(ends.1) && edge.from != Some(edge.to);
        if !is_inside {
            let lines = merged.entry(ends).or_default();
            for line in &edge.label {
                if !lines.contains(line) {
                    lines.push(line.clone());
                }
            }
        }
    }
    let edges = merged.into_iter();
    whole.edges = edges
        .map(|((from, to), label)| Edge { from, to, label })
        .collect();
    whole
}

/// Lists blocks with what goes from them. `reason` says why they are not drawn.
pub(super) fn list(graph: &Graph, reason: &str, limit: f64) -> Canvas {
    let mut canvas = Canvas::default();
    table::caption(
        &mut canvas,
        &format!("A list in place of a drawing: {reason}"),
    );
    let heading = |state: usize| graph.states[state].first().map_or("", String::as_str);
    let entries = graph.states.iter().enumerate().map(|(state, label)| {
        let mut lines = text::wrap(label, WIDTH);
        for edge in graph.edges.iter().filter(|edge| edge.from == Some(state)) {
            let to = heading(edge.to);
            let line = match edge.label.as_slice() {
                [] => format!("to {to}"),
                label => format!("to {to}: {}", label.join(", ")),
            };
            lines.extend(text::wrap(&[line], WIDTH));
        }
        Entry {
            key: format!("#{}", state + 1),
            lines,
        }
    });
    canvas.add_below(GAP, columns(&entries.collect::<Vec<_>>(), limit));
    canvas
}
