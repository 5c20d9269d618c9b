//! Skills and their orders, from text to the input of automata. Errors are in `cases/`, the layout
//! in `format/`.

use crate::support;
use linewright::automata::regex::Regex;
use linewright::contract::machine::Machine;
use linewright::contract::{Library, load};
use linewright::diagnostics::{Diagnostic, has_errors};
use linewright::order::{Deletion, Event, Kind, Level, Rule, Skills};
use std::fmt::Write as _;
use std::sync::Arc;

const UNIT: &str = "
    /// Moves along the trays.
    component x: {left, right} = right {
        Left -> left, Right -> right
    }
    component z: {up, down} = up {
        /// Above the trays.
        Up -> up
        Down -> down
    }
    component gripper: {open, closed} = open { Grip -> closed; Release -> open }
    component camera { Inspect }
";

fn read(text: &str) -> (Library, Vec<Diagnostic>) {
    load(
        &[("a.lw".to_owned(), text.to_owned())],
        &|name, _| match name {
            "unit.lw" => Ok((
                "unit.lw".to_owned(),
                format!("/// A unit.\nskills Unit {{{UNIT}}}"),
            )),
            _ => Err("there is none".to_owned()),
        },
    )
}

#[track_caller]
fn sound(text: &str) -> Library {
    let (library, findings) = read(text);
    let errors: Vec<_> = findings
        .iter()
        .filter(|f| has_errors(std::slice::from_ref(*f)))
        .collect();
    assert!(errors.is_empty(), "{text}\n{errors:#?}");
    library
}

/// The set with this order added.
#[track_caller]
fn with(orders: &str) -> Arc<Skills> {
    let library = sound(&format!(
        "/// A unit.\nskills Unit {{{UNIT}\n    {orders}\n}}\n"
    ));
    Arc::clone(&library.skills[0])
}

#[track_caller]
fn rule(order: &str) -> Rule {
    let set = with(order);
    assert_eq!(set.rules.len(), 1);
    set.rules[0].clone()
}

const LEFT: usize = 0;
const RIGHT: usize = 1;
const UP: usize = 2;
const DOWN: usize = 3;
const GRIP: usize = 4;
const RELEASE: usize = 5;

fn one(skill: usize) -> Vec<Event> {
    vec![Event(vec![skill])]
}

#[test]
fn components_have_their_situations_and_skills() {
    let set = with("");
    assert_eq!((set.name.as_str(), set.doc.as_str()), ("Unit", "A unit."));
    let components: Vec<_> = set
        .components
        .iter()
        .map(|c| (c.name.as_str(), c.situations.join(" "), c.initial))
        .collect();
    let wanted = [
        ("x", "left right", 1),
        ("z", "up down", 0),
        ("gripper", "open closed", 0),
        ("camera", "", 0),
    ];
    assert_eq!(components, wanted.map(|(n, s, i)| (n, s.to_owned(), i)));
    assert_eq!(set.components[0].doc, "Moves along the trays.");
    let skills: Vec<_> = set
        .skills
        .iter()
        .map(|s| (s.name.as_str(), s.component, s.effect))
        .collect();
    let wanted = [
        ("Left", 0, Some(0)),
        ("Right", 0, Some(1)),
        ("Up", 1, Some(0)),
        ("Down", 1, Some(1)),
        ("Grip", 2, Some(1)),
        ("Release", 2, Some(0)),
        ("Inspect", 3, None),
    ];
    assert_eq!(skills, wanted);
    assert_eq!(set.skills[UP].doc, "Above the trays.");
}

#[test]
fn every_form_of_an_order_is_what_it_says() {
    for (text, kind) in [
        ("never Left", Kind::Never(one(LEFT))),
        (
            // In ascending order, however they were written.
            "never Down & Left, Grip",
            Kind::Never(vec![Event(vec![LEFT, DOWN]), Event(vec![GRIP])]),
        ),
        (
            "after Down until Up: never Left, Right",
            Kind::After {
                from: one(DOWN),
                until: one(UP),
                never: vec![Event(vec![LEFT]), Event(vec![RIGHT])],
            },
        ),
        (
            "after Down: never Left",
            Kind::After {
                from: one(DOWN),
                until: Vec::new(),
                never: one(LEFT),
            },
        ),
        (
            "Left before Down",
            Kind::Before {
                first: one(LEFT),
                then: one(DOWN),
            },
        ),
        (
            "Release only after Grip",
            Kind::OnlyAfter {
                what: one(RELEASE),
                after: one(GRIP),
            },
        ),
        (
            "at most 2 of Grip between Down and Up",
            Kind::AtMost {
                count: 2,
                of: one(GRIP),
                from: one(DOWN),
                until: one(UP),
            },
        ),
        (
            "at most 0 of Grip",
            Kind::AtMost {
                count: 0,
                of: one(GRIP),
                from: Vec::new(),
                until: Vec::new(),
            },
        ),
        (
            "never Grip, Release twice in a row",
            Kind::InARow(vec![
                vec![one(GRIP), one(GRIP)],
                vec![one(RELEASE), one(RELEASE)],
            ]),
        ),
        (
            "never Left then Up, Down then Right",
            Kind::InARow(vec![vec![
                one(LEFT),
                vec![Event(vec![UP]), Event(vec![DOWN])],
                one(RIGHT),
            ]]),
        ),
    ] {
        let rule = rule(&format!("order: {text}"));
        assert_eq!(rule.kind, kind, "{text}");
        assert_eq!(rule.text, text);
    }
}

#[test]
fn regular_expressions_are_what_they_say() {
    use Regex::{AnyBut, AnyOrder, Concat, Either, Empty, Letter, Repeat};
    let repeat = |of: Regex, low: u32, high: Option<u32>| Repeat {
        of: Box::new(of),
        low,
        high,
    };
    for (text, regex) in [
        ("()", Empty),
        ("(Left)", Letter(LEFT)),
        ("((Left))*", repeat(Letter(LEFT), 0, None)),
        ("(Left+)", repeat(Letter(LEFT), 1, None)),
        ("(Left)?", repeat(Letter(LEFT), 0, Some(1))),
        ("(Left{3})", repeat(Letter(LEFT), 3, Some(3))),
        ("(Left{3,})", repeat(Letter(LEFT), 3, None)),
        ("(Left{2,1000})", repeat(Letter(LEFT), 2, Some(1000))),
        ("(Left Right)", Concat(vec![Letter(LEFT), Letter(RIGHT)])),
        ("(Left, Right)", Concat(vec![Letter(LEFT), Letter(RIGHT)])),
        (
            "(Left Right | Up)",
            Either(vec![Concat(vec![Letter(LEFT), Letter(RIGHT)]), Letter(UP)]),
        ),
        (
            "(Left (Right | Up))",
            Concat(vec![Letter(LEFT), Either(vec![Letter(RIGHT), Letter(UP)])]),
        ),
        ("(.*)", repeat(AnyBut(Vec::new()), 0, None)),
        ("(not Up)", AnyBut(vec![UP])),
        ("(not Up*)", repeat(AnyBut(vec![UP]), 0, None)),
        ("(not (Up | Left | Up))", AnyBut(vec![LEFT, UP])),
        ("(Grip & Left)", AnyOrder(vec![LEFT, GRIP])),
        (
            "(Grip & Left Up)",
            Concat(vec![AnyOrder(vec![LEFT, GRIP]), Letter(UP)]),
        ),
    ] {
        let rule = rule(&format!("order: sequence {text}"));
        assert_eq!(rule.kind, Kind::Sequence(regex), "{text}");
    }
}

#[test]
fn an_order_has_a_name_a_requirement_a_level_and_a_text() {
    let set = with(
        "/// Never there.
    order trays [R-7]: after Down /* b */ until
        Up: never Left // c
        deletes down & left -> right, x.right & z.down -> left // d
    order at reasonable: never Left
    order [R-8] at valid: never Left
    order at at reasonable: never Left
    /// The order itself.
    order: never Left",
    );
    let heads: Vec<_> = set
        .rules
        .iter()
        .map(|r| (r.name.as_str(), r.requirement.as_deref(), r.level))
        .collect();
    let (valid, reasonable) = (Level::Valid, Level::Reasonable);
    let wanted = [
        ("trays", Some("R-7"), valid),
        ("order 2", None, reasonable),
        ("order 3", Some("R-8"), valid),
        ("at", None, reasonable),
        ("order 5", None, valid),
    ];
    assert_eq!(heads, wanted);
    let trays = &set.rules[0];
    assert_eq!(trays.doc, "Never there.");
    assert_eq!(trays.text, "after Down until Up: never Left");
    let deletion = |from: [(usize, usize); 2], to: (usize, usize)| Deletion {
        from: from.to_vec(),
        to: vec![to],
    };
    let wanted = [
        deletion([(0, 0), (1, 1)], (0, 1)),
        deletion([(0, 1), (1, 1)], (0, 0)),
    ];
    assert_eq!(trays.deletions, wanted);
    let library = sound(&format!(
        "skills Unit {{{UNIT}\norder o: never Left // d\n}}"
    ));
    let rule = &library.skills[0].rules[0];
    assert_eq!(library.sources.text(rule.span), "order o: never Left");
}

/// The words of skills are no words of the language: they remain valid names elsewhere.
#[test]
fn words_of_skills_are_names_everywhere() {
    let words = [
        "skills",
        "component",
        "order",
        "sequence",
        "deletes",
        "at",
        "most",
        "of",
        "only",
        "twice",
        "row",
        "a",
        "between",
    ];
    let mut text = "contract C {\n".to_owned();
    for word in words {
        let _ = writeln!(
            text,
            "    input {word}: bool\n    guarantee {word}: always {word}_ = {word}\n    output {word}_: bool"
        );
    }
    text += "}\nmachine skills {\n    signal skills: bool = true\n    signal order: bool = true\n    action component: C {\n";
    for word in words {
        let _ = writeln!(text, "        {word} = skills\n");
    }
    text += "    }\n    guarantee order: always (order or\n        skills)\n}\n";
    text += "define order(skills) = skills\ntype component = {skills_, at}\n";
    let (library, findings) = read(&text);
    assert!(!has_errors(&findings), "{findings:#?}");
    assert_eq!((library.contracts.len(), library.machines.len()), (1, 1));
    // And among skills their own words, and those of temporal operators.
    sound(
        "skills component {
        component order: {after, X} = X { at -> after, G -> X }
        component skills: {U} = U { until -> U, order -> U, sequence -> U }
        order after: after at, order until until: never G
        order sequence: sequence before order
        order at: at most 3 of at between at and until
    }",
    );
}

fn shown(machine: &Machine, of: usize) -> Vec<String> {
    let orders = &machine.orders[of];
    let mut wires: Vec<String> = Vec::new();
    for when in &orders.when {
        let mut names = Vec::new();
        when.for_each_var(&mut |v, _| names.push(machine.wire_name(v.index())));
        wires.push(names.join(" "));
    }
    wires
}

const MACHINES: &str = "
contract Arm {
    output move: {none, left, right}
    output grip: bool
    guarantee g: always (move = none and not grip)
}
skills Gripping {
    component gripper: {open, closed} = open { Grip -> closed, Release -> open }
}
skills Moving {
    component x: {left, right} = left { Left -> left, Right -> right }
}
machine Unit {
    signal ready: bool = true
    action arm: Arm
    action other: Arm
    skills Moving {
        Left = other.move = left
        Right = ready and other.move = right
    }
}
machine Cell {
    action first: Arm
    machine left: Unit
    skills Gripping at reasonable { Release = false; Grip = first.grip or left.other.grip }
    signal ready: bool = false
}
machine Hall {
    machine cell: Cell
    signal ready: bool = true
}
";

#[test]
fn inner_machines_keep_their_orders() {
    let library = sound(MACHINES);
    let [unit, cell, hall] = library.machines.as_slice() else {
        panic!("three machines");
    };
    let moving = library.skills.iter().find(|s| s.name == "Moving");
    assert!(Arc::ptr_eq(&unit.orders[0].skills, moving.expect("a set")));
    assert_eq!(shown(unit, 0), ["other.move", "ready other.move"]);
    let heads = |machine: &Machine| -> Vec<(String, String, Level)> {
        let heads = machine.orders.iter();
        heads
            .map(|o| (o.caller.clone(), o.skills.name.clone(), o.level))
            .collect()
    };
    let head = |of: &str, set: &str, level| (of.to_owned(), set.to_owned(), level);
    let (valid, reasonable) = (Level::Valid, Level::Reasonable);
    let wanted = [
        head("", "Gripping", reasonable),
        head("left", "Moving", valid),
    ];
    assert_eq!(heads(cell), wanted);
    // In the order of the skills, and over the flat machine's wires.
    assert_eq!(shown(cell, 0), ["first.grip left.other.grip", ""]);
    assert_eq!(shown(cell, 1), ["left.other.move", "ready left.other.move"]);
    let wanted = [
        head("cell", "Gripping", reasonable),
        head("cell.left", "Moving", valid),
    ];
    assert_eq!(heads(hall), wanted);
    let wanted = ["cell.left.other.move", "ready cell.left.other.move"];
    assert_eq!(shown(hall, 1), wanted);
    // Nothing is abstracted if no inner machine refines a contract.
    assert_eq!(heads(hall.abstraction()), heads(hall));
}

/// An inner machine represented by a contract is proved by itself, with its orders.
#[test]
fn orders_of_a_promise_stay_with_the_machine_that_makes_it() {
    let text = MACHINES.replace(
        "    skills Moving {",
        "    refines Arm { move = arm.move grip = arm.grip }\n    skills Moving {",
    );
    let text = text.replace("left.other.grip", "left.grip");
    let library = sound(&text);
    let cell = &library.machines[1];
    assert_eq!(cell.orders.len(), 2);
    assert_eq!(cell.abstraction().orders.len(), 1);
    assert_eq!(cell.layers.inner[0].machine.orders.len(), 1);
    let abstracted = cell.abstraction();
    assert_eq!(shown(abstracted, 0), ["first.grip left.grip", ""]);
}

#[test]
fn sets_are_imported() {
    let library = sound(
        "import \"unit.lw\"
contract Arm {
    output a: bool
    guarantee g: always a
}
machine M {
    action arm: Arm
    skills Unit { Left = arm.a Right = false Up = false Down = false Grip = false Release = false Inspect = arm.a }
}",
    );
    assert_eq!(library.skills.len(), 1);
    let orders = &library.machines[0].orders;
    assert!(Arc::ptr_eq(&orders[0].skills, &library.skills[0]));
}

#[test]
fn a_set_that_cannot_be_used_is_reported() {
    let (library, findings) =
        read("skills A { component c { B } order: never C }\nskills D { component c { B } }");
    assert!(has_errors(&findings));
    let names: Vec<&str> = library
        .refused_skills
        .iter()
        .map(|(n, _)| n.as_str())
        .collect();
    assert_eq!(names, ["A"]);
    assert_eq!(library.skills[0].name, "D");
}

/// Even many orders are not nested.
#[test]
fn many_orders_are_not_deep() {
    let orders = "order: sequence (X Left)*\n order: never X\n order: at most 2 of G\n".repeat(200);
    let set = format!(
        "skills S {{ component c {{ X Left G }}\n{orders} order: sequence {}X{} }}",
        "(".repeat(150),
        ")*".repeat(150)
    );
    let library = sound(&set);
    assert_eq!(library.skills[0].rules.len(), 601);
}

/// An error in a set affects the machines that call its skills, and nothing else in the file.
#[test]
fn check_lists_a_set_and_blames_nobody_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let check = |text: &str| {
        std::fs::write(folder.path().join("a.lw"), text).expect("a file");
        let output = support::linewright(
            folder.path(),
            &["check", "a.lw", "--format", "json", "--no-timing"],
        );
        let document: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("a document");
        (output.status.code(), document)
    };
    let set = format!("skills Unit {{{UNIT}}}\n");
    let (code, document) = check(&set);
    assert_eq!(
        (code, &document["contracts"]),
        (Some(0), &serde_json::json!([]))
    );
    assert_eq!(document["summary"]["findings"], 0);
    assert_eq!(document["skills"][0]["verdict"], "consistent");

    let wrong = set
        .replace("}}}", "}")
        .replace("Left -> left", "Left -> lft");
    let contract = "contract Arm {\n    output a: bool\n    guarantee g: always a\n}\n";
    let calls = "Left = arm.a Right = false Up = false Down = false Grip = false Release = false Inspect = false";
    let machine = format!("machine M {{\n    action arm: Arm\n    skills Unit {{ {calls} }}\n}}\n");
    let (code, document) = check(&format!("{contract}{wrong}{machine}"));
    assert_eq!(code, Some(1));
    assert_eq!(document["contracts"][0]["verdict"], "realizable");
    assert_eq!(document["machines"][0]["verdict"], "invalid");
    assert_eq!(document["skills"][0]["verdict"], "invalid");
    let findings = &document["skills"][0]["findings"];
    assert_eq!(findings[0]["code"], "LW101");
    assert_eq!(findings.as_array().map(Vec::len), Some(1));
    assert_eq!(document["findings"], serde_json::json!([]));
}
