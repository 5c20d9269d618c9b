//! Labelled state graphs as Graphviz text and as pictures, timing diagrams and Gantt charts. The
//! callers decide what the graphs show.

mod blocks;
mod canvas;
pub mod dot;
pub mod fold;
pub mod gantt;
mod layered;
pub mod layers;
mod legend;
mod outline;
pub mod svg;
mod table;
mod text;
pub mod timing;

/// States and edges with their labels, independent of the output format.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Graph {
    /// Label of each state, as lines.
    pub states: Vec<Vec<String>>,
    /// Edges, including those that lead to the initial states.
    pub edges: Vec<Edge>,
    /// How each state looks in SVG; [`BoxStyle::State`] for those that are not listed.
    pub styles: Vec<BoxStyle>,
    /// Frames around states in SVG.
    pub frames: Vec<Frame>,
}

impl Graph {
    /// Returns the part of the graph around a state: the states that at most `steps` edges, in
    /// either direction, separate from it, and the edges between them. Frames keep the states that
    /// are shown.
    #[must_use]
    pub fn around(&self, state: usize, steps: usize) -> Self {
        let mut is_near = vec![false; self.states.len()];
        is_near[state] = true;
        for _ in 0..steps {
            let mut wider = is_near.clone();
            for edge in &self.edges {
                let ends = edge.from.into_iter().chain([edge.to]);
                if ends.clone().any(|end| is_near[end]) {
                    ends.for_each(|end| wider[end] = true);
                }
            }
            is_near = wider;
        }
        let kept: Vec<usize> = (0..self.states.len()).filter(|s| is_near[*s]).collect();
        let number = |state: usize| kept.binary_search(&state).ok();
        let edges = self.edges.iter().filter_map(|edge| {
            let from = match edge.from {
                None => None,
                Some(from) => Some(number(from)?),
            };
            let to = number(edge.to)?;
            let label = edge.label.clone();
            Some(Edge { from, to, label })
        });
        Self {
            states: kept
                .iter()
                .map(|state| self.states[*state].clone())
                .collect(),
            styles: kept
                .iter()
                .filter_map(|state| self.styles.get(*state).copied())
                .collect(),
            edges: edges.collect(),
            frames: self.frames_around(number),
        }
    }

    /// Returns the frames with the states that have a new `number`, without those that are empty.
    fn frames_around(&self, number: impl Fn(usize) -> Option<usize>) -> Vec<Frame> {
        let mut kept: Vec<Frame> = self.frames.clone();
        let mut is_used: Vec<bool> = Vec::new();
        for frame in &mut kept {
            frame.states = frame.states.iter().copied().filter_map(&number).collect();
            is_used.push(!frame.states.is_empty());
        }
        // A frame follows the one around it.
        for (index, frame) in kept.iter().enumerate().rev() {
            if let Some(parent) = frame.parent
                && is_used[index]
            {
                is_used[parent] = true;
            }
        }
        let place = |frame: usize| is_used[..frame].iter().filter(|used| **used).count();
        let frames = kept.into_iter().enumerate();
        let frames = frames.filter(|(index, _)| is_used[*index]);
        frames
            .map(|(_, frame)| Frame {
                parent: frame.parent.map(place),
                ..frame
            })
            .collect()
    }

    /// Returns how a state looks.
    fn style(&self, state: usize) -> BoxStyle {
        self.styles.get(state).copied().unwrap_or_default()
    }
}

/// How a state, or what takes its place in other graphs, looks in SVG.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoxStyle {
    /// State of an automaton.
    #[default]
    State,
    /// Component of a machine that decides what the others do: with a double border.
    Coordinator,
    /// Component of a machine, or place of a line: with sharp corners.
    Block,
    /// Component of a machine that only observes: with a dashed border.
    Observer,
    /// Beginning or end of what the graph shows: with round ends.
    Terminal,
    /// Conveyor with this number of places, with marks between them.
    Conveyor(u32),
}

/// A frame around some of the states, such as the components of an inner machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Title shown in the frame.
    pub title: String,
    /// Index of the frame around it; a frame follows the one around it.
    pub parent: Option<usize>,
    /// The states in it that are not in a frame within it.
    pub states: Vec<usize>,
}

/// An edge of a [`Graph`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    /// Source state; `None` for an edge to an initial state, which is drawn from a dot.
    pub from: Option<usize>,
    /// Target state.
    pub to: usize,
    /// Label, as lines.
    pub label: Vec<String>,
}

/// One of several graphs shown side by side, such as the parallel regions of a statechart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Title shown on the region.
    pub title: String,
    /// Graph shown in the region.
    pub graph: Graph,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_around_a_state_keeps_its_frames() {
        let frame = |title: &str, parent: Option<usize>, states: &[usize]| Frame {
            title: title.to_owned(),
            parent,
            states: states.to_vec(),
        };
        let edge = |from: usize| Edge {
            from: Some(from),
            to: from + 1,
            label: Vec::new(),
        };
        let graph = Graph {
            states: (0..5).map(|state| vec![format!("S{state}")]).collect(),
            edges: (0..4).map(edge).collect(),
            frames: vec![
                frame("far", None, &[0]),
                frame("outer", None, &[]),
                frame("inner", Some(1), &[2, 3]),
            ],
            ..Graph::default()
        };
        let around = graph.around(4, 1);
        assert_eq!(around.states, [["S3"], ["S4"]]);
        let wanted = [frame("outer", None, &[]), frame("inner", Some(0), &[0])];
        assert_eq!(around.frames, wanted);
    }
}
