//! Foreign objects on disk, and empty folders.

use super::session::Session;
use crate::support::{linewright, root};
#[cfg(unix)]
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::process::{Command, Output, Stdio};
#[cfg(unix)]
use std::time::{Duration, Instant};

#[test]
fn a_folder_without_files_is_the_same_to_all() {
    let session = Session::new();
    std::fs::create_dir(session.path("empty")).expect("a folder");
    for line in [
        "check empty",
        "fmt empty",
        "fmt --check empty",
        "build empty",
    ] {
        let printed = session.run(line);
        assert_eq!(printed.code, 2, "{line}");
        let all = format!("{}{}", printed.out, printed.err);
        let wanted = "error[LW001]: empty cannot be read: it contains no .lw file";
        assert!(all.contains(wanted), "{line}: {all}");
    }
}

/// A folder that cannot be read, since its path is too long for the system, is reported; its
/// neighbors are examined.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_read_is_named() {
    let session = Session::new();
    let half: PathBuf = std::iter::repeat_n("0".repeat(250), 9).collect();
    for folder in ["plant", "moved"] {
        std::fs::create_dir_all(session.path(folder).join(&half)).expect("a folder");
    }
    let inner = session.path("plant").join(&half).join("inner");
    std::fs::rename(session.path("moved"), inner).expect("a folder that moves");
    std::fs::copy(session.path("lamp.lw"), session.path("plant/lamp.lw")).expect("a copy");
    for line in ["check plant", "fmt --check plant"] {
        let printed = session.run(&format!("{line} --format short"));
        assert_eq!(printed.code, 2, "{line}");
        let all = format!("{}{}", printed.out, printed.err);
        assert!(all.contains("error[LW001]: plant/0000"), "{line}: {all}");
        assert_eq!(all.matches("cannot be read").count(), 1, "{line}: {all}");
        assert!(
            !line.starts_with("check") || all.contains("contract Light: realizable"),
            "{all}"
        );
    }
}

/// A command that names its own source as the place of its result is refused, and the source is
/// kept.
#[test]
fn no_result_is_written_over_its_source() {
    let session = Session::new();
    let examples = root().join("examples");
    for name in [
        "other-tools/arbiter.tlsf",
        "other-tools/arbiter.spc",
        "pick-and-place/unit.lw",
    ] {
        let place = examples.join(name);
        let own = place.file_name().expect("a name").to_string_lossy();
        std::fs::copy(&place, session.path(&own)).expect("a copy");
    }
    std::fs::write(session.path("save.txt"), "save lamp.lw\n").expect("a file");
    std::fs::create_dir(session.path("inner")).expect("a folder");
    for (line, file) in [
        ("check lamp.lw --proof lamp.lw", "lamp.lw"),
        ("check lamp.lw --proof inner/../lamp.lw", "lamp.lw"),
        ("synth arbiter.tlsf --emit tlsf --out .", "arbiter.tlsf"),
        ("import arbiter.spc --out arbiter.spc", "arbiter.spc"),
        ("order fsm unit.lw --out unit.lw", "unit.lw"),
        ("step lamp.lw --script save.txt", "lamp.lw"),
    ] {
        let before = std::fs::read(session.path(file)).expect("a file");
        let printed = session.run(line);
        let all = format!("{}{}", printed.out, printed.err);
        assert_ne!(printed.code, 0, "{line}: {all}");
        assert!(
            all.contains("is not overwritten: it is a source of this result"),
            "{line}: {all}"
        );
        let after = std::fs::read(session.path(file)).expect("a file");
        assert!(before == after, "{line}");
    }
}

/// A folder named like a contract is reported, and not searched.
#[test]
fn a_folder_with_the_name_of_a_file() {
    let session = Session::new();
    std::fs::create_dir_all(session.path("plant/old.lw")).expect("a folder");
    std::fs::copy(session.path("lamp.lw"), session.path("plant/old.lw/a.lw")).expect("a copy");
    std::fs::copy(session.path("lamp.lw"), session.path("plant/lamp.lw")).expect("a copy");
    for command in ["check", "fmt --check"] {
        let printed = session.run(&format!("{command} plant"));
        assert_eq!(printed.code, 2, "{command}");
        let all = format!("{}{}", printed.out, printed.err);
        let wanted = "plant/old.lw cannot be read: it is a folder";
        assert!(all.contains(wanted), "{command}: {all}");
    }
}

/// Creates a named pipe, if there is a program for it. Nothing writes to it, so reading it never
/// ends.
#[cfg(unix)]
fn pipe(at: &Path) -> bool {
    let made = Command::new("mkfifo").arg(at).status();
    let made = made.is_ok_and(|s| s.success());
    if !made {
        println!("skipped: mkfifo");
    }
    made
}

/// The result of a command, which must end.
#[cfg(unix)]
fn ended(mut command: Command) -> Output {
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .stdin(Stdio::null())
        .spawn()
        .expect("the program starts");
    let begin = Instant::now();
    while child.try_wait().expect("it is ours").is_none() {
        if begin.elapsed() > Duration::from_mins(2) {
            child.kill().expect("it is ours");
            panic!("{command:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().expect("it ended")
}

/// Objects in place of a library, a manifest or a cache entry are replaced, and never waited for.
#[cfg(unix)]
#[test]
fn pipes_in_place_of_what_was_made_are_replaced() {
    let session = Session::new();
    let run = |line: &str| {
        let mut command = session.command(line);
        command.env("LINEWRIGHT_CACHE", session.path("cache"));
        let output = ended(command);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
    };
    run("run lamp.lw --out made");
    for ending in ["json", "so"] {
        for folder in ["made", "cache"] {
            let entries = std::fs::read_dir(session.path(folder)).expect("a folder");
            for path in entries.map(|e| e.expect("an entry").path()) {
                let chosen = folder == "cache" || path.extension().is_some_and(|e| e == ending);
                if !chosen || !path.is_file() {
                    continue;
                }
                std::fs::remove_file(&path).expect("it is there");
                if !pipe(&path) {
                    return;
                }
            }
        }
        run("check lamp.lw");
        run("run lamp.lw --out made");
    }
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_named_and_hangs_nothing() {
    let session = Session::new();
    std::fs::create_dir(session.path("plant")).expect("a folder");
    std::fs::copy(session.path("lamp.lw"), session.path("plant/lamp.lw")).expect("a copy");
    if !pipe(&session.path("plant/pipe.lw")) {
        return;
    }
    std::os::unix::fs::symlink("/dev/zero", session.path("plant/zero.lw")).expect("a link");
    std::fs::write(session.path("plant/reads.lw"), "import \"pipe.lw\"\n").expect("a file");
    let unit = root().join("examples/pick-and-place/unit.lw");
    let unit = unit.display();
    let calls = format!("order check plant/pipe.lw --rules {unit}");
    let endless = format!("order check plant/zero.lw --rules {unit}");
    for (line, named) in [
        (calls.as_str(), &["pipe.lw"][..]),
        (&endless, &["zero.lw"]),
        ("doctor --probe plant/pipe.lw", &["pipe.lw"]),
        ("build lamp.lw --profile plant/pipe.lw", &["pipe.lw"]),
        ("check lamp.lw --proof plant/pipe.lw", &["pipe.lw"]),
        ("check lamp.lw --proof plant/zero.lw", &["zero.lw"]),
        ("check plant", &["pipe.lw", "zero.lw"]),
        ("check plant/pipe.lw", &["pipe.lw"]),
        ("check plant/zero.lw", &["zero.lw"]),
        ("fmt --check plant", &["pipe.lw", "zero.lw"]),
        ("build plant/pipe.lw", &["pipe.lw"]),
        ("run plant/pipe.lw", &["pipe.lw"]),
        ("step plant/pipe.lw", &["pipe.lw"]),
        ("check plant/reads.lw", &["pipe.lw"]),
    ] {
        let output = ended(session.command(line));
        assert!(matches!(output.status.code(), Some(1 | 2)), "{line}");
        let all = [output.stdout, output.stderr].concat();
        let all = String::from_utf8_lossy(&all);
        for name in named {
            let what = if *name == "pipe.lw" {
                "a named pipe"
            } else {
                "a device"
            };
            assert!(all.contains(name) && all.contains(what), "{line}: {all}");
        }
    }
    // Readable files are judged nevertheless.
    let printed = session.run("check plant --format short");
    assert!(
        printed
            .out
            .contains("plant/lamp.lw: contract Light: realizable"),
        "{}",
        printed.out
    );
}

/// A link to a result file stays a link, and its target is written.
#[cfg(unix)]
#[test]
fn a_result_is_written_where_a_link_leads() {
    let session = Session::new();
    std::fs::write(session.path("target.json"), "old").expect("a file");
    std::os::unix::fs::symlink("target.json", session.path("link.json")).expect("a link");
    assert_eq!(session.run("check lamp.lw --proof link.json").code, 0);
    let link = std::fs::symlink_metadata(session.path("link.json")).expect("it is there");
    assert!(link.file_type().is_symlink());
    let text = std::fs::read_to_string(session.path("target.json")).expect("a text");
    assert!(text.contains("linewright/proof/1"), "{text}");
}

/// A file that is imported in two ways is one file, from whichever folder the program is started,
/// including through links.
#[test]
fn a_file_is_one_file_however_it_is_reached() {
    let session = Session::new();
    let write = |name: &str, text: &str| {
        let path = session.path(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    write(
        "two/a/c.lw",
        "contract C {\n    input a: bool\n    output b: bool\n    guarantee always (b <-> a)\n}\n",
    );
    write("two/b/z.lw", "import \"../a/c.lw\"\n");
    write("two/a/main.lw", "import \"c.lw\"\nimport \"../b/z.lw\"\n");
    let check = |folder: &str, files: &[&str]| {
        let mut arguments = vec!["check", "--no-timing", "--format", "short"];
        arguments.extend(files);
        let output = linewright(&session.path(folder), &arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{folder}: {text}");
        text
    };
    assert_eq!(
        check("two", &["a/main.lw"]),
        "a/c.lw: contract C: realizable\n"
    );
    let own = "c.lw: contract C: realizable\n";
    assert_eq!(check("two/a", &["main.lw"]), own);
    assert_eq!(check("two/a", &["c.lw", "../a/c.lw", "main.lw"]), own);
    let other = "../a/c.lw: contract C: realizable\n";
    assert_eq!(check("two/b", &["../a/main.lw", "z.lw"]), other);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(".", session.path("two/a/self")).expect("a link");
        write(
            "two/a/links.lw",
            "import \"c.lw\"\nimport \"self/main.lw\"\n",
        );
        assert_eq!(check("two/a", &["links.lw"]), own);
    }
}
