//! The pick-and-place unit as a handwritten table.

use linewright::order::table::{RECALL, REFUSED, RuleCitation, Table};

/// Left, Right, Up, Down, Grip, Release: the component that each moves, and whether to its second
/// situation.
const SKILLS: [(&str, usize, bool); 6] = [
    ("Left", 0, false),
    ("Right", 0, true),
    ("Up", 1, false),
    ("Down", 1, true),
    ("Grip", 2, true),
    ("Release", 2, false),
];

fn cited(name: &str, text: &str) -> RuleCitation {
    RuleCitation {
        name: name.to_owned(),
        requirement: None,
        text: text.to_owned(),
    }
}

/// The masks of `skills` skills that `may` allows: single ones in order, then sets of two, and so
/// on.
pub fn calls(skills: u32, may: impl Fn(u64) -> bool) -> Vec<u64> {
    let mut masks: Vec<u64> = (1..1_u64 << skills).filter(|m| may(*m)).collect();
    masks.sort_by_key(|m| (m.count_ones(), *m));
    masks
}

/// One skill in a situation: one bit per component, the second one for down. The next situation, or
/// the reason for a refusal.
fn call(situation: u32, skill: usize, recalls: bool) -> Result<u32, u16> {
    let (_, component, second) = SKILLS[skill];
    let down = situation >> 1 & 1 == 1;
    match skill {
        0 | 1 if down => return Err(0),
        5 if !down => return Err(1),
        _ => {}
    }
    let after = situation & !(1 << component) | u32::from(second) << component;
    if after == situation && !recalls {
        return Err(RECALL);
    }
    Ok(after)
}

/// Every order of calling the skills of a mask, one after the other; returns the first refusal of
/// any.
fn every_order(situation: u32, mask: u64, recalls: bool) -> Result<u32, u16> {
    let mut after = Ok(situation);
    for skill in (0..SKILLS.len()).filter(|s| mask >> s & 1 == 1) {
        let one = call(situation, skill, recalls)?;
        after = Ok(every_order(one, mask & !(1 << skill), recalls)?);
    }
    after
}

/// The unit with both rules, initially up, left and open; one state per situation.
pub fn pick_and_place(recalls: bool) -> Table {
    let one_each = |mask: u64| {
        let of = |component: usize| {
            let own = (0..6).filter(|s| mask >> s & 1 == 1 && SKILLS[*s].1 == component);
            own.count()
        };
        (0..3).all(|c| of(c) <= 1)
    };
    let calls = calls(6, one_each);
    let (mut next, mut why) = (Vec::new(), Vec::new());
    for situation in 0..8 {
        for mask in &calls {
            let after = every_order(situation, *mask, recalls);
            next.push(after.unwrap_or(REFUSED));
            why.push(after.err().unwrap_or(0));
        }
    }
    Table {
        name: "PickAndPlace".to_owned(),
        options_text: "at the level valid".to_owned(),
        skills: SKILLS.iter().map(|(name, ..)| (*name).to_owned()).collect(),
        rules: vec![
            cited("trays", "after Down until Up: never Left, Right"),
            cited("transport", "after Up until Down: never Release"),
        ],
        calls,
        next,
        reasons: why,
        states: 8,
        start: 0,
    }
}
