//! Valid documents that make no sense, each with all its findings.

use crate::invalid::{check, findings};
use crate::support::{pad, read_again};
use linewright_b2mml::{Document, write};

/// Returns a property with values, each a key and a text.
fn property(id: &str, values: &[(&str, &str)]) -> String {
    let values = values.iter().map(|(key, text)| {
        let key = match *key {
            "" => String::new(),
            key => format!("<Key>{key}</Key>"),
        };
        format!("<Value><ValueString>{text}</ValueString>{key}</Value>")
    });
    let values: String = values.collect();
    format!("<EquipmentProperty><ID>{id}</ID>{values}</EquipmentProperty>")
}

#[test]
fn resources_that_make_no_sense() {
    check(
        "EquipmentInformation",
        "<ID/>",
        &["2:1: meaning: there is no equipment"],
    );
    let content = [
        "<ID>Cell</ID><Equipment><ID>r</ID>".to_owned(),
        property("Capacity", &[("", "two")]),
        property("States", &[("", "s0"), ("", "s1"), ("", "s1")]),
        property("WaitingStates", &[("", "s2")]),
        property("InitialState", &[("", "s3")]),
        property("Holds", &[("", "a"), ("", "b")]),
        property(
            "Transition 1",
            &[("From", "s0"), ("To", "s4"), ("In", "1"), ("Out", "1")],
        ),
        property(
            "Transition 2",
            &[("From", "s0"), ("In", "1"), ("Duration", "-1"), ("x", "y")],
        ),
        property(
            "Transition 3",
            &[("From", "s0"), ("To", "s0"), ("In", "1"), ("Power", "NaN")],
        ),
        property("States", &[]),
        "<EquipmentClassID>glue</EquipmentClassID></Equipment>".to_owned(),
        "<Equipment><ID>r</ID></Equipment>".to_owned(),
    ];
    let content = content.join("\n");
    check(
        "EquipmentInformation",
        &content,
        &[
            "3:14: reference: resource `r` has two states `s1`",
            "3:14: reference: resource `r` has no state `s3`",
            "3:14: reference: resource `r` has no state `s4`",
            "3:14: meaning: resource `r` holds 2 parts at the start, but has room for 1",
            "4:37: meaning: a number of parts is expected, not `two`",
            "6:42: reference: there is no state `s2`",
            "9:213: meaning: the transition has a second value `Out`",
            "10:1: meaning: `Transition 2` needs values with the keys `From`, `To` and what it \
             does",
            "10:156: meaning: a finite number of at least zero is expected",
            "10:219: meaning: a transition has no value with the key `x`",
            "11:213: meaning: a finite number of at least zero is expected",
            "12:1: reference: the property `States` occurs twice",
            "13:1: reference: no transition performs `glue`",
            "14:1: reference: two resources are called `r`",
        ],
    );
    check(
        "EquipmentInformation",
        "<ID/><Equipment><ID>a</ID><EquipmentChild><ID>r</ID></EquipmentChild></Equipment>
<Equipment><ID>b</ID></Equipment>
<Equipment><ID>a</ID><EquipmentChild><ID>r</ID></EquipmentChild></Equipment>",
        &[
            "2:1: reference: two work cells are called `a`",
            "4:1: meaning: `b` is in no work cell and contains none",
        ],
    );
}

#[test]
fn recipes_that_make_no_sense() {
    let text = write::definition(&pad::hinge(false)).expect("it is sound");
    for (right, wrong, expected) in [
        (
            "<ValueString>visionOk</ValueString>",
            "<ValueString/>",
            &[][..],
        ),
        (
            "<ID>Otherwise</ID>",
            "<ID>Tested</ID>",
            &["1000:1: meaning: a guard is either a test or otherwise"][..],
        ),
        (
            "<ID>From</ID>",
            "<ID>Form</ID>",
            &["1000:1: meaning: the parameter `From` is missing"],
        ),
        (
            "<SegmentID>T1.S1.O1</SegmentID>",
            "<SegmentID>T1.S1.O9</SegmentID>",
            &["1000:1: reference: there is no segment `T1.S1.O9` beside this"],
        ),
        (
            "<Dependency>AfterEnd</Dependency>\n    <SegmentID>T1.S1.O1<",
            "<Dependency>AfterStart</Dependency>\n    <SegmentID>T1.S1.O1<",
            &["1000:1: meaning: the dependency `AfterStart` is not read"],
        ),
        (
            "<SegmentID>T1.S1.O1</SegmentID>",
            "<SegmentID>T1.S6.O1</SegmentID>",
            &["1000:1: meaning: the dependencies of this segment form a circle"],
        ),
        (
            "<ID>T1.S2.O1</ID>",
            "<ID>T1.S1.O1</ID>",
            &["1000:1: reference: two segments have the identifier `T1.S1.O1`"],
        ),
        (
            "<MaterialUse>Consumed</MaterialUse>",
            "<MaterialUse>Inventoried</MaterialUse>",
            &["1000:1: meaning: the material use `Inventoried` is not known"],
        ),
        (
            "<QuantityString>1</QuantityString>",
            "<QuantityString>1.5</QuantityString>",
            &["1000:1: meaning: a number of pieces from 1 to 10000 is expected, not `1.5`"],
        ),
        (
            "<ID>Start</ID>\n   <Value>\n    <ValueString>a<",
            "<ID>Start</ID>\n   <Value>\n    <ValueString>x<",
            &["1000:1: reference: the recipe has no state `x`"],
        ),
        (
            "OtherValue=\"Recipe\"",
            "OtherValue=\"Recipes\"",
            &["1000:1: meaning: it is not said how `f` is used"],
        ),
    ] {
        assert!(text.contains(right), "{right}");
        let changed = text.replacen(right, wrong, 1);
        if expected.is_empty() {
            // The empty name of a test is written differently, but it is a name.
            assert!(matches!(read_again(&changed), Document::Recipes(_)));
            continue;
        }
        let found = findings(&changed);
        let message = |line: &str| line.splitn(3, ':').nth(2).map(str::to_owned);
        let place = changed.lines().zip(text.lines()).position(|(a, b)| a != b);
        let first_change = place.expect("there is a change") + 1;
        let lines: Vec<String> = found.lines().filter_map(message).collect();
        for line in expected {
            let wanted = message(line).expect("it has a message");
            assert!(lines.contains(&wanted), "{wanted} in {found}");
        }
        let near = found
            .lines()
            .filter_map(|l| l.split(':').next()?.parse::<usize>().ok());
        let distances = near.map(|line| line.abs_diff(first_change));
        assert!(
            distances.min().is_some_and(|d| d < 80),
            "{first_change}: {found}"
        );
    }
    check(
        "OperationsDefinition",
        "<ID>x</ID>",
        &["2:1: meaning: the recipe has no segments"],
    );
}

#[test]
fn workflows_that_make_no_sense() {
    let nodes = "<WorkflowSpecificationNode><ID>a</ID></WorkflowSpecificationNode>\
        <WorkflowSpecificationNode><ID>b</ID></WorkflowSpecificationNode>";
    let connection = |from: &str, to: &str, dependency: &str| {
        format!(
            "\n<WorkflowSpecificationConnection><ID>1</ID><FromWSNodeID>{from}</FromWSNodeID>\
             <ToWSNodeID>{to}</ToWSNodeID>{dependency}</WorkflowSpecificationConnection>"
        )
    };
    let after = "<Dependency>AfterEnd</Dependency>";
    let guard = "<Dependency OtherValue='ok'>Other</Dependency>";
    for (connections, expected) in [
        (
            connection("a", "c", after),
            vec!["4:74: reference: there is no node `c`"],
        ),
        (
            connection("a", "b", guard),
            vec![
                "3:11: meaning: the guards of state `a` do not cover every outcome: `otherwise` is \
                 missing",
            ],
        ),
        (
            connection("a", "b", "<Dependency>NotFollow</Dependency>"),
            vec!["4:1: meaning: the dependency `NotFollow` is not read"],
        ),
        (
            connection("a", "b", after) + &connection("b", "a", after),
            vec!["2:1: meaning: it is not clear where the workflow starts"],
        ),
        (
            connection("a", "b", "<Dependency>AtStart</Dependency>"),
            vec!["4:1: meaning: `AtStart` joins operations that one connection enters"],
        ),
        (
            connection("a", "b</ToWSNodeID><ToWSNodeID>a", after),
            vec!["4:1: meaning: only operations can begin together"],
        ),
        (
            connection("a", "c</ToWSNodeID><ToWSNodeID>c", after).replace(
                "\n<Work",
                "\n<WorkflowSpecificationNode><ID>c</ID>\
                    <WorkMasterID>c</WorkMasterID></WorkflowSpecificationNode><Work",
            ),
            vec!["4:96: meaning: operations begin together with different ones"],
        ),
    ] {
        check(
            "WorkflowSpecification",
            &format!("<ID>x</ID>{nodes}{connections}"),
            &expected,
        );
    }
}

#[test]
fn schedules_that_make_no_sense() {
    let text = crate::support::documents(&pad::layout(6), &pad::hinge(false)).swap_remove(3);
    assert!(text.contains("<OperationsSchedule "));
    for (right, wrong, expected) in [
        (
            "<ID>Vector</ID>",
            "<ID>Sector</ID>",
            "meaning: a place has a position, a transition and a vector",
        ),
        (
            "<EquipmentUse>out</EquipmentUse>",
            "<EquipmentUse>in</EquipmentUse>",
            "meaning: a routing moves one part out of a resource into another",
        ),
        (
            "OtherValue=\"Routing\">Other</OperationsType>\n   <ProcessSegmentID>",
            "OtherValue=\"Transport\">Other</OperationsType>\n   <ProcessSegmentID>",
            "meaning: an operation has one resource; only `Routing` has two",
        ),
        (
            "<SegmentRequirement>\n   <ID>P1-T1-V2-R1</ID>",
            "<SegmentRequirement>\n   <ID>P1-T1-V1-R1</ID>",
            "reference: two requests have the identifier `P1-T1-V1-R1`",
        ),
        (
            "<MaterialDefinitionID>Fixture<",
            "<MaterialDefinitionID>Pin<",
            "reference: part `f` had the type `Pin` before",
        ),
    ] {
        assert!(text.contains(right), "{right} in {text}");
        let found = findings(&text.replacen(right, wrong, 1));
        assert!(found.contains(expected), "{expected} in {found}");
    }
}
