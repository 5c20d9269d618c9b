//! A monitor of skill orders as C99: a header and a source file without dependencies, allocation or
//! recursion.

use crate::emit::Names;
use crate::emit::controller::Files;
use crate::emit::text::{comment, string, wrap};
use crate::emit::words::word;
use crate::template::render;
use linewright_language::order::layout::Layout;
use linewright_language::order::monitor::RefusalReason;
use linewright_language::order::table::Table;
use serde::Serialize;

/// Emits the monitor of a table: `PickAndPlaceUnit_order.h` and `PickAndPlaceUnit_order.c`.
pub fn files(table: &Table) -> Files {
    let text = Text::new(table);
    Files {
        header: text.header(),
        source: text.source(),
        name: text.name,
    }
}

struct Text<'a> {
    table: &'a Table,
    layout: Layout,
    /// Prefix of all declarations.
    name: String,
    /// Constants of the skills.
    skills: Vec<String>,
    /// Constants of the rules.
    rules: Vec<String>,
}

/// Heading of both files.
#[derive(Serialize)]
struct Heading<'a> {
    about: String,
    orders: Vec<String>,
    name: &'a str,
}

/// The fields of `monitor.h`.
#[derive(Serialize)]
struct Header<'a> {
    #[serde(flatten)]
    heading: Heading<'a>,
    skills: &'a [String],
    count: usize,
    refusals: Vec<Refusal>,
}

/// An answer that refuses a call.
#[derive(Serialize)]
struct Refusal {
    about: String,
    name: String,
    answer: i64,
}

/// The fields of `monitor.c`.
#[derive(Serialize)]
struct Source<'a> {
    #[serde(flatten)]
    heading: Heading<'a>,
    /// Number of entries in a row of the table.
    row: usize,
    refused: u32,
    together: u32,
    unknown: u32,
    /// Mask of all skills in hexadecimal.
    all: String,
    /// Comment above the table.
    after_a_skill: String,
    kind: &'static str,
    single: Vec<String>,
    texts: Vec<String>,
    sets: Vec<Set>,
    set_count: usize,
    at_once: Vec<String>,
    start: u32,
}

/// Skills that may be called at once.
#[derive(Serialize)]
struct Set {
    mask: String,
    about: String,
}

impl<'a> Text<'a> {
    fn new(table: &'a Table) -> Self {
        let own = word(&table.name);
        let name = format!("{own}_order");
        let mut names = Names::default();
        let mut constants = |prefix: &str, of: &mut dyn Iterator<Item = &String>| {
            of.map(|n| names.unique(&format!("{prefix}_{}", identifier(n))))
                .collect()
        };
        Self {
            skills: constants(&format!("{own}_skill"), &mut table.skills.iter()),
            rules: constants(
                &format!("{own}_rule"),
                &mut table.rules.iter().map(|r| &r.name),
            ),
            layout: Layout::new(table),
            table,
            name,
        }
    }

    /// Heading of both files.
    fn heading(&self) -> Heading<'_> {
        let about = format!(
            "The skill orders of {} {}, as a monitor made by linewright.",
            comment(&self.table.name),
            self.table.kept
        );
        let orders = self
            .table
            .rules
            .iter()
            .map(|rule| wrap(&comment(&rule.to_string()), " *       "));
        Heading {
            about: wrap(&about, " * "),
            orders: orders.collect(),
            name: &self.name,
        }
    }

    fn header(&self) -> String {
        let rules =
            self.rules
                .iter()
                .zip(&self.table.rules)
                .enumerate()
                .map(|(number, (name, rule))| Refusal {
                    about: wrap(&format!("/* {} */", comment(&rule.to_string())), "     * "),
                    name: name.clone(),
                    answer: self.answer(RefusalReason::Rule(number)),
                });
        let others = [
            ("RECALL", RefusalReason::Recall),
            ("TOGETHER", RefusalReason::Together),
            ("UNKNOWN", RefusalReason::Unknown),
        ];
        let others = others.map(|(constant, why)| Refusal {
            about: format!("/* {} */", comment(&why.text(&self.table.rules))),
            name: format!("{}_{constant}", self.name),
            answer: self.answer(why),
        });
        render(
            "monitor/monitor.h",
            Header {
                heading: self.heading(),
                skills: &self.skills,
                count: self.skills.len(),
                refusals: rules.chain(others).collect(),
            },
        )
    }

    /// The answer that refuses for a reason.
    fn answer(&self, why: RefusalReason) -> i64 {
        -1 - i64::from(self.layout.code(why) - self.layout.refused)
    }

    fn source(&self) -> String {
        let Self { table, layout, .. } = self;
        let kind = match layout.code(RefusalReason::Unknown) {
            0..=0xff => "uint8_t",
            0x100..=0xffff => "uint16_t",
            _ => "uint32_t",
        };
        let all = match table.skills.len() {
            0 => 0,
            count => u64::MAX >> (64 - count),
        };
        let skills: Vec<String> = table.skills.iter().map(|s| comment(s)).collect();
        let after_a_skill = format!("/* After a single skill: {}. */", skills.join(", "));
        let reasons = (0..table.rules.len()).map(RefusalReason::Rule).chain([
            RefusalReason::Recall,
            RefusalReason::Together,
            RefusalReason::Unknown,
        ]);
        render(
            "monitor/monitor.c",
            Source {
                heading: self.heading(),
                row: layout.stride,
                refused: layout.refused,
                together: layout.code(RefusalReason::Together),
                unknown: layout.code(RefusalReason::Unknown),
                all: format!("{all:x}"),
                after_a_skill: wrap(&after_a_skill, " * "),
                kind,
                single: rows(&layout.single, layout.stride),
                texts: reasons.map(|why| string(&why.text(&table.rules))).collect(),
                sets: self.sets(),
                set_count: layout.sets.len(),
                at_once: rows(&layout.at_once, layout.sets.len()),
                start: layout.start,
            },
        )
    }

    /// The sets of skills that may be called at once, each with its names.
    fn sets(&self) -> Vec<Set> {
        let sets = self.layout.sets.iter().map(|set| {
            let all = self.table.skills.iter().enumerate();
            let named = all.filter(|(skill, _)| set >> skill & 1 == 1);
            let named: Vec<String> = named.map(|(_, skill)| comment(skill)).collect();
            Set {
                mask: format!("{set:x}"),
                about: wrap(&format!("/* {} */", named.join(" & ")), "     * "),
            }
        });
        sets.collect()
    }
}

/// The part of a name that is allowed after another in an identifier.
fn identifier(name: &str) -> String {
    crate::emit::text::identifier(name)
}

/// Numbers in lines of `width`; empty if `width` is 0.
fn rows(numbers: &[u32], width: usize) -> Vec<String> {
    let rows = numbers.chunks(width.max(1)).map(|row| {
        let row: Vec<String> = row.iter().map(u32::to_string).collect();
        wrap(&row.join(", "), "    ")
    });
    rows.collect()
}
