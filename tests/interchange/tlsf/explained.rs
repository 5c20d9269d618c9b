//! Unrealizable files: minimal cores, counterstrategies and plays, in the terms of the file.

#[path = "../../solver/explained/legal.rs"]
mod legal;

use super::{bench, file, sound, verdict};
use linewright::game::{GuaranteeRef, Limits, Outcome, attack, select_guarantees, solve};
use linewright::gr1::Specification;
use linewright::mealy::counter::to_machine;
use linewright::mealy::verify::verify_counterstrategy;

const HEADINGS: [&str; 10] = [
    "PRESET",
    "ASSERT",
    "INVARIANTS",
    "GUARANTEE",
    "GUARANTEES",
    "REQUIRE",
    "ASSUME",
    "ASSUMPTIONS",
    "the safety of ",
    "what was broken stays broken",
];

/// The core, after all checks.
fn explained(text: &str) -> (Specification, Vec<GuaranteeRef>) {
    let limits = Limits::default();
    let specification = sound(text);
    let Outcome::Unrealizable(lost) = solve(&specification, &limits) else {
        panic!("realizable: {text}");
    };
    let core = lost.core.expect("no limit");
    let small = select_guarantees(&specification, &core);
    assert!(!verdict(&small), "{text}");
    for k in 0..core.len() {
        let mut rest = core.clone();
        rest.remove(k);
        assert!(
            verdict(&select_guarantees(&specification, &rest)),
            "{k} of {core:?}\n{text}"
        );
    }
    let found = attack(&small, &[], &limits).expect("no limit");
    let found = found.expect("a counterstrategy");
    let counterstrategy = to_machine(&small, &found);
    let verified = verify_counterstrategy(&small, &counterstrategy, &limits).expect("no limit");
    assert_eq!(verified, Ok(()), "{text}");
    assert_eq!(legal::legal(&small, &found.play), Ok(()), "{text}");
    for part in &core {
        let formula = part.formula(&specification.guarantees);
        let (start, end) = (formula.span.start as usize, formula.span.end as usize);
        let section = HEADINGS.iter().any(|h| formula.name.starts_with(h));
        assert!(section && start < end && end <= text.len(), "{formula:?}");
    }
    (specification, core)
}

/// The names of a core's formulas, and the texts at their places.
fn shown(text: &str) -> Vec<(String, String)> {
    let (specification, core) = explained(text);
    let mut found: Vec<(String, String)> = core
        .iter()
        .map(|part| {
            let formula = part.formula(&specification.guarantees);
            let at = &text[formula.span.start as usize..formula.span.end as usize];
            (formula.name.clone(), at.to_owned())
        })
        .collect();
    found.sort();
    found.dedup();
    found
}

#[test]
fn a_core_names_the_rounds_of_big_operators_and_points_into_definitions() {
    let main = "INPUTS { r[n]; } OUTPUTS { g[n]; h; }
        ASSERT { exclusive(g); h -> X !h; }
        GUARANTEE { &&[0 <= i < n] answered(r[i], g[i]); G F h; }";
    let text = file("Mealy", "Mealy", main).replace(
        "MAIN",
        "GLOBAL { PARAMETERS { n = 3; } DEFINITIONS {
           exclusive(b) = &&[0 <= i < SIZEOF b] &&[i < j < SIZEOF b] !(b[i] && b[j]);
           answered(r, g) = G (r -> X g); } }
         MAIN",
    );
    let shown = shown(&text);
    let names: Vec<&str> = shown.iter().map(|t| t.0.as_str()).collect();
    let [exclusive, first, second] = names.as_slice() else {
        panic!("{shown:?}");
    };
    assert!(
        exclusive.starts_with("ASSERT 1.") && exclusive.contains("j = "),
        "{shown:?}"
    );
    assert!(
        first.starts_with("GUARANTEE 1.") && first.contains("(i = "),
        "{shown:?}"
    );
    assert!(
        second.starts_with("GUARANTEE 1.") && second.contains("(i = "),
        "{shown:?}"
    );
    let places: Vec<&str> = shown.iter().map(|t| t.1.as_str()).collect();
    assert_eq!(places, ["!(b[i] && b[j])", "G (r -> X g)", "G (r -> X g)"]);
}

#[test]
fn unrealizable_files_are_explained_in_all_semantics() {
    let signals = "INPUTS { r[2]; stop; } OUTPUTS { g[2]; }";
    let both = "ASSERT { !(g[0] && g[1]); } GUARANTEE { &&[0 <= i < 2] G (r[i] -> F g[i]);";
    let mains = [
        // Nothing is granted while the plant stops, and it may stop for ever.
        format!("{signals} {both} G (stop -> !g[0]); }}"),
        format!("{signals} ASSUME {{ G F !r[0]; }} {both} G (stop -> !g[0]); }}"),
        format!(
            "{signals} REQUIRE {{ r[0] -> X !r[0]; }} {both} G (stop -> !g[0]); G !(stop && g[1]); }}"
        ),
        format!(
            "{signals} REQUIRE {{ stop -> X stop; }} ASSUME {{ G F r[0]; }} {both} G (stop -> X !g[0]); }}"
        ),
        format!(
            "{signals} PRESET {{ G (stop -> !g[0]); }} ASSUME {{ G (r[0] -> X r[0]); }} {both} }}"
        ),
        format!("{signals} GUARANTEE {{ G (r[0] -> X (!g[0] W r[1])); G (r[0] -> X X g[0]); }}"),
        format!(
            "{signals} GUARANTEE {{ G (r[0] -> X r[0]) && G F r[1] -> G (stop -> !g[0]) && G F g[0]; }}"
        ),
    ];
    let mut explained_files = 0;
    for main in &mains {
        for (semantics, target) in [
            ("Mealy", "Mealy"),
            ("Moore", "Moore"),
            ("Mealy,Strict", "Mealy"),
            ("Moore,Strict", "Moore"),
            ("Mealy", "Moore"),
            ("Moore", "Mealy"),
        ] {
            let text = file(semantics, target, main);
            let reading = super::read_text(&text);
            let Some(specification) = reading.specification else {
                continue;
            };
            if verdict(&specification) {
                continue;
            }
            explained_files += 1;
            explained(&text);
        }
    }
    println!("{explained_files} files explained");
    assert!(explained_files >= 30, "{explained_files}");
}

/// If INITIALLY contradicts itself, nothing is demanded, whatever the semantics and the target.
/// Otherwise PRESET is.
#[test]
fn a_contradictory_beginning_excuses_the_system() {
    for (beginning, wanted) in [("a && !a", true), ("a", false)] {
        let main = format!(
            "INPUTS {{ a; }} OUTPUTS {{ x; }} INITIALLY {{ {beginning}; }} PRESET {{ x && !x; }} \
             GUARANTEE {{ G F x; }}"
        );
        for semantics in ["Mealy", "Moore", "Mealy,Strict", "Moore,Strict"] {
            for target in ["Mealy", "Moore"] {
                let reading = super::read_text(&file(semantics, target, &main));
                let specification = reading.specification.expect("a file");
                assert_eq!(
                    verdict(&specification),
                    wanted,
                    "{semantics} {target} {main}"
                );
            }
        }
    }
}

#[test]
fn the_public_unrealizable_file_is_explained() {
    let Some(folder) = bench() else { return };
    let text = std::fs::read_to_string(folder.join("amba_case_study_unreal.tlsf")).expect("a file");
    for (name, place) in shown(&text) {
        println!("{name}: {place}");
    }
}
