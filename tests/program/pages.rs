//! What pages of checks, controllers and plays say, read as text.

use crate::support::{programs, sandbox};
use std::path::Path;

/// Runs a command with an option that writes a page, and returns the page.
fn page(folder: &Path, arguments: &[&str]) -> String {
    let path = programs::page(folder, "page", arguments);
    std::fs::read_to_string(path).expect("the page")
}

/// The text of elements, with single blanks between words.
fn text(html: &str) -> String {
    let mut shown = String::new();
    // Long names may be broken, but are one word.
    let html = html.replace("<wbr>", "");
    for (index, piece) in html.split('<').enumerate() {
        let inside = match piece.split_once('>') {
            Some((_, inside)) if index > 0 => inside,
            _ => piece,
        };
        shown.push_str(inside);
        shown.push(' ');
    }
    let words: Vec<&str> = shown.split_whitespace().collect();
    let plain = words.join(" ");
    plain
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&")
}

/// The declaration with a name.
fn article<'a>(page: &'a str, name: &str) -> &'a str {
    let mut articles = page.split("<article").skip(1);
    let heading = format!("<h3>{name} ");
    let found = articles.find(|article| article.contains(&heading));
    let found = found.unwrap_or_else(|| panic!("no {name}"));
    found.split_once("</article>").map_or(found, |(own, _)| own)
}

/// What a reader sees without opening anything.
fn seen(html: &str) -> String {
    let mut shown = String::new();
    let mut rest = html;
    while let Some((before, after)) = rest.split_once("<details>") {
        shown.push_str(before);
        rest = after.split_once("</details>").map_or("", |(_, rest)| rest);
    }
    text(&(shown + rest))
}

#[track_caller]
fn contains(text: &str, wanted: &[&str]) {
    for words in wanted {
        assert!(text.contains(words), "{words:?} is not in {text}");
    }
}

#[test]
fn a_line_comes_first_and_shows_what_its_proof_rests_on() {
    let sandbox = sandbox();
    let command = ["check", "examples/ice-lab/line.lw", "--report"];
    let page = page(sandbox.path(), &command);
    let sections = ["lines", "machines", "contracts"];
    let places = sections.map(|id| page.find(&format!("<section id=\"{id}\"")));
    assert!(places.is_sorted() && places[0].is_some(), "{places:?}");
    let rows = ["#line-1", "#machine-1", "#contract-1"];
    let places = rows.map(|id| page.find(&format!("<a href=\"{id}\"")));
    assert!(places.is_sorted() && places[0].is_some(), "{places:?}");

    let line = seen(article(&page, "IceLab"));
    contains(
        &line,
        &[
            "valid, proved under premises",
            "stock_of_BrickOne_at_warehouse the stock of BrickOne at warehouse does not run out",
            "examples/ice-lab/line.lw:24",
            "Printer, layers: fed always eventually (filament or not requested) assumed about the environment: Printer: signal filament",
            "AssemblyCell, cell: screw_needs_part always (idle and next job = screw -> grip_a) left to the caller: the check of a line reports each call that breaks it",
            "examples/ice-lab/coordinator.lw:41",
            "HolisticCell is a contract of the machine AssemblyCell as a whole. No component has it, so it is not among the contracts of this page. It is proved that the components together keep it",
            "No route leads to or from milling, so it is not used.",
            "The slowest station is printer: 3 min 24 s a part (Printed), so at most 17.6 parts an hour pass it.",
        ],
    );
    assert!(!line.contains("it always holds"), "{line}");
    let cell = article(&page, "AssemblyCell");
    contains(
        &seen(cell),
        &[
            "1,632,096 reachable states",
            "cell: first_job job in {none",
            "left to the caller: the check of a line reports each call that breaks it",
            "pick_a: part_comes",
        ],
    );
    contains(
        &text(cell),
        &[
            "is met (discharged)",
            "(induction)",
            "happens again and again (justice)",
            "command gets if cell.arm = a then cell.command else none",
        ],
    );
}

#[test]
fn alike_stations_are_counted_in_the_slowest_one() {
    let sandbox = sandbox();
    let line = "line Fill {
    part Bottle
    product Bottle
    source bottles: Bottle every 2 s
    station filler { takes 8 s }
    buffer tray capacity 5
    station capper times 3 { takes 30 s }
    sink out
    route Bottle: bottles -> filler -> tray -> capper -> out
}
";
    let write = |text: &str| {
        std::fs::write(sandbox.path().join("fill.lw"), text).expect("a line");
        let page = page(sandbox.path(), &["check", "fill.lw", "--report"]);
        seen(article(&page, "Fill"))
    };
    let known = write(line);
    contains(
        &known,
        &[
            "The slowest station is capper, of which there are 3 in parallel: 30 s a part (Bottle), one part every 10 s of all 3, so at most 360 parts an hour pass them.",
            "work_of_filler_ends the work of filler always ends",
        ],
    );
    let unknown = write(&line.replace("takes 8 s", "takes exponential(8 s)"));
    assert!(!unknown.contains("slowest"), "{unknown}");
}

#[test]
fn warnings_are_not_behind_a_check_mark() {
    let sandbox = sandbox();
    let contract = "contract Lamp {
    input asked, unused: bool
    output lit: bool
    guarantee follows: always (lit <-> asked)
}
";
    std::fs::write(sandbox.path().join("lamp.lw"), contract).expect("a contract");
    let page = page(sandbox.path(), &["check", "lamp.lw", "--report"]);
    contains(
        &page,
        &[
            "<td class=\"warned\">realizable</td>",
            "<span class=\"verdict warned\">realizable</span>",
            "<td class=\"counts\">1 warning</td>",
            ".verdict, .counts, td.good, td.bad, td.open, td.warned { white-space: nowrap; }",
        ],
    );
    assert!(!page.contains("class=\"good\""), "{page}");
    // A line whose proof reached a limit is not shown as good either.
    let bottling = ["check", "examples/bottling/line.lw", "--report"];
    let page = self::page(sandbox.path(), &bottling);
    contains(
        &page,
        &[
            "<td class=\"open\">valid</td>",
            "<td class=\"counts\">1 note</td>",
        ],
    );
}

#[test]
fn changes_are_shown_once_by_kind_and_in_words() {
    let sandbox = sandbox();
    let page = page(
        sandbox.path(),
        &["check", "examples/repair-me/1-clash.lw", "--report"],
    );
    let clamp = text(article(&page, "Clamp"));
    let change = "assume always (door_open -> not close)";
    assert_eq!(clamp.matches(change).count(), 1, "{clamp}");
    contains(
        &clamp,
        &[
            "Assume more, if it is true of your plant: one of these is enough",
            "Assume that whenever door_open holds, not close holds too.",
            "Require less: one of these is enough",
            "Keep guard , except where close and door_open holds.",
            "always (closed <-> close)",
        ],
    );
    assert!(!clamp.contains("Help:"), "{clamp}");
}

#[test]
fn definitions_stand_beside_the_rules() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let turn = "contracts/handling/turn.lw";
    let play = ["step", turn, "--script", "examples/step/turn.txt", "--html"];
    for command in [
        &["check", turn, "--report"][..],
        &["synth", turn, "--report"],
        &play,
    ] {
        let page = text(&page(folder, command));
        contains(
            &page,
            &[
                "Definitions in these rules:",
                "requested command = turn contracts/handling/turn.lw:",
                "always (requested -> grip)",
            ],
        );
    }
}
