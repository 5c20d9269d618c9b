//! The formulas of a section as parts, each with its name and its place.

use super::ast::Section;
use super::found::{Conjunct, LocatedPiece, is_safety};
use super::lexer::one_line;
use super::ltl::{FormulaId, Op};
use super::meaning::Meaning;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::monitors::Origin;
use linewright_core::source::Span;
use std::collections::BTreeMap;

impl Meaning<'_, '_, '_> {
    /// Conjunctions at the top, and implications, taken apart: `H & (A -> B)` is PRESET, ASSUME and
    /// GUARANTEE, where H is safety and nothing else is assumed; without H anything may be.
    pub(super) fn flattened(&mut self, wishes: Vec<Conjunct>) -> Vec<Conjunct> {
        let mut wishes = self.split(wishes);
        loop {
            let formulas = &*self.classifier.formulas;
            let implication = |w: &Conjunct| match *formulas.op(w.formula) {
                Op::Implies(a, b)
                    if w.section == Section::Guarantee && formulas.ahead(w.formula).is_none() =>
                {
                    Some((a, b))
                }
                _ => None,
            };
            let mut found = wishes
                .iter()
                .enumerate()
                .filter_map(|(k, w)| Some((k, implication(w)?)));
            let (Some((k, (a, b))), None) = (found.next(), found.next()) else {
                return wishes;
            };
            let alone = !wishes
                .iter()
                .enumerate()
                .any(|(other, w)| other != k && is_promise(w));
            if !alone && !self.kept_anyway(&mut wishes, k) {
                return wishes;
            }
            let only = wishes.remove(k);
            for (section, formula) in [(Section::Assume, a), (Section::Guarantee, b)] {
                wishes.push(Conjunct {
                    section,
                    formula,
                    ..only.clone()
                });
            }
            wishes = self.split(wishes);
        }
    }

    /// Moves the promises but one to PRESET; `false` where that would mean something else.
    fn kept_anyway(&mut self, wishes: &mut [Conjunct], but: usize) -> bool {
        let assumed = |w: &Conjunct| matches!(w.section, Section::Require | Section::Assume);
        if wishes.iter().any(assumed) {
            return false;
        }
        let mut moved = Vec::new();
        for (k, wish) in wishes.iter().enumerate() {
            if k == but || !is_promise(wish) {
                continue;
            }
            let formulas = &mut *self.classifier.formulas;
            let place = formulas.place(wish.formula);
            let formula = if wish.section == Section::Assert {
                formulas.make(Op::Globally(wish.formula), place)
            } else {
                wish.formula
            };
            let positive = formulas.positive(formula, false);
            let range = place.range();
            self.classifier.origin = Origin {
                name: wish.name.clone(),
                requirement: None,
                span: self.report.span(&range),
                text: one_line(self.text.get(range).unwrap_or("")),
            };
            for part in self.classifier.formulas.parts(positive) {
                let piece = self.classifier.piece(part);
                if !piece.is_ok_and(|p| is_safety(&p)) {
                    return false;
                }
            }
            moved.push((k, formula));
        }
        for (k, formula) in moved {
            wishes[k].section = Section::Preset;
            wishes[k].formula = formula;
            self.kept_anyway = true;
        }
        true
    }

    pub(super) fn split(&mut self, wishes: Vec<Conjunct>) -> Vec<Conjunct> {
        let mut found = Vec::new();
        for wish in wishes {
            match self.classifier.formulas.op(wish.formula).clone() {
                Op::And(list) => {
                    let list = list.into_iter().map(|formula| Conjunct {
                        formula,
                        ..wish.clone()
                    });
                    let inner = self.split(list.collect());
                    found.extend(inner);
                }
                _ => found.push(wish),
            }
        }
        found
    }

    /// The parts of a formula of a section that hold together exactly if it holds in the way of the
    /// section.
    pub(super) fn parts(&mut self, wish: &Conjunct, section: Section) -> Vec<FormulaId> {
        let formulas = &mut *self.classifier.formulas;
        let place = formulas.place(wish.formula);
        let every = matches!(section, Section::Require | Section::Assert);
        let whole = if every {
            formulas.make(Op::Globally(wish.formula), place)
        } else {
            wish.formula
        };
        if let Some(refusal) = self.classifier.nested_until(whole) {
            self.refuse(&refusal);
            return Vec::new();
        }
        let formulas = &mut *self.classifier.formulas;
        let positive = formulas.positive(whole, false);
        let mut parts = formulas.parts(positive);
        // What is constantly true asks nothing.
        parts.retain(|part| formulas.truth(*part) != Some(true));
        parts
    }

    /// The pieces of all formulas of a section.
    pub(super) fn pieces(&mut self, wishes: &[Conjunct], section: Section) -> Vec<LocatedPiece> {
        let mut all: Vec<(&Conjunct, FormulaId)> = Vec::new();
        let mut counts: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
        for wish in wishes.iter().filter(|w| w.section == section) {
            for part in self.parts(wish, section) {
                all.push((wish, part));
                counts.entry(&wish.name).or_default().0 += 1;
            }
        }
        let mut found = Vec::new();
        for (wish, part) in all {
            let place = self.classifier.formulas.place(part);
            let range = place.range();
            let (several, number) = counts.entry(&wish.name).or_default();
            *number += 1;
            let mut name = wish.name.clone();
            if *several > 1 {
                name = format!("{name}.{number}");
            }
            let with = super::expand::bindings(place.site, self.sites);
            if !with.is_empty() {
                name = format!("{name} ({with})");
            }
            let origin = Origin {
                name,
                requirement: None,
                span: self.report.span(&range),
                text: one_line(self.text.get(range).unwrap_or("")),
            };
            self.classifier.origin = origin.clone();
            match self.classifier.piece(part) {
                Ok(piece) => found.push(LocatedPiece {
                    piece,
                    at: part,
                    origin: origin.clone(),
                    heading: wish.heading.clone(),
                }),
                Err(refusal) => self.refuse(&refusal),
            }
            if self.classifier.formulas.too_large {
                self.too_large(origin.span);
                return found;
            }
        }
        found
    }

    pub(super) fn too_large(&mut self, span: Span) {
        let finding = Diagnostic::error(
            codes::TOO_LARGE,
            span,
            "this formula becomes too large once its conjunctions are pulled apart",
        )
        .with_help("give parts of it outputs of their own");
        self.report.push(finding);
    }
}

fn is_promise(wish: &Conjunct) -> bool {
    matches!(wish.section, Section::Assert | Section::Guarantee)
}
