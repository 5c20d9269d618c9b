//! A failing run leaves nothing half-written, and deletes nothing.

use super::session::Session;
use std::collections::BTreeMap;

type Contents = BTreeMap<String, Vec<u8>>;

/// Files that are new or changed; without folders. No file may have disappeared.
fn added(before: &Contents, after: &Contents) -> Vec<String> {
    for name in before.keys() {
        assert!(after.contains_key(name), "{name} is gone");
    }
    let new = after
        .iter()
        .filter(|(name, bytes)| before.get(*name) != Some(bytes) && !name.ends_with('/'));
    new.map(|(name, _)| name.clone()).collect()
}

#[test]
fn a_failed_run_changes_nothing() {
    let session = Session::new();
    let path = session.failing_compiler();
    assert_eq!(session.run("run lamp.lw").code, 0);
    std::fs::write(session.path(".linewright/notes.txt"), "mine").expect("a file");
    std::fs::write(session.path("taken"), "mine").expect("a file");
    // From here on, a library would have to be rebuilt.
    session.edit("lamp.lw", "power 5 W", "power 6 W");
    let before = session.contents();
    let failing = [("PATH", path.as_str())];
    let nowhere = [("PATH", "nowhere")];
    for (line, environment, code) in [
        ("run lamp.lw", &failing[..], 2),
        ("run lamp.lw", &nowhere, 2),
        ("run lamp.lw --rebuild", &failing, 2),
        ("run lamp.lw --out elsewhere", &failing, 2),
        ("run lamp.lw --trace log.csv", &failing, 2),
        ("run lamp.lw --report page.html", &failing, 2),
        ("build lamp.lw", &nowhere, 2),
        ("run lamp.lw --out taken", &[], 2),
        ("run lamp.lw --timeout 0.000001", &[], 3),
        ("synth unrealizable.lw --out controllers", &[], 1),
        ("synth lamp.lw::Light --out taken", &[], 2),
        ("build unbound.lw", &[], 1),
        ("check syntax.lw type.lw", &[], 2),
    ] {
        let printed = session.run_with(line, environment);
        assert_eq!(printed.code, code, "{line}\n{}", printed.err);
        let mut new = added(&before, &session.contents());
        new.retain(|name| name != "compiler.log");
        assert_eq!(new, Vec::<String>::new(), "{line}");
    }
}

#[test]
fn a_new_library_stands_beside_the_old_one() {
    let session = Session::new();
    assert_eq!(session.run("run lamp.lw").code, 0);
    let before = session.contents();
    session.edit("lamp.lw", "power 5 W", "power 6 W");
    let edited = session.contents();
    assert_eq!(added(&before, &edited), ["lamp.lw"]);
    assert_eq!(session.run("run lamp.lw").code, 0);
    let new = added(&edited, &session.contents());
    assert_eq!(new.len(), 2, "a library and its manifest: {new:?}");
}

#[test]
fn controllers_are_written_whole() {
    let session = Session::new();
    let before = session.contents();
    let line = "synth lamp.lw --emit json --emit dot --emit svg --emit gr1c --out controllers";
    assert_eq!(session.run(line).code, 0);
    let first = session.contents();
    let new = added(&before, &first);
    let wanted = ["Light.dot", "Light.gr1c.json", "Light.json", "Light.svg"];
    let wanted: Vec<String> = wanted.iter().map(|n| format!("controllers/{n}")).collect();
    assert_eq!(new, wanted);
    // Again: the same bytes.
    assert_eq!(session.run(line).code, 0);
    assert_eq!(session.contents(), first);
}
