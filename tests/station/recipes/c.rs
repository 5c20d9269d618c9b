//! The C of machines, compiled without a warning, on random inputs that take every transition.

use super::cells::Made;
use crate::random::Random;
use linewright::mealy::Machine;
use linewright::station::emit::controller::of_machine_from;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// Maximum number of steps until every transition was taken.
const MAX_STEPS: usize = 50_000;

/// Inputs with the outputs of the machine, one step per line. The first number of an input tells
/// whether to begin anew.
fn walk(machine: &Machine, random: &mut Random) -> (String, String) {
    let (mut given, mut wanted) = (String::new(), String::new());
    let mut left: BTreeSet<(Option<usize>, usize)> = (0..machine.states.len())
        .map(Some)
        .chain([None])
        .flat_map(|state| (0..machine.transitions(state).len()).map(move |t| (state, t)))
        .collect();
    let (mut state, mut finished) = (None, 0);
    for _ in 0..MAX_STEPS {
        let reset = finished > 3 || random.chance(1);
        if reset {
            (state, finished) = (None, 0);
        }
        let inputs: Vec<i64> = (machine.inputs.iter().enumerate())
            .map(|(input, _)| i64::from(random.chance(if input == 0 { 70 } else { 40 })))
            .collect();
        let all = machine.transitions(state).iter();
        let taken = all.into_iter().position(|t| t.guard.holds(&inputs));
        let taken = taken.expect("a transition for all inputs");
        left.remove(&(state, taken));
        let taken = &machine.transitions(state)[taken];
        finished += taken.output.last().copied().unwrap_or_default();
        state = Some(taken.to);
        let line = |values: &[i64]| {
            let values: Vec<String> = values.iter().map(i64::to_string).collect();
            values.join(" ")
        };
        let _ = writeln!(given, "{} {}", i32::from(reset), line(&inputs));
        let _ = writeln!(wanted, "0 {}", line(&taken.output));
        if left.is_empty() {
            return (given, wanted);
        }
    }
    panic!("{}: {left:?} not taken", machine.name);
}

/// A program that runs the controller named by its argument. All values are of the type `int32_t`.
fn driver(names: &[String]) -> String {
    let mut text = "#include <stdio.h>\n#include <string.h>\n".to_owned();
    for name in names {
        let _ = writeln!(
            text,
            "#include \"{name}.h\"
static int run_{name}(void)
{{
    {name}_state state;
    {name}_inputs inputs;
    {name}_outputs outputs;
    int32_t in[sizeof inputs / 4], out[sizeof outputs / 4];
    int reset;
    size_t i;
    {name}_reset(&state);
    while (scanf(\"%d\", &reset) == 1) {{
        if (reset) {name}_reset(&state);
        for (i = 0; i < sizeof in / sizeof in[0]; i++) if (scanf(\"%d\", &in[i]) != 1) return 1;
        memcpy(&inputs, in, sizeof in);
        printf(\"%d\", {name}_step(&state, &inputs, &outputs));
        memcpy(out, &outputs, sizeof out);
        for (i = 0; i < sizeof out / sizeof out[0]; i++) printf(\" %d\", out[i]);
        printf(\"\\n\");
    }}
    return 0;
}}"
        );
    }
    text.push_str("int main(int argc, char **argv)\n{\n");
    for name in names {
        let _ = writeln!(
            text,
            "    if (argc == 2 && strcmp(argv[1], \"{name}\") == 0) return run_{name}();"
        );
    }
    text + "    return 1;\n}\n"
}

fn compile(folder: &Path, arguments: &[String]) {
    let output = Command::new("cc")
        .args(arguments)
        .current_dir(folder)
        .output();
    let output = output.expect("the compiler starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.is_empty(), "{text}");
}

/// Compiles all, runs each, and compares.
pub fn compare(all: &[Made]) {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: String, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a file can be written");
    };
    let mut names = Vec::new();
    for made in all {
        let origin = made.built.origin(&made.layout, &made.recipe);
        let specification = made.built.specification();
        let files = of_machine_from(&made.built.machine, &specification, &origin);
        write(format!("{}.h", files.name), &files.header);
        write(format!("{}.c", files.name), &files.source);
        names.push(files.name);
    }
    write("driver.c".to_owned(), &driver(&names));
    let strict = "-std=c99 -pedantic -Wall -Wextra -Wconversion -Werror -c".split(' ');
    let sources = names.iter().map(|name| format!("{name}.c"));
    let arguments: Vec<String> = strict.map(str::to_owned).chain(sources).collect();
    compile(folder.path(), &arguments);
    let objects = names.iter().map(|name| format!("{name}.o"));
    let driver = "-std=c99 -o driver driver.c".split(' ').map(str::to_owned);
    compile(folder.path(), &driver.chain(objects).collect::<Vec<_>>());
    for (made, name) in all.iter().zip(&names) {
        let (given, wanted) = walk(&made.built.machine, &mut Random::new(7));
        let mut child = Command::new(folder.path().join("driver"))
            .arg(name)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the driver starts");
        let mut stdin = child.stdin.take().expect("a pipe");
        let writer = std::thread::spawn(move || stdin.write_all(given.as_bytes()));
        let output = child.wait_with_output().expect("the driver ends");
        let _ = writer.join();
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(printed == wanted, "{name}: {printed}\n{wanted}");
    }
}
