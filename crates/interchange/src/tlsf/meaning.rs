//! How the sections make one formula, and that formula as a strict GR(1) specification.
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
//! A [`Specification`] is strict: the machine has to keep its safety for as long as the environment
//! has kept its own. By a plain implication it may break its safety as soon as the environment will
//! have to break an assumption, however late. So what is promised under assumptions is asked as
//!
//! ```text
//! safety   promise | broken'          an internal variable may admit that it was broken,
//!          broken -> broken'          for ever,
//! justice  !broken                    which loses unless an assumption is broken.
//! ```
//!
//! Nothing is added where nothing is assumed beyond step 0, nor for PRESET and strict ASSERT. Those
//! have to be kept in a step in which the environment breaks an assumption, so where there are
//! some, assumptions count from the next step on: `R` becomes a condition on the environment's next
//! move. Then "from every step to the next the environment keeps all R of this step, or else the
//! machine all S of this step" is `S W !R` to the letter, as long as neither looks further than the
//! next step.
//!
//! From what PRESET asks of all steps no assumption excuses. Where there is such a thing, no
//! assumption is one of safety: that it has been kept so far is assumed again and again.

use super::ast::Section;
use super::classify::{Classifier, Piece, Refusal};
use super::expand::Site;
use super::found::{Conjunct, LocatedPiece, formula, is_safety, only_in_vain, under_assumptions};
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
    /// Whether promises were moved to PRESET.
    pub kept_anyway: bool,
}

/// What is to be kept in the very step in which an assumption is broken, which therefore counts
/// later.
#[derive(Debug, Clone, Copy)]
struct BreakingStep {
    /// Something about a step.
    pressing: bool,
    /// Something about a step and the next one.
    moving: bool,
    /// Breaking it excuses from no safety.
    only_live: bool,
}

/// What the sections come to.
pub(super) struct Sides {
    pub assumptions: Side,
    pub guarantees: Side,
    /// The assumptions that appear in the file as they are here. The others were moved by a step,
    /// made of what was kept so far, or of promises: what a solver finds odd about those is odd
    /// about this encoding.
    pub own: Side,
}

impl Sides {
    /// An assumption as it stands in the file.
    pub fn assume(&mut self, list: fn(&mut Side) -> &mut Vec<Formula>, formula: Formula) {
        list(&mut self.own).push(formula.clone());
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
        // Monitors are outputs.
        self.variables
            .get(v.index())
            .is_none_or(|v| v.owner == Owner::System)
    }

    pub(super) fn mentions(&self, e: &Expr, wanted: &dyn Fn(&Self, VarId, Time) -> bool) -> bool {
        let mut found = false;
        e.for_each_var(&mut |v, t| found |= wanted(self, v, t));
        found
    }

    /// The whole specification; findings are reported.
    pub fn sides(&mut self, wishes: Vec<Conjunct>) -> Sides {
        let wishes = self.first_steps(wishes);
        let wishes = self.flattened(wishes);
        let initially = self.pieces(&wishes, Section::Initially);
        let preset = self.pieces(&wishes, Section::Preset);
        let require = self.pieces(&wishes, Section::Require);
        let mut assume = self.pieces(&wishes, Section::Assume);
        only_in_vain(&mut assume);
        let mut assert = self.pieces(&wishes, Section::Assert);
        let mut guarantee = self.pieces(&wishes, Section::Guarantee);
        if !self.strict {
            under_assumptions(&require, &assume, &mut assert);
        }
        under_assumptions(&require, &assume, &mut guarantee);
        let mut sides = Sides {
            assumptions: Side::default(),
            guarantees: Side::default(),
            own: Side::default(),
        };
        // What PRESET asks of more than the first step is asked without the assumptions, too.
        let strict = self.strict;
        let formulas = &*self.classifier.formulas;
        let further = |f: &LocatedPiece| formulas.ahead(f.at).is_none_or(|n| n > u32::from(strict));
        let lasting_preset = self.kept_anyway || preset.iter().any(further);
        let required = !require.is_empty();
        self.beginnings(&initially, &preset, required, &mut sides);

        let lasting = |f: &&LocatedPiece| !matches!(f.piece, Piece::Initial(_));
        let assumed = !require.is_empty() || { assume.iter() }
            // PRESET is kept in the very step in which an assumption about the first one is broken.
            .any(|f| !preset.is_empty() || lasting_preset || lasting(&f) || self.reads_output(f));
        only_in_vain(&mut guarantee);
        if assumed && !strict {
            only_in_vain(&mut assert);
        }
        let (hard, soft): (Vec<&LocatedPiece>, Vec<&LocatedPiece>) = match (self.strict, assumed) {
            (_, false) => (assert.iter().chain(&guarantee).collect(), Vec::new()),
            (false, true) => (Vec::new(), assert.iter().chain(&guarantee).collect()),
            (true, true) => (assert.iter().collect(), guarantee.iter().collect()),
        };
        let soft_safety = soft.iter().any(|f| is_safety(&f.piece));
        // What has to be kept in the very step in which an assumption is broken.
        let pressing = !preset.is_empty() || (assumed && !hard.is_empty());
        // A PRESET that was moved by a step is about the environment's first move, too.
        let moving = preset.iter().any(|f| matches!(f.piece, Piece::Step(_)));
        if self.strict && assumed && !assert.is_empty() {
            self.check_strict(&require, &assert);
        }

        let mut excused = Vec::new();
        for found in require.iter().chain(&assume) {
            // In a strict file only REQUIRE ends what ASSERT asks.
            let only_live =
                lasting_preset || (self.strict && !assert.is_empty() && !is_in(&require, found));
            let when = BreakingStep {
                pressing,
                moving,
                only_live,
            };
            self.assumption(found, when, &mut sides, &mut excused);
        }
        // Where outputs of the next step are required, the machine breaks REQUIRE and ASSERT with
        // the same move.
        let mut released = Vec::new();
        for found in require.iter().filter(|_| self.strict) {
            let late = |e: &Expr| self.mentions(e, &|s, v, t| t == Time::Next && s.is_output(v));
            match &found.piece {
                Piece::Step(e) if moving || late(e) => released.push(e.clone().not()),
                Piece::Initial(e) | Piece::Invariant(e) if moving => {
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

    /// In a strict file with assumptions, neither side of `S W !R` may look further than the next
    /// step.
    fn check_strict(&mut self, require: &[LocatedPiece], assert: &[LocatedPiece]) {
        let mut wrong = Vec::new();
        for found in require.iter().chain(assert) {
            let remembers = match &found.piece {
                Piece::Initial(e) | Piece::Invariant(e) | Piece::Step(e) => {
                    self.classifier.monitors.occur_in(e)
                }
                _ => true,
            };
            if remembers {
                wrong.push(found.at);
            }
        }
        for at in wrong {
            self.refuse(&Refusal {
                at,
                why: "in a strict file this is asked until the environment breaks REQUIRE, and it looks further than the next step".to_owned(),
                help: "`S W !R` with such a formula has no equivalent here: move it to GUARANTEE or ASSUME, under `G`".to_owned(),
            });
        }
    }

    fn assumption(
        &mut self,
        found: &LocatedPiece,
        when: BreakingStep,
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
                    why: "this assumption says that one thing happens again and again if another does, which is outside GR(1)".to_owned(),
                    help: "assume the second thing outright, `G F b`, if the environment sees to that: GR(1) has assumptions `G F a` and promises `G F b`".to_owned(),
                };
                self.refuse(&refusal);
            }
            piece if when.only_live => {
                if let Some(e) = self.classifier.past(piece) {
                    let kept = self.classifier.kept(&e);
                    side.justice.push(formula(found, &kept));
                }
            }
            // The environment is held to it a move after the first one.
            piece @ (Piece::Initial(_) | Piece::Invariant(_)) if when.moving => {
                if let Some(e) = self.classifier.past(piece) {
                    let e = self.classifier.one_later(&e);
                    side.safety.push(formula(found, &e));
                }
            }
            Piece::Initial(e) | Piece::Invariant(e) => {
                let outputs = self.mentions(e, &|s, v, _| s.is_output(v));
                let initial = matches!(found.piece, Piece::Initial(_));
                if when.pressing || outputs {
                    // The environment is held to it in its next move.
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
                if outputs || when.moving {
                    let e = self.classifier.late(e);
                    side.safety.push(formula(found, &e));
                } else {
                    sides.assume(|s| &mut s.safety, formula(found, e));
                }
            }
        }
    }

    /// Promises that an assumption excuses which is broken later.
    fn soft(&mut self, soft: &[&LocatedPiece], excused: &[Expr], sides: &mut Sides) {
        let broken = self.classifier.broken;
        for found in soft {
            self.classifier.origin = found.origin.clone();
            let side = &mut sides.guarantees;
            if self.timing == Timing::Moore {
                // The machine answers before it sees the inputs, so it admits a step later.
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

/// A promise that nothing excuses but what the environment has broken before.
fn keep(found: &LocatedPiece, late: bool, released: &[Expr], sides: &mut Sides) {
    let side = &mut sides.guarantees;
    let unless = |e: &Expr| excuse(e.clone(), released);
    match &found.piece {
        // Only what is constant is left of a formula under `G`.
        Piece::Initial(e) if late => side.safety.push(formula(found, &unless(e))),
        Piece::Initial(e) => side.initial.push(formula(found, e)),
        // What REQUIRE asks of this step comes first.
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
