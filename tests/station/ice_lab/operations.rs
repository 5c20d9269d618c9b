//! Every operation of every machine: the coordinator does what the machine's file says.
//!
//! An operation begins in a state where its assumptions hold (`screw` needs a part in the gripper,
//! so `hold` comes before it); the necessary preceding ones are searched, and compared with what
//! the process needs. It then runs twice: in one call of `simulate`, and step by step, where the
//! active actions are recorded.

use crate::differential::{Random, assert_same};
use crate::laboratory::{Controlled, machines};
use linewright::contract::machine::{Machine, PlantSource};
use linewright::gr1::eval;
use linewright::station::interpret::Interpreter;
use linewright::station::load::{Instance, Library};
use linewright::station::{Controller, ErrorCode, Package, Toolchain};
use std::sync::Arc;

/// An interpreter and an instance of the library in the same state.
struct Pair {
    machine: Arc<Machine>,
    ours: Interpreter,
    theirs: Instance,
}

impl Pair {
    fn new(controlled: &Controlled, library: &Arc<Library>) -> Self {
        let machine = Arc::clone(&controlled.machine);
        let controllers = Arc::clone(&controlled.controllers);
        Self {
            ours: Interpreter::new(Arc::clone(&machine), controllers),
            theirs: library.instance().expect("there is room"),
            machine,
        }
    }

    fn reset(&mut self) {
        self.ours.reset();
        self.theirs.reset();
    }

    /// Both run one operation; returns its steps, seconds and joules if they succeed.
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Option<(u64, f64, f64)> {
        let name = &self.machine.operations[operation].name;
        let place = format!("{}.{name} with {values:?}", self.machine.name);
        let mut others = values.to_vec();
        let expected = self.ours.simulate(operation, values);
        let answer = self.theirs.simulate(operation, &mut others);
        assert_same(&expected, &answer, &place);
        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(values), bits(&others), "{place}");
        let (Ok(a), Ok(b)) = (expected, answer) else {
            return None;
        };
        let figures = |s: &linewright::station::Service| (s.steps, s.seconds, s.joules);
        assert_eq!(
            (a.steps, a.seconds.to_bits(), a.joules.to_bits()),
            (b.steps, b.seconds.to_bits(), b.joules.to_bits()),
            "{place}"
        );
        Some(figures(&a))
    }

    /// Both run one operation in single steps. Returns the executions, each a component and its
    /// number of steps, and the total number of steps.
    fn walk(&mut self, operation: usize, values: &[f64]) -> (Vec<usize>, u64) {
        let machine = Arc::clone(&self.machine);
        let outputs = machine.wire_count() - machine.plant.len();
        let (mut ours, mut theirs) = (vec![0; outputs], vec![0; outputs]);
        let (mut executions, mut before) = (Vec::new(), None);
        for step in 0..machine.step_limit {
            let plant = plant(&machine, operation, values, step);
            let expected = self.ours.step(&plant, &mut ours);
            let answer = self.theirs.step(&plant, &mut theirs);
            let place = format!("{} step {step} of {operation}", machine.name);
            assert_same(&expected, &answer, &place);
            assert_eq!(expected, Ok(()), "{place}");
            assert_eq!(ours, theirs, "{place}");
            let wires: Vec<i64> = plant.iter().chain(&ours).copied().collect();
            let holds = |e| eval::eval(e, &wires, &[]) != 0;
            let mut active = machine.components.iter().enumerate();
            let mut active = active
                .by_ref()
                .filter(|(_, c)| c.active.as_ref().is_some_and(holds));
            let now = active.next().map(|(c, _)| c);
            assert_eq!(active.next().map(|(_, c)| &c.name), None, "{place}: one");
            if now != before {
                executions.extend(now);
            }
            before = now;
            if machine.done.as_ref().is_some_and(holds) {
                return (executions, step + 1);
            }
        }
        panic!("{}: operation {operation} does not end", machine.name);
    }
}

/// The plant's wires in a step of an operation, as documented at [`PlantSource`].
fn plant(machine: &Machine, operation: usize, values: &[f64], step: u64) -> Vec<i64> {
    let wire = |source: &PlantSource| match source {
        PlantSource::Operation => machine.operations[operation].value,
        PlantSource::Signal { script } => script[(step % script.len() as u64) as usize],
        PlantSource::Property(expr) => expr.eval(values, &[]) as i64,
    };
    machine.plant.iter().map(|p| wire(&p.source)).collect()
}

/// The properties' defaults for the first call, then values from their domains; angles in steps of
/// 45 degrees.
fn values(machine: &Machine, call: usize, random: &mut Random) -> Vec<f64> {
    let properties = machine.properties.iter();
    properties
        .map(|p| match (&p.domain, call) {
            (_, 0) => p.default,
            // Only full blanks are milled.
            (Some(domain), _) if machine.name == "Milling" && p.name.starts_with("heights") => {
                domain.high() as f64
            }
            (Some(domain), _) => random.within(domain) as f64,
            (None, _) => 45.0 * random.below(9) as f64,
        })
        .collect()
}

/// Shortest list of operations from the start after which this one runs.
fn preparation(pair: &mut Pair, operation: usize) -> Vec<usize> {
    let count = pair.machine.operations.len();
    let mut lists: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..3 {
        let mut runnable = Vec::new();
        for list in lists {
            let whole: Vec<usize> = list.iter().copied().chain([operation]).collect();
            if all_run(pair, &whole) {
                return list;
            }
            if all_run(pair, &list) {
                runnable.push(list);
            }
        }
        let longer = runnable
            .iter()
            .flat_map(|l| (0..count).map(move |o| l.iter().copied().chain([o]).collect()));
        lists = longer.collect();
    }
    let name = &pair.machine.operations[operation].name;
    panic!("{}.{name} never runs", pair.machine.name);
}

fn all_run(pair: &mut Pair, operations: &[usize]) -> bool {
    pair.reset();
    let mut values: Vec<f64> = pair.machine.properties.iter().map(|p| p.default).collect();
    let mut run = |o: &usize| pair.simulate(*o, &mut values).is_some();
    operations.iter().all(&mut run)
}

#[test]
fn every_operation_does_what_its_machine_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut prepared = Vec::new();
    let mut random = Random(5);
    for controlled in machines() {
        let machine = &controlled.machine;
        let package = Package::emit(machine, &controlled.controllers);
        let built = Toolchain::host().build(&package, folder.path(), false);
        let library = Library::open(&built.unwrap().path).unwrap();
        let mut pair = Pair::new(controlled, &library);
        for (index, operation) in machine.operations.iter().enumerate() {
            let before = preparation(&mut pair, index);
            for call in 0..200 {
                let start = values(machine, call, &mut random);
                let mut steps = Vec::new();
                let mut written = Vec::new();
                for stepwise in [false, true] {
                    pair.reset();
                    let mut now = start.clone();
                    for o in &before {
                        assert!(pair.simulate(*o, &mut now).is_some());
                    }
                    if stepwise {
                        let (executions, count) = pair.walk(index, &now);
                        let names = |list: &[usize]| {
                            let names = list.iter().map(|c| machine.components[*c].name.clone());
                            names.collect::<Vec<_>>().join(", ")
                        };
                        let (done, said) = (names(&executions), names(&operation.sequence));
                        assert_eq!(done, said, "{}.{}", machine.name, operation.name);
                        steps.push(count);
                    } else {
                        let service = pair.simulate(index, &mut now);
                        let (count, seconds, joules) = service.unwrap();
                        assert!(seconds > 0.0 && joules > 0.0);
                        steps.push(count);
                        written = now;
                    }
                }
                assert_eq!(steps[0], steps[1]);
                check_written(&machine.name, &operation.name, &start, &written);
            }
            let names: Vec<&str> = before
                .iter()
                .map(|o| machine.operations[*o].name.as_str())
                .collect();
            prepared.push(format!(
                "{}.{}: after [{}]",
                machine.name,
                operation.name,
                names.join(", ")
            ));
        }
    }
    insta::assert_snapshot!(prepared.join("\n"));
}

/// What an operation must write to the part, defined here independently of the machine's file.
fn check_written(machine: &str, operation: &str, before: &[f64], after: &[f64]) {
    let mut wanted = before.to_vec();
    match (machine, operation) {
        // heights, target
        ("Printer" | "Milling", _) => wanted.copy_within(2..4, 0),
        // heights, target, verdict
        ("QualityCheck", _) => {
            let equal = before[..2] == before[2..4];
            wanted[4] = if equal { 1.0 } else { 2.0 };
        }
        // angle, target angle, x, y
        ("AssemblyCell", "emptying" | "screw" | "clamp") => wanted[0] = before[1] % 360.0,
        ("AssemblyCell", _) => {}
        other => panic!("{other:?} is new: say what it leaves"),
    }
    assert_eq!(after, wanted, "{machine}.{operation}");
}

/// A blank with missing material cannot be milled to a greater height: it is refused, and stays
/// unchanged.
#[test]
fn a_part_that_is_lower_than_its_target_is_not_milled() {
    let folder = tempfile::tempdir().unwrap();
    let milling = machines().iter().find(|m| m.machine.name == "Milling");
    let milling = milling.expect("it is there");
    let package = Package::emit(&milling.machine, &milling.controllers);
    let built = Toolchain::host().build(&package, folder.path(), false);
    let library = Library::open(&built.unwrap().path).unwrap();
    let mut pair = Pair::new(milling, &library);
    for [low, high] in [[0.0, 0.0], [0.0, 1.0], [2.0, 0.0], [1.0, 1.0], [2.0, 1.0]] {
        let values = [low, high, 2.0, 1.0];
        let error = pair.ours.simulate(0, &mut values.clone()).unwrap_err();
        assert_eq!(error.code, ErrorCode::Assumption);
        assert_eq!(error.rule.as_deref(), Some("cutter: begins_full"));
        let mut after = values;
        assert_eq!(pair.simulate(0, &mut after), None);
        assert_eq!(after.map(f64::to_bits), values.map(f64::to_bits));
    }
    // The instance is unchanged.
    let mut values = [2.0, 2.0, 2.0, 1.0];
    assert!(pair.simulate(0, &mut values).is_some());
    let milled = [2.0, 1.0, 2.0, 1.0_f64];
    assert_eq!(values.map(f64::to_bits), milled.map(f64::to_bits));
}
