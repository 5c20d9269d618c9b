//! The lines of `examples`: what is proved of them, and that the proof rests on what it names.

use super::replay::accepts;
use crate::models::{Builder, constant};
use crate::mutants::nothing_can_be_left_out;
use linewright::algebra::proof::prove;
use linewright::contract::line::{Line, NodeKind, Supply};
use linewright::contract::machine::RealExpr;
use linewright::diagnostics::has_errors;
use linewright::engine::files::{self, StandardLibrary};
use linewright::game::Limits;
use linewright::line::abstraction::{
    Abstraction, NO_CIRCULAR_WAIT, PlaceKind, decide, examine, findings,
};
use linewright::line::{End, Options, UndecidedReason};
use std::path::Path;

/// Maximum number of variables of small lines.
const MOST_VARIABLES: usize = 24;

const ICE: &str = "examples/ice-lab/line.lw";

pub fn load(path: &str) -> Line {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let loaded = files::load(&[file.display().to_string()], &StandardLibrary::default());
    assert!(
        !has_errors(&loaded.findings),
        "{path}: {:?}",
        loaded.findings
    );
    let mut lines = loaded.library.lines;
    assert_eq!(lines.len(), 1, "{path}");
    lines.remove(0)
}

#[test]
fn they_are_proved() {
    proved(
        &["examples/loader/line.lw", "examples/ice-lab/milled.lw"],
        &[Abstraction::of, Abstraction::at_once],
    );
}

#[test]
fn the_line_of_the_laboratory_is_proved() {
    // Parts that eventually move also move at once: there are fewer runs then.
    proved(&[ICE], &[Abstraction::of]);
}

type Form = fn(&Line) -> Result<Abstraction, UndecidedReason>;

fn proved(paths: &[&str], forms: &[Form]) {
    for path in paths {
        let line = load(path);
        for (form, abstraction) in forms.iter().enumerate() {
            let abstraction = abstraction(&line).unwrap();
            let what = ["at some time", "at once"][form];
            let start = std::time::Instant::now();
            let verdict = decide(&abstraction, &Limits::default()).unwrap();
            let open: Vec<&str> = verdict
                .open
                .iter()
                .map(|o| abstraction.goal(o.what).name.as_str())
                .collect();
            assert!(verdict.holds(), "{path}, moves {what}: {open:?}");
            println!(
                "{path}, moves {what}: {} variables, {} contracts, {} guarantees, {} assumptions, {} goals, {:.2} s",
                abstraction.system.variables.len(),
                abstraction.system.components.len(),
                abstraction
                    .system
                    .components
                    .iter()
                    .map(|p| p.guarantees.all().count())
                    .sum::<usize>(),
                abstraction
                    .system
                    .components
                    .iter()
                    .map(|p| p.assumptions.all().count())
                    .sum::<usize>(),
                abstraction.claim.goal.all().count(),
                start.elapsed().as_secs_f64(),
            );
        }
    }
}

/// The belt's contract moves it as a whole, so two parts can fill its three places: one at the end,
/// and one on the first place.
#[test]
fn the_belts_contract_says_how_much_room_is_sure() {
    let abstraction = Abstraction::of(&load(ICE)).unwrap();
    let belts = abstraction
        .shape
        .places
        .iter()
        .filter_map(|p| match p.kind {
            PlaceKind::Conveyor { places, sure, .. } => Some((places, sure)),
            _ => None,
        });
    assert_eq!(belts.collect::<Vec<_>>(), [(3, 2); 6]);
}

fn with_limit(most: Option<u32>) -> Line {
    let mut line = load(ICE);
    for node in &mut line.nodes {
        if let NodeKind::Source { most: own, .. } = &mut node.kind {
            *own = most;
        }
    }
    line
}

/// Camera, belt, cell, belt: seven parts fill the circle, so six may be in the line.
#[test]
fn without_its_limit_the_line_of_the_laboratory_can_get_stuck() {
    for (most, wanted) in [
        (Some(1), true),
        (Some(6), true),
        (Some(7), false),
        (None, false),
    ] {
        let line = with_limit(most);
        let (abstraction, verdict) = examine(&line, &Limits::default(), 0).unwrap();
        assert_eq!(verdict.open.is_empty(), wanted, "{most:?}");
        for open in &verdict.open {
            accepts(&abstraction, open).unwrap();
        }
        if most.is_none() {
            let found = findings(&line, &abstraction, &verdict);
            let [finding] = found.as_slice() else {
                panic!("{found:#?}")
            };
            insta::assert_snapshot!(format!(
                "{}: {}\n- {}\n- {}",
                finding.code.id,
                finding.message,
                finding.notes.join("\n- "),
                finding.help.as_deref().unwrap_or_default()
            ));
        }
    }
}

/// The same places and ways, with times that force them into the circle: the way of the products to
/// the camera is slow.
#[test]
fn the_runner_gets_stuck_where_the_abstraction_says() {
    let build = |most: Option<u32>| {
        let mut builder = Builder::new(&["Brick", "Printed", "Toy"]);
        builder
            .bill("Toy", &[("Brick", 1), ("Printed", 1)])
            .source("spool", "Printed", Supply::OnOrder)
            .store("warehouse", &[("Brick", 500)])
            .station("printer", &["Printed"], constant(1.0))
            .station("camera", &["Printed", "Toy"], constant(1.0))
            .station("cell", &["Toy"], constant(1.0))
            .conveyor("belt_good", 2, 1.0)
            .conveyor("belt_toy", 2, 100.0)
            .route(
                "Printed",
                &["spool", "printer", "camera", "belt_good", "cell"],
            )
            .route("Brick", &["warehouse", "cell"])
            .route("Toy", &["cell", "belt_toy", "camera", "warehouse"]);
        if let Some(most) = most {
            super::lines::at_most(&mut builder.line, "spool", most);
        }
        builder
    };
    for (most, stuck) in [(None, true), (Some(7), true), (Some(6), false)] {
        let mut builder = build(most);
        let (abstraction, verdict) =
            examine(&builder.line, &Limits::default(), MOST_VARIABLES).unwrap();
        let names: Vec<&str> = verdict
            .open
            .iter()
            .map(|o| abstraction.goal(o.what).name.as_str())
            .collect();
        assert_eq!(
            names.contains(&NO_CIRCULAR_WAIT),
            stuck,
            "{most:?}: {names:?}"
        );
        let trace = builder.run(20);
        assert_eq!(
            trace.end == End::Blocked,
            stuck,
            "{most:?}: {:?}",
            trace.findings
        );
        if let Some(most) = most {
            let mut plant = builder_again(&build, most);
            assert_eq!(plant.run_seeded(2).end == End::Blocked, stuck);
        }
    }
}

fn builder_again(build: &dyn Fn(Option<u32>) -> Builder, most: u32) -> linewright::line::Plant {
    build(Some(most)).plant(Options {
        parts: Some(20),
        ..Options::default()
    })
}

/// One type that goes round in a small circle, while another one passes.
#[test]
fn a_circle_beside_a_way_that_is_open_is_found() {
    let mut builder = Builder::new(&["Other", "Brick"]);
    builder
        .property(
            "Brick",
            "again",
            linewright::contract::line::InitialValue::Number(0.0),
        )
        .source("bricks", "Brick", Supply::OnOrder)
        .source("others", "Other", Supply::OnOrder)
        .conveyor("first", 1, 1.0)
        .conveyor("second", 1, 1.0)
        .conveyor("third", 1, 1.0)
        .sink("out")
        .route("Brick", &["bricks", "first", "second"])
        .route_if("Brick", "second", "first", Some(RealExpr::Property(0)))
        .route("Brick", &["second", "out"])
        .route("Other", &["others", "third", "out"]);
    let (abstraction, verdict) =
        examine(&builder.line, &Limits::default(), MOST_VARIABLES).unwrap();
    for open in &verdict.open {
        accepts(&abstraction, open).unwrap();
    }
    let found = findings(&builder.line, &abstraction, &verdict);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!(
        found[0].message,
        "some parts can deadlock (circular wait) while others go on: first has a Brick that waits for room on second, \
         second has a Brick that waits for room on first"
    );
}

/// The table of a line, and its mutants.
fn table_of(path: &str) -> (usize, usize) {
    let abstraction = Abstraction::of(&load(path)).unwrap();
    let Abstraction { system, claim, .. } = &abstraction;
    let proof = prove(system, claim, &Limits::default()).unwrap();
    assert!(proof.holds());
    for (at, formula) in claim.goals() {
        let shown = proof.discharges.iter().any(|d| d.what == at);
        assert!(shown || claim.lemmas.contains_key(&at), "{}", formula.name);
    }
    let longest = proof.discharges.iter().map(|d| d.by.len()).max();
    assert!(longest.is_some_and(|names| names < 30), "{longest:?}");
    let counts = nothing_can_be_left_out(system, claim, &proof);
    println!(
        "{path}: {} lines of the table, {} mutants, all of them fail",
        counts.0, counts.1
    );
    counts
}

/// Progress is in these tables, too.
#[test]
fn nothing_that_the_tables_of_lines_name_can_be_left_out() {
    let loader = table_of("examples/loader/line.lw");
    let milled = table_of("examples/ice-lab/milled.lw");
    assert!(
        loader.0 + milled.0 > 40 && loader.1 + milled.1 > 150,
        "{loader:?} {milled:?}"
    );
}

/// The whole laboratory: no line of its table is too long for a person to read.
#[test]
fn nothing_that_the_table_of_the_laboratory_names_can_be_left_out() {
    let (lines, mutants) = table_of(ICE);
    assert!(lines > 100 && mutants > 400, "{lines} {mutants}");
}
