//! The Windows binary in each archive, stepped by a Windows host under Wine.

use crate::hosts::{binary_name, command, file_of, host, laboratory, record, run, unpack};
use crate::support::{Wine, mingw, wine};
use crate::tape::compare;

#[test]
fn the_windows_binary_steps_under_wine() {
    let Some(compiler) = mingw() else { return };
    let Some(wine) = wine() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (seed, built) in (100..).zip(laboratory()) {
        let name = format!("{} {:?}", built.machine.name, built.unit.version);
        assert!(
            file_of(&built.archive, &binary_name(&built.unit, true)).is_some(),
            "{name}"
        );
        let host = host(&compiler, built.unit.version, folder.path());
        let library = Wine::path(&unpack(built, true, folder.path()));
        let step = built.machine.step_seconds;
        let tape = record(built, 20, 60, seed);
        let mut play = command(wine.command(&host), "play", &library, &built.unit, step);
        let printed = run(&mut play, &tape.text);
        compare(&tape, &printed, true).unwrap_or_else(|e| panic!("{name}: {e}"));
        if built.machine.name == "AssemblyCell" {
            let mut check = command(wine.command(&host), "check", &library, &built.unit, step);
            assert_eq!(run(&mut check, ""), "HOST PASSED\n");
        }
    }
}
