//! What lies on the disk and is no file of ours, and folders in which there is nothing.

use crate::session::Session;
use crate::support::root;

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
        let wanted = "error[LW001]: empty cannot be read: it holds no .lw file";
        assert!(all.contains(wanted), "{line}: {all}");
    }
}

/// A folder that is called like a contract is named, and not searched.
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

/// Nobody writes into this pipe, so whoever reads it waits for ever: the limit of the test's own patience is what `timeout` says.
#[cfg(unix)]
#[test]
fn a_named_pipe_is_named_and_hangs_nothing() {
    use std::process::Command;
    let session = Session::new();
    std::fs::create_dir(session.path("plant")).expect("a folder");
    std::fs::copy(session.path("lamp.lw"), session.path("plant/lamp.lw")).expect("a copy");
    let made = Command::new("mkfifo")
        .arg(session.path("plant/pipe.lw"))
        .status();
    if !made.is_ok_and(|s| s.success()) {
        println!("skipped: mkfifo");
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
        let mut command = session.command(line);
        let mut child = command
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .stdin(std::process::Stdio::null())
            .spawn()
            .expect("the program starts");
        let begin = std::time::Instant::now();
        while child.try_wait().expect("it is ours").is_none() {
            if begin.elapsed() > std::time::Duration::from_mins(2) {
                child.kill().expect("it is ours");
                panic!("{line} hangs");
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        let output = child.wait_with_output().expect("it ended");
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
    // What can be read is judged all the same.
    let printed = session.run("check plant --format short");
    assert!(
        printed
            .out
            .contains("plant/lamp.lw: contract Light: realizable"),
        "{}",
        printed.out
    );
}

/// A link to a file of results stays a link, and the file behind it is written.
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
