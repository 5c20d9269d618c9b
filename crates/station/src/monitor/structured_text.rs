//! Emits a monitor of skill orders as a function block of IEC 61131-3. The block has one input per
//! skill; a rising edge at an input is a call of that skill.
//!
//! A table holds the union of each set of skills with one more skill. The block uses the table
//! skill by skill to find the number of the set of skills that are called at once. It therefore
//! needs no bit masks, which systems store in different ways. All sets that are never called at
//! once share one number.

use crate::structured_text::names::{Names, comment, identifier, stem, string};
use crate::structured_text::tables::{element, named_table};
use crate::structured_text::{Block, Section, Type, Variable, Width};
use crate::template::render;
use linewright_language::order::layout::Layout;
use linewright_language::order::monitor::RefusalReason;
use linewright_language::order::table::Table;
use serde::Serialize;
use std::collections::BTreeMap;

/// Maximum length of a rule's text: the default string length of most systems.
const MAX_TEXT_CHARS: usize = 80;

/// Creates the monitor of a table as a function block `FB_PickAndPlaceUnitOrder`.
pub fn block(table: &Table) -> Block {
    let words = Words::new(table);
    let sets = Sets::new(table);
    let layout = Layout::new(table);
    let set_with = named_table(
        &words.set_with,
        sets.unions(table.skills.len()),
        0,
        &format!(
            "union of a set and one skill, at index {} * set + skill",
            table.skills.len()
        ),
    );
    let next = named_table(
        &words.next,
        sets.next(table, &layout),
        0,
        &format!(
            "next state after a set, at index {} * state + set; a negative number is a reason to refuse",
            sets.count()
        ),
    );
    let index = [&set_with, &next].map(length).into_iter().max();
    let index = Width::of(0, index.unwrap_or(0));
    let body = body(table, &layout, &words, &sets, &set_with, &next, index);
    let control = |name: &str, about: &str| Variable::new(name, Type::Bool, about);
    let called = words.skills.iter().zip(&table.skills).map(|(name, skill)| {
        let about = if name == skill {
            String::new()
        } else {
            comment(skill)
        };
        control(name, &about)
    });
    let mut inputs = vec![control(
        &words.reset,
        "return to the state before the first call; no skill is called while it is TRUE",
    )];
    inputs.extend(called);
    let mut outputs = vec![
        control(&words.allowed, "all calls are allowed"),
        control(&words.violated, "a call was refused since the last reset"),
        Variable::new(
            &words.rule,
            Type::Text(MAX_TEXT_CHARS),
            "reason of the last refusal",
        ),
    ];
    for (granted, skill) in words.granted.iter().zip(&table.skills) {
        let about = format!("{} is called and allowed", comment(skill));
        outputs.push(control(granted, &about));
    }
    let number = |name: &str, about: &str| Variable::new(name, Type::Integer(index), about);
    let start = i64::from(table.start);
    let mut state = number(&words.state, "");
    if start != 0 {
        state = state.with_initial_value(&start.to_string());
    }
    Block {
        contract: table.name.clone(),
        name: words.block.clone(),
        description: description(table, &words),
        types: Vec::new(),
        sections: vec![
            (Section::Input, inputs),
            (Section::Output, outputs),
            (Section::Local, vec![state]),
            (Section::Constant, vec![set_with, next]),
            (
                Section::Temporary,
                vec![
                    number(&words.set, "set of skills called now"),
                    number(&words.to, "next state, or reason to refuse"),
                ],
            ),
        ],
        body,
    }
}

/// The names of the block.
struct Words {
    block: String,
    /// Inputs of the skills.
    skills: Vec<String>,
    /// Outputs, one per skill.
    granted: Vec<String>,
    reset: String,
    allowed: String,
    violated: String,
    rule: String,
    state: String,
    set_with: String,
    next: String,
    set: String,
    to: String,
}

impl Words {
    fn new(table: &Table) -> Self {
        let mut names = Names::default();
        let block = names.unique(&format!("FB_{}Order", stem(&table.name)));
        // On a conflict, skills keep their names, and the block's own names get a number.
        let skills: Vec<String> = table
            .skills
            .iter()
            .map(|s| names.unique(&identifier(s)))
            .collect();
        let granted = table
            .skills
            .iter()
            .map(|s| names.unique(&identifier(&format!("granted_{s}"))))
            .collect();
        let mut own = |preferred: &str| names.unique(&identifier(preferred));
        Self {
            block,
            skills,
            granted,
            reset: own("reset"),
            allowed: own("allowed"),
            violated: own("violated"),
            rule: own("rule"),
            state: own("state"),
            set_with: own("set_with"),
            next: own("next"),
            set: own("set"),
            to: own("next_state"),
        }
    }
}

/// The numbers of all sets of skills that can be called at once, and of the smaller sets that arise
/// when their skills are added in order. Number 0 is the empty set; the last number stands for all
/// other sets.
struct Sets(BTreeMap<(u32, u64), usize>);

impl Sets {
    fn new(table: &Table) -> Self {
        let mut sets = BTreeMap::new();
        for mask in &table.calls {
            // Include the intermediate sets, skill by skill.
            let mut rest = *mask;
            while rest != 0 {
                sets.insert((rest.count_ones(), rest), 0);
                rest &= !(1 << rest.ilog2());
            }
        }
        for (number, set) in sets.values_mut().enumerate() {
            *set = number + 1;
        }
        Self(sets)
    }

    fn count(&self) -> usize {
        self.0.len() + 2
    }

    /// Returns, for every set and skill, the number of their union. If the skill does not come
    /// after all skills of the set, or if the union is never called, it is the number of all other
    /// sets.
    fn unions(&self, skills: usize) -> Vec<i64> {
        let other = self.count() - 1;
        let masks = std::iter::once(0).chain(self.0.keys().map(|(_, mask)| *mask));
        let mut with = Vec::new();
        for mask in masks {
            with.extend((0..skills).map(|skill| {
                let both = mask | 1 << skill;
                let is_last = both >> skill == 1;
                let known = self.0.get(&(both.count_ones(), both));
                let set = known.filter(|_| is_last && both != mask);
                *set.unwrap_or(&other) as i64
            }));
        }
        with.extend(std::iter::repeat_n(other as i64, skills));
        with
    }

    /// Returns, for every state and set, the next state or a negative number that stands for the
    /// reason to refuse the set.
    fn next(&self, table: &Table, layout: &Layout) -> Vec<i64> {
        let mut next = Vec::new();
        for state in 0..table.states {
            let entry = |mask: u64| {
                let several = || {
                    let set = layout.sets.binary_search(&mask).ok()?;
                    Some(layout.at_once[state * layout.sets.len() + set])
                };
                let known = if mask.is_power_of_two() {
                    Some(layout.single[state * layout.stride + mask.trailing_zeros() as usize])
                } else {
                    several()
                };
                match known {
                    Some(entry) if entry < layout.refused => {
                        i64::from(entry / layout.stride as u32)
                    }
                    Some(entry) => refusal(layout, layout.refusal_reason(entry)),
                    None => refusal(layout, RefusalReason::Together),
                }
            };
            next.push(state as i64);
            next.extend(self.0.keys().map(|(_, mask)| entry(*mask)));
            next.push(refusal(layout, RefusalReason::Together));
        }
        next
    }
}

/// The negative number that stands for a reason to refuse instead of a next state.
fn refusal(layout: &Layout, why: RefusalReason) -> i64 {
    -1 - i64::from(layout.refusal_code(why) - layout.refused)
}

/// Number of elements of a table.
fn length(table: &Variable) -> i64 {
    match table.kind {
        Type::Array(_, last, _) => last + 1,
        _ => 1,
    }
}

/// The fields of `description.txt`.
#[derive(Serialize)]
struct Description<'a> {
    name: String,
    kept: &'a str,
    allowed: &'a str,
    violated: &'a str,
    rule: &'a str,
    reset: &'a str,
    orders: Vec<String>,
}

/// Renders the description of the block, one paragraph per line.
fn description(table: &Table, words: &Words) -> Vec<String> {
    let orders = table.rules.iter().map(|r| comment(&r.to_string()));
    let text = render(
        "monitor/description.txt",
        Description {
            name: comment(&table.name),
            kept: &table.options_text,
            allowed: &words.allowed,
            violated: &words.violated,
            rule: &words.rule,
            reset: &words.reset,
            orders: orders.collect(),
        },
    );
    text.lines().map(str::to_owned).collect()
}

/// The fields of `monitor.st`.
#[derive(Serialize)]
struct Body<'a> {
    allowed: &'a str,
    reset: &'a str,
    state: &'a str,
    start: u32,
    violated: &'a str,
    rule: &'a str,
    set: &'a str,
    to: &'a str,
    /// Expression of the next state after the set of calls, or of the reason to refuse it.
    next: String,
    skills: Vec<Skill<'a>>,
    reasons: Vec<Reason>,
}

/// The input and the output of a skill, and the expression of the union of a set with the skill.
#[derive(Serialize)]
struct Skill<'a> {
    name: &'a str,
    granted: &'a str,
    set_with: String,
}

/// A reason to refuse a call.
#[derive(Serialize)]
struct Reason {
    code: i64,
    text: String,
}

fn body(
    table: &Table,
    layout: &Layout,
    words: &Words,
    sets: &Sets,
    set_with: &Variable,
    next: &Variable,
    index: Width,
) -> String {
    let (state, set) = (&words.state, &words.set);
    let count = table.skills.len();
    let skills =
        words
            .skills
            .iter()
            .zip(&words.granted)
            .enumerate()
            .map(|(number, (name, granted))| {
                let place = format!("{}[{count} * {set} + {number}]", set_with.name);
                Skill {
                    name,
                    granted,
                    set_with: element(set_with).convert(index, &place),
                }
            });
    let reasons = (0..table.rules.len())
        .map(RefusalReason::Rule)
        .chain([RefusalReason::Recall, RefusalReason::Together])
        .map(|why| {
            let text = match why {
                RefusalReason::Rule(rule) => table.rules[rule].name.clone(),
                other => other.text(&table.rules),
            };
            Reason {
                code: refusal(layout, why),
                text: string(&text, MAX_TEXT_CHARS),
            }
        });
    let place = format!("{}[{} * {state} + {set}]", next.name, sets.count());
    render(
        "monitor/monitor.st",
        Body {
            allowed: &words.allowed,
            reset: &words.reset,
            state,
            start: table.start,
            violated: &words.violated,
            rule: &words.rule,
            set,
            to: &words.to,
            next: element(next).convert(index, &place),
            skills: skills.collect(),
            reasons: reasons.collect(),
        },
    )
}
