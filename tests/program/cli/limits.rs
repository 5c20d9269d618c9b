//! Limits end a run in time, whatever is being computed, with a report of the progress.

use super::session::Session;
use crate::support::{linewright, root};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time for the program to end after a limit. One second is promised; the rest is for a busy
/// computer.
const MARGIN: Duration = Duration::from_secs(2);

/// `product.lw` multiplies two 20-bit numbers: no variable order makes that small.
const HARD: &str = "check product.lw --no-timing";

#[test]
fn a_time_limit_ends_a_run_that_would_last() {
    let session = Session::new();
    for kernel in ["auto", "biodivine", "shared"] {
        let begin = Instant::now();
        let printed = session.run(&format!("{HARD} --kernel {kernel} --timeout 2"));
        let elapsed = begin.elapsed();
        assert_eq!(printed.code, 3, "{}", printed.out);
        assert!(elapsed >= Duration::from_secs(2), "{elapsed:?}");
        assert!(elapsed < Duration::from_secs(2) + MARGIN, "{elapsed:?}");
        let wanted = "the time limit was reached while encoding its formulas";
        assert!(printed.out.contains(wanted), "{}", printed.out);
    }
}

/// If the verdict is there in time but not all of its explanation, the finding says so. Within the
/// first of these limits that suffices for the verdict, the search for suggestions cannot end.
#[test]
fn an_explanation_that_a_limit_stops_says_so() {
    let session = Session::new();
    let text = "contract Arbiter {
    input r: array[24] of bool
    output g: array[24] of bool
    output c: 0..888
    assume always forall i in r: (r[i] and not g[i] -> next r[i])
    guarantee always ((count i in g: g[i]) <= 1)
    guarantee c = 0
    guarantee always (next c = (if g[0] then 0 else min(c + 1, 888)))
    guarantee always forall i in g: (g[i] -> r[i])
    guarantee forall i in g: always eventually (g[i] or not r[i])
    guarantee always (c < 888)
}
";
    std::fs::write(session.path("arbiter.lw"), text).expect("a file");
    let printed = ["0.5", "1", "2", "4", "8"]
        .into_iter()
        .map(|seconds| session.run(&format!("check arbiter.lw --no-cache --timeout {seconds}")))
        .find(|printed| printed.code == 1)
        .expect("a verdict");
    for text in [
        "error[LW203]",
        "= note: this explanation is incomplete: the time limit was reached; give it more time",
    ] {
        let shown = format!("{}{}", printed.out, printed.err);
        assert!(shown.contains(text), "{shown}");
    }
}

/// No kernel can number so many bits; that is a limit, not an internal error.
#[test]
fn a_contract_with_too_many_bits_has_no_verdict() {
    let session = Session::new();
    let text = "contract Wide {
    input readings: array[2048] of 0..65535
    output high: bool
    guarantee first: always (high <-> readings[0] > 3)
}
";
    std::fs::write(session.path("wide.lw"), text).expect("a file");
    for options in [
        "",
        "--kernel biodivine",
        "--kernel shared --without structure",
    ] {
        let printed = session.run(&format!("check wide.lw --no-cache {options}"));
        assert_eq!(printed.code, 3, "{options}: {}{}", printed.out, printed.err);
        let wanted = "no verdict on `Wide`: its variables take more than 32767 bits";
        assert!(printed.out.contains(wanted), "{options}: {}", printed.out);
    }
}

#[test]
fn the_other_contracts_keep_their_verdicts() {
    let session = Session::new();
    let printed =
        session.run("check lamp.lw product.lw unrealizable.lw --format short --timeout 3");
    assert_eq!(printed.code, 3, "{}", printed.out);
    for line in [
        "lamp.lw: contract Light: realizable",
        "product.lw: contract Product: gave_up",
        "unrealizable.lw: contract Foresight: unrealizable",
    ] {
        assert!(printed.out.contains(line), "{line}: {}", printed.out);
    }
}

/// The machine has a controller in its own size. In the size that the line gives it, there is not
/// enough time to decide that; this is no error of the line.
#[test]
fn a_line_with_an_undecided_machine_gave_up() {
    let session = Session::new();
    let text = "
contract Product(n: 1..1048575 = 3) {
    input a, b: 0..n
    output odd: bool
    guarantee product: always (odd <-> a * b mod 2097143 > 1000000)
}
machine M(n: 1..1048575 = 3) {
    signal a: 0..n = 0
    signal b: 0..n = 1
    action p: Product(n = n) when operation = w
    operation w: p
    done operation = w
}
line L {
    part T
    source s: T every 5 s
    station m: M(n = 1048575) {
        perform w on T
    }
    sink box
    route T: s -> m -> box
}
";
    std::fs::write(session.path("undecided.lw"), text).expect("a file");
    let printed = session.run("check undecided.lw --format short --timeout 1");
    assert_eq!(printed.code, 3, "{}", printed.out);
    let wanted = "undecided.lw: line L: gave_up";
    assert!(printed.out.contains(wanted), "{}", printed.out);
}

#[test]
fn a_memory_limit_ends_in_a_message() {
    let session = Session::new();
    for (kernel, mib) in [
        ("auto", 1),
        ("auto", 8),
        ("biodivine", 8),
        ("shared", 8),
        ("shared", 0),
    ] {
        let printed = session.run(&format!("{HARD} --kernel {kernel} --memory {mib}"));
        assert_eq!(
            printed.code, 3,
            "{kernel} {mib}: {}{}",
            printed.out, printed.err
        );
        let wanted = "no verdict on `Product`: the memory limit was reached";
        assert!(
            printed.out.contains(wanted),
            "{kernel} {mib}: {}",
            printed.out
        );
        assert_eq!(printed.err, "", "{kernel} {mib}");
    }
}

/// A verdict whose examination did not fit into memory is not as good as one without findings.
#[test]
fn an_examination_that_a_limit_stops_says_so() {
    let session = Session::new();
    let text = "contract Arbiter {
    input r: array[12] of bool
    output g: array[12] of bool
    assume always forall i in r: (r[i] and not g[i] -> next r[i])
    guarantee always ((count i in g: g[i]) <= 1)
    guarantee forall i in g: always eventually (g[i] or not r[i])
}
";
    std::fs::write(session.path("arbiter.lw"), text).expect("a file");
    let mut stopped = 0;
    for mib in 4..40 {
        let printed = session.run(&format!("check arbiter.lw --no-cache --memory {mib}"));
        let is_decided = printed.out.contains("Arbiter  12 in");
        let says = printed.out.contains("the memory limit was reached");
        let warned = "warning[LW204]: `Arbiter` was not examined completely";
        stopped += u32::from(printed.out.contains(warned));
        assert_eq!(printed.code == 3, says, "{mib}: {}", printed.out);
        assert!(is_decided || says, "{mib}: {}", printed.out);
    }
    assert!(stopped > 0);
}

/// Parsing does not check the memory; a file that is too large for it still ends in a message, and
/// so does every other command that reads it.
#[test]
fn a_file_that_does_not_fit_into_memory_ends_in_a_message() {
    let session = Session::new();
    let line = "    guarantee always y\n";
    let text = format!(
        "contract Long {{\n    output y: bool\n{}}}\n",
        line.repeat(100_000)
    );
    std::fs::write(session.path("long.lw"), text).expect("a file");
    for command in ["check", "synth", "fmt --check"] {
        let printed = session.run(&format!("{command} long.lw --no-cache --memory 70"));
        assert_eq!(printed.code, 3, "{command}: {}", printed.out);
        let said = printed.out + &printed.err;
        for wanted in ["the memory limit was reached", "--memory MIB"] {
            assert!(said.contains(wanted), "{command}: {said}");
        }
    }
}

#[test]
fn a_counterstrategy_that_is_not_found_names_the_limit() {
    let session = Session::new();
    let printed = session.run("synth product.lw --counterstrategy --memory 8");
    assert_eq!(printed.code, 3, "{}", printed.err);
    for wanted in ["the memory limit was reached", "--memory MIB"] {
        assert!(printed.err.contains(wanted), "{wanted}: {}", printed.err);
    }
}

#[test]
fn skills_that_are_not_decided_are_not_called_consistent() {
    let session = Session::new();
    let skills = |repeated: usize| {
        let sequence = format!("sequence ((A | B)* A (A | B){{{repeated}}} A)");
        let text = format!(
            "skills S {{ component c {{ A B }} order r: {sequence} order never_A: never A }}\n"
        );
        std::fs::write(session.path("skills.lw"), text).expect("a file");
        let printed = session.run("check skills.lw --format json --no-timing");
        let document: serde_json::Value = serde_json::from_str(&printed.out).expect("a document");
        let verdict = document["skills"][0]["verdict"].clone();
        (printed.code, verdict)
    };
    assert_eq!(skills(3), (1, "contradictory".into()));
    assert_eq!(skills(40), (0, "gave_up".into()));
    let human = session.run("check skills.lw");
    assert!(human.out.contains("? skills S"), "{}", human.out);
}

#[test]
fn json_keeps_its_form_when_it_gives_up() {
    let session = Session::new();
    let printed = session.run("check product.lw --format json --stats --timeout 1");
    assert_eq!(printed.code, 3);
    let document: serde_json::Value = serde_json::from_str(&printed.out).expect("a document");
    let contract = &document["contracts"][0];
    assert_eq!(contract["verdict"], "gave_up");
    assert_eq!(contract["statistics"]["pairs"], 42);
    assert_eq!(document["summary"]["gave_up"], 1);
}

/// The effort of a proof is counted, so a busy computer and a long time limit change nothing.
#[test]
fn proofs_are_limited_by_counted_work() {
    let session = Session::new();
    let example = root().join("examples/loader/line.lw");
    std::fs::copy(example, session.path("loader.lw")).expect("a copy");
    let run = |more: &str| {
        let printed = session.run(&format!("check loader.lw -v --no-timing {more}"));
        (printed.code, printed.out, printed.err)
    };
    let busy = |more: &str| {
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    while !over.load(Ordering::Relaxed) {
                        std::hint::black_box(0);
                    }
                });
            }
            let printed = run(more);
            over.store(true, Ordering::Relaxed);
            printed
        })
    };
    let whole = run("");
    assert_eq!(whole.0, 0, "{}", whole.1);
    assert!(!whole.1.contains("LW410"), "{}", whole.1);
    assert_eq!(busy("--timeout 3000"), whole);

    let little = run("--effort 0.00001");
    let wanted = "it needed more than 10 nodes at once";
    assert!(little.1.contains(wanted), "{}", little.1);
    assert!(little.1.contains("--effort 10"), "{}", little.1);
    assert_eq!(busy("--effort 0.00001 --timeout 3000"), little);
}

#[test]
fn an_explanation_is_limited_by_work() {
    let session = Session::new();
    let contract = "contract Clamp {
        input close, door_open: bool
        output closed: bool
        guarantee follows: always (closed <-> close)
        guarantee guard: always (door_open -> not closed)
    }";
    std::fs::write(session.path("never.lw"), contract).expect("a file");
    let whole = session.run("check never.lw --no-cache");
    assert_eq!(whole.code, 1, "{}", whole.err);
    assert!(!whole.out.contains("incomplete"), "{}", whole.out);
    let little = session.run("check never.lw --no-cache --effort 1e-9");
    assert_eq!(little.code, 1, "{}", little.err);
    let wanted = "this explanation is incomplete: it took more than";
    let printed = format!("{}{}", little.out, little.err);
    assert!(printed.contains(wanted), "{printed}");
    assert!(printed.contains("--effort"), "{printed}");
}

#[test]
fn an_effort_is_a_number_above_nothing() {
    let session = Session::new();
    for wrong in ["0", "-1", "inf", "much"] {
        let printed = session.run(&format!("check lamp.lw --effort {wrong}"));
        assert_eq!(printed.code, 2, "{}", printed.err);
        let wanted = "expected a number above 0, such as 10 or 0.5";
        assert!(printed.err.contains(wanted), "{}", printed.err);
    }
}

#[cfg(unix)]
mod interrupts {
    use super::{HARD, MARGIN, Session};
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;
    use std::process::{Child, Output, Stdio};
    use std::time::{Duration, Instant};

    fn start(session: &Session, line: &str) -> Child {
        let mut command = session.command(line);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("the program starts")
    }

    fn interrupt(child: &Child) {
        let id = i32::try_from(child.id()).expect("a process id");
        kill(Pid::from_raw(id), Signal::SIGINT).expect("a signal");
    }

    fn text(output: &Output) -> String {
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    #[test]
    fn the_first_one_ends_what_is_being_solved() {
        let session = Session::new();
        let child = start(&session, HARD);
        std::thread::sleep(Duration::from_secs(2));
        interrupt(&child);
        let begin = Instant::now();
        let output = child.wait_with_output().expect("it ends");
        assert!(begin.elapsed() < MARGIN, "{:?}", begin.elapsed());
        assert_eq!(output.status.code(), Some(3), "{}", text(&output));
        let wanted = "no verdict on `Product`: it was interrupted while";
        assert!(text(&output).contains(wanted), "{}", text(&output));
    }

    /// Not only contracts are given up, but also proofs of lines, and runs. The proof takes
    /// several seconds in a release build: it is interrupted long before its end.
    #[test]
    fn it_ends_proofs_and_runs() {
        let session = Session::new();
        super::joined(&session);
        let line = std::fs::read_to_string(session.path("joined.lw")).expect("a file");
        let longer = line.replace("conveyor c2 places 4", "conveyor c2 places 14");
        assert_ne!(longer, line);
        std::fs::write(session.path("joined.lw"), longer).expect("a file");
        for (command, wanted) in [
            ("check joined.lw --no-cache", "contract Act: realizable"),
            ("check joined.lw --no-cache", "it was interrupted"),
            (
                "run joined.lw --parts 1000000000",
                "it was interrupted: it reached",
            ),
        ] {
            // An earlier call has already compiled the library.
            let _ = session.run("build joined.lw");
            let child = start(&session, &format!("{command} --format short"));
            std::thread::sleep(Duration::from_millis(1500));
            interrupt(&child);
            let begin = Instant::now();
            let output = child.wait_with_output().expect("it ends");
            assert!(begin.elapsed() < MARGIN, "{command}: {:?}", begin.elapsed());
            let said = text(&output) + &String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(3), "{command}: {said}");
            assert!(said.contains(wanted), "{command}: {said}");
        }
    }

    #[test]
    fn what_is_known_is_printed() {
        let session = Session::new();
        let child = start(&session, "check unrealizable.lw product.lw --format short");
        std::thread::sleep(Duration::from_secs(2));
        interrupt(&child);
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(3), "{}", text(&output));
        let wanted = "unrealizable.lw: contract Foresight: unrealizable";
        assert!(text(&output).contains(wanted), "{}", text(&output));
    }
}

/// A machine with large tables becomes functions, if these are acceptable.
#[test]
fn large_tables_become_functions() {
    let session = Session::new();
    for (wires, schema) in [(6, "linewright/machine/1"), (13, "linewright/functions/1")] {
        let text = format!(
            "contract Copy {{\n    input x: array[{wires}] of bool\n    output y: array[{wires}] of bool\n\n    guarantee same: always (forall i in 0..{}: y[i] = x[i])\n}}\n",
            wires - 1
        );
        std::fs::write(session.path("copy.lw"), text).expect("a file");
        let printed = session.run("synth copy.lw");
        assert_eq!(printed.code, 0, "{}", printed.err);
        assert!(printed.out.contains(schema), "{wires} wires");
    }
}

/// A line that was not decided in time has no verdict, like a contract.
#[test]
fn a_line_that_is_not_decided_in_time_ends_with_3() {
    use std::fmt::Write as _;
    let session = Session::new();
    let mut line = String::from(
        "import std.coordination.single
contract Work {
    input requested: bool
    output finished: bool
    guarantee report: always (finished <-> requested)
}
machine M {
    step 1 s
    coordinator c: Single {
        job = operation = go
        executed = a.finished
    }
    action a: Work when c.command {
        requested = c.command
    }
    operation go: a
    done c.done
}
line L {
    part P
    source s: P on order
    sink k
",
    );
    let mut way = String::from("    route P: s");
    for i in 0..300 {
        let _ = writeln!(line, "    station m{i}: M {{ perform go on P }}");
        let _ = write!(way, " -> m{i}");
    }
    let _ = writeln!(line, "{way} -> k\n}}");
    std::fs::write(session.path("long.lw"), line).expect("a file");
    let printed = session.run("check long.lw --no-timing --timeout 0.3");
    assert_eq!(printed.code, 3, "{}{}", printed.out, printed.err);
    assert!(
        printed.err.contains("the time limit was reached")
            || printed.out.contains("the time limit was reached")
    );
}

/// A limit is named even if the line has errors, which prevent a proof anyway.
#[test]
fn a_limit_is_named_beside_errors() {
    let session = Session::new();
    let file = root().join("tests/program/cli/refused_and_large.lw");
    std::fs::copy(file, session.path("refused_and_large.lw")).expect("a copy");
    let printed = session.run("check refused_and_large.lw --no-timing --timeout 0.3");
    assert_eq!(printed.code, 3, "{}{}", printed.out, printed.err);
    let text = printed.out + &printed.err;
    assert!(text.contains("the time limit was reached"), "{text}");
}

/// A line whose proof takes seconds.
fn joined(session: &Session) {
    let file = root().join("tests/program/cli/joined.lw");
    std::fs::copy(file, session.path("joined.lw")).expect("a copy");
}

/// If a limit of the command ends the proof of a line, the exit code is 3 and the limit is named:
/// never a weaker verdict that looks like the line's own.
#[test]
fn a_proof_that_is_cut_short_names_the_limit() {
    let session = Session::new();
    joined(&session);
    let limits = [
        "--timeout 0.05",
        "--timeout 0.2",
        "--timeout 0.5",
        "--timeout 1",
        "--timeout 2",
        "--memory 1",
        "--memory 5",
        "--memory 1000",
    ];
    for limit in limits {
        let printed = session.run(&format!("check joined.lw --no-timing --no-cache {limit}"));
        let said = printed.out.clone() + &printed.err;
        if printed.code == 0 {
            assert!(said.contains("  proved\n"), "{limit}: {said}");
            continue;
        }
        assert_eq!(printed.code, 3, "{limit}: {said}");
        let (what, remedy) = if limit.contains("time") {
            ("the time limit was reached", "--timeout SECONDS")
        } else {
            ("the memory limit was reached", "--memory MIB")
        };
        assert!(
            said.contains(what) && said.contains(remedy),
            "{limit}: {said}"
        );
        assert!(!said.contains("--effort"), "{limit}: {said}");
    }
}

/// A line of 60 stations whose parts carry millions of combinations of values, all of which
/// `--effort` allows to follow.
fn counting() -> String {
    use std::fmt::Write as _;
    let mut line = String::from(
        "import std.coordination.single
contract Work {
    input requested: bool
    output finished: bool
    guarantee report: always (finished <-> requested)
}
machine M {
    property n: 0..9999 = 0
    coordinator c: Single {
        job = operation = go
        executed = a.finished
    }
    action a: Work when c.command {
        requested = c.command
        time 1 s
    }
    operation go: a
    done c.done
    write n = min(n + 1, 9999)
}
line L {
    part P {
        property n: 0..9999 = 0
    }
    source s: P on order, at most 1 in the line
    sink k
",
    );
    let mut way = String::from("    route P: s");
    for i in 0..60 {
        let _ = writeln!(
            line,
            "    station m{i}: M {{\n        perform go on P\n        defect on P probability 1 %: n becomes 0\n    }}"
        );
        let _ = write!(way, " -> m{i}");
    }
    line + &way + "\n    route P: m59 -> k when n >= 9000\n    route P: m59 -> m0 otherwise\n}\n"
}

/// Checks of `build` and `run` beside their own work are named if a limit cut them short.
#[test]
fn parts_that_are_not_followed_in_time_are_named_by_all_commands() {
    let session = Session::new();
    std::fs::write(session.path("counting.lw"), counting()).expect("a file");
    for command in [
        "check counting.lw",
        "build counting.lw --target source --out made",
        "run counting.lw --parts 1 --out made",
    ] {
        let limits = "--effort 10000 --timeout 1 --format short";
        let printed = session.run(&format!("{command} {limits}"));
        assert_eq!(printed.code, 3, "{command}: {}{}", printed.out, printed.err);
        let said = printed.out + &printed.err;
        let wanted = "answers every call: the time limit was reached";
        assert!(said.contains(wanted), "{command}: {said}");
    }
}

/// Thousands of variables on one line of text, each with a finding, are prepared and reported
/// within seconds.
#[test]
fn many_variables_take_no_time_of_their_own() {
    let session = Session::new();
    let names: Vec<String> = (0..9_000).map(|i| format!("out{i}")).collect();
    let contract = format!(
        "contract A {{\n    output {}: bool\n    guarantee g: always out0\n}}\n",
        names.join(", ")
    );
    std::fs::write(session.path("many.lw"), contract).expect("a file");
    let printed = session.run("check many.lw --timeout 20");
    assert_eq!(printed.code, 0, "{}", printed.err);
    let found = "1 contract: 1 realizable; 8999 findings";
    assert!(printed.out.contains(found), "{}", printed.out.len());
    assert!(printed.out.contains("--> many.lw:2:18"));
}

#[test]
fn a_proof_of_a_large_line_ends_by_itself() {
    let session = Session::new();
    let file = root().join("tests/program/cli/rework.lw");
    std::fs::copy(file, session.path("rework.lw")).expect("a copy");
    let printed = session.run("check rework.lw --no-timing --effort 0.1");
    assert_eq!(printed.code, 0, "{}{}", printed.out, printed.err);
    for wanted in [
        "something can always move in L, but it was not decided whether every part keeps moving",
        "raise the work limit with --effort FACTOR",
        "no global deadlock",
    ] {
        assert!(printed.out.contains(wanted), "{}", printed.out);
    }
}

/// After 4e9 s the clock does not resolve a microsecond.
#[test]
fn no_run_goes_on_when_times_are_no_longer_exact() {
    let session = Session::new();
    let line = "line L {
    part P
    source s: P every 1e9 s
    sink k
    conveyor c places 1 pitch 0.0001 m speed 1 m/s
    route P: s -> c -> k
}
";
    std::fs::write(session.path("clock.lw"), line).expect("a file");
    let printed = session.run("run clock.lw --until 2000000h");
    assert_eq!(printed.code, 2, "{}", printed.err);
    assert!(
        printed
            .err
            .contains("the maximum is 4000000000 s, beyond which"),
        "{}",
        printed.err
    );
    let printed = session.run("run clock.lw --parts 9");
    assert_eq!(printed.code, 3, "{}{}", printed.out, printed.err);
    let said = printed.out + &printed.err;
    assert!(said.contains("the run had not ended at 4e9 s"), "{said}");
    assert_eq!(session.run("run clock.lw --until 1000000h").code, 0);
    assert_eq!(session.run("run clock.lw --parts 4").code, 0);
}

/// A small budget ends a proof: no operation on diagrams continues for ever because its cache is
/// small.
#[test]
fn a_small_effort_ends_soon() {
    let line = "examples/ice-lab/line.lw";
    let arguments = ["check", line, "-v", "--no-timing", "--effort", "0.1"];
    let output = linewright(root(), &[&arguments[..], &["--timeout", "300"]].concat());
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("it took more than"), "{text}");
}

/// What a limit left undecided is no error: proving that the parts of this machine fit together
/// takes more work than allowed, and what its coordinator alone allows need not happen.
#[test]
fn what_was_not_decided_is_no_error() {
    let session = Session::new();
    let text = "import std.coordination.single

contract Work {
    input requested: bool
    output finished: bool

    guarantee fast: always (requested <-> finished)
}

skills Arm {
    component x: {left, right} = left {
        Left -> left
        Right -> right
    }
    order alternate: never Left then Left
}

machine Two {
    coordinator c: Single {
        job = operation != none
        executed = a.finished
    }
    action a: Work when c.command {
        requested = c.command
    }
    operation left: a
    operation right: a
    done c.done
    skills Arm {
        Left = operation = left
        Right = operation = right
    }
}
";
    std::fs::write(session.path("two.lw"), text).expect("a file");
    let decided = session.run("check two.lw --format short");
    assert!(!decided.out.contains("LW"), "{}", decided.out);
    let printed = session.run("check two.lw --format short --effort 1e-6");
    assert_eq!(printed.code, 0, "{}{}", printed.out, printed.err);
    let all = format!("{}{}", printed.out, printed.err);
    for wanted in [
        "warning[LW204]: could not decide whether the parts of `Two` fit together",
        "warning[LW303]: the assumption `order alternate` of `Arm` might not be discharged",
        "two.lw: machine Two: realizable",
    ] {
        assert!(all.contains(wanted), "{wanted}: {all}");
    }
    assert!(!all.contains("error["), "{all}");
}

/// Compilers are terminated at the limit, and leave no partial results.
#[cfg(unix)]
#[test]
fn a_time_limit_ends_compilers() {
    use std::os::unix::fs::PermissionsExt as _;
    let session = Session::new();
    // A compiler that is slow for libraries, but not for trials.
    let script = "#!/bin/sh\ncase \"$*\" in *-shared*) exec sleep 600;; *) exec cc \"$@\";; esac\n";
    std::fs::write(session.path("slow-cc"), script).expect("a file");
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(session.path("slow-cc"), mode).expect("a program");
    let compiler = session.path("slow-cc").display().to_string();
    for line in [
        "build lamp.lw --target linux --out made --timeout 3",
        "run lamp.lw --out made --timeout 3",
    ] {
        let begin = Instant::now();
        let printed = session.run_with(line, &[("CC", &compiler)]);
        assert_eq!(printed.code, 3, "{line}: {}{}", printed.out, printed.err);
        let all = format!("{}{}", printed.out, printed.err);
        let wanted =
            "error[LW204]: the library of `Lamp` was not built: the time limit was reached";
        assert!(all.contains(wanted), "{line}: {all}");
        assert!(begin.elapsed() < Duration::from_mins(5), "{line}");
        let left = std::fs::read_dir(session.path("made")).map_or(0, Iterator::count);
        assert_eq!(left, 0, "{line}");
    }
}

/// A script is not interactive: it ends at the limits of the command.
#[test]
fn a_script_of_steps_keeps_the_time_limit() {
    let session = Session::new();
    std::fs::write(session.path("endless.txt"), "random 1000000000\n").expect("a file");
    let begin = Instant::now();
    let printed = session.run("step lamp.lw --script endless.txt --timeout 0.2");
    assert_eq!(printed.code, 3, "{}{}", printed.out, printed.err);
    let wanted = "`step` has no result: the time limit was reached";
    assert!(printed.err.contains(wanted), "{}", printed.err);
    assert!(begin.elapsed() < Duration::from_mins(1));
}

/// A file that does not fit into the memory is not read at all.
#[test]
fn a_file_larger_than_the_memory_is_refused() {
    let session = Session::new();
    let large = std::fs::File::create(session.path("large.lw")).expect("a file");
    large.set_len(400 << 20).expect("room on the disk");
    let printed = session.run("check large.lw --format short --memory 100");
    assert_eq!(printed.code, 2, "{}{}", printed.out, printed.err);
    let all = printed.out + &printed.err;
    let wanted = "large.lw cannot be read: it has 400 MiB, and the memory limit leaves ";
    assert!(all.contains(wanted), "{all}");
    assert!(all.contains("--memory MIB"), "{all}");
}

/// A play in a terminal takes as long as its player likes, but loading its contract does not.
#[test]
fn loading_a_play_keeps_the_time_limit() {
    let session = Session::new();
    let mut text = String::from("contract Long {\n  output y: bool\n");
    text.push_str(&"  guarantee always (y or y and y)\n".repeat(400_000));
    text.push_str("}\n");
    std::fs::write(session.path("long.lw"), text).expect("a file");
    let begin = Instant::now();
    let printed = session.run("step long.lw --timeout 0.05");
    assert_eq!(printed.code, 3, "{}{}", printed.out, printed.err);
    let wanted = "`step` has no result: the time limit was reached";
    assert!(printed.err.contains(wanted), "{}", printed.err);
    assert!(begin.elapsed() < Duration::from_mins(1));
}

/// Reading does not check the clock: input that never ends is abandoned nevertheless.
#[test]
fn a_time_limit_ends_what_does_not_look_at_it() {
    let session = Session::new();
    let begin = Instant::now();
    let mut child = session
        .command("fmt - --timeout 0.2")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let open = child.stdin.take();
    let output = child.wait_with_output().unwrap();
    let elapsed = begin.elapsed();
    drop(open);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(text.contains("`fmt` has no result"), "{text}");
    assert!(elapsed < Duration::from_mins(1), "{elapsed:?}");
}
