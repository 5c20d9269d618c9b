//! Runs one small specification through everything that `check` and `synth` do with it: both
//! kernels, and the naive solver if it is small enough, must agree, and everything made from the
//! verdict must be correct.

#[path = "../solver/game.rs"]
mod game;

use game::{Board, Subset};
use linewright::game::{
    EnvironmentFindings, GuaranteeRef, KernelChoice, Limit, Limits, LostGame, Options, Outcome,
    WonGame, examine_environment, solve_with,
};
use linewright::gr1::{Formula, FormulaKind, Specification};
use linewright::mealy::certify::certify;
use linewright::mealy::extract::extract;
use linewright::mealy::functions::Functions;
use linewright::mealy::verify::verify;

/// Outcome for a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solved {
    Realizable,
    Unrealizable,
    /// A limit was reached.
    GaveUp,
}

/// Maximum number of bits.
const MOST_BITS: u32 = 10;

/// Maximum number of valuations for the naive solver, which examines every pair of them for every
/// formula.
const MOST_VALUATIONS: u64 = 64;

const KERNELS: [KernelChoice; 2] = [KernelChoice::Biodivine, KernelChoice::Shared];

/// Whether it is solved quickly.
pub fn is_small(specification: &Specification) -> bool {
    let variables = specification.variables.iter();
    let bits = variables.map(|v| 64 - (v.domain.size() - 1).leading_zeros());
    bits.sum::<u32>() <= MOST_BITS
}

/// Measured as work, not time: the same bytes always give the same result.
fn limits() -> Limits {
    Limits {
        max_nodes: Some(1 << 16),
        max_created: Some(1 << 22),
        ..Limits::default()
    }
}

fn outcome(specification: &Specification, kernel: KernelChoice, without_core: bool) -> Outcome {
    let options = Options {
        limits: limits(),
        kernel,
        without_core,
        ..Options::default()
    };
    solve_with(specification, &options).outcome
}

/// Solves it; panics if anything is wrong.
pub fn solve(specification: &Specification) -> Solved {
    let variables = specification.variables.iter();
    let valuations: u64 = variables.map(|v| v.domain.size()).product();
    let board = (valuations <= MOST_VALUATIONS).then(|| Board::new(specification));
    let board = board.as_ref();
    if let (Some(board), Ok(found)) = (board, examine_environment(specification, &limits())) {
        environment(board, &found);
    }
    let mut verdicts = Vec::new();
    let mut cores = Vec::new();
    for kernel in KERNELS {
        let outcome = outcome(specification, kernel, false);
        verdicts.push(match &outcome {
            Outcome::GaveUp(_) => return Solved::GaveUp,
            Outcome::Realizable(won) => {
                let made = controllers(specification, won);
                assert!(!matches!(made, Err(Limit::Stopped(_))), "there is no clock");
                Solved::Realizable
            }
            Outcome::Unrealizable(lost) => {
                core(specification, lost, kernel, board);
                cores.push(lost.core.clone());
                Solved::Unrealizable
            }
        });
    }
    assert_eq!(verdicts[0], verdicts[1], "the kernels");
    assert!(cores.windows(2).all(|two| two[0] == two[1]), "{cores:?}");
    if let Some(board) = board {
        let realizable = verdicts[0] == Solved::Realizable;
        assert_eq!(
            board.realizable(&Subset::All),
            realizable,
            "the naive solver"
        );
    }
    verdicts[0]
}

/// A machine and functions, each judged independently of how they were made.
fn controllers(specification: &Specification, won: &WonGame) -> Result<(), Limit> {
    let limits = limits();
    let machine = extract(specification, won, &limits)?;
    assert_eq!(
        verify(specification, &machine, &limits)?,
        Ok(()),
        "the machine"
    );
    let functions = Functions::extract(specification, won, &limits)?;
    assert_eq!(
        certify(specification, &functions, &limits)?,
        Ok(()),
        "the functions"
    );
    Ok(())
}

/// The core is unrealizable, and by the naive solver nothing can be omitted from it.
fn core(
    specification: &Specification,
    lost: &LostGame,
    kernel: KernelChoice,
    board: Option<&Board<'_>>,
) {
    let Some(core) = &lost.core else { return };
    let alone = only(specification, core);
    let again = outcome(&alone, kernel, true);
    assert!(
        !matches!(again, Outcome::Realizable(_)),
        "the core {core:?}"
    );
    let Some(board) = board else { return };
    assert!(!board.realizable(&Subset::Only(core)), "the core {core:?}");
    for left_out in 0..core.len() {
        let mut less = core.clone();
        less.remove(left_out);
        assert!(
            board.realizable(&Subset::Only(&less)),
            "the core {core:?} without {left_out}"
        );
    }
}

/// The specification with only these guarantees.
fn only(specification: &Specification, core: &[GuaranteeRef]) -> Specification {
    let mut only = specification.clone();
    let keep = |kind: FormulaKind, formulas: &mut Vec<Formula>| {
        let mut index = 0;
        formulas.retain(|_| {
            index += 1;
            let index = index - 1;
            core.contains(&GuaranteeRef { kind, index })
        });
    };
    let guarantees = &mut only.guarantees;
    keep(FormulaKind::Initial, &mut guarantees.initial);
    keep(FormulaKind::Invariant, &mut guarantees.invariants);
    keep(FormulaKind::Safety, &mut guarantees.safety);
    keep(FormulaKind::Justice, &mut guarantees.justice);
    only
}

/// The findings about the assumptions equal those of the naive solver.
fn environment(board: &Board<'_>, found: &EnvironmentFindings) {
    let expected = board.environment();
    assert_eq!(found.cannot_start, expected.cannot_start);
    for (situation, set) in [
        (&found.stuck_at_start, expected.stuck_at_start),
        (&found.dead_end, expected.dead_end),
        (&found.forced, expected.forced),
        (&found.forced_recklessly, expected.forced_recklessly),
    ] {
        assert!(board.is_prime_implicant(situation.as_ref(), set));
    }
    assert_eq!(found.unsatisfiable, expected.unsatisfiable);
    let counted = |[from, all]: [f64; 2]| [from as u32, all as u32];
    assert_eq!(counted(found.forced_states), expected.forced_states);
    let recklessly = expected.forced_recklessly_states;
    assert_eq!(counted(found.forced_recklessly_states), recklessly);
}
