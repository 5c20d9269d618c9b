//! Skill orders on the command line: documents, exit codes, the formats of programs, emitted files.
//! The READMEs show the rest.

use crate::support;
use crate::support::linewright;
use serde_json::Value;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const UNIT: &str = "examples/pick-and-place/unit.lw";

fn at_root(arguments: &[&str]) -> Output {
    linewright(support::root(), arguments)
}

fn document(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)))
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The document of `order check` on a program with this name and text.
fn checked(name: &str, program: &str, more: &[&str]) -> (Value, Output) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, program).expect("a program");
    let path = path.to_string_lossy();
    let all = ["order", "check", &path, "--rules", UNIT, "--format", "json"];
    let output = at_root(&[&all[..], more].concat());
    (document(&output), output)
}

#[test]
fn a_violation_has_its_step_its_rule_and_the_way_out() {
    let (document, output) = checked("p.txt", "Right\nDown\n\n# still down\nLeft\n", &[]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(document["schema"], "linewright/order-check/1");
    let program = &document["programs"][0];
    assert_eq!(program["verdict"], "refused");
    assert_eq!(program["calls"], 3);
    let violation = &program["violation"];
    assert_eq!(violation["step"], 3);
    assert_eq!(violation["rule"], "trays");
    assert_eq!(violation["detour"], serde_json::json!([["Up"]]));
    assert_eq!(program["findings"][0]["code"], "LW317");
    assert_eq!(program["findings"][0]["span"]["line"], 5);
}

/// Whatever a command finds, its document first states its kind, the skills, and the level.
#[test]
fn documents_begin_alike() {
    let program = "examples/pick-and-place/intended.txt";
    for (command, rest) in [
        ("check", vec![program, "--rules", UNIT]),
        ("complete", vec![UNIT]),
        ("fsm", vec![UNIT]),
        ("regex", vec![UNIT]),
        ("strongest", vec![UNIT]),
    ] {
        let all = ["order", command, "--format", "json", "--level", "valid"];
        let output = at_root(&[&all[..], &rest].concat());
        let start = format!(
            "{{\n  \"schema\": \"linewright/order-{command}/1\",\n  \"skills\": \"PickAndPlace\",\n  \"level\": \"valid\",\n"
        );
        assert!(text(&output).starts_with(&start), "{}", text(&output));
        // A program's errors are findings; results of the other commands are not.
        let output = at_root(&[&["order", command, "--format", "sarif"], &rest[..]].concat());
        if command == "check" {
            assert_eq!(document(&output)["version"], "2.1.0");
        } else {
            assert_eq!(output.status.code(), Some(2), "{command}");
            assert!(error(&output).contains("--format json"), "{command}");
        }
    }
}

/// Each command that fails at the file of rules reports so in its own name.
#[test]
fn mistakes_in_a_file_are_reported_by_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write("a.lw", "skills A { component x { next } }\n");
    write("p.txt", "Left\n");
    for (command, rest) in [
        ("check", vec!["p.txt", "--rules", "a.lw"]),
        ("complete", vec!["a.lw"]),
        ("diff", vec!["a.lw", "a.lw"]),
        ("fsm", vec!["a.lw"]),
        ("monitor", vec!["a.lw"]),
        ("regex", vec!["a.lw"]),
        ("strongest", vec!["a.lw"]),
    ] {
        let all = ["order", command, "--format", "json"];
        let output = linewright(folder.path(), &[&all[..], &rest].concat());
        assert_eq!(output.status.code(), Some(2), "{command}");
        let found = document(&output);
        let schema = format!("linewright/order-{command}/1");
        assert_eq!(found["schema"], schema.as_str());
        assert_eq!(found["findings"][0]["code"], "LW002");
    }
}

#[test]
fn unknown_situations_are_reported_with_their_component() {
    for useful in ["z.lft", "gripper.left"] {
        let output = at_root(&["order", "strongest", UNIT, "--useful", useful]);
        assert_eq!(output.status.code(), Some(2));
        let wanted =
            format!("there is no situation `{useful}`: choose one of x.left, x.right, z.up");
        assert!(error(&output).contains(&wanted), "{}", error(&output));
    }
}

/// All of these are the program `Right & Grip`, `Down`.
#[test]
fn a_program_is_text_or_a_table() {
    for (name, program) in [
        ("p.txt", "Right & Grip // at once\nDown\n"),
        ("p.txt", "\u{feff}Right&Grip\r\nDown\r\n"),
        ("p.txt", "Right & Grip\rDown\r"),
        ("p.csv", "Right,Grip\nDown,\n"),
        ("p.csv", "skill;comment\nRight & Grip;both\nDown;then\n"),
        ("p.csv", "step,skill\n1,Right\n1,Grip\n\n2,Down\n"),
        (
            "p.csv",
            "\u{feff}\n;\nstep;skill\n1;Right\n01;Grip\n;\n2;Down\n",
        ),
        (
            "p.CSV",
            "Step\tCalls\r\n10\tRight\r\n10\tGrip\r\n20\tDown\r\n",
        ),
        ("p.csv", "step;skill\r1;Right\r1;Grip\r2;Down\r"),
    ] {
        let (document, output) = checked(name, program, &[]);
        assert_eq!(output.status.code(), Some(0), "{program}: {document}");
        assert_eq!(document["programs"][0]["calls"], 2, "{program}");
        assert_eq!(document["programs"][0]["verdict"], "accepted");
    }
}

/// The findings for a program that cannot be read.
fn invalid(name: &str, program: &str) -> String {
    let (document, output) = checked(name, program, &[]);
    assert_eq!(output.status.code(), Some(2), "{document}");
    let program = &document["programs"][0];
    assert_eq!(program["verdict"], "invalid");
    let findings = program["findings"].as_array().expect("findings");
    let shown = findings.iter().map(|f| {
        let place = &f["span"];
        format!(
            "{}:{} {} ({})",
            place["line"], place["column"], f["message"], f["help"]
        )
    });
    shown.collect::<Vec<_>>().join("\n")
}

/// Rows of one call are consecutive and in call order.
#[test]
fn repeated_and_decreasing_steps_are_reported() {
    let programs = [
        // Repeated steps.
        "step,skill\n1,Right\n1,Grip\n2,Down\n1,Up\n1,Release\n2,Up\n",
        // Going back, and an unknown name.
        "step;skill\n10;Right\n 9;Down\n11;Dwon\n",
        // Names of steps have no order, but do not occur again either.
        "step;skill\nb;Right\na;Down\nb;Up\n",
        // The same number, and the same skill twice.
        "step;skill\n1;Right\n01;Grip\n1;Right\n",
        // Without a step.
        "step;skill\n1;Right\n;Grip\n2;Down\n",
        // The part before the dot counts.
        "step;skill\n1.9;Right\n1.10;Down\n2.1;Grip\n1.11;Up\n",
        // An error in a step does not affect the previous one.
        "step;skill\n1;Right\n2;Rihgt\n2;Right\n",
    ];
    let shown = programs.map(|p| format!("{p}{}\n", invalid("p.csv", p)));
    insta::assert_snapshot!(shown.join("\n"));
    let (document, output) = checked(
        "p.csv",
        "step;skill\n-1;Right\n2;Down\n2;Grip\n10;Up\nA;Left\n3;Down\n",
        &[],
    );
    assert_eq!(output.status.code(), Some(0), "{document}");
    assert_eq!(document["programs"][0]["calls"], 5);
}

#[test]
fn a_table_without_a_header_says_how_to_write_one() {
    let programs = [
        "1;Left\n2;Rigth\n3;Up\n",
        "\n1,Left\n",
        "no;action\n1;Left\n",
        "Lfet;Down\n",
        "Left;before all\nDown;\n",
    ];
    let shown = programs.map(|p| format!("{p}{}\n", invalid("p.csv", p)));
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn all_unreadable_files_are_reported_at_once() {
    let program = "Rigth\nDown Grip\nUp & Up\nLeft &\nUp\n";
    insta::assert_snapshot!(invalid("p.txt", program));
    let (document, output) = checked("p.csv", "skill\nRigth\nUp\n", &[]);
    assert_ne!(output.status.code(), Some(0));
    assert_eq!(document["programs"][0]["findings"][0]["span"]["line"], 2);
}

/// A missing program is reported before rules are searched beside it.
#[test]
fn a_missing_program_is_reported_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let check =
        |arguments: &[&str]| linewright(folder.path(), &[&["order", "check"], arguments].concat());
    let output = check(&["nosuch.txt"]);
    assert_eq!(output.status.code(), Some(2));
    let said = error(&output);
    assert!(
        said.starts_with("error[LW001]: nosuch.txt cannot be read"),
        "{said}"
    );
    assert!(!said.contains("--rules"), "{said}");
    let found = document(&check(&["nosuch.txt", "--format", "json"]));
    assert_eq!(found["schema"], "linewright/order-check/1");
    assert_eq!(found["findings"][0]["code"], "LW001");

    // The rules beside another one are used; if there are none, both findings are reported.
    fs::write(folder.path().join("p.txt"), "Right\n").expect("a program");
    let said = error(&check(&["nosuch.txt", "p.txt"]));
    let (program, rules) = (said.find("nosuch.txt cannot"), said.find("--rules FILE"));
    assert!(program.is_some() && program < rules, "{said}");
    fs::copy(support::root().join(UNIT), folder.path().join("unit.lw")).expect("a copy");
    let output = check(&["nosuch.txt", "p.txt"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        text(&output),
        "nosuch.txt: cannot be read\np.txt: accepted, 1 call (valid)\n"
    );
}

/// A set of skills `Small` with these orders, in a separate file: the output of a command for it.
fn small(orders: &str, command: &[&str]) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    let set = format!(
        "skills Small {{\n    component x {{ Left, Right }}\n    component y {{ Grip }}\n    {orders}\n}}\n"
    );
    fs::write(folder.path().join("small.lw"), set).expect("a file");
    let all = [&["order", command[0], "small.lw"], &command[1..]].concat();
    linewright(folder.path(), &all)
}

/// Each is an option of the command.
#[test]
fn what_is_advised_where_it_is_too_large_is_there() {
    let large = "order many: sequence (.* Left .{20})";
    for (command, options) in [
        (&["regex"][..], &["--rule NAME"][..]),
        (&["fsm"], &["--rule NAME", "--at-once N", "--by-component"]),
        (&["fsm", "--by-component"], &["--rule NAME"]),
        (&["complete"], &["--rule NAME"]),
        (
            &["complete", "--at-once", "2"],
            &["--rule NAME", "--at-once N"],
        ),
        (&["monitor"], &["--rule NAME", "--at-once N"]),
        (&["monitor", "--at-once", "1"], &["--rule NAME"]),
        (&["strongest"], &["--rule NAME", "--longest N"]),
    ] {
        let output = small(large, command);
        assert_eq!(output.status.code(), Some(3), "{command:?}");
        let said = error(&output);
        for option in [
            "--rule NAME",
            "--at-once N",
            "--by-component",
            "--longest N",
        ] {
            let wanted = options.contains(&option);
            assert_eq!(said.contains(option), wanted, "{command:?}: {said}");
        }
    }
}

/// The printed expression can be pasted into a file, or the output says that it cannot.
#[test]
fn an_expression_goes_back_into_a_file() {
    for (orders, why) in [
        ("order: at most 2 of Grip", None),
        (
            "order: at most 250 of Grip",
            Some("nested more than 200 levels deep (LW002)"),
        ),
        (
            "order: at most 12 of Left\n    order: at most 12 of Right",
            Some("more than 10000 skills when repetitions are expanded (LW112)"),
        ),
    ] {
        let output = small(orders, &["regex"]);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
        match why {
            None => assert_eq!(error(&output), ""),
            Some(why) => assert!(error(&output).contains(why), "{}", error(&output)),
        }
        let sequence = format!("order: sequence ({})", text(&output).trim());
        let again = small(&sequence, &["regex"]);
        assert_eq!(again.status.code() == Some(0), why.is_none(), "{orders}");
        if why.is_none() {
            assert_eq!(text(&again), text(&output));
        }
    }
}

/// A sequence that cannot be completed because of the other rules.
#[test]
fn an_expression_for_no_program_is_said_to_be_that() {
    let orders = "order begin: sequence (Left Grip)\n    order end: never Grip";
    let output = small(orders, &["regex", "--whole"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output), "not (Left | Right | Grip)\n");
    assert!(
        error(&output).starts_with("no program is complete"),
        "{}",
        error(&output)
    );
    let sequence = format!("order: sequence ({})", text(&output).trim());
    assert_eq!(
        text(&small(&sequence, &["regex", "--whole"])),
        text(&output)
    );
    assert_eq!(text(&small(orders, &["regex"])), "Left?\n");
}

/// The help for a missing name uses existing skills.
#[test]
fn help_names_skills_that_there_are() {
    let said = |component: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(
            folder.path().join("a.lw"),
            format!("skills A {{ component x {{ Turn Stop }} {component} }}\n"),
        )
        .expect("a file");
        error(&linewright(
            folder.path(),
            &["order", "complete", "a.lw", ""],
        ))
    };
    let wanted =
        "a skill is missing: write `Turn`, or `Turn & Wait` for skills that are called at once";
    assert!(said("component y { Wait }").contains(wanted));
    assert!(
        said("")
            .trim_end()
            .ends_with("a skill is missing: write `Turn`")
    );
}

#[test]
fn rules_are_chosen_by_name_and_level() {
    let program = "Down\nRight\n";
    let codes = [
        (vec![], 1),
        (vec!["--rule", "transport"], 0),
        (vec!["--no-rule", "trays"], 0),
        (vec!["--level", "arbitrary"], 0),
        (vec!["--level", "reasonable", "--rule", "transport"], 0),
    ];
    for (more, code) in codes {
        let (_, output) = checked("p.txt", program, &more);
        assert_eq!(output.status.code(), Some(code), "{more:?}");
    }
    let output = at_root(&["order", "fsm", UNIT, "--rule", "tray"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        error(&output).contains("did you mean `trays`?"),
        "{}",
        error(&output)
    );
}

#[test]
fn one_order_is_enough_where_that_is_asked_for() {
    let program = "Right & Down\n";
    let (_, every) = checked("p.txt", program, &[]);
    let (_, some) = checked("p.txt", program, &["--some-order"]);
    assert_eq!(
        (every.status.code(), some.status.code()),
        (Some(1), Some(0))
    );
}

fn transitions(more: &[&str]) -> (usize, usize) {
    let all = ["order", "fsm", UNIT, "--format", "json"];
    let document = document(&at_root(&[&all[..], more].concat()));
    let count = |of: &str| document["automaton"][of].as_array().map_or(0, Vec::len);
    (count("states"), count("transitions"))
}

/// The figures of the paper, and those with every order.
#[test]
fn the_papers_figures() {
    let rules: [&[&str]; 4] = [
        &["--level", "arbitrary"],
        &["--rule", "trays"],
        &["--rule", "transport"],
        &[],
    ];
    let of = |more: &[&str]| rules.map(|r| transitions(&[r, more].concat()));
    assert_eq!(of(&[]), [(8, 64), (8, 40), (8, 52), (8, 32)]);
    assert_eq!(of(&["--paper"]), [(8, 64), (8, 48), (8, 52), (8, 38)]);
}

#[test]
fn an_automaton_is_written_in_every_form() {
    let folder = tempfile::tempdir().expect("a folder");
    for (form, start) in [
        ("table", "PickAndPlace"),
        ("json", "{"),
        ("dot", "digraph"),
        ("svg", "<svg"),
    ] {
        for more in [&[][..], &["--by-component"]] {
            let path = folder.path().join(format!("{form}{}", more.len()));
            let out = path.to_string_lossy();
            let all = ["order", "fsm", UNIT, "--emit", form, "--out", &out];
            let output = at_root(&[&all[..], more].concat());
            assert_eq!(output.status.code(), Some(0), "{}", error(&output));
            let text = fs::read_to_string(&path).expect("it was written");
            assert!(text.starts_with(start) || form == "table", "{form}: {text}");
        }
    }
}

/// The program's line-by-line answers to this input, by the rules of the unit.
fn monitored(input: impl AsRef<[u8]>, more: &[&str]) -> Output {
    watched(&support::root().join(UNIT), input, more)
}

/// The same by other rules.
fn watched(rules: &Path, input: impl AsRef<[u8]>, more: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_linewright"))
        .args(["order", "monitor"])
        .arg(rules)
        .args(more)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    // With `--stop` it may have ended already.
    let _ = stdin.write_all(input.as_ref());
    drop(stdin);
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_monitor_answers_each_line_and_refuses_without_losing_its_place() {
    let output = monitored("Down\nLeft # too early\nUp\nLeft & Grip\n", &[]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        text(&output),
        "Down: ok\nLeft: refused, trays: after Down until Up: never Left, Right\nUp: ok\nLeft & Grip: ok\n"
    );
    let output = monitored("Down\nLeft\nUp\n", &["--stop", "--format", "json"]);
    let lines: Vec<String> = text(&output).lines().map(str::to_owned).collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    let last: Value = serde_json::from_str(&lines[1]).expect("JSON");
    assert_eq!(
        (&last["line"], &last["allowed"]),
        (&Value::from(2), &Value::from(false))
    );
}

/// A line that is no call is refused like a call, and the next one is read.
#[test]
fn a_monitor_goes_on_behind_what_it_cannot_read() {
    let lines = "\u{feff}Down\nLfet\nL\u{1b}ft & \nDown & Down\n\u{a0}Up\u{a0}\nLeft\n";
    let output = monitored(lines, &[]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(error(&output), "");
    insta::assert_snapshot!(text(&output));

    let documents = |input: &[u8], more: &[&str]| -> Vec<Value> {
        let output = monitored(input, &[&["--format", "json"], more].concat());
        assert_eq!(output.status.code(), Some(1), "{}", error(&output));
        let lines: Vec<String> = text(&output).lines().map(str::to_owned).collect();
        let read = |l: &String| serde_json::from_str(l).expect("JSON");
        lines.iter().map(read).collect()
    };
    let found = documents(b"Down\n\nL\xffft\nLfet\nUp\n", &[]);
    let wanted = serde_json::json!([
        { "line": 1, "allowed": true },
        { "line": 3, "allowed": false, "why": "this line is not UTF-8 text: send the names of skills in UTF-8" },
        { "line": 4, "allowed": false, "why": "there is no skill `Lfet`: did you mean `Left`?" },
        { "line": 5, "allowed": true },
    ]);
    assert_eq!(Value::from(found), wanted);
    let found = documents(b"Down\nL\xffft\nUp\n", &["--stop"]);
    assert_eq!(found.len(), 2, "{found:?}");
    let long = "Left ".repeat(1 << 16);
    let output = monitored(long.as_bytes(), &[]);
    assert!(text(&output).len() < 1 << 13, "{}", text(&output).len());
}

/// A sender that waits after a call gets the answer, although more is to come.
#[test]
fn an_answer_does_not_wait_for_the_next_call() {
    use std::io::{BufRead as _, BufReader};
    let mut child = Command::new(env!("CARGO_BIN_EXE_linewright"))
        .current_dir(support::root())
        .args(["order", "monitor", UNIT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    let mut answers = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    for call in ["Down", "Grip", "Up"] {
        writeln!(stdin, "{call}").expect("it listens");
        let answer = answers.next().expect("an answer").expect("text");
        assert_eq!(answer, format!("{call}: ok"));
    }
    drop(stdin);
    assert!(child.wait().expect("it ends").success());
}

#[test]
fn differences_have_exit_codes() {
    let diff = |more: &[&str]| {
        let all = ["order", "diff", UNIT, UNIT, "--format", "json"];
        at_root(&[&all[..], more].concat())
    };
    let same = diff(&["--at-once", "3"]);
    assert_eq!(same.status.code(), Some(0));
    assert_eq!(document(&same)["equal"], true);
    let levels = diff(&["--other-level", "reasonable"]);
    assert_eq!(levels.status.code(), Some(1));
    let found = document(&levels);
    assert_eq!(found["calls"], serde_json::json!([["Left"]]));
    assert_eq!(found["allowed_by"], "first");
    let other = at_root(&["order", "diff", UNIT, "examples/ice-lab/line.lw"]);
    assert_eq!(other.status.code(), Some(2));
}

#[test]
fn the_strongest_level_still_takes_the_intended_program() {
    let output = at_root(&[
        "order",
        "strongest",
        UNIT,
        "--longest",
        "3",
        "--format",
        "json",
    ]);
    assert_eq!(output.status.code(), Some(0));
    let found = document(&output);
    let kept: Vec<String> = found["candidates"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(|c| c["verdict"] == "kept")
        .map(|c| format!("    {}\n", c["text"].as_str().expect("a text")))
        .collect();
    assert!(kept.len() > 6, "{kept:?}");
    // The printed rules can be pasted into the file.
    let folder = tempfile::tempdir().expect("a folder");
    let unit = fs::read_to_string(support::root().join(UNIT)).expect("the unit");
    let at = unit.find("    /// Do not hit").expect("the rules");
    let stronger = format!("{}{}{}", &unit[..at], kept.concat(), &unit[at..]);
    let path = folder.path().join("unit.lw");
    fs::write(&path, stronger).expect("a file");
    let rules = path.to_string_lossy();
    for level in ["arbitrary", "valid", "reasonable"] {
        let program = "examples/pick-and-place/intended.txt";
        let output = at_root(&[
            "order", "check", program, "--rules", &rules, "--level", level,
        ]);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{level}: {}{}",
            text(&output),
            error(&output)
        );
    }
}

/// The rules hold at the level for which they were found: with them in the file, nothing more can
/// be omitted there, and the level is the same.
#[test]
fn a_strongest_level_is_its_own_strongest_level() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("own.lw");
    let file = path.to_string_lossy();
    let unit = fs::read_to_string(support::root().join(UNIT)).expect("the unit");
    let at = unit.find("    /// Do not hit").expect("the rules");
    let unit = (&unit[..at], &unit[at..]);
    // A recall of `B` is needed, which the level reasonable forbids.
    let twice = (
        "skills S {
    component c: {a, b} = a {
        A -> a
        B -> b
    }
",
        "    order twice: sequence (B B A)*\n}\n",
    );
    for (before, after) in [unit, twice] {
        for level in ["valid", "reasonable"] {
            let strongest = |rules: &str| {
                fs::write(&path, format!("{before}{rules}{after}")).expect("a file");
                let output = at_root(&[
                    "order",
                    "strongest",
                    &file,
                    "--level",
                    level,
                    "--longest",
                    "3",
                    "--format",
                    "json",
                ]);
                assert_eq!(output.status.code(), Some(0), "{}", error(&output));
                document(&output)
            };
            let first = strongest("");
            let candidates = first["candidates"].as_array().expect("a list");
            let kept: Vec<String> = candidates
                .iter()
                .filter(|c| c["verdict"] == "kept")
                .map(|c| format!("    {}\n", c["text"].as_str().expect("a text")))
                .collect();
            let second = strongest(&kept.concat());
            for count in ["states", "transitions"] {
                assert_eq!(first[count], second[count], "{level}: {kept:?}");
            }
            let mut left = second["candidates"].as_array().expect("a list").iter();
            assert!(left.all(|c| c["verdict"] == "needed"), "{level}: {second}");
            let checked = at_root(&["check", &file, "--format", "short"]);
            assert!(!error(&checked).contains("LW316"), "{}", error(&checked));
        }
    }
}

/// A set with this many components with two skills each, `A0` and `B0` and so on, in a separate
/// file.
fn many(components: usize, orders: &[String]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let component = |i| {
        format!(
            "    component c{i}: {{a, b}} = a {{\n        A{i} -> a\n        B{i} -> b\n    }}\n"
        )
    };
    let components: String = (0..components).map(component).collect();
    let orders = orders.iter().enumerate();
    let orders: Vec<String> = orders
        .map(|(i, order)| format!("    order r{i}: {order}\n"))
        .collect();
    let text = format!("skills Many {{\n{components}{}}}\n", orders.concat());
    fs::write(folder.path().join("many.lw"), text).expect("a file");
    folder
}

/// No part of a table is ignored silently.
#[test]
fn cells_that_do_not_fit_are_reported() {
    for (table, said) in [
        ("step,skill\n1;Down\n2;Left\n", "this row names no skill"),
        ("step;skill;skill\n1;Right;Down\n", "have the same meaning"),
        (
            "step;skill\n1;Grip;Down\n",
            "`Down` has no column in the header",
        ),
        ("skill\nRight,Down\n", "`Down` has no column in the header"),
        ("step;skill\n1;\n", "this row names no skill"),
        ("step;skill\n1;Right\n1.0;Down\n", "not written as step 1"),
        ("step;skill\n1;\"Right\n", "unclosed quote"),
    ] {
        let (document, output) = checked("p.csv", table, &[]);
        assert_eq!(output.status.code(), Some(2), "{table}: {document}");
        assert!(document.to_string().contains(said), "{table}: {document}");
    }
    let (document, _) = checked("p.csv", "Left\nDown;Grip\n", &[]);
    assert_eq!(document["programs"][0]["calls"], 2, "{document}");
}

/// More skills at once than a table has columns for.
#[test]
fn an_event_of_many_skills_is_watched() {
    let event = (0..5)
        .map(|i| format!("B{i}"))
        .collect::<Vec<_>>()
        .join(" & ");
    let folder = many(16, &[format!("after {event}: never B5")]);
    let check = linewright(folder.path(), &["check", "many.lw", "--no-timing"]);
    assert!(text(&check).contains("consistent"), "{}", text(&check));
    assert_eq!(check.status.code(), Some(0));
    let output = watched(
        &folder.path().join("many.lw"),
        format!("{event}\nB5\n"),
        &[],
    );
    let said = text(&output);
    assert!(
        said.starts_with(&format!("{event}: ok\nB5: refused, r0")),
        "{said}"
    );
    let arguments = ["order", "monitor", "many.lw", "--emit", "st"];
    let emitted = linewright(folder.path(), &arguments);
    assert!(
        error(&emitted).contains("limited to calls of at most"),
        "{}",
        error(&emitted)
    );
}

#[test]
fn unused_formulas_are_reported() {
    let folder = many(2, &["never A0".to_owned()]);
    let path = folder.path().join("many.lw");
    let levelled = fs::read_to_string(&path).expect("a file");
    fs::write(
        &path,
        levelled.replace("order r0:", "order r0 at reasonable:"),
    )
    .expect("a file");
    let output = linewright(folder.path(), &["order", "fsm", "many.lw", "--rule", "r0"]);
    assert!(
        error(&output).contains("--level reasonable"),
        "{}",
        error(&output)
    );
    let useful = ["order", "strongest", "many.lw", "--useful", "c0.a & c0.b"];
    let output = linewright(folder.path(), &useful);
    assert!(
        error(&output).contains("in one situation at a time"),
        "{}",
        error(&output)
    );
}

/// Skills that no rule mentions do not count.
#[test]
fn a_rule_about_three_of_64_skills_is_a_small_one() {
    let folder = many(32, &["after A0 until B0: never A1".to_owned()]);
    let run = |arguments: &[&str]| linewright(folder.path(), arguments);
    let checked = run(&["check", "many.lw", "--no-timing"]);
    assert!(text(&checked).contains("consistent"), "{}", text(&checked));
    assert!(!error(&checked).contains("LW112"), "{}", error(&checked));
    let expression = run(&["order", "regex", "many.lw"]);
    assert!(text(&expression).len() < 200, "{}", text(&expression));
    let c = run(&[
        "order",
        "monitor",
        "many.lw",
        "--emit",
        "c",
        "--at-once",
        "1",
    ]);
    assert_eq!(c.status.code(), Some(0), "{}", error(&c));
}

/// The rules are evaluated directly if they have no table.
#[test]
fn rules_without_a_table_are_watched_all_the_same() {
    let orders: Vec<String> = (0..31)
        .map(|i| format!("after A{i} until B{i}: never A{}", i + 1))
        .collect();
    let folder = many(32, &orders);
    let emitted = linewright(
        folder.path(),
        &["order", "monitor", "many.lw", "--emit", "c"],
    );
    assert_eq!(emitted.status.code(), Some(3), "{}", error(&emitted));
    // All components are at `a`: what the rules forbid is allowed once the previous one has been
    // called to `b`.
    let watched = watched(
        &folder.path().join("many.lw"),
        "A5\nB4\nA5\nA5 & B9\nA5 & B5\n",
        &[],
    );
    assert_eq!(watched.status.code(), Some(1));
    let said = text(&watched);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 5, "{said}");
    assert!(
        lines[0].starts_with("A5: refused, r4: after A4 until B4: never A5"),
        "{said}"
    );
    assert_eq!(&lines[1..4], ["B4: ok", "A5: ok", "A5 & B9: ok"]);
    assert!(
        lines[4].starts_with("A5 & B5: refused, two skills"),
        "{said}"
    );
}

#[test]
fn a_time_limit_ends_every_search() {
    let order = |i: usize| {
        let next = i + 1;
        let most = i + 5;
        format!("at most {most} of A{i}, B{i} between A{next} and B{next}")
    };
    let orders: Vec<String> = (0..6).map(order).collect();
    let folder = many(8, &orders);
    let run = |arguments: &[&str]| linewright(folder.path(), arguments);
    for command in [&["fsm", "--at-once", "1"][..], &["regex"], &["strongest"]] {
        let limited = ["--timeout", "0.01"];
        let output = run(&[&["order", command[0], "many.lw"], &command[1..], &limited].concat());
        assert_eq!(
            output.status.code(),
            Some(3),
            "{command:?}: {}",
            error(&output)
        );
        let said = error(&output);
        assert!(said.contains("the time limit was reached"), "{said}");
        assert!(
            said.contains("give it more time with --timeout SECONDS"),
            "{said}"
        );
        let json = ["--timeout", "0.01", "--format", "json"];
        let output = run(&[&["order", command[0], "many.lw"], &command[1..], &json].concat());
        assert_eq!(output.status.code(), Some(3));
        let found = document(&output);
        assert_eq!(
            found["schema"],
            format!("linewright/order-{}/1", command[0])
        );
        assert_eq!(found["findings"][0]["code"], "LW204");
    }
}

/// If there are too many ways to continue, nothing is reported about them.
#[test]
fn a_way_that_was_not_found_is_no_way_that_is_not_there() {
    let count = |i: usize| {
        format!(
            "at most {0} of A{i}, B{i} between A{1} and B{1}",
            i + 3,
            i + 1
        )
    };
    let mut orders: Vec<String> = (0..10).map(count).collect();
    orders.push("after A0 until B0: never A11".to_owned());
    orders.push("never B0".to_owned());
    let folder = many(12, &orders);
    let next = linewright(folder.path(), &["order", "complete", "many.lw", "A0"]);
    assert_eq!(next.status.code(), Some(0), "{}", error(&next));
    let said = text(&next);
    assert!(
        said.contains("could not decide whether it is allowed later"),
        "{said}"
    );
    fs::write(folder.path().join("p.txt"), "A0\nA11\n").expect("a file");
    let checked = linewright(folder.path(), &["order", "check", "p.txt"]);
    assert_eq!(checked.status.code(), Some(1));
    let said = error(&checked);
    assert!(
        said.contains("could not decide whether `A11` is allowed later"),
        "{said}"
    );
}
