//! Random specifications compared with an independent naive solver.

mod check;
mod enumerated;
mod exhaustive;
mod formulas;
mod shape;
mod switches;
mod ways;

use crate::game::{Board, Subset};
use crate::random::{Random, mutate, specification};
use check::accepts;
use linewright::game::{GuaranteeRef, Limits, Outcome, examine_environment, solve};
use linewright::gr1::{Domain, Expr, Formula, Specification, Timing, VarId};
use linewright::mealy::{Machine, extract::extract, verify::verify};
use linewright::source::Span;

const SPECIFICATIONS: u64 = 5_000;

fn machine_of(specification: &Specification) -> Result<Machine, Option<Vec<GuaranteeRef>>> {
    let limits = Limits::default();
    match solve(specification, &limits) {
        Outcome::Realizable(won) => Ok(extract(specification, &won, &limits).expect("no limit")),
        Outcome::Unrealizable(lost) => Err(lost.core),
        Outcome::GaveUp(limit) => panic!("gave up without a limit: {limit}"),
    }
}

#[test]
fn verdicts_machines_mutants_and_cores() {
    let limits = Limits::default();
    let (mut realizable, mut moore, mut integers) = (0, 0, 0);
    let (mut mutants, mut violating, mut cores, mut shrunk) = (0, 0, 0, 0);
    for seed in 0..SPECIFICATIONS {
        let mut random = Random::new(seed);
        let spec = specification(&mut random);
        let board = Board::new(&spec);
        moore += u32::from(spec.timing == Timing::Moore);
        integers += u32::from(spec.variables.iter().any(|v| v.domain.size() != 2));
        let expected = board.realizable(&Subset::All);
        match machine_of(&spec) {
            Ok(machine) => {
                assert!(expected, "seed {seed}: should be unrealizable\n{spec:#?}");
                realizable += 1;
                let accepted = accepts(&board, &machine);
                assert_eq!(accepted, Ok(()), "seed {seed}: {machine:#?}\n{spec:#?}");
                let verdict = verify(&spec, &machine, &limits).expect("no limit");
                assert_eq!(verdict, Ok(()), "seed {seed}: {machine:#?}\n{spec:#?}");
                for _ in 0..2 {
                    let Some(mutant) = mutate(&mut random, &machine) else {
                        continue;
                    };
                    mutants += 1;
                    let accepted = accepts(&board, &mutant);
                    let verdict = verify(&spec, &mutant, &limits).expect("no limit");
                    assert_eq!(
                        accepted.is_ok(),
                        verdict.is_ok(),
                        "seed {seed}: oracle {accepted:?}, verifier {verdict:?}\n{mutant:#?}\n{spec:#?}"
                    );
                    if let Err(violation) = verdict {
                        violating += 1;
                        check::replay(&board, &mutant, &violation);
                    }
                }
            }
            Err(core) => {
                assert!(!expected, "seed {seed}: should be realizable\n{spec:#?}");
                let core = core.expect("no limit");
                cores += 1;
                assert!(!board.realizable(&Subset::Only(&core)), "seed {seed}");
                for i in 0..core.len() {
                    let mut less = core.clone();
                    less.remove(i);
                    assert!(
                        board.realizable(&Subset::Only(&less)),
                        "seed {seed}: the core {core:?} is not minimal at {i}"
                    );
                }
                let all = spec.guarantees.all().count();
                shrunk += u32::from(core.len() < all);
            }
        }
    }
    let unrealizable = SPECIFICATIONS as u32 - realizable;
    println!(
        "{SPECIFICATIONS} specifications ({moore} Moore, {integers} with integers or labels): {realizable} realizable, \
         {unrealizable} not; {mutants} mutants, {violating} of them violating; {cores} minimal cores, {shrunk} proper"
    );
    const { assert!(SPECIFICATIONS >= 2_000) };
    assert!(u64::from(realizable) * 4 >= SPECIFICATIONS);
    assert!(u64::from(unrealizable) * 4 >= SPECIFICATIONS);
    assert!(moore > 500 && integers > 300);
    assert!(mutants >= 200 && violating >= 100 && mutants - violating >= 20);
    assert!(cores >= 500 && shrunk >= 100);
}

#[test]
fn findings_about_the_environment() {
    let limits = Limits::default();
    let (mut stuck, mut forced, mut separated, mut hopeless, mut partial) = (0, 0, 0, 0, 0);
    for seed in 0..1_000 {
        let spec = specification(&mut Random::new(1_000_000 + seed));
        let board = Board::new(&spec);
        let found = examine_environment(&spec, &limits).expect("no limit");
        let expected = board.environment();
        assert_eq!(found.cannot_start, expected.cannot_start, "seed {seed}");
        for (situation, set) in [
            (&found.stuck_at_start, expected.stuck_at_start),
            (&found.dead_end, expected.dead_end),
            (&found.forced, expected.forced),
            (&found.forced_recklessly, expected.forced_recklessly),
        ] {
            assert!(
                board.is_prime_implicant(situation.as_ref(), set),
                "seed {seed}\n{spec:#?}"
            );
            partial += u32::from(situation.as_ref().is_some_and(|s| s.contains(&None)));
        }
        assert_eq!(
            found.unsatisfiable, expected.unsatisfiable,
            "seed {seed}\n{spec:#?}"
        );
        let counted = |[from, all]: [f64; 2]| [from as u32, all as u32];
        assert_eq!(
            counted(found.forced_states),
            expected.forced_states,
            "seed {seed}\n{spec:#?}"
        );
        assert_eq!(
            counted(found.forced_recklessly_states),
            expected.forced_recklessly_states,
            "seed {seed}\n{spec:#?}"
        );
        hopeless += u32::from(expected.unsatisfiable);
        let [dead_end, can_force] = [expected.dead_end[0] != 0, expected.forced[0] != 0];
        stuck += u32::from(dead_end);
        forced += u32::from(can_force && !dead_end);
        separated += u32::from(found.is_well_separated());
    }
    println!(
        "dead ends {stuck}, forced otherwise {forced}, well-separated {separated}, unsatisfiable {hopeless}"
    );
    assert!(stuck >= 20 && forced >= 20 && separated >= 20 && hopeless >= 20 && partial >= 100);
}

/// Where a realizable specification demands less than it seems to.
#[test]
fn shapes_of_realizable_specifications() {
    let limits = Limits::default();
    let mut seen = [0; 8];
    let mut checked = 0;
    for seed in 0..2_500 {
        let mut random = Random::new(2_000_000 + seed);
        let mut spec = specification(&mut random);
        let is_bool = |v: VarId| spec.variable(v).domain == Domain::Bool;
        let first = spec
            .inputs()
            .next()
            .filter(|v| v.index() == 0 && is_bool(*v));
        let done = spec.outputs().find(|v| is_bool(*v));
        if let (Some(request), Some(done), true) = (first, done, seed % 2 == 0) {
            let expr = Expr::now(request)
                .and(Expr::now(done).not())
                .implies(Expr::next(request));
            let held = Formula {
                defines: false,
                name: "held".to_owned(),
                requirement: None,
                expr,
                span: Span::default(),
                text: String::new(),
            };
            spec.assumptions.safety.insert(0, held);
        }
        let Outcome::Realizable(won) = solve(&spec, &limits) else {
            continue;
        };
        checked += 1;
        let found = won.find_weaknesses(&spec, &limits).expect("no limit");
        let shown = Board::new(&spec).agrees(&found);
        assert_eq!(shown, Ok(()), "seed {seed}: {found:#?}\n{spec:#?}");
        let open = found.requests.iter().any(|r| r.enforceable);
        let chance = found.requests.iter().any(|r| !r.enforceable);
        for (count, is) in seen.iter_mut().zip([
            !found.unbreakable.is_empty(),
            !found.unreachable.is_empty(),
            !found.unconstrained.is_empty(),
            !found.constant.is_empty(),
            !found.unframed.is_empty(),
            found.idle,
            open,
            chance,
        ]) {
            *count += u32::from(is);
        }
    }
    println!("{checked} realizable ones; of LW212 to LW216, LW219, LW218, LW217: {seen:?}");
    assert!(checked >= 500);
    assert!(seen.iter().all(|n| *n >= 5), "{seen:?}");
}
