//! Random specifications against a naive solver that shares no code with the real one.

#[path = "oracle/check.rs"]
mod check;
#[path = "oracle/enumerated.rs"]
mod enumerated;
#[path = "oracle/exhaustive.rs"]
mod exhaustive;
#[path = "oracle/formulas.rs"]
mod formulas;
#[path = "oracle/game.rs"]
mod game;
#[path = "oracle/random.rs"]
mod random;
#[path = "oracle/switches.rs"]
mod switches;
#[path = "oracle/ways.rs"]
mod ways;

use check::accepts;
use game::{Board, Subset};
use linewright::game::{GuaranteeRef, Limits, Outcome, examine_environment, solve};
use linewright::gr1::{Specification, Timing};
use linewright::mealy::{Machine, extract::extract, verify::verify};
use random::{Random, mutate, specification};

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
    let (mut stuck, mut forced, mut separated) = (0, 0, 0);
    for seed in 0..400 {
        let spec = specification(&mut Random::new(1_000_000 + seed));
        let board = Board::new(&spec);
        let found = examine_environment(&spec, &limits).expect("no limit");
        let expected = board.environment();
        assert_eq!(found.cannot_start, expected.cannot_start, "seed {seed}");
        assert_eq!(
            found.dead_end.is_some(),
            expected.dead_end,
            "seed {seed}\n{spec:#?}"
        );
        assert_eq!(
            found.stuck_at_start.is_some(),
            expected.stuck_at_start,
            "seed {seed}"
        );
        assert_eq!(
            found.forced.is_some(),
            expected.forced,
            "seed {seed}\n{spec:#?}"
        );
        stuck += u32::from(expected.dead_end);
        forced += u32::from(expected.forced && !expected.dead_end);
        separated += u32::from(found.well_separated());
    }
    println!("dead ends {stuck}, forced otherwise {forced}, well-separated {separated}");
    assert!(stuck >= 20 && forced >= 20 && separated >= 20);
}
