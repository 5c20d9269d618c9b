//! Lemmas about single places that help to prove a line. They hold for most lines; where they do,
//! the proof of the claim can use them.
//!
//! A cycle of places keeps moving because it is never full, and a station that joins parts keeps
//! working because its components arrive. Each lemma involves only a few places. Without the
//! lemmas, a goal about parts that pass through a cycle could only be proved for all places at
//! once. If a supply limits the number of its parts in the line, the lemmas rest on a proof in many
//! small steps ([`super::limited`]).

use super::book::ClaimBuilder;
use super::limited::LimitedSupply;
use super::shape::PlaceKind;
use super::vocabulary::Model;
use super::words::is;
use linewright_algebra::proof::{Claim, Reach};
use linewright_algebra::system::{FormulaRef, System};
use linewright_core::gr1::FormulaKind;
use linewright_language::contract::line::Line;
use std::collections::BTreeSet;

/// Adds the lemmas to a claim.
pub(super) fn add(model: Model<'_>, line: &Line, system: &System, claim: &mut Claim) {
    let mut book = ClaimBuilder {
        model,
        line,
        system,
        claim,
    };
    let supplies = 0..model.shape.places.len();
    let limited: Vec<LimitedSupply> = supplies
        .filter_map(|s| LimitedSupply::new(model, s))
        .collect();
    let others = components(&mut book, &limited);
    for supply in &limited {
        supply.add(&mut book, &others);
    }
}

/// Adds a lemma for every component that a station joins, except limited ones: the component's
/// places are filled again and again. Returns pairs of a place and its lemma.
fn components(
    book: &mut ClaimBuilder<'_>,
    limited: &[LimitedSupply<'_>],
) -> Vec<(usize, FormulaRef)> {
    let model = book.model;
    let mut found = Vec::new();
    for (place, declared) in model.shape.places.iter().enumerate() {
        let PlaceKind::Station { tasks } = &declared.kind else {
            continue;
        };
        for (task, bill) in model.vars(place).bills.iter().enumerate() {
            for (line, (there, most)) in bill.iter().enumerate() {
                if limited.iter().any(|l| l.brings(place, task, line)) {
                    continue;
                }
                let (component, _) = tasks[task].bill[line];
                let kind = &model.shape.types[component];
                let name = format!("{kind}_comes_to_{}", declared.name);
                let text = format!(
                    "again and again, {} receives a {kind} to join",
                    declared.name
                );
                let full = is(*there, *most as usize);
                let words = (name.as_str(), text.as_str());
                let near = BTreeSet::new();
                let lemma =
                    book.lemma(place, FormulaKind::Justice, words, &full, near, Reach::Near);
                found.push((place, lemma));
            }
        }
    }
    found
}
