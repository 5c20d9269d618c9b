//! Names of ports and labels.

use super::cells;

#[test]
fn labels_name_what_resources_could_not_know_and_all_names_differ() {
    let made = cells::odd();
    let machine = &made.built.machine;
    let ports = machine.inputs.iter().chain(&machine.outputs);
    let shown = ports.map(|p| format!("{}: {}\n", p.name, p.domain.describe()));
    insta::assert_snapshot!(shown.collect::<String>());
}
