//! Recipes on layouts on the command line, on `examples/pad`: what `check` decides, and the
//! commands of `recipe`.

use crate::support::{linewright, sandbox};
use quick_xml::events::Event;
use serde_json::Value;
use std::fmt::Write as _;
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

/// Writes a file that asks for products of the demonstrator. Returns its name.
fn asking(folder: &Path, import: &str, statement: &str) -> String {
    let text = format!("import \"examples/pad/{import}\"\n\n{statement}\n");
    std::fs::write(folder.join("asking.lw"), text).expect("a file");
    "asking.lw".to_owned()
}

/// The entry of a statement `realize` in a list.
fn named<'d>(entries: &'d Value, name: &str) -> &'d Value {
    let mut all = entries.as_array().expect("entries").iter();
    let found = all.find(|e| e["name"] == name);
    found.unwrap_or_else(|| panic!("no {name} in {entries}"))
}

/// A cell with one pin in stock, and a place for one part.
const STOCK: &str = "layout Cell {
    resource store at s0 {
        s0 -> s0: sort
        nop s0
    }
    at start store s0 holds Pin
}
recipe Use {
    part p: Pin
    start a
    a -> b: sort(p)()
    end b
}
recipe Keep {
    part p: Pin, q: Box
    start a
    a -> b: sort(p)(q)
    end b
    leftover q
}
";

#[test]
fn several_products_are_decided() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    // One hinge after the other takes 42 steps; a search over all plans finds 41.
    let file = asking(folder, "hinge.lw", "realize 2 Hinge on Pad");
    let (code, checked) = document(folder, &format!("check {file}"));
    assert_eq!(code, 0);
    let entry = named(&checked["realizations"], "2 Hinge on Pad");
    assert_eq!(entry["verdict"], "realizable");
    assert_eq!(entry["worst_case"], 42);
    assert_eq!(entry["is_least"], false);
    let bound = entry["lower_bound"].as_u64().expect("a lower bound");
    assert!((21..=41).contains(&bound), "{bound}");
    let (code, human) = text(folder, &format!("check {file}"));
    assert_eq!(code, 0);
    assert!(
        human.contains(&format!("42 steps, at least {bound}")),
        "{human}"
    );
    let (code, planned) = document(folder, &format!("recipe plan {file}"));
    assert_eq!(code, 0);
    let plan = &planned["plans"][0]["schedule"];
    assert_eq!(
        (&plan["value"], &plan["unit"]),
        (&41.0.into(), &"steps".into())
    );
    assert_eq!(
        (&plan["is_least"], &plan["method"]),
        (&true.into(), &"search".into())
    );
    assert!(planned["plans"][0]["plan"].is_null());
    let (_, human) = text(folder, &format!("recipe plan {file}"));
    let head = "2 Hinge on Pad: 41 steps in the worst case, the least possible\nfound by a search over all plans\n";
    assert!(human.starts_with(head), "{human}");
}

#[test]
fn twenty_products_are_made_one_after_the_other() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let file = asking(folder, "ten.lw", "realize 20 Hinge on Ten");
    let (code, checked) = document(folder, &format!("check {file}"));
    assert_eq!(code, 0);
    let entry = named(&checked["realizations"], "20 Hinge on Ten");
    assert_eq!(entry["verdict"], "realizable");
    // Each takes 20 steps with a second glue robot.
    assert_eq!(entry["worst_case"], 400);
    let (code, human) = text(folder, &format!("recipe plan {file}"));
    assert_eq!(code, 0);
    let mut lines = human.lines();
    let head = lines.next().expect("a line");
    assert!(
        head.starts_with(
            "20 Hinge on Ten: 400 steps in the worst case, and no plan has less than "
        ),
        "{head}"
    );
    let method = "made one product after the other; other orders may be better";
    assert_eq!(lines.next(), Some(method));
    assert!(human.contains("19 of 20 products finished"), "{human}");
}

#[test]
fn products_that_cannot_be_made_have_their_causes() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    // One of the recipes has a cause, which is found without a search.
    let file = asking(folder, "parallel.lw", "realize 3 Hinge, 2 FastHinge on Pad");
    let (code, checked) = document(folder, &format!("check {file}"));
    assert_eq!(code, 1);
    let entry = named(&checked["realizations"], "3 Hinge, 2 FastHinge on Pad");
    assert_eq!(entry["verdict"], "unrealizable");
    let place = "glue(p)(p) || engrave(h)(h)".to_owned();
    assert_eq!(found(folder, entry), [("LW611".to_owned(), 10, place)]);
    // One recipe cannot be made alone, which only a search shows; two can be made, but not both.
    for (statement, code, message) in [
        (
            "realize 3 Use on Cell",
            "LW614",
            "3 Use on Cell cannot be made: 1 can be made, but no plan makes them all",
        ),
        (
            "realize Use, Keep on Cell",
            "LW614",
            "Use, Keep on Cell cannot be made: a product of each of `Use` and `Keep` can be made alone, but no plan makes them all",
        ),
        (
            "recipe Lost {\n part p: Pin, q: Box\n start a\n a -> b: sort(p)(q)\n end b\n}\nrealize Use, Lost on Cell",
            "LW613",
            "`Lost` cannot be made on `Cell` without `q` remaining in the cell",
        ),
    ] {
        std::fs::write(folder.join("stock.lw"), format!("{STOCK}{statement}\n")).expect("a file");
        for command in ["check", "recipe plan"] {
            let (exit, document) = document(folder, &format!("{command} stock.lw"));
            assert_eq!(exit, 1, "{document}");
            let list = if command == "check" {
                "realizations"
            } else {
                "plans"
            };
            let entry = &document[list][0];
            assert_eq!(entry["verdict"], "unrealizable");
            let finding = &entry["findings"][0];
            assert_eq!(
                (&finding["code"], &finding["message"]),
                (&code.into(), &message.into())
            );
        }
    }
}

/// Two single places cannot exchange their parts. Twenty tables that turn by themselves give the
/// cell 2^20 configurations, so that the explicit search reaches its limits; the symbolic game does
/// not.
#[test]
fn a_large_cell_is_decided_by_a_symbolic_game() {
    let folder = sandbox();
    let mut tables = String::new();
    for number in 0..20 {
        let _ = write!(
            tables,
            "    resource table{number} at left {{
        left -> right: internal turn
        right -> left: internal turn
        nop left, right
    }}
"
        );
    }
    let cell = format!(
        "layout Swap {{
    resource one at s0 {{
        s0 -> s0: press, mark, in:one, out:two
        nop s0
    }}
    resource two at s0 {{
        s0 -> s0: punch, paint, in:two, out:one
        nop s0
    }}
{tables}}}

recipe Pair {{
    part f: Frame, g: Lid
    leftover f, g
    start a
    a -> b: press()(f); punch()(g); paint(f)(f); mark(g)(g)
    end b
}}

realize Pair on Swap
"
    );
    std::fs::write(folder.path().join("swap.lw"), cell).expect("a file");
    let (code, document) = document(folder.path(), "check swap.lw --effort 0.01");
    assert_eq!(code, 1, "{document}");
    let expected = [("Pair on Swap".to_owned(), "unrealizable".to_owned(), None)];
    assert_eq!(verdicts(&document), expected);
    let finding = &document["realizations"][0]["findings"][0];
    assert_eq!(finding["code"], "LW614");
    let message = finding["message"].as_str().expect("a message");
    assert!(message.contains("a symbolic search proves it"), "{message}");
}

#[test]
fn a_search_that_gives_up_says_what_it_has_tried() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let file = asking(folder, "hinge.lw", "realize 2 Hinge on Pad");
    std::fs::write(
        folder.join("many.lw"),
        format!("{STOCK}realize 70 Use on Cell\n"),
    )
    .expect("a file");
    std::fs::write(
        folder.join("all.lw"),
        format!("{STOCK}realize 9000 Use, 9000 Keep on Cell\n"),
    )
    .expect("a file");
    for (line, name, message) in [
        (
            format!("{file} --effort 0.00001"),
            "2 Hinge on Pad",
            "it is not decided whether 2 Hinge on Pad can be made: no plan makes one product after the other; the search over all plans ended at ",
        ),
        (
            "many.lw".to_owned(),
            "70 Use on Cell",
            "it is not decided whether 70 Use on Cell can be made: no plan makes one product after the other; more than 64 products are not searched together",
        ),
        (
            "all.lw".to_owned(),
            "9000 Use, 9000 Keep on Cell",
            "it is not decided whether 9000 Use, 9000 Keep on Cell can be made: there are more than 10000 products or parts of products",
        ),
    ] {
        for command in ["check", "recipe plan"] {
            let (code, document) = document(folder, &format!("{command} {line}"));
            assert_eq!(code, 3, "{document}");
            let list = if command == "check" {
                "realizations"
            } else {
                "plans"
            };
            let entry = named(&document[list], name);
            assert_eq!(entry["verdict"], "gave_up");
            let finding = &entry["findings"][0];
            assert_eq!(finding["code"], "LW615");
            let shown = finding["message"].as_str().expect("a text");
            assert!(shown.starts_with(message), "{shown}");
        }
    }
    let (code, human) = text(folder, "recipe plan many.lw");
    assert_eq!(code, 3);
    assert!(human.ends_with("70 Use on Cell: not decided\n"), "{human}");
}

/// The values are those of `crates/recipe/tests/floor.rs`, which were also added up by hand.
#[test]
fn plans_have_least_time_energy_and_transfers() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let proved = "the least possible";
    for (least, value, bound, unit, shown) in [
        (
            "time",
            81.0,
            76.0,
            "s",
            "1 min 21 s in the worst case, and no plan has less than 1 min 16 s (gap 6.2 %)",
        ),
        ("energy", 8700.0, 8700.0, "J", "2.42 Wh in the worst case, "),
        (
            "transfers",
            14.0,
            14.0,
            "transfers",
            "14 transfers in the worst case, ",
        ),
    ] {
        let line = format!("recipe plan examples/pad/times.lw --least {least}");
        let (code, planned) = document(folder, &line);
        assert_eq!(code, 0);
        assert_eq!(planned["least"], least);
        let plan = &planned["plans"][0]["schedule"];
        let has = |field: &str, wanted: Value| assert_eq!(plan[field], wanted, "{least}: {field}");
        has("value", value.into());
        has("lower_bound", bound.into());
        has("is_least", (least != "time").into());
        has("unit", unit.into());
        has("time_unit", "s".into());
        has("verified", true.into());
        let (code, human) = text(folder, &line);
        assert_eq!(code, 0);
        let rest = human.strip_prefix(&format!("Hinge on Timed: {shown}"));
        let rest = rest.unwrap_or_else(|| panic!("{human}"));
        assert_eq!(rest.starts_with(proved), least != "time", "{human}");
        assert_eq!(human.contains("* on the critical path"), least == "time");
    }
    // The least steps are the same with and without times.
    let (_, human) = text(folder, "recipe plan examples/pad/times.lw");
    assert!(
        human.starts_with(
            "Hinge on Timed: 21 steps in the worst case, the least possible\n\na -> b"
        )
    );
    let (code, human) = text(folder, "recipe plan examples/pad/hinge.lw --least time");
    assert_eq!(code, 0);
    assert!(
        human.contains("\nno transition of `Pad` has a duration\n"),
        "{human}"
    );
}

/// Follows a timed plan of two products: states change as the moves say, no resource takes two
/// transitions at a time, and the critical path has no gap.
#[test]
fn a_schedule_can_be_followed() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let file = asking(folder, "times.lw", "realize 2 Hinge on Timed");
    let (code, planned) = document(folder, &format!("recipe plan {file} --least time"));
    assert_eq!(code, 0);
    let plan = &planned["plans"][0]["schedule"];
    let (value, bound) = (seconds(&plan["value"]), seconds(&plan["lower_bound"]));
    assert!(value < 2.0 * 81.0 && bound <= value, "{bound} {value}");
    assert!((seconds(&plan["gap"]) - (value - bound) / value).abs() < 1e-9);
    let resources = plan["resources"].as_array().expect("resources");
    let sections = plan["sections"].as_array().expect("sections");
    let (mut worst, mut ways) = (0.0_f64, 0);
    let mut critical: Vec<(f64, f64)> = Vec::new();
    for last in sections
        .iter()
        .filter(|s| s["then"].as_array().is_some_and(Vec::is_empty))
    {
        let number = last["number"].as_str().expect("a number");
        let way = sections.iter().filter(|s| {
            let before = s["number"].as_str().expect("a number");
            number == before || number.starts_with(&format!("{before}."))
        });
        let way: Vec<&Value> = way.collect();
        let mut states = way[0]["resource_states"]
            .as_array()
            .expect("states")
            .clone();
        let mut free = vec![0.0; resources.len()];
        let mut path: Vec<(f64, f64)> = Vec::new();
        for m in way
            .iter()
            .flat_map(|s| s["moves"].as_array().expect("moves"))
        {
            let at = resources.iter().position(|r| *r == m["resource"]);
            let at = at.expect("a resource");
            assert_eq!(states[at], m["from"]);
            states[at] = m["to"].clone();
            let (start, end) = (seconds(&m["start"]), seconds(&m["end"]));
            assert!(free[at] <= start && start <= end && end <= seconds(&last["end"]));
            free[at] = end;
            if m["is_critical"] == true {
                path.push((start, end));
            }
        }
        if seconds(&last["end"]) > worst {
            worst = seconds(&last["end"]);
            critical = path;
        }
        ways += 1;
    }
    assert!((worst - value).abs() < 1e-9);
    assert_eq!(ways, 9, "three ways through the tests of each product");
    critical.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut time = 0.0;
    for (start, end) in critical {
        assert!((start - time).abs() < 1e-9, "a gap before {start}");
        time = end;
    }
    assert!((time - value).abs() < 1e-9);
}

fn seconds(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Reads the bars of a Gantt chart: class, left edge and width.
fn bars(svg: &str) -> Vec<(String, f64, f64)> {
    let mut reader = quick_xml::Reader::from_str(svg);
    let mut found = Vec::new();
    loop {
        match reader.read_event().expect("an SVG document") {
            Event::Start(element) => {
                let name = element.name();
                let name: &str = name.as_ref();
                if name != "rect" {
                    continue;
                }
                let of = |name: &str| {
                    let found = element.try_get_attribute(name).expect("an attribute");
                    found.expect("an attribute").value.into_owned()
                };
                let number = |name: &str| of(name).parse::<f64>().expect("a number");
                found.push((of("class"), number("x"), number("width")));
            }
            Event::Eof => return found,
            _ => {}
        }
    }
}

#[test]
fn a_gantt_chart_has_the_times_of_its_plan() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let line = "recipe plan examples/pad/times.lw --least time --gantt hinge.svg";
    let (code, planned) = document(folder, line);
    assert_eq!(code, 0);
    let svg = std::fs::read_to_string(folder.join("hinge.svg")).expect("a chart");
    let sections = planned["plans"][0]["schedule"]["sections"]
        .as_array()
        .expect("sections");
    let mut wanted: Vec<(String, f64, f64)> = Vec::new();
    // One chart for each way through the tests: a row for each resource.
    for way in [
        &["1", "1.1", "1.1.1"][..],
        &["1", "1.1", "1.1.2"],
        &["1", "1.2"],
    ] {
        let mut rows: Vec<Vec<&Value>> = vec![Vec::new(); 5];
        for section in sections
            .iter()
            .filter(|s| way.contains(&s["number"].as_str().unwrap_or("")))
        {
            for m in section["moves"].as_array().expect("moves") {
                let row = m["resource"]
                    .as_str()
                    .and_then(|r| r[1..].parse::<usize>().ok());
                rows[row.expect("a resource") - 1].push(m);
            }
        }
        for m in rows.into_iter().flatten() {
            let (start, end) = (seconds(&m["start"]), seconds(&m["end"]));
            if end > start {
                let kind = if m["part"].is_null() {
                    "operation"
                } else {
                    "transfer"
                };
                let critical = if m["is_critical"] == true {
                    " critical"
                } else {
                    ""
                };
                wanted.push((format!("{kind}{critical}"), start, end - start));
            }
        }
    }
    let drawn = bars(&svg);
    let classes = |all: &[(String, f64, f64)]| all.iter().map(|b| b.0.clone()).collect::<Vec<_>>();
    assert_eq!(classes(&drawn), classes(&wanted));
    assert!(drawn.iter().any(|bar| bar.0 == "operation critical"));
    // The scale follows from the longest bar, and the origin from the first one, which begins at 0.
    let longest = (0..wanted.len()).max_by(|a, b| wanted[*a].2.total_cmp(&wanted[*b].2));
    let longest = longest.expect("a bar");
    let scale = drawn[longest].2 / wanted[longest].2;
    let origin = drawn[0].1;
    assert!(wanted[0].1.abs() < 1e-9);
    for (bar, (_, start, length)) in drawn.iter().zip(&wanted) {
        assert!(
            (bar.1 - origin - start * scale).abs() < 1.0,
            "{bar:?} at {start}"
        );
        assert!((bar.2 - length * scale).abs() < 0.3, "{bar:?} of {length}");
    }
    for text in [
        "load",
        "glue",
        "80 s",
        "critical path",
        "b -&gt; d otherwise",
        "r5",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    // The drawing is the same each time.
    assert_eq!(text(folder, &line.replace("hinge.svg", "again.svg")).0, 0);
    let again = std::fs::read_to_string(folder.join("again.svg")).expect("a chart");
    assert_eq!(svg, again);
    // Steps have no times, and one chart shows one plan.
    for line in [
        "recipe plan examples/pad/times.lw --gantt x.svg",
        "recipe plan examples/pad/parallel.lw --least time --gantt x.svg",
    ] {
        assert_eq!(text(folder, line).0, 2, "{line}");
    }
    assert!(!folder.join("x.svg").exists());
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

/// A press that is slower than another and needs less power, and one without a way to the press.
const PRESSES: &str = "
layout Slow {
    resource table: Table at s0 { s0 -> s1: load in 1 s  s1 -> s0: out:table  nop s0, s1 }
    resource press: Press at s0 {
        s0 -> s1: in:press  s1 -> s2: form in 9 s power 100 W  s2 -> s0: unload in 1 s
        nop s0, s1, s2
    }
    transport cart { table -> press in 2 s }
}
layout Fast {
    resource table: Table at s0 { s0 -> s1: load in 1 s  s1 -> s0: out:table  nop s0, s1 }
    resource press: Press at s0 {
        s0 -> s1: in:press  s1 -> s2: form in 4 s power 900 W  s2 -> s0: unload in 1 s
        nop s0, s1, s2
    }
    transport cart { table -> press in 2 s }
}
recipe Cup {
    part c: Cup
    start a
    a -> b: load()(c); form(c)(c); unload(c)()
    end b
}
";

#[test]
fn layouts_are_compared_by_what_plans_have_least_of() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    std::fs::write(folder.join("presses.lw"), PRESSES).expect("the file is written");
    let compared = |options: &str| text(folder, &format!("recipe diff presses.lw {options}"));
    let (code, steps) = compared("Slow Fast");
    assert_eq!((code, steps.contains("the same")), (0, true), "{steps}");
    let (code, faster) = compared("Slow Fast --least time");
    assert_eq!((code, faster.contains("faster")), (0, true), "{faster}");
    assert!(
        faster.contains("13 s") && faster.contains("8 s"),
        "{faster}"
    );
    let (code, slower) = compared("Fast Slow --least time");
    assert_eq!((code, slower.contains("slower")), (1, true), "{slower}");
    let (code, more) = compared("Slow Fast --least energy");
    assert_eq!((code, more.contains("more")), (1, true), "{more}");
    let (_, document) = document(folder, "recipe diff presses.lw Slow Fast --least energy");
    assert_eq!(document["least"], "energy");
    let recipe = &document["recipes"][0];
    let values = ["first", "second"].map(|layout| recipe[layout]["value"].as_f64());
    assert_eq!(values, [Some(900.0), Some(3600.0)]);
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
        let steps = ["first", "second"].map(|field| recipe[field]["value"].as_f64());
        (recipe["change"].as_str().expect("a word").to_owned(), steps)
    };
    assert_eq!(
        change("Hinge"),
        ("less".to_owned(), [Some(21.0), Some(20.0)])
    );
    assert_eq!(
        change("FastHinge"),
        ("gained".to_owned(), [None, Some(21.0)])
    );
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

/// `synth` writes the controllers of recipes like those of contracts, and says what it cannot.
#[test]
fn synth_writes_the_controllers_of_recipes() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let (code, printed) = text(folder, "synth examples/pad/hinge.lw::Hinge");
    assert_eq!(code, 0);
    let machine: Value = serde_json::from_str(&printed).expect("a document");
    let names = |ports: &Value| -> Vec<String> {
        let ports = ports.as_array().expect("ports").iter();
        ports
            .map(|p| p["name"].as_str().expect("a name").to_owned())
            .collect()
    };
    assert_eq!(machine["name"], "Hinge_on_Pad");
    assert_eq!(machine["verified"], true);
    assert_eq!(
        names(&machine["inputs"]),
        ["done", "visionOk_h2", "forceOk_h2"]
    );
    assert_eq!(
        names(&machine["outputs"]),
        ["r1", "r2", "r3", "r4", "r5", "finished"]
    );
    let forms = "--emit st --emit plcopen --emit c --emit dot --emit svg --emit gr1c --out made";
    let (code, _) = text(folder, &format!("synth examples/pad/six.lw::Six {forms}"));
    assert_eq!(code, 0);
    for ending in ["st", "xml", "c", "h", "dot", "svg", "gr1c.json"] {
        let name = format!("made/Hinge_on_Six.{ending}");
        assert!(folder.join(&name).is_file(), "{name}");
    }

    // A file with both.
    let lamp = "contract Lamp { output on: bool\n guarantee on: always on }\n";
    let pad = "import \"examples/pad/hinge.lw\"\n";
    let both = format!("{pad}{lamp}realize Hinge on Pad\n");
    std::fs::write(folder.join("both.lw"), both).expect("a file");
    let (code, _) = text(folder, "synth both.lw --out both");
    assert_eq!(code, 0);
    assert!(folder.join("both/Lamp.json").is_file());
    assert!(folder.join("both/Hinge_on_Pad.json").is_file());
    let (code, printed) = text(folder, "synth both.lw::Lamp --counterstrategy");
    assert_eq!((code, printed.as_str()), (2, ""));
    let (code, _) = text(folder, "synth both.lw::Lamp --emit spc");
    assert_eq!(code, 0);
    for (argument, reason) in [
        ("--counterstrategy", "has no counterstrategy"),
        ("--report page.html", "has no report"),
        ("--emit spc", "has no GR(1) specification"),
    ] {
        let line = format!("synth both.lw {argument} --out both");
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let output = linewright(folder, &arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(errors.contains(reason), "{errors}");
        assert_eq!(output.status.code(), Some(2));
    }

    // Findings are those of `recipe plan`.
    let (code, failed) = document(folder, "synth examples/pad/parallel.lw::Pad");
    assert_eq!(code, 1);
    assert_eq!(failed["findings"][0]["code"], "LW611");
    let (_, planned) = document(folder, "recipe plan examples/pad/parallel.lw::Pad");
    assert_eq!(failed["findings"], planned["plans"][0]["findings"]);

    // What the selected recipe needs has to be right.
    let broken = "layout Bad { resource r at s0 { s0 -> s0: make; nop s1 } }
recipe R { part p; start a; a -> b: make()(p); end b; leftover p }
realize R on Bad\n";
    std::fs::write(folder.join("broken.lw"), broken).expect("a file");
    let (code, failed) = document(folder, "synth broken.lw::R");
    assert_eq!(code, 1);
    assert_eq!(failed["findings"][0]["code"], "LW101");

    // Two results with one name.
    let twice = format!("{pad}realize Hinge on Pad\nrealize Hinge on Pad\n");
    std::fs::write(folder.join("twice.lw"), twice).expect("a file");
    let (code, failed) = document(folder, "synth twice.lw --out twice");
    assert_eq!(code, 2);
    assert_eq!(failed["findings"][0]["code"], "LW504");
}

/// A plan that assumes a missing operation says which. The verdict and its causes are those of the
/// layout as it is.
#[test]
fn a_plan_can_assume_what_is_missing() {
    let folder = sandbox();
    let line = "recipe plan examples/pad/parallel.lw::Pad";
    let (code, strict) = document(folder.path(), line);
    let (with_code, assuming) = document(folder.path(), &format!("{line} --assume 2"));
    assert_eq!((code, with_code), (1, 1));
    let (strict, assuming) = (
        named(&strict["plans"], "FastHinge on Pad"),
        named(&assuming["plans"], "FastHinge on Pad"),
    );
    assert_eq!(strict["verdict"], "unrealizable");
    assert_eq!(assuming["verdict"], strict["verdict"]);
    assert_eq!(assuming["findings"], strict["findings"]);
    assert!(strict["plan"].is_null() && strict["assumed"].is_null());
    // One is enough, and the plan performs it.
    let assumed = assuming["assumed"].as_array().expect("operations");
    let texts: Vec<_> = assumed.iter().map(|change| &change["text"]).collect();
    assert_eq!(texts, ["r2: s3 -> s1: glue"]);
    let moves = assuming["plan"]["positions"][0]["legs"][0]["vectors"]
        .as_array()
        .expect("vectors")
        .iter()
        .flat_map(|vector| vector.as_array().expect("moves"));
    let glued = moves.filter(|m| m["action"] == "glue" && m["resource"] == "r2");
    assert_eq!(glued.count(), 1);
    // Where nothing is missing, nothing is assumed.
    let (code, whole) = document(
        folder.path(),
        "recipe plan examples/pad/hinge.lw --assume 1",
    );
    assert_eq!(code, 0);
    assert!(whole["plans"][0]["assumed"].is_null());
}
