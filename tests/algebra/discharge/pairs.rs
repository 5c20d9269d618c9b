//! Pairs of contracts: the paper's own, and circles that are sound for safety but not for justice.

use super::tables::table;
use linewright::algebra::join::{Member, Sharing, join};
use linewright::algebra::proof::{Claim, Exports, Proof, prove};
use linewright::algebra::system::System;
use linewright::contract;
use linewright::game::Limits;

/// The composition of the contracts in some texts, in order.
fn composed(texts: &[&str]) -> (System, Claim, Proof) {
    let files: Vec<(String, String)> = texts
        .iter()
        .enumerate()
        .map(|(i, text)| (format!("{i}.lw"), (*text).to_owned()))
        .collect();
    let (library, _) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    let members: Vec<Member<'_>> = library
        .contracts
        .iter()
        .map(|c| Member {
            specification: &c.specification,
            name: c.name.clone(),
            renamings: Vec::new(),
        })
        .collect();
    let system = join(&members, Sharing::OneDriver).expect("ports that fit");
    let claim = Claim {
        exports: Exports::Always,
        ..Claim::default()
    };
    let proof = prove(&system, &claim, &Limits::default()).expect("no limit");
    (system, claim, proof)
}

/// Four assumptions that are not discharged, and one circle: `available` is the coordinator's own,
/// the gripper's guarantee is only the converse of what Turn needs, and the last two wait for each
/// other.
#[test]
fn the_papers_own_pair_leaves_four_assumptions_open_and_has_one_circle() {
    let (system, claim, proof) = composed(&[
        include_str!("../../cases/table1/coordinator_actuated.lw"),
        include_str!("../../cases/table1/turn_actuated.lw"),
    ]);
    assert_eq!(proof.discharges, []);
    assert_eq!(proof.open.len(), 4);
    assert_eq!(proof.cycles.len(), 1);
    insta::assert_snapshot!(table(&system, &claim, &proof), @"
    Coordinator: assumption 1 | OPEN | a cycle of 1 steps
    Coordinator: assumption 2 | OPEN | a cycle of 1 steps
    Turn: assumption 1 | OPEN | a trace of 1 steps
    Turn: assumption 2 | OPEN | a cycle of 1 steps
    circle: Coordinator: assumption 2 -> Turn: assumption 2
    ");
}

#[test]
fn a_circle_of_safety_is_sound_and_one_of_justice_is_not() {
    let (system, claim, proof) =
        composed(&[include_str!("../../../examples/fit-together/safe.lw")]);
    insta::assert_snapshot!(table(&system, &claim, &proof), @"
    Feeder: careful | induction | Gripper: grips
    Gripper: stays | induction | Feeder: stays
    ");
    let (system, claim, proof) =
        composed(&[include_str!("../../../examples/fit-together/circle.lw")]);
    insta::assert_snapshot!(table(&system, &claim, &proof), @"
    Feeder: reached_for | OPEN | a cycle of 1 steps
    Gripper: parts_come | OPEN | a cycle of 1 steps
    circle: Feeder: reached_for -> Gripper: parts_come
    ");
    let (system, claim, proof) =
        composed(&[include_str!("../../../examples/fit-together/mended.lw")]);
    insta::assert_snapshot!(table(&system, &claim, &proof), @"
    Feeder: held | induction | Gripper: held
    Gripper: fed | justice 1 | Feeder: feeds
    ");
}

#[test]
fn a_loop_within_a_step_is_refused_with_its_variables() {
    let (system, claim, proof) =
        composed(&[include_str!("../../../examples/fit-together/loop.lw")]);
    insta::assert_snapshot!(table(&system, &claim, &proof), @"loop: shut -> lit");
}

/// Circles of safety among contracts that see each other's answers in the same step are loops: each
/// may only keep its promise because the other does.
#[test]
fn a_circle_of_safety_within_a_step_is_refused() {
    let text = "
contract Left {
    input b: bool
    output a: bool
    assume other: always b
    guarantee own: always a
}
contract Right {
    input a: bool
    output b: bool
    assume other: always a
    guarantee own: always b
}
";
    let (system, claim, proof) = composed(&[text]);
    assert!(!proof.holds());
    insta::assert_snapshot!(table(&system, &claim, &proof), @"loop: b -> a");
    // If they answer first, each refers to the previous step.
    let (_, _, proof) = composed(&[&text.replace("contract", "moore contract")]);
    assert!(proof.holds());
    // One of the two is enough.
    let (_, _, proof) = composed(&[&text.replacen("contract", "moore contract", 1)]);
    assert!(proof.holds());
}

/// A contract that fixes every step need not state that requests are completed.
#[test]
fn a_completion_that_follows_from_a_contract_alone_is_relied_on() {
    let text = "
moore contract Lead {
    input done: bool
    output ask: bool
    assume served: always eventually (not ask or done)
    guarantee rest: not ask
    guarantee asks: always (next ask <-> not (ask and done))
}
contract Act {
    input ask, part: bool
    output stage: 0..2
    output done: bool
    assume held: always (ask and not done -> next ask)
    assume comes: always eventually (part or not ask)
    guarantee rest: stage = 0
    guarantee goes: always (ask and part -> next stage = min(stage + 1, 2))
    guarantee waits: always (ask and not part -> next stage = stage)
    guarantee reset: always (not ask -> next stage = 0)
    guarantee report: always (done <-> stage = 2)
}
";
    let (system, claim, proof) = composed(&[text]);
    insta::assert_snapshot!(table(&system, &claim, &proof), @"
    Lead: served | justice 1 | Act: every request completes
    Act: held | induction | Lead: asks
    Act: comes | exported | 
    ");
    // Without parts, it does not follow.
    let parts = "    assume comes: always eventually (part or not ask)\n";
    let (_, _, proof) = composed(&[&text.replace(parts, "")]);
    assert!(!proof.holds());
    // An action that waits for what its coordinator does not promise completes nothing.
    let circle = text.replace("part or not ask", "not ask");
    let (_, _, proof) = composed(&[&circle]);
    assert!(!proof.holds());
}
