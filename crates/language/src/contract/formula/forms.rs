//! GR(1) forms of formulas outside GR(1).
//!
//! These clauses of [`ltl`](super::ltl) have a form:
//!
//! | clause | form |
//! |---|---|
//! | disjunctions of conditions, `always a` and `p unless q` | `always` of their past forms |
//! | such disjunctions that also contain `eventually b` or `always eventually c` | `always eventually` of past forms |
//! | `always (a or eventually b)` | a response |
//! | `always (a or (p unless q))` | a pattern with the scope `after ... until ...` |
//!
//! `eventually always d` has no equivalent form, because no condition on the past can tell that `d`
//! will hold for ever. As a guarantee, it gets a stronger form, in which the machine signals with a
//! variable that `d` holds from now on. As an assumption, it gets the weaker form `always
//! eventually d`.

use super::ltl::{
    Ltl, arrow, at_first, conj, disj, ever, historically, implies, make, name, not, once, previous,
    read, so_far, truth,
};
use super::{mentions_next, temporal};
use linewright_syntax::ast::{BinaryOp, Expr, ExprKind, PatternKind, Scope};
use linewright_syntax::format;

/// A GR(1) replacement for a formula.
#[derive(Debug, Clone)]
pub(super) struct Form {
    /// Internal variable that the replacement needs.
    pub variable: Option<String>,
    /// Formulas of the replacement. The flag tells whether the formula is a guarantee.
    pub rules: Vec<(bool, Expr)>,
    /// How the replacement compares with the original formula.
    pub strength: Strength,
}

/// How a form compares with the original formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Strength {
    /// Both hold on the same runs.
    Equivalent,
    /// The form implies the formula.
    Stronger,
    /// The formula implies the form.
    Weaker,
    /// The premise of an implication has become an assumption.
    Assumed,
}

impl Form {
    /// Formats the form for a help text, in which it follows the word "write".
    pub fn text(&self) -> String {
        let variable = self
            .variable
            .iter()
            .map(|v| format!("`internal {v}: bool`"));
        let rules = self.rules.iter().map(|(guarantee, e)| {
            let word = if *guarantee { "guarantee" } else { "assume" };
            format!("`{word} {}`", format::format_expression(e))
        });
        let items: Vec<String> = variable.chain(rules).collect();
        let list = match items.as_slice() {
            [most @ .., last] if !most.is_empty() => format!("{} and {last}", most.join(", ")),
            other => other.concat(),
        };
        let remark = match (self.strength, &self.variable) {
            (Strength::Equivalent, _) => "which is equivalent",
            (Strength::Stronger, Some(_)) => "so that the machine signals when this begins",
            (Strength::Stronger, None) => "which is slightly stronger",
            (Strength::Weaker, _) => "which is weaker, but often sufficient",
            (Strength::Assumed, _) => "where the condition before the arrow becomes an assumption",
        };
        format!("{list}, {remark}")
    }
}

/// Returns the form of an assumption or guarantee; `None` if no form is known. `input` returns
/// whether a formula mentions only inputs. `fresh` is an unused name for a variable that the form
/// can declare; `None` if it must not declare one.
pub(super) fn of(
    e: &Expr,
    guarantee: bool,
    input: &dyn Fn(&Expr) -> bool,
    fresh: Option<&str>,
) -> Option<Form> {
    let (body, under) = match &e.kind {
        ExprKind::Always(inner) => (&**inner, true),
        _ => (e, false),
    };
    if let ExprKind::Binary(BinaryOp::Implies, a, b) = &body.kind
        && guarantee
        && temporal(a)
        && input(a)
        // Under `always`, the premise has to have the same value at every step of a run.
        && (!under || matches!(&a.kind, ExprKind::Always(x) if matches!(x.kind, ExprKind::Eventually(_))))
        && let b = if under { globally((**b).clone()) } else { (**b).clone() }
        && let (Some(a), Some(b)) = (of(a, false, input, None), of(&b, true, input, fresh))
        && (a.strength, b.strength) == (Strength::Equivalent, Strength::Equivalent)
    {
        return Some(Form {
            variable: None,
            rules: [a.rules, b.rules].concat(),
            strength: Strength::Assumed,
        });
    }
    let mut form = Form {
        variable: None,
        rules: Vec::new(),
        strength: Strength::Equivalent,
    };
    let clauses = match read(e, true)? {
        Ltl::And(clauses) => clauses,
        one => vec![one],
    };
    for clause in &clauses {
        form.clause(clause, guarantee, fresh)?;
    }
    Some(form)
}

impl Form {
    /// Adds the form of a clause.
    fn clause(&mut self, clause: &Ltl, guarantee: bool, fresh: Option<&str>) -> Option<()> {
        if let Ltl::Or(parts) = clause {
            return self.disjunction(parts, guarantee, fresh);
        }
        if let Some(d) = persists(clause) {
            let d = self.settles(d, guarantee, fresh)?;
            self.rules.push((guarantee, again_and_again(d)));
            return Some(());
        }
        if let Some((trigger, q, r)) = chain(clause) {
            // A guarantee becomes stronger: it requires an `r` after every `q`, not only after a
            // `q` that follows a trigger. An assumption becomes weaker: it requires the `q`, but no
            // `r`.
            let begins = make(ExprKind::Eventually(Box::new(q.clone())));
            self.rules
                .push((guarantee, globally(arrow(trigger, begins))));
            if guarantee {
                let ends = make(ExprKind::Eventually(Box::new(r)));
                self.rules.push((guarantee, globally(arrow(q, ends))));
                self.strength = Strength::Stronger;
            } else {
                self.strength = Strength::Weaker;
            }
            return Some(());
        }
        self.rules.push((guarantee, exactly(clause)?));
        Some(())
    }

    /// Adds the form of a disjunction.
    fn disjunction(&mut self, parts: &[Ltl], guarantee: bool, fresh: Option<&str>) -> Option<()> {
        if let [Ltl::State(p), Ltl::Eventually(b)] | [Ltl::Eventually(b), Ltl::State(p)] = parts
            && let Ltl::State(b) = &**b
        {
            let later = make(ExprKind::Eventually(Box::new(plain(b)?)));
            let rule = globally(arrow(at_first(&not(p))?, later));
            self.rules.push((guarantee, rule));
            return Some(());
        }
        let open = parts.iter().filter(|p| !matches!(p, Ltl::State(_))).count();
        let live = parts.iter().any(|p| looks_back(p).is_none());
        let mut kept: Option<Expr> = None;
        let mut conditions: Vec<Expr> = Vec::new();
        for part in parts {
            let piece = match part {
                Ltl::State(p) => {
                    conditions.push(once(&at_first(&not(p))?)?);
                    continue;
                }
                // The other parts are conditions on the first step.
                Ltl::Always(a) if !live && open == 1 => match &**a {
                    Ltl::State(a) => a.clone(),
                    _ => return None,
                },
                _ if !live => looks_back(part)?,
                _ => match persists(part) {
                    Some(d) => self.settles(d, guarantee, fresh)?,
                    None => again(part)?,
                },
            };
            kept = Some(match kept {
                Some(kept) => disj(kept, piece),
                None => piece,
            });
        }
        let kept = conditions
            .into_iter()
            .fold(kept?, |kept, c| implies(c, kept));
        let rule = if live {
            again_and_again(kept)
        } else {
            globally(kept)
        };
        self.rules.push((guarantee, rule));
        Some(())
    }

    /// Returns the condition that replaces `eventually always d` under `always eventually`: `d` in
    /// an assumption, a new variable in a guarantee. Returns `None` if no new variable can be
    /// declared.
    fn settles(&mut self, d: &Expr, guarantee: bool, fresh: Option<&str>) -> Option<Expr> {
        if !guarantee {
            self.strength = Strength::Weaker;
            return Some(d.clone());
        }
        if self.variable.is_some() {
            return None;
        }
        let settled = name(fresh?);
        self.variable = fresh.map(str::to_owned);
        self.strength = Strength::Stronger;
        let stays = make(ExprKind::Next(Box::new(settled.clone())));
        self.rules
            .push((true, globally(implies(settled.clone(), stays))));
        self.rules
            .push((true, globally(implies(settled.clone(), d.clone()))));
        Some(settled)
    }
}

/// Returns the equivalent form of a clause that is not a disjunction; `None` if there is none.
fn exactly(clause: &Ltl) -> Option<Expr> {
    Some(match clause {
        Ltl::State(p) if mentions_next(p) => globally(arrow(not(&previous(&truth())?), p.clone())),
        Ltl::State(p) => p.clone(),
        Ltl::Unless(p, q) => globally(disj(p.clone(), once(q)?)),
        Ltl::Always(x) => match &**x {
            Ltl::State(a) => globally(a.clone()),
            Ltl::Eventually(c) => match &**c {
                Ltl::State(c) => again_and_again(c.clone()),
                _ => return None,
            },
            Ltl::Or(parts) => match parts.as_slice() {
                [Ltl::State(a), Ltl::Eventually(c)] => match &**c {
                    Ltl::State(c) => {
                        let later = make(ExprKind::Eventually(Box::new(plain(c)?)));
                        globally(arrow(plain(&not(a))?, later))
                    }
                    _ => return None,
                },
                [Ltl::State(a), Ltl::Unless(p, q)] => {
                    let scope = Scope::AfterUntil(Box::new(plain(&not(a))?), Box::new(plain(q)?));
                    let kind = PatternKind::Universality(Box::new(plain(p)?));
                    make(ExprKind::Pattern(kind.in_scope(None, scope)))
                }
                _ => return None,
            },
            _ => return None,
        },
        Ltl::Eventually(x) => match &**x {
            Ltl::State(b) => make(ExprKind::Eventually(Box::new(plain(b)?))),
            Ltl::And(parts) => match parts.as_slice() {
                [Ltl::State(q), Ltl::Eventually(r)] => match &**r {
                    Ltl::State(r) => {
                        let both = conj(plain(r)?, once(q)?);
                        make(ExprKind::Eventually(Box::new(both)))
                    }
                    _ => return None,
                },
                _ => return None,
            },
            _ => return None,
        },
        Ltl::Next(x) => match &**x {
            Ltl::Always(a) => match &**a {
                Ltl::State(a) => globally(implies(previous(&truth())?, a.clone())),
                _ => return None,
            },
            Ltl::Eventually(b) => match &**b {
                Ltl::State(b) => {
                    let later = conj(plain(b)?, previous(&truth())?);
                    make(ExprKind::Eventually(Box::new(later)))
                }
                _ => return None,
            },
            _ => return None,
        },
        Ltl::And(_) | Ltl::Or(_) => return None,
    })
}

/// Returns the past form of a safety clause: a condition on past steps that becomes false for ever
/// when the clause is violated. Returns `None` for other clauses.
fn looks_back(part: &Ltl) -> Option<Expr> {
    match part {
        Ltl::State(p) => once(&at_first(p)?),
        Ltl::Always(a) => match &**a {
            Ltl::State(a) => so_far(a),
            _ => None,
        },
        Ltl::Unless(p, q) => historically(&disj(p.clone(), once(q)?)),
        _ => None,
    }
}

/// Returns a condition that holds infinitely often exactly on the runs that satisfy the part;
/// `None` for `eventually always`.
fn again(part: &Ltl) -> Option<Expr> {
    match part {
        Ltl::Eventually(b) => match &**b {
            Ltl::State(b) => ever(b),
            _ => None,
        },
        Ltl::Always(x) => match &**x {
            Ltl::Eventually(c) => match &**c {
                Ltl::State(c) => Some(c.clone()),
                _ => None,
            },
            Ltl::Or(parts) => match parts.as_slice() {
                [Ltl::State(a), Ltl::Eventually(c)] => match &**c {
                    Ltl::State(c) => {
                        let waits = Box::new(not(&plain(c)?));
                        let asked = conj(not(&plain(a)?), (*waits).clone());
                        Some(not(&make(ExprKind::Since(waits, Box::new(asked)))))
                    }
                    _ => None,
                },
                _ => None,
            },
            _ => looks_back(part),
        },
        _ => looks_back(part),
    }
}

/// Returns `d` if the part is `eventually always d`.
fn persists(part: &Ltl) -> Option<&Expr> {
    match part {
        Ltl::Eventually(x) => match &**x {
            Ltl::Always(d) => match &**d {
                Ltl::State(d) => Some(d),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

/// Returns `p`, `q` and `r` if the part is `always (p -> eventually (q and eventually r))`.
fn chain(part: &Ltl) -> Option<(Expr, Expr, Expr)> {
    let Ltl::Always(x) = part else { return None };
    let Ltl::Or(parts) = &**x else { return None };
    let [Ltl::State(a), Ltl::Eventually(later)] = parts.as_slice() else {
        return None;
    };
    let Ltl::And(both) = &**later else {
        return None;
    };
    let [Ltl::State(q), Ltl::Eventually(r)] = both.as_slice() else {
        return None;
    };
    let Ltl::State(r) = &**r else { return None };
    Some((not(&plain(a)?), plain(q)?, plain(r)?))
}

/// Returns the expression if it is a condition on one step, as monitors need; otherwise `None`.
fn plain(e: &Expr) -> Option<Expr> {
    (!mentions_next(e)).then(|| e.clone())
}

fn globally(e: Expr) -> Expr {
    make(ExprKind::Always(Box::new(e)))
}

fn again_and_again(e: Expr) -> Expr {
    globally(make(ExprKind::Eventually(Box::new(e))))
}

#[cfg(test)]
mod tests;
