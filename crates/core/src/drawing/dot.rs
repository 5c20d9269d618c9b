//! A graph as Graphviz text.

use super::{Graph, Region};
use std::fmt::Write as _;

/// Renders a graph, in the Graphviz language.
pub fn render(name: &str, graph: &Graph) -> String {
    let mut text = head(name, "LR");
    text.push_str("  start [shape=point, label=\"\"];\n");
    body(&mut text, graph, "", "  ");
    text.push_str("}\n");
    text
}

/// Renders regions, each as a cluster with its title.
pub fn render_regions(name: &str, regions: &[Region]) -> String {
    let mut text = head(name, "TB");
    for (number, region) in regions.iter().enumerate() {
        let title = quoted(std::slice::from_ref(&region.title));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  subgraph cluster_{number} {{\n    label={title}; style=dashed;\n    r{number}_start [shape=point, label=\"\"];"
        );
        body(&mut text, &region.graph, &format!("r{number}_"), "    ");
        text.push_str("  }\n");
    }
    text.push_str("}\n");
    text
}

fn head(name: &str, direction: &str) -> String {
    let name = quoted(&[name.to_owned()]);
    format!(
        "digraph {name} {{\n  rankdir={direction};\n  node [shape=box, style=rounded, fontname=\"sans-serif\", fontsize=11];\n  \
         edge [fontname=\"sans-serif\", fontsize=9];\n"
    )
}

fn body(text: &mut String, graph: &Graph, prefix: &str, indent: &str) {
    for (number, label) in graph.states.iter().enumerate() {
        let _ = writeln!(text, "{indent}{prefix}s{number} [label={}];", quoted(label));
    }
    for edge in &graph.edges {
        let from = edge.from.map_or("start".to_owned(), |s| format!("s{s}"));
        let _ = writeln!(
            text,
            "{indent}{prefix}{from} -> {prefix}s{} [label={}];",
            edge.to,
            quoted(&edge.label)
        );
    }
    for (number, frame) in graph.frames.iter().enumerate() {
        if frame.parent.is_none() {
            cluster(text, graph, number, prefix, indent);
        }
    }
}

/// Adds a frame, with the frames in it, as a cluster.
fn cluster(text: &mut String, graph: &Graph, number: usize, prefix: &str, indent: &str) {
    let frame = &graph.frames[number];
    let title = quoted(std::slice::from_ref(&frame.title));
    let _ = writeln!(
        text,
        "{indent}subgraph cluster_{prefix}frame{number} {{\n{indent}  label={title}; style=dashed;"
    );
    for state in &frame.states {
        let _ = writeln!(text, "{indent}  {prefix}s{state};");
    }
    let deeper = format!("{indent}  ");
    let inner = graph.frames.iter().enumerate();
    for (inner, _) in inner.filter(|(_, inner)| inner.parent == Some(number)) {
        cluster(text, graph, inner, prefix, &deeper);
    }
    let _ = writeln!(text, "{indent}}}");
}

/// Joins lines into one quoted label.
fn quoted(lines: &[String]) -> String {
    let lines = lines.iter();
    let escaped: Vec<String> = lines
        .map(|l| l.replace('\\', "\\\\").replace('"', "\\\""))
        .collect();
    format!("\"{}\"", escaped.join("\\n"))
}

#[cfg(test)]
mod tests {
    use super::super::Frame;
    use super::*;

    #[test]
    fn frames_are_clusters_with_those_in_them() {
        let frame = |title: &str, parent: Option<usize>, states: Vec<usize>| Frame {
            title: title.to_owned(),
            parent,
            states,
        };
        let graph = Graph {
            states: (0..3).map(|state| vec![format!("S{state}")]).collect(),
            frames: vec![
                frame("for \"home\"", None, vec![0]),
                frame("inner", Some(0), vec![2]),
            ],
            ..Graph::default()
        };
        let text = render("Turn", &graph);
        let clusters = text.find("  subgraph").map(|at| &text[at..]);
        let wanted = r#"  subgraph cluster_frame0 {
    label="for \"home\""; style=dashed;
    s0;
    subgraph cluster_frame1 {
      label="inner"; style=dashed;
      s2;
    }
  }
}
"#;
        assert_eq!(clusters, Some(wanted), "{text}");
    }
}
