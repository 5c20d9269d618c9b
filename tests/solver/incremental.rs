//! A slightly changed contract starts from the data of its previous version: the same verdicts and
//! the same region.

use crate::random;
use crate::random::Random;
use linewright::engine::cache::Version;
use linewright::game::{Diagram, KernelChoice, Options, Outcome, Solution, solve_with};
use linewright::gr1::{Formula, Owner, Side, Specification};

fn solve(spec: &Specification, kernel: KernelChoice, hints: Option<&Version>) -> Solution {
    let hints = hints.map(|v| v.hints(spec)).unwrap_or_default();
    let options = Options {
        kernel,
        initial_order: hints.order,
        is_final_order: hints.is_final,
        initial_region: hints.region,
        ..Options::default()
    };
    solve_with(spec, &options)
}

fn version(spec: &Specification, solved: &Solution) -> Version {
    let names: Vec<String> = solved
        .statistics
        .order_after
        .iter()
        .map(|v| spec.variable(*v).name.clone())
        .collect();
    let order = solved.statistics.last_order.as_ref().expect("an order");
    Version::new(spec, order, &names, region(solved))
}

fn region(solved: &Solution) -> Option<Diagram> {
    match &solved.outcome {
        Outcome::Realizable(won) => Some(won.region()),
        _ => None,
    }
}

/// The region as a set of states.
fn states(spec: &Specification, solved: &Solution) -> Option<Vec<bool>> {
    let region = region(solved)?;
    let mut bits = 0;
    for v in &spec.variables {
        bits += u64::BITS - (v.domain.size() - 1).leading_zeros();
    }
    let value = |code: u64| {
        let values: Vec<bool> = (0..2 * bits + 2)
            .map(|b| code >> (b / 2) & 1 == 1)
            .collect();
        region.evaluate(0, &values)
    };
    Some((0..1 << bits).map(value).collect())
}

/// Removes some formulas.
fn thin(r: &mut Random, list: &mut Vec<Formula>) {
    list.retain(|_| r.chance(60));
}

fn thin_side(r: &mut Random, side: &mut Side, invariants: bool) {
    thin(r, &mut side.initial);
    thin(r, &mut side.safety);
    thin(r, &mut side.justice);
    if invariants {
        thin(r, &mut side.invariants);
    }
}

/// The earlier version is made from the later one by removing guarantees, and the later one by
/// removing assumptions: so the old region may be used. In every third case the rule is broken by
/// also removing assumed invariants; then it may not be used.
#[test]
fn the_last_region_changes_nothing() {
    let (mut used, mut refused, mut shrunk) = (0, 0, 0);
    for seed in 0..1500 {
        let mut r = Random::new(seed);
        let whole = random::specification(&mut r);
        let mut old = whole.clone();
        thin_side(&mut r, &mut old.guarantees, true);
        let mut new = whole;
        thin_side(&mut r, &mut new.assumptions, seed % 3 == 0);
        let kernel = [KernelChoice::Biodivine, KernelChoice::Shared][(seed % 2) as usize];
        let before = solve(&old, kernel, None);
        let version = version(&old, &before);
        let hints = version.hints(&new);
        assert!(hints.is_final && hints.order.is_some());
        let invariants_went = old.assumptions.invariants != new.assumptions.invariants;
        assert!(!(invariants_went && hints.region.is_some()), "seed {seed}");
        let fresh = solve(&new, kernel, None);
        let incremental = solve(&new, kernel, Some(&version));
        let (expected, found) = (states(&new, &fresh), states(&new, &incremental));
        assert_eq!(expected, found, "seed {seed}\n{old:#?}\n{new:#?}");
        used += u32::from(hints.region.is_some());
        refused += u32::from(hints.region.is_none());
        shrunk += u32::from(hints.region.is_some() && states(&old, &before) != expected);
    }
    assert!(
        used >= 100 && refused >= 100 && shrunk >= 20,
        "{used} {refused} {shrunk}"
    );
}

/// With the versions exchanged, the old region is not used.
#[test]
fn a_weaker_contract_does_not_begin_in_the_old_region() {
    let (mut tried, mut differ) = (0, 0);
    for seed in 0..600 {
        let mut r = Random::new(seed);
        let old = random::specification(&mut r);
        let mut new = old.clone();
        thin_side(&mut r, &mut new.guarantees, true);
        if new.guarantees.safety == old.guarantees.safety
            && new.guarantees.justice == old.guarantees.justice
        {
            continue;
        }
        let before = solve(&old, KernelChoice::Shared, None);
        let version = version(&old, &before);
        // Lists with a duplicate formula are the same set after removing one copy.
        if let Some(region) = version.hints(&new).region {
            let same =
                |a: &[Formula], b: &[Formula]| a.iter().all(|f| b.iter().any(|g| g.expr == f.expr));
            let (o, n) = (&old.guarantees, &new.guarantees);
            assert!(
                same(&o.safety, &n.safety) && same(&o.justice, &n.justice),
                "seed {seed} {region:?}"
            );
        }
        tried += 1;
        let fresh = solve(&new, KernelChoice::Shared, None);
        let incremental = solve(&new, KernelChoice::Shared, Some(&version));
        assert_eq!(
            states(&new, &fresh),
            states(&new, &incremental),
            "seed {seed}"
        );
        differ += u32::from(states(&new, &fresh) != states(&old, &before));
    }
    assert!(tried >= 100 && differ >= 20, "{tried} {differ}");
}

/// If the variables have changed, the remaining ones keep their order.
#[test]
fn other_variables_keep_the_order() {
    let old = random::specification(&mut Random::new(3));
    let before = solve(&old, KernelChoice::Shared, None);
    let version = version(&old, &before);
    let mut new = old.clone();
    let mut more = new.variables[0].clone();
    "another".clone_into(&mut more.name);
    more.owner = Owner::System;
    new.variables.push(more);
    let hints = version.hints(&new);
    assert!(!hints.is_final && hints.region.is_none());
    let order = hints.order.expect("an order");
    let bits: u32 = new
        .variables
        .iter()
        .map(|v| u64::BITS - (v.domain.size() - 1).leading_zeros())
        .sum();
    assert_eq!(order.pairs().len() as u32, bits + 1);
    let fresh = solve(&new, KernelChoice::Shared, None);
    let incremental = solve(&new, KernelChoice::Shared, Some(&version));
    assert_eq!(states(&new, &fresh), states(&new, &incremental));
    // All variables differ: no order to start from.
    for v in &mut new.variables {
        v.name.push('x');
    }
    assert_eq!(
        version.hints(&new),
        linewright::engine::cache::Hints::default()
    );
}
