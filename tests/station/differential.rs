//! A library compared with the interpreter, step by step: the same outputs, the same errors.
//!
//! Runs over every machine of a line. Inputs are random, but so that the walk makes progress: for
//! each step it is drawn whether the step should succeed, violate an assumption, or leave a domain,
//! and the first of some candidates that does so is taken.

use linewright::contract::machine::Machine;
use linewright::gr1::Domain;
use linewright::mealy;
use linewright::station::interpret::Interpreter;
use linewright::station::load::Library;
use linewright::station::{CallError, Controller, ErrorCode, Package, Toolchain};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Statistics of a walk.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Steps that succeeded.
    pub ok: usize,
    /// Steps by error.
    pub errors: BTreeMap<i32, usize>,
    /// Violated rules with their counts.
    pub rules: BTreeMap<String, usize>,
}

impl Counts {
    /// Number of steps with this error.
    pub fn of(&self, code: ErrorCode) -> usize {
        self.errors.get(&(code as i32)).copied().unwrap_or(0)
    }
}

/// splitmix64: small, and the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }
    pub fn within(&mut self, domain: &Domain) -> i64 {
        domain.low() + self.below(domain.size()) as i64
    }
}

/// Builds the machine's library in `folder`, and makes `steps` random steps with it and the
/// interpreter side by side.
///
/// # Panics
/// Panics if they differ in outputs or errors.
pub fn differential(
    machine: &Arc<Machine>,
    controllers: &Arc<Vec<mealy::Controller>>,
    steps: usize,
    seed: u64,
    folder: &Path,
) -> Counts {
    let package = Package::emit(machine, controllers);
    let built = Toolchain::host()
        .build(&package, folder, false)
        .expect("the library is built");
    let library = Library::open(&built.path).expect("the library is loaded");
    let mut instance = library.instance().expect("there is room");
    let mut interpreter = Interpreter::new(Arc::clone(machine), Arc::clone(controllers));
    let mut random = Random(seed);
    let mut counts = Counts::default();
    let outputs = machine.wire_count() - machine.plant.len();
    let (mut theirs, mut ours) = (vec![-99; outputs], vec![-99; outputs]);
    let mut plant: Vec<i64> = machine.plant.iter().map(|p| p.domain.low()).collect();
    let mut failed_in_a_row = 0;
    for step in 0..steps {
        // An environment may have reached its own dead end.
        if random.below(500) == 0 || failed_in_a_row > 12 {
            failed_in_a_row = 0;
            interpreter.reset();
            instance.reset();
        }
        let wish = match random.below(20) {
            0 => Some(ErrorCode::Domain),
            // Some machines have few assumptions, which can be violated only occasionally.
            _ if counts.of(ErrorCode::Assumption) * 7 < step => Some(ErrorCode::Assumption),
            1..=4 => Some(ErrorCode::Assumption),
            _ => None,
        };
        plant = candidate(machine, &interpreter, &plant, wish, &mut random);
        let expected = interpreter.step(&plant, &mut ours);
        let answer = instance.step(&plant, &mut theirs);
        assert_same(
            &expected,
            &answer,
            &format!("{} in step {step} with {plant:?}", machine.name),
        );
        assert_eq!(ours, theirs, "outputs of {} in step {step}", machine.name);
        match expected {
            Ok(()) => {
                counts.ok += 1;
                failed_in_a_row = 0;
            }
            Err(error) => {
                failed_in_a_row += 1;
                *counts.errors.entry(error.code as i32).or_default() += 1;
                if let Some(rule) = error.rule {
                    *counts.rules.entry(rule).or_default() += 1;
                }
                // A value outside its domain would otherwise stay for long.
                if error.code == ErrorCode::Domain {
                    for (value, input) in plant.iter_mut().zip(&machine.plant) {
                        *value = (*value).clamp(input.domain.low(), input.domain.high());
                    }
                }
            }
        }
    }
    counts
}

/// The same error: code, rule and text (which the library cuts at a fixed size).
pub fn assert_same<T>(expected: &Result<T, CallError>, answer: &Result<T, CallError>, place: &str) {
    match (expected, answer) {
        (Ok(_), Ok(_)) => {}
        (Err(a), Err(b)) => {
            assert_eq!(
                (a.code, &a.rule),
                (b.code, &b.rule),
                "{place}: {} / {}",
                a.message,
                b.message
            );
            // A library has room for 1023 bytes, and cuts between two characters.
            let mut end = a.message.len().min(1023);
            while !a.message.is_char_boundary(end) {
                end -= 1;
            }
            assert_eq!(b.message, a.message[..end], "{place}");
        }
        (Ok(_), Err(b)) => panic!("{place}: only the library says: {b:?}"),
        (Err(a), Ok(_)) => panic!("{place}: only the interpreter says: {a:?}"),
    }
}

/// The next plant wires.
fn candidate(
    machine: &Machine,
    interpreter: &Interpreter,
    before: &[i64],
    wish: Option<ErrorCode>,
    random: &mut Random,
) -> Vec<i64> {
    let mut plant = before.to_vec();
    for _ in 0..12 {
        plant = before.to_vec();
        // Near the previous step, or anywhere.
        let changes = if random.below(3) == 0 {
            machine.plant.len() as u64
        } else {
            random.below(3)
        };
        for _ in 0..changes {
            if let Some(i) = (!plant.is_empty()).then(|| random.below(plant.len() as u64) as usize)
            {
                plant[i] = random.within(&machine.plant[i].domain);
            }
        }
        if wish == Some(ErrorCode::Domain) && !plant.is_empty() {
            let i = random.below(plant.len() as u64) as usize;
            let domain = &machine.plant[i].domain;
            plant[i] = match random.below(4) {
                0 => domain.low() - 1,
                1 => i64::MIN,
                2 => i64::MAX,
                _ => domain.high() + 1,
            };
            return plant;
        }
        if interpreter.peek(&plant).err().map(|e| e.code) == wish {
            break;
        }
    }
    plant
}
