//! The monitor in C: compiled without a warning, as C and as C++, and run beside the one of this
//! process.

use super::reference::some_call;
use super::tables::random;
use crate::random::Random;
use crate::unit::pick_and_place;
use linewright::order::monitor::{Monitor, RefusalReason, Verdict};
use linewright::order::table::Table;
use linewright::station::emit::controller::Files;
use linewright::station::monitor::c;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// Commands of a script: `c` a mask called at once, `o` one skill, `a` a query for a mask, `n` the
/// possible next calls, `t` a run of skills, `r` reset.
fn driver(name: &str) -> String {
    format!(
        "#include \"{name}.h\"\n#include <stdio.h>\n#include <inttypes.h>\n\
         static int say(int answer) {{ printf(\"%d %s\\n\", answer, {name}_text(answer)); return 0; }}\n\
         int main(void) {{\n    {name} monitor;\n    char what;\n    uint64_t mask;\n    uint8_t run[64];\n    size_t i;\n    {name}_reset(&monitor);\n\
         \x20   while (scanf(\" %c %\" SCNu64, &what, &mask) == 2) {{\n\
         \x20       switch (what) {{\n\
         \x20       case 'c': say({name}_call(&monitor, mask)); break;\n\
         \x20       case 'o': say({name}_call_one(&monitor, (unsigned)mask)); break;\n\
         \x20       case 'a': say({name}_allows(&monitor, mask)); break;\n\
         \x20       case 'n': printf(\"%\" PRIu64 \"\\n\", {name}_allowed(&monitor)); break;\n\
         \x20       case 'r': {name}_reset(&monitor); printf(\"reset\\n\"); break;\n\
         \x20       default:\n\
         \x20           for (i = 0; i < mask; i++) {{ unsigned one; if (scanf(\"%u\", &one) != 1) return 1; run[i] = (uint8_t)one; }}\n\
         \x20           printf(\"%u\\n\", (unsigned){name}_run(&monitor, run, (size_t)mask));\n\
         \x20       }}\n    }}\n    return 0;\n}}\n"
    )
}

fn compile(folder: &Path, compiler: &str, arguments: &str) {
    let output = Command::new(compiler)
        .args(arguments.split(' '))
        .current_dir(folder)
        .output();
    let output = output.expect("the compiler starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.is_empty(), "{text}");
}

/// A script of random calls, and the answers of this process's monitor.
fn script(table: &Table, steps: usize, seed: u64) -> (String, String) {
    let mut random = Random::new(seed);
    let mut monitor = Monitor::new(table);
    let answer = |verdict: Verdict| {
        let rules = table.rules.len();
        match verdict {
            Verdict::Allowed => "0 allowed".to_owned(),
            Verdict::Refused(why) => {
                let code = match why {
                    RefusalReason::Rule(rule) => rule,
                    RefusalReason::Recall => rules,
                    RefusalReason::Together => rules + 1,
                    RefusalReason::Unknown => rules + 2,
                };
                format!("-{} {}", code + 1, why.text(&table.rules))
            }
        }
    };
    let (mut given, mut wanted) = (String::new(), String::new());
    for _ in 0..steps {
        let mask = some_call(table, &mut random);
        let said = match random.below(20) {
            0 => {
                given.push_str("r 0\n");
                monitor.reset();
                "reset".to_owned()
            }
            1 => {
                given.push_str("n 0\n");
                monitor.allowed().to_string()
            }
            2 => {
                let bound = table.skills.len() as u64 + u64::from(random.chance(20));
                let calls: Vec<u8> = (0..random.below(20))
                    .map(|_| random.below(bound) as u8)
                    .collect();
                let _ = write!(given, "t {}", calls.len());
                for call in &calls {
                    let _ = write!(given, " {call}");
                }
                given.push('\n');
                let refusal = monitor.run(&calls);
                refusal.map_or(calls.len(), |r| r.at).to_string()
            }
            3 => {
                let _ = writeln!(given, "a {mask}");
                answer(monitor.allows(mask))
            }
            4..10 => {
                let skill = random.below(table.skills.len() as u64 + 2) as u8;
                let _ = writeln!(given, "o {skill}");
                answer(monitor.call(skill))
            }
            _ => {
                let _ = writeln!(given, "c {mask}");
                answer(monitor.call_at_once(mask))
            }
        };
        wanted.push_str(&said);
        wanted.push('\n');
    }
    (given, wanted)
}

/// Compiles, runs, compares.
fn compare(files: &Files, table: &Table, steps: usize, seed: u64) {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a file can be written");
    };
    let source = format!("{}.c", files.name);
    write(&format!("{}.h", files.name), &files.header);
    write(&source, &files.source);
    write("driver.c", &driver(&files.name));
    let strict = "-pedantic -Wall -Wextra -Wconversion -Werror -c";
    let c99 = format!("-std=c99 {strict} -O2 {source} -o monitor.o");
    compile(folder.path(), "cc", &c99);
    let header = format!("-x c++ -std=c++11 {strict} {}.h -o header.o", files.name);
    if Command::new("c++").arg("--version").output().is_ok() {
        compile(folder.path(), "c++", &header);
    }
    compile(
        folder.path(),
        "cc",
        "-std=c99 -w driver.c monitor.o -o driver",
    );
    let (given, wanted) = script(table, steps, seed);
    let mut child = Command::new(folder.path().join("driver"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the driver starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    let text = given.clone();
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let output = child.wait_with_output().expect("the driver ends");
    let _ = writer.join();
    let printed = String::from_utf8_lossy(&output.stdout);
    let said = printed.lines().zip(wanted.lines());
    for (step, (asked, (printed, wanted))) in given.lines().zip(said).enumerate() {
        assert_eq!(printed, wanted, "{}, step {step}: {asked}", files.name);
    }
    assert_eq!(printed.lines().count(), steps, "{}", files.name);
}

#[test]
fn the_unit_in_c() {
    for recalls in [true, false] {
        let table = pick_and_place(recalls);
        compare(&c::files(&table), &table, 50_000, 11);
    }
}

#[test]
fn any_table_in_c() {
    for seed in 0..12 {
        let table = random(seed);
        compare(&c::files(&table), &table, 3_000, seed);
    }
}

#[test]
fn what_the_c_looks_like() {
    let files = c::files(&pick_and_place(false));
    assert_eq!(files.name, "PickAndPlace_order");
    insta::assert_snapshot!("header", files.header);
    insta::assert_snapshot!("source", files.source);
}
