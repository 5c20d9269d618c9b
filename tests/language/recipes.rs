//! Layouts and recipes, from text to the models of the crate `recipe`. Errors are in `cases/`.

use linewright::contract::recipe::{Layout, Recipe};
use linewright::contract::set::{Owner, Setting, Settings};
use linewright::contract::{Library, load, load_with, settable};
use linewright::diagnostics::{Diagnostic, Severity};
use linewright::syntax::ast::Item;
use linewright::syntax::parse;
use linewright_recipe::controller::Controller;
use linewright_recipe::model::Action;
use linewright_recipe::realize::{Outcome, SearchLimits, realize};
use linewright_recipe::topology;

/// A reconstruction of the paper's demonstrator.
const PAD: &str = include_str!("../cases/recipe/pad.lw");

fn read(text: &str) -> (Library, Vec<Diagnostic>) {
    load(&[("a.lw".to_owned(), text.to_owned())], &|name, _| {
        (name == "pad.lw")
            .then(|| (name.to_owned(), PAD.to_owned()))
            .ok_or_else(|| "there is none".to_owned())
    })
}

#[track_caller]
fn sound(text: &str) -> Library {
    let (library, findings) = read(text);
    assert!(findings.is_empty(), "{text}\n{findings:#?}");
    library
}

/// The demonstrator with more statements in its layout.
fn pad_with(statements: &str) -> String {
    PAD.replace(
        "/// Load and unload area",
        &format!("{statements}\n/// Load and unload area"),
    )
}

/// States and transitions of the topology of the first layout.
fn size(library: &Library) -> (usize, usize) {
    let size = topology::size(&library.layouts[0].model, 1 << 20).expect("it is small enough");
    (size.states, size.transitions as usize)
}

fn controller(library: &Library) -> Option<Controller> {
    let (layout, recipe) = (&library.layouts[0].model, &library.recipes[0].model);
    match realize(layout, recipe, SearchLimits::default()) {
        Ok(Outcome::Realizable(controller)) => Some(controller),
        Ok(Outcome::Unrealizable(_)) => None,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_reconstructed_demonstrator_has_the_topology_that_was_measured() {
    let mut statements = String::new();
    for (duplicate, states, transitions) in [
        ("", 288, 1_300),
        ("resource r6 = r3", 1_060, 7_673),
        ("resource r7 = r1", 2_600, 30_284),
    ] {
        statements.push_str(duplicate);
        statements.push('\n');
        assert_eq!(size(&sound(&pad_with(&statements))), (states, transitions));
    }
}

#[test]
fn the_hinge_can_be_made_in_sequence_and_with_a_second_robot_in_parallel() {
    let worst = |text: &str| controller(&sound(text)).map(|c| c.worst_case);
    assert_eq!(worst(PAD), Some(21));
    let parallel = |text: &str| text.replace("glue(p)(p); engrave", "glue(p)(p) || engrave");
    assert_eq!(worst(&parallel(PAD)), None);
    assert_eq!(worst(&pad_with("resource r6 = r3")), Some(20));
    assert_eq!(worst(&parallel(&pad_with("resource r6 = r3"))), Some(21));
}

#[test]
fn what_is_to_be_made_refers_to_declarations() {
    let library = sound("import \"pad.lw\"\n\nrealize 3 Hinge on Pad\n");
    assert_eq!(library.realizations.len(), 2);
    for realization in &library.realizations {
        let layout = library.layout_at(realization.layout_declared);
        assert_eq!(layout.map(|l| l.model.name.as_str()), Some("Pad"));
        let wanted = &realization.recipes[0];
        let recipe = library.recipe_at(wanted.declared).expect("a recipe");
        assert_eq!(
            (recipe.model.name.as_str(), recipe.doc.as_str()),
            ("Hinge", "Reconstruction of the recipe of the hinge.")
        );
        let counts = if library.sources.file(realization.span.file).name == "a.lw" {
            3
        } else {
            1
        };
        assert_eq!(wanted.count, counts);
    }
}

/// Every place is that of the name or the action that it stands for.
#[test]
fn places_are_those_of_the_text() {
    let library = sound(&pad_with("resource r6 = r3\nat start r2 s3 holds 2 Pin"));
    let text = |span| library.sources.text(span);
    let layout: &Layout = &library.layouts[0];
    for (resource, info) in layout.model.resources.iter().zip(&layout.resources) {
        assert_eq!(text(info.name), resource.name);
        assert_eq!(info.states.len(), resource.states.len());
        assert_eq!(info.transitions.len(), resource.transitions.len());
        assert_eq!(info.holds.len(), resource.holds.len());
        if info.is_transport || resource.name == "r6" {
            continue;
        }
        for (state, span) in resource.states.iter().zip(&info.states) {
            assert_eq!(text(*span), state.name);
        }
        for (transition, span) in resource.transitions.iter().zip(&info.transitions) {
            assert_eq!(
                text(*span),
                match &transition.action {
                    Action::Operation(name) | Action::Internal(name) => name.clone(),
                    Action::In(label) => format!("in:{label}"),
                    Action::Out(label) => format!("out:{label}"),
                }
            );
        }
    }
    let recipe: &Recipe = &library.recipes[0];
    for (state, span) in recipe.model.states.iter().zip(&recipe.states) {
        assert_eq!(text(*span), state);
    }
    for (part, span) in recipe.model.parts.iter().zip(&recipe.parts) {
        assert_eq!(text(*span), part.name);
    }
    for (transition, places) in recipe.model.transitions.iter().zip(&recipe.transitions) {
        assert_eq!(
            text(places.span),
            format!("{} -> {}", transition.from, transition.to)
        );
        for (step, places) in transition.steps.iter().zip(&places.steps) {
            for (call, places) in step.operations.iter().zip(places) {
                assert_eq!(text(places.name), call.name);
                let shown = format!(
                    "{}({})({})",
                    call.name,
                    call.inputs.join(", "),
                    call.outputs.join(", ")
                );
                assert_eq!(text(places.span), shown);
                let inputs = places.inputs.iter().map(|s| text(*s));
                assert!(inputs.eq(call.inputs.iter().map(String::as_str)));
            }
        }
    }
}

/// The names of the resources, and the transitions of one as text.
fn transitions(library: &Library, name: &str) -> Vec<String> {
    let layout = &library.layouts[0].model;
    let at = layout
        .resource(name)
        .unwrap_or_else(|| panic!("no {name} in {layout:#?}"));
    let shown = layout.resources[at].transitions.iter().map(|t| {
        let action = match &t.action {
            Action::Operation(name) => name.clone(),
            Action::Internal(name) => format!("internal {name}"),
            Action::In(label) => format!("in:{label}"),
            Action::Out(label) => format!("out:{label}"),
        };
        let time = t.seconds.map(|s| format!(" in {s}")).unwrap_or_default();
        let power = t.watts.map(|w| format!(" power {w}")).unwrap_or_default();
        format!("{} -> {}: {action}{time}{power}", t.from, t.to)
    });
    shown.collect()
}

const ENDS: &str = "
    resource a at s { s -> s: load, out:left, out:right nop s }
    resource b at s { s -> s: in, store nop s }
";

#[test]
fn routes_become_transfers_with_the_labels_of_their_ends() {
    let layout = |statements: &str| sound(&format!("layout Cell {{{ENDS}{statements}\n}}\n"));
    let library = layout("const T = 2 s transport belt { a -> b in T * 3 power 1 kW }");
    assert_eq!(
        transitions(&library, "belt"),
        [
            "empty -> a: in:left",
            "empty -> a: in:right",
            "a -> empty: out:b in 6 power 1000",
        ]
    );
    let library = layout("transport belt holds 2 { a:left -> b } transport other { a:right -> b }");
    assert_eq!(
        transitions(&library, "belt"),
        transitions(&library, "belt#2")
    );
    assert_eq!(
        transitions(&library, "other"),
        ["empty -> a: in:right", "a -> empty: out:b"]
    );
    // From one transport to another.
    let library = layout("transport belt { a -> lift } transport lift { belt -> b }");
    assert_eq!(
        transitions(&library, "belt")[2],
        "a -> empty: out:belt->lift"
    );
    assert_eq!(
        transitions(&library, "lift"),
        ["empty -> belt: in:belt->lift", "belt -> empty: out:b"]
    );
    // A route of its own for a duplicate.
    let library = layout("transport belt { a -> b a2 -> b2 } resource a2 = a resource b2 = b");
    let belt = transitions(&library, "belt");
    for wanted in [
        "empty -> a: in:left",
        "empty -> a@a2: in:left@a2",
        "a@a2 -> empty: out:b@b2",
    ] {
        assert!(
            belt.iter().any(|t| t == wanted),
            "{wanted} is not in {belt:#?}"
        );
    }
}

/// A direct partner of a transfer is not served by a transport.
#[test]
fn a_transfer_with_a_direct_partner_needs_its_label_in_a_route() {
    let direct = "resource c at s { s -> s: in:left, store nop s }";
    let library = sound(&format!(
        "layout Cell {{{ENDS}{direct} transport belt {{ a -> b }}\n}}\n"
    ));
    assert_eq!(transitions(&library, "belt")[0], "empty -> a: in:right");
    let library = sound(&format!(
        "layout Cell {{{ENDS}{direct} transport belt {{ a:left, a:right -> b }}\n}}\n"
    ));
    assert_eq!(transitions(&library, "belt").len(), 3);
}

#[test]
fn work_can_be_there_at_the_start() {
    let library = sound(&format!(
        "layout Cell {{{ENDS} transport belt {{ a -> b }} resource a2 = a
         at start b s holds Pin
         at start belt a2 holds p }}\n"
    ));
    let resources = &library.layouts[0].model.resources;
    let find = |name: &str| {
        resources
            .iter()
            .find(|r| r.name == name)
            .expect("a resource")
    };
    assert_eq!(find("b").holds, ["Pin"]);
    assert_eq!(
        (find("belt").initial.as_str(), find("belt").holds.join(" ")),
        ("a@a2", "p".to_owned())
    );
}

/// The demonstrator with numbers of its layout set from outside.
fn set(list: &[&str]) -> (Library, Vec<Diagnostic>) {
    let list: Vec<Setting> = (list.iter())
        .map(|text| text.parse().expect("a setting"))
        .collect();
    let settings = Settings {
        of: Owner::Layout,
        name: None,
        list: &list,
    };
    let text = pad_with(
        "const CYCLE = 3 s\nresource rack at s holds 5 { s -> s: sort nop s }\nat start rack s holds 2 Pin",
    );
    let files = [("a.lw".to_owned(), text)];
    load_with(&files, &|_, _| Err("there is none".to_owned()), settings)
}

#[test]
fn numbers_of_a_layout_can_be_set() {
    let (plain, findings) = set(&[]);
    assert_eq!(findings, []);
    let text = plain.sources.files().next().expect("the file").1;
    let text = text.text.to_string();
    let files = [("a.lw".to_owned(), text)];
    let numbers = settable(
        &files,
        &|_, _| Err("there is none".to_owned()),
        Owner::Layout,
        Some("Pad"),
    );
    let names: Vec<&str> = (numbers.iter())
        .filter_map(|n| n.names.first())
        .map(String::as_str)
        .collect();
    for name in [
        "CYCLE",
        "r3.holds",
        "r3.s1.s2.glue.time",
        "r1.load.power",
        "r5.r1.r2.time",
        "rack.Pin",
    ] {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
    // A number set to itself changes nothing, under its shortest and its full name.
    for which in [<[String]>::first, <[String]>::last] {
        let own: Vec<String> = (numbers.iter())
            .filter_map(|n| Some(format!("{}={}", which(&n.names)?, n.value.as_ref()?)))
            .collect();
        let own: Vec<&str> = own.iter().map(String::as_str).collect();
        let (same, findings) = set(&own);
        assert_eq!(findings, []);
        assert_eq!(same.layouts[0].model, plain.layouts[0].model);
    }
    let (changed, findings) = set(&[
        "rack.Pin=4",
        "rack.holds=4",
        "r5.r1.r2.time=2 min",
        "r1.load.time=CYCLE * 2",
        "r1.load.power=1 kW",
        "CYCLE=5 s",
    ]);
    assert_eq!(findings, []);
    let rack = changed.layouts[0].model.resource("rack").expect("a rack");
    let rack = &changed.layouts[0].model.resources[rack];
    assert_eq!((rack.capacity, rack.holds.len()), (4, 4));
    assert!(transitions(&changed, "r5").contains(&"r1 -> empty: out:2 in 120".to_owned()));
    assert!(
        transitions(&changed, "r1").contains(&"s0 -> s1: load in 10 power 1000".to_owned()),
        "{:?}",
        transitions(&changed, "r1")
    );
}

#[test]
fn wrong_settings_of_a_layout_are_reported() {
    for (setting, code, message) in [
        (
            "r9.holds=2",
            "LW101",
            "`Pad` has no resource, transport or constant `r9`",
        ),
        (
            "r1.hold=2",
            "LW101",
            "`r1` has no number `r1.hold` that can be set",
        ),
        (
            "rack.holds=0",
            "LW105",
            "0 parts are not a possible capacity",
        ),
        (
            "rack.holds=1",
            "LW603",
            "`rack` has room for 1, but would hold 2 at the start",
        ),
        ("r1.load.time=2 W", "LW103", ""),
    ] {
        let (_, findings) = set(&[setting]);
        let found: Vec<_> = findings
            .iter()
            .map(|f| (f.code.id, f.message.as_str()))
            .collect();
        assert!(
            found
                .iter()
                .any(|(id, text)| *id == code && text.starts_with(message)),
            "{setting}: {found:?}"
        );
    }
}

/// Only `in` and `out` are no names of operations; everything else may be one, or a state.
#[test]
fn words_are_names_where_their_place_does_not_need_them() {
    let words = "layout recipe realize resource transport holds nop internl at start end part leftover otherwise when on power a G";
    for word in words.split(' ') {
        let text = format!(
            "layout {word} {{
    resource {word}: {word} at {word} {{
        {word} -> {word}: {word}, internal {word}
        nop {word}
    }}
    resource other = {word}
    transport belt {{}}
    at start {word} {word} holds {word}
}}

recipe R{word} {{
    part {word}: {word}
    start {word}
    {word} -> end when {word}({word}) at {word}: {word}({word})({word}) || {word}()()
    {word} -> end otherwise
    end end
    leftover {word}, {word}
}}

realize {word} on {word}
"
        );
        let (file, findings) = parse(linewright::source::FileId::default(), &text);
        assert!(findings.is_empty(), "{word}: {findings:#?}");
        assert!(matches!(
            file.items.as_slice(),
            [Item::Layout(_), Item::Recipe(_), Item::Realize(_)]
        ));
        let printed = linewright::syntax::format::format_checked(&file, &text);
        assert_eq!(printed.as_deref(), Ok(text.as_str()), "{word}");
    }
    // A record after the name does not make it a declaration.
    for (word, lasts) in [("layout", "in {a = b}"), ("recipe", "power {a = b}")] {
        let text = format!(
            "layout A {{\n    resource r at s {{\n        s -> s: a,\n            {word} {lasts}\n    }}\n}}\n"
        );
        assert_eq!(
            parse(linewright::source::FileId::default(), &text).1,
            [],
            "{text}"
        );
    }
    // Elsewhere they are names of anything.
    let text = "const layout = 3\nconst recipe = layout\ndefine realize(x) = recipe\n\nlayout A { resource r at s { s -> s: a nop s } }\n";
    assert_eq!(parse(linewright::source::FileId::default(), text).1, []);
}

#[test]
fn a_finding_in_a_recipe_does_not_hide_others() {
    let (library, findings) = read(
        &PAD.replacen("h2)(h2)\n    b", "h3)(h2)\n    b", 1)
            .replace("end d, e", "end d, f"),
    );
    let errors: Vec<_> = findings
        .iter()
        .filter(|f| f.severity == Severity::Error)
        .collect();
    assert_eq!(errors.len(), 3, "{errors:#?}");
    assert_eq!((library.layouts.len(), library.recipes.len()), (1, 0));
    assert_eq!(library.refused_recipes[0].0, "Hinge");
    assert!(library.realizations.is_empty());
}
