//! Verdicts compared with a naive game on explicit states, for the formula that a file means: plain
//! and strict, Mealy and Moore.

use super::lassos::{Dice, L};
use super::{file, sound, verdict};

/// A file whose formulas refer at most one step ahead.
struct Random {
    moore: bool,
    strict: bool,
    initially: Vec<L>,
    preset: Vec<L>,
    /// Under `G` in PRESET.
    always: Vec<L>,
    require: Vec<L>,
    assert: Vec<L>,
    /// In ASSUME, about the first step.
    given: Vec<L>,
    /// Under `G`, and under `G F`.
    assume: [Vec<L>; 2],
    guarantee: [Vec<L>; 2],
}

impl Random {
    fn new(dice: &mut Dice) -> Self {
        let list = |dice: &mut Dice, next: bool| -> Vec<L> {
            (0..dice.below(3) / 2 + dice.below(2))
                .map(|_| dice.step(2, next))
                .collect()
        };
        let initially = match dice.below(8) {
            0 | 1 => vec![L::A],
            2 => vec![L::Not(Box::new(L::A))],
            3 => vec![dice.step(1, false)],
            _ => Vec::new(),
        };
        Self {
            moore: dice.below(2) == 0,
            strict: dice.below(2) == 0,
            initially,
            preset: if dice.below(2) == 0 {
                list(dice, false)
            } else {
                Vec::new()
            },
            always: if dice.below(4) == 0 {
                list(dice, true)
            } else {
                Vec::new()
            },
            // Next values of outputs would refer further than REQUIRE may in a strict file.
            require: list(dice, true),
            assert: list(dice, true),
            given: if dice.below(4) == 0 {
                vec![dice.step(1, false)]
            } else {
                Vec::new()
            },
            assume: [list(dice, true), list(dice, false)],
            guarantee: [list(dice, true), list(dice, false)],
        }
    }

    fn text(&self) -> String {
        let section = |head: &str, list: &[L], before: &str| {
            let list: Vec<String> = list.iter().map(|f| format!("{before} ({f});")).collect();
            format!("{head} {{ {} }}\n", list.join(" "))
        };
        let main = [
            "INPUTS { a; } OUTPUTS { b; }\n".to_owned(),
            section("INITIALLY", &self.initially, ""),
            section("PRESET", &self.preset, ""),
            section("PRESET", &self.always, "G"),
            section("REQUIRE", &self.require, ""),
            section("ASSERT", &self.assert, ""),
            section("ASSUME", &self.given, ""),
            section("ASSUME", &self.assume[0], "G"),
            section("ASSUME", &self.assume[1], "G F"),
            section("GUARANTEE", &self.guarantee[0], "G"),
            section("GUARANTEE", &self.guarantee[1], "G F"),
        ]
        .concat();
        let kind = if self.moore { "Moore" } else { "Mealy" };
        let strict = if self.strict { ",Strict" } else { "" };
        file(&format!("{kind}{strict}"), kind, &main)
    }

    /// The state after a step: what is violated so far (1 REQUIRE or safety of ASSUME, 2 GUARANTEE,
    /// 4 REQUIRE), and the letter; 32 is won, 33 lost.
    fn next(&self, state: usize, letter: u8) -> usize {
        if state >= 32 {
            return state;
        }
        let (now, mut broken) = ((state & 3) as u8, state >> 2);
        let holds = |list: &[L]| list.iter().all(|f| f.on_two(now, letter));
        if !holds(&self.always) {
            return 33;
        }
        if !holds(&self.require) {
            broken |= 1 | 4;
        }
        if !holds(&self.assume[0]) {
            broken |= 1;
        }
        if !holds(&self.guarantee[0]) {
            broken |= 2;
        }
        if !holds(&self.assert) {
            if self.strict {
                // S W !R: lost unless REQUIRE is violated in this step or was before.
                if broken & 4 == 0 {
                    return 33;
                }
            } else {
                broken |= 2;
            }
        }
        broken << 2 | usize::from(letter)
    }

    fn first(&self, letter: u8) -> usize {
        let holds = |list: &[L]| list.iter().all(|f| f.on_two(letter, 0));
        if !holds(&self.initially) {
            32
        } else if !holds(&self.preset) {
            33
        } else {
            usize::from(!holds(&self.given)) << 2 | usize::from(letter)
        }
    }

    /// Whether the machine can choose its output so that `good` holds for the letter.
    fn forces(&self, good: &dyn Fn(u8) -> bool) -> bool {
        if self.moore {
            [0, 2]
                .into_iter()
                .any(|b| [0, 1].into_iter().all(|a| good(a | b)))
        } else {
            [0, 1]
                .into_iter()
                .all(|a| [0, 2].into_iter().any(|b| good(a | b)))
        }
    }

    fn realizable(&self) -> bool {
        const ALL: u64 = (1 << 34) - 1;
        let set =
            |of: &dyn Fn(usize) -> bool| (0..34).filter(|s| of(*s)).fold(0_u64, |m, s| m | 1 << s);
        let again = |f: &L| set(&|s| s == 32 || s < 32 && f.on_two((s & 3) as u8, 0));
        // Assumptions and promises; where the game is won the promises are kept, where it is lost
        // the assumptions.
        let mut assumed: Vec<u64> = self.assume[1].iter().map(|f| again(f) | 1 << 33).collect();
        assumed.push(set(&|s| s >= 32 || s >> 2 & 1 == 0));
        let mut promised: Vec<u64> = self.guarantee[1].iter().map(again).collect();
        promised.push(set(&|s| s == 32 || s < 32 && s >> 2 & 2 == 0));
        let step = |target: u64| set(&|s| self.forces(&|l| target >> self.next(s, l) & 1 == 1));
        // νZ ∧ μY ∨ νX: the fixpoint of Piterman, Pnueli and Sa'ar, 2006.
        let mut z = ALL;
        loop {
            let before = z;
            for j in &promised {
                let mut y = 0;
                loop {
                    let old = y;
                    for i in &assumed {
                        let base = j & step(z) | step(y);
                        let mut x = ALL;
                        loop {
                            let new = base | !i & ALL & step(x);
                            if new == x {
                                break;
                            }
                            x = new;
                        }
                        y |= x;
                    }
                    if y == old {
                        break;
                    }
                }
                z &= y;
            }
            if z == before {
                break;
            }
        }
        self.forces(&|l| z >> self.first(l) & 1 == 1)
    }
}

#[test]
fn random_files_have_the_verdict_of_their_formula() {
    let mut dice = Dice(3);
    let mut counts = [[0; 2]; 4];
    for _ in 0..3000 {
        let random = Random::new(&mut dice);
        let text = random.text();
        let reading = super::read_text(&text);
        // Requirements on all steps in a strict file's PRESET, and on outputs in its INITIALLY,
        // have no counterpart.
        let beyond = random.strict
            && (!random.always.is_empty() && !random.require.is_empty()
                || random.initially.iter().any(L::mentions_b) && !random.assert.is_empty());
        let Some(specification) = reading.specification else {
            assert!(beyond, "{}", super::shown(&reading, &text));
            continue;
        };
        let wanted = random.realizable();
        assert_eq!(
            verdict(&specification),
            wanted,
            "{text}\n{specification:#?}"
        );
        counts[usize::from(random.moore) * 2 + usize::from(random.strict)][usize::from(wanted)] +=
            1;
    }
    println!("plain and strict Mealy, plain and strict Moore: {counts:?}");
    assert!(counts.iter().flatten().all(|c| *c > 50), "{counts:?}");
}

/// An assumption about the first step excuses no PRESET, but everything else from that step on.
#[test]
fn assumptions_about_the_first_step_beside_preset() {
    let mut dice = Dice(6);
    let mut counts = [0; 2];
    while counts.iter().sum::<i32>() < 600 {
        let random = Random {
            require: Vec::new(),
            given: vec![dice.step(1, false)],
            assume: [Vec::new(), Vec::new()],
            ..Random::new(&mut dice)
        };
        let text = random.text();
        let reading = super::read_text(&text);
        let Some(specification) = reading.specification.filter(|_| !random.preset.is_empty())
        else {
            continue;
        };
        let wanted = random.realizable();
        assert_eq!(verdict(&specification), wanted, "{text}");
        counts[usize::from(wanted)] += 1;
    }
    println!("unrealizable and realizable: {counts:?}");
    assert!(counts.iter().all(|c| *c > 50), "{counts:?}");
}

/// A Moore file for a Mealy machine, and vice versa, has the verdict of its own semantics, plain
/// and strict.
#[test]
fn the_target_changes_no_verdict() {
    let mut dice = Dice(4);
    let mut counts = [0; 4];
    for _ in 0..1200 {
        let random = Random::new(&mut dice);
        let kinds = ["Mealy", "Moore"];
        let (own, other) = (
            kinds[usize::from(random.moore)],
            kinds[usize::from(!random.moore)],
        );
        let text = random
            .text()
            .replace(&format!("TARGET: {own}"), &format!("TARGET: {other}"));
        let Some(specification) = super::read_text(&text).specification else {
            continue;
        };
        counts[usize::from(random.moore) * 2 + usize::from(random.strict)] += 1;
        assert_eq!(verdict(&specification), random.realizable(), "{text}");
    }
    println!("moved from plain and strict Mealy, plain and strict Moore: {counts:?}");
    assert!(counts.iter().all(|c| *c > 100), "{counts:?}");
}

/// Safety together with an implication in one formula: the safety is kept whatever happens to the
/// assumptions.
#[test]
fn safety_beside_an_implication_is_kept_anyway() {
    let mut dice = Dice(5);
    let mut counts = [0; 2];
    for _ in 0..1200 {
        let mut random = Random {
            require: Vec::new(),
            assert: Vec::new(),
            strict: false,
            ..Random::new(&mut dice)
        };
        random.always.push(dice.step(2, true));
        // An assumption about the first output leaves more than one implication.
        if random.initially.iter().any(L::mentions_b) {
            continue;
        }
        let all = |list: &[L], before: &str| {
            let list: Vec<String> = list.iter().map(|f| format!("{before} ({f})")).collect();
            format!(
                "({})",
                if list.is_empty() {
                    "true".to_owned()
                } else {
                    list.join(" && ")
                }
            )
        };
        let both =
            |lists: &[Vec<L>; 2]| format!("{} && {}", all(&lists[0], "G"), all(&lists[1], "G F"));
        let main = format!(
            "INPUTS {{ a; }} OUTPUTS {{ b; }} INITIALLY {{ {}; }} PRESET {{ {}; }} GUARANTEE {{ {} && ({} && {} -> {}); }}",
            all(&random.initially, ""),
            all(&random.preset, ""),
            all(&random.always, "G"),
            all(&random.given, ""),
            both(&random.assume),
            both(&random.guarantee)
        );
        let kind = if random.moore { "Moore" } else { "Mealy" };
        let text = file(kind, kind, &main);
        let wanted = random.realizable();
        assert_eq!(verdict(&sound(&text)), wanted, "{text}");
        counts[usize::from(wanted)] += 1;
    }
    println!("unrealizable and realizable: {counts:?}");
    assert!(counts.iter().all(|c| *c > 100), "{counts:?}");
}

#[test]
fn a_promise_may_be_broken_if_the_environment_will_have_to_break_its_own() {
    // Plain: violating b -> X !a by b = true for ever is excused, since a is then both required and
    // forbidden.
    let main =
        "INPUTS { a; } OUTPUTS { b; } REQUIRE { b -> X a; b -> X !a; } GUARANTEE { G !b; G F b; }";
    assert!(verdict(&sound(&file("Mealy", "Mealy", main))));
    let main = main.replace("GUARANTEE { G !b;", "ASSERT { !b; } GUARANTEE {");
    assert!(verdict(&sound(&file("Mealy", "Mealy", &main))));
}
