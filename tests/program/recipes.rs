//! Recipes on layouts on the command line, on `examples/pad`: what `check` decides, and the
//! commands of `recipe`.

use crate::support::{linewright, sandbox};
use serde_json::Value;
use std::path::Path;

/// Runs the program in a folder with the examples. Returns the exit code and the document.
pub(super) fn document(folder: &Path, line: &str) -> (i32, Value) {
    let mut arguments: Vec<&str> = line.split_whitespace().collect();
    arguments.extend(["--format", "json"]);
    let output = linewright(folder, &arguments);
    let text = String::from_utf8_lossy(&output.stdout);
    let document = serde_json::from_str(&text).unwrap_or_else(|e| {
        panic!(
            "{line}: {e}: {text}{}",
            String::from_utf8_lossy(&output.stderr)
        )
    });
    (output.status.code().expect("an exit code"), document)
}

/// Runs the program. Returns the exit code and standard output.
pub(super) fn text(folder: &Path, line: &str) -> (i32, String) {
    let arguments: Vec<&str> = line.split_whitespace().collect();
    let output = linewright(folder, &arguments);
    let code = output.status.code().expect("an exit code");
    (code, String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Name, verdict and worst case of each statement `realize` of a check.
fn verdicts(document: &Value) -> Vec<(String, String, Option<u64>)> {
    let entries = document["realizations"].as_array().expect("realizations");
    let of = |entry: &Value, field: &str| entry[field].as_str().expect("a text").to_owned();
    let entry = |e: &Value| (of(e, "name"), of(e, "verdict"), e["worst_case"].as_u64());
    entries.iter().map(entry).collect()
}

/// Code, line and text at the place of each finding of a statement.
fn found(folder: &Path, entry: &Value) -> Vec<(String, u64, String)> {
    let findings = entry["findings"].as_array().expect("findings");
    let place = |finding: &Value| {
        let span = &finding["span"];
        let file = span["file"].as_str().expect("a file");
        let source = std::fs::read_to_string(folder.join(file)).expect("a file");
        let number = |field: &str| span[field].as_u64().expect("a number");
        let line = number("line");
        let written = source.lines().nth(line as usize - 1).expect("a line");
        let (from, to) = (
            number("column") as usize - 1,
            number("end_column") as usize - 1,
        );
        let code = finding["code"].as_str().expect("a code").to_owned();
        (code, line, written[from..to].to_owned())
    };
    findings.iter().map(place).collect()
}

#[test]
fn check_decides_each_statement_of_the_demonstrator() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let (code, checked) = document(folder, "check examples/pad/hinge.lw");
    assert_eq!(code, 0);
    let made = |name: &str, steps| (name.to_owned(), "realizable".to_owned(), Some(steps));
    assert_eq!(verdicts(&checked), [made("Hinge on Pad", 21)]);
    assert_eq!(checked["realizations"][0]["is_least"], true);
    assert_eq!(checked["layouts"][0]["resources"], 5);
    assert_eq!(checked["recipes"][0]["transitions"], 5);
    let (code, checked) = document(folder, "check examples/pad/parallel.lw");
    assert_eq!(code, 1);
    let not = (
        "FastHinge on Pad".to_owned(),
        "unrealizable".to_owned(),
        None,
    );
    let all = verdicts(&checked);
    for wanted in [
        not,
        made("FastHinge on Six", 21),
        made("Hinge on Six", 20),
        made("Hinge on Pad", 21),
    ] {
        assert!(all.contains(&wanted), "{wanted:?} is not in {all:?}");
    }
    let (code, short) = text(folder, "check examples/pad/hinge.lw --format short");
    assert_eq!(code, 0);
    let row = "examples/pad/hinge.lw: realize Hinge on Pad: realizable";
    assert!(short.lines().any(|line| line == row), "{short}");
}

#[test]
fn findings_stand_at_the_operation_that_is_the_cause() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let of = |checked: &Value, name: &str| {
        let entries = checked["realizations"].as_array().expect("realizations");
        let entry = entries.iter().find(|e| e["name"] == name);
        found(
            folder,
            entry.unwrap_or_else(|| panic!("no {name} in {checked}")),
        )
    };
    let (_, checked) = document(folder, "check examples/pad/parallel.lw");
    assert_eq!(
        of(&checked, "FastHinge on Pad"),
        [(
            "LW611".to_owned(),
            10,
            "glue(p)(p) || engrave(h)(h)".to_owned()
        )]
    );
    let (code, checked) = document(folder, "check examples/pad/missing-route.lw");
    assert_eq!(code, 1);
    let found = of(&checked, "Hinge on Cut");
    let codes: Vec<_> = found.iter().map(|(code, _, at)| (&**code, &**at)).collect();
    assert_eq!(codes, [("LW609", "p"), ("LW609", "h")]);
}

/// The same question about edited files: a cause of each kind, and none.
#[test]
fn each_cause_has_its_code() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let hinge = std::fs::read_to_string(folder.join("examples/pad/hinge.lw")).expect("a file");
    for (from, to, codes) in [
        ("s1 -> s2: vision", "s1 -> s2: inspect", vec!["LW607"]),
        ("load()(f); separate", "separate", vec!["LW608"]),
        ("r2 -> r3, r4", "r2 -> r3", vec!["LW609"]),
        (
            "AssemblyRobot at s0 holds 2",
            "AssemblyRobot at s0",
            vec!["LW610", "LW610"],
        ),
        ("GlueRobot at s0 holds 2", "GlueRobot at s0", vec!["LW610"]),
        ("insert(p, h)(h2)", "insert(p, h)(h2, p)", vec!["LW613"]),
        ("", "", vec![]),
    ] {
        assert!(hinge.contains(from), "{from}");
        let edited = hinge.replacen(from, to, 1);
        std::fs::write(folder.join("edited.lw"), edited).expect("a file");
        let (code, checked) = document(folder, "check edited.lw");
        let entry = &checked["realizations"][0];
        let findings = entry["findings"].as_array().expect("findings");
        let found: Vec<&str> = findings.iter().filter_map(|f| f["code"].as_str()).collect();
        assert_eq!(found, codes, "{from}: {entry:#}");
        assert_eq!(code, i32::from(!codes.is_empty()), "{from}");
    }
}

#[test]
fn several_products_are_not_decided() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let text = "import \"examples/pad/hinge.lw\"\n\nrealize 2 Hinge on Pad\n";
    std::fs::write(folder.join("two.lw"), text).expect("a file");
    let (code, checked) = document(folder, "check two.lw");
    assert_eq!(code, 3);
    let all = verdicts(&checked);
    assert!(all.contains(&("2 Hinge on Pad".to_owned(), "gave_up".to_owned(), None)));
}

/// Follows a plan: states, and which parts a resource holds, change as the moves say.
#[test]
fn a_plan_can_be_followed() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let (code, planned) = document(folder, "recipe plan examples/pad/hinge.lw");
    assert_eq!(code, 0);
    let plan = &planned["plans"][0]["plan"];
    assert_eq!(
        (&plan["worst_case"], &plan["verified"]),
        (&21.into(), &true.into())
    );
    let resources = plan["resources"].as_array().expect("resources");
    let positions = plan["positions"].as_array().expect("positions");
    assert!(positions.len() >= 5);
    let mut lengths = Vec::new();
    for position in positions {
        for leg in position["legs"].as_array().expect("legs") {
            let mut states = position["resource_states"]
                .as_array()
                .expect("states")
                .clone();
            let mut parts = position["parts"].as_array().expect("parts").clone();
            let vectors = leg["vectors"].as_array().expect("vectors");
            lengths.push(vectors.len());
            for vector in vectors {
                for m in vector.as_array().expect("moves") {
                    let at = resources.iter().position(|r| *r == m["resource"]);
                    let at = at.expect("a resource");
                    assert_eq!(states[at], m["from"]);
                    states[at] = m["to"].clone();
                    let held = parts[at].as_array_mut().expect("parts");
                    let action = m["action"].as_str().expect("an action");
                    if let Some(operation) = m["operation"].as_str() {
                        let (_, lists) = operation.split_once('(').expect("a bracket");
                        let (needed, made) = lists.split_once(")(").expect("two lists");
                        for name in needed.split(", ").filter(|n| !n.is_empty()) {
                            let found = held.iter().position(|p| p == name);
                            held.remove(found.expect("the part is held"));
                        }
                        let made = made.trim_end_matches(')').split(", ");
                        held.extend(made.filter(|n| !n.is_empty()).map(Value::from));
                    } else if action.starts_with("out:") {
                        let found = held.iter().position(|p| *p == m["part"]);
                        held.remove(found.expect("the part is held"));
                    } else {
                        assert!(action.starts_with("in:"), "{action}");
                        held.push(m["part"].clone());
                    }
                }
            }
            let to = &positions[leg["to"].as_u64().expect("a number") as usize];
            assert_eq!(to["resource_states"].as_array(), Some(&states));
            let mut wanted = to["parts"].as_array().expect("parts").clone();
            for (one, other) in parts.iter_mut().zip(&mut wanted) {
                for list in [one, other] {
                    let list = list.as_array_mut().expect("parts");
                    list.sort_by_key(ToString::to_string);
                }
            }
            assert_eq!(parts, wanted);
        }
    }
    // To the vision test, then to the ends.
    assert_eq!(lengths[0], 17);
}

#[test]
fn a_plan_uses_the_numbers_that_are_set() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let plan = "recipe plan examples/pad/hinge.lw";
    let (code, out) = text(folder, plan);
    assert_eq!(code, 0);
    let head = "Hinge on Pad: 21 steps in the worst case, the least possible";
    assert_eq!(out.lines().next(), Some(head));
    assert!(
        out.contains("r3: glue(p)(p)") && out.contains("r1 => r5: f"),
        "{out}"
    );
    let (code, out) = text(folder, &format!("{plan} --set r3.holds=1"));
    assert_eq!(code, 1);
    assert!(
        out.contains("LW610") && out.contains("Hinge on Pad: cannot be made"),
        "{out}"
    );
    let (code, _) = text(folder, &format!("{plan} --set r9.holds=1"));
    assert_eq!(code, 1);
    let (code, _) = text(
        folder,
        "recipe plan examples/pad/parallel.lw --set r3.holds=1",
    );
    assert_eq!(code, 2, "two layouts");
}

#[test]
fn the_topology_has_the_size_that_was_measured() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let size = |layout: &str| {
        let (code, document) = document(folder, &format!("recipe topology {layout}"));
        assert_eq!(code, 0, "{document}");
        let layout = &document["layouts"][0];
        ["resources", "states", "transitions"].map(|field| layout[field].as_u64())
    };
    assert_eq!(size("examples/pad/hinge.lw"), [5, 288, 1_300].map(Some));
    assert_eq!(
        size("examples/pad/six.lw::Six"),
        [6, 1_060, 7_673].map(Some)
    );
    let (code, _) = document(
        folder,
        "recipe topology examples/pad/hinge.lw --max-states 100",
    );
    assert_eq!(code, 3);
    let (code, dot) = text(folder, "recipe topology examples/pad/hinge.lw --emit dot");
    assert_eq!(code, 0);
    assert!(
        dot.starts_with("digraph") && dot.contains("separate"),
        "{dot}"
    );
    let (code, svg) = text(folder, "recipe topology examples/pad/hinge.lw --emit svg");
    assert_eq!(code, 0);
    assert!(svg.starts_with("<svg"), "{svg}");
}

/// The largest layout, in a release build: `cargo test --release --test program recipes:: --
/// --ignored`.
#[test]
#[ignore = "takes seconds without optimization"]
fn the_topology_of_ten_resources_has_the_size_that_the_paper_says() {
    let sandbox = sandbox();
    let (_, document) = document(sandbox.path(), "recipe topology examples/pad/ten.lw");
    let layout = &document["layouts"][0];
    assert_eq!(
        ["resources", "states", "transitions"].map(|field| layout[field].as_u64()),
        [10, 84_288, 2_354_562].map(Some)
    );
}

#[test]
fn two_layouts_are_compared() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let (code, document) = document(folder, "recipe diff examples/pad/parallel.lw Pad Six");
    assert_eq!(code, 0, "the second is better");
    let recipes = document["recipes"].as_array().expect("recipes");
    let change = |name: &str| {
        let recipe = recipes
            .iter()
            .find(|r| r["name"] == name)
            .expect("a recipe");
        let steps = ["first", "second"].map(|field| recipe[field].as_u64());
        (recipe["change"].as_str().expect("a word").to_owned(), steps)
    };
    assert_eq!(
        change("Hinge"),
        ("shorter".to_owned(), [Some(21), Some(20)])
    );
    assert_eq!(change("FastHinge"), ("gained".to_owned(), [None, Some(21)]));
    let (code, same) = text(folder, "recipe diff examples/pad/hinge.lw Pad Pad");
    assert_eq!(code, 0);
    assert!(same.contains("the same"), "{same}");
    let (code, worse) = text(folder, "recipe diff examples/pad/six.lw Six Pad");
    assert_eq!(code, 1);
    assert!(worse.contains("longer"), "{worse}");
    assert_eq!(
        text(folder, "recipe diff examples/pad/hinge.lw Pad Pat").0,
        2
    );
}

#[test]
fn repairs_are_listed_in_words_of_the_language() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let repairs = |line: &str| {
        let (code, document) = document(folder, &format!("recipe repair {line}"));
        let entry = &document["realizations"][0];
        let sets = entry["repairs"].as_array().expect("repairs");
        let text = |set: &Value| {
            let changes = set.as_array().expect("changes").iter();
            let changes: Vec<&str> = changes.filter_map(|c| c["text"].as_str()).collect();
            changes.join("; ")
        };
        let outcome = entry["outcome"].as_str().expect("a word").to_owned();
        (code, outcome, sets.iter().map(text).collect::<Vec<_>>())
    };
    let (code, outcome, sets) = repairs("examples/pad/missing-route.lw --only routes");
    assert_eq!((code, outcome.as_str()), (0, "repaired"));
    assert_eq!(sets, ["r5: s3 -> s0: out:2"]);
    let (code, outcome, sets) = repairs("examples/pad/parallel.lw::Pad --only duplicates");
    assert_eq!((code, outcome.as_str()), (0, "repaired"));
    assert_eq!(sets, ["resource r3_2 = r3"]);
    let (code, outcome, sets) = repairs("examples/pad/parallel.lw::Pad --only routes,capacities");
    assert_eq!((code, outcome.as_str(), sets.len()), (1, "none", 0));
    let (code, outcome, _) = repairs("examples/pad/hinge.lw");
    assert_eq!((code, outcome.as_str()), (0, "not_needed"));
    // A route of a transport that begins where no other does.
    let hinge = std::fs::read_to_string(folder.join("examples/pad/hinge.lw")).expect("a file");
    let cut = hinge.replace("        r3 -> r2\n", "");
    std::fs::write(folder.join("cut.lw"), cut).expect("a file");
    let (_, _, sets) = repairs("cut.lw --only routes");
    assert_eq!(sets, ["transport r5: r3 -> r2"]);
}
