//! PLCopen XML: a block in this format runs like its text.

use super::play::{compare, compiled};
use crate::iec::document::{read, text_of};
use crate::library::{as_functions, machines};
use linewright::mealy::Controller;
use linewright::station::structured_text::{block, block_with_tables};

#[test]
fn a_document_says_what_the_text_says() {
    for controlled in machines() {
        let specification = &controlled.specification;
        let functions = as_functions(specification);
        let machine = controlled.controller.machine().expect("a machine");
        let blocks = [
            (
                block(&controlled.controller, specification),
                &controlled.controller,
            ),
            (
                block_with_tables(machine, specification),
                &controlled.controller,
            ),
            (block(&functions, specification), &functions),
        ];
        for (block, controller) in blocks {
            let text = text_of(&block.to_plcopen());
            let program = compiled(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let counts = compare(&program, controller, specification, 3_000, 11);
            let counts = counts.unwrap_or_else(|e| panic!("{e}"));
            assert!(counts.accepted > 0, "{counts:?}");
        }
    }
}

#[test]
fn a_document_is_the_same_every_time() {
    let controlled = &machines()[0];
    let Controller::Machine(_) = &controlled.controller else {
        panic!("a machine");
    };
    let write = || block(&controlled.controller, &controlled.specification).to_plcopen();
    assert_eq!(write(), write());
    assert!(!write().contains("202"), "no date of today");
}

#[test]
fn the_reader_reads_what_it_should() {
    let document = read("<?xml?><a b=\"&lt;x&#65;&#x42;\"><c/><d>1 &amp; 2</d> 3</a>");
    assert_eq!(document.attribute("b"), "<xAB");
    assert_eq!(document.get(&["d"]).text, "1 & 2");
    assert_eq!(document.text, " 3");
    assert_eq!(document.children[0].name, "c");
}
