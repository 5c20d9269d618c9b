//! Splits the formulas of a section into parts with names and locations.

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
    /// Splits conjunctions and implications at the top level.
    ///
    /// `H & (A -> B)` becomes H under PRESET, A under ASSUME and B under GUARANTEE. If there is an
    /// H, H has to be a safety formula, and the file must have no other assumptions.
    pub(super) fn flatten(&mut self, conjuncts: Vec<Conjunct>) -> Vec<Conjunct> {
        let mut conjuncts = self.split(conjuncts);
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
            let mut found = conjuncts
                .iter()
                .enumerate()
                .filter_map(|(k, w)| Some((k, implication(w)?)));
            let (Some((k, (a, b))), None) = (found.next(), found.next()) else {
                return conjuncts;
            };
            let alone = !conjuncts
                .iter()
                .enumerate()
                .any(|(other, w)| other != k && is_guarantee(w));
            if !alone && !self.move_to_preset(&mut conjuncts, k) {
                return conjuncts;
            }
            let only = conjuncts.remove(k);
            for (section, formula) in [(Section::Assume, a), (Section::Guarantee, b)] {
                conjuncts.push(Conjunct {
                    section,
                    formula,
                    ..only.clone()
                });
            }
            conjuncts = self.split(conjuncts);
        }
    }

    /// Moves all guarantees except `but` to PRESET; `false` if that would change the meaning.
    fn move_to_preset(&mut self, conjuncts: &mut [Conjunct], but: usize) -> bool {
        let assumed = |w: &Conjunct| matches!(w.section, Section::Require | Section::Assume);
        if conjuncts.iter().any(assumed) {
            return false;
        }
        let mut moved = Vec::new();
        for (k, conjunct) in conjuncts.iter().enumerate() {
            if k == but || !is_guarantee(conjunct) {
                continue;
            }
            let formulas = &mut *self.classifier.formulas;
            let place = formulas.place(conjunct.formula);
            let formula = if conjunct.section == Section::Assert {
                formulas.make(Op::Globally(conjunct.formula), place)
            } else {
                conjunct.formula
            };
            let positive = formulas.positive(formula, false);
            let range = place.range();
            self.classifier.origin = Origin {
                name: conjunct.name.clone(),
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
            conjuncts[k].section = Section::Preset;
            conjuncts[k].formula = formula;
            self.moved_to_preset = true;
        }
        true
    }

    pub(super) fn split(&mut self, conjuncts: Vec<Conjunct>) -> Vec<Conjunct> {
        let mut found = Vec::new();
        for conjunct in conjuncts {
            match self.classifier.formulas.op(conjunct.formula).clone() {
                Op::And(list) => {
                    let list = list.into_iter().map(|formula| Conjunct {
                        formula,
                        ..conjunct.clone()
                    });
                    let inner = self.split(list.collect());
                    found.extend(inner);
                }
                _ => found.push(conjunct),
            }
        }
        found
    }

    /// The conjuncts of a formula. Formulas of REQUIRE and ASSERT implicitly begin with `G`.
    pub(super) fn parts(&mut self, conjunct: &Conjunct, section: Section) -> Vec<FormulaId> {
        let formulas = &mut *self.classifier.formulas;
        let place = formulas.place(conjunct.formula);
        let every = matches!(section, Section::Require | Section::Assert);
        let whole = if every {
            formulas.make(Op::Globally(conjunct.formula), place)
        } else {
            conjunct.formula
        };
        if let Some(refusal) = self.classifier.nested_until(whole) {
            self.refuse(&refusal);
            return Vec::new();
        }
        let formulas = &mut *self.classifier.formulas;
        let positive = formulas.positive(whole, false);
        let mut parts = formulas.parts(positive);
        // Constant conjuncts that are true have no effect.
        parts.retain(|part| formulas.truth(*part) != Some(true));
        parts
    }

    /// The pieces of all formulas of a section; reports formulas outside GR(1).
    pub(super) fn pieces(&mut self, conjuncts: &[Conjunct], section: Section) -> Vec<LocatedPiece> {
        let mut all: Vec<(&Conjunct, FormulaId)> = Vec::new();
        let mut counts: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
        for conjunct in conjuncts.iter().filter(|w| w.section == section) {
            for part in self.parts(conjunct, section) {
                all.push((conjunct, part));
                counts.entry(&conjunct.name).or_default().0 += 1;
            }
        }
        let mut found = Vec::new();
        for (conjunct, part) in all {
            let place = self.classifier.formulas.place(part);
            let range = place.range();
            let (several, number) = counts.entry(&conjunct.name).or_default();
            *number += 1;
            let mut name = conjunct.name.clone();
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
                    heading: conjunct.heading.clone(),
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
            "this formula becomes too large after its conjunctions are split",
        )
        .with_help("introduce outputs for parts of it");
        self.report.push(finding);
    }
}

fn is_guarantee(conjunct: &Conjunct) -> bool {
    matches!(conjunct.section, Section::Assert | Section::Guarantee)
}
