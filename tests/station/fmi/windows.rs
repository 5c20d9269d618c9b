//! The Windows binary in each archive, stepped by a Windows host under Wine.

use super::hosts::{
    PATIENCE, arguments, binary_name, file_of, host, laboratory, record, unpack, write,
};
use super::tape::compare;
use crate::support::skip;
use crate::support::wine::{windows_path, wine};
use linewright::station::toolchain::Compiler;

#[test]
fn the_windows_binary_steps_under_wine() {
    let compiler = match Compiler::windows() {
        Ok((_, compiler)) => compiler,
        Err(error) => return skip("mingw", &error.to_string()),
    };
    let wine = match wine() {
        Ok(wine) => wine,
        Err(why) => return skip("wine", &why),
    };
    let folder = tempfile::tempdir().unwrap();
    for (seed, built) in (100..).zip(laboratory()) {
        let name = format!("{} {:?}", built.machine.name, built.unit.version);
        let inside = binary_name(&built.unit, true);
        assert!(file_of(&built.archive, &inside).is_some(), "{name}");
        let host = host(compiler.command(), built.unit.version, folder.path());
        let library = windows_path(&unpack(built, true, folder.path()));
        let tape = record(built, 20, 60, seed);
        let file = windows_path(&write(&tape, folder.path()));
        let play = arguments(built, library.clone(), Some(file));
        let finished = wine.run(&host, &play, PATIENCE);
        compare(&tape, &finished.output, true).unwrap_or_else(|e| panic!("{name}: {e}"));
        if built.machine.name == "AssemblyCell" {
            let check = arguments(built, library, None);
            let finished = wine.run(&host, &check, PATIENCE);
            assert_eq!(finished.output, "HOST PASSED\n");
        }
    }
}
