//! Monitors of skill orders: skills per second on one core, for the pick-and-place unit with both
//! rules.
//!
//!     cargo bench --bench monitor
//!
//! A legal program of four million random skills is read in one run, and call by call: by
//! Linewright's monitor, by the emitted C (compiled with `cc -O2`, loaded as a library), and by the
//! compiled automaton of the regular expression for the same rules (regex-automata, minimized),
//! queried after every skill whether it may go on, and with its own search.

#[expect(dead_code, reason = "only its random numbers are needed")]
#[path = "../solver/random.rs"]
mod random;
#[path = "../station/unit.rs"]
mod unit;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use linewright::order::monitor::Monitor;
use linewright::order::table::Table;
use linewright::station::monitor::c;
use random::Random;
use regex_automata::dfa::{Automaton, StartKind, dense};
use regex_automata::util::{start, syntax};
use regex_automata::{Anchored, Input};
use std::hint::black_box;
use std::process::Command;

const SKILLS: usize = 4_000_000;

/// What the emitted C declares.
type Reset = unsafe extern "C" fn(*mut u32);
type CallOne = unsafe extern "C" fn(*mut u32, u32) -> i32;
type Run = unsafe extern "C" fn(*mut u32, *const u8, usize) -> usize;

/// The rules from up: Left, Right, Up, Down, Grip and Release are the bytes 0 to 5. The language is
/// prefix-closed.
const RULES: &str = r"(?s-u)(?:[\x00\x01\x02\x04]*\x03[\x03\x04\x05]*\x02)*[\x00\x01\x02\x04]*(?:\x03[\x03\x04\x05]*)?";

/// Random skills, all allowed.
fn program(table: &Table) -> Vec<u8> {
    let mut random = Random::new(7);
    let mut monitor = Monitor::new(table);
    let mut program = Vec::with_capacity(SKILLS);
    while program.len() < SKILLS {
        let skill = random.below(6) as u8;
        if monitor.call(skill).is_allowed() {
            program.push(skill);
        }
    }
    program
}

/// The emitted C as a loaded library.
fn library(table: &Table) -> libloading::Library {
    let files = c::files(table);
    let folder = tempfile::tempdir().expect("a folder");
    let write = |ending: &str, text: &str| {
        let path = folder.path().join(format!("{}.{ending}", files.name));
        std::fs::write(path, text).expect("a file can be written");
    };
    write("h", &files.header);
    write("c", &files.source);
    let library = folder.path().join("monitor.so");
    let status = Command::new("cc")
        .args(["-std=c99", "-O2", "-fPIC", "-shared", "-o"])
        .arg(&library)
        .arg(folder.path().join(format!("{}.c", files.name)))
        .status();
    assert!(status.expect("the compiler starts").success());
    #[expect(unsafe_code, reason = "the C form is measured as it ships")]
    // SAFETY: the library is our own C, which has no constructors.
    unsafe { libloading::Library::new(library) }.expect("a library that loads")
}

fn find<T: Copy>(library: &libloading::Library, name: &str) -> T {
    #[expect(unsafe_code, reason = "the C form is measured as it ships")]
    // SAFETY: the types above are those of the emitted header.
    unsafe { library.get::<T>(name) }
        .map(|symbol| *symbol)
        .expect("the function is exported")
}

fn monitors(criterion: &mut Criterion) {
    let table = unit::pick_and_place(true);
    let program = program(&table);
    let mut group = criterion.benchmark_group("monitor");
    group.throughput(Throughput::Elements(SKILLS as u64));
    group.sample_size(20);

    let mut monitor = Monitor::new(&table);
    group.bench_function("ours, one run", |b| {
        b.iter(|| {
            monitor.reset();
            assert_eq!(monitor.run(black_box(&program)), None);
        });
    });
    group.bench_function("ours, call by call", |b| {
        b.iter(|| {
            monitor.reset();
            for skill in black_box(&program) {
                assert!(monitor.call(*skill).is_allowed());
            }
        });
    });

    let library = library(&table);
    let reset: Reset = find(&library, "PickAndPlace_order_reset");
    let call_one: CallOne = find(&library, "PickAndPlace_order_call_one");
    let run: Run = find(&library, "PickAndPlace_order_run");
    let mut state = 0;
    #[expect(unsafe_code, reason = "the C form is measured as it ships")]
    group.bench_function("C, one run", |b| {
        b.iter(|| {
            let program = black_box(&program);
            // SAFETY: the state is the only field of the monitor, and the program has that many
            // bytes.
            let count = unsafe {
                reset(&raw mut state);
                run(&raw mut state, program.as_ptr(), program.len())
            };
            assert_eq!(count, SKILLS);
        });
    });
    #[expect(unsafe_code, reason = "the C form is measured as it ships")]
    group.bench_function("C, call by call", |b| {
        b.iter(|| {
            // SAFETY: the state is the only field of the monitor.
            unsafe { reset(&raw mut state) };
            for skill in black_box(&program) {
                // SAFETY: as before.
                let answer = unsafe { call_one(&raw mut state, u32::from(*skill)) };
                assert_eq!(answer, 0);
            }
        });
    });

    let dfa = dense::Builder::new()
        .configure(
            dense::Config::new()
                .minimize(true)
                .start_kind(StartKind::Anchored),
        )
        .syntax(syntax::Config::new().unicode(false).utf8(false))
        .build(RULES)
        .expect("an automaton");
    let start = start::Config::new().anchored(Anchored::Yes);
    let start = dfa.start_state(&start).expect("a start");
    group.bench_function("regex-automata, skill by skill", |b| {
        b.iter(|| {
            let mut state = start;
            let refused = black_box(&program).iter().position(|skill| {
                state = dfa.next_state(state, *skill);
                dfa.is_dead_state(state)
            });
            assert_eq!(refused, None);
        });
    });
    group.bench_function("regex-automata, one search", |b| {
        b.iter(|| {
            let input = Input::new(black_box(&program)).anchored(Anchored::Yes);
            let found = dfa.try_search_fwd(&input).expect("a search");
            assert_eq!(found.map(|half| half.offset()), Some(SKILLS));
        });
    });
    group.finish();
}

criterion_group!(benches, monitors);
criterion_main!(benches);
