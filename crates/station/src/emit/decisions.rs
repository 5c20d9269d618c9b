//! The tables of a controller as functions: decisions with shared parts, and their roots.
//!
//! Even large tables compile quickly, parts that are shared are stored only once, and a short loop
//! evaluates the decisions. The file that uses the tables declares their types.

use super::rows;
use super::text::wrap;
use linewright_solver::game::StrategyFunctions;
use linewright_solver::symbolic::{Bit, DiagramNode, Edge};
use serde::Serialize;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Formats the fields that identify the signal of a decision or an output.
pub(super) type Signals<'a> = &'a dyn Fn(Bit) -> String;

/// Rows of all tables. `computed` begins with the outputs of step 0.
#[derive(Serialize)]
pub(super) struct Tables {
    nodes: String,
    computed: String,
    modes: String,
    goals: String,
}

/// Like `Tables`, with the starts of walks instead of `computed`. The starts of step 0 come first,
/// then the starts of all modes.
#[derive(Serialize)]
pub(super) struct WalkTables {
    nodes: String,
    walks: String,
    modes: String,
    goals: String,
}

/// Number of nodes above which a line holds as many of them as fit, without spaces: nobody reads so
/// many, and the file is more than a quarter smaller.
const MANY_NODES: usize = 1_000;

fn nodes(nodes: &[DiagramNode], signal: Signals<'_>) -> String {
    if nodes.len() > MANY_NODES {
        let nodes = nodes.iter().fold(String::new(), |mut text, n| {
            let signal = signal(n.bit).replace(' ', "");
            let _ = write!(text, "{{{},{},{signal}}}, ", n.high.0, n.low.0);
            text
        });
        return format!("    {}", wrap(nodes.trim_end(), "    "));
    }
    let nodes = nodes
        .iter()
        .map(|n| format!("    {{ {}, {}, {} }},", n.high.0, n.low.0, signal(n.bit)));
    rows(&nodes.collect::<Vec<_>>(), "{ 0 }")
}

/// Renders two tables. The first holds the condition and the first output of each mode. The second
/// holds, for each goal, its first mode and the condition under which the goal is reached.
fn goals(goals: &[(Vec<(Edge, usize)>, Edge)]) -> (String, String) {
    let (mut modes, mut reached_goals) = (Vec::new(), Vec::new());
    for (of_goal, reached) in goals {
        reached_goals.push(format!("    {{ {}, {} }},", modes.len(), reached.0));
        let of_goal = of_goal.iter();
        modes.extend(of_goal.map(|(when, first)| format!("    {{ {}, {first} }},", when.0)));
    }
    (rows(&modes, "{ 0, 0 }"), rows(&reached_goals, "{ 0, 0 }"))
}

/// Renders the tables of decisions and outputs.
pub(super) fn tables(controls: &StrategyFunctions, signal: Signals<'_>) -> Tables {
    let row = |outputs: &[(Bit, Edge)]| -> String {
        let items = outputs
            .iter()
            .map(|(b, e)| format!("{{ {}, {} }}, ", e.0, signal(*b)));
        items.collect::<String>()
    };
    let count = controls.first.len();
    let mut outputs = vec![row(&controls.first)];
    let mut known: HashMap<String, usize> = HashMap::new();
    let mut pursued = Vec::new();
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
        pursued.push((modes, goal.reached));
    }
    let outputs: Vec<String> = outputs
        .iter()
        .filter(|row| !row.is_empty())
        .map(|row| format!("    {}", wrap(row.trim_end(), "    ")))
        .collect();
    let (modes, goals) = goals(&pursued);
    Tables {
        nodes: nodes(&controls.diagram.nodes, signal),
        computed: rows(&outputs, "{ 0 }"),
        modes,
        goals,
    }
}

/// Renders the tables of decisions and of the starts of walks. `starts` lists the starts for step
/// 0, then for all modes, goal by goal. The table of the walks themselves is not included.
pub(super) fn walk_tables(
    controls: &StrategyFunctions,
    signal: Signals<'_>,
    starts: &[Vec<usize>],
) -> WalkTables {
    let pursued = &controls.goals;
    let edges: Vec<Edge> = pursued
        .iter()
        .flat_map(|g| g.modes.iter().map(|m| m.when).chain([g.reached]))
        .collect();
    let diagram = controls.diagram.extract_roots(&edges);
    let mut known: HashMap<&[usize], usize> = HashMap::new();
    let (mut list, mut count) = (Vec::new(), 0);
    let mut places: Vec<usize> = Vec::new();
    for starts in starts {
        let place = *known.entry(starts).or_insert(count);
        if place == count {
            let numbers = starts
                .iter()
                .fold(String::new(), |s, n| s + &format!("{n}, "));
            list.push(format!("    {}", wrap(&format!("{numbers}0,"), "    ")));
            count += starts.len() + 1;
        }
        places.push(place);
    }
    let (mut edges, mut starts) = (diagram.roots.as_slice(), &places[1..]);
    let mut reached = Vec::new();
    for goal in pursued {
        let count = goal.modes.len();
        let modes = edges.iter().copied().zip(starts.iter().copied());
        reached.push((modes.take(count).collect(), edges[count]));
        (edges, starts) = (&edges[count + 1..], &starts[count..]);
    }
    let (modes, goals) = goals(&reached);
    WalkTables {
        nodes: nodes(&diagram.nodes, signal),
        walks: rows(&list, "0"),
        modes,
        goals,
    }
}
