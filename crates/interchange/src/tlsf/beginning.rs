//! Lowers INITIALLY and PRESET.

use super::ast::Section;
use super::classify::{Piece, Refusal};
use super::found::{Conjunct, LocatedPiece, formula};
use super::ltl::{FormulaId, Formulas, Op};
use super::meaning::{Meaning, Sides};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Owner, Time, VarId};

impl Meaning<'_, '_, '_> {
    /// Adds the formulas of INITIALLY and PRESET; `required` is whether the file has REQUIRE.
    pub(super) fn initial_sections(
        &mut self,
        initially: &[LocatedPiece],
        preset: &[LocatedPiece],
        required: bool,
        sides: &mut Sides,
    ) {
        for found in initially {
            match &found.piece {
                Piece::Initial(e) if !self.mentions(e, &|s, v, _| s.is_output(v)) => {
                    sides.assume(|s| &mut s.initial, formula(found, e));
                }
                Piece::Step(e)
                    if !self.mentions(e, &|s, v, t| t == Time::Next && s.is_output(v)) =>
                {
                    sides.assume(|s| &mut s.safety, formula(found, e));
                }
                Piece::Initial(_) | Piece::Step(_) => {
                    let finding = Diagnostic::error(
                        codes::NOT_CONTROLLED,
                        found.origin.span,
                        "this initial condition of the environment refers to outputs, which the system chooses",
                    )
                    .with_help("refer only to inputs under INITIALLY, and put initial values of outputs under PRESET");
                    self.report.push(finding);
                }
                _ => self.misplaced(found, "INITIALLY", "REQUIRE or ASSUME"),
            }
        }
        for found in preset {
            let ahead = self.classifier.formulas.ahead(found.at);
            let lasting = ahead.is_none_or(|n| n > 1);
            match &found.piece {
                // The formula cannot be moved to ASSERT, because there a violation of REQUIRE would
                // end it.
                _ if lasting && self.strict && required => {
                    self.misplaced(found, "PRESET", "ASSERT or GUARANTEE");
                }
                Piece::Initial(e) => sides.guarantees.initial.push(formula(found, e)),
                Piece::Invariant(e) => {
                    sides.guarantees.invariants.push(formula(found, e));
                }
                Piece::Step(e) => sides.guarantees.safety.push(formula(found, e)),
                _ => self.refuse(&Refusal {
                    at: found.at,
                    why: "PRESET holds without any assumption, but this formula is about the long run, which GR(1) can only guarantee under all assumptions".to_owned(),
                    help: "put it under GUARANTEE, if it can depend on all assumptions".to_owned(),
                }),
            }
        }
    }

    /// If the environment chooses the values of INITIALLY in the first transition, checks PRESET
    /// there, too. Otherwise the system would lose in step 0 before the environment can break an
    /// INITIALLY that contradicts itself.
    pub(super) fn defer_preset(&mut self, initially: &[LocatedPiece], preset: &mut [LocatedPiece]) {
        if !initially.iter().any(|f| matches!(f.piece, Piece::Step(_))) {
            return;
        }
        for found in preset {
            if let Piece::Initial(e) = &found.piece {
                let e = e.clone();
                self.classifier.origin = found.origin.clone();
                found.piece = self.classifier.only_in(0, e);
            }
        }
    }

    /// Moves formulas of INITIALLY and PRESET about more than the first step to other sections.
    ///
    /// If the formulas I of INITIALLY move to ASSUME, a formula P of PRESET becomes `I -> P`,
    /// because `I -> P & (A -> B)` is equivalent to `(I -> P) & (I & A -> B)`. If there are no
    /// assumptions, PRESET formulas about the long run move to GUARANTEE.
    pub(super) fn move_lasting_formulas(&mut self, mut conjuncts: Vec<Conjunct>) -> Vec<Conjunct> {
        let formulas = &mut *self.classifier.formulas;
        let variables = self.variables;
        let owned = |v: VarId| variables[v.index()].owner == Owner::Environment;
        let has = |conjuncts: &[Conjunct], section: Section| {
            conjuncts.iter().any(|w| w.section == section)
        };
        let ordinary = |w: &Conjunct, formulas: &Formulas| {
            formulas.ahead(w.formula).is_some() && formulas.all_atoms(w.formula, &owned)
        };
        let moved = conjuncts
            .iter()
            .any(|w| w.section == Section::Initially && !ordinary(w, formulas));
        if moved && !(self.strict && has(&conjuncts, Section::Assert)) {
            let given: Vec<FormulaId> = conjuncts
                .iter()
                .filter(|w| w.section == Section::Initially)
                .map(|w| w.formula)
                .collect();
            for conjunct in &mut conjuncts {
                if conjunct.section == Section::Initially {
                    conjunct.section = Section::Assume;
                } else if conjunct.section == Section::Preset {
                    let place = formulas.place(conjunct.formula);
                    let given = formulas.and(given.clone(), place);
                    conjunct.formula = formulas.make(Op::Implies(given, conjunct.formula), place);
                }
            }
        }
        if !has(&conjuncts, Section::Require) && !has(&conjuncts, Section::Assume) {
            for conjunct in &mut conjuncts {
                if conjunct.section == Section::Preset && formulas.ahead(conjunct.formula).is_none()
                {
                    conjunct.section = Section::Guarantee;
                }
            }
        }
        conjuncts
    }

    pub(super) fn misplaced(&mut self, found: &LocatedPiece, here: &str, there: &str) {
        let refusal = Refusal {
            at: found.at,
            why: format!("{here} is for the first step, but this formula is about all steps"),
            help: format!("put it under {there}"),
        };
        self.refuse(&refusal);
    }
}
