//! Documents that other programs write.

use crate::support::read_again;
use linewright_b2mml::{Activity, Document, read};
use linewright_recipe::model::{
    Action, Guard, Layout, OperationCall, Part, Recipe, RecipeTransition, Resource, Step,
};

/// Returns a document with a root and what it contains.
pub fn document(root: &str, content: &str) -> String {
    let namespace = linewright_b2mml::NAMESPACE;
    format!("<?xml version=\"1.0\"?>\n<{root} xmlns=\"{namespace}\">\n{content}\n</{root}>\n")
}

fn step(calls: &[(&str, &[&str], &[&str])]) -> Step {
    let calls = calls.iter().map(|(n, i, o)| OperationCall::new(n, i, o));
    Step::new(calls.collect())
}

fn material(part: &str, kind: &str, usage: &str) -> String {
    format!(
        "<MaterialSpecification><ID>{part}</ID><MaterialDefinitionID>{kind}</MaterialDefinitionID>\
         <MaterialUse>{usage}</MaterialUse></MaterialSpecification>"
    )
}

#[test]
fn equipment_with_classes_offers_its_operations() {
    let text = document(
        "EquipmentInformation",
        "<ID>Hall 3</ID>
        <Equipment><ID>Site</ID><EquipmentLevel>Site</EquipmentLevel>
          <EquipmentChild><ID>Cell A</ID><EquipmentLevel>WorkCell</EquipmentLevel>
            <EquipmentChild><ID>press</ID><EquipmentClassID>form</EquipmentClassID>
              <EquipmentClassID>cut</EquipmentClassID></EquipmentChild>
            <EquipmentChild><ID>robot</ID></EquipmentChild>
          </EquipmentChild>
          <EquipmentChild><ID>Cell B</ID>
            <EquipmentChild><ID>saw</ID><EquipmentClassID>cut</EquipmentClassID></EquipmentChild>
          </EquipmentChild>
        </Equipment>",
    );
    let operation = |name: &str| Action::Operation(name.to_owned());
    let layout = |name: &str, resources| Layout {
        name: name.to_owned(),
        resources,
    };
    let press = Resource::new("press", &["idle"], &[])
        .with("idle", operation("form"), "idle")
        .with("idle", operation("cut"), "idle");
    let saw = Resource::new("saw", &["idle"], &[]).with("idle", operation("cut"), "idle");
    let robot = Resource::new("robot", &["idle"], &[]);
    let expected = vec![
        layout("Cell A", vec![press, robot]),
        layout("Cell B", vec![saw]),
    ];
    assert_eq!(read_again(&text), Document::Layouts(expected));

    let text = document(
        "EquipmentInformation",
        "<ID>Hall</ID><Equipment><ID>saw</ID><EquipmentProperty><ID>Serial number</ID>\
         </EquipmentProperty><EquipmentClassID>cut</EquipmentClassID></Equipment>",
    );
    let reading = read(text.as_bytes()).expect("it is a layout");
    let Document::Layouts(layouts) = reading.document else {
        panic!("{text}");
    };
    assert_eq!(
        (layouts[0].name.as_str(), layouts[0].resources.len()),
        ("Hall", 1)
    );
    assert_eq!(
        reading.notes.to_string(),
        "3:37: left out: `EquipmentProperty` is left out"
    );
}

/// Segments in the order of their dependencies: paint before pack, drill together with mill.
#[test]
fn segments_become_steps() {
    let segment = |id: &str, content: &str| {
        format!("<OperationsSegment><ID>{id}</ID>{content}</OperationsSegment>\n")
    };
    let dependency = |kind: &str, on: &str| {
        format!(
            "<SegmentDependency><ID>1</ID><Dependency>{kind}</Dependency>\
             <SegmentID>{on}</SegmentID></SegmentDependency>"
        )
    };
    let pack = segment(
        "pack",
        &format!(
            "{}{}{}{}",
            material("box", "Box", "Consumed"),
            material("part", "Part", "Consumed"),
            material("parcel", "Parcel", "Produced"),
            dependency("AfterEnd", "paint")
        ),
    );
    let make = format!(
        "<OperationsSegment><ID>make</ID>
           <OperationsSegmentChild><ID>mill</ID><ProcessSegmentID>Milling</ProcessSegmentID>
             {}</OperationsSegmentChild>
           <OperationsSegmentChild><ID>drill</ID>{}</OperationsSegmentChild>
         </OperationsSegment>",
        material("part", "Part", "Produced"),
        dependency("AtStart", "mill")
    );
    let paint = segment("paint", &dependency("AfterEnd", "make"));
    let content = format!("<ID>Parcels</ID>{pack}{make}{paint}");
    let recipe = Recipe {
        name: "Parcels".to_owned(),
        parts: vec![
            Part::new("part", "Part"),
            Part::new("box", "Box"),
            Part::new("parcel", "Parcel"),
        ],
        states: vec!["start".to_owned(), "end".to_owned()],
        start: "start".to_owned(),
        ends: vec!["end".to_owned()],
        leftover: vec!["parcel".to_owned()],
        transitions: vec![RecipeTransition::new(
            "start",
            "end",
            Guard::Always,
            vec![
                step(&[("Milling", &[], &["part"]), ("drill", &[], &[])]),
                step(&[("paint", &[], &[])]),
                step(&[("pack", &["box", "part"], &["parcel"])]),
            ],
        )],
    };
    let text = document("OperationsDefinition", &content);
    assert_eq!(read_again(&text), Document::Recipes(vec![recipe.clone()]));
    let content = format!(
        "<ID>All</ID><OperationsDefinition>{content}</OperationsDefinition>\
         <OperationsDefinition><ID>Other</ID><OperationsSegment><ID>x</ID></OperationsSegment>\
         </OperationsDefinition>"
    );
    let text = document("OperationsDefinitionInformation", &content);
    let Document::Recipes(recipes) = read_again(&text) else {
        panic!("{text}");
    };
    assert_eq!(recipes.len(), 2);
    assert_eq!((&recipes[0], recipes[1].name.as_str()), (&recipe, "Other"));
}

/// Operations without states between them, with a choice and a loop.
#[test]
fn workflows_of_operations_get_states() {
    let node = |id: &str| {
        format!(
            "<WorkflowSpecificationNode><ID>{id}</ID><WorkMasterID>{id}</WorkMasterID>\
             </WorkflowSpecificationNode>\n"
        )
    };
    let connection = |id: &str, from: &str, to: &str, guard: &str| {
        let dependency = if guard.is_empty() {
            "<Dependency>AfterEnd</Dependency>".to_owned()
        } else {
            format!("<Dependency OtherValue=\"{guard}\">Other</Dependency>")
        };
        format!(
            "<WorkflowSpecificationConnection><ID>{id}</ID><FromWSNodeID>{from}</FromWSNodeID>\
             <ToWSNodeID>{to}</ToWSNodeID>{dependency}</WorkflowSpecificationConnection>\n"
        )
    };
    let nodes: String = ["load", "clean", "check", "pack"].map(node).concat();
    let content = format!(
        "<ID>Loop</ID>{nodes}{}{}{}{}",
        connection("1", "load", "clean", ""),
        connection("2", "clean", "check", ""),
        connection("3", "check", "clean", "dirty"),
        connection("4", "check", "pack", "else"),
    );
    let Document::Recipes(recipes) = read_again(&document("WorkflowSpecification", &content))
    else {
        panic!("it is a recipe");
    };
    let recipe = &recipes[0];
    let one = |name: &str| step(&[(name, &[], &[])]);
    assert_eq!(
        recipe.transitions,
        [
            RecipeTransition::new(
                "behind check",
                "before clean",
                Guard::test("dirty", &[]),
                vec![]
            ),
            RecipeTransition::new(
                "behind check",
                "behind pack",
                Guard::Otherwise,
                vec![one("pack")]
            ),
            RecipeTransition::new(
                "before clean",
                "behind check",
                Guard::Always,
                vec![one("clean"), one("check")]
            ),
            RecipeTransition::new(
                "before load",
                "before clean",
                Guard::Always,
                vec![one("load")]
            ),
        ]
    );
    assert_eq!(
        (recipe.start.as_str(), recipe.ends.as_slice()),
        ("before load", ["behind pack".to_owned()].as_slice())
    );
}

/// Operations that only lead to each other end, since a state is put where the loop is entered.
#[test]
fn loops_of_operations_are_read() {
    let node = |id: &str| {
        format!(
            "<WorkflowSpecificationNode><ID>{id}</ID><WorkMasterID>{id}</WorkMasterID>\
             </WorkflowSpecificationNode>\n"
        )
    };
    let connection = |from: &str, to: &str| {
        format!(
            "<WorkflowSpecificationConnection><ID>{from}{to}</ID>\
             <FromWSNodeID>{from}</FromWSNodeID><ToWSNodeID>{to}</ToWSNodeID>\
             <Dependency>AfterEnd</Dependency></WorkflowSpecificationConnection>\n"
        )
    };
    let nodes: String = ["a", "b", "c"].map(node).concat();
    for (connections, expected) in [
        (
            [
                connection("a", "b"),
                connection("b", "c"),
                connection("c", "b"),
            ]
            .concat(),
            "2:1: meaning: the recipe `x` has no end",
        ),
        (
            [connection("b", "c"), connection("c", "b")].concat(),
            "meaning: the operation is never reached",
        ),
    ] {
        let content = format!("<ID>x</ID>\n{nodes}{connections}");
        let found = read(document("WorkflowSpecification", &content).as_bytes());
        let found = found
            .expect_err("it has no end or cannot be reached")
            .to_string();
        assert!(found.contains(expected), "{found}");
    }
}

/// A schedule with what is not needed here, a transfer with its halves, and a quantity.
#[test]
fn schedules_are_read() {
    let ids = "<OperationsDefinitionID>hinge</OperationsDefinitionID>\
               <OperationsSegmentID>x</OperationsSegmentID>";
    let text = document(
        "OperationsSchedule",
        &format!(
            "<ID>hinge-0001</ID><PublishedDate>2016-11-24T12:38:50Z</PublishedDate>
            <OperationsRequest><ID>A-B</ID><Priority>1</Priority>
             <SegmentRequirement><ID>1</ID>
              <OperationsType OtherValue=\"Loading\">Other</OperationsType>
              <ProcessSegmentID>Load</ProcessSegmentID><Duration>PT1M8S</Duration>{ids}
              <SegmentParameter><ID>shelf</ID></SegmentParameter>
              <EquipmentRequirement><ID>R1</ID><EquipmentID>Resource1</EquipmentID>
              </EquipmentRequirement>
              <MaterialRequirement><ID>f</ID><MaterialDefinitionID>Fixture</MaterialDefinitionID>
               <MaterialUse>Produced</MaterialUse>
               <Quantity><QuantityString>2</QuantityString></Quantity></MaterialRequirement>
             </SegmentRequirement>
             <SegmentRequirement><ID>2</ID>
              <OperationsType OtherValue=\"Routing\">Other</OperationsType>
              <ProcessSegmentID>Transfer</ProcessSegmentID>{ids}
              <EquipmentRequirement><ID>R5</ID><EquipmentUse>in</EquipmentUse>
              </EquipmentRequirement>
              <EquipmentRequirement><ID>R1</ID><EquipmentID>Resource1</EquipmentID>
               <EquipmentUse>out</EquipmentUse></EquipmentRequirement>
              <SegmentRequirementChild><ID>2a</ID><ProcessSegmentID>Give</ProcessSegmentID>{ids}
              </SegmentRequirementChild>
             </SegmentRequirement>
            </OperationsRequest>"
        ),
    );
    let reading = read(text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    let Document::Schedule(schedule) = reading.document else {
        panic!("{text}");
    };
    let activities: Vec<&Activity> = schedule.requests.iter().map(|r| &r.activity).collect();
    assert_eq!(
        activities,
        [
            &Activity::Operation {
                resource: Some("Resource1".to_owned()),
                call: OperationCall::new("Load", &[], &["f", "f"]),
                segment: "x".to_owned(),
            },
            &Activity::Transfer {
                from: "Resource1".to_owned(),
                to: "R5".to_owned(),
                label: "x".to_owned(),
                part: None,
            },
        ]
    );
    assert_eq!(schedule.requests[0].seconds, Some(68.0));
    assert_eq!(schedule.parts, [Part::new("f", "Fixture")]);
    let notes: Vec<String> = reading
        .notes
        .list
        .iter()
        .map(|n| n.message.clone())
        .collect();
    assert_eq!(
        notes,
        [
            "`Priority` is left out",
            "`SegmentParameter` is left out",
            "`SegmentRequirementChild` is left out"
        ]
    );
    let recipes = schedule.recipes().expect("there are no choices");
    assert_eq!(
        (recipes[0].name.as_str(), recipes[0].leftover.as_slice()),
        ("hinge", ["f".to_owned()].as_slice())
    );
}

#[test]
fn prefixes_comments_and_references_are_read() {
    let text = format!(
        "\u{feff}<?xml version='1.0' encoding='UTF-8' standalone='yes'?><!-- a - b -->\r\n\
         <?target and text?><b:EquipmentInformation xmlns:b='{}' \
         xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' \
         xsi:schemaLocation='{0} B2MML-Equipment.xsd'>\r\n\
         <b:ID schemeName=\"&#x3c;&quot;\">A<!-- c --> &amp;<![CDATA[ <B>]]>&#252;</b:ID >\
         <b:Equipment><b:ID>\n  r\n</b:ID></b:Equipment></b:EquipmentInformation><!---->\n",
        linewright_b2mml::NAMESPACE
    );
    let Document::Layouts(layouts) = read_again(&text) else {
        panic!("{text}");
    };
    let layout = &layouts[0];
    let names = (layout.name.as_str(), layout.resources[0].name.as_str());
    assert_eq!(names, ("A & <B>ü", "r"));
}
