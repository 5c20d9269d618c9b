//! Every contract of the library, and every contract, machine, line and skill set of the examples
//! is drawn, and each drawing is read back: it is at most 1,600 units wide, no text is on another
//! one, and nothing is outside. The pictures of the guide are what their commands draw.

use super::support;
use super::support::files_below;
use linewright::contract::{Library, load, picture as machine_picture};
use linewright::diagnostics::Diagnostic;
use linewright::gr1::{Time, VarId};
use linewright::line::picture as line_picture;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Maximum width of a drawing, in its units.
const MAX_WIDTH: f64 = 1600.0;

/// Rounding error that is no overlap, in the same units.
const TOLERANCE: f64 = 0.2;

/// What is not drawn, with what the message says.
const NOT_DRAWN: [(&str, &str); 1] = [(
    "examples/ice-lab/holistic.lw",
    "`HolisticCell` is realizable, but its controller was not extracted: the machine is too large to be listed state by state",
)];

/// Left, top, right and bottom.
type Frame = [f64; 4];

/// A drawing as it was read.
#[derive(Default)]
pub(super) struct Drawing {
    size: (f64, f64),
    /// Distance of the upper left corner from the origin.
    margin: f64,
    pub(super) texts: Vec<(String, Frame)>,
    /// Boxes and the ends of arrows.
    shapes: Vec<Frame>,
}

/// The value of an attribute; the empty text if there is none.
fn attribute(element: &BytesStart<'_>, name: &str) -> String {
    let found = element.try_get_attribute(name).expect("an attribute");
    found.map_or(String::new(), |found| found.value.into_owned())
}

fn number(element: &BytesStart<'_>, name: &str) -> f64 {
    let text = attribute(element, name);
    text.parse()
        .unwrap_or_else(|_| panic!("{name} is {text:?}"))
}

impl Drawing {
    pub(super) fn read(svg: &str) -> Self {
        let mut drawing = Self::default();
        let mut reader = Reader::from_str(svg);
        let mut open: Option<Frame> = None;
        loop {
            match reader.read_event().expect("an SVG document") {
                Event::Start(element) | Event::Empty(element) => {
                    open = drawing.element(&element);
                }
                Event::Text(text) => {
                    if let Some(frame) = open.take() {
                        drawing.texts.push((text.to_string(), frame));
                    }
                }
                Event::End(_) => {
                    // A text without letters.
                    drawing
                        .texts
                        .extend(open.take().map(|frame| (String::new(), frame)));
                }
                Event::Eof => return drawing,
                _ => {}
            }
        }
    }

    /// Reads an element; returns the frame of a text.
    fn element(&mut self, element: &BytesStart<'_>) -> Option<Frame> {
        match element.name().as_ref() {
            "svg" => {
                self.size = (number(element, "width"), number(element, "height"));
                let view = attribute(element, "viewBox");
                let left = view.split(' ').next().and_then(|x| x.parse::<f64>().ok());
                self.margin = -left.expect("a left border");
            }
            "rect" => {
                let (x, y) = (number(element, "x"), number(element, "y"));
                let (width, height) = (number(element, "width"), number(element, "height"));
                self.shapes.push([x, y, x + width, y + height]);
            }
            "circle" => {
                let (x, y) = (number(element, "cx"), number(element, "cy"));
                let radius = number(element, "r");
                self.shapes
                    .push([x - radius, y - radius, x + radius, y + radius]);
            }
            "path" => {
                let data = attribute(element, "d").replace(['M', 'L', 'Q'], " ");
                let numbers = data.split_whitespace().map(str::parse::<f64>);
                let numbers: Vec<f64> = numbers.map(|n| n.expect("a number")).collect();
                let points = numbers.chunks(2).map(|p| [p[0], p[1], p[0], p[1]]);
                self.shapes.extend(points);
            }
            "polyline" => {
                let points = attribute(element, "points").replace(',', " ");
                let numbers = points.split_whitespace().map(str::parse::<f64>);
                let numbers: Vec<f64> = numbers.map(|n| n.expect("a number")).collect();
                let points = numbers.chunks(2).map(|p| [p[0], p[1], p[0], p[1]]);
                self.shapes.extend(points);
            }
            "text" => {
                let (x, y) = (number(element, "x"), number(element, "y"));
                let font = number(element, "font-size");
                let width = attribute(element, "textLength").parse().unwrap_or(0.0);
                let is_start = attribute(element, "text-anchor") == "start";
                let left = if is_start { x } else { x - width / 2.0 };
                return Some([left, y - 0.75 * font, left + width, y + 0.25 * font]);
            }
            _ => {}
        }
        None
    }

    pub(super) fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let (width, height) = self.size;
        if width > MAX_WIDTH {
            faults.push(format!("it is {width} wide"));
        }
        // Width and height are rounded.
        let margin = self.margin + 0.6;
        let is_outside = |[left, top, right, bottom]: &Frame| {
            *left < -margin
                || *top < -margin
                || *right > width - self.margin + 0.6
                || *bottom > height - self.margin + 0.6
        };
        let texts = self.texts.iter().filter(|(_, frame)| is_outside(frame));
        faults.extend(texts.map(|(text, _)| format!("{text:?} is outside")));
        let shapes = self.shapes.iter().filter(|frame| is_outside(frame));
        faults.extend(shapes.map(|frame| format!("{frame:?} is outside")));
        for (index, (a, first)) in self.texts.iter().enumerate() {
            for (b, second) in &self.texts[index + 1..] {
                let overlap = |low: usize, high: usize| {
                    first[high].min(second[high]) - first[low].max(second[low]) > TOLERANCE
                };
                if overlap(0, 2) && overlap(1, 3) {
                    faults.push(format!("{a:?} is on {b:?}"));
                }
            }
        }
        faults
    }
}

/// What a file declares and imports, and what is found in it. Its name there is its path.
pub(super) fn loaded(path: &Path) -> (Library, Vec<Diagnostic>) {
    let text = std::fs::read_to_string(path).expect("a file");
    let files = [(path.display().to_string(), text)];
    load(&files, &|wanted, from| {
        let inner = wanted.strip_prefix("std.").map(|rest| {
            let relative = rest.replace('.', "/") + ".lw";
            support::root().join("contracts").join(relative)
        });
        let beside = || Path::new(from).with_file_name(wanted);
        let path = inner.unwrap_or_else(beside);
        let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
        Ok((path.display().to_string(), text))
    })
}

/// The names of what a file declares.
fn declared(path: &Path) -> Vec<String> {
    let (library, _) = loaded(path);
    let name = path.display().to_string();
    let is_own = |file| library.sources.file(file).name == name;
    let contracts = library.contracts.iter().map(|c| (&c.name, c.span));
    let machines = library.machines.iter().map(|m| (&m.name, m.span));
    let lines = library.lines.iter().map(|l| (&l.name, l.span));
    let skills = library.skills.iter().map(|s| (&s.name, s.span));
    let all = contracts.chain(machines).chain(lines).chain(skills);
    let own = all.filter(|(_, span)| is_own(span.file));
    own.map(|(name, _)| name.clone()).collect()
}

/// Each signal that a component reads is on an edge to it or in a box with an edge to it, and each
/// route of a line has its edge.
#[test]
fn all_wires_and_routes_are_drawn() {
    let mut counts = (0, 0);
    for path in files_below(&support::root().join("examples"), &["lw"]) {
        let (library, _) = loaded(&path);
        for machine in &library.machines {
            let graph = machine_picture::to_graph(machine);
            for (reader, component) in machine.components.iter().enumerate() {
                let edges = graph.edges.iter().filter(|edge| edge.to == reader);
                let shown: Vec<&String> = edges
                    .flat_map(|edge| {
                        let from = &graph.states[edge.from.expect("a box")];
                        edge.label.iter().chain(from)
                    })
                    .collect();
                let mut read = |wire: VarId, _: Time| {
                    let name = machine.wire_name(wire.index());
                    let last = name.rsplit('.').next().unwrap_or(&name);
                    let is_shown = shown
                        .iter()
                        .any(|text| text.split(' ').next() == Some(last));
                    assert!(is_shown, "{}: {name} to {}", machine.name, component.name);
                    counts.0 += 1;
                };
                let bindings = component.bindings.iter();
                bindings.for_each(|binding| binding.for_each_var(&mut read));
            }
        }
        for line in &library.lines {
            let graph = line_picture::to_graph(line, &library.sources);
            for route in &line.routes {
                let ends = (Some(route.from), route.to);
                let mut edges = graph.edges.iter();
                assert!(edges.any(|edge| (edge.from, edge.to) == ends));
                counts.1 += 1;
            }
        }
    }
    assert!(counts.0 > 100 && counts.1 > 50, "{counts:?}");
}

/// Draws all of a file; returns what is wrong.
fn drawn(path: &Path) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let relative = path.strip_prefix(support::root()).expect("it is below");
    let file = relative.to_string_lossy().replace('\\', "/");
    let out = folder.path().to_string_lossy().into_owned();
    let output = support::linewright(support::root(), &["draw", &file, "--out", &out]);
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    let names = declared(path);
    let known = NOT_DRAWN.iter().find(|(known, _)| *known == file);
    let mut faults = Vec::new();
    if let Some((_, reason)) = known {
        if output.status.code() != Some(3) || !printed.contains(reason) {
            faults.push(format!("{file} should say why it is not drawn: {printed}"));
        }
    } else if names.is_empty() == output.status.success() {
        faults.push(format!("{file}: {printed}"));
    }
    for name in names {
        let endings = [".svg", ".counterstrategy.svg"];
        let files = endings.map(|ending| folder.path().join(name.clone() + ending));
        let text = files
            .iter()
            .find_map(|file| std::fs::read_to_string(file).ok());
        match text {
            Some(text) => {
                let found = Drawing::read(&text).faults();
                faults.extend(found.iter().map(|fault| format!("{file}::{name}: {fault}")));
            }
            None if known.is_some() => {}
            None => faults.push(format!("{file}::{name} is not drawn: {printed}")),
        }
    }
    faults
}

#[test]
fn all_of_the_library_and_the_examples_is_drawn_without_overlaps() {
    let folders = ["contracts", "examples"].map(|folder| support::root().join(folder));
    let files = folders
        .iter()
        .flat_map(|folder| files_below(folder, &["lw"]));
    let files: Vec<PathBuf> = files.collect();
    assert!(files.len() > 30);
    let faults: Vec<String> = files.par_iter().flat_map(|path| drawn(path)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn what_cannot_be_drawn_is_explained() {
    let turn = "contracts/handling/turn.lw";
    let cell = "examples/transfer/cell.lw";
    let cases: [(&[&str], i32, &str); 9] = [
        (
            &[cell],
            2,
            "there are 4 results: give an output folder with --out DIR",
        ),
        (
            &["contracts/handling/turn.lw::Twist"],
            2,
            "nothing to draw with the name `Twist`: write `contracts/handling/turn.lw::NAME`",
        ),
        (
            &["contracts/common/command.lw"],
            2,
            "give a file with a contract, a machine, a line or a skill set",
        ),
        (
            &[turn, "--around", "S99"],
            2,
            "`Turn` has no state `S99`: its states are S0 to S12",
        ),
        (
            &["examples/loader/line.lw::Loader", "--around", "S0"],
            2,
            "--around needs one contract",
        ),
        (&[turn, "--steps", "2"], 2, "--around"),
        (&[turn, "--format", "sarif"], 2, "a drawing has no findings"),
        (&["tests/cases/cli/type.lw"], 1, "error[LW1"),
        (
            &["tests/cases/cli/unrealizable.lw"],
            0,
            "so its counterstrategy is drawn",
        ),
    ];
    for (arguments, code, message) in cases {
        let arguments: Vec<&str> = ["draw"].iter().chain(arguments).copied().collect();
        let output = support::linewright(support::root(), &arguments);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {printed}");
        assert!(printed.contains(message), "{arguments:?}: {printed}");
    }
}

/// The part around a state has the states that its edges lead to, and no others.
#[test]
fn a_part_of_a_controller_is_drawn() {
    let turn = ["draw", "contracts/handling/turn.lw", "--around", "S12"];
    let states = |more: &[&str]| {
        let arguments: Vec<&str> = turn.iter().chain(more).copied().collect();
        let output = support::linewright(support::root(), &arguments);
        let svg = String::from_utf8_lossy(&output.stdout).into_owned();
        let texts = Drawing::read(&svg).texts.into_iter().map(|(text, _)| text);
        let mut states: Vec<String> = texts.filter(|text| text.starts_with('S')).collect();
        states.sort();
        states
    };
    assert_eq!(states(&[]), ["S11", "S12"]);
    assert_eq!(states(&["--steps", "2"]), ["S11", "S12", "S8", "S9"]);
}

/// By an output, a drawing has a box for each of its values, without names of states.
#[test]
fn the_values_of_an_output_are_drawn() {
    let draw = |by: &str| {
        let clamp = ["draw", "contracts/handling/clamp.lw", "--by", by];
        support::linewright(support::root(), &clamp)
    };
    let output = draw("phase");
    let svg = String::from_utf8_lossy(&output.stdout).into_owned();
    let drawing = Drawing::read(&svg);
    assert_eq!(drawing.faults(), [""; 0]);
    let texts = drawing.texts.into_iter().map(|(text, _)| text);
    let mut texts: Vec<String> = texts.collect();
    texts.sort();
    let phases = ["approach", "fault", "hold", "idle", "press", "unclamp"];
    assert_eq!(texts, phases.map(|phase| format!("phase = {phase}")));
    let refused = draw("phase,gap");
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        message.contains("`Clamp` has no output `gap`: its outputs are phase, clamp_done"),
        "{message}"
    );
}

/// Each of these must be found.
#[test]
fn faults_of_drawings_are_found() {
    let svg = |inside: &str| {
        format!("<svg width=\"100\" height=\"50\" viewBox=\"-10 -10 100 50\">{inside}</svg>")
    };
    let text = |x: i32, y: i32| {
        format!("<text x=\"{x}\" y=\"{y}\" font-size=\"10\" textLength=\"40\">a</text>")
    };
    let faults = |inside: &str| Drawing::read(&svg(inside)).faults();
    assert_eq!(faults(&text(30, 10)), [""; 0]);
    assert_eq!(
        faults(&(text(30, 10) + &text(60, 12))),
        ["\"a\" is on \"a\""]
    );
    assert_eq!(faults(&text(5, 10)), ["\"a\" is outside"]);
    let outside = "<path d=\"M0 0L95 0\"/>";
    assert_eq!(faults(outside).len(), 1);
    let wide = svg("").replace("\"100\"", "\"1601\"");
    assert_eq!(Drawing::read(&wide).faults(), ["it is 1601 wide"]);
}

/// Compares a picture of the guide with a drawing, or writes it.
fn compare_picture(image: &str, drawing: &[u8]) {
    let path = support::root().join("docs/images").join(image);
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(&path, drawing).expect("the picture can be written");
    }
    let shown = std::fs::read(&path).unwrap_or_default();
    assert!(
        shown == drawing,
        "docs/images/{image} is not what is drawn: run INSTA_UPDATE=always cargo test --test program -- drawings"
    );
}

/// The timing diagram in the page on `step` is that of the command beside it.
#[test]
fn the_timing_diagram_of_the_guide_is_up_to_date() {
    let page = support::root().join("docs/guide/step.md");
    let page = std::fs::read_to_string(page).expect("the page");
    let commands = page.lines().find_map(|line| {
        let commands = line.strip_prefix("$ printf '")?.split_once("save play.svg");
        Some(commands?.0.replace("\\n", "\n"))
    });
    let sandbox = support::sandbox();
    let script = commands.expect("the command") + "save play.svg\n";
    std::fs::write(sandbox.path().join("play.txt"), script).expect("a script");
    let arguments = ["step", "contracts/handling/turn.lw", "--script", "play.txt"];
    let played = support::linewright(sandbox.path(), &arguments);
    assert!(played.status.success());
    let drawing = std::fs::read(sandbox.path().join("play.svg")).expect("the drawing");
    let text = String::from_utf8(drawing.clone()).expect("text");
    assert_eq!(Drawing::read(&text).faults(), [""; 0]);
    compare_picture("turn-play.svg", &drawing);
}

/// The pictures of the guide and of the README are those of the commands beside them
/// (`INSTA_UPDATE=always` writes them anew).
#[test]
fn the_pictures_of_the_guide_are_up_to_date() {
    let of_guide = compare_pictures("docs/guide/drawings.md", "../images/");
    assert!(of_guide >= 7, "{of_guide}");
    assert_eq!(compare_pictures("README.md", "docs/images/"), 1);
}

/// Compares the pictures of a page, in a folder that is given relative to it. Returns their number.
fn compare_pictures(page: &str, folder: &str) -> usize {
    let page = support::root().join(page);
    let page = std::fs::read_to_string(page).expect("the page");
    let commands = page
        .lines()
        .filter_map(|l| l.strip_prefix("$ linewright draw "));
    let mut count = 0;
    for command in commands {
        let Some((arguments, image)) = command.split_once(" > ") else {
            continue;
        };
        let arguments: Vec<&str> = ["draw"].into_iter().chain(arguments.split(' ')).collect();
        let output = support::linewright(support::root(), &arguments);
        assert!(output.status.success(), "{command}");
        compare_picture(image, &output.stdout);
        assert!(page.contains(&format!("]({folder}{image})")), "{image}");
        count += 1;
    }
    count
}

/// Frames of goals are in the Graphviz text as in the SVG, and in the part around a state.
#[test]
fn goals_are_in_all_forms_of_a_drawing() {
    let goals = "examples/other-tools/arbiter.spc";
    let shown = |arguments: &[&str]| {
        let output = support::linewright(support::root(), arguments);
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).expect("a drawing")
    };
    let dot = shown(&["synth", goals, "--emit", "dot"]);
    let svg = shown(&["draw", goals]);
    let around = shown(&["draw", goals, "--around", "S0"]);
    let mut titles = dot.split("label=\"for ").skip(1);
    let title = titles.next().and_then(|title| title.split('"').next());
    let title = title.expect("a cluster of a goal");
    assert!(dot.contains("subgraph cluster_frame0 {"), "{dot}");
    assert!(svg.contains(&format!("for {title}")), "{svg}");
    assert!(around.contains("for "), "{around}");
}
