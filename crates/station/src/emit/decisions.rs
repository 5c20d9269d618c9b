//! The tables of a controller as functions: decisions with shared parts, and which of them give what.
//!
//! Tables rather than code: they compile in a moment whatever their size, what is shared is there once, and a short loop walks
//! them. The types are declared by whoever reads the tables.

use super::table;
use super::text::wrap;
use linewright_solver::game::Controls;
use linewright_solver::symbolic::{Bit, DiagramNode, Edge};
use std::collections::HashMap;

/// How types and tables are named, and signals written.
#[derive(Clone, Copy)]
pub(super) struct Naming<'a> {
    /// Begins the names of the types: `lw_`.
    pub types: &'a str,
    /// Begins the names of the tables: `c1_turn_`.
    pub tables: &'a str,
    /// The fields that say which signal a decision or an output is about.
    pub signal: &'a dyn Fn(Bit) -> String,
}

impl Naming<'_> {
    fn kind(&self, name: &str) -> String {
        format!("{}{name}", self.types)
    }

    fn table(&self, name: &str) -> String {
        format!("{}{name}", self.tables)
    }

    /// Writes the table `nodes`.
    pub fn nodes(&self, out: &mut String, nodes: &[DiagramNode]) {
        let nodes = nodes.iter().map(|n| {
            let signal = (self.signal)(n.bit);
            format!("    {{ {}, {}, {signal} }},\n", n.high.0, n.low.0)
        });
        let (kind, name) = (self.kind("node"), self.table("nodes"));
        table(out, &kind, &name, &nodes.collect::<Vec<_>>(), "{ 0 }");
    }

    /// Writes the tables `modes` and `goals`: when each mode is taken and where its outputs begin, and when a goal is reached.
    pub fn goals(&self, out: &mut String, goals: &[(Vec<(Edge, usize)>, Edge)]) {
        let (mut modes, mut rows) = (Vec::new(), Vec::new());
        for (of_goal, reached) in goals {
            rows.push(format!("    {{ {}, {} }},\n", modes.len(), reached.0));
            for (when, first) in of_goal {
                modes.push(format!("    {{ {}, {first} }},\n", when.0));
            }
        }
        let names = [("mode", "modes", modes), ("goal", "goals", rows)];
        for (kind, name, rows) in names {
            let (kind, name) = (self.kind(kind), self.table(name));
            table(out, &kind, &name, &rows, "{ 0, 0 }");
        }
    }
}

/// Writes the tables `nodes`, `computed`, `modes` and `goals`. The first rows of `computed` are the outputs of step 0.
pub(super) fn tables(out: &mut String, controls: &Controls, naming: Naming<'_>) {
    naming.nodes(out, &controls.diagram.nodes);
    let row = |outputs: &[(Bit, Edge)]| -> String {
        let items = outputs.iter();
        let items = items.map(|(b, e)| format!("{{ {}, {} }}, ", e.0, (naming.signal)(*b)));
        items.collect::<String>()
    };
    let count = controls.first.len();
    let mut outputs = vec![row(&controls.first)];
    let mut known: HashMap<String, usize> = HashMap::new();
    let mut goals = Vec::new();
    for goal in &controls.goals {
        let mut modes = Vec::new();
        for mode in &goal.modes {
            let text = row(&mode.outputs);
            let fresh = outputs.len();
            let place = *known.entry(text.clone()).or_insert(fresh);
            if place == fresh {
                outputs.push(text);
            }
            modes.push((mode.when, place * count));
        }
        goals.push((modes, goal.reached));
    }
    let outputs: Vec<String> = outputs
        .iter()
        .filter(|row| !row.is_empty())
        .map(|row| format!("    {}\n", wrap(row.trim_end(), "    ")))
        .collect();
    out.push_str(
        "/* The outputs of step 0 and of the modes, in the order in which they are computed. */\n",
    );
    let (kind, name) = (naming.kind("output"), naming.table("computed"));
    table(out, &kind, &name, &outputs, "{ 0 }");
    naming.goals(out, &goals);
}

/// The same with walks in the place of `computed`: `walks` lists where those of step 0 and of all modes, goal by goal, begin. Their own
/// table is written elsewhere.
pub(super) fn around_walks(
    out: &mut String,
    controls: &Controls,
    naming: Naming<'_>,
    starts: &[Vec<usize>],
) {
    let goals = &controls.goals;
    let edges: Vec<Edge> = goals
        .iter()
        .flat_map(|g| g.modes.iter().map(|m| m.when).chain([g.reached]))
        .collect();
    let diagram = controls.diagram.keeping(&edges);
    naming.nodes(out, &diagram.nodes);
    let mut known: HashMap<&[usize], usize> = HashMap::new();
    let (mut list, mut count) = (Vec::new(), 0);
    let mut places: Vec<usize> = Vec::new();
    for starts in starts {
        let place = *known.entry(starts).or_insert(count);
        if place == count {
            let numbers = starts
                .iter()
                .fold(String::new(), |s, n| s + &format!("{n}, "));
            list.push(format!("    {}\n", wrap(&format!("{numbers}0,"), "    ")));
            count += starts.len() + 1;
        }
        places.push(place);
    }
    out.push_str("/* Where the walks of step 0 begin, and those of the modes. */\n");
    table(out, "uint32_t", &naming.table("walks"), &list, "0");
    let (mut edges, mut starts) = (diagram.roots.as_slice(), &places[1..]);
    let mut rows = Vec::new();
    for goal in goals {
        let count = goal.modes.len();
        let modes = edges.iter().copied().zip(starts.iter().copied());
        rows.push((modes.take(count).collect(), edges[count]));
        (edges, starts) = (&edges[count + 1..], &starts[count..]);
    }
    naming.goals(out, &rows);
}
