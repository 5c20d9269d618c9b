//! A walk through a machine that covers everything it can do.
//!
//! Places of all components together are explored breadth-first from step 0, with every letter of
//! the plant if there are few, and with some of them otherwise. For every row of a controller (a
//! cube of a transition) that was met, the shortest way to it goes into the script, followed by
//! some steps, so that a row with a wrong target is detected. Then random ways are tried, and those
//! that meet another row are kept. Operations and random steps follow, including refused ones.

use super::machines::Subject;
use linewright::contract::machine::{ActionTime, Machine, PlantSource, RealExpr};
use linewright::gr1::eval;
use linewright::mealy;
use linewright::station::interpret::Interpreter;
use linewright::station::{CallError, Controller, ErrorCode, Service};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use crate::differential::Random;

/// One call of a host.
#[derive(Debug, Clone, PartialEq)]
pub enum Call {
    Reset,
    Step(Vec<i64>),
    Operation(usize, Vec<f64>),
}

/// The answer to it.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    Reset,
    Outputs(Vec<i64>),
    Service(Service, Vec<f64>),
    Error(CallError),
}

/// A row of a controller, one cube of one transition: the component, and the index of the row in
/// the order of its places.
pub type Row = (usize, usize);

/// A query of a component: which one, at which place (`None` before step 0), with which inputs.
pub type Question = (usize, Option<usize>, Vec<i64>);

/// Number of letters tried at one place, and of steps tried in total.
const LETTERS: u64 = 512;
const TRIES: usize = 120_000;

/// Number of random ways, to find what a bounded exploration does not.
const WAYS: usize = 500;

/// Values at about the maximum distance from an integer (1e-9), also in cells of 90 degrees; the
/// least that are too small or too large.
const UNUSUAL: [f64; 9] = [
    1e-9,
    1.0 + 5e-10,
    1.0 + 5e-9,
    -5e-10,
    90.0 + 4.5e-8,
    90.0 + 4.5e-7,
    0.0,
    -3.0,
    1e300,
];

/// Number of steps after each row.
const BEYOND: usize = 5;

pub fn interpreter(subject: &Subject) -> Interpreter {
    Interpreter::new(
        Arc::clone(&subject.machine),
        Arc::clone(&subject.controllers),
    )
}

/// Makes a call.
pub fn answer(machine: &Machine, interpreter: &mut Interpreter, call: &Call) -> Answer {
    match call {
        Call::Reset => {
            interpreter.reset();
            Answer::Reset
        }
        Call::Step(plant) => {
            let mut outputs = vec![0; machine.wire_count() - machine.plant.len()];
            match interpreter.step(plant, &mut outputs) {
                Ok(()) => Answer::Outputs(outputs),
                Err(error) => Answer::Error(error),
            }
        }
        Call::Operation(operation, values) => {
            let mut values = values.clone();
            match interpreter.simulate(*operation, &mut values) {
                Ok(service) => Answer::Service(service, values),
                Err(error) => Answer::Error(error),
            }
        }
    }
}

/// The place of each component, and its outgoing rows.
pub struct Tables<'a> {
    subject: &'a Subject,
    /// For every component that is a table, the first row of every place (before step 0 first), and
    /// the number of rows.
    first: Vec<Option<Vec<usize>>>,
}

type Places = Vec<Option<usize>>;

impl<'a> Tables<'a> {
    pub fn new(subject: &'a Subject) -> Self {
        let first = |c: &mealy::Controller| {
            let machine = c.machine()?;
            let mut first = vec![0];
            let mut rows = 0;
            for transitions in std::iter::once(&machine.initial).chain(&machine.states) {
                rows += transitions.iter().map(|t| t.guard.0.len()).sum::<usize>();
                first.push(rows);
            }
            Some(first)
        };
        Self {
            subject,
            first: subject.controllers.iter().map(first).collect(),
        }
    }

    /// Number of rows of all tables.
    pub fn rows(&self) -> usize {
        self.first.iter().flatten().filter_map(|f| f.last()).sum()
    }

    fn start(&self) -> Places {
        vec![None; self.first.len()]
    }

    /// Advances the places by a step that set these wires, and returns the rows that did so.
    fn follow(&self, places: &mut Places, wires: &[i64]) -> Vec<(Row, Question)> {
        let mut rows = Vec::new();
        for (c, component) in self.subject.machine.components.iter().enumerate() {
            let (Some(first), Some(machine)) =
                (&self.first[c], self.subject.controllers[c].machine())
            else {
                continue;
            };
            let bindings = component.bindings.iter();
            let inputs: Vec<i64> = bindings.map(|b| eval::eval(b, wires, &[])).collect();
            let mut row = first[places[c].map_or(0, |p| p + 1)];
            let found = machine.transitions(places[c]).iter().find_map(|t| {
                let cube = t.guard.0.iter().position(|cube| cube.holds(&inputs));
                if cube.is_none() {
                    row += t.guard.0.len();
                }
                Some((row + cube?, t.to))
            });
            let (row, to) = found.expect("a step that was made has a row in every table");
            rows.push(((c, row), (c, places[c], inputs)));
            places[c] = Some(to);
        }
        rows
    }
}

/// A place of the whole machine that was met.
struct Node {
    interpreter: Interpreter,
    places: Places,
    /// The previous node, and the letter that led here.
    from: Option<(usize, Vec<i64>)>,
}

/// Results of an exploration.
struct Explored {
    nodes: Vec<Node>,
    /// Where each row was first met.
    rows: BTreeMap<Row, (usize, Vec<i64>)>,
    /// Whether nothing was left out.
    whole: bool,
}

/// Every letter if there are few, and whether these are all; otherwise those near the previous
/// letter, and some others.
fn letters(machine: &Machine, before: &[i64], random: &mut Random) -> (Vec<Vec<i64>>, bool) {
    let mut sizes = machine.plant.iter().map(|p| p.domain.size());
    if sizes
        .try_fold(1_u64, u64::checked_mul)
        .is_some_and(|n| n <= LETTERS)
    {
        let mut all: Vec<Vec<i64>> = vec![vec![]];
        for input in &machine.plant {
            let values = || input.domain.low()..=input.domain.high();
            all = all
                .into_iter()
                .flat_map(|l| values().map(move |v| [l.as_slice(), &[v]].concat()))
                .collect();
        }
        return (all, true);
    }
    let mut near = vec![before.to_vec()];
    for (i, input) in machine.plant.iter().enumerate() {
        for value in input.domain.low()..=input.domain.high() {
            let mut letter = before.to_vec();
            letter[i] = value;
            near.push(letter);
        }
    }
    for _ in 0..100 {
        let mut letter = before.to_vec();
        vary(machine, &mut letter, random);
        near.push(letter);
    }
    near.sort_unstable();
    near.dedup();
    (near, false)
}

fn explore(subject: &Subject, tables: &Tables<'_>, random: &mut Random) -> Explored {
    let machine = &subject.machine;
    let mut found = Explored {
        nodes: vec![Node {
            interpreter: interpreter(subject),
            places: tables.start(),
            from: None,
        }],
        rows: BTreeMap::new(),
        whole: true,
    };
    // New places first; the same places with other wires may still allow other letters.
    let (mut queue, mut later) = (VecDeque::from([0]), VecDeque::new());
    let mut places_met = BTreeSet::from([tables.start()]);
    let mut met: BTreeSet<(Places, Vec<i64>)> = BTreeSet::new();
    let mut tries = 0;
    while let Some(node) = queue.pop_front().or_else(|| later.pop_front()) {
        if tries > TRIES {
            found.whole = false;
            break;
        }
        let before = found.nodes[node].from.as_ref().map_or_else(
            || machine.plant.iter().map(|p| p.domain.low()).collect(),
            |(_, letter)| letter.clone(),
        );
        let (letters, all) = letters(machine, &before, random);
        found.whole &= all;
        for letter in letters {
            tries += 1;
            let Ok(wires) = found.nodes[node].interpreter.peek(&letter) else {
                continue;
            };
            let mut places = found.nodes[node].places.clone();
            for (row, _) in tables.follow(&mut places, &wires) {
                found
                    .rows
                    .entry(row)
                    .or_insert_with(|| (node, letter.clone()));
            }
            if !met.insert((places.clone(), wires)) {
                continue;
            }
            let new = places_met.insert(places.clone());
            let mut interpreter = found.nodes[node].interpreter.clone();
            answer(machine, &mut interpreter, &Call::Step(letter.clone()));
            let to = if new { &mut queue } else { &mut later };
            to.push_back(found.nodes.len());
            found.nodes.push(Node {
                interpreter,
                places,
                from: Some((node, letter)),
            });
        }
    }
    found
}

impl Explored {
    /// The letters that lead to a node from before step 0.
    fn way(&self, mut node: usize) -> Vec<Vec<i64>> {
        let mut way = Vec::new();
        while let Some((from, letter)) = &self.nodes[node].from {
            way.push(letter.clone());
            node = *from;
        }
        way.reverse();
        way
    }
}

/// A script with the answers of the machine in this process.
#[derive(Default)]
pub struct Script {
    pub calls: Vec<Call>,
    pub answers: Vec<Answer>,
    /// The rows that it covers.
    pub covered: BTreeSet<Row>,
    /// The queries of the components.
    pub questions: BTreeSet<Question>,
    /// Number of rows of all tables. Not all can be met in a machine: its coordinator does not use
    /// everything.
    pub rows: usize,
    /// Whether the exploration was complete, so that no other row can be met.
    pub whole: bool,
}

/// A script under construction.
struct Writer<'a> {
    subject: &'a Subject,
    tables: &'a Tables<'a>,
    interpreter: Interpreter,
    places: Places,
    /// The wires after the last step; zeros before step 0.
    wires: Vec<i64>,
    script: Script,
}

impl Writer<'_> {
    fn begin_anew(&mut self) {
        self.wires = vec![0; self.subject.machine.wire_count()];
        self.places = self.tables.start();
    }

    fn follow(&mut self, wires: Vec<i64>) {
        for (row, question) in self.tables.follow(&mut self.places, &wires) {
            self.script.covered.insert(row);
            self.script.questions.insert(question);
        }
        self.wires = wires;
    }

    /// Makes a call, and records its answer and the rows covered. Returns whether it succeeded.
    fn call(&mut self, call: Call) -> bool {
        let machine = &*self.subject.machine;
        let before = self.interpreter.clone();
        let given = answer(machine, &mut self.interpreter, &call);
        match (&call, &given) {
            (Call::Reset, _) => self.begin_anew(),
            (Call::Step(plant), Answer::Outputs(outputs)) => {
                self.follow([plant.as_slice(), outputs].concat());
            }
            (Call::Operation(operation, values), Answer::Service(service, _)) => {
                self.single_steps(before, *operation, values, service.steps);
            }
            (_, Answer::Error(error)) if error.code == ErrorCode::Limit => self.begin_anew(),
            _ => {}
        }
        let succeeded = !matches!(given, Answer::Error(_));
        self.script.calls.push(call);
        self.script.answers.push(given);
        succeeded
    }

    /// The steps of an operation that ended.
    fn single_steps(
        &mut self,
        mut interpreter: Interpreter,
        operation: usize,
        values: &[f64],
        steps: u64,
    ) {
        let machine = &*self.subject.machine;
        let start = self.wires.clone();
        for step in 0..steps {
            let wire = |source: &PlantSource| match source {
                PlantSource::Operation => machine.operations[operation].value,
                PlantSource::Signal { script } => script[(step % script.len() as u64) as usize],
                PlantSource::Property(expr) => expr.eval(values, &start).round() as i64,
            };
            let plant: Vec<i64> = machine.plant.iter().map(|p| wire(&p.source)).collect();
            let Answer::Outputs(outputs) =
                answer(machine, &mut interpreter, &Call::Step(plant.clone()))
            else {
                panic!("an operation that ended is one in single steps, too");
            };
            self.follow([plant, outputs].concat());
        }
    }

    /// A step that succeeds, if one is found quickly.
    fn step_on(&mut self, random: &mut Random) -> bool {
        let machine = &*self.subject.machine;
        let mut letter = self.wires[..machine.plant.len()].to_vec();
        for _ in 0..12 {
            vary(machine, &mut letter, random);
            if self.interpreter.peek(&letter).is_ok() {
                return self.call(Call::Step(letter));
            }
            letter = self.wires[..machine.plant.len()].to_vec();
        }
        false
    }

    /// Operations with values of all kinds, each occasionally followed by a step.
    fn operations(&mut self, calls: usize, random: &mut Random) {
        let machine = &*self.subject.machine;
        let count = machine.operations.len();
        let mut values: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
        let mut failed = 0;
        for _ in 0..calls {
            if failed > 6 || random.below(25) == 0 {
                self.call(Call::Reset);
                failed = 0;
            }
            for (property, value) in machine.properties.iter().zip(&mut values) {
                *value = match (random.below(4), &property.domain) {
                    (0, Some(domain)) => random.within(domain) as f64,
                    (0, None) => {
                        [0.0, 45.0, 90.0, 180.0, 270.0, 0.3, 1.0, 2.0][random.below(8) as usize]
                    }
                    _ => *value,
                };
            }
            let mut given = values.clone();
            let odd_one = random.below(given.len().max(1) as u64) as usize;
            if let (true, Some(value)) = (random.below(12) == 0, given.get_mut(odd_one)) {
                let odd = [
                    f64::NAN,
                    f64::INFINITY,
                    0.5,
                    -3.0,
                    1e300,
                    45.0 + 2e-7,
                    -0.0,
                    123_456_789.25,
                    -98_765_432.125,
                    // In cells of 90 degrees: the least that is too large for a text, less than is
                    // shown, and -1.
                    9e13,
                    -1e-5,
                    -90.0,
                ];
                *value = odd[random.below(12) as usize];
            }
            // Occasionally one that does not exist.
            let operation = random.below(count as u64 + 1) as usize;
            let operation = if operation == count && random.below(4) != 0 {
                0
            } else {
                operation
            };
            if self.call(Call::Operation(operation, given)) {
                failed = 0;
                if let Some(Answer::Service(_, after)) = self.script.answers.last() {
                    values.clone_from(after);
                }
            } else {
                failed += 1;
            }
            if random.below(10) == 0 {
                self.step_on(random);
            }
        }
    }

    /// Operations with values that are almost integers, negative, or large, for everything from
    /// which inputs, times and powers are computed.
    fn unusual_values(&mut self) {
        let machine = &*self.subject.machine;
        let values: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
        let mut read = BTreeSet::new();
        let mut reads = |expr: &RealExpr| {
            expr.for_each(&mut |part| {
                if let RealExpr::Property(property) = part {
                    read.insert(*property);
                }
            });
        };
        for input in &machine.plant {
            if let PlantSource::Property(expr) = &input.source {
                reads(expr);
            }
        }
        for component in &machine.components {
            reads(&component.watts);
            if let Some(ActionTime::PerStep(expr) | ActionTime::PerExecution(expr)) =
                &component.time
            {
                reads(expr);
            }
        }
        for operation in 0..machine.operations.len().min(2) {
            for property in &read {
                for value in UNUSUAL {
                    let mut given = values.clone();
                    given[*property] = value;
                    self.call(Call::Reset);
                    self.call(Call::Operation(operation, given));
                }
            }
        }
    }

    /// Steps that are refused before step 0: initial conditions are violated there.
    fn refused_at_first(&mut self, random: &mut Random) {
        let machine = &*self.subject.machine;
        let low: Vec<i64> = machine.plant.iter().map(|p| p.domain.low()).collect();
        let fresh = interpreter(self.subject);
        let mut letters = letters(machine, &low, random).0;
        letters.retain(|letter| fresh.peek(letter).is_err());
        letters.truncate(40);
        self.call(Call::Reset);
        for letter in letters {
            self.call(Call::Step(letter));
        }
    }

    /// Steps of all kinds: successful ones, violations of an assumption, and values out of their
    /// domain.
    fn steps(&mut self, calls: usize, random: &mut Random) {
        let machine = &*self.subject.machine;
        for _ in 0..calls {
            let mut letter = self.wires[..machine.plant.len()].to_vec();
            vary(machine, &mut letter, random);
            match random.below(10) {
                0 if !letter.is_empty() => {
                    let i = random.below(letter.len() as u64) as usize;
                    let domain = &machine.plant[i].domain;
                    let outside = [domain.low() - 1, domain.high() + 1, i64::MIN, i64::MAX];
                    letter[i] = outside[random.below(4) as usize];
                    self.call(Call::Step(letter));
                }
                1 | 2 => {
                    self.call(Call::Step(letter));
                }
                _ => {
                    if !self.step_on(random) {
                        self.call(Call::Reset);
                    }
                }
            }
        }
    }
}

/// Changes one or two of the plant's letters, or all.
fn vary(machine: &Machine, letter: &mut [i64], random: &mut Random) {
    if letter.is_empty() {
        return;
    }
    let all = random.below(3) == 0;
    let changes = if all {
        letter.len() as u64
    } else {
        random.below(3)
    };
    for change in 0..changes {
        let i = if all {
            change
        } else {
            random.below(letter.len() as u64)
        } as usize;
        letter[i] = random.within(&machine.plant[i].domain);
    }
}

impl<'a> Writer<'a> {
    fn new(subject: &'a Subject, tables: &'a Tables<'a>) -> Self {
        Self {
            subject,
            tables,
            interpreter: interpreter(subject),
            places: tables.start(),
            wires: vec![0; subject.machine.wire_count()],
            script: Script::default(),
        }
    }

    /// The shortest way to each row that was met.
    fn ways(&mut self, explored: &Explored, random: &mut Random) {
        // The farthest first: their ways cover many others.
        let rows = explored.rows.iter();
        let mut aims: Vec<(usize, Row)> = rows
            .map(|(row, (node, _))| (explored.way(*node).len(), *row))
            .collect();
        aims.sort_unstable_by(|a, b| b.cmp(a));
        for (_, row) in aims {
            if self.script.covered.contains(&row) {
                continue;
            }
            let (node, letter) = &explored.rows[&row];
            self.call(Call::Reset);
            for letter in explored.way(*node).into_iter().chain([letter.clone()]) {
                assert!(self.call(Call::Step(letter)), "a way that was found");
            }
            for _ in 0..BEYOND {
                self.step_on(random);
            }
        }
    }

    /// Random ways, of which those are kept that cover a row for the first time.
    fn more_ways(&mut self, random: &mut Random) {
        let mut scout = Writer::new(self.subject, self.tables);
        for _ in 0..WAYS {
            scout.script = Script {
                covered: self.script.covered.clone(),
                ..Script::default()
            };
            scout.call(Call::Reset);
            scout.operations(random.below(4) as usize, random);
            let mut useful = 0;
            for _ in 0..40 {
                let met = scout.script.covered.len();
                if !scout.step_on(random) {
                    break;
                }
                if scout.script.covered.len() > met {
                    useful = scout.script.calls.len() + BEYOND;
                }
            }
            if scout.script.covered.len() > self.script.covered.len() {
                for call in scout.script.calls.drain(..).take(useful.max(1 + BEYOND)) {
                    self.call(call);
                }
            }
        }
    }
}

/// The script of a machine; always the same for the same machine.
pub fn script(subject: &Subject) -> Script {
    let tables = Tables::new(subject);
    let mut random = Random(41);
    let explored = explore(subject, &tables, &mut random);
    let mut writer = Writer::new(subject, &tables);
    writer.ways(&explored, &mut random);
    writer.more_ways(&mut random);
    writer.refused_at_first(&mut random);
    writer.call(Call::Reset);
    writer.operations(600, &mut random);
    writer.call(Call::Reset);
    writer.steps(2_000, &mut random);
    writer.unusual_values();
    let script = &mut writer.script;
    let missed: Vec<&Row> = explored
        .rows
        .keys()
        .filter(|r| !script.covered.contains(r))
        .collect();
    assert_eq!(missed, Vec::<&Row>::new(), "{}", subject.name());
    script.whole = explored.whole;
    script.rows = tables.rows();
    writer.script
}
