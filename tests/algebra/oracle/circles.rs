//! Proofs of composition compared with all possible machines.
//!
//! A machine keeps its contract in the strict sense: its guarantees for as long as its assumptions
//! were kept, and their justice whenever that of its assumptions is met. Some such machines,
//! together in some environment, can take a step of the whole exactly if every part whose
//! assumptions still hold answers within the winning region of its own contract (if it answers
//! first: with an answer that is correct for every legal input), and if the environment keeps what
//! is given and what was passed on. In the winning region every such answer belongs to some
//! machine; and a cycle belongs to some machines exactly if each of them meets its justice on it,
//! or its environment does not. So steps are enumerated, and no machine has to be built.

use super::contracts::{Scope, expression, formula};
use super::graph::{Board, Relation, Set, Steps, members};
use super::lassos::keeps;
use super::wired::{self, Plan};
use crate::game;
use crate::random::Random;
use linewright::algebra::proof::{Claim, DischargeRule, Exports, Open, Proof, Refutation, prove};
use linewright::algebra::replay;
use linewright::algebra::system::System;
use linewright::game::Limits;
use linewright::gr1::{Formula, FormulaKind, Owner, Side, Specification, Timing, VarId};

const SYSTEMS: u64 = 4_000;

/// One part with explicit states.
struct Machine {
    timing: Timing,
    /// Its assumptions and its guarantees.
    assumed: Steps,
    promised: Steps,
    /// Valuations from which it can keep its contract.
    winning: Set,
    from_others: Vec<Set>,
    own: Vec<Set>,
    owed: Vec<Relation>,
    goals: Vec<Relation>,
}

impl Machine {
    /// `None` if nothing implements the contract.
    fn new(system: &System, board: &Board, index: usize) -> Option<Self> {
        let part = &system.components[index];
        let variables = system.variables.iter().enumerate().map(|(i, v)| {
            let own = part.drives.contains(&VarId(i as u32));
            linewright::gr1::Variable {
                owner: if own {
                    Owner::System
                } else {
                    Owner::Environment
                },
                ..v.clone()
            }
        });
        let specification = Specification {
            name: part.name.clone(),
            timing: part.timing,
            variables: variables.collect(),
            assumptions: part.assumptions.clone(),
            guarantees: part.guarantees.clone(),
        };
        let naive = game::Board::new(&specification);
        assert_eq!(naive.valuations, board.valuations);
        let rules = naive.rules(&game::Subset::All);
        if !naive.wins(&rules) {
            return None;
        }
        let groups = naive.groups();
        Some(Self {
            timing: part.timing,
            assumed: board.steps([&part.assumptions]),
            promised: board.steps([&part.guarantees]),
            winning: naive.winning(&rules),
            from_others: groups.inputs,
            own: groups.outputs,
            owed: board.relations(&part.assumptions.justice),
            goals: board.relations(&part.guarantees.justice),
        })
    }

    /// The steps that some machine can take part in.
    fn moves(&self, assumed: Set, promised: Set, everything: Set) -> Set {
        let good = promised & self.winning;
        match self.timing {
            Timing::Mealy => (everything & !assumed) | good,
            Timing::Moore => {
                let legal = self.from_others.iter().filter(|x| *x & assumed != 0);
                let legal: Vec<Set> = legal.copied().collect();
                let answers = self.own.iter();
                answers
                    .filter(|y| legal.iter().all(|x| x & *y & good != 0))
                    .fold(0, |all, y| all | y)
            }
        }
    }
}

/// All machines together, in every environment that keeps its obligations.
struct Composed {
    machines: Vec<Machine>,
    /// Possible steps.
    steps: Steps,
    /// Justice of the environment: what is given, and what was passed on.
    environment: Vec<Relation>,
}

impl Composed {
    fn new(system: &System, claim: &Claim, proof: &Proof) -> Option<Self> {
        let board = Board::new(&system.variables);
        let parts = 0..system.components.len();
        let machines: Vec<Machine> = parts
            .map(|i| Machine::new(system, &board, i))
            .collect::<Option<_>>()?;
        let mut handed_on = Side::default();
        for discharge in &proof.discharges {
            if discharge.rule == DischargeRule::Exported {
                let formula = replay::formula(system, claim, discharge.what).clone();
                handed_on.list_mut(discharge.what.kind).push(formula);
            }
        }
        let everything = board.everything();
        let given = board.steps([&claim.given]);
        let handed = board.steps([&handed_on]);
        // After other steps the environment is free.
        let binding = match &claim.exports {
            Exports::After(after) => board.states(&formula(String::new(), after.clone())),
            _ => everything,
        };
        let step = |after: Option<usize>| -> Set {
            let (given, handed) = match after {
                None => (given.start, handed.start),
                Some(s) if binding >> s & 1 == 1 => (given.step[s], handed.step[s]),
                Some(s) => (given.step[s], everything),
            };
            machines.iter().fold(given & handed, |all, m| {
                let (assumed, promised) = match after {
                    None => (m.assumed.start, m.promised.start),
                    Some(s) => (m.assumed.step[s], m.promised.step[s]),
                };
                all & m.moves(assumed, promised, everything)
            })
        };
        let steps = Steps {
            start: step(None),
            step: (0..board.valuations.len()).map(|s| step(Some(s))).collect(),
        };
        let justice = claim.given.justice.iter().chain(&handed_on.justice);
        let environment = justice.map(|f| board.relation(f)).collect();
        Some(Self {
            machines,
            steps,
            environment,
        })
    }

    /// Steps in which every part's assumptions are kept.
    fn kept(&self) -> Steps {
        let mut steps = self.steps.clone();
        for m in &self.machines {
            steps.start &= m.assumed.start;
            for (row, assumed) in steps.step.iter_mut().zip(&m.assumed.step) {
                *row &= assumed;
            }
        }
        steps
    }

    /// Whether a part that answers first reaches a state without legal inputs. Then any answer is
    /// correct for all of them, so that it may break even its own guarantees.
    fn has_dead_end(&self) -> bool {
        let kept = self.kept();
        let reached = kept.reach(kept.start);
        let mut first = self.machines.iter().filter(|m| m.timing == Timing::Moore);
        first.any(|m| m.assumed.start == 0 || members(reached).any(|s| m.assumed.step[s] == 0))
    }

    /// Whether, with all assumptions kept so far, the safety of one can be violated.
    fn breaks_an_assumption(&self) -> bool {
        let kept = self.kept();
        let reached = kept.reach(kept.start);
        self.steps.start != kept.start
            || members(reached).any(|s| self.steps.step[s] != kept.step[s])
    }

    /// Whether all safety can be kept and the justice of an assumption starved: every part meets
    /// its goals, or one of its assumptions is starved; and at least one is.
    fn starves_an_assumption(&self) -> bool {
        let kept = self.kept();
        let reached = kept.reach(kept.start);
        let mut choices: Vec<Vec<Option<usize>>> = vec![Vec::new()];
        for m in &self.machines {
            let ways: Vec<Option<usize>> = ((0..m.owed.len()).map(Some)).chain([None]).collect();
            let longer = |c: &Vec<Option<usize>>| {
                let with = |w: &Option<usize>| [&c[..], &[*w]].concat();
                ways.iter().map(with).collect::<Vec<_>>()
            };
            choices = choices.iter().flat_map(longer).collect();
        }
        choices
            .iter()
            .filter(|c| c.iter().any(Option::is_some))
            .any(|choice| {
                let mut steps = kept.clone();
                let mut justice = self.environment.clone();
                for (m, way) in self.machines.iter().zip(choice) {
                    match way {
                        Some(j) => remove(&mut steps, &m.owed[*j]),
                        None => justice.extend(m.goals.iter().cloned()),
                    }
                }
                steps.has_cycle(reached, &justice)
            })
    }

    /// Whether, with all assumptions kept and their justice met, a part of the goal can be
    /// violated.
    fn breaks_the_goal(&self, board: &Board, goal: &Side) -> bool {
        let kept = self.kept();
        let reached = kept.reach(kept.start);
        let goals = self
            .machines
            .iter()
            .flat_map(|m| m.goals.iter().chain(&m.owed));
        let justice: Vec<Relation> = goals.chain(&self.environment).cloned().collect();
        let lasting = kept.lasting(&justice);
        let right = board.steps([goal]);
        let breaks = kept.start & !right.start & lasting != 0
            || members(reached).any(|s| kept.step[s] & !right.step[s] & lasting != 0);
        breaks
            || goal.justice.iter().any(|f| {
                let mut steps = kept.clone();
                remove(&mut steps, &board.relation(f));
                steps.has_cycle(reached, &justice)
            })
    }
}

/// Removes the steps of a relation.
fn remove(steps: &mut Steps, relation: &Relation) {
    for (row, met) in steps.step.iter_mut().zip(relation) {
        *row &= !met;
    }
}

/// Whether a part's possible answers depend on another variable of the same step, whatever came
/// before.
fn depends(board: &Board, guarantees: &Side, on: VarId) -> bool {
    let steps = board.steps([guarantees]);
    let rows = steps.step.iter().chain([&steps.start]);
    let alike = |a: usize, b: usize| {
        let pairs = board.valuations[a]
            .iter()
            .zip(&board.valuations[b])
            .enumerate();
        pairs
            .into_iter()
            .all(|(i, (x, y))| i == on.index() || x == y)
    };
    let count = board.valuations.len();
    rows.into_iter().any(|row| {
        (0..count).any(|a| (0..a).any(|b| alike(a, b) && (row >> a ^ row >> b) & 1 == 1))
    })
}

/// Whether formulas about a step restrict a variable. A part that does not restrict its own output
/// sets it freely, whatever it says about others.
fn mentions(side: &Side, variable: VarId) -> bool {
    let mut found = false;
    for formula in side
        .initial
        .iter()
        .chain(&side.invariants)
        .chain(&side.safety)
    {
        formula
            .expr
            .for_each_var(&mut |v, _| found |= v == variable);
    }
    found
}

/// For each part, the parts on whose answers in the same step its own depend.
fn dependencies(system: &System, board: &Board) -> Vec<Vec<usize>> {
    let parts = system.components.iter().enumerate();
    let of = parts.map(|(i, part)| {
        let others = (0..system.components.len()).filter(|j| *j != i);
        let waits = others.filter(|j| {
            part.timing == Timing::Mealy
                && mentions(&part.guarantees, part.drives[0])
                && depends(board, &part.guarantees, system.components[*j].drives[0])
        });
        waits.collect()
    });
    of.collect()
}

/// Whether a path leads from a part back to itself.
fn has_circle(edges: &[Vec<usize>]) -> bool {
    (0..edges.len()).any(|start| {
        let mut seen = vec![false; edges.len()];
        let mut open = edges[start].clone();
        while let Some(at) = open.pop() {
            if !std::mem::replace(&mut seen[at], true) {
                open.extend(&edges[at]);
            }
        }
        seen[start]
    })
}

/// A claim about a system: something about the environment, and something that a part guarantees,
/// or a weaker formula, or a random one.
fn claim(r: &mut Random, system: &System) -> Claim {
    let variables = &system.variables;
    let all = Scope::all(variables, true).now;
    let (outside, driven): (Vec<VarId>, Vec<VarId>) =
        all.iter().partition(|v| system.driver(**v).is_none());
    let mut given = Side::default();
    let from_outside = |next: &[VarId], now: &[VarId]| Scope {
        variables,
        now: now.to_vec(),
        next: next.to_vec(),
    };
    if r.chance(30) {
        let expr = expression(r, &from_outside(&[], &outside));
        given
            .initial
            .push(formula("given at first".to_owned(), expr));
    }
    if r.chance(30) {
        let expr = expression(r, &from_outside(&outside, &all));
        given.safety.push(formula("given".to_owned(), expr));
    }
    if r.chance(50) {
        let expr = expression(r, &from_outside(&[], &outside));
        given.justice.push(formula("given again".to_owned(), expr));
    }
    let mut goal = Side::default();
    for part in &system.components {
        for formula in &part.guarantees.safety {
            if r.chance(20) {
                goal.safety.push(formula.clone());
            }
        }
        for formula in &part.guarantees.justice {
            if r.chance(30) {
                goal.justice.push(formula.clone());
            }
        }
    }
    if r.chance(25) {
        let expr = expression(r, &from_outside(&[], &driven));
        goal.invariants.push(formula("goal".to_owned(), expr));
    }
    if r.chance(25) {
        let expr = expression(r, &from_outside(&[], &driven));
        goal.justice.push(formula("goal again".to_owned(), expr));
    }
    let exports = match r.below(10) {
        0..=3 => Exports::Never,
        4..=7 => Exports::Always,
        _ => Exports::After(expression(r, &from_outside(&[], &all))),
    };
    Claim {
        given,
        goal,
        exports,
        ..Claim::default()
    }
}

/// The evaluator accepts the counterexample, and it is one by the definitions.
fn check_open(system: &System, claim: &Claim, proof: &Proof, open: &Open) {
    assert_eq!(
        replay::accepts(system, claim, proof, open),
        Ok(()),
        "{open:?}"
    );
    let board = Board::new(&system.variables);
    let parts = system
        .components
        .iter()
        .flat_map(|p| [&p.assumptions, &p.guarantees]);
    let all: Vec<&Side> = parts.chain([&claim.given]).collect();
    let what = replay::formula(system, claim, open.what);
    match &open.why {
        Refutation::Trace(steps) => {
            let width = system.variables.len();
            let states: Vec<usize> = steps.iter().map(|s| board.number(&s[..width])).collect();
            let (last, before) = states.split_last().expect("a step");
            let kept = board.steps(all.iter().copied());
            assert!(
                before.first().is_none_or(|s| kept.start >> s & 1 == 1),
                "{steps:?}"
            );
            let on = |p: &[usize]| kept.step[p[0]] >> p[1] & 1 == 1;
            assert!(before.windows(2).all(on), "{steps:?}");
            let breaks = match (open.what.kind, before.last()) {
                (FormulaKind::Initial, None) | (FormulaKind::Invariant, _) => {
                    board.states(what) >> last & 1 == 0
                }
                (FormulaKind::Safety, Some(s)) => board.relation(what)[*s] >> last & 1 == 0,
                _ => false,
            };
            assert!(breaks, "{steps:?}");
            let given = board.steps([&claim.given]);
            let allowed = before.last().map_or(given.start, |s| given.step[*s]);
            assert!(allowed >> last & 1 == 1, "{steps:?}");
        }
        Refutation::Lasso(run) => {
            let safe = |side: &&Side| {
                let safe = Side {
                    justice: Vec::new(),
                    ..(**side).clone()
                };
                keeps(&safe, run)
            };
            assert!(all.iter().all(safe), "{run:?}");
            assert!(keeps(&claim.given, run), "{run:?}");
            let justice = Side {
                justice: vec![what.clone()],
                ..Side::default()
            };
            assert!(!keeps(&justice, run), "{run:?}");
        }
    }
}

#[derive(Debug, Default)]
struct Counts {
    /// Systems with a part that nothing implements: these are skipped.
    unrealizable: u32,
    /// Systems with a part that answers first, and whose assumptions cannot be kept any more in
    /// some step.
    dead_ends: u32,
    /// Systems whose parts rely on one another in a circle, by the variables of their assumptions.
    circular: u32,
    holds: u32,
    holds_in_a_circle: u32,
    exports: u32,
    /// Proofs that need justice of parts.
    by_justice: u32,
    fails: u32,
    /// Failing proofs for which machines exist that violate something.
    really: u32,
    traces: u32,
    lassos: u32,
    justice_circles: u32,
    loops: u32,
    /// Loops of assumptions in which no answer depends on another.
    assumed_loops: u32,
    /// Those for which machines exist that violate an assumption.
    assumed_loops_really: u32,
}

/// Whether there are loops within a step: then one is found, and in each one found, every answer
/// depends on the next variable.
fn waits_in_a_circle(system: &System, board: &Board, proof: &Proof) -> bool {
    let waits = dependencies(system, board);
    if !has_circle(&waits) {
        return false;
    }
    assert!(!proof.loops.is_empty());
    for found in &proof.loops {
        assert!(found.variables.len() > 1);
        let next = found.variables.iter().cycle().skip(1);
        for pair in found.variables.iter().zip(next) {
            let [answer, on] = [pair.0, pair.1].map(|v| system.driver(*v).expect("driven"));
            assert!(waits[answer].contains(&on), "{found:?}");
        }
    }
    true
}

/// Removes guarantees, in most cases until something implements each part.
fn mend(r: &mut Random, system: &mut System) {
    if r.chance(10) {
        return;
    }
    let board = Board::new(&system.variables);
    for i in 0..system.components.len() {
        while Machine::new(system, &board, i).is_none() {
            let side = &mut system.components[i].guarantees;
            let lists = [
                &mut side.initial,
                &mut side.invariants,
                &mut side.safety,
                &mut side.justice,
            ];
            let mut all: Vec<&mut Vec<Formula>> =
                lists.into_iter().filter(|l| !l.is_empty()).collect();
            let n = r.below(all.len() as u64) as usize;
            all[n].pop();
        }
    }
}

/// The parts whose outputs each part's assumptions mention.
fn relies(system: &System) -> Vec<Vec<usize>> {
    let parts = system.components.iter().enumerate();
    let of = parts.map(|(i, part)| {
        let mut drivers = Vec::new();
        for formula in part.assumptions.all() {
            formula.expr.for_each_var(&mut |v, _| {
                drivers.extend(system.driver(v).filter(|j| *j != i));
            });
        }
        drivers
    });
    of.collect()
}

/// Where a proof holds, no machines that keep the parts' contracts, in any environment that keeps
/// its obligations, ever violate the safety of an assumption, starve its justice, or miss the goal.
/// Counterexamples are accepted.
#[test]
fn proofs_hold_of_all_machines() {
    let limits = Limits::default();
    let mut counts = Counts::default();
    for seed in 80_000..80_000 + SYSTEMS {
        let mut r = Random::new(seed);
        let parts = 2 + r.below(2);
        let plan = Plan {
            parts,
            outside: if parts == 2 { 1 + r.below(2) } else { 1 },
            moore: 40,
            derived: 85,
            demanding: false,
            sees: 40,
        };
        let plan = if r.chance(20) {
            Plan {
                moore: 10,
                sees: 80,
                ..plan
            }
        } else {
            plan
        };
        let system = wired::system(&mut r, &plan, &mend);
        let claim = claim(&mut r, &system);
        let board = Board::new(&system.variables);
        let proof = prove(&system, &claim, &limits).expect("no limit");
        let circular = has_circle(&relies(&system));
        counts.circular += u32::from(circular);

        if waits_in_a_circle(&system, &board, &proof) {
            counts.loops += 1;
            continue;
        }
        for open in &proof.open {
            match open.why {
                Refutation::Trace(_) => counts.traces += 1,
                Refutation::Lasso(_) => counts.lassos += 1,
            }
            check_open(&system, &claim, &proof, open);
        }
        counts.justice_circles += u32::from(!proof.cycles.is_empty());
        let Some(composed) = Composed::new(&system, &claim, &proof) else {
            counts.unrealizable += 1;
            continue;
        };
        if composed.has_dead_end() {
            counts.dead_ends += 1;
            continue;
        }
        let breaks = composed.breaks_an_assumption();
        let starves = composed.starves_an_assumption();
        let misses = composed.breaks_the_goal(&board, &claim.goal);
        if proof.holds() {
            assert!(!breaks, "seed {seed}: {system:#?}");
            assert!(!starves, "seed {seed}: {system:#?}");
            assert!(!misses, "seed {seed}: {system:#?}");
            counts.holds += 1;
            counts.holds_in_a_circle += u32::from(circular);
            let rules = |rule: fn(&DischargeRule) -> bool| {
                u32::from(proof.discharges.iter().any(|d| rule(&d.rule)))
            };
            counts.exports += rules(|rule| *rule == DischargeRule::Exported);
            counts.by_justice += rules(|rule| matches!(rule, DischargeRule::Justice { .. }));
        } else {
            counts.fails += 1;
            counts.really += u32::from(breaks || starves || misses);
            if !proof.loops.is_empty() {
                counts.assumed_loops += 1;
                counts.assumed_loops_really += u32::from(breaks);
            }
        }
    }
    println!("{SYSTEMS} systems: {counts:?}");
    let c = &counts;
    assert!(c.holds >= 1_000 && c.fails >= 1_000 && c.holds_in_a_circle >= 800);
    assert!(c.exports >= 200 && c.by_justice >= 150 && c.justice_circles >= 20);
    assert!(c.traces >= 500 && c.lassos >= 500);
    // Most rejected claims are really wrong, although a proof considers only guarantees, not who
    // can win with them.
    assert!(c.really * 10 >= c.fails * 9, "{c:?}");
    assert!(c.assumed_loops >= 50 && c.assumed_loops_really * 2 >= c.assumed_loops);
    assert!((c.unrealizable + c.dead_ends) * 20 <= SYSTEMS as u32);
}

/// Loops within a step are reported where answers depend on one another in a circle: each on the
/// next one's value in the same step. If none do, and no assumption could make them, none is
/// reported.
#[test]
fn loops_within_a_step_are_loops() {
    let limits = Limits::default();
    let (mut loops, mut none, mut longest) = (0, 0, 0);
    for seed in 90_000..90_000 + 3_000 {
        let mut r = Random::new(seed);
        let plan = Plan {
            parts: 2 + r.below(2),
            outside: 1,
            moore: 5,
            derived: 0,
            demanding: false,
            sees: 90,
        };
        let mut system = wired::system(&mut r, &plan, &|_, _| ());
        for part in &mut system.components {
            part.assumptions = Side::default();
        }
        let board = Board::new(&system.variables);
        let proof = prove(&system, &Claim::default(), &limits).expect("no limit");
        if waits_in_a_circle(&system, &board, &proof) {
            loops += 1;
            let length = proof.loops.iter().map(|l| l.variables.len()).max();
            longest = longest.max(length.unwrap_or(0));
        } else {
            none += 1;
            assert!(proof.loops.is_empty(), "seed {seed}: {:?}", proof.loops);
        }
    }
    println!("3000 systems: {loops} with loops of up to {longest} variables, {none} without");
    assert!(loops >= 300 && none >= 300 && longest >= 3);
}
