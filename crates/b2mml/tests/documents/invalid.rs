//! Documents that are not well-formed, of other versions, not valid or too large, each with all its
//! findings.

use crate::foreign::document;
use linewright_b2mml::{Rule, read};
use std::fmt::Write as _;

/// Returns the findings of a document that is not read.
pub fn findings(text: &str) -> String {
    match read(text.as_bytes()) {
        Err(findings) => findings.to_string(),
        Ok(reading) => panic!("{reading:?}"),
    }
}

/// Checks the findings of a document with a root and what it contains, which begins in line 3.
pub fn check(root: &str, content: &str, expected: &[&str]) {
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
