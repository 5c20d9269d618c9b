//! The formulas of a section as parts, each with its name and its place.

use super::ast::Section;
use super::lexer::one_line;
use super::ltl::{F, Op};
use super::meaning::{Found, Meaning, Wish};
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::monitors::Origin;
use crate::source::Span;
use std::collections::BTreeMap;

impl Meaning<'_, '_, '_> {
    /// Conjunctions at the top, and implications that are the only promise, taken apart.
    pub(super) fn flattened(&mut self, wishes: Vec<Wish>) -> Vec<Wish> {
        let mut wishes = self.split(wishes);
        loop {
            let bound = |w: &&Wish| matches!(w.section, Section::Assert | Section::Guarantee);
            let mut promises = wishes.iter().filter(bound);
            let (Some(only), None) = (promises.next(), promises.next()) else {
                return wishes;
            };
            let Op::Implies(a, b) = *self.classifier.formulas.op(only.formula) else {
                return wishes;
            };
            if only.section != Section::Guarantee
                || self.classifier.formulas.ahead(only.formula).is_some()
            {
                return wishes;
            }
            let only = only.clone();
            wishes.retain(|w| !bound(&w));
            for (section, formula) in [(Section::Assume, a), (Section::Guarantee, b)] {
                wishes.push(Wish {
                    section,
                    formula,
                    ..only.clone()
                });
            }
            wishes = self.split(wishes);
        }
    }

    pub(super) fn split(&mut self, wishes: Vec<Wish>) -> Vec<Wish> {
        let mut found = Vec::new();
        for wish in wishes {
            match self.classifier.formulas.op(wish.formula).clone() {
                Op::And(list) => {
                    let list = list.into_iter().map(|formula| Wish {
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

    /// The parts of a formula of a section that hold together exactly if it holds in the way of the section.
    pub(super) fn parts(&mut self, wish: &Wish, section: Section) -> Vec<F> {
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
    pub(super) fn pieces(&mut self, wishes: &[Wish], section: Section) -> Vec<Found> {
        let mut all: Vec<(&Wish, F)> = Vec::new();
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
                Ok(piece) => found.push(Found {
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
