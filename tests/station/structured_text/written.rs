//! The output for a small controller, in every form.

use crate::library::{Controlled, as_functions, machines};
use crate::support::linewright;
use linewright::station::structured_text::{block, block_with_tables};

fn single() -> &'static Controlled {
    let found = machines().iter().find(|c| c.controller.name() == "Single");
    found.expect("a contract of the library")
}

#[test]
fn a_machine_is_a_case_over_its_states() {
    let single = single();
    insta::assert_snapshot!(block(&single.controller, &single.specification).to_text());
}

#[test]
fn a_long_machine_is_tables() {
    let single = single();
    let machine = single.controller.machine().expect("a machine");
    insta::assert_snapshot!(block_with_tables(machine, &single.specification).to_text());
}

#[test]
fn functions_are_decisions_that_a_loop_walks() {
    let specification = &single().specification;
    insta::assert_snapshot!(block(&as_functions(specification), specification).to_text());
}

#[test]
fn a_document_holds_the_same() {
    let single = single();
    insta::assert_snapshot!(block(&single.controller, &single.specification).to_plcopen());
}

const ODD: &str = "
contract Odd {
    input a, b: bool
    output c: bool
    assume both: always ((a -> b) and (b -> a))
    guarantee odd: always ((c -> a) // ) and (
        and (not (a and b)
            or /* ) */ (c)))
}
";

#[test]
fn formulas_in_comments_have_all_their_brackets() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("odd.lw"), ODD).expect("a file can be written");
    let arguments = [
        "synth", "odd.lw", "--emit", "st", "--emit", "c", "--out", ".",
    ];
    let output = linewright(folder.path(), &arguments);
    assert!(output.status.success(), "{output:?}");
    let read = |name: &str| {
        let text = std::fs::read_to_string(folder.path().join(name));
        text.expect("a written file")
    };
    let (block, source) = (read("Odd.st"), read("Odd.c"));
    let assumed = "both: always ((a -> b) and (b -> a))";
    let promised = "odd: always ((c -> a) and (not (a and b) or (c)))";
    assert!(block.contains(&format!("  {assumed}\n")), "{block}");
    assert!(block.contains(&format!("  {promised}\n")), "{block}");
    assert!(source.contains(&format!("/* {assumed} */")), "{source}");
}
