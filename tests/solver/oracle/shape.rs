//! Where a specification demands less than it seems to, by enumeration: the definitions of
//! `game::WeaknessFindings` word for word.

use crate::game::{Board, Relation, Set, Subset, value};
use linewright::game::{GuaranteeRef, WeaknessFindings};
use linewright::gr1::{
    BinaryOp, Expr, Formula, FormulaKind as Kind, Owner, Side, Time, Timing, VarId,
};

/// Valuations and steps that can occur under controllers.
struct Occurring {
    reached: Set,
    moves: Relation,
}

impl Board<'_> {
    fn under_controllers(&self) -> Occurring {
        let rules = self.rules(&Subset::All);
        let region = self.winning(&rules);
        let groups = self.groups();
        let blind = |legal: Set, good: Set| -> Set {
            if self.specification.timing == Timing::Mealy {
                return good;
            }
            let inputs: Vec<Set> = groups
                .inputs
                .iter()
                .copied()
                .filter(|x| x & legal != 0)
                .collect();
            let right = |y: &&Set| inputs.iter().all(|x| x & **y & good != 0);
            good & groups.outputs.iter().filter(right).fold(0, |a, b| a | b)
        };
        let moves: Relation = (0..self.valuations.len())
            .map(|s| {
                let legal = rules.env_step[s];
                legal & blind(legal, rules.sys_step[s] & region)
            })
            .collect();
        let first = rules.env_start & blind(rules.env_start, rules.sys_start & region);
        let mut reached = first;
        loop {
            let more = (0..self.valuations.len())
                .filter(|s| reached >> s & 1 == 1)
                .fold(reached, |set, s| set | moves[s]);
            if more == reached {
                return Occurring { reached, moves };
            }
            reached = more;
        }
    }

    fn holds(&self, expr: &Expr, now: usize, next: usize) -> bool {
        value(expr, &self.valuations[now], &self.valuations[next]) != 0
    }

    /// Compares; returns a description of the difference.
    pub fn agrees(&self, found: &WeaknessFindings) -> Result<(), String> {
        let spec = self.specification;
        let occurring = self.under_controllers();
        let rules = self.rules(&Subset::All);
        let states: Vec<usize> = (0..self.valuations.len()).collect();
        let pairs = |set: &dyn Fn(usize) -> Set| -> Vec<(usize, usize)> {
            let next = |s: usize| states.iter().filter(move |t| set(s) >> **t & 1 == 1);
            states
                .iter()
                .flat_map(|s| next(*s).map(move |t| (*s, *t)))
                .collect()
        };
        let alone = |set: Set| pairs(&|s| if set >> s & 1 == 1 { 1 << s } else { 0 });
        let always = self.satisfying(&self.assumed.invariants);
        let env_pairs = pairs(&|s| {
            if always >> s & 1 == 1 {
                rules.env_step[s]
            } else {
                0
            }
        });
        let steps = pairs(&|s| {
            if occurring.reached >> s & 1 == 1 {
                occurring.moves[s]
            } else {
                0
            }
        });
        let (mut unbreakable, mut unreachable, mut unneeded) = (Vec::new(), Vec::new(), Vec::new());
        let sides = [(true, &spec.guarantees), (false, &spec.assumptions)];
        for (guaranteed, side) in sides {
            for (place, formula) in formulas(side) {
                let reached = alone(occurring.reached);
                let (allowed, among) = match place.kind {
                    Kind::Initial => (
                        alone(rules.env_start),
                        alone(occurring.reached & rules.env_start & rules.sys_start),
                    ),
                    Kind::Invariant => (alone(always), reached.clone()),
                    Kind::Safety | Kind::Justice => (env_pairs.clone(), steps.clone()),
                };
                let mut kept = allowed.iter();
                if guaranteed && kept.all(|(s, t)| self.holds(&formula.expr, *s, *t)) {
                    unbreakable.push(place);
                }
                let mut parts = Vec::new();
                conjuncts(&formula.expr, &mut parts);
                let mut conditions = parts.iter().map(|part| antecedents(part));
                let never = conditions.all(|conditions| {
                    let Some(conditions) = conditions else {
                        return false;
                    };
                    let of_now = !conditions.iter().any(|c| c.mentions_next());
                    let among = match place.kind {
                        Kind::Initial => &among,
                        _ if of_now => &reached,
                        _ => &among,
                    };
                    let holds =
                        |(s, t): &(usize, usize)| conditions.iter().all(|c| self.holds(c, *s, *t));
                    !among.iter().any(holds)
                });
                if never {
                    let list = if guaranteed {
                        &mut unreachable
                    } else {
                        &mut unneeded
                    };
                    list.push(place);
                }
            }
        }
        same("unbreakable", &found.unbreakable, &unbreakable)?;
        same("unreachable", &found.unreachable, &unreachable)?;
        same("unneeded", &found.unneeded, &unneeded)?;

        let outputs: Vec<usize> = (0..spec.variables.len())
            .filter(|v| {
                let variable = &spec.variables[*v];
                let own = variable.owner == Owner::System && !variable.internal;
                own && variable.domain.size() > 1
            })
            .collect();
        let mut constant = Vec::new();
        let mut unconstrained = Vec::new();
        let mut unframed = Vec::new();
        for v in &outputs {
            let values: Vec<i64> = states
                .iter()
                .filter(|s| occurring.reached >> **s & 1 == 1)
                .map(|s| self.valuations[*s][*v])
                .collect();
            if let Some(first) = values.first()
                && values.iter().all(|x| x == first)
            {
                constant.push((VarId(*v as u32), *first));
            }
            let mentions = |f: &&Formula| {
                let mut mentioned = false;
                f.expr
                    .for_each_var(&mut |w, _| mentioned |= w.index() == *v);
                mentioned
            };
            let mut all = spec.assumptions.all().chain(spec.guarantees.all());
            let restricted = spec.guarantees.all().any(|f| self.depends(f, *v));
            if all.any(|f| mentions(&f)) && !restricted {
                unconstrained.push(VarId(*v as u32));
            }
            if self.is_unframed(*v, &occurring) {
                unframed.push(VarId(*v as u32));
            }
        }
        same("constant", &found.constant, &constant)?;
        same("unconstrained", &found.unconstrained, &unconstrained)?;
        let variables: Vec<VarId> = found.unframed.iter().map(|u| u.variable).collect();
        same("unframed", &variables, &unframed)?;

        // A machine that never changes an output.
        let mut still = self.rules(&Subset::All);
        for s in &states {
            still.sys_step[*s] &= states
                .iter()
                .filter(|t| {
                    outputs
                        .iter()
                        .all(|v| self.valuations[*s][*v] == self.valuations[**t][*v])
                })
                .fold(0, |set: Set, t| set | 1 << t);
        }
        let busy = !spec.assumptions.justice.is_empty() || !spec.guarantees.justice.is_empty();
        let idle = busy && !outputs.is_empty() && self.wins(&still);
        same("idle", &found.idle, &idle)?;
        self.requests(found, &occurring)
    }

    /// Whether two values of a variable make a difference to a formula.
    fn depends(&self, formula: &Formula, v: usize) -> bool {
        let alike = |a: usize, b: usize| {
            let (a, b) = (&self.valuations[a], &self.valuations[b]);
            (0..a.len()).all(|w| w == v || a[w] == b[w])
        };
        let states = 0..self.valuations.len();
        states.clone().any(|a| {
            states.clone().filter(|b| alike(a, *b)).any(|b| {
                states.clone().any(|other| {
                    let now =
                        self.holds(&formula.expr, a, other) != self.holds(&formula.expr, b, other);
                    now || self.holds(&formula.expr, other, a)
                        != self.holds(&formula.expr, other, b)
                })
            })
        })
    }

    fn is_unframed(&self, v: usize, occurring: &Occurring) -> bool {
        let spec = self.specification;
        let rules = self.rules(&Subset::All);
        let groups = self.groups();
        let domain = spec.variables[v].domain.clone();
        let setting: Vec<&Formula> = spec
            .guarantees
            .safety
            .iter()
            .filter(|f| {
                let mut sets = false;
                f.expr
                    .for_each_var(&mut |w, t| sets |= w.index() == v && t == Time::Next);
                sets
            })
            .collect();
        if setting.is_empty() {
            return false;
        }
        let changed = |t: usize, to: i64| {
            let mut wanted = self.valuations[t].clone();
            wanted[v] = to;
            self.valuations
                .iter()
                .position(|x| *x == wanted)
                .expect("a valuation")
        };
        let (mut free, mut fixed) = (false, false);
        let mut framed = self.rules(&Subset::All);
        for s in (0..self.valuations.len()).filter(|s| occurring.reached >> s & 1 == 1) {
            let legal = rules.env_step[s];
            let mut answers = rules.sys_step[s];
            if spec.timing == Timing::Moore {
                // A safety guarantee restricts the answer for all given inputs.
                let safe = safety_only(self, s);
                let x: Vec<Set> = groups
                    .inputs
                    .iter()
                    .copied()
                    .filter(|x| x & legal != 0)
                    .collect();
                let right = |y: &&Set| x.iter().all(|x| x & **y & safe == x & **y);
                answers &= groups.outputs.iter().filter(right).fold(0, |a, b| a | b);
            }
            for x in groups.inputs.iter().filter(|x| **x & legal != 0) {
                let here = x & answers;
                let members =
                    |set: Set| (0..self.valuations.len()).filter(move |t| set >> t & 1 == 1);
                let values = || domain.low()..=domain.high();
                // Formulas about its next value impose nothing here, whatever the other variables
                // are ...
                let allowed = |t: usize| setting.iter().all(|f| self.holds(&f.expr, s, t));
                let silent = members(*x).all(|t| {
                    let kept = values().filter(|to| allowed(changed(t, *to))).count() as u64;
                    kept == 0 || kept == domain.size()
                });
                // ... and each value is part of some answer.
                let answered = |to: i64| members(here).any(|t| self.valuations[t][v] == to);
                if silent && values().all(answered) {
                    free = true;
                    let stays = |t: &usize| self.valuations[*t][v] == self.valuations[s][v];
                    let kept = members(*x)
                        .filter(stays)
                        .fold(0, |set: Set, t| set | 1 << t);
                    framed.sys_step[s] &= !x | kept;
                }
                for formula in &setting {
                    // Some values of the other next outputs leave this one a single value.
                    fixed |= members(*x).any(|t| {
                        let allowed: Vec<i64> = values()
                            .filter(|to| self.holds(&formula.expr, s, changed(t, *to)))
                            .collect();
                        allowed.len() == 1 && allowed[0] != self.valuations[s][v]
                    });
                }
            }
        }
        free && fixed && self.wins(&framed)
    }

    fn requests(&self, found: &WeaknessFindings, occurring: &Occurring) -> Result<(), String> {
        for (v, variable) in self.specification.variables.iter().enumerate() {
            if variable.owner == Owner::Environment {
                continue;
            }
            // The tests put such an assumption first: v0 and not v -> next v0.
            let Some(first) = self.specification.assumptions.safety.first() else {
                continue;
            };
            let held = Expr::now(VarId(0))
                .and(Expr::now(VarId(v as u32)).not())
                .implies(Expr::next(VarId(0)));
            if first.expr != held {
                continue;
            }
            let waiting = (0..self.valuations.len())
                .filter(|s| self.valuations[*s][0] != 0 && self.valuations[*s][v] == 0)
                .fold(0, |set: Set, s| set | 1 << s);
            let rules = self.rules(&Subset::All);
            let justice: Vec<Relation> = rules
                .assumptions
                .iter()
                .chain(&rules.goals)
                .cloned()
                .collect();
            let stays = self.lasting(&occurring.moves, &justice, waiting);
            let mut asked = self.rules(&Subset::All);
            let met = self.all() & !waiting;
            let all = self.all();
            let goal = (0..self.valuations.len()).map(|s| if met >> s & 1 == 1 { all } else { 0 });
            asked.goals.push(goal.collect());
            let enforceable = self.wins(&asked);
            // A fault, say, that may come in place of a completion.
            let reached = occurring.reached;
            let has_exception = rules.goals.iter().any(|goal| {
                let states = |set: Set, holds: &dyn Fn(Set) -> bool| {
                    (0..self.valuations.len()).any(|s| set >> s & 1 == 1 && holds(goal[s]))
                };
                let is_unmet = |row: Set| row != all;
                states(reached, &is_unmet)
                    && !states(reached & !waiting, &is_unmet)
                    && states(reached & waiting, &|row| row != 0)
            });
            let open = stays & reached != 0 && (enforceable || !has_exception);
            let listed = found.requests.iter().find(|r| r.output.index() == v);
            if listed.is_some() != open {
                return Err(format!(
                    "request of v{v}: {listed:?}, by enumeration {open}"
                ));
            }
            if let Some(listed) = listed {
                same("enforceable", &listed.enforceable, &enforceable)?;
            }
        }
        Ok(())
    }
}

/// The next valuations allowed by the safety guarantees alone.
fn safety_only(board: &Board<'_>, s: usize) -> Set {
    let safety = board.guaranteed.safety.iter();
    safety.fold(board.all(), |set, r| set & r[s])
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, found: &T, expected: &T) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    Err(format!(
        "{what}: found {found:?}, by enumeration {expected:?}"
    ))
}

fn formulas(g: &Side) -> Vec<(GuaranteeRef, &Formula)> {
    let mut all = Vec::new();
    for (kind, list) in [
        (Kind::Initial, &g.initial),
        (Kind::Invariant, &g.invariants),
        (Kind::Safety, &g.safety),
        (Kind::Justice, &g.justice),
    ] {
        for (index, formula) in list.iter().enumerate() {
            all.push((GuaranteeRef { kind, index }, formula));
        }
    }
    all
}

fn conjuncts<'e>(expr: &'e Expr, found: &mut Vec<&'e Expr>) {
    match expr {
        Expr::Binary(BinaryOp::And, a, b) => {
            conjuncts(a, found);
            conjuncts(b, found);
        }
        other => found.push(other),
    }
}

/// The conditions of nested implications.
fn antecedents(expr: &Expr) -> Option<Vec<&Expr>> {
    let Expr::Binary(BinaryOp::Implies, a, b) = expr else {
        return None;
    };
    let mut all = vec![&**a];
    all.extend(antecedents(b).unwrap_or_default());
    Some(all)
}
