//! Compares diagrams with the enumeration of all values, on random small questions.

use super::query::{Answer, Question};
use super::{diagrams, support};
use linewright_core::gr1::{BinaryOp, Expr, Time, VarId};
use linewright_language::contract;
use linewright_language::contract::machine::Machine;

/// Plant wires of several kinds; the machine itself is irrelevant.
const TEXT: &str = "
contract Idle { output free: bool guarantee rest: always free }
machine M {
    signal a: bool = true
    signal b: bool = true
    signal c: 0..2 = 0
    signal d: -1..3 = 0
    action idle: Idle
}
";

fn machine() -> Machine {
    let files = [("m.lw".to_owned(), TEXT.to_owned())];
    let (library, _) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    library.machines[0].clone()
}

/// splitmix64.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % bound
    }

    fn number(&mut self, depth: u64) -> Expr {
        use BinaryOp::{Add, Max, Min, Sub};
        match self.below(if depth == 0 { 2 } else { 3 }) {
            0 => Expr::Const(self.below(5) as i64 - 1),
            1 => {
                let time = [Time::Now, Time::Next][self.below(2) as usize];
                Expr::Var(VarId(self.below(4) as u32), time)
            }
            _ => {
                let op = [Add, Sub, Min, Max][self.below(4) as usize];
                Expr::binary(op, self.number(depth - 1), self.number(depth - 1))
            }
        }
    }

    fn truth(&mut self, depth: u64) -> Expr {
        use BinaryOp::{And, Eq, Implies, Le, Lt, Ne, Or};
        if depth == 0 || self.below(4) == 0 {
            let op = [Eq, Ne, Lt, Le][self.below(4) as usize];
            return Expr::binary(op, self.number(1), self.number(1));
        }
        let op = [And, Or, Implies][self.below(3) as usize];
        Expr::binary(op, self.truth(depth - 1), self.truth(depth - 1))
    }
}

#[test]
fn diagrams_answer_as_trying_does() {
    let machine = machine();
    let mut random = Random(41);
    let mut seen = [0; 2];
    for round in 0..3_000 {
        let hypotheses: Vec<Expr> = (0..random.below(4)).map(|_| random.truth(2)).collect();
        let goal = random.truth(2);
        let relevant: Vec<&Expr> = hypotheses.iter().collect();
        let mut wires: Vec<(VarId, Time)> = relevant.iter().flat_map(|h| support(h)).collect();
        wires.extend(support(&goal));
        wires.sort_unstable();
        wires.dedup();
        let tried = Question::plain(&goal).enumerate(&machine, &wires, &relevant);
        let found = diagrams::decide(&machine, &goal, &relevant);
        match (tried, found) {
            (Answer::Holds, Answer::Holds) => seen[0] += 1,
            (Answer::Fails(_), Answer::Fails(values)) => {
                seen[1] += 1;
                // With these values, the goal fails, and the hypotheses can hold.
                let fixed = values.0.iter().map(|((wire, time), value)| {
                    Expr::Var(*wire, *time).equals(Expr::Const(*value))
                });
                let fixed: Vec<Expr> = fixed.collect();
                let there: Vec<&Expr> = fixed.iter().chain(&hypotheses).collect();
                let never = Question::plain(&goal).enumerate(&machine, &wires, &there);
                assert!(
                    matches!(never, Answer::Fails(_)),
                    "round {round}: {values:?}"
                );
                let named: Vec<(VarId, Time)> = values.0.iter().map(|(w, _)| *w).collect();
                assert_eq!(named, support(&goal), "round {round}");
            }
            other => panic!("round {round}: {other:?} on {goal:?} from {hypotheses:?}"),
        }
    }
    assert!(seen.iter().all(|n| *n > 300), "{seen:?}");
}
