//! The C of a controller compared with its interpreter: 100,000 random steps, including refused
//! ones.

use super::{benchmark, fixtures, functions, library, support};
use crate::random::{self, Random};
use crate::support::assumed::Assumed;
use linewright::game::{KernelChoice, Limits, Outcome, solve};
use linewright::gr1::{Domain, Specification};
use linewright::mealy::extract::extract;
use linewright::mealy::functions::{Functions, Refusal};
use linewright::mealy::{Machine, Port};
use linewright::station::emit::controller::{Files, of_functions, of_machine};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

const STEPS: usize = 100_000;

/// Maximum number of letters tried for a step.
const TRIES: usize = 16;

/// Number of successive refused steps after which the play is reset.
const REFUSED_AT_MOST: usize = 50;

/// A controller played step by step: outputs, or the code of the refusal.
trait Player {
    fn inputs(&self) -> &[Port];
    fn step(&mut self, inputs: &[i64]) -> Result<Vec<i64>, i32>;
    fn reset(&mut self);
}

struct Played<'a> {
    functions: &'a Functions,
    state: linewright::mealy::functions::State,
}

impl Player for Played<'_> {
    fn inputs(&self) -> &[Port] {
        &self.functions.inputs
    }

    fn step(&mut self, inputs: &[i64]) -> Result<Vec<i64>, i32> {
        let answer = self.functions.step(&mut self.state, inputs);
        answer.map_err(|refusal| match refusal {
            Refusal::Assumption(_) => -1,
            Refusal::Domain(_) => -2,
        })
    }

    fn reset(&mut self) {
        self.state = self.functions.initial_state();
    }
}

struct Explicit<'a> {
    machine: &'a Machine,
    assumed: Assumed<'a>,
    state: Option<usize>,
    /// Refused letters for which there is a transition.
    overruled: usize,
}

impl Player for Explicit<'_> {
    fn inputs(&self) -> &[Port] {
        &self.machine.inputs
    }

    fn step(&mut self, inputs: &[i64]) -> Result<Vec<i64>, i32> {
        let ports = self.machine.inputs.iter().zip(inputs);
        if ports.into_iter().any(|(p, v)| !p.domain.contains(*v)) {
            return Err(-2);
        }
        let taken = self.machine.step(self.state, inputs);
        if self.assumed.broken(inputs).is_some() {
            self.overruled += usize::from(taken.is_some());
            return Err(-1);
        }
        let taken = taken.expect("a transition wherever the assumptions are kept");
        self.assumed.accepted(inputs, &taken.output);
        self.state = Some(taken.to);
        Ok(taken.output.clone())
    }

    fn reset(&mut self) {
        self.state = None;
        self.assumed.reset();
    }
}

/// Inputs near the last ones; rarely some outside their domains.
fn letter(last: &[i64], domains: &[Domain], random: &mut Random) -> Vec<i64> {
    let mut inputs = last.to_vec();
    let all = random.chance(20);
    for (value, domain) in inputs.iter_mut().zip(domains) {
        if all || random.below(domains.len() as u64) == 0 {
            *value = domain.low() + random.below(domain.size()) as i64;
        }
    }
    if !inputs.is_empty() && random.chance(1) {
        let place = random.below(inputs.len() as u64) as usize;
        inputs[place] = domains[place].high() + 1;
    }
    inputs
}

/// Plays at random: inputs and answers. Inputs stay near the last accepted ones, so that most keep
/// the assumptions. If nothing is accepted for long, the environment has no way to continue, and
/// everything is reset.
fn play(player: &mut dyn Player, random: &mut Random, steps: usize) -> (String, String) {
    let (mut given, mut wanted) = (String::new(), String::new());
    let domains: Vec<_> = player.inputs().iter().map(|p| p.domain.clone()).collect();
    let mut last: Vec<i64> = domains.iter().map(Domain::low).collect();
    let mut refused = 0;
    for _ in 0..steps {
        let reset = refused == REFUSED_AT_MOST;
        if reset {
            player.reset();
            last = domains.iter().map(Domain::low).collect();
            refused = 0;
        }
        // A refusal changes nothing, so that a few letters can be tried; in two of five steps the
        // first one is taken as it is.
        let tries = if random.chance(40) { 1 } else { TRIES };
        let mut inputs = Vec::new();
        let mut answer = Err(0);
        for _ in 0..tries {
            inputs = letter(&last, &domains, random);
            answer = player.step(&inputs);
            if answer.is_ok() {
                break;
            }
        }
        let values: Vec<String> = inputs.iter().map(i64::to_string).collect();
        let _ = writeln!(given, "{} {}", i32::from(reset), values.join(" "));
        match answer {
            Ok(outputs) => {
                last = inputs;
                refused = 0;
                let values: Vec<String> = outputs.iter().map(i64::to_string).collect();
                let _ = writeln!(wanted, "0 {}", values.join(" "));
            }
            Err(code) => {
                refused += 1;
                let _ = writeln!(wanted, "{code}");
            }
        }
    }
    (given, wanted)
}

/// The fields of a structure of the header, in order.
fn fields(files: &Files, structure: &str) -> Vec<String> {
    let begin = format!("typedef struct {}_{structure} {{", files.name);
    let lines = files.header.lines().skip_while(|l| *l != begin).skip(1);
    let lines = lines.take_while(|l| !l.starts_with('}'));
    let fields = lines.filter_map(|l| l.split(';').next()?.split_whitespace().nth(1));
    fields.filter(|f| *f != "none").map(str::to_owned).collect()
}

/// A program that reads inputs and prints the answers of `NAME_step`.
fn driver(files: &Files) -> String {
    let name = &files.name;
    let mut reads = String::new();
    for field in fields(files, "inputs") {
        let _ = writeln!(
            reads,
            "        if (scanf(\"%lld\", &value) != 1) return 0;\n        inputs.{field} = value;"
        );
    }
    let mut prints = String::new();
    for field in fields(files, "outputs") {
        let _ = writeln!(
            prints,
            "            printf(\" %lld\", (long long)outputs.{field});"
        );
    }
    format!(
        "#include \"{name}.h\"\n#include <stdio.h>\n#include <string.h>\n\
         int main(int argc, char **argv)\n{{\n    {name}_state state, before;\n    {name}_inputs inputs;\n    {name}_outputs outputs;\n    long long value = 0, step, steps = 0;\n    int code;\n\
         memset(&state, 0, sizeof state);\n    memset(&inputs, 0, sizeof inputs);\n    if (argc < 2 || sscanf(argv[1], \"%lld\", &steps) != 1) return 2;\n    (void)value;\n    {name}_reset(&state);\n    for (step = 0; step < steps; step++) {{\n        if (scanf(\"%lld\", &value) != 1) return 0;\n        if (value) {name}_reset(&state);\n{reads}\
         memcpy(&before, &state, sizeof state);\n        code = {name}_step(&state, &inputs, &outputs);\n        printf(\"%d\", code);\n        if (code == 0) {{\n{prints}        }} else if (memcmp(&before, &state, sizeof state) != 0) {{\n            printf(\" changed\");\n        }}\n        printf(\"\\n\");\n    }}\n    return 0;\n}}\n"
    )
}

fn compiler() -> bool {
    let found = Command::new("cc")
        .arg("--version")
        .stdout(Stdio::null())
        .status();
    let found = found.is_ok_and(|s| s.success());
    if !found {
        support::skip("cc", "there is no C compiler");
    }
    found
}

fn compile(folder: &Path, arguments: &[&str]) {
    let output = Command::new("cc")
        .args(arguments)
        .current_dir(folder)
        .output();
    let output = output.expect("the compiler starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.is_empty(), "{text}");
}

/// Compiles without a warning, runs, and compares. Returns the number of accepted steps.
fn compare(files: &Files, player: &mut dyn Player, steps: usize) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a file can be written");
    };
    let source = format!("{}.c", files.name);
    write(&format!("{}.h", files.name), &files.header);
    write(&source, &files.source);
    write("driver.c", &driver(files));
    let strict = "-std=c99 -pedantic -Wall -Wextra -Wconversion -Werror -O1 -c";
    let strict: Vec<&str> = strict
        .split(' ')
        .chain([source.as_str(), "-o", "controller.o"])
        .collect();
    compile(folder.path(), &strict);
    compile(
        folder.path(),
        &["-w", "driver.c", "controller.o", "-o", "driver"],
    );

    let (given, wanted) = play(player, &mut Random::new(7), steps);
    let mut child = Command::new(folder.path().join("driver"))
        .arg(steps.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the driver starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    let writer = std::thread::spawn(move || stdin.write_all(given.as_bytes()));
    let output = child.wait_with_output().expect("the driver ends");
    let _ = writer.join();
    let printed = String::from_utf8_lossy(&output.stdout);
    let pairs = printed
        .lines()
        .map(str::trim_end)
        .zip(wanted.lines().map(str::trim_end));
    for (i, (printed, wanted)) in pairs.enumerate() {
        assert_eq!(printed, wanted, "{}: step {i}", files.name);
    }
    assert_eq!(printed.lines().count(), steps, "{}", files.name);
    let count = |code: &str| wanted.lines().filter(|l| l.starts_with(code)).count();
    let (accepted, broken) = (count("0"), count("-1"));
    println!(
        "{}: {accepted} of {steps} steps accepted, {broken} broke an assumption",
        files.name
    );
    accepted
}

/// The number of accepted steps; `None` for an unrealizable specification.
fn compare_functions(specification: &Specification, steps: usize) -> Option<usize> {
    let functions = functions(specification, KernelChoice::Automatic)?;
    let mut player = Played {
        state: functions.initial_state(),
        functions: &functions,
    };
    Some(compare(&of_functions(&functions), &mut player, steps))
}

fn compare_machine(specification: &Specification, steps: usize) {
    let limits = Limits::default();
    if let Outcome::Realizable(won) = solve(specification, &limits) {
        let machine = extract(specification, &won, &limits).expect("no limit");
        play_machine(&machine, specification, steps);
    }
}

/// Number of refused letters for which the machine has a transition.
fn play_machine(machine: &Machine, specification: &Specification, steps: usize) -> usize {
    let mut player = Explicit {
        machine,
        assumed: Assumed::new(specification),
        state: None,
        overruled: 0,
    };
    compare(&of_machine(machine, specification), &mut player, steps);
    player.overruled
}

#[test]
fn c_of_the_fixtures_does_what_the_interpreter_does() {
    if !compiler() {
        return;
    }
    for specification in fixtures::contracts() {
        assert!(compare_functions(&specification, STEPS) > Some(STEPS / 10));
        compare_machine(&specification, STEPS);
    }
}

#[test]
fn c_of_the_library_does_what_the_interpreter_does() {
    if !compiler() {
        return;
    }
    let mut overruled = 0;
    for controlled in library::machines() {
        let specification = &controlled.specification;
        let machine = controlled.controller.machine().expect("a machine");
        overruled += play_machine(machine, specification, STEPS);
        assert!(compare_functions(specification, STEPS).is_some());
    }
    assert!(overruled > STEPS, "{overruled}");
}

#[test]
fn c_of_assumptions_that_compute_does_what_the_interpreter_does() {
    if !compiler() {
        return;
    }
    let specification = library::wide();
    compare_machine(&specification, STEPS);
    assert!(compare_functions(&specification, STEPS).is_some());
}

#[test]
fn names_that_headers_and_compilers_use_are_replaced() {
    if !compiler() {
        return;
    }
    let mut specification = fixtures::contracts().swap_remove(0);
    specification.name = "stdint".to_owned();
    let names = [
        "NULL",
        "INT32_MAX",
        "linux",
        "static_assert",
        "int32_t",
        "LINEWRIGHT_stdint_H",
        "class",
        "for",
    ];
    for (variable, name) in specification.variables.iter_mut().zip(names) {
        name.clone_into(&mut variable.name);
    }
    assert!(compare_functions(&specification, 5_000).is_some());
    compare_machine(&specification, 5_000);
}

#[test]
fn c_of_random_controllers_does_what_the_interpreter_does() {
    if !compiler() {
        return;
    }
    let mut compared = 0;
    for seed in 0.. {
        let specification = random::specification(&mut Random::new(seed));
        if compare_functions(&specification, 5_000).is_some() {
            compare_machine(&specification, 5_000);
            compared += 1;
        }
        if compared == 15 {
            break;
        }
    }
}

#[test]
fn c_of_benchmarks_does_what_the_interpreter_does() {
    if !compiler() {
        return;
    }
    for name in [
        "genbuf5.slugsin",
        "genbuf10.slugsin",
        "genbuf40.slugsin",
        "amba2.slugsin",
        "amba5.slugsin",
    ] {
        if let Some(specification) = benchmark(name) {
            assert!(compare_functions(&specification, STEPS) > Some(STEPS / 20));
            if name == "genbuf5.slugsin" {
                compare_machine(&specification, STEPS);
            }
        }
    }
}
