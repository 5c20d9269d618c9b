//! INITIALLY and PRESET.

use super::ast::Section;
use super::classify::{Piece, Refusal};
use super::found::{Conjunct, LocatedPiece, formula};
use super::ltl::{FormulaId, Formulas, Op};
use super::meaning::{Meaning, Sides};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Owner, Time, VarId};

impl Meaning<'_, '_, '_> {
    /// INITIALLY and PRESET.
    pub(super) fn beginnings(
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
                    .with_help("INITIALLY is about inputs; initial values of outputs belong under PRESET");
                    self.report.push(finding);
                }
                _ => self.misplaced(found, "INITIALLY", "REQUIRE or ASSUME"),
            }
        }
        for found in preset {
            let ahead = self.classifier.formulas.ahead(found.at);
            let lasting = ahead.is_none_or(|n| n > 1);
            match &found.piece {
                // Breaking REQUIRE ends what ASSERT asks, and not this.
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
                    why: "PRESET is kept whatever is assumed, and this formula asks for something in the long run, which GR(1) promises under all assumptions only".to_owned(),
                    help: "put it under GUARANTEE, if all assumptions may be needed for it".to_owned(),
                }),
            }
        }
    }

    /// What INITIALLY and PRESET ask of more than the first step, as far as other sections can ask
    /// it: `I -> P & (A -> B)` is `(I -> P) & (I & A -> B)`, and without A `P & B`.
    pub(super) fn first_steps(&mut self, mut wishes: Vec<Conjunct>) -> Vec<Conjunct> {
        let formulas = &mut *self.classifier.formulas;
        let variables = self.variables;
        let owned = |v: VarId| variables[v.index()].owner == Owner::Environment;
        let has =
            |wishes: &[Conjunct], section: Section| wishes.iter().any(|w| w.section == section);
        let ordinary = |w: &Conjunct, formulas: &Formulas| {
            formulas.ahead(w.formula).is_some() && formulas.all_atoms(w.formula, &owned)
        };
        let moved = wishes
            .iter()
            .any(|w| w.section == Section::Initially && !ordinary(w, formulas));
        if moved && !(self.strict && has(&wishes, Section::Assert)) {
            let given: Vec<FormulaId> = wishes
                .iter()
                .filter(|w| w.section == Section::Initially)
                .map(|w| w.formula)
                .collect();
            for wish in &mut wishes {
                if wish.section == Section::Initially {
                    wish.section = Section::Assume;
                } else if wish.section == Section::Preset {
                    let place = formulas.place(wish.formula);
                    let given = formulas.and(given.clone(), place);
                    wish.formula = formulas.make(Op::Implies(given, wish.formula), place);
                }
            }
        }
        if !has(&wishes, Section::Require) && !has(&wishes, Section::Assume) {
            for wish in &mut wishes {
                if wish.section == Section::Preset && formulas.ahead(wish.formula).is_none() {
                    wish.section = Section::Guarantee;
                }
            }
        }
        wishes
    }

    pub(super) fn misplaced(&mut self, found: &LocatedPiece, here: &str, there: &str) {
        let refusal = Refusal {
            at: found.at,
            why: format!("{here} is about the first step, and this formula about all of them"),
            help: format!("put it under {there}"),
        };
        self.refuse(&refusal);
    }
}
