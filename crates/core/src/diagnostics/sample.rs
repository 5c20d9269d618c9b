//! Findings for the renderers' tests: each kind of place, severity and message length once.

use super::{Diagnostic, codes};
use crate::source::{FileId, SourceMap, Span};
use std::fmt::Write as _;

const TURN: &str = "\
/// Rotates the part in the gripper.
contract Turn(cells: 2..360 = 8) implements vdi:Drehen {
    input command: {none, turn}
    output angle: 0..cells-1
    assume held: □ (command = turn → comand = turn)
    guarantee done: always eventually angle
    guarantee moves: always (
        command = turn -> next angle = angle + 1
    )
}
";

const CELL: &str =
    "import \"turn.lw\"\nmachine Cell {\n    action turn: Turn(cells = 1) when true {}\n}\n";

/// Returns two files and findings in them, not in display order.
pub fn findings() -> (SourceMap, Vec<Diagnostic>) {
    let mut sources = SourceMap::new();
    let turn = sources.add("contracts/turn.lw", TURN);
    let cell = sources.add("cell.lw", CELL);
    let place = |file: FileId, part: &str| {
        let text = &sources.file(file).text;
        let start = text.find(part).expect("the part is in the sample");
        Span::new(file, start, start + part.len())
    };
    let findings = vec![
        Diagnostic::error(
            codes::COMPILER_MISSING,
            None,
            "no C compiler was found: neither `cc` nor `gcc` nor `clang` can be started",
        )
        .with_help("install one (`apt-get install gcc`), or name it in the variable CC"),
        Diagnostic::warning(
            codes::DOMAIN_LEFT,
            place(
                turn,
                "always (\n        command = turn -> next angle = angle + 1\n    )",
            ),
            "the next value of `angle` can be 8, but its domain ends at 7",
        )
        .with_label(place(turn, "0..cells-1"), "with cells = 8 this is 0..7")
        .with_help("write `min(angle + 1, cells - 1)`, or let it wrap around with `mod cells`"),
        Diagnostic::error(
            codes::TYPE_MISMATCH,
            place(turn, "angle\n"),
            "`angle` is a number, but a condition is needed here",
        ),
        Diagnostic::error(
            codes::NAME_UNKNOWN,
            place(turn, "comand"),
            "`comand` is not declared",
        )
        .with_help("did you mean `command`?"),
        Diagnostic::error(
            codes::ARGUMENT,
            place(cell, "1"),
            "the argument `cells` is 1, but its range is 2..360",
        )
        .with_label(
            place(turn, "cells: 2..360"),
            "the parameter is declared here",
        ),
        Diagnostic::note(
            codes::UNUSED,
            place(turn, "done"),
            "the name `done` is never used",
        ),
    ];
    (sources, findings)
}

/// Joins sources and rendering into one text, so that a snapshot shows both.
pub fn with_sources(sources: &SourceMap, rendered: &str) -> String {
    let mut text = String::new();
    for (_, file) in sources.files() {
        let _ = writeln!(text, "--- {}\n{}", file.name, file.text);
    }
    let _ = write!(text, "--- rendered\n{rendered}");
    text
}
