//! How the sections make one formula, and that formula as a strict GR(1) specification.
//!
//! With the conjunctions *I*, *P*, *R*, *A*, *S*, *G* of INITIALLY, PRESET, REQUIRE, ASSUME, ASSERT and GUARANTEE, a file means (Jacobs,
//! Klein and Schirmer, A High-Level LTL Synthesis Format: TLSF v1.1, SYNT 2016)
//!
//! ```text
//! plain    I -> P & (G R & A -> G S & G)
//! strict   I -> P & (S W !R) & (G R & A -> G)
//! ```
//!
//! Where TARGET is not the machine that SEMANTICS was written for, the formula is moved by a step first: for a Moore machine a Mealy
//! formula reads outputs one step later, for a Mealy machine a Moore formula reads inputs one step later; or the other side one step
//! earlier, where the formula reads it behind `X` only.
//!
//! # Plain implications in a strict game
//!
//! A [`Specification`] is strict: the machine has to keep its safety for as long as the environment has kept its own. By a plain
//! implication it may break its safety as soon as the environment will have to break an assumption, however late. So what is promised
//! under assumptions is asked as
//!
//! ```text
//! safety   promise | broken'          an internal variable may admit that it was broken,
//!          broken -> broken'          for ever,
//! justice  !broken                    which loses unless an assumption is broken.
//! ```
//!
//! Nothing is added where nothing is assumed beyond step 0, nor for PRESET and strict ASSERT. Those have to be kept in a step in which the
//! environment breaks an assumption, so where there are some, assumptions count from the next step on: `R` becomes a condition on the
//! environment's next move. Then "from every step to the next the environment keeps all R of this step, or else the machine all S of this
//! step" is `S W !R` to the letter, as long as neither looks further than the next step.

use super::ast::Section;
use super::classify::{Classifier, Piece, Refusal};
use super::expand::Site;
use super::lexer::one_line;
use super::ltl::{F, Op};
use super::report::Report;
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::monitors::Origin;
use crate::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, VarId, Variable,
};
use crate::source::Span;

/// A formula of a section, expanded.
#[derive(Debug, Clone)]
pub(super) struct Wish {
    pub section: Section,
    pub name: String,
    pub formula: F,
}

/// A piece and where it comes from.
struct Found {
    piece: Piece,
    at: F,
    origin: Origin,
}

pub(super) struct Meaning<'c, 'f, 'r> {
    pub classifier: &'c mut Classifier<'f>,
    pub report: &'r mut Report,
    pub sites: &'r [Site],
    pub text: &'r str,
    pub variables: &'r [Variable],
    pub timing: Timing,
    pub strict: bool,
}

/// What is to be kept in the very step in which an assumption is broken, which therefore counts later.
#[derive(Debug, Clone, Copy)]
struct When {
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
}

impl Meaning<'_, '_, '_> {
    fn refuse(&mut self, refusal: &Refusal) {
        let place = self.classifier.formulas.place(refusal.at);
        let span = self.report.span(&place.range());
        let finding = Diagnostic::error(codes::NOT_GR1, span, refusal.why.clone())
            .with_help(refusal.help.clone());
        let finding = super::expand::located(finding, place.site, self.sites, self.report);
        self.report.push(finding);
    }

    /// Conjunctions at the top, and implications that are the only promise, taken apart.
    fn flattened(&mut self, wishes: Vec<Wish>) -> Vec<Wish> {
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
            let name = only.name.clone();
            wishes.retain(|w| !bound(&w));
            for (section, formula) in [(Section::Assume, a), (Section::Guarantee, b)] {
                wishes.push(Wish {
                    section,
                    name: name.clone(),
                    formula,
                });
            }
            wishes = self.split(wishes);
        }
    }

    fn split(&mut self, wishes: Vec<Wish>) -> Vec<Wish> {
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

    /// The pieces of all formulas of a section.
    fn pieces(&mut self, wishes: &[Wish], section: Section) -> Vec<Found> {
        let mut found = Vec::new();
        for wish in wishes.iter().filter(|w| w.section == section) {
            let formulas = &mut *self.classifier.formulas;
            let place = formulas.place(wish.formula);
            let every = matches!(section, Section::Require | Section::Assert);
            let whole = if every {
                formulas.make(Op::Globally(wish.formula), place)
            } else {
                wish.formula
            };
            let positive = formulas.positive(whole, false);
            let parts = formulas.parts(positive);
            let several = parts.len() > 1;
            for (k, part) in parts.into_iter().enumerate() {
                // What is constantly true asks nothing.
                if self.classifier.formulas.truth(part) == Some(true) {
                    continue;
                }
                let place = self.classifier.formulas.place(part);
                let range = place.range();
                let origin = Origin {
                    name: if several {
                        format!("{}.{}", wish.name, k + 1)
                    } else {
                        wish.name.clone()
                    },
                    requirement: None,
                    span: self.report.span(&range),
                    text: one_line(self.text.get(range).unwrap_or("")),
                };
                self.classifier.origin = origin.clone();
                match self.classifier.pieces(part) {
                    Ok(pieces) => found.extend(pieces.into_iter().map(|piece| Found {
                        piece,
                        at: part,
                        origin: origin.clone(),
                    })),
                    Err(refusal) => self.refuse(&refusal),
                }
                if self.classifier.formulas.too_large {
                    self.too_large(origin.span);
                    return found;
                }
            }
        }
        found
    }

    fn too_large(&mut self, span: Span) {
        let finding = Diagnostic::error(
            codes::TOO_LARGE,
            span,
            "this formula becomes too large once its conjunctions are pulled apart",
        )
        .with_help("give parts of it outputs of their own");
        self.report.push(finding);
    }

    fn is_output(&self, v: VarId) -> bool {
        // Monitors are outputs.
        { self.variables.get(v.index()) }.is_none_or(|v| v.owner == Owner::System)
    }

    fn mentions(&self, e: &Expr, wanted: &dyn Fn(&Self, VarId, Time) -> bool) -> bool {
        let mut found = false;
        e.for_each_var(&mut |v, t| found |= wanted(self, v, t));
        found
    }

    /// The whole specification; findings are reported.
    pub fn sides(&mut self, wishes: Vec<Wish>) -> Sides {
        let wishes = self.flattened(wishes);
        let initially = self.pieces(&wishes, Section::Initially);
        let preset = self.pieces(&wishes, Section::Preset);
        let require = self.pieces(&wishes, Section::Require);
        let assume = self.pieces(&wishes, Section::Assume);
        let assert = self.pieces(&wishes, Section::Assert);
        let guarantee = self.pieces(&wishes, Section::Guarantee);
        let mut sides = Sides {
            assumptions: Side::default(),
            guarantees: Side::default(),
        };
        self.beginnings(&initially, &preset, &mut sides);

        let lasting = |f: &&Found| !matches!(f.piece, Piece::Initial(_));
        let assumed =
            !require.is_empty() || { assume.iter() }.any(|f| lasting(&f) || self.reads_output(f));
        let (hard, soft): (Vec<&Found>, Vec<&Found>) = match (self.strict, assumed) {
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
            let only_live = self.strict && !assert.is_empty() && !is_in(&require, found);
            let when = When {
                pressing,
                moving,
                only_live,
            };
            self.assumption(found, when, &mut sides, &mut excused);
        }
        // Where outputs of the next step are required, the machine breaks REQUIRE and ASSERT with the same move.
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

    fn reads_output(&self, found: &Found) -> bool {
        match &found.piece {
            Piece::Initial(e) => self.mentions(e, &|s, v, _| s.is_output(v)),
            _ => false,
        }
    }

    /// INITIALLY and PRESET.
    fn beginnings(&mut self, initially: &[Found], preset: &[Found], sides: &mut Sides) {
        for found in initially {
            match &found.piece {
                Piece::Initial(e) if !self.mentions(e, &|s, v, _| s.is_output(v)) => {
                    sides.assumptions.initial.push(formula(found, e));
                }
                Piece::Step(e)
                    if !self.mentions(e, &|s, v, t| t == Time::Next && s.is_output(v)) =>
                {
                    sides.assumptions.safety.push(formula(found, e));
                }
                Piece::Initial(_) | Piece::Step(_) => {
                    let finding = Diagnostic::error(
                        codes::NOT_CONTROLLED,
                        found.origin.span,
                        "this initial condition of the environment speaks of outputs, which the system chooses",
                    )
                    .with_help("INITIALLY is about inputs; what outputs are at the beginning stands under PRESET");
                    self.report.push(finding);
                }
                _ => self.misplaced(found, "INITIALLY", "REQUIRE or ASSUME"),
            }
        }
        for found in preset {
            match &found.piece {
                Piece::Initial(e) => sides.guarantees.initial.push(formula(found, e)),
                Piece::Step(e) => sides.guarantees.safety.push(formula(found, e)),
                _ => self.misplaced(found, "PRESET", "ASSERT or GUARANTEE"),
            }
        }
    }

    fn misplaced(&mut self, found: &Found, here: &str, there: &str) {
        let refusal = Refusal {
            at: found.at,
            why: format!("{here} is about the first step, and this formula about all of them"),
            help: format!("put it under {there}"),
        };
        self.refuse(&refusal);
    }

    /// In a strict file with assumptions, neither side of `S W !R` may look further than the next step.
    fn check_strict(&mut self, require: &[Found], assert: &[Found]) {
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
        found: &Found,
        when: When,
        sides: &mut Sides,
        excused: &mut Vec<Expr>,
    ) {
        self.classifier.origin = found.origin.clone();
        let side = &mut sides.assumptions;
        match &found.piece {
            Piece::Recurrent(e) => side.justice.push(formula(found, e)),
            Piece::Persistent(e) => excused.push(e.clone().not().simplify()),
            Piece::Pair(..) => {
                let refusal = Refusal {
                    at: found.at,
                    why: "this assumption says that one thing happens again and again if another does, which is outside GR(1)".to_owned(),
                    help: "GR(1) has assumptions `G F a` and promises `G F b`; a choice between `F G a` and `G F b` is a promise only".to_owned(),
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
                    let e = if initial {
                        self.classifier.not_first().or(e.clone()).simplify()
                    } else {
                        e.clone()
                    };
                    side.safety.push(formula(found, &e));
                } else if initial {
                    side.initial.push(formula(found, e));
                } else {
                    side.invariants.push(formula(found, e));
                }
            }
            Piece::Step(e) => {
                let outputs = self.mentions(e, &|s, v, t| t == Time::Next && s.is_output(v));
                let e = if outputs || when.moving {
                    self.classifier.late(e)
                } else {
                    e.clone()
                };
                side.safety.push(formula(found, &e));
            }
        }
    }

    /// Promises that an assumption excuses which is broken later.
    fn soft(&mut self, soft: &[&Found], excused: &[Expr], sides: &mut Sides) {
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
        let made = |name: &str, expr| Formula {
            name: name.to_owned(),
            requirement: None,
            expr,
            span: self.report.span(&(0..0)),
            text: String::new(),
        };
        let stays = Expr::now(broken).implies(Expr::next(broken));
        sides
            .guarantees
            .safety
            .push(made("what was broken stays broken", stays));
        let never = excuse(Expr::now(broken).not(), excused);
        sides
            .guarantees
            .justice
            .push(made("no promise is broken", never));
    }

    /// What promises of the form "if again and again, then again and again" assume; all have to assume the same.
    fn pairs(&mut self, assert: &[Found], guarantee: &[Found], soft_safety: bool) -> Vec<Formula> {
        let mut first: Option<(&Found, &Vec<(F, Expr)>)> = None;
        let same = |a: &[(F, Expr)], b: &[(F, Expr)]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.1 == b.1)
        };
        let mut refusals = Vec::new();
        for found in assert.iter().chain(guarantee) {
            match &found.piece {
                Piece::Persistent(_) => refusals.push(Refusal {
                    at: found.at,
                    why: "`F G` (from some step on for ever) is promised, which is outside GR(1)".to_owned(),
                    help: "let an output say when it begins: `G (settled -> X settled)`, `G (settled -> a)` and `G F settled`".to_owned(),
                }),
                Piece::Pair(when, _) => match first {
                    None => first = Some((found, when)),
                    Some((_, known)) if same(known, when) => {}
                    Some(_) => refusals.push(pair(found, "another promise has another condition")),
                },
                _ => {}
            }
        }
        if let Some((found, _)) = first {
            let other =
                { assert.iter().chain(guarantee) }.any(|f| matches!(f.piece, Piece::Recurrent(_)));
            if other {
                refusals.push(pair(
                    found,
                    "other promises of `F` or `G F` have no such condition",
                ));
            } else if soft_safety {
                refusals.push(pair(found, "the promises of safety have no such condition"));
            }
        }
        for refusal in &refusals {
            self.refuse(refusal);
        }
        let Some((found, when)) = first else {
            return Vec::new();
        };
        when.iter().map(|(_, e)| formula(found, e)).collect()
    }
}

/// A promise that nothing excuses but what the environment has broken before.
fn keep(found: &Found, late: bool, released: &[Expr], sides: &mut Sides) {
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

fn pair(found: &Found, why: &str) -> Refusal {
    let at = match &found.piece {
        Piece::Pair(when, _) => when.first().map_or(found.at, |w| w.0),
        _ => found.at,
    };
    Refusal {
        at,
        why: format!("a promise depends on this happening again and again, and {why}: a Streett pair beyond GR(1)"),
        help: "GR(1) is one implication, from all assumptions `G F a` to all promises `G F b`: put the condition under ASSUME, if all may depend on it".to_owned(),
    }
}

fn is_in(list: &[Found], found: &Found) -> bool {
    list.iter().any(|f| std::ptr::eq(f, found))
}

fn is_safety(piece: &Piece) -> bool {
    matches!(
        piece,
        Piece::Initial(_) | Piece::Invariant(_) | Piece::Step(_)
    )
}

fn excuse(e: Expr, excused: &[Expr]) -> Expr {
    excused.iter().fold(e, |e, x| e.or(x.clone())).simplify()
}

fn formula(found: &Found, expr: &Expr) -> Formula {
    Formula {
        name: found.origin.name.clone(),
        requirement: None,
        expr: expr.simplify(),
        span: found.origin.span,
        text: found.origin.text.clone(),
    }
}

/// Puts everything together.
pub(super) fn specification(
    name: &str,
    timing: Timing,
    mut variables: Vec<Variable>,
    sides: Sides,
    classifier: &Classifier<'_>,
    span: Span,
) -> Specification {
    let Sides {
        assumptions,
        guarantees,
    } = sides;
    let mut taken: Vec<String> = variables.iter().map(|v| v.name.clone()).collect();
    taken.extend(classifier.monitors.variables().map(|v| v.name.clone()));
    let mut word = "broken".to_owned();
    while taken.contains(&word) {
        word.push('_');
    }
    variables.push(Variable {
        name: word,
        owner: Owner::System,
        internal: true,
        domain: Domain::Bool,
        unit: String::new(),
        span,
    });
    let mut specification = Specification {
        name: name.to_owned(),
        timing,
        variables,
        assumptions,
        guarantees,
    };
    classifier.monitors.add_to(&mut specification);
    without(&mut specification, classifier.broken);
    specification
}

/// Drops a variable that no formula mentions.
fn without(specification: &mut Specification, id: VarId) {
    let sides = [&specification.assumptions, &specification.guarantees];
    let mut used = false;
    for formula in sides.into_iter().flat_map(Side::all) {
        formula.expr.for_each_var(&mut |v, _| used |= v == id);
    }
    if used {
        return;
    }
    specification.variables.remove(id.index());
    for side in [
        &mut specification.assumptions,
        &mut specification.guarantees,
    ] {
        for list in [
            &mut side.initial,
            &mut side.invariants,
            &mut side.safety,
            &mut side.justice,
        ] {
            for formula in list {
                formula.expr = formula
                    .expr
                    .substitute(&mut |v, t| Expr::Var(if v > id { VarId(v.0 - 1) } else { v }, t));
            }
        }
    }
}
