//! A graph as an SVG picture that fits on a page, in the first of these forms that does: in layers,
//! with narrower labels, with keys in place of labels and a legend, as an outline in which states
//! with the same outputs are one box, or as a table and a matrix.

use super::canvas::{Canvas, MARGIN, REGION, STATE_FONT, Shape};
use super::layered::{self, Form};
use super::layers::{Point, Size};
use super::legend::{columns, with_keys};
use super::outline::Outline;
use super::{Graph, Region, blocks, table, text};

/// Maximum width of a picture in SVG units.
pub(super) const PAGE_WIDTH: f64 = 1600.0;

/// Distance between regions, and padding inside a region, in SVG units.
pub(super) const GAP: f64 = 12.0;

/// Maximum number of states in a drawing in layers; more are a wall that nobody reads.
const MAX_STATES: usize = 60;

/// Maximum number of edges in a drawing in layers. The time of the placement grows faster than the
/// square of their number.
const MAX_EDGES: usize = 120;

/// How large a drawing with frames may be in proportion to the one without them, with room for each
/// frame in SVG units. Frames that scatter the states hide more than they show.
const FRAMES: f64 = 1.1;
const FRAME_ROOM: f64 = 40.0;

/// Maximum number of edges of a graph that is drawn with frames of goals. The placement of larger
/// ones takes longer, and their frames hardly ever fit.
const MAX_FRAMED_EDGES: usize = 60;

/// Maximum numbers of boxes and edges of a drawing in rows, which is read along its ways, and whose
/// placement is simpler.
const MAX_IN_ROWS: (usize, usize) = (200, 300);

/// Maximum number of characters in a line of a narrow label.
const NARROW: usize = 24;

/// Maximum number of characters in a line of the title of a region.
const TITLE: usize = 60;

/// Draws a graph and returns the SVG document, which is at most 1,600 units wide. Takes at most
/// some seconds: graphs that are too large for a drawing in layers become outlines or tables.
pub fn render(name: &str, graph: &Graph) -> String {
    picture(graph, PAGE_WIDTH - 2.0 * MARGIN).document(name)
}

/// Draws blocks and what goes from one to another, such as the components of a machine, in layers.
/// If they are too many, or the drawing is too wide, each outermost frame is one block, or there is
/// a list in place of a drawing.
pub fn render_blocks(name: &str, graph: &Graph) -> String {
    blocks::picture(graph, Form::Layers, PAGE_WIDTH - 2.0 * MARGIN).document(name)
}

/// Draws blocks as [`render_blocks`] does, but from left to right in rows, such as the places of a
/// line. Frames are not drawn.
pub fn render_rows(name: &str, graph: &Graph) -> String {
    blocks::picture(graph, Form::Rows, PAGE_WIDTH - 2.0 * MARGIN).document(name)
}

/// Draws regions side by side, each in a frame with its title, in as many rows as needed.
pub fn render_regions(name: &str, regions: &[Region]) -> String {
    regions_picture(regions).document(name)
}

fn regions_picture(regions: &[Region]) -> Canvas {
    let limit = PAGE_WIDTH - 2.0 * MARGIN;
    let mut whole = Canvas::default();
    let mut row = Canvas::default();
    for region in regions {
        let framed = framed(region, limit);
        let mut x = row.size.width + if row.shapes.is_empty() { 0.0 } else { GAP };
        if x > 0.0 && x + framed.size.width > limit {
            whole.add_below(GAP, std::mem::take(&mut row));
            x = 0.0;
        }
        row.add(Point { x, y: 0.0 }, framed);
    }
    whole.add_below(GAP, row);
    whole
}

/// Draws a region in its frame.
fn framed(region: &Region, limit: f64) -> Canvas {
    let inside = picture(&region.graph, limit - 2.0 * GAP);
    let title = text::wrap(std::slice::from_ref(&region.title), TITLE);
    let title_size = text::size(&title, STATE_FONT, true);
    let mut canvas = Canvas::default();
    canvas.size.width = inside.size.width.max(title_size.width) + 2.0 * GAP;
    canvas.size.height = title_size.height + inside.size.height + GAP;
    let corner = Point { x: 0.0, y: 0.0 };
    let size = canvas.size;
    canvas.shapes.push(Shape::Rectangle(corner, size, REGION));
    let x = size.width / 2.0;
    let y = title_size.height / 2.0;
    canvas.lines(Point { x, y }, &title, STATE_FONT, true);
    let at = Point {
        x: (size.width - inside.size.width) / 2.0,
        y: title_size.height,
    };
    canvas.add(at, inside);
    canvas
}

/// Draws a graph within a width in SVG units. If its frames take too much room, their titles stand
/// in the states.
fn picture(graph: &Graph, limit: f64) -> Canvas {
    let plain = &without_frames(graph);
    let drawn = in_layers(plain, Form::Layers, limit);
    let area = |Size { width, height }: Size, room: f64| (width + room) * (height + room);
    let room = FRAME_ROOM * graph.frames.len() as f64;
    if !graph.frames.is_empty()
        && graph.edges.len() <= MAX_FRAMED_EDGES
        && let Ok(framed) = in_layers(graph, Form::Layers, limit)
        && drawn
            .as_ref()
            .is_ok_and(|drawn| area(framed.size, 0.0) <= FRAMES * area(drawn.size, room))
    {
        return framed;
    }
    let (graph, reason) = match drawn {
        Ok(canvas) => return canvas,
        Err(reason) => (plain, reason),
    };
    let outline = Outline::new(graph);
    if outline.is_useful(graph)
        && let Ok(drawn) = in_layers(&outline.graph, Form::Layers, limit)
    {
        let mut canvas = Canvas::default();
        let shown = outline.caption(graph);
        table::caption(&mut canvas, &format!("{shown}: {reason}"));
        canvas.add_below(GAP, drawn);
        return canvas;
    }
    table::draw(graph, &outline, &reason, limit)
}

/// Appends the titles of the frames to the headings of their states in place of the frames.
fn without_frames(graph: &Graph) -> Graph {
    let mut plain = graph.clone();
    for frame in std::mem::take(&mut plain.frames) {
        for state in frame.states {
            if let Some(heading) = plain.states[state].first_mut() {
                *heading = format!("{heading} {}", frame.title);
            }
        }
    }
    plain
}

/// Draws a graph as it is, if its labels can be made narrow enough for the width.
///
/// # Errors
/// Why it is not drawn.
pub(super) fn in_layers(graph: &Graph, form: Form, limit: f64) -> Result<Canvas, String> {
    let (max_states, max_edges) = match form {
        Form::Layers => (MAX_STATES, MAX_EDGES),
        Form::Rows => MAX_IN_ROWS,
    };
    if graph.states.len() > max_states {
        let kind = match graph.styles.as_slice() {
            [] => "states",
            _ => "boxes",
        };
        return Err(format!("more than {max_states} {kind} are not drawn"));
    }
    if graph.edges.len() > max_edges {
        return Err(format!("more than {max_edges} edges are not drawn"));
    }
    let fits = |canvas: &Canvas| canvas.size.width <= limit;
    let whole = layered::draw(graph, form, limit);
    if fits(&whole) {
        return Ok(whole);
    }
    let narrow = narrow(graph);
    let drawn = layered::draw(&narrow, form, limit);
    if fits(&drawn) {
        return Ok(drawn);
    }
    // The legend has room for the original lines of the labels.
    let (mut keyed, legend) = with_keys(graph);
    keyed.states = narrow.states;
    let mut drawn = layered::draw(&keyed, form, limit);
    if fits(&drawn) {
        drawn.add_below(2.0 * GAP, columns(&legend, limit));
    }
    if fits(&drawn) {
        return Ok(drawn);
    }
    Err("the drawing of all of them would be too wide".to_owned())
}

/// Wraps the lines of all labels.
fn narrow(graph: &Graph) -> Graph {
    let mut graph = graph.clone();
    for state in &mut graph.states {
        *state = text::wrap(state, NARROW);
    }
    for edge in &mut graph.edges {
        edge.label = text::wrap(&edge.label, NARROW);
    }
    graph
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::canvas::{Anchor, Text};
    use super::super::{BoxStyle, Edge, Frame};
    use super::*;
    use proptest::prelude::*;

    const LIMIT: f64 = PAGE_WIDTH - 2.0 * MARGIN;

    /// Left, top, right and bottom of a text.
    fn frame(text: &Text) -> [f64; 4] {
        let width = text::width(&text.content, text.font, text.is_bold);
        let left = match text.anchor {
            Anchor::Start => text.at.x,
            Anchor::Middle => text.at.x - width / 2.0,
        };
        let (top, bottom) = (text.at.y - 0.75 * text.font, text.at.y + 0.25 * text.font);
        [left, top, left + width, bottom]
    }

    /// Returns what is wrong with a picture: a text on another one, something outside.
    pub fn faults(canvas: &Canvas) -> Vec<String> {
        let Size { width, height } = canvas.size;
        let is_in =
            |at: Point| at.x > -0.1 && at.y > -0.1 && at.x < width + 0.1 && at.y < height + 0.1;
        let mut faults = Vec::new();
        let mut frames: Vec<(&str, [f64; 4])> = Vec::new();
        for shape in &canvas.shapes {
            let is_inside = match shape {
                Shape::Text(text) => {
                    let [x, y, right, bottom] = frame(text);
                    frames.push((&text.content, frame(text)));
                    is_in(Point { x, y })
                        && is_in(Point {
                            x: right,
                            y: bottom,
                        })
                }
                Shape::Rectangle(corner, size, _) | Shape::Titled(corner, size, ..) => {
                    let x = corner.x + size.width;
                    let y = corner.y + size.height;
                    is_in(*corner) && is_in(Point { x, y })
                }
                Shape::Line(points, _) | Shape::Arrow(points) | Shape::Route(points) => {
                    points.iter().all(|at| is_in(*at))
                }
                Shape::Dot(at) => is_in(*at),
            };
            if !is_inside {
                faults.push(format!("outside: {shape:?}"));
            }
        }
        for (index, (a, first)) in frames.iter().enumerate() {
            for (b, second) in &frames[index + 1..] {
                let overlap = |low: usize, high: usize| {
                    first[high].min(second[high]) - first[low].max(second[low]) > 0.1
                };
                if overlap(0, 2) && overlap(1, 3) {
                    faults.push(format!("{a:?} is on {b:?}"));
                }
            }
        }
        faults
    }

    pub fn texts(canvas: &Canvas) -> Vec<&str> {
        let mut texts = Vec::new();
        for shape in &canvas.shapes {
            if let Shape::Text(text) = shape {
                texts.push(text.content.as_str());
            }
        }
        texts
    }

    /// A ring of states in which each state also has a loop and chords. `lines` is the number of
    /// lines of each label, `groups` that of different outputs.
    fn ring(count: usize, chords: usize, lines: usize, groups: usize) -> Graph {
        let state = |s| vec![format!("S{s}"), format!("speed = {}, !turning", s % groups)];
        let edge = |from: usize, to: usize| {
            let line = format!("command != move & grip & tx = {from} & ty != {to}");
            Edge {
                from: Some(from),
                to,
                label: vec![line; lines],
            }
        };
        let mut edges = vec![Edge {
            from: None,
            to: 0,
            label: vec!["true".to_owned()],
        }];
        for from in 0..count {
            edges.push(edge(from, from));
            edges.extend((0..chords).map(|chord| edge(from, (from + 1 + 3 * chord) % count)));
        }
        Graph {
            states: (0..count).map(state).collect(),
            edges,
            ..Graph::default()
        }
    }

    #[test]
    fn a_small_graph_keeps_its_labels() {
        let canvas = picture(&ring(3, 1, 1, 3), LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let label = "command != move & grip & tx = 0 & ty != 1";
        assert!(texts(&canvas).contains(&label));
    }

    #[test]
    fn wide_labels_become_narrow_and_then_keys() {
        let graph = ring(12, 4, 1, 12);
        let canvas = picture(&graph, LIMIT);
        assert!(canvas.size.width <= LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        // The picture and the legend.
        let count = |text: &str| texts(&canvas).iter().filter(|t| **t == text).count();
        assert_eq!(count("b"), 2);
        assert_eq!(count("aa"), 2);
    }

    #[test]
    fn equal_labels_have_one_key() {
        let mut graph = ring(12, 4, 1, 12);
        for edge in &mut graph.edges {
            edge.label = vec!["x".repeat(47); 2];
        }
        let canvas = picture(&graph, LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let texts = texts(&canvas);
        assert!(texts.contains(&"a") && !texts.contains(&"b"));
    }

    #[test]
    fn regions_are_in_rows() {
        let region = |number: usize| Region {
            title: format!("Rule {number}"),
            graph: ring(4, 2, 1, 4),
        };
        let canvas = regions_picture(&[0, 1, 2, 3].map(region));
        assert!(canvas.size.width <= LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let svg = render_regions("Rules", &[0, 1, 2, 3].map(region));
        assert!(svg.contains("Rule 3"));
    }

    #[test]
    fn many_states_become_groups_of_equal_outputs() {
        let canvas = picture(&ring(69, 0, 1, 4), LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let texts = texts(&canvas);
        assert_eq!(
            texts[0],
            "69 states in 4 groups of equal outputs: more than 60 states are not drawn"
        );
        assert!(texts.contains(&"18 states"));
        assert!(texts.contains(&"S1, S5, S9, S13, S17, S21, S25, S29, S33, ..."));
        assert!(texts.contains(&"18 edges"));
    }

    #[test]
    fn many_groups_become_a_table_and_a_matrix() {
        let canvas = picture(&ring(90, 1, 2, 90), LIMIT);
        assert!(canvas.size.width <= LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let texts = texts(&canvas);
        assert!(texts.contains(&"speed = 89, !turning"));
        let count = |text: &str| texts.iter().filter(|t| **t == text).count();
        // In the table, once as a column, and as a row of two blocks.
        assert_eq!(count("S44"), 4);
        // The last of 181 labels, in its cell and in the legend.
        assert_eq!(count("fy"), 2);
    }

    #[test]
    fn parallel_edges_are_counted_in_the_matrix() {
        let mut graph = ring(61, 1, 1, 61);
        graph.edges.extend(graph.edges.clone());
        let canvas = picture(&graph, LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let twos = texts(&canvas).iter().filter(|text| **text == "2").count();
        assert_eq!(twos, 1 + 2 * 61);
    }

    #[test]
    fn a_matrix_that_would_be_too_large_is_left_out_with_the_reason() {
        let canvas = picture(&ring(1000, 1, 1, 300), LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let reason = "There is no matrix of the edges, because there are more than 200 states.";
        assert!(texts(&canvas).contains(&reason));
    }

    #[test]
    fn long_names_have_numbers_in_the_matrix() {
        let mut graph = ring(70, 1, 1, 70);
        graph.states[7][0] = "W".repeat(300);
        let canvas = picture(&graph, LIMIT);
        assert!(canvas.size.width <= LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let texts = texts(&canvas);
        assert!(texts.contains(&"#69") && texts.contains(&"#69 S69"));
    }

    #[test]
    fn a_graph_without_states_is_an_empty_picture() {
        assert_eq!(picture(&Graph::default(), LIMIT), Canvas::default());
    }

    /// Lines with short and long words.
    fn any_lines() -> impl Strategy<Value = Vec<String>> {
        prop::collection::vec("[a-zW!&|,<=]{1,12}( [a-z]{1,30}){0,4}", 0..4)
    }

    fn any_graph() -> impl Strategy<Value = Graph> {
        prop::collection::vec(any_lines(), 1..20).prop_flat_map(|states| {
            let count = states.len();
            let edge = (prop::option::of(0..count), 0..count, any_lines());
            let edge = edge.prop_map(|(from, to, label)| Edge { from, to, label });
            let edges = prop::collection::vec(edge, 0..40);
            edges.prop_map(move |edges| Graph {
                states: states.clone(),
                edges,
                ..Graph::default()
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn no_text_is_on_a_text_and_nothing_is_outside(graph in any_graph()) {
            let canvas = picture(&graph, LIMIT);
            prop_assert!(canvas.size.width <= LIMIT);
            prop_assert_eq!(faults(&canvas), [""; 0]);
            let outline = Outline::new(&graph);
            let canvas = table::draw(&graph, &outline, "for a test", LIMIT);
            prop_assert!(canvas.size.width <= LIMIT);
            prop_assert_eq!(faults(&canvas), [""; 0]);
        }
    }

    /// A graph with frames, some of them within others, and boxes of all styles.
    fn any_blocks() -> impl Strategy<Value = Graph> {
        (
            any_graph(),
            prop::collection::vec(0_usize..20, 20),
            0_usize..5,
        )
            .prop_map(|(graph, places, count)| {
                let frames = (0..count).map(|number| Frame {
                    title: format!("frame {number}"),
                    parent: (number % 3).checked_sub(1).filter(|_| number > 0),
                    states: (0..graph.states.len())
                        .filter(|state| places[*state] == number)
                        .collect(),
                });
                let styles = (0..graph.states.len()).map(|state| match state % 6 {
                    0 => BoxStyle::State,
                    1 => BoxStyle::Coordinator,
                    2 => BoxStyle::Block,
                    3 => BoxStyle::Observer,
                    4 => BoxStyle::Terminal,
                    _ => BoxStyle::Conveyor(state as u32),
                });
                let frames = frames.collect();
                let styles = styles.collect();
                Graph {
                    styles,
                    frames,
                    ..graph
                }
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn blocks_in_frames_and_in_rows_do_not_overlap(graph in any_blocks()) {
            for form in [Form::Layers, Form::Rows] {
                let canvas = blocks::picture(&graph, form, LIMIT);
                prop_assert!(canvas.size.width <= LIMIT);
                prop_assert_eq!(faults(&canvas), [""; 0]);
            }
            let canvas = blocks::list(&graph, "for a test", LIMIT);
            prop_assert!(canvas.size.width <= LIMIT);
            prop_assert_eq!(faults(&canvas), [""; 0]);
        }
    }

    /// A chain of boxes, every ten of them in a frame.
    fn framed_chain(count: usize) -> Graph {
        let frames = (0..count / 10).map(|number| Frame {
            title: format!("unit {number}"),
            parent: None,
            states: (10 * number..10 * number + 10).collect(),
        });
        let edges = (1..count).map(|to| Edge {
            from: Some(to - 1),
            to,
            label: vec![format!("signal {to}")],
        });
        Graph {
            states: (0..count).map(|n| vec![format!("part {n}")]).collect(),
            styles: vec![BoxStyle::Block; count],
            frames: frames.collect(),
            edges: edges.collect(),
        }
    }

    #[test]
    fn many_blocks_are_collapsed_and_more_are_listed() {
        let canvas = blocks::picture(&framed_chain(80), Form::Layers, LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let shown = texts(&canvas);
        let caption = "The blocks of each frame are shown as one: more than 60 boxes are not drawn";
        assert_eq!(shown[0], caption);
        assert!(shown.contains(&"unit 7") && shown.contains(&"signal 70"));
        assert!(!shown.contains(&"part 0") && !shown.contains(&"signal 71"));
        let canvas = blocks::picture(&framed_chain(700), Form::Layers, LIMIT);
        assert!(canvas.size.width <= LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let caption = "A list in place of a drawing: more than 60 boxes are not drawn";
        assert_eq!(texts(&canvas)[0], caption);
        assert!(texts(&canvas).contains(&"to part 699: signal 699"));
    }

    #[test]
    fn frames_of_states_are_drawn_if_they_fit() {
        let mut graph = framed_chain(20);
        graph.styles.clear();
        let canvas = picture(&graph, LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        assert!(texts(&canvas).contains(&"unit 1"));
        // States of two frames in turn would be far apart.
        for (number, frame) in graph.frames.iter_mut().enumerate() {
            frame.states = (0..10).map(|n| 2 * n + number).collect();
        }
        let canvas = picture(&graph, LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        assert!(texts(&canvas).contains(&"part 3 unit 1"));
    }

    #[test]
    fn too_many_edges_are_not_drawn() {
        let graph = ring(20, 6, 1, 20);
        assert!(graph.edges.len() > MAX_EDGES);
        assert!(in_layers(&graph, Form::Layers, LIMIT).is_err());
        let canvas = picture(&graph, LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let reason = "20 states in 20 groups of equal outputs: more than 120 edges are not drawn";
        assert_eq!(texts(&canvas)[0], reason);
    }
}
