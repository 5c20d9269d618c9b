//! Random meaningless tables with hostile names.

use crate::random::Random;
use crate::unit::calls;
use linewright::order::table::{RECALL, REFUSED, RuleCitation, TOGETHER, Table};

/// Possible names.
const NAMES: [&str; 16] = [
    "Left",
    "left",
    "int",
    "EN",
    "Über",
    "a b",
    "a_b",
    "a*/b",
    "(*x*)",
    "3d",
    "say \"what??/\"",
    "100 %",
    "it's $5",
    "",
    "\u{202e}",
    "Call",
];

/// One of them.
pub fn random(seed: u64) -> Table {
    let mut random = Random::new(seed);
    let skills = [1, 2, 3, 5, 8, 9, 13, 63, 64][random.below(9) as usize];
    let one = |random: &mut Random| NAMES[random.below(16) as usize].to_owned();
    let name = one(&mut random);
    let names: Vec<String> = (0..skills).map(|_| one(&mut random)).collect();
    let count = random.below(5);
    let rules = (0..count).map(|_| RuleCitation {
        name: one(&mut random),
        requirement: random.chance(30).then(|| one(&mut random)),
        text: format!("never {} twice in a row", one(&mut random)),
    });
    let rules: Vec<RuleCitation> = rules.collect();
    let few = skills.min(8);
    let mut table_calls: Vec<u64> = (0..skills).map(|s| 1 << s).collect();
    let salt = random.below(7);
    let several = calls(few, |m| m.count_ones() > 1 && !(m + salt).is_multiple_of(3));
    // If there are many skills, the sets contain the last ones.
    table_calls.extend(several.iter().map(|m| m << (skills - few)));
    let states = 1 + random.below(40) as usize;
    let (mut next, mut why) = (Vec::new(), Vec::new());
    for _ in 0..states * table_calls.len() {
        if random.chance(70) {
            next.push(random.below(states as u64) as u32);
            why.push(0);
        } else {
            let reason = random.below(rules.len() as u64 + 2) as usize;
            next.push(REFUSED);
            why.push(match reason.checked_sub(rules.len()) {
                None => reason as u16,
                Some(0) => RECALL,
                Some(_) => TOGETHER,
            });
        }
    }
    Table {
        name,
        options_text: "at the level valid".to_owned(),
        skills: names,
        rules,
        calls: table_calls,
        next,
        reasons: why,
        states,
        start: random.below(states as u64) as u32,
    }
}
