//! Turns the sections into one formula, and the formula into a strict GR(1) specification.
//!
//! With the conjunctions *I*, *P*, *R*, *A*, *S*, *G* of INITIALLY, PRESET, REQUIRE, ASSUME, ASSERT
//! and GUARANTEE, a file means (Jacobs, Klein and Schirmer, A High-Level LTL Synthesis Format: TLSF
//! v1.1, SYNT 2016)
//!
//! ```text
//! plain    I -> P & (G R & A -> G S & G)
//! strict   I -> P & (S W !R) & (G R & A -> G)
//! ```
//!
//! # Plain implications in a strict game
//!
//! A [`Specification`] is strict: the system has to keep its safety guarantees as long as the
//! environment has kept its safety assumptions. With a plain implication, the system can break a
//! safety guarantee first, if the environment is then forced to break an assumption later.
//! Therefore guarantees that depend on assumptions are encoded as
//!
//! ```text
//! safety   guarantee | broken'     the internal variable `broken` records a violation
//!          broken -> broken'       and then stays true,
//! justice  !broken                 so the system loses unless an assumption is broken.
//! ```
//!
//! This encoding is not needed if all assumptions are about step 0, nor for PRESET and strict
//! ASSERT. PRESET and strict ASSERT have to be kept even in the step in which the environment
//! breaks an assumption. If the file has either of them, assumptions take effect one step later:
//! `R` becomes a condition on the environment's next move. Then "in each transition, the
//! environment keeps all R of this step, or the system keeps all S of this step" is exactly
//! `S W !R`, as long as R and S look no further than the next step.
//!
//! A PRESET formula about all steps has to hold even after an assumption was violated. If the file
//! has one, each safety assumption becomes a justice assumption: the environment has kept it so
//! far.

use super::ast::Section;
use super::classify::{Classifier, Piece, Refusal};
use super::expand::Site;
use super::found::{
    Conjunct, LocatedPiece, drop_assumed_conditions, formula, is_safety, normalize_constants,
};
use super::report::Report;
use crate::terms::negated;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Expr, Formula, Owner, Side, Time, Timing, VarId, Variable};

pub(super) struct Meaning<'c, 'f, 'r> {
    pub classifier: &'c mut Classifier<'f>,
    pub report: &'r mut Report,
    pub sites: &'r [Site],
    pub text: &'r str,
    pub variables: &'r [Variable],
    pub timing: Timing,
    pub strict: bool,
    /// Whether guarantees were moved to PRESET.
    pub moved_to_preset: bool,
}

/// Why the violation of an assumption takes effect later than in the step of the violation.
#[derive(Debug, Clone, Copy)]
struct DelayReasons {
    /// Some guarantee about a single step has to hold even if an assumption is violated in that
    /// step.
    same_step: bool,
    /// Some guarantee about a step and the next one has to hold even if an assumption is violated
    /// in one of the two.
    first_move: bool,
    /// The violation excuses the system from justice guarantees only.
    justice_only: bool,
}

/// The assumptions and guarantees of a file.
pub(super) struct Sides {
    pub assumptions: Side,
    pub guarantees: Side,
    /// The assumptions that are unchanged from the file. The others were moved by a step, or were
    /// derived from a history or from guarantees; findings of a solver about those would only
    /// concern the encoding.
    pub unchanged: Side,
}

impl Sides {
    /// Adds an assumption that is taken from the file unchanged.
    pub fn assume(&mut self, list: fn(&mut Side) -> &mut Vec<Formula>, formula: Formula) {
        list(&mut self.unchanged).push(formula.clone());
        list(&mut self.assumptions).push(formula);
    }
}

impl Meaning<'_, '_, '_> {
    pub(super) fn refuse(&mut self, refusal: &Refusal) {
        let place = self.classifier.formulas.place(refusal.at);
        let span = self.report.span(&place.range());
        let finding = Diagnostic::error(codes::NOT_GR1, span, refusal.why.clone())
            .with_help(refusal.help.clone());
        let finding = super::expand::located(finding, place.site, self.sites, self.report);
        self.report.push(finding);
    }

    pub(super) fn is_output(&self, v: VarId) -> bool {
        // Monitors are not in `variables`; they are outputs.
        self.variables
            .get(v.index())
            .is_none_or(|v| v.owner == Owner::System)
    }

    pub(super) fn mentions(&self, e: &Expr, wanted: &dyn Fn(&Self, VarId, Time) -> bool) -> bool {
        let mut found = false;
        e.for_each_var(&mut |v, t| found |= wanted(self, v, t));
        found
    }

    /// Lowers all sections; reports formulas outside GR(1).
    pub fn sides(&mut self, conjuncts: Vec<Conjunct>) -> Sides {
        let conjuncts = self.move_lasting_formulas(conjuncts);
        let conjuncts = self.flatten(conjuncts);
        let initially = self.pieces(&conjuncts, Section::Initially);
        let mut preset = self.pieces(&conjuncts, Section::Preset);
        self.defer_preset(&initially, &mut preset);
        let require = self.pieces(&conjuncts, Section::Require);
        let mut assume = self.pieces(&conjuncts, Section::Assume);
        normalize_constants(&mut assume);
        let mut assert = self.pieces(&conjuncts, Section::Assert);
        let mut guarantee = self.pieces(&conjuncts, Section::Guarantee);
        if !self.strict {
            drop_assumed_conditions(&require, &assume, &mut assert);
        }
        drop_assumed_conditions(&require, &assume, &mut guarantee);
        let mut sides = Sides {
            assumptions: Side::default(),
            guarantees: Side::default(),
            unchanged: Side::default(),
        };
        // PRESET formulas about more than the first step have to hold without the assumptions, too.
        let strict = self.strict;
        let formulas = &*self.classifier.formulas;
        let further = |f: &LocatedPiece| formulas.ahead(f.at).is_none_or(|n| n > u32::from(strict));
        let lasting_preset = self.moved_to_preset || preset.iter().any(further);
        let required = !require.is_empty();
        self.initial_sections(&initially, &preset, required, &mut sides);

        let lasting = |f: &&LocatedPiece| !matches!(f.piece, Piece::Initial(_));
        let assumed = !require.is_empty() || { assume.iter() }
            // PRESET has to be kept even in the step in which an initial assumption is broken.
            .any(|f| !preset.is_empty() || lasting_preset || lasting(&f) || self.reads_output(f));
        normalize_constants(&mut guarantee);
        if assumed && !strict {
            normalize_constants(&mut assert);
        }
        let (hard, soft): (Vec<&LocatedPiece>, Vec<&LocatedPiece>) = match (self.strict, assumed) {
            (_, false) => (assert.iter().chain(&guarantee).collect(), Vec::new()),
            (false, true) => (Vec::new(), assert.iter().chain(&guarantee).collect()),
            (true, true) => (assert.iter().collect(), guarantee.iter().collect()),
        };
        let soft_safety = soft.iter().any(|f| is_safety(&f.piece));
        // Guarantees that have to be kept even in the step in which an assumption is broken.
        let same_step = !preset.is_empty() || (assumed && !hard.is_empty());
        // A PRESET formula about a transition also concerns the environment's first move.
        let first_move = preset.iter().any(|f| matches!(f.piece, Piece::Step(_)));
        if self.strict && assumed && !assert.is_empty() {
            self.check_strict(&conjuncts, &require, &assert);
        }

        let mut excused = Vec::new();
        for found in require.iter().chain(&assume) {
            // With strict semantics, only a violation of REQUIRE releases the system from ASSERT.
            let justice_only =
                lasting_preset || (self.strict && !assert.is_empty() && !is_in(&require, found));
            let when = DelayReasons {
                same_step,
                first_move,
                justice_only,
            };
            self.assumption(found, when, &mut sides, &mut excused);
        }
        // If REQUIRE refers to outputs of the next step, one move of the system can violate both
        // REQUIRE and ASSERT.
        let mut released = Vec::new();
        for found in require.iter().filter(|_| self.strict) {
            let late = |e: &Expr| self.mentions(e, &|s, v, t| t == Time::Next && s.is_output(v));
            match &found.piece {
                Piece::Step(e) if first_move || late(e) => released.push(e.clone().not()),
                Piece::Initial(e) | Piece::Invariant(e) if first_move => {
                    released.push(e.clone().not());
                }
                _ => {}
            }
        }
        for found in hard {
            keep(found, assumed, &released, &mut sides);
        }
        let pairs = self.pairs(&assert, &guarantee, soft_safety);
        sides.assumptions.justice.extend(pairs);
        if soft_safety {
            self.soft(&soft, &excused, &mut sides);
        }
        for found in &soft {
            if let Piece::Recurrent(e) | Piece::Pair(_, e) = &found.piece {
                let e = excuse(e.clone(), &excused);
                sides.guarantees.justice.push(formula(found, &e));
            }
        }
        sides
    }

    fn reads_output(&self, found: &LocatedPiece) -> bool {
        match &found.piece {
            Piece::Initial(e) => self.mentions(e, &|s, v, _| s.is_output(v)),
            _ => false,
        }
    }

    /// For strict semantics with assumptions, reports the formulas of REQUIRE and ASSERT that look
    /// further than the next step, because `S W !R` has no equivalent for them. `G a` in ASSERT is
    /// such a formula, although `G G a` is an invariant: once it was required, the system has to
    /// keep `a` even after REQUIRE was broken.
    fn check_strict(
        &mut self,
        conjuncts: &[Conjunct],
        require: &[LocatedPiece],
        assert: &[LocatedPiece],
    ) {
        let formulas = &*self.classifier.formulas;
        let lasting = |c: &&Conjunct| {
            c.section == Section::Assert
                && !require.is_empty()
                && formulas.ahead(c.formula).is_none()
        };
        let lasting = conjuncts.iter().filter(lasting).map(|c| c.formula);
        let mut wrong: Vec<_> = lasting.collect();
        for found in require.iter().chain(assert) {
            let remembers = match &found.piece {
                Piece::Initial(e) | Piece::Invariant(e) | Piece::Step(e) => {
                    self.classifier.monitors.occur_in(e)
                }
                _ => true,
            };
            let place = |at| self.classifier.formulas.place(at).range();
            if remembers && !wrong.iter().any(|at| place(*at) == place(found.at)) {
                wrong.push(found.at);
            }
        }
        for at in wrong {
            self.refuse(&Refusal {
                at,
                why: "with strict semantics this formula is required until the environment breaks REQUIRE, but it looks further than the next step".to_owned(),
                help: "move it to GUARANTEE or ASSUME and write `G` before it: `S W !R` with such a formula has no equivalent here".to_owned(),
            });
        }
    }

    fn assumption(
        &mut self,
        found: &LocatedPiece,
        when: DelayReasons,
        sides: &mut Sides,
        excused: &mut Vec<Expr>,
    ) {
        self.classifier.origin = found.origin.clone();
        let side = &mut sides.assumptions;
        match &found.piece {
            Piece::Recurrent(e) => sides.assume(|s| &mut s.justice, formula(found, e)),
            Piece::Persistent(e) => excused.push(negated(e)),
            Piece::Pair(..) => {
                let refusal = Refusal {
                    at: found.at,
                    why: "this assumption has the form `G F a -> G F b`, which is outside GR(1)"
                        .to_owned(),
                    help: "assume `G F b` without the condition, if the environment ensures it"
                        .to_owned(),
                };
                self.refuse(&refusal);
            }
            piece if when.justice_only => {
                if let Some(e) = self.classifier.past(piece) {
                    let kept = self.classifier.kept(&e);
                    side.justice.push(formula(found, &kept));
                }
            }
            // The assumption takes effect in the move after the environment's next one.
            piece @ (Piece::Initial(_) | Piece::Invariant(_)) if when.first_move => {
                if let Some(e) = self.classifier.past(piece) {
                    let e = self.classifier.previous_step(&e);
                    side.safety.push(formula(found, &e));
                }
            }
            Piece::Initial(e) | Piece::Invariant(e) => {
                let outputs = self.mentions(e, &|s, v, _| s.is_output(v));
                let initial = matches!(found.piece, Piece::Initial(_));
                if when.same_step || outputs {
                    // The assumption takes effect in the environment's next move.
                    let e = if initial && !matches!(e, Expr::Const(_)) {
                        self.classifier.not_first().or(e.clone()).simplify()
                    } else {
                        e.clone()
                    };
                    side.safety.push(formula(found, &e));
                } else if initial {
                    sides.assume(|s| &mut s.initial, formula(found, e));
                } else {
                    sides.assume(|s| &mut s.invariants, formula(found, e));
                }
            }
            Piece::Step(e) => {
                let outputs = self.mentions(e, &|s, v, t| t == Time::Next && s.is_output(v));
                if outputs || when.first_move {
                    let e = self.classifier.transition_to_past(e);
                    side.safety.push(formula(found, &e));
                } else {
                    sides.assume(|s| &mut s.safety, formula(found, e));
                }
            }
        }
    }

    /// Adds safety guarantees that a later violation of an assumption excuses.
    fn soft(&mut self, soft: &[&LocatedPiece], excused: &[Expr], sides: &mut Sides) {
        let broken = self.classifier.broken;
        for found in soft {
            self.classifier.origin = found.origin.clone();
            let side = &mut sides.guarantees;
            if self.timing == Timing::Moore {
                // The system answers before it sees the inputs, so it sets `broken` a step later.
                if let Some(e) = self.classifier.past(&found.piece) {
                    side.safety.push(formula(found, &e.or(Expr::next(broken))));
                }
                continue;
            }
            match &found.piece {
                Piece::Initial(e) => {
                    side.initial
                        .push(formula(found, &e.clone().or(Expr::now(broken))));
                }
                Piece::Invariant(e) => {
                    side.invariants
                        .push(formula(found, &e.clone().or(Expr::now(broken))));
                }
                Piece::Step(e) => {
                    side.safety
                        .push(formula(found, &e.clone().or(Expr::next(broken))));
                }
                _ => {}
            }
        }
        let mut headings = Vec::new();
        for found in soft.iter().filter(|f| is_safety(&f.piece)) {
            if !headings.contains(&found.heading) {
                headings.push(found.heading.clone());
            }
        }
        let heading = headings.first().cloned().unwrap_or(0..0);
        let mut words: Vec<&str> = headings
            .into_iter()
            .filter_map(|place| self.text.get(place))
            .collect();
        words.dedup();
        let made = |name: &str, expr| Formula {
            defines: false,
            name: name.to_owned(),
            requirement: None,
            expr,
            span: self.report.span(&heading),
            text: String::new(),
        };
        let stays = Expr::now(broken).implies(Expr::next(broken));
        sides
            .guarantees
            .safety
            .push(made("what was broken stays broken", stays));
        let never = excuse(Expr::now(broken).not(), excused);
        sides.guarantees.justice.push(made(
            &format!("the safety of {}", words.join(" and ")),
            never,
        ));
    }
}

/// Adds a guarantee that only an earlier violation by the environment excuses.
fn keep(found: &LocatedPiece, late: bool, released: &[Expr], sides: &mut Sides) {
    let side = &mut sides.guarantees;
    let unless = |e: &Expr| excuse(e.clone(), released);
    match &found.piece {
        // With assumptions beyond step 0, only constant formulas are left here.
        Piece::Initial(e) if late => side.safety.push(formula(found, &unless(e))),
        Piece::Initial(e) => side.initial.push(formula(found, e)),
        // As a transition formula, it does not apply if REQUIRE is violated in the same step.
        Piece::Invariant(e) if late => side.safety.push(formula(found, &unless(e))),
        Piece::Invariant(e) => side.invariants.push(formula(found, e)),
        Piece::Step(e) => side.safety.push(formula(found, &unless(e))),
        Piece::Recurrent(e) | Piece::Pair(_, e) => {
            side.justice.push(formula(found, e));
        }
        Piece::Persistent(_) => {}
    }
}

fn is_in(list: &[LocatedPiece], found: &LocatedPiece) -> bool {
    list.iter().any(|f| std::ptr::eq(f, found))
}

fn excuse(e: Expr, excused: &[Expr]) -> Expr {
    excused.iter().fold(e, |e, x| e.or(x.clone())).simplify()
}
