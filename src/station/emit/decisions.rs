//! The tables of a controller as functions: decisions with shared parts, and which of them give what.
//!
//! Tables rather than code: they compile in a moment whatever their size, what is shared is there once, and a short loop walks
//! them. The types are declared by whoever reads the tables.

use super::table;
use super::text::wrap;
use crate::game::Controls;
use crate::symbolic::{Bit, Edge};
use std::collections::HashMap;

/// How types and tables are named.
#[derive(Debug, Clone, Copy)]
pub(super) struct Naming<'a> {
    /// Begins the names of the types: `lw_`.
    pub types: &'a str,
    /// Begins the names of the tables: `c1_turn_`.
    pub tables: &'a str,
}

/// Writes the tables `nodes`, `computed`, `modes` and `goals`. The first rows of `computed` are the outputs of step 0.
pub(super) fn tables(out: &mut String, controls: &Controls, naming: Naming<'_>) {
    let kind = |name: &str| format!("{}{name}", naming.types);
    let named = |name: &str| format!("{}{name}", naming.tables);
    let nodes = controls.diagram.nodes.iter();
    let nodes: Vec<String> = nodes
        .map(|n| format!("    {{ {}, {}, {} }},\n", n.high.0, n.low.0, n.bit.0))
        .collect();
    table(out, &kind("node"), &named("nodes"), &nodes, "{ 0, 0, 0 }");
    let row = |outputs: &[(Bit, Edge)]| -> String {
        let items = outputs.iter();
        let items = items.map(|(b, e)| format!("{{ {}, {} }}, ", e.0, b.0));
        items.collect::<String>()
    };
    let count = controls.first.len();
    let mut outputs = vec![row(&controls.first)];
    let (mut modes, mut goals) = (Vec::new(), Vec::new());
    let mut known: HashMap<String, usize> = HashMap::new();
    for goal in &controls.goals {
        goals.push(format!("    {{ {}, {} }},\n", modes.len(), goal.reached.0));
        for mode in &goal.modes {
            let text = row(&mode.outputs);
            let fresh = outputs.len();
            let place = *known.entry(text.clone()).or_insert(fresh);
            if place == fresh {
                outputs.push(text);
            }
            modes.push(format!("    {{ {}, {} }},\n", mode.when.0, place * count));
        }
    }
    let outputs: Vec<String> = outputs
        .iter()
        .filter(|row| !row.is_empty())
        .map(|row| format!("    {}\n", wrap(row.trim_end(), "    ")))
        .collect();
    out.push_str(
        "/* The outputs of step 0 and of the modes, in the order in which they are computed. */\n",
    );
    table(
        out,
        &kind("output"),
        &named("computed"),
        &outputs,
        "{ 0, 0 }",
    );
    table(out, &kind("mode"), &named("modes"), &modes, "{ 0, 0 }");
    table(out, &kind("goal"), &named("goals"), &goals, "{ 0, 0 }");
}
