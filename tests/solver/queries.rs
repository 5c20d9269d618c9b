//! Queries about runs, one after another: what is kept of earlier answers changes no later one.

use crate::random;
use crate::random::Random;
use linewright::game::{Rule, RunQuery, Runs};
use linewright::gr1::{FormulaKind, Specification};
use linewright::symbolic::Limits;

/// The formulas of both sides.
fn rules(spec: &Specification) -> Vec<Rule> {
    let sides = [&spec.assumptions, &spec.guarantees];
    let kinds = [
        FormulaKind::Initial,
        FormulaKind::Invariant,
        FormulaKind::Safety,
        FormulaKind::Justice,
    ];
    let rules = sides.into_iter().flat_map(|side| {
        let of_kind = move |kind| {
            let formulas = side.list(kind).iter();
            formulas.map(move |formula| Rule {
                kind,
                expr: formula.expr.clone(),
            })
        };
        kinds.into_iter().flat_map(of_kind)
    });
    rules.collect()
}

/// Adds the rules to the query in random order, and sometimes begins again.
fn growing(r: &mut Random, rules: &[Rule]) -> Vec<RunQuery> {
    let of_kind = |justice: bool| {
        let all = 0..rules.len();
        let wanted = all.filter(|i| (rules[*i].kind == FormulaKind::Justice) == justice);
        wanted.collect::<Vec<usize>>()
    };
    let (kept, again) = (of_kind(false), of_kind(true));
    let mut queries = Vec::new();
    for _ in 0..3 {
        let mut query = RunQuery::default();
        if let Some(rule) = again.get(r.below(again.len() as u64 + 1) as usize) {
            query.finitely_often.push(*rule);
        }
        for _ in 0..8 {
            let (list, from) = if r.chance(50) {
                (&mut query.keep, &kept)
            } else {
                (&mut query.infinitely_often, &again)
            };
            let place = r.below(from.len().max(1) as u64) as usize;
            let rule = from.get(place).filter(|rule| !list.contains(rule));
            list.extend(rule);
            queries.push(query.clone());
        }
    }
    queries
}

#[test]
fn earlier_answers_change_no_later_one() {
    let (mut with_run, mut without) = (0, 0);
    for seed in 0..300 {
        let r = &mut Random::new(seed);
        let spec = random::specification_with_goals(r);
        let rules = rules(&spec);
        let limits = Limits::default();
        let new = || Runs::new(&spec.variables, rules.clone(), &limits).expect("few bits");
        let mut runs = new();
        for query in growing(r, &rules) {
            let found = runs.has_lasso(&query).expect("a small query");
            let alone = new().find_lasso(&query).expect("a small query");
            assert_eq!(found, alone.is_some(), "seed {seed}: {query:?}");
            *(if found { &mut with_run } else { &mut without }) += 1;
        }
    }
    assert!(with_run >= 1000 && without >= 1000, "{with_run}, {without}");
}
