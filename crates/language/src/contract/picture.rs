//! The drawing of a machine: its components with their wires.
//!
//! A wire leads from the component that sets it to each component with an input that is bound to an
//! expression over it. What the plant sets, and what leaves the machine, has boxes of its own close
//! to the components, so that no wire crosses the whole picture to a common border.

use super::machine::{Component, Machine, PlantInput, PlantSource, Role};
use linewright_core::drawing::{BoxStyle, Edge, Frame, Graph, svg};
use linewright_core::gr1::text;
use linewright_core::gr1::{Expr, Side, Specification, Timing, Variable};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of signals in a label or in a box of the plant.
const MAX_SIGNALS: usize = 12;

/// Returns the drawing of a machine as SVG.
pub fn to_svg(machine: &Machine) -> String {
    svg::render_blocks(&machine.name, &to_graph(machine))
}

/// Returns the components of a machine as blocks, inner machines as frames, and wires as edges.
pub fn to_graph(machine: &Machine) -> Graph {
    let mut builder = Builder {
        machine,
        wires: Wires::new(machine),
        graph: Graph::default(),
        frames: BTreeMap::new(),
        read: BTreeSet::new(),
    };
    for component in &machine.components {
        builder.add_component(component);
    }
    builder.add_wires();
    builder.add_plant_inputs();
    builder.add_outputs();
    builder.graph
}

/// Who sets each wire, and its name there.
struct Wires {
    /// The component; `None` for a wire of the plant.
    setters: Vec<Option<usize>>,
    names: Vec<String>,
    /// Whether it is a variable that is not part of the component's interface.
    internal: Vec<bool>,
}

impl Wires {
    fn new(machine: &Machine) -> Self {
        let mut wires = Self {
            setters: vec![None; machine.plant.len()],
            names: machine
                .plant
                .iter()
                .map(|input| input.name.clone())
                .collect(),
            internal: vec![false; machine.plant.len()],
        };
        for (number, component) in machine.components.iter().enumerate() {
            let specification = &component.specification;
            for id in specification.outputs() {
                let variable = specification.variable(id);
                wires.setters.push(Some(number));
                wires.names.push(variable.name.clone());
                wires.internal.push(variable.internal);
            }
        }
        wires
    }
}

struct Builder<'a> {
    machine: &'a Machine,
    wires: Wires,
    graph: Graph,
    /// Index of the frame of each inner machine, by its path.
    frames: BTreeMap<String, usize>,
    /// Wires of components that something in the picture reads.
    read: BTreeSet<usize>,
}

impl Builder<'_> {
    fn add_component(&mut self, component: &Component) {
        let (path, name) = match component.name.rsplit_once('.') {
            Some((path, name)) => (Some(path), name),
            None => (None, component.name.as_str()),
        };
        let (style, role) = match component.role {
            Role::Coordinator => (BoxStyle::Coordinator, Some("coordinator")),
            Role::Action => (BoxStyle::Block, None),
            Role::Watch => (BoxStyle::Observer, Some("observes calls")),
        };
        let mut label = vec![name.to_owned(), component.contract.clone()];
        label.extend(role.map(str::to_owned));
        let block = self.add_box(label, style);
        if let Some(path) = path {
            let frame = self.frame(path);
            self.graph.frames[frame].states.push(block);
        }
    }

    fn add_box(&mut self, label: Vec<String>, style: BoxStyle) -> usize {
        self.graph.states.push(label);
        self.graph.styles.push(style);
        self.graph.states.len() - 1
    }

    /// Returns the frame of an inner machine with this path: `left.arm`.
    fn frame(&mut self, path: &str) -> usize {
        if let Some(known) = self.frames.get(path) {
            return *known;
        }
        let (outer, name) = match path.rsplit_once('.') {
            Some((outer, name)) => (Some(outer), name),
            None => (None, path),
        };
        let parent = outer.map(|outer| self.frame(outer));
        let title = match inner_machine(self.machine, path) {
            Some(machine) => format!("{name}: {machine}"),
            None => name.to_owned(),
        };
        self.graph.frames.push(Frame {
            title,
            parent,
            states: Vec::new(),
        });
        let frame = self.graph.frames.len() - 1;
        self.frames.insert(path.to_owned(), frame);
        frame
    }

    /// Adds the wires between components, all those between two of them as one edge.
    fn add_wires(&mut self) {
        let mut bundles: BTreeMap<(usize, usize), Vec<String>> = BTreeMap::new();
        for (reader, component) in self.machine.components.iter().enumerate() {
            for wire in wires_of(&component.bindings) {
                let Some(setter) = self.wires.setters[wire] else {
                    continue;
                };
                self.read.insert(wire);
                let names = bundles.entry((setter, reader)).or_default();
                names.push(self.wires.names[wire].clone());
            }
        }
        self.graph.edges.extend(bundles.into_iter().map(edge));
    }

    /// Adds a box for the plant's wires of each set of components that read them.
    fn add_plant_inputs(&mut self) {
        let mut readers: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); self.machine.plant.len()];
        for (reader, component) in self.machine.components.iter().enumerate() {
            for wire in wires_of(&component.bindings) {
                if let Some(known) = readers.get_mut(wire) {
                    known.insert(reader);
                }
            }
        }
        let mut groups: BTreeMap<BTreeSet<usize>, Vec<String>> = BTreeMap::new();
        for (input, readers) in self.machine.plant.iter().zip(readers) {
            groups.entry(readers).or_default().push(described(input));
        }
        for (readers, names) in groups
            .into_iter()
            .filter(|(readers, _)| !readers.is_empty())
        {
            let mut label = vec!["from the plant".to_owned()];
            label.extend(shortened(names));
            let from = self.add_box(label, BoxStyle::Terminal);
            let edges = readers.into_iter().map(|to| edge(((from, to), Vec::new())));
            self.graph.edges.extend(edges);
        }
    }

    /// Adds what leaves the machine: the end of an operation, what is written to the part, and the
    /// outputs that no component reads.
    fn add_outputs(&mut self) {
        if let Some(done) = &self.machine.done {
            let wires = wires_of(std::slice::from_ref(done));
            self.add_output(vec!["operation done".to_owned()], wires);
        }
        for (property, value) in &self.machine.writes {
            let mut wires = BTreeSet::new();
            value.for_each(&mut |part| {
                if let super::machine::RealExpr::Wire(wire) = part {
                    wires.insert(*wire);
                }
            });
            let name = self.machine.properties[*property].name.clone();
            self.add_output(vec!["to the part".to_owned(), name], wires);
        }
        let mut unread: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for (wire, setter) in self.wires.setters.iter().enumerate() {
            if let Some(setter) = setter
                && !self.read.contains(&wire)
                && !self.wires.internal[wire]
            {
                let names = unread.entry(*setter).or_default();
                names.push(self.wires.names[wire].clone());
            }
        }
        for (setter, names) in unread {
            let mut label = vec!["to the plant".to_owned()];
            label.extend(shortened(names));
            let to = self.add_box(label, BoxStyle::Terminal);
            self.graph.edges.push(edge(((setter, to), Vec::new())));
        }
    }

    /// Adds a box for something that is computed from wires.
    fn add_output(&mut self, label: Vec<String>, wires: BTreeSet<usize>) {
        let mut names: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for wire in wires {
            if let Some(setter) = self.wires.setters[wire] {
                self.read.insert(wire);
                let names = names.entry(setter).or_default();
                names.push(self.wires.names[wire].clone());
            }
        }
        if names.is_empty() {
            return;
        }
        let to = self.add_box(label, BoxStyle::Terminal);
        let edges = names.into_iter();
        let edges = edges.map(|(setter, names)| edge(((setter, to), names)));
        self.graph.edges.extend(edges);
    }
}

fn edge(((from, to), label): ((usize, usize), Vec<String>)) -> Edge {
    Edge {
        from: Some(from),
        to,
        label: shortened(label),
    }
}

/// The first of many names, with the number of the others.
fn shortened(mut names: Vec<String>) -> Vec<String> {
    if names.len() > MAX_SIGNALS {
        let more = names.len() - (MAX_SIGNALS - 1);
        names.truncate(MAX_SIGNALS - 1);
        names.push(format!("... {more} more"));
    }
    names
}

/// The wires that expressions are over, in ascending order.
fn wires_of(expressions: &[Expr]) -> BTreeSet<usize> {
    let mut wires = BTreeSet::new();
    for expression in expressions {
        expression.for_each_var(&mut |wire, _| {
            wires.insert(wire.index());
        });
    }
    wires
}

/// The inputs of a component of a machine that get something with another name, each with the
/// expression over wires that it gets: `requested` and `control.command`.
pub fn inputs(machine: &Machine, component: &Component) -> Vec<(String, String)> {
    let specification = all_wires(machine);
    let own = &component.specification;
    let inputs = own.inputs().zip(&component.bindings);
    let inputs = inputs.map(|(id, binding)| {
        let input = own.variable(id);
        let value = text::value(&specification, binding, input);
        (input.name.clone(), value)
    });
    inputs.filter(|(name, value)| name != value).collect()
}

/// The wires of a machine as variables, with the names that they have in its declaration.
fn all_wires(machine: &Machine) -> Specification {
    let plant = machine.plant.iter().map(PlantInput::variable);
    let of_components = machine.components.iter().flat_map(|component| {
        let own = &component.specification;
        own.outputs().map(move |id| {
            let variable = own.variable(id);
            Variable {
                name: format!("{}.{}", component.name, variable.name),
                ..variable.clone()
            }
        })
    });
    Specification {
        name: machine.name.clone(),
        timing: Timing::Mealy,
        variables: plant.chain(of_components).collect(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    }
}

/// A wire of the plant, with what it comes from if this is not a signal.
fn described(input: &PlantInput) -> String {
    match &input.source {
        PlantSource::Signal { .. } => input.name.clone(),
        PlantSource::Operation => format!("{} (asked for)", input.name),
        PlantSource::Property(_) => format!("{} (from the part)", input.name),
    }
}

/// Name of the machine that an inner machine with this path is.
fn inner_machine<'a>(machine: &'a Machine, path: &str) -> Option<&'a str> {
    let (first, rest) = match path.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (path, None),
    };
    let mut inner = machine.layers.inner.iter();
    let inner = &inner.find(|inner| inner.name == first)?.machine;
    match rest {
        Some(rest) => inner_machine(inner, rest),
        None => Some(&inner.name),
    }
}
