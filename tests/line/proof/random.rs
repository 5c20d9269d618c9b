//! Random small lines: the abstraction, the explorer and the runner agree.

use super::explorer::Explorer;
use super::lines::line;
use super::replay::accepts;
use linewright::game::{Limits, Rule, Runs, SafetyViolationQuery};
use linewright::gr1::{BinaryOp, Expr, FormulaKind};
use linewright::line::abstraction::{
    Abstraction, NO_CIRCULAR_WAIT, NO_OVERFLOW, NO_PART_LOST, PlaceKind, Queue, decide,
};
use linewright::line::{End, Options};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The queues that can be full, by node.
fn full(abstraction: &Abstraction) -> BTreeSet<usize> {
    let model = abstraction.model();
    let parts = abstraction.system.components.iter();
    let mut rules: Vec<Rule> = Vec::new();
    for part in parts {
        let side = &part.guarantees;
        let lists = [
            (FormulaKind::Initial, &side.initial),
            (FormulaKind::Safety, &side.safety),
        ];
        rules.extend(lists.into_iter().flat_map(|(kind, list)| {
            list.iter().map(move |f| Rule {
                kind,
                expr: f.expr.clone(),
            })
        }));
    }
    let kept: Vec<usize> = (0..rules.len()).collect();
    let mut asked = Vec::new();
    for (place, declared) in abstraction.shape.places.iter().enumerate() {
        let capacity = match declared.kind {
            PlaceKind::Conveyor { places, .. } => places,
            PlaceKind::Room { capacity, .. } => capacity,
            _ => continue,
        };
        let expr = match &model.vars(place).queue {
            Some(Queue::Count(count, _)) => Expr::binary(
                BinaryOp::Ne,
                Expr::now(*count),
                Expr::Const(i64::from(capacity)),
            ),
            Some(Queue::Slots(slots, _)) => {
                Expr::now(slots[slots.len() - 1]).equals(Expr::Const(0))
            }
            None => panic!("a queue"),
        };
        asked.push((declared.node, rules.len()));
        rules.push(Rule {
            kind: FormulaKind::Invariant,
            expr,
        });
    }
    let mut runs = Runs::new(&abstraction.system.variables, rules, &Limits::default()).unwrap();
    let mut can_be = |rule: usize| {
        let slip = SafetyViolationQuery {
            before: kept.clone(),
            last: kept.clone(),
            broken: rule,
        };
        runs.find_violation(&slip).unwrap().is_some()
    };
    asked
        .into_iter()
        .filter(|(_, rule)| can_be(*rule))
        .map(|(node, _)| node)
        .collect()
}

/// About seven in ten give a line that is small enough, and in which time passes.
const SEEDS: u64 = 500;

#[test]
fn the_explorer_and_the_runner_agree() {
    let start = std::time::Instant::now();
    let (mut timeless, mut spurious, mut fuller) = (0, 0, 0);
    let (mut compared, mut stuck, mut slow, mut runs, mut blocked, mut unfinished) =
        (0, 0, 0, 0, 0, 0);
    let (mut largest, mut report) = (0, String::new());
    for seed in 0..SEEDS {
        let mut builder = line(seed);
        let Some(explored) = Explorer::new(&builder.line).explore(4_000) else {
            slow += 1;
            continue;
        };
        let Ok(mut abstraction) = Abstraction::at_once(&builder.line) else {
            timeless += 1;
            continue;
        };
        // Justice takes longest, and is examined for some lines only.
        if seed % 8 != 0 {
            abstraction.claim.goal.justice.clear();
        }
        let verdict = decide(&abstraction, &Limits::default()).unwrap();
        // What holds in the looser abstraction also holds in this one.
        if seed % 8 == 0 {
            let loose =
                decide(&Abstraction::of(&builder.line).unwrap(), &Limits::default()).unwrap();
            if loose.holds() && !verdict.holds() {
                let _ = writeln!(report, "{seed}: the looser abstraction is no looser");
            }
            spurious += usize::from(!loose.holds() && verdict.holds());
        }
        for open in &verdict.open {
            if let Err(why) = accepts(&abstraction, open) {
                let _ = writeln!(
                    report,
                    "{seed}: {}: {why}",
                    abstraction.goal(open.what).name
                );
            }
        }
        let names: Vec<&str> = verdict
            .open
            .iter()
            .map(|o| abstraction.goal(o.what).name.as_str())
            .collect();
        let is_stuck = names.contains(&NO_CIRCULAR_WAIT);
        if is_stuck != explored.stuck {
            let _ = writeln!(
                report,
                "{seed}: stuck in the abstraction {is_stuck}, explored {}",
                explored.stuck
            );
        }
        for name in &names {
            assert!(
                !name.starts_with(NO_OVERFLOW) && !name.starts_with(NO_PART_LOST),
                "{seed}: {name}"
            );
        }
        let in_abstraction = full(&abstraction);
        // The abstraction allows more, but hardly ever does here.
        fuller += usize::from(in_abstraction != explored.full);
        if !explored.full.is_subset(&in_abstraction) {
            let _ = writeln!(
                report,
                "{seed}: full {in_abstraction:?} in the abstraction, explored {:?}",
                explored.full
            );
        }
        compared += 1;
        stuck += usize::from(is_stuck);
        unfinished += usize::from(!is_stuck && !names.is_empty());
        largest = largest.max(explored.states);
        if seed % 20 == 0 {
            println!(
                "{seed}: {compared} compared after {:.0} s",
                start.elapsed().as_secs_f64()
            );
        }
        let mut plant = builder.plant(Options {
            parts: Some(12),
            ..Options::default()
        });
        for run in 0..4 {
            let trace = plant.run_seeded(run);
            runs += 1;
            if trace.end == End::Blocked {
                blocked += 1;
                // A starving line makes no progress but is not stuck; starvation was not examined
                // for all.
                let stuck = trace
                    .findings
                    .iter()
                    .any(|f| f.message.contains("no longer advance"));
                // Some parts may be stuck while others go on, until the orders are done.
                let is_refuted = || {
                    let full = Abstraction::at_once(&builder.line).unwrap();
                    !decide(&full, &Limits::default()).unwrap().holds()
                };
                let passes = verdict.holds() && (stuck || seed % 8 == 0);
                if passes && (seed % 8 == 0 || !is_refuted()) {
                    let _ = writeln!(
                        report,
                        "{seed}: the runner gets stuck: {}",
                        trace.findings[0].message
                    );
                }
            }
        }
    }
    println!(
        "{compared} lines compared, {stuck} of them can get stuck, {unfinished} starve somebody; of an eighth, {spurious} are proved only with moves at once; \
         {slow} were too large, in {timeless} no time passes; \
         the largest had {largest} states; {blocked} of {runs} runs got stuck"
    );
    assert!(report.is_empty(), "{report}");
    assert!(fuller <= 5, "{fuller} lines have more in the abstraction");
    assert!(compared >= 300 && stuck >= 50 && compared - stuck >= 50 && blocked >= 10);
}
