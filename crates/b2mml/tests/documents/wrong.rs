//! Documents that are not read, each with all its findings.

use crate::foreign::document;
use crate::support::{pad, read_again};
use linewright_b2mml::{Document, Rule, read, write};
use std::fmt::Write as _;

/// Returns the findings of a document that is not read.
fn findings(text: &str) -> String {
    match read(text.as_bytes()) {
        Err(findings) => findings.to_string(),
        Ok(reading) => panic!("{reading:?}"),
    }
}

/// Checks the findings of a document with a root and what it contains, which begins in line 3.
fn check(root: &str, content: &str, expected: &[&str]) {
    let found = findings(&document(root, content));
    assert_eq!(found.lines().collect::<Vec<_>>(), expected, "{content}");
}

#[test]
fn texts_that_are_no_xml() {
    let long = "<a>".repeat(101);
    let root = |content: &str| format!("<a xmlns='x'>{content}</a>");
    for (text, expected) in [
        ("", "1:1: syntax: there is no element"),
        ("text", "1:1: syntax: there is text outside of the root"),
        ("<a>", "1:1: syntax: `a` does not end"),
        ("<a/><b/>", "1:5: syntax: there is a second root"),
        (
            "<a>\n</b>",
            "2:1: syntax: ill-formed document: expected `</a>`, but `</b>` was found",
        ),
        (
            "<a b='1' b='2'/>",
            "1:10: syntax: attribute `b` occurs twice",
        ),
        (
            "<a b='<'/>",
            "1:7: syntax: `<` is not allowed in the value of an attribute",
        ),
        ("<1/>", "1:1: syntax: `1` is not a name"),
        ("<x:a/>", "1:1: syntax: prefix `x` is not declared"),
        ("<a x:b=''/>", "1:4: syntax: prefix `x` is not declared"),
        (
            "<a xmlns:x=''/>",
            "1:4: syntax: a prefix is declared without a namespace",
        ),
        (
            "<a xmlns:x='u' xmlns:y='u' x:b='' y:b=''/>",
            "1:35: syntax: attribute `b` occurs twice",
        ),
        (
            " <?xml version='1.0'?><a/>",
            "1:2: syntax: the XML declaration is not at the beginning",
        ),
        (
            "<?xml version='1.1'?><a/>",
            "1:16: syntax: XML 1.0 is read, not `1.1`",
        ),
        (
            "<?xml version='1.0' encoding='latin1'?><a/>",
            "1:31: syntax: UTF-8 is read, not `latin1`",
        ),
        (
            "<a/><?xMl?>",
            "1:5: syntax: a processing instruction has no proper name",
        ),
        (&root("&x;"), "1:14: syntax: entity `x` is not declared"),
        (
            &root("&#xFFFF;"),
            "1:14: syntax: `&#xFFFF;` is not a character of XML",
        ),
        (
            &root("ü]]>"),
            "1:15: syntax: `]]>` is not allowed in a text",
        ),
        (
            &root("\u{1}"),
            "1:14: syntax: the character U+0001 is not allowed in XML",
        ),
        (
            &root("<!-- -- -->"),
            "1:19: syntax: ill-formed document: forbidden string `--` was found in a comment",
        ),
        (
            &root("<!-- --->"),
            "1:19: syntax: ill-formed document: forbidden string `--` was found in a comment",
        ),
        (
            &root("<!-->"),
            "1:14: syntax: syntax error: comment not closed: `-->` not found before end of input",
        ),
        (
            &root("<!--->"),
            "1:14: syntax: syntax error: comment not closed: `-->` not found before end of input",
        ),
        (
            &root("<!bang>"),
            "1:14: syntax: syntax error: unknown or missed symbol in markup",
        ),
        (&long, "1:301: size: elements are nested deeper than 100"),
    ] {
        assert_eq!(findings(text), expected, "{text}");
    }
    let found = read(b"<a>\n \xff</a>").expect_err("it is no UTF-8");
    assert_eq!(
        found.to_string(),
        "2:2: encoding: the document is not UTF-8 from here on"
    );
}

/// Entities that contain each other would take memory without end.
#[test]
fn declarations_of_entities_are_refused() {
    let mut text = "<!DOCTYPE a [<!ENTITY e0 \"lol\">".to_owned();
    for number in 1..20 {
        let reference = format!("&e{};", number - 1).repeat(10);
        let written = write!(text, "<!ENTITY e{number} \"{reference}\">");
        written.expect("a string takes all");
    }
    text.push_str("]><a>&e19;</a>");
    for text in [
        &text,
        "<!DOCTYPE a SYSTEM \"http://x/y.dtd\"><a/>",
        "<!DOCTYPE a><a/>",
    ] {
        let expected = "1:1: document type: a document type declaration is not read";
        assert_eq!(findings(text), expected);
    }
}

#[test]
fn other_versions_and_documents_are_refused() {
    for (root, expected) in [
        (
            "<OperationsSchedule xmlns='http://www.mesa.org/xml/B2MML-V0600'/>",
            "1:1: version: this is a document of B2MML 6; B2MML 7 is read, with the namespace \
             `http://www.mesa.org/xml/B2MML`",
        ),
        (
            "<ProductionSchedule xmlns='http://www.mesa.org/xml/B2MML-V0401'/>",
            "1:1: version: this is a document of B2MML 401; B2MML 7 is read, with the namespace \
             `http://www.mesa.org/xml/B2MML`",
        ),
        (
            "<OperationsSchedule/>",
            "1:1: version: the document has no namespace; B2MML 7 is read, with the namespace \
             `http://www.mesa.org/xml/B2MML`",
        ),
        (
            "<html xmlns='http://www.w3.org/1999/xhtml'/>",
            "1:1: version: the namespace is `http://www.w3.org/1999/xhtml`; B2MML 7 is read, with \
             the namespace `http://www.mesa.org/xml/B2MML`",
        ),
        (
            "<WorkSchedule xmlns='http://www.mesa.org/xml/B2MML'/>",
            "1:1: root: `WorkSchedule` is not read; these are: `EquipmentInformation`, \
             `OperationsDefinition`, `OperationsDefinitionInformation`, `OperationsPerformance`, \
             `OperationsSchedule`, `WorkflowSpecification`, `WorkflowSpecificationInformation`",
        ),
    ] {
        assert_eq!(findings(root), expected, "{root}");
    }
}

/// All that the schema does not allow is found at once.
#[test]
fn documents_that_are_not_valid() {
    check(
        "EquipmentInformation",
        "<PublishedDate>yesterday</PublishedDate>
<Equipment id='1'>text<ID languageID='en' schemeURI='a b'>r</ID><ID>s</ID>
 <EquipmentLevel>Cell</EquipmentLevel><Version/><Robot/>
 <EquipmentProperty><ID><b/></ID><Value><DataType>string</DataType></Value></EquipmentProperty>
</Equipment>",
        &[
            "3:1: structure: `EquipmentInformation` needs `ID` before this",
            "3:1: value: `PublishedDate` is not a date and time such as `2026-11-30T12:00:00Z`, \
             but `yesterday`",
            "4:12: attribute: `Equipment` has no attribute `id`",
            "4:19: structure: `Equipment` cannot have text",
            "4:27: attribute: `ID` has no attribute `languageID`",
            "4:43: attribute: `schemeURI` is not a URI, but `a b`",
            "4:65: structure: `ID` cannot occur again here",
            "5:2: value: `EquipmentLevel` is not one of `Enterprise`, `Site`, `Area`, \
             `ProcessCell`, `Unit`, `ProductionLine`, `WorkCell`, `ProductionUnit`, `StorageZone`, \
             `StorageUnit`, `WorkCenter`, `WorkUnit`, ..., but `Cell`",
            "5:39: structure: `Version` must stand before `EquipmentLevel`",
            "5:49: structure: `Equipment` cannot contain `Robot`; here it can contain \
             `SpatialDefinition`, `EquipmentAssetMapping`, `PhysicalAssetID`, \
             `OperationalLocation`, `EquipmentProperty`",
            "6:25: structure: `ID` cannot have elements",
            "6:41: structure: `Value` needs `ValueString` before this",
        ],
    );
    check(
        "OperationsSchedule",
        "<ID>x</ID>",
        &["2:1: structure: `OperationsSchedule` needs `OperationsRequest`"],
    );
    check(
        "WorkflowSpecification",
        "<ID xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:nil='true'/>
<WorkflowSpecificationNode><ID/><WorkflowSpecificationNodeProperty><ID/><Value>
 <ValueString xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:nil='1'>x</ValueString>
 <UnitOfMeasure xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:nil='maybe'/>
 </Value></WorkflowSpecificationNodeProperty></WorkflowSpecificationNode>
<x:Node xmlns:x='y'/>",
        &[
            "3:59: attribute: the attribute `xsi:nil` is not allowed here",
            "5:2: value: `ValueString` is nil, so it must be empty",
            "6:71: attribute: `nil` is not `true` or `false`, but `maybe`",
            "8:1: structure: `WorkflowSpecification` cannot contain `Node`; here it can contain \
             `WorkflowSpecificationNode`, `WorkflowSpecificationConnection`, \
             `WorkflowSpecificationPatternID`, `WorkflowSpecificationProperty`",
        ],
    );
}

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

/// Depth and size that a hostile document has, in bounded time.
#[test]
fn large_documents_are_bounded() {
    let many = "<b>".repeat(3_000_000);
    let found = read(document("EquipmentInformation", &many).as_bytes()).expect_err("too deep");
    assert_eq!(found.list[0].rule, Rule::Size);
    let many = format!(
        "<EquipmentInformation xmlns='{}' {}/>",
        linewright_b2mml::NAMESPACE,
        (0..200_000).fold(String::new(), |mut text, n| {
            let _ = write!(text, "a{n}='' ");
            text
        })
    );
    let found = read(many.as_bytes()).expect_err("too many attributes");
    assert_eq!(found.list[0].rule, Rule::Syntax);
    let quantity = "<Quantity><QuantityString>10000</QuantityString></Quantity>";
    let material = format!(
        "<MaterialSpecification><ID>p</ID><MaterialUse>Produced</MaterialUse>{quantity}\
         </MaterialSpecification>"
    );
    let materials = material.repeat(1_000);
    let segment = format!("<OperationsSegment><ID>s</ID>{materials}</OperationsSegment>");
    let many = document("OperationsDefinition", &format!("<ID/>{segment}"));
    let found = read(many.as_bytes()).expect_err("too many pieces");
    assert!(found.list.iter().all(|f| f.rule == Rule::Size), "{found}");
    let states = "<Value><ValueString>s</ValueString></Value>".repeat(20_000);
    let property = format!("<EquipmentProperty><ID>States</ID>{states}</EquipmentProperty>");
    let name = "r".repeat(10_000);
    let equipment = format!("<ID/><Equipment><ID>{name}</ID>{property}</Equipment>");
    let many = document("EquipmentInformation", &equipment);
    let found = read(many.as_bytes()).expect_err("a long name and many states");
    assert!(found.list.iter().any(|f| f.rule == Rule::Size), "{found}");
    let many = document("EquipmentInformation", &"<b/>".repeat(200_000));
    let found = read(many.as_bytes()).expect_err("they are not of the schema");
    assert_eq!(found.list.len(), linewright_b2mml::MAX_FINDINGS);
    assert!(found.omitted > 190_000, "{}", found.omitted);
}
