//! What a small controller looks like, in every form.

use crate::library::{Controlled, as_functions, machines};
use linewright::station::structured_text::{block, block_of_tables};

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
    insta::assert_snapshot!(block_of_tables(machine, &single.specification).to_text());
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
